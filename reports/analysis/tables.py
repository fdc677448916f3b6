"""Runs -> rows: one per fact, lower-case snake_case columns. Times in s, errors in the unit of their quantity."""

from __future__ import annotations

from collections import Counter
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import reference
from cases.compile_cache import cached

from ..running.records import Experiment, Run, default, finest, first_error, is_truth, routes
from ..running.storage.fingerprint import installed_packages
from . import accuracy_levels, quantities
from .convergence import convergence_rows

if TYPE_CHECKING:
    import pandas as pd

OUTCOMES = ("right", "wrong", "refused", "crashed", "timed_out")


# --- the tables -------------------------------------------------------------------------------------------------------


def errata_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """The paper's misprints, each formula evaluated; they are the same for every experiment, and kept."""

    def make() -> list[dict[str, Any]]:
        from reference.errata import errata  # it imports SciPy's integrators, a quarter of a second

        # A verdict is said of transitions; what is found of a formula has a name of its own.
        return [
            {"finding" if name == "verdict" else name: value for name, value in erratum._asdict().items()}
            for erratum in errata()
        ]

    return cached("errata", (installed_packages("scipy"),), Path(reference.__file__).parent, make)


def truth_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """The motions the runs are judged by: one row per transition, or one with event 0 for a case without."""
    rows = []
    for label, truth in experiment.truths.items():
        common: dict[str, Any] = {
            "case": label,
            "method": truth.method,
            "first_mode": truth.first_mode,
            "status": truth.status,
        }
        common |= {"friction_sensitivity": truth.friction_sensitivity}
        notes = truth.failure or f"witnesses: {', '.join(truth.witnesses)}"
        for event, (transition, bar) in enumerate(zip(truth.transitions, truth.error_bars, strict=True), start=1):
            told = {"before": transition.before, "after": transition.after, "time": transition.time}
            rows.append({**common, "event": event, **told, "truth_error_bar": bar, "notes": notes})
        if not truth.transitions:
            none = {"before": "", "after": "", "time": nan, "truth_error_bar": nan}
            rows.append({**common, "event": 0, **none, "notes": notes})
    return rows


def transition_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per transition of the truth or of a run: matched, missed, unresolved or spurious. `reading_doubt`, s: how
    far the time moves when it is read from other samples; empty for a solver that locates its transitions itself."""
    rows = []
    for run in experiment.runs:
        bars, doubts = experiment.truths[run.case].error_bars, _reading_doubts(run)
        for place, row in enumerate(run.ledger):
            rows.append(
                {
                    "case": run.case,
                    "solver": run.solver,
                    "route": run.route,
                    "setting": run.setting,
                    "event": row.event,
                    "before": row.before,
                    "after": row.after,
                    "time": row.time,
                    "reference_time": row.reference_time,
                    "error": row.error,
                    "truth_error_bar": nan if row.verdict == "spurious" else bars[row.event - 1],
                    "verdict": row.verdict,
                    "reading_doubt": doubts.get(place, nan),
                }
            )
    return rows


def _reading_doubts(run: Run) -> dict[int, float]:
    """The doubt of each of the solver's own transitions by its place in the ledger."""
    own = [place for place, row in enumerate(run.ledger) if isfinite(row.time)]
    # `spreads` are in the order in which the solver has them.
    own.sort(key=lambda place: run.ledger[place].time)
    return dict(zip(own, run.spreads, strict=False))


def trajectory_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per run, whatever came of it."""
    rows = []
    for run in experiment.runs:
        verdicts = Counter(row.verdict for row in run.ledger)
        rows.append(
            {
                "case": run.case,
                "solver": run.solver,
                "route": run.route,
                "setting": run.setting,
                "outcome": run.outcome,
                "reason": run.reason,
                **_score_columns(run),
                "status": run.status,
                "first_mode": run.first_mode,
                "transitions_true": len(experiment.truths[run.case].transitions),
                "matched": verdicts["matched"],
                "missed": verdicts["missed"],
                "spurious": verdicts["spurious"],
                **run.distance._asdict(),
                "cpu_s": run.cost.cpu_s,
                "setup_s": run.cost.setup_s,
                "steps": run.cost.steps,
                "run_at": run.when,
            }
        )
    return rows


def _score_columns(run: Run) -> dict[str, Any]:
    """The score of a run, its grade and the reason for it."""
    score = run.score
    return {
        "grade": run.grade,
        "grade_reason": run.grade_reason,
        "sequence": run.sequence,
        "off": score.off if score else nan,
        "off_doubt": score.doubt if score else nan,
        "friction_factor": run.friction_factor,
        "pose_score": score.pose if score else nan,
        "mode_score": score.mode if score else nan,
        "slip_score": score.slip if score else nan,
        "creep": score.creep if score else nan,
    }


def headline_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per case and route, default and finest: the error of the quantity that leads the case, which chance
    cannot meet, and what the ladder reached in it; beside it the first transition's error and the centre's."""
    orders = {
        (row["case"], row["solver"], row["route"]): row["order"]
        for row in convergence_rows(experiment)
        if row["quantity"] == "first_transition_time"
    }
    rows = []
    for (case, solver, route), group in routes(experiment.runs).items():
        fine, own, truth = finest(group), default(group), experiment.truths[case]
        lead = quantities.lead(truth)
        row: dict[str, Any] = {"case": case, "solver": solver, "route": route}
        row |= {"lead_quantity": lead, "unit": quantities.UNITS[lead]}
        row["reached"] = accuracy_levels.finest_level(group, lead, truth)
        row["lead_error_bar"] = quantities.bar(truth, lead, {})
        for name, run in (("default", own), ("finest", fine)):
            row |= {
                f"{name}_lead_error": quantities.error(run, lead) if run else nan,
                f"{name}_first_error": first_error(run),
                f"{name}_centre_max": run.distance.centre_max if run else nan,
            }
        row |= {
            "default_outcome": own.outcome if own else "",
            "finest_outcome": fine.outcome if fine else group[-1].outcome,
            "finest_setting": str(fine.setting) if fine else "",
            "order": orders.get((case, solver, route), nan),
            "transitions_true": len(truth.transitions),
            "truth_error_bar": truth.error_bars[0] if truth.error_bars else nan,
            "is_truth": bool(fine and is_truth(fine, truth)),
        }
        rows.append(row)
    return rows


def outcome_counts(experiment: Experiment) -> dict[str, Counter]:
    """Outcomes by solver."""
    counts: dict[str, Counter] = {}
    for run in experiment.runs:
        counts.setdefault(run.solver, Counter())[run.outcome] += 1
    return counts


TABLES = {
    "headline": headline_rows,
    "transitions": transition_rows,
    "trajectories": trajectory_rows,
    "convergence": convergence_rows,
    "truth": truth_rows,
    "errata": errata_rows,
}
HOLDS = {
    "headline": "What each route reaches, and its errors at the finest setting and as the engine comes",
    "transitions": (
        "Every transition of every run: matched, missed, unresolved (a rebound too short for its samples) or spurious"
    ),
    "trajectories": "Every run: outcome, grade and score, distance from the truth, cost",
    "convergence": "Observed order of every route",
    "truth": "The certified transitions the runs are judged by",
    "errata": "The paper's misprints, each formula evaluated (residuals relative to what it must equal)",
}


def frames(experiment: Experiment) -> dict[str, pd.DataFrame]:
    """Every table by name."""
    import pandas as pd

    return {name: pd.DataFrame(make(experiment)) for name, make in TABLES.items()}
