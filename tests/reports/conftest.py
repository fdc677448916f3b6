"""What several tests of reports begin with."""

from __future__ import annotations

import pytest

from .loopback import Processes


@pytest.fixture
def loopback(tmp_path):
    """A Dask scheduler on loopback, to which a test adds workers."""
    found = Processes(tmp_path)
    yield found
    found.close()
