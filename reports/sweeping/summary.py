"""The summary of a sweep: how many scenarios did what, why some have no motion, and what the engines made of them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from statistics import median
from typing import Any, NamedTuple

from reference.sweeping.motions import USUAL
from reference.sweeping.table import BAD, FAILED

from ..judging.grades import percent
from .computation import ROWS
from .map_figures import kind
from .sweep_folder import Folder

# Outcomes without a motion.
_NO_MOTION = (BAD, FAILED, "crashed", "timed_out")
# Lines of each list; the rarer ones are not printed.
MOST = 12
_NUMBER = re.compile(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?")


class Explanation(NamedTuple):
    """Why scenarios have no motion, or end unusually: their outcome, the reason of the first one (those that differ in
    numbers alone count as one), and their number."""

    outcome: str
    text: str
    scenarios: int


class EngineSummary(NamedTuple):
    """What an engine by one of its routes made of a sweep: scenarios by outcome, answers by grade, median of `off`, and
    the reasons of those without an answer."""

    title: str
    outcomes: dict[str, int]
    grades: dict[str, int]
    median_off: float
    reasons: list[Explanation]


class Summary(NamedTuple):
    """Scenarios by the kind of their motion, reasons of those without a usual one, engines, and whether anything ran:
    the reference, and of the engines asked for at least one."""

    kinds: dict[str, int]
    reasons: list[Explanation]
    engines: list[EngineSummary]
    ran: bool


def summary(folder: Folder, engines: Mapping[str, str]) -> Summary:
    """The summary of the rows in a folder; `engines`: kinds of rows and their titles."""
    kinds, outcomes, reasons = Counter[str](), Counter[str](), _Reasons()
    for rows in folder.rows(ROWS, ["sequence", "outcome", "reason"]):
        groups = rows.group_by(["sequence", "outcome", "reason"], use_threads=False).aggregate([([], "count_all")])
        for row in groups.to_pylist():
            kinds[kind(row["sequence"] or "", row["outcome"])] += row["count_all"]
            outcomes[row["outcome"]] += row["count_all"]
            if row["outcome"] not in USUAL:
                reasons.add(row["outcome"], row["reason"], row["count_all"])
    by_engine = [_of_engine(folder, name, title) for name, title in engines.items()]
    moves = any(outcome not in _NO_MOTION for outcome in outcomes)
    answers = not engines or any(one.outcomes.get("answered") for one in by_engine)
    return Summary(dict(kinds.most_common()), reasons.listed(), by_engine, moves and answers)


class _Reasons:
    """Reasons by outcome and text without numbers, each with its count."""

    def __init__(self) -> None:
        self.texts, self.counts = dict[tuple[str, str], str](), Counter[tuple[str, str]]()

    def add(self, outcome: str, text: str | None, count: int) -> None:
        key = outcome, _NUMBER.sub("#", text or "")
        self.texts.setdefault(key, text or "")
        self.counts[key] += count

    def listed(self) -> list[Explanation]:
        return [Explanation(key[0], self.texts[key], count) for key, count in self.counts.most_common()]


def _of_engine(folder: Folder, rows_kind: str, title: str) -> EngineSummary:
    outcomes, grades, off, reasons = Counter[str](), Counter[str](), list[float](), _Reasons()
    for rows in folder.rows(rows_kind, ["outcome", "grade", "off", "reason"]):
        for row in rows.to_pylist():
            outcomes[row["outcome"]] += 1
            if row["outcome"] == "answered":
                grades[row["grade"]] += 1
                off += [row["off"]] if row["off"] is not None else []
            elif row["outcome"] not in (BAD, FAILED):  # of the scene itself, not of the engine
                reasons.add(row["outcome"], row["reason"], 1)
    middle = median(off) if off else float("nan")
    return EngineSummary(title, dict(outcomes.most_common()), dict(grades.most_common()), middle, reasons.listed())


def as_text(one: Summary) -> str:
    """The summary as indented lines."""
    lines = [f"  {count:>12,}  {what}" for what, count in [*one.kinds.items()][:MOST]]
    lines += _reason_lines(one.reasons)
    for engine in one.engines:
        grades = ", ".join(f"{count:,} {name}" for name, count in engine.grades.items())
        others = ", ".join(f"{count:,} {name}" for name, count in engine.outcomes.items() if name != "answered")
        off = f"; median off {percent(engine.median_off)}" if engine.median_off == engine.median_off else ""
        lines.append(f"{engine.title}: {'; '.join(text for text in (grades, others) if text)}{off}")
        lines += _reason_lines(engine.reasons)
    return "\n".join(lines)


def _reason_lines(reasons: list[Explanation]) -> list[str]:
    return [f"  {one.scenarios:>12,}  {one.outcome}: {one.text}" for one in reasons[:MOST]]


def as_dict(one: Summary) -> dict[str, Any]:
    """The summary as named values, for JSON."""
    reasons = [reason._asdict() for reason in one.reasons]
    engines = [{**engine._asdict(), "reasons": [r._asdict() for r in engine.reasons]} for engine in one.engines]
    return {"kinds": one.kinds, "reasons": reasons, "engines": engines, "ran": one.ran}
