"""What people, files and programs put where a number or an object belongs, in one place or in several at once."""

import functools
from decimal import Decimal
from fractions import Fraction
from math import inf, nan, pi

import numpy as np
import sympy as sp

import cases
import reference
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
    library,
)

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

CIRCLE, DISC = library.circle(1.0), disc(0.1, 1.0)
EFFECTS = (
    Gravity(1.0), CoulombFriction(0.1), Unilateral(), Unilateral, Flight(), Impact(0.5), PerfectlyRough(),
    RollingResistance(0.1), Load(1.0), Belt(0.5), Drive("sin(t)"),
)  # fmt: skip

# Whatever is made by a call, with a right value for each argument.
MAKERS = {
    "Gravity": (Gravity, dict(g=9.81, direction=-pi / 2)),
    "CoulombFriction": (CoulombFriction, dict(mu=0.2, mu_static=0.3)),
    "RollingResistance": (RollingResistance, dict(arm=0.01)),
    "Impact": (Impact, dict(restitution=0.5, law="poisson")),
    "Belt": (Belt, dict(speed="1+sin(t)")),
    "Drive": (Drive, dict(x="sin(t)", y=0.0, angle="t")),
    "Load": (Load, dict(fx="sin(t)", fy=1.0, moment=0.0)),
    "Start": (Start, dict(xi1=0.1, xi2=0.0, slip=0.0, omega=1.0, gap=0.0, gap_rate=0.0)),
    "disc": (disc, dict(radius=0.1, mass=1.0, inertia=0.005)),
    "Plate": (Plate, dict(outline=CIRCLE, mass=1.0, inertia=1.0)),
    "Case": (
        Case,
        dict(
            track=CIRCLE,
            plate=DISC,
            effects=(Gravity(9.81),),
            start=Start(0.1),
            duration=1.0,
            name="mine",
            parameters={},
        ),
    ),
    "Curve": (Curve, dict(function=lambda s: (s, s**2), domain=(-1.0, 1.0))),
    "Curve.spline": (
        Curve.spline,
        dict(
            points=[(0.1 * i, 0.01 * i * i) for i in range(12)], smoothing=0.0, closed=False, scale=1.0, may_cross=False
        ),
    ),
    "simulate": (
        reference.simulate,
        dict(case=Case(CIRCLE, DISC, (Gravity(9.81),), Start(0.1), 0.1), rtol=1e-6, method=None),
    ),
    "line": (library.line, dict(slope=0.1)),
    "circle": (library.circle, dict(radius=1.0)),
    "ellipse": (library.ellipse, dict(a=1.0, b=0.5)),
    "parabola": (library.parabola, dict(focus=0.4, reach=3.0)),
    "cosine": (library.cosine, dict(depth=0.3, wavenumber=2.0, reach=3.0)),
    "cycloid": (library.cycloid, dict(a=0.25, offset=0.1)),
    "trochoid": (library.trochoid, dict(a=0.5, arm=0.3, arches=2)),
    "superellipse": (library.superellipse, dict(a=0.2, b=0.1, exponent=4)),
    "logarithmic_spiral": (library.logarithmic_spiral, dict(start=0.1, growth=0.2, turns=0.5)),
    "rounded_polygon": (library.rounded_polygon, dict(radius=0.1, corners=3, sharpness=0.5)),
    "load": (cases.load, dict(name="disc_in_circle", mu=0.2)),
    "select": (cases.select, dict(text="disc_in_circle[mu=0.2]")),
    "entry": (cases.entry, dict(name="disc_in_circle")),
    "load_file": (cases.load_file, dict(path="nowhere.py")),
}


def draw(chance):
    name = chance.choice(sorted(MAKERS))
    make, right = MAKERS[name]
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
