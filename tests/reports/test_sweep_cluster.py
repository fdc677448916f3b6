"""A sweep on a Dask cluster on loopback: workers killed, the scheduler gone and back, workers that do not fit."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pyarrow as pa
import pytest
from pyarrow import parquet

from reference.sweeping import plan
from reports.sweeping import cluster, local, parts
from reports.sweeping.local import Part
from reports.sweeping.parts import Work

pytest.importorskip("distributed")
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]
ROOT = Path(__file__).parents[2]
PLAN = plan("disc_in_circle", dict(mu="0.01:0.5:100", xi1="0:1.5:80"), rtol=1e-9)
PARTS = [Part(start, min(start + 200, len(PLAN))) for start in range(0, len(PLAN), 200)]


class Cluster:
    """A scheduler and workers in processes of their own, so that they can be killed."""

    def __init__(self, folder: Path):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.folder, self.address = folder, f"tcp://127.0.0.1:{self.port}"
        self.workers: list[subprocess.Popen] = []
        self.start_scheduler()

    def _start(self, module: str, *words: str, path: str = "") -> subprocess.Popen:
        where = os.pathsep.join(filter(None, [path, str(ROOT)]))
        environment = {**os.environ, "PYTHONPATH": where}
        command = [sys.executable, "-m", f"distributed.cli.{module}", *words, "--no-dashboard"]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen(command, env=environment, cwd=self.folder, **quiet)

    def start_scheduler(self) -> None:
        self.scheduler = self._start("dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port))

    def start_worker(self, path: str = "") -> subprocess.Popen:
        words = [self.address, "--nthreads", "1", "--no-nanny", "--local-directory", str(self.folder)]
        self.workers.append(self._start("dask_worker", *words, path=path))
        return self.workers[-1]

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.send_signal(signal.SIGKILL)
            process.wait()


@pytest.fixture
def loopback(tmp_path):
    found = Cluster(tmp_path)
    yield found
    found.close()


@pytest.fixture(scope="module")
def exact():
    """The rows of this plan by the workers of one machine."""
    return rows(local.done(Work(PLAN, identity=parts.identity()), PARTS, 2))


def rows(coming) -> pa.Table:
    """All rows that came, but for what they cost; no part may come twice."""
    found = dict[int, bytes]()
    for part, content in coming:
        assert part.start not in found
        found[part.start] = content
    tables = [parquet.read_table(pa.BufferReader(found[start])) for start in sorted(found)]
    return pa.concat_tables(tables).drop_columns(["cpu_s"]).unify_dictionaries().combine_chunks()


def asked(loopback, patience: float = 120.0):
    return cluster.done(Work(PLAN, identity=parts.identity()), PARTS, loopback.address, 2, patience)


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
                loopback.scheduler.kill()
                loopback.scheduler.wait()
                time.sleep(12.0)  # longer than the client tries to reconnect by itself
                loopback.start_scheduler()
                loopback.start_worker(), loopback.start_worker()

    assert rows(taken()).equals(exact)
    assert "is gone" in capsys.readouterr().err


def test_a_worker_without_heyoka_is_left_out_and_the_reason_told(loopback, exact, capsys, tmp_path):
    other = tmp_path / "other" / "heyoka"
    other.mkdir(parents=True)
    (other / "__init__.py").write_text("raise ImportError('not here')\n")
    loopback.start_worker(path=str(other.parent))
    loopback.start_worker()
    assert rows(asked(loopback)).equals(exact)
    told = capsys.readouterr().err
    assert "method of the reference is dop853, not taylor" in told


def test_where_nobody_fits_it_is_said_in_a_sentence(loopback, tmp_path):
    other = tmp_path / "other" / "heyoka"
    other.mkdir(parents=True)
    (other / "__init__.py").write_text("raise ImportError('not here')\n")
    loopback.start_worker(path=str(other.parent))
    with pytest.raises(OSError, match="no worker at .* fits: .*dop853"):
        list(asked(loopback, patience=20.0))
