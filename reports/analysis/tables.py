"""Runs -> rows: one per fact, lower-case snake_case columns. Times in s, errors in the unit of their quantity."""

from __future__ import annotations

from collections import Counter
from math import isfinite, nan
from typing import Any

from reference.certification import WITNESSED, confirmations

from ..judging.friction_sensitivity import CHANGE, LEAST, not_ranked
from ..judging.grades import Grade
from ..running.records import Experiment, Run, default, defaults, finest, first_error, is_truth, routes
from ..running.solvers import NOT_INSTALLED
from . import levels
from .convergence import convergence_rows

OUTCOMES = ("answered", "unsupported", "crashed", "timed_out", NOT_INSTALLED)


def run_keys(run: Run) -> dict[str, Any]:
    """The columns that identify a run."""
    return {"case": run.case, "solver": run.solver, "route": run.route, "setting": run.setting}


# --- the tables -------------------------------------------------------------------------------------------------------


def truth_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """The motions that runs are compared with: a row per transition, or one with event 0 for a case without any."""
    rows = []
    for label, truth in experiment.truths.items():
        common: dict[str, Any] = {
            "case": label,
            "method": truth.method,
            "first_mode": truth.first_mode,
            "status": truth.status,
        }
        common |= {
            "friction_sensitivity": truth.friction_sensitivity,
            "friction_share": truth.scale.share if truth.scale and isfinite(truth.scale.share) else nan,
            "not_ranked": not_ranked(truth.friction_sensitivity, truth.scale),
        }
        parts = confirmations(truth.witnesses).items()
        notes = truth.failure or "; ".join(f"{what}: {', '.join(names)}" for what, names in parts)
        kinds = truth.kinds or (WITNESSED,) * len(truth.transitions)
        certified = zip(truth.transitions, truth.error_bars, kinds, strict=True)
        for event, (transition, bar, kind) in enumerate(certified, start=1):
            event_columns = {"before": transition.before, "after": transition.after, "time": transition.time}
            event_columns |= {"truth_error_bar": bar, "certificate": kind, "contact": transition.contact}
            rows.append({**common, "event": event, **event_columns, "notes": notes})
        if not truth.transitions:
            none = {"before": "", "after": "", "time": nan, "truth_error_bar": nan, "certificate": "", "contact": ""}
            rows.append({**common, "event": 0, **none, "notes": notes})
    return rows


def transition_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per transition of the truth or of a run. `reading_doubt`, s: the change of the time if it is read from
    other samples; empty for a solver that locates its transitions itself."""
    rows = []
    for run in experiment.runs:
        bars, doubts = experiment.truths[run.case].error_bars, _reading_doubts(run)
        for place, row in enumerate(run.ledger):
            rows.append(
                {
                    **run_keys(run),
                    "event": row.event,
                    "before": row.before,
                    "after": row.after,
                    "time": row.time,
                    "reference_time": row.reference_time,
                    "error": row.error,
                    "truth_error_bar": bars[row.event - 1] if row.is_true else nan,
                    "pairing": row.pairing,
                    "contact": row.contact,
                    "reading_doubt": doubts.get(place, nan),
                }
            )
    return rows


def impact_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per impact of a motion, next to the truth's, and with several contacts one with event 0 for the time of
    rest. There is no error of a plate that ends at rest later than its case."""
    return [
        {
            **run_keys(run),
            "event": row.event,
            "contact": row.contact,
            "time": row.time,
            "reference_time": row.reference_time,
            "error": row.time - row.reference_time,
            "swing": row.swing,
            "reference_swing": row.reference_swing,
            "closing_speed": row.closing,
            "reference_closing_speed": row.reference_closing,
            "restitution": row.restitution,
            "reference_restitution": row.reference_restitution,
        }
        for run in experiment.runs
        for row in run.impacts
    ]


def impulse_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per contact in each impact of the truth: its impulses and their work, and those of the run."""
    return [{**run_keys(run), **row._asdict()} for run in experiment.runs for row in run.impulses]


def _reading_doubts(run: Run) -> dict[int, float]:
    """The doubt of each of the solver's own transitions by its place in the ledger."""
    own = [place for place, row in enumerate(run.ledger) if isfinite(row.time)]
    # `spreads` are in the order in which the solver has them.
    own.sort(key=lambda place: run.ledger[place].time)
    return dict(zip(own, run.spreads, strict=False))


def trajectory_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per run, whatever its outcome."""
    rows = []
    for run in experiment.runs:
        pairings = Counter(row.pairing for row in run.ledger)
        rows.append(
            {
                **run_keys(run),
                "outcome": run.outcome,
                **_score_columns(run, experiment.truths[run.case].friction_sensitivity),
                "status": run.status,
                "first_mode": run.first_mode,
                "transitions_true": len(experiment.truths[run.case].transitions),
                **{name: pairings[name] for name in ("paired", "missed", "spurious")},
                **run.distance._asdict(),
                "cpu_s": run.cost.cpu_s,
                "setup_s": run.cost.setup_s,
                "steps": run.cost.steps,
                "run_at": run.when,
                "law_error": run.law.median,
                "law_error_at": run.law.time,
            }
        )
    return rows


def _score_columns(run: Run, sensitivity: float) -> dict[str, Any]:
    """The grade of a run with its reason, and the score. `sensitivity`: off of 1 % of friction."""
    score = run.score
    return {
        "grade": str(run.grade),
        "off": score.off if score else nan,
        "off_doubt": score.doubt if score else nan,
        "mu_equivalent": score.off * CHANGE / sensitivity if score and sensitivity >= LEAST else nan,
        "friction_factor": run.friction_factor,
        "reason": run.reason,
        "refusal": run.refusal,
        "sequence": run.sequence,
        "pose_score": score.pose if score else nan,
        "mode_score": score.mode if score else nan,
        "slip_score": score.slip if score else nan,
        "creep": score.creep if score else nan,
    }


def _off_columns(name: str, run: Run | None) -> dict[str, Any]:
    """Off of a run with its doubt and grade."""
    score = run.score if run else None
    return {
        f"{name}_off": score.off if score else nan,
        f"{name}_off_doubt": score.doubt if score else nan,
        f"{name}_grade": run.grade if run else "",
    }


def headline_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per case and route: grade and errors with default settings and at the finest setting run, and the
    smallest level that the ladder reaches."""
    orders = {
        (row["case"], row["solver"], row["route"]): row["order"]
        for row in convergence_rows(experiment)
        if row["quantity"] == "first_transition_time"
    }
    results: dict[tuple[str, str, str], list[levels.LevelResult]] = {}
    for one in levels.level_results(experiment):
        results.setdefault(one[:3], []).append(one)
    rows = []
    for key, group in routes(experiment.runs).items():
        fine, own, truth, grid = finest(group), default(group), experiment.truths[key[0]], defaults(group)
        row: dict[str, Any] = dict(zip(("case", "solver", "route"), key, strict=True))
        row["level"], row["settings_within"] = levels.finest_level(results.get(key, ()))
        for name, run in (("default", own), ("finest", fine)):
            row |= {
                **_off_columns(name, run),
                f"{name}_friction_factor": run.friction_factor if run else nan,
                f"{name}_first_error": first_error(run),
                f"{name}_centre_max": run.distance.centre_max if run else nan,
            }
        row |= {
            "default_off_best": min((run.score.off for run in grid if run.score), default=nan),
            "default_off_worst": max((run.score.off for run in grid if run.score), default=nan),
            "default_settings": len(grid),
            "default_outcome": own.outcome if own else "",
            "finest_outcome": fine.outcome if fine else group[-1].outcome,
            "finest_setting": str(fine.setting) if fine else "",
            "order": orders.get(key, nan),
            "transitions_true": len(truth.transitions),
            "truth_error_bar": truth.error_bars[0] if truth.error_bars else nan,
            "is_truth": bool(fine and is_truth(fine, truth)),
        }
        rows.append(row)
    return rows


def outcome_counts(experiment: Experiment) -> str:
    """The numbers of outcomes in words, with the grades of the answered runs."""
    outcomes = Counter(run.outcome for run in experiment.runs)
    grades = Counter(run.grade for run in experiment.runs)
    words = [f"{outcomes[name]} {name.replace('_', ' ')}" for name in OUTCOMES if outcomes[name]]
    of_grades = ", ".join(f"{grades[name]} {name}" for name in Grade if grades[name])
    return ", ".join(f"{text} ({of_grades})" if text.endswith("answered") else text for text in words)
