"""A sweep from its plan to its rows: parts that are there are left, the others are made and kept as they come."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases import BadValue
from reference.sweeping import CHUNK, Plan

from ..running import fingerprint
from ..running.solvers import routes
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
        if self.dask is None:
            return local.done(work, wanted, self.jobs)
        from . import cluster

        return cluster.done(work, wanted, self.dask, self.jobs)


def asked(plan: Plan, certified: bool) -> dict[str, Any]:
    """All that decides the rows of a sweep."""
    who = dict(parts.identity())
    return {"plan": plan.as_text(), "scene": _scene(plan), "certified": certified, "made with": who}


def _scene(plan: Plan) -> str:
    """The code of the case's function and of its file, in a few letters."""
    try:
        file = inspect.getsourcefile(plan.function)
        return fingerprint.digest(Path(file).read_text(encoding="utf-8") if file else plan.name)[:16]
    except (OSError, TypeError):
        return "unknown"


def run(plan: Plan, folder: Folder, certified: bool, machines: Machines) -> int:
    """Make what is not there of the reference's rows; how many scenarios were made now."""
    work = Work(plan, certified=certified, identity=parts.identity())
    return _made(work, folder, ROWS, machines)


def routes_of(solver: str) -> tuple[str, ...]:
    """The routes of an engine; raises BadValue if it is not there."""
    return _of_engine(routes, solver)


def run_engine(plan: Plan, folder: Folder, solver: str, ways: tuple[str, ...], machines: Machines) -> dict[str, str]:
    """The same of every route of an engine; by kind of rows the title of each."""
    kinds = {}
    for route in ways:
        work = Work(plan, solver, route, identity=_of_engine(parts.identity, solver))
        kinds[f"{solver}.{route}"] = f"{solver}, {route}"
        _made(work, folder, f"{solver}.{route}", machines)
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
    if length is None:
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
        ((_, answer),) = pool.run(parts.rate, [(work._replace(identity=()),)], local.PATIENCE)
    finally:
        pool.close()
    if answer.outcome != "done":
        return LEAST  # one of the first scenarios ends its worker: small parts find it soonest
    length = CHUNK
    while length > LEAST and length > LASTS * answer.value:
        length //= 2
    return max(LEAST, length)
