"""Names of exudyn's interface that changed between 1.8 and 1.13: the adapter uses the newest, and this file translates.

Each function looks at the installed interface, not at a version number.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item

from ..interface import Refusal

# Until 1.11 a solver that gives up raises one of Python's own exceptions.
ERRORS: tuple[type[Exception], ...] = (
    (exu.ExudynError,) if hasattr(exu, "ExudynError") else (RuntimeError, SystemError, ValueError)
)


def contact_object(name: str) -> Refusal | None:
    """Why one of the engine's contact objects cannot be used, in one sentence, or None."""
    return None if hasattr(item, name) else Refusal(f"Exudyn {exu.__version__} has no {name}.", "its list of items")


def rigid_body(mass: float, inertia: float | list[float]) -> dict[str, Any]:
    """Mass and inertia as keywords of rigid bodies: `physicsMass` and `physicsInertia` until 1.11."""
    if _has(item.ObjectRigidBody2D, "mass"):
        return dict(mass=mass, inertia=inertia)
    return dict(physicsMass=mass, physicsInertia=inertia)


def sphere_radius(radius: float) -> dict[str, float]:
    """A radius as keyword of ObjectContactSphereTriangle: `radiusSphere` until 1.11."""
    return {"sphereRadius" if _has(item.ObjectContactSphereTriangle, "sphereRadius") else "radiusSphere": radius}


def set_output(settings: Any, sensor_period: float) -> None:
    """Write no file, and let sensors store a row per period (s); both settings had other names until 1.11."""
    if hasattr(settings, "solution"):
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = sensor_period
    else:
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = sensor_period


@contextmanager
def quiet() -> Iterator[None]:
    """Turn the engine's console off, then restore it; the switch is global in the process.

    Until 1.11 it cannot be read, and is on afterwards, as by default.
    """
    if not hasattr(getattr(exu, "config", None), "printToConsole"):
        exu.SetWriteToConsole(False)
        try:
            yield
        finally:
            exu.SetWriteToConsole(True)
        return
    before = exu.config.printToConsole
    exu.config.printToConsole = False
    try:
        yield
    finally:
        exu.config.printToConsole = before


def _has(kind: type, keyword: str) -> bool:
    return keyword in inspect.signature(kind).parameters
