"""The map of the first screen: every route against every case, with default settings and at the finest setting run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from typing import Any

from ..drawing.colours import GRADES
from ..judging.grades import LIMITS, USUAL_FRICTION, Grade, percent
from ..running.records import Experiment, Run, default, defaults, finest, routes
from .chapters import anchor
from .fragments import short_percent, switch

# From so many cases on a cell has no room for more than its number.
_DENSE = 9
_SAME_SEQUENCE = "same sequence"


def engine_map(
    experiment: Experiment, order: Iterable[tuple[str, str]], exclusions: Mapping[str, str]
) -> dict[str, Any]:
    """Data of the map for its template: bands of cases, those that rank engines first, and in each band two rows of
    cells for each route in `order`. Few cases share one band. `exclusions`: why the other cases do not rank them."""
    labels = [case.label for case in experiment.cases]
    ranking = [label for label in labels if label not in exclusions]
    others = [label for label in labels if label in exclusions]
    is_dense = len(labels) >= _DENSE
    bands = [ranking, others] if is_dense and ranking else [ranking + others]
    groups = routes(experiment.runs)
    return {
        "bands": [_band(band, groups, list(order), exclusions) for band in bands if band],
        "is_dense": is_dense,
        "has_exclusions": bool(others),
        "grades": _legend(),
    }


def _band(
    labels: Sequence[str],
    groups: Mapping[tuple[str, str, str], Sequence[Run]],
    order: Sequence[tuple[str, str]],
    exclusions: Mapping[str, str],
) -> dict[str, Any]:
    entries = [
        {
            "solver": solver,
            "route": route,
            "switch": switch(solver, route),
            "rows": _rows({label: groups.get((label, solver, route), []) for label in labels}, f"{solver} {route}"),
        }
        for solver, route in order
    ]
    cases = [
        {"label": label, "anchor": anchor(label), "exclusion": exclusions.get(label, ""), "first": _is_first(labels, i)}
        for i, label in enumerate(labels)
    ]
    return {"cases": cases, "routes": entries}


def _is_first(labels: Sequence[str], place: int) -> bool:
    """Whether a case begins another scene than the case before it."""
    return place > 0 and labels[place].partition("[")[0] != labels[place - 1].partition("[")[0]


def _rows(groups: Mapping[str, Sequence[Run]], name: str) -> list[dict[str, Any]]:
    cells: dict[str, list[dict[str, Any]]] = {"default": [], "finest": []}
    for label, group in groups.items():
        own, fine = default(group), finest(group)
        missing = _missing(group)
        first = _cell(defaults(group), own) if own and own.score else missing
        last = _cell([fine], fine) if fine else missing
        for settings, cell in (("default", first), ("finest", last)):
            tip = f"{name}, {settings} settings, {label}: {cell['tip']}"
            cells[settings].append(cell | {"tip": tip.replace("finest settings", "finest setting run")})
    # A route without any motion keeps one row, hatched.
    visible = [settings for settings, row in cells.items() if any(cell["off"] for cell in row)] or ["finest"]
    return [{"settings": settings, "cells": cells[settings]} for settings in visible]


def _missing(group: Sequence[Run]) -> dict[str, Any]:
    """The cell of a route without a motion: hatched, with its outcome."""
    run = group[-1] if group else None
    outcome = run.outcome.replace("_", " ") if run and not run.score else "not run"
    why = f": {run.reason}" if run and run.reason and not run.score else ""
    return {"off": "", "brief": "", "small": outcome, "grade": "none", "tip": f"{outcome}{why}"}


def _cell(runs: Sequence[Run], run: Run) -> dict[str, Any]:
    """The cell of a run: its off with its grade, and the range of `runs`; small print is its friction × or the shortest
    phases that it misses."""
    assert run.score is not None, "a cell has a motion"
    offs, off = sorted(run.score.off for run in runs if run.score), run.score.off
    spread = f" ({percent(offs[0])} to {percent(offs[-1])} over {len(offs)} usual values)" if len(offs) > 1 else ""
    tip = [f"{percent(off)} ± {percent(run.score.doubt)} off{spread}", run.grade]
    if isfinite(run.friction_factor):
        tip.append(f"friction × {run.friction_factor:.2g}")
    if isfinite(run.law.median):
        tip.append(f"friction force off by {percent(run.law.median)} of μN, most at {run.law.time:.3g} s")
    tip += [run.sequence] if run.sequence else []
    return {
        "off": short_percent(off),
        "brief": _brief(off),
        "small": _small(run),
        "grade": run.grade.replace(" ", "-"),
        "tip": ", ".join(tip),
    }


def _brief(off: float) -> str:
    """Off in percent with at most three characters: >1k, 31, 2.1, .27, 0."""
    return ">1k" if off >= 9.995 else short_percent(off).replace("<.01", "0")


def _small(run: Run) -> str:
    low, high = USUAL_FRICTION
    if isfinite(run.friction_factor) and not low <= run.friction_factor <= high:
        return f"friction × {float(f'{run.friction_factor:.2g}'):g}"
    if run.sequence.startswith(_SAME_SEQUENCE):
        return ""
    return run.sequence.replace("phases of up to", "phases ≤").replace("another sequence of modes", "other sequence")


def _legend() -> list[dict[str, str]]:
    """The grades with their limits and colours."""
    words = {name: f"≤ {percent(limit)}" for name, limit in LIMITS.items()} | {
        Grade.UNUSABLE: "more",
        Grade.UNDECIDED: "by its samples",
    }
    return [
        {"name": str(name), "id": str(name).replace(" ", "-"), "limit": words[name], "colour": GRADES[name]}
        for name in words
    ]
