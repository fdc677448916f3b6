"""The table `levels`: from which setting on a route stays within a level, and what leaves it open."""

from __future__ import annotations

from math import isnan, nan

import pytest

from adapters import Setting
from reports.analysis import levels
from reports.judging.friction_factor import Losses
from reports.judging.grades import LEVELS
from reports.judging.score import Scale, Score
from reports.running.records import Experiment, Run, Truth

SCALE = Scale(1.0, 1.0, 0.5, 2.0, (), (), (), 1.0, Losses(1.0, 1.0), "no friction", 1.0, 0.01)
DEFAULTS = Setting.of(rung="defaults")


def run(place: int, off: float | None, doubt: float = 0.0, setting: Setting | None = None) -> Run:
    score = None if off is None else Score(off, doubt, off, 0.0, 0.0, nan, 0.0, 1e-3, False)
    outcome = "crashed" if off is None else "answered"
    return Run("a", "engine", "native", setting or Setting.of(n=place), place, outcome, score=score)


def table(*runs: Run, truth: Truth | None = None) -> dict[float, dict]:
    experiment = Experiment((), {"a": truth or Truth(scales={"": SCALE})}, runs)
    return {row["level"]: row for row in levels.rows(experiment)}


def test_levels_are_limits_of_grades():
    assert LEVELS == (0.1, 0.01, 1e-3, 1e-4)
    assert list(table(run(1, 0.5))) == list(LEVELS)


def test_a_ladder_reaches_a_level_where_off_and_doubt_stay_within_it():
    rows = table(run(1, 0.2), run(2, 0.05), run(3, 0.008, 0.001), run(4, 0.002), run(5, 0.0008))
    found = [(row["reached"], row["setting"], row["settings_within"], row["settings"]) for row in rows.values()]
    assert found == [
        ("reached", "n=2", 4, 5), ("reached", "n=3", 3, 5), ("one setting", "n=5", 1, 5), ("not reached", "", 0, 5)
    ]  # fmt: skip


def test_a_setting_that_a_finer_one_contradicts_reaches_nothing():
    # The second one is within 0.1 % by luck.
    rows = table(run(1, 0.3), run(2, 0.0005), run(3, 0.02), run(4, 0.015))
    assert rows[1e-3]["reached"] == "not reached" and rows[0.1]["setting"] == "n=2"


def test_a_setting_without_a_motion_contradicts_nothing():
    rows = table(run(1, 0.05), run(2, None), run(3, 0.02))
    assert (rows[0.1]["reached"], rows[0.1]["settings_within"], rows[0.1]["settings"]) == ("reached", 2, 2)


def test_default_settings_are_not_part_of_the_ladder():
    rows = table(run(1, 1e-5, setting=DEFAULTS), run(2, 0.05))
    assert rows[0.1]["reached"] == "one setting" and rows[1e-3]["reached"] == "not reached"
    assert {row["settings"] for row in table(run(1, 1e-5, setting=DEFAULTS)).values()} == {0}


def test_a_level_within_the_doubt_or_the_truths_error_bar_is_not_known():
    assert table(run(1, 0.008, 0.005))[0.01]["reached"] == "not known"
    # 0.5 s in another mode are an off of 1; an error bar of 0.4 s is 0.8 of it.
    vague = Truth(scales={"": SCALE}, error_bars=(0.4,))
    assert {row["reached"] for row in table(run(1, 1e-5), truth=vague).values()} == {"not known"}


@pytest.mark.parametrize(
    "offs, expected", [((0.5, 0.05, 0.02), (0.1, 2)), ((0.5, 1e-5), (1e-4, 1)), ((0.5,), (nan, 0))]
)
def test_the_headline_has_the_smallest_level(offs, expected):
    runs = tuple(run(place, off) for place, off in enumerate(offs))
    found = levels.finest_level(levels.level_results(Experiment((), {"a": Truth(scales={"": SCALE})}, runs)))
    assert found == expected or (isnan(found[0]) and isnan(expected[0]) and found[1] == 0)
