"""`python -m reports.compare_builds A B`: what differs between two reports, of two machines, two versions or two days.

Accuracies must be the same to the last digit where code and machine are; times may not, and only what neither report's
interval allows is told. Exit status: 0 if nothing differs, 3 if something does, 2 if the two cannot be compared.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cases import BadValue
from cases.command_line import status
from cases.user_files import place, text

from . import options
from .running.records import legible

if TYPE_CHECKING:
    import pandas as pd

COMMAND = "reports.compare_builds"

# What names a row of each table that is compared, and the columns that depend on the machine's day.
_ROWS = {
    "headline": ("case", "solver", "route"),
    "trajectories": ("case", "solver", "route", "setting"),
    "transitions": ("case", "solver", "route", "setting", "event", "before", "after", "verdict", "_number"),
    "convergence": ("case", "solver", "route", "quantity"),
    "truth": ("case", "event"),
    "work_precision": ("case", "solver", "route", "setting", "quantity"),
    "work_precision_fits": ("case", "solver", "route", "quantity"),
    "null_scores": ("case", "motion"),
}
_OF_THE_DAY = {
    "cpu_s", "cpu_low_s", "cpu_high_s", "wall_s", "setup_s", "compile_s", "read_s", "call_s", "first_call_s",
    "engine_s", "binding_s", "callback_s", "notes_s", "repeats", "disturbed_repeats", "disturbed", "run_at",
    "order_in_time", "order_in_time_low", "order_in_time_high",
    "version",  # told for all of a report
}  # fmt: skip
_TIMED = ("case", "quantity", "accuracy", "solver", "route")
# The numbers of `time_to_accuracy` that are compared.
_RATIOS = ("ratio", "ratio_low", "ratio_high", "rank")
# Bytes of a file of a report: a full one's largest table has a tenth of it.
_LARGEST = 100 * 2**20
# Differences of a kind that are told one by one; beyond it they are counted.
_SHOWN = 12


class Difference(NamedTuple):
    """Where two reports differ: the table, the row, the column, and both values."""

    table: str
    row: str
    column: str
    one: Any
    other: Any


class BuildComparison(NamedTuple):
    """Accuracies that changed; awards, ratios outside both intervals and ranks that changed; and of how many ratios."""

    accuracies: list[Difference]
    awards: list[Difference]
    ratios: list[Difference]
    ranks: list[Difference]
    compared: int

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not (self.accuracies or self.awards or self.ratios or self.ranks)


def compare(one: Path, other: Path, solvers: Sequence[str] = ()) -> BuildComparison:
    """What differs between the reports in two folders, or between one of two `solvers` in the first and the other in
    the second, as if they had one name. Raises BadValue for a folder that holds no report or not the solver."""
    frames = [_tables(one), _tables(other)]
    if solvers:
        both = " | ".join(solvers)
        frames = [
            _of_solver(f, name, folder, both) for f, name, folder in zip(frames, solvers, (one, other), strict=True)
        ]
    accuracies = [d for name, keys in _ROWS.items() for d in _accuracies(name, keys, *(f.get(name) for f in frames))]
    pairs = _pairs(_TIMED, *(f.get("time_to_accuracy") for f in frames))
    awards, ratios, ranks, compared = [], [], [], 0
    for row, a, b in pairs:
        summary_lines = ("time_to_accuracy", row)
        if _stands(a) != _stands(b):
            awards.append(Difference(*summary_lines, "award", a["award"], b["award"]))
        if a["ratio_low"] == a["ratio_low"] and b["ratio_low"] == b["ratio_low"]:  # NaN is not itself
            compared += 1
            if a["ratio_low"] > b["ratio_high"] or b["ratio_low"] > a["ratio_high"]:
                ratios.append(Difference(*summary_lines, "ratio", a["ratio"], b["ratio"]))
        if a["rank"] != b["rank"] and a["rank"] == a["rank"] and b["rank"] == b["rank"]:
            ranks.append(Difference(*summary_lines, "rank", a["rank"], b["rank"]))
    return BuildComparison(accuracies, awards, ratios, ranks, compared)


def _stands(row: dict[str, Any]) -> str:
    """What accuracy alone decides of an award: whether there is a time for it is the day's."""
    return "reached" if row["award"] in ("reached", "not timed", "disturbed") else row["award"]


def _tables(folder: Path) -> dict[str, pd.DataFrame]:
    import pandas as pd

    files = sorted((folder / "tables").glob("*.csv"))
    if not files or not (folder / "manifest.json").is_file():
        raise BadValue(f"{folder} holds no report; give a folder that `python -m reports.build --out` wrote")
    frames: dict[str, pd.DataFrame] = {}
    for file in files:
        # Read as text nothing is rounded, and an empty cell equals an empty cell.
        kind = str if file.stem in _ROWS else None
        content = StringIO(text("table", file, _LARGEST))
        try:
            frame = pd.read_csv(content, keep_default_na=file.stem == "time_to_accuracy", dtype=kind)
        except (ValueError, OverflowError, RecursionError) as problem:
            raise BadValue(f"{file} cannot be read as comma-separated values: {problem}") from problem
        _check_columns(file, frame)
        frames[file.stem] = frame
    return frames


def _check_columns(file: Path, frame: pd.DataFrame) -> None:
    """Raises BadValue for a table without the columns that are compared, or with words where its numbers stand."""
    from pandas.api.types import is_numeric_dtype

    timed = file.stem == "time_to_accuracy"
    needed = (*_TIMED, "award", *_RATIOS) if timed else _ROWS.get(file.stem, ())
    missing = [name for name in needed if name not in frame.columns and name != "_number"]
    if missing:
        raise BadValue(f"{file} has no column {missing[0]}; give a report of this suite")
    words = [name for name in _RATIOS if timed and not is_numeric_dtype(frame[name])]
    if words:
        raise BadValue(f"{words[0]} in {file} is not a number all along; give a report of this suite")


def _of_solver(frames: dict[str, pd.DataFrame], name: str, folder: Path, called: str) -> dict[str, pd.DataFrame]:
    """A solver's rows of the tables that have a column for it, under another name."""
    found = {}
    for table, frame in frames.items():
        if "solver" in frame.columns:
            found[table] = frame[frame["solver"] == name].assign(solver=called)
    if all(frame.empty for frame in found.values()):
        raise BadValue(f"{folder} has nothing of the solver {name}; its tables tell which it has")
    return found


def _pairs(
    keys: Sequence[str], one: pd.DataFrame | None, other: pd.DataFrame | None
) -> list[tuple[str, dict[str, Any], dict[str, Any]]]:
    """The rows of both tables that have the same keys, with those in words."""
    found = [_by_keys(keys, frame) for frame in (one, other)]
    return [(", ".join(map(str, key)), found[0][key], found[1][key]) for key in found[0] if key in found[1]]


def _by_keys(keys: Sequence[str], frame: pd.DataFrame | None) -> dict[tuple, dict[str, Any]]:
    """Rows by their keys; `_number` tells apart those that have the others in common."""
    rows: dict[tuple, dict[str, Any]] = {}
    for row in [] if frame is None else frame.to_dict("records"):
        key = tuple(row[k] for k in keys if k != "_number")
        number = 1
        while (*key, number) in rows:
            number += 1
        rows[(*key, number)] = {str(name): value for name, value in row.items()}
    return {key if key[-1] > 1 else key[:-1]: row for key, row in rows.items()}


def _accuracies(
    name: str, keys: Sequence[str], one: pd.DataFrame | None, other: pd.DataFrame | None
) -> list[Difference]:
    """Cells that differ, of rows in both; and rows that only one has."""
    if one is None or other is None:
        return []  # it was made with --quick, or for one case: what it does not have is not compared
    first, second = _by_keys(keys, one), _by_keys(keys, other)
    found = [Difference(name, ", ".join(map(str, k)), "row", "there", "missing") for k in first if k not in second]
    found += [Difference(name, ", ".join(map(str, k)), "row", "missing", "there") for k in second if k not in first]
    columns = [c for c in one.columns if c in other.columns and c not in _OF_THE_DAY and c not in keys]
    for row, a, b in _pairs(keys, one, other):
        found += [Difference(name, row, c, a[c], b[c]) for c in columns if a[c] != b[c]]
    return found


# --- in words ---------------------------------------------------------------------------------------------------------


def summary_lines(comparison: BuildComparison, one: Path, other: Path, solvers: Sequence[str] = ()) -> str:
    """The comparison as text: first what the reports were made with, where that differs."""
    names = [f", {name}" for name in solvers] or ["", ""]
    lines = [f"A: {one}{names[0]}", f"B: {other}{names[1]}", *_provenance(one, other)]
    parts = {
        "accuracies that changed": comparison.accuracies,
        "awards that changed": comparison.awards,
        f"ratios outside both intervals, of {comparison.compared}": comparison.ratios,
        "ranks that changed": comparison.ranks,
    }
    for title, found in parts.items():
        lines.append(f"{title}: {len(found) or 'none'}")
        lines += [f"  {d.table}, {d.row}: {d.column} {_short(d.one)} | {_short(d.other)}" for d in found[:_SHOWN]]
        if len(found) > _SHOWN:
            lines.append(f"  … and {len(found) - _SHOWN} more")
    return "\n".join(map(legible, lines))  # a stranger's report may say anything


def _short(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value) or "(empty)"


def _provenance(one: Path, other: Path) -> list[str]:
    """What differs in how the two were made."""
    manifests = [_manifest(folder / "manifest.json") for folder in (one, other)]
    names = ("commit", "machine", "python", "solvers", "packages", "settings")
    values = [{name: m.get(name) for name in names} for m in manifests]
    return [f"{n}: {values[0][n]} | {values[1][n]}" for n in names if values[0][n] != values[1][n]]


def _manifest(file: Path) -> dict[str, Any]:
    try:
        summary_lines = json.loads(text("manifest", file, _LARGEST))
    except (json.JSONDecodeError, RecursionError) as problem:
        raise BadValue(f"{file} is no JSON: {problem}; give a report of this suite") from problem
    if not isinstance(summary_lines, dict):
        raise BadValue(f"{file} says nothing of a report; give a report of this suite")
    return summary_lines


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit status."""

    def work(words: list[str]) -> int:
        positional = {"A": "the folder of a report", "B": "the folder of another"}
        parser = options.parser(
            COMMAND, "Say what differs between two reports, or between two solvers.", "solver", words=positional,
            example=f"python -m {COMMAND} report report --solver pymunk@6.11.1 --solver pymunk@7.3.1",
        )  # fmt: skip
        given = parser.parse_args(words)
        one, other, solvers = place("report", given.A), place("report", given.B), given.solver or ()
        if len(solvers) not in (0, 2):
            raise BadValue("--solver is given twice, once for A and once for B, or not at all")
        comparison = compare(one, other, solvers)
        print(summary_lines(comparison, one, other, solvers))
        return 0 if comparison.same else 3

    return status(COMMAND, work, argv)


if __name__ == "__main__":
    sys.exit(main())
