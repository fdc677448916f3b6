"""Calls whose answers are kept: made once for each key, and again after a failure."""

from pathlib import Path

import numpy as np
import pytest

import cases
from reports.running.calls import Calls, StorePolicy
from reports.running.processes.workers import WorkerPool
from reports.running.storage.result_store import Store

from .called import work

pytestmark = pytest.mark.builds

LINE = cases.load("disc_on_line")


@pytest.fixture(scope="module")
def pool():
    """One worker for all: which calls are made is asked here, not by whom."""
    pool = WorkerPool(1)
    yield pool
    pool.close()


@pytest.fixture
def answers(tmp_path, pool):
    """answers(calls, versions) -> outcomes and values, by the same store each time; `answers.log` names the calls."""
    log = tmp_path / "log"

    def run(*calls, versions=None):
        asked = [(str(log), *call) for call in calls]
        versions = {"reference": "1"} if versions is None else versions
        calls = Calls(1, store=Store(tmp_path / "store"), versions=versions)
        calls._pool = pool
        return calls.all("work", work, asked, keep=StorePolicy())

    run.log = lambda: log.read_text().split() if Path(log).exists() else []
    return run


def call(how="a", key=LINE, solver="reference", numbers=(1 / 3, float("nan"))):
    return key, solver, np.array(numbers), how


def test_an_answer_is_kept_and_a_failure_is_made_again(answers):
    first = answers(call("a"), call("fails"), call("b"))
    again = answers(call("b"), call("fails"), call("c"), call("a"))
    assert answers.log() == ["a", "fails", "b", "fails", "c"]
    assert [answer.outcome for answer in again] == ["done", "raised", "done", "done"]
    assert again[0].value[0] == "b" and again[3].value[0] == "a"
    np.testing.assert_array_equal(again[3].value[1]["twice"], first[0].value[1]["twice"])


def test_other_numbers_another_case_and_another_version_are_other_calls(answers):
    other = cases.load("disc_on_line", mu=0.2)
    answers(call())
    answers(call(numbers=(1 / 3, 0.0)), call(key=other))
    answers(call(), versions={"reference": "2"})
    assert len(answers.log()) == 4
    answers(call(), call(numbers=(1 / 3, 0.0)), call(key=other))
    assert len(answers.log()) == 4


def test_of_a_solver_that_cannot_tell_its_version_nothing_is_kept(answers):
    answers(call(), versions={"reference": ""})
    answers(call(), versions={"reference": ""})
    assert len(answers.log()) == 2
