"""The tables of a report, written one after the other; one that fails with a solver's rows is made without them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis import advice, cost_tables, tables
from ..analysis.columns import Table, described, with_version
from ..analysis.work_precision import Measured
from ..running import per_solver
from ..running.per_solver import LeftOut
from ..running.records import Experiment
from . import dictionary, first, text

if TYPE_CHECKING:
    import pandas as pd

    from ..studies import Result

LEFT_OUT = "left_out"
HOLDS = "Tables and figures that were made without the results of a solver, since with them they fail"


class Tables:
    """Tables of a report by name, what is said of each, and which were made without a solver's rows.

    `folder`: where they are written; `command` makes the report again; `versions`: of the solvers; `paper`: TeX, too.
    """

    def __init__(self, folder: Path, command: str, versions: Mapping[str, str], paper: bool = False):
        self.folder, self.command, self.versions, self.paper = folder, command, versions, paper
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
        """Write the tables that `make` makes of the records; `holds` says what is in each, or `words` all of it."""

        def written(*some: Any) -> tuple[dict[str, pd.DataFrame], Mapping[str, Table]]:
            frames = {name: with_version(frame, self.versions) for name, frame in make(*some).items()}
            said = words or {name: described(holds[name], map(str, frame.columns)) for name, frame in frames.items()}
            text.write(frames, said, self.folder, command or self.command, self.paper)
            return frames, said

        (frames, said), left = per_solver.made(written, records, per_solver.solvers_of(records), item)
        self.frames |= frames
        self.words |= said
        self.left_out += left

    def note(self, left_out: Iterable[LeftOut]) -> None:
        """Write the table of what was left out again, with more rows."""
        import pandas as pd

        self.left_out = list(dict.fromkeys([*self.left_out, *left_out]))
        if self.left_out:
            frame = pd.DataFrame(self.left_out, columns=list(LeftOut._fields))
            self.add(lambda: {LEFT_OUT: frame}, (), {LEFT_OUT: HOLDS}, LEFT_OUT)


def write(
    made: Tables, shown: Experiment, ran: Experiment, measured: Measured, studied: Sequence[Result]
) -> list[dict]:
    """All tables of a report but that of what was left out; returns the rows of the answer table. `ran`: what was run
    here, without what is external."""
    import pandas as pd

    made.add(cost_tables.frames, (ran, measured), cost_tables.HOLDS, "tables of cost")
    for name, rows in tables.TABLES.items():
        make = lambda experiment, name=name, rows=rows: {name: pd.DataFrame(rows(experiment))}  # noqa: E731
        made.add(make, (shown,), tables.HOLDS, f"table {name}")
    for result in studied:
        made.left_out += result.left_out
        made.add(dict, (result.frames,), {}, f"tables of {result.name}", result.command, result.words)

    answers: list[dict[str, Any]] = []

    def answered(experiment: Experiment, frames: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
        answers[:] = advice.rows(experiment, frames)
        # What the terminal is told of them is made here as well: a row that cannot be told is left out of both.
        first.in_terminal(answers), first.notes(answers), advice.sentences(answers)
        return {"answers": pd.DataFrame(answers)}

    made.add(answered, (shown, made.frames), {"answers": advice.HOLDS}, "table answers")
    made.frames = {"answers": made.frames.pop("answers")} | made.frames
    return answers


def describe(made: Tables) -> None:
    """Write the dictionary of all columns."""
    dictionary.write(made.frames, made.words, made.folder, made.command)
