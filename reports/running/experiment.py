"""Runs an experiment: cases × solvers × routes × settings.

It has four steps, each a list of calls of `tasks`: versions of the solvers, truths, settings of the solvers, runs.
Every run gives a record, also if it fails. Finished results are stored at once, and stored results are reused.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import reference
from adapters import Setting, refusal_kind
from adapters.processes.worker import CallResult
from cases import Case

from . import reference_adapter
from .calls import Calls, Skip, StorePolicy
from .ladder_selection import ladder_case
from .records import Experiment, Offer, Run, Truth, finest, now, routes
from .storage.fingerprint import truth_key
from .tasks import find_truth, measure, survey
from .time_limits import ASKING_SECONDS
from .versions import split_version

# A solver that did not answer for so many cases is not asked about the others, which would take as long.
_MOST_SILENCES = 3

# Takes a case's label, a solver, its route and its ladder; returns the settings to run.
Thin = Callable[[str, str, str, tuple[Setting, ...]], tuple[Setting, ...]]

# The code that computes the truth is not part of a run's key, because the truth itself is; for the reference as a
# contestant, its adapter's code is part of the key.
TRUTHS_OWN = (reference, reference_adapter)
_KEEP_TRUTH = StorePolicy("truth", of=lambda case: (case, truth_key()))
_KEEP_RUN = StorePolicy(
    "run",
    of=lambda case, solver, route, setting, rung, truth, *more: (case, solver, route, setting, truth, *more),
    apart=TRUTHS_OWN,
)


def run_cases(
    cases: Sequence[Case],
    solvers: Sequence[str],
    calls: Calls,
    thin: Thin = lambda case, solver, route, settings: settings,
    knobs: str = "ladder",
    truths: Mapping[str, Truth] | None = None,
    is_hard: bool = False,
    limit: float | None = None,
    step: str = "runs",
) -> Experiment:
    """Run every setting of every route of every solver on every case, or those that `thin(case label, solver, route,
    ladder)` returns. A study may have the settings of a grid (`knobs`), `truths` of its own, residuals in place of
    samples (`is_hard`), another time `limit` (s) of a run, and a name of this `step`.

    A solver that is not installed has no runs, only its entry in `versions`; one selected with a version has a row with
    the reason for each case."""
    present = calls.present(solvers)
    solvers = [name for name in solvers if name in present or split_version(name)[1]]
    truths = dict(truths) if truths else find_truths(cases, calls)
    offers_by_case = offers(cases, solvers, calls, knobs)
    in_detail = {ladder_case(cases)} if knobs == "ladder" else {case.label for case in cases}
    runs, tasks = _plan(cases, offers_by_case, truths, thin, is_hard, in_detail)
    for place, run in _make(tasks, calls, step, limit, knobs == "ladder"):
        runs[place] = run
    return Experiment(
        tuple(cases), truths, _with_figures(runs, in_detail), dict(calls.versions), _our_parts(offers_by_case)
    )


def _our_parts(offers_by_case: Mapping[tuple[str, str], tuple[Offer, ...]]) -> dict[tuple[str, str], str]:
    """What of each route is not its engine's own, by solver and route, where there is such a part."""
    by_solver = [(name, offer) for (_, name), route_offers in offers_by_case.items() for offer in route_offers]
    return {(name, offer.route): offer.our_part for name, offer in by_solver if offer.our_part}


def find_truths(cases: Sequence[Case], calls: Calls) -> dict[str, Truth]:
    """The truth of each case, stored or computed, by the case's label."""
    answers = calls.all("truth", find_truth, [(case,) for case in cases], keep=_KEEP_TRUTH)
    return {
        case.label: answer.value if answer.outcome == "done" else Truth(failure=answer.reason)
        for case, answer in zip(cases, answers, strict=True)
    }


def offers(
    cases: Sequence[Case], solvers: Sequence[str], calls: Calls, knobs: str = "ladder"
) -> dict[tuple[str, str], tuple[Offer, ...]]:
    """The settings (a ladder or a grid) of each solver for each case, by label and name; a failure is an offer.

    Never stored: the calls are quick, and an engine may have been installed since."""

    def silent(call: tuple, slow: Sequence[tuple]) -> CallResult | None:
        if Counter(other[1] for other in slow)[call[1]] < _MOST_SILENCES:
            return None
        return CallResult("timed_out", reason=f"not asked: {call[1]} had not answered for {_MOST_SILENCES} other cases")

    requests = [(case, name, knobs) for case in cases for name in solvers]
    answers = calls.all("survey", survey, requests, limit=min(calls.limit, ASKING_SECONDS), skip=silent, brief=True)
    by_key: dict[tuple[str, str], tuple[Offer, ...]] = {}
    for (case, name, _), answer in zip(requests, answers, strict=True):
        outcome, reason = answer.failure
        failure = (Offer("", (), outcome, f"asking for its {knobs}: {reason}"),)
        by_key[case.label, name] = answer.value if answer.outcome == "done" else failure
    return by_key


class _Task(NamedTuple):
    """A run to make: its place among the runs, and the arguments of `measure`."""

    place: int
    call: tuple


def _plan(
    cases: Sequence[Case],
    all_offers: Mapping[tuple[str, str], tuple[Offer, ...]],
    truths: Mapping[str, Truth],
    thin: Thin,
    is_hard: bool,
    in_detail: Collection[str],
) -> tuple[list[Run], list[_Task]]:
    """All runs in the order of the tables, and the tasks for those without an outcome yet. `in_detail`: the cases whose
    runs keep all their samples."""
    by_label = {case.label: case for case in cases}
    runs: list[Run] = []
    tasks: list[_Task] = []
    for (label, name), of_routes in all_offers.items():
        truth, more = truths[label], (is_hard, label in in_detail)
        for offer in of_routes:
            excuse = _excuse(offer, truth)
            if excuse:
                outcome, reason, kind = excuse
                runs.append(Run(label, name, offer.route, Setting.of(), 0, outcome, reason, refusal=kind))
                continue
            for rung, setting in enumerate(thin(label, name, offer.route, offer.settings), start=1):
                call = (by_label[label], name, offer.route, setting, rung, truth.without_samples(), *more)
                tasks.append(_Task(len(runs), call))
                runs.append(Run(label, name, offer.route, setting, rung, outcome=""))
    return runs, tasks


def _excuse(offer: Offer, truth: Truth) -> tuple[str, str, str] | None:
    """Outcome, reason and kind of refusal if there is nothing to run; else None."""
    if offer.outcome:
        return offer.outcome, offer.reason, offer.refusal
    if truth.failure:
        return "unsupported", f"there is no truth to judge it by: {truth.failure}", ""
    if truth.has_several_contacts and offer.one_contact_only:
        return "unsupported", offer.one_contact_only, refusal_kind(offer.one_contact_only)
    return None if offer.settings else ("unsupported", "it offers no setting for this case", refusal_kind(""))


def _make(
    tasks: Sequence[_Task], calls: Calls, step: str, limit: float | None, in_order: bool
) -> Iterator[tuple[int, Run]]:
    """Yield place and run of every task as they end; `in_order`: a route's settings are from coarse to fine."""
    skip: Skip = hopeless if in_order else lambda call, slow: None
    arguments = [task.call for task in tasks]
    for i, answer in calls.each(step, measure, arguments, limit=limit, keep=_KEEP_RUN, skip=skip):
        yield tasks[i].place, _run(tasks[i].call, answer)


def _run(call: tuple, answer: CallResult) -> Run:
    case, name, route, setting, rung, *_ = call
    result = answer.value
    names = (case.label, name, route, setting)
    if answer.outcome == "done" and (result.case, result.solver, result.route, result.setting) == names:
        return replace(result, rung=rung)
    if answer.outcome != "done":
        outcome, reason = answer.failure
    else:  # a check: an answer to another call must not get into a table
        outcome, reason = "crashed", f"the record belongs to another call: {result}"
    return Run(case.label, name, route, setting, rung, outcome, reason, when=answer.when or now())


def hopeless(call: tuple, slow: Sequence[tuple]) -> CallResult | None:
    """A time-out for a rung finer than one that timed out, which would time out as well; None for other rungs.

    Calls are (case, solver, route, setting, rung, …); ladders go from coarse to fine."""
    for other in slow:
        if other[:3] == call[:3] and other[4] < call[4]:
            return CallResult("timed_out", reason=f"not tried: {other[3]} had timed out", lasting=False)
    return None


def _with_figures(runs: Sequence[Run], in_detail: Collection[str]) -> tuple[Run, ...]:
    """The runs, with differences only where figures show them: with default settings, at the finest, `in_detail`."""
    best = {id(finest(group)) for group in routes(runs).values()}
    return tuple(
        run if run.setting.is_default or run.case in in_detail or id(run) in best else replace(run, off={})
        for run in runs
    )
