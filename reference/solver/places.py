"""Numbers of contacts at one instant: nearest points, gaps, the rows of their velocities, and projections.

With t and n = U t at the contact, r_A and r_B the arms from the centres of mass of base and plate, and φ̇ the rate at
which the common tangent turns, the relative acceleration of the touching points is, per row (derived from (8)″ with
both sides moving; s_A, s_B are arc lengths of the contact's place on both curves):

    n·(a_B − a_A) + h_t ω̇_B − f_t ω̇_A = ω_B² h_n − ω_A² f_n − ω_B ṡ_B + ω_A ṡ_A + v φ̇,
    t·(a_B − a_A) − h_n ω̇_B + f_n ω̇_A = v̇ + ω_B² h_t − ω_A² f_t.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from math import cos, inf, sin
from typing import NamedTuple, cast

import numpy as np

from cases import Case, Mode
from cases.contact import belt_speed, geometry, start_motion
from cases.curves.corner import Corner, Piece
from cases.scene.couples import Couple
from cases.scene.free_plates import plates_of, start_poses
from cases.scene.piece_case import PieceCase
from cases.scene.supports import TRACK

from ..effect_laws import Laws, laws
from ..effect_laws.restitution import restitution
from .contact_terms import Bend, contact_rates
from .plate_numbers import Sides, bodies, rows_of, size, turning_row

# Newton's steps that move plates onto their contacts: each squares the error, which begins at a tolerance.
STEPS = 8
# The rows of two contacts of the same plates are the same one within this part: their tangents lie on one line.
SAME_ROW = 1e-9

State = Sequence[float] | np.ndarray


def couple_of(pair: PieceCase) -> Couple:
    """The couple of a plate and a boundary that a pair of elements belongs to."""
    return cast(Couple, pair.whole)


def who_and_which(couple: Couple) -> tuple[str, str]:
    """What sentences call the plate of a couple and what it may touch."""
    name, _, base = couple.pair_name.partition("/")
    who = f"The plate {name!r}" if couple.whole.others else "The plate"
    return who, "its track" if base == TRACK else f"the {'support' if couple.base is None else 'plate'} {base!r}"


def in_round(pair: PieceCase) -> tuple[int, int]:
    """The numbers of the elements of a pair, within one round of closed curves."""
    couple = couple_of(pair)
    counts = [len(getattr(curve, "elements", (None,))) for curve in (couple.track, couple.plate.outline)]
    return pair.first.number % counts[0], pair.second.number % counts[1]


def sides_of(pair: PieceCase) -> Sides:
    """The numbers of the plates of a pair of elements."""
    couple = couple_of(pair)
    return (couple.body,) if couple.base is None else (couple.body, couple.base)


class ContactPlace(NamedTuple):
    """One contact: its pair of elements, gap (m), tangent, parameters of both elements, the rows (3n,) of lift and slip
    velocity, the parts of their rates that the velocities give, and the clearance of the curvatures (1/m)."""

    pair: PieceCase
    gap: float
    tangent: tuple[float, float]
    xi1: float
    xi2: float
    lift_row: np.ndarray
    slip_row: np.ndarray
    lift_bias: float
    slip_bias: float
    clearance: float

    @property
    def law(self) -> Laws:
        """The laws of its couple's effects."""
        return laws(couple_of(self.pair))

    def belt(self, t: float) -> float:
        """The speed of the base's surface, m/s."""
        return float(belt_speed(self.pair, t))

    def belt_rate(self, t: float) -> float:
        """The rate of that speed, m/s²."""
        return self.law.belt.rate(self.pair, t)

    def slip(self, velocity: np.ndarray, t: float) -> float:
        """The slip velocity (m/s) relative to the surface of the base."""
        return float(self.slip_row @ velocity) - belt_speed(self.pair, t)

    def slip_rate(self, acceleration: np.ndarray, t: float) -> float:
        """The rate of the slip velocity (m/s²) with accelerations (3n,) of all plates."""
        return float(self.slip_row @ acceleration) + self.slip_bias - self.belt_rate(t)

    def mu_of(self, velocity: np.ndarray, t: float) -> float:
        """The coefficient of friction at the slip that these velocities have."""
        return self.law.friction.coefficient_at(self.pair, self.slip(velocity, t))

    @property
    def mu(self) -> float:
        """The coefficient of friction of a slip that begins."""
        return self.law.friction.coefficients(self.pair)[0]

    @property
    def stick(self) -> float:
        """The coefficient of friction without slip."""
        return self.law.friction.coefficients(self.pair)[1]

    @property
    def restitution(self) -> float:
        """The coefficient of restitution."""
        return restitution(self.pair)

    @property
    def turning_row(self) -> np.ndarray:
        """The row (3n,) of the rotation that rolling resistance is against."""
        return turning_row(self.sides, len(self.lift_row))

    @property
    def resisting_arm(self) -> float:
        """The largest couple of rolling resistance per normal force, m."""
        return self.law.resistance.arm(self.pair)

    @property
    def without_slip(self) -> Mode:
        """The mode of the contact without slip: of a plate that cannot turn on what is fixed it is a rest."""
        couple = couple_of(self.pair)
        rests = not (couple.plate.turns or couple.plate.spins_by_load) and couple.base is None
        return Mode.REST if rests else Mode.ROLL

    @property
    def sides(self) -> Sides:
        """The numbers of the plates that touch."""
        return sides_of(self.pair)


def place(pair: PieceCase, state: State, near: tuple[float, float]) -> ContactPlace:
    """The contact of two elements next to a pair of parameters. Raises DoesNotFit."""
    couple, half = couple_of(pair), len(state) // 2
    poses, rates = np.asarray(state[:half], dtype=float), np.asarray(state[half:], dtype=float)
    u, v, turn = (float(value) for value in couple.relative_pose(poses))
    at = geometry.find(*pair.pieces, u, v, turn, near)
    track, outline = cast(tuple[Piece, Piece], pair.pieces)
    body = couple.body
    x, y, theta = poses[3 * body : 3 * body + 3].tolist()
    u, v, turn = poses[3 * couple.base : 3 * couple.base + 3].tolist() if couple.base is not None else (0.0, 0.0, 0.0)
    (tx, ty), (px, py) = track.tangent(at.xi1).tolist(), track.point(at.xi1).tolist()
    c, s = cos(turn), sin(turn)
    (tx, ty), (fx, fy) = (c * tx - s * ty, s * tx + c * ty), (c * px - s * py, s * px + c * py)
    hx, hy = u + fx - at.gap * ty - x, v + fy + at.gap * tx - y
    ht, hn = hx * tx + hy * ty, hy * tx - hx * ty
    ft, fn = fx * tx + fy * ty, fy * tx - fx * ty
    lift, slip = np.zeros(half), np.zeros(half)
    lift[3 * body : 3 * body + 3], slip[3 * body : 3 * body + 3] = (-ty, tx, ht), (tx, ty, -hn)
    spin, turning = float(rates[3 * body + 2]), 0.0
    if couple.base is not None:
        own = slice(3 * couple.base, 3 * couple.base + 3)
        lift[own], slip[own] = (ty, -tx, -ft), (-tx, -ty, fn)
        turning = float(rates[3 * couple.base + 2])
    speed = float(slip @ rates)
    f, h = (
        Bend(piece.sign, 0.0) if isinstance(piece, Corner) else Bend(0.0, float(piece.curvature(s)))
        for piece, s in ((track, at.xi1), (outline, at.xi2))
    )
    along_track, along_outline, tangent_rate, clearance = contact_rates(f, h, speed, spin, turning)
    bias_n = -spin * spin * hn + turning * turning * fn + spin * along_outline - turning * along_track
    bias_t = -spin * spin * ht + turning * turning * ft
    return ContactPlace(
        pair, at.gap, (tx, ty), at.xi1, at.xi2, lift, slip, bias_n - speed * tangent_rate, bias_t,
        inf if clearance is None else clearance,
    )  # fmt: skip


def groups(now: Sequence[ContactPlace]) -> list[list[int]]:
    """The places of contacts in groups that share plates: what happens in one changes no other."""
    results = list[tuple[set[int], list[int]]]()
    for k, at in enumerate(now):
        own = [group for group in results if group[0] & set(at.sides)]
        sides = set(at.sides).union(*(group[0] for group in own))
        contacts = sorted([k, *(n for group in own for n in group[1])])
        results = [group for group in results if group not in own] + [(sides, contacts)]
    return [contacts for _, contacts in results]


def plates_in(now: Iterable[ContactPlace]) -> frozenset[int]:
    """The plates of some contacts."""
    return frozenset(side for at in now for side in at.sides)


def anchors_of(
    case: Case, velocity: np.ndarray, closed: Sequence[ContactPlace], stuck: Sequence[ContactPlace]
) -> frozenset[int]:
    """Plates without velocity that closed contacts with what does not move hold: as many rows of theirs are independent
    as the plate has freedoms. A belt moves a plate that sticks to it."""
    some, anchors = bodies(case), set[int]()
    plates = plates_of(case)
    still = {b for b in plates_in(closed) if not velocity[3 * b : 3 * b + 3].any() and not plates[b].spins_by_load}
    for _ in still:
        for body in still - anchors:
            own = slice(3 * body, 3 * body + 3)
            rows = [
                row[own] * np.sqrt(some.inverse[own])
                for at, row in [*((at, at.lift_row) for at in closed), *((at, at.slip_row) for at in stuck)]
                if body in at.sides and set(at.sides) <= anchors | {body} and not at.law.belt.runs
            ]
            freedoms = np.count_nonzero(some.inverse[own])
            if (
                len(rows) >= freedoms
                and np.linalg.matrix_rank(np.array(rows), tol=SAME_ROW * some.inverse[own].max() ** 0.5) == freedoms
            ):
                anchors.add(body)
    return frozenset(anchors)


def sharing(now: Sequence[ContactPlace]) -> dict[int, int]:
    """Contacts with the first one of the same plates and the same slip, as of two corners of a side: friction forces
    of both have the same effect, and only their sum is unique."""
    result = dict[int, int]()
    for k, at in enumerate(now):
        size_of = float(np.abs(at.slip_row).max())
        for first in range(k):
            other = now[first]
            same = first not in result and at.sides == other.sides
            if same and float(np.abs(at.slip_row - other.slip_row).max()) <= SAME_ROW * size_of:
                result[k] = first
                break
    return result


def project(
    case: Case, state: tuple[float, ...], now: Sequence[ContactPlace]
) -> tuple[tuple[float, ...], list[ContactPlace]]:
    """The plates moved by rounding so that these contacts, which are those of the state, have no gap, and the contacts;
    plates of other contacts keep their bits."""
    values, inverse, half, now = np.array(state, dtype=float), bodies(case).inverse, len(state) // 2, list(now)
    least, is_moved = 2e-16 * size(case, values), False
    for group in groups(now):
        for _ in range(STEPS):
            some = [now[k] for k in group]
            gaps = np.array([at.gap for at in some])
            if np.abs(gaps).max() <= least:
                break
            is_moved = True
            rows = np.array([at.lift_row for at in some])
            values[:half] -= inverse * (rows.T @ np.linalg.lstsq(rows * inverse @ rows.T, gaps, rcond=1e-10)[0])
            for k in group:
                now[k] = place(now[k].pair, values, (now[k].xi1, now[k].xi2))
    return tuple(values.tolist()) if is_moved else state, now


def without_velocity(
    case: Case, t: float, state: State, touching: Sequence[ContactPlace], stuck: Sequence[ContactPlace],
    still: Collection[Sides] = (),
) -> tuple[float, ...]:  # fmt: skip
    """The state with lift velocity 0 at touching contacts and slip velocity 0 at the stuck ones, and without rotation
    of the plates `still` against each other: the nearest such velocities in kinetic energy. Plates of other contacts
    keep their bits."""
    if not touching:
        return tuple(state)
    some, half = bodies(case), len(state) // 2
    velocity = np.array(state[half:], dtype=float)
    now, count = [*touching, *stuck], len(touching)
    for group in groups(now):
        rows = np.array([now[k].lift_row if k < count else now[k].slip_row for k in group])
        goals = np.array([0.0 if k < count else belt_speed(now[k].pair, t) for k in group])
        plates = plates_in(now[k] for k in group)
        rotations = [turning_row(sides, half) for sides in still if set(sides) <= plates]
        if rotations:
            rows, goals = np.vstack([rows, rotations]), np.append(goals, np.zeros(len(rotations)))
        steps = [np.arange(len(rows))] * 2  # the second step removes the rounding of the first
        if goals.any():  # plates on two belts need not fit both, and stay on them
            steps.append(np.flatnonzero(np.array(group) < count))
        for some_rows in steps:
            part = rows[some_rows]
            missing = part @ velocity - goals[some_rows]
            off = np.linalg.lstsq(part * some.inverse @ part.T, missing, rcond=1e-10)[0]
            velocity = velocity - some.inverse * (part.T @ off)
        # Plates that their contacts hold have no velocity, to the last bit.
        own = rows_of(plates)
        sizes = np.linalg.svd(rows * np.sqrt(some.inverse), compute_uv=False)
        rank = np.count_nonzero(sizes > 1e-9 * sizes[0])
        is_held = not velocity[own][some.inverse[own] == 0.0].any()  # none of them is turned
        if not goals.any() and is_held and rank == np.count_nonzero(some.inverse[own]):
            velocity[own] = 0.0
    return (*map(float, state[:half]), *velocity.tolist())


def start_of(case: Case) -> tuple[float, ...]:
    """The state of all plates where a motion begins."""
    poses, first = start_poses(case), start_motion(case)
    poses[0] = first.x, first.y, first.theta, first.vx, first.vy, first.omega  # on a belt
    return (*poses[:, :3].ravel().tolist(), *poses[:, 3:].ravel().tolist())
