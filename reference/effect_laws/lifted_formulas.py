"""Formulas of effects with their constants lifted, and parameters that have names of their own at each contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple, TypeVar

from cases import Case
from cases.derivation import in_one_thread
from cases.formulas import late_sympy as sp
from cases.formulas.expression_graph import Node, from_sympy, symbol
from cases.formulas.expressions import constants, lift_constants

Conditions = dict[str, Node]

L = TypeVar("L", bound="NumberedLaw")
E = TypeVar("E")


class LiftedFormulas(NamedTuple):
    """Formulas with symbols for their constants, so that effects that differ in numbers share one system."""

    expressions: tuple[sp.Expr, ...]
    sizes: tuple[sp.Symbol, ...]

    def nodes(
        self, name: str, symbols: Mapping[sp.Basic, Node] | None = None, expressions: Sequence[sp.Expr] | None = None
    ) -> tuple[Node, ...]:
        """These formulas, or other `expressions` of the same constants, whose names begin with `name`; `symbols`: what
        stands for their variables (None: symbols of the same names)."""
        names: dict[sp.Basic, Node] = {size: symbol(f"{name}_{size.name}") for size in self.sizes}
        return tuple(
            from_sympy(e, {**names, **(symbols or {})})
            for e in (self.expressions if expressions is None else expressions)
        )


@lru_cache(maxsize=1024)
@in_one_thread
def lift(*formulas: sp.Expr) -> LiftedFormulas:
    """The formulas with symbols for their constants."""
    return LiftedFormulas(*lift_constants(formulas))


def constant_values(name: str, formulas: Sequence[sp.Expr]) -> dict[str, float]:
    """The values of the constants of formulas, by the names that `LiftedFormulas.nodes` gives them."""
    return {f"{name}_c{i}": value for i, value in enumerate(constants(formulas))}


def effect_of(case: Case, kind: type[E]) -> E:
    """The case's effect of a kind that it has."""
    effect = case.effect(kind)
    assert effect is not None
    return effect


@dataclass(frozen=True, kw_only=True)
class NumberedLaw:
    """A law of a contact; `number`: of several contacts that of its own, with which its parameters' names end."""

    number: int | None = None

    def of_contact(self: L, number: int) -> L:
        """The same law with names of its own, for one of several contacts."""
        return replace(self, number=number)

    def name(self, parameter: str) -> str:
        """The name of a parameter at the contact."""
        return parameter if self.number is None else f"{parameter}_{self.number}"
