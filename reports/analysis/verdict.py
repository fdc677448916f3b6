"""The verdict: how far each route is from the truth, and how many cases it answers: two facts, and no rank of both.

Errors are compared over the same cases only: those that depend on friction's law and that all engines by themselves
answer, and in pairs over those that both answer. The reference is not among them, since it defines the truth.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from math import inf, isfinite, isnan, log, nan
from statistics import median
from typing import Any, NamedTuple

from ..judging.friction_sensitivity import CHANGE, not_ranked
from ..judging.grades import LIMITS, Grade, grade, percent
from ..judging.score import Score
from ..running import external_motions, submissions
from ..running.names import REFERENCE
from ..running.records import Experiment, Run, default, defaults, routes
from .levels import ONE_SETTING, level_results
from .time_to_accuracy import WITH_TIMES, cost

COLUMNS = (
    "solver", "route", "our_part", "friction_cases", "answered", "unsupported", "crashed", "timed_out",
    "common_cases", "common_default_off", "common_finest_off", "default_off", "default_off_best", "default_off_worst",
    "finest_off", "finest_off_worst", "median_grade", "good_cases", "good_one_setting", "excellent_cases",
    "excellent_one_setting", "worst_friction_factor", "cost_case", "good_first_s", "good_thousand_s",
)  # fmt: skip
PAIR_COLUMNS = (
    "solver", "route", "other_solver", "other_route", "common_cases", "default_off", "other_default_off", "finest_off",
    "other_finest_off", "nearer", "other_nearer", "undecided",
)  # fmt: skip
WITHOUT_MOTION = ("unsupported", "crashed", "timed_out")
# Levels whose cases are counted, and what their columns are called.
_COUNT_LEVELS = {"good": LIMITS[Grade.GOOD], "excellent": LIMITS[Grade.EXCELLENT]}
# A route: solver and name.
Key = tuple[str, str]


class SceneOffs(NamedTuple):
    """The errors (off) of a route in a case that it answers: with default settings, the median one of its grid (NaN if
    it has none), and the score at the finest setting run."""

    default: float
    finest: Score


def exclusions(experiment: Experiment) -> dict[str, str]:
    """The cases that do not rank engines, with the reason."""
    reasons = {label: not_ranked(t.friction_sensitivity, t.scale) for label, t in experiment.truths.items()}
    return {label: reason for label, reason in reasons.items() if reason}


def friction_cases(experiment: Experiment) -> list[str]:
    """The cases that rank engines: those that depend on friction's law, by more than an engine's step."""
    others = exclusions(experiment)
    return [label for label in experiment.truths if label not in others]


def cost_of_friction(sensitivities: Sequence[float]) -> str:
    """What 1 % off means in friction, in a phrase. `sensitivities`: off of 1 % of friction in each case that ranks."""
    shares = sorted(CHANGE * LIMITS[Grade.GOOD] / value for value in sensitivities)
    if not shares:
        return ""
    low, middle, high = (percent(value) for value in (shares[0], median(shares), shares[-1]))
    many = f"{len(shares)} case{'s' * (len(shares) > 1)}"
    return f"1 % off is what μ wrong by {middle} makes (median of {many}; {low} to {high})"


def scenes(experiment: Experiment) -> dict[Key, dict[str, SceneOffs]]:
    """The errors of every route but the reference's in each case that depends on friction's law and that it answers."""
    cases = friction_cases(experiment)
    return {
        key: {case: offs for case, group in groups.items() if case in cases and (offs := _scene_offs(group))}
        for key, groups in _groups(experiment).items()
    }


def _groups(experiment: Experiment) -> dict[Key, dict[str, list[Run]]]:
    """The runs of every route but the reference's, by case."""
    result: dict[Key, dict[str, list[Run]]] = {}
    for (case, solver, route), group in routes(experiment.runs).items():
        if solver != REFERENCE:
            result.setdefault((solver, route), {})[case] = group
    return result


def _scene_offs(group: Sequence[Run]) -> SceneOffs | None:
    scores = [run.score for run in group if run.score is not None]
    usual = default(group)
    return SceneOffs(usual.score.off if usual and usual.score else nan, scores[-1]) if scores else None


def rows(experiment: Experiment, times: Sequence[Mapping[str, Any]] = ()) -> list[dict[str, Any]]:
    """One row per route with the columns `COLUMNS`: engines by themselves, the nearest on common cases first, then
    routes that are partly this project's. `times`: rows of `time_to_accuracy`."""
    cases = friction_cases(experiment)
    counts = _level_counts(experiment, cases)
    costs = _costs(times, cases)
    offs = scenes(experiment)
    common = _common([own for key, own in offs.items() if _is_own(experiment, key)])
    table = [
        {"solver": key[0], "route": key[1], "our_part": experiment.our_parts.get(key, ""), "friction_cases": len(cases)}
        | _row([groups[case] for case in cases if case in groups], list(offs[key].values()))
        | _common_offs(offs[key], common)
        | counts[key]
        | costs(key)
        for key, groups in _groups(experiment).items()
    ]
    # NaN is in no order.
    return sorted(table, key=lambda row: (bool(row["our_part"]), not row["answered"], *_order(row)))


def pairs(experiment: Experiment) -> list[dict[str, Any]]:
    """One row for two engines by themselves with the columns `PAIR_COLUMNS`; one is nearer in a case if the doubts of
    both finest motions do not leave it open."""
    offs = {key: own for key, own in scenes(experiment).items() if _is_own(experiment, key)}
    result = []
    for (one, own), (other, others) in combinations(offs.items(), 2):
        common = [case for case in own if case in others]
        signs = [_sign(own[case].finest, others[case].finest) for case in common]
        errors = (_common_offs(offs_of, common) for offs_of in (own, others))
        values = [(row["common_default_off"], row["common_finest_off"]) for row in errors]
        (first, last), (other_first, other_last) = values
        row = (*one, *other, len(common), first, other_first, last, other_last)
        result.append(dict(zip(PAIR_COLUMNS, (*row, signs.count(-1), signs.count(1), signs.count(0)), strict=True)))
    return result


def _is_own(experiment: Experiment, key: Key) -> bool:
    return _is_by_itself(key[1], experiment.our_parts.get(key, ""))


def _sign(one: Score, other: Score) -> int:
    """-1 if the one is nearer to the truth, 1 if the other is, 0 if their doubts leave it open."""
    open_ = abs(one.off - other.off) <= one.doubt + other.doubt
    return 0 if open_ else -1 if one.off < other.off else 1


def _common(offs: Sequence[Mapping[str, SceneOffs]]) -> list[str]:
    """The cases that all routes answer which answer any."""
    answers = [own for own in offs if own]
    return [case for case in (answers[0] if answers else ()) if all(case in own for own in answers)]


def _common_offs(own: Mapping[str, SceneOffs], common: Sequence[str]) -> dict[str, Any]:
    """The median errors over the common cases, NaN for a route that does not answer all of them."""
    is_whole = bool(common) and all(case in own for case in common)
    usual = [own[case].default for case in common] if is_whole else [nan]
    return {
        "common_cases": len(common),
        "common_default_off": median(usual) if all(map(isfinite, usual)) else nan,
        "common_finest_off": median(own[case].finest.off for case in common) if is_whole else nan,
    }


def _order(row: Mapping[str, Any]) -> tuple[float, str]:
    off = row["common_finest_off"]
    return off if isfinite(off) else inf, name(row)


def _level_counts(experiment: Experiment, cases: Sequence[str]) -> dict[Key, Counter]:
    """In how many cases each route reaches the counted levels, and in how many of them by one setting only."""
    # A solver that crashed before it named its routes reaches none.
    none = {f"{name}_{what}": 0 for name in _COUNT_LEVELS for what in ("cases", "one_setting")}
    counts = {(run.solver, run.route): Counter(none) for run in experiment.runs}
    for one in level_results(experiment):
        count = counts[one.solver, one.route]
        for name, level in _COUNT_LEVELS.items():
            is_counted = one.level == level and one.case in cases
            count[f"{name}_cases"] += is_counted and bool(one.settings)
            count[f"{name}_one_setting"] += is_counted and one.word == ONE_SETTING
    return counts


def _costs(times: Sequence[Mapping[str, Any]], cases: Sequence[str]) -> Callable[[Key], dict[str, Any]]:
    """The cost of staying within 1 % in the first timed case, by solver and route: whole calls, s."""
    case = next((row["case"] for row in times if row["case"] in cases), "")
    good = {
        (row["solver"], row["route"]): row
        for row in times
        if row["case"] == case and row["level"] == _COUNT_LEVELS["good"] and row["reached"] in WITH_TIMES
    }

    def columns(key: Key) -> dict[str, Any]:
        row = good.get(key)
        counts = (("first", 1), ("thousand", 1000))
        return {"cost_case": case} | {f"good_{name}_s": cost(row, runs) if row else nan for name, runs in counts}

    return columns


def _row(groups: Sequence[Sequence[Run]], offs: Sequence[SceneOffs]) -> dict[str, Any]:
    """The columns over all cases that a route answers. `groups`: its runs of each case."""
    answers = [[run for run in group if run.score is not None] for group in groups]
    missing = Counter(group[-1].outcome for group, motions in zip(groups, answers, strict=True) if not motions)
    usual = [run for motions in answers for run in defaults(motions)]
    defaults_off = [run.score.off for run in usual if run.score]
    middles = [scene.default for scene in offs if not isnan(scene.default)]
    finest = [scene.finest.off for scene in offs]
    return {
        "answered": len(offs),
        **{outcome: missing[outcome] for outcome in WITHOUT_MOTION},
        "default_off": median(middles) if middles else nan,
        "default_off_best": min(defaults_off, default=nan),
        "default_off_worst": max(defaults_off, default=nan),
        "finest_off": median(finest) if finest else nan,
        "finest_off_worst": max(finest, default=nan),
        "median_grade": str(grade(median(finest))) if finest else "",
        "worst_friction_factor": _worst_friction([*usual, *(motions[-1] for motions in answers if motions)]),
    }


def _worst_friction(runs: Sequence[Run]) -> float:
    """The friction × that is farthest from 1, by its ratio; NaN where none is known."""
    factors = [run.friction_factor for run in runs if isfinite(run.friction_factor)]
    return max(factors, key=lambda factor: abs(log(factor)) if factor > 0.0 else inf, default=nan)


_FROM_FILES = (external_motions.ROUTE, submissions.ROUTE)


def is_engine(row: Mapping[str, Any]) -> bool:
    """Whether a row is of an engine by itself."""
    return _is_by_itself(row["route"], row["our_part"])


def _is_by_itself(route: str, our_part: str) -> bool:
    """Whether a route is an engine by itself, which a user can install and run, and not motions from files."""
    return bool(route) and not our_part and route not in _FROM_FILES


def name(row: Mapping[str, Any]) -> str:
    """Solver and route."""
    return f"{row['solver']} {row['route']}"
