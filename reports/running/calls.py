"""The one way to run a list of calls: in workers, within a limit, with progress shown; what is kept is not made again.

What is kept is kept under a key of the function's code, its arguments and the solvers that they name. Nothing that an
adapter brings is called in this process: what a solver is asked, it is asked in a worker.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any, NamedTuple, get_type_hints

from cases import Case

from .processes import workers
from .processes.cluster import Cluster
from .processes.progress import Progress, silent
from .processes.worker_process import CallResult
from .records import now
from .solvers import groups_of, is_missing, named_in, version
from .storage.fingerprint import Key, adapter_sources, environment_key, of_argument, sources
from .storage.result_store import Store
from .timing.phase_times import PhaseTimes
from .versions import split_version

# Wall time (s) a call may take. A whole default report takes minutes, so one run that takes longer has lost its way.
LIMIT_SECONDS = 60.0
# Wall seconds in which a solver says its version, or what it offers for a case: that takes milliseconds, and imports a
# few seconds.
ASKING_SECONDS = 20.0

# Kinds of answers that do not depend on the machine, as far as a cluster's are like this one.
ELSEWHERE = {"truth", "run", "trial"}
# What is longer is no name of anything.
_NAMED_CHARACTERS = 120

# Given a call and the calls that ran out of time so far: the answer that stands for it, or None if it is to be made.
Skip = Callable[[tuple, Sequence[tuple]], CallResult | None]


class StorePolicy(NamedTuple):
    """How answers are kept: the store's word for them; what of the arguments they depend on; modules whose code they
    do not depend on, because what it found out is an argument; which answers are worth keeping; whether failures are
    kept as well."""

    kind: str = "trial"
    of: Callable[..., tuple] = lambda *arguments: arguments
    apart: tuple[ModuleType, ...] = ()
    worth: Callable[[Any], bool] = lambda value: True
    failures: bool = True


class _Failure(NamedTuple):
    """What is kept of a call that ended its process or ran out of time."""

    outcome: str
    reason: str
    output: str
    when: str


@dataclass
class Calls:
    """Where calls are made: how many at a time, within how many wall seconds each, who watches, where answers are kept.

    `versions`: what each solver said of itself (`ask_versions`), "" where it could not; without it nothing that
    depends on the solver is kept. `lost`: a sentence for each call that something outside ended twice, so that it would
    come out otherwise another time. `spent`: what each step took. `cluster`: who makes calls of the kinds ELSEWHERE, if
    that is not this machine. `timed`: nothing but the calls runs in the workers. A context manager: the workers of this
    machine end with it.
    """

    jobs: int = 2
    limit: float = LIMIT_SECONDS
    store: Store = field(default_factory=lambda: Store(None))
    progress: Progress = silent
    versions: dict[str, str] = field(default_factory=dict)
    lost: list[str] = field(default_factory=list)
    spent: PhaseTimes = field(default_factory=PhaseTimes)
    cluster: Cluster | None = None
    timed: bool = False

    def __enter__(self) -> Calls:
        self._pool = workers.WorkerPool(self.jobs, known_run=not self.timed)
        return self

    def __exit__(self, *_) -> None:
        self._pool.close()

    def begin(self, solvers: Iterable[str]) -> None:
        """Have workers start, and meanwhile read the code that decides the solvers' results."""
        solvers = tuple(solvers)
        self._pool.begin(
            sorted({group for group in groups_of((name,) for name in solvers) if not split_version(group)[1]})
        )
        for name in solvers:
            with suppress(SyntaxError, ValueError, LookupError, OSError):  # its solver fails when it is asked, in a row
                adapter_sources(name)

    def alone(self) -> Calls:
        """The same with one worker of its own, on this machine, and nothing shown: for what is timed."""
        return replace(self, jobs=1, progress=silent, cluster=None, timed=True)

    def ask_versions(self, solvers: Iterable[str]) -> None:
        """Note the versions of solvers that are not known yet."""
        new = [name for name in solvers if name not in self.versions]
        limit = min(self.limit, ASKING_SECONDS)
        answers = self.all("versions", version, [(name,) for name in new], limit=limit, brief=True)
        self.versions |= {n: a.value if a.outcome == "done" else "" for n, a in zip(new, answers, strict=True)}

    def present(self, solvers: Iterable[str]) -> tuple[str, ...]:
        """Those of the solvers that are installed here."""
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
        """Index and answer of `function(*arguments[i])` for every i as they come: what is kept first, then the rest.

        `limit` stands in the place of the usual one; `brief` calls take milliseconds each.
        `group`: the worker group of all of them ("": nothing of an engine is loaded). With `keep` a call that
        returned is made only once, and so is one that ended its process or ran out of time under this limit; the
        function's annotation says what it returns. What came from outside (a signal, an exception that is the machine's
        fault) is not kept.
        """
        limit = self.limit if limit is None else limit
        keys = [keep and self.key(function, call, keep) for call in arguments]
        left: list[int] = []
        slow: list[tuple] = []
        for i, key in enumerate(keys):
            answer = self._kept(function, key, keep, limit)
            if answer is None:
                left.append(i)
                continue
            if answer.outcome == "timed_out":
                slow.append(arguments[i])
            yield i, answer
        if not left:
            self.spent.book(step)
            return
        calls = [arguments[i] for i in left]
        title = f"{step} ({len(keys) - len(left)} more from the store)" if len(left) < len(keys) else step
        groups = groups_of(calls) if group is None else [group] * len(calls)
        pool = self.cluster if self.cluster is not None and keep and keep.kind in ELSEWHERE else self._pool
        with closing(pool.run(function, calls, limit, lambda k: skip(calls[k], slow), groups, brief)) as coming:
            for k, answer in self.progress(title, len(calls), coming):
                if answer.outcome == "timed_out":
                    slow.append(calls[k])
                if answer.outcome == "died" and not answer.lasting:
                    self.lost.append(f"{step}, {_call_text(calls[k])}: {answer.reason}")
                if keep:
                    answer = replace(answer, when=now())
                    self._keep(function, keys[left[k]], keep, limit, answer)
                yield left[k], answer
        self.spent.book(step)

    def _kept(self, function: Callable, key: Key | None, keep: StorePolicy | None, limit: float) -> CallResult | None:
        if keep is None or key is None:
            return None
        value = self.store.get(keep.kind, key, _result(function))
        if value is not None:
            return CallResult("done", value=value)
        # A finished call stands whatever the limit is now; one that failed, under the limit it had.
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
        """What decides a call's answer; None, and so nothing is kept, where a solver could not tell its version or an
        argument has something that cannot be compared."""
        said = keep.of(*call)
        cases = [each for each in said if isinstance(each, Case)]
        engines = environment_key(self.versions, sorted(named_in(said, self.versions.__contains__)))
        arguments = [of_argument(each) for each in said]
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
    """The type that a function says it returns."""
    return get_type_hints(function)["return"]


def _call_text(call: tuple) -> str:
    """A call's cases, solvers and settings, for people."""
    told = [argument.label if isinstance(argument, Case) else str(argument) for argument in call[:4]]
    return " ".join(text for text in told if text and len(text) <= _NAMED_CHARACTERS)
