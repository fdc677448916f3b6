"""What accuracy costs in time: errors of the experiment beside timings of the clock, as rows; who is timed.

Errors are absolute, in s for times and m for the centre. Only right runs count, and only times taken alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from math import inf, isfinite, nan
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import reference
from cases import Case, CaseError, CoulombFriction

from . import clock, tables, workers
from .clock import Contestant, Timing
from .fingerprint import Key as Kept
from .fingerprint import Keys
from .records import REFERENCE, CaseKey, Experiment, Run, Truth
from .store import Store
from .trial import load

if TYPE_CHECKING:
    import pandas as pd

# The unit of each quantity's error.
QUANTITIES = {"first_transition_time": "s", "all_transitions": "s", "final_centre": "m", "centre_rms": "m"}
ACCURACIES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
NEVER, NOT_TIMED, NOT_KNOWN = "never", "not timed", "not known"
# No error is told below ten times the truth's bar: there one digit of it is the truth's own.
ABOVE_BAR = 10.0
# Wall seconds for all timings of a default report, and how many cases share them: a full ladder of every route takes
# some ten seconds a case.
BUDGET, MOST_CASES = 60.0, 6
# A full report times every case, each for about so long.
FULL_BUDGET_A_CASE = 60.0
# Beyond its budget a case may take as long as one run more and its compilations.
_PATIENCE = 60.0

Key = tuple[str, str, str, str]  # case, solver, route, setting
Tell = Callable[[str, int, Iterator], Iterator]


class Measured(NamedTuple):
    """What the timed pass found: the cases timed, timings, null motions' rows, and why a case's timing failed."""

    cases: tuple[str, ...] = ()
    timings: dict[Key, Timing] = {}
    nulls: tuple[dict[str, Any], ...] = ()
    failures: dict[str, str] = {}


# --- the timed pass ---------------------------------------------------------------------------------------------------


def chosen(experiment: Experiment, full: bool) -> list[Case]:
    """The cases to time: all, or of each family the variant with most transitions, those that most routes can run."""
    able = [case for case in experiment.cases if not experiment.truths[case.label].failure]
    if full:
        return able
    events = {case.label: len(experiment.truths[case.label].transitions) for case in able}
    families: dict[str, list[Case]] = {}
    for case in able:
        families.setdefault(case.name, []).append(case)
    one_each = [max(family, key=lambda case: events[case.label]) for family in families.values()]
    routes = {case.label: len({r[:2] for r in _right_routes(experiment, case.label)}) for case in one_each}
    return sorted(one_each, key=lambda case: (-routes[case.label], -events[case.label]))[:MOST_CASES]


def _right_routes(experiment: Experiment, label: str) -> list[tuple[str, str]]:
    return [(run.solver, run.route) for run in experiment.runs if run.case == label and run.outcome == "right"]


def measure(
    experiment: Experiment, files: tuple[str, ...], full: bool, tell: Tell, store: Store | None = None
) -> Measured:
    """Time the chosen cases one after the other, each in one process with nothing beside it, or take what is kept."""
    store = store or Store(None)
    cases = chosen(experiment, full)
    timings: dict[Key, Timing] = {}
    nulls: list[dict[str, Any]] = []
    failures: dict[str, str] = {}
    deadline = time.perf_counter() + BUDGET

    def one_by_one() -> Iterator[str]:
        for place, case in enumerate(cases):
            left = max(deadline - time.perf_counter(), 1.0) / (len(cases) - place)
            budget = FULL_BUDGET_A_CASE if full else left
            label, key = case.label, CaseKey.of(case, files)
            who = contestants(experiment, label)
            share = FULL_BUDGET_A_CASE if full else BUDGET / len(cases)
            kept_under = Keys(case, experiment.versions).timing([one[:3] for one in who], share)
            answer = _timed(store, kept_under, (key, who, budget), budget + _PATIENCE)
            if answer.outcome == "done":
                timings.update({(label, *one): timing for one, timing in answer.value.items()})
            else:
                failures[label] = answer.reason
            yield label

    list(tell("timings", len(cases), one_by_one()))
    keys = [(CaseKey.of(case, files),) for case in cases]
    for index, answer in sorted(workers.run(null_scores, keys, jobs=1), key=lambda pair: pair[0]):
        told = answer.value if answer.outcome == "done" else [_null(cases[index].label, "any", nan, nan, answer.reason)]
        nulls.extend(told)
    return Measured(tuple(case.label for case in cases), timings, tuple(nulls), failures)


def _timed(store: Store, kept_under: Kept | None, call: tuple, limit: float) -> workers.Answer:
    """A case's timings, together as they were taken in turns: those kept, or new ones, kept if none is disturbed."""
    kept = store.get("timing", kept_under, dict[tuple[str, str, str], Timing])
    if kept is not None:
        return workers.Answer("done", value=kept)
    (_, answer), *_ = workers.run(clock.time_case, [call], jobs=1, limit=limit)
    if answer.outcome == "done" and not any(timing.disturbed for timing in answer.value.values()):
        store.put("timing", kept_under, answer.value)
    return answer


def contestants(experiment: Experiment, label: str) -> list[Contestant]:
    """Every setting that gave a right motion of the case."""
    runs = [run for run in experiment.runs if run.case == label and run.outcome == "right"]
    return [Contestant(r.solver, r.route, r.setting, r.cost.wall_s + r.cost.setup_s) for r in runs]


# --- rows -------------------------------------------------------------------------------------------------------------


def error(run: Run, quantity: str) -> float:
    """The run's error, at least zero; NaN where there is none."""
    if quantity == "first_transition_time":
        return abs(tables.first_error(run))
    if quantity == "all_transitions":
        return max((abs(row.error) for row in run.ledger), default=nan)
    if quantity == "final_centre":
        return float(run.off["centre"][-1]) if len(run.off.get("centre", ())) else nan
    return run.distance.centre_rms


def floor(truth: Truth, quantity: str) -> float:
    """Ten times the truth's error bar: below it no error is told. Infinite where the bar is not known."""
    if quantity == "first_transition_time":
        bar = truth.error_bars[0] if truth.error_bars else nan
    elif quantity == "all_transitions":
        bar = max(truth.error_bars, default=nan)
    else:
        bar = truth.centre_bar
    return ABOVE_BAR * bar if isfinite(bar) else inf


def quantities(truth: Truth) -> list[str]:
    """What can be asked of a case: nothing about transitions where there are none."""
    return [q for q in QUANTITIES if isfinite(floor(truth, q))]


def work_precision_rows(experiment: Experiment, measured: Measured) -> list[dict[str, Any]]:
    """One row per right run of a timed case and quantity. `cpu_s` is NaN where the budget left no time for it.

    `below_floor`: the error is below ten times the truth's bar, so that its size is not known.
    """
    rows = []
    for run in experiment.runs:
        if run.case not in measured.cases or run.outcome != "right":
            continue
        timing = measured.timings.get((run.case, run.solver, run.route, run.setting))
        truth = experiment.truths[run.case]
        for quantity in quantities(truth):
            size = error(run, quantity)
            rows.append(
                {
                    "case": run.case,
                    "solver": run.solver,
                    "route": run.route,
                    "setting": run.setting,
                    "cpu_s": timing.cpu_s if timing else nan,
                    "cpu_spread_s": timing.spread_s if timing else nan,
                    "wall_s": timing.wall_s if timing else nan,
                    "setup_s": timing.setup_s if timing else nan,
                    "repeats": timing.repeats if timing else 0,
                    "steps": run.cost.steps,
                    "error": size,
                    "quantity": quantity,
                    "floor_error": floor(truth, quantity),
                    "below_floor": size <= floor(truth, quantity),
                    "disturbed": timing.disturbed if timing else False,
                }
            )
    return rows


def time_to_accuracy_rows(points: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The cheapest setting of each route for each accuracy, and its ratio to the fastest route's.

    `cpu_s` is a number, or: never (no setting is as accurate), not timed (one is, and the budget did not reach it),
    not known (the truth itself is not that sure). The ratio's interval is that of both interquartile ranges.
    """
    rows = []
    for (case, quantity), of_quantity in _groups(points, "case", "quantity").items():
        for accuracy in ACCURACIES:
            best = {who: _cheapest(group, accuracy) for who, group in _groups(of_quantity, "solver", "route").items()}
            timed = [p for p in best.values() if not isinstance(p, str)]
            fastest = min(timed, key=lambda p: p["cpu_s"], default=None)
            for (solver, route), point in best.items():
                row = {"case": case, "quantity": quantity, "accuracy": accuracy, "solver": solver, "route": route}
                if isinstance(point, str) or fastest is None:
                    told = {"cpu_s": point, "setting": "", "ratio": nan, "ratio_low": nan, "ratio_high": nan}
                else:
                    low, middle, high = ratio(point, fastest)
                    told = {"cpu_s": point["cpu_s"], "setting": point["setting"], "ratio": middle}
                    told |= {"ratio_low": low, "ratio_high": high}
                rows.append({**row, **told, "disturbed": not isinstance(point, str) and point["disturbed"]})
    return rows


def ratio(one: dict[str, Any], other: dict[str, Any]) -> tuple[float, float, float]:
    """CPU time of one row in units of the other's: from quartiles, of medians, from quartiles."""
    if one is other:
        return 1.0, 1.0, 1.0
    (low, high), (least, most) = (
        (row["cpu_s"] - row["cpu_spread_s"] / 2, row["cpu_s"] + row["cpu_spread_s"] / 2) for row in (one, other)
    )
    return low / most, one["cpu_s"] / other["cpu_s"], high / least if least > 0 else nan


def _cheapest(group: Sequence[dict[str, Any]], accuracy: float) -> dict[str, Any] | str:
    """The cheapest timed row that is accurate enough, or the word why there is none."""
    if group[0]["floor_error"] > accuracy:
        return NOT_KNOWN
    able = [row for row in group if max(row["error"], row["floor_error"]) <= accuracy]
    timed = [row for row in able if isfinite(row["cpu_s"])]
    if timed:
        return min(timed, key=lambda row: row["cpu_s"])
    return NOT_TIMED if able else NEVER


def _groups(rows: Iterable[dict[str, Any]], *columns: str) -> dict[tuple, list[dict[str, Any]]]:
    groups: dict[tuple, list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[c] for c in columns), []).append(row)
    return groups


# --- null scores ------------------------------------------------------------------------------------------------------


def null_scores(key: CaseKey) -> list[dict[str, Any]]:
    """What motions that know nothing of friction's law would score: centre errors, m, over the true motion's time."""
    case = load(key)
    truth = reference.simulate(case)
    rows = []
    for name, motion in (("never moves", None), ("no friction", frictionless), ("rolls from the start", rolling)):
        try:
            other = reference.simulate(motion(case)) if motion else None
        except CaseError as problem:
            rows.append(_null(case.label, name, nan, nan, str(problem)))
            continue
        # A null motion that ends early is compared while it lasts.
        times = np.linspace(0.0, min(truth.t[-1], other.t[-1] if other else inf), 1001)
        state, exact = (other or truth)(times if other else np.zeros_like(times)), truth(times)
        off = np.hypot(np.asarray(state.x) - exact.x, np.asarray(state.y) - exact.y)
        note = "" if times[-1] == truth.t[-1] else f"until {times[-1]:.4g} s, where it ends: {other and other.status}"
        rows.append(_null(case.label, name, float(off[-1]), float(np.sqrt(np.mean(off**2))), note))
    return rows


def frictionless(case: Case) -> Case:
    """The case without friction; raises CaseError if it has none to leave out."""
    if case.effect(CoulombFriction) is None:
        raise CaseError("the case has no friction to leave out")
    return replace(case, effects=tuple(e for e in case.effects if not isinstance(e, CoulombFriction)))


def rolling(case: Case) -> Case:
    """The case with friction that never gives way, its centre as fast as at the start; a disc only (else CaseError)."""
    if case.plate.radius is None or case.effect(CoulombFriction) is None:
        raise CaseError("only a disc with friction has a rolling twin here")
    # Far beyond every cone a disc's rolling friction asks for, where the normal force stays positive.
    strong = tuple(CoulombFriction(1e3) if isinstance(e, CoulombFriction) else e for e in case.effects)
    omega = case.start.omega - case.start.slip / case.plate.radius
    return replace(case, effects=strong, start=replace(case.start, slip=0.0, omega=omega))


def _null(label: str, motion: str, final: float, rms: float, note: str) -> dict[str, Any]:
    return {"case": label, "motion": motion, "final_centre_error": final, "centre_rms": rms, "note": note}


# --- in words ---------------------------------------------------------------------------------------------------------


class Verdict(NamedTuple):
    """At the finest level of a case that any engine reaches: that engine's CPU time over the reference's method's."""

    case: str
    quantity: str
    accuracy: float
    engine: str
    ratios: dict[str, float]


def verdicts(rows: Sequence[dict[str, Any]]) -> list[Verdict]:
    """One for each case where both an engine and the reference were timed: by the first transition, or the centre."""
    found = []
    for (case,), of_case in _groups(rows, "case").items():
        asked = {row["quantity"] for row in of_case}
        quantity = next(q for q in ("first_transition_time", "final_centre") if q in asked)
        timed = [r for r in of_case if r["quantity"] == quantity and not isinstance(r["cpu_s"], str)]
        engines = [r for r in timed if r["solver"] != REFERENCE]
        if not engines:
            continue
        finest = min(r["accuracy"] for r in engines)
        best = min((r for r in engines if r["accuracy"] == finest), key=lambda r: r["cpu_s"])
        own = {r["route"]: r["cpu_s"] for r in timed if r["solver"] == REFERENCE and r["accuracy"] == finest}
        if own:
            ratios = {route: best["cpu_s"] / cpu for route, cpu in own.items()}
            found.append(Verdict(case, quantity, finest, f"{best['solver']} {best['route']}", ratios))
    return found


def headline(rows: Sequence[dict[str, Any]]) -> str:
    """The section's first sentences: by what factor the reference is cheaper, and where it is not."""
    found = verdicts(rows)
    if not found:
        return "No case was timed with both an engine and the reference."
    parts = []
    for method in dict.fromkeys(method for verdict in found for method in verdict.ratios):
        ratios = [v.ratios[method] for v in found if method in v.ratios]
        parts.append(f"{method} {median(ratios):.2g} times (from {min(ratios):.2g} to {max(ratios):.2g})")
    told = (
        "At the finest accuracy that any engine reaches, the engine that gets there first takes, in units of the "
        f"reference's CPU time, in the median over {len(found)} case{'s' * (len(found) != 1)}: {'; '.join(parts)}."
    )
    dearer = [
        f"{v.case} at {v.accuracy:g} {QUANTITIES[v.quantity]} "
        f"({v.engine} takes {v.ratios[method]:.2g} of {method}'s time)"
        for v in found
        for method in v.ratios
        if v.ratios[method] < 1.0
    ]
    if dearer:
        told += f" The reference is not the cheaper one on: {'; '.join(dearer)}."
    timed = [row for row in rows if not isinstance(row["cpu_s"], str)]
    if any(row["disturbed"] for row in timed):
        part = sum(row["disturbed"] for row in timed) / len(timed)
        told += f" The machine was disturbed during {part:.0%} of these timings: make them again on a quiet one."
    return told


def frames(experiment: Experiment, measured: Measured) -> dict[str, pd.DataFrame]:
    """The tables of this section by name; none if nothing was timed."""
    import pandas as pd

    if not measured.cases:
        return {}
    points = work_precision_rows(experiment, measured)
    return {
        "work_precision": pd.DataFrame(points),
        "time_to_accuracy": pd.DataFrame(time_to_accuracy_rows(points)),
        "null_scores": pd.DataFrame(measured.nulls),
    }
