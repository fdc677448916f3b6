"""Effects of the user's own: forces at the contact, and conditions that end the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cases import Case
from cases.formulas import formula_symbols
from cases.formulas.expression_graph import Node
from cases.own_effects import own_effects

from .lifted_formulas import Conditions, LiftedFormulas, constant_values, lift

# Components of a force of the user's own at the contact; the prefix of guards that end the motion by its conditions.
OWN_COMPONENTS, OWN_END = 3, "end_"


@dataclass(frozen=True)
class OwnForce:
    """An effect by its formulas, with its number among the case's own, and the statuses of its conditions."""

    number: int
    formulas: LiftedFormulas
    statuses: tuple[str, ...]

    def force(self, slip: Node, omega: Node) -> tuple[Node, Node, Node]:
        """Force along the tangent and the normal, and couple (N, N m)."""
        along, across, couple = self._nodes(slip, omega)[:OWN_COMPONENTS]
        return along, across, couple

    def ends(self, slip: Node, omega: Node) -> Conditions:
        """The guards that end the motion, by name."""
        conditions = self._nodes(slip, omega)[OWN_COMPONENTS:]
        return {f"{OWN_END}{status}": node for status, node in zip(self.statuses, conditions, strict=True)}

    def values(self, case: Case) -> dict[str, float]:
        return constant_values(f"own{self.number}", own_effects(case.effects)[self.number].formulas)

    def _nodes(self, slip: Node, omega: Node) -> tuple[Node, ...]:
        _, of_slip, of_omega = formula_symbols.CONTACT
        return self.formulas.nodes(f"own{self.number}", {of_slip: slip, of_omega: omega})


def own_forces(case: Case) -> tuple[OwnForce, ...]:
    """The forms of the case's effects of the user's own."""
    return tuple(
        OwnForce(i, lift(*effect.formulas), tuple(end.status for end in effect.ends()))
        for i, effect in enumerate(own_effects(case.effects))
    )


def own_force_values(case: Case, t: float, slip: float, omega: float) -> list[Sequence[float]]:
    """Force along the tangent and the normal, and couple (N, N m), of each of these effects at a contact."""
    return [effect.at(t, slip, omega)[:OWN_COMPONENTS] for effect in own_effects(case.effects)]


def changes_in_time(case: Case) -> bool:
    """Whether a force of the user's own depends on time itself."""
    parts = [part for one in own_effects(case.effects) for part in one.formulas[:OWN_COMPONENTS]]
    return any(part.has(formula_symbols.TIME) for part in parts)


def own_ending(case: Case, guard: str) -> tuple[str, str]:
    """Status and reason of the ending by a guard of such an effect."""
    ends = [end for effect in own_effects(case.effects) for end in effect.ends()]
    return next((end.status, end.reason) for end in ends if guard == f"{OWN_END}{end.status}")


def own_guard(case: Case, guard: str, t: float, slip: float, omega: float) -> float:
    """The value of a guard of such an effect."""
    for effect in own_effects(case.effects):
        for end, value in zip(effect.ends(), effect.at(t, slip, omega)[OWN_COMPONENTS:], strict=True):
            if guard == f"{OWN_END}{end.status}":
                return value
    raise KeyError(guard)
