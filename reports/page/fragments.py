"""Elements of the page: templates, figures, tables, and the command that reproduces them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ..analysis import tables
from ..analysis.columns import is_in_percent, unit_of
from ..analysis.number_format import number
from ..drawing import svg_writer
from ..drawing.colours import LineStyles
from ..drawing.figure_files import short_digest
from ..drawing.traces import Diagram
from ..judging.grades import Grade
from ..running.names import REFERENCE
from .text import shorten

if TYPE_CHECKING:
    import pandas as pd

_TEMPLATES = Path(__file__).parent / "templates"
_POWER, _ZERO = re.compile(r"(\d)e([+-])0(\d)\b"), re.compile(r"\b0\.0e\+00\b")
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


@lru_cache(maxsize=1)
def environment() -> Environment:
    """The templates of the page; all text is escaped, and an undefined name is an error."""
    loader = FileSystemLoader(_TEMPLATES)
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a frame as dictionaries with text keys."""
    return [{str(column): value for column, value in row.items()} for row in frame.to_dict("records")]


def command_of(label: str, manifest: dict[str, Any]) -> str:
    """The command that reproduces one case's figures and tables; with an empty label, those of all cases."""
    if not label:
        return manifest["command"]
    return f'python -m reports.build {manifest["options"]} --case "{label}"'.replace("  ", " ")


def anchor(label: str) -> str:
    """The HTML anchor of a case on the page; with a digest of the label where characters of it are replaced, so that no
    two cases have the same."""
    readable = "".join(c if c.isalnum() or c == "_" else "-" for c in label)
    return f"case-{readable}" if readable == label else f"case-{readable.strip('-')}-{short_digest(label)}"


def figure_of(diagram: Diagram | None, looks: LineStyles, height: float = 210.0) -> dict[str, Any] | None:
    """Data of a figure for its template; None for none."""
    if diagram is None:
        return None
    words = {"title": diagram.title, "caption": diagram.caption}
    return words | {"svg": svg_writer.svg(diagram, looks, height)}


def table(
    frame: pd.DataFrame,
    columns: Mapping[str, str],
    words: Mapping[str, str] | None = None,
    file: str = "",
    most: int | None = None,
) -> dict[str, Any]:
    """Headings and rows of some columns for the template.

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
        cells = [_cell(row[c], c, c in numeric) for c in visible]
        rows.append(
            {
                "solver": str(row.get("solver", "")),
                "route": switch(str(row.get("solver", "")), str(row.get("route", ""))),
                "cells": cells,
            }
        )
    counts = {"count": len(frame), "columns": len(columns)}
    return {"heads": heads, "rows": rows, "file": file, **counts}


def _narrowed(frame: pd.DataFrame, columns: Mapping[str, str]) -> dict[str, str]:
    """The first columns whose values differ."""
    varied = [c for c in columns if len(frame) < 2 or frame[c].astype(str).nunique() > 1]
    return {c: columns[c] for c in varied[:_WIDEST]}


def _head(column: str, title: str, is_number: bool, description: str) -> dict[str, Any]:
    """The heading of a column: its name, and its unit if the dictionary or its description ends with one."""
    match = _UNIT.search(description)
    unit = unit_of(column) or (match[1] if match else "")
    unit = "%" if is_in_percent(column) else unit if len(unit) <= _LONGEST_UNIT and unit != "1" else ""
    return {
        "title": title.removesuffix(f" {unit}") if unit else title,
        "unit": unit,
        "column": column,
        "number": is_number,
        "tip": description,
    }


def verbatim(text: str) -> str:
    """A number's text in its short form: 1.1e-7 and 0, not 1.1e-07 and 0.0e+00."""
    return _POWER.sub(lambda m: f"{m[1]}e{m[2].removeprefix('+')}{m[3]}", _ZERO.sub("0", text))


def short_percent(off: float) -> str:
    """Off in percent with few characters and without the sign: 278, 31, 2.1, .27, <.01."""
    share = 100.0 * off
    if share < 0.005:
        return "<.01"
    if share >= 9.95:
        return f"{share:,.0f}"
    return f"{share:.1f}" if share >= 0.995 else f"{share:.2f}".removeprefix("0")


def switch(solver: str, route: str) -> str:
    """The route if the page has a switch for it, otherwise ""; the reference's methods have none."""
    return "" if solver == REFERENCE else route


def _is_number(text: str) -> bool:
    """Whether the text is empty or parses as a number, so that it can be sorted by its text."""
    try:
        float(text or "0")
    except ValueError:
        return False
    return True


def _cell(value: Any, column: str, numeric: bool) -> dict[str, Any]:
    if numeric and is_in_percent(column):
        text = number(100.0 * value) if isfinite(value) else ""
        return {"text": text, "kind": "number", "order": f"{value:.10g}" if isfinite(value) else "1e308"}
    text = shorten(value, column)
    if numeric:
        text_of_number = verbatim(text)
        return {
            "text": text_of_number,
            "kind": "number",
            "order": None if _is_number(text_of_number) else f"{value:.10g}",
        }
    if text in _WITH_COLOUR:
        kind = text.replace(" ", "-")
    elif "setting" in column:
        kind = "setting"
    else:
        kind = "reason" if column in _REMARKS or len(text) > _LONG else ""
    return {"text": text, "kind": kind, "order": None}
