"""A motion as samples: poses, velocities and contacts at 25 instants of each of its steps.

A step lies between two knots of a motion's dense output. Its instants are Chebyshev's points, which have both ends.
Plane vectors are complex numbers.
"""

from __future__ import annotations

from cmath import rect
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from cases import (
    Case,
    Chain,
    CoulombFriction,
    Curve,
    Impact,
    Mode,
    PerfectlyRough,
    RollingResistance,
    State,
    Trajectory,
    Transition,
)  # fmt: skip
from cases.curves.corner import Piece
from cases.effects import Effect, one
from cases.motion.trajectory import CONTACT
from cases.moving_surface import Belt
from cases.scene.free_plates import names_of, plates_of
from cases.scene.supports import TRACK, base_of, effects_at

from ..endings import CAUSES
from .chebyshev import COUNT, NODES

# The node in the middle of a step.
MIDDLE = COUNT // 2
# Between knots closer than this many roundings of the motion's end is no step.
CLOSE = 16 * float(np.finfo(float).eps)
# A contact that never slips faster than this part of the plate's speed sticks: what roundings of velocities leave.
CREEP = 1e-9


class PlateSamples(NamedTuple):
    """One plate, arrays (steps, 25), or all plates at one instant, (plates,): place and velocity of the centre of mass
    (complex, m and m/s), the direction of its own x axis (complex, of length 1), its spin (rad/s) and angle (rad)."""

    place: np.ndarray
    turn: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    angle: np.ndarray

    @property
    def rates(self) -> np.ndarray:
        """Generalised velocities of all plates, (3 plates,)."""
        return np.column_stack([self.velocity.real, self.velocity.imag, self.spin]).ravel()


class ContactLaw(NamedTuple):
    """The laws at a contact of that name: the number of its plate, that of the plate on which it lies (None: track or
    support), the curves that touch, and the effects."""

    name: str
    body: int
    base: int | None
    track: Curve
    outline: Curve
    effects: tuple[Effect, ...]
    friction: CoulombFriction | None
    is_rough: bool
    arm: float
    belt: Belt | None

    @property
    def stick(self) -> float:
        """The coefficient that bounds friction without slip."""
        return np.inf if self.is_rough else self.friction.stick if self.friction else 0.0

    def coefficient(self, slip: np.ndarray):
        """The coefficient of friction at slip velocities (m/s), an array of their shape or one number."""
        return self.friction.at(abs(slip)) if self.friction else 0.0

    def in_impact(self, slip: Any) -> tuple[Any, Any]:
        """The coefficients of friction against slip and without it of an impact that begins at slip velocities (m/s),
        arrays of their shape or one number each."""
        if self.is_rough:
            return np.inf, np.inf
        return self.friction.in_impact(slip) if self.friction else (0.0, 0.0)

    @property
    def impact(self) -> Impact:
        """The law of impact, of a case that has one."""
        return next(effect for effect in self.effects if isinstance(effect, Impact))


class ContactInstants(NamedTuple):
    """One contact in the m steps in which it is closed, given by their numbers (m,): arrays (m, 25) of the point of its
    base (complex, m) and the unit tangent there (complex), the slip velocity (m/s), normal and friction force (N, NaN
    where they are not unique), the point of its plate (complex, m) and the unit tangent of its outline (complex), and
    the parameters of both. `modes`: of each step."""

    law: ContactLaw
    steps: np.ndarray
    base: np.ndarray
    tangent: np.ndarray
    slip: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    point: np.ndarray
    direction: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    modes: np.ndarray


class MotionSamples(NamedTuple):
    """The samples of a motion: starts and ends of n steps (s), times (n, 25), plates in the order of the case's, and
    contacts. `is_straight`: which steps are no solution of the equations but the rest of a series of impacts, (n,);
    `near`: parameters of track and supports, by name, at which plates touch them or are near; `motion`: itself. The
    `case` has a track at rest."""

    case: Case
    start: np.ndarray
    end: np.ndarray
    times: np.ndarray
    plates: tuple[PlateSamples, ...]
    contacts: tuple[ContactInstants, ...]
    is_straight: np.ndarray
    near: dict[str, np.ndarray]
    motion: Trajectory

    @property
    def transitions(self) -> tuple[Transition, ...]:
        """Those of the motion."""
        return self.motion.transitions

    @property
    def length(self) -> np.ndarray:
        """Of each step, s."""
        return self.end - self.start


@lru_cache(maxsize=512)
def law_at(case: Case, name: str) -> ContactLaw:
    """The laws at a contact of a case, by its name such as "plate/wall 2"."""
    names, plates, base = names_of(case), plates_of(case), base_of(name)
    body, effects = names.index(name.partition("/")[0]), effects_at(case, name)
    on_plate = names.index(base) if base in names else None
    curves = {"track": case.track} | {support.name: support.curve for support in case.supports}
    resistance = one(effects, RollingResistance)
    return ContactLaw(
        name, body, on_plate, curves[base] if on_plate is None else plates[on_plate].outline, plates[body].outline,
        effects, one(effects, CoulombFriction), one(effects, PerfectlyRough) is not None,
        resistance.arm if resistance else 0.0, one(effects, Belt),
    )  # fmt: skip


def point_and_tangent(curve, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and unit tangents, complex, of a curve, an edge or a corner at parameters of any shape."""
    if type(curve) is Curve:
        x, y, dx, dy = curve.jets(s)[:4]
        rate = dx + 1j * dy
        return x + 1j * y, rate / np.abs(rate)
    point, tangent = curve.point(s.ravel()), curve.tangent(s.ravel())
    return (point[0] + 1j * point[1]).reshape(s.shape), (tangent[0] + 1j * tangent[1]).reshape(s.shape)


def place_at(curve: Piece, s: float) -> tuple[complex, complex]:
    """The same at one parameter, in numbers."""
    if isinstance(curve, Chain):
        point, tangent = point_and_tangent(curve, np.array([s]))
        return complex(point[0]), complex(tangent[0])
    x, y, dx, dy, *_ = curve.jet(s)
    rate = complex(dx, dy)
    return complex(x, y), rate / abs(rate) if rate else rect(1.0, curve.tangent_angle(s))


def steps_of(motion: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Starts and ends (s) of the steps of a motion between its samples and transitions. Of knots that are close, as
    those of two impacts within roundings, a step ends at the first and the next begins at the last: none contains an
    impact."""
    end = float(motion.t[-1])
    knots = np.unique([*motion.t, *(change.time for change in motion.transitions if 0.0 < change.time < end)])
    is_step = np.diff(knots) > CLOSE * end
    return knots[:-1][is_step], knots[1:][is_step]


def nodes_of(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The nodes of steps (starts and ends, s), (n, 25); the end of a step is looked at from inside."""
    times = start[:, None] + (end - start)[:, None] * NODES
    times[:, -1] = np.nextafter(end, -np.inf)
    return times


def of_motion(case: Case, motion: Trajectory, start: np.ndarray, end: np.ndarray) -> MotionSamples:
    """The samples of some steps (starts and ends, s) of any motion with dense output, of a case with a track at
    rest."""
    times = nodes_of(start, end)
    plates = plates_of_motion(motion, times)
    near = parameters_near(case, motion.transitions)
    contacts = [_contact(case, motion, name, plates, times, near) for name in motion.contact_names]
    rests = [change.time for change in motion.transitions if change.cause == CAUSES["rest"]]
    is_straight = np.isin(end, rests) if rests else np.zeros(len(start), dtype=bool)
    return MotionSamples(
        case, start, end, times, plates, tuple(c for c in contacts if len(c.steps)), is_straight,
        {name: np.array(values) for name, values in near.items()}, motion,
    )  # fmt: skip


def plates_of_motion(motion: Trajectory, times: np.ndarray) -> tuple[PlateSamples, ...]:
    """All plates of a motion at times of any shape, s."""
    return tuple(_plate(state_of(motion, name, times.ravel()), times.shape) for name in motion.plate_names)


def parameters_near(case: Case, transitions: Sequence[Transition]) -> dict[str, list[float]]:
    """Parameters of track and supports, by name, at which plates are in the start and in the transitions."""
    near = {TRACK: [case.start.xi1]} | {support.name: [support.curve.span[0]] for support in case.supports}
    for change in transitions:
        if np.isfinite(change.xi1) and base_of(change.contact or CONTACT) in near:
            near[base_of(change.contact or CONTACT)].append(change.xi1)
    return near


def _only_mode(law: ContactLaw, slip: np.ndarray, speed: float) -> Mode:
    """The mode of a contact that never changes it, of a plate of that speed (m/s)."""
    largest = slip[np.nanargmax(np.abs(slip))] if np.isfinite(slip).any() else np.nan
    if np.isnan(largest):
        return Mode.FLIGHT
    if law.friction is None and not law.is_rough:
        return Mode.SLIDE
    if abs(largest) > CREEP * speed:
        return Mode.SLIP_FORWARD if largest > 0.0 else Mode.SLIP_BACKWARD
    return Mode.ROLL


def state_of(motion: Trajectory, name: str, times: np.ndarray) -> State:
    """A plate of a motion at times (n,)."""
    return motion.plate_columns(name, times) if motion.plate_columns else (motion.dense or motion._interpolate)(times)


def contact_of(motion: Trajectory, name: str, times: np.ndarray) -> Any:
    """A contact's columns at times (n,), without ranges of forces; of a motion with one contact its state."""
    columns = motion.contact_columns
    return (
        state_of(motion, name, times) if columns is None else getattr(columns, "without_ranges", columns)(name, times)
    )


def _plate(state: State, shape: tuple[int, ...]) -> PlateSamples:
    x, y, theta, vx, vy, omega = (np.reshape(row, shape) for row in state[:6])
    return PlateSamples(x + 1j * y, np.exp(1j * theta), vx + 1j * vy, omega, theta)


def _contact(
    case: Case, motion: Trajectory, name: str, plates: tuple[PlateSamples, ...], times: np.ndarray,
    near: dict[str, list[float]],
) -> ContactInstants:  # fmt: skip
    """One contact of a motion at the nodes of its steps; its parameters are added to those that are near."""
    law, now = law_at(case, name or CONTACT), contact_of(motion, name, times.ravel())
    own, first = list(motion.transitions), motion.first_mode
    if motion.contact_columns is not None:
        own = [t for t in own if t.contact == name]
        first = own[0].before if own else _only_mode(law, now.slip, float(np.abs(plates[law.body].velocity).max()))
    rows = (now.slip, now.normal_force, now.friction_force, now.xi1, now.xi2)
    slip, normal, friction, xi1, xi2 = (np.reshape(np.broadcast_to(row, times.size), times.shape) for row in rows)
    changes = np.array([change.time for change in own])
    modes = np.array(
        [first or (own[0].before if own else Mode.FLIGHT), *(change.after for change in own)], dtype=object
    )
    middle = times[:, MIDDLE]
    mode = modes[np.searchsorted(changes, middle, side="right")]
    steps = np.flatnonzero(np.isfinite(slip).all(axis=1))
    slip, normal, friction, xi1, xi2 = (row[steps] for row in (slip, normal, friction, xi1, xi2))
    base, tangent = point_and_tangent(law.track, xi1)
    if law.base is None and len(steps):
        near[base_of(law.name)] += [float(xi1.min()), float(xi1.max())]
    if law.base is not None:  # an outline runs with the other plate on its right
        under = plates[law.base]
        base = under.place[steps] + under.turn[steps] * base
        tangent = -under.turn[steps] * tangent
    touching, direction = point_and_tangent(law.outline, xi2)
    point = plates[law.body].place[steps] + plates[law.body].turn[steps] * touching
    direction = plates[law.body].turn[steps] * direction
    return ContactInstants(law, steps, base, tangent, slip, normal, friction, point, direction, xi1, xi2, mode[steps])
