"""Interface to heyoka: no disk cache of its own, and conversion of expressions, with special treatment of numbers that
are no doubles and of integer powers."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import heyoka as hy

from cases import NotSupported
from cases.formulas import late_sympy as sp
from cases.formulas.expression_graph import Node, in_order

from ..elimination import T
from ..system import System

# Optimising a system of this many operations (a disc on a line, a flight) takes 10 ms more than not optimising it. For
# larger ones it takes 80 ms (a disc in a circle) to 2 s, to save a tenth to a half of a motion of a millisecond.
SMALL = 32
# Code of a system with more operations than this (several plates) is a loop over them: written out it takes 0.2 s to
# compile instead of 0.05 s, and saves 30 µs of a step, of which a phase has ten.
LARGE = 250

_ARITHMETIC = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}
_HALF = Fraction(1, 2)


def operations_of(system: System) -> int:
    """The number of operations in a system's rates and guards."""
    return len(in_order((*system.rates, *system.guards.values()), {*system.constants}))


@contextmanager
def nothing_on_disk() -> Iterator[None]:
    """Disable heyoka's disk cache: it would fill the user's home with gigabytes, and compilation times would vary."""
    state = hy.llvm_state
    if not hasattr(state, "set_diskcache_enabled"):  # versions before it had that cache
        yield
        return
    setting = state.get_diskcache_enabled()
    state.set_diskcache_enabled(False)
    try:
        yield
    finally:
        state.set_diskcache_enabled(setting)


def variables(system: System, constants: bool = True) -> dict[Node, Any]:
    """The system's variables, parameters and time as heyoka's; with `constants` these, too, as parameters."""
    symbols = {v: hy.expression(v.name) for v in system.variables}
    parameters = system.parameters[: None if constants else len(system.names)]
    return symbols | {p: hy.par[i] for i, p in enumerate(parameters)} | {T: hy.time}


def convert(outputs: Iterable[Node], known: Mapping[Node, Any]) -> list:
    """Nodes as heyoka's expressions, with those in `known` as they are there."""
    outputs = list(outputs)
    results = dict(known)
    moving = {T, *(symbol for symbol, value in known.items() if hy.get_variables([value]))}
    for current in in_order(outputs, known):
        if current not in results:
            results[current] = (
                _number(current.args[0]) if current.op == "number" else _operation(current, results, moving)
            )
    return [results[output] for output in outputs]


def _operation(current: Node, results: Mapping[Node, Any], moving: set[Node]):
    x = results[current.args[0]]
    if current.op == "**":
        return _power(x, current.args[1], results)
    if current.op == "tanh":
        return _tanh(x)
    if current.op in _ARITHMETIC:
        y = results[current.args[1]]
        # A constant factor comes first: products that differ only in their order are then computed once.
        is_second = current.op == "*" and moving.isdisjoint(current.args[1].symbols)
        return _ARITHMETIC[current.op](*((y, x) if is_second else (x, y)))
    try:
        return getattr(hy, current.op)(x)
    except AttributeError as problem:  # in an older version
        raise NotSupported(f"the Taylor method cannot do this case ({problem}); give method='dop853'") from problem


def _tanh(x):
    """tanh, as 2 sigmoid(2 x) - 1.

    The series of tanh has the terms x_k - (tanh² x)_k. Where tanh is 1 except for rounding they are roundings of x_k,
    and a load whose argument is 1e8 has a force that is wrong by a part in a hundred. The series of the sigmoid S has
    the terms (S - S²)_k, which vanish there.
    """
    return 2.0 * hy.sigmoid(2.0 * x) - 1.0


def _power(base, power: Node, results: Mapping[Node, Any]):
    """A power; positive integer powers as products, as heyoka's own power has no Taylor series at zero."""
    exponent = power.args[0] if power.op == "number" else None
    if isinstance(exponent, int) and exponent > 1:
        return _product(base, exponent)
    return hy.sqrt(base) if exponent == _HALF else base ** results[power]


def _product(base, exponent: int):
    """An integer power by repeated squaring."""
    if exponent in (2, 3):
        return base * base if exponent == 2 else base * (base * base)
    half = _product(base, exponent // 2)
    return half * half if exponent % 2 == 0 else base * (half * half)


def _number(value: int | float | Fraction | sp.Expr):
    """The number as a double if that is exact, else in quadruple precision if heyoka supports it: a compilation in
    double precision rounds it again."""
    if isinstance(value, int | float) or (isinstance(value, Fraction) and Fraction(float(value)) == value):
        return hy.expression(float(value))
    with localcontext(prec=40):  # quadruple precision has 34 digits
        digits = Decimal(value.numerator) / value.denominator if isinstance(value, Fraction) else sp.N(value, 40)
    return hy.expression(hy.real128(str(digits)) if hasattr(hy, "real128") else float(digits))
