"""Baselines: errors of motions that ignore friction's law, to show which quantities depend on it.

The same worker also measures the distance of the reference's second method from the truth's: an error bar for the
quantities that the certificate does not contain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

import reference
from cases import Case, CaseError, Trajectory, Transition

from ..judging import distances, null_motions
from ..judging.distances import Distance
from ..judging.null_motions import NULL_MOTIONS
from ..judging.score import Scale, scale_of, score
from ..running.calls import Calls
from ..running.records import TRUTH_RTOL
from . import quantities

# Even times at which motions are compared.
_SAMPLES = 1001


class Baseline(NamedTuple):
    """Rows of null motions, and the distance of the reference's second method from the truth's by quantity."""

    rows: tuple[dict[str, Any], ...]
    witness_errors: dict[str, float]


def measure(cases: Sequence[Case], calls: Calls) -> dict[str, Baseline]:
    """The baseline of each case, by its label."""
    answers = calls.all("null scores", baseline, [(case,) for case in cases])
    return {
        case.label: a.value if a.outcome == "done" else Baseline((_score(case.label, "any", {}, a.failure[1]),), {})
        for case, a in zip(cases, answers, strict=True)
    }


def baseline(case: Case) -> Baseline:
    """Both for a case; the null motions' rows hold an error for each quantity of `quantities.UNITS`."""
    truth = reference.simulate(case, rtol=TRUTH_RTOL)
    scale = scale_of(case, truth, truth.transitions, null_motions.null_motions(case))
    rows = [_row(case, truth, scale, name, motion) for name, motion in NULL_MOTIONS.items()]
    return Baseline(tuple(rows), _witness(case, truth))


def _row(
    case: Case, truth: Trajectory, scale: Scale, name: str, motion: Callable[[Case], Trajectory]
) -> dict[str, Any]:
    try:
        other = motion(case)
    except CaseError as problem:
        return _score(case.label, name, {}, str(problem))
    # A null motion that ends early is compared while it lasts.
    end = min(float(truth.t[-1]), float(other.t[-1]))
    note = "" if end == truth.t[-1] else f"until {end:.4g} s, where it ends: {other.status}"
    result = distance(case, other, truth, end)
    errors = {q: quantities.from_distance(result, q) for q in quantities.DISTANCES}
    errors["off"] = score(case, other, truth, scale).off
    if motion is null_motions.rolling:
        errors |= _as_if_at_once(truth.transitions)
    return _score(case.label, name, errors, note)


def _as_if_at_once(transitions: tuple[Transition, ...]) -> dict[str, float]:
    """Errors in time of a motion that rolls from the start: its first transition is at time zero."""
    if not transitions:
        return {}
    # It does not have the later ones, so it has no error of all transitions if there are several.
    return {"first_transition_time": transitions[0].time} | (
        {"all_transitions": transitions[0].time} if len(transitions) == 1 else {}
    )


def distance(case: Case, motion: Trajectory, truth: Trajectory, end: float = inf) -> Distance:
    """The distance of two motions at even times up to `end`, or to the end of the shorter one."""
    times = np.linspace(0.0, min(float(truth.t[-1]), float(motion.t[-1]), end), _SAMPLES)
    samples = Trajectory(t=times, **motion(times)._asdict())
    return distances.distance(distances.differences(samples, truth, case))


def _witness(case: Case, truth: Trajectory) -> dict[str, float]:
    # Without a second method, the same method at a looser tolerance is used; the certificate has more witnesses.
    method, rtol = ("dop853", TRUTH_RTOL) if len(reference.METHODS) > 1 else (reference.METHODS[0], 10 * TRUTH_RTOL)
    result = distance(case, reference.simulate(case, rtol=rtol, method=method), truth)
    return {q: quantities.from_distance(result, q) for q in quantities.DISTANCES}


def _score(label: str, motion: str, errors: dict[str, float], note: str) -> dict[str, Any]:
    return {"case": label, "motion": motion, **{q: errors.get(q, nan) for q in quantities.UNITS}, "note": note}
