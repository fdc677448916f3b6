"""The exact scene that a proof is about: a case with each number read as an exact one.

A `Case` holds doubles, and the double nearest to 0.1 is not 1/10. A proof states which numbers it means:

- a double is the decimal number with the fewest digits that identifies it (0.1 is 1/10, 9.81 is 981/100);
- a direction of gravity, or a contact parameter of the start, that is the double nearest to a multiple of π/2 is that
  multiple; the curve is then shifted by it, so that the start has the parameter 0;
- the inertia of a disc that is within rounding of q·m·r² for a fraction q with a denominator up to 10 is q·m·r².

The scene differs from the case's doubles by roundings. Everything is listed in the proof's record.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import pi

import sympy as sp

from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    NotSupported,
    PerfectlyRough,
    RollingResistance,
    Unilateral,
)
from cases.effects import MOTION
from cases.formulas.expressions import PARAMETER

Pair = tuple[sp.Expr, sp.Expr]
# The largest denominator of an inertia's share of m r², and the roundings that lie between it and the double.
LARGEST_DENOMINATOR, ROUNDINGS = 10, 8


@dataclass(frozen=True)
class Scene:
    """A case in exact numbers; forces and couples are per mass, expressions have rational constants only.

    `disc` is the radius of a plate that is a disc about its centre of mass, else None and `outline` is its curve.
    """

    track: Pair
    track_domain: tuple[Fraction, Fraction] | None
    track_turns: int  # ξ₁ is the parameter of `track` plus so many quarter turns
    disc: Fraction | None
    outline: Pair
    outline_domain: tuple[Fraction, Fraction] | None
    outline_turns: int
    gyration: Fraction  # J/m
    gravity: Pair
    load: tuple[sp.Expr, sp.Expr, sp.Expr] | None  # force and moment per mass, in `cases.effects.MOTION`
    mu: Fraction | None  # None: no friction
    mu_static: Fraction | None
    rough: bool
    arm: Fraction | None
    unilateral: bool
    flies: bool
    xi1: Fraction
    xi2: Fraction
    slip: Fraction
    omega: Fraction
    duration: Fraction

    def described(self) -> dict[str, object]:
        """The scene as texts, for a record."""
        return {
            "track": [str(part) for part in self.track],
            "track_domain": _texts(self.track_domain),
            "track_parameter": _parameter("xi1", self.track_turns),
            "plate": "disc" if self.disc is not None else "outline",
            "radius": _text(self.disc),
            "outline": None if self.disc is not None else [str(part) for part in self.outline],
            "outline_domain": _texts(self.outline_domain),
            "outline_parameter": None if self.disc is not None else _parameter("xi2", self.outline_turns),
            "inertia_per_mass": _text(self.gyration),
            "gravity": [str(part) for part in self.gravity],
            "load_per_mass": None if self.load is None else [str(part) for part in self.load],
            "mu": _text(self.mu),
            "mu_static": _text(self.mu_static),
            "perfectly_rough": self.rough,
            "resistance_arm": _text(self.arm),
            "unilateral": self.unilateral,
            "start": {name: _text(getattr(self, name)) for name in ("xi1", "xi2", "slip", "omega")},
            "duration": _text(self.duration),
        }


def _parameter(name: str, turns: int) -> str:
    return f"{name} = s" if not turns else f"{name} = s {'+' if turns > 0 else '-'} {abs(turns)}*pi/2"


def _text(number: Fraction | None) -> str | None:
    return None if number is None else str(number)


def _texts(pair: tuple[Fraction, Fraction] | None) -> list[str] | None:
    return None if pair is None else [str(number) for number in pair]


def exact(number: float) -> Fraction:
    """The decimal number with the fewest digits that identifies the double."""
    return Fraction(repr(float(number)))


def exact_scene(case: Case) -> Scene:
    """The case in exact numbers. Raises NotSupported if a proof does not cover the case."""
    _check_supported(case)
    start, plate, friction = case.start, case.plate, case.effect(CoulombFriction)
    resistance, load = case.effect(RollingResistance), case.effect(Load)
    radius = None if plate.radius is None else exact(_nominal(case))
    mass = exact(plate.mass)
    track, domain, xi1, turns = _curve(case.track, start.xi1)
    outline, outline_domain, xi2, outline_turns = _curve(plate.outline, 0.0 if start.xi2 is None else start.xi2)
    static = None if friction is None or friction.mu_static is None else exact(friction.mu_static)
    return Scene(
        track=track,
        track_domain=domain,
        track_turns=turns,
        disc=radius,
        outline=outline,
        outline_domain=None if radius is not None else outline_domain,
        outline_turns=outline_turns,
        gyration=_gyration(plate.inertia, mass, radius),
        gravity=_gravity(case.effect(Gravity)),
        load=None if load is None else _load(load, mass),
        mu=None if friction is None else exact(friction.mu),
        mu_static=static if static is not None or friction is None else exact(friction.mu),
        rough=case.effect(PerfectlyRough) is not None,
        arm=None if resistance is None else exact(resistance.arm),
        unilateral=case.effect(Unilateral) is not None,
        flies=case.effect(Flight) is not None,
        xi1=xi1,
        xi2=xi2,
        slip=exact(start.slip),
        omega=exact(start.omega),
        duration=exact(case.duration),
    )


SUPPORTED = (CoulombFriction, Flight, Gravity, Impact, Load, PerfectlyRough, RollingResistance, Unilateral)


def _check_supported(case: Case) -> None:
    """Raise NotSupported for a case outside the class that proofs cover."""
    if not case.start.in_contact:
        raise NotSupported(f"{case.label} begins in flight; proofs cover motions in contact")
    other = [type(effect).__name__ for effect in case.effects if not isinstance(effect, SUPPORTED)]
    if other:
        raise NotSupported(f"{case.label} has {', '.join(other)}, which proofs do not cover")
    friction = case.effect(CoulombFriction)
    if friction is not None and friction.by_speed:
        raise NotSupported(f"{case.label} has friction that depends on the slip velocity, which proofs do not cover")
    if not case.plate.turns:
        raise NotSupported(f"{case.label} has a plate that does not turn, which proofs do not cover")
    load = case.effect(Load)
    if load is not None and any(part.has(MOTION[3]) for part in load.expression):
        raise NotSupported(f"{case.label} has a load that depends on theta, which proofs do not cover")
    if case.plate.radius is None and case.start.xi2 is None:
        raise NotSupported(f"{case.label} leaves xi2 of its start open; proofs need a number")


def _nominal(case: Case) -> float:
    """The radius as the outline's expression has it; the plate's own is a mean of samples."""
    sizes = case.plate.outline.constants
    return sizes[0] if len(sizes) == 1 else float(case.plate.radius or 0.0)


def _gyration(inertia: float, mass: Fraction, radius: Fraction | None) -> Fraction:
    if radius is not None:
        share = exact(inertia) / (mass * radius**2)
        simple = share.limit_denominator(LARGEST_DENOMINATOR)
        if simple and abs(share / simple - 1) <= Fraction(ROUNDINGS, 2**53):
            return simple * radius**2
    return exact(inertia) / mass


def _gravity(gravity: Gravity | None) -> Pair:
    if gravity is None:
        return sp.Integer(0), sp.Integer(0)
    g, turns = _rational(exact(gravity.g)), _quarter_turns(gravity.direction)
    angle = _rational(exact(gravity.direction)) if turns is None else turns * sp.pi / 2
    return g * sp.cos(angle), g * sp.sin(angle)


def _load(load: Load, mass: Fraction) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    fx, fy, moment = (_exact_expression(part) / _rational(mass) for part in load.expression)
    return fx, fy, moment


def _curve(curve: Curve, start: float) -> tuple[Pair, tuple[Fraction, Fraction] | None, Fraction, int]:
    """Expressions, domain, the start's parameter, and the quarter turns by which the parameter is shifted."""
    if any(part.has(sp.Integral) for part in curve.expression):
        raise NotSupported("proofs do not cover curves by integrals")
    x, y = (_exact_expression(part) for part in curve.expression)
    turns = _quarter_turns(start)
    if turns and curve.domain is None:
        angle = turns * sp.pi / 2
        x, y = (part.subs(PARAMETER, PARAMETER + angle) for part in (x, y))
        return (x, y), None, Fraction(0), turns
    ends = None if curve.domain is None or curve.period else (exact(curve.domain[0]), exact(curve.domain[1]))
    return (x, y), ends, exact(start), 0


def _quarter_turns(angle: float) -> int | None:
    """n if the angle is the double nearest to n π/2, else None."""
    turns = round(angle / (pi / 2))
    return turns if angle == turns * (pi / 2) else None


def _exact_expression(expression: sp.Expr) -> sp.Expr:
    """The expression with each floating-point constant replaced by its exact reading."""
    return expression.xreplace({f: _rational(exact(float(f))) for f in expression.atoms(sp.Float)})


def _rational(number: Fraction) -> sp.Rational:
    return sp.Rational(number.numerator, number.denominator)
