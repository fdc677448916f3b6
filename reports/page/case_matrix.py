"""The table of all cases: off of each route with default settings and at the finest setting run, with its grade."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import isfinite

from ..analysis import verdict
from ..judging.grades import LIMITS, Grade, percent
from ..running.records import Experiment, Run, default, defaults, finest, routes
from . import motions
from .fragments import anchor, short_percent, switch
from .page_table import Cell, Head, PageRow, PageTable, number_cell


def matrix(experiment: Experiment, order: Iterable[tuple[str, str]]) -> PageTable:
    """A row for each case, family by family, and two cells for each route in `order`."""
    exclusions, groups, keys = verdict.exclusions(experiment), routes(experiment.runs), list(order)
    rows = []
    for case in experiment.cases:
        label, sensitivity = case.label, experiment.truths[case.label].friction_sensitivity
        why = exclusions.get(label, "")
        own = Cell(f"{label}{'*' * bool(why)}", kind="case", tip=why and f"not ranked: {why}", link=f"#{anchor(label)}")
        change = number_cell(short_percent(sensitivity) if isfinite(sensitivity) else "", sensitivity)
        cells = [cell for key in keys for cell in _cells(groups.get((label, *key), ()))]
        rows.append(PageRow([Cell(motions.family(case)), own, change, *cells]))
    families = list(dict.fromkeys(row.cells[0].text for row in rows))
    rows.sort(key=lambda row: families.index(row.cells[0].text))
    tip = "off in % that 1 % more or less friction makes"
    heads = [Head("family"), Head("case"), Head("1 % of μ", number=True, tip=tip)]
    for solver, route in keys:
        name, where = f"{solver} {route}", (solver, switch(solver, route))
        heads += [Head(name, words, "", True, "", *where) for words in ("default", "finest")]
    return PageTable("all cases", heads, rows, "short grades cells", "headline", len(rows), len(heads))


def _cells(group: Sequence[Run]) -> Iterator[Cell]:
    """The cells of a route in a case, with default settings and at the finest setting run."""
    for run, grid in ((default(group), defaults(group)), (finest(group), ())):
        if run and run.score:
            off = run.score.off
            yield number_cell(short_percent(off), off, run.grade.replace(" ", "-"), _details(run, grid))
        else:
            yield number_cell("–", float("nan"), "none", _missing(group))


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


def legend() -> list[dict[str, str]]:
    """The grades with their limits."""
    words = {name: f"≤ {percent(limit)}" for name, limit in LIMITS.items()}
    words |= {Grade.UNUSABLE: "more", Grade.UNDECIDED: "by its samples"}
    return [{"name": str(name), "id": str(name).replace(" ", "-"), "limit": words[name]} for name in words]
