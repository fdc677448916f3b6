"""Records of an experiment, plain and frozen: they are sent between processes and become the rows of the tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from math import inf, nan

import numpy as np

from adapters import Setting
from cases import Case, Cost, Mode, Transition

from ..judging.distances import Distance
from ..judging.grades import LIMITS, Grade, is_within
from ..judging.impacts import ImpactRow, ImpulseRow
from ..judging.law_error import LawError
from ..judging.ledger import LedgerRow
from ..judging.score import Scale, Score
from ..judging.validation import Residuals
from .names import REFERENCE

# Runs are compared with the motion of the reference's best method at this tolerance; the times of its transitions and
# their error bars are the certified ones.
TRUTH_RTOL = 1e-13

# A row of a table, as it is sent and stored.
Row = dict[str, str | float | int | bool | None]


@dataclass(frozen=True)
class Offer:
    """The ladder of settings that one route of a solver offers for a case, or the reason why there is none.

    `outcome` is "" for an offer, else "unsupported", "crashed" or "not_installed". `our_part`: what of the route is not
    the engine's own, "" for an engine by itself; `refusal`: whether the engine cannot or its adapter does not yet;
    `one_contact_only`: why it does not support motions with
    several contacts, "" if it does."""

    route: str
    settings: tuple[Setting, ...] = ()
    outcome: str = ""
    reason: str = ""
    our_part: str = ""
    one_contact_only: str = ""
    refusal: str = ""


@dataclass(frozen=True)
class Truth:
    """The motion that a case's runs are compared with, by `method` of the reference. `error_bars` (s) belong to
    `transitions`.

    `kinds` says for each transition whether it is proved or witnessed (empty: all witnessed). `samples` is for figures;
    `witnesses` are the ways of solving that agree within the bars. `failure` is the reason why there is no truth; the
    other fields are then empty.
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
    scales: dict[str, Scale] = field(default_factory=dict)  # of each contact by its name, "" for the only one
    contact_samples: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)  # for the player, by contact
    plate_samples: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)  # for the player, by free plate
    friction_sensitivity: float = float("nan")  # the score that 1 % of friction makes
    centre_bar: float = float("nan")  # error bar of the motion's centre, m
    kinds: tuple[str, ...] = ()

    def without_samples(self) -> Truth:
        """The truth by which runs are judged, without what only figures show."""
        return replace(self, samples={}, contact_samples={}, plate_samples={})

    @property
    def has_several_contacts(self) -> bool:
        """Whether the plate touches its track in several places."""
        return len(self.scales) > 1

    @property
    def scale(self) -> Scale | None:
        """The errors of motions that ignore friction's law; of several contacts, the first one's."""
        return next(iter(self.scales.values()), None)


@dataclass(frozen=True)
class Run:
    """One row of the experiment: solver, setting, outcome, and the comparison with the truth.

    `outcome` is one of answered, unsupported, crashed, timed_out. An answered run has a `score`, a `grade`, its
    friction × and law error (NaN where they are not known), and as `reason` what the grade is due to; any other has why
    there is no motion. `refusal`: whether the engine cannot do an unsupported case, or its adapter does not yet.
    `off` (solver minus truth) is for figures, thinned; `spreads` (s) are the reading doubts of the solver's
    transitions; `impacts` those on the track, or on several contacts, and `impulses` what each contact does in them;
    `residuals` are those of hard scenes. `when`:
    time of the run, since CPU times vary from day to day.
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
    off: dict[str, np.ndarray] = field(default_factory=dict)
    when: str = ""
    score: Score | None = None
    friction_factor: float = float("nan")
    law: LawError = LawError()
    grade: str = ""
    sequence: str = ""
    impacts: tuple[ImpactRow, ...] = ()
    impulses: tuple[ImpulseRow, ...] = ()
    refusal: str = ""
    residuals: Residuals = Residuals()


@dataclass(frozen=True)
class Experiment:
    """All results in the requested order: truths by case label, and the runs. The default settings and the finest run
    of each route have their `off`; of one case every run has it. `versions`: of the solvers, "" if
    unknown. `our_parts`: by solver and route, what of it is not the engine's own, for routes that have such a part."""

    cases: tuple[Case, ...]
    truths: dict[str, Truth]
    runs: tuple[Run, ...]
    versions: dict[str, str] = field(default_factory=dict)
    our_parts: dict[tuple[str, str], str] = field(default_factory=dict)


def gives_motion(run: Run) -> bool:
    """Whether a rung of the ladder, not the default settings, gave a motion."""
    return run.outcome == "answered" and not run.setting.is_default


def usable(run: Run) -> bool:
    """Whether a run gave a motion that is certainly better than the worst grade."""
    return run.score is not None and is_within(run.score, LIMITS[Grade.POOR]) is True


def is_default(run: Run) -> bool:
    """Whether the run has the engine's default settings."""
    return run.setting.is_default


def is_truth(run: Run, truth: Truth) -> bool:
    """Whether the run is the one that all others are compared with, so that its error is zero by construction."""
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
    """The run with the engine's default settings, if the route has one: of those of its grid that gave a motion the one
    with the median error (of an even number the better one in the middle), else the first."""
    by_error = sorted(defaults(group), key=lambda run: run.score.off if run.score else inf)
    return by_error[(len(by_error) - 1) // 2] if by_error else next(filter(is_default, group), None)


def defaults(group: Sequence[Run]) -> list[Run]:
    """The runs with default settings that gave a motion: the grid of usual values."""
    return [run for run in group if is_default(run) and run.score is not None]


def one_default(settings: Iterable[Setting]) -> list[Setting]:
    """The settings without those of the grid of default settings except its first."""
    firsts: list[Setting] = []
    for setting in settings:
        if not setting.is_default or not any(other.is_default for other in firsts):
            firsts.append(setting)
    return firsts


def first_error(run: Run | None) -> float:
    """Error of the time of the truth's first transition, s; NaN if it was missed or there is none."""
    rows = [row for row in run.ledger if row.event == 1 and row.is_true] if run else []
    return rows[0].error if rows else nan


def now() -> str:
    """The time, UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")
