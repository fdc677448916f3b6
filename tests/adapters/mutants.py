"""Adapters with one mistake each, for the tests of the laws: every effect, every parameter, every column.

Most are the reference, sampled as an engine's steps are, with a case that differs from the given one (`of_case`) or
with columns that do (`of_motion`). `mutant_list` has all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from math import pi
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

import reference
from adapters import Setting
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Load,
    Plate,
    Start,
    Trajectory,
    curves,
)
from cases.contact import start_motion
from cases.curves.line_or_circle import as_line
from cases.effects import MOTION
from cases.motion.sampled_contacts import SampledPlates
from cases.slip_laws import SLIP_SPEED

# Samples of a motion, about as many as an engine's steps in a scene of the laws.
STEPS = 2000


class Hashable(SimpleNamespace):
    """A namespace that is hashed by its identity, so that a cache accepts it as a key."""

    __hash__ = object.__hash__


def of_case(change: Callable[[Case], Case] = lambda case: case, spoil=lambda case, motion: motion) -> Any:
    """The reference on `change(case)`, its motion changed by `spoil`: an adapter with one mistake."""

    def read(case: Case) -> Trajectory:
        return spoil(case, _sampled(change(case)))

    return Hashable(
        NAME="mutant",
        routes=("native",),
        SLIP_LAWS=("native",),
        SEVERAL_PLATES=("native",),
        FREE_POLYGONS=("native",),
        refuses=lambda case, route: None,
        ladder=lambda case, route: (Setting.of(), Setting.of()),
        build=lambda case, route, setting: case,
        run=lambda model: None,
        read=read,
    )


@lru_cache(maxsize=256)
def _sampled(case: Case) -> Trajectory:
    """The true motion, evenly sampled; both sides of a landing are kept, as engines' readers do."""
    motion = reference.simulate(case)
    times = np.linspace(motion.t[0], motion.t[-1], max(3, round(STEPS * motion.t[-1] / case.duration) + 1))
    state = {name: np.array(values) for name, values in motion(times)._asdict().items()}
    names = motion.plate_names if case.others else ()
    plates = SampledPlates(times, {name: np.array(motion.plate(name)(times)[:6]) for name in names}) if names else None
    return replace(motion, dense=None, t=times, **state, plate_columns=plates)


def of_motion(**columns: Callable[[Trajectory], np.ndarray]) -> Any:
    """The reference with columns changed: name = function of the motion."""
    return of_case(spoil=lambda case, m: replace(m, **{name: change(m) for name, change in columns.items()}))


# --- changes of a case ------------------------------------------------------------------------------------------------


def effect(kind: type, change: Callable[[Any], Any]) -> Callable[[Case], Case]:
    """The case with its effect of that kind changed; None drops it."""

    def changed(case: Case) -> Case:
        effects = tuple(change(e) if isinstance(e, kind) else e for e in case.effects)
        return replace(case, effects=tuple(e for e in effects if e is not None))

    return changed


def friction(change: Callable[[float], float]) -> Callable[[Case], Case]:
    """The case with another coefficient, of slip and stick alike."""
    return effect(CoulombFriction, lambda e: CoulombFriction(change(e.mu), e.mu_static and change(e.mu_static)))


def slip_law(change: Callable[[Any, Any], Any]) -> Callable[[Case], Case]:
    """The case with another formula (mu, v) of friction that depends on the slip velocity."""

    def changed(e: CoulombFriction) -> CoulombFriction:
        return CoulombFriction(change(e.mu, SLIP_SPEED), e.mu_static) if e.by_speed else e

    return effect(CoulombFriction, changed)


def load(change: Callable[[dict, Case], dict]) -> Callable[[Case], Case]:
    """The case with the load's components (fx, fy, moment) changed."""

    def changed(case: Case) -> Case:
        own = case.effect(Load)
        if own is None:
            return case
        parts = change(dict(zip(("fx", "fy", "moment"), own.expression, strict=True)), case)
        others = tuple(e for e in case.effects if e is not own)
        return replace(case, effects=(*others, Load(**parts)) if any(parts.values()) else others)

    return changed


def frozen(**values: float) -> Callable[[Case], Case]:
    """The case with variables of the load (t, x, …) at constant values."""
    symbols = {symbol: values[symbol.name] for symbol in MOTION if symbol.name in values}
    return load(lambda parts, case: {name: part.subs(symbols) for name, part in parts.items()})


def plate(change: Callable[[Plate], Plate]) -> Callable[[Case], Case]:
    """The case with another plate."""
    return lambda case: replace(case, plate=change(case.plate))


def start(change: Callable[[Start], Start]) -> Callable[[Case], Case]:
    """The case with another start."""
    return lambda case: replace(case, start=change(case.start))


def where(condition: Callable[[Case], bool], change: Callable[[Case], Case]) -> Callable[[Case], Case]:
    """The change where the condition holds."""
    return lambda case: change(case) if condition(case) else case


def on_hill(case: Case) -> bool:
    """Whether the track bends away from the plate at its parameter 0, the top or bottom of the laws' tracks."""
    return float(case.track.curvature(0.0)) < -1e-9


def in_valley(case: Case) -> bool:
    """Whether the track bends towards the plate at its parameter 0."""
    return float(case.track.curvature(0.0)) > 1e-9


def on_line(case: Case) -> bool:
    """Whether the track is straight."""
    return as_line(case.track) is not None


def outline(change: Callable[[Any, Any, Case], tuple[Any, Any]], only=lambda case: True) -> Callable[[Case], Case]:
    """The case with the points (x, y) of its outline moved in the plate's frame, the start's pose kept apart."""

    def changed(case: Case) -> Case:
        own = case.plate.outline
        moved = Curve(lambda s: change(*own.at(s), case), domain=own.domain)
        return replace(case, plate=replace(case.plate, outline=moved)) if only(case) else case

    return changed


def centre(case: Case) -> tuple[float, float]:
    """The mean of the outline's points: the centre of a disc."""
    points = case.plate.outline.point(np.linspace(*case.plate.outline.span, 65)[:-1])
    return float(points[0].mean()), float(points[1].mean())


def off_centre(case: Case) -> bool:
    """Whether the centre of mass is not the centre."""
    return bool(np.hypot(*centre(case)) > 1e-6)


def track(change: Callable[[Any, Any], tuple[Any, Any]]) -> Callable[[Case], Case]:
    """The case with the points (x, y) of its track moved."""
    return lambda case: replace(case, track=Curve(lambda s: change(*case.track.at(s)), domain=case.track.domain))


def osculating(case: Case) -> Case:
    """The case with its track replaced by the circle of curvature at the start."""
    begin, bend = case.start.xi1, float(case.track.curvature(case.start.xi1))
    if abs(bend) < 1e-9:
        return case
    x, y = (float(c) for c in case.track.point(begin) + case.track.normal(begin) / bend)
    first, pace = float(case.track.tangent_angle(begin)) - pi / 2, float(case.track.speed(begin))

    def circle(s):
        angle = first + (s - begin) * pace * bend
        return x + curves.cos(angle) / bend, y + curves.sin(angle) / bend

    return replace(case, track=Curve(circle), start=replace(case.start, xi2=start_motion(case).xi2))


def damped(linear: float, angular: float) -> Callable[[Case], Case]:
    """The case with the damping (1/s) that engines have by default."""

    def changed(case: Case) -> Case:
        own, m = case.effect(Load), case.plate.mass
        fx, fy, moment = own.expression if own else (0.0, 0.0, 0.0)
        _, _, _, _, vx, vy, omega = MOTION
        drag = Load(fx - linear * m * vx, fy - linear * m * vy, moment - angular * case.plate.inertia * omega)
        return replace(case, effects=(*(e for e in case.effects if e is not own), drag))

    return changed


# --- changes of a motion ----------------------------------------------------------------------------------------------


def late(values: np.ndarray, steps: int) -> np.ndarray:
    """The column that many samples late."""
    return np.concatenate([np.repeat(values[:1], steps), values[:-steps]])


class Mutant(NamedTuple):
    """A wrong adapter, the law that must catch it, and words that the law's message must contain."""

    name: str
    law: str
    words: str
    adapter: Callable[[], Any]
