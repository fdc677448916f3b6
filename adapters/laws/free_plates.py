"""Laws of several free plates: momentum and restitution between them, friction, a pile at rest, and a wedge.

Each follows from Newton's and Coulomb's laws in a line or two, given in its docstring, for values that are drawn from
the route's seed. Tolerances are those of `adapters.laws.runs`.
"""

from __future__ import annotations

from math import cos, sin, sqrt, tan

import numpy as np

from cases import (
    Case,
    CoulombFriction,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Pair,
    Plate,
    StartPose,
    Unilateral,
)
from cases.effects import Effect

from .effects import RESTITUTION
from .runs import LawRun, Steps, law
from .scenes import LEVEL, Draw


def _two_discs(
    d: Draw, restitution: float, *friction: CoulombFriction, pair: CoulombFriction | None = None
) -> tuple[Case, float, float, float]:
    """A disc that meets another one in flight, high above the track, and its speed (m/s), the height of both centres
    (m) and the time (s) at which they meet; `pair`: the friction of both discs, if it is not that of the others."""
    radii, g = (d.between(0.08, 0.12), d.between(0.13, 0.2)), d.g()
    first, second = d.disc(radii[0]), d.disc(radii[1])
    gap, speed = d.between(0.4, 0.6) * radii[0], d.signed(1.0, 2.0) * sqrt(g * radii[0])
    meets = gap / abs(speed)
    high = 4.0 * radii[1] + 4.0 * g * meets**2
    spin = 0.0
    if friction:
        # Twice the spin that friction would stop: it slips through the whole impact.
        impulse = abs(speed) / (1.0 / first.mass + 1.0 / second.mass)
        levers = 1.0 / first.mass + 1.0 / second.mass + _lever(first) ** 2 + _lever(second) ** 2
        spin = 2.0 * d.signed(1.0, 1.5) * (pair or friction[0]).mu * impulse * levers / radii[0]
    far = np.sign(speed) * (sum(radii) + gap)
    other = FreePlate(second, StartPose(float(far), high), "second")
    effects: tuple[Effect, ...] = (Gravity(g), Unilateral(), Flight(), Impact(restitution, "moreau"), *friction)
    start = StartPose(0.0, high, vx=speed, omega=spin)
    pairs = (Pair("second/plate", (pair,)),) if pair else ()
    return Case(LEVEL, first, effects, start, 1.8 * meets, others=(other,), pairs=pairs), speed, high, meets


def _lever(plate: Plate) -> float:
    """r/√J, 1/√kg."""
    return (plate.radius or 0.0) / sqrt(plate.inertia)


def _velocities_after(run: LawRun, time: float) -> list[tuple[float, float, float]]:
    """(vx, vy, ω) of both plates, the means of the samples after a time (s)."""
    after = run.motion.t > time
    plates = (run.motion, run.motion.plate("second"))
    return [tuple(float(getattr(own, name)[after].mean()) for name in ("vx", "vy", "omega")) for own in plates]  # type: ignore[misc]


@law("collision of free plates")
def collision_of_free_plates(d: Draw) -> Steps:
    """A disc meets another in flight without friction: their momentum stays, and they part with e times the speed."""
    case, speed, high, meets = _two_discs(d, d.but(0.3, 0.8, 0.5, 0.05))
    run, impact = (yield case), case.effect(Impact)
    assert impact is not None
    masses = case.plate.mass, case.others[0].plate.mass
    # An impact may take some periods of a spring.
    middle = 0.5 * (meets + float(run.motion.t[-1]))
    (first, _, spin), (second, _, other_spin) = _velocities_after(run, max(meets + 2 * run.step, middle))
    suspect = "the reaction on the other plate, or the mass of each"
    momentum = masses[0] * first + masses[1] * second - masses[0] * speed
    tolerance = (10 * run.rounding * len(run.motion.t) ** 0.5 + 1e-9) * sum(masses) * abs(speed)
    yield "the momentum", momentum, tolerance, suspect
    parting, exact = np.sign(speed) * (second - first), impact.restitution * abs(speed)
    suspect = f"restitution of Impact: {parting / abs(speed):.4g} would fit, the case has {impact.restitution:g}"
    yield "the speed of parting", parting - exact, 2 * RESTITUTION * abs(speed), suspect
    spins = max(abs(spin), abs(other_spin)) * case.plate.reach
    yield "a spin", spins, RESTITUTION * abs(speed), "friction where the case has none"
    fall = run.motion.plate("second").y - high + 0.5 * _gravity(case) * run.motion.t**2
    yield "y of the second plate", fall, run.kick * run.motion.t[-1], "its start, or g"


def _gravity(case: Case) -> float:
    """The strength of gravity, m/s²."""
    gravity = case.effect(Gravity)
    assert gravity is not None, "the scenes have gravity"
    return gravity.g


@law("friction of free plates")
def friction_of_free_plates(d: Draw) -> Steps:
    """A spinning disc meets another in flight: friction takes μ of the impulse, with opposite forces on both."""
    mu = d.mu(0.1, 0.3)
    yield from _friction(mu, *_two_discs(d, 0.0, CoulombFriction(mu)))


@law("friction of a pair")
def friction_of_a_pair(d: Draw) -> Steps:
    """The same of two materials with a coefficient of their own: it is that of the pair, not a mean or a product of
    those of both discs against other bodies."""
    mu = d.mu(0.1, 0.3)
    yield from _friction(mu, *_two_discs(d, 0.0, CoulombFriction(0.4 * mu), pair=CoulombFriction(mu)))


def _friction(mu: float, case: Case, speed: float, high: float, meets: float) -> Steps:
    run = yield case
    plates = case.plate, case.others[0].plate
    impulse = abs(speed) / (1.0 / plates[0].mass + 1.0 / plates[1].mass)
    (_, up, spin), (_, other_up, other_spin) = _velocities_after(run, meets + 2 * run.step)
    along = -np.sign(case.start.omega)
    fit = plates[0].inertia * along * (spin - case.start.omega) / ((plates[0].radius or 1.0) * impulse)
    suspect = f"mu of CoulombFriction between the plates: {fit:.4g} would fit, the case has {mu:g}"
    # The direction of the contact turns if one plate falls a step longer than the other.
    tolerance = RESTITUTION * mu + run.kick * run.step / (case.plate.reach + plates[1].reach)
    yield "the impulse on the first spin over the normal one", fit - mu, tolerance, suspect
    other = plates[1].inertia * along * other_spin / ((plates[1].radius or 1.0) * impulse)
    suspect = "the reaction on the other plate, or the inertia of each"
    yield "the impulse on the second spin over the normal one", other - mu, tolerance, suspect
    # The forces are opposite: the sum of m vy is gravity's.
    falls = plates[0].mass * up + plates[1].mass * other_up
    after = run.motion.t[run.motion.t > meets + 2 * run.step]
    exact = -(plates[0].mass + plates[1].mass) * _gravity(case) * float(after.mean())
    grain = (plates[0].mass + plates[1].mass) * run.kick
    yield "the momentum along gravity", falls - exact, grain, suspect


@law("row of free plates")
def row_of_free_plates(d: Draw) -> Steps:
    """Equal discs in a row on a floor, some way apart, e = 1, without friction: each passes its speed on."""
    radius, g = d.between(0.08, 0.15), d.g()
    plate, gap, speed = d.disc(radius), d.between(0.3, 0.5) * radius, d.signed(1.0, 2.0) * sqrt(g * radius)
    way = np.sign(speed) * (2.0 * radius + gap)
    others = tuple(
        FreePlate(plate, StartPose(float(number * way), radius), name)
        for number, name in enumerate(("second", "third"), start=1)
    )
    effects = Gravity(g), Unilateral(), Flight(), Impact(1.0, "moreau")
    start = StartPose(0.0, radius, vx=speed)
    run = yield Case(LEVEL, plate, effects, start, duration=4.0 * gap / abs(speed), others=others)
    for name, share in zip(run.motion.plate_names, (0.0, 0.0, 1.0), strict=True):
        off = float(run.motion.plate(name).vx[-1]) - share * speed
        yield f"vx of {name}", off, 3 * RESTITUTION * abs(speed), "restitution of Impact"


@law("pile of free plates")
def pile_of_free_plates(d: Draw) -> Steps:
    """Two discs that touch and one on both rest if μ is above 2 − √3."""
    radius, g = d.between(0.08, 0.15), d.g()
    plate, mu = d.disc(radius), d.between(0.45, 0.6)
    others = (
        FreePlate(plate, StartPose(2.0 * radius, radius), "second"),
        FreePlate(plate, StartPose(radius, (1.0 + sqrt(3.0)) * radius), "upper"),
    )
    effects = Gravity(g), Unilateral(), Flight(), Impact(0.0, "moreau"), CoulombFriction(mu)
    start = StartPose(0.0, radius)
    run = yield Case(LEVEL, plate, effects, start, duration=6.0 * sqrt(radius / g), others=others)
    # A step's fall, what engines leave of overlap, and as much for each of the steps in which contacts settle.
    tolerance = 10.0 * run.kick * run.step + 2e-3 * radius
    for name in run.motion.plate_names:
        own = run.motion.plate(name)
        off = np.hypot(own.x - own.x[0], own.y - own.y[0])
        yield f"the way of {name}", off, tolerance, "mu of CoulombFriction between the plates"


@law("wedge of free plates")
def wedge_of_free_plates(d: Draw) -> Steps:
    """A disc slides without friction down a wedge that gives way: the wedge has the acceleration
    m g sin α cos α/(M + m sin²α) and does not turn."""
    radius, g, slope = d.between(0.08, 0.12), d.g(), d.between(0.35, 0.6)
    plate, width, mass = d.disc(radius), d.between(0.9, 1.3), d.between(0.5, 1.5)
    wedge = Plate.polygon([(0.0, 0.0), (width, 0.0), (0.0, width * tan(slope))], mass * plate.mass)
    start = StartPose(0.25 * width + radius * sin(slope), 0.75 * width * tan(slope) + radius * cos(slope))
    other = FreePlate(wedge, StartPose(width / 3.0, width * tan(slope) / 3.0), "wedge")
    share = 1.0 / (mass + sin(slope) ** 2)
    # A quarter of the slope, of which the disc has three.
    duration = sqrt(0.5 * width / cos(slope) / (g * sin(slope) * (mass + 1.0) * share))
    effects = Gravity(g), Unilateral(), Flight(), Impact(0.0, "moreau")
    run = yield Case(LEVEL, plate, effects, start, duration=duration, others=(other,))
    own, rate = run.motion.plate("wedge"), -g * sin(slope) * cos(slope) * share
    suspect = "the corners or the mass of the polygon, or g"
    yield "vx of the wedge", own.vx - rate * run.motion.t, 2.0 * run.kick, suspect
    turns = width * own.theta
    yield "the turn of the wedge", turns, run.kick * run.step + 1e-3 * radius, suspect
