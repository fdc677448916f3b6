"""Runs -> tables: one row per fact, lower-case snake_case columns. Times in s, errors in the unit of their quantity."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from reference.errata import errata

from ..running.records import REFERENCE, TRUTH_RTOL, Experiment, Run, Truth, gives_motion, is_default_setting
from . import convergence as fits

if TYPE_CHECKING:
    import pandas as pd

# Columns that hold errors, by the end of their names.
_ERRORS = ("error", "error_bar", "_max", "_rms", "_mean", "_final", "_doubt", "accuracy")
OUTCOMES = ("right", "wrong", "refused", "crashed", "timed_out")

# Rounding of a time read at the end of a run of very many steps, in units of its last place.
_ULPS = 16


def is_default(run: Run) -> bool:
    """Whether the run is the engine as it comes."""
    return is_default_setting(run.setting)


def is_truth(run: Run, truth: Truth) -> bool:
    """Whether the run is the very one the others are judged by, so that its error is zero by construction."""
    return run.solver == REFERENCE and run.route == truth.method and run.setting == f"rtol={TRUTH_RTOL:g}"


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


# --- the tables -------------------------------------------------------------------------------------------------------


def errata_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """The paper's misprints, each formula evaluated; they are the same for every experiment."""
    return [erratum._asdict() for erratum in errata()]


def truth_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """The motions the runs are judged by: one row per transition, or one with event 0 for a case without."""
    rows = []
    for label, truth in experiment.truths.items():
        common = {"case": label, "method": truth.method, "first_mode": truth.first_mode, "status": truth.status}
        notes = truth.failure or f"witnesses: {', '.join(truth.witnesses)}"
        for event, (transition, bar) in enumerate(zip(truth.transitions, truth.error_bars, strict=True), start=1):
            told = {"before": transition.before, "after": transition.after, "time": transition.time}
            rows.append({**common, "event": event, **told, "truth_error_bar": bar, "notes": notes})
        if not truth.transitions:
            none = {"before": "", "after": "", "time": nan, "truth_error_bar": nan}
            rows.append({**common, "event": 0, **none, "notes": notes})
    return rows


def transition_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per transition of the truth or of a run: matched, missed or spurious. `reading_doubt`, s: how far the
    time moves when it is read from other samples; empty for a solver that locates its transitions itself."""
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


def convergence_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per route and quantity: the observed order with its confidence interval, the error of the finest rung,
    and what keeps the finest rungs from improving (`fits`)."""
    rows = []
    for (case, solver, route), group in routes(experiment.runs).items():
        fine = finest(group)
        if fine is None:
            continue
        truth = experiment.truths[case]
        ladder = [run for run in group if run.outcome == "right" and not is_default(run) and not is_truth(run, truth)]
        quantities = [("centre_max", [run.distance.centre_max for run in ladder], 0.0, fine.distance.centre_max)]
        if truth.transitions:
            errors = [first_error(run) for run in ladder]
            quantities.insert(0, ("first_transition_time", errors, _floor(truth), first_error(fine)))
        for quantity, errors, floor, finest_error in quantities:
            points = _points(ladder, errors, floor)
            fit, settled = fits.order(points), fits.saturation(points)
            rows.append(
                {
                    "case": case,
                    "solver": solver,
                    "route": route,
                    "quantity": quantity,
                    "order": fit.order,
                    "order_low": fit.low,
                    "order_high": fit.high,
                    "finest_error": finest_error,
                    "settings_used": " | ".join(fit.settings),
                    "note": fit.note,
                    "saturation": settled.cause,
                    "saturated_from": settled.setting,
                }
            )
    return rows


def _floor(truth: Truth) -> float:
    return max(truth.error_bars[0], _ULPS * float(np.spacing(truth.transitions[0].time)))


def _points(ladder: Sequence[Run], errors: Sequence[float], floor: float) -> list[fits.Point]:
    return [
        fits.Point(run.setting, run.cost.steps, abs(size), floor, _doubt(run), rounding(run))
        for run, size in zip(ladder, errors, strict=True)
    ]


def _doubt(run: Run) -> float:
    """How sure the reading of the first transition is, s."""
    return run.spreads[0] if run.spreads and isfinite(run.spreads[0]) else 0.0


def rounding(run: Run) -> float:
    """Rounding of a sum of as many terms as the run has steps, of the order one."""
    return float(np.finfo(float).eps) * max(run.cost.steps, 1) ** 0.5


def headline_rows(experiment: Experiment) -> list[dict[str, Any]]:
    """One row per case and route: first-transition error (where there is one) and centre error, default and finest."""
    orders = {
        (row["case"], row["solver"], row["route"]): row["order"]
        for row in convergence_rows(experiment)
        if row["quantity"] == "first_transition_time"
    }
    rows = []
    for (case, solver, route), group in routes(experiment.runs).items():
        fine, own, truth = finest(group), default(group), experiment.truths[case]
        rows.append(
            {
                "case": case,
                "solver": solver,
                "route": route,
                "default_error": first_error(own),
                "default_centre_max": own.distance.centre_max if own else nan,
                "default_outcome": own.outcome if own else "",
                "finest_error": first_error(fine),
                "finest_centre_max": fine.distance.centre_max if fine else nan,
                "finest_outcome": fine.outcome if fine else group[-1].outcome,
                "finest_setting": fine.setting if fine else "",
                "order": orders.get((case, solver, route), nan),
                "transitions": len(truth.transitions),
                "truth_error_bar": truth.error_bars[0] if truth.error_bars else nan,
                "is_truth": bool(fine and is_truth(fine, truth)),
            }
        )
    return rows


def error_text(row: Mapping[str, Any], column: str) -> str:
    """An error of a headline row (`default_error`, `finest_error`) with its sign, or in words where there is none.

    No more is claimed than the truth's error bar allows; without a transition the centre's error stands instead.
    """
    if column == "finest_error" and row["is_truth"]:
        return "is the truth"
    value, outcome = row[column], row[column.replace("error", "outcome")]
    if outcome in ("", "refused", "crashed", "timed_out"):
        return outcome
    doubt = "" if outcome == "right" else f" ({outcome})"
    if not row["transitions"]:
        return f"centre {row[column.replace('error', 'centre_max')]:.1e}{doubt}"
    if not isfinite(value):
        return "missed"
    bar = row["truth_error_bar"]
    return (f"{value:+.1e}" if abs(value) > bar else f"< {bar:.1e}") + doubt


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


def frames(experiment: Experiment) -> dict[str, pd.DataFrame]:
    """Every table by name."""
    import pandas as pd

    return {name: pd.DataFrame(make(experiment)) for name, make in TABLES.items()}


# --- files and text ---------------------------------------------------------------------------------------------------


def write(tables: dict[str, pd.DataFrame], folder: Path, command: str = "") -> None:
    """Each table as NAME.csv (all digits) and NAME.md (for reading, with the command that makes it again, if given)."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, frame in tables.items():
        frame.to_csv(folder / f"{name}.csv", index=False)
        again = f"\nMake it again: `{command}`\n" if command else ""
        (folder / f"{name}.md").write_text(f"{markdown(frame)}\n{again}", encoding="utf-8")


def markdown(frame: pd.DataFrame) -> str:
    """The table as a Markdown pipe table, numbers shortened for reading."""
    from tabulate import tabulate

    if frame.empty:
        return "No rows."
    columns = [str(column) for column in frame.columns]
    rows = [[shorten(row[c], c).replace("|", "\\|") for c in columns] for row in frame.to_dict("records")]
    return tabulate(rows, headers=columns, tablefmt="pipe", disable_numparse=True)


def shorten(value: Any, column: str) -> str:
    """A value as people read it: times with nine digits, errors with two, an empty cell where there is nothing."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else ""
    if isinstance(value, float | np.floating):
        if not isfinite(value):
            return ""
        if column in ("time", "reference_time"):
            return f"{value:.9g}"
        if column.endswith(_ERRORS):
            return f"{value:.1e}"
        return f"{value:.2f}" if column.startswith("order") else f"{value:.2g}"
    return "" if value is None else str(value)
