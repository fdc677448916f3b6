"""What an experiment finds out, as plain frozen records: they travel between processes and become the tables' rows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from math import nan

import numpy as np

from adapters import Setting
from cases import Case, Cost, Mode, Transition

from ..judging.distances import Distance
from ..judging.ledger import LedgerRow
from ..judging.score import Scale, Score

REFERENCE = "reference"
# The motion that runs are compared with is the reference's best method at this tolerance; the times of its transitions
# and their error bars are the certified ones.
TRUTH_RTOL = 1e-13
# No honest sentence is longer; the last error message of an engine fits.
_LONGEST_TEXT = 2000

# A row of a table, as it travels and is kept.
Row = dict[str, str | float | int | bool | None]


@dataclass(frozen=True)
class Offer:
    """What one route of a solver offers for a case: a ladder of settings, or the reason why not.

    `outcome` is "" for an offer, else "refused", "crashed" or "not_installed". `our_part`: what of the route is not the
    engine's own, "" for an engine by itself."""

    route: str
    settings: tuple[Setting, ...] = ()
    outcome: str = ""
    reason: str = ""
    our_part: str = ""


@dataclass(frozen=True)
class Truth:
    """The motion a case's runs are judged by, by `method` of the reference. `error_bars` (s) belong to `transitions`.

    `samples` is for figures; `witnesses` are the ways of solving that agree within the bars. `failure` is a
    sentence if there is no truth to be had; the rest is then empty.
    """

    method: str = ""
    transitions: tuple[Transition, ...] = ()
    error_bars: tuple[float, ...] = ()
    first_mode: Mode | None = None
    status: str = ""
    reason: str = ""
    samples: dict[str, np.ndarray] = field(default_factory=dict)
    witnesses: tuple[str, ...] = ()
    failure: str = ""
    scale: Scale | None = None  # what the scores of its runs are measured by
    friction_sensitivity: float = float("nan")  # the score that 1 % of friction makes
    centre_bar: float = float("nan")  # m; how sure the motion's centre is


@dataclass(frozen=True)
class Run:
    """One row of the experiment: who ran what, what came of it, and how it compares with the truth.

    `outcome` is one of right, wrong, refused, crashed, timed_out. `samples` and `off` (solver minus truth) are for
    figures, thinned; `spreads` (s) tell how sure the reading of each of the solver's transitions is. `when` it was
    run: times of another day are that day's.
    """

    case: str
    solver: str
    route: str
    setting: Setting
    rung: int
    outcome: str
    reason: str = ""
    status: str = ""
    first_mode: str = ""
    ledger: tuple[LedgerRow, ...] = ()
    spreads: tuple[float, ...] = ()
    distance: Distance = Distance(*6 * (float("nan"),))
    cost: Cost = Cost()
    samples: dict[str, np.ndarray] = field(default_factory=dict)
    off: dict[str, np.ndarray] = field(default_factory=dict)
    when: str = ""
    score: Score | None = None
    friction_factor: float = float("nan")
    grade: str = ""
    grade_reason: str = ""
    sequence: str = ""


@dataclass(frozen=True)
class Experiment:
    """Everything that was found out, in the order asked for: truths by case label, and the runs. Only the finest run
    of each route still has its `samples` and `off`. `versions`: of the solvers, "" where one could not tell.
    `our_parts`: by solver and route, what of it is not the engine's own, for routes that have such a part."""

    cases: tuple[Case, ...]
    truths: dict[str, Truth]
    runs: tuple[Run, ...]
    seconds: float
    versions: dict[str, str] = field(default_factory=dict)
    our_parts: dict[tuple[str, str], str] = field(default_factory=dict)


def gives_motion(run: Run) -> bool:
    """Whether a rung of the ladder, not the engine as it comes, gave a motion."""
    return run.outcome in ("right", "wrong") and not run.setting.is_default


def is_default(run: Run) -> bool:
    """Whether the run is the engine as it comes."""
    return run.setting.is_default


def is_truth(run: Run, truth: Truth) -> bool:
    """Whether the run is the very one the others are judged by, so that its error is zero by construction."""
    return run.solver == REFERENCE and run.route == truth.method and run.setting == Setting.of(rtol=TRUTH_RTOL)


def routes(runs: Iterable[Run]) -> dict[tuple[str, str, str], list[Run]]:
    """Runs by (case, solver, route), each from coarse to fine."""
    groups: dict[tuple[str, str, str], list[Run]] = {}
    for run in runs:
        groups.setdefault((run.case, run.solver, run.route), []).append(run)
    return groups


def finest(group: Sequence[Run]) -> Run | None:
    """The finest rung that gave a motion, or None."""
    return next((run for run in reversed(group) if gives_motion(run)), None)


def default(group: Sequence[Run]) -> Run | None:
    """The engine's own settings, if the route has such a rung."""
    return next((run for run in group if is_default(run)), None)


def first_error(run: Run | None) -> float:
    """Error of the time of the truth's first transition, s; NaN if it was missed or there is none."""
    rows = [row for row in run.ledger if row.event == 1 and row.verdict != "spurious"] if run else []
    return rows[0].error if rows else nan


def now() -> str:
    """The time, UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def legible(text: object, most: int = _LONGEST_TEXT) -> str:
    """What a solver says, as text that every file and terminal can hold: of at most so many characters, what is no
    printable character (a lone surrogate, NUL, an escape) spelled out."""
    whole = str(text)
    shown = whole if len(whole) <= most else f"{whole[: most - 1]}…"
    return "".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in shown)
