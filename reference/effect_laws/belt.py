"""Belts: the speed of the surface that a plate touches, in equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from cases import Belt, Case
from cases.formulas import formula_symbols
from cases.formulas import late_sympy as sp
from cases.formulas.expression_graph import ZERO, Node

from .lifted_formulas import LiftedFormulas, NumberedLaw, constant_values, effect_of, lift


class Surface(NamedTuple):
    """The speed of the track's surface along the track, and its rate: both zero but for a belt."""

    speed: Node
    rate: Node


@dataclass(frozen=True)
class FixedSurface(NumberedLaw):
    """A surface at rest."""

    runs = False

    @property
    def surface(self) -> Surface:
        """Its speed and the rate of that."""
        return Surface(ZERO, ZERO)

    def values(self, contact: Case) -> dict[str, float]:
        """The numbers of its parameters, by name."""
        return {}

    def rate(self, contact: Case, t: float) -> float:
        """The rate of the surface's speed at time t (s), m/s²."""
        return 0.0


@dataclass(frozen=True)
class RunningSurface(FixedSurface):
    """A belt by the formula of its speed."""

    formulas: LiftedFormulas
    runs = True

    @property
    def surface(self) -> Surface:
        (speed,) = self.formulas.expressions
        rate = sp.diff(speed, formula_symbols.TIME)
        return Surface(*self.formulas.nodes(self.name("belt"), expressions=(speed, rate)))

    def values(self, contact: Case) -> dict[str, float]:
        return constant_values(self.name("belt"), [effect_of(contact, Belt).expression])

    def rate(self, contact: Case, t: float) -> float:
        return float(effect_of(contact, Belt).at(t)[1])


def surface_of(contact: Case) -> FixedSurface:
    """The form of the surface at a contact."""
    belt = contact.effect(Belt)
    return RunningSurface(lift(belt.expression)) if belt else FixedSurface()
