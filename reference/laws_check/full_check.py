"""The laws that a motion breaks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from cases import BadValue, Case, Trajectory, Transition
from cases.moving_frame import in_track_frame, relative_case

from ..endings import CAUSES
from . import laws, penetration
from .broken_laws import OVERLAP, BrokenLaw, worst, worst_first
from .contact_check import contact_defects, unresolved_steps
from .ends_check import end_defects, following_defects, start_defects
from .events import event_defects, limit_of_impacts
from .formula_steps import finer_steps
from .impact_check import impact_defects
from .laws import Defects, Joins, MotionScales
from .samples import ContactInstants, MotionSamples, PlateSamples, nodes_of, of_motion, plates_of_motion, steps_of
from .tolerances import DRIVEN, OVERLAPS, POSE

# Steps whose forces the nodes do not resolve are divided into so many parts, so many times: the worst of them.
DIVIDED, DIVISIONS, MOST_DIVIDED = 4, 5, 8
# Overlaps are looked for where plates go so far at the most, in parts of their size, but in so many parts of a step.
WAY, MOST_WAYS = 0.8, 64
# Steps in which a sign is not resolved are divided into so many parts.
SIGN_PARTS = 16


def check(case: Case, motion: Trajectory, rtol: float = 1e-10) -> tuple[BrokenLaw, ...]:
    """The laws that a motion of a case breaks, overlaps first, then the one that is broken most (in parts of its
    limit).

    `motion`: a Trajectory with dense output, from any solver, with the modes of its contacts in its transitions;
    `rtol`: its relative accuracy, of which a hundredfold is no broken law (0: it is exact to roundings). Of each step
    between two samples the laws are evaluated at 25 instants, and more closely where these do not resolve the forces:
    no overlap of any pair, normal forces press, Coulomb's law, no slip in a roll, contacts stay closed, poses are
    continuous, velocities jump by the law of impact only, energy is not created (where no load, belt or effect of a
    package gives some), and momenta change by the forces; at transitions their condition vanishes, and the motion goes
    on as the laws allow; start and end are the case's, and the status holds. Forces that are not unique (NaN) are in no
    balance, and the modes within a series of impacts that are not listed are not known.
    A motion that ends where it begins breaks none. Raises BadValue for a longer one without dense output.
    """
    if isinstance(motion, Trajectory) and len(motion.t) < 2:
        return ()
    if not isinstance(motion, Trajectory) or motion.dense is None:
        raise BadValue(f"check was given {motion!r}; give a Trajectory with dense output, as reference.simulate does")
    relative = relative_case(case)
    seen = motion if relative is case else in_track_frame(motion)
    with np.errstate(all="ignore"):
        return _broken_by(relative, seen, rtol, POSE if relative is case else DRIVEN)


def _broken_by(case: Case, motion: Trajectory, rtol: float, poses: float) -> tuple[BrokenLaw, ...]:
    """The laws that a motion breaks, of a case with a track at rest. A motion that ends where it begins has no steps,
    and breaks none."""
    start, end = steps_of(motion)
    if not len(start):
        return ()
    samples = of_motion(case, motion, start, end)
    scales = laws.motion_scales(samples, poses)
    every = laws.joins(samples)
    sudden = laws.jumps(every, scales.reach, scales.speed, laws.sudden_part(scales, rtol))
    samples = samples._replace(is_straight=samples.is_straight | _nested_rests(samples, sudden.times))
    results = list[BrokenLaw]()
    for defects in _motion_defects(samples, scales):
        if worst(defects, rtol) and (closer := _closer(case, motion, samples, defects, rtol, poses)):
            results.append(closer)
    if (finer := _finer(case, motion, samples, scales)) is not None:
        own = laws.motion_scales(finer, poses)
        of_finer = chain(_motion_defects(finer, own), _of_contacts(finer, own, sudden))
        results += [one for defects in of_finer if (one := worst(defects, rtol))]
    others = chain(
        start_defects(samples, scales, rtol), _other_defects(samples, scales, every, sudden, rtol),
        following_defects(samples, scales), end_defects(samples, scales, motion, case.duration, rtol),
    )  # fmt: skip
    results += [one for defects in others if (one := worst(defects, rtol))]
    return worst_first(results)


def _closer(
    case: Case, motion: Trajectory, samples: MotionSamples, defects: Defects, rtol: float, poses: float
) -> BrokenLaw | None:
    """The broken law of some steps if it is broken also with more instants: forces may change more quickly than those
    of a step resolve."""
    parts, limit = 1, defects.limit(rtol)
    steps = np.flatnonzero(np.abs(defects.sizes) > limit)
    sizes = defects.sizes[steps]
    for _ in range(DIVISIONS):
        parts *= DIVIDED
        steps = steps[np.argsort(-np.abs(sizes) / limit[steps])][:MOST_DIVIDED]
        knots = samples.start[steps, None] + samples.length[steps, None] * (np.arange(parts + 1) / parts)
        knots[:, -1] = samples.end[steps]
        again = of_motion(case, motion, knots[:, :-1].ravel(), knots[:, 1:].ravel())
        scales = laws.motion_scales(again, poses)
        one = next(d for d in _motion_defects(again, scales) if (d.law, d.place) == (defects.law, defects.place))
        sizes = one.sizes.reshape(-1, parts).sum(axis=1)
        steps, sizes = (values[np.abs(sizes) > limit[steps]] for values in (steps, sizes))
        if not len(steps):
            return None
    return worst(defects._replace(times=defects.times[steps], sizes=sizes, scale=limit[steps], floor=1.0), 0.0)


def _motion_defects(samples: MotionSamples, scales: MotionScales) -> Iterator[Defects]:
    """The defects of momenta and rates of poses in each step."""
    for one in laws.motion_defects(samples, laws.sums(samples, scales.speed), scales):
        yield one._replace(sizes=np.where(samples.is_straight, 0.0, one.sizes))


def _finer(case: Case, motion: Trajectory, samples: MotionSamples, scales: MotionScales) -> MotionSamples | None:
    """Samples of the parts of those steps that the nodes do not resolve, or None."""
    start, end = finer_steps(case, motion, samples, scales)
    signs = unresolved_steps(samples, scales)[:MOST_DIVIDED]
    knots = samples.start[signs, None] + samples.length[signs, None] * (np.arange(SIGN_PARTS + 1) / SIGN_PARTS)
    start, end = np.concatenate([start, knots[:, :-1].ravel()]), np.concatenate([end, knots[:, 1:].ravel()])
    return of_motion(case, motion, start, end) if len(start) else None


def _of_contacts(samples: MotionSamples, scales: MotionScales, sudden: Joins) -> Iterator[Defects]:
    for contact in samples.contacts:
        law, *rows = contact
        is_listed = _is_listed(samples, sudden.times, contact.steps)
        # The rest of small impacts that are not listed: a step after one of them, without forces, as of those listed.
        is_rest = ~is_listed & np.isnan(contact.normal).all(axis=1)
        is_rest &= np.isin(samples.start[contact.steps], sudden.times)
        # Of several contacts the impacts are not of one series.
        ends = samples.end[contact.steps[is_rest]].tolist() if len(samples.motion.contact_names) == 1 else []
        for end in ends:
            yield from limit_of_impacts(end, law.name, sudden.times, float(samples.end[-1]))
        keep = ~(samples.is_straight[contact.steps] | is_rest)
        if keep.any():
            solved = contact if keep.all() else ContactInstants(law, *(row[keep] for row in rows))
            yield from contact_defects(samples, solved, scales, is_listed[keep])


def _other_defects(
    samples: MotionSamples, scales: MotionScales, every: Joins, sudden: Joins, rtol: float
) -> Iterator[Defects]:
    yield from _of_contacts(samples, scales, sudden)
    is_series = ~(_is_listed(samples, sudden.times, every.steps) & _is_listed(samples, sudden.times, every.steps - 1))
    yield from laws.continuity_defects(samples, every, scales, is_series)
    if len(sudden.steps):
        yield from impact_defects(samples, scales, sudden, rtol)
    yield from laws.energy_defects(samples, scales)
    yield from event_defects(samples, scales, sudden.times)
    for depth in penetration.depths(samples.case, *_short_ways(samples, scales), samples.near):
        yield Defects(OVERLAP, depth.pair, depth.times, depth.depths, scales.extent, "m", OVERLAPS)


def _short_ways(samples: MotionSamples, scales: MotionScales) -> tuple[np.ndarray, tuple[PlateSamples, ...]]:
    """Times (parts, nodes) and plates there, of the steps and of parts in which no plate goes far: a narrow ripple that
    is a thousandth of a plate's size deep in it is there for a twentieth of that."""
    ways = [
        np.abs(np.diff(one.place, axis=1)).sum(axis=1) / size
        for one, size in zip(samples.plates, scales.reach, strict=True)
    ]
    count = np.clip(np.ceil(np.max(ways, axis=0) / WAY), 1, MOST_WAYS).astype(int)
    if (count == 1).all():
        return samples.times, samples.plates
    part = np.concatenate([np.arange(n) / n for n in count])
    length = np.repeat(samples.length, count)
    start = np.repeat(samples.start, count) + length * part
    times = nodes_of(start, start + length / np.repeat(count, count))
    return times, plates_of_motion(samples.motion, times)


def _is_listed(samples: MotionSamples, sudden: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Which of some steps have the modes that the transitions list (`sudden`: times at which velocities jump): not
    those of a series of impacts that are not listed, from the last transition before one of these to its end."""
    instants = np.array([0.0, *(change.time for change in samples.transitions)])
    others = np.setdiff1d(sudden, instants)
    first = instants[np.searchsorted(instants, others) - 1]
    last = np.array([_rest_after(samples.transitions, t) for t in others.tolist()])
    start = samples.start[steps]
    return ~((start[:, None] >= first) & (start[:, None] < last)).any(axis=1)


def _nested_rests(samples: MotionSamples, sudden: np.ndarray) -> np.ndarray:
    """Which steps go from the last of small impacts to their end, within a series of others that is not listed."""
    is_rest = ~_is_listed(samples, sudden, np.arange(len(samples.start)))
    is_rest &= np.isin(samples.start, sudden) & ~np.isin(samples.end, sudden)
    for step in np.flatnonzero(is_rest):
        limits = limit_of_impacts(float(samples.end[step]), "", sudden, float(samples.end[-1]))
        is_rest[step] = [worst(one, 0.0) for one in limits] == [None]
    return is_rest


def _rest_after(transitions: Sequence[Transition], t: float) -> float:
    """When all series of impacts that go on at a time (s) are over: those of contacts whose next change is a rest, else
    the next one; infinite without one."""
    after = [change for change in transitions if change.time > t]
    rests = [change.time for change in after if change.cause == CAUSES["rest"]]
    following = {change.contact: change for change in reversed(after)}.values()
    every = [change.time for change in following if change.cause == CAUSES["rest"]]
    return max(every, default=min(rests, default=np.inf))
