"""Tables as files: comma-separated values with all rows and digits, and the dictionary of their columns: `columns.md`
for readers, `datapackage.json` for programs (a Data Package: https://datapackage.org/standard/data-package/, each table
a resource with its schema)."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from decimal import ROUND_UP, Context
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cases.errors import printable

from ..analysis.columns import Table, describe_column, infinite, unit_of, with_version
from ..analysis.table_list import TABLES, Results, frames

if TYPE_CHECKING:
    import pandas as pd

    from ..studies import Result


class Tables(NamedTuple):
    """The tables of a report by name, and their descriptions."""

    frames: dict[str, pd.DataFrame]
    words: dict[str, Table]


def of_report(results: Results, study_results: Sequence[Result], versions: Mapping[str, str]) -> Tables:
    """All tables of a report and of its studies, with versions and short numbers. `versions`: of the solvers."""
    tables = dict(frames(results))
    words = {name: result.words[name] for result in study_results for name in result.frames}
    for result in study_results:
        tables.update(result.frames)
    complete = {name: with_short_numbers(with_version(frame, versions)) for name, frame in tables.items()}
    own = {n: describe_column(TABLES[n].holds, map(str, f.columns)) for n, f in complete.items() if n not in words}
    return Tables(complete, own | words)


def write(tables: Tables, folder: Path, command: str) -> list[Path]:
    """Write each table as NAME.csv, and their dictionary; returns the files. `command` makes them again. Raises
    ValueError for an infinite result, or for a column without description."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, frame in tables.frames.items():
        if infinite(frame):
            where = ", ".join(infinite(frame))
            raise ValueError(f"the table {name} has an infinite result in {where}; use a word instead")
        missing = [str(c) for c in frame.columns if not tables.words[name].columns.get(str(c))]
        if missing:
            raise ValueError(f"no description of {', '.join(missing)} in the table {name}")
        inert(frame).to_csv(folder / f"{name}.csv", index=False, errors="backslashreplace")
    resources = [_resource(name, frame, tables.words[name]) for name, frame in tables.frames.items()]
    package = json.dumps({"name": "slip-to-roll-tables", "resources": resources}, indent=1, ensure_ascii=False)
    texts = {"columns.md": _for_people(*tables, command), "datapackage.json": package + "\n"}
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in (*(f"{name}.csv" for name in tables.frames), *texts)]


# Text that a spreadsheet reads as a formula, with the white space that it skips.
_FORMULA = re.compile(r"\s*[=+\-@]")


def inert(frame: pd.DataFrame) -> pd.DataFrame:
    """The table with an apostrophe before each text that a spreadsheet would evaluate, and without characters that a
    terminal acts on; texts of numbers stay as is."""
    texts = [column for column in frame.columns if frame[column].dtype == object or str(frame[column].dtype) == "str"]
    return frame.assign(**{column: [_inert(value) for value in frame[column]] for column in texts})


def _inert(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    value = printable(value)
    if not _FORMULA.match(value):
        return value
    try:
        float(value)
    except ValueError:
        return f"'{value}"
    return value


def _for_people(tables: Mapping[str, pd.DataFrame], words: Mapping[str, Table], command: str) -> str:
    parts = ["# What the columns mean\n\nEmpty: not measured or not applicable.\n"]
    for name, frame in tables.items():
        rows = "".join(f"- `{c}`: {words[name].columns[str(c)]}\n" for c in frame.columns)
        parts.append(f"## {name}.csv\n\n{words[name].holds}.\n\n{rows}")
    return "\n".join(parts) + f"\nMake it again: `{command}`\n"


def _resource(name: str, frame: pd.DataFrame, words: Table) -> dict[str, Any]:
    fields = []
    for column in map(str, frame.columns):
        field = {"name": column, "type": kind(frame[column]), "description": words.columns[column]}
        # The standard has no property for units, but allows additional properties.
        fields.append(field | ({"unit": unit_of(column)} if unit_of(column) else {}))
    return {
        "name": name,
        "path": f"{name}.csv",
        "format": "csv",
        "mediatype": "text/csv",
        "encoding": "utf-8",
        "description": words.holds,
        "schema": {"fields": fields, "missingValues": [""]},
    }


def kind(values: pd.Series) -> str:
    """The type of a column by the standard's names: boolean, integer, number or string."""
    if not len(values):
        return "string"
    if all(isinstance(v, bool | np.bool_) for v in values):
        return "boolean"
    if all(isinstance(v, int | np.integer) for v in values):
        return "integer"
    return "number" if all(isinstance(v, int | float | np.number) for v in values) else "string"


# A column in seconds of the motion, not of the computer.
_OF_MOTIONS = {"end_s"}
# Columns that say how uncertain a number is; errors and scores keep all digits.
_UNCERTAINTIES = {"truth_error_bar", "floor_error", "reading_doubt", "doubt"}
# Decimal arithmetic to four digits that never makes an error bar smaller.
_UPWARDS = Context(prec=4, rounding=ROUND_UP)


def with_short_numbers(frame: pd.DataFrame) -> pd.DataFrame:
    """The table with its computing times to six digits and its uncertainties to four, rounded up: the other digits are
    noise, and a tenth of the tables.

    A column may hold other values than numbers, as a solver returned them: these stay.
    """

    def short_time(value: Any) -> Any:
        return float(f"{value:.6g}") if isinstance(value, float) else value

    def short_bar(value: Any) -> Any:
        is_number = isinstance(value, float) and isfinite(value)
        return float(_UPWARDS.create_decimal(repr(float(value)))) if is_number else value

    names = [str(c) for c in frame.columns]
    short = {name: frame[name].map(short_time) for name in names if name.endswith("_s") and name not in _OF_MOTIONS}
    return frame.assign(**short, **{name: frame[name].map(short_bar) for name in names if name in _UNCERTAINTIES})
