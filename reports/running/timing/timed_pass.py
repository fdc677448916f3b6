"""The timed pass of an experiment: selects cases and settings, has them timed and collects the results.

How often a run is repeated, and when its time counts as disturbed, is in `clock`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple

from adapters.lookup import executables
from cases import Case

from ..calls import Calls, StorePolicy
from ..records import Experiment, one_default, routes, usable
from ..solvers import SEVERAL
from ..versions import split_version
from . import clock, cold_start, time_breakdown
from .clock import Contestant, Key, Timing
from .cold_start import ColdStart
from .time_breakdown import TimeBreakdown

# Fewest settings of a curve from which order and saturation can be estimated.
LEAST_SETTINGS = 6
# Wall seconds for all timings of a default report, and largest number of cases that share them. Expensive settings that
# do not fit are left out.
BUDGET, MOST_CASES = 10.0, 5
# Approximate wall seconds per case in a full report, which times every case.
FULL_BUDGET_A_CASE = 60.0
# Wall seconds for cold starts (in addition to calls made for imports) and for time breakdowns, of the one case of a
# default report that has them.
COLD_BUDGET, PARTS_BUDGET = 6.0, 6.0
# Additional wall seconds of a case beyond its budget, for one more run and its compilations.
PATIENCE = 60.0
# Name of the build step that measures cold starts and time breakdowns.
_EXTRA_STEP = "cold starts and parts"
# Result of a contestant that an answer does not contain.
_NONE = None, "it is missing from the clock's answer"
# After so many time-outs of settings that are timed separately no other of their solver is tried.
_MOST_LATE = 1


class Timings(NamedTuple):
    """The timed cases, the timings, and the reasons of failures."""

    cases: tuple[Case, ...] = ()
    timings: Mapping[Key, Timing] = {}
    failures: Mapping[str, str] = {}


class ExtraTimings(NamedTuple):
    """Further measurements of some settings: cold starts and time breakdowns."""

    cold: Mapping[Key, ColdStart] = {}
    parts: Mapping[Key, TimeBreakdown] = {}


def cases_to_time(experiment: Experiment, full: bool) -> list[Case]:
    """The cases to time: all, or per family the variant with most transitions, for the families in which most routes
    ran their whole ladders."""
    able = [case for case in experiment.cases if not experiment.truths[case.label].failure]
    if full:
        return able
    events = {case.label: len(experiment.truths[case.label].transitions) for case in able}
    families: dict[str, list[Case]] = {}
    for case in able:
        families.setdefault(case.name, []).append(case)
    one_each = [max(family, key=lambda case: events[case.label]) for family in families.values()]
    whole = {case.label: _whole_ladders(experiment, case.label) for case in one_each}
    ranking = sorted(one_each, key=lambda case: (-whole[case.label], -events[case.label]))
    return [case for case in ranking if whole[case.label]][:MOST_CASES]


def _whole_ladders(experiment: Experiment, label: str) -> int:
    """Number of routes that ran enough settings of the case for a curve."""
    groups = routes(run for run in experiment.runs if run.case == label and run.rung)
    return sum(len(one_default(run.setting for run in group)) >= LEAST_SETTINGS for group in groups.values())


def contestants(experiment: Experiment, case: Case) -> list[Contestant]:
    """Every setting with a usable motion of the case; of the default settings the first of their grid."""
    # An executable reports its own time; the clock cannot measure its process.
    external = executables()
    mine = [run for run in experiment.runs if run.case == case.label and run.solver not in external]
    defaults = {key: one_default(run.setting for run in group) for key, group in routes(mine).items()}
    runs = [run for run in mine if usable(run) and run.setting in defaults[run.case, run.solver, run.route]]
    return [Contestant(case, r.solver, r.route, r.setting, r.cost.wall_s + r.cost.setup_s) for r in runs]


def measure(experiment: Experiment, full: bool, calls: Calls) -> Timings:
    """Time the selected cases one after another, each in one process without other load; stored timings are reused."""
    cases, in_turn = _in_turn(full, experiment)
    timings: dict[Key, Timing] = {}
    failures: dict[Key, str] = {}
    deadline = time.perf_counter() + BUDGET
    share = FULL_BUDGET_A_CASE if full else BUDGET / max(len(cases), 1)
    with calls.alone() as alone:
        for place, entrants in calls.progress("timings", len(cases), enumerate(in_turn)):
            remaining = max(deadline - time.perf_counter(), 1.0) / (len(cases) - place)
            budget = FULL_BUDGET_A_CASE if full else remaining
            measurements, problems = together(clock.time_all, entrants, budget, share, alone, "timings")
            timings |= measurements
            failures |= problems
    return Timings(
        tuple(cases), timings, {f"{key[0]}, {' '.join(map(str, key[1:]))}": failures[key] for key in failures}
    )


def _in_turn(full: bool, experiment: Experiment) -> tuple[list[Case], list[list[Contestant]]]:
    """The cases to time, and the contestants of each, cheap cases first: expensive ones get the rest of the budget."""
    cases = cases_to_time(experiment, full)
    entrants = (contestants(experiment, case) for case in cases)
    return cases, sorted(entrants, key=lambda some: sum(one.expected_s for one in some))


def measure_extra(experiment: Experiment, selection: Collection[Key], full: bool, calls: Calls) -> ExtraTimings:
    """Measure cold starts and time breakdowns of the settings in `selection`."""
    colds: dict[Key, ColdStart] = {}
    shares: dict[Key, TimeBreakdown] = {}
    by_case = _entrants_by_case(selection, experiment)
    cold, parts = (FULL_BUDGET_A_CASE,) * 2 if full else (COLD_BUDGET, PARTS_BUDGET)
    # The process that forks the cold starts must not have compiled anything; hence separate processes.
    with calls.alone() as cold_alone, calls.alone() as parts_alone:
        for entrants in calls.progress(_EXTRA_STEP, len(by_case), iter(by_case)):
            colds |= together(cold_start.first_calls, entrants, cold, cold, cold_alone, _EXTRA_STEP)[0]
            shares |= together(time_breakdown.parts_of_all, entrants, parts, parts, parts_alone, _EXTRA_STEP)[0]
    return ExtraTimings(colds, shares)


def _entrants_by_case(selection: Collection[Key], experiment: Experiment) -> list[list[Contestant]]:
    """The contestants in the selection, by case."""
    by_case = ([one for one in contestants(experiment, case) if one.key in selection] for case in experiment.cases)
    return [entrants for entrants in by_case if entrants]


def _group(entrants: Sequence[Contestant]) -> str:
    """The worker of contestants of one process (`together`).

    All unversioned solvers share one, whichever of them a case has: another one would import the engines again, and a
    process in which other modules are imported is another process to be timed in."""
    name = entrants[0].solver
    return name if split_version(name)[1] else SEVERAL


def _is_quiet(results: Mapping[Key, tuple[Any, str]]) -> bool:
    """Whether no measurement was disturbed; only then the results are stored."""
    return not any(getattr(value, "disturbed", False) for value, _ in results.values())


def _by(entrants: Sequence[Contestant], key: Callable[[Contestant], str]) -> list[list[Contestant]]:
    groups: dict[str, list[Contestant]] = {}
    for one in entrants:
        groups.setdefault(key(one), []).append(one)
    return list(groups.values())


def _content(entrants: Sequence[Contestant], budget: float) -> tuple:
    """The part of the key that describes a timing, independent of order: cases, contestants and budget."""
    cases = sorted(dict.fromkeys(one.case for one in entrants), key=lambda case: case.label)
    return *cases, sorted((one.key for one in entrants), key=repr), budget


_KEEP = StorePolicy("timing", of=_content, worth=_is_quiet)


def together(
    function: Callable, entrants: Sequence[Contestant], budget: float, share: float, alone: Calls, step: str
) -> tuple[dict[Key, Any], dict[Key, str]]:
    """Measure contestants in one process by `function(entrants, budget)`; returns the measurements, stored or new, and
    the reasons of failures.

    Measurements are stored if none is disturbed, with `share`, their part of the budget, in the key. Versions of an
    engine have separate processes, one after another; if a process ends, each solver has one, and then each setting.
    """
    processes, late = _by(entrants, lambda one: one.solver if split_version(one.solver)[1] else ""), 0
    if len(processes) == 1:
        keep = _KEEP._replace(of=lambda entrants, _: _content(entrants, share))
        limit, group = budget + PATIENCE, _group(entrants)
        (answer,) = alone.all(step, function, [(entrants, budget)], limit=limit, keep=keep, group=group)
        if answer.outcome == "done" or len(entrants) == 1:
            lost = _NONE if answer.outcome == "done" else (None, answer.failure[1])
            results = {one.key: (answer.value or {}).get(one.key, lost) for one in entrants}
            return (
                {key: value for key, (value, _) in results.items() if value},
                {key: why for key, (_, why) in results.items() if why},
            )
        processes = _by(entrants, lambda one: one.solver)
        processes = processes if len(processes) > 1 else [[one] for one in entrants]
    measurements: dict[Key, Any] = {}
    failures: dict[Key, str] = {}
    for some in processes:
        if late > _MOST_LATE:
            failures |= {one.key: "not tried: others of its solver timed out" for one in some}
            continue
        part = len(some) / len(entrants)
        more, lost_ones = together(function, some, budget * part, share * part, alone, step)
        measurements |= more
        failures |= lost_ones
        late += len(some) == 1 and "still running" in lost_ones.get(some[0].key, "")
    return measurements, failures
