"""Friction: none, perfectly rough, or Coulomb's law (28), (30), also with a coefficient by the slip speed."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar

from cases import Case, CoulombFriction, Mode, PerfectlyRough
from cases.effects import checked_quantities
from cases.formulas import formula_symbols
from cases.formulas.expression_graph import ONE, ZERO, Node, from_sympy, symbol
from cases.formulas.features import singular_arguments

from .lifted_formulas import Conditions, LiftedFormulas, NumberedLaw, constant_values, effect_of, lift

SLIP_SIGN = {Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}
# The modes of a contact without slip.
STICKING = (Mode.ROLL, Mode.REST)


@dataclass(frozen=True)
class Frictionless(NumberedLaw):
    """No friction: one mode, no force, no condition."""

    modes: ClassVar[tuple[Mode, ...]] = (Mode.SLIDE,)
    has_bound = False  # whether the friction force is limited by the normal force
    by_speed = False  # whether its coefficient depends on the slip speed

    @property
    def slip_modes(self) -> tuple[Mode, ...]:
        """The modes of a contact that slips, or may begin to."""
        return tuple(mode for mode in self.modes if mode not in STICKING)

    @property
    def ratio(self) -> Node:
        """The friction force per normal force (the paper's μ of (30) with its sign), while the normal force is
        eliminated."""
        return ZERO

    def ratio_at(self, slip: Node, side: Node = ONE) -> Node:
        """The same at a slip velocity; `side`: the sign of the normal force."""
        return self.ratio

    def checked_arguments(self, slip: Node) -> tuple[tuple[Node, ...], int]:
        """The arguments of the law's functions, which have to be checked along each step with that slip velocity
        together with the friction force, and how many of them, the first, are compared with 1 if they are smaller;
        empty if the law's derivatives at a step's start show all that it does."""
        return (), 0

    def slip_conditions(self, slip: Node) -> Conditions:
        """The conditions of a slip in the direction of its mode; of the slip's rate their rates."""
        return {}

    def stick_conditions(self, normal: Node, friction: Node, side: Node = ONE) -> Conditions:
        """The conditions of a contact without slip, with its normal and friction force; `side`: the sign of the former
        that presses."""
        return {}

    def values(self, contact: Case, mode: Mode, side: int = 1) -> dict[str, float]:
        """The numbers of its parameters in a mode, by name."""
        return {}

    def coefficients(self, contact: Case) -> tuple[float, float]:
        """The coefficients of a slip that begins and without slip; infinite for a perfectly rough contact."""
        return 0.0, 0.0

    def coefficient_at(self, contact: Case, slip: float) -> float:
        """The coefficient at a slip velocity (m/s)."""
        return self.coefficients(contact)[0]

    def in_impact(self, contact: Case, slip: float) -> tuple[float, float]:
        """The coefficients against slip and without it of an impact that begins at a slip velocity (m/s)."""
        return self.coefficients(contact)


@dataclass(frozen=True)
class Rough(Frictionless):
    """Perfectly rough contact: the rolling row, and a tangential multiplier without bound."""

    modes: ClassVar[tuple[Mode, ...]] = (Mode.ROLL,)

    def coefficients(self, contact: Case) -> tuple[float, float]:
        return inf, inf


@dataclass(frozen=True)
class Coulomb(Frictionless):
    """Coulomb friction: the rolling row within the cone; outside, a force per normal force against the slip."""

    modes: ClassVar[tuple[Mode, ...]] = (Mode.ROLL, Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD)
    has_bound = True

    @property
    def ratio(self) -> Node:
        return symbol(self.name("k"))

    @property
    def sigma(self) -> Node:
        """The sign of the slip."""
        return symbol(self.name("sigma"))

    def slip_conditions(self, slip: Node) -> Conditions:
        return {"slip": self.sigma * slip}

    def stick_conditions(self, normal: Node, friction: Node, side: Node = ONE) -> Conditions:
        bound = side * symbol(self.name("mu_stick")) * normal
        return {"cone_forward": bound + friction, "cone_backward": bound - friction}

    def values(self, contact: Case, mode: Mode, side: int = 1) -> dict[str, float]:
        friction, sign = effect_of(contact, CoulombFriction), SLIP_SIGN.get(mode, 0.0)
        own = self._coefficient_values(friction, sign * side)
        return own | {self.name("sigma"): sign, self.name("mu_stick"): friction.stick}

    def _coefficient_values(self, friction: CoulombFriction, sign: float) -> dict[str, Any]:
        return {self.name("k"): -sign * friction.mu}

    def coefficients(self, contact: Case) -> tuple[float, float]:
        friction = effect_of(contact, CoulombFriction)
        return friction.at_rest, friction.stick

    def coefficient_at(self, contact: Case, slip: float) -> float:
        return float(effect_of(contact, CoulombFriction).at(abs(slip)))

    def in_impact(self, contact: Case, slip: float) -> tuple[float, float]:
        mu, stick = effect_of(contact, CoulombFriction).in_impact(slip)
        return float(mu), float(stick)


@dataclass(frozen=True)
class CoulombBySpeed(Coulomb):
    """Coulomb friction whose coefficient is a formula in the slip speed."""

    formulas: LiftedFormulas
    by_speed = True

    def ratio_at(self, slip: Node, side: Node = ONE) -> Node:
        return -self.sigma * side * self._nodes(self.formulas.expressions, slip)[0]

    def checked_arguments(self, slip: Node) -> tuple[tuple[Node, ...], int]:
        # All arguments that are proportional to the slip are rounding when it ends; exp, tanh and the like change over
        # 1, only logarithms, roots and fractions near the zero of their argument.
        (formula,) = self.formulas.expressions
        arguments = checked_quantities([formula], [formula_symbols.SLIP_SPEED])[:-1]
        singular = set(singular_arguments(from_sympy(formula)))
        ordered = sorted(arguments, key=lambda argument: argument in singular)
        return self._nodes(ordered, slip), sum(argument not in singular for argument in ordered)

    def _coefficient_values(self, friction: CoulombFriction, sign: float) -> dict[str, Any]:
        return constant_values(self.name("mu"), [friction.mu])

    def _nodes(self, expressions, slip: Node) -> tuple[Node, ...]:
        return self.formulas.nodes(self.name("mu"), {formula_symbols.SLIP_SPEED: self.sigma * slip}, expressions)


def friction_of(contact: Case) -> Frictionless:
    """The form of the friction at a contact."""
    friction = contact.effect(CoulombFriction)
    if friction is None:
        return Rough() if contact.effect(PerfectlyRough) else Frictionless()
    return CoulombBySpeed(lift(friction.mu)) if friction.by_speed else Coulomb()
