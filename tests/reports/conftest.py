"""What several tests of reports begin with."""

from __future__ import annotations

import pytest

from adapters.processes.worker import CallResult
from reports.running.timing import clock, cold_start, time_breakdown

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
    for module in (clock, cold_start, time_breakdown):
        monkeypatch.setattr(module, "time", watch)
    for module in (clock, cold_start):
        monkeypatch.setattr(module, "calibrate", lambda: LOOP)
    monkeypatch.setattr(clock, "neighbours", lambda: False)
    return watch


@pytest.fixture
def here(watch, monkeypatch) -> Watch:
    """The same; first calls are made in this process."""
    monkeypatch.setattr(
        cold_start, "call_in_copy", lambda function, argument, _: CallResult("done", function(argument))
    )
    return watch
