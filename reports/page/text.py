"""Tables and numbers as people read them: files of comma-separated values and Markdown, shortened numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.tables import Table

if TYPE_CHECKING:
    import pandas as pd

# Columns that hold errors, by the end of their names.
_ERRORS = ("error", "error_bar", "_max", "_rms", "_mean", "_final", "_doubt", "accuracy")


def error_text(row: Mapping[str, Any], column: str) -> str:
    """An error of a headline row (`default_error`, `finest_error`) with its sign, or in words where there is none.

    No more is claimed than the truth's error bar allows; without a transition the centre's error stands instead.
    """
    if column == "finest_error" and row["is_truth"]:
        return "is the truth"
    value, outcome = row[column], row[column.replace("error", "outcome")]
    if outcome in ("", "refused", "crashed", "timed_out"):
        return outcome
    doubt = "" if outcome == "right" else f" ({outcome})"
    if not row["transitions"]:
        return f"centre {row[column.replace('error', 'centre_max')]:.1e}{doubt}"
    if not isfinite(value):
        return "missed"
    bar = row["truth_error_bar"]
    return (f"{value:+.1e}" if abs(value) > bar else f"< {bar:.1e}") + doubt


def write(tables: Mapping[str, pd.DataFrame], words: Mapping[str, Table], folder: Path, command: str) -> list[Path]:
    """Each table as NAME.csv (all digits) and NAME.md (for reading: with the words for its columns and the command that
    makes it again); returns the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, frame in tables.items():
        files += [folder / f"{name}.csv", folder / f"{name}.md"]
        inert(frame).to_csv(files[-2], index=False)
        meanings = "".join(f"- `{column}`: {text}\n" for column, text in words[name].columns.items())
        text = f"{markdown(frame)}\n" + (f"\n{meanings}" if meanings else "") + f"\nMake it again: `{command}`\n"
        files[-1].write_text(text, encoding="utf-8")
    return files


# What a spreadsheet takes for a formula, or skips to reach one.
_FORMULA = re.compile(r"\s*[=+\-@]")
# What a reader of Markdown may take for HTML.
_TAG = re.compile(r"<(?=[A-Za-z/!?])")


def inert(frame: pd.DataFrame) -> pd.DataFrame:
    """The table with an apostrophe before each text that a spreadsheet would work out; a number in words is none."""
    texts = [column for column in frame.columns if frame[column].dtype == object or str(frame[column].dtype) == "str"]
    return frame.assign(**{column: [_inert(value) for value in frame[column]] for column in texts})


def _inert(value: Any) -> Any:
    if not isinstance(value, str) or not _FORMULA.match(value):
        return value
    try:
        float(value)
    except ValueError:
        return f"'{value}"
    return value


def markdown(frame: pd.DataFrame) -> str:
    """The table as a Markdown pipe table, numbers shortened for reading."""
    from tabulate import tabulate

    if frame.empty:
        return "No rows."
    columns = [str(column) for column in frame.columns]
    rows = [
        [_TAG.sub("&lt;", shorten(row[c], c).replace("|", "\\|")) for c in columns] for row in frame.to_dict("records")
    ]
    return tabulate(rows, headers=columns, tablefmt="pipe", disable_numparse=True)


def plain(frame: pd.DataFrame) -> str:
    """The table for the terminal, numbers shortened."""
    from tabulate import tabulate

    columns = [str(column) for column in frame.columns]
    rows = [[shorten(row[c], c) for c in columns] for row in frame.to_dict("records")]
    return tabulate(rows, headers=columns, tablefmt="plain", disable_numparse=True)


def shorten(value: Any, column: str) -> str:
    """A value as people read it: times with nine digits, errors with two, an empty cell where there is nothing."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else ""
    if isinstance(value, float | np.floating):
        if not isfinite(value):
            return ""
        if column in ("time", "reference_time"):
            return f"{value:.9g}"
        if column.endswith(_ERRORS):
            return f"{value:.1e}"
        return f"{value:.2f}" if column.startswith("order") else f"{value:.2g}"
    return "" if value is None else str(value)
