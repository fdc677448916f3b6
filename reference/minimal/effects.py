"""The contribution of each effect to the equations: its force, its columns and rows, its conditions, its numbers.

The equations are assembled from the effects of the case. An absent effect is represented by an object without symbols
and conditions, so that no equation tests which effects there are, and an effect costs nothing in cases without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar, NamedTuple

import sympy as sp

from cases import Belt, Case, CoulombFriction, Gravity, Load, Mode, PerfectlyRough, RollingResistance, Unilateral
from cases.derivation import in_one_thread
from cases.effects import MOTION, checked_quantities
from cases.expression_graph import ONE, ZERO, Node, from_sympy, sqrt, substitute, symbol
from cases.expressions import constants, lift_constants
from cases.features import singular_arguments
from cases.moving_surface import TIME
from cases.own_effects import CONTACT, ContactEffect, own_effects
from cases.slip_laws import SLIP_SPEED

from .elimination import GYRATION, Elimination, Surface

GX, GY, MASS = map(symbol, ("gx", "gy", "m"))
# Friction force per normal force (the paper's μ of (30) with its sign), sign of the slip, sign of the normal force,
# and the coefficient that bounds friction without slip.
RATIO, SIGMA, SIDE, STICK = map(symbol, ("k", "sigma", "nu", "mu_stick"))
# The same for the resistance to rotation: couple per normal force, sign of the rotation, lever arm.
RESISTANCE, TURN, ARM = map(symbol, ("rho", "tau", "arm"))

THETA = symbol(MOTION[3].name)

# Components of a force of the user's own at the contact; the prefix of guards that end the motion by its conditions.
OWN_COMPONENTS, OWN_END = 3, "end_"

SLIP_SIGN = {Mode.SLIP_FORWARD: 1.0, Mode.SLIP_BACKWARD: -1.0}
Conditions = dict[str, Node]


# --- forces -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Weight:
    """Gravity: a constant force per mass."""

    torsor = GX, GY, ZERO
    checked_quantities: ClassVar[tuple[Node, ...]] = ()

    def values(self, case: Case) -> dict[str, float]:
        gravity = case.effect(Gravity)
        assert gravity is not None
        gx, gy = gravity.vector
        return {"gx": gx, "gy": gy}


@dataclass(frozen=True)
class AppliedLoad:
    """A load: its formulas with their constants lifted, so that loads that differ in numbers share one system. The
    constants' names begin with `name`."""

    formulas: tuple[sp.Expr, ...]
    sizes: tuple[sp.Symbol, ...]
    name: str = "load"

    @property
    def torsor(self):
        return tuple(e / MASS for e in self.forces)

    @property
    def forces(self) -> tuple[Node, ...]:
        """Force and moment (N, N m)."""
        return self._nodes(self.formulas)

    @property
    def checked_quantities(self) -> tuple[Node, ...]:
        """The arguments of the load's functions, then force and moment (N, N m); empty if steps need no check."""
        return self._nodes(checked_quantities(self.formulas))

    def _nodes(self, expressions: tuple[sp.Expr, ...]) -> tuple[Node, ...]:
        names = {s: symbol(f"{self.name}_{s.name}") for s in self.sizes}
        return tuple(from_sympy(e, names) for e in expressions)

    def values(self, case: Case) -> dict[str, float]:
        load = case.effect(Load)
        assert load is not None
        return self.constants_of(load)

    def constants_of(self, load: Load) -> dict[str, float]:
        """The constants of a load of this form, by name."""
        return {f"{self.name}_c{i}": value for i, value in enumerate(constants(load.expression))}


@lru_cache(maxsize=256)
@in_one_thread
def applied_load(expression: tuple[sp.Expr, ...], name: str) -> AppliedLoad:
    """The form of a load with those components."""
    return AppliedLoad(*lift_constants(expression), name)


# --- surface ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FixedSurface:
    """A surface at rest."""

    surface: ClassVar[Surface] = Surface(ZERO, ZERO)

    def of_contact(self, number: int) -> FixedSurface:
        """The same surface with names of its own, for one of several contacts."""
        return self

    def values(self, case: Case) -> dict[str, float]:
        return {}


@dataclass(frozen=True)
class RunningSurface(FixedSurface):
    """A belt: its speed with its constants lifted, so that belts that differ in numbers share one system. Their names
    begin with `name`."""

    formula: sp.Expr
    sizes: tuple[sp.Symbol, ...]
    name: str = "belt"

    @property
    def surface(self) -> Surface:  # type: ignore[override]
        names = {s: symbol(f"{self.name}_{s.name}") for s in self.sizes}
        return Surface(*(from_sympy(e, names) for e in (self.formula, sp.diff(self.formula, TIME))))

    def values(self, case: Case) -> dict[str, float]:
        belt = case.effect(Belt)
        assert belt is not None
        return {f"{self.name}_c{i}": value for i, value in enumerate(constants([belt.expression]))}

    def of_contact(self, number: int) -> FixedSurface:
        return replace(self, name=f"belt{number}")


# --- friction ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Frictionless:
    """No friction: one mode, no force, no condition."""

    modes: ClassVar[tuple[Mode, ...]] = (Mode.SLIDE,)
    ratio = ZERO
    by_magnitude = False  # whether the law needs the sign of the normal force

    def with_law(self, motion: Elimination, side) -> Elimination:
        """The equations of a slip with the law in place of `ratio`, where that is no number."""
        return motion

    def of_contact(self, number: int) -> Frictionless:
        """The same law with names of its own, for one of several contacts."""
        return self

    def checked_arguments(self, speed: Node) -> tuple[tuple[Node, ...], int]:
        """The arguments of the law's functions, which have to be checked along each step of a slip of that speed
        together with the friction force, and how many of them, the first, are compared with 1 if they are smaller;
        empty if the law's derivatives at a step's start show all that it does."""
        return (), 0

    def conditions(self, slips: bool, motion: Elimination, side) -> Conditions:
        return {}

    def values(self, case: Case, mode: Mode, side: int) -> dict[str, float]:
        return {}


@dataclass(frozen=True)
class Rough(Frictionless):
    """Perfectly rough contact: the rolling row, and a tangential multiplier without bound."""

    modes: ClassVar[tuple[Mode, ...]] = (Mode.ROLL,)


@dataclass(frozen=True)
class Coulomb(Frictionless):
    """Coulomb friction: the rolling row within the cone; outside, a force per normal force against the slip: (28),
    (30)."""

    modes: ClassVar[tuple[Mode, ...]] = (Mode.ROLL, Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD)
    ratio = RATIO
    by_magnitude = True

    def conditions(self, slips: bool, motion: Elimination, side) -> Conditions:
        if slips:
            return {"slip": SIGMA * motion.slip}
        bound = side * STICK * motion.normal
        return {"cone_forward": bound + motion.friction, "cone_backward": bound - motion.friction}

    def values(self, case: Case, mode: Mode, side: int) -> dict[str, float]:
        friction = case.effect(CoulombFriction)
        assert friction is not None
        sign = SLIP_SIGN.get(mode, 0.0)
        return {"k": -sign * side * friction.mu, "sigma": sign, "mu_stick": friction.stick}


@dataclass(frozen=True)
class CoulombBySpeed(Coulomb):
    """Coulomb friction with a coefficient that depends on the slip speed: its formula with its constants lifted. Their
    names begin with `name`."""

    formula: sp.Expr
    sizes: tuple[sp.Symbol, ...]
    name: str = "mu"

    def with_law(self, motion: Elimination, side) -> Elimination:
        coefficient = self.coefficient(SIGMA * motion.slip)
        return Elimination(*substitute(motion, {RATIO: -SIGMA * side * coefficient}))

    def of_contact(self, number: int) -> CoulombBySpeed:
        return replace(self, name=f"mu{number}")

    def coefficient(self, speed: Node) -> Node:
        """The coefficient at a slip speed."""
        return self._nodes([self.formula], speed)[0]

    def checked_arguments(self, speed: Node) -> tuple[tuple[Node, ...], int]:
        # All arguments that are proportional to the slip are rounding when it ends; exp, tanh and the like change over
        # 1, only logarithms, roots and fractions near the zero of their argument.
        arguments = checked_quantities([self.formula], [SLIP_SPEED])[:-1]
        singular = set(singular_arguments(self.formula))
        ordered = sorted(arguments, key=lambda argument: argument in singular)
        return self._nodes(ordered, speed), sum(argument not in singular for argument in ordered)

    def values(self, case: Case, mode: Mode, side: int) -> dict[str, float]:
        friction = case.effect(CoulombFriction)
        assert friction is not None
        return {"sigma": SLIP_SIGN.get(mode, 0.0), "mu_stick": friction.stick} | self.sizes_of(friction)

    def sizes_of(self, friction: CoulombFriction) -> dict[str, float]:
        """The constants of a law of this form, by name."""
        return {f"{self.name}_c{i}": value for i, value in enumerate(constants([friction.mu]))}

    def _nodes(self, expressions: Sequence[sp.Expr], speed: Node) -> tuple[Node, ...]:
        names: dict[sp.Basic, Node] = {size: symbol(f"{self.name}_{size.name}") for size in self.sizes}
        return tuple(from_sympy(e, {**names, SLIP_SPEED: speed}) for e in expressions)


# --- resistance to rotation -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class NoResistance:
    """No resistance to rotation."""

    turns: ClassVar[tuple[int | None, ...]] = (None,)
    couple = ZERO
    by_magnitude = False

    def conditions(self, holds: bool, motion: Elimination, side) -> Conditions:
        return {}

    def values(self, case: Case, turn: int | None, side: int) -> dict[str, float]:
        return {}


@dataclass(frozen=True)
class LeverArm(NoResistance):
    """Rolling resistance: the row ω̇ = 0 while the couple it needs is within its bound, else a couple against ω.

    Conditions in units of a force per mass, by the radius of gyration.
    """

    turns: ClassVar[tuple[int | None, ...]] = (0, 1, -1)
    couple = RESISTANCE
    by_magnitude = True

    def conditions(self, holds: bool, motion: Elimination, side) -> Conditions:
        size = sqrt(GYRATION)
        if not holds:
            return {"turn": TURN * motion.omega * size}
        bound = side * ARM * motion.normal
        # Forward is the direction in which the plate begins to turn when the holding couple reaches its bound.
        return {"couple_forward": (bound + motion.couple) / size, "couple_backward": (bound - motion.couple) / size}

    def values(self, case: Case, turn: int | None, side: int) -> dict[str, float]:
        resistance = case.effect(RollingResistance)
        assert resistance is not None and turn is not None
        return {"rho": -turn * side * resistance.arm, "tau": float(turn), "arm": resistance.arm}


@dataclass(frozen=True)
class FixedRotation(NoResistance):
    """A plate of infinite inertia: the row ω̇ = 0, with a couple without bound."""

    turns: ClassVar[tuple[int | None, ...]] = (0,)


# --- effects of the user's own ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class OwnForce:
    """An effect of the user's own: its formulas with their constants lifted, and its number among the case's own."""

    number: int
    formulas: tuple[sp.Expr, ...]
    sizes: tuple[sp.Symbol, ...]
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
        formulas = own_effects(case.effects)[self.number].formulas
        return {f"own{self.number}_c{i}": value for i, value in enumerate(constants(formulas))}

    def _nodes(self, slip: Node, omega: Node) -> list[Node]:
        names: dict[sp.Basic, Node] = {size: symbol(f"own{self.number}_{size.name}") for size in self.sizes}
        _, of_slip, of_omega = CONTACT
        return [from_sympy(e, {**names, of_slip: slip, of_omega: omega}) for e in self.formulas]


def _own_forces(effects: Sequence[ContactEffect]) -> tuple[OwnForce, ...]:
    return tuple(
        OwnForce(i, *lift_constants(effect.formulas), tuple(end.status for end in effect.ends()))
        for i, effect in enumerate(effects)
    )


class Laws(NamedTuple):
    """All contributions of a case's effects; hashable, the same for cases that differ only in numbers."""

    loads: tuple[Weight | AppliedLoad, ...]
    friction: Frictionless
    resistance: NoResistance
    unilateral: bool
    belt: FixedSurface = FixedSurface()
    own: tuple[OwnForce, ...] = ()

    @property
    def rotation_fixed(self) -> bool:
        """Whether the plate never turns."""
        return isinstance(self.resistance, FixedRotation)

    @property
    def surface(self) -> Surface:
        """The speed of the track's surface, and its rate."""
        return _surface(self.belt)

    @property
    def depends_on_side(self) -> bool:
        """Whether the contact law depends on which side of the track presses."""
        return not self.unilateral and (self.friction.by_magnitude or self.resistance.by_magnitude)

    @property
    def side(self) -> Node:
        """Sign of the normal force in the equations."""
        return SIDE if self.depends_on_side else ONE

    @property
    def torsor(self) -> tuple[Node, Node, Node]:
        """The applied force in the fixed frame and its moment, per mass: F of (19)."""
        fx, fy, moment = (sum((load.torsor[i] for load in self.loads), ZERO) for i in range(3))
        return fx, fy, moment

    @property
    def checked_quantities(self) -> tuple[Node, ...]:
        """The quantities of its loads that have to be checked along each step."""
        return _checked_quantities(self)

    @property
    def needs_angle(self) -> bool:
        """Whether θ itself occurs in the equations and must be integrated: (6) gives it only up to whole turns."""
        return _needs_angle(self)


@lru_cache(maxsize=1024)
def laws(case: Case) -> Laws:
    """The contributions of the case's effects to the equations."""
    load, friction, belt = case.effect(Load), case.effect(CoulombFriction), case.effect(Belt)
    kinds = frozenset(map(type, case.effects))
    mu = friction.mu if friction and friction.by_speed else None
    force, speed = load.expression if load else None, belt.expression if belt else None
    common = _laws(kinds, force, mu, speed, case.plate.turns)
    own = own_effects(case.effects)
    return common._replace(own=_own_forces(own)) if own else common


@lru_cache(maxsize=256)
@in_one_thread
def _laws(
    kinds: frozenset[type], load: tuple[sp.Expr, ...] | None, mu: sp.Expr | None, belt: sp.Expr | None, turns: bool
) -> Laws:
    loads: list[Weight | AppliedLoad] = [Weight()] if Gravity in kinds else []
    if load is not None:
        loads.append(AppliedLoad(*lift_constants(load)))
    friction = Coulomb() if CoulombFriction in kinds else Rough() if PerfectlyRough in kinds else Frictionless()
    if mu is not None:
        (formula,), sizes = lift_constants([mu])
        friction = CoulombBySpeed(formula, sizes)
    resistance = LeverArm() if RollingResistance in kinds else NoResistance() if turns else FixedRotation()
    surface = FixedSurface()
    if belt is not None:
        (formula,), sizes = lift_constants((belt,))
        surface = RunningSurface(formula, sizes)
    return Laws(tuple(loads), friction, resistance, Unilateral in kinds, surface)


@lru_cache(maxsize=256)
@in_one_thread
def _surface(belt: FixedSurface) -> Surface:
    return belt.surface


@lru_cache(maxsize=256)
@in_one_thread
def _checked_quantities(law: Laws) -> tuple[Node, ...]:
    return tuple(e for load in law.loads for e in load.checked_quantities)


@lru_cache(maxsize=256)
@in_one_thread
def _needs_angle(law: Laws) -> bool:
    return any(THETA in e.symbols for e in law.torsor)
