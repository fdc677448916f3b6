"""The verdict: how far each route is from the truth, in one table; only what an engine does by itself is ranked.

All routes are compared over the same cases: those that depend on friction's law. The reference is not among them, since
it defines the truth.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from math import hypot, inf, isfinite, log, nan
from statistics import median
from textwrap import wrap
from typing import Any

from ..judging.friction_sensitivity import LEAST, LEAST_SHARE, not_ranked
from ..judging.grades import LIMITS, Grade, grade, percent
from ..judging.ranking import TIE, Standing, ranking
from ..judging.score import Score
from ..running import external_motions, submissions
from ..running.names import REFERENCE
from ..running.records import Experiment, Run, defaults, routes
from .levels import ONE_SETTING, level_results
from .number_format import seconds
from .time_to_accuracy import WITH_TIMES, cost

HOLDS = (
    "How far each route is from the truth, over the cases that depend on friction's law (1: as bad as ignoring it); "
    "engines by themselves first"
)
COLUMNS = (
    "digits_rank", "solver", "route", "our_part", "friction_cases", "answered", "unsupported", "crashed", "timed_out",
    "default_off", "default_off_best", "default_off_worst", "finest_off", "finest_off_worst", "median_grade",
    "good_cases", "good_one_setting", "excellent_cases", "excellent_one_setting", "worst_friction_factor", "digits",
    "digits_doubt", "cost_case", "good_first_s", "good_thousand_s",
)  # fmt: skip
_WITHOUT_MOTION = ("unsupported", "crashed", "timed_out")
# Levels whose cases are counted, and what their columns are called.
_COUNT_LEVELS = {"good": LIMITS[Grade.GOOD], "excellent": LIMITS[Grade.EXCELLENT]}


def exclusions(experiment: Experiment) -> dict[str, str]:
    """The cases that do not rank engines, with the reason."""
    reasons = {label: not_ranked(t.friction_sensitivity, t.scale) for label, t in experiment.truths.items()}
    return {label: reason for label, reason in reasons.items() if reason}


def friction_cases(experiment: Experiment) -> list[str]:
    """The cases that rank engines: those that depend on friction's law, by more than an engine's step."""
    others = exclusions(experiment)
    return [label for label in experiment.truths if label not in others]


def rows(experiment: Experiment, times: Sequence[Mapping[str, Any]] = ()) -> list[dict[str, Any]]:
    """One row per route with the columns `COLUMNS`: engines by themselves, the best first, then routes that are partly
    this project's, without a rank. `times`: rows of `time_to_accuracy`."""
    cases = friction_cases(experiment)
    counts = _level_counts(experiment, cases)
    costs = _costs(times, cases)
    groups: dict[tuple[str, str], dict[str, list[Run]]] = {}
    for (case, solver, route), group in routes(experiment.runs).items():
        if solver != REFERENCE:
            groups.setdefault((solver, route), {})[case] = group
    own = [key for key in groups if key[1] and key not in experiment.our_parts]
    standings = _standings(groups, own, cases)
    others = [key for key in groups if key not in own]
    without_rank = {key: standing for one in others for key, standing in _standings(groups, [one], cases).items()}
    without_rank = {key: standing._replace(rank=0) for key, standing in without_rank.items()}
    rest = sorted(without_rank, key=lambda key: (key not in experiment.our_parts, -without_rank[key].digits))
    order = [*standings, *rest]
    every = standings | without_rank
    return [
        _row(key, groups[key], every[key], experiment.our_parts.get(key, ""), cases) | counts[key] | costs(key)
        for key in order
    ]


def _level_counts(experiment: Experiment, cases: Sequence[str]) -> dict[tuple[str, str], Counter]:
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


def _costs(times: Sequence[Mapping[str, Any]], cases: Sequence[str]) -> Callable[[tuple[str, str]], dict[str, Any]]:
    """The cost of staying within 1 % in the first timed case, by solver and route: whole calls, s."""
    case = next((row["case"] for row in times if row["case"] in cases), "")
    good = {
        (row["solver"], row["route"]): row
        for row in times
        if row["case"] == case and row["level"] == _COUNT_LEVELS["good"] and row["reached"] in WITH_TIMES
    }

    def columns(key: tuple[str, str]) -> dict[str, Any]:
        row = good.get(key)
        counts = (("first", 1), ("thousand", 1000))
        return {"cost_case": case} | {f"good_{name}_s": cost(row, runs) if row else nan for name, runs in counts}

    return columns


def _standings(
    groups: Mapping[tuple[str, str], Mapping[str, list[Run]]], keys: Sequence[tuple[str, str]], cases: Sequence[str]
) -> dict[tuple[str, str], Standing]:
    """The routes ranked by the finest setting run in each case, best first; none without a case to rank them by."""
    names = {" ".join(key): key for key in keys}
    scores = {name: _scores(groups[key]) for name, key in names.items()}
    results = ranking(scores, cases) or [Standing(name, nan, nan, 0, 0) for name in names]
    return {names[standing.route]: standing for standing in results}


def _scores(group: Mapping[str, list[Run]]) -> dict[str, Score]:
    return {case: run.score for case, runs in group.items() if (run := _finest(runs)) is not None and run.score}


def _finest(group: Sequence[Run]) -> Run | None:
    """The finest setting run that gave a motion, or None."""
    return next((run for run in reversed(group) if run.score is not None), None)


def _row(
    key: tuple[str, str], group: Mapping[str, list[Run]], standing: Standing, our_part: str, cases: Sequence[str]
) -> dict[str, Any]:
    mine = [group[case] for case in cases if case in group]
    last = [run for runs in mine if (run := _finest(runs)) is not None]
    grids = [grid for runs in mine if (grid := defaults(runs))]
    missing = Counter(runs[-1].outcome for runs in mine if _finest(runs) is None)
    finest, of_defaults = _offs(last), [_offs(grid) for grid in grids]
    middle = median(finest) if finest else nan
    return {
        "digits_rank": standing.rank or nan,
        "solver": key[0],
        "route": key[1],
        "our_part": our_part,
        "friction_cases": len(cases),
        "answered": len(last),
        **{outcome: missing[outcome] for outcome in _WITHOUT_MOTION},
        "default_off": median(map(median, of_defaults)) if of_defaults else nan,
        "default_off_best": min(map(min, of_defaults), default=nan),
        "default_off_worst": max(map(max, of_defaults), default=nan),
        "finest_off": middle,
        "finest_off_worst": max(finest, default=nan),
        "median_grade": str(grade(middle)) if finest else "",
        "worst_friction_factor": _worst_friction([*chain(*grids), *last]),
        "digits": standing.digits,
        "digits_doubt": standing.doubt,
    }


def _offs(runs: Sequence[Run]) -> list[float]:
    return [run.score.off for run in runs if run.score is not None]


def _worst_friction(runs: Sequence[Run]) -> float:
    """The friction × that is farthest from 1, by its ratio; NaN where none is known."""
    factors = [run.friction_factor for run in runs if isfinite(run.friction_factor)]
    return max(factors, key=lambda factor: abs(log(factor)) if factor > 0.0 else inf, default=nan)


# --- in words ---------------------------------------------------------------------------------------------------------


def sentence(table: Sequence[Mapping[str, Any]]) -> str:
    """The most accurate engine by itself, and those tied with it; motions from files are not engines."""
    engine_rows = [row for row in table if is_engine(row)]
    if not engine_rows:
        return "No engine was ranked: none was run on a case that depends on friction's law."
    best = engine_rows[0]
    ties = [
        row
        for row in engine_rows
        if best["digits"] - row["digits"] <= max(TIE, hypot(best["digits_doubt"], row["digits_doubt"]))
    ]
    return f"{LEAD} {'; tied with it '.join(phrase(row) for row in ties)}."


def is_engine(row: Mapping[str, Any]) -> bool:
    """Whether a row is of an engine by itself, which a user can install and run, and not of motions from files."""
    return isfinite(row["digits_rank"]) and row["route"] not in (external_motions.ROUTE, submissions.ROUTE)


LEAD = "Most accurate of the engines shown (100 % off: as bad as ignoring friction's law):"


def phrase(row: Mapping[str, Any]) -> str:
    """What a route does, in one phrase that is true of it whatever others do."""
    if not row["answered"]:
        return f"{row['solver']} {row['route']}, which answers none of the {row['friction_cases']} cases"
    default_words = f", {percent(row['default_off'])} with default settings" if isfinite(row["default_off"]) else ""
    return (
        f"{row['solver']} {row['route']}, {percent(row['finest_off'])} off at the finest setting run{default_words} "
        f"(medians of the {row['answered']} of {row['friction_cases']} cases that it answers); within 1 % in "
        f"{row['good_cases']}"
    )


def cells(row: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """The row for readers, as in the terminal and on the page: main text and small text by heading."""
    lacking = [f"{row[outcome]} {outcome.replace('_', ' ')}" for outcome in _WITHOUT_MOTION if row[outcome]]
    count = f"{row['answered']} of {row['friction_cases']}"
    factor = row["worst_friction_factor"]
    digits = f"{row['digits']:.2f} ± {row['digits_doubt']:.2f}" if isfinite(row["digits"]) else "–"
    return {
        "answered": (count, ", ".join(lacking)),
        "default": (_percent(row["default_off"]), _range(row)),
        "finest": (_percent(row["finest_off"]), _worst(row["finest_off_worst"])),
        "grade": (row["median_grade"] or "–", ""),
        "≤ 1 %": (str(row["good_cases"]), f"≤ 0.01 %: {row['excellent_cases']}"),
        "friction ×": (f"{float(f'{factor:.2g}'):g}" if isfinite(factor) else "–", ""),
        "digits": (digits, ""),
        **({"time to 1 %": _time(row)} if row["cost_case"] else {}),
    }


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
    "answered": "cases run",
    "default": "default",
    "finest": "finest",
    "≤ 1 %": "≤ 1 %",
    "friction ×": "friction ×",
}
_DETAILS = {"grade": "grade", "digits": "digits"}


def in_terminal(table: Sequence[Mapping[str, Any]]) -> str:
    """The table for the terminal, at most `WIDTH` wide: ranked engines, then routes that are partly this project's."""
    return _in_terminal(table, [{new: cells(row)[old][0] for old, new in _SHORT.items()} for row in table])


def details(table: Sequence[Mapping[str, Any]]) -> str:
    """Further columns for the terminal, at most `WIDTH` wide: grade, worst case, digits and times."""
    lines = []
    for row in table:
        texts = cells(row)
        line = {"worst": texts["finest"][1].removeprefix("worst "), "≤ 0.01 %": str(row["excellent_cases"])}
        line |= {new: texts[old][0] for old, new in _DETAILS.items()}
        if "time to 1 %" in texts:
            first, thousand = texts["time to 1 %"]
            line |= {"first run": first, "1,000 runs": thousand.removeprefix("1,000 runs: ")}
        lines.append(line)
    return _in_terminal(table, lines)


def _in_terminal(table: Sequence[Mapping[str, Any]], lines: Sequence[Mapping[str, str]]) -> str:
    from tabulate import tabulate

    names = [f"{row['solver']} {row['route']}" for row in table]
    ranks = [f"{row['digits_rank']:.0f}. " if isfinite(row["digits_rank"]) else "" for row in table]

    def text(names: Sequence[str], is_dense: bool) -> str:
        labels = [{"engine": rank + name} for rank, name in zip(ranks, names, strict=True)]
        pairs = [label | dict(line) for label, line in zip(labels, lines, strict=True)]
        options: dict[str, Any] = dict(tablefmt="plain", disable_numparse=True, stralign="right")
        if is_dense:  # tabulate pads columns with a heading by two more spaces
            return tabulate([list(pairs[0]), *(list(pair.values()) for pair in pairs)], **options)
        return tabulate(pairs, headers="keys", **options)

    def excess(text: str) -> int:
        return max(map(len, text.splitlines()), default=0) - WIDTH

    if excess(text(names, False)) <= 0:
        return text(names, False)
    # The engines' names are the only cells without a bound.
    longest = max(len(rank + name) for rank, name in zip(ranks, names, strict=True))
    longest -= max(0, excess(text(names, True)))
    return text([_shorten(name, longest - len(rank)) for rank, name in zip(ranks, names, strict=True)], True)


def _shorten(name: str, longest: int) -> str:
    return name if len(name) <= longest else f"{name[: longest - 1]}…"


def legend(table: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the columns of `in_terminal` mean, in lines of at most `WIDTH` characters."""
    no_rank = [f"{row['solver']} {row['route']}" for row in table if row["our_part"]]
    return filled(
        "default, finest: error with default settings and at the finest setting run, 100 % = as bad as ignoring "
        "friction's law (medians of the cases run).",
        "≤ 1 %: number of cases that stay within 1 %. friction ×: friction compared with the law's, in the worst case.",
        *([f"Without a rank, because this project computes the contact: {', '.join(no_rank)}."] if no_rank else []),
    )


def notes(table: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the columns of `details` mean, and what the routes without a rank are, in lines of at most `WIDTH`."""
    parts = {f"{row['solver']} {row['route']}": row["our_part"] for row in table if row["our_part"]}
    return filled(
        "worst, grade: the largest error and the grade of the median error, at the finest setting run.",
        f"Cases: those where 1 % of friction changes the error by {LEAST:g} or more, and ignoring friction changes the "
        f"path by {100 * LEAST_SHARE:g} % or more. ≤ 1 %, ≤ 0.01 %: number of cases "
        "in which the error and its doubt stay within that from a setting on.",
        "digits: mean of -log10(error) over all cases, between -1 and 4, and its doubt; 0 if not answered.",
        *(f"Not ranked: {name} ({words})." for name, words in parts.items()),
    )


def filled(*texts: str) -> list[str]:
    """The texts in lines of at most `WIDTH`; a number and its percent sign stay together."""
    joined = [text.replace(" %", "\N{NO-BREAK SPACE}%") for text in texts]
    return [
        line.replace("\N{NO-BREAK SPACE}", " ") for text in joined for line in wrap(text, WIDTH, break_on_hyphens=False)
    ]
