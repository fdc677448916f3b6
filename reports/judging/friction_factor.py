"""The friction factor of a motion: its loss of energy relative to what the case's law of friction takes from it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import Belt, Case, CoulombFriction, Drive, RollingResistance, Trajectory, Unilateral
from cases.contact import belt_speed
from cases.motion.mechanics import applied_forces, energy, gravity, kinetic_energy

from .distances import even_samples

# Below this fraction of a case's largest kinetic energy, the work of friction is not used: errors of an engine's
# energy are as large.
_LEAST_LOSS = 1e-3
# A motion has no friction factor if the law of friction takes less than this fraction of the truth's loss from it. So
# 10,000 is the largest possible factor.
_LEAST_SLIP = 1e-4


# A track is straight if the plate is larger than this part of its radius of curvature nowhere.
_STRAIGHT = 1e-9
# How the names of a plate's contacts with its track begin.
ON_TRACK = "plate/track"


class Losses(NamedTuple):
    """Energy that a motion lost, J, and the energy that the case's law of friction takes from this motion, J."""

    actual: float
    by_law: float


INDETERMINATE = Losses(np.nan, np.nan)


def friction_factor(case: Case, motion: Trajectory, truth: Losses, end: float) -> float:
    """The energy lost up to the time `end`, relative to what the law of friction takes from this motion: 1 for the law,
    60 for an engine whose friction (and other losses) is 60 times as large. `truth`: the losses of the true motion.

    NaN where the losses are unknown, and where friction takes almost nothing from the truth or from the motion.
    """
    if not is_defined(case, motion, truth):
        return np.nan
    own = _losses_of_any(case, motion, end)
    return own.actual / own.by_law if _LEAST_SLIP * truth.by_law < own.by_law < np.inf else np.nan


def is_defined(case: Case, motion: Trajectory, truth: Losses) -> bool:
    """Whether friction takes something from the truth, and the losses of the motion may be known."""
    return 0.0 < truth.by_law < np.inf and _has_losses(case, motion)  # not NaN


def losses_of_truth(case: Case, truth: Trajectory) -> Losses:
    """The losses of the true motion; `by_law` is NaN where friction takes almost nothing."""
    own = _losses_of_any(case, truth, float(truth.t[-1]))
    largest = float(np.max(kinetic_energy(case, truth)))
    return own if own.by_law > _LEAST_LOSS * largest else Losses(own.actual, np.nan)


def _losses_of_any(case: Case, motion: Trajectory, end: float) -> Losses:
    """The losses of a motion, which is sampled only if they can be known."""
    if not _has_losses(case, motion):
        return INDETERMINATE
    return losses(case, even_samples(motion), end)


def _has_losses(case: Case, motion: Trajectory) -> bool:
    """Whether the losses follow from the momentum: with Coulomb friction, a track at rest, and one contact, or several
    of one plate with one straight track, whose forces act along the same normal."""
    if case.effect(CoulombFriction) is None or case.effect(Drive) is not None:
        return False
    if len(motion.contact_names) == 1:
        return True
    places = np.concatenate([columns.xi1 for columns in motion.contacts.values()])
    bends = np.abs(case.track.curvature(places[np.isfinite(places)]))
    is_straight = bool(np.max(bends, initial=0.0) * case.plate.reach <= _STRAIGHT)
    return is_straight and not case.others and all(name.startswith(ON_TRACK) for name in motion.contact_names)


def _contact(motion: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Slip velocity (m/s) and place on the track, of several contacts their means; NaN where none is touches."""
    if len(motion.contact_names) == 1:
        return motion.slip, motion.xi1
    contacts = motion.contacts.values()
    slips, places = np.array([one.slip for one in contacts]), np.array([one.xi1 for one in contacts])
    touches = np.isfinite(slips)
    count = np.where(touches.any(axis=0), touches.sum(axis=0), np.nan)
    slip, xi1 = (np.sum(np.where(touches, values, 0.0), axis=0) / count for values in (slips, places))
    return slip, xi1


def losses(case: Case, motion: Trajectory, end: float) -> Losses:
    """The losses of a motion up to the time `end`: the law takes Σ (μ|slip| + arm|ω|) N h.

    The normal force N follows from the motion's momentum, m (Δv/h − g) − load, along the track's normal. The work of a
    load, of the user's own effects and of a belt counts as energy added. NaN where the case has no Coulomb friction or
    a driven track, for contacts whose normal forces do not follow from the momentum, and where the plate
    flies, because an impact takes energy in no time.
    """
    friction, resistance = case.effect(CoulombFriction), case.effect(RollingResistance)
    inside = motion.t <= end
    if friction is None or not _has_losses(case, motion):
        return INDETERMINATE
    slip, xi1 = (values[inside] for values in _contact(motion))
    if inside.sum() < 2 or not np.isfinite(xi1).all():
        return INDETERMINATE
    h, load = np.diff(motion.t[inside]), applied_forces(case, motion, inside)
    vx, vy, omega = (getattr(motion, name)[inside] for name in ("vx", "vy", "omega"))
    push_x, push_y = contact_impulses(case, motion, load, inside)
    normal = np.asarray(case.track.normal(_middle(xi1)))
    impulse = push_x * normal[0] + push_y * normal[1]
    if case.effect(Unilateral) is None:
        impulse = np.abs(impulse)
    rates = friction.at(np.abs(slip)) * np.abs(slip) + (resistance.arm * np.abs(omega) if resistance else 0.0)
    work = np.sum(h * _middle(load[0] * vx + load[1] * vy + load[2] * omega))
    if case.effect(Belt) is not None:
        tangent = np.asarray(case.track.tangent(_middle(xi1)))
        work += np.sum((push_x * tangent[0] + push_y * tangent[1]) * _middle(belt_speed(case, motion.t[inside])))
    total = energy(case, motion)[inside]
    return Losses(float(total[0] - total[-1] + work), float(np.sum(_middle(rates) * impulse)))


def contact_impulses(case: Case, motion: Trajectory, load: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Impulse of the contacts with the track from each of the samples `inside` to the next, by the plate's momentum:
    m Δv − (weight + load) h, shape (2, n − 1), N s. `load`: the forces at the samples, N, shape (2 or more, n)."""
    forces = load[:2] + case.plate.mass * gravity(case)[:, None]
    velocity = np.array([motion.vx[inside], motion.vy[inside]])
    means = 0.5 * (forces[:, 1:] + forces[:, :-1])
    return case.plate.mass * np.diff(velocity, axis=1) - np.diff(motion.t[inside]) * means


def _middle(values: np.ndarray) -> np.ndarray:
    """The means of neighbouring values."""
    return 0.5 * (values[1:] + values[:-1])
