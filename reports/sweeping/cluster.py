"""The parts of a sweep on a Dask cluster, through its standard client.

Workers come and go, and so may the scheduler: a part counts when its rows are here, and is asked for again until then.
A worker that would give other rows (another version, no heyoka, no such engine) is left out, and the reason is said.
"""

from __future__ import annotations

import sys
import time
from asyncio import CancelledError
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from cases import BadValue

from . import parts, probe
from .local import Part, joined
from .parts import Work

LOCAL = "local"
# Tasks handed out at a time, for each thread that works: enough that none waits for the next one.
AHEAD = 4
# Seconds between two looks at who is there; how long a scheduler or a worker that fits may be gone.
LOOK, PATIENCE = 2.0, 600.0
# A piece that ended so many workers is halved: there may be a scenario in it that does.
DEADLY = 3


class Piece(NamedTuple):
    """Some scenarios of the part that begins with `owner`."""

    owner: Part
    start: int
    stop: int


def say(text: str) -> None:
    """A sentence on the terminal."""
    print(f"dask: {text}", file=sys.stderr, flush=True)


def done(
    work: Work, wanted: Sequence[Part], address: str, jobs: int, patience: float = PATIENCE
) -> Iterator[tuple[Part, bytes]]:
    """The bytes of each part as they come.

    Raises OSError if the scheduler or workers that fit stay away."""
    distributed, cluster = _dask(), None
    if address == LOCAL:
        import dask

        dask.config.set({"distributed.worker.profile.enabled": False})  # it looks at each worker every 10 ms
        cluster = distributed.LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None)
        address = cluster.scheduler_address
    try:
        yield from _Sweep(distributed, work, wanted, address, patience).run()
    finally:
        if cluster is not None:
            cluster.close()


def check(address: str) -> None:
    """Raises BadValue, in one sentence, if there is no Dask here, or no scheduler at the address."""
    distributed = _dask()
    if address == LOCAL:
        return
    try:
        distributed.Client(address, timeout=5, set_as_default=False).close()
    except (OSError, TimeoutError, ValueError) as problem:
        raise BadValue(f"nobody answers at --dask {address} ({problem}); start a scheduler there") from None


def _dask():
    try:
        import cloudpickle
        import distributed
    except ImportError as problem:
        raise BadValue(f"--dask needs Dask ({problem}); install it: pip install 'slip-to-roll[dask]'") from None
    cloudpickle.register_pickle_by_value(probe)
    return distributed


class _Sweep:
    """What is left to do, what is under way, and what came of it."""

    def __init__(self, distributed, work: Work, wanted: Sequence[Part], address: str, patience: float):
        self.dask, self.work, self.address, self.patience = distributed, work, address, patience
        self.waiting = [Piece(part, *part) for part in reversed(wanted)]
        self.flying: dict[Any, tuple[Piece, tuple[str, ...]]] = {}  # futures, and who may do them
        self.asked: dict[str, Any] = {}  # workers that have not said yet what they are
        self.came: dict[Part, list[bytes]] = {}  # of parts that had to be cut
        self.missing = Counter(dict.fromkeys(wanted, 1))  # pieces of each part that are not here
        self.deaths: Counter[Piece] = Counter()
        self.fit: list[str] = []  # workers that give the same rows
        self.unfit: dict[str, str] = {}
        self.client: Any = None
        self.lost = False  # whether the scheduler was gone

    def run(self) -> Iterator[tuple[Part, bytes]]:
        """Part after part; from the beginning with another client where the scheduler was gone."""
        while any(self.missing.values()):
            try:
                self._connect()
                while any(self.missing.values()):
                    self._look()
                    self._hand_out()
                    yield from self._collect()
            except (OSError, TimeoutError, CancelledError) as problem:  # what Dask raises when nobody answers
                if isinstance(problem, _Nobody):
                    raise
                self.lost = True
                say(f"the scheduler at {self.address} is gone ({type(problem).__name__}); waiting for it")
                self._give_up()
        self._give_up()

    def _connect(self) -> None:
        """A client of the scheduler, as soon as there is one."""
        until = time.monotonic() + self.patience
        while True:
            try:
                self.client = self.dask.Client(self.address, timeout=10)
                if self.lost:
                    say(f"the scheduler is there again; {sum(self.missing.values())} parts are left")
                return
            except (OSError, TimeoutError):
                if time.monotonic() > until:
                    raise _Nobody(f"no scheduler at {self.address} for {self.patience:g} s") from None
            time.sleep(LOOK)

    def _give_up(self) -> None:
        """What is under way is asked for again; the client goes."""
        self.waiting += [piece for piece, _ in self.flying.values()]
        self.flying.clear()
        self.asked.clear()
        self.fit, self.unfit = [], {}
        if self.client is not None:
            self.client.close(timeout=2)
            self.client = None

    def _look(self) -> None:
        """Who is there, and whether they fit; waits for one that does."""
        until = time.monotonic() + self.patience
        while True:
            there = self.client.scheduler_info(n_workers=-1).get("workers", {})
            if self.client.status != "running":
                raise OSError("the connection is lost")
            for worker in there:
                if worker not in (*self.fit, *self.unfit, *self.asked):
                    self.asked[worker] = self.client.submit(probe.told, self.work.solver, workers=[worker], pure=False)
            self.asked = {worker: future for worker, future in self.asked.items() if worker in there}
            self._hear()
            self.fit = [worker for worker in self.fit if worker in there]
            stranded = [future for future, (_, tied) in self.flying.items() if not {*tied} & {*there}]
            self.waiting += [self.flying.pop(future)[0] for future in stranded]
            if self.fit:
                return
            if time.monotonic() > until:
                reasons = "; ".join(dict.fromkeys(self.unfit.values())) or "there is none"
                raise _Nobody(f"no worker at {self.address} fits: {reasons}")
            time.sleep(0.1 * LOOK)

    def _hear(self) -> None:
        """What the workers that were asked say of themselves."""
        for worker, future in list(self.asked.items()):
            if future.status == "pending":
                continue
            del self.asked[worker]
            if future.status != "finished":
                continue  # it is gone, or is asked again
            told = future.result()
            other = told if isinstance(told, str) else parts.difference(told, self.work.identity)
            if other:
                self.unfit[worker] = other
                say(f"worker {worker} is left out: {other}")
            else:
                self.fit.append(worker)

    def _hand_out(self) -> None:
        while self.waiting and len(self.flying) < AHEAD * len(self.fit):
            piece = self.waiting.pop()
            future = self.client.submit(
                parts.perform, self.work, piece.start, piece.stop, workers=self.fit, pure=False, retries=0
            )
            self.flying[future] = piece, tuple(self.fit)

    def _collect(self) -> Iterator[tuple[Part, bytes]]:
        """What has ended within a little while."""
        try:
            self.dask.wait(list(self.flying), timeout=LOOK, return_when="FIRST_COMPLETED")
        except TimeoutError:
            return
        ended = [future for future in self.flying if future.status != "pending"]
        good = [future for future in ended if future.status == "finished"]
        contents = self.client.gather(good, errors="skip") if good else []
        if len(contents) != len(good):  # the worker that held a result is gone: it is asked for again
            contents, good = [], []
        for future, content in zip(good, contents, strict=True):
            yield from self._arrived(self.flying.pop(future)[0], content)
        for future in ended:
            if future in self.flying:
                yield from self._lost(self.flying.pop(future)[0], future)

    def _arrived(self, piece: Piece, content: bytes) -> Iterator[tuple[Part, bytes]]:
        self.missing[piece.owner] -= 1
        if (piece.start, piece.stop) == piece.owner:
            yield piece.owner, content
            return
        self.came.setdefault(piece.owner, []).append(content)
        if not self.missing[piece.owner]:
            yield piece.owner, joined(self.came.pop(piece.owner))

    def _lost(self, piece: Piece, future) -> Iterator[tuple[Part, bytes]]:
        """Ask for a piece again; in halves if it ended its workers or failed, at last it is a row."""
        problem = future.exception() if future.status == "error" else None
        if problem is None or isinstance(problem, parts.Foreign):
            if problem is not None:
                self.fit = []  # some worker is not what it said: all are asked again
            self.waiting.append(piece)
            return
        killed = isinstance(problem, self.dask.scheduler.KilledWorker)
        self.deaths[piece] += 1
        if killed and self.deaths[piece] < DEADLY:
            self.waiting.append(piece)
        elif piece.stop - piece.start > 1:
            middle = (piece.start + piece.stop) // 2
            self.missing[piece.owner] += 1
            self.waiting += [Piece(piece.owner, piece.start, middle), Piece(piece.owner, middle, piece.stop)]
        else:
            reason = f"it ended {DEADLY} workers" if killed else f"{type(problem).__name__}: {problem}"
            yield from self._arrived(piece, parts.failed(self.work, piece.start, "crashed", reason))


class _Nobody(OSError):
    """The scheduler or a fitting worker stayed away."""
