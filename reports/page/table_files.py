"""The tables of a report, in their order, as files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from decimal import ROUND_UP, Context
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..analysis.columns import Table, describe_column, with_version
from ..analysis.table_list import TABLES, Results, frames
from . import dictionary, text

if TYPE_CHECKING:
    import pandas as pd

    from ..studies import Result


class Tables(NamedTuple):
    """The tables of a report by name, and their descriptions."""

    frames: dict[str, pd.DataFrame]
    words: dict[str, Table]


def write(
    folder: Path, results: Results, study_results: Sequence[Result], command: str, versions: Mapping[str, str]
) -> Tables:
    """Write all tables of a report and their dictionary to a folder. `command` reproduces the report; `versions`: of
    the solvers."""
    output = Tables({}, {})

    def add(frames: Mapping[str, pd.DataFrame], words: Callable[[str], Table]) -> None:
        complete = {name: with_short_numbers(with_version(frame, versions)) for name, frame in frames.items()}
        output.frames.update(complete)
        output.words.update({name: words(name) for name in complete})
        text.write(complete, folder)

    add(frames(results), lambda name: describe_column(TABLES[name].holds, map(str, output.frames[name].columns)))
    for result in study_results:
        add(result.frames, result.words.__getitem__)
    dictionary.write(output.frames, output.words, folder, command)
    return output


# A column in seconds of the motion, not of the computer.
_OF_MOTIONS = {"end_s"}
# Columns that say how uncertain a number is; errors and scores keep all digits.
_UNCERTAINTIES = {"truth_error_bar", "floor_error", "reading_doubt", "doubt"}
# Decimal arithmetic to four digits that never makes an error bar smaller.
_UPWARDS = Context(prec=4, rounding=ROUND_UP)


def with_short_numbers(frame: pd.DataFrame) -> pd.DataFrame:
    """The table with its computing times to six digits and its uncertainties to four, rounded up: the other digits are
    noise, and a tenth of the tables.

    A column may hold other values than numbers, as a solver returned them: these stay.
    """

    def short_time(value: Any) -> Any:
        return float(f"{value:.6g}") if isinstance(value, float) else value

    def short_bar(value: Any) -> Any:
        is_number = isinstance(value, float) and isfinite(value)
        return float(_UPWARDS.create_decimal(repr(float(value)))) if is_number else value

    names = [str(c) for c in frame.columns]
    short = {name: frame[name].map(short_time) for name in names if name.endswith("_s") and name not in _OF_MOTIONS}
    return frame.assign(**short, **{name: frame[name].map(short_bar) for name in names if name in _UNCERTAINTIES})
