"""The series of a mode's conditions as machine code: the recurrences of `series`, evaluated once on symbols.

Optional: without heyoka there is no compiled code, and decisions take a tenth of a millisecond longer.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import lru_cache

from .series import Series
from .system import System

try:
    import heyoka as hy
except ImportError:
    AVAILABLE = False
else:
    from .integrators.conversion import build, compile_quickly, small

    AVAILABLE = True


class Symbol:
    """A symbolic input of the compiled function; it supports the operations of floats."""

    def __init__(self, expression) -> None:
        self.expression = expression

    def __neg__(self):
        return Symbol(-self.expression)

    def __abs__(self):
        return Symbol(2.0 * hy.relu(self.expression) - self.expression)  # exact, as is the double of a float


def _operation(name: str, swap: bool = False) -> Callable:
    """An operation of `operator` on symbols and floats; `swap`: with the float first."""

    def apply(self, other):
        if not isinstance(other, Symbol | float | int):
            return NotImplemented
        pair = (other, self) if swap else (self, other)
        first, second = (v.expression if isinstance(v, Symbol) else hy.expression(float(v)) for v in pair)
        return Symbol(getattr(operator, name)(first, second))

    return apply


for _name in ("add", "sub", "mul", "truediv", "pow"):
    setattr(Symbol, f"__{_name}__", _operation(_name))
    setattr(Symbol, f"__r{_name}__", _operation(_name, swap=True))
for _name in ("exp", "log", "sqrt", "sin", "cos", "sinh", "cosh", "tanh", "asin", "acos", "atan"):
    setattr(Symbol, _name, lambda self, name=_name: Symbol(getattr(hy, name)(self.expression)))


@lru_cache(maxsize=256)
def compile_series(system: System, order: int) -> Callable[..., list[Series]] | None:
    """The conditions of `System.expand` to that order, compiled; None if compilation does not pay off."""
    if not AVAILABLE:
        return None
    function = system.from_cache("series", (order, hy.__version__, build()), lambda: _compile_source(system, order))
    if function is None:
        return None
    terms = order + 1

    def evaluate(t, y, bounds, parameters) -> list[Series]:
        values = function([t, *y, *bounds, *parameters]).tolist()
        starts = range(0, len(values), 2 * terms)
        return [Series(values[i : i + terms], values[i + terms : i + 2 * terms]) for i in starts]

    return evaluate


def _compile_source(system: System, order: int):
    if not small(system):
        return None
    y, parameters = system.variables, system.parameters
    names = ["t", *(f"y_{v.name}" for v in y), *(f"e_{v.name}" for v in y), *(f"p_{p.name}" for p in parameters)]
    inputs = [hy.expression(name) for name in names]
    symbols = list(map(Symbol, inputs))
    parts = symbols[1 : 1 + len(y)], symbols[1 + len(y) : 1 + 2 * len(y)], symbols[1 + 2 * len(y) :]
    outputs: list = []
    for value in system.expand(symbols[0], *parts, order)[1]:
        value_series = value if isinstance(value, Series) else Series([value] + [0.0] * order, [0.0] * (order + 1))
        outputs += (
            v.expression if isinstance(v, Symbol) else hy.expression(v) for v in (*value_series.c, *value_series.e)
        )
    return compile_quickly(outputs, inputs)
