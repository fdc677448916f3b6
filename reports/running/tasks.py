"""What happens in a worker: ask a solver what it offers, find a case's truth, run one setting and judge it.

Owns the clock. Whatever a solver does short of ending the process becomes a record.
"""

from __future__ import annotations

import time
from dataclasses import replace
from functools import lru_cache
from types import ModuleType

import numpy as np

import adapters
import cases
import reference
from adapters import EngineFailure, Setting
from cases import Case, NotSupported, Trajectory
from reference.certification import Certificate, NotCertified, kept_or_new

from ..judging import distances
from ..judging import slip_phases as metrics
from ..judging import transitions as reading
from .records import REFERENCE, TRUTH_RTOL, CaseKey, Offer, Run, Truth

# What a figure can show; samples beyond are left out at even distances.
_SHOWN_SAMPLES = 1500
# A solver that stops no more than this many of its own steps before the end of the truth has ended with it.
_LAST_STEPS = 2.5


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
    """The certified truth of a case: kept with the suite for its catalogue, made anew for a case from a file."""
    case = load(key)
    try:
        certificate = kept_or_new(case, kept=not key.files)
    except NotCertified as problem:
        return Truth(failure=str(problem))
    method = reference.METHODS[0]
    motion = _true_motion(key, method)
    certified = certificate.transitions
    if [(event.before, event.after) for event in motion.transitions] != [row[:2] for row in certified]:
        return Truth(failure="the reference's motion is not the certified one; rebuild the truth: python -m reference")
    return Truth(
        method=method,
        transitions=tuple(
            replace(event, time=row[2].value) for event, row in zip(motion.transitions, certified, strict=True)
        ),
        error_bars=tuple(row[2].bar for row in certified),
        first_mode=motion.first_mode,
        status=motion.status,
        reason=motion.reason,
        samples=_shown(case, _evenly(motion)),
        witnesses=certificate.witnesses,
        centre_bar=_centre_bar(certificate, motion),
    )


def _centre_bar(certificate: Certificate, motion: Trajectory) -> float:
    """How sure the centre of the motion is, m: its largest distance from the certified samples, and their bars."""
    state = motion(np.minimum(certificate.times, motion.t[-1]))
    off = []
    for values, certified in ((state.x, certificate.samples["x"]), (state.y, certificate.samples["y"])):
        centres, bars = np.array(certified).T
        off.append(np.abs(values - centres) + bars)
    return float(np.hypot(*off).max())


def _evenly(motion: Trajectory) -> Trajectory:
    """A motion sampled at even distances and at its transitions."""
    events = [event.time for event in motion.transitions]
    times = np.union1d(np.linspace(motion.t[0], motion.t[-1], _SHOWN_SAMPLES - len(events)), events)
    return Trajectory(t=times, **motion(times)._asdict(), first_mode=motion.first_mode)


def perform(key: CaseKey, name: str, route: str, setting: Setting, rung: int, truth: Truth) -> Run:
    """Run one setting of one route and judge it. Only `run` of the solver is on the clock.

    Raises what is the machine's fault and may be mended (ImportError, MemoryError, OSError): it is no result to keep.
    """
    case = load(key)
    row = Run(case.label, name, route, str(setting), rung, outcome="")
    try:
        trajectory = timed(solver(name), case, route, setting)
    except NotSupported as refusal:
        return replace(row, outcome="refused", reason=str(refusal))
    except EngineFailure as failure:
        return replace(row, outcome="crashed", reason=str(failure))
    except (ImportError, MemoryError, OSError):
        raise
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
    told = read(case, trajectory)
    ledger = metrics.match(truth.transitions, told.transitions)
    off = distances.differences(trajectory, motion, case)
    wrong = _faults(told, ledger, trajectory, truth)
    return replace(
        row,
        outcome="wrong" if wrong else "right",
        reason="; ".join(wrong),
        first_mode=str(told.first_mode),
        ledger=ledger,
        spreads=told.spreads,
        distance=distances.distance(off),
        samples=_shown(case, trajectory),
        off={name: _thin(values) for name, values in off.items()},
    )


def read(case: Case, trajectory: Trajectory) -> metrics.Reading:
    """A solver's transitions: its own where it locates them itself (it then names its first mode), else as sampled."""
    if trajectory.first_mode is not None:
        own = tuple(trajectory.transitions)
        return metrics.Reading(trajectory.first_mode, own, (float("nan"),) * len(own))
    return reading.read(case, trajectory)


def _faults(told: metrics.Reading, ledger, trajectory: Trajectory, truth: Truth) -> list[str]:
    """Why a run is wrong, in phrases; an empty list means right."""
    faults = []
    if told.first_mode != truth.first_mode:
        faults.append(f"begins with {told.first_mode}, not {truth.first_mode}")
    for verdict in ("missed", "spurious"):
        kinds = [f"{row.before} to {row.after}" for row in ledger if row.verdict == verdict]
        if kinds:
            faults.append(f"{len(kinds)} {verdict} ({', '.join(kinds[:3])}{', …' if len(kinds) > 3 else ''})")
    end, step = float(truth.samples["t"][-1]), float(np.max(np.diff(trajectory.t)))
    if truth.status != "lift_off" and trajectory.t[-1] < end - _LAST_STEPS * step:
        faults.append(f"ends at {trajectory.t[-1]:.6g} s, the truth at {end:.6g} s")
    return faults


def _sound(trajectory: Trajectory) -> bool:
    names = ("t", "x", "y", "theta", "vx", "vy", "omega")
    finite = all(np.all(np.isfinite(getattr(trajectory, name))) for name in names)
    # In flight there is no slip, and then no place of contact either.
    finite = finite and bool(np.all(np.isfinite(trajectory.slip) | np.isnan(trajectory.xi1)))
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
