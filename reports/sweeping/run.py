"""A sweep from its plan to its rows: parts that are there are left, the others are made and kept as they come."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases import BadValue
from reference.sweeping import CHUNK, Plan

from ..running import cluster, elsewhere, fingerprint
from ..running.records import REFERENCE
from ..running.solvers import routes, version
from ..running.workers import Pool
from . import local, parts
from .folder import Folder
from .local import Part
from .parts import Work

# A task lasts about so long, s: long beside what it takes to hand one out (a millisecond), short beside a coffee.
LASTS = 2.0
# A part of slow scenarios has at least so many.
LEAST = 8
ROWS = "rows"


@dataclass(frozen=True)
class Machines:
    """Where parts are made: so many workers here, or a Dask cluster; and who watches."""

    jobs: int
    dask: str | None
    progress: Callable[[str, int, Iterator], Iterator]

    def done(self, work: Work, wanted: list[Part]) -> Iterator[tuple[Part, bytes]]:
        """The bytes of each part, as they come."""
        return local.done(work, wanted, Pool(self.jobs) if self.dask is None else self._cluster(work))

    def _cluster(self, work: Work) -> cluster.Cluster:
        engines = () if work.solver == REFERENCE else (work.solver,)
        told = dict(elsewhere.identity(versions_of(engines), work.plan.files))
        del told[elsewhere.PROCESSOR]  # it has a say in last digits; half a cluster idle would be the worse of the two
        return cluster.Cluster(self.dask or "", self.jobs, tuple(told.items()), engines, work.plan.files)


def asked(plan: Plan, certified: bool) -> dict[str, Any]:
    """All that decides the rows of a sweep."""
    return {"plan": plan.as_text(), "scene": scene(plan), "certified": certified, "made with": parts.made_with()}


def scene(plan: Plan) -> str:
    """The code of the case's function and of its file, in a few letters."""
    try:
        file = inspect.getsourcefile(plan.function)
        return fingerprint.digest(Path(file).read_text(encoding="utf-8") if file else plan.name)[:16]
    except (OSError, TypeError):
        return "unknown"


def run(plan: Plan, folder: Folder, certified: bool, machines: Machines) -> int:
    """Make what is not there of the reference's rows; how many scenarios were made now."""
    return _made(Work(plan, certified=certified), folder, ROWS, machines)


def routes_of(solver: str) -> tuple[str, ...]:
    """The routes of an engine; raises BadValue if it is not there."""
    return _of_engine(routes, solver)


def versions_of(engines: Sequence[str]) -> dict[str, str]:
    """The versions of engines; raises BadValue if one is not there."""
    return {name: _of_engine(version, name) for name in engines}


def run_engine(plan: Plan, folder: Folder, solver: str, ways: tuple[str, ...], machines: Machines) -> dict[str, str]:
    """The same of every route of an engine; by kind of rows the title of each. Raises BadValue if the folder has rows
    that the engine made in another version, or by another adapter."""
    own = {**versions_of([solver]), "its adapter": fingerprint.adapter_sources(solver)[:16]}
    there = folder.told(f"made with {solver}")
    if there not in (None, own):
        raise BadValue(f"{folder.path} holds rows of {there}, not {own}; give another --out, or --fresh to forget them")
    folder.tell({f"made with {solver}": own})
    kinds = {}
    for route in ways:
        kinds[f"{solver}.{route}"] = f"{solver}, {route}"
        _made(Work(plan, solver, route), folder, f"{solver}.{route}", machines)
    return kinds


def _of_engine(function: Callable, name: str):
    """What an engine is asked, in a worker: it is not loaded here."""
    pool = Pool(1)
    try:
        ((_, answer),) = pool.run(function, [(name,)])
    finally:
        pool.close()
    if answer.outcome != "done":
        raise BadValue(f"{name} cannot take part: {answer.failure[1]}")
    return answer.value


def _made(work: Work, folder: Folder, kind: str, machines: Machines) -> int:
    length = folder.told(f"chunk of {kind}")
    if not isinstance(length, int) or length < 1:
        length = _length(work)
        folder.tell({f"chunk of {kind}": length})
    n, there = len(work.plan), folder.done(kind)
    wanted = [Part(start, min(start + length, n)) for start in range(0, n, length) if start not in there]
    name = work.solver if not work.route else f"{work.solver} {work.route}"
    title = f"{name}, {length} scenarios a part" + (f" ({len(there)} parts were there)" if there else "")
    if not wanted:
        return 0
    for part, content in machines.progress(title, len(wanted), machines.done(work, wanted)):
        folder.put(kind, part.start, content)
    return sum(part.stop - part.start for part in wanted)


def _length(work: Work) -> int:
    """How many scenarios make a part, by a pilot; halves and doubles of the usual, so that noise seldom matters."""
    if len(work.plan) <= LEAST:
        return LEAST
    pool = Pool(1)
    try:
        ((_, answer),) = pool.run(parts.rate, [(work,)], local.PATIENCE)
    finally:
        pool.close()
    if answer.outcome != "done":
        return LEAST  # one of the first scenarios ends its worker: small parts find it soonest
    length = CHUNK
    while length > LEAST and length > LASTS * answer.value:
        length //= 2
    return max(LEAST, length)
