"""The motions that runs are compared with are the same numbers, computed or read from another worker's file."""

from __future__ import annotations

import numpy as np
import pytest

import cases
import reference
from reports.running import true_motions
from reports.running.processes import worker_process

CASE = cases.load("disc_on_incline", slope=0.2)
TIMES = np.linspace(0.0, CASE.duration, 11)


@pytest.fixture
def in_worker(tmp_path, monkeypatch):
    """Compute a motion as a worker of that group does, without the motions of earlier calls."""
    monkeypatch.setattr(worker_process, "pool_folder", tmp_path)

    def motion_in(group: str, case=CASE):
        monkeypatch.setattr(worker_process, "group", group)
        true_motions.true_motion.cache_clear()
        return true_motions.true_motion(case, "taylor")

    yield motion_in
    true_motions.true_motion.cache_clear()


def test_an_engine_s_worker_reads_the_motion_that_one_without_engines_computed(in_worker, tmp_path, monkeypatch):
    computed = in_worker("")
    assert [file.suffix for file in tmp_path.iterdir()] == [".motion"]
    monkeypatch.setattr(reference, "simulate", None)  # whoever computes it again fails
    read = in_worker("exudyn")
    assert read.transitions == computed.transitions
    assert np.array(read(TIMES)).tobytes() == np.array(computed(TIMES)).tobytes()


def test_an_engine_s_worker_writes_no_motion(in_worker, tmp_path):
    assert in_worker("exudyn").status == "completed"
    assert not list(tmp_path.iterdir())


def test_another_case_has_another_motion(in_worker, tmp_path):
    in_worker("")
    other = cases.load("disc_on_incline", slope=0.3)
    assert in_worker("exudyn", other)(1.0).x != in_worker("exudyn")(1.0).x


def test_a_motion_that_cannot_be_written_is_still_a_motion(in_worker, monkeypatch, tmp_path):
    monkeypatch.setattr(worker_process, "pool_folder", tmp_path / "missing")
    assert in_worker("").status == "completed"
