"""Laws of further effects: load, impact, rough contact, bilateral guide, rolling resistance, belt, driven track.

Each follows from Newton's laws in a line or two, given in its docstring, for values that are drawn from the route's
seed. `OF_EFFECT` lists the laws that check each effect, so that no adapter claims an effect without a check. Tolerances
are those of `adapters.laws.runs`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import cos, exp, inf, log, sin, sqrt
from typing import NamedTuple

import numpy as np

from cases import (
    Belt,
    Case,
    CoulombFriction,
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
)
from cases.contact import start_motion

from .runs import Check, LawRun, Steps, law
from .scenes import LEVEL, Draw, hill, incline

# Engines whose impacts are contact forces have their restitution to a hundredth, according to their manuals.
RESTITUTION = 1e-2


def _disc(d: Draw) -> tuple[Plate, float, float, float]:
    """A disc, its radius, a strength of gravity, and the time in which it falls by half of its radius."""
    radius, g = d.between(0.08, 0.15), d.g()
    return d.disc(radius), radius, g, sqrt(radius / g)


@law("load")
def load(d: Draw) -> Steps:
    """A frictionless disc on a level line: m v̇ = F − c v, so v = F/c + (v₀ − F/c) exp(−c t/m); J ω̇ = M sin(w t)."""
    plate, radius, g, time = _disc(d)
    duration = 10 * time
    drag, rate = d.between(0.3, 1.0) * plate.mass / duration, d.between(3.0, 5.0) / duration
    initial, push = d.signed(5.0, 9.0) * radius / time, d.signed(0.05, 0.15) * plate.mass * g
    moment = d.signed(0.05, 0.15) * plate.mass * g * radius
    force = Load(fx=f"{push!r} - {drag!r}*vx", moment=f"{moment!r}*sin({rate!r}*t)")
    run = yield Case(LEVEL, plate, (Gravity(g), force, Unilateral()), Start(0.0, slip=initial), duration=duration)
    t = run.motion.t
    # Forces act up to a step early or late.
    tolerance = 2.0 * run.step + 10 * run.rounding * len(t) ** 0.5 + 1e-9
    final = push / drag
    exact = final + (initial - final) * np.exp(-drag * t / plate.mass)
    most = (drag * abs(initial) + abs(push)) / plate.mass
    yield "vx", run.motion.vx - exact, tolerance * most, "fx of Load, mass of the plate"
    exact = moment / (plate.inertia * rate) * (1 - np.cos(rate * t))
    suspect = "moment of Load, inertia of the plate"
    yield "omega", run.motion.omega - exact, tolerance * abs(moment) / plate.inertia, suspect


@law("friction by speed")
def friction_by_speed(d: Draw) -> Steps:
    """A disc that slides with μ = a + b exp(−v/w): u = exp(v/w) obeys u̇ = −k (a u + b), k = g (1 + m r²/J)/w."""
    plate, radius, g, time = _disc(d)
    a, b, width = d.mu(0.06, 0.2), d.between(0.2, 0.4), d.between(0.2, 0.6) * radius / time
    slip = d.signed(3.0, 5.0) * width
    lever = plate.mass * radius / plate.inertia
    rate = g * (1 + lever * radius) / width
    first = exp(abs(slip) / width)
    # Up to a tenth of the width before it rolls.
    duration = log((first + b / a) / (exp(0.1) + b / a)) / (rate * a)
    friction = CoulombFriction(f"{a!r} + {b!r}*exp(-v/{width!r})")
    run = yield Case(LEVEL, plate, (Gravity(g), friction, Unilateral()), Start(0.0, slip=slip), duration)
    exact = width * np.log((first + b / a) * np.exp(-rate * a * run.motion.t) - b / a)
    # Friction acts up to a step early or late, by the largest coefficient; until then its change has grown as the
    # difference of two slip speeds does, by the ratio of their rates at most.
    tolerance = (a + b) * run.kick * (1 + lever * radius) * (a + b) / a + 1e-9
    suspect = "mu of CoulombFriction as a formula of v: a coefficient, the width of the exponential, or the unit of v"
    yield "the slip", np.sign(slip) * run.motion.slip - exact, tolerance, suspect


class Drop(NamedTuple):
    """A disc that falls on a level line, and the time (s) and speed (m/s) at which it meets the line."""

    case: Case
    time: float
    speed: float
    g: float


def _drop(d: Draw, restitution: float, mu: float, spin: float, after: float) -> Drop:
    """A disc that falls with the spin (rad/s) times √(g/r); the case ends `after` (in v/g) the impact."""
    plate, radius, g, time = _disc(d)
    friction = (CoulombFriction(mu),) if mu else ()
    effects = (Gravity(g), *friction, Unilateral(), Flight(), Impact(restitution))
    gap, rate, omega = d.between(1.5, 2.5) * radius, d.signed(0.2, 0.5) * radius / time, spin / time
    start = Start(0.0, slip=radius * omega, omega=omega, gap=gap, gap_rate=rate)
    speed = sqrt(2 * g * gap + rate**2)
    meets = (speed + rate) / g
    return Drop(Case(LEVEL, plate, effects, start, duration=meets + after * speed / g), meets, speed, g)


@law("bounce")
def bounce(d: Draw) -> Steps:
    """A disc that meets a level line at the speed v rises to e² v²/(2 g)."""
    restitution = d.but(0.3, 0.8, 0.5, 0.05)
    case, time, speed, g = _drop(d, restitution, 0.0, 0.0, 1.5 * restitution)
    run = yield case
    after = run.motion.t > time + 2 * run.step + 0.1 * restitution * speed / g
    top, exact = float(run.motion.y[after].max()) - (case.plate.radius or 0.0), (restitution * speed) ** 2 / (2 * g)
    tolerance = 2 * restitution * speed * run.kick / g + 2 * RESTITUTION * exact

    def suspect() -> str:
        return (
            f"restitution of Impact: {sqrt(max(2 * g * top, 0.0)) / speed:.4g} would fit, the case has {restitution:g}"
        )

    yield "the height", top - exact, tolerance, suspect


@law("bounce with friction")
def bounce_with_friction(d: Draw) -> Steps:
    """A spinning disc that slips through its impact: friction takes μ of the impulse, so v_t grows by μ (1 + e) v_n."""
    restitution, mu = d.but(0.3, 0.8, 0.5, 0.05), d.mu(0.06, 0.2)
    case, time, speed, g = _drop(d, restitution, mu, d.signed(5.0, 7.0), 1.5 * restitution)
    run = yield case
    after = run.motion.t > time + 2 * run.step + 0.1 * restitution * speed / g
    impulse = mu * (1 + restitution) * speed
    suspect = "mu of CoulombFriction, restitution of Impact: friction takes mu of the impulse of both phases"
    yield from _spin(run, after, impulse, RESTITUTION * impulse, suspect)


@law("landing")
def landing(d: Draw) -> Steps:
    """A spinning disc that stays where it lands: v_t grows by μ v_n in the impact, and by μ g t from then on."""
    mu = d.mu(0.06, 0.2)
    case, time, speed, g = _drop(d, 0.0, mu, d.signed(5.0, 7.0), 0.9)
    run = yield case
    after = run.motion.t > time + 2 * run.step + 0.1 * speed / g
    growth = mu * (speed + g * (run.motion.t[after] - time))
    suspect = "mu of CoulombFriction, in the impact or after it; g of Gravity; restitution of Impact (0)"
    yield from _spin(run, after, growth, RESTITUTION * mu * speed, suspect)


def _spin(run: LawRun, after: np.ndarray, growth, tolerance: float, suspect: str) -> Iterator[Check]:
    """Check the velocity along the line and the spin after an impact: friction's impulse changes both."""
    tolerance += run.kick
    initial, plate = start_motion(run.case), run.case.plate
    exact = -np.sign(initial.omega) * growth
    yield "vx", run.motion.vx[after] - initial.vx - exact, tolerance, suspect
    ratio = plate.mass * (plate.radius or 0.0) / plate.inertia
    suspect = f"inertia of the plate, {suspect}"
    yield "the spin", run.motion.omega[after] - initial.omega - ratio * exact, ratio * tolerance, suspect


@law("perfectly rough")
def perfectly_rough(d: Draw) -> Steps:
    """A disc rolls down a steep incline, whatever friction that takes: (m + J/r²) v̇ = m g sin."""
    plate, radius, g, time = _disc(d)
    angle, duration = d.between(1.0, 1.3), 5 * time
    run = yield Case(incline(angle), plate, (Gravity(g), PerfectlyRough(), Unilateral()), Start(0.0), duration)
    growth = g * sin(angle) / (1 + plate.inertia / (plate.mass * radius**2))
    motion, creep = run.motion, run.motion.slip_resolution
    yield "the end of the motion", float(motion.t[-1]) - duration, 2 * run.step
    suspect = "PerfectlyRough, inertia of the plate, g of Gravity"
    spin = motion.omega + growth * motion.t / radius
    yield "the spin", spin, (run.kick + creep) / radius, suspect
    most = 2 * creep + run.kick * (1 + plate.mass * radius**2 / plate.inertia)
    yield "the slip", motion.slip, most, "PerfectlyRough"


@law("guide")
def guide(d: Draw) -> Steps:
    """A track that also pulls keeps a frictionless disc where it would lift off: N = m g (3 cos φ − 2 cos φ₀)."""
    plate, radius, g, _ = _disc(d)
    initial, size = d.between(0.18, 0.25), d.between(0.8, 1.2)
    length = size + radius
    duration = 3.5 * sqrt(length / g)
    run = yield Case(hill(size), plate, (Gravity(g),), Start(initial), duration=duration)
    motion = run.motion
    suspect = "Unilateral, which this case does not have: the track also pulls"
    yield "the end of the motion", float(motion.t[-1]) - duration, 2 * run.step, suspect
    angle = np.arctan2(motion.x, motion.y)
    speed = np.sqrt(2 * g * length * np.maximum(cos(initial) - np.cos(angle), 0.0))
    yield "the speed", np.hypot(motion.vx, motion.vy) - speed, 2 * run.kick, "g of Gravity"
    exact = plate.mass * g * (3 * np.cos(angle) - 2 * cos(initial))
    if exact.min() > -0.5 * plate.mass * g:
        raise AssertionError("guide: the disc does not reach the part where the track has to pull")
    # The first force may belong to the time before the motion; an error `kick` of the speed is one of the force.
    tolerance = 4 * plate.mass * run.kick * speed[1:] / length + plate.mass * run.kick + run.grain
    yield "the normal force", run.forces[0][1:] - exact[1:], tolerance, "the sign of the normal force, mass"


@law("rolling resistance")
def rolling_resistance(d: Draw) -> Steps:
    """A disc that rolls on a level line against a couple a·N: (m + J/r²) v̇ = −m g a/r, until it rests."""
    plate, radius, g, time = _disc(d)
    arm, duration = float(f"{d.between(0.01, 0.03) * radius:.4g}"), 8 * time
    deceleration = g * arm / (radius**2 * (1 + plate.inertia / (plate.mass * radius**2)))
    # It does not come to rest.
    initial = d.signed(1.2, 2.0) * deceleration * duration
    effects = (Gravity(g), CoulombFriction(d.mu(0.3, 0.6)), RollingResistance(arm), Unilateral())
    run = yield Case(LEVEL, plate, effects, Start(0.0, omega=initial), duration=duration)
    exact = initial - np.sign(initial) * deceleration * run.motion.t
    # The couple acts up to a step early or late, and a rolling disc may creep.
    tolerance = (
        2 * deceleration * run.step
        + (run.motion.slip_resolution + 10 * run.rounding * run.speed * len(exact) ** 0.5) / radius
    )
    slowed = abs(initial) - float(np.abs(run.motion.omega[-1]))
    suspect = (
        f"arm of RollingResistance: {arm * slowed / (deceleration * duration):.4g} would fit, the case has {arm:g}"
    )
    yield "the spin", run.motion.omega - exact, tolerance + 1e-9, suspect


@law("belt")
def belt(d: Draw) -> Steps:
    """A disc set down on a conveyor: m v̇ = μ m g until it rolls on it, at t = b/(μ g (1 + m r²/J)); then v stays."""
    plate, radius, g, time = _disc(d)
    mu, speed = d.mu(0.1, 0.4), d.signed(2.0, 4.0) * radius / time
    grip = 1 + plate.mass * radius**2 / plate.inertia
    rolls = abs(speed) / (mu * g * grip)
    effects = (Gravity(g), CoulombFriction(mu), Belt(speed), Unilateral())
    run = yield Case(LEVEL, plate, effects, Start(0.0, slip=-speed), duration=1.5 * rolls)
    motion = run.motion
    exact = np.sign(speed) * mu * g * np.minimum(motion.t, rolls)
    # Friction acts up to a step early or late, and a disc that sticks may creep.
    tolerance = run.kick + 2 * mu * g * run.step + 2 * motion.slip_resolution + 1e-9
    share = float(motion.vx[-1]) / (speed / grip)
    suspect = f"speed of Belt: {speed * share:.4g} would fit at the end, the case has {speed:g}; mu of CoulombFriction"
    yield "vx", motion.vx - exact, tolerance, suspect
    spin = plate.mass * radius / plate.inertia * exact
    yield "the spin", motion.omega - spin, tolerance * plate.mass * radius / plate.inertia, suspect
    slip = exact * grip - speed
    yield "the slip", motion.slip - slip, tolerance * grip, "speed of Belt: the slip is relative to the belt"


@law("driven track")
def driven_track(d: Draw) -> Steps:
    """A disc on a table at x = j t³/6 rolls: J ω̇ = T r, m v̇ = T and v̇ + r ω̇ = j t give v̇ = j t/(1 + m r²/J)."""
    plate, radius, g, time = _disc(d)
    mu, grip, duration = d.mu(0.2, 0.5), 1 + plate.mass * radius**2 / plate.inertia, 8 * time
    # Friction stays below nine tenths of its bound.
    jerk = d.signed(0.7, 0.9) * mu * g * grip / duration
    effects = (Gravity(g), CoulombFriction(mu), Drive(x=f"{jerk / 6!r}*t**3"), Unilateral())
    run = yield Case(LEVEL, plate, effects, Start(0.0), duration)
    motion = run.motion
    table = 0.5 * jerk * motion.t**2
    # The table is up to a step early or late, and a disc that sticks may creep.
    tolerance = 2 * abs(jerk) * duration * run.step + 2 * motion.slip_resolution + 1e-9
    tolerance += 10 * run.rounding * run.speed * len(motion.t) ** 0.5
    suspect = "x of Drive: its second rate drives the plate by friction; inertia of the plate"
    yield "vx", motion.vx - table / grip, tolerance, suspect
    yield "the spin", radius * motion.omega - table * (1 - 1 / grip), tolerance, suspect
    yield "the slip", motion.slip, tolerance * grip, "x of Drive: the slip is relative to the track"


@law("fixed rotation")
def fixed_rotation(d: Draw) -> Steps:
    """A plate of infinite inertia slides on a level line: v̇ = −μ g until it rests, at v₀²/(2 μ g), without a turn."""
    plate, radius, g, time = _disc(d)
    mu, initial = d.mu(0.1, 0.4), d.signed(2.0, 4.0) * radius / time
    rests = abs(initial) / (mu * g)
    effects = (Gravity(g), CoulombFriction(mu), Unilateral())
    run = yield Case(LEVEL, replace(plate, inertia=inf), effects, Start(0.0, slip=initial), 1.3 * rests)
    motion = run.motion
    exact = initial - np.sign(initial) * mu * g * np.minimum(motion.t, rests)
    tolerance = run.kick + 2 * mu * g * run.step + 2 * motion.slip_resolution + 1e-9
    yield "vx", motion.vx - exact, tolerance, "mu of CoulombFriction, inertia of the plate (infinite)"
    way = float(motion.x[-1] - motion.x[0]) - initial * rests / 2
    yield "the way", way, tolerance * float(motion.t[-1]), "mu of CoulombFriction"
    yield "the spin", motion.omega * radius, 1e-9 * abs(initial), "inertia of the plate (infinite)"


# The laws that check an effect. (Without `Unilateral` the contact is a bilateral guide.)
OF_EFFECT: dict[type, tuple[str, ...]] = {
    Load: ("load", "equations_of_motion"),
    Impact: ("bounce", "bounce_with_friction", "landing"),
    PerfectlyRough: ("perfectly_rough", "equations_of_motion"),
    RollingResistance: ("rolling_resistance", "equations_of_motion"),
    Belt: ("belt",),
    Drive: ("driven_track",),
    Flight: ("free_fall", "landing"),
    Unilateral: ("lift_off", "guide"),
    CoulombFriction: ("friction_torque", "sticking_threshold", "equations_of_motion", "friction_by_speed"),
    Gravity: ("free_fall", "equations_of_motion"),
}
