"""What acts against a plate's rotation: nothing, rolling resistance, or infinite inertia."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cases import Case, RollingResistance
from cases.formulas.expression_graph import ONE, ZERO, Node, symbol

from .lifted_formulas import Conditions, NumberedLaw, effect_of


@dataclass(frozen=True)
class NoResistance(NumberedLaw):
    """No resistance to rotation.

    `turns`: the senses of rotation that are modes of their own; 0: none, None: it is free.
    """

    turns: ClassVar[tuple[int | None, ...]] = (None,)
    has_bound = False  # whether the couple is limited by the normal force
    is_fixed = False  # whether nothing turns the plate

    @property
    def couple(self) -> Node:
        """The couple per normal force of a plate that turns (m)."""
        return ZERO

    def bound(self, normal: Node, side: Node = ONE) -> Node:
        """The largest couple at that normal force; `side`: the sign of the normal force that presses."""
        return ZERO

    def turn_conditions(self, omega: Node, length: Node) -> Conditions:
        """The conditions of a rotation in the sense of its mode, in m/s by a length; of the rotation's rate their
        rates."""
        return {}

    def hold_conditions(self, bound: Node, couple: Node, length: Node) -> Conditions:
        """The conditions of a couple that holds a plate, in units of a force by a length."""
        return {}

    def values(self, contact: Case, turn: int | None, side: int = 1) -> dict[str, float]:
        """The numbers of its parameters in a sense of rotation, by name."""
        return {}

    def arm(self, contact: Case) -> float:
        """The largest couple per normal force, m."""
        return 0.0


@dataclass(frozen=True)
class LeverArm(NoResistance):
    """Rolling resistance: the row ω̇ = 0 while the couple it needs is within its bound, else a couple against ω."""

    turns: ClassVar[tuple[int | None, ...]] = (0, 1, -1)
    has_bound = True

    @property
    def couple(self) -> Node:
        return symbol(self.name("rho"))

    def bound(self, normal: Node, side: Node = ONE) -> Node:
        return side * symbol(self.name("arm")) * normal

    def turn_conditions(self, omega: Node, length: Node) -> Conditions:
        return {"turn": symbol(self.name("tau")) * omega * length}

    def hold_conditions(self, bound: Node, couple: Node, length: Node) -> Conditions:
        # Forward is the direction in which the plate begins to turn when the holding couple reaches its bound.
        return {"couple_forward": (bound + couple) / length, "couple_backward": (bound - couple) / length}

    def values(self, contact: Case, turn: int | None, side: int = 1) -> dict[str, float]:
        assert turn is not None
        arm = self.arm(contact)
        return {self.name("rho"): -turn * side * arm, self.name("tau"): float(turn), self.name("arm"): arm}

    def arm(self, contact: Case) -> float:
        return effect_of(contact, RollingResistance).arm


@dataclass(frozen=True)
class FixedRotation(NoResistance):
    """A plate of infinite inertia: the row ω̇ = 0, with a couple without bound."""

    turns: ClassVar[tuple[int | None, ...]] = (0,)
    is_fixed = True


def resistance_of(contact: Case) -> NoResistance:
    """The form of what acts against rotation at a contact."""
    if contact.effect(RollingResistance):
        return LeverArm()
    return NoResistance() if contact.plate.turns else FixedRotation()
