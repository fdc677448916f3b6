"""Which engine, for what accuracy, at what cost, once and a thousand times: answers, from `time_to_accuracy`."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import Any

from ..running.records import REFERENCE
from .time_to_accuracy import YES, break_even, cost
from .work_precision import groups

# For once, as a user tries an engine; for a sweep or a training.
RUNS = (1, 1000)
# Accuracies whose cold starts and parts of time are measured.
LEVELS = (1e-2, 1e-4, 1e-6)
# Who is dearer by less than this is called alike: so much two processes may differ, and cold starts are few.
ALIKE_BELOW = 1.1
ALIKE = "alike"
NOBODY = "no engine reaches it"


def cold_start_keys(told: Sequence[dict[str, Any]]) -> set[tuple]:
    """Case, solver, route and setting of all that the answers need from cold and in parts."""
    rows = [r for r in told if r["lead"] and r["accuracy"] in LEVELS and r["award"] == YES]
    return {(r["case"], r["solver"], r["route"], r["setting"]) for r in rows}


def rows(told: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """One answer per case, accuracy and number of runs: the cheapest engine beside the cheapest method of the
    reference, by whole calls as used from Python, the first from cold.

    `cheaper` names who is, by `factor`, or says "alike"; it is empty where one of the two is not known, and `reason`
    says why. `engine_alone_s`: what the engine's compiled code takes of the engine's time. `break_even_runs`: from how
    many runs on the reference is cheaper than every engine; empty: never.
    """
    found = []
    for (case, accuracy), level in groups([r for r in told if r["lead"]], "case", "accuracy").items():
        if accuracy in LEVELS:
            found += [_answer(case, accuracy, runs, level) for runs in RUNS]
    return found


def _answer(case: str, accuracy: float, runs: int, level: Sequence[dict[str, Any]]) -> dict[str, Any]:
    timed = [r for r in level if isfinite(cost(r, runs))]
    engines, own = ([r for r in timed if (r["solver"] == REFERENCE) == ours] for ours in (False, True))
    engine, method = (min(group, key=lambda r: cost(r, runs), default=None) for group in (engines, own))
    row: dict[str, Any] = {"case": case, "quantity": level[0]["quantity"], "unit": level[0]["unit"]}
    row |= (
        {"accuracy": accuracy, "runs": runs}
        | _cell_text("engine", engine, runs)
        | _cell_text("reference", method, runs)
    )
    row["engine_alone_s"] = runs * engine["engine_s"] if engine else nan
    row |= {"cheaper": "", "factor": nan, "break_even_runs": nan, "reason": ""}
    if not engine or not method:
        row["reason"] = "; ".join(
            _reason(level, side) for side, one in ((True, engine), (False, method)) if one is None
        )
        return row
    spent = (row["engine_total_s"], row["reference_total_s"])
    row["factor"] = max(spent) / min(spent)
    winner = row["engine"] if spent[0] < spent[1] else row["reference"]
    row["cheaper"] = ALIKE if row["factor"] < ALIKE_BELOW else winner
    row["break_even_runs"] = break_even(engines, own)
    return row


def _cell_text(who: str, row: dict[str, Any] | None, runs: int) -> dict[str, Any]:
    """Name, setting and seconds of the cheapest of a side."""
    if row is None:
        return {who: "", f"{who}_setting": "", f"{who}_total_s": nan}
    return {who: f"{row['solver']} {row['route']}", f"{who}_setting": row["setting"], f"{who}_total_s": cost(row, runs)}


def _reason(level: Sequence[dict[str, Any]], engines: bool) -> str:
    """Why one side has no time."""
    side = [r for r in level if (r["solver"] != REFERENCE) == engines]
    if not any(r["award"] == YES for r in side):
        words = dict.fromkeys(r["award"] for r in side)
        if engines and set(words) <= {"never", "by chance"}:
            return NOBODY
        return f"{'the engines' if engines else 'the reference'}: {', '.join(words)}" if words else "nobody took part"
    return f"{'the engines were' if engines else 'the reference was'} not timed from cold"
