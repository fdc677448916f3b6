"""Calls on a Dask cluster: the same answers as on this machine, whatever becomes of workers and scheduler."""

from __future__ import annotations

import math
import operator
import os
import time

import pytest

from adapters.processes.pool import WorkerPool
from reports.running import cluster_worker
from reports.running.calls import Calls
from reports.running.cluster import Cluster, NoWorkers

pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")  # Dask's own


# Functions that every process has: one that answers, raises, ends its process, hangs; and one that cannot travel.
WAYS = [(math.sqrt, 2.0), (math.sqrt, -1.0), (os.abort,), (time.sleep, 60.0), (math.sqrt, 3.0), (lambda: None,)]


def fits(solvers, files):
    """A worker that says it is what was asked for."""
    cluster_worker._ready.set()
    return ()


@pytest.fixture
def within(monkeypatch):
    """A cluster within this process."""
    import distributed

    monkeypatch.setattr(cluster_worker, "ask_identity", fits)
    own = distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None)
    yield Cluster(own.scheduler_address, 1, ())
    own.close()
    cluster_worker._own().close()
    cluster_worker._own.cache_clear(), cluster_worker._ready.clear()


@pytest.mark.slow
def test_calls_have_the_answers_they_have_here(within):
    """Also where one raises, ends its process, hangs or cannot travel; and the worker lives on."""
    here = WorkerPool(1)
    answers = [dict(pool.run(operator.call, WAYS, 0.3)) for pool in (here, within)]
    here.close()
    assert [answers[1][i].outcome for i in range(6)] == ["done", "raised", "died", "timed_out", "done", "raised"]
    output = [[(i, a.outcome, a.value, a.reason) for i, a in sorted(some.items())] for some in answers]
    assert output[0] == output[1]


@pytest.mark.parametrize("times", [1, 3])
def test_a_fault_of_a_worker_is_no_answer(times, within, monkeypatch):
    """The call is made again, elsewhere if there is another worker; a fault that stays ends the command."""
    run, faults = WorkerPool.run, []

    def fails(pool, *call, **how):
        faults.append(call)
        if len(faults) <= times:
            raise OSError("no space left")
        return run(pool, *call, **how)

    monkeypatch.setattr(WorkerPool, "run", fails)
    if times == 1:
        ((_, answer),) = within.run(operator.call, [(math.sqrt, 2.0)])
        assert answer.value == math.sqrt(2.0)
    else:
        with pytest.raises(NoWorkers, match="no worker of the cluster can make a call .*no space left"):
            list(within.run(operator.call, [(math.sqrt, 2.0)]))


def test_what_differs_is_told():
    asked = (("numpy", "2.0"), ("python", "3.11"), ("the file a.py", "abc"))
    assert cluster_worker.difference(asked, asked) == ""
    assert cluster_worker.difference((("numpy", "2.0"), ("python", "3.12")), asked) == (
        "python is 3.12, not 3.11; the file a.py is unknown, not abc"
    )


# --- on loopback ------------------------------------------------------------------------------------------------------


def without(tmp_path, package: str) -> str:
    """A folder in which a package cannot be imported."""
    other = tmp_path / "other" / package
    other.mkdir(parents=True)
    (other / "__init__.py").write_text("raise ImportError('not here')\n")
    return str(other.parent)


def with_version(tmp_path, package: str) -> str:
    """A folder in which a package says that it has another version."""
    output = tmp_path / "other" / f"{package}-0.1.dist-info"
    output.mkdir(parents=True)
    (output / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 0.1\n")
    return str(output.parent)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lacks", "package", "words"),
    [
        (without, "exudyn", "exudyn is not_installed"),
        (without, "heyoka", "method of the reference is dop853, not taylor"),
        (with_version, "numpy", "numpy is 0.1, not"),
    ],
)
def test_a_worker_that_differs_is_left_out_and_the_reason_told(loopback, tmp_path, capsys, lacks, package, words):
    loopback.start_worker(path=lacks(tmp_path, package))
    solvers = ("reference", "exudyn", "pymunk")
    with Calls(2) as calls:
        present = calls.present(solvers)
        identity = cluster_worker.identity({name: calls.versions[name] for name in present})
    machines = Cluster(loopback.address, 2, identity, present, patience=40.0)
    with pytest.raises(NoWorkers, match=f"no worker at .* is suitable: .*{words}"):
        list(machines.run(math.sqrt, [(4.0,)]))
    assert words in capsys.readouterr().err
