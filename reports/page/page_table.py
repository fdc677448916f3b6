"""A table of the page: headings and rows of cells, and such a table of a frame."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..analysis import tables
from ..analysis.columns import is_in_percent, unit_of
from ..analysis.number_format import number
from ..judging.grades import Grade
from .fragments import records, switch, verbatim
from .text import shorten

if TYPE_CHECKING:
    import pandas as pd

_REMARKS = ("reason", "note", "notes")
# Rows of a long table that are shown at first and in print; the length up to which a table is whole, a page in print.
FIRST_ROWS, WHOLE = 8, 50
# The most columns of a table, for a window 1440 pixels wide.
_WIDEST = 12
# Longer texts may be broken within a word.
_LONG = 40
# The unit at the end of a description.
_UNIT = re.compile(r"(?:, | \()(s|m|rad|m/s|m²|J|N|kg|MB|%)\)?$")
_LONGEST_UNIT = 5
# Words of a table with their own colours.
_WITH_COLOUR = (*tables.OUTCOMES, *Grade, "paired", "missed", "spurious", "unresolved")
# The digits of a sort key, which are also those that are copied.
_DIGITS = 10
LAST = "1e308"


class Cell(NamedTuple):
    """A cell: its text, the number by which it is sorted (None: its text), its classes, its tooltip, and the address to
    which it leads."""

    text: str
    order: str | None = None
    kind: str = ""
    tip: str = ""
    link: str = ""


class Head(NamedTuple):
    """The heading of a column: title, unit, column of the file, whether it holds numbers, tooltip; solver and route if
    the whole column is one route's."""

    title: str
    unit: str = ""
    column: str = ""
    number: bool = False
    tip: str = ""
    solver: str = ""
    route: str = ""


class PageRow(NamedTuple):
    """A row: its cells, its solver and route for the page's switches, its tooltip, and the group it belongs to."""

    cells: Sequence[Cell]
    solver: str = ""
    route: str = ""
    tip: str = ""
    group: str = ""


@dataclass(frozen=True)
class PageTable:
    """A table, its `name`, its classes, and its `file`, which has `count` rows and `columns` columns."""

    name: str
    heads: Sequence[Head]
    rows: Sequence[PageRow]
    kind: str = ""
    file: str = ""
    count: int = 0
    columns: int = 0


def number_cell(text: str, value: float, kind: str = "", tip: str = "") -> Cell:
    """A cell that is sorted by a number; a cell without one is sorted last."""
    order = f"{value:.{_DIGITS}g}" if isfinite(value) else LAST
    return Cell(text, order, f"number {kind}".rstrip(), tip)


def table(
    name: str,
    frame: pd.DataFrame,
    columns: Mapping[str, str],
    words: Mapping[str, str] | None = None,
    file: str = "",
    most: int | None = None,
) -> PageTable:
    """Some columns of a frame.

    A column's description is its tooltip. A number whose text a program cannot read, such as 1,700, has a sort key.
    Columns of remarks that are empty in all rows are omitted, of a wide table also those beyond `_WIDEST`. A long table
    has its first rows, or `most`; a script gets the others from its `file` inside the page.
    """
    columns = {c: title for c, title in columns.items() if c not in _REMARKS or any(frame[c].astype(bool))}
    visible = columns if len(columns) <= _WIDEST else _narrowed(frame, columns)
    numeric = {c for c in visible if len(frame) and all(isinstance(v, int | float | np.number) for v in frame[c])}
    heads = [_head(c, title, c in numeric, (words or {}).get(c, "")) for c, title in visible.items()]
    top = frame.head((len(frame) if len(frame) <= WHOLE else FIRST_ROWS) if most is None else most)
    rows = []
    for row in records(top):
        solver, route = str(row.get("solver", "")), str(row.get("route", ""))
        rows.append(PageRow([_cell(row[c], c, c in numeric) for c in visible], solver, switch(solver, route)))
    return PageTable(name, heads, rows, file=file, count=len(frame), columns=len(columns))


def _narrowed(frame: pd.DataFrame, columns: Mapping[str, str]) -> dict[str, str]:
    """The first columns whose values differ."""
    varied = [c for c in columns if len(frame) < 2 or frame[c].astype(str).nunique() > 1]
    return {c: columns[c] for c in varied[:_WIDEST]}


def _head(column: str, title: str, is_number: bool, description: str) -> Head:
    """The heading of a column: its name, and its unit if the dictionary or its description ends with one."""
    match = _UNIT.search(description)
    unit = unit_of(column) or (match[1] if match else "")
    unit = "%" if is_in_percent(column) else unit if len(unit) <= _LONGEST_UNIT and unit != "1" else ""
    return Head(title.removesuffix(f" {unit}") if unit else title, unit, column, is_number, description)


def _cell(value: Any, column: str, numeric: bool) -> Cell:
    if numeric and is_in_percent(column):
        return number_cell(number(100.0 * value) if isfinite(value) else "", value)
    text = shorten(value, column)
    if numeric:
        text = verbatim(text)
        return Cell(text, kind="number") if _is_number(text) else number_cell(text, value)
    if text in _WITH_COLOUR:
        return Cell(text, kind=text.replace(" ", "-"))
    if "setting" in column:
        return Cell(text, kind="setting")
    return Cell(text, kind="reason" if column in _REMARKS or len(text) > _LONG else "")


def _is_number(text: str) -> bool:
    """Whether the text is empty or parses as a number, so that it can be sorted by its text."""
    try:
        float(text or "0")
    except ValueError:
        return False
    return True
