"""Equations of the second formulation: forces in the contact's own frame.

State (ξ₁, ξ₂, ω, v): contact parameters, spin and slip velocity. Only curvatures occur, no third derivatives:

    ṡ_track = (ω − κ_outline v) / (κ_track − κ_outline),      ṡ_outline = ṡ_track − v,

(on a corner of the track ṡ_track = 0 and ṡ_outline = −v, on one of the outline ṡ_track = v and ṡ_outline = 0), and
Newton–Euler is written along tangent and normal for the plate's material point at the contact, whose acceleration
is v̇ t + (v κ_track ṡ_track − ω ṡ_outline) n. On a belt the state has the slip relative to it; v and v̇ in these
formulas are then slip plus speed of the belt, and their rates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import copysign, cos, hypot, inf, isfinite, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from cases import Belt, Case, CoulombFriction, Gravity, Load, Mode, PerfectlyRough, RollingResistance, Unilateral
from cases.contact import pose
from cases.curves.corner import Corner
from cases.own_effects import own_effects
from cases.scene.piece_case import PieceCase

from .drive import DriveLoad
from .loads import load_scales, slip_scales
from .steps import StepFailure

# Curvatures are sampled at this many places of a track; a track whose values agree to `EVEN` is a line or a circle.
TRACK_SAMPLES, EVEN = 721, 1e-9
# On a track without ends the places lie between NEAR and FAR from the start, in sizes of the plate, closer together
# near it; features are included up to FEATURE_RANGE sizes away.
NEAR, FAR, FEATURE_RANGE = 1e-3, 1e6, 100.0

# A scene at rest without forces is searched for a load that sets in later: this many doublings of time, from 2⁻⁴⁰ s.
DOUBLINGS = 80


class ContactPhase(NamedTuple):
    """The state of the contact, finer than a mode: within one phase all forces are smooth.

    `slip`, `turn`: direction of slip and of rotation (±1), 0 if it is kept at zero, None if nothing opposes it; `side`:
    sign of the normal force.
    """

    slip: int | None
    turn: int | None
    side: int = 1

    @property
    def mode(self) -> Mode:
        if self.slip is None:
            return Mode.SLIDE
        if self.slip:
            return Mode.SLIP_FORWARD if self.slip > 0 else Mode.SLIP_BACKWARD
        return Mode.REST if self.turn == 0 else Mode.ROLL


class Forces(NamedTuple):
    """Contact forces (N) and couple (N m), rates of spin and slip.

    `push` (N/kg) has the normal force's sign if `inverse_mass` is positive; `inverse_mass` is Painlevé's number.
    """

    normal: float
    friction: float
    couple: float
    spin_rate: float
    slip_rate: float
    push: float
    inverse_mass: float


class Place(NamedTuple):
    """Geometry at one pair of contact parameters, in the frame: speeds, curvatures, arm from the centre of mass.

    At a corner the curvature is infinite and the speed is zero.
    """

    P: float
    p: float
    tx: float
    ty: float
    bend_track: float
    bend_outline: float
    arm_t: float
    arm_n: float


class ContactLaws(NamedTuple):
    """The coefficients of friction and rolling resistance; None: the case has no such effect; infinite: no bound, as
    for a perfectly rough contact, and for the rotation of a plate of infinite inertia."""

    slip: float | None  # coefficient against slip; of one that depends on the slip speed, its value at v = 0
    stick: float  # coefficient that holds
    arm: float | None
    by_speed: Callable[[float], float] | None = None  # the coefficient that depends on the slip speed


def _laws(friction: CoulombFriction | None, arm: float | None) -> ContactLaws:
    if friction is None:
        return ContactLaws(None, 0.0, arm)
    return ContactLaws(friction.at_rest, friction.stick, arm, friction.at if friction.by_speed else None)


class ContactScene:
    """The numbers of a case, extracted once."""

    def __init__(self, case: Case, drive_load: DriveLoad | None = None):
        self.case = case
        self.track, self.outline = case.track, case.plate.outline
        self.is_corner = isinstance(self.track, Corner) or isinstance(self.outline, Corner)
        self.m, self.J = case.plate.mass, case.plate.inertia
        gravity, friction = case.effect(Gravity), case.effect(CoulombFriction)
        self.g = gravity.vector if gravity else (0.0, 0.0)
        load, resistance = case.effect(Load), case.effect(RollingResistance)
        self.load: Callable[..., list[float]] | None = drive_load.at if drive_load else load.at if load else None
        self.load_scales = drive_load.scales if drive_load else load_scales(load)
        self.slip_scales = slip_scales(friction)
        arm = resistance.arm if resistance else None if case.plate.turns else inf
        if case.effect(PerfectlyRough):
            self.laws = ContactLaws(inf, inf, arm)
        else:
            self.laws = _laws(friction, arm)
        self.belt = case.effect(Belt)
        self.own = own_effects(case.effects)
        self.unilateral = case.effect(Unilateral) is not None
        # Features that a step could pass over: in time, and by the first two rows of a state in contact.
        self.in_time = [(None, load.features)] if load and load.features else []
        self.in_time += [(None, feature) for feature in drive_load.features] if drive_load else []
        curves = [(row, curve.features) for row, curve in enumerate((self.track, self.outline))]
        belt = [(None, self.belt.features if self.belt else None)]
        self.in_contact = [*self.in_time, *((row, features) for row, features in [*belt, *curves] if features)]
        whole = case.whole.plate.outline if isinstance(case, PieceCase) else self.outline
        self.reach = float(np.hypot(*whole.point(np.linspace(*whole.span, TRACK_SAMPLES))).max())
        self.turn = case.turn if isinstance(case, PieceCase) else 0.0
        self.is_disc = case.plate.radius is not None
        self.grain = self._grain()

    def _grain(self) -> float:
        """The length (m) along the track over which the forces on the plate change; infinite on an endless line.

        For a circle it is the radius, for a line with ends their distance, for any other curve at most the plate's
        size.
        """
        if isinstance(self.track, Corner):
            return self.reach
        with np.errstate(all="ignore"):  # far out a curve may be too large for a double
            bends = np.abs(np.asarray(self.track.curvature(self._sample_parameters())))
        bends = bends[np.isfinite(bends)]
        bend = float(bends.max())
        if bend * self.reach <= EVEN:
            first, last = (self.track.point(end) for end in self.track.span)
            return float(np.hypot(*(last - first))) if self.ends else inf
        return 1.0 / bend if np.ptp(bends) <= EVEN * bend else min(self.reach, 1.0 / bend)

    def _sample_parameters(self) -> np.ndarray:
        """Parameters of the track at which its curvature is sampled, chosen by distance, not by the parameter's
        unit."""
        if self.track.domain is not None or self.track.period:
            return np.linspace(*self.track.span, TRACK_SAMPLES)
        near = self.case.start.xi1
        size = self.reach / float(self.track.speed(near))
        away = size * np.geomspace(NEAR, FAR, TRACK_SAMPLES // 2)
        parameters = np.concatenate([near - away[::-1], [near], near + away])
        features = self.track.features
        return (
            np.union1d(parameters, features.places(near - FEATURE_RANGE * size, near + FEATURE_RANGE * size))
            if features
            else parameters
        )

    @property
    def ends(self) -> bool:
        """Whether the track has ends."""
        return self.track.ends is not None

    def place(self, xi1: float, xi2: float) -> Place:
        if self.is_corner:
            return self._place_at_corner(xi1, xi2)
        _, _, Xp, Yp, Xs, Ys, _, _ = self.track.jet(xi1)
        x, y, xp, yp, xs, ys, _, _ = self.outline.jet(xi2)
        P, p = hypot(Xp, Yp), hypot(xp, yp)
        return Place(
            P, p, Xp / P, Yp / P, (Xp * Ys - Yp * Xs) / P**3, (xp * ys - yp * xs) / p**3,
            (x * xp + y * yp) / p, (y * xp - x * yp) / p,
        )  # fmt: skip

    def _place_at_corner(self, xi1: float, xi2: float) -> Place:
        along, (x, y), angle = self.track.tangent(xi1), self.outline.point(xi2), self.outline.tangent_angle(xi2)
        c, s = cos(angle), sin(angle)
        return Place(
            float(self.track.speed(xi1)), float(self.outline.speed(xi2)), float(along[0]), float(along[1]),
            float(self.track.curvature(xi1)), float(self.outline.curvature(xi2)),
            float(x * c + y * s), float(y * c - x * s),
        )  # fmt: skip

    def surface(self, t: float) -> tuple[float, float]:
        """The speed of the track's surface along the track (m/s), and its rate (m/s²)."""
        if self.belt is None:
            return 0.0, 0.0
        speed, rate = self.belt.at(t)
        if not (isfinite(speed) and isfinite(rate)):
            raise StepFailure(f"the belt's speed has no value at t = {t:.9g} s; end the case before")
        return speed, rate

    def absolute(self, t: float, z) -> list[float]:
        """The state (ξ₁, ξ₂, ω, v) with the velocity v of the plate's point in place of its slip."""
        return [z[0], z[1], z[2], z[3] + self.surface(t)[0]]

    def pull(self, t: float, body) -> tuple[float, float, float]:
        """Gravity and load per mass: acceleration in the fixed frame and M/m, for (x, y, θ, vx, vy, ω)."""
        if self.load is None:
            return self.g[0], self.g[1], 0.0
        try:
            fx, fy, moment = self.load(t, *body)
        except (ArithmeticError, ValueError) as problem:
            raise StepFailure(f"the load has no value at t = {t:.9g} s ({problem}); end the case before") from None
        return self.g[0] + fx / self.m, self.g[1] + fy / self.m, moment / self.m

    def body(self, t: float, z, turns: int) -> list[float]:
        """(x, y, θ, vx, vy, ω) of the plate in contact at time t; `turns` whole turns are added to the angle that (6)
        gives."""
        return self.body_with(self.absolute(t, z), turns)

    def body_with(self, z, turns: int, q: Place | None = None) -> list[float]:
        """The same from (ξ₁, ξ₂, ω) and the velocity of the plate's point, which is not relative to a belt; `q`: the
        place of the state, if it is known."""
        xi1, xi2, w, v = z
        q = q or self.place(xi1, xi2)
        x, y, theta = pose(self.case, xi1, xi2)
        # (11): the centre of mass moves as the contact's material point less ω U arm.
        along, across = v + w * q.arm_n, -w * q.arm_t
        vx, vy = along * q.tx - across * q.ty, along * q.ty + across * q.tx
        return [float(x), float(y), float(theta) + self.turn + 2 * pi * turns, vx, vy, w]

    def load_allows(self, times: np.ndarray, states: np.ndarray, turns: int) -> bool:
        """Whether the load allows a step through these states (ξ₁, ξ₂, ω, v) of the contact, shape (4, n)."""
        if self.load_scales is None:
            return True
        pairs = zip(times.tolist(), states.T.tolist(), strict=True)
        return self.load_allows_flight(times, np.array([self.body(t, z, turns) for t, z in pairs]).T)

    def load_allows_flight(self, times: np.ndarray, bodies: np.ndarray) -> bool:
        """Whether the load allows a step of a flight through (x, y, θ, vx, vy, ω), shape (6, n)."""
        return self.load_scales is None or self.load_scales.allows(times, *bodies)

    def slip_allows(self, times: np.ndarray, states: np.ndarray, phase: ContactPhase) -> bool:
        """Whether friction's law allows a step through these states in a phase of slip."""
        return self.slip_scales is None or not phase.slip or self.slip_scales.allows(phase.slip * states[3])

    def pull_in_contact(self, t: float, z, q: Place, turns: int) -> tuple[float, float, float]:
        """What `pull` gives, and the forces of the user's own effects, which act at the contact."""
        ax, ay, spin_pull = self.pull(t, self.body_with(self.absolute(t, z), turns, q) if self.load else None)
        for along, across, own_spin_pull in self._own_pulls(t, z, q):
            ax, ay = ax + along * q.tx - across * q.ty, ay + along * q.ty + across * q.tx
            spin_pull += own_spin_pull
        return ax, ay, spin_pull

    def _own_pulls(self, t: float, z, q: Place) -> Iterator[tuple[float, float, float]]:
        """For each of the user's own effects its force along tangent and normal and its moment, per mass."""
        for effect in self.own:
            along, across, couple = (value / self.m for value in effect.at(t, z[3], z[2])[:3])
            if not isfinite(along + across + couple):
                raise StepFailure(f"{type(effect).__name__} has no value at t = {t:.9g} s; end the case before")
            yield along, across, q.arm_t * across - q.arm_n * along + couple

    def own_lift(self, t: float, z) -> float:
        """The gap's acceleration (m/s²) by the user's own effects, which act in contact alone."""
        if not self.own:
            return 0.0
        q = self.place(z[0], z[1])
        return sum((lift + q.arm_t * moment * self.m / self.J for _, lift, moment in self._own_pulls(t, z, q)), 0.0)

    def forces(self, t: float, z, phase: ContactPhase, turns: int) -> Forces:
        """Forces and rates in one phase: Newton–Euler with one linear condition each on friction and couple."""
        return self.forces_at(self.place(z[0], z[1]), t, z, phase, turns)

    def forces_at(self, q: Place, t: float, z, phase: ContactPhase, turns: int) -> Forces:
        """The same from the place of the state, which takes half of the time."""
        (speed, speed_rate), w = self.surface(t), z[2]
        v = z[3] + speed
        ax, ay, spin_pull = self.pull_in_contact(t, z, q, turns)
        along_track, along_outline = speeds(q, w, v)
        J, at, an = self.J / self.m, q.arm_t, q.arm_n
        turning = v * (w + q.bend_outline * along_outline) if q.P == 0.0 else v * q.bend_track * along_track
        down = turning - w * along_outline + w * w * an - (ay * q.tx - ax * q.ty)
        back = w * w * at - (ax * q.tx + ay * q.ty) + speed_rate
        # Per mass N = down − ω̇ arm_t for every phase; v̇ = −back + T − ω̇ arm_n; J ω̇ = arm_t N − arm_n T + couple.
        friction, couple = ratios(self.laws, phase, z[3])
        if phase.turn == 0:
            N, spin_rate, push, inverse_mass = down, 0.0, down, 1.0
            T = back if phase.slip == 0 else friction * N
            couple_now = an * T - at * N - spin_pull
        elif phase.slip == 0:
            free = J + an * an
            inverse_mass = 1.0 + at * (at + couple) / free
            push = down + at * (an * back - spin_pull) / free
            spin_rate = ((at + couple) * down - an * back + spin_pull) / (free * inverse_mass)
            N, T = down - spin_rate * at, back + spin_rate * an
            couple_now = couple * N
        else:
            lever = at - friction * an + couple
            inverse_mass = 1.0 + at * lever / J
            push = down - at * spin_pull / J
            N = push / inverse_mass
            T, spin_rate = friction * N, (lever * N + spin_pull) / J
            couple_now = couple * N
        slip_rate = 0.0 if phase.slip == 0 else T - back - spin_rate * an
        return Forces(self.m * N, self.m * T, self.m * couple_now, spin_rate, slip_rate, push, inverse_mass)

    def scale(self, t: float, z, turns: int) -> float:
        """The size of the scene's forces, N: their rounding is relative to it. It is at least the weight, with which a
        load may cancel."""
        return max(self._scale_at(self.place(z[0], z[1]), t, z, turns), self.m * hypot(*self.g))

    def _scale_at(self, q: Place, t: float, z, turns: int) -> float:
        ax, ay, spin_pull = self.pull_in_contact(t, z, q, turns)
        arm = hypot(q.arm_t, q.arm_n)
        return self.m * (hypot(ax, ay) + abs(spin_pull) * arm * self.m / self.J + z[2] ** 2 * arm)

    def pace(self, t: float, z, turns: int) -> float:
        """The rate at which the forces on the plate in contact change, rad/s: speed/length and √(acceleration/length).

        On a circle the length is a pendulum's, 1/κ_track − 1/κ_outline. Zero if nothing changes: for a disc on an
        endless line, whose forces are the same everywhere.
        """
        q, (_, _, w, v) = self.place(z[0], z[1]), self.absolute(t, z)
        along_track, along_outline = speeds(q, w, v)
        bends = [_relative_bend(q)]
        frequencies = [abs(along_track) / self.grain]
        if not self.is_disc:
            bends.append(1.0 / self.reach)
            frequencies += [abs(w), abs(along_outline) / self.reach]
        if self.grain * abs(q.bend_track) < 1.0 - EVEN or q.P == 0.0:
            bends.append(1.0 / self.grain)
        if self.belt:
            frequencies.append(sqrt(abs(self.surface(t)[1]) / self.reach))
        if self.load:
            frequencies.append(self.free_pace(t, self.body(t, z, turns)))
        return max(*frequencies, sqrt(self._scale_at(q, t, z, turns) / self.m * max(bends)))

    def free_pace(self, t: float, body) -> float:
        """The same rate for a plate off its track or under a load, rad/s: by the plate's own size."""
        ax, ay, spin_pull = self.pull(t, body)
        pull = hypot(ax, ay) + abs(spin_pull) * self.m / self.J * self.reach
        frequency = max(hypot(body[3], body[4]) / self.reach, abs(body[5]), sqrt(pull / self.reach))
        return frequency if frequency > 0.0 or self.load is None else self._pace_of_what_comes(t, body)

    def flight_pace(self, t: float, body) -> float:
        """The rate at which the velocities of a flight change, rad/s; functions in a load set bounds of their own.

        A force that grows with the speed moves a fast plate by many times its own size before it changes.
        """
        ax, ay, spin_pull = self.pull(t, body)
        pull = hypot(ax, ay) + abs(spin_pull) * self.m / self.J * self.reach
        speed = hypot(body[3], body[4]) + abs(body[5]) * self.reach
        change = min(sqrt(pull / self.reach), pull / speed) if speed > 0.0 else sqrt(pull / self.reach)
        frequency = max(abs(body[5]), change)
        return frequency if frequency > 0.0 else self._pace_of_what_comes(t, body)

    def _pace_of_what_comes(self, t: float, body) -> float:
        """The rate for a plate at rest without forces, rad/s: the inverse of the time until a load moves it."""
        soonest = inf
        for wait in 2.0 ** np.arange(DOUBLINGS) * 2.0**-40:
            if wait >= soonest:
                break
            try:
                ax, ay, spin_pull = self.pull(t + wait, body)
            except StepFailure:
                break  # the load ends there; a motion that reaches this time raises the error itself
            pull = hypot(ax, ay) + abs(spin_pull) * self.m / self.J * self.reach
            soonest = min(soonest, wait + sqrt(self.reach / pull)) if pull > 0.0 else soonest
        return 1.0 / soonest


def _relative_bend(q: Place) -> float:
    """The inverse of the difference of the radii of curvature; the radius of a corner is zero."""
    if q.P == 0.0 or q.p == 0.0:
        return abs(q.bend_outline if q.P == 0.0 else q.bend_track)
    return abs(q.bend_track * q.bend_outline / (q.bend_outline - q.bend_track))


def speeds(q: Place, w: float, v: float) -> tuple[float, float]:
    """Speeds of the contact point along track and outline."""
    if q.P == 0.0 or q.p == 0.0:
        return (0.0, -v) if q.P == 0.0 else (v, 0.0)
    along_track = (w - q.bend_outline * v) / (q.bend_track - q.bend_outline)
    return along_track, along_track - v


def ratios(laws: ContactLaws, phase: ContactPhase, v: float = 0.0) -> tuple[float, float]:
    """Friction and couple per normal force at slip v if they oppose a motion; 0 if they are absent or static."""
    friction = 0.0
    if phase.slip and laws.slip is not None:
        friction = -phase.side * phase.slip * (laws.by_speed(phase.slip * v) if laws.by_speed else laws.slip)
    couple = -phase.side * phase.turn * laws.arm if phase.turn and laws.arm is not None else 0.0
    return friction, couple


def rates(scene: ContactScene, t: float, z, phase: ContactPhase, turns: int) -> np.ndarray:
    """Time derivatives of (ξ₁, ξ₂, ω, v)."""
    q = scene.place(z[0], z[1])
    forces = scene.forces_at(q, t, z, phase, turns)
    w, v = z[2], z[3] + scene.surface(t)[0]
    along_track, along_outline = speeds(q, w, v)
    if q.P == 0.0:  # the tangent of the track turns with the plate and along its outline
        first = copysign(1.0, q.bend_track) * (w + q.bend_outline * along_outline)
        return np.array([first, along_outline / q.p, forces.spin_rate, forces.slip_rate])
    if q.p == 0.0:
        second = copysign(1.0, q.bend_outline) * (q.bend_track * along_track - w)
        return np.array([along_track / q.P, second, forces.spin_rate, forces.slip_rate])
    return np.array([along_track / q.P, along_outline / q.p, forces.spin_rate, forces.slip_rate])
