"""Every study says what its tables hold: a table or column without words is refused here, not after a report's runs."""

from functools import cache
from importlib import import_module
from math import nan
from typing import Any

import pytest

import cases
from adapters import Setting
from reports import studies, sweep
from reports.running.processes.worker_process import CallResult
from reports.running.records import Run, Truth
from reports.studies.error_parts import measure as error_parts
from reports.studies.published import study as published
from reports.studies.stability import measure as stability
from reports.studies.stability.sensitivity import Conditioning, Sensitivity
from reports.studies.stability.step_limit import Bracket

pytestmark = pytest.mark.builds

CASE = cases.load("disc_on_line", mu=0.1)
ROW = Run(CASE.label, "engine", "native", Setting.of(h=0.1), 1, "crashed", "It blew up.")
SCENE = stability.HardScene(Truth(), Truth(), None, Conditioning(nan, nan, nan), Sensitivity("", nan, nan))
HUNG = CallResult("timed_out", reason="It hung.")
WHO = ("engine", "native")


@cache
def short_results() -> dict[str, Any]:
    """A result of each study that has next to no rows; made by the first test that reads them."""
    return {
        "error_parts": [error_parts.ErrorCell(CASE.label, *WHO, Setting.of(), "unsupported", "No such curve.")],
        "published": published.of_one(0)[:1],
        "stability": stability.Stability(
            (CASE,),
            {CASE.label: SCENE},
            (ROW,),
            (Bracket.failure(CASE, "engine", "native", "It hung."),),
        ),
    }  # fmt: skip


def test_every_study_is_known_by_its_place():
    assert set(studies.names()) == short_results().keys()


@pytest.mark.parametrize("name", studies.names())
def test_every_study_has_its_words(name):
    study = studies.study(name)
    assert study.TITLE and study.QUESTION.endswith(".") and set(study.TAKES) <= {"case", "solver"}
    assert study.IN_REPORT in (True, False) and callable(study.run) and callable(study.draw)
    tables = study.rows(short_results()[name])
    assert tables.keys() == study.TABLES.keys()
    for table, rows in tables.items():
        words = study.TABLES[table]
        assert words.holds and all(words.columns.values())
        for row in rows:
            assert list(row) == list(words.columns), table


@pytest.mark.parametrize("name", studies.MOVED)
def test_a_study_that_moved_says_what_to_type(name):
    with pytest.raises(cases.BadValue, match=f"in a clone type: python -m tests.benchmarks {name}"):
        studies.study(name)
    assert callable(import_module(studies.MOVED[name]).run)


def test_maps_are_a_sweep(capsys, tmp_path):
    with pytest.raises(cases.BadValue, match="maps is a sweep; type: python -m reports.sweep disc_in_circle"):
        studies.study("maps")
    words = studies.MAPS.replace("121", "3").replace("91", "2").split()[3:]
    assert sweep.main([*words, "--out", str(tmp_path / "out")]) == 0 and "6 scenarios" in capsys.readouterr().out


def test_a_study_that_fails_is_said_in_its_result(monkeypatch):
    study = studies.study("published")

    def run(request, calls):
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr(study, "run", run)
    result = studies.run_study("published", studies.Request(), None, "the command")
    assert (result.failure, result.frames, result.command) == ("ZeroDivisionError: by zero", {}, "the command")


def test_a_picture_that_fails_leaves_the_numbers(tmp_path):
    study = studies.study("stability")
    (drawn,) = studies.Result("stability", study, "", findings=None).draw(tmp_path)
    assert drawn.name == "" and "could not be drawn" in drawn.caption
