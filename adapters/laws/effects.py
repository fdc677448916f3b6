"""Laws of further effects: load, impact, rough contact, bilateral guide, rolling resistance.

Each follows from Newton's laws in a line or two, given in its docstring. `OF_EFFECT` lists the laws that check each
effect, so that no adapter claims an effect without a check. Tolerances are those of `adapters.laws.runs`.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin

import numpy as np

from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    RollingResistance,
    Start,
    Unilateral,
    curves,
    disc,
)
from cases.contact import start_motion

from .runs import G, LawRun, Route, hold

LEVEL = Curve(lambda s: (s, 0))
MASS, RADIUS, INERTIA = 2.0, 0.1, 0.012
# An inertia of its own keeps the disc from hiding a solver that assumes ½ m r².
DISC = disc(RADIUS, MASS, inertia=INERTIA)
# Engines whose impacts are contact forces have their restitution to a hundredth, according to their manuals.
RESTITUTION = 1e-2


def load(route: Route) -> None:
    """A frictionless disc on a level line: m v̇ = −c v, so v = v₀ exp(−c t/m); J ω̇ = M sin(w t)."""
    drag, moment, rate, initial = 0.8, 0.02, 4.0, 1.0
    push = Load(fx=f"-{drag}*vx", moment=f"{moment}*sin({rate}*t)")
    run = route.simulate(Case(LEVEL, DISC, (Gravity(G), push, Unilateral()), Start(0.0, slip=initial), duration=1.0))
    t = run.motion.t
    # Forces act up to a step early or late.
    tolerance = 2.0 * run.step + 10 * run.rounding * len(t) ** 0.5 + 1e-9
    hold("load", "vx", run.motion.vx - initial * np.exp(-drag * t / MASS), tolerance * drag * initial / MASS)
    exact = moment / (INERTIA * rate) * (1 - np.cos(rate * t))
    hold("load", "omega", run.motion.omega - exact, tolerance * moment / INERTIA)


def _drop(restitution: float, mu: float, omega: float, duration: float) -> Case:
    friction = (CoulombFriction(mu),) if mu else ()
    effects = (Gravity(G), *friction, Unilateral(), Flight(), Impact(restitution))
    return Case(LEVEL, DISC, effects, Start(0.0, slip=RADIUS * omega, omega=omega, gap=0.2), duration=duration)


def _fall(case: Case) -> tuple[float, float]:
    """The time (s) and speed (m/s) at which the disc meets the line."""
    speed = (2 * G * (start_motion(case).y - RADIUS)) ** 0.5
    return speed / G, speed


def bounce(route: Route) -> None:
    """A disc that falls from h on a level line rises to e² h again."""
    restitution = 0.5
    case = _drop(restitution, 0.0, 0.0, duration=0.42)
    run, (time, speed) = route.simulate(case), _fall(case)
    after = run.motion.t > time + 2 * run.step + 0.02
    top, exact = float(run.motion.y[after].max()) - RADIUS, (restitution * speed) ** 2 / (2 * G)
    tolerance = 2 * restitution * speed * run.kick / G + 2 * RESTITUTION * exact
    hold("bounce", "the height", top - exact, tolerance)


def bounce_with_friction(route: Route) -> None:
    """A spinning disc that slips through its impact: friction takes μ of the impulse, so v_t grows by μ (1 + e) v_n."""
    restitution, mu, omega = 0.5, 0.1, 60.0
    case = _drop(restitution, mu, omega, duration=0.38)
    run, (time, speed) = route.simulate(case), _fall(case)
    after = run.motion.t > time + 2 * run.step + 0.02
    _check_spin(
        "bounce with friction",
        run,
        after,
        -mu * (1 + restitution) * speed,
        RESTITUTION * mu * (1 + restitution) * speed,
    )


def landing(route: Route) -> None:
    """A spinning disc that stays where it lands: v_t grows by μ v_n in the impact, and by μ g t from then on."""
    mu, omega = 0.1, 60.0
    case = _drop(0.0, mu, omega, duration=0.4)
    run, (time, speed) = route.simulate(case), _fall(case)
    after = run.motion.t > time + 2 * run.step + 0.02
    _check_spin("landing", run, after, -mu * (speed + G * (run.motion.t[after] - time)), RESTITUTION * mu * speed)


def _check_spin(law: str, run: LawRun, after: np.ndarray, exact, tolerance: float) -> None:
    """Check the velocity along the line and the spin after an impact: friction's impulse changes both."""
    tolerance += run.kick
    initial = start_motion(run.case)
    hold(law, "vx", run.motion.vx[after] - initial.vx - exact, tolerance)
    ratio = MASS * RADIUS / INERTIA
    hold(law, "the spin", run.motion.omega[after] - initial.omega - ratio * exact, ratio * tolerance)


def perfectly_rough(route: Route) -> None:
    """A disc rolls down an incline of 69°, whatever friction that takes: (m + J/r²) v̇ = m g sin."""
    angle, duration = 1.2, 0.5
    track = Curve(lambda s: (s * curves.cos(angle), -s * curves.sin(angle)))
    run = route.simulate(Case(track, DISC, (Gravity(G), PerfectlyRough(), Unilateral()), Start(0.0), duration=duration))
    growth = G * sin(angle) / (1 + INERTIA / (MASS * RADIUS**2))
    motion = run.motion
    hold("perfectly rough", "the end of the motion", float(motion.t[-1]) - duration, 2 * run.step)
    creep = motion.slip_resolution
    hold("perfectly rough", "the spin", motion.omega + growth * motion.t / RADIUS, (run.kick + creep) / RADIUS)
    hold("perfectly rough", "the slip", motion.slip, 2 * creep + run.kick * (1 + MASS * RADIUS**2 / INERTIA))


def guide(route: Route) -> None:
    """A track that also pulls keeps a frictionless disc where it would lift off: N = m g (3 cos φ − 2 cos φ₀)."""
    initial = 0.2
    # φ is counted from the top, clockwise: with the parameter running that way the plate, on the left, is outside.
    track = Curve(lambda s: (1.0 * curves.sin(s), 1.0 * curves.cos(s)))
    run = route.simulate(Case(track, DISC, (Gravity(G),), Start(initial), duration=1.2))
    motion = run.motion
    hold("guide", "the end of the motion", float(motion.t[-1]) - 1.2, 2 * run.step)
    length = 1.0 + RADIUS
    angle = np.arctan2(motion.x, motion.y)
    speed = np.sqrt(2 * G * length * (cos(initial) - np.cos(angle)))
    hold("guide", "the speed", np.hypot(motion.vx, motion.vy) - speed, 2 * run.kick)
    exact = MASS * G * (3 * np.cos(angle) - 2 * cos(initial))
    if exact.min() > -0.5 * MASS * G:
        raise AssertionError("guide: the disc does not reach the part where the track has to pull")
    # The first force may belong to the time before the motion; an error `kick` of the speed is one of the force.
    tolerance = 4 * MASS * run.kick * speed[1:] / length + MASS * run.kick + run.grain
    hold("guide", "the normal force", run.forces[0][1:] - exact[1:], tolerance)


def rolling_resistance(route: Route) -> None:
    """A disc that rolls on a level line against a couple a·N: (m + J/r²) v̇ = −m g a/r, until it rests."""
    arm, initial, duration = 2e-3, -6.0, 1.0
    effects = (Gravity(G), CoulombFriction(0.5), RollingResistance(arm), Unilateral())
    run = route.simulate(Case(LEVEL, DISC, effects, Start(0.0, omega=initial), duration=duration))
    deceleration = G * arm / (RADIUS**2 * (1 + INERTIA / (MASS * RADIUS**2)))
    exact = initial + deceleration * run.motion.t
    # The couple acts up to a step early or late, and a rolling disc may creep.
    tolerance = (
        2 * deceleration * run.step
        + (run.motion.slip_resolution + 10 * run.rounding * run.speed * len(exact) ** 0.5) / RADIUS
    )
    hold("rolling resistance", "the spin", run.motion.omega - exact, tolerance + 1e-9)


Law = Callable[[Route], None]

LAWS: dict[str, Law] = {
    law.__name__: law
    for law in (load, bounce, bounce_with_friction, landing, perfectly_rough, guide, rolling_resistance)
}

# The laws that check an effect. (Without `Unilateral` the contact is a bilateral guide.)
OF_EFFECT: dict[type, tuple[str, ...]] = {
    Load: ("load",),
    Impact: ("bounce", "bounce_with_friction", "landing"),
    PerfectlyRough: ("perfectly_rough",),
    RollingResistance: ("rolling_resistance",),
    Flight: ("free_fall", "landing"),
    Unilateral: ("lift_off", "guide"),
    CoulombFriction: ("friction_torque", "sticking_threshold"),
    Gravity: ("free_fall",),
}
