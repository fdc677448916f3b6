"""`slip-to-roll compare A B`: differences between two reports, of two machines, versions or days.

With the same code and machine, grades and errors must be equal to the last digit. Times vary; only differences outside
both reports' intervals are shown.
Exit status: 0 if nothing differs, 3 if something does, 2 if the two cannot be compared, as one of version 0.1.0 with a
later one.
"""

from __future__ import annotations

import json
import sys
from argparse import Namespace
from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cases import BadValue
from cases.errors import legible
from cases.files.user_files import place, text

from . import options

if TYPE_CHECKING:
    import pandas as pd

COMMAND = "reports.compare_builds"

# Columns that vary from build to build.
_OF_THE_DAY = {
    "cpu_s", "cpu_low_s", "cpu_high_s", "wall_s", "setup_s", "compile_s", "read_s", "call_s", "first_call_s",
    "engine_s", "binding_s", "callback_s", "notes_s", "repeats", "disturbed_repeats", "disturbed", "run_at",
    "order_in_time", "order_in_time_low", "order_in_time_high", "good_first_s", "good_thousand_s",
    "version",  # shown for the whole report
}  # fmt: skip
_TIMING_KEYS = ("case", "level", "solver", "route")
# The numbers of `time_to_accuracy` that are compared.
_RATIOS = ("ratio", "ratio_low", "ratio_high", "rank")
# Size limit of a file of a report in bytes: the largest table of a full one has a tenth of it.
_LARGEST = 100 * 2**20
# Largest number of differences of a kind that are listed; the others are counted.
_MOST_LINES = 12


class Difference(NamedTuple):
    """Where two reports differ: the table, the row, the column, and both values."""

    table: str
    row: str
    column: str
    one: Any
    other: Any


class BuildComparison(NamedTuple):
    """Changed results and levels reached, ratios outside both intervals, changed ranks, and the number of ratios."""

    results: list[Difference]
    levels: list[Difference]
    ratios: list[Difference]
    ranks: list[Difference]
    ratio_count: int

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not (self.results or self.levels or self.ratios or self.ranks)


def compare(one: Path, other: Path, solvers: Sequence[str] = ()) -> BuildComparison:
    """Compare the reports in two folders, or one of two `solvers` in the first with the other in the second.

    Raises BadValue for a folder without a report or without the solver, and for reports of two formats."""
    for folder in (one, other):
        if not list((folder / "tables").glob("*.csv")) or not (folder / "manifest.json").is_file():
            raise BadValue(f"{folder} contains no report; give a folder that `slip-to-roll report --out` wrote")
    formats = [_manifest(folder / "manifest.json").get("format", 1) for folder in (one, other)]
    if formats[0] != formats[1]:
        raise BadValue(f"{one} has the format {formats[0]} and {other} {formats[1]}; build the older one again")
    frames = [_tables(folder) for folder in (one, other)]
    if solvers:
        both = " | ".join(solvers)
        frames = [
            _of_solver(f, name, folder, both) for f, name, folder in zip(frames, solvers, (one, other), strict=True)
        ]
    results = [d for name, keys in _keys().items() for d in _changed_cells(name, keys, *(f.get(name) for f in frames))]
    pairs = _pairs(_TIMING_KEYS, *(f.get("time_to_accuracy") for f in frames))
    levels, ratios, ranks, ratio_count = [], [], [], 0
    for row, a, b in pairs:
        place = ("time_to_accuracy", row)
        if _is_reached(a) != _is_reached(b):
            levels.append(Difference(*place, "reached", a["reached"], b["reached"]))
        if a["ratio_low"] == a["ratio_low"] and b["ratio_low"] == b["ratio_low"]:  # NaN is not itself
            ratio_count += 1
            if a["ratio_low"] > b["ratio_high"] or b["ratio_low"] > a["ratio_high"]:
                ratios.append(Difference(*place, "ratio", a["ratio"], b["ratio"]))
        if a["rank"] != b["rank"] and a["rank"] == a["rank"] and b["rank"] == b["rank"]:
            ranks.append(Difference(*place, "rank", a["rank"], b["rank"]))
    return BuildComparison(results, levels, ratios, ranks, ratio_count)


def _keys() -> dict[str, tuple[str, ...]]:
    """The key columns of each compared table."""
    from .analysis.table_list import TABLES

    return {name: table.keys for name, table in TABLES.items() if table.keys}


def _is_reached(row: dict[str, Any]) -> bool:
    """Whether a level is reached, with or without a time: whether it has one varies from build to build."""
    return row["reached"] not in ("not reached", "not known")


def _tables(folder: Path) -> dict[str, pd.DataFrame]:
    """The tables of a report."""
    frames: dict[str, pd.DataFrame] = {}
    for file in sorted((folder / "tables").glob("*.csv")):
        # Read as text, so that nothing is rounded and empty cells are equal.
        kind = str if file.stem in _keys() else None
        frames[file.stem] = read_table(file, keep_default_na=file.stem == "time_to_accuracy", dtype=kind)
        _check_columns(file, frames[file.stem])
    return frames


def read_table(file: Path, **how: Any) -> pd.DataFrame:
    """A table of an untrusted report, read as pandas does with these options; raises BadValue."""
    import pandas as pd

    content = StringIO(text("table", file, _LARGEST))
    try:
        return pd.read_csv(content, **how)
    except (ValueError, OverflowError, RecursionError) as problem:
        raise BadValue(f"{file} cannot be read as comma-separated values: {problem}") from problem


def _check_columns(file: Path, frame: pd.DataFrame) -> None:
    """Raises BadValue for a table without the compared columns, or with text in columns of numbers."""
    from pandas.api.types import is_numeric_dtype

    is_timing_table = file.stem == "time_to_accuracy"
    columns = (*_TIMING_KEYS, "reached", *_RATIOS) if is_timing_table else _keys().get(file.stem, ())
    missing = [name for name in columns if name not in frame.columns and name != "_number"]
    if missing:
        raise BadValue(f"{file} has no column {missing[0]}; give a report of this suite")
    words = [name for name in _RATIOS if is_timing_table and not is_numeric_dtype(frame[name])]
    if words:
        raise BadValue(f"{words[0]} in {file} is not a column of numbers; give a report of this suite")


def _of_solver(frames: dict[str, pd.DataFrame], name: str, folder: Path, label: str) -> dict[str, pd.DataFrame]:
    """The rows of a solver in all tables with a column `solver`, under another name."""
    tables = {}
    for table, frame in frames.items():
        if "solver" in frame.columns:
            tables[table] = frame[frame["solver"] == name].assign(solver=label)
    if all(frame.empty for frame in tables.values()):
        raise BadValue(f"{folder} has no rows of the solver {name}; its tables list the solvers it has")
    return tables


def _pairs(
    keys: Sequence[str], one: pd.DataFrame | None, other: pd.DataFrame | None
) -> list[tuple[str, dict[str, Any], dict[str, Any]]]:
    """The rows of both tables with the same keys, each with its key as text."""
    rows = [_by_keys(keys, frame) for frame in (one, other)]
    return [(", ".join(map(str, key)), rows[0][key], rows[1][key]) for key in rows[0] if key in rows[1]]


def _by_keys(keys: Sequence[str], frame: pd.DataFrame | None) -> dict[tuple, dict[str, Any]]:
    """Rows by their keys; `_number` distinguishes rows whose other keys are equal."""
    rows: dict[tuple, dict[str, Any]] = {}
    for row in [] if frame is None else frame.to_dict("records"):
        key = tuple(row[k] for k in keys if k != "_number")
        number = 1
        while (*key, number) in rows:
            number += 1
        rows[(*key, number)] = {str(name): value for name, value in row.items()}
    return {key if key[-1] > 1 else key[:-1]: row for key, row in rows.items()}


def _changed_cells(
    name: str, keys: Sequence[str], one: pd.DataFrame | None, other: pd.DataFrame | None
) -> list[Difference]:
    """Cells that differ in rows of both tables, and rows that only one table has."""
    if one is None or other is None:
        return []  # reports with --quick or of one case lack tables; these are not compared
    first, second = _by_keys(keys, one), _by_keys(keys, other)
    differences = [
        Difference(name, ", ".join(map(str, k)), "row", "there", "missing") for k in first if k not in second
    ]
    differences += [
        Difference(name, ", ".join(map(str, k)), "row", "missing", "there") for k in second if k not in first
    ]
    columns = [c for c in one.columns if c in other.columns and c not in _OF_THE_DAY and c not in keys]
    for row, a, b in _pairs(keys, one, other):
        differences += [Difference(name, row, c, a[c], b[c]) for c in columns if a[c] != b[c]]
    return differences


# --- as text ----------------------------------------------------------------------------------------------------------


def summary_lines(comparison: BuildComparison, one: Path, other: Path, solvers: Sequence[str] = ()) -> str:
    """The comparison as text, after differences in how the reports were made."""
    names = [f", {name}" for name in solvers] or ["", ""]
    lines = [f"A: {one}{names[0]}", f"B: {other}{names[1]}", *_provenance(one, other)]
    lines += _only_in_one(one, other)
    parts = {
        "results that changed": comparison.results,
        "levels reached that changed": comparison.levels,
        f"ratios outside both intervals, of {comparison.ratio_count}": comparison.ratios,
        "ranks that changed": comparison.ranks,
    }
    for title, differences in parts.items():
        lines.append(f"{title}: {len(differences) or 'none'}")
        lines += [
            f"  {d.table}, {d.row}: {d.column} {_short(d.one)} | {_short(d.other)}" for d in differences[:_MOST_LINES]
        ]
        if len(differences) > _MOST_LINES:
            lines.append(f"  … and {len(differences) - _MOST_LINES} more")
    return "\n".join(map(legible, lines))  # an untrusted report can contain any text


def _as_dict(comparison: BuildComparison) -> dict[str, Any]:
    """The comparison for JSON: each difference by names."""
    lists = {
        name: [d._asdict() for d in value] for name, value in comparison._asdict().items() if isinstance(value, list)
    }
    return {**lists, "ratio_count": comparison.ratio_count}


def _short(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value) or "(empty)"


def _provenance(one: Path, other: Path) -> list[str]:
    """Differences in how the two reports were made."""
    manifests = [_manifest(folder / "manifest.json") for folder in (one, other)]
    names = ("commit", "machine", "python", "solvers", "packages", "settings")
    values = [{name: m.get(name) for name in names} for m in manifests]
    return [f"{n}: {values[0][n]} | {values[1][n]}" for n in names if values[0][n] != values[1][n]]


def _only_in_one(one: Path, other: Path) -> list[str]:
    """The tables that only one of the reports has: those are not compared."""
    names = [{file.stem for file in (folder / "tables").glob("*.csv")} & _keys().keys() for folder in (one, other)]
    lacking = {"A": names[1] - names[0], "B": names[0] - names[1]}
    return [
        f"{report} has no table {', '.join(sorted(tables))}: not compared"
        for report, tables in lacking.items()
        if tables
    ]


def _manifest(file: Path) -> dict[str, Any]:
    try:
        manifest = json.loads(text("manifest", file, _LARGEST))
    except (json.JSONDecodeError, RecursionError) as problem:
        raise BadValue(f"{file} is not JSON: {problem}; give a report of this suite") from problem
    if not isinstance(manifest, dict):
        raise BadValue(f"{file} is not the manifest of a report; give a report of this suite")
    return manifest


def show(one: Path, other: Path, arguments: Namespace) -> int:
    """Print the differences between two reports as the options `solver` and `format` ask; returns the exit status."""
    solvers = arguments.solver or ()
    if len(solvers) not in (0, 2):
        raise BadValue("give --solver twice, once for A and once for B, or not at all")
    comparison = compare(one, other, solvers)
    if options.is_json(arguments):
        print(options.json_of(_as_dict(comparison)))
    else:
        print(summary_lines(comparison, one, other, solvers))
    return 0 if comparison.same else 3


@options.runs(
    COMMAND, "Show the differences between two reports, or between two solvers.", "solver", "format",
    words={"A": "the folder of a report", "B": "the folder of another"},
    example=f"python -m {COMMAND} report report --solver pymunk@6.11.1 --solver pymunk@7.3.1",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> int:
    """Run the command by its older name; returns its exit status."""
    return show(place("report", arguments.A), place("report", arguments.B), arguments)


if __name__ == "__main__":
    sys.exit(main())
