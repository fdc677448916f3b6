"""A clock for tests: time passes only where a test says so, so that no result depends on the machine or its load."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import SimpleNamespace

from adapters.processes.worker import CallResult
from reports.running.calls import Calls

# Seconds that a look at the clock takes: far below every time that a test measures.
TICK = 1e-9
LOOP = 1e-3  # s, of an undisturbed calibration

# What is left of a run without its notes, without the callback as well, and without the binding as well.
LEFT = {"notes": 0.8, "callback": 0.5, "binding": 0.375}


class Watch:
    """Stands for the module `time`; the processor's seconds and those on the wall pass separately."""

    def __init__(self) -> None:
        self.wall = self.cpu = 0.0

    def perf_counter(self) -> float:
        """Wall seconds."""
        self.wall += TICK
        return self.wall

    def process_time(self) -> float:
        """CPU seconds."""
        self.cpu += TICK
        return self.cpu

    monotonic, thread_time = perf_counter, process_time

    def spend(self, cpu: float, wall: float | None = None) -> None:
        """Let CPU seconds pass, and as many on the wall if it does not say how many."""
        self.cpu += cpu
        self.wall += cpu if wall is None else wall

    def work(self, cpu: float, done: Callable[[], object] = lambda: None, wall: float | None = None) -> Callable:
        """A function of any arguments that calls `done`, takes so long and returns its first argument."""

        def work(*arguments):
            done()
            self.spend(cpu, wall)
            return arguments[0] if arguments else None

        return work

    def engine(self, build: float, run: float, read: float, /, **more) -> SimpleNamespace:
        """An adapter whose functions take so many CPU seconds; each setting's knob `cost` multiplies all three."""

        def built(case, route, setting):
            self.spend(build * setting["cost"])
            return SimpleNamespace(cost=setting["cost"])

        def taking(seconds: float) -> Callable:
            def work(model):
                self.spend(seconds * model.cost)
                return SimpleNamespace(t=())

            return work

        def bare_run(case, route, setting, without):
            return self.work(run * setting["cost"] * LEFT[without])

        functions = dict(build=built, run=taking(run), read=taking(read), bare_run=bare_run)
        return SimpleNamespace(**functions | more)


class Here:
    """Stands for a pool of workers: makes the calls in this process, at once; `made` are those it was given."""

    def __init__(self) -> None:
        self.made: list[tuple] = []

    def run(self, function: Callable, arguments, *_) -> Iterator[tuple[int, CallResult]]:
        """Answers in the order of the calls."""
        for i, call in enumerate(arguments):
            self.made.append(call)
            yield i, CallResult("done", value=function(*call))

    def close(self) -> None:
        """There is nothing to end."""


class CallsHere(Calls):
    """Calls that are made in this process; `made` are those that were not taken from the store."""

    made: list[tuple]

    def __enter__(self) -> CallsHere:
        self._pool = Here()
        self.made = self._pool.made
        return self
