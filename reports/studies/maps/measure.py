"""The scenarios of the maps, made in workers like everything that may fail."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from reference.sweeping import Plan, plan

from ...running.calls import Calls, Keep
from ...running.records import REFERENCE
from ...running.solvers import routes
from ...sweeping import parts
from ...sweeping.maps import Mark, kind
from ...sweeping.parts import Work
from ...sweeping.run import scene

# The paper's coefficients, let go on the level wall, which its text does not say.
MARKS = tuple(Mark(mu, 0.0, f"μ₀ = {mu:g}") for mu in (0.01, 0.1, 0.2))
ENGINES = ("exudyn", "pymunk")
# Scenarios to a part: of the reference, and of an engine.
CHUNK, FEW = 4000, 50
# Seconds that a part may take.
PATIENCE = 600.0
# A plan names its case; what that is stands in its file.
_KEEP = Keep(of=lambda work, start, stop: (work, start, stop, scene(work.plan)))


class Map(NamedTuple):
    """A solver's rows over the plane, as Parquet files by their first scenario; why parts are missing, if they are."""

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
    """The reference's map; of a full report, the engines' too, on a coarser grid."""
    found = [_map(_plan(121, 91), REFERENCE, "", CHUNK, calls)]
    engines = ENGINES if full else ()
    for name, answer in zip(engines, calls.all("routes", routes, [(name,) for name in engines]), strict=True):
        for route in answer.value if answer.outcome == "done" else ():
            found.append(_map(_plan(31, 25), name, route, FEW, calls))
    return found


def _plan(mus: int, starts: int) -> Plan:
    """Friction from the paper's smallest, starts from the level wall to nearly the bottom."""
    return plan("disc_in_circle", {"mu": f"0.01:0.4:{mus}", "xi1": f"0:1.5:{starts}"})


def some_rows(work: Work, start: int, stop: int) -> np.ndarray:
    """The bytes of a part, as an array: what a store keeps."""
    return np.frombuffer(parts.perform(work, start, stop), dtype=np.uint8)


def _map(asked: Plan, solver: str, route: str, length: int, calls: Calls) -> Map:
    work = Work(asked, solver, route)
    pieces = [(start, min(start + length, len(asked))) for start in range(0, len(asked), length)]
    title = f"map of {' '.join(filter(None, (solver, route)))}"
    answers = calls.all(title, some_rows, [(work, *piece) for piece in pieces], limit=PATIENCE, keep=_KEEP)
    done = {p[0]: a.value.tobytes() for p, a in zip(pieces, answers, strict=True) if a.outcome == "done"}
    failures = tuple(a.failure[1] for a in answers if a.outcome != "done")
    for (start, stop), answer in zip(pieces, answers, strict=True):
        if answer.outcome != "done":  # a row each, so that none is missing
            rows = [parts.failed(work, i, *answer.failure) for i in range(start, stop)]
            tables = [parquet.read_table(pa.BufferReader(row)) for row in rows]
            done[start] = parts.packed(pa.concat_tables(tables))
    return Map(solver, route, asked, done, failures)


def rows(maps: list[Map]) -> list[dict[str, Any]]:
    """How many scenarios of each kind (of an engine: of each verdict), and when at the paper's points."""
    told = []
    for found in maps:
        who = {"case": found.plan.name, "solver": found.solver, "route": found.route}
        for what, times in _by_kind(found).items():
            known = times[np.isfinite(times)]
            many = {"scenarios": len(times), "share": len(times) / len(found.plan)}
            spread = (
                {"earliest": known.min(), "latest": known.max()}
                if known.size
                else {"earliest": np.nan, "latest": np.nan}
            )
            told.append({**who, "what": what, **many, **spread})
    return told


def _by_kind(found: Map) -> dict[str, np.ndarray]:
    kinds: dict[str, list[float]] = {}
    for row in found.table.to_pylist():
        if found.solver == REFERENCE:
            what = kind(row["sequence"] or "", row["outcome"])
        else:
            what = row["verdict"] or row["outcome"]
        kinds.setdefault(what, []).append(np.nan if row["first_time"] is None else row["first_time"])
    return {what: np.array(times) for what, times in sorted(kinds.items())}
