"""Computation of a sweep from its plan: missing parts are computed and written as they are completed.

The workers are of this machine or of a cluster. A part that ends its worker is halved until the scenario that causes it
is isolated; that scenario is a row of failure.
"""

from __future__ import annotations

import inspect
import logging
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow as pa

from adapters.processes.pool import WorkerPool
from cases import BadValue
from reference.sweeping import CHUNK, Plan

from ..running import cluster, cluster_worker
from ..running.names import REFERENCE
from ..running.progress import in_words
from ..running.solvers import pool, routes, version
from ..running.storage import fingerprint
from . import parts
from .parts import SweepWork
from .sweep_folder import Folder

# Approximate duration of a task, s: long compared with its scheduling (1 ms), short compared with a user's patience.
LASTS = 2.0
# Smallest number of scenarios in a part.
LEAST = 8
ROWS = "rows"
# Wall-clock limit of a part in seconds: parts are sized to take seconds.
PATIENCE = 900.0
# Parts submitted to a pool at a time: the pool searches its waiting parts whenever it assigns one.
TOGETHER = 1000


class Part(NamedTuple):
    """A range of scenarios: start … stop − 1."""

    start: int
    stop: int


@dataclass(frozen=True)
class Machines:
    """The workers that compute parts (`jobs` on this machine, or a Dask cluster), and the display of progress."""

    jobs: int
    dask: str | None
    progress: Callable[[str, int, Iterator], Iterator]

    def compute(self, work: SweepWork, pending: list[Part]) -> Iterator[tuple[Part, bytes]]:
        """Yield the bytes of each part as it is completed."""
        return run_parts(work, pending, pool(self.jobs) if self.dask is None else self._cluster(work))

    def _cluster(self, work: SweepWork) -> cluster.Cluster:
        engines = () if work.solver == REFERENCE else (work.solver,)
        identity = dict(cluster_worker.identity(versions_of(engines), work.plan.files))
        # The processor affects only last digits, and a mixed cluster would otherwise be partly idle.
        del identity[cluster_worker.PROCESSOR]
        return cluster.Cluster(self.dask or "", self.jobs, tuple(identity.items()), engines, work.plan.files)


def sweep_identity(plan: Plan, certified: bool) -> dict[str, Any]:
    """Everything that determines the rows of a sweep."""
    return {"plan": plan.as_text(), "scene": scene(plan), "certified": certified, "made with": parts.environment()}


def scene(plan: Plan) -> str:
    """A digest of the file that defines the case's function."""
    try:
        file = inspect.getsourcefile(plan.function)
        return fingerprint.digest(Path(file).read_text(encoding="utf-8") if file else plan.name)[:16]
    except (OSError, TypeError):
        return "unknown"


def run_reference(plan: Plan, folder: Folder, certified: bool, machines: Machines) -> int:
    """Compute the missing parts of the reference's rows; returns the number of scenarios computed now."""
    return _provenance(SweepWork(plan, certified=certified), folder, ROWS, machines)


def routes_of(solver: str) -> tuple[str, ...]:
    """The routes of an engine; raises BadValue if it is not installed."""
    return _of_engine(routes, solver)


def versions_of(engines: Sequence[str]) -> dict[str, str]:
    """The versions of engines; raises BadValue if one is not installed."""
    return {name: _of_engine(version, name) for name in engines}


def run_engine(plan: Plan, folder: Folder, solver: str, ways: tuple[str, ...], machines: Machines) -> dict[str, str]:
    """Compute the missing rows of every route of an engine; returns titles by kind of rows.

    Raises BadValue if the folder has rows of another version of the engine, or of another version of its adapter.
    """
    environment_now = {**versions_of([solver]), "its adapter": fingerprint.adapter_sources(solver)[:16]}
    before = folder.value(f"made with {solver}")
    if before not in (None, environment_now):
        raise BadValue(
            f"{folder.path} holds rows of {before}, not {environment_now}; give another --out, or --fresh to delete "
            "them"
        )
    folder.record({f"made with {solver}": environment_now})
    kinds = {}
    for route in ways:
        kinds[f"{solver}.{route}"] = f"{solver}, {route}"
        _provenance(SweepWork(plan, solver, route), folder, f"{solver}.{route}", machines)
    return kinds


def _of_engine(function: Callable, name: str):
    """Call a function on an engine in a worker, so that the engine is not loaded in this process."""
    with pool(1) as alone:
        answer = alone.call(function, name)
    if answer.outcome != "done":
        raise BadValue(f"{name} cannot be used: {answer.failure[1]}")
    return answer.value


def _provenance(work: SweepWork, folder: Folder, kind: str, machines: Machines) -> int:
    n, starts = len(work.plan), folder.part_starts(kind)
    name = work.solver if not work.route else f"{work.solver} {work.route}"
    length = folder.value(f"chunk of {kind}")
    if not isinstance(length, int) or length < 1:
        pace = _pilot(work)
        length = _length(pace)
        folder.record({f"chunk of {kind}": length})
        if pace is not None:
            print(f"{name}: {_pace_text(pace, n, machines.jobs)}", file=sys.stderr)
    pending = [Part(start, min(start + length, n)) for start in range(0, n, length) if start not in starts]
    title = f"{name}, {length} scenarios per part" + (f" ({len(starts)} parts already complete)" if starts else "")
    if not pending:
        return 0
    for part, content in machines.progress(title, len(pending), machines.compute(work, pending)):
        folder.add_part(kind, part.start, content)
        logging.getLogger("reports").info("%s: scenarios %d to %d are done", name, part.start, part.stop - 1)
    return sum(part.stop - part.start for part in pending)


def _pilot(work: SweepWork) -> parts.Pilot | None:
    """The trial of a plan in a worker; None if one of the first scenarios ends its worker.

    Raises BadValue if none of those tried is a scene: what applies to all shows after a few, not after an hour."""
    with pool(1) as alone:
        answer = alone.call(parts.pilot, work, limit=PATIENCE)
    if answer.outcome != "done":
        return None
    if answer.value.no_scene:
        raise BadValue(f"none of {answer.value.trials} scenarios tried, of {len(work.plan):,}: {answer.value.no_scene}")
    return answer.value


def _length(pace: parts.Pilot | None) -> int:
    """Number of scenarios per part; CHUNK divided by a power of two, so that noise rarely matters."""
    if pace is None:
        return LEAST  # small parts isolate a scenario that ends its worker soonest
    length = CHUNK
    while length > LEAST and length * pace.seconds > LASTS:
        length //= 2
    return max(LEAST, length)


def _pace_text(pace: parts.Pilot, count: int, jobs: int) -> str:
    """Pace and duration: "93 ms of CPU time per scenario, one by one; 10,000 take about 8 min with 2 processes"."""
    power, unit = next((each for each in ((0, "s"), (3, "ms")) if pace.seconds * 10 ** each[0] >= 1.0), (6, "µs"))
    how = ", one by one" if pace.one_by_one else ""
    lasts, workers = in_words(count * pace.seconds / jobs), f"{jobs} process{'es' if jobs > 1 else ''}"
    each = f"{pace.seconds * 10**power:.3g} {unit}"
    return f"{each} of CPU time per scenario{how}; {count:,} take about {lasts} with {workers}"


# --- parts ------------------------------------------------------------------------------------------------------------


def run_parts(
    work: SweepWork, pending: Sequence[Part], machines: WorkerPool | cluster.Cluster
) -> Iterator[tuple[Part, bytes]]:
    """Yield the bytes of each part as it is completed; closes the machines at the end."""
    try:
        failed_parts = []
        for begin in range(0, len(pending), TOGETHER):
            batch = pending[begin : begin + TOGETHER]
            for i, answer in machines.run(parts.perform, [(work, *part) for part in batch], PATIENCE):
                if answer.outcome == "done":
                    yield batch[i], answer.value
                else:
                    failed_parts.append(batch[i])
        for whole in failed_parts:
            yield whole, _in_halves(machines, work, whole)
    finally:
        machines.close()


def _in_halves(machines: WorkerPool | cluster.Cluster, work: SweepWork, whole: Part) -> bytes:
    """Compute a failed part by repeated halving."""
    waiting, tables = [whole], []
    while waiting:
        batch, waiting = waiting, []
        for i, answer in machines.run(parts.perform, [(work, *piece) for piece in batch], PATIENCE):
            start, stop = batch[i]
            if answer.outcome == "done":
                tables.append(answer.value)
            elif stop - start == 1:
                outcome, reason = answer.failure
                tables.append(parts.failure_text(work, start, outcome, reason))
            else:
                middle = (start + stop) // 2
                waiting += [Part(start, middle), Part(middle, stop)]
    return join_parts(tables)


def join_parts(contents: Sequence[bytes]) -> bytes:
    """Join the pieces of a part to one file."""
    from pyarrow import parquet

    tables = [parquet.read_table(pa.BufferReader(content)) for content in contents]
    return parts.pack(pa.concat_tables(tables).sort_by("scenario"))
