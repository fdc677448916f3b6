"""The contacts of a plate in their own frames, in numbers: rows and biases of the accelerations of gap and slip."""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch
from math import cos, hypot, sin
from typing import Any, NamedTuple

import numpy as np

from cases import Belt, Case, CoulombFriction, DoesNotFit, Gravity, Load, PerfectlyRough, RollingResistance
from cases.contact import find
from cases.scene.contact_pairs import PairCase

from ..contact_frame.drive import DriveLoad

# Pairs of nearest points with a gap below this part of the plate's reach are looked for among samples of the track.
NEAR, SAMPLES = 0.3, 240
# Two pairs are the same one if their track points are closer than this part of the reach.
APART = 1e-6
# A corner or an arc that is deeper behind a curve than this part of the reach has not closed its gap: between two looks
# it moves by a tenth of that.
BEHIND = 0.3


class PairState(NamedTuple):
    """A contact in its frame: its pair, parameters, gap (m), lift and slip velocity (m/s), their rows in (vx, vy, ω),
    their accelerations without that of the plate (m/s²), the rate of ξ₁ (1/s), and the speed of the support's surface
    (m/s), to which the slip is relative (`on_surface`)."""

    contact: PairCase
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
    surface: float = 0.0

    @property
    def clearance(self) -> float:
        """Curvature of the outline less that of the support at this gap, 1/m; infinite at a corner."""
        bend = float(self.contact.track.curvature(self.xi1))
        own = float(self.contact.plate.outline.curvature(self.xi2))
        return own * (1.0 - self.gap * bend) - bend


@singledispatch
def pair_at(pair: Any, body: Sequence[float] | np.ndarray, near: tuple[float, float]) -> PairState:
    """The pair of nearest points next to `near`; `body` is (x, y, θ, vx, vy, ω). Raises DoesNotFit."""
    x, y, theta, vx, vy, omega = (float(v) for v in body)
    contact = find(pair, x, y, theta, near)
    jet, own = pair.track.jet(contact.xi1), pair.plate.outline.jet(contact.xi2)
    speed, own_speed = hypot(jet[2], jet[3]), hypot(own[2], own[3])
    bend = (jet[2] * jet[5] - jet[3] * jet[4]) / speed**3
    tx, ty = jet[2] / speed, jet[3] / speed
    c, s = cos(theta), sin(theta)
    rx, ry = c * own[0] - s * own[1], s * own[0] + c * own[1]
    rt, rn = rx * tx + ry * ty, ry * tx - rx * ty
    slip_row, lift_row = np.array([tx, ty, -rn]), np.array([-ty, tx, rt])
    slip, lift = vx * tx + vy * ty - omega * rn, vy * tx - vx * ty + omega * rt
    # The normals turn together; how fast the points move along their curves follows from slip, spin and gap.
    shrink = 1.0 - contact.gap * bend
    if own_speed == 0.0:  # a corner's point is fixed
        along, along_own = slip / shrink, 0.0
    else:
        own_bend = (own[2] * own[5] - own[3] * own[4]) / own_speed**3
        along = (own_bend * slip - omega) / (own_bend * shrink - bend)
        along_own = along * shrink - slip
    turning = bend * along
    lift_bias = -omega * omega * rn + omega * along_own - turning * slip
    slip_bias = -omega * omega * rt + turning * lift
    return PairState(
        pair, contact.xi1, contact.xi2, contact.gap, lift, slip, lift_row, slip_row, lift_bias, slip_bias, along / speed
    )


def is_watched_always(pair: PairCase) -> bool:
    """Whether the gap of a pair is watched in all poses; otherwise its contacts are searched for."""
    return pair.has_unique_points or pair.is_point_on_curve


def open_pair_at(pair: PairCase, body: Sequence[float] | np.ndarray, near: tuple[float, float]) -> PairState:
    """The same of an open contact: that of a corner or an arc has the nearest points of the whole curve. Behind the
    curve, or nearest to an end of it, it has its distance as a positive gap: it cannot close there."""
    if pair.has_unique_points or not pair.is_point_on_curve:
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


def surfaces(pairs: Sequence[PairState]) -> np.ndarray:
    """What the velocities of lift, then of slip, then of the rotation where it is resisted, are relative to, m/s."""
    none = [0.0] * len(pairs)
    return np.array(none + [pair.surface for pair in pairs] + (none if resists(pairs) else []))


def all_pairs(case: PairCase, body: Sequence[float] | np.ndarray, around: float) -> list[tuple[float, float]]:
    """Pairs of nearest points with small gaps in one pose, from Newton's method at samples of the track near `around`,
    a parameter near the plate."""
    track, outline, reach = case.track, case.plate.outline, case.plate.reach
    x, y, theta = (float(v) for v in body[:3])
    if track.domain or track.period:
        samples = np.linspace(*track.span, 8 * SAMPLES)
    else:
        wide = 6.0 * reach / float(track.speed(around))
        samples = np.linspace(around - wide, around + wide, 4 * SAMPLES)
    points = track.point(samples)
    samples = samples[np.hypot(points[0] - x, points[1] - y) < (1.0 + NEAR) * reach]
    samples = samples[:: max(1, len(samples) // SAMPLES)]
    own = np.linspace(*outline.span, 1440)
    angles = np.asarray(outline.tangent_angle(own)) + theta
    results: list[tuple[float, float]] = []
    for xi1 in samples.tolist():
        off = np.angle(np.exp(1j * (angles - float(track.tangent_angle(xi1)))))
        try:
            one = find(case, x, y, theta, (xi1, float(own[np.argmin(np.abs(off))])))
        except DoesNotFit:
            continue
        if track.ends and not track.ends[0] <= one.xi1 <= track.ends[1]:
            continue
        if abs(one.gap) > NEAR * reach or not _faces(case, one.xi1, one.xi2, theta):
            continue
        place = track.point(one.xi1)
        if all(np.hypot(*(place - track.point(xi1))) > APART * reach for xi1, _ in results):
            results.append((one.xi1, one.xi2))
    return results


def _faces(case: Case, xi1: float, xi2: float, theta: float) -> bool:
    """Whether the tangents point in the same direction, and the outline bends more than the track."""
    angle = float(case.track.tangent_angle(xi1)) - float(case.plate.outline.tangent_angle(xi2)) - theta
    return cos(angle) > 0.0 and float(case.plate.outline.curvature(xi2)) > float(case.track.curvature(xi1))


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


def frictions(contacts: Sequence[PairState]) -> tuple[np.ndarray, np.ndarray]:
    """The coefficients of friction of all contacts with their slip, and without; where one resists rolling, followed by
    the arms in units of the radius of gyration."""
    values = np.array([friction_of(one.contact, abs(one.slip)) for one in contacts]).reshape(-1, 2)
    if not resists(contacts):
        return values[:, 0], values[:, 1]
    arms = [resisting_arm(one.contact) / one.contact.plate.gyration for one in contacts]
    return np.append(values[:, 0], arms), np.append(values[:, 1], arms)


class PlateDynamics:
    """Mass and applied forces of a case."""

    def __init__(self, case: Case, drive_load: DriveLoad | None = None):
        self.case = case
        self.inverse = 1.0 / np.array([case.plate.mass, case.plate.mass, case.plate.inertia])
        self.units = np.array([1.0, 1.0, case.plate.gyration])
        gravity = case.effect(Gravity)
        self.weight = np.zeros(3)
        if gravity is not None:
            self.weight[:2] = case.plate.mass * np.array(gravity.vector)
        self.load = drive_load or case.effect(Load)

    @property
    def turning_row(self) -> np.ndarray:
        """The row of a plate's rotation in (vx, vy, ω), in units of its radius of gyration."""
        return np.array([0.0, 0.0, self.units[2]])

    @property
    def moves(self) -> np.ndarray:
        """Which velocities can change: a plate of infinite inertia does not turn."""
        return self.inverse > 0.0

    def torsor(self, t: float, body: Sequence[float] | np.ndarray) -> np.ndarray:
        """The applied force and moment (N, N, N m)."""
        if self.load is None:
            return self.weight
        return self.weight + np.array(self.load.at(t, *(float(v) for v in body)))

    def delassus(self, pairs: Sequence[PairState]) -> tuple[np.ndarray, np.ndarray]:
        """The Delassus matrix (2K, 2K) of lifts, then slips, and the rows (2K, velocities); where a contact resists
        rolling, followed by the rotation for each contact, in units of the radius of gyration: 3K."""
        turning = [self.turning_row] * len(pairs) if resists(pairs) else []
        rows = np.array([p.lift_row for p in pairs] + [p.slip_row for p in pairs] + turning)
        rows = rows.reshape(-1, len(self.inverse))
        return rows * self.inverse @ rows.T, rows

    def free_rates(
        self, t: float, body: Sequence[float] | np.ndarray, pairs: Sequence[PairState], rows: np.ndarray
    ) -> np.ndarray:
        """Accelerations of the gaps, then of the slips, without contact forces; `rows` are those of `delassus`."""
        biases = np.array([p.lift_bias for p in pairs] + [p.slip_bias for p in pairs])
        biases = np.append(biases, np.zeros(len(rows) - len(biases)))
        return rows @ (self.inverse * self.torsor(t, body)) + biases
