"""Studies: questions in addition to the comparison. Every module and folder in this package is a study.

A study is a module (in a folder: its `study.py`) with

    TITLE, QUESTION     its title and question on the page
    TABLES              by name, the content of each table and the meaning of each of its columns (`Table`)
    TAKES               the options it accepts, of "case" and "solver": a study may have its own scenes or contestants
    TAB                 the tab of the page: "evidence" (how we know) or "errors" (why engines err)
    IN_REPORT           whether a report includes it
    run(request, calls)     returns the findings; its runs are those of `running.experiment.run_cases`, with settings,
                            cases and truths of its own, and a failure is a row
    rows(findings)          returns the rows of each table
    summary(findings)       optional: text for the terminal instead of the tables
    in_words(findings)      optional: a text for each scene on the page
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import cases
from cases import BadValue
from cases.errors import unknown_name

from ..running.names import REFERENCE

if TYPE_CHECKING:
    import pandas as pd

    from cases import Case

    from ..analysis.columns import Table
    from ..running.calls import Calls


# What to type for the study `maps` of older versions.
MAPS = "slip-to-roll sweep disc_in_circle --vary mu=0.01:0.4:121 --vary xi1=0:1.5:91"
# Studies of older versions that measure the suite itself or depend on no engine, and their modules in a clone.
MOVED = {name: f"tests.benchmarks.{name}" for name in ("meanings", "paper", "reference_cost", "settings", "uniqueness")}


class Request(NamedTuple):
    """The options of a study: cases (empty: the study's own), solvers, and whether to run without a time budget."""

    cases: tuple[Case, ...] = ()
    solvers: tuple[str, ...] = ()
    full: bool = False

    @property
    def engines(self) -> tuple[str, ...]:
        """The solvers without the reference."""
        return tuple(name for name in self.solvers if name != REFERENCE)

    def cases_or(self, defaults: Sequence[str]) -> tuple[Case, ...]:
        """The requested cases, otherwise the study's default cases with all their variants."""
        return self.cases or tuple(case for text in defaults for case in cases.select(text))


class Result(NamedTuple):
    """Outcome of a study: its module, the command that reproduces it, its tables and findings, or the reason of its
    failure."""

    name: str
    study: ModuleType
    command: str
    frames: dict[str, pd.DataFrame] = {}
    findings: Any = None
    failure: str = ""

    @property
    def words(self) -> dict[str, Table]:
        """Descriptions of its tables."""
        from ..analysis.columns import with_version_words

        return {name: with_version_words(self.study.TABLES[name], frame) for name, frame in self.frames.items()}


def names() -> tuple[str, ...]:
    """Every study's name, in alphabetical order. Imports none of them."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def study(name: str) -> ModuleType:
    """The study of that name; raises UnknownName, and BadValue for one of `MOVED`."""
    if name in MOVED:
        raise BadValue(f"{name} is no study of engines' runs; in a clone type: python -m tests.benchmarks {name}")
    if name == "maps":
        raise BadValue(f"maps is a sweep; type: {MAPS}")
    if name not in names():
        raise unknown_name("study", name, names())
    module = importlib.import_module(f"{__name__}.{name}")
    return importlib.import_module(f"{module.__name__}.study") if hasattr(module, "__path__") else module


def run_study(name: str, request: Request, calls: Calls, command: str) -> Result:
    """Run a study. A failure is recorded in the result and affects nothing else."""
    module = study(name)
    try:
        # Solvers that are not installed are skipped.
        present = calls.present(request.solvers) if request.solvers else ()
        findings = module.run(request._replace(solvers=present), calls)
        return Result(name, module, command, _frames(module.rows(findings), calls), findings)
    except Exception as problem:  # the report continues without this study and shows the reason
        return Result(name, module, command, failure=f"{type(problem).__name__}: {problem}")


def _frames(rows: Mapping[str, Any], calls: Calls) -> dict[str, pd.DataFrame]:
    """Tables as data frames; raises ValueError for an infinite result."""
    import pandas as pd

    from ..analysis.columns import infinite, with_version

    frames = {table: with_version(pd.DataFrame(rows[table]), calls.versions) for table in rows}
    for table, frame in frames.items():
        if infinite(frame):
            raise ValueError(f"the table {table} has an infinite result in {', '.join(infinite(frame))}")
    return frames
