"""Grades and their reasons, and the levels that a ladder reaches."""

from __future__ import annotations

from math import inf, nan

import pytest

from reports.judging.friction_factor import Losses
from reports.judging.grades import LIMITS, Grade, duration, grade, percent, reason, sequence_note, summary
from reports.judging.score import Scale, Score

SCALE = Scale(1.0, 1.0, 0.5, 2.0, (), (), (), 1.0, Losses(1.0, 1.0), "no friction", 1.0, 0.01)


def score(off, doubt=0.0, sequence=0.0, missing=False, resolution=1e-3) -> Score:
    """A score whose error is one of pose."""
    return Score(off, doubt, off, 0.0, 0.0, nan, sequence, resolution, missing)


def test_limits_belong_to_the_better_grade():
    for name, limit in LIMITS.items():
        assert grade(limit) is name and grade(1.000001 * limit) is not name
    assert grade(0.0) is Grade.EXCELLENT and grade(0.6) is grade(nan) is grade(inf) is Grade.UNUSABLE
    assert [*LIMITS, Grade.UNUSABLE, Grade.UNDECIDED] == list(Grade)


@pytest.mark.parametrize(
    "sequence, missing, note",
    [
        (0.0, False, "same sequence"),
        (1e-3, True, "same sequence"),  # shorter than the samples resolve
        (6e-3, False, "same sequence down to 6 ms"),
        (2.807e-3, True, "misses phases of up to 2.8 ms"),
        (0.3, False, "another sequence of modes"),  # more than a tenth of the motion
        (inf, True, "another sequence of modes"),
    ],
)
def test_sequence_note(sequence, missing, note):
    assert sequence_note(score(0.1, sequence=sequence, missing=missing), SCALE) == note


def test_reason_names_the_largest_score_and_what_explains_it():
    plain = reason(score(0.005), SCALE, 1.0)
    assert plain == "pose: 0.5 % of the error of ignoring friction"
    assert "friction and other losses are 60 times" in reason(score(0.9), SCALE, 60.0)
    assert "friction" not in reason(score(0.9), SCALE, nan).removeprefix(plain[:5]).replace("ignoring friction", "")
    assert "its samples leave 2 % in doubt" in reason(score(0.005, doubt=0.02), SCALE, 1.0)
    modes = Score(0.02, 0.0, 0.01, 0.02, 0.0, nan, 0.0, 1e-3, False)
    assert reason(modes, SCALE, 1.0) == "modes: 10 ms in another mode than the truth"


def test_summary_is_one_line():
    assert summary(score(0.9, 0.01), 60.0, "why") == "off 90 % ± 1 %: unusable; friction × 60; why"
    assert summary(score(0.0), nan, "why").startswith("off less than 0.0001 % ± less than 0.0001 %: excellent; why")


def test_numbers_in_words():
    assert [duration(t) for t in (6.2e-6, 0.333, 2.0, 4e-9, 3e-16)] == [
        "6.2 µs", "330 ms", "2 s", "4 ns", "less than 1 ns"
    ]  # fmt: skip
    assert [percent(p) for p in (0.0123, 0.999, 2.78, 1e-9)] == ["1.2 %", "100 %", "280 %", "less than 0.0001 %"]
