"""The augmented system (27) eliminated by hand, symbolically once per structure of curves and effects.

In the frame of the common tangent (t along the track, n = U t towards the plate) the tangents of track and outline
coincide, so (27) splits: the n-component of its first constraint rows holds neither ξ̈₁ nor ξ̈₂ and gives the normal
force by one division; the t-component and the tangency row then give ξ̈₁ and ξ̈₂. Letters: P = |R_p|, a = R_s·t,
b = R_s·n, c = R_t·n on the track; p, a, b, c on the outline, turned with the plate; h = θr, the arm to the contact.

Forces are taken per mass, so that mass drops out where it does not matter. One symbolic source serves every
integrator: sizes, friction, loads and start are runtime parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import cos, sin
from typing import NamedTuple

import sympy as sp

from cases import Case, CoulombFriction, Curve, Gravity, Mode, Unilateral
from cases.curves import PARAMETER

from . import series

T, X1, X2, U1, U2 = sp.symbols("t xi1 xi2 u1 u2", real=True)
GYRATION = sp.Symbol("G", positive=True)  # J/m, the square of the radius of gyration
NORMAL = sp.Symbol("N", real=True)  # the normal force per mass, while it is being eliminated
GX, GY = sp.symbols("gx gy", real=True)
# Friction force per normal force (the paper's μ of (30) with its sign), sign of the slip, sign of the normal force,
# and the coefficient that bounds friction in roll.
RATIO, SIGMA, SIDE, STICK = sp.symbols("k sigma nu mu_stick", real=True)
LOW, HIGH = sp.symbols("low high", real=True)


class Frame(NamedTuple):
    """A curve at one parameter, in the frame of its tangent: speed, second and third derivatives, position, tangent."""

    P: sp.Expr
    a: sp.Expr
    b: sp.Expr
    c: sp.Expr
    ht: sp.Expr
    hn: sp.Expr
    tx: sp.Expr
    ty: sp.Expr

    @property
    def curvature(self) -> sp.Expr:
        return _short(self.b / self.P**2)


def frame(structure, parameter: sp.Symbol, prefix: str) -> tuple[Frame, tuple[sp.Symbol, ...]]:
    """The frame of a curve of that structure, and its size symbols renamed with the prefix."""
    (x, y), symbols = structure
    sizes = tuple(sp.Symbol(prefix + s.name, positive=True) for s in symbols)
    rename = {PARAMETER: parameter, **dict(zip(symbols, sizes, strict=True))}
    quantities = [q.subs(rename, simultaneous=True) for q in _frame(x, y)]
    return Frame(*quantities), sizes


@lru_cache(maxsize=256)
def _frame(x: sp.Expr, y: sp.Expr) -> Frame:
    (xp, yp), (xs, ys), (xt, yt) = ((sp.diff(x, PARAMETER, order), sp.diff(y, PARAMETER, order)) for order in (1, 2, 3))
    P = sp.sqrt(_tidy(xp**2 + yp**2))
    return Frame(
        P=P,
        a=_tidy(xp * xs + yp * ys) / P,
        b=_tidy(xp * ys - yp * xs) / P,
        c=_tidy(xp * yt - yp * xt) / P,
        ht=_tidy(x * xp + y * yp) / P,
        hn=_tidy(xp * y - yp * x) / P,
        tx=xp / P,
        ty=yp / P,
    )


def _tidy(expression: sp.Expr) -> sp.Expr:
    """A curve's expression or its trigonometric simplification, the shorter; long ones stay as they are."""
    # Simplification pays for lines, circles and ellipses; beyond forty operations it takes seconds and gains little.
    if sp.count_ops(expression) > 40:
        return expression
    flat = sp.expand(expression)
    return min((expression, flat, sp.trigsimp(flat)), key=sp.count_ops)


def _short(expression: sp.Expr) -> sp.Expr:
    """The shortest of the expression, multiplied out and factored; long ones and ones with roots stay as they are."""
    # With a root among the generators, or with more terms than circles and lines bring, factoring takes seconds.
    if sp.count_ops(expression) > 60 or not all(power.exp.is_Integer for power in expression.atoms(sp.Pow)):
        return expression
    flat = sp.expand(expression)
    return min((expression, flat, sp.factor(flat)), key=sp.count_ops)


class Motion(NamedTuple):
    """Symbolic outcome of one mode: accelerations, contact forces (per mass), spin and slip with their rates."""

    u1_dot: sp.Expr
    u2_dot: sp.Expr
    normal: sp.Expr
    friction: sp.Expr
    omega: sp.Expr
    omega_dot: sp.Expr
    slip: sp.Expr
    slip_dot: sp.Expr
    division: sp.Expr  # the coefficient of the normal force in its equation, times the mass: Painlevé's number


def _rates(f: Frame, h: Frame, u1, u2):
    """What the constraints say of the state: spin, ξ̇₁²a − ξ̇₂²a, and the right-hand sides of (26) in the frame."""
    omega = u1 * f.b / f.P - u2 * h.b / h.P  # (9)
    along = u1**2 * f.a - u2**2 * h.a
    C_t = omega**2 * h.ht + along
    C_n = omega**2 * h.hn - 2 * omega * u2 * h.P - u2**2 * h.b + u1**2 * f.b
    C_3 = (
        2 * omega * (u1 * f.a * h.P + u2 * h.a * f.P)
        - u1**2 * h.P * f.c
        + u2**2 * f.P * h.c
        - 2 * u1 * u2 * (f.b * h.a - f.a * h.b)
    )
    return omega, along, C_t, _short(C_n), _short(C_3)


def sliding(f: Frame, h: Frame, u1, u2, force, ratio) -> Motion:
    """(27) with one multiplier: friction is `ratio` times the normal force. `force` is (F_t, F_n, M₀) per mass."""
    F_t, F_n, M_0 = force
    omega, along, C_t, C_n, C_3 = _rates(f, h, u1, u2)
    division = _short(1 + h.ht * (h.ht - h.hn * ratio) / GYRATION)
    N = (C_n - h.ht * M_0 / GYRATION - F_n) / division
    omega_dot = (M_0 + NORMAL * _short(h.ht - h.hn * ratio)) / GYRATION
    sigma = F_t + ratio * NORMAL - omega_dot * h.hn - C_t  # ξ̈₁ P − ξ̈₂ p, the t-component
    u1_dot = _short((C_3 / (f.P * h.P) + omega_dot - sigma * h.curvature) / _short(f.P * (f.curvature - h.curvature)))
    u2_dot = _short((u1_dot * f.P - sigma) / h.P)
    motion = Motion(
        u1_dot, u2_dot, NORMAL, ratio * NORMAL, _short(omega), omega_dot, u1 * f.P - u2 * h.P, sigma + along, division
    )
    return Motion(*(sp.sympify(e).subs(NORMAL, N) for e in motion))


def rolling(f: Frame, h: Frame, u1, force) -> Motion:
    """(27) with the tangential multiplier and the rolling row; ξ̇₂ follows from v = 0."""
    F_t, F_n, M_0 = force
    u2 = u1 * f.P / h.P
    omega, along, C_t, C_n, C_3 = _rates(f, h, u1, u2)
    # Moments about the contact: neither multiplier appears.
    moment = _short(M_0 + h.ht * (C_n - F_n) - h.hn * (omega**2 * h.ht - F_t))
    omega_dot = moment / _short(GYRATION + h.ht**2 + h.hn**2)
    u1_dot = _short((omega_dot + h.curvature * along + C_3 / (f.P * h.P)) / _short(f.P * (f.curvature - h.curvature)))
    u2_dot = (u1_dot * f.P + along) / h.P
    N = C_n - omega_dot * h.ht - F_n
    friction = omega**2 * h.ht + omega_dot * h.hn - F_t
    zero, one = sp.Integer(0), sp.Integer(1)
    return Motion(u1_dot, u2_dot, N, friction, _short(omega), omega_dot, zero, zero, one)


@dataclass(frozen=True, eq=False)
class System:
    """One mode's equations, symbolic: y' = rates(t, y; parameters), what can be observed, what ends the mode.

    `conditions` are what a decision for this mode asks for; `guards` are positive while it lasts: the conditions and
    the geometry's limits, less those that the state cannot change.
    """

    variables: tuple[sp.Symbol, ...]
    parameters: tuple[sp.Symbol, ...]
    rates: tuple[sp.Expr, ...]
    observed: Motion
    conditions: dict[str, sp.Expr]
    guards: dict[str, sp.Expr]

    def _compile(self, expressions, library):
        return sp.lambdify([T, self.variables, self.parameters], list(expressions), modules=library, cse=True)

    @cached_property
    def rates_of_numbers(self):
        """(t, y, parameters) -> list of rates, on floats."""
        return self._compile(self.rates, "math")

    @cached_property
    def rates_of_series(self):
        """The same on `series.Series`."""
        return self._compile(self.rates, [series.FUNCTIONS])

    @cached_property
    def guards_of_numbers(self):
        """(t, y, parameters) -> list of guard values, on floats."""
        return self._compile(self.guards.values(), "math")

    @cached_property
    def guards_of_arrays(self):
        """The same on arrays of shape (n,); a constant guard stays a number."""
        return self._compile(self.guards.values(), "numpy")

    @cached_property
    def conditions_of_numbers(self):
        """(t, y, parameters) -> list of the conditions' values, on floats."""
        return self._compile(self.conditions.values(), "math")

    @cached_property
    def slip_rate_of_numbers(self):
        """(t, y, parameters) -> rate of the "slip" condition, on floats."""
        return self._compile([SIGMA * self.observed.slip_dot], "math")

    @cached_property
    def conditions_of_series(self):
        """The same on `series.Series`; a constant condition stays a number."""
        return self._compile(self.conditions.values(), [series.FUNCTIONS])

    @cached_property
    def observed_of_arrays(self):
        """(t, y, parameters) -> list in the order of `Motion`, on arrays."""
        return self._compile(self.observed, "numpy")

    @cached_property
    def observed_of_numbers(self):
        """The same on floats."""
        return self._compile(self.observed, "math")


@lru_cache(maxsize=256)
def _derive(track, outline, bounded: tuple[bool, bool], effects: frozenset, rolls: bool) -> System:
    """The system of a structure: two curves, which of them have ends, the kinds of effects, rolling or sliding."""
    f, track_sizes = frame(track, X1, "track_")
    h, outline_sizes = frame(outline, X2, "outline_")
    parameters = [*track_sizes, *outline_sizes, GYRATION]
    force = [sp.Integer(0)] * 3
    if Gravity in effects:
        parameters += [GX, GY]
        force[0] = GX * f.tx + GY * f.ty
        force[1] = GY * f.tx - GX * f.ty
    conditions: dict[str, sp.Expr] = {}
    guards: dict[str, sp.Expr] = {"fit": h.curvature - f.curvature}
    if rolls:
        parameters += [STICK, SIDE]
        motion = rolling(f, h, U1, force)
        conditions["cone_forward"] = SIDE * STICK * motion.normal + motion.friction
        conditions["cone_backward"] = SIDE * STICK * motion.normal - motion.friction
    elif CoulombFriction in effects:
        parameters += [RATIO, SIGMA, SIDE]
        motion = sliding(f, h, U1, U2, force, RATIO)
        conditions["slip"] = SIGMA * motion.slip
        conditions["normal_force"] = SIDE * motion.normal
        guards["painleve"] = motion.division
    else:
        motion = sliding(f, h, U1, U2, force, sp.Integer(0))
        if Unilateral in effects:
            conditions["normal_force"] = motion.normal
    for name, bound, variable in zip(("track", "outline"), bounded, (X1, X2), strict=True):
        if bound:
            low, high = sp.Symbol(f"{name}_low", real=True), sp.Symbol(f"{name}_high", real=True)
            parameters += [low, high]
            guards[f"{name}_start"], guards[f"{name}_end"] = variable - low, high - variable
    variables = (X1, X2, U1) if rolls else (X1, X2, U1, U2)
    rates = (U1, U1 * f.P / h.P, motion.u1_dot) if rolls else (U1, U2, motion.u1_dot, motion.u2_dot)
    moving = set(variables) | {T}
    guards = {name: g for name, g in (conditions | guards).items() if g.free_symbols & moving}
    return System(variables, tuple(parameters), rates, motion, conditions, guards)


def system(case: Case, mode: Mode) -> System:
    """The equations of one mode of a case, derived once per structure."""
    track, outline = case.track, case.plate.outline
    bounded = (_has_ends(track), _has_ends(outline))
    return _derive(
        track.structure, outline.structure, bounded, frozenset(type(e) for e in case.effects), mode is Mode.ROLL
    )


def _has_ends(curve: Curve) -> bool:
    return curve.domain is not None and curve.period is None


def parameter_values(case: Case, values: dict[sp.Symbol, float], names: tuple[sp.Symbol, ...]) -> tuple[float, ...]:
    """The runtime parameters in the system's order: the case's own and the mode's `values`."""
    track, outline = case.track, case.plate.outline
    known: dict[str, float] = {"G": case.plate.inertia / case.plate.mass}
    for prefix, curve in (("track", track), ("outline", outline)):
        known |= {f"{prefix}_c{i}": value for i, value in enumerate(curve.constants)}
        if curve.domain:
            known |= {f"{prefix}_low": curve.domain[0], f"{prefix}_high": curve.domain[1]}
    gravity = case.effect(Gravity)
    if gravity:
        known |= {"gx": gravity.g * cos(gravity.direction), "gy": gravity.g * sin(gravity.direction)}
    known |= {symbol.name: value for symbol, value in values.items()}
    return tuple(known[symbol.name] for symbol in names)
