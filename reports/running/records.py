"""What an experiment finds out, as plain frozen records: they travel between processes and become the tables' rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from adapters import Setting
from cases import Case, Cost, Mode, Transition

from ..judging.distances import Distance
from ..judging.slip_phases import LedgerRow

REFERENCE = "reference"
# The motion that runs are compared with is the reference's best method at this tolerance; the times of its transitions
# and their error bars are the certified ones.
TRUTH_RTOL = 1e-13


class CaseKey(NamedTuple):
    """What names a case across processes: its name and parameters, and the files to be read before."""

    name: str
    parameters: tuple[tuple[str, Any], ...]
    files: tuple[str, ...]

    @classmethod
    def of(cls, case: Case, files: tuple[str, ...] = ()) -> CaseKey:
        """The key of a case of the catalogue or of `files`."""
        return cls(case.name, tuple(case.parameters.items()), files)


@dataclass(frozen=True)
class Offer:
    """What one route of a solver offers for a case: a ladder of settings, or the reason why not.

    `outcome` is "" for an offer, else "refused" or "crashed"."""

    route: str
    settings: tuple[Setting, ...] = ()
    outcome: str = ""
    reason: str = ""


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
    setting: str
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


@dataclass(frozen=True)
class Experiment:
    """Everything that was found out, in the order asked for: truths by case label, and the runs. Only the finest run
    of each route still has its `samples` and `off`. `versions`: of the solvers, "" where one could not tell."""

    cases: tuple[Case, ...]
    truths: dict[str, Truth]
    runs: tuple[Run, ...]
    seconds: float
    versions: dict[str, str] = field(default_factory=dict)


def gives_motion(run: Run) -> bool:
    """Whether a rung of the ladder, not the engine as it comes, gave a motion."""
    return run.outcome in ("right", "wrong") and not is_default_setting(run.setting)


def is_default_setting(setting: Setting | str) -> bool:
    """Whether a setting is the engine as it comes: adapters name that rung `rung=defaults`."""
    return "rung=defaults" in str(setting).split()
