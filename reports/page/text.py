"""Tables as files of comma-separated values and Markdown, and numbers rounded for reading."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.errors import printable

from ..analysis.columns import Table, infinite
from ..analysis.number_format import level, number

if TYPE_CHECKING:
    import pandas as pd

# Columns whose values agree in many digits.
_NINE_DIGITS = ("time", "reference_time", "published", "ours")
# Columns that hold errors, by the end of their names.
_ERRORS = ("error", "error_bar", "_max", "_rms", "_mean", "_final", "_doubt")


def lost_text(lost_calls: Sequence[str]) -> str:
    """A sentence about calls whose processes were ended from outside; "" if there are none."""
    if not lost_calls:
        return ""
    count = "1 call was" if len(lost_calls) == 1 else f"{len(lost_calls)} calls were"
    return f"{count} ended from outside twice ({lost_calls[0]}); run the same command again to complete the report"


def write(tables: Mapping[str, pd.DataFrame], words: Mapping[str, Table], folder: Path, command: str) -> list[Path]:
    """Write each table as NAME.csv (all rows, all digits) and NAME.md (first rows, descriptions of the columns, and the
    command that reproduces it); returns the files.

    Raises ValueError for an infinite result.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, frame in tables.items():
        files += [folder / f"{name}.csv", folder / f"{name}.md"]
        if infinite(frame):
            raise ValueError(
                f"the table {name} has an infinite result in {', '.join(infinite(frame))}; use a word instead"
            )
        inert(frame).to_csv(files[-2], index=False, errors="backslashreplace")
        meanings = "".join(f"- `{column}`: {text}\n" for column, text in words[name].columns.items())
        text = f"{words[name].holds}.\n\n{top(name, frame)}\n" + (f"\n{meanings}" if meanings else "")
        files[-1].write_text(f"{text}\nMake it again: `{command}`\n", encoding="utf-8")
    return files


# Text that a spreadsheet reads as a formula, with the white space that it skips.
_FORMULA = re.compile(r"\s*[=+\-@]")
# What a Markdown renderer may read as HTML, as a link or an image, or as an address; and how it is written as text.
_ACTIVE = re.compile(r"<(?=[A-Za-z/!?])|\](?=[(\[:])|(?<=:)/(?=/)|(?<=www)\.", re.IGNORECASE)
_INERT = {"<": "&lt;", "]": "&#93;", "/": "&#47;", ".": "&#46;"}


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


# Limits of a Markdown table: rows, and characters of a cell. The CSV file next to it has everything.
TOP_ROWS, _CELL = 20, 60


def top(name: str, frame: pd.DataFrame) -> str:
    """The first rows of a table as Markdown, with a link to the complete file."""
    more = len(frame) - TOP_ROWS
    rest = f"\n\nThe first {TOP_ROWS} of {len(frame)} rows; all of them: [{name}.csv]({name}.csv)." if more > 0 else ""
    return markdown(frame.head(TOP_ROWS)) + rest


def markdown(frame: pd.DataFrame) -> str:
    """The table as a Markdown pipe table; numbers and long texts are shortened."""
    if frame.empty:
        return "No rows."
    columns = [str(column) for column in frame.columns]
    rows = [[_cell(row[c], c) for c in columns] for row in frame.to_dict("records")]
    # Without padding, which only a terminal needs.
    return "\n".join(f"| {' | '.join(line)} |" for line in (columns, ["---"] * len(columns), *rows))


def _clip(text: str) -> str:
    return text if len(text) <= _CELL else f"{text[: _CELL - 1].rstrip()}…"


def _cell(value: Any, column: str) -> str:
    text = " ".join(printable(_clip(shorten(value, column))).split())
    return _ACTIVE.sub(lambda active: _INERT[active[0]], text.replace("|", "\\|"))


def plain(frame: pd.DataFrame) -> str:
    """The table as text for the terminal; numbers are rounded."""
    from tabulate import tabulate

    columns = [str(column) for column in frame.columns]
    rows = [[shorten(row[c], c) for c in columns] for row in frame.to_dict("records")]
    return tabulate(rows, headers=columns, tablefmt="plain", disable_numparse=True)


def shorten(value: Any, column: str) -> str:
    """A value rounded for reading: times to nine digits, errors to two; empty if there is no value."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else ""
    if isinstance(value, float | np.floating):
        value = float(value)
        if not isfinite(value):
            return ""
        if column == "level":
            return level(value)
        if column in _NINE_DIGITS:
            return f"{value:.9g}"
        if column.endswith(_ERRORS):
            return f"{value:.1e}"
        if column.startswith("order"):
            return f"{value:.2f}"
        # Scientific notation only for small numbers: 1,700, not 1.7e+03.
        return number(value) if abs(value) >= 100.0 else f"{value:.2g}"
    return "" if value is None else str(value)
