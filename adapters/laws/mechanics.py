"""Laws of mechanics that every adapter is checked against, as plain functions of one route of an adapter.

`LAWS` names them all. A law raises AssertionError, which begins with the law's name, if the route breaks it, and
NotSupported if the route cannot model the law's scene. No law compares solvers: each follows from Newton's and
Coulomb's laws, or from a symmetry of theirs. Tolerances are those of `adapters.laws.runs`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import atan, cos, pi, sin

import numpy as np

from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    NotSupported,
    Plate,
    Start,
    Trajectory,
    Unilateral,
    curves,
    disc,
)
from cases.contact import follow, pose, slip_velocity, start_motion
from cases.mechanics import energy, energy_growth

from .runs import G, LawRun, Route, hold

# --- scenes ----------------------------------------------------------------------------------------------------------

CIRCLE = Curve(lambda s: (1.0 * curves.cos(s), 1.0 * curves.sin(s)))


VALLEY = Curve(lambda s: (s, -0.3 * curves.cos(2 * s)), domain=(-3.0, 3.0))


def _case_on_circle(plate: Plate, start: Start, mu: float | None = 0.1) -> Case:
    friction = (CoulombFriction(mu),) if mu else ()
    return Case(CIRCLE, plate, (Gravity(G), *friction, Unilateral()), start, duration=1.0)


def _elliptic_plate() -> Plate:
    a, b = 0.2, 0.12
    return Plate(Curve(lambda s: (a * curves.cos(s), b * curves.sin(s))), 1.0, (a * a + b * b) / 4)


# A disc and an ellipse, released on the wall of a circle. The disc's inertia is not ½ m r², so that a solver which
# assumes that fails. In the valley the curvature changes: a solver that approximates its tracks by circles fails there.
SCENES = {
    "disc in a circle": _case_on_circle(disc(0.1, 2.0, inertia=0.012), Start(-2.6, slip=0.3, omega=1.0)),
    "ellipse in a circle": _case_on_circle(_elliptic_plate(), Start(-2.6, xi2=-1.2, slip=0.3)),
    "disc in a valley": replace(
        _case_on_circle(disc(0.1, 2.0, inertia=0.012), Start(-0.9, slip=0.3, omega=1.0)), track=VALLEY, duration=0.8
    ),
}


def _slope(angle: float, mu: float, **how) -> Case:
    """A hollow-ish disc on a line that falls to the right."""
    track = Curve(lambda s: (s * curves.cos(angle), -s * curves.sin(angle)))
    return Case(track, disc(0.1, 2.0), (Gravity(G), CoulombFriction(mu), Unilateral()), Start(0.0), **how)


def mirror(case: Case) -> Case:
    """The case mirrored left to right; parameters are reversed so that the plate stays on the left."""
    start, gravity = start_motion(case), case.effect(Gravity)
    assert gravity is not None
    others = tuple(effect for effect in case.effects if effect is not gravity)
    return replace(
        case,
        track=_mirror(case.track),
        plate=replace(case.plate, outline=_mirror(case.plate.outline)),
        effects=(Gravity(gravity.g, pi - gravity.direction), *others),
        start=Start(-start.xi1, -start.xi2, -case.start.slip, -case.start.omega),
    )


def _mirror(curve: Curve) -> Curve:
    def function(s):
        x, y = curve.at(-s)
        return -x, y

    return Curve(function, domain=curve.domain and (-curve.domain[1], -curve.domain[0]))


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


# --- laws ------------------------------------------------------------------------------------------------------------


def friction_torque(route: Route) -> None:
    """A sliding disc spins up: ω = −(μ g t) m r/J, whatever its inertia."""
    mu, mass, radius, inertia = 0.1, 2.0, 0.1, 0.012
    # It would roll after v₀/(μ g (1 + m r²/J)) = 0.38 s.
    case = Case(
        Curve(lambda s: (s, 0)),
        disc(radius, mass, inertia),
        (Gravity(G), CoulombFriction(mu), Unilateral()),
        Start(0.0, slip=1.0),
        duration=0.3,
    )
    run = route.simulate(case)
    exact = -mu * G * run.motion.t * mass * radius / inertia
    # The kick of friction, with the same lever.
    tolerance = mu * run.kick * mass * radius / inertia
    hold("friction torque", "the spin of a sliding disc", run.motion.omega - exact, tolerance)


def cone(route: Route, scene: Case) -> None:
    """|T| ≤ μ N at every sample: friction never exceeds Coulomb's bound, nor acts without a normal force."""
    run = route.simulate(scene)
    normal, friction = run.forces
    mu = _mu(scene)
    # A normal force whose direction has the error `tilt` has this part along the tangent; 1e-9 of the weight is
    # rounding.
    nothing = 1e-9 * scene.plate.mass * G + run.grain
    hold("cone", "friction beyond zero", friction, (mu + run.tilt) * np.abs(normal) + nothing)
    hold("cone", "the normal force below zero", np.minimum(normal, 0.0), run.tilt * np.abs(friction) + nothing)


def friction_opposes_slip(route: Route, scene: Case) -> None:
    """T = −μ N sign(v) where the plate certainly slips: the force's direction, and its mean size."""
    run, mu = route.simulate(scene), _mu(scene)
    motion = run.motion
    # Slip that a step can reverse is left out: friction acts in both directions there.
    sure = np.abs(motion.slip) > 2 * motion.slip_resolution + run.kick * _ease(scene.plate)
    sure[0] = False
    if sure.sum() < 10:
        raise NotSupported("the plate hardly slips in this scene")
    normal, friction = run.forces
    against, push = -np.sign(motion.slip[sure]) * friction[sure], normal[sure]
    # On facets the force of one step is noise, but the sum is not.
    hold("friction opposes slip", "the sum of friction", against.sum() / push.sum() - mu, run.tilt + 1e-6)


def sticking_threshold(route: Route) -> None:
    """A disc rolls down an incline up to tan = 3μ and slips beyond; checked 0.1 % on either side."""
    mu, off, duration = 0.1, 1e-3, 1.0
    for share, slips in ((1 - off, False), (1 + off, True)):
        angle = atan(3 * mu * share)
        run = route.simulate(_slope(angle, mu, duration=duration))
        # m r²/J = 2, so slip grows with g (sin − 3 μ cos), if it grows.
        exact = G * (sin(angle) - 3 * mu * cos(angle)) * duration if slips else 0.0
        # Half of the slip on the other side distinguishes the two.
        tolerance = 0.5 * G * 3 * mu * off * cos(angle) * duration
        side = "above" if slips else "below"
        hold("sticking threshold", f"slip 0.1 % {side} tan = 3 mu", run.motion.slip[-1] - exact, tolerance)


def no_friction_no_spin(route: Route) -> None:
    """Without friction a disc keeps its spin, since the normal force points at its centre."""
    run = route.simulate(replace(SCENES["disc in a circle"], effects=(Gravity(G), Unilateral())))
    omega = run.motion.omega
    from scipy.integrate import trapezoid  # slow to import

    # No moment acts, so a step cannot act early or late: only rounding remains, of a thousand steps or more and of the
    # lever of the normal force. (A force that is not reported adds no rounding.)
    force = np.nan_to_num(run.motion.normal_force)
    plate, push = run.case.plate, float(trapezoid(np.abs(force), run.motion.t))
    tolerance = 1e-9 * (1 + abs(omega[0])) + run.rounding * (plate.radius or 0.0) * push / plate.inertia
    hold("no spin-up without friction", "the spin", omega - omega[0], tolerance)


def energy_conservation(route: Route, scene: Case) -> None:
    """Without friction the energy is constant."""
    frictionless = replace(scene, effects=(Gravity(G), Unilateral()))
    run = route.simulate(frictionless)
    total = energy(frictionless, run.motion)
    hold("energy conservation without friction", "the energy", total - total[0], run.loss + _swing(run))


def energy_never_grows(route: Route, scene: Case) -> None:
    """With friction and no load the energy never increases."""
    run = route.simulate(scene)
    total = energy(scene, run.motion)
    hold("energy never grows", "the energy, above its least so far,", energy_growth(total), _swing(run))


def mirror_image(route: Route, scene: Case) -> None:
    """The mirrored case has the mirrored motion."""
    here, there = route.simulate(scene), route.simulate(mirror(scene))
    a, b = _common(here, there)
    image = replace(b, x=-b.x, theta=-b.theta)
    _hold_same_motion("mirror image", here, a, image)


def turn_frame(route: Route, scene: Case) -> None:
    """The case turned about the origin, gravity and all, has the turned motion."""
    angle = 2.1
    here, there = route.simulate(scene), route.simulate(turn_gravity(scene, angle))
    a, b = _common(here, there)
    back = replace(
        b, x=b.x * cos(angle) + b.y * sin(angle), y=b.y * cos(angle) - b.x * sin(angle), theta=b.theta - angle
    )
    _hold_same_motion("turned frame", here, a, back)


def on_its_track(route: Route, scene: Case) -> None:
    """The plate touches the case's track, at the reported parameters, with the reported slip."""
    run = route.simulate(scene)
    motion, reach = run.motion, scene.plate.reach
    gap = follow(scene, motion.x, motion.y, motion.theta)[2]
    # The displacement in a step, the corners' sagitta, and the overlap that engines do not correct.
    tolerance = run.kick * run.step + reach * run.corners**2 / 8 + 1e-3 * reach
    hold("on its track", "the gap", gap, tolerance)
    slip = slip_velocity(scene, motion.x, motion.y, motion.vx, motion.vy, motion.omega, motion.xi1)
    hold("on its track", "the slip", motion.slip - slip, run.kick * _ease(scene.plate) + run.tilt * run.speed)


def momentum_balance(route: Route, scene: Case) -> None:
    """m v and J ω change by the integrals of the reported forces: m v̇ = N n + T t + m g, J ω̇ = arm × force."""
    from scipy.integrate import cumulative_trapezoid  # slow to import

    run, motion, plate = route.simulate(scene), route.simulate(scene).motion, scene.plate
    tangent, normal = scene.track.tangent(motion.xi1), scene.track.normal(motion.xi1)
    normal_force, friction_force = run.forces
    fx, fy = normal_force * normal + friction_force * tangent
    arm = scene.track.point(motion.xi1) - pose(scene, motion.xi1, motion.xi2)[:2]
    weight = -plate.mass * G

    def sum_up(rate):
        return cumulative_trapezoid(rate, motion.t, initial=0.0)

    lever = float(np.hypot(*arm).max())
    # The point on a facet where the force acts is not reported; the arm is known to the facet's length.
    doubt = lever * run.corners * sum_up(np.abs(normal_force))[-1]
    for what, change, force, tolerance in (
        ("m vx", plate.mass * (motion.vx - motion.vx[0]), fx, plate.mass * run.kick),
        ("m vy", plate.mass * (motion.vy - motion.vy[0]), fy + weight, plate.mass * run.kick),
        (
            "J omega",
            plate.inertia * (motion.omega - motion.omega[0]),
            arm[0] * fy - arm[1] * fx,
            lever * plate.mass * run.kick + doubt,
        ),
    ):
        hold("momentum balance", f"{what} against the reported forces", change - sum_up(force), tolerance)


def lift_off(route: Route) -> None:
    """A frictionless disc released near the top of a circle leaves it where N vanishes: at ⅔ of its initial cos φ."""
    # φ is counted from the top, clockwise: with the parameter running that way the plate, on the left, is outside.
    track = Curve(lambda s: (1.0 * curves.sin(s), 1.0 * curves.cos(s)))
    case = Case(track, disc(0.1, 2.0), (Gravity(G), Unilateral()), Start(0.2), duration=1.2)
    run = route.simulate(case)
    motion, length = run.motion, 1.1
    if motion.status != "lift_off":
        raise AssertionError(f"lift-off: the motion should end with lift_off, and its status is {motion.status}")
    exact = 2 / 3 * cos(0.2)
    speed = (G * length * exact) ** 0.5
    # The displacement in a step, and N = m (g cos φ − v²/L) with an error `kick` of the speed.
    tolerance = run.step * speed / length + 2 * speed * run.kick / (3 * G * length)
    hold("lift-off", "cos phi where it leaves", cos(motion.xi1[-1]) - exact, tolerance)


def free_fall(route: Route) -> None:
    """A disc off its track falls along a parabola and keeps its spin."""
    start = Start(0.0, slip=0.4, omega=3.0, gap=0.5)
    # It would land after 0.32 s.
    case = Case(Curve(lambda s: (s, 0)), disc(0.1, 2.0), (Gravity(G), Unilateral(), Flight()), start, duration=0.25)
    run, start_state = route.simulate(case), start_motion(case)
    motion, t = run.motion, run.motion.t
    hold("free fall", "the end of the motion", float(t[-1]) - case.duration, 2 * run.step)
    # Gravity acts up to a step early or late, and the angle has an error of one step's turn; 1e-9 is rounding, and so
    # is the random walk of single precision.
    turn = start_state.omega**2 * run.step * case.duration
    grain = 10 * run.rounding * run.speed * len(t) ** 0.5
    for what, values, exact, tolerance in (
        ("x", motion.x, start_state.x + start_state.vx * t, 1e-9),
        ("y", motion.y, start_state.y + start_state.vy * t - 0.5 * G * t**2, run.kick * case.duration),
        ("vx", motion.vx, start_state.vx, 1e-9),
        ("vy", motion.vy, start_state.vy - G * t, run.kick),
        ("theta", motion.theta, start_state.theta + start_state.omega * t, turn),
        ("omega", motion.omega, start_state.omega, 1e-9),
    ):
        hold("free fall", what, values - exact, tolerance + grain)


def _mu(case: Case) -> float:
    friction = case.effect(CoulombFriction)
    return friction.mu if friction else 0.0


def _ease(plate: Plate) -> float:
    """The ratio of the contact point's velocity change to the centre's: 1 + m ρ²/J with the largest lever ρ."""
    return 1 + plate.mass * plate.reach**2 / plate.inertia


def _swing(run: LawRun) -> float:
    """The error of a sample's energy, J, if its velocity has the error `kick`."""
    return run.case.plate.mass * run.speed * run.kick


def _common(here: LawRun, there: LawRun) -> tuple[Trajectory, Trajectory]:
    """Both motions at the times of the first, up to the end of the shorter.

    An engine that chooses its steps may choose others in another frame because of rounding.
    """
    a, b = here.motion, there.motion
    times = a.t[a.t <= b.t[-1] + 1e-9]
    return tuple(replace(each, dense=None, t=times, **each(times)._asdict()) for each in (a, b))  # type: ignore[return-value]


def _hold_same_motion(law: str, run: LawRun, a: Trajectory, b: Trajectory) -> None:
    # An error `kick` of the velocity during the whole motion.
    drift = run.kick * float(a.t[-1])
    hold(law, "the end of the motion", float(a.t[-1]) - run.case.duration, 2 * run.step)
    hold(law, "the centre", np.hypot(a.x - b.x, a.y - b.y), drift)
    turns = 2 * pi * round(float(a.theta[0] - b.theta[0]) / (2 * pi))
    size = run.case.plate.radius or float(np.hypot(*run.case.plate.outline.point(np.pi / 2)))
    hold(law, "the angle", a.theta - b.theta - turns, drift / size)


Law = Callable[[Route], None]


def _everywhere(law: Callable[[Route, Case], None]) -> dict[str, Law]:
    name = law.__name__
    return {f"{name}[{scene}]": partial(_on, law, case) for scene, case in SCENES.items()}


def _on(law: Callable[[Route, Case], None], scene: Case, route: Route) -> None:
    law(route, scene)


LAWS: dict[str, Law] = {
    "friction_torque": friction_torque,
    "sticking_threshold": sticking_threshold,
    "no_friction_no_spin": no_friction_no_spin,
    "lift_off": lift_off,
    "free_fall": free_fall,
    **_everywhere(on_its_track),
    **_everywhere(cone),
    **_everywhere(friction_opposes_slip),
    **_everywhere(energy_conservation),
    **_everywhere(energy_never_grows),
    **_everywhere(mirror_image),
    **_everywhere(turn_frame),
    **_everywhere(momentum_balance),
}
