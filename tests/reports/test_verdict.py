"""The table `verdict`: which cases and routes take part, how they are ranked, and what is said of them."""

from __future__ import annotations

from math import isnan, nan
from types import SimpleNamespace

import pytest

from adapters import Setting, our_part
from reports.analysis import verdict
from reports.judging.friction_factor import Losses
from reports.judging.score import Scale, Score
from reports.running.experiment import _our_parts
from reports.running.records import Experiment, Offer, Run, Truth

DEFAULTS, FINE = Setting.of(rung="defaults"), Setting.of(h=1e-4)
SCALE = Scale(1.0, 1.0, 0.5, 2.0, (), (), (), 1.0, Losses(1.0, 1.0), "no friction", 1.0, 0.01)
TRUTHS = {"a": Truth(friction_sensitivity=0.01, scale=SCALE), "b": Truth(friction_sensitivity=0.02, scale=SCALE)}
# At the edge of the limit, below it, and without a truth.
OTHERS = {
    "edge": Truth(friction_sensitivity=1e-5, scale=SCALE),
    "free": Truth(friction_sensitivity=9e-6, scale=SCALE),
    "none": Truth(failure="-"),
}


def run(case, solver, route, off, setting=FINE, friction=nan) -> Run:
    score = Score(off, 0.0, off, 0.0, 0.0, nan, 0.0, 1e-3, False)
    return Run(case, solver, route, setting, 1, "answered", score=score, friction_factor=friction)


def unanswered(case, solver, route, outcome="unsupported") -> Run:
    return Run(case, solver, route, Setting.of(), 0, outcome)


def experiment(*runs, truths=TRUTHS, **our_parts) -> Experiment:
    parts = {(solver, "assisted"): words for solver, words in our_parts.items()}
    return Experiment((), dict(truths), runs, 0.0, our_parts=parts)


def table(*runs, **more):
    return verdict.rows(experiment(*runs, **more))


def test_only_cases_that_depend_on_frictions_law_take_part():
    assert verdict.friction_cases(experiment(truths=TRUTHS | OTHERS)) == ["a", "b", "edge"]
    (row,) = table(run("a", "one", "native", 0.1), run("free", "one", "native", 1e-9), truths=TRUTHS | OTHERS)
    assert (row["friction_cases"], row["answered"], row["finest_off"]) == (3, 1, 0.1)


def test_only_engines_by_themselves_are_ranked_and_the_reference_is_not_there():
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
    assert [row["digits_rank"] for row in rows[:2]] == [1, 2] and isnan(rows[2]["digits_rank"])
    # The route that is partly ours has the most digits, and is not in the sentence.
    assert rows[2]["digits"] > rows[0]["digits"] and rows[2]["our_part"]
    assert verdict.sentence(rows).startswith(f"{verdict.LEAD} two native, 0.1 % off")
    assert "one" not in verdict.sentence(rows)


def test_an_engine_that_crashed_before_it_named_its_routes_has_a_row():
    rows = table(run("a", "one", "native", 1e-4), unanswered("a", "broken", "", "crashed"))
    assert [(row["solver"], row["crashed"], row["good_cases"], row["excellent_one_setting"]) for row in rows] == [
        ("one", 0, 1, 1), ("broken", 1, 0, 0)
    ]  # fmt: skip
    assert "broken" in verdict.in_terminal(rows) and "broken" not in verdict.sentence(rows)


def test_a_case_without_an_answer_counts_as_ignoring_friction():
    rows = table(
        run("a", "easy", "native", 1e-4), unanswered("b", "easy", "native"),
        run("a", "all", "native", 1e-3), run("b", "all", "native", 1e-3),
    )  # fmt: skip
    assert [row["solver"] for row in rows] == ["all", "easy"]
    easy = rows[1]
    assert (easy["answered"], easy["unsupported"], easy["digits"]) == (1, 1, 2.0)
    assert "1 unsupported" in verdict.cells(easy)["answered"][1]


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


def test_the_sentence_is_of_an_engine_that_can_be_installed_not_of_motions_from_files():
    rows = table(
        run("a", "mine", "file", 1e-6), run("a", "theirs", "submission", 1e-5), run("a", "one", "native", 0.1),
        run("a", "one", "assisted", 1e-6), one="our contact geometry around one's step",
    )  # fmt: skip
    assert rows[0]["solver"] == "mine" and rows[0]["digits_rank"] == 1
    assert verdict.sentence(rows).startswith(f"{verdict.LEAD} one native, 10 % off")
    assert "mine" not in verdict.sentence(rows) and "assisted" not in verdict.sentence(rows)


def test_default_settings_are_a_grid_shown_as_median_and_range():
    grid = [Setting.of(rung="defaults", h=h) for h in (0.02, 0.01, 0.005)]
    runs = [run("a", "one", "native", off, setting) for off, setting in zip((0.4, 0.1, 0.9), grid, strict=True)]
    rows = table(*runs, run("b", "one", "native", 0.2, grid[0]), run("a", "one", "native", 0.01))
    (row,) = rows
    assert (row["default_off_best"], row["default_off"], row["default_off_worst"]) == (0.1, pytest.approx(0.3), 0.9)
    assert verdict.cells(row)["default"] == ("30 %", "10 to 90 %")


def test_a_tie_is_in_the_sentence():
    rows = table(run("a", "one", "native", 0.0100), run("a", "two", "native", 0.0105), run("a", "three", "native", 0.9))
    assert [row["digits_rank"] for row in rows] == [1, 1, 3]
    text = verdict.sentence(rows)
    assert text.count("native") == 2 and "tied with it two native" in text


def test_without_an_engine_or_a_case_with_friction_the_sentence_says_so():
    assert "No engine was ranked" in verdict.sentence(table(run("a", "reference", "taylor", 0.0)))
    rows = table(run("free", "one", "native", 0.1), truths=OTHERS | {"edge": Truth(failure="-")})
    assert "No engine was ranked" in verdict.sentence(rows)
    assert len(verdict.in_terminal(rows).splitlines()) == 2


def test_the_terminal_has_a_row_for_each_route_and_says_what_is_not_ranked():
    rows = table(
        run("a", "one", "native", 0.0123, DEFAULTS), run("a", "one", "native", 0.001),
        run("a", "one", "assisted", 1e-6),
        one="our contact geometry around one's step",
    )  # fmt: skip
    head, first, second = verdict.in_terminal(rows).splitlines()
    for text in ("1. one native", "1.2 %", "0.1 %"):
        assert text in first
    _, first_details, _ = verdict.details(rows).splitlines()
    for text in ("1. one native", "very good", "1.50 ± 0.00"):
        assert text in first_details
    assert "one assisted" in second and "." not in second.split("one")[0]
    assert "Not ranked: one assisted (our contact geometry around one's step)." in verdict.notes(rows)
    assert "one assisted" in " ".join(verdict.legend(rows))


@pytest.mark.parametrize("name", ["one", "an_engine_with_a_name_that_is_far_longer_than_a_terminal_is_wide" * 2])
def test_every_line_of_the_terminal_fits_80_characters(name):
    rows = table(
        run("a", name, "native", 12.3456, DEFAULTS, friction=-123.4), run("a", name, "native", 1e-9, friction=1e-9),
        run("a", name, "assisted", 1e-6), run("a", "two", "native", 0.2),
        **{name: "our contact geometry around this engine's step, in a description of many words " * 3},
    )  # fmt: skip
    lines = [
        *verdict.filled(verdict.sentence(rows)), *verdict.in_terminal(rows).splitlines(), *verdict.legend(rows),
        *verdict.details(rows).splitlines(), *verdict.notes(rows),
    ]  # fmt: skip
    assert max(map(len, lines)) <= 80
    assert all(line.split("%")[0].rstrip() for line in lines if "%" in line)  # no line begins with a percent sign
    assert "two native" in verdict.in_terminal(rows)  # only the names that do not fit are shortened


def test_narrower_columns_come_before_a_shorter_name():
    rows = table(
        run("a", "my_engine 2.1.0", "submission", 1e-9), run("a", "two", "native", 0.2), run("a", "two", "native", 1e-9)
    )
    assert "my_engine 2.1.0 submission" in verdict.in_terminal(rows)
    assert max(map(len, verdict.in_terminal(rows).splitlines())) <= 80


def test_an_adapter_says_what_of_its_routes_is_not_its_engines_own():
    adapter = SimpleNamespace(NAME="mine")
    assert our_part(adapter, "native") == our_part(adapter, "process") == ""
    assert our_part(adapter, "assisted") == "our contact geometry around mine's step"
    assert our_part(adapter, "integrator") == "our contact geometry and contact law around mine's integrator"
    own = SimpleNamespace(NAME="mine", OUR_PARTS={"planned": "our plan", "assisted": ""})
    assert (our_part(own, "planned"), our_part(own, "assisted")) == ("our plan", "")
    offers = {("a", "mine"): (Offer("native"), Offer("planned", our_part="our plan"))}
    assert _our_parts(offers) == {("mine", "planned"): "our plan"}
