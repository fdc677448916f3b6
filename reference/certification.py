"""Truth with error bars: what several independent ways of solving a case agree on.

    python -m reference            rebuilds truth.json for the whole catalogue

Witnesses: the Taylor method at two tolerances and in quadruple precision within each phase (where heyoka is
installed), DOP853 at its tightest, and the second formulation, which shares no code with the others. The central value
is the most precise witness's; the error bar is the largest distance of any witness from it, and at least a few
units in the last place.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

import cases
from cases import Case, CaseError, Mode, NotSupported, Transition

from . import contact_frame, solve, taylor

TRUTH = Path(__file__).with_name("truth.json")
QUANTITIES = ("x", "y", "theta", "slip", "omega")
SAMPLES = 11

# Witnesses whose transition times lie further apart than this (s) contradict each other: a million times what they
# differ by on ordinary scenes, and no truth for engines that come within 1e-8 s.
WIDEST = 1e-7

# Central values are rounded to double precision at the start and at each transition; this many units in the last
# place cover that.
ULPS = 4


# Steps to a motion of the second formulation, at least: with 300 its errors are 1e-14, with its usual 60 up to 1e-11.
LOOKS = 300


class NotCertified(CaseError):
    """The witnesses do not agree on what happens: the case is ill-conditioned or a solver is wrong."""


class Bar(NamedTuple):
    """A value and the half-width of its error bar."""

    value: float
    bar: float


@dataclass(frozen=True)
class Certificate:
    """The certified motion of a case: transitions with bars on their times, sample states with bars.

    `samples` maps a quantity to bars at `times`; `witnesses` names the ways of solving that agree.
    """

    case: str
    status: str
    end: Bar
    transitions: tuple[tuple[Mode, Mode, Bar, Bar], ...]  # before, after, time (s), xi1 (rad)
    times: tuple[float, ...]
    samples: dict[str, tuple[Bar, ...]]
    witnesses: tuple[str, ...]


class Witness(NamedTuple):
    """One way of solving: its transitions, status, end of the motion, and states at any times, by quantity."""

    name: str
    transitions: Sequence[Transition]
    status: str
    end: float
    states: Callable[[np.ndarray], dict[str, np.ndarray]]


def certify(case: Case) -> Certificate:
    """The case's motion with error bars; raises NotCertified if the witnesses' sequences of events differ."""
    witnesses = _witnesses(case)
    centre = witnesses[0]
    for other in witnesses[1:]:
        if _events(other) != _events(centre):
            raise NotCertified(
                f"{case.label}: {other.name} finds {_told(other)}, {centre.name} finds {_told(centre)}; "
                "change a parameter a little, this scene is ill-conditioned"
            )
    widest = max(
        (_bar([t.time for t in same]).bar for same in zip(*(w.transitions for w in witnesses), strict=True)), default=0
    )
    if widest > WIDEST:
        raise NotCertified(
            f"{case.label}: its witnesses' times of a transition differ by {widest:.1e} s; "
            "change a parameter a little, this scene is ill-conditioned"
        )
    # The samples stop short of the earliest end, so that every witness has a state there.
    last = min(witness.end for witness in witnesses)
    times = np.linspace(0.0, last, SAMPLES)
    states = [witness.states(times) for witness in witnesses]
    return Certificate(
        case=case.label,
        status=centre.status,
        end=_bar([witness.end for witness in witnesses]),
        transitions=tuple(
            (t[0].before, t[0].after, _bar([w.time for w in t]), _bar([w.xi1 for w in t], case.track.period))
            for t in zip(*(witness.transitions for witness in witnesses), strict=True)
        ),
        times=tuple(times.tolist()),
        samples={q: tuple(_bar([state[q][i] for state in states]) for i in range(len(times))) for q in QUANTITIES},
        witnesses=tuple(witness.name for witness in witnesses),
    )


def kept_or_new(case: Case, kept: bool = True) -> Certificate:
    """The kept certificate of a catalogue's case, else a new one (always, if not `kept`)."""
    return (read().get(case.label) if kept else None) or certify(case)


def _bar(values: Sequence[float], period: float | None = None) -> Bar:
    """The first value and the others' largest distance from it; of a parameter with a period, whole turns aside.

    Where no witness has a value (slip in flight) that is certain; where only some have, nothing is.
    """
    centre = float(values[0])
    if np.all(np.isnan(values)):
        return Bar(centre, 0.0)
    if np.any(np.isnan(values)):
        return Bar(centre, np.inf)
    apart = [float(value) - centre for value in values]
    if period:
        # After a flight each witness says in its own way how many turns of a closed track it has gone round.
        apart = [distance - period * round(distance / period) for distance in apart]
    return Bar(centre, max(*map(abs, apart), ULPS * float(np.spacing(abs(centre)))))


def _events(witness: Witness):
    return witness.status, [(t.before, t.after) for t in witness.transitions]


def _told(witness: Witness) -> str:
    return f"{len(witness.transitions)} transitions ({witness.status})"


def _witnesses(case: Case) -> list[Witness]:
    runs = []
    if taylor.AVAILABLE:
        runs += [("taylor, quadruple precision", "taylor_quadruple", 1e-14), ("taylor 1e-14", "taylor", 1e-14)]
        runs += [("taylor 1e-12", "taylor", 1e-12)]
    runs.append(("dop853 1e-13", "dop853", 1e-13))
    witnesses = [_by_first(case, *run) for run in runs]
    try:
        witnesses.append(_by_second(case))
    except NotSupported:
        pass  # a scene the second formulation has no equations for: the certificate names its witnesses
    except FloatingPointError as problem:
        raise NotCertified(f"{case.label}: {problem}") from problem
    return witnesses


def _by_first(case: Case, name: str, method: str, rtol: float) -> Witness:
    motion = solve.simulate(case, rtol=rtol, method=method)

    def states(times):
        state = motion(np.minimum(times, motion.t[-1]))
        return {q: np.asarray(getattr(state, q)) for q in QUANTITIES}

    return Witness(name, motion.transitions, motion.status, float(motion.t[-1]), states)


def _by_second(case: Case) -> Witness:
    answer = contact_frame.solve(case, rtol=1e-13, looks=LOOKS)

    def states(times):
        motions = contact_frame.solve(case, rtol=1e-13, times=times, looks=LOOKS).motions
        return {q: motions[contact_frame.MOTION.index(q)] for q in QUANTITIES}

    return Witness("contact frame 1e-13", answer.transitions, answer.status, answer.end, states)


def write(certificates: Sequence[Certificate], path: Path = TRUTH) -> None:
    """Keep certificates as data."""
    rows = [certificate.__dict__ for certificate in certificates]
    path.write_text(json.dumps(rows, indent=1) + "\n")


@lru_cache(maxsize=1)
def read(path: Path = TRUTH) -> dict[str, Certificate]:
    """The kept certificates by the case's label; an empty dictionary if none are kept."""
    if not path.exists():
        return {}
    kept = {}
    for row in json.loads(path.read_text()):
        row["end"] = Bar(*row["end"])
        row["transitions"] = tuple((Mode(b), Mode(a), Bar(*t), Bar(*x)) for b, a, t, x in row["transitions"])
        row["times"] = tuple(row["times"])
        row["samples"] = {q: tuple(Bar(*bar) for bar in bars) for q, bars in row["samples"].items()}
        row["witnesses"] = tuple(row["witnesses"])
        kept[row["case"]] = Certificate(**row)
    return kept


def main() -> None:
    """Rebuild the kept truth of every case of the catalogue."""
    certificates = []
    for name in cases.names():
        for case in cases.select(name):
            try:
                certificates.append(certify(case))
            except NotCertified as problem:
                if not cases.entry(name).hard:
                    raise
                print(f"not kept: {problem}", flush=True)  # some hard scenes hang on the last bit
                continue
            widest = max((t[2].bar for t in certificates[-1].transitions), default=0.0)
            print(
                f"{case.label}: {len(certificates[-1].transitions)} transitions, widest bar {widest:.1e} s", flush=True
            )
    write(certificates)
    print(f"written: {TRUTH.name}, {len(certificates)} cases")
