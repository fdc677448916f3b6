"""Calls on a Dask cluster, through its standard client, for who would else make them in a `Pool` of this machine.

Workers come and go, and so may the scheduler: a call counts when its answer is here, and is asked for again until then.
A worker that would give other answers (another version, no heyoka, no such engine) is left out, and the reason is said.
"""

from __future__ import annotations

import pickle
import sys
import time
from asyncio import CancelledError
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import replace
from typing import Any

from cases import BadValue

from ..records import legible
from ..solvers import groups_of
from . import cluster_probe, cluster_worker
from .cluster_worker import Identity
from .worker_process import CallResult
from .workers import read

LOCAL = "local"
# Calls handed out at a time, for each worker: enough that none waits for the next one.
AHEAD = 4
# Seconds between two looks at who is there; how long a scheduler or a worker that fits may be gone.
LOOK, PATIENCE = 2.0, 600.0
# A call that ended so many workers is not asked for again.
DEADLY = 3
# Seconds in which a scheduler answers, or is none.
ANSWERS = 5.0


class NoWorkers(OSError):
    """The scheduler, or a worker that fits, stayed away."""


def say(text: str) -> None:
    """A sentence on the terminal."""
    print(f"dask: {text}", file=sys.stderr, flush=True)


def check(address: str) -> None:
    """Raises BadValue, in one sentence, if there is no Dask here, or no scheduler at the address."""
    distributed = _dask()
    if address == LOCAL:
        return
    try:
        distributed.comm.get_address_host_port(address)  # a client that cannot begin has no quiet end
        distributed.Client(address, timeout=ANSWERS, set_as_default=False).close()
    except (OSError, TimeoutError, ValueError) as problem:
        raise BadValue(f"nobody answers at --dask {address} ({problem}); start a scheduler there") from None


def _dask():
    try:
        import cloudpickle
        import distributed
    except ImportError as problem:
        raise BadValue(f"--dask needs Dask ({problem}); install it: pip install 'slip-to-roll[dask]'") from None
    cloudpickle.register_pickle_by_value(cluster_probe)
    return distributed


class Cluster:
    """The workers of the scheduler at an address (LOCAL: `jobs` workers of this machine) that are what `identity` says,
    used as a `workers.Pool` is. `solvers` and `files` are what they are asked about.

    A scheduler or workers that stay away for `patience` seconds raise Nobody.
    """

    def __init__(
        self,
        address: str,
        jobs: int,
        identity: Identity,
        solvers: Sequence[str] = (),
        files: Sequence[str] = (),
        patience: float = PATIENCE,
    ):
        self.dask, self.address, self.patience = _dask(), address, patience
        self.identity, self.question = identity, (tuple(solvers), tuple(files))
        self.told: set[str] = set()  # of workers that are left out
        self._own = None
        if address == LOCAL:
            import dask

            dask.config.set({"distributed.worker.profile.enabled": False})  # it looks at each worker every 10 ms
            self._own = self.dask.LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None)
            self.address = self._own.scheduler_address

    def close(self) -> None:
        """End the workers, where they are of this machine alone."""
        if self._own is not None:
            self._own.close()

    def run(
        self,
        function: Callable,
        arguments: Sequence[tuple],
        limit: float = 60.0,
        skip: Callable[[int], CallResult | None] = lambda index: None,
        groups: Sequence[str] = (),
        brief: bool = False,
    ) -> Generator[tuple[int, CallResult]]:
        """As `Pool.run`; its workers are there already, whether calls are brief or not. A call that ended DEADLY
        workers has "died", from outside."""
        run = _ClusterRun(self, function, arguments, limit, skip, groups or groups_of(arguments))
        try:
            yield from run.answers()
        finally:
            run.give_up()


class _ClusterRun:
    """What is left to do, and what is under way."""

    def __init__(self, cluster: Cluster, function: Callable, arguments: Sequence[tuple], limit: float, skip, groups):
        self.cluster, self.function, self.arguments = cluster, function, arguments
        self.limit, self.skip, self.groups = limit, skip, groups
        self.waiting = list(range(len(arguments)))[::-1]
        self.flying: dict[Any, tuple[int, tuple[str, ...]]] = {}  # futures, and who may make them
        self.deaths: Counter[int] = Counter()
        self.asked: dict[str, Any] = {}  # workers that have not said yet what they are
        self.fit: list[str] = []
        self.unfit: dict[str, str] = {}
        self.client: Any = None
        self.lost = False  # whether the scheduler was gone

    def answers(self) -> Iterator[tuple[int, CallResult]]:
        """Answer after answer; from the beginning with another client where the scheduler was gone."""
        while self.waiting or self.flying:
            try:
                self._connect()
                while self.waiting or self.flying:
                    self._look()
                    yield from self._hand_out()
                    yield from self._collect()
            except NoWorkers:
                raise
            except (OSError, TimeoutError, CancelledError) as problem:  # what Dask raises when nobody answers
                self.lost = True
                say(f"the scheduler at {self.cluster.address} is gone ({type(problem).__name__}); waiting for it")
                self.give_up()

    def _connect(self) -> None:
        """A client of the scheduler, as soon as there is one."""
        until = time.monotonic() + self.cluster.patience
        while True:
            try:
                self.client = self.cluster.dask.Client(self.cluster.address, timeout=10)
                if self.lost:
                    say(f"the scheduler is there again; {len(self.waiting)} calls are left")
                return
            except (OSError, TimeoutError):
                if time.monotonic() > until:
                    away = f"no scheduler at {self.cluster.address} for {self.cluster.patience:g} s"
                    raise NoWorkers(away) from None
            time.sleep(LOOK)

    def give_up(self) -> None:
        """What is under way is left; the client goes."""
        self.waiting += [index for index, _ in self.flying.values()]
        self.flying.clear()
        self.asked.clear()
        self.fit, self.unfit = [], {}
        if self.client is not None:
            self.client.close(timeout=2)
            self.client = None

    def _look(self) -> None:
        """Who is there, and whether they fit; waits for one that does."""
        until = time.monotonic() + self.cluster.patience
        while True:
            there = self.client.scheduler_info(n_workers=-1).get("workers", {})
            if self.client.status != "running":
                raise OSError("the connection is lost")
            for worker in there:
                if worker not in (*self.fit, *self.unfit, *self.asked):
                    question = self.cluster.question
                    self.asked[worker] = self.client.submit(
                        cluster_probe.identify, *question, workers=[worker], pure=False
                    )
            self.asked = {worker: future for worker, future in self.asked.items() if worker in there}
            self._hear()
            self.fit = [worker for worker in self.fit if worker in there]
            stranded = [future for future, (_, tied) in self.flying.items() if not {*tied} & {*there}]
            self.waiting += [self.flying.pop(future)[0] for future in stranded]
            if self.fit:
                return
            if time.monotonic() > until:
                reasons = "; ".join(dict.fromkeys(self.unfit.values())) or "there is none"
                raise NoWorkers(f"no worker at {self.cluster.address} fits: {reasons}")
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
            other = told if isinstance(told, str) else cluster_worker.difference(told, self.cluster.identity)
            if not other:
                self.fit.append(worker)
                continue
            self.unfit[worker] = other
            if worker not in self.cluster.told:
                self.cluster.told.add(worker)
                say(f"worker {worker} is left out: {other}")

    def _hand_out(self) -> Iterator[tuple[int, CallResult]]:
        while self.waiting and len(self.flying) < AHEAD * len(self.fit):
            index = self.waiting.pop()
            given = self.skip(index)
            if given is not None:
                yield index, given
                continue
            try:
                call = pickle.dumps((self.function, self.arguments[index]))
            except (pickle.PicklingError, TypeError, AttributeError) as problem:
                yield index, CallResult("raised", reason=legible(f"what it is given cannot travel: {problem}"))
                continue
            future = self.client.submit(
                cluster_worker.make, call, self.limit, self.groups[index], workers=self.fit, pure=False, retries=0
            )
            self.flying[future] = index, tuple(self.fit)

    def _collect(self) -> Iterator[tuple[int, CallResult]]:
        """What has ended within a little while."""
        if not self.flying:
            return
        try:
            self.cluster.dask.wait(list(self.flying), timeout=LOOK, return_when="FIRST_COMPLETED")
        except TimeoutError:
            return
        ended = [future for future in self.flying if future.status != "pending"]
        good = [future for future in ended if future.status == "finished"]
        answers = self.client.gather(good, errors="skip") if good else []
        if len(answers) != len(good):  # the worker that held an answer is gone: it is asked for again
            answers, good = [], []
        for future, answer in zip(good, answers, strict=True):
            index, _ = self.flying.pop(future)
            yield index, _open(answer)
        for future in ended:
            if future in self.flying:
                yield from self._without(self.flying.pop(future)[0], future)

    def _without(self, index: int, future) -> Iterator[tuple[int, CallResult]]:
        """Ask for a call again that has ended without an answer, unless it is the call's own fault."""
        problem = future.exception() if future.status == "error" else None
        killed = isinstance(problem, self.cluster.dask.scheduler.KilledWorker)
        self.deaths[index] += killed
        if isinstance(problem, cluster_worker.UnknownWorker):
            self.fit = []  # all are asked again
        if (
            problem is None
            or isinstance(problem, cluster_worker.UnknownWorker)
            or (killed and self.deaths[index] < DEADLY)
        ):
            self.waiting.append(index)
        elif killed:
            yield index, CallResult("died", reason=f"it ended {DEADLY} workers of the cluster", lasting=False)
        else:
            yield index, CallResult("raised", reason=legible(f"{type(problem).__name__}: {problem}"))


def _open(answer: CallResult) -> CallResult:
    """An answer with its value as it was before it travelled."""
    if answer.outcome != "done":
        return answer
    try:
        return replace(answer, value=read(answer.value))
    except Exception as problem:  # whatever stands in an answer's place
        return CallResult("raised", reason=legible(f"its answer cannot be read: {problem}"))
