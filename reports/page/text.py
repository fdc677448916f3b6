"""Texts of the terminal and the page: tables, and numbers rounded for reading."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

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
