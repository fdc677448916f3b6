"""A sweep on a Dask cluster on loopback: workers killed, the scheduler gone and back, workers that do not fit."""

from __future__ import annotations

import pyarrow as pa
import pytest
from pyarrow import parquet

from reference.sweeping import plan
from reports.running import cluster_worker
from reports.running.cluster import Cluster
from reports.running.solvers import pool
from reports.sweeping.computation import Part, run_parts
from reports.sweeping.parts import SweepWork

pytest.importorskip("distributed")
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]
PLAN = plan("disc_in_circle", dict(mu="0.01:0.5:100", xi1="0:1.5:80"), rtol=1e-9)
PARTS = [Part(start, min(start + 200, len(PLAN))) for start in range(0, len(PLAN), 200)]


@pytest.fixture(scope="module")
def exact():
    """The rows of this plan by the workers of one machine."""
    return rows(run_parts(SweepWork(PLAN), PARTS, pool(2)))


def rows(coming) -> pa.Table:
    """All rows that came, but for what they cost; no part may come twice."""
    found = dict[int, bytes]()
    for part, content in coming:
        assert part.start not in found
        found[part.start] = content
    tables = [parquet.read_table(pa.BufferReader(found[start])) for start in sorted(found)]
    return pa.concat_tables(tables).drop_columns(["cpu_s"]).unify_dictionaries().combine_chunks()


def asked(loopback, patience: float = 120.0):
    machines = Cluster(loopback.address, 2, cluster_worker.identity({}), patience=patience)
    return run_parts(SweepWork(PLAN), PARTS, machines)


def test_with_workers_killed_again_and_again_no_digit_differs(loopback, exact):
    loopback.start_worker(), loopback.start_worker()

    def taken():
        for number, part in enumerate(asked(loopback)):
            yield part
            if number % 6 == 3:  # whoever is at work longest, with what it holds; another takes its place
                victim = next(w for w in loopback.workers if w.poll() is None)
                loopback.start_worker()
                victim.kill()
                victim.wait()

    assert rows(taken()).equals(exact)
    assert sum(worker.poll() is not None for worker in loopback.workers) >= 5


def test_a_scheduler_that_goes_and_comes_back_loses_nothing(loopback, exact, capsys):
    loopback.start_worker(), loopback.start_worker()

    def taken():
        for number, part in enumerate(asked(loopback)):
            yield part
            if number == 5:
                loopback.restart_scheduler()

    assert rows(taken()).equals(exact)
    assert "is gone" in capsys.readouterr().err
