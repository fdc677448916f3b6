"""What a curve's function may return and a load may be given besides text: objects, and expressions of SymPy."""

import functools

import numpy as np
import sympy as sp

from cases import Curve, Load
from cases.effects import MOTION

from ..harness import Kind
from .values import ODD

FUNCTIONS = (
    sp.sin, sp.cos, sp.exp, sp.tanh, sp.atan, sp.Abs, sp.sign, sp.Heaviside, sp.erf, sp.gamma, sp.floor, sp.DiracDelta,
    sp.sec, sp.coth, sp.asinh, sp.acosh, sp.atanh, sp.csch, sp.LambertW, sp.re, sp.conjugate, sp.sinc, sp.Function("f"),
)  # fmt: skip


def expression(chance, v: sp.Symbol, depth: int = 3):
    """A random expression, some of it poison."""
    if depth == 0 or chance.random() < 0.2:
        numbers = (1, 2, sp.Rational(1, 3), 0.7, sp.Rational(-5, 7), sp.pi, sp.E, sp.I, 1e200, sp.Symbol("q"))
        return v if chance.random() < 0.6 else chance.choice(numbers[:7] if chance.random() < 0.9 else numbers)
    a = expression(chance, v, depth - 1)
    if chance.random() < 0.5:
        return chance.choice(FUNCTIONS[:5] if chance.random() < 0.7 else FUNCTIONS)(a)
    b = expression(chance, v, depth - 1)
    return chance.choice((lambda: a + b, lambda: a * b, lambda: a - b / 3, lambda: a ** sp.Rational(2, 3) * b))()


def of_curve(given):
    def call():
        made = Curve(lambda s: given, (0.2, 1.0))
        return made.structure, made.features

    return call


def draw(chance):
    if chance.random() < 0.3:
        given = chance.choice(ODD)
        return (
            (f"Load({given!r})", functools.partial(Load, given))
            if chance.random() < 0.5
            else (f"curve (s, {given!r})", functools.partial(Curve, lambda s: (s, given)))
        )
    if chance.random() < 0.5:
        v = chance.choice(MOTION)
        given = expression(chance, v)
        return f"Load({sp.srepr(given)})", functools.partial(Load, given)
    from cases.formulas.expressions import PARAMETER

    given = (PARAMETER, expression(chance, PARAMETER))
    return f"curve {given}", of_curve(given)


s = sp.Symbol("s", real=True)
SHAPES = (
    lambda s: s, lambda s: (s,), lambda s: (s, s, s), lambda s: None, lambda: (1, 2), lambda s: (s, 1 / 0),
    lambda s: (s, "s"), lambda s: (s, "__import__('os').system('false')"), lambda s: (s, np.array([1.0])),
    lambda s: (np.cos(s), s), lambda s: (0.0, 0.0), lambda s: (s**3, s**2), lambda s: (s, sp.Piecewise((0,
    s < 0), (s, True))),
    lambda s: (_ for _ in ()), lambda s: {1, 2}, lambda s: (True, False), lambda s: (s, sp.Abs(s)),
    lambda s: (s, sp.Heaviside(s - 0.3)), lambda s: (s, sp.atan(1 / (s - 0.0371))), lambda s: (s, sp.sqrt(s**2 - 1e-6)),
    lambda s: (sp.cos(s), sp.Symbol("t") * s), lambda s: ([s], [s]), lambda s: (s, sp.Integral(s, s)),
)  # fmt: skip
FOUND = (
    *((f"shape {i}", functools.partial(Curve, shape, (-1.0, 1.0))) for i, shape in enumerate(SHAPES)),
    ("Load of a list", functools.partial(Load, ["__import__('os').system('false')"])),
    ("Load of a dict", functools.partial(Load, {"__import__('os').system('false')": 1})),
    ("deep", lambda: Load(functools.reduce(lambda e, _: sp.sin(e), range(300), MOTION[0]))),
)
KIND = Kind("expressions", draw, 300, 30, FOUND)
