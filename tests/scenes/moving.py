"""Random scenes with belts, driven tracks, plates that do not turn, friction by slip speed, and own effects, and what
must hold for each of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

import reference
from cases import (
    BadValue,
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
from cases.moving_frame import relative_case
from tests.scenes.motions import in_other_units, mirrored

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


# --- what must hold ---------------------------------------------------------------------------------------------------


def _in_other_units(case: Case) -> Case:
    scales = 2.5, 1.7, 3.1
    own = {effect: effect.in_other_units(*scales) for effect in case.effects if isinstance(effect, Adhesion)}
    other = in_other_units(case, *scales, turn=0.7)
    return replace(other, effects=tuple(own.get(e, e) if isinstance(e, Adhesion) else e for e in other.effects))


def check_invariance(case: Case) -> bool:
    """The mirror image, and the scene turned and in other units, have the same transitions; false if the formulas of
    the turned scene are too long."""
    here = reference.simulate(case, rtol=1e-13)
    for change in (mirrored, _in_other_units):
        try:
            other = change(case)
            relative_case(other)
        except BadValue:
            return False
        there, unit = reference.simulate(other, rtol=1e-13), other.duration / case.duration
        assert there.status == here.status
        assert [t.time / unit for t in there.transitions] == pytest.approx(
            [t.time for t in here.transitions], abs=1e-10
        )
    return True
