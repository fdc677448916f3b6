"""The motions that runs are compared with are the same numbers, computed or read from another worker's file."""

from __future__ import annotations

import numpy as np
import pytest

import cases
import reference
from adapters import Setting
from adapters.processes import worker
from cases import lookup
from reports.running import tasks, true_motions
from reports.running.records import TRUTH_RTOL
from tests.sampling import quick_every

CASE = cases.load("disc_on_incline", slope=0.2)
TIMES = np.linspace(0.0, CASE.duration, 11)


@pytest.fixture
def in_worker(tmp_path, monkeypatch):
    """Compute a motion as a worker of that group does, without the motions of earlier calls."""
    monkeypatch.setattr(worker, "pool_folder", tmp_path)

    def motion_in(group: str, case=CASE):
        monkeypatch.setattr(worker, "group", group)
        true_motions.true_motion.cache_clear()
        return true_motions.true_motion(case, reference.METHODS[0])

    yield motion_in
    true_motions.true_motion.cache_clear()


def test_an_engine_s_worker_reads_the_motion_that_one_without_engines_computed(in_worker, tmp_path, monkeypatch):
    computed = in_worker("")
    assert [file.suffix for file in tmp_path.iterdir()] == [".motion"]
    monkeypatch.setattr(true_motions, "run_on_clock", None)  # whoever computes it again fails
    read = in_worker("exudyn")
    assert read.transitions == computed.transitions
    assert np.array(read(TIMES)).tobytes() == np.array(computed(TIMES)).tobytes()


def test_the_reference_s_run_at_the_truth_s_tolerance_is_the_truth_s_motion(in_worker, monkeypatch):
    truth, computed = tasks.find_truth(CASE), in_worker("")
    monkeypatch.setattr(tasks, "run_on_clock", None)  # whoever makes the run again fails
    true_motions.true_motion.cache_clear()  # as in another worker
    run = tasks.measure(CASE, "reference", truth.method, Setting.of(rtol=TRUTH_RTOL), 6, truth)
    assert (run.outcome, run.cost, run.distance.centre_max) == ("answered", computed.cost, 0.0)
    assert run.cost.cpu_s > 0.0 and run.cost.setup_s > 0.0 and run.cost.steps > 0
    again = reference.simulate(CASE, rtol=TRUTH_RTOL, method=truth.method)
    assert np.array(computed(TIMES)).tobytes() == np.array(again(TIMES)).tobytes()


@quick_every(8)
@pytest.mark.parametrize("name", cases.names(hard=False))
def test_every_case_of_the_default_report_has_a_truth_without_heyoka(name, monkeypatch):
    monkeypatch.setattr(reference, "METHODS", ("dop853",))
    for case in lookup.case_name(name).every():
        assert tasks.find_truth(case).failure == ""


def test_an_engine_s_worker_writes_no_motion(in_worker, tmp_path):
    assert in_worker("exudyn").status == "completed"
    assert not list(tmp_path.iterdir())
