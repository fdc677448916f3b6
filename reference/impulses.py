"""The impulses of a motion's impacts, from the velocities before and after them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import nan
from typing import NamedTuple

import numpy as np

from cases import BadValue, Case, ContactImpulse, Drive, Trajectory
from cases.motion.mechanics import gravity
from cases.moving_frame import in_track_frame, relative_case
from cases.scene.free_plates import loads_of, plates_of

from .laws_check import laws
from .laws_check.impact_check import groups_of, places_of_impact
from .laws_check.samples import of_motion, steps_of
from .laws_check.tolerances import POSE
from .laws_check.touches import masses, plates_at

# Impulses whose combination changes no velocity by more than this part of the largest are not unique.
NOT_UNIQUE = 1e-9


class _TouchingPlates(NamedTuple):
    """Contacts that hang together in an impact: its time (s), their names, the matrix (2 k, 3 n) from the rates of all
    plates to the velocities along their normals and tangents, and those rates before and after, (3 n,)."""

    time: float
    contacts: list[str]
    rows: np.ndarray
    before: np.ndarray
    after: np.ndarray


def impacts(case: Case, motion: Trajectory, rtol: float = 1e-10) -> tuple[ContactImpulse, ...]:
    """The impulses of every impact of a motion of a case, in the order of their times; `motion.impacts` has them, too.

    `motion`: a Trajectory with dense output, as `reference.simulate` gives it, of relative accuracy `rtol`: smaller
    jumps of velocities are no impacts. M (u⁺ − u⁻) = Σ (tᵀ P_t + nᵀ P_n) over the contacts that touch, and a contact's
    work is P · (u⁻ + u⁺)/2, so that the sum of all is the change of kinetic energy. Where the track moves, velocities
    are those against it. Raises BadValue for a motion without dense output.
    """
    if not isinstance(motion, Trajectory) or (motion.dense is None and len(motion.t) > 1):
        raise BadValue(f"impacts was given {motion!r}; give a Trajectory with dense output, as reference.simulate does")
    mass = masses(relative_case(case))[0]
    return tuple(one for impact in _impacts(case, motion, rtol) for one in _impulses(impact, mass))


def impacts_of_samples(
    case: Case, truth: Trajectory, motion: Trajectory, time_of: Callable[[float], float]
) -> tuple[ContactImpulse, ...]:
    """The impulses of a sampled motion in the impacts of the true one, in the order of `impacts(case, truth)`.

    `time_of` maps the time of a true impact to that of the motion's (s), NaN where it has none. Velocities are those of
    the last sample before and the first one after it, continued to it under gravity and loads: forces of contacts that
    go on there count as impulses. NaN where they are not known, and on a track that moves.
    """
    mass, results = masses(case)[0], list[ContactImpulse]()
    for impact in _impacts(case, truth, 1e-10):
        time = time_of(impact.time)
        i, j = int(np.searchsorted(motion.t, time)) - 1, int(np.searchsorted(motion.t, time, side="right"))
        if case.effect(Drive) is None and 0 <= i and j < len(motion.t):
            before, after = (_rates(motion, k) + (time - motion.t[k]) * _accelerations(case, motion, k) for k in (i, j))
            results += _impulses(impact._replace(time=time, before=before, after=after), mass)
        else:
            results += [ContactImpulse(time, name, nan, nan, nan) for name in impact.contacts]
    return tuple(results)


def _impacts(case: Case, motion: Trajectory, rtol: float) -> Iterator[_TouchingPlates]:
    """The impacts of a motion with dense output in the order of their times, those of one instant by contacts that hang
    together."""
    start, end = steps_of(motion)
    if not len(start):
        return
    relative = relative_case(case)
    with np.errstate(all="ignore"):  # parameters of open contacts are NaN
        samples = of_motion(relative, motion if relative is case else in_track_frame(motion), start, end)
        scales = laws.motion_scales(samples, POSE)
        sudden = laws.jumps(laws.joins(samples), scales.reach, scales.speed, laws.sudden_part(scales, rtol))
    for time, step in zip(sudden.times.tolist(), sudden.steps.tolist(), strict=True):
        with np.errstate(all="ignore"):
            before, after = plates_at(samples, step - 1, -1), plates_at(samples, step, 0)
            groups = groups_of(places_of_impact(samples, scales, before, step, time, rtol))
        for group in groups:
            rows = np.array([row for one in group for row in (one.across, one.along)])
            yield _TouchingPlates(time, [one.law.name for one in group], rows, before.rates, after.rates)


def _impulses(impact: _TouchingPlates, mass: np.ndarray) -> list[ContactImpulse]:
    """The impulses of an impact's contacts; `mass`: masses and moments of inertia of all plates, (3 n,)."""
    values = _unique(impact.rows, mass * (impact.after - impact.before)).reshape(-1, 2)
    mean = (impact.rows @ (0.5 * (impact.before + impact.after))).reshape(-1, 2)
    work = (values * mean).sum(axis=1)
    both = zip(impact.contacts, values.tolist(), work.tolist(), strict=True)
    return [ContactImpulse(impact.time, name, normal, friction, of_both) for name, (normal, friction), of_both in both]


def _rates(motion: Trajectory, i: int) -> np.ndarray:
    """The velocities of all plates at a sample, (3 n,)."""
    plates = [motion.plate(name) for name in motion.plate_names]
    return np.array([getattr(plate, name)[i] for plate in plates for name in ("vx", "vy", "omega")])


def _accelerations(case: Case, motion: Trajectory, i: int) -> np.ndarray:
    """The accelerations of all plates by gravity and loads at a sample, (3 n,)."""
    rows = []
    for name, plate, load in zip(motion.plate_names, plates_of(case), loads_of(case), strict=True):
        one = motion.plate(name)
        now = [float(getattr(one, name)[i]) for name in ("t", "x", "y", "theta", "vx", "vy", "omega")]
        fx, fy, moment = load.at(*now) if load is not None else (0.0, 0.0, 0.0)
        rows.append((*(gravity(case) + np.array([fx, fy]) / plate.mass), moment / plate.inertia))
    return np.array(rows).ravel()


def _unique(rows: np.ndarray, change: np.ndarray) -> np.ndarray:
    """The impulses along the rows that make a change of momenta; NaN where others make the same."""
    impulses, *_, sizes = np.linalg.lstsq(rows.T, change, rcond=NOT_UNIQUE)
    _, _, basis = np.linalg.svd(rows.T)
    free = basis[np.count_nonzero(sizes > NOT_UNIQUE * sizes.max(initial=0.0)) :]
    return np.where((np.abs(free) > NOT_UNIQUE).any(axis=0), np.nan, impulses)
