"""How far a sampled motion is from the law of friction, without any truth: from its samples alone."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Drive, Trajectory
from cases.motion.mechanics import applied_forces

from .friction_factor import contact_impulses

# Slip below this part of the largest, and pressure below this part of the median, is left out: near zero both are
# differences of roundings.
SLIPS, PRESSES = 0.02, 0.05


class LawError(NamedTuple):
    """The error of the law of friction in units of μ N while the plate slips: its median over the steps between samples
    and the value that 90 % of them do not exceed; and the time (s) at which it is largest. NaN where the law is not
    looked at."""

    median: float = nan
    upper: float = nan
    time: float = nan


def law_error(case: Case, motion: Trajectory) -> LawError:
    """|T + sign(slip) μ N| / (μ N) of the forces that changed the velocities from sample to sample.

    N and T are the parts of the impulse of the contact, by the plate's momentum, along the normal and the tangent of
    the track at the place of contact; slip is the mean of both samples. An error of second order in the time between
    samples remains, and one of first order where forces change at once. NaN with a moving track, several plates or
    contacts, and without friction.
    """
    friction = case.effect(CoulombFriction)
    if (
        friction is None
        or case.effect(Drive) is not None
        or case.others
        or case.supports
        or len(motion.contact_names) > 1
    ):
        return LawError()
    inside = np.concatenate([np.diff(motion.t) > 0.0, [True]])
    if np.count_nonzero(inside) < 2:
        return LawError()
    t, slip, xi1 = (0.5 * (row[inside][1:] + row[inside][:-1]) for row in (motion.t, motion.slip, motion.xi1))
    push = contact_impulses(case, motion, applied_forces(case, motion, inside), inside) / np.diff(motion.t[inside])
    place = np.where(np.isfinite(xi1), xi1, case.start.xi1)
    along, across = (np.sum(push * side(place), axis=0) for side in (case.track.tangent, case.track.normal))
    touches = np.isfinite(xi1 + slip + along + across)
    if not touches.any():
        return LawError()
    slips = touches & (np.abs(slip) > SLIPS * np.abs(slip[touches]).max())
    # A contact that may pull has friction of either sign of its normal force.
    pressure = np.abs(across)
    slips &= pressure > PRESSES * np.median(pressure[touches])
    if not slips.any():
        return LawError()
    bound = friction.at(np.abs(slip[slips])) * pressure[slips]
    error = np.abs(along[slips] + np.sign(slip[slips]) * bound) / np.where(bound > 0.0, bound, nan)
    if not np.isfinite(error).any():
        return LawError()
    return LawError(float(np.nanmedian(error)), float(np.nanquantile(error, 0.9)), float(t[slips][np.nanargmax(error)]))
