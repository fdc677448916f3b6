"""What the page is made of: figures, tables, the command that makes them again."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis import tables
from ..drawing.files import Drawn
from .text import shorten

if TYPE_CHECKING:
    import pandas as pd


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    return [{str(column): value for column, value in row.items()} for row in frame.to_dict("records")]


def command_of(label: str, manifest: dict[str, Any]) -> str:
    """The command that makes one case's figures and tables again; of all cases for no label."""
    if not label:
        return manifest["command"]
    return f'python -m reports.build {manifest["options"]} --case "{label}"'.replace("  ", " ")


def figure_of(drawn: Drawn, folder: Path, command: str) -> str:
    if not drawn.name:
        return f'<div class="warning"><strong>{escape(drawn.title)}.</strong> {escape(drawn.caption)}</div>'
    title = f"{drawn.title}: {drawn.case}" if drawn.case else drawn.title
    return (
        f'<figure><a href="figures/{drawn.name}.svg"><img loading="lazy" alt="{escape(title)}" '
        f'src="{_address((folder / f"{drawn.name}.svg").read_text(encoding="utf-8"))}"></a>'
        f"<figcaption><strong>{escape(drawn.title)}.</strong> {escape(drawn.caption)}</figcaption></figure>"
        f"{remake(command)}"
    )


# What an address or an attribute of HTML would take for its own. Escaping no more than that keeps a picture a quarter
# smaller than base64 would.
_ESCAPES = str.maketrans({"%": "%25", "#": "%23", "&": "%26", '"': "'", "\n": " "})


def _address(svg: str) -> str:
    """The picture itself as an address. No attribute of ours holds an apostrophe, so that quotes may become such."""
    return f"data:image/svg+xml;charset=utf-8,{svg.strip().translate(_ESCAPES)}"


def remake(command: str) -> str:
    return f'<p class="remake">Make it again: <code>{escape(command)}</code></p>'


def table_of(frame: pd.DataFrame, columns: dict[str, str], words: Mapping[str, str] | None = None) -> str:
    """Some columns of a table as HTML; a line above each new case, and what a column means as its tip."""
    numeric = {c for c in columns if len(frame) and all(isinstance(v, int | float | np.number) for v in frame[c])}
    tips = {column: f' title="{escape(text)}"' for column, text in (words or {}).items()}
    head = "".join(
        f"<th{class_of('number' if c in numeric else '')}{tips.get(c, '')}>{escape(title)}</th>"
        for c, title in columns.items()
    )
    rows, before = [], None
    for row in records(frame):
        new = "case" in columns and before is not None and row["case"] != before
        before = row.get("case")
        cells = "".join(_cell(row[c], c, numeric) for c in columns)
        rows.append(f"<tr{class_of('first') if new else ''}>{cells}</tr>")
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'


def class_of(name: str) -> str:
    return f' class="{name}"' if name else ""


def _cell(value: Any, column: str, numeric: set[str]) -> str:
    text = shorten(value, column)
    if column in numeric:
        kind = "number"
    elif text in (*tables.OUTCOMES, "matched", "missed", "spurious", "unresolved"):
        kind = text
    elif "setting" in column:
        kind = "setting"
    else:
        kind = "reason" if column in ("reason", "note", "notes") else ""
    return f"<td{class_of(kind)}>{escape(text)}</td>"
