"""Studies: questions that stand beside the comparison. A module or a folder's being here registers a study.

A study is a module (of a folder: its `study.py`) with

    TITLE, QUESTION     what the page says first
    TABLES              by name what each table holds and what its columns mean (`Table`); every column has its words
    TAKES               which of "case" and "solver" it takes: a study may have scenes or contestants of its own
    IN_REPORT           whether a report has it
    run(request, calls)     what it finds out; everything that may fail is called in a worker, and a failure is a row
    rows(found)             the rows of each table
    draw(found, folder)     writes its pictures, and yields what was written
    summary(found)          if it likes: what the terminal is shown in the place of the tables
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import cases
from cases import Case
from cases.errors import unknown

from ..running import per_solver
from ..running.per_solver import LeftOut
from ..running.records import REFERENCE

if TYPE_CHECKING:
    import pandas as pd

    from ..analysis.columns import Table
    from ..drawing.files import Drawn
    from ..running.calls import Calls


class Request(NamedTuple):
    """What a study is asked: cases named by the user (none: those it chooses itself), solvers, and whether it may take
    as long as it likes."""

    cases: tuple[Case, ...] = ()
    solvers: tuple[str, ...] = ()
    full: bool = False

    @property
    def engines(self) -> tuple[str, ...]:
        """The solvers without the reference."""
        return tuple(name for name in self.solvers if name != REFERENCE)

    def cases_or(self, own: Sequence[str]) -> tuple[Case, ...]:
        """The cases named, else the study's own, with all their variants."""
        return self.cases or tuple(case for text in own for case in cases.select(text))


class Result(NamedTuple):
    """What came of a study: its module, the command that makes it alone, its tables, what it found; or why it failed,
    in a sentence. `left_out`: the solvers without whose results its tables were made, since with them they fail."""

    name: str
    study: ModuleType
    command: str
    frames: dict[str, pd.DataFrame] = {}
    found: Any = None
    failure: str = ""
    left_out: tuple[LeftOut, ...] = ()

    @property
    def words(self) -> dict[str, Table]:
        """What is said of its tables."""
        from ..analysis.columns import with_version_words

        return {name: with_version_words(self.study.TABLES[name], frame) for name, frame in self.frames.items()}

    def draw(self, folder: Path) -> list[Drawn]:
        """Its pictures, written into the folder; if they fail, what says so."""
        from ..drawing.files import Drawn

        if self.failure:
            return []
        folder.mkdir(parents=True, exist_ok=True)
        try:
            return draw(self.name, self.study.draw, (self.found,), folder)
        except Exception as problem:  # the numbers are there, whatever happens to a picture
            return [Drawn("", "", "Pictures", f"They could not be drawn: {type(problem).__name__}: {problem}")]


def draw(name: str, function: Callable[..., Iterable[Drawn]], records: tuple, folder: Path) -> list[Drawn]:
    """The pictures that `function(*records, folder)` writes; where they fail with the results of a solver, without
    them."""
    solvers = per_solver.solvers_of(records)
    drawn, left = per_solver.made(lambda *some: list(function(*some, folder)), records, solvers, f"figures of {name}")
    return [replace(one, left_out=tuple(left)) for one in drawn]


def names() -> tuple[str, ...]:
    """Every study's name, in alphabetical order. Imports none of them."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def study(name: str) -> ModuleType:
    """The study of that name; raises UnknownName."""
    if name not in names():
        raise unknown("study", name, names())
    module = importlib.import_module(f"{__name__}.{name}")
    return importlib.import_module(f"{module.__name__}.study") if hasattr(module, "__path__") else module


def run(name: str, request: Request, calls: Calls, command: str) -> Result:
    """Make a study. What fails is said in its result; it takes nothing else with it."""
    made = study(name)
    try:
        # One that is not installed has no part in it.
        present = calls.present(request.solvers) if request.solvers else ()
        # Where it fails with a solver's results it is made again without them, from what the store has.
        found, failed = per_solver.made(
            lambda some: made.run(request._replace(solvers=some), calls), (present,), present, f"study {name}"
        )
        solvers = per_solver.solvers_of(found)
        frames, left = per_solver.made(lambda some: _frames(made.rows(some), calls), (found,), solvers, f"study {name}")
        found = per_solver.without(found, {one.solver for one in left})
        return Result(name, made, command, frames, found, left_out=(*failed, *left))
    except Exception as problem:  # whatever it is, the report goes on without this study and says so
        return Result(name, made, command, failure=f"{type(problem).__name__}: {problem}")


def _frames(rows: Mapping[str, Any], calls: Calls) -> dict[str, pd.DataFrame]:
    """The rows of each table as a table; raises ValueError for an infinite result."""
    import pandas as pd

    from ..analysis.columns import infinite, with_version

    frames = {table: with_version(pd.DataFrame(rows[table]), calls.versions) for table in rows}
    for table, frame in frames.items():
        if infinite(frame):
            raise ValueError(f"the table {table} has an infinite result in {', '.join(infinite(frame))}")
    return frames
