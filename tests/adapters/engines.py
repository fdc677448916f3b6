"""Runs of engines for tests: a motion at a setting of the ladder, and its distance from the reference's."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import adapters
import reference
from adapters import Setting, engine, refusal
from cases import Case, Trajectory


@cache
def routes() -> tuple[tuple[str, str], ...]:
    """Engine and route of all adapters that can be imported here."""
    found = list[tuple[str, str]]()
    for name in adapters.engines():
        try:
            found += [(name, route) for route in engine(name).routes]
        except ImportError:
            continue
    return tuple(found)


def play(name: str, route: str, case: Case, rung: int = -1, setting: Setting | None = None) -> Trajectory:
    """The motion by a route, at a rung of its ladder or another setting; skips the test if the engine is missing."""
    pytest.importorskip(f"adapters.{name}")
    adapter = engine(name)
    reason = refusal(adapter, case, route)
    assert reason is None, reason
    model = adapter.build(case, route, setting or adapter.ladder(case, route)[rung])
    adapter.run(model)
    return adapter.read(model)


def off(case: Case, moved: Trajectory) -> tuple[float, float]:
    """Largest distance of a centre (m) and of an angle (rad) from the reference's, of all plates."""
    true, far, turn = reference.simulate(case, rtol=1e-11), 0.0, 0.0
    for name in true.plate_names:
        own = moved.plate(name) if case.others else moved
        exact = true.plate_columns(name, moved.t) if true.plate_columns else true(moved.t)
        far = max(far, float(np.hypot(own.x - exact.x, own.y - exact.y).max()))
        turn = max(turn, float(np.abs((own.theta - own.theta[0]) - (exact.theta - exact.theta[0])).max()))
    return far, turn
