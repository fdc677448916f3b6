"""Cases × solvers × routes × settings -> runs.

Four steps, each a list of isolated calls of `trial`: ask the solvers for their versions, find the truths, ask what the
solvers offer, run it all. Whatever happens, each run gives a record. What is finished goes into the store at once, and
what is there already is not done again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from typing import NamedTuple

from adapters import Setting
from cases import Case

from . import workers
from .fingerprint import Key, Keys, record_digest
from .records import CaseKey, Experiment, Offer, Run, Truth, gives_motion
from .store import Store, now
from .tasks import find_truth, perform, survey, version
from .workers import Answer

# Wall time a run may take. A whole default report takes minutes, so one run that takes longer has lost its way.
LIMIT_SECONDS = 60.0

Tell = Callable[[str, int, Iterator], Iterator]
Thin = Callable[[str, str, tuple[Setting, ...]], tuple[Setting, ...]]


def run(
    asked: tuple[Case, ...],
    solvers: tuple[str, ...],
    files: tuple[str, ...] = (),
    thin: Thin = lambda case, solver, settings: settings,
    jobs: int = 2,
    limit: float = LIMIT_SECONDS,
    tell: Tell = lambda step, total, answers: answers,
    store: Store | None = None,
) -> Experiment:
    """Run every setting of every route of every solver on every case, or those that `thin(case name, solver, ladder)`
    leaves.

    `tell(step, total, answers)` may show progress: it hands on what it iterates over. Without a `store` nothing is
    kept.
    """
    began = time.perf_counter()
    with workers.Pool(jobs) as pool:
        bench = _Bench(pool, limit, tell, store or Store(None))
        names = {case.label: CaseKey.of(case, files) for case in asked}
        versions = bench.versions(solvers)
        keys = {case.label: Keys(case, versions) for case in asked}
        truths = bench.truths(names, keys)
        runs, tasks = _planned(bench.offers(names, solvers), names, truths, keys, thin)
        _filled(runs, bench.runs(tasks))
    return Experiment(asked, truths, tuple(runs), time.perf_counter() - began, versions)


def _filled(runs: list[Run], coming: Iterator[tuple[int, Run]]) -> None:
    """Put the runs that come in their places, without samples and differences but for the finest of each route.

    Those are for figures, which draw no other: a thousand runs' would take some hundred megabytes.
    """
    finest: dict[tuple[str, str, str], int] = {}
    for place, found in coming:
        runs[place] = found
        route = (found.case, found.solver, found.route)
        undrawn, best = place, finest.get(route)
        if gives_motion(found) and (best is None or place > best):
            finest[route], undrawn = place, place if best is None else best
        if undrawn != finest.get(route):
            runs[undrawn] = replace(runs[undrawn], samples={}, off={})


class _Task(NamedTuple):
    """A run to make: its place among the runs, its case's label, the arguments of `perform`, its key in the store."""

    place: int
    label: str
    call: tuple
    key: Key | None


@dataclass(frozen=True)
class _Bench:
    """Where calls are made: by whom, for how long each, who watches, where results are kept."""

    pool: workers.Pool
    limit: float
    tell: Tell
    store: Store

    def versions(self, solvers: tuple[str, ...]) -> dict[str, str]:
        """What each solver tells of itself; "" where it cannot."""
        answers = dict(self._calls("versions", version, [(name,) for name in solvers]))
        return {name: answers[i].value if answers[i].outcome == "done" else "" for i, name in enumerate(solvers)}

    def truths(self, names: Mapping[str, CaseKey], keys: Mapping[str, Keys]) -> dict[str, Truth]:
        """The motion each case's runs are judged by, kept or found."""
        under = {label: keys[label].truth(kept=not name.files) for label, name in names.items()}
        kept = {label: self.store.get("truth", key, Truth) for label, key in under.items()}
        found = {label: truth for label, truth in kept.items() if truth}
        missing = [label for label in names if label not in found]
        calls = [(names[label],) for label in missing]
        for i, answer in self._calls(_title("truth", len(found)), find_truth, calls):
            found[missing[i]] = answer.value if answer.outcome == "done" else Truth(failure=answer.reason)
            if answer.outcome == "done":
                self.store.put("truth", under[missing[i]], answer.value)
        return {label: found[label] for label in names}

    def offers(
        self, names: Mapping[str, CaseKey], solvers: tuple[str, ...]
    ) -> dict[tuple[str, str], tuple[Offer, ...]]:
        """What each solver offers for each case, by label and name. Asked anew each time: it is quick, and an engine
        that was not installed may be now."""
        pairs = [(label, name) for label in names for name in solvers]
        answers = dict(self._calls("survey", survey, [(names[label], name) for label, name in pairs]))
        return {pair: _offers(answers[i]) for i, pair in enumerate(pairs)}

    def runs(self, tasks: list[_Task]) -> Iterator[tuple[int, Run]]:
        """Place and run of every task as they come: those kept first, then those made, each kept before it is told."""
        left: list[_Task] = []
        slow: list[tuple] = []
        for task in tasks:
            # A finished run stands whatever the limit is now; one that ran out of time, under the limit it had.
            kept = self.store.get("run", task.key, Run) or self.store.get("run", _within(task.key, self.limit), Run)
            if kept is None:
                left.append(task)
                continue
            if kept.outcome == "timed_out":
                slow.append(task.call)
            yield task.place, replace(kept, rung=task.call[4])
        step = _title("runs", len(tasks) - len(left))
        for i, answer in self._calls(step, perform, [t.call for t in left], lambda i: hopeless(left[i].call, slow)):
            task, found = left[i], _run(left[i], answer)
            if found.outcome == "timed_out":
                slow.append(task.call)
            if answer.lasting and answer.outcome != "raised":
                key = _within(task.key, self.limit) if found.outcome == "timed_out" else task.key
                self.store.put("run", key, found)
            yield task.place, found

    def _calls(
        self,
        step: str,
        function: Callable,
        arguments: list[tuple],
        instead: Callable[[int], Answer | None] = lambda i: None,
    ) -> Iterator[tuple[int, Answer]]:
        """Index and answer of each call as they come."""
        if not arguments:
            return
        with closing(self.pool.run(function, arguments, self.limit, instead)) as coming:
            yield from self.tell(step, len(arguments), coming)


def _title(step: str, kept: int) -> str:
    return f"{step} ({kept} more from the store)" if kept else step


def hopeless(call: tuple, slow: Iterable[tuple]) -> Answer | None:
    """A rung finer than one that ran out of time would run out of time as well: it is told so, not waited for.

    Calls are (case, solver, route, setting, rung, …); ladders go from coarse to fine."""
    for other in slow:
        if other[:3] == call[:3] and other[4] < call[4]:
            return Answer("timed_out", reason=f"not tried: {other[3]} had run out of time", lasting=False)
    return None


def _within(key: Key | None, limit: float) -> Key | None:
    return key and {**key, "limit": limit}


def _planned(
    offers: Mapping[tuple[str, str], tuple[Offer, ...]],
    names: Mapping[str, CaseKey],
    truths: Mapping[str, Truth],
    keys: Mapping[str, Keys],
    thin: Thin,
) -> tuple[list[Run], list[_Task]]:
    """All runs in the tables' order, and the tasks that fill in those without an outcome yet."""
    runs: list[Run] = []
    tasks: list[_Task] = []
    for (label, name), of_routes in offers.items():
        truth, judge = truths[label], record_digest(truths[label])
        for offer in of_routes:
            excuse = _excuse(offer, truth)
            if excuse:
                runs.append(Run(label, name, offer.route, "", 0, *excuse))
                continue
            for rung, setting in enumerate(thin(names[label].name, name, offer.settings), start=1):
                call = (names[label], name, offer.route, setting, rung, truth)
                tasks.append(_Task(len(runs), label, call, keys[label].run(name, offer.route, setting, judge)))
                runs.append(Run(label, name, offer.route, str(setting), rung, outcome=""))
    return runs, tasks


def _offers(answer: Answer) -> tuple[Offer, ...]:
    if answer.outcome == "done":
        return answer.value
    return (Offer("", (), _outcome(answer), f"asking for its settings: {answer.reason}"),)


def _excuse(offer: Offer, truth: Truth) -> tuple[str, str] | None:
    """Outcome and reason where there is nothing to run."""
    if offer.outcome:
        return offer.outcome, offer.reason
    if truth.failure:
        return "refused", f"there is no truth to judge it by: {truth.failure}"
    return None if offer.settings else ("refused", "it offers no setting for this case")


def _run(task: _Task, answer: Answer) -> Run:
    if answer.outcome == "done":
        return replace(answer.value, when=now())
    _, name, route, setting, rung, _ = task.call
    reason = f"{answer.reason}; it last printed: {answer.output[-200:]}" if answer.output else answer.reason
    return Run(task.label, name, route, str(setting), rung, _outcome(answer), reason, when=now())


def _outcome(answer: Answer) -> str:
    return "timed_out" if answer.outcome == "timed_out" else "crashed"
