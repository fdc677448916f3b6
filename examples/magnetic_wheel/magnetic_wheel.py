"""A wheel that a magnet pulls to its track: a normal force, and a couple against the rotation by eddy currents."""

from dataclasses import dataclass
from math import pi

from cases import (
    BadValue,
    Case,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    EndCondition,
    Gravity,
    Start,
    Unilateral,
    case,
    disc,
)
from cases.library import circle


@dataclass(frozen=True)
class Magnet(ContactEffect):
    """A magnet in the wheel pulls it to the track with `pull` (N); eddy currents brake its rotation with `brake` times
    the spin (N m s). Above the spin `fastest` (rad/s) the motion ends."""

    pull: float
    brake: float = 0.0
    fastest: float = 1000.0

    laws = ("magnetic_wheel_laws:magnet_braking",)

    def __post_init__(self):
        if self.pull < 0.0 or self.brake < 0.0:
            raise BadValue(f"pull and brake of Magnet are {self.pull:g} and {self.brake:g}; give zero or more")

    def force(self) -> ContactForce:
        """The track is on the right of its direction, so the pull is along the negative normal."""
        return ContactForce(across=-self.pull, couple=f"-{self.brake!r}*omega")

    def ends(self) -> tuple[EndCondition, ...]:
        """The motion ends where the spin reaches its limit."""
        limit = f"{self.fastest!r}**2 - omega**2"
        return (EndCondition("too_fast", limit, "The spin reached the limit of the magnet."),)


@case
def magnetic_wheel_in_loop(pull=60.0, brake=0.0, mu=0.5, speed=3.0, R=1.0, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A wheel on the inside of a loop: the magnet holds it where it would fall without one.

    Why: an effect of another package, with a normal force that gravity alone does not give.
    Source: posed here.
    Known exactly: without a brake it rolls like a pendulum, whatever the pull.
    """
    effects = (Gravity(g), CoulombFriction(mu), Magnet(pull, brake), Unilateral())
    return Case(circle(R), disc(r, m), effects, Start(xi1=-pi / 2, omega=-speed / r), duration)
