"""What heyoka needs to be told: which build it is, to keep nothing by itself, and SymPy's expressions where the two
differ: numbers that are no doubles, and whole powers."""

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

# Optimising a system whose expressions have so many nodes takes 0.3 s. For larger ones (curvatures change) it takes
# 0.5 to 2.7 s, ten times the rest of their compilation, to save a fifth to a half of runs of a millisecond.
SMALL = 500


@lru_cache(maxsize=1)
def build() -> tuple[int, int]:
    """Which build of heyoka this is: the same version may come with another LLVM."""
    stat = Path(getfile(hy.expression)).stat()  # the compiled module, whose name differs between versions
    return stat.st_size, stat.st_mtime_ns


def small(system: System) -> bool:
    """Whether optimising the system's code is worth its time."""
    nodes = chain.from_iterable(sp.preorder_traversal(e) for e in (*system.rates, *system.guards.values()))
    return next(islice(nodes, SMALL, None), None) is None


@contextmanager
def nothing_on_disk() -> Iterator[None]:
    """heyoka would keep all it compiles in the user's home, gigabytes of it, and compile at another speed each time."""
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
    """Expressions as a compiled function of one array, without optimisation and for one input at a time: a third of the
    compilation's time, and a tenth of a microsecond a call."""
    with nothing_on_disk():
        return hy.cfunc(outputs, inputs, opt_level=0, batch_size=1)


def variables(system: System) -> dict:
    """SymPy symbols of the system as heyoka's variables, parameters and time."""
    symbols = {v: hy.expression(v.name) for v in system.variables}
    return symbols | {p: hy.par[i] for i, p in enumerate(system.parameters)} | {T: hy.time}


@lru_cache(maxsize=64)
def guards(system: System) -> tuple:
    """The system's guards as heyoka's expressions: its integrators need them, and what leaves a phase's start."""
    symbols = variables(system)
    return tuple(convert(guard, symbols) for guard in system.guards.values())


def convert(expression: sp.Expr, symbols: dict):
    """The expression as heyoka's, whole powers as products: heyoka's own power has no Taylor series at zero.

    A magnitude, which SymPy makes of a root of a square, is that root again: it is a speed |R_p|, which is never zero.
    """
    symbols = symbols | {number: _number(number) for number in _numbers(expression)}
    products: dict[sp.Expr, sp.Symbol] = {}
    powers = [p for p in expression.atoms(sp.Pow) if p.exp.is_Integer and p.exp > 2]
    powers += expression.atoms(sp.Abs)
    # What a power contains comes before it. SymPy sorts sums by names: those given here do not depend on what was
    # compiled before, so that a motion is the same to its last bit whatever ran earlier.
    for i, power in enumerate(sorted(powers, key=lambda p: (p.count_ops(), sp.default_sort_key(p)))):
        base = _from_sympy(power.args[0].xreplace(products), symbols)
        products[power] = sp.Symbol(f"power_{i:04d}")
        symbols[products[power]] = hy.sqrt(base * base) if isinstance(power, sp.Abs) else _power(base, int(power.exp))
    return _from_sympy(expression.xreplace(products), symbols)


def _from_sympy(expression: sp.Expr, symbols: dict):
    """heyoka's own conversion; raises NotSupported for a function that it has no series of."""
    try:
        return hy.from_sympy(expression, symbols)
    except (TypeError, ValueError) as problem:
        raise NotSupported(f"the Taylor method cannot do this case ({problem}); give method='dop853'") from problem


def _numbers(expression: sp.Expr) -> Iterator[sp.Expr]:
    """Numbers inside the expression that heyoka refuses or rounds to double precision: 1/3, sqrt(2), exp(1)."""
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
    """The number in quadruple precision, where heyoka has it; a compilation in double precision rounds it once more."""
    digits = str(sp.N(number, 40))  # quadruple precision has 34
    return hy.expression(hy.real128(digits) if hasattr(hy, "real128") else float(digits))


def _power(base, exponent: int):
    """Repeated squaring."""
    half = base if exponent < 4 else _power(base, exponent // 2)
    if exponent in (2, 3):
        return base * base if exponent == 2 else base * (base * base)
    return half * half if exponent % 2 == 0 else base * (half * half)
