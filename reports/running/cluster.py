"""Runs calls on a Dask cluster with its standard client, in place of a `WorkerPool` of this machine.

Workers and the scheduler may leave and return: a call is submitted again until its answer has arrived. A worker whose
answers would differ (another version, no heyoka, engine not installed) is excluded, and a message gives the reason.
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

from adapters.processes.pool import read
from adapters.processes.worker import CallResult
from cases import BadValue
from cases.errors import describe, legible

from . import cluster_worker
from .cluster_worker import Identity
from .solvers import groups_of

LOCAL = "local"
# Calls submitted at a time per worker: enough that no worker is idle.
CALLS_PER_WORKER = 4
# Seconds between two checks of the workers; longest absence of the scheduler or of all suitable workers, s.
POLL_SECONDS, PATIENCE = 2.0, 600.0
# A call that so many times ended its worker, or that workers could not make, is not submitted again.
DEADLY = 3
# Time limit for the connection to a scheduler, s.
ANSWERS = 5.0


class NoWorkers(OSError):
    """The scheduler or all suitable workers were absent for too long."""


def say(text: str) -> None:
    """Print a message on the terminal."""
    print(f"dask: {text}", file=sys.stderr, flush=True)


def check(address: str) -> None:
    """Raises BadValue if Dask is not installed or no scheduler answers at the address."""
    distributed = _dask()
    if address == LOCAL:
        return
    try:
        distributed.comm.get_address_host_port(address)  # a client that fails to start prints tracebacks
        distributed.Client(address, timeout=ANSWERS, set_as_default=False).close()
    except (OSError, TimeoutError, ValueError) as problem:
        raise BadValue(f"no scheduler answers at --dask {address} ({problem}); start one there") from None


def _dask():
    try:
        import distributed
    except ImportError as problem:
        raise BadValue(f"--dask needs Dask ({problem}); install it: pip install 'slip-to-roll[dask]'") from None
    return distributed


class Cluster:
    """The workers of a scheduler that have the same `identity` as this machine; the interface of `pools.WorkerPool`.

    `address`: the scheduler's, or LOCAL for `jobs` workers of this machine. `solvers` and `files`: the solvers and case
    files that are part of the identity. Raises NoWorkers if the scheduler or all suitable workers are absent for
    `patience` seconds.
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
        self.warnings: set[str] = set()  # workers whose exclusion was reported
        self._own = None
        if address == LOCAL:
            import dask

            dask.config.set({"distributed.worker.profile.enabled": False})  # it samples each worker every 10 ms
            self._own = self.dask.LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None)
            self.address = self._own.scheduler_address

    def close(self) -> None:
        """End the workers of a local cluster; other clusters keep theirs."""
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
        """As `WorkerPool.run`; `brief` has no effect, because the workers run already. A call that ended DEADLY workers
        has the outcome "died", not lasting."""
        run = _ClusterRun(self, function, arguments, limit, skip, groups or groups_of(arguments))
        try:
            yield from run.answers()
        finally:
            run.give_up()


class _ClusterRun:
    """The state of one `Cluster.run`: waiting calls and calls in flight."""

    def __init__(self, cluster: Cluster, function: Callable, arguments: Sequence[tuple], limit: float, skip, groups):
        self.cluster, self.function, self.arguments = cluster, function, arguments
        self.limit, self.skip, self.groups = limit, skip, groups
        self.waiting = list(range(len(arguments)))[::-1]
        self.in_flight: dict[Any, tuple[int, tuple[str, ...]]] = {}  # call and allowed workers
        self.deaths: Counter[int] = Counter()
        self.pending: dict[str, Any] = {}  # workers whose identity is not known yet
        self.fit: list[str] = []
        self.unfit: dict[str, str] = {}
        self.client: Any = None
        self.reconnecting = False  # whether the connection to the scheduler was lost before

    def answers(self) -> Iterator[tuple[int, CallResult]]:
        """Yield the answers; connects again if the scheduler was gone."""
        while self.waiting or self.in_flight:
            try:
                self._connect()
                while self.waiting or self.in_flight:
                    self._update_workers()
                    yield from self._hand_out()
                    yield from self._collect()
            except NoWorkers:
                raise
            except (
                OSError,
                TimeoutError,
                CancelledError,
            ) as problem:  # Dask: no answer
                self.reconnecting = True
                say(f"the scheduler at {self.cluster.address} is gone ({type(problem).__name__}); waiting for it")
                self.give_up()

    def _connect(self) -> None:
        """Connect to the scheduler; waits until it answers."""
        until = time.monotonic() + self.cluster.patience
        while True:
            try:
                self.client = self.cluster.dask.Client(self.cluster.address, timeout=10)
                if self.reconnecting:
                    say(f"the scheduler is back; {len(self.waiting)} calls remain")
                return
            except (OSError, TimeoutError):
                if time.monotonic() > until:
                    away = f"no scheduler at {self.cluster.address} for {self.cluster.patience:g} s"
                    raise NoWorkers(away) from None
            time.sleep(POLL_SECONDS)

    def give_up(self) -> None:
        """Return calls in flight to the waiting ones, and close the client."""
        self.waiting += [index for index, _ in self.in_flight.values()]
        self.in_flight.clear()
        self.pending.clear()
        self.fit, self.unfit = [], {}
        if self.client is not None:
            self.client.close(timeout=2)
            self.client = None

    def _update_workers(self) -> None:
        """Update the lists of suitable and excluded workers; waits until one is suitable."""
        until = time.monotonic() + self.cluster.patience
        while True:
            there = self.client.scheduler_info(n_workers=-1).get("workers", {})
            if self.client.status != "running":
                raise OSError("the connection is lost")
            for worker in there:
                if worker not in (*self.fit, *self.unfit, *self.pending):
                    question = self.cluster.question
                    self.pending[worker] = self.client.submit(_probe(), *question, workers=[worker], pure=False)
            self.pending = {worker: future for worker, future in self.pending.items() if worker in there}
            self._collect_identities()
            self.fit = [worker for worker in self.fit if worker in there]
            orphans = [future for future, (_, workers) in self.in_flight.items() if not {*workers} & {*there}]
            self.waiting += [self.in_flight.pop(future)[0] for future in orphans]
            if self.fit:
                return
            if time.monotonic() > until:
                reasons = "; ".join(dict.fromkeys(self.unfit.values())) or "there are no workers"
                raise NoWorkers(f"no worker at {self.cluster.address} is suitable: {reasons}")
            time.sleep(0.1 * POLL_SECONDS)

    def _collect_identities(self) -> None:
        """Compare the identities that workers have sent with the required one."""
        for worker, future in list(self.pending.items()):
            if future.status == "pending":
                continue
            del self.pending[worker]
            if future.status != "finished":
                continue  # the worker is gone, or is asked again
            reply = future.result()
            other = reply if isinstance(reply, str) else cluster_worker.difference(reply, self.cluster.identity)
            if not other:
                self.fit.append(worker)
                continue
            self.unfit[worker] = other
            if worker not in self.cluster.warnings:
                self.cluster.warnings.add(worker)
                say(f"worker {worker} is excluded: {other}")

    def _hand_out(self) -> Iterator[tuple[int, CallResult]]:
        while self.waiting and len(self.in_flight) < CALLS_PER_WORKER * len(self.fit):
            index = self.waiting.pop()
            substitute = self.skip(index)
            if substitute is not None:
                yield index, substitute
                continue
            try:
                call = pickle.dumps((self.function, self.arguments[index]))
            except (pickle.PicklingError, TypeError, AttributeError) as problem:
                yield index, CallResult("raised", reason=legible(f"its arguments cannot be pickled: {problem}"))
                continue
            future = self.client.submit(
                cluster_worker.make, call, self.limit, self.groups[index], workers=self.fit, pure=False, retries=0
            )
            self.in_flight[future] = index, tuple(self.fit)

    def _collect(self) -> Iterator[tuple[int, CallResult]]:
        """Yield the answers that arrive within POLL_SECONDS."""
        if not self.in_flight:
            return
        try:
            self.cluster.dask.wait(list(self.in_flight), timeout=POLL_SECONDS, return_when="FIRST_COMPLETED")
        except TimeoutError:
            return
        ready = [future for future in self.in_flight if future.status != "pending"]
        good = [future for future in ready if future.status == "finished"]
        answers = self.client.gather(good, errors="skip") if good else []
        if len(answers) != len(good):  # the worker with an answer is gone: the call is made again
            answers, good = [], []
        for future, answer in zip(good, answers, strict=True):
            index, _ = self.in_flight.pop(future)
            yield index, _unpickle_value(answer)
        for future in ready:
            if future in self.in_flight:
                yield from self._retry_or_fail(self.in_flight.pop(future)[0], future)

    def _retry_or_fail(self, index: int, future) -> Iterator[tuple[int, CallResult]]:
        """Submit a call without an answer again; after DEADLY failures yield one if it ended its workers, and raise
        NoWorkers for any other exception: what a call raises is an answer, so the machines or the suite raised it."""
        problem = future.exception() if future.status == "error" else None
        if isinstance(problem, cluster_worker.UnknownWorker):
            problem, self.fit = None, []  # all identities are requested again
        self.deaths[index] += problem is not None
        if problem is None or self.deaths[index] < DEADLY:
            self.waiting.append(index)
        elif isinstance(problem, self.cluster.dask.scheduler.KilledWorker):
            yield index, CallResult("died", reason=f"it ended {DEADLY} workers of the cluster", lasting=False)
        else:
            raise NoWorkers(f"no worker of the cluster can make a call ({describe(problem)}); repeat the command")


def _probe() -> Callable:
    """The first call on a cluster's worker. It is pickled with its code, as all functions within functions are, because
    the worker may not have the suite."""

    def identify(solvers: tuple[str, ...], files: tuple[str, ...]):
        """The identity of the machine that runs this, or the reason why it has none."""
        try:
            from reports.running import cluster_worker

            return cluster_worker.ask_identity(solvers, files)
        except Exception as problem:
            return f"the suite is missing or incomplete ({type(problem).__name__}: {problem})"

    return identify


def _unpickle_value(answer: CallResult) -> CallResult:
    """The answer with its value unpickled."""
    if answer.outcome != "done":
        return answer
    try:
        return replace(answer, value=read(answer.value))
    except Exception as problem:  # the bytes of a broken answer can raise anything
        return CallResult("raised", reason=legible(f"its answer cannot be read: {problem}"))
