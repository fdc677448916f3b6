"""The tables of a report, in their order, as files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import ROUND_UP, Context
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis import cost_tables, tables, verdict
from ..analysis.columns import Table, describe_column, with_version
from ..analysis.work_precision import CostMeasurements
from ..running.records import Experiment
from . import dictionary, text
from .fragments import records

if TYPE_CHECKING:
    import pandas as pd

    from ..studies import Result


class Tables:
    """Tables of a report by name, and their descriptions.

    `folder`: output folder; `command` reproduces the report; `versions`: of the solvers.
    """

    def __init__(self, folder: Path, command: str, versions: Mapping[str, str]):
        self.folder, self.command, self.versions = folder, command, versions
        self.frames: dict[str, pd.DataFrame] = {}
        self.words: dict[str, Table] = {}

    def add(
        self,
        frames: Mapping[str, pd.DataFrame],
        holds: Mapping[str, str],
        command: str = "",
        words: Mapping[str, Table] | None = None,
    ) -> None:
        """Write tables, described by `holds` (content only) or by `words`."""
        frames = {name: with_short_numbers(with_version(frame, self.versions)) for name, frame in frames.items()}
        words = words or {name: describe_column(holds[name], map(str, frame.columns)) for name, frame in frames.items()}
        text.write(frames, words, self.folder, command or self.command)
        self.frames |= frames
        self.words |= words


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


def write(
    output: Tables, shown: Experiment, ran: Experiment, measurements: CostMeasurements, results: Sequence[Result]
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Write all tables of a report; returns the rows of the verdict and of pairs.

    `ran`: the experiment without external motions.
    """
    import pandas as pd

    output.add(cost_tables.frames(ran, measurements), cost_tables.HOLDS)
    output.add({name: tables.frame(name, shown) for name in tables.TABLES}, tables.HOLDS)
    for result in results:
        output.add(result.frames, {}, result.command, result.words)
    times = [output.frames[name] for name in ("time_to_accuracy",) if name in output.frames]
    verdicts = verdict.rows(shown, [row for frame in times for row in records(frame)])
    pairs = verdict.pairs(shown)
    frames = {
        "verdict": pd.DataFrame(verdicts, columns=list(verdict.COLUMNS)),
        "pairs": pd.DataFrame(pairs, columns=list(verdict.PAIR_COLUMNS)),
    }
    output.add(frames, {"verdict": verdict.HOLDS, "pairs": verdict.PAIRS_HOLD})
    output.frames = {"verdict": output.frames.pop("verdict")} | output.frames
    return verdicts, pairs


def describe(output: Tables) -> None:
    """Write the data dictionary of all columns."""
    dictionary.write(output.frames, output.words, output.folder, output.command)
