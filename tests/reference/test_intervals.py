"""Bounds by interval arithmetic hold wherever a formula is looked at, and are narrow where the interval is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cases
from cases import Chain, Curve
from cases.curves import curve_pieces as pieces
from cases.curves.curve_pieces import piece_bounds
from cases.formulas.intervals import Interval, bounds
from tests.sampling import quick_every

INSIDE = np.linspace(0.0, 1.0, 41)[:, None]

# Functions of one variable that a curve's formula may call, each where it has a value.
FUNCTIONS = {
    "sin": (np.sin, -9, 9), "cos": (np.cos, -9, 9), "tan": (np.tan, -1.5, 1.5), "exp": (np.exp, -6, 6),
    "log": (np.log, 0.01, 6), "sqrt": (np.sqrt, 0, 6), "atan": (np.arctan, -6, 6), "asin": (np.arcsin, -1, 1),
    "acos": (np.arccos, -1, 1), "sinh": (np.sinh, -6, 6), "cosh": (np.cosh, -6, 6), "tanh": (np.tanh, -6, 6),
    "square": (lambda s: s**2, -6, 6), "cube": (lambda s: s**3, -6, 6), "inverse": (lambda s: 1 / s, 0.01, 6),
    "inverse square": (lambda s: s**-2, 0.01, 6), "root of a cube": (lambda s: s**1.5, 0, 6),
    "power of two": (lambda s: 2.0**s, -6, 6), "sum": (lambda s: 1.0 - s + 2.0 * s, -6, 6),
    "product": (lambda s: np.sin(s) * (s - 3.0) / (s * s + 0.1), -6, 6), "absolute": (np.abs, -6, 6),
}  # fmt: skip


@quick_every(2)
@settings(max_examples=30, deadline=None, derandomize=True)
@given(ends=st.lists(st.floats(0.0, 1.0), min_size=2, max_size=12))
@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_stays_within_its_bounds(name, ends):
    function, low, high = FUNCTIONS[name]
    a, b = np.sort(low + (high - low) * np.resize(ends, (2, len(ends) // 2)), axis=0)
    with np.errstate(all="ignore"):
        found = bounds(function(Interval(a, b)), a)
        values = function(a + INSIDE * (b - a))
    rounding = 1e-14 * np.abs(values).max(axis=0)
    assert np.all(found.low <= values.min(axis=0) + rounding)
    assert np.all(values.max(axis=0) - rounding <= found.high)


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name != "absolute"])
def test_bounds_are_as_narrow_as_their_interval(name):
    function, low, high = FUNCTIONS[name]
    a = low + (high - low) * np.array([0.21, 0.47, 0.83])
    widths = []
    for wide in (1e-3, 1e-4):
        found = bounds(function(Interval(a, a + wide)), a)
        widths.append(found.high - found.low)
    assert np.all(widths[0] < 0.3) and np.all(widths[1] <= 0.2 * widths[0])


def curves() -> dict[str, Curve]:
    found = {
        "ripples": Curve(("s", "1e-6*sin(2513.27*s)")),
        "lobes": Curve(("(0.1+1e-4*cos(100*s))*cos(s)", "(0.1+1e-4*cos(100*s))*sin(s)")),
        "bump": Curve(("s", "exp(-(s/0.01)**2)"), (-3, 3)),
    }
    for name in cases.names():
        case = cases.select(name)[0]
        both = {f"{name}: track": case.track, f"{name}: outline": case.plate.outline}
        found |= {key: curve for key, curve in both.items() if not isinstance(curve, Chain)}  # it has no one formula
    return found


CURVES = curves()


@quick_every(5)
@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("count", [7, 300])
def test_a_curve_stays_within_the_bounds_of_its_pieces(name, count):
    curve = CURVES[name]
    edges = np.linspace(*curve.span, count + 1)
    table = piece_bounds(curve, edges[:-1], edges[1:])
    s = table[pieces.LOW] + INSIDE * (table[pieces.HIGH] - table[pieces.LOW])
    x, y, xp, yp, xs, ys, _, _ = curve.jets(s.ravel()).reshape(8, *s.shape)
    dx, dy, tx, ty = (
        x - table[pieces.X],
        y - table[pieces.Y],
        table[pieces.TX],
        table[pieces.TY],
    )
    along, across = dx * tx + dy * ty, dy * tx - dx * ty
    turn = np.abs(np.arctan2(yp * tx - xp * ty, xp * tx + yp * ty))
    bend = (xp * ys - yp * xs) / np.hypot(xp, yp) ** 3
    size, bent = 1e-13 * (1.0 + np.abs(x) + np.abs(y)), 1e-9 * (1.0 + np.abs(bend))
    assert np.all(table[pieces.BACK] - size <= along) and np.all(along <= table[pieces.AHEAD] + size)
    assert np.all(table[pieces.BELOW] - size <= across) and np.all(across <= table[pieces.ABOVE] + size)
    assert np.all(np.hypot(along, across) <= table[pieces.REACH] + size)
    assert np.all(turn <= table[pieces.TURN] + 1e-9)
    assert np.all(table[pieces.BEND_LOW] - bent <= bend) and np.all(bend <= table[pieces.BEND_HIGH] + bent)
