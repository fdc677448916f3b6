"""What a case can ask for. An effect is data only: what it means is written once in each solver.

SI units, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from .errors import BadValue, finite, not_negative


@dataclass(frozen=True)
class Gravity:
    """Uniform gravity of strength `g` (m/s²), pulling along the angle `direction` of the fixed frame (default: −Y)."""

    g: float
    direction: float = -pi / 2

    def __post_init__(self):
        object.__setattr__(self, "g", not_negative("g of Gravity", self.g))
        object.__setattr__(self, "direction", finite("direction of Gravity", self.direction))


@dataclass(frozen=True)
class CoulombFriction:
    """Dry friction: |T| = mu·N against the slip velocity, |T| ≤ mu_static·N without slip (mu_static=None: mu)."""

    mu: float
    mu_static: float | None = None

    def __post_init__(self):
        object.__setattr__(self, "mu", not_negative("mu of CoulombFriction", self.mu))
        if self.mu == 0.0:
            raise BadValue("mu of CoulombFriction is 0; leave CoulombFriction out for a scene without friction")
        if self.mu_static is not None:
            object.__setattr__(self, "mu_static", not_negative("mu_static of CoulombFriction", self.mu_static))
            if self.mu_static < self.mu:
                raise BadValue(
                    f"mu_static of CoulombFriction is {self.mu_static:g}, below mu = {self.mu:g}; give at least mu"
                )

    @property
    def stick(self) -> float:
        """The coefficient that bounds friction without slip."""
        return self.mu if self.mu_static is None else self.mu_static


@dataclass(frozen=True)
class Unilateral:
    """The track pushes and never pulls: the motion ends (lift-off) where the normal force would change sign."""


Effect = Gravity | CoulombFriction | Unilateral
