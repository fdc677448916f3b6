"""The timed pass of an experiment: which cases and settings take their turns at the clock, and what came of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from adapters.lookup import executables
from cases import Case

from .. import per_solver
from ..calls import Calls, StorePolicy
from ..processes.worker_process import CallResult
from ..records import Experiment, routes
from ..versions import split_version
from . import clock, cold_start, time_breakdown
from .clock import Contestant, Key, Timing
from .cold_start import ColdStart
from .time_breakdown import TimeBreakdown

# A curve of fewer settings tells no order and no saturation.
LEAST_SETTINGS = 6
# Wall seconds for all timings of a default report, and how many cases share them: once through the full ladder of every
# route takes some five seconds on a dear case, and an interval needs three times.
BUDGET, MOST_CASES = 42.0, 7
# A full report times every case, each for about so long.
FULL_BUDGET_A_CASE = 60.0
# Wall seconds a case may take for calls from cold, beside those that are made for imports, and for the parts of runs.
COLD_BUDGET, PARTS_BUDGET = 1.0, 1.5
# Beyond its budget a case may take as long as one run more and its compilations.
PATIENCE = 60.0
# The step of a build in which cold starts and the parts of runs are measured.
_BESIDE = "cold starts and parts"
# What is said of a contestant that an answer does not name.
_NONE = None, "the answer of the clock does not name it"
# The budget of those that are timed alone only to see whether they end their process.
_TRIAL_SECONDS = 1.0


class Timings(NamedTuple):
    """The cases timed, timings, and what could not be timed, with the reason."""

    cases: tuple[Case, ...] = ()
    timings: Mapping[Key, Timing] = {}
    failures: Mapping[str, str] = {}


class ExtraTimings(NamedTuple):
    """What is measured of some settings only, beside the timings: a call from cold, and the parts of a run."""

    cold: Mapping[Key, ColdStart] = {}
    parts: Mapping[Key, TimeBreakdown] = {}


def cases_to_time(experiment: Experiment, full: bool) -> list[Case]:
    """The cases to time: all, or of each family the variant with most transitions, those that most routes ran with
    their whole ladders."""
    able = [case for case in experiment.cases if not experiment.truths[case.label].failure]
    if full:
        return able
    events = {case.label: len(experiment.truths[case.label].transitions) for case in able}
    families: dict[str, list[Case]] = {}
    for case in able:
        families.setdefault(case.name, []).append(case)
    one_each = [max(family, key=lambda case: events[case.label]) for family in families.values()]
    whole = {case.label: _whole_ladders(experiment, case.label) for case in one_each}
    ranked = sorted(one_each, key=lambda case: (-whole[case.label], -events[case.label]))
    return [case for case in ranked if whole[case.label]][:MOST_CASES]


def _whole_ladders(experiment: Experiment, label: str) -> int:
    """How many routes ran enough settings of the case for a curve."""
    groups = routes(run for run in experiment.runs if run.case == label and run.rung)
    return sum(len(group) >= LEAST_SETTINGS for group in groups.values())


def contestants(experiment: Experiment, case: Case) -> list[Contestant]:
    """Every setting that gave a right motion of the case."""
    # An executable's time is its own word, and its process none of those that the clock can see.
    told = executables()
    mine = [run for run in experiment.runs if run.case == case.label and run.solver not in told]
    runs = [run for run in mine if run.outcome == "right"]
    return [Contestant(case, r.solver, r.route, r.setting, r.cost.wall_s + r.cost.setup_s) for r in runs]


def measure(experiment: Experiment, full: bool, calls: Calls) -> Timings:
    """Time the chosen cases one after the other, each in one process with nothing beside it, or take what is kept."""
    solvers = [run.solver for run in experiment.runs]
    (cases, in_turn), left_out = per_solver.make_per_solver(partial(_in_turn, full), (experiment,), solvers)
    timings: dict[Key, Timing] = {}
    failures = {f"all cases, {one.solver}": one.reason for one in left_out}
    deadline = time.perf_counter() + BUDGET
    share = FULL_BUDGET_A_CASE if full else BUDGET / max(len(cases), 1)

    def one_by_one(alone: Calls) -> Iterator[None]:
        for place, who in enumerate(in_turn):
            left = max(deadline - time.perf_counter(), 1.0) / (len(cases) - place)
            found, failed = time_together(who, FULL_BUDGET_A_CASE if full else left, share, alone)
            timings.update({one.key: timing for one, timing in found})
            failures.update({f"{one.case.label}, {' '.join(map(str, one[1:4]))}": why for one, why in failed})
            yield

    with calls.alone() as alone:
        for _ in calls.progress("timings", len(cases), one_by_one(alone)):
            pass
    return Timings(tuple(cases), timings, failures)


def _in_turn(full: bool, experiment: Experiment) -> tuple[list[Case], list[list[Contestant]]]:
    """The cases to time, and the contestants of each, cheap cases first: what they leave of the budget the dear ones
    have."""
    cases = cases_to_time(experiment, full)
    who = (contestants(experiment, case) for case in cases)
    return cases, sorted(who, key=lambda some: sum(one.expected_s for one in some))


def beside(experiment: Experiment, wanted: Collection[Key], full: bool, calls: Calls) -> ExtraTimings:
    """Calls from cold, and the parts of runs, of the settings that are wanted."""
    colds: dict[Key, ColdStart] = {}
    shares: dict[Key, TimeBreakdown] = {}
    by_case, _ = per_solver.make_per_solver(partial(_those, wanted), (experiment,), [key[1] for key in wanted])
    cold_budget, parts_budget = (FULL_BUDGET_A_CASE,) * 2 if full else (COLD_BUDGET, PARTS_BUDGET)

    def one_by_one(cold_alone: Calls, parts_alone: Calls) -> Iterator[None]:
        for who in by_case:
            colds.update(_measure(partial(_cold_starts, cold_alone), who, cold_budget))
            shares.update(_measure(partial(_parts, parts_alone), who, parts_budget))
            yield

    # Nothing may have been compiled in a process that is to begin cold: it splits off others, which make the calls.
    with calls.alone() as cold_alone, calls.alone() as parts_alone:
        steps = one_by_one(cold_alone, parts_alone)
        for _ in calls.progress(_BESIDE, len(by_case), steps):
            pass
    return ExtraTimings(colds, shares)


def _those(wanted: Collection[Key], experiment: Experiment) -> list[list[Contestant]]:
    """The contestants that are wanted, by case."""
    by_case = ([one for one in contestants(experiment, case) if one.key in wanted] for case in experiment.cases)
    return [who for who in by_case if who]


def _cold_starts(alone: Calls, who: Sequence[Contestant], share: float) -> list[CallResult]:
    return alone.all(_BESIDE, cold_start.first_calls, [(who, share)], limit=share + PATIENCE, keep=_KEEP)


def _parts(alone: Calls, who: Sequence[Contestant], share: float) -> list[CallResult]:
    return alone.all(_BESIDE, time_breakdown.parts_of_all, [(who, share)], limit=share + PATIENCE, keep=_KEEP)


def _measure(ask: Callable[..., list[CallResult]], who: Sequence[Contestant], budget: float) -> dict[Key, Any]:
    """What was measured of each contestant, within `budget` wall seconds for all processes that this takes."""
    found: dict[Key, Any] = {}
    for some in _by_version(who):
        (answer,) = ask(some, budget * len(some) / len(who))
        results = answer.value if answer.outcome == "done" else {}
        found |= {one.key: value for one in some if (value := results.get(one.key, _NONE)[0])}
    return found


def _repeat_disturbed(results: Mapping[Key, tuple[Any, str]]) -> bool:
    """Whether nothing else had a part in what was measured, which is then worth keeping."""
    return not any(getattr(value, "disturbed", False) for value, _ in results.values())


def _by_version(who: Sequence[Contestant]) -> list[list[Contestant]]:
    """Those that fit into one process: a solver that was asked for with a version has one of its own."""
    found: dict[str, list[Contestant]] = {}
    for one in who:
        found.setdefault(one.solver if split_version(one.solver)[1] else "", []).append(one)
    return list(found.values())


def _content(who: Sequence[Contestant], budget: float) -> tuple:
    """What decides a timing, whatever the order of the contestants: the cases, who runs which of them by which setting,
    and the time there was for it."""
    cases = sorted(dict.fromkeys(one.case for one in who), key=lambda case: case.label)
    return *cases, sorted((one.key for one in who), key=repr), budget


_KEEP = StorePolicy("timing", of=_content, worth=_repeat_disturbed)


def time_together(
    who: Sequence[Contestant], budget: float, share: float, alone: Calls, again: bool = True
) -> tuple[list[tuple[Contestant, Timing]], list[tuple[Contestant, str]]]:
    """The timings of contestants that take their turns in one process, kept or new, and the failures.

    They are kept if none is disturbed, under the `share` of the budget that was theirs. What ends the process by itself
    is found, and the others take their turns again; where nothing does, all do (`again`), and then each solver's by
    itself. Versions of an engine have processes of their own, one after the other.
    """
    if len(processes := _by_version(who)) > 1:
        portions = [(some, len(some) / len(who)) for some in processes]
        told = [time_together(some, budget * part, share * part, alone, again) for some, part in portions]
        return [pair for found, _ in told for pair in found], [pair for _, failed in told for pair in failed]
    keep = _KEEP._replace(of=lambda who, _: _content(who, share))
    (answer,) = alone.all("timings", clock.time_all, [(who, budget)], limit=budget + PATIENCE, keep=keep)
    if answer.outcome == "done":
        return _in_order([(who, answer)])
    culprits = _culprits(who, alone)
    left = [one for one in who if one not in culprits]
    if left and (culprits or again):
        found, more = time_together(left, budget, share, alone, again=bool(culprits))
        return found, [*culprits.items(), *more]
    apart = _by_solver(left)
    calls = [(group, budget / len(apart)) for group in apart]
    answers = alone.all("timings", clock.time_all, calls, limit=budget + PATIENCE)
    found, more = _in_order(list(zip(apart, answers, strict=True)))
    return found, [*culprits.items(), *more]


def _in_order(
    answered: Sequence[tuple[Sequence[Contestant], CallResult]],
) -> tuple[list[tuple[Contestant, Timing]], list[tuple[Contestant, str]]]:
    """What has a timing, and what has none and why."""
    found: list[tuple[Contestant, Timing]] = []
    failed: list[tuple[Contestant, str]] = []
    for who, answer in answered:
        for one in who:
            timing, why = answer.value.get(one.key, _NONE) if answer.outcome == "done" else (None, answer.failure[1])
            found += [(one, timing)] if timing else []
            failed += [(one, why)] if why else []
    return found, failed


def _by_solver(who: Sequence[Contestant]) -> list[list[Contestant]]:
    return [[one for one in who if one.solver == name] for name in dict.fromkeys(one.solver for one in who)]


def _culprits(who: Sequence[Contestant], alone: Calls) -> dict[Contestant, str]:
    """Those that end their process when they are timed alone, and why: asked of each solver's, then one by one."""
    suspects = [
        one for group, answer in _time_in_turns(_by_solver(who), alone) if answer.outcome != "done" for one in group
    ]
    answered = _time_in_turns([[one] for one in suspects], alone)
    return {one: answer.failure[1] for (one,), answer in answered if answer.outcome != "done"}


def _time_in_turns(groups: list[list[Contestant]], alone: Calls) -> list[tuple[list[Contestant], CallResult]]:
    def enough(call: tuple, slow: Sequence[tuple]) -> CallResult | None:
        late = sum(other[0][0].solver == call[0][0].solver for other in slow)
        return CallResult("timed_out", reason="not tried: others of its solver ran out of time") if late > 1 else None

    calls = [(group, _TRIAL_SECONDS) for group in groups]
    answers = alone.all("timings", clock.time_all, calls, limit=PATIENCE, skip=enough)
    return list(zip(groups, answers, strict=True))
