"""The tables of a report. A table that fails with a solver's rows is made without these rows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import ROUND_UP, Context
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis import cost_tables, tables, verdict, verdict_text
from ..analysis.columns import Table, describe_column, with_version
from ..analysis.work_precision import CostMeasurements
from ..running import per_solver
from ..running.per_solver import LeftOut
from ..running.records import Experiment
from . import dictionary, text
from .fragments import records

if TYPE_CHECKING:
    import pandas as pd

    from ..studies import Result

OMISSIONS = "left_out"
HOLDS = "Tables and figures that were made without the results of a solver, because they fail with them"


class Tables:
    """Tables of a report by name, their descriptions, and the list of omitted solvers.

    `folder`: output folder; `command` reproduces the report; `versions`: of the solvers.
    """

    def __init__(self, folder: Path, command: str, versions: Mapping[str, str]):
        self.folder, self.command, self.versions = folder, command, versions
        self.frames: dict[str, pd.DataFrame] = {}
        self.words: dict[str, Table] = {}
        self.left_out: list[LeftOut] = []

    def add(
        self,
        make: Callable[..., dict[str, pd.DataFrame]],
        records: tuple,
        holds: Mapping[str, str],
        item: str,
        command: str = "",
        words: Mapping[str, Table] | None = None,
    ) -> None:
        """Write the tables that `make` returns for the records; described by `holds` (content only) or by `words`."""

        def write_frames(*args: Any) -> tuple[dict[str, pd.DataFrame], Mapping[str, Table]]:
            frames = {name: with_version(frame, self.versions) for name, frame in make(*args).items()}
            frames = {name: with_short_numbers(frame) for name, frame in frames.items()}
            descriptions = words or {
                name: describe_column(holds[name], map(str, frame.columns)) for name, frame in frames.items()
            }
            text.write(frames, descriptions, self.folder, command or self.command)
            return frames, descriptions

        (frames, descriptions), omitted = per_solver.make_per_solver(
            write_frames, records, per_solver.solvers_of(records), item
        )
        self.frames |= frames
        self.words |= descriptions
        self.left_out += omitted

    def note(self, left_out: Iterable[LeftOut]) -> None:
        """Add rows to the table of omitted results and write it again."""
        import pandas as pd

        self.left_out = list(dict.fromkeys([*self.left_out, *left_out]))
        if self.left_out:
            frame = pd.DataFrame(self.left_out, columns=list(LeftOut._fields))
            self.add(lambda: {OMISSIONS: frame}, (), {OMISSIONS: HOLDS}, OMISSIONS)


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
    """Write all tables of a report except that of omitted results; returns the rows of the verdict and of pairs.

    `ran`: the experiment without external motions.
    """
    import pandas as pd

    output.add(cost_tables.frames, (ran, measurements), cost_tables.HOLDS, "tables of cost")
    for name in tables.TABLES:
        make = lambda experiment, name=name: {name: tables.frame(name, experiment)}  # noqa: E731
        output.add(make, (shown,), tables.HOLDS, f"table {name}")
    for result in results:
        output.left_out += result.left_out
        output.add(dict, (result.frames,), {}, f"tables of {result.name}", result.command, result.words)

    verdicts, in_pairs = list[dict[str, Any]](), list[dict[str, Any]]()
    times = [output.frames[name] for name in ("time_to_accuracy",) if name in output.frames]

    def make_verdict(experiment: Experiment, *times: pd.DataFrame) -> dict[str, pd.DataFrame]:
        verdicts[:] = verdict.rows(experiment, [row for frame in times for row in records(frame)])
        # The terminal's text is made here as well, so that a row that fails there is omitted from both.
        in_pairs[:] = verdict.pairs(experiment)
        verdict_text.sentence(verdicts, in_pairs)
        for in_words in (verdict_text.in_terminal, verdict_text.legend, verdict_text.details, verdict_text.notes):
            in_words(verdicts)
        return {
            "verdict": pd.DataFrame(verdicts, columns=list(verdict.COLUMNS)),
            "pairs": pd.DataFrame(in_pairs, columns=list(verdict.PAIR_COLUMNS)),
        }

    words = {"verdict": verdict.HOLDS, "pairs": verdict.PAIRS_HOLD}
    output.add(make_verdict, (shown, *times), words, "tables verdict and pairs")
    output.frames = {"verdict": output.frames.pop("verdict")} | output.frames
    return verdicts, in_pairs


def describe(output: Tables) -> None:
    """Write the data dictionary of all columns."""
    dictionary.write(output.frames, output.words, output.folder, output.command)
