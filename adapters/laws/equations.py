"""The equations of motion as a law: Newton's and Euler's equations with Coulomb's friction, along the reported motion.

At every sample the accelerations follow from the reported pose and velocities: the contact's acceleration condition
gives the normal force, Coulomb's law the friction. Their integral is compared with the reported velocities. No reported
force is used, so the law applies to every engine.

The kinematics. C is the track's point at the contact, r = C − G its lever, t and n the track's tangent and left
normal, κ the track's and κ_p the outline's curvature, u the slip velocity. The contact moves along the track with
ṡ = (ω − κ_p u)/(κ − κ_p): the tangents turn together, and u = ṡ − ṡ_p. The plate's material point there has no
velocity along n; the time derivative of this condition is n·a + α (r·t) = −ω (ṡ − t·v) + κ ṡ u. Without slip u stays 0,
so that t·a − α (r·n) = −ω (n·v).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Load, PerfectlyRough, RollingResistance, Unilateral
from cases.contact import follow, slip_velocity
from cases.errors import DoesNotFit
from cases.motion.mechanics import gravity

from .runs import Check, LawRun, Steps, ease, law
from .scenes import MORE_SCENES, SCENES

# More samples than this do not change the integrals: the trapezoidal rule has an error of (T/n)² of them.
MOST_SAMPLES = 2000
# Samples of stick before a beginning of slip counts as a breakaway.
LASTING_STICK = 10
# A value that fits and is less than this part of the case's is zero: what roundings leave of the integrals.
NOTHING = 1e-9


class ContactSamples(NamedTuple):
    """A reported motion at n samples, with the geometry of its contact. Vectors have the shape (2, n)."""

    t: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray
    slip: np.ndarray
    tangent: np.ndarray
    normal: np.ndarray
    lever: np.ndarray
    bend: np.ndarray
    plate_bend: np.ndarray
    load: np.ndarray  # (3, n)
    touching: np.ndarray


@dataclass(frozen=True)
class Mechanics:
    """The parameters of the equations of motion; each is a number, so that one can be varied alone."""

    g: float
    direction: float  # of gravity, rad
    mu: float
    mu_static: float | None  # None: that of slip
    mass: float
    inertia: float
    arm: float
    fx: float = 1.0  # shares of the load's components
    fy: float = 1.0
    moment: float = 1.0
    curvature: float = 1.0  # share of the track's
    rough: bool = False
    unilateral: bool = True

    @classmethod
    def of(cls, case: Case) -> Mechanics:
        """The parameters of the case."""
        gx, gy = gravity(case)
        friction, resistance = case.effect(CoulombFriction), case.effect(RollingResistance)
        return cls(
            g=float(np.hypot(gx, gy)),
            direction=float(np.arctan2(gy, gx)),
            mu=friction.mu if friction else 0.0,
            mu_static=friction.mu_static if friction else None,
            mass=case.plate.mass,
            inertia=case.plate.inertia,
            arm=resistance.arm if resistance else 0.0,
            rough=case.effect(PerfectlyRough) is not None,
            unilateral=case.effect(Unilateral) is not None,
        )

    @property
    def stick(self) -> float:
        """The coefficient of stick."""
        return self.mu if self.mu_static is None else self.mu_static


class Accelerations(NamedTuple):
    """(ẍ, ÿ, θ̈) at n samples, and the friction that stick takes as a share of the normal force."""

    rates: np.ndarray  # (3, n)
    needed: np.ndarray


def kinematics(run: LawRun) -> ContactSamples:
    """The motion's samples; raises AssertionError if the plate is not near its track."""
    case, motion = run.case, run.motion
    places = np.unique(np.linspace(0, len(motion.t) - 1, min(len(motion.t), MOST_SAMPLES)).astype(int))
    t, x, y, theta = (values[places] for values in (motion.t, motion.x, motion.y, motion.theta))
    vx, vy, omega = (values[places] for values in (motion.vx, motion.vy, motion.omega))
    touching = np.isfinite(motion.slip[places])
    xi1, xi2 = np.full(len(t), case.start.xi1), np.full(len(t), case.start.xi2 or 0.0)
    if touching.all():
        try:
            xi1, xi2, _ = follow(case, x, y, theta)
        except DoesNotFit as problem:
            raise AssertionError(f"equations of motion: the plate leaves its track ({problem})") from None
    elif touching.any():
        touching[:] = True  # parts in flight are for other laws: `_check` compares only motions of one kind
    load = np.zeros((3, len(t)))
    formula = case.effect(Load)
    if formula:
        load = np.array([formula.at(*map(float, row)) for row in zip(t, x, y, theta, vx, vy, omega, strict=True)]).T
    return ContactSamples(
        t=t,
        velocity=np.array([vx, vy]),
        omega=omega,
        slip=slip_velocity(case, x, y, vx, vy, omega, xi1, t),
        tangent=case.track.tangent(xi1),
        normal=case.track.normal(xi1),
        lever=case.track.point(xi1) - (x, y),
        bend=np.broadcast_to(case.track.curvature(xi1), t.shape),
        plate_bend=np.broadcast_to(case.plate.outline.curvature(xi2), t.shape),
        load=load,
        touching=touching,
    )


def accelerations(model: Mechanics, k: ContactSamples, threshold: float) -> Accelerations:
    """The accelerations that the equations of motion give; slip below the threshold (m/s) is treated as stick."""
    mass, inertia = model.mass, model.inertia
    gx, gy = model.g * np.cos(model.direction), model.g * np.sin(model.direction)
    free = np.array([gx + model.fx * k.load[0] / mass, gy + model.fy * k.load[1] / mass])
    free_spin = model.moment * k.load[2] / inertia
    along, across = np.sum(k.lever * k.tangent, axis=0), np.sum(k.lever * k.normal, axis=0)
    # From the condition itself: an error of n·v, such as half a step of gravity, would be multiplied by the spin.
    outward = -k.omega * along
    forward = np.sum(k.velocity * k.tangent, axis=0)
    bend = model.curvature * k.bend
    pace = (k.omega - k.plate_bend * k.slip) / (bend - k.plate_bend)
    # Right-hand sides of the two conditions, less what acts without the contact.
    normal_rest = -k.omega * (pace - forward) + bend * pace * k.slip - np.sum(free * k.normal, axis=0)
    normal_rest -= free_spin * along
    tangent_rest = -k.omega * outward - np.sum(free * k.tangent, axis=0) + free_spin * across
    # A couple arm·N against the spin acts with the normal force.
    couple = -model.arm * np.sign(k.omega)
    # Stick: two equations for N and T. n·(force/m) + along·(moment/J), with moment = along N − across T + couple N.
    a11 = 1 / mass + along * (along + couple) / inertia
    a12 = -along * across / inertia
    a21 = -across * (along + couple) / inertia
    a22 = 1 / mass + across**2 / inertia
    det = a11 * a22 - a12 * a21
    stick_normal = (a22 * normal_rest - a12 * tangent_rest) / det
    stick_friction = (a11 * tangent_rest - a21 * normal_rest) / det
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.abs(stick_friction / stick_normal)
    sticks = (np.abs(k.slip) <= threshold) & ((needed <= model.stick) | model.rough) | model.rough
    direction = np.where(np.abs(k.slip) <= threshold, np.sign(-stick_friction), np.sign(k.slip))
    ratio = -direction * model.mu
    normal = normal_rest / (a11 + a12 * ratio)
    pulled = normal_rest / (a11 - a12 * ratio)  # where the track pulls, friction has the sign of −N
    ratio = np.where(normal < 0.0, -ratio, ratio)
    normal = np.where(normal < 0.0, pulled, normal)
    friction = np.where(sticks, stick_friction, ratio * normal)
    normal = np.where(sticks, stick_normal, normal)
    gone = ~k.touching | (normal < 0.0) & model.unilateral
    normal, friction = np.where(gone, 0.0, normal), np.where(gone, 0.0, friction)
    rates = np.empty((3, len(k.t)))
    rates[:2] = free + (normal * k.normal + friction * k.tangent) / mass
    rates[2] = free_spin + (normal * (along + couple) - friction * across) / inertia
    return Accelerations(rates, needed)


def residuals(model: Mechanics, k: ContactSamples, threshold: float) -> np.ndarray:
    """The reported changes of velocity less the integrals of the accelerations, (3, n) in m/s, m/s and rad/s."""
    from scipy.integrate import cumulative_trapezoid  # slow to import

    reported = np.array([*k.velocity, k.omega])
    integral = cumulative_trapezoid(accelerations(model, k, threshold).rates, k.t, initial=0.0)
    return reported - reported[:, :1] - integral


@law("equations of motion", (*SCENES, *MORE_SCENES))
def equations_of_motion(scene: Case) -> Steps:
    """m v and J ω change as the case's forces and the contact's conditions require, at every sample."""
    run = yield scene
    k = kinematics(run)
    threshold = 2 * run.motion.slip_resolution + run.kick * ease(scene.plate)
    model, tolerance = Mechanics.of(scene), tolerances(run, k, threshold)
    off = residuals(model, k, threshold)

    def suspects() -> str:
        return suspicion(model, k, threshold, tolerance)

    for what, error, allowed in zip(("vx", "vy", "omega"), off, tolerance, strict=True):
        yield what, error, allowed, suspects
    if not run.case.effect(PerfectlyRough) and model.mu:
        yield from _breakaway(run, k, model, threshold)
    early = run.case.duration - float(run.motion.t[-1])
    yield "the end of the motion", early, 2 * run.step, "Unilateral: the plate leaves its track"


def tolerances(run: LawRun, k: ContactSamples, threshold: float) -> np.ndarray:
    """The residuals of a solver of first order with the run's step, (3, n) in m/s, m/s and rad/s.

    The velocities are those of up to a step earlier or later (`kick`), and so are the velocities from which the
    accelerations are computed: an acceleration v² κ or ω² e then differs by 2 kick over the radius of the motion, for
    the whole time. Friction may have either sign while the slip is below the threshold, which counts from the first
    such sample on. On facets a normal has the error `corners`, and so has the direction of the velocity.
    """
    from scipy.integrate import cumulative_trapezoid  # slow to import

    plate = run.case.plate
    turn = np.hypot(*k.velocity) * np.abs(k.bend) + np.abs(k.omega) * (1 - plate.inner / plate.reach)
    lasting = 2 * cumulative_trapezoid(turn, k.t, initial=0.0)
    grain = 10 * run.rounding * run.speed * len(run.motion.t) ** 0.5
    unsure = np.maximum.accumulate(np.abs(k.slip) <= threshold) * 2 * threshold / ease(plate)
    velocity = run.kick * (1 + lasting) + unsure + run.speed * run.corners + grain
    return np.array([velocity, velocity, plate.mass * plate.reach / plate.inertia * velocity])


def _breakaway(run: LawRun, k: ContactSamples, model: Mechanics, threshold: float) -> Iterator[Check]:
    """Slip begins after stick only where friction has reached its bound."""
    needed = accelerations(model, k, threshold).needed
    sticking = np.abs(k.slip) <= threshold
    for i in np.flatnonzero(sticking[:-1] & ~sticking[1:]):
        steady = sticking[max(0, i - LASTING_STICK) : i + 1]
        leaves = np.abs(k.slip[i + 1 : i + 1 + LASTING_STICK])
        if len(steady) <= LASTING_STICK or not steady.all() or not (leaves > threshold).all():
            continue
        short = model.stick - needed[i]
        which = "mu" if model.mu_static is None else "mu_static"
        yield (
            f"friction over the normal force at the breakaway at {k.t[i]:.4g} s",
            max(float(short), 0.0),
            run.tilt + 1e-3 * model.stick,
            f"{which} of CoulombFriction: slip begins at {needed[i]:.4g}, the case has {model.stick:.4g}",
        )


# --- which parameter --------------------------------------------------------------------------------------------------


def suspicion(model: Mechanics, k: ContactSamples, threshold: float, scale: np.ndarray) -> str:
    """Which single parameter with another value explains the motion, and that value; what is left if none does."""

    def size(candidate: Mechanics) -> float:
        return float(np.sqrt(np.mean((residuals(candidate, k, threshold) / scale) ** 2)))

    before, fits = size(model), []
    for name, (_, acts) in PARAMETERS.items():
        if acts(model, k):
            value = _fit(name, model, k, threshold, scale)
            fits.append((size(_with(model, name, value)), name, value))
    fits.sort()
    # What explains the motion leaves no more than the tolerance, or a small part of a large error.
    if not fits or fits[0][0] > max(1.0, 0.05 * before):
        return "no single parameter explains it; check the geometry of track and plate, and what the columns contain"
    best = [fit for fit in fits if fit[0] <= 1.5 * fits[0][0] + 0.05]
    return " or ".join(_suspect(name, value, getattr(model, name)) for _, name, value in best)


def _suspect(name: str, fit: float, has: float) -> str:
    """A parameter in words, with the value that fits, zero if it is a rounding of the case's, and that of the case."""
    fit = fit if abs(fit) > NOTHING * abs(has) else 0.0
    return f"{PARAMETERS[name][0]}: {fit:.4g} would fit, the case has {has:.4g}"


# The parameters by their names in `Mechanics`: in words, and whether a motion depends on them.
PARAMETERS: dict[str, tuple[str, Callable[[Mechanics, ContactSamples], object]]] = {
    "g": ("g of Gravity", lambda model, k: model.g),
    "direction": ("direction of Gravity", lambda model, k: model.g),
    "mu": ("mu of CoulombFriction", lambda model, k: model.mu),
    "mu_static": ("mu_static of CoulombFriction", lambda model, k: model.mu_static not in (None, model.mu)),
    "inertia": ("inertia of the plate", lambda model, k: k.touching.any() or k.load[2].any()),
    "mass": ("mass of the plate", lambda model, k: k.load[:2].any()),
    "arm": ("arm of RollingResistance", lambda model, k: model.arm),
    "fx": ("fx of Load (as a share)", lambda model, k: k.load[0].any()),
    "fy": ("fy of Load (as a share)", lambda model, k: k.load[1].any()),
    "moment": ("moment of Load (as a share)", lambda model, k: k.load[2].any()),
    "curvature": ("curvature of the track (as a share)", lambda model, k: k.touching.any() and k.bend.any()),
}
_OF_ANY_SIGN = ("direction", "fx", "fy", "moment", "curvature")
# Evaluations of a fit: parameters that are off by a factor of ten take six steps.
MOST_FITS = 24


def _with(model: Mechanics, name: str, value: float) -> Mechanics:
    return replace(model, **{name: value})  # type: ignore[arg-type]


def _fit(name: str, model: Mechanics, k: ContactSamples, threshold: float, scale: np.ndarray) -> float:
    """The value of one parameter that fits best."""
    from scipy.optimize import least_squares  # slow to import

    def off(value: np.ndarray) -> np.ndarray:
        return (residuals(_with(model, name, float(value[0])), k, threshold) / scale).ravel()

    true = getattr(model, name)
    least = -np.inf if name in _OF_ANY_SIGN else 0.02 * true
    # Differences over a change that is larger than the kinks between stick and slip.
    return float(least_squares(off, true, bounds=(least, np.inf), diff_step=1e-3, max_nfev=MOST_FITS).x[0])
