"""One phase of several contacts: accelerations with fixed modes, and the guards that are positive while it lasts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple, cast

import numpy as np

from cases import Case, CoulombFriction, Mode
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
    on_surface,
    open_pair_at,
    pair_at,
    resisting_arm,
)
from .loads import FormulaScales, slip_scales
from .watched_pairs import next_elements, sides_of

# Singular values below this part of the largest are rows that depend on others.
DEPENDENT = 1e-10
# Rates below this part of those without contact forces are none.
NO_RATE = 1e-12
SIGN = {Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}
# The modes of contacts that do not slip.
STICKS = (Mode.ROLL, Mode.REST)
# The kinds of guards at which a closed contact has reached an end of a curve; they are the statuses of the motion.
CURVE_ENDS = ("track_end", "outline_end")


def rotation_name(sides: Sides) -> str:
    """The name under which the rotation of two plates against each other is compared with slips."""
    return f"rotation {sides}"


class WatchedContact(NamedTuple):
    """A watched contact: its name, its pair of a support and a feature, its points, mode (FLIGHT: open), and whether it
    is an arc that is turned away from the support."""

    name: str
    case: AnyPair
    pair: tuple[float, float]
    mode: Mode
    is_away: int = 0

    @property
    def is_closed(self) -> bool:
        return self.mode is not Mode.FLIGHT


class ContactSolution(NamedTuple):
    """Accelerations (3n,), normal and friction force of each contact (K,), N, and for plates that do not turn against
    each other the couple of all their contacts over the radius of gyration, N."""

    acceleration: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    couples: Mapping[Sides, float] = MappingProxyType({})


class SeveralContactPhase:
    """The equations of a phase, and the pairs of points, which are followed from one evaluation to the next.

    `rests`: the contacts hold the plate. `is_carried`: they have more than three rows and run with belts: the plate's
    accelerations are unique, and forces are not. `turns`: for plates whose contacts resist their rotation against each
    other its sense, 0 if they prevent it. `resting`: plates at rest, which have no accelerations, and their contacts no
    guards and forces.
    """

    def __init__(
        self,
        dynamics: PlateDynamics,
        contacts: Sequence[WatchedContact],
        rests: bool = False,
        is_carried: bool = False,
        turns: Mapping[Sides, int] = MappingProxyType({}),
        resting: frozenset[int] = frozenset(),
    ):
        self.dynamics, self.contacts, self.rests, self.is_carried = dynamics, list(contacts), rests, is_carried
        self.turns, self.resting = dict(turns), resting
        self.frozen = {contact.name for contact in contacts if sides_of(contact.case) <= resting}
        self.near = [contact.pair for contact in contacts]

    def pairs(self, t: float, body: Sequence[float] | np.ndarray) -> list[PairState]:
        """All contacts in one state of the plate."""
        now = [
            on_surface((pair_at if c.is_closed else open_pair_at)(c.case, body, near), t)
            for c, near in zip(self.contacts, self.near, strict=True)
        ]
        self.near = [(pair.xi1, pair.xi2) for pair in now]
        return now

    def closed_pairs(self, t: float, body: Sequence[float] | np.ndarray) -> list[PairState | None]:
        """The closed contacts in one state; an integrator's stages lie ahead, where open ones may be lost."""
        return [
            on_surface(pair_at(contact.case, body, near), t) if contact.is_closed else None
            for contact, near in zip(self.contacts, self.near, strict=True)
        ]

    def forces(
        self, t: float, body: Sequence[float] | np.ndarray, now: Sequence[PairState | None] | None = None
    ) -> ContactSolution:
        """Accelerations and forces in the phase's modes, from the Delassus matrix."""
        now = self.closed_pairs(t, body) if now is None else now
        now = [None if c.name in self.frozen else pair for c, pair in zip(self.contacts, now, strict=True)]
        dynamics, count = self.dynamics, len(self.contacts)
        some = [pair for c, pair in zip(self.contacts, now, strict=True) if pair is not None and c.is_closed]
        free = dynamics.inverse * dynamics.torsor(t, body)
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
        still = [3 * b + i for b in self.resting for i in range(3)]
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
            multipliers = np.linalg.solve(matrix, right)
        for (k, share), value in zip(which, multipliers.tolist(), strict=False):
            if share is None:
                friction[k] = value
            else:
                normal[k] = value
                friction[k] = share * value
        acceleration = free + dynamics.inverse * (columns_matrix @ multipliers)
        acceleration[still] = 0.0
        couples = dict(zip(couple_rows, multipliers[len(which) :].tolist(), strict=True))
        return ContactSolution(acceleration, normal, friction, couples)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """The derivative of (x, y, θ, vx, vy, ω)."""
        return np.concatenate([y[len(y) // 2 :], self.forces(t, y).acceleration])

    def slips_allow(self, times: np.ndarray, states: np.ndarray) -> bool:
        """Whether the laws of friction of slipping contacts allow a step through these states (variables, n)."""
        some = [(k, scales, SIGN[c.mode]) for k, c in enumerate(self.contacts)
                if c.mode in SIGN and (scales := _scales(c.case)) is not None]  # fmt: skip
        every = [self.closed_pairs(t, state) for t, state in zip(times.tolist(), states.T, strict=True) if some]
        return all(scales.allows(sign * np.array([now[k].slip for now in every])) for k, scales, sign in some)  # type: ignore[union-attr]

    def guards(self, t: float, y: np.ndarray) -> dict[tuple[str, str], float]:
        """Values by (kind, contact) that are positive while the phase lasts, each in its natural unit: forces in the
        weight or load, speeds and gaps in SI units."""
        now = self.pairs(t, y)
        forces = self.forces(t, y, now)
        values: dict[tuple[str, str], float] = {}
        for k, (contact, pair) in enumerate(zip(self.contacts, now, strict=True)):
            normal, friction = float(forces.normal[k]), float(forces.friction[k])
            if isinstance(contact.case, PairCase) and contact.case.arc_range is not None:
                low, high = contact.case.limits_of_turn(contact.is_away)
                values["turn", contact.name] = min(pair.xi2 - low, high - pair.xi2)
            if isinstance(contact.case, PieceCase):
                following = next_elements(contact.case, (pair.xi1, pair.xi2))
                values |= {("turn", contact.name): following.distance} if following else {}
            if contact.is_away:
                continue
            if not contact.is_closed:
                values["gap", contact.name] = pair.gap
            elif self.is_carried:
                pass  # its force is not unique: "held" shows whether forces are admissible
            elif contact.mode in STICKS and not is_rough(contact.case):
                bound = friction_of(contact.case)[1] * normal
                values["cone+", contact.name], values["cone-", contact.name] = bound + friction, bound - friction
            else:
                values["normal", contact.name] = normal
            if contact.mode in SIGN:
                values["slip", contact.name] = SIGN[contact.mode] * pair.slip
            if contact.is_closed:
                values |= _inside_ends(contact, pair)
        for sides, sense in self.turns.items():
            name, same = rotation_name(sides), [k for k, pair in enumerate(now) if pair.sides == sides]
            if sense:
                values["rotation", name] = sense * float(now[same[0]].turning_row @ y[len(y) // 2 :])
            elif sides in forces.couples and not self.is_carried:
                bound = sum(resisting_arm(self.contacts[k].case) * float(forces.normal[k]) for k in same)
                bound, couple = bound / now[same[0]].contact.plate.gyration, forces.couples[sides]
                values["couple+", name], values["couple-", name] = bound + couple, bound - couple
        if self.is_carried:
            values["held", ""] = 1.0 if self.starts(t, y) is None else -1.0
        return {key: value for key, value in values.items() if key[1] not in self.frozen}

    def starts(self, t: float, y: np.ndarray) -> dict[str, float] | None:
        """The contacts that Coulomb's law opens (0) or lets slip (the sign of the slip) where it does not let a plate
        go on that is carried by belts, and the sense in which the plate begins to turn; None where it does."""
        closed = [(c, cast(PairState, p)) for c, p in zip(self.contacts, self.closed_pairs(t, y), strict=True) if p]
        some, count = [pair for _, pair in closed], len(closed)
        delassus, rows = self.dynamics.delassus(some)
        free = self.dynamics.free_rates(t, y, some, rows)
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
        return self.starts(t + step, y if self.rests else y + step * self.rates(t, y)) or {}


@lru_cache(maxsize=256)
def _scales(pair: Case) -> FormulaScales | None:
    return slip_scales(pair.effect(CoulombFriction))


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
