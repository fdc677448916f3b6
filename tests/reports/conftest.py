"""What several tests of reports begin with."""

from __future__ import annotations

import pytest

from reports.running.timing import clock

from .loopback import Processes
from .watch import LOOP, Watch


@pytest.fixture
def loopback(tmp_path):
    """A Dask scheduler on loopback, to which a test adds workers."""
    found = Processes(tmp_path)
    yield found
    found.close()


@pytest.fixture
def watch(monkeypatch) -> Watch:
    """The clock of a machine on which nothing else is seen to run, whatever runs."""
    watch = Watch()
    monkeypatch.setattr(clock, "time", watch)
    monkeypatch.setattr(clock, "neighbours", lambda: False)
    monkeypatch.setattr(clock, "calibrate", lambda: LOOP)
    return watch
