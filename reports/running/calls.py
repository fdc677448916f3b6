"""Runs lists of calls: in workers, with a time limit and a progress display; stored results are reused.

A result is stored with a key of the function's code, its arguments and the solvers that they name. No code of an
adapter runs in this process: all questions to a solver are asked in a worker.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any, NamedTuple, get_type_hints

from adapters.processes.worker import CallResult
from cases import Case

from .cluster import Cluster
from .progress import Progress, silent
from .records import now
from .solvers import groups_of, is_missing, named_in, pool, version
from .storage.fingerprint import Key, adapter_sources, environment_key, of_argument, sources
from .storage.result_store import Store
from .time_limits import ASKING_SECONDS, LIMIT_SECONDS
from .timing.phase_times import PhaseTimes
from .versions import split_version

# Kinds of answers that do not depend on the machine, if its identity is the same; these may run on a cluster.
ELSEWHERE = {"truth", "run", "trial"}
# A longer text is not a name.
_NAMED_CHARACTERS = 120

# Takes a call and the calls that timed out so far; returns an answer in its place, or None if it must be made.
Skip = Callable[[tuple, Sequence[tuple]], CallResult | None]


class StorePolicy(NamedTuple):
    """How answers are stored.

    `kind`: their kind in the store; `of`: the part of the arguments that they depend on; `apart`: modules whose code is
    not part of the key, because their results are arguments; `worth`: which answers are stored; `failures`: whether
    failures are stored too."""

    kind: str = "trial"
    of: Callable[..., tuple] = lambda *arguments: arguments
    apart: tuple[ModuleType, ...] = ()
    worth: Callable[[Any], bool] = lambda value: True
    failures: bool = True


class _Failure(NamedTuple):
    """The stored record of a call that ended its process or timed out."""

    outcome: str
    reason: str
    output: str
    when: str


@dataclass
class Calls:
    """Makes calls: `jobs` at a time, each within `limit` wall seconds, with a progress display and a store.

    `versions`: the version of each solver (`ask_versions`), "" if unknown; results of such a solver are not stored.
    `interruptions`: a sentence for each call that was ended twice from outside, so that its result may differ another
    time. `times`: wall and CPU time of each step. `cluster`: makes the calls of the kinds ELSEWHERE, if given.
    A context manager that ends the workers of this machine.
    """

    jobs: int = 2
    limit: float = LIMIT_SECONDS
    store: Store = field(default_factory=lambda: Store(None))
    progress: Progress = silent
    versions: dict[str, str] = field(default_factory=dict)
    interruptions: list[str] = field(default_factory=list)
    times: PhaseTimes = field(default_factory=PhaseTimes)
    cluster: Cluster | None = None

    def __enter__(self) -> Calls:
        self._pool = pool(self.jobs)
        return self

    def __exit__(self, *_) -> None:
        self._pool.close()

    def begin(self, solvers: Iterable[str]) -> None:
        """Start workers, and meanwhile read the source code for the solvers' keys."""
        solvers = tuple(solvers)
        groups = sorted({group for group in groups_of((name,) for name in solvers) if not split_version(group)[1]})
        self._pool.begin(groups, "reports.running.tasks")
        for name in solvers:
            with suppress(SyntaxError, ValueError, LookupError, OSError):  # the solver then fails in its rows
                adapter_sources(name)

    def alone(self) -> Calls:
        """A copy for timings: one separate worker on this machine, without a progress display."""
        return replace(self, jobs=1, progress=silent, cluster=None)

    def ask_versions(self, solvers: Iterable[str]) -> None:
        """Ask the solvers for their versions, unless known."""
        new = [name for name in solvers if name not in self.versions]
        limit = min(self.limit, ASKING_SECONDS)
        answers = self.all("versions", version, [(name,) for name in new], limit=limit, brief=True)
        self.versions |= {n: a.value if a.outcome == "done" else "" for n, a in zip(new, answers, strict=True)}

    def present(self, solvers: Iterable[str]) -> tuple[str, ...]:
        """The solvers that are installed here."""
        solvers = tuple(solvers)
        self.ask_versions(solvers)
        return tuple(name for name in solvers if not is_missing(self.versions[name]))

    def all(self, step: str, function: Callable, arguments: Sequence[tuple], **how) -> list[CallResult]:
        """The answers of `each`, in the order of the arguments."""
        return [answer for _, answer in sorted(self.each(step, function, arguments, **how), key=lambda pair: pair[0])]

    def each(
        self,
        step: str,
        function: Callable,
        arguments: Sequence[tuple],
        limit: float | None = None,
        keep: StorePolicy | None = None,
        skip: Skip = lambda call, slow: None,
        brief: bool = False,
        group: str | None = None,
    ) -> Iterator[tuple[int, CallResult]]:
        """Yield index and answer of `function(*arguments[i])` for every i: stored answers first, then the rest.

        `limit` replaces the usual time limit; `brief` calls take milliseconds each; `group`: the worker group of all
        calls ("": no engine is loaded). With `keep`, answers are stored and reused, also of calls that ended their
        process or timed out with this limit; the function's return annotation is the stored type. Outcomes with a cause
        outside (a signal, a fault of the machine) are not stored.
        """
        limit = self.limit if limit is None else limit
        keys = [keep and self.key(function, call, keep) for call in arguments]
        remaining: list[int] = []
        slow: list[tuple] = []
        for i, key in enumerate(keys):
            answer = self._from_store(function, key, keep, limit)
            if answer is None:
                remaining.append(i)
                continue
            if answer.outcome == "timed_out":
                slow.append(arguments[i])
            yield i, answer
        if not remaining:
            self.times.book(step)
            return
        calls = [arguments[i] for i in remaining]
        title = f"{step} ({len(keys) - len(remaining)} more from the store)" if len(remaining) < len(keys) else step
        groups = groups_of(calls) if group is None else [group] * len(calls)
        machines = self.cluster if self.cluster is not None and keep and keep.kind in ELSEWHERE else self._pool
        with closing(machines.run(function, calls, limit, lambda k: skip(calls[k], slow), groups, brief)) as coming:
            for k, answer in self.progress(title, len(calls), coming):
                if answer.outcome == "timed_out":
                    slow.append(calls[k])
                if answer.outcome == "died" and not answer.lasting:
                    self.interruptions.append(f"{step}, {_call_text(calls[k])}: {answer.reason}")
                if keep:
                    answer = replace(answer, when=now())
                    self._keep(function, keys[remaining[k]], keep, limit, answer)
                yield remaining[k], answer
        self.times.book(step)

    def _from_store(
        self, function: Callable, key: Key | None, keep: StorePolicy | None, limit: float
    ) -> CallResult | None:
        if keep is None or key is None:
            return None
        value = self.store.get(keep.kind, key, _result(function))
        if value is not None:
            return CallResult("done", value=value)
        # A finished call is valid for any limit, a failed one only for the same limit.
        failure = self.store.get(keep.kind, {**key, "limit": limit}, _Failure)
        return failure and CallResult(**failure._asdict())

    def _keep(self, function: Callable, key: Key | None, keep: StorePolicy, limit: float, answer: CallResult) -> None:
        if answer.outcome == "done":
            if keep.worth(answer.value):
                self.store.put(keep.kind, key, answer.value, _result(function))
        elif keep.failures and answer.lasting and answer.outcome != "raised":
            failure = _Failure(answer.outcome, answer.reason, answer.output, answer.when)
            self.store.put(keep.kind, key and {**key, "limit": limit}, failure, _Failure)

    def key(self, function: Callable, call: tuple, keep: StorePolicy) -> Key | None:
        """The key of a call's answer; None (not stored) if the version of a solver is unknown or an argument cannot be
        compared."""
        content = keep.of(*call)
        cases = [each for each in content if isinstance(each, Case)]
        engines = environment_key(self.versions, sorted(named_in(content, self.versions.__contains__)))
        arguments = [of_argument(each) for each in content]
        if engines is None or None in arguments:
            return None
        return {
            "case": ", ".join(case.label for case in cases),
            "function": f"{function.__module__}.{function.__qualname__}",
            "arguments": arguments,
            "code": sources(sys.modules[function.__module__], keep.apart),
            **engines,
        }


def _result(function: Callable) -> Any:
    """The return annotation of a function."""
    return get_type_hints(function)["return"]


def _call_text(call: tuple) -> str:
    """A call's cases, solvers and settings as text."""
    texts = [argument.label if isinstance(argument, Case) else str(argument) for argument in call[:4]]
    return " ".join(text for text in texts if text and len(text) <= _NAMED_CHARACTERS)
