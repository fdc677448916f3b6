"""The cost of the reference, compared with heyoka on the paper's closed form, for longer motions, and at a cold start.

Warm contestants are timed in turns: ratios are reliable on a noisy machine, absolute times are not.
"""

from __future__ import annotations

import time
from math import isnan, nan
from typing import Any, NamedTuple

import cases
from adapters import Setting
from reports.running.calls import CallResult, Calls
from reports.running.names import REFERENCE
from reports.running.timing.clock import NO_TIMING, ClockEntry, Contestant, Timing, take_turns, timing
from reports.studies import Request

from . import growth, process_start
from .contestants import COEFFICIENTS, RTOL, contestants

# Wall-clock budget of the timings in seconds; a full study takes longer for more precise medians.
BUDGET, FULL_BUDGET = 20.0, 60.0
# Time in addition to the budget: derivations and compilations of all contestants (half a minute without other load).
_PATIENCE = 300.0
# Time limit of one size of a growing motion, s.
_LONGEST = 600.0


class CostLimit(NamedTuple):
    """A limit on cost: a contestant may take at most `limit` times the CPU time of the `baseline`."""

    contestant: str
    baseline: str
    limit: float


BARS = (
    *(CostLimit(f"taylor, first slip, mu={mu}", f"heyoka on (35), first slip, mu={mu}", 2.5) for mu in COEFFICIENTS),
    *(
        CostLimit(f"simulate by taylor, first slip, new mu={mu}", f"heyoka on (35), first slip, mu={mu}", 60.0)
        for mu in COEFFICIENTS
    ),
    CostLimit("simulate by taylor, disc in circle, 5 s", "taylor, disc in circle, 5 s", 2.0),
    CostLimit("taylor with decisions and second contacts, cosine valley, 2 s", "taylor, cosine valley, 2 s", 4.0),
    CostLimit("taylor with decisions and second contacts, superellipse on hill", "taylor, superellipse on hill", 4.0),
)
# Limits in CPU seconds: the whole call of the disc's five seconds, `import reference`, the first motion of a process.
WHOLE, CALL = "simulate by taylor, disc in circle, 5 s", 1.2e-3
IMPORT, IMPORT_SECONDS = "import reference", 0.45
FIRST = 0.5
# Largest cost of a unit of a longer motion over that of a unit of any shorter one: the cost grows in proportion, within
# 15 %, or more slowly. Cheaper units are expected, because calls have fixed costs and loops warm up.
DEARER = 1.15
# Limits that are known to be exceeded, with the reasons.
_LEAVING = (
    "The compiled steps alone take 5 µs, 1.5 times heyoka on (35). Leaving the start, where a guard is zero, takes "
    "6 µs (2 for its coefficients, 3 for one compiled function with its arguments and results, 1 for setting the state "
    "again); input and output of a phase take 3. Each call of a compiled function from Python takes at least 1 µs."
)
_DECIDING = (
    "Of 180 µs, the two phases take 65 (35 of them integration), the first decision 20, the equations of two modes for "
    "a new case 25, making and checking the case 20, the answer 8."
)
EXPLANATIONS: dict[str, str] = {
    **{f"taylor, first slip, mu={mu}": _LEAVING for mu in COEFFICIENTS},
    **{f"simulate by taylor, first slip, new mu={mu}": _DECIDING for mu in COEFFICIENTS},
    "simulate by taylor, disc in circle, 5 s": (
        "Of 350 µs, integration takes 125, the new case with its first decision and its answer 110 (once per call); "
        "the rest are the eight transitions, 14 µs each: 8 for the decision, 6 for transferring and recording the "
        "state. The ratio was chosen when integration took 600 µs; the call itself takes a third of its limit."
    ),
}


class CostRows(NamedTuple):
    """Rows of the first three tables, and CPU seconds of `import reference`."""

    hot: list[dict[str, Any]]
    growth: list[dict[str, Any]]
    cold: list[dict[str, Any]]
    import_s: float = nan


def run(request: Request, calls: Calls) -> CostRows:
    """Run all timings one after the other, without other load."""
    full = request.full
    budget = FULL_BUDGET if full else BUDGET
    sizes = [(g, size) for g in growth.GROWTHS for size in (g.all_sizes if full else g.sizes)]
    labels = process_start.labels(full)
    with calls.alone() as alone:
        (hot,) = alone.all("timings", timings, [(budget,)], limit=budget + _PATIENCE)
        (import_answer,) = alone.all("import", process_start.import_seconds, [()])
        first = alone.all("first motions", process_start.first_motion, [(label,) for label in labels])
    growth_answers = []
    for size in sizes:
        with calls.alone() as alone:  # a process for each: memory freed by one would hide what the next takes
            growth_answers += alone.all("growing motions", growth.measure, [size], limit=_LONGEST)
    return CostRows(
        _hot_rows(hot),
        _growth_rows(sizes, growth_answers),
        [_cold_row(label, answer) for label, answer in zip(labels, first, strict=True)],
        import_answer.value if import_answer.outcome == "done" else nan,
    )


def timings(budget: float) -> dict[str, tuple[Timing, float]]:
    """Timing and error (s, NaN for whole motions) of every contestant, within about `budget` wall-clock seconds."""
    entries, programs = [], contestants()
    for name, program in programs.items():
        # The case is only a label here.
        contestant = Contestant(cases.load("disc_in_circle"), REFERENCE, name, Setting.of(rtol=RTOL), 1e-3)
        entries.append(ClockEntry(contestant, lambda: None, lambda model, run=program.run: run()))  # type: ignore[misc]
    loop = take_turns(entries, time.perf_counter() + budget)
    return {e.contestant.route: (timing(e, loop), programs[e.contestant.route].error) for e in entries if e.repeats}


def _hot_rows(answer: CallResult) -> list[dict[str, Any]]:
    """Rows of warm contestants; the ratio of the fastest is one."""
    if answer.outcome != "done":
        return [_row("all", NO_TIMING, reason=answer.failure[1])]
    fastest = min(t.cpu_s for t, _ in answer.value.values())
    return [_row(name, t, t.cpu_s / fastest, error) for name, (t, error) in answer.value.items()]


def _row(name: str, t: Timing, ratio: float = nan, error: float = nan, reason: str = "") -> dict[str, Any]:
    times = {"cpu_s": t.cpu_s, "cpu_low_s": t.cpu_low_s, "cpu_high_s": t.cpu_high_s}
    counts = {"repeats": t.repeats, "disturbed": t.disturbed}
    return {"contestant": name, **times, "ratio": ratio, **counts, "error_s": error, "reason": reason}


def _growth_rows(sizes: list[tuple[growth.Growth, int]], answers: list[CallResult]) -> list[dict[str, Any]]:
    growth_rows = []
    least: dict[str, tuple[int, float]] = {}
    for (what, size), answer in zip(sizes, answers, strict=True):
        is_done = answer.outcome == "done"
        size_cost = answer.value if is_done else growth.GrowthRow(nan, nan, 0, 0, nan, answer.failure[1])
        fewest, first_s = least.setdefault(what.quantity, (size, size_cost.call_s))
        unit_s = (size_cost.call_s - first_s) / (size - fewest) if size > fewest else nan
        growth_rows.append(
            {"case": what.case, "counted": what.quantity, "size": size, "cpu_s": size_cost.call_s, "unit_s": unit_s}
            | {"sampled_s": size_cost.sampled_s, "transitions": size_cost.transitions, "steps": size_cost.steps}
            | {"memory_mb": size_cost.memory_mb, "status": size_cost.status}
        )
    return growth_rows


def _cold_row(label: str, answer: CallResult) -> dict[str, Any]:
    is_done = answer.outcome == "done"
    return {"case": label, "cpu_s": answer.value if is_done else nan, "reason": "" if is_done else answer.failure[1]}


def rows(findings: CostRows) -> dict[str, list[dict[str, Any]]]:
    """The tables of costs, and the table of limits."""
    return {
        "reference_cost": findings.hot,
        "reference_growth": findings.growth,
        "reference_cold": findings.cold,
        "reference_cost_bars": bars(findings),
    }


def bars(findings: CostRows) -> list[dict[str, Any]]:
    """Each limit with the measured value; "not timed" if the value or its baseline is missing."""
    cpu_s = {row["contestant"]: row["cpu_s"] for row in findings.hot}
    bar_rows = [
        _bar(b.contestant, b.baseline, b.limit, cpu_s.get(b.contestant, nan) / cpu_s.get(b.baseline, nan)) for b in BARS
    ]
    bar_rows.append(_bar(WHOLE, "s", CALL, cpu_s.get(WHOLE, nan)))
    for what in growth.GROWTHS:
        units = [row["unit_s"] for row in findings.growth if row["counted"] == what.quantity][1:]
        bar_rows.append(
            _bar(f"a later one of {what.quantity}", "the cheapest of those before it", DEARER, _dearer(units))
        )
    bar_rows.append(_bar(IMPORT, "s", IMPORT_SECONDS, findings.import_s))
    bar_rows += [_bar(f"first motion, {row['case']}", "s", FIRST, row["cpu_s"]) for row in findings.cold]
    return bar_rows


def _dearer(units: list[float]) -> float:
    """The largest ratio of a later unit's time to an earlier one's; NaN if one has no time."""
    if any(map(isnan, units)):
        return nan
    return max((later / min(units[:i]) for i, later in enumerate(units) if i), default=nan)


def _bar(what: str, baseline: str, limit: float, value: float) -> dict[str, Any]:
    outcome = "not timed" if isnan(value) else "pass" if value <= limit else "fail"
    row = {"what": what, "beside": baseline, "limit": limit, "measured": value, "outcome": outcome}
    return row | {"remark": EXPLANATIONS.get(what, "") if outcome == "fail" else ""}
