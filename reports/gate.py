"""`slip-to-roll compare BASELINE REPORT --worse-than 10%`: whether a report is worse than a baseline.

Each run of the baseline is compared with the run of the same case, solver, route and setting in REPORT. A run is worse
if it has no motion any more, if it is missing, or if its error (off) has grown by more than --worse-than, by more than
the doubts of both, and to more than 0.01 %. It is not decided if their doubts leave that open. Exit status: 0 if no run
is worse, 1 if one is, 3 if none is but some are not decided, and 2 with one sentence if the two cannot be compared.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from cases import BadValue
from cases.errors import choice, legible, not_negative, number_in
from cases.files.user_files import place

from . import options
from .compare_builds import read_table

COMMAND = "reports.gate"
FORMATS = ("text", "json", "junit")
# What identifies a run, and the further columns that are compared.
KEYS, VALUES = ("case", "solver", "route", "setting"), ("outcome", "off", "off_doubt")
# Smaller errors count as none: 4 digits, as in a ranking.
LEAST_OFF = 1e-4
# Exit status where no run is worse but some are not decided: a continuous integration can let it pass, or ask for runs
# with more samples.
OPEN = 3
_STATUSES = {"worse": 1, "not decided": OPEN}
# JUnit's element of a run that is neither better nor the same.
_ELEMENTS = {"worse": "failure", "not decided": "skipped"}


class RunChange(NamedTuple):
    """A run in two reports: "worse", "better", "same", "not decided" or "new", the errors (off) of both, and why."""

    case: str
    solver: str
    route: str
    setting: str
    change: str
    baseline: float
    now: float
    reason: str


class _Result(NamedTuple):
    outcome: str
    off: float
    doubt: float


def compare(baseline: Path, report: Path, tolerance: float, solvers: Sequence[str] = ()) -> list[RunChange]:
    """The runs of both reports, those of the baseline first; raises BadValue if they have no run in common.

    `tolerance`: the relative growth of off that is accepted. `solvers`: only these, by name; of all versions.
    """
    old, new = (_results(folder, solvers) for folder in (baseline, report))
    if not old.keys() & new.keys():
        raise BadValue(
            f"{baseline} and {report} have no run in common; build both with the same cases, solvers and settings"
        )
    changes = [RunChange(*key, *_change(result, new.get(key), tolerance)) for key, result in old.items()]
    nan = float("nan")
    return changes + [RunChange(*key, "new", nan, new[key].off, "") for key in new if key not in old]


def _change(old: _Result, new: _Result | None, tolerance: float) -> tuple[str, float, float, str]:
    """Change, both errors and the reason."""
    if new is None:
        change = "worse" if old.outcome == "answered" else "same"
        return change, old.off, float("nan"), "the run is missing"
    if old.outcome != "answered" or new.outcome != "answered":
        change = "same" if old.outcome == new.outcome else "worse" if old.outcome == "answered" else "better"
        return change, old.off, new.off, f"{old.outcome}, now {new.outcome}" if change != "same" else ""
    doubt, words = (
        old.doubt + new.doubt,
        "off {} ± {} %, now {} ± {} %".format(
            *(f"{100 * value:.3g}" for value in (old.off, old.doubt, new.off, new.doubt))
        ),
    )
    for name, before, after in (("worse", old.off, new.off), ("better", new.off, old.off)):
        if after - before > doubt and after > max(before * (1 + tolerance), LEAST_OFF):
            return name, old.off, new.off, words
    # The same numbers are the same motion, whatever its samples do not show.
    if old == new or new.off + doubt <= max(old.off * (1 + tolerance), LEAST_OFF):
        return "same", old.off, new.off, ""
    return "not decided", old.off, new.off, words


def _results(folder: Path, solvers: Sequence[str]) -> dict[tuple[str, str, str, str], _Result]:
    """The runs of a report by case, solver (without version), route and setting; raises BadValue."""
    file = folder / "tables" / "trajectories.csv"
    if not file.is_file():
        raise BadValue(f"{folder} contains no report; give a folder that `slip-to-roll report --out` wrote")
    frame = read_table(file, dtype=str, keep_default_na=False)
    missing = [name for name in (*KEYS, *VALUES) if name not in frame.columns]
    if missing:
        raise BadValue(f"{file} has no column {missing[0]}; give a report of version 0.2.0 or newer")
    frame["solver"] = [name.partition("@")[0] for name in frame["solver"]]
    unknown = sorted(set(solvers) - set(frame["solver"]))
    if unknown:
        raise BadValue(f"{folder} has no runs of the solver {unknown[0]}; its tables list the solvers it has")
    results = {}
    for row in frame.to_dict("records"):
        if not solvers or row["solver"] in solvers:
            case, solver, route, setting = (str(row[name]) for name in KEYS)
            off, doubt = _number(row["off"]), _number(row["off_doubt"])
            result = _Result(str(row["outcome"]), off, doubt if isfinite(doubt) else 0.0)
            results[case, solver, route, setting] = result
    return results


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


# --- output -----------------------------------------------------------------------------------------------------------


def as_text(changes: Sequence[RunChange]) -> str:
    """The changed runs, one per line, and the counts."""
    lines = [
        f"{run.change}: {run.case}, {run.solver} {run.route}, {run.setting}: {run.reason}"
        for run in changes
        if run.change in ("worse", "better", "not decided")
    ]
    counts = Counter(run.change for run in changes)
    lines.append(", ".join(f"{counts[name]} {name}" for name in ("worse", "better", "same", "not decided", "new")))
    return "\n".join(map(legible, lines))  # an untrusted report can contain any text


def as_json(changes: Sequence[RunChange]) -> str:
    """Counts and all runs; an error that is not known is null."""
    counts = Counter(run.change for run in changes)
    return options.json_of({"counts": counts, "runs": [run._asdict() for run in changes]})


def as_junit(changes: Sequence[RunChange]) -> str:
    """JUnit's XML: a test case for each run of the baseline, with a failure if it is worse; skipped if not decided."""
    runs = [run for run in changes if run.change != "new"]
    counts = Counter(run.change for run in runs)
    numbers = {"tests": len(runs), "failures": counts["worse"], "skipped": counts["not decided"]}
    suite = ElementTree.Element("testsuite", {name: str(number) for name, number in numbers.items()})
    suite.set("name", "slip-to-roll gate")
    for run in runs:
        name = legible(f"{run.case} {run.setting}")
        case = ElementTree.SubElement(suite, "testcase", classname=legible(f"{run.solver}.{run.route}"), name=name)
        if run.change in _ELEMENTS:
            ElementTree.SubElement(case, _ELEMENTS[run.change], message=legible(run.reason))
    return ElementTree.tostring(suite, encoding="unicode")


def tolerance_of(words: str) -> float:
    """A relative tolerance from text: 10% or 0.1; raises BadValue."""
    try:
        number = not_negative("--worse-than", number_in("--worse-than", words.removesuffix("%")))
    except BadValue:
        raise BadValue(f"--worse-than is {words[:40]!r}; give a share such as 10% or 0.1") from None
    return number / (100.0 if words.endswith("%") else 1.0)


def show(baseline: Path, report: Path, arguments: argparse.Namespace) -> int:
    """Print the changed runs as the options `worse_than`, `format` and `solver` ask; returns the exit status."""
    choice("--format", arguments.format, FORMATS)
    changes = compare(baseline, report, tolerance_of(arguments.worse_than), arguments.solver or ())
    print({"text": as_text, "json": as_json, "junit": as_junit}[arguments.format](changes))
    return max((_STATUSES.get(run.change, 0) for run in changes), key=(0, OPEN, 1).index, default=0)


@options.runs(
    COMMAND, "Whether a report is worse than a baseline: exit status 1 if it is, 3 if that is not decided.",
    "baseline", "solver", "worse_than", "format", words={"REPORT*": "the folder of a report (default: report)"},
    example=f"python -m {COMMAND} --baseline old --solver exudyn --worse-than 10% --format junit > gate.xml",
    worse_than="10%",
)  # fmt: skip
def main(arguments: argparse.Namespace, words: list[str]) -> int:
    """Run the command by its older name; returns its exit status."""
    if not arguments.baseline or len(arguments.REPORT) > 1:
        raise BadValue("give --baseline DIR, and at most one report to compare with it")
    report = place("report", (arguments.REPORT or ["report"])[0])
    return show(place("report", arguments.baseline), report, arguments)


if __name__ == "__main__":
    sys.exit(main())
