"""Random scenes with belts, driven tracks, plates that do not turn, friction by slip speed, and own effects, and what
must hold for each of them."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count
from math import inf, pi

import numpy as np
import pytest

import reference
from cases import (
    BadValue,
    Belt,
    Case,
    CaseError,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases.curves import cos
from cases.library import circle, ellipse, line
from cases.moving_frame import relative_case
from tests.scenes.motions import energy, in_other_units, mirrored, work_done
from tests.scenes.slip_laws import random_law

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


# --- random scenes ----------------------------------------------------------------------------------------------------


def _belt_speed(chance: random.Random) -> str:
    def between(low, high):
        return chance.uniform(low, high)

    return chance.choice(
        [
            f"{between(-2, 2):.3f}",
            f"{between(-1, 1):.3f} + {between(0.1, 1):.3f}*sin({between(1, 8):.2f}*t)",
            f"{between(-1, 1):.3f}*tanh({between(1, 30):.2f}*(t - 0.3))",
        ]
    )


def _on_belt(chance: random.Random) -> Case:
    """A disc or an ellipse on a belt along a circle, a slope or a wave, in contact or landing."""

    def between(low, high):
        return chance.uniform(low, high)

    r, kind = between(0.05, 0.2), chance.choice(["circle", "bottom", "line", "slope", "wave"])
    track = {"line": line(), "slope": line(between(-0.3, 0.3))}.get(kind, circle(1.0))
    if kind == "wave":
        track = Curve(lambda s: (s, -0.3 * cos(2 * s)), domain=(-3, 3))
    round_plate = chance.random() < 0.6
    plate = (
        disc(r, 1.0) if round_plate else Plate(ellipse(r, r * between(0.6, 0.95)), 1.0, 0.5 * r * r * between(0.4, 1))
    )
    friction = CoulombFriction(between(0.05, 0.8)) if chance.random() < 0.85 else PerfectlyRough()
    effects = [Gravity(G), friction, Belt(_belt_speed(chance))]
    if chance.random() < 0.7:
        effects.append(Unilateral())
    if chance.random() < 0.3:
        effects.append(Load(fx=f"{between(-1, 1):.2f}*vx + {between(-1, 1):.2f}*sin(3*t)"))
    bounces = Unilateral() in effects and chance.random() < 0.6
    if bounces:
        effects += [Flight(), Impact(chance.choice([0.0, 0.3, 0.6]), chance.choice(["poisson", "moreau"]))]
    width = {"circle": 1.2, "bottom": 0.5}.get(kind)
    xi1 = -pi / 2 + between(-width, width) if width else between(-1, 1)
    slip = 0.0 if isinstance(friction, PerfectlyRough) else chance.choice([0.0, between(-1, 1)])
    lift = dict(gap=between(0, 0.1), gap_rate=between(-1, 1)) if bounces and chance.random() < 0.4 else {}
    xi2 = None if round_plate else between(0.0, 2 * pi)
    return Case(track, plate, tuple(effects), Start(xi1, xi2, slip=slip, omega=between(-3, 3), **lift), 1.5)


def _without(case: Case, *kinds: type) -> tuple:
    return tuple(effect for effect in case.effects if not isinstance(effect, kinds))


def _still(case: Case) -> Case:
    """The case with a plate that does not turn."""
    effects = _without(case, RollingResistance)
    start = replace(case.start, omega=0.0)
    return Case(case.track, replace(case.plate, inertia=inf), effects, start, case.duration)


def _fixed(chance: random.Random) -> Case:
    case = _on_belt(chance)
    return _still(case if chance.random() < 0.5 else replace(case, effects=_without(case, Belt)))


def _driven(chance: random.Random) -> Case:
    """On a track that is shaken, accelerated and turned."""

    def between(low, high):
        return chance.uniform(low, high)

    case, turns = _on_belt(chance), chance.random() < 0.8
    x = chance.choice([f"{between(-0.1, 0.1):.3f}*sin({between(1, 12):.2f}*t)", f"{between(-0.5, 0.5):.3f}*t**2", "0"])
    y = chance.choice([f"{between(-0.05, 0.05):.3f}*cos({between(1, 12):.2f}*t)", "0"])
    angle = chance.choice([f"{between(-0.5, 0.5):.3f}*sin({between(1, 6):.2f}*t)", f"{between(-0.3, 0.3):.3f}*t", "0"])
    effects = case.effects if chance.random() < 0.4 else _without(case, Belt)
    with_belt = any(isinstance(e, Belt) for e in effects)
    if turns and not with_belt and chance.random() < 0.3:
        effects = (*effects, RollingResistance(0.005))
    case = replace(case, effects=effects)
    case = case if turns else _still(case)
    return replace(case, effects=(*case.effects, Drive(x, y, angle if turns else "0")))


def _by_slip_speed(chance: random.Random) -> Case:
    """Friction by a formula of the slip speed, on a belt, on a driven track or with a plate that does not turn."""
    case = chance.choice([_on_belt, _driven, _fixed])(chance)
    law = random_law(np.random.default_rng(chance.randrange(2**32)))
    start = replace(case.start, gap=0.0, gap_rate=0.0)
    effects = (*_without(case, CoulombFriction, PerfectlyRough, Impact), law)
    return Case(case.track, case.plate, effects, start, case.duration)


def _with_own_effect(chance: random.Random) -> Case:
    """An effect of a user's own with each of the others."""
    case = chance.choice([_on_belt, _driven, _fixed, _by_slip_speed])(chance)
    brake = chance.uniform(0.0, 0.005) if case.plate.turns else 0.0
    return replace(case, effects=(*case.effects, Adhesion(chance.uniform(0.0, 6.0), chance.choice([0.0, 0.3]), brake)))


FAMILIES = {
    "belts": _on_belt,
    "driven tracks": _driven,
    "plates that do not turn": _fixed,
    "friction by slip speed with the others": _by_slip_speed,
    "effects of a user's own with the others": _with_own_effect,
}


def random_scenes(family: str, seed: int, number: int) -> Iterator[Case]:
    """Admissible scenes of a family, each from its own seed, so that one of them can be repeated alone."""
    for place in count():
        if number == 0:
            return
        try:
            case = FAMILIES[family](random.Random(f"{family} {seed} {place}"))
            relative_case(case)
        except CaseError:  # the plate does not fit there, or the scene has no effect of its family left
            continue
        number -= 1
        yield case


# --- what must hold ---------------------------------------------------------------------------------------------------


def check_work(case: Case) -> None:
    """The energy that a motion without impact gains is the work of friction, belt, drive and load."""
    motion = reference.simulate(case, rtol=1e-13)
    times = np.linspace(motion.t[0], motion.t[-1], 200)
    gained = energy(case, motion(float(motion.t[-1]))) - energy(case, motion(0.0))
    scale = np.ptp(energy(case, motion(times))) + np.max(np.hypot(motion.vx, motion.vy)) ** 2 * case.plate.mass
    assert abs(gained - work_done(case, motion)) <= 1e-10 * scale, case


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
