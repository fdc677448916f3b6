"""The levels of accuracy that each route reaches in each case, and from which setting on.

A level is a limit of a grade (`grades.LEVELS`), so it means the same in every case. A route reaches it at a setting if
off and its doubt together stay within the level there and at all finer settings of the ladder. A single setting, the
finest one run, may be accurate by luck, so it is marked. Default settings are not part of a ladder.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Any, NamedTuple

from adapters import Setting

from ..judging.grades import LEVELS
from ..running.records import Experiment, Run, Truth, is_default, routes
from . import quantities

# Values of the column `reached`. "Not known": the doubt of the samples or the truth's error bar exceeds the level.
WITHIN, ONE_SETTING, BEYOND, OPEN = "reached", "one setting", "not reached", "not known"


class FirstWithin(NamedTuple):
    """The setting from which on a route stays within a level. `first`: its number in the ladder, None if there is none;
    `settings`: number of settings from it to the finest; a single one is not confirmed by a finer one. `is_known`:
    False if the doubt leaves open whether the level is reached."""

    first: int | None
    settings: int
    is_known: bool


def first_within(ladder: Sequence[tuple[float, float]], level: float) -> FirstWithin:
    """The first setting of a ladder, coarse to fine, at which off and doubt together stay within the level, as they do
    at all finer ones. `ladder`: off and doubt of each setting with a motion."""
    first, settings, possible = None, 0, False
    highest, lowest = 0.0, 0.0
    for number, (off, doubt) in reversed(list(enumerate(ladder))):
        highest = max(highest, off + doubt)
        lowest = max(lowest, off - doubt)
        if highest <= level:
            first, settings = number, settings + 1
        possible = possible or lowest <= level
    return FirstWithin(first, settings, first is not None or not possible)


class LevelResult(NamedTuple):
    """Whether a route reaches a level in a case (`word`), and the settings that do, the coarsest first; `settings_run`:
    the number of settings of the ladder that gave a motion."""

    case: str
    solver: str
    route: str
    level: float
    word: str
    settings: tuple[Setting, ...]
    settings_run: int


def level_results(experiment: Experiment) -> list[LevelResult]:
    """One for each case, route and level, in the order of the runs."""
    results = []
    for key, group in routes(experiment.runs).items():
        ladder = [run for run in group if run.score is not None and not is_default(run)]
        results += [_level(key, ladder, experiment.truths[key[0]], level) for level in LEVELS if key[2]]
    return results


def _level(key: tuple[str, str, str], ladder: Sequence[Run], truth: Truth, level: float) -> LevelResult:
    bar = quantities.bar(truth, "off", {})
    errors = [(run.score.off, run.score.doubt + bar) for run in ladder if run.score]
    first, settings, is_certain = first_within(errors, level)
    if first is None:
        return LevelResult(*key, level, BEYOND if is_certain else OPEN, (), len(ladder))
    word = WITHIN if settings > 1 else ONE_SETTING
    return LevelResult(*key, level, word, tuple(run.setting for run in ladder[first:]), len(ladder))


def rows(experiment: Experiment) -> list[dict[str, Any]]:
    """The rows of the table `levels`."""
    return [
        {
            "case": one.case,
            "solver": one.solver,
            "route": one.route,
            "level": one.level,
            "reached": one.word,
            "setting": str(one.settings[0]) if one.settings else "",
            "settings_within": len(one.settings),
            "settings": one.settings_run,
        }
        for one in level_results(experiment)
    ]


def finest_level(results: Sequence[LevelResult]) -> tuple[float, int]:
    """The smallest level that a route reaches in a case, and by how many settings; NaN and 0 if it reaches none."""
    best = min((one for one in results if one.settings), key=lambda one: one.level, default=None)
    return (best.level, len(best.settings)) if best else (nan, 0)
