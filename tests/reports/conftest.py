"""What several tests of reports begin with."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path

import pytest

from reports.running.processes import worker_process, workers
from reports.running.timing import clock

from .loopback import Processes
from .watch import LOOP, Watch


@pytest.fixture
def loopback(tmp_path):
    """A Dask scheduler on loopback, to which a test adds workers."""
    found = Processes(tmp_path)
    yield found
    found.close()


@pytest.fixture(scope="session")
def in_process() -> Callable:
    """In `with in_process():` workers' calls are made in this process: starting workers is most of the cost of a small
    report. For tests of a command's files and words; that calls are separated is tested elsewhere."""

    def run(self, function, arguments, limit=60.0, skip=lambda index: None, groups=(), brief=False):
        for i, args in enumerate(arguments):
            given = skip(i)
            yield i, given or worker_process._call(function, args, Path(tempfile.mkdtemp()))

    @contextmanager
    def patched():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(workers.WorkerPool, "run", run)
            patch.setattr(workers.WorkerPool, "begin", lambda self, groups: None)
            yield

    return patched


@pytest.fixture
def watch(monkeypatch) -> Watch:
    """The clock of a machine on which nothing else is seen to run, whatever runs."""
    watch = Watch()
    monkeypatch.setattr(clock, "time", watch)
    monkeypatch.setattr(clock, "neighbours", lambda: False)
    monkeypatch.setattr(clock, "calibrate", lambda: LOOP)
    return watch
