"""What the page is made of: templates, figures, tables, the command that makes them again."""

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
from ..drawing.files import Drawn
from ..running import per_solver
from ..running.records import REFERENCE
from .text import shorten

if TYPE_CHECKING:
    import pandas as pd

_TEMPLATES = Path(__file__).parent / "templates"
# Words of a table that have a colour of their own.
_POWER, _ZERO = re.compile(r"(\d)e([+-])0(\d)\b"), re.compile(r"\b0\.0e\+00\b")
_REMARKS = ("reason", "note", "notes")
_VERDICTS = (*tables.OUTCOMES, "matched", "missed", "spurious", "unresolved")


@lru_cache(maxsize=1)
def environment() -> Environment:
    """The templates of the page; all text is escaped, and a name that is not given is an error."""
    loader = FileSystemLoader(_TEMPLATES)
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    return [{str(column): value for column, value in row.items()} for row in frame.to_dict("records")]


def command_of(label: str, manifest: dict[str, Any]) -> str:
    """The command that makes one case's figures and tables again; of all cases for no label."""
    if not label:
        return manifest["command"]
    return f'python -m reports.build {manifest["options"]} --case "{label}"'.replace("  ", " ")


def picture(drawn: Drawn, folder: Path, inside: bool = True) -> dict[str, Any]:
    """A figure as its template takes it: the picture itself is its address, or its file beside the page."""
    caption = " ".join(filter(None, (drawn.caption, per_solver.words(drawn.left_out))))
    told = {"name": drawn.name, "title": drawn.title, "caption": caption, "failure": not drawn.name}
    if drawn.name:
        told["alt"] = f"{drawn.title}: {drawn.case}" if drawn.case else drawn.title
        file = folder / f"{drawn.name}.svg"
        told["source"] = Markup(_address(file.read_text(encoding="utf-8"))) if inside else f"figures/{file.name}"
    return told


# What an address or an attribute of HTML would take for its own. Escaping no more than that keeps a picture a quarter
# smaller than base64 would.
_ESCAPES = str.maketrans({"%": "%25", "#": "%23", "&": "%26", '"': "'", "\n": " ", "<": "%3C", ">": "%3E"})


def _address(svg: str) -> str:
    """The picture itself as an address. No attribute of ours holds an apostrophe, so that quotes may become such."""
    return f"data:image/svg+xml;charset=utf-8,{svg.strip().translate(_ESCAPES)}"


def table(
    frame: pd.DataFrame, columns: Mapping[str, str], words: Mapping[str, str] | None = None
) -> dict[str, list[dict[str, Any]]]:
    """Heads and rows of some columns, as the template takes them: what a column means is its tip, and a number
    that is not written as one, such as 1,700, knows by what it is sorted. Remarks that nowhere say anything are left
    out."""
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


def as_written(text: str) -> str:
    """A number's text as people write it: 1.1e-7 and 0, not 1.1e-07 and 0.0e+00."""
    return _POWER.sub(lambda m: f"{m[1]}e{m[2].removeprefix('+')}{m[3]}", _ZERO.sub("0", text))


def switch(solver: str, route: str) -> str:
    """The route, if it is one that is switched on and off: the reference's methods are not."""
    return "" if solver == REFERENCE else route


def _is_number(text: str) -> bool:
    """Whether a program reads the text as a number, so that it can be sorted by what is shown; or it is none at all."""
    try:
        float(text or "0")
    except ValueError:
        return False
    return True


def _cell(value: Any, column: str, numeric: bool) -> dict[str, Any]:
    text = shorten(value, column)
    if numeric:
        shown = as_written(text)
        return {"text": shown, "kind": "number", "order": None if _is_number(shown) else f"{value:.10g}"}
    if text in _VERDICTS:
        kind = text
    elif "setting" in column:
        kind = "setting"
    else:
        kind = "reason" if column in _REMARKS else ""
    return {"text": text, "kind": kind, "order": None}
