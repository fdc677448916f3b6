"""Tables and numbers as people read them: files of comma-separated values and Markdown, shortened numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.columns import Table, infinite
from ..analysis.words import level, number

if TYPE_CHECKING:
    import pandas as pd

# Columns that hold errors, by the end of their names.
_ERRORS = ("error", "error_bar", "_max", "_rms", "_mean", "_final", "_doubt", "accuracy")


def lost_words(lost: Sequence[str]) -> str:
    """What is said of calls that something outside ended, "" where there are none."""
    if not lost:
        return ""
    count = "1 call was" if len(lost) == 1 else f"{len(lost)} calls were"
    return f"{count} ended from outside, and again when made once more ({lost[0]}); the same command makes up for it"


def error_text(row: Mapping[str, Any], which: str) -> str:
    """The error of the first transition's time of a headline row with its sign, or in words where there is none;
    `which` is "default" or "finest".

    No more is claimed than the truth's error bar allows; without a transition the centre's error stands instead.
    """
    words = _no_error(row, which)
    if words is not None:
        return words
    value, bar, doubt = row[f"{which}_first_error"], row["truth_error_bar"], _unsure(row, which)
    if not row["transitions_true"]:
        return f"centre {row[f'{which}_centre_max']:.1e}{doubt}"
    if not isfinite(value):
        return "missed"
    return (f"{value:+.1e}" if abs(value) > bar else f"< {bar:.1e}") + doubt


def lead_text(row: Mapping[str, Any], which: str) -> str:
    """The error of the quantity that leads the case, with its unit, or in words where there is none."""
    words = _no_error(row, which)
    if words is not None:
        return words
    value, bar = row[f"{which}_lead_error"], row["lead_error_bar"]
    if not isfinite(value):
        return "missed"
    return (f"< {bar:.1e}" if value <= bar else f"{value:.1e}") + f" {row['unit']}{_unsure(row, which)}"


def _no_error(row: Mapping[str, Any], which: str) -> str | None:
    if which == "finest" and row["is_truth"]:
        return "is the truth"
    outcome = row[f"{which}_outcome"]
    return outcome if outcome in ("", "refused", "crashed", "timed_out", "not_installed") else None


def _unsure(row: Mapping[str, Any], which: str) -> str:
    outcome = row[f"{which}_outcome"]
    return "" if outcome == "right" else f" ({outcome})"


def reached_text(row: Mapping[str, Any]) -> str:
    """The finest accuracy a route reached, or what no rung finer than another contradicts: none."""
    return level(row["reached"]) if isfinite(row["reached"]) else ""


def write(
    tables: Mapping[str, pd.DataFrame], words: Mapping[str, Table], folder: Path, command: str, paper: bool = False
) -> list[Path]:
    """Each table as NAME.csv (all rows, all digits) and NAME.md (for reading: the top of it, with the words for its
    columns and the command that makes it again), for a paper also as NAME.tex; returns the files.

    Raises ValueError for an infinite result.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, frame in tables.items():
        files += [folder / f"{name}.csv", folder / f"{name}.md"]
        if infinite(frame):
            raise ValueError(f"the table {name} has an infinite result in {', '.join(infinite(frame))}; a word is due")
        inert(frame).to_csv(files[-2], index=False, errors="backslashreplace")
        meanings = "".join(f"- `{column}`: {text}\n" for column, text in words[name].columns.items())
        text = f"{words[name].holds}.\n\n{top(name, frame)}\n" + (f"\n{meanings}" if meanings else "")
        files[-1].write_text(f"{text}\nMake it again: `{command}`\n", encoding="utf-8")
        if paper:
            files.append(folder / f"{name}.tex")
            files[-1].write_text(f"% {words[name].holds}. Make it again: {command}\n{latex(frame)}\n", encoding="utf-8")
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


# What is read of a table: so many rows, and of a cell so many characters; the rest is in the file beside it.
TOP_ROWS, _CELL = 20, 60


def top(name: str, frame: pd.DataFrame) -> str:
    """The first rows of a table as Markdown, and where the others are."""
    more = len(frame) - TOP_ROWS
    rest = f"\n\nThe first {TOP_ROWS} of {len(frame)} rows; all of them: [{name}.csv]({name}.csv)." if more > 0 else ""
    return markdown(frame.head(TOP_ROWS)) + rest


def markdown(frame: pd.DataFrame) -> str:
    """The table as a Markdown pipe table, numbers and long words shortened for reading."""
    if frame.empty:
        return "No rows."
    columns = [str(column) for column in frame.columns]
    rows = [[_cell(row[c], c) for c in columns] for row in frame.to_dict("records")]
    # As narrow as it gets: padding is for the terminal.
    return "\n".join(f"| {' | '.join(line)} |" for line in (columns, ["---"] * len(columns), *rows))


def _clipped(text: str) -> str:
    return text if len(text) <= _CELL else f"{text[: _CELL - 1].rstrip()}…"


def latex(frame: pd.DataFrame) -> str:
    """The table as a LaTeX `longtable`, numbers shortened for reading."""
    from tabulate import tabulate

    columns = [str(column) for column in frame.columns]
    rows = [[shorten(row[c], c) for c in columns] for row in frame.to_dict("records")]
    return tabulate(rows, headers=columns, tablefmt="latex_longtable", disable_numparse=True)


def _cell(value: Any, column: str) -> str:
    return _TAG.sub("&lt;", _clipped(shorten(value, column)).replace("|", "\\|"))


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
        value = float(value)
        if not isfinite(value):
            return ""
        if column in ("accuracy", "reached"):
            return level(value)
        if column in ("time", "reference_time"):
            return f"{value:.9g}"
        if column.endswith(_ERRORS):
            return f"{value:.1e}"
        if column.startswith("order"):
            return f"{value:.2f}"
        # Powers of ten for what is very small alone: 1,700, not 1.7e+03.
        return number(value) if abs(value) >= 100.0 else f"{value:.2g}"
    return "" if value is None else str(value)
