"""Interface to heyoka: its build, no disk cache of its own, and conversion of SymPy expressions, with special treatment
of numbers that are no doubles and of integer powers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from inspect import getfile
from itertools import chain, islice
from pathlib import Path

import heyoka as hy
import sympy as sp

from cases import NotSupported

from ..elimination import T
from ..system import System

# Optimising a system whose expressions have this many nodes takes 0.3 s. For larger ones (curvatures change) it takes
# 0.5 to 2.7 s, ten times the rest of their compilation, to save a fifth to a half of runs of a millisecond.
SMALL = 500


@lru_cache(maxsize=1)
def build() -> tuple[int, int]:
    """The build of heyoka: the same version may come with another LLVM."""
    stat = Path(getfile(hy.expression)).stat()  # the compiled module, whose name differs between versions
    return stat.st_size, stat.st_mtime_ns


def small(system: System) -> bool:
    """Whether optimising the system's code is worth its time."""
    nodes = chain.from_iterable(sp.preorder_traversal(e) for e in (*system.rates, *system.guards.values()))
    return next(islice(nodes, SMALL, None), None) is None


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


def compile_quickly(outputs: list, inputs: list):
    """Compile expressions to a function of one array, without optimisation and for one input at a time: a third of the
    compilation time, for a tenth of a microsecond more per call."""
    with nothing_on_disk():
        return hy.cfunc(outputs, inputs, opt_level=0, batch_size=1)


def variables(system: System) -> dict:
    """SymPy symbols of the system as heyoka's variables, parameters and time."""
    symbols = {v: hy.expression(v.name) for v in system.variables}
    return symbols | {p: hy.par[i] for i, p in enumerate(system.parameters)} | {T: hy.time}


@lru_cache(maxsize=64)
def guards(system: System) -> tuple:
    """The system's guards as heyoka expressions, for its integrators and for the first step of a phase."""
    symbols = variables(system)
    return tuple(convert(guard, symbols) for guard in system.guards.values())


def convert(expression: sp.Expr, symbols: dict):
    """Convert an expression to heyoka's, integer powers as products: heyoka's own power has no Taylor series at zero.

    An absolute value, to which SymPy converts a root of a square, becomes that root again: it is a speed |R_p|, which
    is never zero.
    """
    symbols = symbols | {number: _number(number) for number in _numbers(expression)}
    products: dict[sp.Expr, sp.Symbol] = {}
    powers = [p for p in expression.atoms(sp.Pow) if p.exp.is_Integer and p.exp > 2]
    powers += expression.atoms(sp.Abs)
    # The powers inside a power come before it. SymPy sorts sums by names: these names do not depend on earlier
    # compilations, so that a motion is the same to its last bit whatever ran before.
    for i, power in enumerate(sorted(powers, key=lambda p: (p.count_ops(), sp.default_sort_key(p)))):
        base = _from_sympy(power.args[0].xreplace(products), symbols)
        products[power] = sp.Symbol(f"power_{i:04d}")
        symbols[products[power]] = hy.sqrt(base * base) if isinstance(power, sp.Abs) else _power(base, int(power.exp))
    return _from_sympy(expression.xreplace(products), symbols)


def _from_sympy(expression: sp.Expr, symbols: dict):
    """heyoka's own conversion; raises NotSupported for a function without a Taylor series in heyoka."""
    try:
        return hy.from_sympy(expression, symbols)
    except (TypeError, ValueError) as problem:
        raise NotSupported(f"the Taylor method cannot do this case ({problem}); give method='dop853'") from problem


def _numbers(expression: sp.Expr) -> Iterator[sp.Expr]:
    """Numbers inside the expression that heyoka rejects or rounds to double precision: 1/3, sqrt(2), exp(1)."""
    nodes = sp.preorder_traversal(expression)
    for node in nodes:
        # π is heyoka's own; halves, quarters, … are exact, and as exponents they are square roots.
        plain = isinstance(node, sp.Integer | sp.Float) or node is sp.pi or (node.is_Rational and _is_binary(node.q))
        if isinstance(node, sp.Expr) and node.is_number and not plain:
            yield node
            nodes.skip()


def _is_binary(denominator: int) -> bool:
    """Whether the denominator is a power of two."""
    return denominator & (denominator - 1) == 0


def _number(number: sp.Expr):
    """The number in quadruple precision, if heyoka supports it; a compilation in double precision rounds it again."""
    digits = str(sp.N(number, 40))  # quadruple precision has 34
    return hy.expression(hy.real128(digits) if hasattr(hy, "real128") else float(digits))


def _power(base, exponent: int):
    """An integer power by repeated squaring."""
    half = base if exponent < 4 else _power(base, exponent // 2)
    if exponent in (2, 3):
        return base * base if exponent == 2 else base * (base * base)
    return half * half if exponent % 2 == 0 else base * (half * half)
