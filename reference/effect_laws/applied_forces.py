"""Weight and loads: forces per mass that act on a plate wherever it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

from cases import Case, Gravity, Load
from cases.derivation import derived
from cases.effects import checked_quantities
from cases.formulas import late_sympy as sp
from cases.formulas.expression_graph import ZERO, Node, symbol

from .lifted_formulas import LiftedFormulas, constant_values, effect_of, lift

GX, GY, MASS = map(symbol, ("gx", "gy", "m"))


@dataclass(frozen=True)
class Weight:
    """Gravity: a constant force per mass."""

    torsor = GX, GY, ZERO
    checked_quantities: ClassVar[tuple[Node, ...]] = ()
    is_uniform = True  # whether it is the same everywhere, at all times and velocities
    of_all_plates = True  # whether it acts on every plate, or on the first one

    def values(self, case: Case) -> dict[str, float]:
        return dict(zip(("gx", "gy"), weight(case), strict=True))


@dataclass(frozen=True)
class AppliedLoad:
    """A load by its formulas; the names of their constants begin with `name`. `gives_spin`: its moment is the rate of
    the plate's spin."""

    formulas: LiftedFormulas
    name: str = "load"
    gives_spin: bool = False
    is_uniform = of_all_plates = False

    @derived
    def torsor(self) -> tuple[Node, ...]:
        return tuple(e / MASS for e in self.forces)

    @derived
    def forces(self) -> tuple[Node, ...]:
        """Force and moment (N, N m)."""
        return self.formulas.nodes(self.name)

    @derived
    def checked_quantities(self) -> tuple[Node, ...]:
        """The arguments of the load's functions, then force and moment (N, N m); empty if steps need no check."""
        return self.formulas.nodes(self.name, expressions=checked_quantities(self.formulas.expressions))

    def values(self, case: Case) -> dict[str, float]:
        return self.constants_of(effect_of(case, Load))

    def constants_of(self, load: Load) -> dict[str, float]:
        """The constants of a load of this form, by name."""
        return constant_values(self.name, load.expression)


@lru_cache(maxsize=256)
def applied_load(expression: tuple[sp.Expr, ...], name: str = "load", gives_spin: bool = False) -> AppliedLoad:
    """The form of a load with those components."""
    return _applied_load(lift(*expression), name, gives_spin)


_applied_load = lru_cache(maxsize=256)(AppliedLoad)  # one object for loads that differ in numbers


def applied_forces(case: Case) -> tuple[Weight | AppliedLoad, ...]:
    """The forms of the forces on the case's first plate."""
    gravity, load = case.effect(Gravity), case.effect(Load)
    return (
        *((Weight(),) if gravity else ()),
        *((applied_load(load.expression, gives_spin=case.plate.spins_by_load),) if load else ()),
    )


def weight(case: Case) -> Sequence[float]:
    """The components of the weight per mass, m/s²; zeros without gravity."""
    gravity = case.effect(Gravity)
    return gravity.vector if gravity else (0.0, 0.0)
