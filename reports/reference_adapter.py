"""The reference behind the interface of an adapter, so that the experiment runs it like any engine.

Its routes are its methods, its ladder is the relative tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import reference
from adapters import Setting
from cases import Case, Trajectory
from reference.solve import prepare

NAME = "reference"
routes = reference.METHODS

# From what a hurried user asks for to the last digit double precision holds.
_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)


@dataclass
class _Model:
    simulate: Callable[[], Trajectory]
    motion: Trajectory | None = None


def refuses(case: Case, route: str) -> str | None:
    """Nothing is refused beforehand: what the reference has no equations for, it says when it is asked."""
    return None


def ladder(case: Case, route: str) -> tuple[Setting, ...]:
    """Relative tolerances from coarse to fine."""
    return tuple(Setting.of(rtol=rtol) for rtol in _TOLERANCES)


def build(case: Case, route: str, setting: Setting) -> _Model:
    """Derive and compile the equations; raises NotSupported for a case without."""
    prepare(case, route, setting["rtol"])
    return _Model(lambda: reference.simulate(case, rtol=setting["rtol"], method=route))


def run(model: _Model) -> None:
    """Integrate."""
    model.motion = model.simulate()


def read(model: _Model) -> Trajectory:
    """The motion, with the transitions the reference located itself."""
    assert model.motion is not None, "read comes after run"
    return model.motion


def version() -> str:
    """The suite's own version: the reference is part of it."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed("slip-to-roll")
    except PackageNotFoundError:
        return "not installed as a package"
