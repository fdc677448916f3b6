"""The impulses of a motion's impacts, from the velocities before and after them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import BadValue, Case, Trajectory
from cases.moving_frame import in_track_frame, relative_case

from .laws_check import laws
from .laws_check.impact_check import groups_of, places_of_impact
from .laws_check.samples import of_motion, steps_of
from .laws_check.tolerances import POSE
from .laws_check.touches import masses, plates_at

# Impulses whose combination changes no velocity by more than this part of the largest are not unique.
NOT_UNIQUE = 1e-9


class ContactImpulse(NamedTuple):
    """What one contact does in an impact at a `time` (s): the impulses along its normal and tangent, N s, and their
    work, J (negative: lost energy). An impulse that the velocities do not determine, as of a box that lands on both
    corners with friction, is NaN."""

    time: float
    contact: str
    normal: float
    friction: float
    work: float


def impacts(case: Case, motion: Trajectory, rtol: float = 1e-10) -> tuple[ContactImpulse, ...]:
    """The impulses of every impact of a motion of a case, in the order of their times.

    `motion`: a Trajectory with dense output, as `reference.simulate` gives it, of relative accuracy `rtol`: smaller
    jumps of velocities are no impacts. M (u⁺ − u⁻) = Σ (tᵀ P_t + nᵀ P_n) over the contacts that touch, and a contact's
    work is P · (u⁻ + u⁺)/2, so that the sum of all is the change of kinetic energy. Where the track moves, velocities
    are those against it. Raises BadValue for a motion without dense output.
    """
    if not isinstance(motion, Trajectory) or (motion.dense is None and len(motion.t) > 1):
        raise BadValue(f"impacts was given {motion!r}; give a Trajectory with dense output, as reference.simulate does")
    start, end = steps_of(motion)
    if not len(start):
        return ()
    with np.errstate(all="ignore"):  # parameters of open contacts are NaN
        return _impulses(case, motion, start, end, rtol)


def _impulses(
    case: Case, motion: Trajectory, start: np.ndarray, end: np.ndarray, rtol: float
) -> tuple[ContactImpulse, ...]:
    relative = relative_case(case)
    samples = of_motion(relative, motion if relative is case else in_track_frame(motion), start, end)
    scales = laws.motion_scales(samples, POSE)
    sudden = laws.jumps(laws.joins(samples), scales.reach, scales.speed, laws.sudden_part(scales, rtol))
    results = list[ContactImpulse]()
    for time, step in zip(sudden.times.tolist(), sudden.steps.tolist(), strict=True):
        before, after = plates_at(samples, step - 1, -1), plates_at(samples, step, 0)
        for group in groups_of(places_of_impact(samples, scales, before, step, time, rtol)):
            rows = np.array([row for one in group for row in (one.across, one.along)])
            change = masses(relative)[0] * (after.rates - before.rates)
            impulses = _unique(rows, change)
            mean = rows @ (0.5 * (before.rates + after.rates))
            for one, (normal, friction), (across, along) in zip(
                group, impulses.reshape(-1, 2).tolist(), mean.reshape(-1, 2).tolist(), strict=True
            ):
                results.append(ContactImpulse(time, one.law.name, normal, friction, normal * across + friction * along))
    return tuple(results)


def _unique(rows: np.ndarray, change: np.ndarray) -> np.ndarray:
    """The impulses along the rows that make a change of momenta; NaN where others make the same."""
    impulses, *_, sizes = np.linalg.lstsq(rows.T, change, rcond=NOT_UNIQUE)
    _, _, basis = np.linalg.svd(rows.T)
    free = basis[np.count_nonzero(sizes > NOT_UNIQUE * sizes.max(initial=0.0)) :]
    return np.where((np.abs(free) > NOT_UNIQUE).any(axis=0), np.nan, impulses)
