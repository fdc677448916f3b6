"""The table of all cases: off of each route with default settings and at the finest setting run, with its grade."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from typing import Any

from ..analysis import verdict
from ..judging.grades import LIMITS, Grade, percent
from ..running.records import Experiment, Run, default, defaults, finest, routes
from . import motions
from .fragments import anchor, short_percent, switch


def matrix(experiment: Experiment, order: Iterable[tuple[str, str]]) -> dict[str, Any]:
    """A row for each case, family by family, and two cells for each route in `order`."""
    exclusions, groups, keys = verdict.exclusions(experiment), routes(experiment.runs), list(order)
    rows = []
    for case in experiment.cases:
        label, sensitivity = case.label, experiment.truths[case.label].friction_sensitivity
        cells = [cell for key in keys for cell in _cells(groups.get((label, *key), ()), *key)]
        rows.append(
            {
                "family": motions.family(case),
                "case": label,
                "anchor": anchor(label),
                "exclusion": exclusions.get(label, ""),
                "sensitivity": short_percent(sensitivity) if isfinite(sensitivity) else "",
                "order": _order(sensitivity),
                "cells": cells,
            }
        )
    families = list(dict.fromkeys(row["family"] for row in rows))
    rows.sort(key=lambda row: families.index(row["family"]))
    return {
        "routes": [{"solver": solver, "route": route, "switch": switch(solver, route)} for solver, route in keys],
        "rows": rows,
        "grades": _legend(),
    }


def _order(value: float) -> str:
    """The number by which a cell is sorted; without one it is last."""
    return repr(float(value)) if isfinite(value) else "1e308"


def _cells(group: Sequence[Run], solver: str, route: str) -> list[dict[str, Any]]:
    """The cells of a route in a case, with default settings and at the finest setting run."""
    cells = []
    for words, run in (("default settings", default(group)), ("finest setting run", finest(group))):
        run = run if run and run.score else None
        text = _details(run, defaults(group) if words.startswith("default") else ()) if run else _missing(group)
        off = run.score.off if run and run.score else float("nan")
        cells.append(
            {
                "solver": solver,
                "route": switch(solver, route),
                "text": short_percent(off) if run else "–",
                "grade": run.grade.replace(" ", "-") if run else "none",
                "order": _order(off),
                "tip": f"{solver} {route}, {words}: {text}",
            }
        )
    return cells


def _missing(group: Sequence[Run]) -> str:
    """Why there is no motion."""
    run = next((run for run in reversed(group) if not run.score), None)
    if run is None:
        return "not run"
    return run.outcome.replace("_", " ") + (f": {run.reason}" if run.reason else "")


def _details(run: Run, grid: Sequence[Run]) -> str:
    """Off with its doubt, the range over `grid`, grade, friction × and how the sequence of modes agrees."""
    assert run.score is not None, "a cell has a motion"
    offs = sorted(one.score.off for one in grid if one.score)
    spread = f" ({percent(offs[0])} to {percent(offs[-1])} over {len(offs)} usual values)" if len(offs) > 1 else ""
    texts = [f"{percent(run.score.off)} ± {percent(run.score.doubt)} off{spread}", run.grade]
    if isfinite(run.friction_factor):
        texts.append(f"friction × {run.friction_factor:.2g}")
    if isfinite(run.law.median):
        texts.append(f"friction force off by {percent(run.law.median)} of μN, most at {run.law.time:.3g} s")
    return ", ".join([*texts, *([run.sequence] if run.sequence else [])])


def _legend() -> list[dict[str, str]]:
    """The grades with their limits."""
    words = {name: f"≤ {percent(limit)}" for name, limit in LIMITS.items()}
    words |= {Grade.UNUSABLE: "more", Grade.UNDECIDED: "by its samples"}
    return [{"name": str(name), "id": str(name).replace(" ", "-"), "limit": words[name]} for name in words]
