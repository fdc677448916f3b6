"""What a case can ask for. An effect is data only: what it means is written once in each solver.

SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import cos, inf, pi, sin
from typing import Any, TypeVar, get_args

import numpy as np

from . import slip_laws
from .derivation import derived, in_one_thread
from .errors import BadValue, finite, not_negative
from .formulas import features, formula_symbols
from .formulas import late_sympy as sp
from .formulas.effect_formulas import WithFormulas, features_in_time, formula_in, values_of
from .formulas.expression_graph import Node, from_sympy, symbol
from .formulas.formula_symbols import __getattr__ as __getattr__
from .moving_surface import Belt, Drive
from .own_effects import ContactEffect

# How an impact's restitution and friction go together (`Impact`).
IMPACT_LAWS = ("poisson", "newton", "moreau")

# A load that is a polynomial of this degree in place and velocity needs no check: its derivatives at a step's start, of
# which the coarsest integrator takes four, determine it everywhere.
SIMPLE = 2
# Cosine and sine of whole quarter turns.
_QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


@dataclass(frozen=True)
class Gravity:
    """Uniform gravity of strength `g` (m/s²), pulling along the angle `direction` of the fixed frame (default: −Y)."""

    g: float
    direction: float = -pi / 2

    def __post_init__(self):
        object.__setattr__(self, "g", not_negative("g of Gravity", self.g))
        object.__setattr__(self, "direction", finite("direction of Gravity", self.direction))

    @property
    def vector(self) -> tuple[float, float]:
        """Its components in the fixed frame, m/s².

        Along an axis the other one is exactly 0: the cosine of the double nearest to −π/2 is 6e-17, which is not meant
        and moves a disc on a level line with friction of a millionth by 1e-6 s.
        """
        turns = round(self.direction / (pi / 2))
        if self.direction == turns * (pi / 2):
            along, across = _QUARTERS[turns % 4]
            return self.g * along, self.g * across
        return self.g * cos(self.direction), self.g * sin(self.direction)


@dataclass(frozen=True)
class Load(WithFormulas):
    """A force at the centre of mass, components `fx`, `fy` in the fixed frame (N), and a `moment` about it (N m).

    The paper's torsor (F_x, F_y, M₀). Each is a number or a formula in t, x, y, theta, vx, vy, omega: text such as
    "-0.2*vx + sin(3*t)", or an expression in the symbols of `cases.effects.MOTION`. A step in time is a comparison,
    "5*(t > 0.5)" or "5 if 0.5 < t < 1 else 2*t", or SymPy's Piecewise or Heaviside of t: it rises within some 1e-7 s.
    Raises BadValue for anything else.
    """

    fx: sp.Expr | str | float = 0.0
    fy: sp.Expr | str | float = 0.0
    moment: sp.Expr | str | float = 0.0

    @in_one_thread
    def __post_init__(self):
        for name in ("fx", "fy", "moment"):
            symbols, what, given = formula_symbols.MOTION, f"{name} of Load", getattr(self, name)
            object.__setattr__(self, name, formula_in(symbols, what, given, time=symbols[0]))

    @property
    def expression(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """(fx, fy, moment) as expressions in `MOTION`."""
        return self.fx, self.fy, self.moment

    @derived
    def at(self) -> Callable[..., list[float]]:
        """A function (t, x, y, theta, vx, vy, omega) -> [fx, fy, moment], on floats; NaN where there is no value."""
        return values_of(formula_symbols.MOTION, self.expression)

    @derived
    def features(self) -> features.Features | None:
        """Where its parts that depend on time alone change, and how finely; None if it has none.

        Resolved on windows of absolute time, so that they are the same whatever a motion's duration.
        """
        return features_in_time(formula_symbols.MOTION[0], self.expression)


def checked_quantities(formulas: Sequence[sp.Expr], symbols: Sequence[sp.Symbol] = ()) -> tuple[Node, ...]:
    """The quantities that an integrator has to check along each step under a load of these formulas (or friction by a
    formula in other `symbols`): the arguments of the formulas' functions, then the formulas. Empty if the features in
    time and the derivatives at a step's start show all that they do.
    """
    nodes, (t, *others) = [*map(from_sympy, formulas)], map(symbol, formula_symbols.NAMES["MOTION"])
    moving = frozenset(symbol(other.name) for other in symbols) or frozenset(others)
    arguments = dict.fromkeys(a for formula in nodes for a in features.arguments(formula, moving | {t}))
    to_check = [a for a in arguments if moving & a.symbols or features.degree(a, {t}) == inf]
    if not to_check and max(features.degree(formula, moving) for formula in nodes) <= SIMPLE:
        return ()
    return *to_check, *nodes


@dataclass(frozen=True)
class CoulombFriction(WithFormulas):
    """Dry friction: |T| = mu·N against the slip velocity, |T| ≤ mu_static·N without slip (mu_static=None: mu at rest).

    `mu` is a number, or a formula in v, the slip speed (m/s, v ≥ 0): text such as "0.1 + 0.1*exp(-v/0.05) + 0.02*v", or
    an expression in `cases.slip_laws.SLIP_SPEED`. An impact has one coefficient: that of the slip speed before it. A
    case with the coefficient 0 is one without friction. Raises BadValue for anything else, and for a formula that
    `cases.slip_laws` rejects.
    """

    mu: float | Any
    mu_static: float | None = None

    @in_one_thread
    def __post_init__(self):
        object.__setattr__(self, "mu", slip_laws.coefficient("mu of CoulombFriction", self.mu))
        if self.mu_static is not None:
            object.__setattr__(self, "mu_static", not_negative("mu_static of CoulombFriction", self.mu_static))
            if self.mu_static < self.at_rest:
                mu = f"mu = {self.at_rest:g}" + (" at v = 0" if self.by_speed else "")
                raise BadValue(f"mu_static of CoulombFriction is {self.mu_static:g}, below {mu}; give at least mu")
            if self.at_rest == 0.0 < self.mu_static:
                raise BadValue("mu of CoulombFriction is 0 and its mu_static is not; give a mu greater than zero")

    @property
    def by_speed(self) -> bool:
        """Whether the coefficient depends on the slip speed."""
        return not isinstance(self.mu, float)

    def at(self, speed):
        """The coefficient at a slip speed v ≥ 0 (m/s), or at an array of them; a number for all if it is constant."""
        return self._function(speed) if self.by_speed else self.mu

    @derived
    def _function(self) -> Callable:
        return slip_laws.function(self.mu)

    @derived
    def at_rest(self) -> float:
        """The coefficient of a slip that begins: mu at v = 0."""
        return float(self.at(0.0))

    @property
    def stick(self) -> float:
        """The coefficient that bounds friction without slip."""
        return self.at_rest if self.mu_static is None else self.mu_static

    def in_impact(self, slip):
        """The coefficients against slip and without it of an impact that begins at a slip velocity (m/s), or at an
        array of them: an impact has one, `mu` at the slip speed before it; a larger `mu_static` bounds friction without
        slip."""
        mu = self.at(abs(slip))
        return mu, np.maximum(mu, self.mu_static or 0.0)


@dataclass(frozen=True)
class PerfectlyRough:
    """The plate never slips, whatever friction that takes."""


@dataclass(frozen=True)
class RollingResistance:
    """A couple arm·N against the plate's rotation on its track, at most arm·N while it does not turn; `arm` in m.

    (The lever-arm model.) A plate that neither
    slips nor turns is in the mode `rest`.
    """

    arm: float

    def __post_init__(self):
        object.__setattr__(self, "arm", not_negative("arm of RollingResistance", self.arm))


@dataclass(frozen=True)
class Unilateral:
    """The track pushes and never pulls: contact ends (lift-off) where the normal force would change sign.

    Without it the contact is a bilateral guide; its friction uses the magnitude of the normal force.
    """


@dataclass(frozen=True)
class Flight:
    """After lift-off the plate flies on until its outline meets the track again; without it lift-off is the end.

    Without `Impact` the landing is the end. A start may then lie off the track (`gap`, `gap_rate` of Start).
    """


@dataclass(frozen=True)
class Impact:
    """A landing is an impact without duration with friction, `restitution` e in [0, 1].

    `law`: "poisson" (the impulse of restitution is e times that of compression) or "newton" (the contact point's
    normal velocity turns to −e times itself), both by Routh's construction, which follows the slip along the impulse;
    or "moreau", Newton's restitution with Coulomb's law between the whole impulses and the velocities after the
    impact, as engines with a fixed step have it. Newton's restitution can create energy where friction ends or
    reverses the slip: with "newton" such an impact ends the motion with a reason, with "moreau" the motion continues,
    as in those engines. (Wang & Mason 1992, J. Appl. Mech. 59, 635:
    reference looked up, not the text; Routh's book of 1905 is known to us, not looked up. "moreau": Siconos' users'
    guide, "Non Smooth Laws", has the normal part; the whole is derived in `reference.minimal.impact`.)
    """

    restitution: float
    law: str = "poisson"

    def __post_init__(self):
        object.__setattr__(self, "restitution", not_negative("restitution of Impact", self.restitution))
        if self.restitution > 1.0:
            raise BadValue(f"restitution of Impact is {self.restitution:g}; give a number between 0 and 1")
        if not isinstance(self.law, str) or self.law not in IMPACT_LAWS:
            names = ", ".join(f'"{name}"' for name in IMPACT_LAWS)
            raise BadValue(f"law of Impact is {self.law!r}; give one of {names}")


SuiteEffect = (
    Gravity | Load | CoulombFriction | PerfectlyRough | RollingResistance | Unilateral | Flight | Impact | Belt | Drive
)
Effect = SuiteEffect | ContactEffect

_KINDS: tuple[type, ...] = get_args(SuiteEffect)

E = TypeVar("E")


def one(effects: Iterable[Effect], kind: type[E]) -> E | None:
    """The effect of that kind among them, or None."""
    for effect in effects:  # it is asked at every evaluation; `next` of a generator takes twice as long
        if isinstance(effect, kind):
            return effect
    return None


def that_act(effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """The effects without those whose values are 0, as at the end of a range of parameters: friction, and a belt where
    that is its only friction, a belt at rest, rolling resistance, and a load."""
    is_smooth = any(isinstance(e, CoulombFriction) and e.stick == 0.0 for e in effects)
    return tuple(
        e
        for e in effects
        if not (
            (isinstance(e, CoulombFriction) and is_smooth)
            or (isinstance(e, Belt) and (is_smooth or e.expression.is_zero))
            or (isinstance(e, RollingResistance) and e.arm == 0.0)
            or (isinstance(e, Load) and not any(e.expression))
        )
    )


def check_formula(effects) -> tuple[Effect, ...]:
    """The effects that act, as a tuple; raises BadValue with one sentence for what is none, or twice."""
    try:
        effects = tuple(effects)
    except TypeError:
        raise BadValue(f"effects is {effects!r}; give a tuple such as (Gravity(9.81), Unilateral())") from None
    kinds = tuple(map(type, effects))
    for e, kind in zip(effects, kinds, strict=True):
        if kind in _KINDS:
            continue
        if isinstance(e, ContactEffect):
            e.check()
            if kind.__name__ in {other.__name__ for other in _KINDS}:
                raise BadValue(f"{kind.__name__} is an effect of the suite; give your effect another name")
            continue
        if base := next((base_class for base_class in _KINDS if isinstance(e, base_class)), None):
            # What it adds no solver would know, and what it contradicts no check.
            raise BadValue(f"{kind.__name__} is a class of its own; give {base.__name__}, which solvers know")
        raise BadValue(f"{e!r} is not an effect; give objects such as Gravity(9.81), with the brackets")
    statuses = [end.status for e in effects if isinstance(e, ContactEffect) for end in e.ends()]
    if same := next((status for status in statuses if statuses.count(status) > 1), None):
        raise BadValue(f"two conditions end the motion with the status {same!r}; give each a status of its own")
    twice = next((kind for kind in kinds if kinds.count(kind) > 1), None)
    if twice:
        raise BadValue(f"the case asks for {twice.__name__} more than once; give one of each effect")
    return that_act(effects)
