"""One run of a route for the laws of mechanics, and the scales of its error.

Tolerances. They follow from the rung that is run (the finest but one) and from the case, never from what was measured:

- `kick`, a·h: the velocity that the case's accelerations give within one step of h. Every engine here is at least of
  first order, and a first-order step acts up to one step early or late.
- `loss`, ½ m (a h)²·T/h: what is lost if every step removes a velocity a·h that it had let grow.
- `tilt`: by how much a facet's direction, or the direction a step goes by, is off the curve's: the track's and the
  plate's turn within a step, and 2π over the `vertices` or `facets` where the setting names them.
- `grain`, the force that the rounding of velocities looks like: engines in single precision say so by `ROUNDING`.
- `motion.slip_resolution`: the creep that a solver declares it cannot tell from stick.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import pi
from typing import Any

import numpy as np

from cases import Case, NotSupported, Trajectory
from cases.mechanics import gravity

from ..interface import Setting, other_laws

G = 9.81
# The finest rung is what an engine's own tests look at; the one before costs half and every tolerance follows it.
RUNG = -2
# Polygons of more vertices than this take minutes a run; their ladder is taken to end before them.
MOST_VERTICES = 500


class Unsupported(Exception):
    """The route cannot model the law's scene; the text is the adapter's reason."""


class NotReported(Exception):
    """The route tells nothing of what the law is about; the text says of what. It is neither kept nor broken."""


@dataclass(frozen=True)
class Route:
    """One route of an adapter, `adapter` being a module or anything else with its functions."""

    adapter: Any
    name: str

    def run(self, case: Case) -> LawRun:
        """The motion at the finest rung but one; raises Refused."""
        return _run(self.adapter, self.name, case)


@dataclass(frozen=True, eq=False)
class LawRun:
    """A motion, what was asked and with which setting, and the scales of its error (see the module)."""

    case: Case
    setting: Setting
    motion: Trajectory
    rounding: float  # relative, of the engine's numbers

    @property
    def forces(self) -> tuple[np.ndarray, np.ndarray]:
        """Normal and friction force, N; raises NotTold if the route tells none."""
        for name in ("normal_force", "friction_force"):
            if not np.isfinite(getattr(self.motion, name)).any():
                raise NotReported(f"it tells no {name.replace('_', ' ')}")
        return self.motion.normal_force, self.motion.friction_force

    @property
    def step(self) -> float:
        """The longest step between samples, s."""
        return float(np.max(np.diff(self.motion.t)))

    @property
    def speed(self) -> float:
        """The largest speed of the centre or, by spin, of the outline, m/s."""
        size = float(np.hypot(*self.case.plate.outline.point(0.0)))
        return float(np.max(np.hypot(self.motion.vx, self.motion.vy) + size * np.abs(self.motion.omega)))

    @property
    def bend(self) -> float:
        """The largest curvature of the track that was passed, 1/m."""
        bends = np.abs(self.case.track.curvature(self.motion.xi1))
        return float(bends[np.isfinite(bends)].max(initial=0.0))

    @property
    def acceleration(self) -> float:
        """Gravity and what the track's bend asks for, m/s²."""
        return float(np.hypot(*gravity(self.case))) + self.speed**2 * self.bend

    @property
    def kick(self) -> float:
        """m/s."""
        return self.acceleration * self.step

    @property
    def loss(self) -> float:
        """J."""
        return 0.5 * self.case.plate.mass * self.kick**2 * float(self.motion.t[-1]) / self.step

    @property
    def grain(self) -> float:
        """N: a force read as a difference of velocities over a step, each off by a few roundings."""
        return 10 * self.rounding * self.case.plate.mass * self.speed / self.step

    @property
    def corners(self) -> float:
        """The part of `tilt` that facets have, rad."""
        setting = self.setting
        return sum(2 * pi / float(setting[name]) for name in ("vertices", "facets") if name in setting)

    @property
    def tilt(self) -> float:
        """rad."""
        turn = self.speed * self.bend + float(np.abs(self.motion.omega).max())
        return turn * self.step + self.corners


@lru_cache(maxsize=64)
def _run(adapter, route: str, case: Case) -> LawRun:
    refusal = adapter.refuses(case, route)
    if refusal:
        raise Unsupported(refusal)
    differences = other_laws(adapter, case, route)
    if differences:
        raise Unsupported("; ".join(differences))
    ladder = adapter.ladder(case, route)
    setting = [rung for rung in ladder if rung.get("vertices", 0) <= MOST_VERTICES][RUNG]
    model = adapter.build(case, route, setting)
    try:
        adapter.run(model)
    except NotSupported as refusal:
        raise Unsupported(str(refusal)) from refusal
    return LawRun(case, setting, adapter.read(model), getattr(adapter, "ROUNDING", float(np.finfo(float).eps)))


def hold(law: str, what: str, error, tolerance) -> None:
    """Raises AssertionError, with the law's name, where the error (a number or an array) exceeds its tolerance or is no
    number."""
    error, tolerance = np.broadcast_arrays(np.abs(np.asarray(error, dtype=float)), tolerance)
    not_finite = ~np.isfinite(error - tolerance)
    if not_finite.any():
        raise AssertionError(f"{law}: {what} is no number ({not_finite.sum()} samples of {not_finite.size})")
    bad = error > tolerance
    if bad.any():
        at = int(np.argmax(error - tolerance))
        raise AssertionError(
            f"{law}: {what} is off by {error.flat[at]:.3g}, allowed {tolerance.flat[at]:.3g} ({bad.sum()} samples)"
        )
