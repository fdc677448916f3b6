"""One phase of the second formulation: accelerations with fixed modes, and guards that are positive while it lasts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import inf, isfinite
from types import MappingProxyType
from typing import NamedTuple, cast

import numpy as np

from cases import Belt, Case, CoulombFriction, Curve, Mode, Unilateral
from cases.formulas.features import Features
from cases.own_effects import own_effects
from cases.scene.contact_pairs import PairCase
from cases.scene.piece_case import PieceCase

from .complementarity import least_rate, solutions
from .contacts import (
    AnyPair,
    PairState,
    PlateDynamics,
    Sides,
    friction_of,
    frictions,
    is_rough,
    moves,
    on_side,
    on_surface,
    open_pair_at,
    pair_at,
    plates_at,
    resisting_arm,
)
from .loads import FormulaScales, slip_scales
from .watched_pairs import piece_end, sides_of

# Singular values below this part of the largest are rows that depend on others.
DEPENDENT = 1e-10
# Rates below this part of those without contact forces are none.
NO_RATE = 1e-12
SIGN = {Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}
# The modes of contacts that do not slip.
STICKS = (Mode.ROLL, Mode.REST)
# The kinds of guards at which the motion ends with that status: a closed contact has reached an end of a curve, where
# a plate fits no longer, or Painlevé's paradox.
CURVE_ENDS = ("track_end", "outline_end", "no_fit", "paradox")
# The prefix of the kinds of guards by which effects of packages end the motion.
OWN = "own "


def rotation_name(sides: Sides) -> str:
    """The name under which the rotation of two plates against each other is compared with slips."""
    return f"rotation {sides}"


class WatchedContact(NamedTuple):
    """A watched contact: its name, its pair of a support and a feature, its points, mode (FLIGHT: open), and whether it
    is an arc that is turned away from the support, and the side of its normal force (−1: a guide that pulls)."""

    name: str
    case: AnyPair
    pair: tuple[float, float]
    mode: Mode
    is_away: int = 0
    side: int = 1

    @property
    def is_closed(self) -> bool:
        return self.mode is not Mode.FLIGHT

    def at(self, t: float, body: np.ndarray, near: tuple[float, float], gap: float | None = None) -> PairState:
        """The contact in a state of the plates, from points near it, or at these if its `gap` (m) is known."""
        is_near = self.is_closed or gap is not None
        state = pair_at(self.case, body, near, gap) if is_near else open_pair_at(self.case, body, near)
        return on_side(on_surface(state, t), self.side)


class ContactSolution(NamedTuple):
    """Accelerations (3n,), normal and friction force of each contact (K,), N, and for plates that do not turn against
    each other the couple of all their contacts over the radius of gyration, N; of one contact
    the matrix, rows and inverse masses."""

    acceleration: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    couples: Mapping[Sides, float] = MappingProxyType({})
    problem: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    @property
    def inverse_mass(self) -> float:
        """Painlevé's number of one contact, 1 without friction."""
        if self.problem is None:
            return 1.0
        matrix, rows, inverse = self.problem
        return _determinant(matrix) / _determinant(rows * inverse @ rows.T)


def _determinant(matrix: np.ndarray) -> float:
    if len(matrix) > 2:
        return float(np.linalg.det(matrix))
    (a, *b), *rest = matrix.tolist()
    return a * rest[0][1] - b[0] * rest[0][0] if rest else a


def _solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solution of a linear system, of up to two unknowns without LAPACK, whose calls take longer than a phase's
    equations. Raises LinAlgError."""
    if len(right) > 2:
        return np.linalg.solve(matrix, right)
    (a, *b), *rest = matrix.tolist()
    p, *q = right.tolist()
    if not rest:
        values, size = [p], a
    else:
        c, d = rest[0]
        values, size = [p * d - b[0] * q[0], a * q[0] - c * p], a * d - b[0] * c
    if size == 0.0:
        raise np.linalg.LinAlgError("singular")
    return np.array(values) / size


class SeveralContactPhase:
    """The equations of a phase, and the pairs of points, which are followed from one evaluation to the next.

    `is_carried`: contacts have more rows than velocities: accelerations are unique, and forces are not. `turns`: for
    plates whose contacts resist their rotation against each other its sense, 0 if they prevent it. `resting`: plates at
    rest, which have no accelerations, and under a constant load their contacts no guards and forces.
    """

    def __init__(
        self,
        dynamics: PlateDynamics,
        contacts: Sequence[WatchedContact],
        is_carried: bool = False,
        turns: Mapping[Sides, int] = MappingProxyType({}),
        resting: frozenset[int] = frozenset(),
    ):
        self.dynamics, self.contacts, self.is_carried = dynamics, list(contacts), is_carried
        self.turns, self.resting = dict(turns), resting
        frozen = resting if dynamics.is_constant else frozenset()
        self.frozen = {contact.name for contact in contacts if sides_of(contact.case) <= frozen}
        # The plates that one contact holds: their accelerations are zero, not roundings of it.
        self.immobile = {plates_at(c.case)[0] for c in contacts if c.mode is Mode.REST and not moves(c.case)}
        self.near = [contact.pair for contact in contacts]
        self.hopping: set[str] = set()  # contacts in a hop that begins with the phase

    def whole_state(self, body: np.ndarray) -> np.ndarray:
        """The state that is integrated: `body`, the parameters ξ₁ and ξ₂ of each closed contact, and of each in a hop
        that begins with the phase, and the gap of these. Nearest points would give them less accurately where the
        curves nearly fit each other, and a low hop's gap not at all."""
        points = list[float]()
        for contact, near in zip(self.contacts, self.near, strict=True):
            points += near if contact.is_closed else (*near, 0.0) if contact.name in self.hopping else ()
        return np.append(body, points)

    def plates(self, y: np.ndarray) -> np.ndarray:
        """(x, y, θ) of all plates and (vx, vy, ω) of all, of a state of the phase or of many."""
        return y[: 2 * len(self.dynamics.weight)]

    def pairs(self, t: float, y: np.ndarray) -> list[PairState]:
        """All contacts in one state of the phase, or of the plates alone."""
        now = self.pairs_of(t, y, True)
        self.near = [(pair.xi1, pair.xi2) for pair in now if pair is not None]
        return cast(list[PairState], now)

    def closed_pairs(self, t: float, y: np.ndarray) -> list[PairState | None]:
        """The closed contacts in one state; an integrator's stages lie ahead, where open ones may be lost."""
        return self.pairs_of(t, y, False)

    def pairs_of(self, t: float, y: np.ndarray, every: bool) -> list[PairState | None]:
        """The closed contacts, or every one, in one state."""
        body, result = self.plates(y), list[PairState | None]()
        points, is_whole = iter(y[len(body) :].tolist()), len(y) > len(body)
        for contact, near in zip(self.contacts, self.near, strict=True):
            hops = contact.name in self.hopping
            if is_whole and (contact.is_closed or hops):
                at = next(points), next(points)
                result.append(contact.at(t, body, at, next(points) if hops else 0.0))
            else:
                result.append(contact.at(t, body, near) if every or contact.is_closed else None)
        return result

    def forces(self, t: float, y: np.ndarray, now: Sequence[PairState | None] | None = None) -> ContactSolution:
        """Accelerations and forces in the phase's modes, from the Delassus matrix."""
        now, body = self.closed_pairs(t, y) if now is None else now, self.plates(y)
        now = [None if c.name in self.frozen else pair for c, pair in zip(self.contacts, now, strict=True)]
        dynamics, count = self.dynamics, len(self.contacts)
        some = [pair for c, pair in zip(self.contacts, now, strict=True) if pair is not None and c.is_closed]
        free = dynamics.inverse * (dynamics.torsor(t, body) + dynamics.own_forces(t, some))
        normal, friction = np.zeros(count), np.zeros(count)
        rows, columns, biases = list[np.ndarray](), list[np.ndarray](), list[float]()
        which: list[tuple[int, float | None]] = []
        for k, (contact, pair) in enumerate(zip(self.contacts, now, strict=True)):
            if pair is None or not contact.is_closed:
                continue
            sign = SIGN.get(contact.mode, 0.0)
            # A stage may pass the end of the slip: the coefficient is that of the formula just below zero.
            ratio = -sign * friction_of(contact.case, sign * pair.slip)[0]
            rows.append(pair.lift_row)
            columns.append(pair.lift_row + ratio * pair.slip_row)
            if sense := self.turns.get(pair.sides):
                arm = resisting_arm(contact.case) / contact.case.plate.gyration
                columns[-1] = columns[-1] - sense * arm * pair.turning_row
            biases.append(pair.lift_bias)
            which.append((k, ratio))
            if contact.mode in STICKS:
                rows.append(pair.slip_row)
                columns.append(pair.slip_row)
                biases.append(pair.slip_bias)
                which.append((k, None))
        still = [3 * b + i for b in self.resting | self.immobile for i in range(3)]
        if not rows:
            free[still] = 0.0
            return ContactSolution(free, normal, friction)
        couple_rows = {pair.sides: pair.turning_row for pair in some if self.turns.get(pair.sides) == 0}
        rows += couple_rows.values()
        columns += couple_rows.values()
        biases += [0.0] * len(couple_rows)
        rows_matrix, columns_matrix = np.array(rows), np.array(columns).T
        matrix = rows_matrix @ (dynamics.inverse[:, None] * columns_matrix)
        right = -(rows_matrix @ free + np.array(biases))
        if self.is_carried:
            multipliers = np.linalg.lstsq(matrix, right, rcond=DEPENDENT)[0]
        else:
            multipliers = _solve(matrix, right)
        for (k, share), value in zip(which, multipliers.tolist(), strict=False):
            if share is None:
                friction[k] = value
            else:
                normal[k] = value
                friction[k] = share * value
        acceleration = free + dynamics.inverse * (columns_matrix @ multipliers)
        acceleration[still] = 0.0
        couples = dict(zip(couple_rows, multipliers[len(which) :].tolist(), strict=True))
        problem = (matrix, rows_matrix, dynamics.inverse) if len(some) == 1 else None
        return ContactSolution(acceleration, normal, friction, couples, problem)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """The derivative of a state of the phase."""
        now, half = self.closed_pairs(t, y), len(self.dynamics.weight)
        points = list[float]()
        for contact, pair in zip(self.contacts, now, strict=True):
            if pair is not None:
                points += pair.xi1_rate, pair.xi2_rate, *(() if contact.is_closed else (pair.lift,))
        return np.concatenate([y[half : 2 * half], self.forces(t, y, now).acceleration, points])

    def allows(self, times: np.ndarray, states: np.ndarray) -> bool:
        """Whether loads, and the laws of friction of slipping contacts, allow a step through these states (variables,
        n)."""
        if not self.dynamics.load_allows(times, self.plates(states)):
            return False
        some = [(k, scales, SIGN[c.mode]) for k, c in enumerate(self.contacts)
                if c.mode in SIGN and (scales := _scales(c.case)) is not None]  # fmt: skip
        every = [self.closed_pairs(t, state) for t, state in zip(times.tolist(), states.T, strict=True) if some]
        return all(scales.allows(sign * np.array([now[k].slip for now in every])) for k, scales, sign in some)  # type: ignore[union-attr]

    def guards(self, t: float, y: np.ndarray, now: Sequence[PairState] | None = None) -> dict[tuple[str, str], float]:
        """Values by (kind, contact) that are positive while the phase lasts, each in its natural unit: forces in the
        weight or load, speeds and gaps in SI units."""
        now = self.pairs(t, y) if now is None else now
        forces = self.forces(t, y, now)
        values: dict[tuple[str, str], float] = {}
        for k, (contact, pair) in enumerate(zip(self.contacts, now, strict=True)):
            normal, friction = float(forces.normal[k]), float(forces.friction[k])
            if isinstance(contact.case, PairCase) and contact.case.arc_range is not None:
                low, high = contact.case.limits_of_turn(contact.is_away)
                values["turn", contact.name] = min(pair.xi2 - low, high - pair.xi2)
            if isinstance(contact.case, PieceCase):
                end = piece_end(contact.case, (pair.xi1, pair.xi2))
                if end.distance < inf:
                    values["turn" if end.following else CURVE_ENDS[end.curve], contact.name] = end.distance
            if contact.is_away:
                continue
            is_guide = contact.case.effect(Unilateral) is None
            if contact.is_closed and (contact.mode in SIGN or self.turns.get(pair.sides)):
                values["paradox", contact.name] = forces.inverse_mass
            if not contact.is_closed:
                values["gap", contact.name] = pair.gap
            elif self.is_carried:
                pass  # its force is not unique: "held" shows whether forces are admissible
            elif contact.mode in STICKS and not is_rough(contact.case):
                bound = friction_of(contact.case)[1] * normal
                values["cone+", contact.name], values["cone-", contact.name] = bound + friction, bound - friction
            elif is_guide:
                values |= {("side", contact.name): normal} if contact.mode in SIGN or self.turns else {}
            else:
                values["normal", contact.name] = normal
            if contact.mode in SIGN:
                values["slip", contact.name] = SIGN[contact.mode] * pair.slip
            if contact.is_closed:
                values |= _inside_ends(contact, pair) | _own_ends(contact, pair, t)
        for sides, sense in self.turns.items():
            name, same = rotation_name(sides), [k for k, pair in enumerate(now) if pair.sides == sides]
            if sense:
                body = self.plates(y)
                values["rotation", name] = sense * float(now[same[0]].turning_row @ body[len(body) // 2 :])
            elif sides in forces.couples and not self.is_carried:
                bound = sum(resisting_arm(self.contacts[k].case) * float(forces.normal[k]) for k in same)
                bound, couple = bound / now[same[0]].contact.plate.gyration, forces.couples[sides]
                values["couple+", name], values["couple-", name] = bound + couple, bound - couple
        if self.is_carried:
            values["held", ""] = 1.0 if self.starts(t, y) is None else -1.0
        return {key: value for key, value in values.items() if key[1] not in self.frozen}

    def curves(self) -> list[tuple[int, Curve]]:
        """The curves of closed contacts, with the rows of their parameters."""
        some, row = list[tuple[int, Curve]](), 2 * len(self.dynamics.weight)
        for contact in self.contacts:
            if contact.is_closed:
                some += (row, contact.case.track), (row + 1, contact.case.plate.outline)
            row += 2 if contact.is_closed else 3 if contact.name in self.hopping else 0
        return some

    def features(self) -> list[tuple[int | None, Features]]:
        """Features of loads and belts in time (None), and of closed contacts' curves by their parameters' rows."""
        belts = [contact.case.effect(Belt) for contact in self.contacts if contact.is_closed]
        some = [*self.dynamics.features, *(belt.features for belt in belts if belt is not None)]
        by_row = [(row, curve.features) for row, curve in self.curves()]
        return [*((None, one) for one in some if one), *((row, one) for row, one in by_row if one and not one.plain)]

    def starts(self, t: float, y: np.ndarray) -> dict[str, float] | None:
        """The contacts that Coulomb's law opens (0) or lets slip (the sign of the slip) where it does not let a plate
        go on that is carried by belts, and the sense in which the plate begins to turn; None where it does."""
        closed = [(c, cast(PairState, p)) for c, p in zip(self.contacts, self.closed_pairs(t, y), strict=True) if p]
        some, count = [pair for _, pair in closed], len(closed)
        delassus, rows = self.dynamics.delassus(some)
        free = self.dynamics.free_rates(t, self.plates(y), some, rows)
        slips, law = [SIGN.get(contact.mode) for contact, _ in closed], frictions(some)
        senses = [self.turns.get(pair.sides) for pair in some] if len(law[0]) > count else []
        slips += [float(sense) if sense else None for sense in senses]
        rolls = [k for k, (contact, _) in enumerate(closed) if contact.mode in STICKS]
        constraints = [*range(count), *(count + k for k in rolls)]
        constraints += [2 * count + k for k, sense in enumerate(senses) if sense == 0]
        if least_rate(delassus, free, slips, *law, constraints, NO_RATE) <= NO_RATE:
            return None
        answers = solutions(delassus, free, slips, *law)
        if not answers:
            return {}
        rates, small = [delassus @ force + free for force in answers], NO_RATE * float(np.abs(free).max())
        slipping = [k for k in rolls if abs(rates[0][count + k]) > small]
        opening = {closed[k][0].name: 0.0 for k in range(count) if rates[0][k] > small}
        for k, sense in enumerate(senses):
            if sense == 0 and abs(turning := float(rates[0][2 * count + k])) > small:
                opening[rotation_name(some[k].sides)] = float(np.sign(turning))
        return {closed[k][0].name: float(np.sign(rates[0][count + k])) for k in slipping} | opening

    def starts_after(self, step: float, t: float, y: np.ndarray) -> dict[str, float]:
        """`starts` a short time (s) later, when rates that begin at zero are more than rounding; empty if the plate
        goes on."""
        y = self.whole_state(y)
        return self.starts(t + step, y + step * self.rates(t, y)) or {}


@lru_cache(maxsize=256)
def _scales(pair: Case) -> FormulaScales | None:
    return slip_scales(pair.effect(CoulombFriction))


def _own_ends(contact: WatchedContact, pair: PairState, t: float) -> dict[tuple[str, str], float]:
    """The conditions of effects of packages at a closed contact, and that of its curves: that the plate fits."""
    values = dict[tuple[str, str], float]()
    for effect in own_effects(contact.case.effects):
        conditions = zip(effect.ends(), effect.at(t, pair.slip, pair.spin)[3:], strict=True)
        values |= {(f"{OWN}{end.status}", contact.name): value for end, value in conditions}
    if isfinite(clearance := pair.clearance):
        values["no_fit", contact.name] = clearance * contact.case.plate.reach
    return values


def _inside_ends(contact: WatchedContact, pair: PairState) -> dict[tuple[str, str], float]:
    """How far a contact is inside the ends of its curves, in their parameters. A chain's arcs and edges end by
    their turn, and a corner has no ends. Free plates have none: an edge goes on as a corner."""
    if not isinstance(contact.case, PairCase):
        return {}
    curves = [("track_end", contact.case.track, pair.xi1)]
    if contact.case.centre is None and contact.case.arc_range is None:
        curves.append(("outline_end", contact.case.plate.outline, pair.xi2))
    return {
        (kind, contact.name): min(place - curve.ends[0], curve.ends[1] - place)
        for kind, curve, place in curves
        if curve.ends
    }
