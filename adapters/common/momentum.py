"""Whether a track pushes a plate, from the change of its momentum alone, for motions that come without forces."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np

from cases import Case
from cases.motion.mechanics import gravity, loads
from cases.own_effects import own_effects

# A contact force below this part of the usual one is none, or below some times the force that a motion has where it
# certainly flies: an engine's damping and printed digits.
NO_FORCE, NOISE = 1e-4, 4.0


def push(case: Case, columns: Mapping[str, np.ndarray], far: np.ndarray, from_differences: bool) -> np.ndarray:
    """Which samples lie within a contact that lasts, shape (n,); all for a law of the user's own, whose force is known
    in contact only. `far`: the samples that are certainly in flight.

    A sample counts if there is a contact force in each step next to it: an impact alone, of one step, does not. If
    velocities are central differences, `from_differences`, a jump reaches one step further to either side.
    """
    if own_effects(case.effects):
        return np.ones(len(far), dtype=bool)
    external = case.plate.mass * gravity(case)[:, None] + loads(case, SimpleNamespace(**columns))[:2]
    steps = _contact_force(case, columns, external)
    usual = max(float(np.median(steps)), float(np.median(np.hypot(*external))))
    in_flight = steps[far[1:] & far[:-1]]
    noise = float(np.median(in_flight)) if len(in_flight) else 0.0
    pushing = steps > max(NO_FORCE * usual, NOISE * noise)
    width = 2 if from_differences else 1
    around = np.concatenate([np.ones(width, dtype=bool), pushing, np.ones(width, dtype=bool)])
    return np.asarray(np.lib.stride_tricks.sliding_window_view(around, 2 * width).all(axis=1))


def _contact_force(case: Case, columns: Mapping[str, np.ndarray], external: np.ndarray) -> np.ndarray:
    """The mean contact force in each step, shape (n − 1,), N; `external`: gravity and load at the samples, (2, n)."""
    velocity = np.array([columns["vx"], columns["vy"]])
    change = case.plate.mass * np.diff(velocity, axis=1) / np.diff(columns["t"])
    return np.hypot(*(change - 0.5 * (external[:, 1:] + external[:, :-1])))
