"""Every study says what its tables hold: a table or column without words is refused here, not after a report's runs."""

from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import Any

import pytest

import cases
from adapters import Setting
from reports import studies, sweep
from reports.running.records import Run, Truth
from reports.studies import error_parts
from reports.studies.published import study as published
from reports.studies.stability import study as stability
from tests.benchmarks import hard_scenes

from .test_figures import score

CASE = cases.load("disc_on_line", mu=0.1)
ROW = Run(CASE.label, "engine", "native", Setting.of(h=0.1), 1, "crashed", "It blew up.")
SCENE = stability.HardScene(Truth(), Truth())
WHO = ("engine", "native")


@cache
def short_results() -> dict[str, Any]:
    """A result of each study that has next to no rows; made by the first test that reads them."""
    return {
        "error_parts": [error_parts.ErrorCell(Run(CASE.label, *WHO, Setting.of(), 1, "unsupported", "No such curve."))],
        "published": published.run(studies.Request(), None)[:1],
        "stability": stability.Stability((CASE,), {CASE.label: SCENE}, (ROW,)),
    }  # fmt: skip


def test_every_study_is_known_by_its_place():
    assert set(studies.names()) == short_results().keys()


@pytest.mark.parametrize("name", studies.names())
def test_every_study_has_its_words(name):
    study = studies.study(name)
    assert study.TITLE and study.QUESTION.endswith(".") and set(study.TAKES) <= {"case", "solver"}
    assert study.IN_REPORT in (True, False) and callable(study.run) and study.TAB in ("evidence", "errors")
    tables = study.rows(short_results()[name])
    assert tables.keys() == study.TABLES.keys()
    for table, rows in tables.items():
        words = study.TABLES[table]
        assert words.holds and all(words.columns.values())
        for row in rows:
            assert list(row) == list(words.columns), table


@pytest.mark.parametrize("name", studies.MOVED)
def test_a_study_that_moved_is_there(name):
    assert callable(import_module(studies.MOVED[name]).run)


def test_maps_are_a_sweep(capsys, tmp_path):
    words = studies.MAPS.replace("121", "3").replace("91", "2").partition(" sweep ")[2].split()
    assert sweep.main([*words, "--out", str(tmp_path / "out")]) == 0 and "6 scenarios" in capsys.readouterr().out


def test_a_study_that_fails_is_said_in_its_result(monkeypatch):
    study = studies.study("published")

    def run(request, calls):
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr(study, "run", run)
    result = studies.run_study("published", studies.Request(), None, "the command")
    assert (result.failure, result.frames, result.command) == ("ZeroDivisionError: by zero", {}, "the command")


def test_what_the_last_bit_decides_is_known_of_the_catalogue_alone():
    """The file has every variant of a few seconds; another scene may have the name of one."""
    every = hard_scenes.scenes()
    assert list(stability._stored_constants()) == [case.label for case in every]
    flagged = {case.label: stability.chaotic(case) for case in every if stability.chaotic(case)}
    assert flagged == {
        "balanced_on_its_tip[duration=6]": "one unit in the last place moves the centre by 1.2e+01 of its path",
        "touching_slip[above=0]": "one unit in the last place decides: 0 transitions (completed) become 2 transitions "
        "(completed)",
    }
    (one,) = (case for case in every if case.label == "touching_slip[above=0]")
    assert not stability.chaotic(replace(one, duration=5.0)) and not stability.chaotic(CASE)


def test_a_hard_scene_is_told_in_three_sentences_with_the_errors_and_why():
    hard = cases.select("touching_slip")[0]
    scored = replace(ROW, case=hard.label, outcome="answered", reason="slip velocity: 20 %", score=score(0.2))
    found = stability.Stability(
        (CASE, hard), {CASE.label: SCENE, hard.label: SCENE},
        (ROW, scored, replace(scored, route="other", score=score(1e-3), reason="x")),
    )  # fmt: skip
    texts = stability.in_words(found)
    assert list(texts) == [CASE.label, hard.label]  # without any answer it is the hardest
    entry = cases.entry("touching_slip")
    assert texts[CASE.label] == "Seen: engine native: crashed."
    assert texts[hard.label].startswith(f"{entry.summary} Hard: {entry.hard}; known: {entry.outcome}.".replace("`", ""))
    assert texts[hard.label].endswith("Seen: engine native 20 % off (slip velocity: 20 %); engine other 0.1 % off.")
    assert f"{hard.label}: " in stability.summary(found)
