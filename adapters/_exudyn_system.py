"""What the two routes of the Exudyn adapter share: an assembled system, and its contact read back from a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from cases import Case, CoulombFriction, Gravity
from cases.contact import start_motion

from .interface import Setting

# What the geometry raises where a plate is nowhere near its track, or beyond where a curve is defined.
LOST = (ValueError, ArithmeticError)


@dataclass(frozen=True)
class Contact:
    """The contact along a run, arrays of one length: parameters, gap (m), slip (m/s), forces on the plate (N).

    Shorter than the run if the plate was lost on the way, for the reason `lost`.
    """

    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    lost: str | None = None


@dataclass(frozen=True)
class System:
    """An assembled system in the container that owns it.

    `motion` are the sensors of pose and velocity, `force` is that of the contact, if there is one; `contact` reads the
    contact from the arrays they store: pose (n, 3), velocity (n, 3), force (n, 3) or (n, 0).
    """

    container: Any
    system: Any
    motion: tuple[int, int]
    force: int | None
    contact: Callable[[np.ndarray, np.ndarray, np.ndarray], Contact]


def node_sensors(system, node: int) -> tuple[int, int]:
    """Sensors that keep a node's coordinates and velocities in memory."""
    pose, velocity = (
        system.AddSensor(item.SensorNode(nodeNumber=node, outputVariableType=kind, storeInternal=True))
        for kind in (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
    )
    return pose, velocity


def friction_coefficient(case: Case) -> float:
    """mu, zero without friction."""
    friction = case.effect(CoulombFriction)
    return friction.mu if friction else 0.0


def critical_damping(case: Case, setting: Setting) -> float:
    """In N s/m, so that the plate settles on the contact's spring without bouncing, in the spring's own time."""
    return 2.0 * sqrt(setting["k"] * case.plate.mass)


def scales(case: Case) -> tuple[float, float]:
    """A length (m; centre of mass to contact) and an acceleration (m/s²) that the rungs are multiples of."""
    start = start_motion(case)
    length = float(np.hypot(*case.plate.outline.point(start.xi2)))
    gravity = case.effect(Gravity)
    speed = max(abs(start.slip), abs(start.omega) * length)
    # Without gravity the motion itself sets the scale; a plate at rest then stays there, at any scale.
    acceleration = gravity.g if gravity and gravity.g > 0.0 else speed**2 / length
    return length, acceleration or 1.0
