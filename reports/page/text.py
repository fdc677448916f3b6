"""Tables as files of comma-separated values, and numbers rounded for reading."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.errors import printable

from ..analysis.columns import infinite
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


def write(tables: Mapping[str, pd.DataFrame], folder: Path) -> list[Path]:
    """Write each table as NAME.csv, with all rows and digits; returns the files. Raises ValueError for an infinite
    result."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, frame in tables.items():
        files.append(folder / f"{name}.csv")
        if infinite(frame):
            raise ValueError(
                f"the table {name} has an infinite result in {', '.join(infinite(frame))}; use a word instead"
            )
        inert(frame).to_csv(files[-1], index=False, errors="backslashreplace")
    return files


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
