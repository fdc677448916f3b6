"""Cases × solvers × routes × settings -> runs.

Three steps, each a list of isolated calls of `trial`: find the truths, ask the solvers what they offer, run it all.
Whatever happens, each run gives a record.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from adapters import Setting
from cases import Case

from . import workers
from .records import CaseKey, Experiment, Offer, Run, Truth
from .trial import find_truth, load, perform, survey

# Wall time a run may take. A whole default report takes minutes, so one run that takes longer has lost its way.
LIMIT_SECONDS = 60.0


def run(
    asked: tuple[Case, ...],
    solvers: tuple[str, ...],
    files: tuple[str, ...] = (),
    thin: Callable[[str, tuple[Setting, ...]], tuple[Setting, ...]] = lambda case, settings: settings,
    jobs: int = 2,
    limit: float = LIMIT_SECONDS,
    tell: Callable[[str, int, Iterator], Iterator] = lambda step, total, answers: answers,
) -> Experiment:
    """Run every setting (of those `thin(case name, ladder)` leaves) of every route of every solver on every case.

    `tell(step, total, answers)` may show progress: it hands on what it iterates over.
    """
    began = time.perf_counter()
    keys = {case.label: CaseKey.of(case, files) for case in asked}

    def step(name: str, function: Callable, arguments: list[tuple], instead: Instead = never) -> list[workers.Answer]:
        answers: dict[int, workers.Answer] = {}
        calls = workers.run(function, arguments, jobs, limit, lambda index: instead(arguments, answers, index))
        for index, answer in tell(name, len(arguments), calls):
            answers[index] = answer
        return [answers[index] for index in range(len(arguments))]

    found = step("truth", find_truth, [(key,) for key in keys.values()])
    truths = {label: _truth(answer) for label, answer in zip(keys, found, strict=True)}
    pairs = [(label, name) for label in keys for name in solvers]
    offers = step("survey", survey, [(keys[label], name) for label, name in pairs])

    runs: list[Run | None] = []
    todo: list[tuple[int, tuple]] = []
    for (label, name), answer in zip(pairs, offers, strict=True):
        for offer in _offers(answer):
            excuse = _excuse(offer, truths[label])
            for rung, setting in enumerate(() if excuse else thin(keys[label].name, offer.settings), start=1):
                todo.append((len(runs), (keys[label], name, offer.route, setting, rung, truths[label])))
                runs.append(None)
            if excuse:
                runs.append(Run(label, name, offer.route, "", 0, *excuse))
    answers = step("runs", perform, [task for _, task in todo], instead=hopeless)
    for (place, task), answer in zip(todo, answers, strict=True):
        runs[place] = _run(task, answer)
    return Experiment(asked, truths, tuple(run for run in runs if run), time.perf_counter() - began)


Instead = Callable[[list[tuple], dict[int, workers.Answer], int], workers.Answer | None]


def never(arguments: list[tuple], answers: dict[int, workers.Answer], index: int) -> workers.Answer | None:
    """Every call is made."""
    return None


def hopeless(arguments: list[tuple], answers: dict[int, workers.Answer], index: int) -> workers.Answer | None:
    """A rung finer than one that ran out of time would run out of time as well: it is told so, not waited for."""
    for earlier, answer in answers.items():
        # Ladders go from coarse to fine: earlier in the list of the same case, solver and route is coarser.
        if answer.outcome == "timed_out" and earlier < index and arguments[earlier][:3] == arguments[index][:3]:
            return workers.Answer("timed_out", reason=f"not tried: {arguments[earlier][3]} had run out of time")
    return None


def _truth(answer: workers.Answer) -> Truth:
    return answer.value if answer.outcome == "done" else Truth(failure=answer.reason)


def _offers(answer: workers.Answer) -> tuple[Offer, ...]:
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


def _run(task: tuple, answer: workers.Answer) -> Run:
    if answer.outcome == "done":
        return answer.value
    key, name, route, setting, rung, _ = task
    reason = f"{answer.reason}; it last printed: {answer.output[-200:]}" if answer.output else answer.reason
    return Run(_label(key), name, route, str(setting), rung, _outcome(answer), reason)


def _label(key: CaseKey) -> str:
    return load(key).label


def _outcome(answer: workers.Answer) -> str:
    return "timed_out" if answer.outcome == "timed_out" else "crashed"
