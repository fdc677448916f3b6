"""The section's first sentences, from the rows of `which_engine` and `time_to_accuracy`: who is cheaper, and by what.

They say what was measured whoever it favours: where an engine is cheaper, that is what the sentence says.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from statistics import median
from typing import Any, NamedTuple

from ..running.records import REFERENCE
from .number_format import level, number, quantity, seconds, times, unit
from .time_to_accuracy import DISTURBED, YES
from .which_engine import ALIKE, RUNS

# The accuracy an engineer asks for; the first sentence is about it, or the finest coarser one that anybody has.
LEVEL = 1e-4


class Headline(NamedTuple):
    """The first sentence, about one case, and those that follow, about all."""

    first: str
    rest: str


def headline(answers: Sequence[dict[str, Any]], told: Sequence[dict[str, Any]]) -> Headline:
    """By rows of `which_engine` and of `time_to_accuracy`."""
    decided = [row for row in answers if row["cheaper"]]
    if not decided:
        nothing = "No case has timings of both an engine and the reference to be compared by."
        return Headline(_disturbed(told) or nothing, "")
    accuracy = LEVEL if any(row["accuracy"] == LEVEL for row in decided) else decided[0]["accuracy"]
    of_level = [row for row in decided if row["accuracy"] == accuracy]
    case = of_level[0]["case"]
    parts = [_clause(row) for row in of_level if row["case"] == case]
    first = (
        f"As used from Python, to reach {level(accuracy)}{unit(of_level[0]['unit'])} in "
        f"{quantity(of_level[0]['quantity'])} of {case}, {'; '.join(parts)}."
    )
    rest = [_even(of_level[0])] + [_count(of_level, runs) for runs in RUNS] + [_alone(told, case, accuracy)]
    return Headline(first, " ".join(filter(None, [*rest, _disturbed(told)])))


def _clause(row: dict[str, Any]) -> str:
    """Who takes how long for so many runs, the cheaper first."""
    spent = {row["engine"]: row["engine_total_s"], row["reference"]: row["reference_total_s"]}
    one, other = sorted(spent, key=lambda who: spent[who])
    what = "one simulation from cold takes" if row["runs"] == 1 else f"{row['runs']:,} take"
    end = "they are alike" if row["cheaper"] == ALIKE else f"{row['cheaper']} is cheaper, by {times(row['factor'])}"
    return f"{what} {seconds(spent[one])} with {one} and {seconds(spent[other])} with {other}: {end}"


def _even(row: dict[str, Any]) -> str:
    runs = row["break_even_runs"]
    if not isfinite(runs):
        return "However often it is run, an engine stays cheaper there."
    return "The reference is cheaper from the first run on." if runs <= 1 else (
        f"From {runs:,.0f} runs on the reference is cheaper there."
    )  # fmt: skip


def _count(rows: Sequence[dict[str, Any]], runs: int) -> str:
    """At one accuracy, over all cases: in how many an engine is cheaper, and which."""
    same = [row for row in rows if row["runs"] == runs]
    ahead = [row for row in same if row["cheaper"] == row["engine"]]
    how = "run once" if runs == 1 else f"run {runs:,} times"
    told = f"Over all {len(same)} cases decided at {level(rows[0]['accuracy'])}, {how}, an engine is cheaper in "
    if not ahead:
        return told + "none."
    names = "; ".join(f"{row['case']} ({row['engine']}, {times(row['factor'])})" for row in ahead)
    return f"{told}{len(ahead)}: {names}."


def _alone(told: Sequence[dict[str, Any]], case: str, accuracy: float) -> str:
    """What of the cheapest warm run is the engine's own, beside the reference's whole run."""
    rows = [r for r in told if r["case"] == case and r["accuracy"] == accuracy and r["lead"] and r["award"] == YES]
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
    """What is not in the warm times of runs: building and compiling all settings of a case."""
    spent: dict[str, dict[str, float]] = {}
    for row in {(p["case"], p["solver"], p["route"], p["setting"]): p for p in points}.values():
        whole = row["setup_s"] + (row["compile_s"] if isfinite(row["compile_s"]) else 0.0)
        if isfinite(whole):
            of_solver = spent.setdefault(row["solver"], {})
            of_solver[row["case"]] = of_solver.get(row["case"], 0.0) + whole
    if not spent:
        return ""
    told = ", ".join(f"{solver} {seconds(median(cases.values()))}" for solver, cases in spent.items())
    return f"Building and compiling all settings of a case together takes, in the median, {told}."


def _disturbed(told: Sequence[dict[str, Any]]) -> str:
    """How much was measured on a machine that had other things to do, and is ranked nowhere."""
    timed = [row for row in told if row["award"] in (YES, DISTURBED)]
    lost = sum(row["award"] == DISTURBED for row in timed)
    if not lost:
        return ""
    return (
        f"The machine had other things to do during {number(100 * lost / len(timed))} % of these timings, which "
        "therefore rank nothing: make the report again on a quiet one."
    )
