"""What the reference costs, against heyoka on the paper's closed form in the same run, as motions grow, and from cold.

Hot contestants take turns at the one clock: ratios hold on a noisy machine, absolute times do not.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import cases
from adapters import Setting

from ...analysis.columns import Table
from ...running.calls import Answer, Calls
from ...running.clock import UNTIMED, Contestant, Entry, Timing, take_turns, timing
from ...running.records import REFERENCE
from .. import Request
from . import cold, growth
from .contestants import COEFFICIENTS, RTOL, contestants

if TYPE_CHECKING:
    from ...drawing.files import Drawn

TITLE = "What the reference costs"
QUESTION = (
    "The general formulation against a Taylor integrator on the paper's own closed form, whether its cost grows with "
    "the motion and no faster, and what a new process pays."
)
TAKES = ()
IN_REPORT = False  # it says how the reference's own code fares, and nothing of engines
TABLES = {
    "reference_cost": Table(
        "CPU time of the reference and of heyoka on the paper's closed form, all compiled before",
        {
            "contestant": "what is solved by what",
            "cpu_s": "CPU time, s: the median of the undisturbed repeats",
            "cpu_low_s": "where the median of another process is expected to begin, s",
            "cpu_high_s": "where it is expected to end, s",
            "ratio": "CPU time over the fastest contestant's",
            "repeats": "how many repeats the median is of",
            "disturbed": "whether the machine had other things to do",
            "error_s": "error of the first transition's time, s; at most 1e-9 in first slip phases",
            "reason": "why there is no time",
        },
    ),
    "reference_growth": Table(
        "Motions that are made longer",
        {
            "case": "what moves",
            "counted": "what is counted: periods, transitions, or seconds",
            "size": "how many (of transitions: about)",
            "cpu_s": "CPU time of the call, s: the least of a few",
            "unit_s": "CPU time of a unit beyond the call with the fewest, s",
            "sampled_s": "CPU time of the call and of its samples, s",
            "transitions": "transitions of the motion",
            "steps": "steps of the integrator",
            "memory_mb": "by how much the process's memory grew, MB, samples included",
            "status": "how the motion ended, or why there is no time",
        },
    ),
    "reference_cold": Table(
        "The first motion of a new process, its imports done",
        {
            "case": "what moves",
            "without_s": "CPU time without a cache on disk, s: all is derived and compiled",
            "warm_s": "CPU time with a cache that knows it, s: the least of three processes",
            "reason": "why there is no time",
        },
    ),
    "reference_cost_bars": Table(
        "What the reference may cost",
        {
            "what": "what is held to a bar",
            "beside": "what it is measured by",
            "limit": "the bar: at most so much",
            "measured": "so much it was: times the CPU time of what stands beside it, or s",
            "outcome": "pass, fail, or not timed",
            "remark": "of bars that are known to be missed: why",
        },
    ),
}
# Wall seconds for all turns; a full study waits for better known medians.
BUDGET, FULL_BUDGET = 20.0, 60.0
# Beyond its budget: derivations and compilations of all contestants (half a minute on a machine of their own).
_PATIENCE = 300.0
# So long may one size of a growing motion take.
_LONGEST = 600.0


class Bar(NamedTuple):
    """A contestant may take at most `limit` times the CPU time of the one beside it."""

    contestant: str
    beside: str
    limit: float


BARS = (
    *(Bar(f"taylor, first slip, mu={mu}", f"heyoka on (35), first slip, mu={mu}", 2.5) for mu in COEFFICIENTS),
    *(
        Bar(f"simulate by taylor, first slip, new mu={mu}", f"heyoka on (35), first slip, mu={mu}", 60.0)
        for mu in COEFFICIENTS
    ),
    Bar("simulate by taylor, disc in circle, 5 s", "taylor, disc in circle, 5 s", 2.0),
    Bar("taylor with decisions and second contacts, cosine valley, 2 s", "taylor, cosine valley, 2 s", 4.0),
    Bar("taylor with decisions and second contacts, superellipse on hill", "taylor, superellipse on hill", 4.0),
)
# CPU seconds: the whole call of the disc's five seconds, `import reference`, the first motion of a new process.
WHOLE, CALL = "simulate by taylor, disc in circle, 5 s", 1.2e-3
IMPORT, IMPORTED = "import reference", 0.45
FIRST = 0.2
# What a unit of a longer motion may take, over a unit of any shorter one: the cost grows in proportion, to 15 %, or
# slower. That a unit gets cheaper, as calls have fixed costs and loops warm up, is no fault.
DEARER = 1.15
# Bars that are known to be missed, and why.
_LEAVING = (
    "The compiled steps alone take 5 µs, 1.5 times heyoka on (35). To leave the start, where a guard is zero, takes "
    "6 µs (its coefficients 2, one compiled function 3 with what is told to it and by it, the state set anew 1), what "
    "a phase is told and tells takes 3. Each call of a compiled function from Python takes 1 µs whatever it does."
)
_DECIDING = (
    "Of 180 µs the two phases take 65 (35 of them integration), the first decision 20, the equations of two modes for "
    "a new case 25, to make and check the case 20, the answer 8."
)
KNOWN: dict[str, str] = {
    **{f"taylor, first slip, mu={mu}": _LEAVING for mu in COEFFICIENTS},
    **{f"simulate by taylor, first slip, new mu={mu}": _DECIDING for mu in COEFFICIENTS},
    "simulate by taylor, disc in circle, 5 s": (
        "Of 350 µs integration takes 125, the new case with its first decision and its answer 110, once a call; the "
        "rest are the eight transitions, 14 µs each: 8 to decide, 6 to carry over and to tell. The ratio was set where "
        "integration took 600 µs: the call itself takes a third of its bar."
    ),
}


class Found(NamedTuple):
    """Rows of the first three tables, and CPU s of `import reference`."""

    hot: list[dict[str, Any]]
    grown: list[dict[str, Any]]
    cold: list[dict[str, Any]]
    import_s: float = nan


def run(request: Request, calls: Calls) -> Found:
    """All that is timed: alone, one after the other."""
    budget = FULL_BUDGET if request.full else BUDGET
    sizes = [(g, size) for g in growth.GROWTHS for size in (g.all_sizes if request.full else g.sizes)]
    labels = cold.labels(request.full)
    with calls.alone() as alone:
        (hot,) = alone.all("timings", timings, [(budget,)], limit=budget + _PATIENCE)
        (imported,) = alone.all("import", cold.imported, [()])
        first = alone.all("first motions", cold.first_motion, [(label,) for label in labels])
    grown = []
    for size in sizes:
        with calls.alone() as alone:  # a process each: memory that one gave back would hide what the next takes
            grown += alone.all("growing motions", growth.measure, [size], limit=_LONGEST)
    return Found(
        _hot_rows(hot),
        _growth_rows(sizes, grown),
        [_cold_row(label, answer) for label, answer in zip(labels, first, strict=True)],
        imported.value if imported.outcome == "done" else nan,
    )


def timings(budget: float) -> dict[str, tuple[Timing, float]]:
    """Timing and error (s, NaN for whole motions) of every contestant, within about `budget` wall seconds."""
    entries, programs = [], contestants()
    for name, program in programs.items():
        # The case only labels the turn.
        who = Contestant(cases.load("disc_in_circle"), REFERENCE, name, Setting.of(rtol=RTOL), 1e-3)
        entries.append(Entry(who, lambda: None, lambda model, run=program.run: run()))  # type: ignore[misc]
    loop = take_turns(entries, time.perf_counter() + budget)
    return {e.contestant.route: (timing(e, loop), programs[e.contestant.route].error) for e in entries if e.repeats}


def _hot_rows(answer: Answer) -> list[dict[str, Any]]:
    """The fastest contestant's ratio is one."""
    if answer.outcome != "done":
        return [_row("all", UNTIMED, reason=answer.failure[1])]
    fastest = min(t.cpu_s for t, _ in answer.value.values())
    return [_row(name, t, t.cpu_s / fastest, error) for name, (t, error) in answer.value.items()]


def _row(name: str, t: Timing, ratio: float = nan, error: float = nan, reason: str = "") -> dict[str, Any]:
    times = {"cpu_s": t.cpu_s, "cpu_low_s": t.cpu_low_s, "cpu_high_s": t.cpu_high_s}
    counts = {"repeats": t.repeats, "disturbed": t.disturbed}
    return {"contestant": name, **times, "ratio": ratio, **counts, "error_s": error, "reason": reason}


def _growth_rows(sizes: list[tuple[growth.Growth, int]], answers: list[Answer]) -> list[dict[str, Any]]:
    found = []
    least: dict[str, tuple[int, float]] = {}
    for (what, size), answer in zip(sizes, answers, strict=True):
        done = answer.outcome == "done"
        grown = answer.value if done else growth.Grown(nan, nan, 0, 0, nan, answer.failure[1])
        fewest, first_s = least.setdefault(what.counted, (size, grown.call_s))
        unit_s = (grown.call_s - first_s) / (size - fewest) if size > fewest else nan
        found.append(
            {"case": what.case, "counted": what.counted, "size": size, "cpu_s": grown.call_s, "unit_s": unit_s}
            | {"sampled_s": grown.sampled_s, "transitions": grown.transitions, "steps": grown.steps}
            | {"memory_mb": grown.memory_mb, "status": grown.status}
        )
    return found


def _cold_row(label: str, answer: Answer) -> dict[str, Any]:
    done = answer.outcome == "done"
    took = answer.value if done else cold.Cold(nan, nan)
    return {"case": label, **took._asdict(), "reason": "" if done else answer.failure[1]}


def rows(found: Found) -> dict[str, list[dict[str, Any]]]:
    """What everything took, and the bars."""
    return {
        "reference_cost": found.hot,
        "reference_growth": found.grown,
        "reference_cold": found.cold,
        "reference_cost_bars": bars(found),
    }


def bars(found: Found) -> list[dict[str, Any]]:
    """Each bar with what was measured; "not timed" where there is nothing to measure by."""
    took = {row["contestant"]: row["cpu_s"] for row in found.hot}
    told = [_bar(b.contestant, b.beside, b.limit, took.get(b.contestant, nan) / took.get(b.beside, nan)) for b in BARS]
    told.append(_bar(WHOLE, "s", CALL, took.get(WHOLE, nan)))
    for what in growth.GROWTHS:
        units = [row["unit_s"] for row in found.grown if row["counted"] == what.counted][1:]
        told.append(_bar(f"a later one of {what.counted}", "the cheapest of those before it", DEARER, _dearer(units)))
    told.append(_bar(IMPORT, "s", IMPORTED, found.import_s))
    told += [_bar(f"first motion, {row['case']}", "s", FIRST, row["warm_s"]) for row in found.cold]
    return told


def _dearer(units: list[float]) -> float:
    """The most that a later unit takes of what an earlier one takes; NaN where one has no time."""
    if any(map(isnan, units)):
        return nan
    return max((later / min(units[:i]) for i, later in enumerate(units) if i), default=nan)


def _bar(what: str, beside: str, limit: float, measured: float) -> dict[str, Any]:
    outcome = "not timed" if isnan(measured) else "pass" if measured <= limit else "fail"
    row = {"what": what, "beside": beside, "limit": limit, "measured": measured, "outcome": outcome}
    return row | {"remark": KNOWN.get(what, "") if outcome == "fail" else ""}


def draw(found: Found, folder: Path) -> Iterator[Drawn]:
    """No picture: a few numbers need none."""
    return iter(())
