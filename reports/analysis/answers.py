"""The answer in one table: a row for each solver and route, over all cases of a report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from math import isfinite, nan
from statistics import median
from typing import TYPE_CHECKING, Any

from ..running.records import Experiment, Run, default, finest, first_error, is_truth, routes
from .time_to_accuracy import DISTURBED, REACHED, cost

if TYPE_CHECKING:
    import pandas as pd

FAILED = ("crashed", "timed_out")


# Accuracies of what leads a case, and how many runs they are asked for.
LEVELS, RUNS = (1e-2, 1e-4), (1, 1000)


def rows(
    experiment: Experiment, frames: Mapping[str, pd.DataFrame] | None = None, told_cost: Sequence[dict[str, Any]] = ()
) -> list[dict[str, Any]]:
    """One row per solver and route.

    `cases`: those it was asked; `right`, `wrong`, `refused`, `failed` (crashed or timed out): what came of its finest
    setting; `default_error`, `finest_error` (s): the median over the cases of the first transition's error, without the
    motions that are the truth itself (`is_truth`: all are); `hard_right`, …: the same of the study of hard scenes,
    where the report has it.

    `told_cost`: rows of `time_to_accuracy`. With them `s_1e-4_once`, `s_1e-4_1000` and so on: the median CPU time of so
    many whole calls over the timed cases in which that accuracy was reached, and `reached_1e-4`, in how many of them; a
    word where the machine was too busy for all of them.
    """
    found: dict[tuple[str, str], list[list[Run]]] = {}
    for (_, solver, route), group in routes(experiment.runs).items():
        found.setdefault((solver, route), []).append(group)
    told: list[dict[str, Any]] = []
    for (solver, route), groups in found.items():
        last = [finest(group) or group[-1] for group in groups]
        judged = [run for run in last if not is_truth(run, experiment.truths[run.case])]
        told.append(
            {"solver": solver, "route": route, "cases": len(groups), **_counted(run.outcome for run in last)}
            | {"default_error": _middle(map(default, groups)), "finest_error": _middle(judged), "is_truth": not judged}
        )
    stability = (frames or {}).get("stability")
    if stability is not None:
        hard: dict[tuple[str, str], list[str]] = {}
        # The settings of a scene are in their order, the finest last.
        for scene in stability.drop_duplicates(["case", "solver", "route"], keep="last").to_dict("records"):
            hard.setdefault((scene["solver"], scene["route"]), []).append(scene["outcome"])
        for row in told:
            outcomes = _counted(hard.get((row["solver"], row["route"]), ()))
            row.update({f"hard_{name}": count for name, count in outcomes.items()})
    if told_cost:
        for row in told:
            row.update(_costs([r for r in told_cost if (r["solver"], r["route"]) == (row["solver"], row["route"])]))
    return told


def _costs(of_route: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """What a route's accuracies cost: rows of `time_to_accuracy` of one solver and route."""
    found: dict[str, Any] = {}
    for accuracy in LEVELS:
        level = f"{accuracy:.0e}".replace("e-0", "e-")
        asked = [r for r in of_route if r["lead"] and r["accuracy"] == accuracy]
        reached = [r for r in asked if r["award"] in (REACHED, DISTURBED)]
        found[f"reached_{level}"] = f"{len(reached)}/{len(asked)}"
        for runs in RUNS:
            sure = [r for r in reached if r["award"] == REACHED]
            spent = [seconds for r in sure if isfinite(seconds := cost(r, runs))]
            nothing = DISTURBED if reached and not sure else nan
            found[f"s_{level}_{'once' if runs == 1 else runs}"] = median(spent) if spent else nothing
    return found


def _counted(outcomes: Iterable[str]) -> dict[str, int]:
    count = Counter(outcomes)
    named = {name: count[name] for name in ("right", "wrong", "refused")}
    return named | {"failed": sum(count[name] for name in FAILED)}


def _middle(runs: Iterable[Run | None]) -> float:
    """The median size of the first transition's error, s; NaN without one."""
    sizes = [abs(first_error(run)) for run in runs]
    return median(known) if (known := [size for size in sizes if isfinite(size)]) else nan
