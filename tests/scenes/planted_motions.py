"""Faults that are planted in right motions: a table of (name, scene, how the faulty motion is made).

A fault is the motion of another scene, a right motion with some columns, transitions or its end changed, or a motion
given by formulas. Each is one in which an error of a solver, of a file or of its units would show.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, reduce
from math import inf, nan, pi
from typing import Any, NamedTuple

import numpy as np

import cases
import reference
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    Plate,
    Start,
    State,
    Support,
    Trajectory,
    Transition,
    Unilateral,
    disc,
)
from cases.contact import start_motion
from cases.curves import cos, exp, sin
from cases.library import line

Change = Callable[[Case], Case]
Columns = Callable[[np.ndarray], dict[str, Any]]

# As accurate as an integrator is.
RTOL = 1e-12
# A billionth more.
MORE = 1 + 1e-9
G = 9.81


class Fault(NamedTuple):
    """A planted fault: the scene, and what makes the faulty motion of it."""

    scene: Callable[[], Case]
    plant: Callable[[Case], Trajectory]


@cache
def simulate(case: Case, rtol: float = RTOL, method: str | None = None) -> Trajectory:
    """The motion of a scene, computed once."""
    return reference.simulate(case, rtol, method)


# --- scenes -----------------------------------------------------------------------------------------------------------


def catalogue(name: str, **parameters: float) -> Callable[[], Case]:
    """A case of the catalogue."""
    return cache(lambda: cases.load(name, **parameters))


def on_line(*effects, plate: Plate | None = None, duration: float = 2.0, **start: float) -> Case:
    """A disc on a level line with friction 0.2 unless the effects name another."""
    own = [e for e in (Gravity(G), CoulombFriction(0.2), Unilateral()) if not any(type(o) is type(e) for o in effects)]
    return Case(line(), plate or disc(0.1, 1.0), (*own, *effects), Start(**{"xi1": 0.0, **start}), duration)


def block() -> Plate:
    """A plate that does not turn."""
    return Plate(disc(0.1, 1.0).outline, 1.0, inf)


def loaded(**formulas: str) -> Callable[[], Case]:
    """A disc under a load."""
    return cache(lambda: on_line(Load(**formulas), slip=0.5))


@cache
def at_wall() -> Case:
    """A disc that rolls into a wall, without restitution."""
    wall = Support(Curve(lambda s: (0.8 + 0 * s, s)), "wall")
    return replace(on_line(Flight(), Impact(0.0), duration=1.0, slip=2.0), supports=(wall,))


def ripple(height: float, width: float, at: float = 0.3) -> Curve:
    """A level track with one ripple."""
    return Curve(lambda s: (s, height * exp(-(((s - at) / width) ** 2))), domain=(-3, 3))


def flown_over(height: float, width: float) -> Callable[[], Case]:
    """A disc that flies along a ripple."""
    effects = CoulombFriction(0.2), Unilateral(), Flight()
    start = Start(0.0, gap=5e-4, slip=3.0)
    return cache(lambda: Case(ripple(height, width), disc(0.1, 1.0), effects, start, 0.15))


@cache
def rolled_over() -> Case:
    """A disc that slides over a ripple of a micrometre."""
    return replace(on_line(duration=0.5, slip=1.0), track=ripple(1e-6, 1e-5))


@cache
def hump() -> Case:
    """A disc that slides into a hump, which it meets in a second place."""
    return replace(on_line(duration=0.6, slip=2.0), track=ripple(2e-2, 0.03, 0.8))


def flat(case: Case) -> Case:
    """The scene on a level track."""
    return replace(case, track=Curve(lambda s: (s, 0 * s), domain=(-3, 3)))


def on_slope(mu: float, angle: float) -> Callable[[], Case]:
    """A plate at rest under a weight that is turned."""
    return cache(lambda: on_line(Gravity(G, -pi / 2 + angle), CoulombFriction(mu), plate=block(), duration=1.0))


@cache
def nearly_stops(least: float) -> Case:
    """A plate whose slip is 4 (t − 0.5)² − least: friction reverses for some microseconds."""
    load = Load(fx=f"{0.2 * G!r} + 8*(t-0.5)")
    return on_line(load, plate=block(), duration=1.0, slip=1.0 - least)


@cache
def nearly_lifted(part: float) -> Case:
    """A plate without friction that a load lifts by this part of its weight, for some microseconds."""
    load = Load(fy=f"{G * (1 + part)!r} - 100*(t-0.5)**2")
    return Case(line(), block(), (Gravity(G), Unilateral(), load), Start(0.0), 1.0)


@cache
def paradox_rod() -> Case:
    """A rod in Painlevé's paradox, which may fly off or stay."""
    outline = Curve(lambda s: (1e-9 * cos(s) - 0.5, 1e-9 * sin(s)))
    effects = Gravity(G), CoulombFriction(2.0), Unilateral(), Flight()
    start = Start(0.0, xi2=-pi / 2 - 0.9, slip=-3.0, omega=-9.0)
    return Case(line(), Plate(outline, 1.0, 1 / 12), effects, start, 0.01)


def in_units(length: float, mass: float) -> Callable[[], Case]:
    """A disc on a line in other units of length and mass."""
    effects = Gravity(G * length), CoulombFriction(0.1), Unilateral()
    return cache(lambda: Case(line(), disc(0.1 * length, mass), effects, Start(0.0, slip=length), 1.0))


# --- motions of other scenes ------------------------------------------------------------------------------------------


def with_effects(case: Case, change: Callable[[Any], Any]) -> Case:
    """The scene with its effects, on supports too, as a function returns them, without those that become None."""

    def each(effects: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(new for effect in effects if (new := change(effect)) is not None)

    supports = tuple(replace(s, effects=each(s.effects)) if s.effects else s for s in case.supports)
    return replace(case, effects=each(case.effects), supports=supports)


def without(kind: type) -> Change:
    """The scene without effects of a kind."""
    return lambda case: with_effects(case, lambda own: None if isinstance(own, kind) else own)


def instead(effect: Any) -> Change:
    """The scene with another effect of the same kind."""
    return lambda case: with_effects(case, lambda own: effect if isinstance(own, type(effect)) else own)


def alter(kind: type, **changes: Any) -> Change:
    """The scene with other values in its effects of a kind: functions of the own ones, or themselves."""
    return lambda case: with_effects(case, lambda own: _alter(own, changes) if isinstance(own, kind) else own)


def with_part(name: str, **changes: Any) -> Change:
    """The scene with other values in its `plate` or `start`: functions of the own ones, or themselves."""
    return lambda case: replace(case, **{name: _alter(getattr(case, name), changes)})


def _alter(own: Any, changes: dict[str, Any]) -> Any:
    return replace(own, **{n: change(getattr(own, n)) if callable(change) else change for n, change in changes.items()})


def more(value: Any) -> Any:
    """A billionth more; of no value none."""
    return value and value * MORE


def plus(by: float) -> Callable[[float], float]:
    """So much more."""
    return lambda value: value + by


def scene(*changes: Change) -> Callable[[Case], Trajectory]:
    """The motion of another scene, with all the changes, returned for this one."""
    return lambda case: replace(simulate(reduce(lambda now, change: change(now), changes, case)), case=case)


# --- edited motions ---------------------------------------------------------------------------------------------------


def ends(end: float, status: str = "completed", after: bool = False, of: Change = lambda case: case):
    """A motion of the scene, or of another, that ends at another time (s), or so long after its own end, with another
    status."""

    def plant(case: Case) -> Trajectory:
        motion = simulate(of(case))
        times, last = motion.t, simulate(case).t[-1] + end if after else end
        times = np.append(times[times < last], last)
        state = motion.dense(np.minimum(times, np.nextafter(motion.t[-1], 0.0)))
        kept = tuple(c for c in motion.transitions if c.time < last)
        return replace(motion, t=times, **state._asdict(), transitions=kept, status=status, case=case)

    return plant


def column(name: str, change: Callable[[Any, Any], Any], contact: str = "") -> Callable[[Case], Trajectory]:
    """The right motion with one column, or that of one contact, changed: a function of its values and of time."""

    def plant(case: Case) -> Trajectory:
        motion = simulate(case)
        dense, of_contacts = motion.dense, motion.contact_columns

        def new(now: Any, t: Any) -> Any:
            return now._replace(**{name: change(np.asarray(getattr(now, name)), t)})

        if of_contacts is None or not contact:
            return replace(motion, dense=lambda t: new(dense(t), t))
        return replace(
            motion,
            contact_columns=lambda own, t: new(of_contacts(own, t), t) if own == contact else of_contacts(own, t),
        )

    return plant


def jump(name: str, by: float, change: int | None = None) -> Callable[[Case], Trajectory]:
    """The right motion with one column that jumps where its eighth step begins, or at a transition."""

    def plant(case: Case) -> Trajectory:
        right = simulate(case)
        at = float(np.unique(right.t)[7]) if change is None else right.transitions[change].time
        return column(name, lambda values, t: values + by * (t >= at))(case)

    return plant


def transitions(change: Callable[[tuple[Transition, ...]], Sequence[Transition]]) -> Callable[[Case], Trajectory]:
    """The right motion with other transitions."""
    return lambda case: replace(simulate(case), transitions=tuple(change(simulate(case).transitions)))


def later(by: float, *numbers: int) -> Callable[[Case], Trajectory]:
    """Some transitions (none: all) listed later; −1 is the last one."""
    return transitions(
        lambda some: [
            replace(c, time=c.time + by) if {i, i - len(some)} & {*numbers} or not numbers else c
            for i, c in enumerate(some)
        ]
    )


def modes(change: dict[int, dict[str, Mode]]) -> Callable[[Case], Trajectory]:
    """Some transitions between other modes."""
    return transitions(lambda some: [replace(c, **change.get(i, {})) for i, c in enumerate(some)])


def rest_later(by: float) -> Callable[[Case], Trajectory]:
    """The end of a series of impacts at a later time, with all data."""

    def plant(case: Case) -> Trajectory:
        motion = simulate(case)
        rest = next(c.time for c in reversed(motion.transitions) if "came to rest" in c.cause)
        jumps = motion.t[1:][np.diff(motion.t) == 0]
        last, dense, end = jumps[jumps < rest * (1 - 1e-14)][-1], motion.dense, motion.t[-1]

        def warp(t: np.ndarray) -> np.ndarray:
            inside = last + (t - last) * (rest - last) / (rest + by - last)
            return np.clip(np.where(t < last, t, np.where(t < rest + by, inside, t - by)), 0.0, end)

        times = np.where(np.abs(motion.t - rest) < 1e-14, rest + by, motion.t)
        changes = tuple(replace(c, time=c.time + by) if c.time >= rest else c for c in motion.transitions)
        return replace(motion, t=times, transitions=changes, dense=lambda t: dense(warp(t)))

    return plant


def through(case: Case) -> Trajectory:
    """Plates that go on as if they did not meet."""
    motion = simulate(case)
    own = motion.plate_columns
    assert own is not None

    def columns(name: str, t: np.ndarray | None) -> State:
        first, s = own(name, np.zeros(1)), own(name, t)
        still = 0.0 * s.x
        return s._replace(
            x=first.x + first.vx * t, y=first.y + still, theta=first.theta + first.omega * t,
            vx=first.vx + still, vy=still, omega=first.omega + still,
        )  # fmt: skip

    return replace(motion, transitions=(), plate_columns=columns, dense=lambda t: columns("plate", t))


# --- motions by formulas ----------------------------------------------------------------------------------------------


def formulas(first: Mode, columns: Callable[[Case], Columns], knots: Sequence[float] = (0.0, 1.0)):
    """A motion by formulas of time; columns that are not named are those of the start, or 0."""

    def plant(case: Case) -> Trajectory:
        own, begin = columns(case), start_motion(case)

        def dense(t: np.ndarray) -> State:
            t = np.asarray(t)
            values = begin._asdict() | {"normal_force": 0.0, "friction_force": 0.0} | own(t)
            return State(*(np.broadcast_to(values[n], t.shape).astype(float) for n in State._fields))

        times = np.array([k for k in knots if k < case.duration] + [case.duration])
        return Trajectory(times, *dense(times), first_mode=first, dense=dense, case=case)

    return plant


def at_rest(case: Case, speed: float = 0.0) -> Columns:
    gravity = case.effect(Gravity)
    assert gravity is not None
    gx, gy = gravity.vector
    x, xi1 = start_motion(case).x, start_motion(case).xi1
    return lambda t: dict(
        vx=speed, slip=speed, omega=0.0, x=x + speed * t, xi1=xi1 + speed * t, normal_force=-gy, friction_force=-gx
    )


def slips_on(case: Case) -> Columns:
    least, x = 1.0 - case.start.slip, start_motion(case).x

    def columns(t: np.ndarray) -> dict[str, Any]:
        v = 4.0 * (t - 0.5) ** 2 - least
        place = x + 4.0 * ((t - 0.5) ** 3 + 0.125) / 3 - least * t
        return dict(x=place, xi1=place, vx=v, slip=v, normal_force=G, friction_force=-0.2 * G)

    return columns


def presses_on(case: Case) -> Columns:
    load = case.effect(Load)
    assert load is not None
    return lambda t: dict(
        normal_force=G - np.array([load.at(s, 0, 0, 0, 0, 0, 0)[1] for s in np.ravel(t)]).reshape(t.shape)
    )


def flies(case: Case, g: float = G) -> Columns:
    b = start_motion(case)
    return lambda t: (
        dict(x=b.x + b.vx * t, y=b.y + b.vy * t - g * t * t / 2, theta=b.theta + b.omega * t)
        | dict(vy=b.vy - g * t, slip=nan, xi1=nan, xi2=nan)
    )
