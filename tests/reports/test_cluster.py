"""Calls on a Dask cluster: the same answers as on this machine, whatever becomes of workers and scheduler."""

from __future__ import annotations

import math
import operator
import os
import re
import time
from dataclasses import replace
from pathlib import Path

import pytest

import cases
from adapters import Setting
from cases import Cost
from reports.running import experiment
from reports.running.calls import Calls, StorePolicy
from reports.running.processes import cluster_probe, cluster_worker
from reports.running.processes.cluster import Cluster, NoWorkers
from reports.running.processes.workers import WorkerPool
from reports.running.records import Run

pytest.importorskip("distributed")
pytestmark = [pytest.mark.builds, pytest.mark.filterwarnings("ignore")]  # Dask's own


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

    monkeypatch.setattr(cluster_probe, "identify", fits)
    own = distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None)
    yield Cluster(own.scheduler_address, 1, ())
    own.close()
    cluster_worker._own().close()
    cluster_worker._own.cache_clear(), cluster_worker._ready.clear()


def test_a_call_goes_to_a_worker_and_its_answer_comes_back(within):
    answers = dict(within.run(operator.call, [(math.sqrt, 2.0), (math.sqrt, -1.0)]))
    assert answers[0].value == math.sqrt(2.0)
    assert (answers[1].outcome, answers[1].reason) == ("raised", "ValueError: math domain error")


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


def test_a_worker_that_was_not_asked_makes_nothing():
    with pytest.raises(cluster_worker.UnknownWorker):
        cluster_worker.make(b"", 1.0, "")


def test_what_differs_is_told():
    asked = (("numpy", "2.0"), ("python", "3.11"), ("the file a.py", "abc"))
    assert cluster_worker.difference(asked, asked) == ""
    assert cluster_worker.difference((("numpy", "2.0"), ("python", "3.12")), asked) == (
        "python is 3.12, not 3.11; the file a.py is unknown, not abc"
    )


class Noted:
    """A cluster that notes what it is asked, and answers nothing."""

    def __init__(self):
        self.functions = []

    def run(self, function, *_):
        self.functions.append(function)
        yield from ()


@pytest.mark.parametrize(
    ("keep", "goes"),
    [
        (StorePolicy("run"), True),
        (StorePolicy("truth"), True),
        (StorePolicy(), True),
        (StorePolicy("figure"), False),
        (None, False),
    ],
)
def test_only_what_is_the_same_anywhere_goes_to_a_cluster(keep, goes):
    with Calls(1, cluster=(noted := Noted())) as calls:
        calls._pool.run = (own := Noted()).run
        list(calls.each("step", cluster_worker.difference, [((), ())], keep=keep))
        assert bool(noted.functions) is goes and bool(own.functions) is not goes
        assert calls.alone().cluster is None  # what is timed


# --- on loopback ------------------------------------------------------------------------------------------------------

CASES = (cases.load("disc_on_line"), cases.load("disc_in_circle", mu=0.2))
SOLVERS = ("reference", "exudyn", "pymunk")


def some(case: str, solver: str, route: str, settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
    return settings[:3]


def plain(run: Run) -> tuple:
    """A run without what it cost and when, its arrays as bytes: NaN is NaN."""
    arrays = [(name, a.tobytes()) for kept in (run.samples, run.off) for name, a in kept.items()]
    return arrays, repr(replace(run, samples={}, off={}, when="", cost=Cost(steps=run.cost.steps)))


@pytest.fixture(scope="module")
def exact():
    with Calls(2) as calls:
        found = experiment.run_cases(CASES, SOLVERS, calls, some)
    assert len(found.runs) > 20
    return [plain(run) for run in found.runs]


def ran(loopback, patience: float = 120.0, after=lambda number: None) -> list[tuple]:
    """The runs by a cluster; `after(n)` is called when the n-th has come."""

    def watched(step, total, answers):
        for number, answer in enumerate(answers):
            yield answer
            if step.startswith("runs"):
                after(number)

    with Calls(2, progress=watched) as calls:
        present = calls.present(SOLVERS)
        identity = cluster_worker.identity({name: calls.versions[name] for name in present})
        calls.cluster = Cluster(loopback.address, 2, identity, present, patience=patience)
        return [plain(run) for run in experiment.run_cases(CASES, SOLVERS, calls, some).runs]


@pytest.mark.slow
def test_runs_are_the_same_while_workers_are_killed(loopback, exact):
    loopback.start_worker(), loopback.start_worker()

    def kill(number):
        if number % 8 == 3:  # whoever is at work longest, with what it holds; another takes its place
            victim = next(worker for worker in loopback.workers if worker.poll() is None)
            loopback.start_worker()
            victim.kill()
            victim.wait()

    assert ran(loopback, after=kill) == exact
    assert sum(worker.poll() is not None for worker in loopback.workers) >= 3


@pytest.mark.slow
def test_runs_are_the_same_when_the_scheduler_was_gone(loopback, exact, capsys):
    loopback.start_worker(), loopback.start_worker()

    def restart(number):
        if number == 5:
            loopback.restart_scheduler()

    assert ran(loopback, after=restart) == exact
    assert "is gone" in capsys.readouterr().err


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
    with pytest.raises(NoWorkers, match=f"no worker at .* fits: .*{words}"):
        ran(loopback, patience=40.0)
    assert words in capsys.readouterr().err


def test_the_batch_system_of_the_docs_gets_the_job_they_tell(monkeypatch):
    """Nothing is submitted: there is no such system here."""
    jobqueue = pytest.importorskip("dask_jobqueue", reason="dask-jobqueue is not part of the suite")
    page = (Path(__file__).parents[2] / "docs" / "cluster.md").read_text(encoding="utf-8")
    (code,) = (code for code in re.findall(r"```python\n(.*?)```", page, flags=re.S) if "dask_jobqueue" in code)
    scaled = []
    monkeypatch.setattr(jobqueue.SLURMCluster, "scale", lambda self, jobs: scaled.append(jobs))
    names: dict = {}
    exec(code, names)
    script, address = names["cluster"].job_script(), names["cluster"].scheduler_address
    names["cluster"].close()
    assert scaled[-1] == 8 and f"dask_worker {address} " in script
    for words in ("--cpus-per-task=16", "--mem=30G", "-t 04:00:00", "--nthreads 1", "--nworkers 16"):
        assert words in script and words.removeprefix("-t ").removeprefix("04:00:00") in page
