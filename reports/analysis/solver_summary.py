"""The answer in one table: a row for each solver and route, over all cases of a report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from math import isfinite, nan
from statistics import median
from typing import TYPE_CHECKING, Any

from ..running.records import Experiment, Run, default, finest, first_error, is_truth, routes

if TYPE_CHECKING:
    import pandas as pd

FAILED = ("crashed", "timed_out")


def rows(experiment: Experiment, frames: Mapping[str, pd.DataFrame] | None = None) -> list[dict[str, Any]]:
    """One row per solver and route; the costs beside them: `advice`.

    `cases`: those it was asked; `right`, `wrong`, `refused`, `failed` (crashed or timed out): what came of its finest
    setting; `middle_default_error`, `middle_finest_error` (s): the median over the cases of the first transition's
    error, without the motions that are the truth itself (`is_truth`: all are); `hard_right`, …: what came of the study
    of hard scenes, where the report has it.
    """
    found: dict[tuple[str, str], list[list[Run]]] = {}
    for (_, solver, route), group in routes(experiment.runs).items():
        found.setdefault((solver, route), []).append(group)
    told: list[dict[str, Any]] = []
    for (solver, route), groups in found.items():
        last = [finest(group) or group[-1] for group in groups]
        judged = [run for run in last if not is_truth(run, experiment.truths[run.case])]
        told.append(
            {"solver": solver, "route": route, "cases": len(groups), **_count(run.outcome for run in last)}
            | {"middle_default_error": _middle(map(default, groups)), "middle_finest_error": _middle(judged)}
            | {"is_truth": not judged}
        )
    stability = (frames or {}).get("stability")
    if stability is not None:
        hard: dict[tuple[str, str], list[str]] = {}
        # The settings of a scene are in their order, the finest last.
        for scene in stability.drop_duplicates(["case", "solver", "route"], keep="last").to_dict("records"):
            hard.setdefault((scene["solver"], scene["route"]), []).append(scene["outcome"])
        for row in told:
            outcomes = _count(hard.get((row["solver"], row["route"]), ()))
            row.update({f"hard_{name}": count for name, count in outcomes.items()})
    return told


def _count(outcomes: Iterable[str]) -> dict[str, int]:
    count = Counter(outcomes)
    named = {name: count[name] for name in ("right", "wrong", "refused")}
    return named | {"failed": sum(count[name] for name in FAILED)}


def _middle(runs: Iterable[Run | None]) -> float:
    """The median size of the first transition's error, s; NaN without one."""
    sizes = [abs(first_error(run)) for run in runs]
    return median(known) if (known := [size for size in sizes if isfinite(size)]) else nan
