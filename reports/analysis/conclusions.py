"""The section's first sentences, counted from the rows: where the reference is cheaper, by how much, and where not."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from statistics import median
from typing import Any, NamedTuple

from ..running.records import REFERENCE
from .quantities import UNITS
from .work_precision import DISTURBED, groups, ratio_of_intervals

# The factor that is worth the name at the finest level an engine reaches.
CLEARLY = 100.0


class Conclusion(NamedTuple):
    """At one accuracy of a case: the engine that gets there first, and its CPU time over that of each of the
    reference's methods (least, middle, greatest that the timings allow)."""

    case: str
    quantity: str
    accuracy: float
    engine: str
    ratios: dict[str, tuple[float, float, float]]
    finest: bool  # whether no engine is known to reach a finer level


def main_quantity(rows: Sequence[dict[str, Any]]) -> dict[str, str]:
    """What each case is judged by: the first transition's time where there is one, else the final pose."""
    first, pose = "first_transition_time", "final_pose"
    asked = {(row["case"], row["quantity"]) for row in rows}
    return {case: first if (case, first) in asked else pose for case in dict.fromkeys(row["case"] for row in rows)}


def conclusions(rows: Sequence[dict[str, Any]]) -> list[Conclusion]:
    """One for each case and accuracy that both an engine and the reference reach, by rows of `time_to_accuracy`."""
    quantity = main_quantity(rows)
    rows = [row for row in rows if quantity[row["case"]] == row["quantity"]]
    found = []
    for (case,), of_case in groups(rows, "case").items():
        timed = [row for row in of_case if _is_time(row)]
        reached = [row["accuracy"] for row in timed if row["solver"] != REFERENCE]
        for (accuracy,), level in groups(timed, "accuracy").items():
            engines = [row for row in level if row["solver"] != REFERENCE]
            own = [row for row in level if row["solver"] == REFERENCE]
            if engines and own:
                best = min(engines, key=lambda row: row["cpu_s"])
                ratios = {row["route"]: ratio_of_intervals(best, row) for row in own}
                name = f"{best['solver']} {best['route']}"
                found.append(Conclusion(case, quantity[case], accuracy, name, ratios, accuracy == min(reached)))
    return found


def _is_time(row: dict[str, Any]) -> bool:
    return not isinstance(row["cpu_s"], str)


def headline(rows: Sequence[dict[str, Any]]) -> str:
    """What the section says first: by what factor the reference is cheaper, and everywhere that it is not."""
    found = conclusions(rows)
    if not found:
        return f"No case has timings of both an engine and the reference to be ranked by.{_disturbed(rows)}"
    methods = list(dict.fromkeys(method for verdict in found for method in verdict.ratios))
    finest = [verdict for verdict in found if verdict.finest]
    parts = []
    for method in methods:
        ratios = [v.ratios[method][1] for v in finest if method in v.ratios]
        if ratios:
            parts.append(f"{median(ratios):.2g} times {method}'s (from {min(ratios):.2g} to {max(ratios):.2g})")
    told = (
        f"At the finest accuracy that any engine reaches, the engine that gets there first takes {' and '.join(parts)} "
        f"CPU time, in the median over {_cases(len(finest))}."
    )
    best = methods[0]
    close = [v for v in finest if best in v.ratios and 1.0 <= v.ratios[best][1] < CLEARLY]
    if close:
        told += f" It is less than {CLEARLY:g} times {best}'s on {_list(close, best)}."
    return told + "".join(_method(method, found) for method in methods) + _disturbed(rows)


def _method(method: str, found: Sequence[Conclusion]) -> str:
    """Where one method of the reference is cheaper than every engine, and where it is not."""
    mine = [verdict for verdict in found if method in verdict.ratios]
    dearer = [v for v in mine if v.ratios[method][1] < 1.0]
    told = f" {method.capitalize()} is cheaper than every engine at {len(mine) - len(dearer)} of the {len(mine)} levels"
    told += " of accuracy, from 0.01 on, that an engine reaches"
    return told + (f"; not on {_list(dearer, method)}." if dearer else ".")


def _list(found: Sequence[Conclusion], method: str) -> str:
    """Case by case: the accuracies, the engine, and what part of the method's time it takes where that is least."""
    named = []
    for (case, engine), same in groups([v._asdict() for v in found], "case", "engine").items():
        levels = [v["accuracy"] for v in same]
        worst = min((v["ratios"][method] for v in same), key=lambda ratio: ratio[1])
        span = f"{max(levels):g}" + (f" to {min(levels):g}" if len(levels) > 1 else "")
        unit = UNITS[same[0]["quantity"]]
        named.append(f"{case} at {span} {unit} ({engine}: {worst[1]:.2g}{'' if _sure(worst) else ', not for sure'})")
    return "; ".join(named)


def _sure(ratio: tuple[float, float, float]) -> bool:
    """Whether the interval leaves one out."""
    low, _, high = ratio
    return high < 1.0 or low > 1.0


def set_up(points: Sequence[dict[str, Any]]) -> str:
    """What is not in the times of `work_precision`: building and compiling all settings of a case."""
    spent: dict[str, dict[str, float]] = {}
    for row in {(p["case"], p["solver"], p["route"], p["setting"]): p for p in points}.values():
        seconds = row["setup_s"] + (row["compile_s"] if isfinite(row["compile_s"]) else 0.0)
        if isfinite(seconds):
            of_solver = spent.setdefault(row["solver"], {})
            of_solver[row["case"]] = of_solver.get(row["case"], 0.0) + seconds
    told = ", ".join(f"{solver} {median(cases.values()):.2g} s" for solver, cases in spent.items())
    return (
        f"Not in these times: building and compiling. All settings of a case together take, in the median, {told}."
        if told
        else ""
    )


def _cases(count: int) -> str:
    return f"{count} case{'s' * (count != 1)}"


def _disturbed(rows: Sequence[dict[str, Any]]) -> str:
    """How much was measured on a machine that had other things to do, and is ranked nowhere."""
    timed = [row for row in rows if _is_time(row) or row["cpu_s"] == DISTURBED]
    lost = sum(row["cpu_s"] == DISTURBED for row in timed)
    if not lost:
        return ""
    return (
        f" The machine was disturbed during {lost / len(timed):.0%} of these timings, which therefore rank "
        "nothing: make them again on a quiet one."
    )
