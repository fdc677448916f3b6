"""Effects of the user's own: forces at the contact, and conditions that end the motion, as formulas.

A package defines a frozen dataclass derived from `ContactEffect` and names it in the entry-point group
`slip_to_roll.effects`. Every formulation of the reference reads the same formulas. docs/own_effects.md has an example.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import is_dataclass
from typing import Any, ClassVar, NamedTuple, TypeAlias

from .derivation import derived
from .errors import BadValue, describe
from .formulas import features, formula_symbols
from .formulas import late_sympy as sp
from .formulas.effect_formulas import WithFormulas, formula_in, values_of
from .formulas.expression_graph import from_sympy, symbol
from .formulas.formula_symbols import __getattr__ as __getattr__

GROUP = "slip_to_roll.effects"

Formula: TypeAlias = "sp.Expr | str | float"


class ContactForce(NamedTuple):
    """A force on the plate at the contact: along the track's tangent, along its left normal (N), and a couple (N m).
    Each is a number or a formula of t, slip, omega."""

    along: Formula = 0.0
    across: Formula = 0.0
    couple: Formula = 0.0


class EndCondition(NamedTuple):
    """A condition that ends the motion: its status, which no other condition of the case has, a formula of t, slip,
    omega that is positive until then, and a sentence."""

    status: str
    positive: Formula
    reason: str


class ContactEffect(WithFormulas):
    """Base class of effects that act while the plate touches its track; a subclass is a frozen dataclass.

    `force` returns what acts on the plate, `ends` conditions that end the motion. The work of the force is that of its
    components along the slip and the rotation. `laws`: functions "module:function" that adapters are checked with, each
    of an `adapters.laws.Route`. Subclasses have a name that no effect of the suite has.
    """

    laws: ClassVar[tuple[str, ...]] = ()

    def force(self) -> ContactForce:
        """The force at the contact."""
        return ContactForce()

    def ends(self) -> tuple[EndCondition, ...]:
        """The conditions that end the motion."""
        return ()

    @derived
    def formulas(self) -> tuple[sp.Expr, ...]:
        """The force's components, then the conditions that end the motion, as expressions in `CONTACT`."""
        name = type(self).__name__
        components = zip(ContactForce._fields, ContactForce(*self.force()), strict=True)
        conditions = [(end.status, end.positive) for end in self.ends()]
        with_names = [*((f"{part} of {name}", value) for part, value in components), *conditions]
        return tuple(formula_in(formula_symbols.CONTACT, what, value) for what, value in with_names)

    @derived
    def at(self) -> Callable[..., list[float]]:
        """A function (t, slip, omega) -> values of `formulas`, on floats; NaN where there is no value."""
        return values_of(formula_symbols.CONTACT, self.formulas)

    def check(self) -> None:
        """Raise BadValue, with one sentence, if the effect cannot be used."""
        name = type(self).__name__
        if not is_dataclass(self) or not type(self).__dataclass_params__.frozen:
            raise BadValue(f"{name} is no frozen dataclass; write @dataclass(frozen=True) above it")
        try:
            every = self.formulas
        except BadValue:
            raise
        except Exception as problem:
            raise BadValue(f"the formulas of {name} fail: {describe(problem)}") from problem
        nodes, symbols = [*map(from_sympy, every)], frozenset(map(symbol, formula_symbols.NAMES["CONTACT"]))
        checked = [a for formula in nodes for a in features.arguments(formula, symbols)]
        if checked or max(features.degree(formula, symbols) for formula in nodes) > MOST_DEGREE:
            raise BadValue(
                f"a formula of {name} is no polynomial of degree {MOST_DEGREE} at most in t, slip and omega; write it "
                "as a Load, or as mu of CoulombFriction"
            )
        if not self.at(0.0, 0.0, 0.0)[0] == self.at(0.0, 0.0, 0.0)[0]:
            raise BadValue(f"a formula of {name} has no value at t = 0 without slip and spin; give one that has")


# Steps are not checked for features of these formulas, which a polynomial of this degree does not have.
MOST_DEGREE = 2


def own_effects(effects: Sequence[Any]) -> tuple[ContactEffect, ...]:
    """The effects of the user's own among a case's effects."""
    return tuple(effect for effect in effects if isinstance(effect, ContactEffect))


def registered() -> dict[str, type[ContactEffect]]:
    """The effects of installed packages by name; raises BadValue for an entry point that fails or is no effect."""
    from importlib.metadata import entry_points

    found = {}
    for item in entry_points(group=GROUP):
        try:
            effect = item.load()
        except (Exception, SystemExit) as problem:
            raise BadValue(f"the effect {item.value} fails: {describe(problem)}") from problem
        if not (isinstance(effect, type) and issubclass(effect, ContactEffect)):
            raise BadValue(f"the effect {item.value} is no class derived from cases.own_effects.ContactEffect")
        found[item.name] = effect
    return found
