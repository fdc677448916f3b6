"""The impulses of a motion's impacts, from the velocities before and after them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import groupby
from math import inf, nan
from typing import NamedTuple

import numpy as np

from cases import BadValue, Case, ContactImpulse, Drive, Trajectory
from cases.motion.mechanics import gravity
from cases.moving_frame import in_track_frame, relative_case
from cases.scene.free_plates import loads_of, plates_of

from .laws_check import laws
from .laws_check.ends_check import before_start, begins_with_impact
from .laws_check.impact_check import groups_of, places_of_impact
from .laws_check.samples import of_motion, steps_of
from .laws_check.tolerances import POSE
from .laws_check.touches import masses, plates_at

# Impulses whose combination changes no velocity by more than this part of the largest are not unique.
NOT_UNIQUE = 1e-9
# Times of a motion's transition and of its impact differ by less than this part of its duration.
SAME_TIME = 1e-9
# Normal velocities below this part of the closing speed are none: an impulse is known to it.
STILL = 0.01


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
    the last sample before the impact and the first one after it, continued to it under gravity and loads: forces of
    contacts that go on there count as impulses. An impact of finite duration has samples inside it. NaN where
    velocities are not known, and on a track that moves. A motion that has its impulses keeps them.
    """
    if motion.impulses is not None:
        return tuple(_nearest(motion, one._replace(time=time_of(one.time))) for one in truth.impacts)
    at_once = [list(group) for _, group in groupby(_impacts_of_truth(case, truth), lambda impact: impact.time)]
    mass, samples, results = masses(case)[0], _PlateSamples.of(motion), list[ContactImpulse]()
    times = [time_of(impacts[0].time) for impacts in at_once]
    for impacts, time in zip(at_once, times, strict=True):
        span = max([-inf, *(t for t in times if t < time)]), min([inf, *(t for t in times if t > time)])
        ends = samples.ends(case, impacts, time, span) if case.effect(Drive) is None else None
        if ends is None:
            results += [ContactImpulse(time, name, nan, nan, nan) for one in impacts for name in one.contacts]
            continue
        before, after = (samples.rates[:, k] + (time - motion.t[k]) * _accelerations(case, motion, k) for k in ends)
        for one in impacts:
            results += _impulses(one._replace(time=time, before=before, after=after), mass)
    return tuple(results)


def _nearest(motion: Trajectory, one: ContactImpulse) -> ContactImpulse:
    """What the contact does in the motion's own impact at that time; NaN if it has none."""
    none = ContactImpulse(one.time, one.contact, nan, nan, nan)
    here = (own for own in motion.impacts if own.contact == one.contact)
    own = min(here, key=lambda own: abs(own.time - one.time), default=none)
    return own if abs(own.time - one.time) <= SAME_TIME * float(motion.t[-1]) else none


class _PlateSamples(NamedTuple):
    """Samples of a motion: their times (T,), s; velocities of all plates (3 n, T); whether a sample is neither contact
    nor flight, as some are inside an impact (T,); and by contact whether it is closed (T,)."""

    t: np.ndarray
    rates: np.ndarray
    blank: np.ndarray
    closures: dict[str, np.ndarray]

    @classmethod
    def of(cls, motion: Trajectory) -> _PlateSamples:
        plates = [motion.plate(name) for name in motion.plate_names]
        rates = np.array([getattr(plate, name) for plate in plates for name in ("vx", "vy", "omega")])
        is_alone = len(motion.contact_names) == 1
        blank = is_alone & np.isnan(motion.xi1) & np.isnan(motion.normal_force)
        closures = {name: np.isfinite(of.slip) for name, of in motion.contacts.items()}
        return cls(motion.t, rates, blank, closures)

    def ends(
        self, case: Case, impacts: list[_TouchingPlates], time: float, span: tuple[float, float]
    ) -> tuple[int, int] | None:
        """The last sample before the impacts of a time and the first one after them, within `span` (s), between the
        times of the impacts beside them; None if there are none.

        Before it a contact closes; inside it one still closes, moves and is shut, or is accelerated, by more than
        `STILL` of the closing speed and, where gravity is balanced, what that would make meanwhile.
        """
        pull = np.tile([*gravity(case), 0.0], len(self.rates) // 3)
        across, open_ = np.vstack([one.rows[::2] for one in impacts]), np.zeros(len(self.t), bool)
        speeds = across @ (self.rates + np.outer(pull, time - self.t))
        closing = -float((across @ impacts[0].before).min())
        shut = np.array([self.closures.get(name, open_) for one in impacts for name in one.contacts])
        least = STILL * closing + shut * np.hypot(*gravity(case)) * np.abs(self.t - time)
        inside, closes = self.blank | (shut & (np.abs(speeds) > least)).any(axis=0), (speeds < -least).any(axis=0)
        steps = STILL * closing + 2.0 * np.hypot(*gravity(case)) * np.diff(self.t)
        inside[:-1] |= (self.t[:-1] > time) & (np.abs(np.diff(speeds)) > steps).any(axis=0)
        before = np.flatnonzero((self.t > span[0]) & (self.t < time) & ~inside & closes)
        after = np.flatnonzero((self.t > time) & (self.t < span[1]) & ~inside & ~closes)
        return (int(before[-1]), int(after[0])) if len(before) and len(after) else None


@lru_cache(maxsize=4)
def _impacts_of_truth(case: Case, truth: Trajectory) -> tuple[_TouchingPlates, ...]:
    """Cached, as all motions of a case are compared with one truth."""
    return tuple(_impacts(case, truth, 1e-10))


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
        first = [(0.0, 0)] if begins_with_impact(samples, scales, rtol) else []
    for time, step in [*first, *zip(sudden.times.tolist(), sudden.steps.tolist(), strict=True)]:
        with np.errstate(all="ignore"):
            before = plates_at(samples, step - 1, -1) if step else before_start(samples)
            after = plates_at(samples, step, 0)
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
