"""The paper's application over friction and start: kinds of motion, their times, and the grades of engines."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from reference.sweeping import Plan, plan

from ..analysis.columns import Table
from ..drawing.figure_files import FigureEntry, save
from ..running.calls import Calls, StorePolicy
from ..running.names import REFERENCE
from ..running.solvers import routes
from ..sweeping import map_figures, parts
from ..sweeping.computation import ROWS, scene
from ..sweeping.parts import SweepWork
from ..sweeping.sweep_folder import Folder
from . import Request

TITLE = "Maps over friction and start"
QUESTION = (
    "The paper treats three coefficients of friction and does not state where the disc is released. These maps cover "
    "the whole range of both: where it rolls, where its slip reverses, and, in a full report, the grades of "
    "engines with default settings."
)
TAKES = ()
IN_REPORT = True
TABLES = {
    "maps": Table(
        "Kinds of motion of the paper's application over friction and start, counted",
        {
            "case": "the scene, over mu and xi1",
            "solver": "the solver",
            "route": "its route",
            "what": "for the reference the first and second phase of the motion; for an engine its grade or outcome",
            "scenarios": "number of scenarios",
            "share": "its fraction of all scenarios",
            "earliest": "the earliest first transition among them, s",
            "latest": "the latest first transition among them, s",
        },
    )
}


# The paper's coefficients, with release at ξ₁ = 0, which its text does not state.
MARKS = tuple(map_figures.Mark(mu, 0.0, f"μ₀ = {mu:g}") for mu in (0.01, 0.1, 0.2))
ENGINES = ("exudyn", "pymunk")
# Scenarios per part: of the reference, and of an engine.
CHUNK, FEW = 4000, 50
# Time limit of a part, in seconds.
PATIENCE = 600.0
# A plan contains only the name of its case, so the key also contains the code that defines the case.
_KEEP = StorePolicy(of=lambda work, start, stop: (work, start, stop, scene(work.plan)))


class Map(NamedTuple):
    """A solver's rows over the plane, as Parquet files by their first scenario, and the reasons of failed parts."""

    solver: str
    route: str
    plan: Plan
    parts: dict[int, bytes]
    failures: tuple[str, ...] = ()

    @property
    def table(self) -> pa.Table:
        """All rows."""
        return pa.concat_tables([parquet.read_table(pa.BufferReader(part)) for _, part in sorted(self.parts.items())])


def run(request: Request, calls: Calls) -> list[Map]:
    """The reference's map; in a full report also the engines' maps, on a coarser grid."""
    results = [_map(_plan(121, 91), REFERENCE, "", CHUNK, calls)]
    engines = ENGINES if request.full else ()
    for name, answer in zip(engines, calls.all("routes", routes, [(name,) for name in engines]), strict=True):
        for route in answer.value if answer.outcome == "done" else ():
            results.append(_map(_plan(31, 25), name, route, FEW, calls))
    return results


def _plan(mus: int, starts: int) -> Plan:
    """The plan: friction from the paper's smallest coefficient, starts from ξ₁ = 0 to nearly the bottom."""
    return plan("disc_in_circle", {"mu": f"0.01:0.4:{mus}", "xi1": f"0:1.5:{starts}"})


def some_rows(work: SweepWork, start: int, stop: int) -> np.ndarray:
    """The bytes of a part as an array, the form that the store accepts."""
    return np.frombuffer(parts.perform(work, start, stop), dtype=np.uint8)


def _map(sweep_plan: Plan, solver: str, route: str, length: int, calls: Calls) -> Map:
    work = SweepWork(sweep_plan, solver, route)
    pieces = [(start, min(start + length, len(sweep_plan))) for start in range(0, len(sweep_plan), length)]
    title = f"map of {' '.join(filter(None, (solver, route)))}"
    answers = calls.all(title, some_rows, [(work, *piece) for piece in pieces], limit=PATIENCE, keep=_KEEP)
    contents = {p[0]: a.value.tobytes() for p, a in zip(pieces, answers, strict=True) if a.outcome == "done"}
    failures = tuple(a.failure[1] for a in answers if a.outcome != "done")
    for (start, stop), answer in zip(pieces, answers, strict=True):
        if answer.outcome != "done":  # one row per scenario, so that none is missing
            rows = [parts.failure_text(work, i, *answer.failure) for i in range(start, stop)]
            tables = [parquet.read_table(pa.BufferReader(row)) for row in rows]
            contents[start] = parts.pack(pa.concat_tables(tables))
    return Map(solver, route, sweep_plan, contents, failures)


def rows(findings: list[Map]) -> dict[str, list[dict[str, Any]]]:
    """Number of scenarios of each kind (of an engine: of each grade), and the range of their first times."""
    table_rows = []
    for one_map in findings:
        common = {"case": one_map.plan.name, "solver": one_map.solver, "route": one_map.route}
        for what, times in _by_kind(one_map).items():
            finite = times[np.isfinite(times)]
            many = {"scenarios": len(times), "share": len(times) / len(one_map.plan)}
            spread = (
                {"earliest": finite.min(), "latest": finite.max()}
                if finite.size
                else {"earliest": np.nan, "latest": np.nan}
            )
            table_rows.append({**common, "what": what, **many, **spread})
    return {"maps": table_rows}


def _by_kind(one_map: Map) -> dict[str, np.ndarray]:
    kinds: dict[str, list[float]] = {}
    for row in one_map.table.to_pylist():
        if one_map.solver == REFERENCE:
            what = map_figures.kind(row["sequence"] or "", row["outcome"])
        else:
            what = row["grade"] or row["outcome"]
        kinds.setdefault(what, []).append(np.nan if row["first_time"] is None else row["first_time"])
    return {what: np.array(times) for what, times in sorted(kinds.items())}


def draw(findings: list[Map], folder: Path) -> Iterator[FigureEntry]:
    """Write the figures to the folder; yields their entries."""
    for each in findings:
        kind = ROWS if each.solver == REFERENCE else f"{each.solver}.{each.route}"
        with tempfile.TemporaryDirectory() as place:
            rows = Folder(Path(place))
            for start, content in each.parts.items():
                rows.add_part(kind, start, content)
            if each.solver == REFERENCE:
                figure = map_figures.of_reference(each.plan, rows, marks=MARKS)
                title = "Motion of the disc after its release, over friction and start"
                caption = (
                    f"{len(each.plan):,} motions. Thin lines: time at which the slip first ends, s, with R = 1 m, "
                    "r = 0.1 m; thick lines: boundaries between kinds of motion by (35). Dots: the paper's three "
                    "coefficients, with release at ξ₁ = 0."
                )
            else:
                title = f"{each.solver}, {each.route}: grades with default settings, over friction and start"
                caption = f"{len(each.plan):,} runs with default settings. Left: grades. Right: errors of the time."
                figure = map_figures.of_engine(each.plan, rows, kind, f"{each.solver}, {each.route}")
            yield save(figure, folder, f"map_{kind.replace('.', '_')}", "", title, caption)
