"""Elements of the page: templates, figures, tables, and the command that reproduces them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from ..analysis import tables
from ..drawing.figure_files import FigureEntry
from ..judging.grades import Grade
from ..running import per_solver
from ..running.records import REFERENCE
from .text import shorten

if TYPE_CHECKING:
    import pandas as pd

_TEMPLATES = Path(__file__).parent / "templates"
_POWER, _ZERO = re.compile(r"(\d)e([+-])0(\d)\b"), re.compile(r"\b0\.0e\+00\b")
_REMARKS = ("reason", "note", "notes")
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


def picture(entry: FigureEntry, folder: Path, inside: bool = True) -> dict[str, Any]:
    """Data of a figure for its template; its source is a data URI, or the file's path if not `inside` the page."""
    caption = " ".join(filter(None, (entry.caption, per_solver.words(entry.left_out))))
    data = {"name": entry.name, "title": entry.title, "caption": caption, "failure": not entry.name}
    if entry.name:
        data["alt"] = f"{entry.title}: {entry.case}" if entry.case else entry.title
        file = folder / f"{entry.name}.svg"
        data["source"] = Markup(_address(file.read_text(encoding="utf-8"))) if inside else f"figures/{file.name}"
    return data


# Characters with a meaning in a URI or an HTML attribute. Escaping only these keeps a picture a quarter smaller than
# base64 does.
_ESCAPES = str.maketrans({"%": "%25", "#": "%23", "&": "%26", '"': "'", "\n": " ", "<": "%3C", ">": "%3E"})


def _address(svg: str) -> str:
    """The picture as a data URI. Quotes become apostrophes, which is safe: our SVG attributes contain none."""
    return f"data:image/svg+xml;charset=utf-8,{svg.strip().translate(_ESCAPES)}"


def table(
    frame: pd.DataFrame, columns: Mapping[str, str], words: Mapping[str, str] | None = None
) -> dict[str, list[dict[str, Any]]]:
    """Headings and rows of some columns for the template.

    A column's description is its tooltip. A number whose text a program cannot read, such as 1,700, has a sort key.
    Columns of remarks that are empty in all rows are omitted.
    """
    columns = {c: title for c, title in columns.items() if c not in _REMARKS or any(frame[c].astype(bool))}
    numeric = {c for c in columns if len(frame) and all(isinstance(v, int | float | np.number) for v in frame[c])}
    heads = [{"title": title, "number": c in numeric, "tip": (words or {}).get(c, "")} for c, title in columns.items()]
    rows = []
    for row in records(frame):
        cells = [_cell(row[c], c, c in numeric) for c in columns]
        rows.append(
            {
                "solver": str(row.get("solver", "")),
                "route": switch(str(row.get("solver", "")), str(row.get("route", ""))),
                "cells": cells,
            }
        )
    return {"heads": heads, "rows": rows}


def verbatim(text: str) -> str:
    """A number's text in its short form: 1.1e-7 and 0, not 1.1e-07 and 0.0e+00."""
    return _POWER.sub(lambda m: f"{m[1]}e{m[2].removeprefix('+')}{m[3]}", _ZERO.sub("0", text))


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
        kind = "reason" if column in _REMARKS else ""
    return {"text": text, "kind": kind, "order": None}
