"""The table `verdict`: which cases and routes take part, how they are compared, and what is said of them."""

from __future__ import annotations

from dataclasses import replace
from math import nan

import pytest

from adapters import Setting
from reports.analysis import verdict, verdict_text
from reports.judging.friction_factor import Losses
from reports.judging.score import Scale, Score
from reports.running.records import Experiment, Run, Truth

DEFAULTS, FINE = Setting.of(rung="defaults"), Setting.of(h=1e-4)
SCALE = Scale(1.0, 1.0, 0.5, 2.0, (), (), (), 1.0, Losses(1.0, 1.0), "no friction", 1.0, 0.01)
TRUTHS = {
    "a": Truth(friction_sensitivity=0.01, scales={"": SCALE}),
    "b": Truth(friction_sensitivity=0.02, scales={"": SCALE}),
}
# At the edge of the limit, below it, and without a truth.
OTHERS = {
    "edge": Truth(friction_sensitivity=1e-5, scales={"": SCALE}),
    "free": Truth(friction_sensitivity=9e-6, scales={"": SCALE}),
    "none": Truth(failure="-"),
}


def run(case, solver, route, off, setting=FINE, friction=nan) -> Run:
    score = Score(off, 0.0, off, 0.0, 0.0, nan, 0.0, 1e-3, False)
    return Run(case, solver, route, setting, 1, "answered", score=score, friction_factor=friction)


def unanswered(case, solver, route, outcome="unsupported") -> Run:
    return Run(case, solver, route, Setting.of(), 0, outcome)


def experiment(*runs, truths=TRUTHS, **our_parts) -> Experiment:
    parts = {(solver, "assisted"): words for solver, words in our_parts.items()}
    return Experiment((), dict(truths), runs, our_parts=parts)


def table(*runs, **more):
    return verdict.rows(experiment(*runs, **more))


def test_only_cases_that_depend_on_frictions_law_take_part():
    assert verdict.friction_cases(experiment(truths=TRUTHS | OTHERS)) == ["a", "b", "edge"]
    (row,) = table(run("a", "one", "native", 0.1), run("free", "one", "native", 1e-9), truths=TRUTHS | OTHERS)
    assert (row["friction_cases"], row["answered"], row["finest_off"]) == (3, 1, 0.1)


def test_only_engines_by_themselves_are_compared_and_the_reference_is_not_there():
    rows = table(
        run("a", "reference", "taylor", 0.0),
        run("a", "one", "assisted", 1e-6),
        run("a", "one", "native", 0.1),
        run("a", "two", "native", 0.001),
        one="our contact geometry around one's step",
    )
    assert [(row["solver"], row["route"]) for row in rows] == [
        ("two", "native"), ("one", "native"), ("one", "assisted")
    ]  # fmt: skip
    # The route that is partly ours is the nearest, and is not in the sentence.
    assert rows[2]["common_finest_off"] < rows[0]["common_finest_off"] and rows[2]["our_part"]
    assert "assisted" not in verdict_text.sentence(rows)


def test_an_engine_that_crashed_before_it_named_its_routes_has_a_row():
    rows = table(run("a", "one", "native", 1e-4), unanswered("a", "broken", "", "crashed"))
    assert [(row["solver"], row["crashed"], row["good_cases"], row["excellent_one_setting"]) for row in rows] == [
        ("one", 0, 1, 1), ("broken", 1, 0, 0)
    ]  # fmt: skip
    assert "broken" in verdict_text.in_terminal(rows) and "broken" not in verdict_text.sentence(rows)


def test_errors_are_compared_over_the_same_cases_only():
    """A refusal is no error: over all cases that each answers, the engine that refuses the hard one looks better."""
    runs = (
        run("a", "easy", "native", 1e-3), unanswered("b", "easy", "native"),
        run("a", "all", "native", 1e-4), run("b", "all", "native", 1e-2),
    )  # fmt: skip
    rows = table(*runs)
    assert [(row["solver"], row["common_cases"], row["common_finest_off"]) for row in rows] == [
        ("all", 1, 1e-4), ("easy", 1, 1e-3)
    ]  # fmt: skip
    assert rows[0]["finest_off"] > rows[1]["finest_off"]
    assert (rows[1]["answered"], rows[1]["unsupported"]) == (1, 1)
    assert verdict_text.cells(rows[1])["answers"] == "1 of 2"
    text = verdict_text.sentence(rows)
    assert (
        "the 1 case that the 2 engines shown answer" in text and "all native answers 2, easy native answers 1" in text
    )


def test_an_engine_that_answers_nothing_is_not_named_for_its_errors():
    rows = table(unanswered("a", "none", "native"), unanswered("b", "none", "native"), run("a", "one", "native", 0.1))
    assert [row["solver"] for row in rows] == ["one", "none"]
    text = verdict_text.sentence(rows)
    assert "none native answers 0" in text and "none native –" not in text and "the 1 case that the engine" in text
    nobody = table(unanswered("a", "none", "native"))
    assert verdict_text.sentence(nobody).startswith("No engine is compared")


def test_two_engines_are_compared_over_the_cases_that_both_answer():
    runs = (
        run("a", "one", "native", 1e-3), run("b", "one", "native", 1e-3), run("edge", "one", "native", 0.1),
        run("a", "two", "native", 1e-2), run("b", "two", "native", 1e-4),
    )  # fmt: skip
    doubt = run("b", "two", "native", 1e-4)
    vague = replace(doubt, score=doubt.score._replace(doubt=1e-3))
    (pair,) = verdict.pairs(experiment(*runs, truths=TRUTHS | OTHERS))
    assert (pair["common_cases"], pair["nearer"], pair["other_nearer"], pair["undecided"]) == (2, 1, 1, 0)
    (pair,) = verdict.pairs(experiment(*runs[:-1], vague, truths=TRUTHS | OTHERS))
    assert (pair["nearer"], pair["other_nearer"], pair["undecided"]) == (1, 0, 1)
    (pair,) = verdict.pairs(experiment(run("a", "one", "native", 1e-3), unanswered("a", "none", "native")))
    assert (pair["common_cases"], pair["nearer"], pair["other_nearer"], pair["undecided"]) == (0, 0, 0, 0)


@pytest.mark.parametrize("outcome", ["unsupported", "crashed", "timed_out"])
def test_every_case_without_an_answer_is_counted_by_its_outcome(outcome):
    (row,) = table(unanswered("a", "one", "native", outcome), run("b", "one", "native", 0.1))
    assert {name: row[name] for name in ("unsupported", "crashed", "timed_out")} == {
        "unsupported": 0, "crashed": 0, "timed_out": 0
    } | {outcome: 1}  # fmt: skip


def test_default_settings_and_the_finest_are_apart_and_friction_is_the_farthest_from_one():
    (row,) = table(
        run("a", "one", "native", 0.5, DEFAULTS, friction=14.0), run("a", "one", "native", 0.01, friction=1.01),
        run("b", "one", "native", 0.1, DEFAULTS, friction=0.02), run("b", "one", "native", 0.03, friction=0.99),
    )  # fmt: skip
    assert (row["default_off"], row["default_off_worst"]) == (pytest.approx(0.3), 0.5)
    assert (row["finest_off"], row["finest_off_worst"], row["good_cases"]) == (pytest.approx(0.02), 0.03, 1)
    assert row["worst_friction_factor"] == 0.02 and row["median_grade"] == "rough"
    # An engine that gains energy has no ratio: it is the worst.
    (other,) = table(run("a", "one", "native", 0.5, friction=-0.5), run("b", "one", "native", 0.5, friction=1e3))
    assert other["worst_friction_factor"] == -0.5


@pytest.mark.parametrize("name", ["one", "an_engine_with_a_name_that_is_far_longer_than_a_terminal_is_wide" * 2])
def test_every_line_of_the_terminal_fits_80_characters(name):
    rows = table(
        run("a", name, "native", 12.3456, DEFAULTS, friction=-123.4), run("a", name, "native", 1e-9, friction=1e-9),
        run("a", name, "assisted", 1e-6), run("a", "two", "native", 0.2),
        **{name: "our contact geometry around this engine's step, in a description of many words " * 3},
    )  # fmt: skip
    lines = [
        *verdict_text.filled(verdict_text.sentence(rows)),
        *verdict_text.in_terminal(rows).splitlines(),
        *verdict_text.legend(rows),
    ]
    assert max(map(len, lines)) <= 80
    assert all(line.split("%")[0].rstrip() for line in lines if "%" in line)  # no line begins with a percent sign
    assert "two native" in verdict_text.in_terminal(rows)  # only the names that do not fit are shortened
