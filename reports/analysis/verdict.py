"""The verdict: how far each route is from the truth, and how many cases it answers: two facts, and no rank of both.

Errors are compared over the same cases only: those that depend on friction's law and that all engines by themselves
answer, and in pairs over those that both answer. The reference is not among them, since it defines the truth.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import chain, combinations
from math import inf, isfinite, log, nan
from statistics import median
from textwrap import wrap
from typing import Any, NamedTuple

from ..judging.friction_sensitivity import CHANGE, LEAST, LEAST_SHARE, not_ranked
from ..judging.grades import LIMITS, Grade, grade, percent
from ..judging.score import Score
from ..running import external_motions, submissions
from ..running.names import REFERENCE
from ..running.records import Experiment, Run, default, defaults, routes
from .levels import ONE_SETTING, level_results
from .number_format import seconds
from .time_to_accuracy import WITH_TIMES, cost

HOLDS = (
    "How far each route is from the truth, and how many cases it answers, over the cases that depend on friction's law "
    "(1: as bad as ignoring it); engines by themselves first"
)
PAIRS_HOLD = "Two engines by themselves compared over the cases that both answer"
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
_WITHOUT_MOTION = ("unsupported", "crashed", "timed_out")
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
    cases, result = friction_cases(experiment), dict[Key, dict[str, SceneOffs]]()
    for (case, solver, route), group in routes(experiment.runs).items():
        if solver != REFERENCE:
            own = result.setdefault((solver, route), {})
            last, usual = _finest(group), default(group)
            if case in cases and last is not None and last.score:
                own[case] = SceneOffs(usual.score.off if usual and usual.score else nan, last.score)
    return result


def rows(experiment: Experiment, times: Sequence[Mapping[str, Any]] = ()) -> list[dict[str, Any]]:
    """One row per route with the columns `COLUMNS`: engines by themselves, the nearest on common cases first, then
    routes that are partly this project's. `times`: rows of `time_to_accuracy`."""
    cases = friction_cases(experiment)
    counts = _level_counts(experiment, cases)
    costs = _costs(times, cases)
    groups: dict[Key, dict[str, list[Run]]] = {}
    for (case, solver, route), group in routes(experiment.runs).items():
        if solver != REFERENCE:
            groups.setdefault((solver, route), {})[case] = group
    offs = scenes(experiment)
    common = _common([offs[key] for key in groups if _is_own(experiment, key)])
    table = [
        _row(groups[key], experiment.our_parts.get(key, ""), cases)
        | {"solver": key[0], "route": key[1]}
        | _common_offs(offs[key], common)
        | counts[key]
        | costs(key)
        for key in groups
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
    return off if isfinite(off) else inf, f"{row['solver']} {row['route']}"


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


def _finest(group: Sequence[Run]) -> Run | None:
    """The finest setting run that gave a motion, or None."""
    return next((run for run in reversed(group) if run.score is not None), None)


def _row(group: Mapping[str, list[Run]], our_part: str, cases: Sequence[str]) -> dict[str, Any]:
    mine = [group[case] for case in cases if case in group]
    last = [run for runs in mine if (run := _finest(runs)) is not None]
    grids = [grid for runs in mine if (grid := defaults(runs))]
    missing = Counter(runs[-1].outcome for runs in mine if _finest(runs) is None)
    finest, of_defaults = _offs(last), [_offs(grid) for grid in grids]
    usual = _offs([run for runs in mine if (run := default(runs)) is not None])
    middle = median(finest) if finest else nan
    return {
        "our_part": our_part,
        "friction_cases": len(cases),
        "answered": len(last),
        **{outcome: missing[outcome] for outcome in _WITHOUT_MOTION},
        "default_off": median(usual) if usual else nan,
        "default_off_best": min(map(min, of_defaults), default=nan),
        "default_off_worst": max(map(max, of_defaults), default=nan),
        "finest_off": middle,
        "finest_off_worst": max(finest, default=nan),
        "median_grade": str(grade(middle)) if finest else "",
        "worst_friction_factor": _worst_friction([*chain(*grids), *last]),
    }


def _offs(runs: Sequence[Run]) -> list[float]:
    return [run.score.off for run in runs if run.score is not None]


def _worst_friction(runs: Sequence[Run]) -> float:
    """The friction × that is farthest from 1, by its ratio; NaN where none is known."""
    factors = [run.friction_factor for run in runs if isfinite(run.friction_factor)]
    return max(factors, key=lambda factor: abs(log(factor)) if factor > 0.0 else inf, default=nan)


# --- in words ---------------------------------------------------------------------------------------------------------


def sentence(table: Sequence[Mapping[str, Any]], pair_rows: Sequence[Mapping[str, Any]] = ()) -> str:
    """The errors of the engines by themselves on their common cases, and how many each answers."""
    own = [row for row in table if is_engine(row)]
    if not any(row["answered"] for row in own):
        return "No engine is compared: none answers a case that depends on friction's law."
    errors = [row for row in own if row["answered"]]
    many = errors[0]["common_cases"]
    if many:
        texts = "; ".join(
            f"{name(row)} {_percent(row['common_default_off'])} by default, {_percent(row['common_finest_off'])} "
            "at the finest setting run"
            for row in errors
        )
        which = f"{len(errors)} engines" if len(errors) > 1 else "engine"
        start = (
            f"{LEAD} {many} case{'s' * (many != 1)} that the {which} shown answer{'s' * (len(errors) == 1)}: {texts}."
        )
    else:
        start = "No case is answered by all engines shown."
    answers = ", ".join(f"{name(row)} answers {row['answered']}" for row in own)
    nearer = [
        f" Of two, {row['solver']} is nearer in {row['nearer']}, {row['other_solver']} in {row['other_nearer']}, and "
        f"{row['undecided']} are not decided."
        for row in pair_rows
        if len(own) == 2 and row["common_cases"]
    ]
    return f"{start}{''.join(nearer)} Of all {own[0]['friction_cases']}, {answers}."


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


LEAD = "Off (100 %: as bad as ignoring friction's law), medians over the"


def cells(row: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """The row for readers, as in the terminal and on the page: main text and small text by heading."""
    lacking = [f"{row[outcome]} {outcome.replace('_', ' ')}" for outcome in _WITHOUT_MOTION if row[outcome]]
    count = f"{row['answered']} of {row['friction_cases']}"
    factor = row["worst_friction_factor"]
    return {
        "answered": (count, ", ".join(lacking)),
        "common, default": (_percent(row["common_default_off"]), ""),
        "common, finest": (_percent(row["common_finest_off"]), ""),
        "default": (_percent(row["default_off"]), _range(row)),
        "finest": (_percent(row["finest_off"]), _worst(row["finest_off_worst"])),
        "grade": (row["median_grade"] or "–", ""),
        "≤ 1 %": (_confirmed(row, "good"), f"≤ 0.01 %: {_confirmed(row, 'excellent')}"),
        "friction ×": (f"{float(f'{factor:.2g}'):g}" if isfinite(factor) else "–", ""),
        **({"time to 1 %": _time(row)} if row["cost_case"] else {}),
    }


def _confirmed(row: Mapping[str, Any], level: str) -> str:
    """The cases within a level that finer settings confirm, and those that only the finest setting reaches."""
    lucky = row[f"{level}_one_setting"]
    return f"{row[f'{level}_cases'] - lucky} + {lucky}"


def _time(row: Mapping[str, Any]) -> tuple[str, str]:
    """CPU time of the first run within 1 % in the cost case, and of 1,000 runs."""
    first, thousand = row["good_first_s"], row["good_thousand_s"]
    return (seconds(first), f"1,000 runs: {seconds(thousand)}") if isfinite(first) else ("–", "")


def _percent(off: float) -> str:
    return percent(off).replace("less than ", "< ") if isfinite(off) else "–"


def _range(row: Mapping[str, Any]) -> str:
    """The range of off over all cases and default settings."""
    low, high = row["default_off_best"], row["default_off_worst"]
    return f"{_percent(low).removesuffix(' %')} to {_percent(high)}" if isfinite(high) else ""


def _worst(off: float) -> str:
    return f"worst {_percent(off)}" if isfinite(off) else ""


# Widest table of the terminal, in characters: that of a terminal that was not resized.
WIDTH = 80
# Headings of the two tables of the terminal, by the headings of `cells`.
_SHORT = {
    "answered": "answers",
    "common, default": "default",
    "common, finest": "finest",
    "≤ 1 %": "≤ 1 %",
    "friction ×": "friction ×",
}
_DETAILS = {"default": "default", "finest": "finest", "grade": "grade"}


def in_terminal(table: Sequence[Mapping[str, Any]]) -> str:
    """The table for the terminal, at most `WIDTH` wide: engines, then routes that are partly this project's."""
    return _in_terminal(table, [{new: cells(row)[old][0] for old, new in _SHORT.items()} for row in table])


def details(table: Sequence[Mapping[str, Any]]) -> str:
    """Further columns for the terminal, at most `WIDTH` wide: errors over all cases that each answers, and times."""
    lines = []
    for row in table:
        texts = cells(row)
        line = {new: texts[old][0] for old, new in _DETAILS.items()}
        line |= {"worst": texts["finest"][1].removeprefix("worst "), "≤ 0.01 %": _confirmed(row, "excellent")}
        if "time to 1 %" in texts:
            first, thousand = texts["time to 1 %"]
            line |= {"first run": first, "1,000 runs": thousand.removeprefix("1,000 runs: ")}
        lines.append(line)
    return _in_terminal(table, lines)


def _in_terminal(table: Sequence[Mapping[str, Any]], lines: Sequence[Mapping[str, str]]) -> str:
    from tabulate import tabulate

    def text(names: Sequence[str], is_dense: bool) -> str:
        pairs = [{"engine": one} | dict(line) for one, line in zip(names, lines, strict=True)]
        options: dict[str, Any] = dict(tablefmt="plain", disable_numparse=True, stralign="right")
        if is_dense:  # tabulate pads columns with a heading by two more spaces
            return tabulate([list(pairs[0]), *(list(pair.values()) for pair in pairs)], **options)
        return tabulate(pairs, headers="keys", **options)

    def excess(text: str) -> int:
        return max(map(len, text.splitlines()), default=0) - WIDTH

    names = [name(row) for row in table]
    if excess(text(names, False)) <= 0:
        return text(names, False)
    # The engines' names are the only cells without a bound.
    longest = max(map(len, names)) - max(0, excess(text(names, True)))
    return text([_shorten(one, longest) for one in names], True)


def _shorten(words: str, longest: int) -> str:
    return words if len(words) <= longest else f"{words[: longest - 1]}…"


def legend(table: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the columns of `in_terminal` mean, in lines of at most `WIDTH` characters."""
    ours = [name(row) for row in table if row["our_part"]]
    return filled(
        "default, finest: error with default settings (the median one of usual values) and at the finest setting run, "
        "100 % = as bad as ignoring friction's law; medians over the cases that all engines answer.",
        "≤ 1 %: cases that stay within 1 %, confirmed by two settings + by the finest setting only, perhaps by luck. "
        "friction ×: friction compared with the law's, in the worst case.",
        *([f"Not compared, because this project computes the contact: {', '.join(ours)}."] if ours else []),
    )


def notes(table: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the columns of `details` mean, and what the routes are that are partly this project's, in lines of at most
    `WIDTH`."""
    parts = {name(row): row["our_part"] for row in table if row["our_part"]}
    return filled(
        "Here default and finest are medians over the cases that each answers, so not of the same cases. worst, grade: "
        "the largest error and the grade of the median error, at the finest setting run.",
        f"Cases: those where 1 % of friction changes the error by {LEAST:g} or more, and ignoring friction changes the "
        f"path by {100 * LEAST_SHARE:g} % or more. ≤ 1 %, ≤ 0.01 %: number of cases "
        "in which the error and its doubt stay within that from a setting on.",
        *(f"Not compared: {route} ({words})." for route, words in parts.items()),
    )


def filled(*texts: str) -> list[str]:
    """The texts in lines of at most `WIDTH`; a number and its percent sign stay together."""
    joined = [text.replace(" %", "\N{NO-BREAK SPACE}%") for text in texts]
    return [
        line.replace("\N{NO-BREAK SPACE}", " ") for text in joined for line in wrap(text, WIDTH, break_on_hyphens=False)
    ]
