"""The contacts of a plate in their own frames, in numbers: rows and biases of the accelerations of gap and slip."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import copysign, cos, hypot, isfinite, sin
from typing import NamedTuple

import numpy as np

from cases import Belt, Case, CoulombFriction, Gravity, PerfectlyRough, RollingResistance
from cases.contact import Contact, find
from cases.own_effects import own_effects
from cases.scene.contact_pairs import PairCase
from cases.scene.couples import Couple, couples
from cases.scene.free_plates import loads_of, plates_of
from cases.scene.piece_case import PieceCase
from cases.scene.plate import is_convex
from cases.scene.supports import is_straight

from .loads import load_scales
from .steps import StepFailure

# A corner or an arc that is deeper behind a curve than this part of the reach has not closed its gap: between two looks
# it moves by a tenth of that.
BEHIND = 0.3


# The numbers of the plates at a contact: the plate, and that on whose boundary it lies, None on what does not move.
Sides = tuple[int, int | None]
# A feature of a plate on a support, or elements of a couple of several plates.
AnyPair = PairCase | PieceCase


class PairState(NamedTuple):
    """A contact in its frame: its pair, parameters, gap (m), lift and slip velocity (m/s), their rows in (vx, vy, ω),
    their accelerations without that of the plate (m/s²), the rates of ξ₁ and ξ₂ (1/s), the spin of the plate against
    the boundary (rad/s), the speed of the support's surface (m/s), to which the slip is relative (`on_surface`), and
    the side: −1 where a guide pulls, whose normal, gap and lift are opposite (`on_side`)."""

    contact: AnyPair
    xi1: float
    xi2: float
    gap: float
    lift: float
    slip: float
    lift_row: np.ndarray
    slip_row: np.ndarray
    lift_bias: float
    slip_bias: float
    xi1_rate: float
    xi2_rate: float
    spin: float
    surface: float = 0.0
    side: int = 1

    @property
    def sides(self) -> Sides:
        """The plates at the contact."""
        return plates_at(self.contact)

    @property
    def turning_row(self) -> np.ndarray:
        """The row of the rotation of the two against each other, in units of the plate's radius of gyration."""
        row, (own, base) = np.zeros(len(self.lift_row)), self.sides
        row[3 * own + 2] = self.contact.plate.gyration
        if base is not None:
            row[3 * base + 2] = -self.contact.plate.gyration
        return row

    @property
    def clearance(self) -> float:
        """Curvature of the outline less that of the support at this gap, 1/m; infinite at a corner."""
        bend = float(self.contact.track.curvature(self.xi1))
        own = float(self.contact.plate.outline.curvature(self.xi2))
        return own * (1.0 - self.gap * bend) - bend


def is_of_couple(pair: AnyPair) -> bool:
    """Whether a pair is one of elements of two plates, or of one of several plates and a curve."""
    return isinstance(pair, PieceCase) and isinstance(pair.whole, Couple)


def plates_at(pair: AnyPair) -> Sides:
    """The number of a contact's plate, and that of the plate on whose boundary it lies, None on what does not move."""
    return (pair.whole.body, pair.whole.base) if isinstance(pair.whole, Couple) else (0, None)


def pair_at(
    pair: AnyPair, body: Sequence[float] | np.ndarray, near: tuple[float, float], gap: float | None = None
) -> PairState:
    """The pair of nearest points next to `near`, or with a known `gap` (m) these themselves; `body`: (x, y, θ) of all
    plates, then (vx, vy, ω) of all. The frame is that of the boundary: t along it, n = U t to the plate. Raises
    DoesNotFit.

    The velocities of lift and slip are n·(v_B − v_A) and t·(v_B − v_A) of the points that touch. Their derivatives
    follow the contact: the frame turns with ψ̇ = ω_A + κ₁ ṡ₁ = ω_B + κ₂ ṡ₂, and the points move along both boundaries
    with ṡ₁ and ṡ₂ = ṡ₁ − slip; at a corner the point is fixed (derived here).
    """
    own, base = plates_at(pair)
    x, y, theta, vx, vy, omega = _state(body, own)
    u, v, turn, ux, uy, spin = (0.0,) * 6 if base is None else _state(body, base)
    c, s = (1.0, 0.0) if base is None else (cos(turn), sin(turn))
    if gap is not None:
        contact = Contact(*near, gap)
    else:
        turns = (
            turn if is_of_couple(pair) or not isinstance(pair, PieceCase) else pair.turn
        )  # of the pieces' parameters
        contact = find(pair, c * (x - u) + s * (y - v), c * (y - v) - s * (x - u), theta - turns, near)
    jet, outline = pair.track.jet(contact.xi1), pair.plate.outline.jet(contact.xi2)
    speed, own_speed = hypot(jet[2], jet[3]), hypot(outline[2], outline[3])
    tx, ty = (jet[2] / speed, jet[3] / speed) if speed else map(float, pair.track.tangent(contact.xi1))
    tx, ty, px, py = c * tx - s * ty, s * tx + c * ty, c * jet[0] - s * jet[1], s * jet[0] + c * jet[1]
    c, s = cos(theta), sin(theta)
    rx, ry = c * outline[0] - s * outline[1], s * outline[0] + c * outline[1]
    rt, rn, pt, pn = rx * tx + ry * ty, ry * tx - rx * ty, px * tx + py * ty, py * tx - px * ty
    if pair.plate.radius is not None:  # no roundings of its point, whose moments would shorten steps
        rt, rn = 0.0, copysign(pair.plate.radius, rn)
    slip_row, lift_row = np.zeros(len(body) // 2), np.zeros(len(body) // 2)
    slip_row[3 * own : 3 * own + 3], lift_row[3 * own : 3 * own + 3] = (tx, ty, -rn), (-ty, tx, rt)
    slip, lift = vx * tx + vy * ty - omega * rn, vy * tx - vx * ty + omega * rt
    if base is not None:
        slip_row[3 * base : 3 * base + 3], lift_row[3 * base : 3 * base + 3] = (-tx, -ty, pn), (ty, -tx, -pt)
        slip, lift = slip - (ux * tx + uy * ty - spin * pn), lift - (uy * tx - ux * ty + spin * pt)
    # The normals turn together; how fast the points move along their curves follows from slip, spins and gap.
    bend = (jet[2] * jet[5] - jet[3] * jet[4]) / speed**3 if speed else 0.0
    own_bend = (outline[2] * outline[5] - outline[3] * outline[4]) / own_speed**3 if own_speed else 0.0
    shrink = 1.0 - contact.gap * bend
    if not speed:
        along, along_own = 0.0, -slip
        turning = omega + own_bend * along_own
    else:
        along = (own_bend * slip - (omega - spin)) / (own_bend * shrink - bend) if own_speed else slip / shrink
        along_own = along * shrink - slip if own_speed else 0.0
        turning = spin + bend * along
    lift_bias = spin * spin * pn - omega * omega * rn + omega * along_own - spin * along - turning * slip
    slip_bias = spin * spin * pt - omega * omega * rt + turning * lift
    # At a corner its parameter is the direction of the tangent, which turns with the frame.
    rate = along / speed if speed else copysign(1.0, pair.track.turn) * (turning - spin)  # type: ignore[attr-defined]
    own_rate = along_own / own_speed if own_speed else copysign(1.0, pair.plate.outline.turn) * (turning - omega)  # type: ignore[attr-defined]
    return PairState(
        pair, *contact, lift, slip, lift_row, slip_row, lift_bias, slip_bias, rate, own_rate, omega - spin
    )  # fmt: skip


def _state(body: Sequence[float] | np.ndarray, plate: int) -> tuple[float, ...]:
    """(x, y, θ, vx, vy, ω) of one plate."""
    half, first = len(body) // 2, 3 * plate
    return (*map(float, body[first : first + 3]), *map(float, body[half + first : half + first + 3]))


def moves(pair: AnyPair) -> bool:
    """Whether the surface on which a contact lies moves: a plate, or one that runs."""
    return plates_at(pair)[1] is not None or pair.effect(Belt) is not None


def on_whole_curves(pair: AnyPair, points: tuple[float, float]) -> tuple[float, float]:
    """The parameters of a contact on the whole curves: of plates those of their outlines."""
    if not isinstance(pair, PieceCase):
        return points[0], float(pair.whole_xi2(points[1]))
    xi1, xi2 = map(float, pair.to_whole(*points))
    return (float(pair.whole.whole_xi1(xi1)), xi2) if isinstance(pair.whole, Couple) else (xi1, xi2)


@lru_cache(maxsize=1024)
def is_watched_always(pair: AnyPair) -> bool:
    """Whether the gap of a pair is watched in all poses; otherwise its contacts are searched for."""
    if isinstance(pair, PieceCase):
        return is_of_couple(pair)
    is_plain = is_straight(pair.track) and is_convex(pair.plate.outline)
    return pair.has_unique_points or pair.is_point_on_curve or is_plain


def open_pair_at(pair: AnyPair, body: Sequence[float] | np.ndarray, near: tuple[float, float]) -> PairState:
    """The same of an open contact: that of a corner or an arc has the nearest points of the whole curve. Behind the
    curve, or nearest to an end of it, it has its distance as a positive gap: it cannot close there."""
    if isinstance(pair, PieceCase) or pair.has_unique_points or not pair.is_point_on_curve:
        return pair_at(pair, body, near)
    x, y, theta, *_ = (float(v) for v in body)
    state = pair_at(pair, body, pair.guess(x, y, theta))
    low, high = pair.track.domain or (state.xi1, state.xi1)
    if not low <= state.xi1 <= high:
        c, s, (u, v) = cos(theta), sin(theta), pair.plate.outline.point(state.xi2)
        place = np.array([x + c * u - s * v, y + s * u + c * v])
        return state._replace(gap=float(np.hypot(*(place - pair.track.point(min(max(state.xi1, low), high))))))
    return state._replace(gap=-state.gap) if state.gap < -BEHIND * pair.whole.plate.reach else state


def on_surface(pair: PairState, t: float) -> PairState:
    """A contact at time t (s) with its slip relative to the support's surface, where that runs."""
    belt = pair.contact.effect(Belt)
    if belt is None:
        return pair
    speed, rate = belt.at(t)
    return pair._replace(slip=pair.slip - speed, slip_bias=pair.slip_bias - rate, surface=speed)


def on_side(pair: PairState, side: int) -> PairState:
    """A contact with the normal of that side."""
    if side == pair.side:
        return pair
    return pair._replace(
        side=side, gap=-pair.gap, lift=-pair.lift, lift_row=-pair.lift_row, lift_bias=-pair.lift_bias
    )  # fmt: skip


def surfaces(pairs: Sequence[PairState]) -> np.ndarray:
    """What the velocities of lift, then of slip, then of the rotation where it is resisted, are relative to, m/s."""
    none = [0.0] * len(pairs)
    return np.array(none + [pair.surface for pair in pairs] + (none if resists(pairs) else []))


def is_constant_at(contact: Case) -> bool:
    """Whether forces at a contact change neither in time nor with its slip."""
    friction = contact.effect(CoulombFriction)
    return contact.effect(Belt) is None and not (friction and friction.by_speed)


# In place of the friction of a perfectly rough contact: far beyond any force of the scenes, as Lemke's method needs a
# number.
ROUGH = 1e9


def is_rough(contact: Case) -> bool:
    """Whether friction at a contact has no bound."""
    return contact.effect(PerfectlyRough) is not None


def friction_of(contact: Case, speed: float = 0.0) -> tuple[float, float]:
    """The coefficients of friction of a contact, with a slip of that speed (m/s) and without slip."""
    friction = contact.effect(CoulombFriction)
    if is_rough(contact):
        return ROUGH, ROUGH
    return (float(friction.at(speed)) if speed else friction.at_rest, friction.stick) if friction else (0.0, 0.0)


def resisting_arm(contact: Case) -> float:
    """The arm of a contact's rolling resistance, m; 0 without."""
    effect = contact.effect(RollingResistance)
    return 0.0 if effect is None else effect.arm


def resists(contacts: Sequence[PairState]) -> bool:
    """Whether one of the contacts resists rolling."""
    return any(resisting_arm(one.contact) for one in contacts)


def resisting_sides(contacts: Sequence[PairState]) -> set[Sides]:
    """The plates whose rotation against each other contacts resist."""
    return {one.sides for one in contacts if resisting_arm(one.contact)}


def frictions(contacts: Sequence[PairState]) -> tuple[np.ndarray, np.ndarray]:
    """The coefficients of friction of all contacts with their slip, and without; where one resists rolling, followed by
    the arms in units of the radius of gyration."""
    values = np.array([friction_of(one.contact, abs(one.slip)) for one in contacts]).reshape(-1, 2)
    if not resists(contacts):
        return values[:, 0], values[:, 1]
    arms = [resisting_arm(one.contact) / one.contact.plate.gyration for one in contacts]
    return np.append(values[:, 0], arms), np.append(values[:, 1], arms)


class PlateDynamics:
    """Masses of all plates of a case, and the forces applied to them."""

    def __init__(self, case: Case):
        self.case, plates = case, plates_of(case)
        self.inverse = 1.0 / np.array([part for one in plates for part in (one.mass, one.mass, one.inertia)])
        self.units = np.array([part for one in plates for part in (1.0, 1.0, one.gyration)])
        gravity = case.effect(Gravity)
        pull = np.array(gravity.vector if gravity is not None else (0.0, 0.0))
        self.weight = np.concatenate([[*(one.mass * pull), 0.0] for one in plates])
        self.loads = loads_of(case)
        # Features that a step could pass over, in time.
        self.features = [one.features for one in self.loads if one is not None and one.features]
        self.scales = [(3 * i, scales) for i, one in enumerate(self.loads) if (scales := load_scales(one)) is not None]

    @property
    def moves(self) -> np.ndarray:
        """Which velocities can change: a plate of infinite inertia does not turn."""
        return self.inverse > 0.0

    def torsor(self, t: float, body: Sequence[float] | np.ndarray) -> np.ndarray:
        """The applied forces and moments (N, N, N m) of all plates."""
        torsor = self.weight
        for plate, load in enumerate(self.loads):
            if load is not None:
                torsor = torsor.copy()
                torsor[3 * plate : 3 * plate + 3] += load.at(t, *_state(body, plate))
        return torsor

    def load_allows(self, times: np.ndarray, states: np.ndarray) -> bool:
        """Whether the loads allow a step through these states, shape (variables, n)."""
        half = len(states) // 2
        return all(
            scales.allows(times, *states[i : i + 3], *states[half + i : half + i + 3]) for i, scales in self.scales
        )

    def own_forces(self, t: float, pairs: Sequence[PairState]) -> np.ndarray:
        """What effects of packages apply to all plates at closed contacts (N, N, N m)."""
        torsor = np.zeros(len(self.weight))
        for pair in pairs:
            for effect in own_effects(pair.contact.effects):
                along, across, couple = effect.at(t, pair.slip, pair.spin)[:3]
                if not isfinite(along + across + couple):
                    raise StepFailure(f"{type(effect).__name__} has no value at t = {t:.9g} s; end the case before")
                turning = pair.turning_row / pair.contact.plate.gyration
                torsor += along * pair.slip_row + pair.side * across * pair.lift_row + couple * turning
        return torsor

    @property
    def is_constant(self) -> bool:
        """Whether nothing but weight, and at contacts friction, is applied."""
        return not any(self.loads) and not any(own_effects(one.effects) for one in couples(self.case))

    def delassus(self, pairs: Sequence[PairState]) -> tuple[np.ndarray, np.ndarray]:
        """The Delassus matrix (2K, 2K) of lifts, then slips, and the rows (2K, velocities); where a contact resists
        rolling, followed by the rotation for each contact, in units of the radius of gyration: 3K."""
        turning = [p.turning_row for p in pairs] if resists(pairs) else []
        rows = np.array([p.lift_row for p in pairs] + [p.slip_row for p in pairs] + turning)
        rows = rows.reshape(-1, len(self.inverse))
        return rows * self.inverse @ rows.T, rows

    def free_rates(
        self, t: float, body: Sequence[float] | np.ndarray, pairs: Sequence[PairState], rows: np.ndarray
    ) -> np.ndarray:
        """Accelerations of the gaps, then of the slips, without contact forces; `rows` are those of `delassus`."""
        biases = np.array([p.lift_bias for p in pairs] + [p.slip_bias for p in pairs])
        biases = np.append(biases, np.zeros(len(rows) - len(biases)))
        return rows @ (self.inverse * (self.torsor(t, body) + self.own_forces(t, pairs))) + biases
