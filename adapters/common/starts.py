"""The start of every plate, for engines with any number of them."""

from __future__ import annotations

import numpy as np

from cases import Case
from cases.contact import start_motion
from cases.scene.free_plates import POSE


def starts_of(case: Case) -> np.ndarray:
    """(x, y, θ, vx, vy, ω) of every plate at time zero in the fixed frame, shape (plates, 6)."""
    others = [[getattr(other.start, name) for name in POSE] for other in case.others]
    return np.array([start_motion(case)[:6], *others], dtype=float)
