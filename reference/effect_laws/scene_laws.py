"""All laws of a case: its effects' contributions to the equations."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from cases import Belt, Case, Load, Unilateral
from cases.formulas.expression_graph import ONE, ZERO, Node, symbol
from cases.formulas.formula_symbols import NAMES

from .applied_forces import AppliedLoad, Weight, applied_forces
from .belt import FixedSurface, surface_of
from .friction import Frictionless, friction_of
from .own_forces import OwnForce, own_forces
from .rolling_resistance import NoResistance, resistance_of

# The sign of the normal force of a contact that either side may press.
SIDE = symbol("nu")
THETA = symbol(NAMES["MOTION"][3])


class Laws(NamedTuple):
    """All contributions of a case's effects; hashable, the same for cases that differ only in numbers."""

    loads: tuple[Weight | AppliedLoad, ...]
    friction: Frictionless
    resistance: NoResistance
    unilateral: bool
    belt: FixedSurface = FixedSurface()
    own: tuple[OwnForce, ...] = ()

    @property
    def depends_on_side(self) -> bool:
        """Whether the contact law depends on which side of the track presses."""
        return not self.unilateral and (self.friction.has_bound or self.resistance.has_bound)

    @property
    def side(self) -> Node:
        """Sign of the normal force in the equations."""
        return SIDE if self.depends_on_side else ONE

    @property
    def torsor(self) -> tuple[Node, Node, Node]:
        """The applied force in the fixed frame and its moment, per mass: F of (19)."""
        return _sum(self.loads)

    @property
    def torsor_of_all(self) -> tuple[Node, Node, Node]:
        """The same of what acts on every plate, not on the first one only."""
        return _sum([load for load in self.loads if load.of_all_plates])

    @property
    def checked_quantities(self) -> tuple[Node, ...]:
        """The quantities of its loads that have to be checked along each step."""
        return tuple(e for load in self.loads for e in load.checked_quantities)

    @property
    def needs_angle(self) -> bool:
        """Whether θ itself occurs in the equations and must be integrated: (6) gives it only up to whole turns."""
        return any(THETA in e.symbols for load in self.loads for e in load.torsor)


def _sum(loads: Sequence[Weight | AppliedLoad]) -> tuple[Node, Node, Node]:
    fx, fy, moment = (sum((load.torsor[i] for load in loads), ZERO) for i in range(3))
    return fx, fy, moment


def effects_in_time(case: Case) -> tuple[Load | Belt, ...]:
    """The effects whose features in time no step may pass over: the load and the belt."""
    every = case.effect(Load), case.effect(Belt)
    return tuple(effect for effect in every if effect is not None)


@lru_cache(maxsize=1024)
def laws(case: Case) -> Laws:
    """The contributions of the case's effects to the equations."""
    is_unilateral = case.effect(Unilateral) is not None
    return Laws(
        applied_forces(case), friction_of(case), resistance_of(case), is_unilateral, surface_of(case), own_forces(case)
    )
