"""What people, files and programs put where a number or an object belongs, in one place or in several at once."""

import functools
from decimal import Decimal
from fractions import Fraction
from math import inf, nan

import numpy as np
import sympy as sp

import cases
from cases import (
    Belt,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    RollingResistance,
    Unilateral,
)
from tests.scenes.public_calls import CALLS

from ..harness import Kind

# Some of it is a number.
ODD = (
    None, True, False, nan, inf, -inf, 0, 0.0, -0.0, -1, 1, 0.3, 1e308, -1e308, 5e-324, 1e-300, 1e150, 1e12, 10**400,
    "", "0.3", "abc", "nan", b"0.3", [], [1.0], {}, (1.0, 2.0), set(), np.array([]), np.array([1.0]),
    np.array([[1.0, 2.0]]), np.float32(0.3), np.float64(nan), np.int64(2), 1j, Decimal("0.3"), Fraction(1, 3),
    sp.Symbol("s"), sp.pi, sp.nan, object(), int, len, lambda s: s, float("1e-17"), "a" * 5000, "été", "1;2", "\n",
    "a\0b", "~nosuchuser", "\ud800", 2**63, sp.Matrix([[1]]), sp.true, sp.zoo, range(3),
    "__import__('os').system('false')", ["__import__('os').system('false')"],
)  # fmt: skip

EFFECTS = (
    Gravity(1.0), CoulombFriction(0.1), Unilateral(), Unilateral, Flight(), Impact(0.5), PerfectlyRough(),
    RollingResistance(0.1), Load(1.0), Belt(0.5), Drive("sin(t)"),
)  # fmt: skip


def draw(chance):
    name = chance.choice(sorted(CALLS))
    make, right = CALLS[name]
    several = chance.random() < 0.4
    wrong = [key for key in right if chance.random() < 0.5] if several else [chance.choice(sorted(right))]
    given = right | {key: chance.choice(ODD) for key in wrong}
    if name == "Case" and chance.random() < 0.4:
        given["effects"] = [chance.choice((*ODD, *EFFECTS, *EFFECTS, *EFFECTS)) for _ in range(chance.randint(0, 4))]
    return f"{name}({given!r})", functools.partial(make, **given)


FOUND = (
    ("load(None)", lambda: cases.load(None)),
    ("load('a' * 5000)", lambda: cases.load("a" * 5000)),
    ("mu='x'", lambda: cases.load("disc_in_circle", mu="x")),
    ("load_file('x' * 5000)", lambda: cases.load_file("x" * 5000 + ".py")),
    ("spline('/proc/self/mem')", lambda: Curve.spline("/proc/self/mem")),
    ("spline('~nosuchuser/a.csv')", lambda: Curve.spline("~nosuchuser/a.csv")),
)
KIND = Kind("values", draw, 1200, 80, FOUND)
