"""Scenes of the laws, drawn at random from a seed: no fixed value of a parameter satisfies them by luck.

Each scene draws from a generator of its own (seed and the scene's name), so that one scene does not change another.
Drawn are gravity, friction, restitution, mass, inertia, sizes, offsets of the centre of mass, loads and the start;
times and speeds are multiples of those that gravity and size give, so that a scene shows the same phenomena for each
seed.
Values that a solver could have as a constant (9.81 m/s², μ = 0.1, J = ½ m r²) are not drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, sin, sqrt
from typing import NamedTuple
from zlib import crc32

import numpy as np

from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Load,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    curves,
    disc,
)
from cases.contact import start_motion

LEVEL = Curve(lambda s: (s, 0))


class Draw(NamedTuple):
    """Random values of one scene."""

    random: np.random.Generator

    def between(self, low: float, high: float) -> float:
        """A number in the interval, of four digits."""
        return float(f"{self.random.uniform(low, high):.4g}")

    def signed(self, low: float, high: float) -> float:
        """A number whose magnitude is in the interval, of either sign."""
        return self.between(low, high) * (1.0 if self.random.random() < 0.5 else -1.0)

    def but(self, low: float, high: float, usual: float, near: float) -> float:
        """A number in the interval that is at least `near` away from the usual value."""
        for _ in range(100):
            value = self.between(low, high)
            if abs(value - usual) >= near:
                return value
        raise ValueError(f"all of {low:g} to {high:g} is within {near:g} of {usual:g}")

    def g(self) -> float:
        """A strength of gravity, m/s²."""
        return self.but(4.0, 16.0, 9.81, 1.5)

    def mu(self, low: float = 0.06, high: float = 0.3) -> float:
        """A coefficient of friction."""
        return self.but(low, high, 0.1, 0.02)

    def disc(self, radius: float) -> Plate:
        """A disc of that radius whose inertia is not ½ m r²."""
        mass = self.between(0.5, 4.0)
        return disc(radius, mass, float(f"{self.but(0.3, 0.9, 0.5, 0.08) * mass * radius**2:.4g}"))


def draw(seed: int, key: str) -> Draw:
    """The random values of the scene `key`."""
    return Draw(np.random.default_rng([seed, crc32(key.encode())]))


# --- tracks and plates ------------------------------------------------------------------------------------------------


def incline(angle: float) -> Curve:
    """A straight line that falls to the right by `angle` (rad)."""
    return Curve(lambda s: (s * curves.cos(angle), -s * curves.sin(angle)))


def bowl(radius: float) -> Curve:
    """A circle with the plate inside."""
    return Curve(lambda s: (radius * curves.cos(s), radius * curves.sin(s)))


def hill(radius: float) -> Curve:
    """A circle with the plate outside; the parameter is the angle from the top, clockwise."""
    # With the parameter running that way the plate, on the left, is outside.
    return Curve(lambda s: (radius * curves.sin(s), radius * curves.cos(s)))


def wave(height: float, size: float) -> Curve:
    """y = height cos(2 s/size): a valley if the height is negative, a bump if it is positive."""
    return Curve(lambda s: (s, height * curves.cos(2 * s / size)), domain=(-3 * size, 3 * size))


def off_centre(plate: Plate, x: float, y: float) -> Plate:
    """The disc with its centre of mass at (x, y) from its centre, at the same inertia about the centre of mass."""
    r = plate.radius or 0.0
    return replace(plate, outline=Curve(lambda s: (r * curves.cos(s) - x, r * curves.sin(s) - y)))


def turn_gravity(case: Case, angle: float) -> Case:
    """The case with its track and its gravity turned about the origin."""
    start, gravity = start_motion(case), case.effect(Gravity)
    assert gravity is not None

    def function(s):
        x, y = case.track.at(s)
        return x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle)

    others = tuple(effect for effect in case.effects if effect is not gravity)
    return replace(
        case,
        track=Curve(function, domain=case.track.domain),
        effects=(Gravity(gravity.g, gravity.direction + angle), *others),
        start=replace(case.start, xi2=start.xi2),
    )


# --- scenes with a contact that lasts ---------------------------------------------------------------------------------


def _sliding(d: Draw, track: Curve, plate: Plate, start: Start, duration: float, g: float, *effects) -> Case:
    friction = effects or (CoulombFriction(d.mu()), Unilateral())
    return Case(track, plate, (Gravity(g), *friction), start, duration=float(f"{duration:.4g}"))


def disc_in_circle(d: Draw) -> Case:
    """A disc released on the wall of a circle, slipping."""
    g, size = d.g(), d.between(0.7, 1.4)
    plate, speed = d.disc(d.between(0.08, 0.13) * size), sqrt(g * size / 9.81)
    start = Start(d.between(-2.7, -2.5), slip=d.between(0.2, 0.4) * speed, omega=d.between(2.0, 4.0) * speed / size)
    return _sliding(d, bowl(size), plate, start, sqrt(9.81 * size / g), g)


def ellipse_in_circle(d: Draw) -> Case:
    """An ellipse released on the wall of a circle, slipping."""
    g, size = d.g(), d.between(0.7, 1.4)
    a, mass = d.between(0.18, 0.22) * size, d.between(0.5, 4.0)
    b = float(f"{d.between(0.55, 0.7) * a:.4g}")
    outline = Curve(lambda s: (a * curves.cos(s), b * curves.sin(s)))
    plate = Plate(outline, mass, float(f"{mass * (a * a + b * b) * d.but(0.2, 0.35, 0.25, 0.03):.4g}"))
    start = Start(d.between(-2.7, -2.5), xi2=d.between(-1.3, -1.1), slip=0.3 * sqrt(g * size / 9.81))
    return _sliding(d, bowl(size), plate, start, sqrt(9.81 * size / g), g)


def disc_in_valley(d: Draw) -> Case:
    """A disc released on the flank of a valley, whose curvature changes."""
    g, size = d.g(), d.between(0.8, 1.3)
    plate, speed = d.disc(d.between(0.08, 0.12) * size), sqrt(g * size / 9.81)
    start = Start(d.between(-0.95, -0.8) * size, slip=d.between(0.2, 0.4) * speed, omega=speed / size)
    return _sliding(d, wave(-d.between(0.26, 0.32) * size, size), plate, start, 0.8 * sqrt(9.81 * size / g), g)


# A disc and an ellipse, released on the wall of a circle. In the valley the curvature changes: a solver that
# approximates its tracks by circles fails there.
SCENES: dict[str, Callable[[Draw], Case]] = {
    "disc in a circle": disc_in_circle,
    "ellipse in a circle": ellipse_in_circle,
    "disc in a valley": disc_in_valley,
}


def disc_on_hill(d: Draw) -> Case:
    """A disc that slips near the top of a circle; it does not reach the place where it would leave."""
    g, size = d.g(), d.between(0.8, 1.3)
    plate, time = d.disc(d.between(0.08, 0.12) * size), sqrt(size / g)
    start = Start(d.between(-0.2, -0.1), slip=d.between(0.25, 0.4) * size / time, omega=d.signed(0.5, 1.5) / time)
    return _sliding(d, hill(size), plate, start, 0.8 * time, g)


def disc_on_bump(d: Draw) -> Case:
    """A disc that slips over a bump, whose curvature changes."""
    g, size = d.g(), d.between(0.8, 1.3)
    plate, time = d.disc(d.between(0.08, 0.12) * size), sqrt(size / g)
    start = Start(
        d.between(-0.3, -0.2) * size, slip=d.between(0.45, 0.55) * size / time, omega=d.signed(0.5, 1.5) / time
    )
    return _sliding(d, wave(d.between(0.08, 0.12) * size, size), plate, start, 0.9 * time, g)


def off_centre_disc(d: Draw) -> Case:
    """A disc with its centre of mass off its centre, slipping on an incline in a turned frame."""
    g, radius = d.g(), d.between(0.08, 0.15)
    away, where = d.between(0.08, 0.15) * radius, d.between(0.0, 2 * pi)
    plate = off_centre(d.disc(radius), float(f"{away * cos(where):.4g}"), float(f"{away * sin(where):.4g}"))
    # The centre of mass circles with a tenth of gravity at first. Friction slows a spin of the slip's sign, so the disc
    # stays on its track.
    way = 1.0 if d.random.random() < 0.5 else -1.0
    spin, slip = way * 0.3 * sqrt(g / away), way * d.between(1.0, 2.0) * sqrt(g * radius)
    start = Start(0.0, d.between(-2.2, -1.0), slip=slip, omega=spin)
    case = _sliding(d, incline(d.between(0.05, 0.15)), plate, start, 4 * sqrt(radius / g), g)
    return turn_gravity(case, d.between(0.4, 2.6))


def off_centre_disc_in_valley(d: Draw) -> Case:
    """The disc in a valley, with its centre of mass off its centre."""
    case = disc_in_valley(d)
    away = d.between(0.15, 0.3) * (case.plate.radius or 0.0)
    where = d.between(0.0, 2 * pi)
    plate = off_centre(case.plate, float(f"{away * cos(where):.4g}"), float(f"{away * sin(where):.4g}"))
    # With this parameter the outline's tangent is the track's.
    along = float(case.track.tangent_angle(case.start.xi1)) - pi / 2
    return replace(case, plate=plate, start=replace(case.start, xi2=along))


def _load(d: Draw, force: float, length: float, time: float) -> Load:
    """A load of about that force (N), with every component and every variable."""
    rate, drag = d.between(2.0, 4.0) / time, d.between(0.15, 0.3) * force * time / length
    spring, couple = d.between(0.015, 0.025) * force / length, d.between(0.4, 0.8) * force * length
    return Load(
        fx=f"{d.signed(0.6, 1.0) * force:.4g}*cos({rate:.4g}*t) - {drag:.4g}*vx",
        fy=f"{d.signed(0.6, 1.0) * force:.4g}*sin({rate:.4g}*t + 1) - {spring:.4g}*x",
        moment=f"{couple:.4g}*sin({rate:.4g}*t + theta) - {0.1 * couple * time:.4g}*omega",
    )


def loaded_disc(d: Draw) -> Case:
    """A disc that slips on an incline under a force and a moment that depend on time, place and velocity."""
    g, radius = d.g(), d.between(0.1, 0.2)
    plate, time = d.disc(radius), sqrt(radius / g)
    start = Start(0.0, slip=d.signed(3.0, 4.0) * radius / time, omega=d.signed(0.3, 1.0) / time)
    effects = CoulombFriction(d.mu()), Unilateral(), _load(d, 0.35 * plate.mass * g, radius, time)
    return _sliding(d, incline(d.between(0.1, 0.3)), plate, start, 6 * time, g, *effects)


def loaded_disc_in_valley(d: Draw) -> Case:
    """The disc in a valley under a force and a moment."""
    case = disc_in_valley(d)
    radius, gravity = case.plate.radius or 0.0, case.effect(Gravity)
    assert gravity is not None
    load = _load(d, 0.2 * case.weight, radius, 2 * sqrt(radius / gravity.g))
    return replace(case, effects=(*case.effects, load))


def _breakaway(d: Draw, share: float | None) -> Case:
    g, radius = d.g(), d.between(0.1, 0.2)
    plate, time = d.disc(radius), sqrt(radius / g)
    mu = d.mu(0.12, 0.25)
    # A growing couple: the disc rolls until friction reaches its bound at a quarter to a half of the time.
    most = (mu * (share or 1.0)) * plate.mass * g * (1 + plate.inertia / (plate.mass * radius**2)) * radius
    rate = most / (d.between(2.0, 3.0) * time)
    friction = CoulombFriction(mu, None if share is None else float(f"{mu * share:.4g}"))
    effects = friction, Unilateral(), Load(moment=f"{d.signed(1.0, 1.1) * rate:.4g}*t")
    return _sliding(d, LEVEL, plate, Start(0.0), 7 * time, g, *effects)


def breakaway(d: Draw) -> Case:
    """A disc on a level line that rolls under a growing couple until it slips."""
    return _breakaway(d, None)


def static_friction(d: Draw) -> Case:
    """A disc that rolls under a growing couple until it slips, with a static coefficient above the kinetic one."""
    return _breakaway(d, d.between(1.4, 1.9))


def rough_valley(d: Draw) -> Case:
    """A disc in a valley that never slips."""
    case = disc_in_valley(d)
    kept = tuple(effect for effect in case.effects if not isinstance(effect, CoulombFriction))
    return replace(case, effects=(*kept, PerfectlyRough()), start=replace(case.start, slip=0.0))


def resisted_disc(d: Draw) -> Case:
    """A disc that rolls down an incline against a couple arm·N."""
    g, radius = d.g(), d.between(0.1, 0.2)
    plate, time = d.disc(radius), sqrt(radius / g)
    effects = (
        CoulombFriction(d.mu(0.35, 0.5)),
        Unilateral(),
        RollingResistance(float(f"{d.between(0.02, 0.05) * radius:.4g}")),
    )
    return _sliding(
        d, incline(d.between(0.15, 0.3)), plate, Start(0.0, omega=-d.between(2.0, 3.0) / time), 6 * time, g, *effects
    )


def guided_disc(d: Draw) -> Case:
    """A disc with friction on a bump that also pulls: at the top by more than its weight."""
    case = disc_on_bump(d)
    kept = tuple(effect for effect in case.effects if not isinstance(effect, Unilateral))
    return replace(case, effects=kept, start=replace(case.start, slip=4.5 * case.start.slip))


def thrown_disc(d: Draw) -> Case:
    """A disc in flight under a load."""
    g, radius = d.g(), d.between(0.1, 0.2)
    plate, time = d.disc(radius), sqrt(radius / g)
    start = Start(0.0, slip=d.signed(1.0, 2.0) * radius / time, omega=d.signed(0.5, 1.5) / time, gap=12 * radius)
    start = replace(start, gap_rate=d.between(0.5, 1.0) * radius / time)
    effects = Unilateral(), Flight(), _load(d, 0.4 * plate.mass * g, radius, time)
    return _sliding(d, LEVEL, plate, start, 3 * time, g, *effects)


# Scenes whose equations of motion are checked, in addition to SCENES.
MORE_SCENES: dict[str, Callable[[Draw], Case]] = {
    "disc on a hill": disc_on_hill,
    "disc on a bump": disc_on_bump,
    "off-centre disc": off_centre_disc,
    "off-centre disc in a valley": off_centre_disc_in_valley,
    "loaded disc": loaded_disc,
    "loaded disc in a valley": loaded_disc_in_valley,
    "breakaway": breakaway,
    "static friction": static_friction,
    "rough valley": rough_valley,
    "resisted disc": resisted_disc,
    "guided disc": guided_disc,
    "thrown disc": thrown_disc,
}


def scene(name: str, seed: int = 0) -> Case:
    """The scene of that name, with the values that the seed gives."""
    return (SCENES | MORE_SCENES)[name](draw(seed, name))
