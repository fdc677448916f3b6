"""One phase of several contacts: accelerations with fixed modes, and the guards that are positive while it lasts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, cast

import numpy as np

from cases import Mode
from cases.scene.contact_pairs import PairCase

from .complementarity import least_rate, solutions
from .contacts import (
    PairState,
    PlateDynamics,
    friction_of,
    frictions,
    is_rough,
    on_surface,
    open_pair_at,
    pair_at,
    resisting_arm,
)

# Singular values below this part of the largest are rows that depend on others.
DEPENDENT = 1e-10
# Rates below this part of those without contact forces are none.
NO_RATE = 1e-12
SIGN = {Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}
# The modes of contacts that do not slip, and the name under which the plate's rotation is compared with them.
STICKS, ROTATION = (Mode.ROLL, Mode.REST), "rotation"
# The kinds of guards at which a closed contact has reached an end of a curve; they are the statuses of the motion.
CURVE_ENDS = ("track_end", "outline_end")


class WatchedContact(NamedTuple):
    """A watched contact: its name, its pair of a support and a feature, its points, mode (FLIGHT: open), and whether it
    is an arc that is turned away from the support."""

    name: str
    case: PairCase
    pair: tuple[float, float]
    mode: Mode
    is_away: int = 0

    @property
    def is_closed(self) -> bool:
        return self.mode is not Mode.FLIGHT


class ContactSolution(NamedTuple):
    """Accelerations (3,), normal and friction force of each contact (K,), N, and what ends the rotation: the couple of
    all contacts over the radius of gyration, N."""

    acceleration: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    couple: float = 0.0


class SeveralContactPhase:
    """The equations of a phase, and the pairs of points, which are followed from one evaluation to the next.

    `rests`: the contacts hold the plate. `is_carried`: they have more than three rows and run with belts: the plate's
    accelerations are unique, and forces are not. `turn`: the sense of the rotation that contacts resist, 0 if they
    prevent it, None if none resists.
    """

    def __init__(
        self,
        dynamics: PlateDynamics,
        contacts: Sequence[WatchedContact],
        rests: bool = False,
        is_carried: bool = False,
        turn: int | None = None,
    ):
        self.dynamics, self.contacts, self.rests, self.is_carried = dynamics, list(contacts), rests, is_carried
        self.turn = turn
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
        dynamics, count = self.dynamics, len(self.contacts)
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
            if self.turn:
                columns[-1] = columns[-1] - self.turn * resisting_arm(contact.case) * np.array([0.0, 0.0, 1.0])
            biases.append(pair.lift_bias)
            which.append((k, ratio))
            if contact.mode in STICKS:
                rows.append(pair.slip_row)
                columns.append(pair.slip_row)
                biases.append(pair.slip_bias)
                which.append((k, None))
        if not rows:
            return ContactSolution(free, normal, friction)
        if self.turn == 0:
            rows.append(dynamics.turning_row)
            columns.append(dynamics.turning_row)
            biases.append(0.0)
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
        return ContactSolution(acceleration, normal, friction, float(multipliers[-1]) if self.turn == 0 else 0.0)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """The derivative of (x, y, θ, vx, vy, ω)."""
        return np.concatenate([y[len(y) // 2 :], self.forces(t, y).acceleration])

    def guards(self, t: float, y: np.ndarray) -> dict[tuple[str, str], float]:
        """Values by (kind, contact) that are positive while the phase lasts, each in its natural unit: forces in the
        weight or load, speeds and gaps in SI units."""
        now = self.pairs(t, y)
        forces = self.forces(t, y, now)
        values: dict[tuple[str, str], float] = {}
        for k, (contact, pair) in enumerate(zip(self.contacts, now, strict=True)):
            normal, friction = float(forces.normal[k]), float(forces.friction[k])
            if contact.case.arc_range is not None:
                low, high = contact.case.limits_of_turn(contact.is_away)
                values["turn", contact.name] = min(pair.xi2 - low, high - pair.xi2)
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
        if self.turn:
            values["rotation", ROTATION] = self.turn * float(self.dynamics.turning_row @ y[len(y) // 2 :])
        elif self.turn == 0 and not self.is_carried:
            arms = np.array([resisting_arm(contact.case) for contact in self.contacts])
            bound = float(arms @ forces.normal) / self.dynamics.units[2]
            values["couple+", ROTATION], values["couple-", ROTATION] = bound + forces.couple, bound - forces.couple
        if self.is_carried:
            values["held", ""] = 1.0 if self.starts(t, y) is None else -1.0
        return values

    def starts(self, t: float, y: np.ndarray) -> dict[str, float] | None:
        """The contacts that Coulomb's law opens (0) or lets slip (the sign of the slip) where it does not let a plate
        go on that is carried by belts, and the sense in which the plate begins to turn; None where it does."""
        closed = [(c, cast(PairState, p)) for c, p in zip(self.contacts, self.closed_pairs(t, y), strict=True) if p]
        some, count = [pair for _, pair in closed], len(closed)
        delassus, rows = self.dynamics.delassus(some)
        free = self.dynamics.free_rates(t, y, some, rows)
        slips, law = [SIGN.get(contact.mode) for contact, _ in closed], frictions(some)
        slips += [float(self.turn) if self.turn else None] * (len(law[0]) - count)
        rolls = [k for k, (contact, _) in enumerate(closed) if contact.mode in STICKS]
        constraints = [*range(count), *(count + k for k in rolls)]
        constraints += range(2 * count, len(free)) if self.turn == 0 else ()
        if least_rate(delassus, free, slips, *law, constraints, NO_RATE) <= NO_RATE:
            return None
        answers = solutions(delassus, free, slips, *law)
        if not answers:
            return {}
        rates, small = [delassus @ force + free for force in answers], NO_RATE * float(np.abs(free).max())
        slipping = [k for k in rolls if abs(rates[0][count + k]) > small]
        opening = {closed[k][0].name: 0.0 for k in range(count) if rates[0][k] > small}
        turning = float(rates[0][-1]) if self.turn == 0 and len(free) > 2 * count else 0.0
        opening |= {ROTATION: float(np.sign(turning))} if abs(turning) > small else {}
        return {closed[k][0].name: float(np.sign(rates[0][count + k])) for k in slipping} | opening

    def starts_after(self, step: float, t: float, y: np.ndarray) -> dict[str, float]:
        """`starts` a short time (s) later, when rates that begin at zero are more than rounding; empty if the plate
        goes on."""
        return self.starts(t + step, y if self.rests else y + step * self.rates(t, y)) or {}


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
