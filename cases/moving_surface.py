"""Effects that move the track: a belt's surface along it, and a drive of the track itself. Formulas of time.

SI units. What they mean in the equations is written once in each solver.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .derivation import derived, in_one_thread
from .errors import BadValue, numbers
from .formulas import features, formula_symbols
from .formulas import late_sympy as sp
from .formulas.effect_formulas import WithFormulas, features_in_time, formula_in, values_of
from .formulas.expression_code import ON_ARRAYS, function_of
from .formulas.formula_symbols import __getattr__ as __getattr__

Values = Callable[[float], list[float]]


@dataclass(frozen=True)
class Belt(WithFormulas):
    """The track's surface runs along it with `speed` (m/s), positive towards increasing xi1: a conveyor.

    A number or a formula in t, as text such as "0.5 + 0.1*sin(3*t)" or an expression in `cases.moving_surface.TIME`.
    The slip velocity of every motion, and of Start, is that of the plate's point relative to the surface. The track's
    place does not change. Raises BadValue for anything else.
    """

    speed: sp.Expr | str | float

    @in_one_thread
    def __post_init__(self):
        object.__setattr__(self, "speed", formula_in((formula_symbols.TIME,), "speed of Belt", self.speed))

    @property
    def expression(self) -> sp.Expr:
        """The speed as an expression in `TIME`."""
        assert isinstance(self.speed, sp.Expr)
        return self.speed

    @property
    def constant(self) -> float | None:
        """The speed if it does not depend on time, m/s; else None."""
        return None if self.expression.has(formula_symbols.TIME) else float(self.expression)

    @derived
    def at(self) -> Values:
        """A function t -> [speed, its rate] (m/s, m/s²), on floats; NaN where there is no value."""
        return values_of((formula_symbols.TIME,), (self.expression, sp.diff(self.expression, formula_symbols.TIME)))

    @derived
    def at_arrays(self) -> Callable[[np.ndarray], np.ndarray]:
        """A function of times (n,) -> speeds (n,), m/s."""
        function = function_of((formula_symbols.TIME,), (self.expression,), ON_ARRAYS)
        return lambda t: np.broadcast_to(function(t)[0], np.shape(t)).astype(float)

    @derived
    def features(self) -> features.Features | None:
        """Where speed and acceleration change, and how finely; None for a constant speed."""
        return features_in_time(formula_symbols.TIME, (self.expression, sp.diff(self.expression, formula_symbols.TIME)))


class TrackPlace(NamedTuple):
    """Place and angle of a driven track's frame in the fixed frame, with first and second rates (SI units, rad)."""

    x: float
    y: float
    angle: float
    vx: float
    vy: float
    spin: float
    ax: float
    ay: float
    swing: float

    def seen_from_outside(self, x, y, vx, vy, omega):
        """Place, velocity and spin (m, m/s, rad/s) in the fixed frame, of numbers or arrays in the track's frame."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        rx, ry = c * x - s * y, s * x + c * y
        ux, uy = self.vx + c * vx - s * vy - self.spin * ry, self.vy + s * vx + c * vy + self.spin * rx
        return self.x + rx, self.y + ry, ux, uy, omega + self.spin

    def seen_from_track(self, x, y, vx, vy, omega):
        """Place, velocity and spin (m, m/s, rad/s) in the track's frame, of numbers or arrays in the fixed frame."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        dx, dy = x - self.x, y - self.y
        ux, uy = vx - self.vx + self.spin * dy, vy - self.vy - self.spin * dx
        return c * dx + s * dy, c * dy - s * dx, c * ux + s * uy, c * uy - s * ux, omega - self.spin


@dataclass(frozen=True)
class Drive(WithFormulas):
    """The track itself moves: its origin is at (`x`, `y`) (m), and it is turned by `angle` (rad) about its origin.

    Numbers or formulas in t, as text such as "0.05*sin(20*t)" or expressions in `cases.moving_surface.TIME`. Motions
    are in the fixed frame; slip velocities, and those of Start, are relative to the track. `omega` of Start is in the
    fixed frame. Raises BadValue for anything else.
    """

    x: sp.Expr | str | float = 0.0
    y: sp.Expr | str | float = 0.0
    angle: sp.Expr | str | float = 0.0

    @in_one_thread
    def __post_init__(self):
        for name in ("x", "y", "angle"):
            object.__setattr__(self, name, formula_in((formula_symbols.TIME,), f"{name} of Drive", getattr(self, name)))
        if not any(part.has(formula_symbols.TIME) for part in self.expression):
            raise BadValue("no component of Drive depends on t; leave Drive out, or move the track's curve")

    @property
    def expression(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """(x, y, angle) as expressions in `TIME`."""
        return self.x, self.y, self.angle

    @property
    def is_turning(self) -> bool:
        """Whether the track's angle changes, or is not 0."""
        return not self.expression[2].is_zero

    @property
    def rates(self) -> tuple[sp.Expr, ...]:
        """`TrackPlace` as expressions in `TIME`."""
        first = [sp.diff(part, formula_symbols.TIME) for part in self.expression]
        return *self.expression, *first, *(sp.diff(part, formula_symbols.TIME) for part in first)

    @derived
    def _values(self) -> Values:
        return values_of((formula_symbols.TIME,), self.rates)

    def at(self, t: float) -> TrackPlace:
        """The track's place at a time; NaN where there is no value."""
        return TrackPlace(*self._values(t))

    @derived
    def _of_arrays(self) -> Callable[..., list]:
        return function_of((formula_symbols.TIME,), self.rates, ON_ARRAYS)

    def at_times(self, t: np.ndarray) -> TrackPlace:
        """The track's places at times (n,), each component of shape (n,)."""
        times = numbers("times", t)
        rows = (np.broadcast_to(row, times.shape).astype(float) for row in self._of_arrays(times))
        return TrackPlace(*rows)  # type: ignore[arg-type]

    @derived
    def features(self) -> features.Features | None:
        """Where the track's acceleration changes, and how finely; None if it is constant."""
        return features_in_time(formula_symbols.TIME, self.rates)
