"""The second formulation, which certifies the first: the same physics in the moving frame of the contact.

State (ξ₁, ξ₂, ω, v): contact parameters, spin and slip velocity. Only curvatures occur, no third derivatives:

    ṡ_track = (ω − κ_outline v) / (κ_track − κ_outline),      ṡ_outline = ṡ_track − v,

and Newton–Euler is written along tangent and normal for the plate's material point at the contact, whose acceleration
is v̇ t + v κ_track ṡ_track n. It shares no code with `eliminated`, `augmented`, `transitions` or their integrators:
numbers instead of symbols, SciPy's `solve_ivp` with its own events, Coulomb's inequality instead of one-sided
derivatives. Slow and simple on purpose.
"""

from __future__ import annotations

from math import cos, hypot, sin
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from cases import Case, CoulombFriction, Gravity, Mode, NotSupported, Transition, Unilateral

STOPS = {"painleve": "paradox", "fit": "no_fit", "track": "track_end", "outline": "outline_end"}

# A slip that has just begun is not watched for this part of the duration: an instant located to 1e-13 may still lie
# inside the cone, where slip would first go back by far less than anything resolved here.
BLIND = 1e-6

# Far more than any motion of a few seconds has; a loop without progress is told, not run for ever.
MOST_TRANSITIONS = 200


class Answer(NamedTuple):
    """The second formulation's motion: its transitions, how it ended, and its states at the times asked for.

    `states` has shape (4, n): ξ₁, ξ₂, ω, v; NaN after the motion has ended.
    """

    transitions: tuple[Transition, ...]
    status: str
    end: float
    states: np.ndarray


class Forces(NamedTuple):
    """Contact forces (N) and accelerations in one mode: spin rate, slip rate; `division` is Painlevé's number."""

    normal: float
    friction: float
    spin_rate: float
    slip_rate: float
    division: float


class Place(NamedTuple):
    """Geometry at one pair of contact parameters: speeds, curvatures, arm to the contact, gravity, in the frame."""

    P: float
    p: float
    bend_track: float
    bend_outline: float
    arm_t: float
    arm_n: float
    g_t: float
    g_n: float


class Scene:
    """A case's numbers, taken once."""

    def __init__(self, case: Case):
        if case.effect(Unilateral) is None and case.effect(CoulombFriction) is not None:
            raise NotSupported("the second formulation knows no two-sided guide with friction; add Unilateral")
        self.track, self.outline = case.track, case.plate.outline
        self.m, self.J = case.plate.mass, case.plate.inertia
        gravity, friction = case.effect(Gravity), case.effect(CoulombFriction)
        self.g = (gravity.g * cos(gravity.direction), gravity.g * sin(gravity.direction)) if gravity else (0.0, 0.0)
        self.friction = friction
        self.mu = friction.mu if friction else 0.0
        self.stick = friction.stick if friction else 0.0
        self.one_sided = case.effect(Unilateral) is not None

    def place(self, xi1: float, xi2: float) -> Place:
        _, _, Xp, Yp, Xs, Ys, _, _ = self.track.jet(xi1)
        x, y, xp, yp, xs, ys, _, _ = self.outline.jet(xi2)
        P, p = hypot(Xp, Yp), hypot(xp, yp)
        tx, ty = Xp / P, Yp / P
        return Place(
            P, p, (Xp * Ys - Yp * Xs) / P**3, (xp * ys - yp * xs) / p**3,
            (x * xp + y * yp) / p, (y * xp - x * yp) / p,
            self.g[0] * tx + self.g[1] * ty, self.g[1] * tx - self.g[0] * ty,
        )  # fmt: skip

    def sliding(self, z, direction: int) -> Forces:
        """Friction mu·N against slip in that direction (0: no friction)."""
        q, (_, _, w, v) = self.place(z[0], z[1]), z
        along_track, along_outline = speeds(q, w, v)
        ratio = -direction * self.mu
        division = 1 + self.m / self.J * q.arm_t * (q.arm_t - ratio * q.arm_n)
        N = self.m * (v * q.bend_track * along_track - w * along_outline + w * w * q.arm_n - q.g_n) / division
        spin_rate = N * (q.arm_t - ratio * q.arm_n) / self.J
        slip_rate = q.g_t + ratio * N / self.m - spin_rate * q.arm_n - w * w * q.arm_t
        return Forces(N, ratio * N, spin_rate, slip_rate, division)

    def rolling(self, z) -> Forces:
        """Friction as large as it takes to keep v = 0."""
        q, w = self.place(z[0], z[1]), z[2]
        _, along_outline = speeds(q, w, 0.0)
        down = w * w * q.arm_n - w * along_outline - q.g_n  # normal force per mass without spin rate
        back = w * w * q.arm_t - q.g_t
        spin_rate = (q.arm_t * down - q.arm_n * back) / (self.J / self.m + q.arm_t**2 + q.arm_n**2)
        N, T = self.m * (down - spin_rate * q.arm_t), self.m * (back + spin_rate * q.arm_n)
        return Forces(N, T, spin_rate, 0.0, 1.0)


def speeds(q: Place, w: float, v: float) -> tuple[float, float]:
    """Speeds of the contact point along track and outline."""
    along_track = (w - q.bend_outline * v) / (q.bend_track - q.bend_outline)
    return along_track, along_track - v


def solve(case: Case, rtol: float = 1e-10, times=(), looks: int = 60) -> Answer:
    """The case's motion by the second formulation.

    `looks` is how many steps the duration is divided into at least: events are found by their signs at steps' ends.
    Raises NotSupported for a case whose effects it does not know.
    """
    scene, t = Scene(case), 0.0
    z = start(case, scene)
    states = np.full((4, len(times)), np.nan)
    transitions: list[Transition] = []
    mode = _first_mode(case, scene, z)
    while mode is not Mode.FLIGHT:
        if len(transitions) > MOST_TRANSITIONS:
            return Answer(tuple(transitions), "accumulation", t, states)
        phase = _integrate(case, scene, mode, t, z, case.duration, rtol, looks, times, states)
        t, z = float(phase.t[-1]), [float(value) for value in phase.y[:, -1]]
        fired = [name for name, hits in zip(_guards(case, scene, mode), phase.t_events, strict=True) if len(hits)]
        if not fired:
            return Answer(tuple(transitions), "completed", t, states)
        stop = next((STOPS[name] for name in fired if name in STOPS), None)
        if stop:
            return Answer(tuple(transitions), stop, t, states)
        if fired[0] == "slip":
            z[3] = 0.0
        after = _following(scene, mode, fired[0], z)
        transitions.append(Transition(t, mode, after, z[0], z[1]))
        mode = after
    return Answer(tuple(transitions), "lift_off", t, states)


def start(case: Case, scene: Scene) -> list[float]:
    """The case's start as (ξ₁, ξ₂, ω, v)."""
    from cases.contact import level_parameter

    s = case.start
    return [s.xi1, level_parameter(case) if s.xi2 is None else s.xi2, s.omega, s.slip]


def _first_mode(case: Case, scene: Scene, z) -> Mode:
    if scene.friction is None:
        return Mode.SLIDE if not scene.one_sided or scene.sliding(z, 0).normal >= 0 else Mode.FLIGHT
    if z[3] != 0.0:
        direction = 1 if z[3] > 0 else -1
        return _slip(direction) if scene.sliding(z, direction).normal >= 0 else Mode.FLIGHT
    return _without_slip(scene, z)


def _slip(direction: float) -> Mode:
    return Mode.SLIP_FORWARD if direction > 0 else Mode.SLIP_BACKWARD


def _without_slip(scene: Scene, z) -> Mode:
    """Coulomb's inequality: rolling needs no more friction than the normal force allows, else it slips against it."""
    roll = scene.rolling(z)
    if abs(roll.friction) <= scene.stick * roll.normal:
        return Mode.ROLL
    direction = -roll.friction
    slip = scene.sliding(z, 1 if direction > 0 else -1)
    # A normal force of a rounding below zero is a release at N = 0, as in the paper's own start.
    scale = scene.m * (hypot(*scene.g) + abs(roll.friction) / scene.m)
    return _slip(direction) if slip.normal >= -1e-12 * scale else Mode.FLIGHT


def _following(scene: Scene, mode: Mode, guard: str, z) -> Mode:
    if guard == "normal_force":
        return Mode.FLIGHT
    if guard.startswith("cone"):
        return _slip(-scene.rolling(z).friction)
    return _without_slip(scene, z)


def _guards(case: Case, scene: Scene, mode: Mode) -> dict:
    """Functions of (t, z) that are positive while the mode lasts."""
    direction = {Mode.SLIP_FORWARD: 1, Mode.SLIP_BACKWARD: -1}.get(mode, 0)
    if mode is Mode.ROLL:
        guards = {
            "cone+": lambda t, z: scene.stick * (f := scene.rolling(z)).normal + f.friction,
            "cone-": lambda t, z: scene.stick * (f := scene.rolling(z)).normal - f.friction,
        }
    else:
        guards = {}
        if direction:
            guards["slip"] = lambda t, z: direction * z[3]
            guards["painleve"] = lambda t, z: scene.sliding(z, direction).division
        if scene.one_sided:
            guards["normal_force"] = lambda t, z: scene.sliding(z, direction).normal
    guards["fit"] = lambda t, z: (q := scene.place(z[0], z[1])).bend_outline - q.bend_track
    for name, curve, i in (("track", case.track, 0), ("outline", case.plate.outline, 1)):
        if curve.domain and not curve.period:
            guards[name] = _inside(i, *curve.domain)
    return guards


def _inside(i: int, low: float, high: float):
    return lambda t, z: min(z[i] - low, high - z[i])


def _integrate(case: Case, scene: Scene, mode: Mode, t, z, end, rtol, looks, times, states):
    direction = {Mode.SLIP_FORWARD: 1, Mode.SLIP_BACKWARD: -1}.get(mode, 0)

    def rates(_, z):
        z = z.tolist()
        q = scene.place(z[0], z[1])
        forces = scene.rolling(z) if mode is Mode.ROLL else scene.sliding(z, direction)
        along_track, along_outline = speeds(q, z[2], z[3])
        return [along_track / q.P, along_outline / q.p, forces.spin_rate, forces.slip_rate]

    events = []
    for name, guard in _guards(case, scene, mode).items():

        def event(now, z, guard=guard, blind=BLIND * case.duration if name == "slip" else 0.0):
            return 1.0 if now < t + blind else guard(now, z)

        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
        events.append(event)
    solution = solve_ivp(
        rates, (t, end), z, method="DOP853", rtol=max(rtol, 1e-13), atol=1e-2 * max(rtol, 1e-13), events=events,
        max_step=case.duration / looks, dense_output=bool(len(times)),
    )  # fmt: skip
    if not solution.success:
        raise FloatingPointError(f"the second formulation stopped at t = {solution.t[-1]:.9g} s: {solution.message}")
    if len(times):
        inside = (times >= t) & (times <= solution.t[-1])
        if inside.any():
            states[:, inside] = solution.sol(times[inside])
    return solution
