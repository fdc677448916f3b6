"""Laws of mechanics that every adapter is checked against, as steps that `adapters.laws.runs` runs on one route.

A law raises AssertionError, which begins with the law's name, if the route breaks it, and
NotSupported if the route cannot model the law's scene. No law compares solvers: each follows from Newton's and
Coulomb's laws, or from a symmetry of theirs. Tolerances are those of `adapters.laws.runs`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import atan, cos, pi, sin, sqrt

import numpy as np

from cases import Case, CoulombFriction, Curve, Flight, Gravity, NotSupported, Start, Trajectory, Unilateral
from cases.contact import follow, pose, slip_velocity, start_motion
from cases.motion.mechanics import energy, energy_growth, gravity

from .runs import Check, LawRun, MissingQuantity, Steps, ease, law
from .scenes import LEVEL, SCENES, Draw, disc_in_circle, hill, incline, turn_gravity


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


# --- laws ------------------------------------------------------------------------------------------------------------


@law("starts as given", (*SCENES, "off-centre disc", "thrown disc"))
def starts_as_given(scene: Case) -> Steps:
    """The first sample has the start's pose and velocities."""
    run, start = (yield scene), start_motion(scene)
    motion, size = run.motion, scene.plate.reach
    yield "the first time", float(motion.t[0]), 1e-9
    # A pose of the step before or after, and the overlap that engines with soft contacts begin with.
    place = run.speed * run.step + 1e-3 * size
    for name, tolerance in (("x", place), ("y", place), ("theta", place / size)):
        off = float(getattr(motion, name)[0]) - getattr(start, name)
        yield name, off, tolerance, f"{name} at the start: xi1, xi2 and gap of Start, centre of mass"
    kick = run.kick * ease(scene.plate) + 1e-9 * run.speed
    for name, tolerance in (("vx", kick), ("vy", kick), ("omega", kick / size)):
        off = float(getattr(motion, name)[0]) - getattr(start, name)
        yield name, off, tolerance, f"{name} at the start: slip, omega and gap_rate of Start"


@law("rates of the pose", SCENES)
def rates_of_pose(scene: Case) -> Steps:
    """x, y and θ change by the integrals of vx, vy and ω."""
    from scipy.integrate import cumulative_trapezoid  # slow to import

    run = yield scene
    motion, size = run.motion, scene.plate.reach
    # Velocities of a step earlier or later change the integral by their change over the motion, times the step.
    away = 2 * run.speed * run.step + 1e-9 * size + run.speed * run.corners * float(motion.t[-1])
    for name, rate, tolerance in (("x", "vx", away), ("y", "vy", away), ("theta", "omega", away / size)):
        values = getattr(motion, name)
        off = values - values[0] - cumulative_trapezoid(getattr(motion, rate), motion.t, initial=0.0)
        suspect = f"{rate}: its sign, unit, frame or time; or {name}"
        yield f"{name} less the integral of {rate}", off, tolerance, suspect


@law("friction torque")
def friction_torque(d: Draw) -> Steps:
    """A sliding disc spins up: ω = −(μ g t) m r/J, whatever its inertia."""
    mu, g, radius = d.mu(), d.g(), d.between(0.08, 0.15)
    plate = d.disc(radius)
    lever, slip = plate.mass * radius / plate.inertia, d.signed(2.0, 4.0) * sqrt(g * radius)
    # It would roll after v₀/(μ g (1 + m r²/J)).
    duration = 0.8 * abs(slip) / (mu * g * (1 + lever * radius))
    run = yield Case(LEVEL, plate, (Gravity(g), CoulombFriction(mu), Unilateral()), Start(0.0, slip=slip), duration)
    exact = -np.sign(slip) * mu * g * run.motion.t * lever
    # The kick of friction, with the same lever.
    tolerance = mu * run.kick * lever
    fit = float(-np.sign(slip) * run.motion.omega[-1] / (g * run.motion.t[-1] * lever))
    suspect = (
        f"mu of CoulombFriction: {fit:.4g} would fit, the case has {mu:g}; or inertia of the plate, or g of Gravity"
    )
    yield "the spin of a sliding disc", run.motion.omega - exact, tolerance, suspect


@law("cone", SCENES)
def cone(scene: Case) -> Steps:
    """|T| ≤ μ N at every sample: friction never exceeds Coulomb's bound, nor acts without a normal force."""
    run = yield scene
    normal, friction = run.forces
    mu = _mu(scene)
    # A normal force whose direction has the error `tilt` has this part along the tangent; 1e-9 of the weight is
    # rounding.
    nothing = 1e-9 * scene.weight + run.grain
    yield "friction beyond zero", friction, (mu + run.tilt) * np.abs(normal) + nothing, "mu of CoulombFriction"
    yield (
        "the normal force below zero",
        np.minimum(normal, 0.0),
        run.tilt * np.abs(friction) + nothing,
        "the sign of the normal force",
    )


@law("friction opposes slip", SCENES)
def friction_opposes_slip(scene: Case) -> Steps:
    """T = −μ N sign(v) where the plate certainly slips: the force's direction, and its mean size."""
    run, mu = (yield scene), _mu(scene)
    motion = run.motion
    # Slip that a step can reverse is left out: friction acts in both directions there.
    sure = np.abs(motion.slip) > 2 * motion.slip_resolution + run.kick * ease(scene.plate)
    sure[0] = False
    if sure.sum() < 10:
        raise NotSupported("the plate hardly slips in this scene")
    normal, friction = run.forces
    against, push = -np.sign(motion.slip[sure]) * friction[sure], normal[sure]
    # On facets the force of one step is noise, but the sum is not.
    fit = float(against.sum() / push.sum())
    suspect = f"mu of CoulombFriction: {fit:.4g} would fit, the case has {mu:g}"
    yield "the sum of friction", fit - mu, run.tilt + 1e-6, suspect


@law("sticking threshold")
def sticking_threshold(d: Draw) -> Steps:
    """A disc rolls down an incline up to tan = μ (1 + m r²/J) and slips beyond; checked 0.1 % on either side."""
    off = 1e-3
    mu, g, radius = d.mu(0.08, 0.15), d.g(), d.between(0.08, 0.15)
    plate = d.disc(radius)
    factor, duration = 1 + plate.mass * radius**2 / plate.inertia, 10 * sqrt(radius / g)
    for share, slips in ((1 - off, False), (1 + off, True)):
        angle = atan(factor * mu * share)
        effects = (Gravity(g), CoulombFriction(mu), Unilateral())
        run = yield Case(incline(angle), plate, effects, Start(0.0), duration=duration)
        # Slip grows with g (sin − factor μ cos), if it grows; that is cos·factor·μ·off.
        growth = g * factor * mu * off * cos(angle) * duration
        side = "above" if slips else "below"
        what = f"slip 0.1 % {side} tan = mu (1 + m r^2/J)"
        # Half of the slip on the other side distinguishes the two.
        suspect = "mu or mu_static of CoulombFriction, g of Gravity, inertia of the plate"
        yield what, run.motion.slip[-1] - (growth if slips else 0.0), 0.5 * growth, suspect


@law("no spin-up without friction", key="disc in a circle")
def no_friction_no_spin(d: Draw) -> Steps:
    """Without friction a disc keeps its spin, since the normal force points at its centre."""
    run = yield _frictionless(disc_in_circle(d))
    omega = run.motion.omega
    from scipy.integrate import trapezoid  # slow to import

    # No moment acts, so a step cannot act early or late: only rounding remains, of a thousand steps or more and of the
    # lever of the normal force. (A force that is not reported adds no rounding.)
    force = np.nan_to_num(run.motion.normal_force)
    plate, push = run.case.plate, float(trapezoid(np.abs(force), run.motion.t))
    tolerance = 1e-9 * (1 + abs(omega[0])) + run.rounding * (plate.radius or 0.0) * push / plate.inertia
    suspect = "friction where the case has none, angular damping"
    yield "the spin", omega - omega[0], tolerance, suspect


def _frictionless(case: Case) -> Case:
    return replace(case, effects=tuple(e for e in case.effects if not isinstance(e, CoulombFriction)))


@law("energy conservation without friction", SCENES)
def energy_conservation(scene: Case) -> Steps:
    """Without friction the energy is constant."""
    frictionless = _frictionless(scene)
    run = yield frictionless
    total = energy(frictionless, run.motion)
    yield (
        "the energy",
        total - total[0],
        run.loss + _swing(run),
        "g of Gravity, friction or damping where the case has none",
    )


@law("energy never grows", SCENES)
def energy_never_grows(scene: Case) -> Steps:
    """With friction and no load the energy never increases."""
    run = yield scene
    total = energy(scene, run.motion)
    yield (
        "the energy, above its least so far,",
        energy_growth(total),
        _swing(run),
        "direction of CoulombFriction, g of Gravity, mass, inertia",
    )


@law("mirror image", SCENES)
def mirror_image(scene: Case) -> Steps:
    """The mirrored case has the mirrored motion."""
    here, there = (yield scene), (yield mirror(scene))
    a, b = _common(here, there)
    image = replace(b, x=-b.x, theta=-b.theta)
    yield from _same_motion(here, a, image, "signs of directions, of the spin or of the slip")


@law("turned frame", SCENES)
def turn_frame(scene: Case) -> Steps:
    """The case turned about the origin, gravity and all, has the turned motion."""
    angle = 2.1
    here, there = (yield scene), (yield turn_gravity(scene, angle))
    a, b = _common(here, there)
    back = replace(
        b, x=b.x * cos(angle) + b.y * sin(angle), y=b.y * cos(angle) - b.x * sin(angle), theta=b.theta - angle
    )
    yield from _same_motion(here, a, back, "direction of Gravity, components in a fixed frame")


@law("on its track", (*SCENES, "off-centre disc", "disc on a bump"))
def on_its_track(scene: Case) -> Steps:
    """The plate touches the case's track, at the reported parameters, with the reported slip."""
    run = yield scene
    motion, reach = run.motion, scene.plate.reach
    gap = follow(scene, motion.x, motion.y, motion.theta)[2]
    # The displacement in a step, the corners' sagitta, and the overlap that engines do not correct.
    tolerance = run.kick * run.step + reach * run.corners**2 / 8 + 1e-3 * reach
    yield "the gap", gap, tolerance, "curve of the track, outline and centre of mass of the plate"
    slip = slip_velocity(scene, motion.x, motion.y, motion.vx, motion.vy, motion.omega, motion.xi1, motion.t)
    yield (
        "the slip",
        motion.slip - slip,
        run.kick * ease(scene.plate) + run.tilt * run.speed,
        "sign or point of the slip",
    )


_BALANCE = "the reported forces, mass or inertia of the plate, g of Gravity"


@law("momentum balance", SCENES)
def momentum_balance(scene: Case) -> Steps:
    """m v and J ω change by the integrals of the reported forces: m v̇ = N n + T t + m g, J ω̇ = arm × force."""
    from scipy.integrate import cumulative_trapezoid  # slow to import

    run, plate = (yield scene), scene.plate
    motion = run.motion
    tangent, normal = scene.track.tangent(motion.xi1), scene.track.normal(motion.xi1)
    normal_force, friction_force = run.forces
    fx, fy = normal_force * normal + friction_force * tangent
    arm = scene.track.point(motion.xi1) - pose(scene, motion.xi1, motion.xi2)[:2]
    weight_x, weight_y = plate.mass * gravity(scene)

    def sum_up(rate):
        return cumulative_trapezoid(rate, motion.t, initial=0.0)

    lever = float(np.hypot(*arm).max())
    # The point on a facet where the force acts is not reported; the arm is known to the facet's length.
    doubt = lever * run.corners * sum_up(np.abs(normal_force))[-1]
    for what, change, force, tolerance in (
        ("m vx", plate.mass * (motion.vx - motion.vx[0]), fx + weight_x, plate.mass * run.kick),
        ("m vy", plate.mass * (motion.vy - motion.vy[0]), fy + weight_y, plate.mass * run.kick),
        (
            "J omega",
            plate.inertia * (motion.omega - motion.omega[0]),
            arm[0] * fy - arm[1] * fx,
            lever * plate.mass * run.kick + doubt,
        ),
    ):
        yield f"{what} against the reported forces", change - sum_up(force), tolerance, _BALANCE


@law("lift-off")
def lift_off(d: Draw) -> Steps:
    """A frictionless disc released near the top of a circle leaves it where N vanishes: at ⅔ of its initial cos φ."""
    g, size, initial = d.g(), d.between(0.8, 1.2), d.between(0.18, 0.25)
    plate = d.disc(d.between(0.08, 0.12) * size)
    length = size + (plate.radius or 0.0)
    case = Case(hill(size), plate, (Gravity(g), Unilateral()), Start(initial), duration=3.8 * sqrt(length / g))
    run = yield case
    motion = run.motion
    if motion.status != "lift_off":
        raise AssertionError(
            f"lift-off: the motion should end with lift_off, and its status is {motion.status}; suspect Unilateral"
        )
    exact = 2 / 3 * cos(initial)
    speed = sqrt(g * length * exact)
    # The displacement in a step, and N = m (g cos φ − v²/L) with an error `kick` of the speed.
    tolerance = run.step * speed / length + 2 * speed * run.kick / (3 * g * length) + _hop(run, speed, length, g)
    suspect = "g of Gravity, Unilateral, radius of the track or of the plate"
    yield "cos phi where it leaves", cos(motion.xi1[-1]) - exact, tolerance, suspect


def _hop(run: LawRun, speed: float, length: float, g: float) -> float:
    """How much earlier, in cos φ, a solver leaves whose contact acts in single steps with steps of flight between them.

    A push leaves the velocity along the tangent, and the step that follows leaves the gap growing at the rate
    δ = v² h/(2 L). The plate returns if δ − N t/(2 m) + N′ t²/(6 m) = 0 has a solution, where N is the normal force
    that a lasting contact would have and −N′ its rate, 3 m v g sin φ/L; that is as long as N² > 8 m N′ δ/3. So it
    leaves where N = 3 m g Δcos φ is below the root: an error of order √h. Zero if the reported force lasts.
    """
    try:
        force = run.forces[0]
    except MissingQuantity:
        return 0.0
    last = force[-min(len(force), 20) : -1]
    if np.count_nonzero(np.abs(last) <= 1e-9 * run.case.weight + run.grain) < 3:
        return 0.0
    return sqrt(4 * speed**3 * run.step * sqrt(1 - (speed**2 / (g * length)) ** 2) / (9 * g * length**2))


@law("free fall")
def free_fall(d: Draw) -> Steps:
    """A disc off its track falls along a parabola and keeps its spin."""
    g, radius = d.g(), d.between(0.08, 0.15)
    plate, time = d.disc(radius), sqrt(radius / g)
    omega, gap = d.signed(0.3, 1.0) / time, d.between(4.0, 6.0) * radius
    start = Start(
        0.0, slip=d.signed(0.4, 1.0) * radius / time, omega=omega, gap=gap, gap_rate=d.signed(0.3, 0.8) * radius / time
    )
    # It would land after √(2 gap/g), if it did not rise or sink.
    duration = 0.7 * sqrt(2 * gap / g)
    run = yield Case(LEVEL, plate, (Gravity(g), Unilateral(), Flight()), start, duration)
    start_state, motion, t = start_motion(run.case), run.motion, run.motion.t
    yield "the end of the motion", float(t[-1]) - duration, 2 * run.step, "Flight, gap of Start"
    # Gravity acts up to a step early or late, and the angle has an error of one step's turn; 1e-9 is rounding, and so
    # is the random walk of single precision.
    turn = start_state.omega**2 * run.step * duration
    grain = 10 * run.rounding * run.speed * len(t) ** 0.5
    for what, values, exact, tolerance, suspect in (
        ("x", motion.x, start_state.x + start_state.vx * t, 1e-9, "slip of Start, damping, direction of Gravity"),
        (
            "y",
            motion.y,
            start_state.y + start_state.vy * t - 0.5 * g * t**2,
            run.kick * duration,
            "g of Gravity, gap_rate",
        ),
        ("vx", motion.vx, start_state.vx, 1e-9, "slip of Start, damping, direction of Gravity"),
        ("vy", motion.vy, start_state.vy - g * t, run.kick, "g of Gravity, gap_rate of Start, damping"),
        ("theta", motion.theta, start_state.theta + start_state.omega * t, turn, "omega of Start, unit of the angle"),
        ("omega", motion.omega, start_state.omega, 1e-9, "omega of Start, angular damping"),
    ):
        yield what, values - exact, tolerance + grain, suspect


def _mu(case: Case) -> float:
    friction = case.effect(CoulombFriction)
    return friction.mu if friction else 0.0


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


def _same_motion(run: LawRun, a: Trajectory, b: Trajectory, suspect: str) -> Iterator[Check]:
    # An error `kick` of the velocity during the whole motion.
    drift = run.kick * float(a.t[-1])
    yield "the end of the motion", float(a.t[-1]) - run.case.duration, 2 * run.step
    yield "the centre", np.hypot(a.x - b.x, a.y - b.y), drift, suspect
    turns = 2 * pi * round(float(a.theta[0] - b.theta[0]) / (2 * pi))
    size = run.case.plate.radius or float(np.hypot(*run.case.plate.outline.point(np.pi / 2)))
    yield "the angle", a.theta - b.theta - turns, drift / size, suspect
