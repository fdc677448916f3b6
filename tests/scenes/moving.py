"""Random scenes with belts, driven tracks, plates that do not turn, friction by slip speed, and own effects, and what
must hold for each of them."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

import reference
from cases import (
    Case,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    Gravity,
    Start,
    Unilateral,
    disc,
)
from cases.library import line

G, R, M = 9.81, 0.1, 1.0
METHODS = pytest.mark.parametrize("method", [*reference.METHODS, "augmented"])
# Tolerance 1e-13 and rounding in a few hundred operations.
EXACT = 1e-12


def on_line(*effects, mu=0.2, duration=2.0, slope=0.0, **start) -> Case:
    """A disc on a line, with friction and these effects."""
    every = (Gravity(G), CoulombFriction(mu), Unilateral(), *effects)
    return Case(line(slope), disc(R, M), every, Start(0.0, **start), duration)


@dataclass(frozen=True)
class Adhesion(ContactEffect):
    """An effect of a user's own: it pulls the plate to the track, brakes slip and rotation, and grows with time."""

    pull: float
    drag: float
    brake: float
    growth: float = 1.0

    def force(self) -> ContactForce:
        """A viscous force, a pull that grows with time, and a couple against the rotation."""
        pull = f"-{self.pull!r}*(1 + {self.growth!r}*t)"
        return ContactForce(f"-{self.drag!r}*slip", pull, f"-{self.brake!r}*omega")

    def in_other_units(self, length: float, time: float, mass: float) -> Adhesion:
        """The same effect for lengths, times and masses in other units."""
        return Adhesion(
            self.pull * mass * length / time**2, self.drag * mass / time, self.brake * mass * length**2 / time,
            self.growth / time,
        )  # fmt: skip
