"""How far a motion is from the truth, as a share of what a motion that ignores friction's law is: one number, `off`.

    off = max(pose score, mode score, slip score)

Each score is an error divided by that of the nearest of the case's null motions (`null_motions`), so that it has no
unit (docs/report.md). Pure functions; SI units.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Mode, Plate, State, Trajectory, Transition

from . import doubts, transitions
from .claims import claims_hold
from .distances import differences, even_samples
from .friction_factor import Losses, losses_of_truth
from .mean_errors import end_of_samples, mean_errors, sample_gaps
from .phases import (
    ModePhase,
    agreement,
    flights,
    outside,
    phases_of,
    rolling_within,
    time_by_mode,
    time_in_another_mode,
)
from .slip_phases import RESOLVABLE_GAPS, SURELY, Reading

# What differs from the truth by less than this part of its path is the truth, and slip below this part of its speed is
# none: single precision resolves no more.
_SAME = 1e-6
# A plate whose path is shorter than this part of its size stays where it is: double precision resolves no more.
_RESTS = 1e-12
# The time in a wrong mode is measured against this part of the motion at least: else the score of a case that changes
# its mode for an instant would depend on that instant alone.
_LEAST_TIME = 0.25
# A truth whose slip differs from the nearest null motion's by a distance below this part of that motion's pose error is
# judged as one that never slips: else the score of a case that slips for an instant would depend on that instant alone.
_LEAST_SLIP = 0.01
# Slip below this part of the fastest of the truth and of its nearest null motion may count as none, whatever the
# engine's creep is: as an error of slip it makes no more than about this part of a score.
_MOST_CREEP = 0.01
# Creep is free up to this part of the truth's fastest slip. Beyond, a reading that takes it for creep adds to the score
# in proportion, up to 1 at that speed: creep that is as fast as the slip is no creep.
_FREE_CREEP = 0.5
# Such a reading has a threshold that is larger than the creep by this factor.
_BEYOND = 1.05
# Creep is this quantile of the slip in the middle half of the truth's rolls: at their ends slip ends and begins.
_CREEP_QUANTILE, _END_OF_ROLL, _FEWEST = 0.95, 0.25, 3
# What is less than this part of a score does not count.
_SMALL_PART = 0.1
# A motion that locates its transitions is read from its samples too where it is farther from the truth than that.
_SURELY_RIGHT = 1e-4
# By how many thresholds of slip a motion is read at most, after its own.
_MOST_READINGS = 2
# Even times at which the truth is looked at where a motion has no samples.
_EVEN = 1001


@dataclass(frozen=True)
class Scale:
    """What the errors of a case are measured by: `pose` (m) and `slip` (m/s), the errors of the nearest null motion,
    and `time` (s) for the time in a wrong mode.

    `end` (s) and `phases` are the truth's, `slips` (m/s) the largest slip in each. `either` has the time spans (s) in
    which slip is too slow to be distinguished from a roll; they are rolls in `phases`. `fastest_slip` (m/s) is the
    largest of `slips`, or the fastest speed where nothing slips or only for an instant; `losses` are those of
    `friction_factor`. `null_motion` names the null motion with the smallest pose error, "" where none differs from the
    truth: `pose` is then the plate's reach. `share` is `pose` as a share of the truth's path, infinite for a plate that
    stays where it is; `most_creep` (m/s): slip below it may count as none. `hops` (s): the truth's flights after an
    impact.
    """

    pose: float
    slip: float
    time: float
    end: float
    phases: tuple[ModePhase, ...]
    slips: tuple[float, ...]
    either: tuple[tuple[float, float], ...]
    fastest_slip: float
    losses: Losses
    null_motion: str
    share: float
    most_creep: float
    hops: tuple[float, ...] = ()


class Score(NamedTuple):
    """How far a motion is from the truth. `off`: the largest of `pose`, `mode` and `slip`, shares of the error of
    ignoring friction's law. `doubt`: how much of `off` may be due to the motion's samples. `creep` (m/s): slip where
    the truth rolls, NaN where it does not roll. `sequence`: the least duration (s) such that the modes agree once
    phases no longer than that are removed, infinite where they agree for none; `resolution` (s): phases shorter than
    that are not resolved by the samples; `missing`: whether phases of the truth are among the removed ones."""

    off: float
    doubt: float
    pose: float
    mode: float
    slip: float
    creep: float
    sequence: float
    resolution: float
    missing: bool


def scale_of(
    case: Case,
    truth: Trajectory,
    events: Sequence[Transition],
    nulls: Mapping[str, Trajectory],
    losses: Losses | None = None,
) -> Scale:
    """The scale of a case: `truth` is its motion, known at every time, `events` its transitions, `nulls` its null
    motions by name; `losses`: those of the truth, by default `losses_of_truth`."""
    end = float(truth.t[-1])
    state = truth(np.linspace(0.0, end, _EVEN))
    plates = _plates(case, truth, np.linspace(0.0, end, _EVEN), state)
    path = max(_path(plate, own) for plate, own in plates)
    moves = path > _RESTS * case.plate.reach
    fastest = max(float(np.hypot(own.vx, own.vy).max()) for _, own in plates)
    speed = fastest if moves else case.plate.reach / case.duration
    slowest = _SAME * speed
    phases = phases_of(truth.first_mode, events, end)
    slips = tuple(_largest_slip(truth, phase) for phase in phases)
    # A slip that is too slow to be distinguished from a roll is one, for the truth and for every other motion.
    either = tuple(
        (phase.begin, phase.end)
        for phase, largest in zip(phases, slips, strict=True)
        if phase.mode in _SLIPS and largest <= slowest
    )
    phases = rolling_within(phases, either)
    slips = tuple(_largest_slip(truth, phase) for phase in phases)
    errors = {
        name: mean_errors(motion, truth, differences(motion, truth, case), case) for name, motion in nulls.items()
    }
    real = {name: pair for name, pair in errors.items() if pair[0] > _SAME * (path if moves else case.plate.reach)}
    nearest = min(real, key=lambda name: real[name][0], default="")
    others = end - max(time_by_mode(phases).values(), default=end)
    pose, slip_error = real[nearest] if nearest else (case.plate.reach, np.inf)
    least_slip = _LEAST_SLIP * pose / (end or case.duration)
    # An error of 0: they are in contact at no common time, or slip alike.
    is_slipping = max(slips, default=0.0) > slowest and not 0.0 < slip_error < least_slip
    fastest_slip = max(slips) if is_slipping else speed
    return Scale(
        pose=pose,
        slip=_slip_scale(real, nearest, max(_SAME * fastest_slip, least_slip)) or fastest_slip,
        time=(max(others, _LEAST_TIME * end) if others > 0.0 else end) or case.duration,
        end=end,
        phases=phases,
        slips=slips,
        either=either,
        fastest_slip=fastest_slip,
        losses=losses_of_truth(case, truth) if losses is None else losses,
        null_motion=nearest,
        share=pose / path if moves else np.inf,
        most_creep=_MOST_CREEP * max(fastest_slip, _fastest_slip(nulls[nearest]) if nearest else 0.0),
        hops=_hops(events),
    )


def _plates(case: Case, motion: Trajectory, times: np.ndarray, first: State) -> list[tuple[Plate, State]]:
    """All plates of a motion with their states at these times; `first`: those of the case's plate."""
    others = [other for other in case.others if other.name in motion.plate_names]
    return [(case.plate, first), *((other.plate, motion.plate(other.name)(times)) for other in others)]


def _path(plate: Plate, state: State) -> float:
    return float(np.hypot(np.hypot(np.ptp(state.x), np.ptp(state.y)), plate.gyration * np.ptp(state.theta)))


def _slip_scale(errors: Mapping[str, tuple[float, float]], nearest: str, least: float) -> float:
    """The mean slip error of the null motion that is nearest in pose, m/s; where that is below `least`, the smallest
    one of another null motion, 0 if there is none.

    Not simply the smallest one: a plate that never moves never slips, and so has the slip of a plate that rolls all the
    way, however far away it is.
    """
    large = {name: slip for name, (_, slip) in errors.items() if slip > least}
    return large.get(nearest, min(large.values(), default=0.0))


def _fastest_slip(motion: Trajectory | State) -> float:
    """The largest slip of a motion, m/s."""
    slip = np.abs(np.asarray(motion.slip))
    return float(np.max(slip, initial=0.0, where=np.isfinite(slip)))


_SLIPS = (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD)


def _hops(events: Sequence[Transition]) -> tuple[float, ...]:
    """The durations of flights that follow an impact, s."""
    return tuple(
        after.time - impact.time for impact, after in pairwise(events) if impact.before is impact.after is Mode.FLIGHT
    )


def _largest_slip(truth: Trajectory, phase: ModePhase) -> float:
    """The largest slip of the truth in a phase, m/s."""
    return _fastest_slip(truth(np.linspace(phase.begin, phase.end, 33)[1:-1]))


def score(case: Case, motion: Trajectory, truth: Trajectory, scale: Scale) -> Score:
    """The score of a sound motion."""
    return score_and_reading(case, motion, truth, scale)[0]


def _changes_with_slip(case: Case) -> bool:
    """Whether the coefficient of friction changes with the slip speed: by a formula, or from stick to slip."""
    friction = case.effect(CoulombFriction)
    return friction is not None and (bool(friction.by_speed) or friction.stick != friction.mu)


def doubt_of_reading(scores: Mapping[str, Score], of_truth: Mapping[str, Score] | None) -> float:
    """How much of the largest `off` of a motion's contacts may be due to how its samples are read: what each part of it
    has beyond the same part of the truth read from the same samples (`of_truth`) is sure. None: the truth cannot be
    read from them, and the poses alone are sure."""
    sure = [0.0]
    for name, one in scores.items():
        true = of_truth and of_truth[name]
        sure += [one.pose - true.pose, one.mode - true.mode, one.slip - true.slip] if true else [one.pose]
    return max(one.off for one in scores.values()) - max(sure)


# Reads first mode and transitions of a sampled motion.
Reader = Callable[[Case, Trajectory], Reading]


def score_and_reading(
    case: Case,
    motion: Trajectory,
    truth: Trajectory,
    scale: Scale,
    off: Mapping[str, np.ndarray] | None = None,
    read: Reader | None = None,
) -> tuple[Score, Reading]:
    """The score of a sound motion, and the reading of its transitions that agrees best with the truth. `read`: how they
    are read, by default `transitions.read_motion`."""
    errors = mean_errors(motion, truth, differences(motion, truth, case) if off is None else off, case)
    if not claims_hold(motion):
        motion = replace(motion, first_mode=None, transitions=())
    pose, slip = (
        error / size if size > 0.0 else 0.0 for error, size in zip(errors, (scale.pose, scale.slip), strict=True)
    )
    creep = _creep(motion, scale)
    is_exact = motion.first_mode is not None
    resolution = 0.0 if is_exact else RESOLVABLE_GAPS * doubts.gap(motion)
    noise = 0.0
    if not is_exact and scale.slip > 0.0:
        smear = doubts.of_differences(motion, case.plate.reach) if doubts.are_differences(motion) else 0.0
        noise = max(doubts.roughness(motion.t, motion.slip), smear) / scale.slip
    best = _modes(case, motion, scale, creep, resolution, max(pose, slip), read or transitions.read_motion)
    worst, doubt = max(pose, best.wrong, slip), max(best.doubt, noise)
    return Score(worst, doubt, pose, best.wrong, slip, creep, best.longest, resolution, best.missing), best.reading


class _Modes(NamedTuple):
    """The result of one reading of a motion's modes: the mode score, the part of it that is not about flights, its
    doubt, and how the sequences agree."""

    reading: Reading
    wrong: float
    touching: float
    doubt: float
    longest: float
    missing: bool


def _modes(
    case: Case, motion: Trajectory, scale: Scale, creep: float, resolution: float, others: float, read: Reader
) -> _Modes:
    """The reading of a motion's modes that agrees best with the truth. `others`: the larger one of the other scores."""
    is_exact = motion.first_mode is not None
    unresolved = 0.0 if is_exact else doubts.unresolved(motion, scale.phases, scale.slips, scale.hops)
    gaps, last = sample_gaps(motion), end_of_samples(motion, scale.end)
    true_flights, best = flights(scale.phases), None
    for reading, sampled, surcharge in _readings(case, motion, scale, creep, read):
        phases = rolling_within(phases_of(reading.first_mode, reading.transitions, last), scale.either)
        phases = outside(phases, gaps)
        wrong = time_in_another_mode(phases, scale.phases, scale.end) / scale.time + surcharge
        if scale.end == 0.0:  # the truth leaves the track at once, and has its first mode only
            wrong = float(reading.first_mode != scale.phases[0].mode)
        if best is None or wrong < best.wrong * (1.0 - _SAME):
            touching = wrong - time_in_another_mode(flights(phases), true_flights, scale.end) / scale.time
            times = doubts.time(sampled, reading, case.plate.reach, _changes_with_slip(case)) if sampled else 0.0
            doubt = (unresolved + times) / scale.time
            best = _Modes(reading, wrong, touching, doubt, *agreement(phases, scale.phases))
        # A threshold of slip makes no difference to flights, nor one that counts where other scores are larger.
        small = best.touching <= max(_SMALL_PART * best.wrong, is_exact * _SURELY_RIGHT)
        if small or (best.touching <= max(best.doubt, others) and best.longest <= resolution):
            break
    assert best is not None, "a motion has one reading at least"
    return best


def _readings(
    case: Case, motion: Trajectory, scale: Scale, creep: float, read: Reader
) -> Iterator[tuple[Reading, Trajectory | None, float]]:
    """The motion's modes by several thresholds of slip, with the samples that they are read from and what each adds to
    the score; before them its own, where it locates its transitions itself.

    A single threshold fails both ways: one that is too large loses short rolls and slow slips, one that is too small
    takes creep and noise for slip. Slip that is none by the threshold is an error of slip and pose.
    """
    if motion.first_mode is not None:
        own = tuple(motion.transitions)
        yield Reading(motion.first_mode, own, (float("nan"),) * len(own)), None, 0.0
        motion = replace(even_samples(motion), first_mode=None, transitions=())
    cap = scale.most_creep
    creep_limit = min(motion.slip_resolution, cap)
    yield read(case, replace(motion, slip_resolution=creep_limit)), motion, 0.0
    # Where the truth's rolls are too short for the creep to be known, slip within its noise may be none.
    slowest = creep if np.isfinite(creep) else doubts.roughness(motion.t, motion.slip)
    most = _FREE_CREEP * scale.fastest_slip / SURELY
    multiples = [min(share * slowest, most) for share in (2.0, 1.0, 4.0, 0.6)]
    others = dict.fromkeys((*multiples, 0.0, cap / 8.0, cap))
    # A reading takes long, so only the thresholds are read by which fewer samples are in another mode than the truth.
    wrong = _samples_in_another_mode(motion, scale, [creep_limit, *others])
    better = sorted((part, threshold) for threshold, part in zip(others, wrong[1:], strict=True))
    for part, threshold in better[:_MOST_READINGS]:
        if part < (1.0 - _SMALL_PART) * wrong[0]:
            yield read(case, replace(motion, slip_resolution=threshold)), motion, 0.0
    surcharge = (slowest / scale.fastest_slip - _FREE_CREEP) / (1.0 - _FREE_CREEP)
    if 0.0 < surcharge < 1.0:
        yield read(case, replace(motion, slip_resolution=_BEYOND * slowest / SURELY)), motion, surcharge


def _samples_in_another_mode(motion: Trajectory, scale: Scale, thresholds: Sequence[float]) -> list[float]:
    """Seconds of the samples that are in another mode than the truth, by each threshold of slip."""
    truth = {Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0, Mode.FLIGHT: np.nan}
    place = np.searchsorted([phase.end for phase in scale.phases], motion.t).clip(0, len(scale.phases) - 1)
    true = np.array([truth.get(phase.mode, 0.0) for phase in scale.phases])[place]
    weight = np.gradient(motion.t) if len(motion.t) > 1 else np.ones(1)
    contact = np.isfinite(motion.slip) & np.isfinite(true)
    size, sign = np.abs(motion.slip[contact]), np.sign(motion.slip[contact])
    return [
        float(np.sum(weight[contact][np.where(size > SURELY * threshold, sign, 0.0) != true[contact]]))
        for threshold in thresholds
    ]


def _creep(motion: Trajectory, scale: Scale) -> float:
    """The slip of a motion where the truth rolls or rests, m/s; NaN where it does not, or for too short a time."""
    rolls = np.zeros(len(motion.t), dtype=bool)
    for phase in scale.phases:
        if phase.mode in (Mode.ROLL, Mode.REST):
            edge = _END_OF_ROLL * phase.duration
            rolls |= (motion.t > phase.begin + edge) & (motion.t < phase.end - edge)
    slip = np.abs(motion.slip[rolls & np.isfinite(motion.slip)])
    return float(np.quantile(slip, _CREEP_QUANTILE)) if len(slip) >= _FEWEST else float("nan")
