"""The first sentences of the chapter on cost, from rows of `which_engine` and `time_to_accuracy`.

They report the measurements in either direction: where an engine is faster, the sentence says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from statistics import median
from typing import Any, NamedTuple

from ..judging.grades import LIMITS, Grade, percent
from ..running.names import REFERENCE
from .number_format import seconds, times
from .time_to_accuracy import DISTURBED, WITH_TIMES
from .which_engine import RUNS, TIE

# The level of the first sentence; if no case is decided at it, the coarsest that has one.
LEVEL = LIMITS[Grade.GOOD]


class Headline(NamedTuple):
    """The first sentence, about one case, and those that follow, about all."""

    first: str
    rest: str


def headline(answers: Sequence[dict[str, Any]], time_rows: Sequence[dict[str, Any]]) -> Headline:
    """The sentences from rows of `which_engine` and of `time_to_accuracy`."""
    answers_with_engine = [row for row in answers if row["cheaper"]]
    if not answers_with_engine:
        nothing = "No case has times of both an engine and the reference within one level."
        return Headline(_disturbance_note(time_rows) or nothing, "")
    level = LEVEL if any(row["level"] == LEVEL for row in answers_with_engine) else answers_with_engine[0]["level"]
    of_level = [row for row in answers_with_engine if row["level"] == level]
    case = of_level[0]["case"]
    parts = [_clause(row) for row in of_level if row["case"] == case]
    first = f"Called from Python, within {percent(level)} in {case}: {'; '.join(parts)}."
    rest = [_even(of_level[0])] + [_count(of_level, runs) for runs in RUNS] + [_alone(time_rows, case, level)]
    return Headline(first, " ".join(filter(None, [*rest, _disturbance_note(time_rows)])))


def _clause(row: dict[str, Any]) -> str:
    """Times of both for so many runs, the faster first."""
    total = {row["engine"]: row["engine_total_s"], row["reference"]: row["reference_total_s"]}
    one, other = sorted(total, key=lambda route: total[route])
    what = "the first run takes" if row["runs"] == 1 else f"{row['runs']:,} runs take"
    end = "a tie" if row["cheaper"] == TIE else f"{row['cheaper']} is faster, by {times(row['factor'])}"
    return f"{what} {seconds(total[one])} with {one} and {seconds(total[other])} with {other} ({end})"


def _even(row: dict[str, Any]) -> str:
    runs = row["break_even_runs"]
    if not isfinite(runs):
        return "An engine is faster there for any number of runs."
    return "The reference is faster there from the first run on." if runs <= 1 else (
        f"The reference is faster there from {runs:,.0f} runs on."
    )  # fmt: skip


def _count(rows: Sequence[dict[str, Any]], runs: int) -> str:
    """At one level, over all cases: in how many an engine is faster, and which."""
    same = [row for row in rows if row["runs"] == runs]
    if len(same) < 2:  # the first sentence says it
        return ""
    ahead = [row for row in same if row["cheaper"] == row["engine"]]
    number_of_runs = "For the first run" if runs == 1 else f"For {runs:,} runs"
    names = "; ".join(f"{row['case']} ({row['engine']}, {times(row['factor'])})" for row in ahead)
    level, share = percent(rows[0]["level"]), f"{len(ahead)} of {len(same)} cases"
    return f"{number_of_runs} within {level}, an engine is faster in {share}{f': {names}' if names else ''}."


def _alone(time_rows: Sequence[dict[str, Any]], case: str, level: float) -> str:
    """The engine's own part of the cheapest warm run, compared with the reference's whole run."""
    rows = [r for r in time_rows if (r["case"], r["level"]) == (case, level) and r["reached"] in WITH_TIMES]
    own = min((r["cpu_s"] for r in rows if r["solver"] == REFERENCE), default=float("nan"))
    engines = [r for r in rows if r["solver"] != REFERENCE and isfinite(r["engine_s"])]
    if not engines or not isfinite(own):
        return ""
    least = min(engines, key=lambda r: r["engine_s"])
    ratio = least["engine_s"] / own
    side = f"{times(ratio)} that of" if ratio >= 1.0 else f"{times(1.0 / ratio)} less than"
    return (
        f"Much of this is Python: of a warm run of {least['solver']} {least['route']}, {seconds(least['cpu_s'])}, the "
        f"engine alone takes {seconds(least['engine_s'])}, {side} the reference's whole run ({seconds(own)})."
    )


def set_up(points: Sequence[dict[str, Any]]) -> str:
    """The times that warm runs do not contain: building and compiling all settings of a case."""
    total: dict[str, dict[str, float]] = {}
    for row in {(p["case"], p["solver"], p["route"], p["setting"]): p for p in points}.values():
        whole = row["setup_s"] + (row["compile_s"] if isfinite(row["compile_s"]) else 0.0)
        if isfinite(whole):
            of_solver = total.setdefault(row["solver"], {})
            of_solver[row["case"]] = of_solver.get(row["case"], 0.0) + whole
    if not total:
        return ""
    words = ", ".join(f"{solver} {seconds(median(cases.values()))}" for solver, cases in total.items())
    return f"Building and compiling all settings of a case takes, in the median: {words}."


def _disturbance_note(time_rows: Sequence[dict[str, Any]]) -> str:
    """How many of the times to a level other load disturbed; they are not ranked."""
    entries = [row for row in time_rows if row["reached"] in (*WITH_TIMES, DISTURBED)]
    count = sum(row["reached"] == DISTURBED for row in entries)
    if not count:
        return ""
    return (
        f"{count} of the {len(entries)} times of a route to a level were disturbed by other load and are not ranked: "
        "make the report again on a quiet machine."
    )
