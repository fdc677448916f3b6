"""The default method where no method is named: Taylor where heyoka is installed."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True, scope="module")
def default_method() -> None:
    """In place of the fixture of all tests, which has DOP853 integrate."""
