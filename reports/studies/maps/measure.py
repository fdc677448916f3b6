"""The scenarios of the maps, computed in workers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from reference.sweeping import Plan, plan

from ...running.calls import Calls, StorePolicy
from ...running.records import REFERENCE
from ...running.solvers import routes
from ...sweeping import parts
from ...sweeping.maps import Mark, kind
from ...sweeping.parts import SweepWork
from ...sweeping.run import scene

# The paper's coefficients, with release at ξ₁ = 0, which its text does not state.
MARKS = tuple(Mark(mu, 0.0, f"μ₀ = {mu:g}") for mu in (0.01, 0.1, 0.2))
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


def measure(full: bool, calls: Calls) -> list[Map]:
    """The reference's map; in a full report also the engines' maps, on a coarser grid."""
    maps = [_map(_plan(121, 91), REFERENCE, "", CHUNK, calls)]
    engines = ENGINES if full else ()
    for name, answer in zip(engines, calls.all("routes", routes, [(name,) for name in engines]), strict=True):
        for route in answer.value if answer.outcome == "done" else ():
            maps.append(_map(_plan(31, 25), name, route, FEW, calls))
    return maps


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


def rows(maps: list[Map]) -> list[dict[str, Any]]:
    """Number of scenarios of each kind (of an engine: of each verdict), and the range of their first times."""
    table_rows = []
    for one_map in maps:
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
    return table_rows


def _by_kind(one_map: Map) -> dict[str, np.ndarray]:
    kinds: dict[str, list[float]] = {}
    for row in one_map.table.to_pylist():
        if one_map.solver == REFERENCE:
            what = kind(row["sequence"] or "", row["outcome"])
        else:
            what = row["verdict"] or row["outcome"]
        kinds.setdefault(what, []).append(np.nan if row["first_time"] is None else row["first_time"])
    return {what: np.array(times) for what, times in sorted(kinds.items())}
