"""Baselines: what motions that know nothing of friction's law score, so that nobody is praised for a saturated metric.

And, in the same worker, how far the reference's second method is from the truth's: an error bar for the quantities
that the certificate does not keep.
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
from ..running.calls import Calls
from ..running.records import TRUTH_RTOL
from . import quantities

# Even times at which motions are compared.
_SAMPLES = 1001


class Baseline(NamedTuple):
    """Rows of null motions, and by quantity the distance of the reference's second method from the truth's."""

    rows: tuple[dict[str, Any], ...]
    witnessed: dict[str, float]


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
    rows = [_row(case, truth, name, motion) for name, motion in NULL_MOTIONS.items()]
    return Baseline(tuple(rows), _witness(case, truth))


def _row(case: Case, truth: Trajectory, name: str, motion: Callable[[Case], Trajectory]) -> dict[str, Any]:
    try:
        other = motion(case)
    except CaseError as problem:
        return _score(case.label, name, {}, str(problem))
    # A null motion that ends early is compared while it lasts.
    end = min(float(truth.t[-1]), float(other.t[-1]))
    note = "" if end == truth.t[-1] else f"until {end:.4g} s, where it ends: {other.status}"
    found = distance(case, other, truth, end)
    errors = {q: quantities.from_distance(found, q) for q in quantities.UNITS if q not in quantities.TIMES}
    if motion is null_motions.rolling:
        errors |= _as_if_at_once(truth.transitions)
    return _score(case.label, name, errors, note)


def _as_if_at_once(transitions: tuple[Transition, ...]) -> dict[str, float]:
    """Errors in time of a motion that rolls from the start, and so puts the first transition at time zero."""
    if not transitions:
        return {}
    # The later ones it does not have: nobody who has them all scores worse.
    return {"first_transition_time": transitions[0].time} | (
        {"all_transitions": transitions[0].time} if len(transitions) == 1 else {}
    )


def distance(case: Case, motion: Trajectory, truth: Trajectory, end: float = inf) -> Distance:
    """How far two motions are apart at even times up to `end`, or to the end of the shorter one."""
    times = np.linspace(0.0, min(float(truth.t[-1]), float(motion.t[-1]), end), _SAMPLES)
    sampled = Trajectory(t=times, **motion(times)._asdict())
    return distances.distance(distances.differences(sampled, truth, case))


def _witness(case: Case, truth: Trajectory) -> dict[str, float]:
    # Without a second method the same at a looser tolerance has to do; the certificate has more witnesses.
    method, rtol = ("dop853", TRUTH_RTOL) if len(reference.METHODS) > 1 else (reference.METHODS[0], 10 * TRUTH_RTOL)
    found = distance(case, reference.simulate(case, rtol=rtol, method=method), truth)
    return {q: quantities.from_distance(found, q) for q in quantities.UNITS if q not in quantities.TIMES}


def _score(label: str, motion: str, errors: dict[str, float], note: str) -> dict[str, Any]:
    return {"case": label, "motion": motion, **{q: errors.get(q, nan) for q in quantities.UNITS}, "note": note}
