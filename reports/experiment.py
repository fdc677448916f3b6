"""Cases × solvers × routes × settings -> runs. Owns the clock; every solver works in a process of its own.

Three steps, each a list of isolated calls: `survey` asks what a solver offers for a case, `find_truth` makes the
motion the others are judged by, `perform` runs one setting and judges it. Whatever happens, each gives a record.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

import adapters
import cases
import reference
from adapters import EngineFailure, Setting
from cases import Case, Cost, CoulombFriction, Mode, NotSupported, Trajectory, Transition

from . import metrics, workers

REFERENCE = "reference"
# The truth is the reference at its tightest sensible tolerance; how far its other methods, and a hundred times looser
# runs, move each transition stands as its error bar until a certified one takes its place.
TRUTH_RTOL, TRUTH_LOOSER = 1e-13, 1e-11
# Two tight runs whose transitions differ by more than this many seconds contradict each other: it is ten thousand
# times the spread of the worst of the catalogue's cases, and no truth for engines that come within 1e-8 s.
_AGREEMENT = 1e-7
# Rounding of the time itself: an error bar below a few units in its last place would be a fluke.
_ULPS = 4
# What a figure can show; samples beyond are left out at even distances.
_SHOWN_SAMPLES = 1500
# Wall time a run may take. A whole default report takes minutes, so one run that takes longer has lost its way.
LIMIT_SECONDS = 60.0
# A solver that stops no more than this many of its own steps before the end of the truth has ended with it.
_LAST_STEPS = 2.5


class CaseKey(NamedTuple):
    """What names a case across processes: its name and parameters, and the files to be read before."""

    name: str
    parameters: tuple[tuple[str, Any], ...]
    files: tuple[str, ...]

    @classmethod
    def of(cls, case: Case, files: tuple[str, ...] = ()) -> CaseKey:
        """The key of a case of the catalogue or of `files`."""
        return cls(case.name, tuple(case.parameters.items()), files)


@dataclass(frozen=True)
class Offer:
    """What one route of a solver offers for a case: a ladder of settings, or the reason why not.

    `outcome` is "" for an offer, else "refused" or "crashed"."""

    route: str
    settings: tuple[Setting, ...] = ()
    outcome: str = ""
    reason: str = ""


@dataclass(frozen=True)
class Truth:
    """The motion a case's runs are judged by, by `method` of the reference. `error_bars` (s) belong to `transitions`.

    `samples` is for figures; `notes` tell which other runs of the reference disagreed or failed. `failure` is a
    sentence if there is no truth to be had; the rest is then empty.
    """

    method: str = ""
    transitions: tuple[Transition, ...] = ()
    error_bars: tuple[float, ...] = ()
    first_mode: Mode | None = None
    status: str = ""
    reason: str = ""
    samples: dict[str, np.ndarray] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    failure: str = ""


@dataclass(frozen=True)
class Run:
    """One row of the experiment: who ran what, what came of it, and how it compares with the truth.

    `outcome` is one of right, wrong, refused, crashed, timed_out. `samples` and `off` (solver minus truth) are for
    figures, thinned; `spreads` (s) tell how sure the reading of each of the solver's transitions is.
    """

    case: str
    solver: str
    route: str
    setting: str
    rung: int
    outcome: str
    reason: str = ""
    status: str = ""
    first_mode: str = ""
    ledger: tuple[metrics.LedgerRow, ...] = ()
    spreads: tuple[float, ...] = ()
    distance: metrics.Distance = metrics.Distance(*6 * (float("nan"),))
    cost: Cost = Cost()
    samples: dict[str, np.ndarray] = field(default_factory=dict)
    off: dict[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True)
class Experiment:
    """Everything that was found out, in the order asked for: truths by case label, and the runs."""

    cases: tuple[Case, ...]
    truths: dict[str, Truth]
    runs: tuple[Run, ...]
    seconds: float


def is_default_setting(setting: Setting | str) -> bool:
    """Whether a setting is the engine as it comes: adapters name that rung `rung=defaults`."""
    return "rung=defaults" in str(setting).split()


# --- one call each, in a worker ---------------------------------------------------------------------------------------


@lru_cache(maxsize=8)
def load(key: CaseKey) -> Case:
    """The case of a key."""
    for file in key.files:
        if key.name not in cases.names():
            cases.load_file(file)
    return cases.load(key.name, **dict(key.parameters))


def solver(name: str) -> ModuleType:
    """A solver by name, an engine or the reference; raises ImportError if it is not installed."""
    if name == REFERENCE:
        from . import reference_adapter

        return reference_adapter
    return adapters.engine(name)


def version(name: str) -> str:
    """The version of a solver."""
    try:
        return str(solver(name).version())
    except ImportError:
        return "not installed"


def survey(key: CaseKey, name: str) -> tuple[Offer, ...]:
    """What each route of a solver offers for a case."""
    try:
        module = solver(name)
    except ImportError as problem:
        return (Offer("", (), "refused", f"{name} is not installed here ({problem})"),)
    return tuple(_offer(module, load(key), route) for route in module.routes)


def _offer(module: ModuleType, case: Case, route: str) -> Offer:
    try:
        refusal = module.refuses(case, route)
        return Offer(route, (), "refused", refusal) if refusal else Offer(route, tuple(module.ladder(case, route)))
    except Exception as problem:
        return Offer(route, (), "crashed", f"its ladder fails: {_sentence(problem)}")


@lru_cache(maxsize=2)
def _true_motion(key: CaseKey, method: str) -> Trajectory:
    return reference.simulate(load(key), rtol=TRUTH_RTOL, method=method)


def find_truth(key: CaseKey) -> Truth:
    """The truth of a case: the reference's first method that gives one; the other runs bear witness to its times."""
    case = load(key)
    notes, motions = [], []
    for method in reference.METHODS:
        for rtol in (TRUTH_RTOL, TRUTH_LOOSER):
            try:
                motion = reference.simulate(case, rtol=rtol, method=method)
            except Exception as problem:
                notes.append(f"{method} at rtol={rtol:g} fails: {_sentence(problem)}")
                continue
            motions.append((method, rtol, motion))
    exact = next(((m, motion) for m, rtol, motion in motions if rtol == TRUTH_RTOL and _sound(motion)), None)
    if exact is None:
        return Truth(failure="; ".join(notes) or "the reference's numbers are not finite")
    method, motion = exact
    bars = [_ULPS * float(np.spacing(event.time)) for event in motion.transitions]
    for other, rtol, witness in motions:
        rows = metrics.match(motion.transitions, witness.transitions)
        agrees = all(row.verdict == "matched" and abs(row.error) <= _AGREEMENT for row in rows)
        if agrees:
            bars = [max(bar, abs(row.error)) for bar, row in zip(bars, rows, strict=True)]
        elif rtol == TRUTH_RTOL:
            return Truth(failure=f"the reference's methods {method} and {other} contradict each other")
        else:
            notes.append(f"{other} at rtol={rtol:g} finds other transitions")
    return Truth(
        method=method,
        transitions=motion.transitions,
        error_bars=tuple(bars),
        first_mode=motion.first_mode,
        status=motion.status,
        reason=motion.reason,
        samples=_shown(case, _evenly(motion)),
        notes=tuple(notes),
    )


def _evenly(motion: Trajectory) -> Trajectory:
    """A motion sampled at even distances and at its transitions."""
    events = [event.time for event in motion.transitions]
    times = np.union1d(np.linspace(motion.t[0], motion.t[-1], _SHOWN_SAMPLES - len(events)), events)
    return Trajectory(t=times, **motion(times)._asdict(), first_mode=motion.first_mode)


def perform(key: CaseKey, name: str, route: str, setting: Setting, rung: int, truth: Truth) -> Run:
    """Run one setting of one route and judge it. Only `run` of the solver is on the clock."""
    case = load(key)
    row = Run(case.label, name, route, str(setting), rung, outcome="")
    try:
        trajectory = timed(solver(name), case, route, setting)
    except NotSupported as refusal:
        return replace(row, outcome="refused", reason=str(refusal))
    except EngineFailure as failure:
        return replace(row, outcome="crashed", reason=str(failure))
    except Exception as problem:
        return replace(row, outcome="crashed", reason=_sentence(problem))
    row = replace(row, status=trajectory.status, cost=trajectory.cost)
    if not _sound(trajectory):
        return replace(row, outcome="crashed", reason="it gave numbers that are not finite, or times that do not grow")
    return judge(row, case, trajectory, _true_motion(key, truth.method), truth)


def timed(module: ModuleType, case: Case, route: str, setting: Setting) -> Trajectory:
    """Build, run and read, with the clock around `run` alone; build and read count as set-up."""
    began = time.perf_counter()
    model = module.build(case, route, setting)
    setup = time.perf_counter() - began
    cpu, wall = time.process_time(), time.perf_counter()
    module.run(model)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    began = time.perf_counter()
    trajectory = module.read(model)
    setup += time.perf_counter() - began
    steps = trajectory.cost.steps or len(trajectory.t) - 1
    return replace(trajectory, cost=replace(trajectory.cost, cpu_s=cpu, wall_s=wall, setup_s=setup, steps=steps))


def judge(row: Run, case: Case, trajectory: Trajectory, motion: Trajectory, truth: Truth) -> Run:
    """Compare a sound trajectory with the truth: ledger, distances, right or wrong."""
    reading = read(case, trajectory)
    ledger = metrics.match(truth.transitions, reading.transitions)
    off = metrics.differences(trajectory, motion)
    with np.errstate(invalid="ignore"):
        off["lambda"] = off.pop("normal_force") / case.track.speed(np.interp(off["t"], trajectory.t, trajectory.xi1))
    wrong = _faults(reading, ledger, trajectory, truth)
    return replace(
        row,
        outcome="wrong" if wrong else "right",
        reason="; ".join(wrong),
        first_mode=str(reading.first_mode),
        ledger=ledger,
        spreads=reading.spreads,
        distance=metrics.distance(off),
        samples=_shown(case, trajectory),
        off={name: _thin(values) for name, values in off.items()},
    )


def read(case: Case, trajectory: Trajectory) -> metrics.Reading:
    """A solver's transitions: its own where it locates them itself (it then names its first mode), else as sampled."""
    if trajectory.first_mode is not None:
        own = tuple(trajectory.transitions)
        return metrics.Reading(trajectory.first_mode, own, (float("nan"),) * len(own))
    friction = case.effect(CoulombFriction)
    return metrics.read(trajectory, friction.stick if friction else 0.0)


def _faults(reading: metrics.Reading, ledger, trajectory: Trajectory, truth: Truth) -> list[str]:
    """Why a run is wrong, in phrases; an empty list means right."""
    faults = []
    if reading.first_mode != truth.first_mode:
        faults.append(f"begins with {reading.first_mode}, not {truth.first_mode}")
    for verdict in ("missed", "spurious"):
        kinds = [f"{row.before} to {row.after}" for row in ledger if row.verdict == verdict]
        if kinds:
            faults.append(f"{len(kinds)} {verdict} ({', '.join(kinds[:3])}{', …' if len(kinds) > 3 else ''})")
    end, step = float(truth.samples["t"][-1]), float(np.max(np.diff(trajectory.t)))
    if truth.status != "lift_off" and trajectory.t[-1] < end - _LAST_STEPS * step:
        faults.append(f"ends at {trajectory.t[-1]:.6g} s, the truth at {end:.6g} s")
    return faults


def _sound(trajectory: Trajectory) -> bool:
    names = ("t", "x", "y", "theta", "vx", "vy", "omega", "slip")
    finite = all(np.all(np.isfinite(getattr(trajectory, name))) for name in names)
    return finite and len(trajectory.t) > 1 and bool(np.all(np.diff(trajectory.t) >= 0))


def _shown(case: Case, trajectory: Trajectory) -> dict[str, np.ndarray]:
    """What the figures draw: the paper's v, ξ₁, ξ₂, θ and λ = N/‖R_p‖, and the centre; thinned."""
    names = ("t", "x", "y", "theta", "slip", "xi1", "xi2", "normal_force")
    shown = {name: _thin(getattr(trajectory, name)) for name in names}
    with np.errstate(invalid="ignore"):
        shown["lambda"] = shown["normal_force"] / case.track.speed(shown["xi1"])
    return shown


def _thin(values: np.ndarray) -> np.ndarray:
    if len(values) <= _SHOWN_SAMPLES:
        return values
    return values[np.linspace(0, len(values) - 1, _SHOWN_SAMPLES).round().astype(int)]


def _sentence(problem: BaseException) -> str:
    text = " ".join(str(problem).split())
    return f"{type(problem).__name__}: {text}" if text else type(problem).__name__


# --- the whole --------------------------------------------------------------------------------------------------------


def run(
    asked: tuple[Case, ...],
    solvers: tuple[str, ...],
    files: tuple[str, ...] = (),
    thin: Callable[[tuple[Setting, ...]], tuple[Setting, ...]] = tuple,
    jobs: int = 2,
    limit: float = LIMIT_SECONDS,
    tell: Callable[[str, int, Iterator], Iterator] = lambda step, total, answers: answers,
) -> Experiment:
    """Run every setting (of those `thin` leaves of a ladder) of every route of every solver on every case.

    `tell(step, total, answers)` may show progress: it hands on what it iterates over.
    """
    began = time.perf_counter()
    keys = {case.label: CaseKey.of(case, files) for case in asked}

    def step(name: str, function: Callable, arguments: list[tuple]) -> list[workers.Answer]:
        answers: list[workers.Answer] = [workers.Answer("died")] * len(arguments)
        for index, answer in tell(name, len(arguments), workers.run(function, arguments, jobs, limit)):
            answers[index] = answer
        return answers

    found = step("truth", find_truth, [(key,) for key in keys.values()])
    truths = {label: _truth(answer) for label, answer in zip(keys, found, strict=True)}
    pairs = [(label, name) for label in keys for name in solvers]
    offers = step("survey", survey, [(keys[label], name) for label, name in pairs])

    runs: list[Run | None] = []
    todo: list[tuple[int, tuple]] = []
    for (label, name), answer in zip(pairs, offers, strict=True):
        for offer in _offers(answer):
            excuse = _excuse(offer, truths[label])
            for rung, setting in enumerate(() if excuse else thin(offer.settings), start=1):
                todo.append((len(runs), (keys[label], name, offer.route, setting, rung, truths[label])))
                runs.append(None)
            if excuse:
                runs.append(Run(label, name, offer.route, "", 0, *excuse))
    for (place, task), answer in zip(todo, step("runs", perform, [task for _, task in todo]), strict=True):
        runs[place] = _run(task, answer)
    return Experiment(asked, truths, tuple(run for run in runs if run), time.perf_counter() - began)


def _truth(answer: workers.Answer) -> Truth:
    return answer.value if answer.outcome == "done" else Truth(failure=answer.reason)


def _offers(answer: workers.Answer) -> tuple[Offer, ...]:
    if answer.outcome == "done":
        return answer.value
    return (Offer("", (), _outcome(answer), f"asking for its settings: {answer.reason}"),)


def _excuse(offer: Offer, truth: Truth) -> tuple[str, str] | None:
    """Outcome and reason where there is nothing to run."""
    if offer.outcome:
        return offer.outcome, offer.reason
    if truth.failure:
        return "refused", f"there is no truth to judge it by: {truth.failure}"
    return None if offer.settings else ("refused", "it offers no setting for this case")


def _run(task: tuple, answer: workers.Answer) -> Run:
    if answer.outcome == "done":
        return answer.value
    key, name, route, setting, rung, _ = task
    reason = f"{answer.reason}; it last printed: {answer.output[-200:]}" if answer.output else answer.reason
    return Run(_label(key), name, route, str(setting), rung, _outcome(answer), reason)


def _label(key: CaseKey) -> str:
    return load(key).label


def _outcome(answer: workers.Answer) -> str:
    return "timed_out" if answer.outcome == "timed_out" else "crashed"
