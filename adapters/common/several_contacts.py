"""Contacts of a plate that touches its track in several places, from the poses of a motion alone.

Engines report a pose and velocities at each step; which places of the track the plate touches follows from the case's
geometry. A contact is a place where the distance between track and plate is smallest. It is closed while the gap
is below what the engine's step and facets leave. Lengths in metres.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cases import Case, Chain, Flight, Trajectory
from cases.curves.corner import Corner
from cases.scene.contact_limits import touches_by_features
from cases.scene.supports import is_hill

from .closed_samples import by_gap
from .contacts_from_poses import poses_and_rates
from .couple_contacts import couple_contacts
from .facets import round_plate, visible_span
from .pose_contact import with_columns

# Samples of a track at which its bend is looked at.
TRACK_SAMPLES = 2_001


def refuses(case: Case) -> str | None:
    """Why the several contacts of a plate with its track do not follow from its poses, in one sentence, or None."""
    if case.others or case.supports or touches_by_features(case):
        return None
    if round_plate(case) is None and not _has_corners(case):
        return "Several contacts are computed for round plates only, and for curves with corners."
    return None


def _has_corners(case: Case) -> bool:
    return isinstance(case.track, Chain) or isinstance(case.plate.outline, Chain)


def may_touch_twice(case: Case) -> bool:
    """Whether a plate may touch the track in two places at once, as far as this module supports it.

    Between two places that a disc touches the track bends more than the disc: its arc has the same ends and tangents as
    the disc's and is outside of it, so its curvature is at least 1/r somewhere, or it has a hollow corner.
    """
    circle, track = round_plate(case), case.track
    if _has_corners(case) and (case.effect(Flight) is None or is_hill(track)):
        return False
    if circle is None:
        return _has_corners(case)
    if any(isinstance(one.piece, Corner) and one.piece.turn > 0.0 for one in track.elements):
        return True
    bend = track.curvature(np.linspace(*visible_span(case), TRACK_SAMPLES))
    return bool(np.max(bend) * circle.radius >= 1.0)


def with_contacts(
    case: Case, motion: Trajectory, clear: Callable[[np.ndarray], np.ndarray], rounding: float | None = None
) -> Trajectory:
    """The motion with the columns of each contact, if its plate touches the track in more than one place; else the
    motion as it is.

    `clear`: of contact parameters (n,), the gaps (m) below which such contacts are closed; with `rounding` (m) one that
    opens slowly is open as soon as its gap grows beyond that. The trajectory's own slip,
    forces and parameters are then those of the first closed contact. With one closed contact its forces are the
    motion's, with more they are unknown (NaN): the momentum gives only their sum. Where none is closed the plate flies.
    """
    if refuses(case) is not None:
        return motion
    poses, rates = poses_and_rates(motion)
    bounds = clear(np.linspace(*visible_span(case), TRACK_SAMPLES))
    widest = float(np.max(bounds, where=np.isfinite(bounds), initial=0.0))
    every = couple_contacts(case, motion.t, poses, rates, clear, widest)
    if len(every) < 2:
        return motion
    closed = [one.gap <= clear(one.xi1) for one in every]
    if rounding is not None:
        closed = [by_gap(one.gap, shut, rounding) for one, shut in zip(every, closed, strict=True)]
    alone = np.where(np.sum(closed, axis=0) == 1, 1.0, np.nan)
    force = alone * _force(case, motion)
    forces = [np.array([np.sum(force * axis, axis=0) for axis in (one.normal, one.tangent)]) for one in every]
    return with_columns(motion, every, closed, forces)


def _force(case: Case, motion: Trajectory) -> np.ndarray:
    """The force of the track on the plate, shape (2, n), N: from the motion's columns, those of its own contact."""
    xi1 = np.nan_to_num(motion.xi1, nan=case.start.xi1)
    return motion.normal_force * case.track.normal(xi1) + motion.friction_force * case.track.tangent(xi1)
