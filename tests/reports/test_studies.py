"""Every study says what its tables hold: a table or column without words is refused here, not after a report's runs."""

from dataclasses import replace
from functools import cache
from math import nan
from pathlib import Path
from typing import Any

import pytest

import cases
from adapters import Setting
from adapters.lookup import engines
from cases import CoulombFriction, Gravity, Unilateral
from reference.sweeping import plan
from reports import studies
from reports.judging.residuals import Residuals
from reports.running.processes.worker_process import CallResult
from reports.running.records import Run, Truth
from reports.studies import meanings, paper, uniqueness
from reports.studies.effect_costs import measure as effect_costs
from reports.studies.error_parts import measure as error_parts
from reports.studies.maps import Map
from reports.studies.published import study as published
from reports.studies.settings import measure as settings
from reports.studies.stability import measure as stability
from reports.studies.stability.sensitivity import Conditioning, Sensitivity
from reports.studies.stability.step_limit import Bracket
from reports.sweeping import parts
from reports.sweeping.parts import SweepWork

pytestmark = pytest.mark.builds

ROOT = Path(__file__).parents[2]
ROUTES = (("reference", ""), ("engine", "native"))
AREA = plan("disc_in_circle", {"mu": "0.1:0.2:2", "xi1": "0:1:2"})
CASE = cases.load("disc_on_line", mu=0.1)
ROW = Run(CASE.label, "engine", "native", Setting.of(h=0.1), 1, "crashed", "It blew up.")
SCENE = stability.HardScene(Truth(), Truth(), None, Conditioning(nan, nan, nan), Sensitivity("", nan, nan))
HUNG = CallResult("timed_out", reason="It hung.")
WHO = (0, "engine", "native")


@cache
def short_results() -> dict[str, Any]:
    """A result of each study that has next to no rows; made by the first test that reads them."""
    return {
        "effect_costs": [effect_costs._row("in_circle", WHO, {WHO: effect_costs.StageResult("unsupported")}, {})],
        "error_parts": [error_parts.ErrorCell(CASE.label, *WHO[1:], Setting.of(), "unsupported", "No such curve.")],
        "maps": [
            Map(*who, AREA, {0: parts.failure_text(SweepWork(AREA, *who), 0, "crashed", "It blew up.")})
            for who in ROUTES
        ],
        "meanings": [dict.fromkeys(meanings.COLUMNS, "")],
        "paper": paper.Paper(paper.equation_rows()[:1], paper.claim_rows()[:1], paper.remark_rows()[:1], {}),
        "published": published.of_one(0)[:1],
        "settings": [settings.SettingCell(CASE.label, *WHO[1:], "rung 1", Setting.of(h=0.1), "answered", 1.0, 1e-3)],
        "stability": stability.Stability(
            (CASE,),
            {CASE.label: SCENE},
            ((ROW, Residuals()),),
            (Bracket.failure(CASE, "engine", "native", "It hung."),),
        ),
        "uniqueness": [uniqueness.StateRow(uniqueness.FLOOR, 0.5, 0.0625, 0.1, ("floor",))],
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
    assert (ROOT / "tests" / "benchmarks" / name / "study.py").is_file()


def test_a_study_that_fails_is_said_in_its_result(monkeypatch):
    study = studies.study("paper")

    def run(request, calls):
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr(study, "run", run)
    result = studies.run_study("paper", studies.Request(), None, "the command")
    assert (result.failure, result.frames, result.command) == ("ZeroDivisionError: by zero", {}, "the command")


def test_a_picture_that_fails_leaves_the_numbers(tmp_path):
    study = studies.study("stability")
    (drawn,) = studies.Result("stability", study, "", findings=None).draw(tmp_path)
    assert drawn.name == "" and "could not be drawn" in drawn.caption


@pytest.mark.parametrize("name", engines())
def test_the_page_of_parameters_is_what_the_adapters_tell(name):
    pytest.importorskip(f"adapters.{name}")
    page = (ROOT / "docs" / "engine_parameters.md").read_text(encoding="utf-8").splitlines()
    kept = [line for line in page if line.startswith(f"| {name} |")]
    again = "python -m reports.studies.meanings > docs/engine_parameters.md"
    assert kept == meanings.as_lines(meanings.of_one(name)), again


def test_an_effect_adds_operations_to_the_largest_mode_and_a_case_without_it_has_fewer():
    smooth, rough = ((Gravity(9.81),), (Gravity(9.81), CoulombFriction(0.1), Unilateral()))
    case = cases.load("disc_in_circle", mu=0.1)
    few, events = effect_costs.compiled_size(replace(case, effects=smooth))
    more, more_events = effect_costs.compiled_size(replace(case, effects=rough))
    assert 0 < few < more and events < more_events
