"""The second formulation, which certifies the first: the same physics in the moving frame of the contact.

It shares no code with `eliminated`, `augmented`, `transitions` or their integrators: numbers instead of symbols,
SciPy's `solve_ivp` with its own events, Coulomb's inequality instead of one-sided derivatives. Slow and simple on
purpose. `equations` has its forces, `flight` its flight and landing, `impact` its impacts; here
they follow each other.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from cases import Case, CaseError, Flight, Impact, Mode, Transition
from cases.contact import pose, start_motion

from . import bouncing, flight, hops, impact, overlap
from .bouncing import Bounce
from .equations import Phase, Scene, decide, leaves, lets_go, rates
from .flight import Surroundings, Touch
from .record import Record
from .steps import Lost, Paced

# The rows of an answer's `motions`.
MOTION = ("x", "y", "theta", "vx", "vy", "omega", "slip")

STOPS = {
    "painleve": "paradox",
    "fit": "no_fit",
    "track": "track_end",
    "outline": "outline_end",
    "elsewhere": "second_contact",
}

# A slip (or rotation) that has just begun is not watched for this part of the motion's own time: an instant located to
# 1e-13 may still lie inside the cone, where it would first go back by far less than anything resolved here.
BLIND = 1e-6

# Friction and normal force that are both below this part of the scene's forces when friction reaches its bound have
# vanished together: the contact ends, and no slip begins.
VANISHED = 1e-9

# A start's spin or slip that is this part of the other is a few roundings of it.
NOTHING = 1e-15

# Far more changes than any motion makes while it turns once; a loop without progress is told, not run for ever.
MOST_CHANGES = 5000

# A rebound is listed if its speed is at least this part of the greatest closing speed since the plate last lay on its
# track; slower ones belong to bouncing that comes to rest.
LISTED = 7e-4

# A flight is a hop close to the track if all that acts on the plate turns by no more than this (rad) before it is over.
SHORT = 1 / 32

# An accumulation's limit is taken when its time is known this well, or when bounces are this short, both in parts of
# the time in which the plate falls by its own size: nothing of what is left of them is resolved in the motions asked
# for (they rise by 1e-15 of that size).
SETTLED = 1e-13
SHORTEST = 1e-7

# A rebound that rises by no more than this part of the lengths that make its position, four roundings, is none: the end
# of bouncing, at its limit or, where none was found (each ends otherwise than the one before), at once.
OVER = 2.0**-50

# A gap this far below zero (in plate's sizes) at the end of a hop is one in another place: far above rounding.
ELSEWHERE = 1e-9


class Answer(NamedTuple):
    """The second formulation's motion: its transitions, how it ended, and what it does at the times asked for.

    `states` has shape (4, n): ξ₁, ξ₂, ω, v; `motions` has shape (7, n), rows as named in `MOTION`. Contact parameters
    and slip velocity are NaN in flight, everything is after the motion has ended; at an impact: what follows it.
    """

    transitions: tuple[Transition, ...]
    status: str
    end: float
    states: np.ndarray
    motions: np.ndarray


class Touching(NamedTuple):
    """The plate on its track: (ξ₁, ξ₂, ω, v), whole turns that θ is ahead of (6), and the phase."""

    z: list[float]
    turns: int
    phase: Phase


class Leap(NamedTuple):
    """Where a flight left the track: (ξ₁, ξ₂, ω, v), turns, normal velocity; how long a small one lasts (s), and
    whether it is one."""

    z: list[float]
    turns: int
    lift: float
    lasts: float
    short: bool


class Flying(NamedTuple):
    """The plate off its track: (x, y, θ, vx, vy, ω), and the leap that began it, if it began with one."""

    body: list[float]
    leap: Leap | None = None


class Landing(NamedTuple):
    """The plate that has just met its track: (ξ₁, ξ₂, ω, v), turns, and normal velocity."""

    z: list[float]
    turns: int
    lift: float


class Stopped(NamedTuple):
    """The end of a motion."""

    status: str


def solve(
    case: Case, rtol: float = 1e-10, times=(), looks: int = 60, until: float = inf, overlaps: bool = False
) -> Answer:
    """The case's motion by the second formulation, at most `until` that time (s).

    `looks` is how many steps it takes at least while what acts on the plate turns once (`Scene.pace`): events are found
    by their signs at steps' ends. With `overlaps` a second place in which plate and track meet is looked for too, and
    ends the motion. Raises Lost, a FloatingPointError with one sentence, where numbers leave the range of
    a double, a load has no value, or steps come to nothing.
    """
    march = None
    try:
        # An overflow or an undefined value would go on as inf or NaN.
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            march = _March(case, rtol, np.asarray(times, dtype=float), looks, until, overlaps)
            return march.run()
    except (Lost, CaseError):
        raise
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as problem:
        raise Lost(
            f"the second formulation's numbers leave the range of a double at t = {march.t if march else 0.0:.9g} s "
            f"({problem}); give sizes, speeds and coefficients nearer to one"
        ) from problem


class _March:
    """One motion on its way: what has happened so far, and the time."""

    def __init__(self, case: Case, rtol: float, times: np.ndarray, looks: int, until: float, overlaps: bool):
        self.case, self.scene = case, Scene(case)
        # An outline without an inside is only its contact arc.
        self.overlaps = overlaps and bool(case.plate.outline.period)
        self.rtol, self.looks, self.end = max(rtol, 1e-13), looks, min(case.duration, until)
        self.record = Record(case, times)
        self.t = 0.0
        self.transitions: list[Transition] = []
        self.bounces: list[Bounce] = []
        self.fastest = 0.0  # closing speed since the plate last lay on its track
        self.around: Surroundings | None = None  # sampled when the first flight begins
        self.last_xi1 = case.start.xi1

    def run(self) -> Answer:
        now: Touching | Flying | Stopped = self._start()
        changes, counted_until = 0, 0.0
        while not isinstance(now, Stopped):
            if self.t >= counted_until:
                changes, counted_until = 0, self.t + self._turn(now)
            changes += not (isinstance(now, Flying) and now.leap)  # rebounds end where they are no longer resolved
            if changes > MOST_CHANGES:
                now = Stopped("accumulation")
                break
            now = self._contact(now) if isinstance(now, Touching) else self._flight(now)
        if not self.record.finite_until(self.t):
            raise Lost(f"the second formulation's motion is not finite before t = {self.t:.9g} s; give smaller numbers")
        return Answer(tuple(self.transitions), now.status, self.t, self.record.states, self.record.motions)

    def _turn(self, now: Touching | Flying) -> float:
        """How long the plate takes to turn, or to go its own size, s."""
        body = now.body if isinstance(now, Flying) else self.scene.body(now.z, now.turns)
        pace = self.scene.free_pace(self.t, body)
        return 2 * pi / pace if pace > 0.0 else inf

    def _start(self) -> Touching | Flying | Stopped:
        begin = start_motion(self.case)
        body = [begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega]
        # A speed that is a few roundings of the other is none: it would turn back and return within a step unseen.
        size = sqrt(self.case.plate.inertia / self.case.plate.mass)
        omega = begin.omega if size * abs(begin.omega) > NOTHING * abs(begin.slip) else 0.0
        slip = begin.slip if abs(begin.slip) > NOTHING * size * abs(begin.omega) else 0.0
        z = [begin.xi1, begin.xi2, omega, slip]
        if self.case.start.in_contact:
            return self._touching(z, 0) or self._without_mode(z, 0)
        if self.case.start.gap > 0.0:
            return Flying(body)
        lift = self.case.start.gap_rate
        if lift < 0.0 or self._drowns(z, 0, lift):  # what rises by less than a rounding comes down at once, as fast
            return self._landing(Landing(z, 0, -abs(lift)))
        return self._leaps(z, 0, lift)

    # --- in contact -------------------------------------------------------------------------------------------------

    def _touching(self, z, turns: int, **known) -> Touching | None:
        """Contact at the present instant, if a phase of it is consistent; `known`: what has just been let go."""
        phase = decide(self.scene, self.t, z, turns, **known)
        return Touching(z, turns, phase) if phase else None

    def _without_mode(self, z, turns: int) -> Flying | Stopped:
        """No phase of contact is consistent: the plate leaves, or rigid contact has no answer (Painlevé)."""
        return self._off(z, turns) if leaves(self.scene, self.t, z, turns) else Stopped("paradox")

    def _off(self, z, turns: int) -> Flying | Stopped:
        if self.case.effect(Flight) is None:
            return Stopped("lift_off")
        self.last_xi1 = z[0]
        return Flying(self.scene.body(z, turns))

    def _contact(self, now: Touching) -> Touching | Flying | Stopped:
        phase, turns = now.phase, now.turns
        guards = self._guards(phase, turns)
        solution = self._integrate(now, guards)
        self.t, z = float(solution.t[-1]), [float(value) for value in solution.y[:, -1]]
        fired = [name for name, hits in zip(guards, solution.t_events, strict=True) if len(hits)]
        if not fired:
            return Stopped("completed")
        stop = next((STOPS[name] for name in fired if name in STOPS), None)
        if stop:
            return Stopped(stop)
        after: Touching | Flying | Stopped
        if self._vanishes(phase, fired, z, turns):
            if self.scene.laws.stick == inf and not lets_go(self.scene, self.t, z, phase, turns):
                return Stopped("paradox")
            after = self._off(z, turns)
        else:
            after = self._after(phase, fired, z, turns) or self._without_mode(z, turns)
        mode = after.phase.mode if isinstance(after, Touching) else Mode.FLIGHT
        if mode is not phase.mode and after != Stopped("paradox"):
            self.transitions.append(Transition(self.t, phase.mode, mode, z[0], z[1]))
        return after

    def _vanishes(self, phase: Phase, fired: list[str], z, turns: int) -> bool:
        """Whether the normal force has vanished: by itself, or together with the friction that it bounds."""
        if "normal_force" in fired:
            return True
        if not self.scene.unilateral or not any(name.startswith("cone") for name in fired):
            return False
        return self._forceless(phase, z, turns)

    def _forceless(self, phase: Phase, z, turns: int) -> bool:
        """Whether the contact's forces have vanished together."""
        held, scale = self.scene.forces(self.t, z, phase, turns), self.scene.scale(self.t, z, turns)
        return max(abs(held.friction), abs(held.normal)) <= VANISHED * scale

    def _after(self, phase: Phase, fired: list[str], z, turns: int) -> Touching | None:
        """What follows when a guard has fired; sets velocities that have vanished to zero. None: no phase does."""
        if "side" in fired:
            return Touching(z, turns, phase._replace(side=-phase.side))
        if "slip" in fired:
            z[3] = 0.0
        if "turn" in fired:
            z[2] = 0.0
        cone = any(name.startswith("cone") for name in fired)
        couple = any(name.startswith("couple") for name in fired)
        if couple and not self.scene.unilateral and self._forceless(phase, z, turns):
            return Touching(z, turns, phase._replace(side=-phase.side))  # the couple's bound vanished, and grows again
        return self._touching(z, turns, may_stick=not cone, may_hold=not couple)

    def _guards(self, phase: Phase, turns: int) -> dict[str, Callable]:
        """Functions of (t, z) that are positive while the phase lasts."""
        scene, laws = self.scene, self.scene.laws

        def forces(t, z):
            return scene.forces(t, z, phase, turns)

        guards: dict[str, Callable] = {}
        if phase.slip == 0 and laws.stick < inf:
            guards["cone+"] = lambda t, z: laws.stick * phase.side * (f := forces(t, z)).normal + f.friction
            guards["cone-"] = lambda t, z: laws.stick * phase.side * (f := forces(t, z)).normal - f.friction
        if phase.turn == 0 and laws.arm is not None:
            arm = laws.arm
            guards["couple+"] = lambda t, z: arm * phase.side * (f := forces(t, z)).normal + f.couple
            guards["couple-"] = lambda t, z: arm * phase.side * (f := forces(t, z)).normal - f.couple
        if phase.slip:
            guards["slip"] = lambda t, z: phase.slip * z[3]
        if phase.turn:
            guards["turn"] = lambda t, z: phase.turn * z[2]
        if phase.slip or phase.turn:
            guards["painleve"] = lambda t, z: forces(t, z).inverse_mass
        if scene.unilateral and not (phase.slip == 0 and laws.stick < inf):
            # Where friction holds, its cone closes before the normal force vanishes.
            guards["normal_force"] = lambda t, z: forces(t, z).normal
        if not scene.unilateral and (phase.slip is not None or phase.turn is not None):
            guards["side"] = lambda t, z: phase.side * forces(t, z).push
        guards["fit"] = lambda t, z: (q := scene.place(z[0], z[1])).bend_outline - q.bend_track
        if self.overlaps:
            around, body = self._surroundings(), scene.body
            guards["elsewhere"] = lambda t, z: overlap.gap_elsewhere(around, body(z, turns), z[0], z[1])
        for name, curve, i in (("track", scene.track, 0), ("outline", scene.outline, 1)):
            if curve.domain and not curve.period:
                guards[name] = _inside(i, *curve.domain)
        return guards

    def _integrate(self, now: Touching, guards: dict[str, Callable]):
        scene, phase, turns, start = self.scene, now.phase, now.turns, self.t
        just_begun = {"slip": now.z[3] == 0.0, "turn": now.z[2] == 0.0}
        if not scene.unilateral and self._forceless(phase, now.z, turns):
            just_begun |= {"couple+": True, "couple-": True, "side": True}  # bounds that vanish with the normal force
        pace = scene.pace(start, now.z, turns)
        blind = BLIND / pace if pace > 0.0 else inf
        events = []
        for name, guard in guards.items():
            watched = start + blind if just_begun.get(name) else start

            def event(t, z, guard=guard, watched=watched):
                return 1.0 if t < watched else guard(t, z)

            event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
            events.append(event)
        solution = solve_ivp(
            lambda t, z: rates(scene, t, z.tolist(), phase, turns), (start, self.end), now.z,
            method=Paced, rtol=self.rtol, atol=1e-2 * self.rtol, events=events, dense_output=bool(self.record),
            pace=lambda t, z: scene.pace(t, z.tolist(), turns), looks=self.looks,
            features=scene.in_contact,
        )  # fmt: skip
        if not solution.success or not np.isfinite(solution.y[:, -1]).all():
            raise Lost(f"the second formulation stopped at t = {solution.t[-1]:.9g} s: {solution.message}")
        self.record.contact(start, float(solution.t[-1]), solution.sol, turns)
        return solution

    # --- off the track ----------------------------------------------------------------------------------------------

    def _flight(self, now: Flying) -> Touching | Flying | Stopped:
        hop = self._short(now.leap) if now.leap and now.leap.short else None
        if hop is None:
            self.bounces.clear()  # no bounce of an accumulation yet
        after = hop or self._long(now)
        return self._landing(after) if isinstance(after, Landing) else after

    def _short(self, leap: Leap) -> Landing | None:
        """A hop close to the track; None if it is not: it lasts longer, or the plate meets the track elsewhere."""
        found = hops.hop(self.scene, self.t, leap.z, leap.turns, leap.lift, leap.lasts, self.rtol)
        if found is None or self.t + found.duration > self.end:
            return None
        around, middle_and_end = self._surroundings(), np.array([0.5, 1.0]) * found.duration
        if min(around.closest(body).gap for body in found.bodies(middle_and_end).T) < -ELSEWHERE * around.size:
            return None
        start, self.t = self.t, self.t + found.duration
        self.record.flight(start, self.t, lambda times: found.bodies(times - start))
        return Landing(found.z, leap.turns, found.lift)

    def _long(self, now: Flying) -> Landing | Stopped:
        """A flight to wherever the outline meets the track."""
        lasts = now.leap.lasts if now.leap else inf
        flown = flight.fly(self.scene, self._surroundings(), self.t, now.body, self.end, self.rtol, self.looks, lasts)
        self.t = flown.end
        for start, until, interpolant in flown.pieces:
            self.record.flight(start, until, interpolant)
        if flown.touch is None:
            return Stopped("completed")
        xi1, xi2, turns = self._wound(flown.touch)
        seen = flight.frame(self.scene, flown.touch.body, xi1, xi2)
        return Landing([xi1, xi2, flown.touch.body[5], seen.slip], turns, seen.lift)

    def _surroundings(self) -> Surroundings:
        if self.around is None:
            self.around = Surroundings(self.scene, self.last_xi1)
        return self.around

    def _landing(self, landing: Landing) -> Touching | Flying | Stopped:
        """What follows when the outline meets the track."""
        scene, effect = self.scene, self.case.effect(Impact)
        (xi1, xi2, spin, slip), turns = landing.z, landing.turns
        q = scene.place(xi1, xi2)
        if q.bend_outline <= q.bend_track:
            return Stopped("no_fit")
        if effect is None:
            return Stopped("landing")
        try:
            result = impact.hit(scene, effect, q, slip, min(landing.lift, 0.0), spin)
        except impact.Jammed:
            return Stopped("paradox")
        if impact.creates_energy(result):
            return Stopped("energy_gain")
        z = [xi1, xi2, result.spin, result.slip]
        self.last_xi1 = xi1
        self.fastest = max(self.fastest, -landing.lift)
        if result.lift == 0.0:
            return self._settled(z, turns)
        self.bounces.append(Bounce(self.t, (xi1, xi2, result.spin, result.slip), result.lift, result.phase))
        listed = result.lift >= LISTED * self.fastest and not self._drowns(z, turns, result.lift)
        limit = None if listed else self._accumulation(turns)
        if limit is not None:
            self.t = limit.time
            return self._settled(limit.z, turns)
        after = self._leaps(z, turns, result.lift)
        if listed and isinstance(after, Flying):
            self.transitions.append(Transition(self.t, Mode.FLIGHT, Mode.FLIGHT, xi1, xi2))
        return after

    def _press(self, z, turns: int) -> float:
        """The acceleration (m/s²) that brings a plate back to its track."""
        return self.scene.forces(self.t, z, Phase(None, None), turns).push

    def _drowns(self, z, turns: int, lift: float) -> bool:
        """Whether a rebound of that speed (m/s) rises no higher than a position's rounding."""
        q, (x, y) = self.scene.place(z[0], z[1]), self.scene.body(z, turns)[:2]
        return lift**2 <= 2.0 * self._press(z, turns) * OVER * (abs(x) + abs(y) + hypot(q.arm_t, q.arm_n))

    def _leaps(self, z, turns: int, lift: float) -> Touching | Flying | Stopped:
        """Flight from the track with a normal velocity."""
        press = self._press(z, turns)
        lasts = 2.0 * lift / press if press > 0.0 else inf
        if self._drowns(z, turns, lift) or self.t + lasts == self.t:
            return self._settled(z, turns)
        pace = self.scene.pace(self.t, z, turns) + sqrt(max(press, 0.0) / self.scene.reach)
        leap = Leap(z, turns, lift, lasts, lasts * pace <= SHORT)
        return Flying(hops.body(self.scene, [*z, lift, 0.0], turns), leap)

    def _settled(self, z, turns: int) -> Touching | Flying | Stopped:
        """A landing without rebound: contact, or the plate leaves at once because nothing presses it down."""
        self.bounces.clear()
        after = self._touching(z, turns)
        if after is None:
            return Flying(self.scene.body(z, turns)) if leaves(self.scene, self.t, z, turns) else Stopped("paradox")
        self.fastest = 0.0
        self.transitions.append(Transition(self.t, Mode.FLIGHT, after.phase.mode, z[0], z[1]))
        return after

    def _accumulation(self, turns: int) -> bouncing.Limit | None:
        """The end of ever shorter bounces, once it is known well enough and nothing is asked of the time before."""
        found, last = bouncing.limit(self.bounces), self.bounces[-1]
        if found is None or not self.t < found.time < self.end:
            return None
        press = self._press(last.z, turns)
        fall = sqrt(self.scene.reach / press) if press > 0.0 else 0.0
        if self.t - self.bounces[-2].time > SHORTEST * fall:
            known = found.error <= max(SETTLED * fall, np.spacing(self.t))
            if not known or self.record.asks_between(self.t, found.time):
                return None

        def settling(times: np.ndarray) -> np.ndarray:
            # What is left of the bounces is closer to their limit than anything resolved.
            part = (times - last.time) / (found.time - last.time)
            return np.array(last.z)[:, None] + np.outer(np.subtract(found.z, last.z), part)

        self.record.contact(self.t, found.time, settling, turns)
        return found

    def _wound(self, landing: Touch) -> tuple[float, float, int]:
        """Contact parameters of a landing on closed curves: the track's nearest to the last, the outline's such that
        (6) gives the plate's angle; and the whole turns that remain where the outline is open."""
        track, outline, xi1, xi2 = self.scene.track, self.scene.outline, landing.xi1, landing.xi2
        if track.period:
            xi1 += track.period * round((self.last_xi1 - xi1) / track.period)
        turns = round((landing.body[2] - float(pose(self.case, xi1, xi2)[2])) / (2 * pi))
        return (xi1, xi2 - turns * outline.period, 0) if outline.period else (xi1, xi2, turns)


def _inside(i: int, low: float, high: float):
    return lambda t, z: min(z[i] - low, high - z[i])
