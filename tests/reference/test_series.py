"""Taylor series with bounds on their rounding."""

import math
import pickle

import mpmath
import pytest
from hypothesis import given, settings

import cases
from reference.minimal import series, series_code
from reference.minimal.modes import candidates, phase, start_state, state_in
from reference.minimal.series import Series
from tests.scenes.elliptic import numbers

FUNCTIONS = {
    "sin": (series.sin, mpmath.sin), "cos": (series.cos, mpmath.cos), "exp": (series.exp, mpmath.exp),
    "log": (series.log, mpmath.log), "sqrt": (series.sqrt, mpmath.sqrt), "atan": (series.atan, mpmath.atan),
    "sinh": (series.sinh, mpmath.sinh), "cosh": (series.cosh, mpmath.cosh), "tan": (series.tan, mpmath.tan),
    "cube": (lambda x: x**3, lambda x: x**3), "inverse": (lambda x: 1 / x, lambda x: 1 / x),
    "power": (lambda x: x**-1.5, lambda x: x ** mpmath.mpf(-1.5)),
}  # fmt: skip


@pytest.mark.parametrize("name", FUNCTIONS)
@given(a=numbers(0.3, 1.2), b=numbers(-1.0, 1.0), c=numbers(-1.0, 1.0))
@settings(max_examples=15, deadline=None)
def test_coefficients_agree_with_high_precision_derivatives_within_their_own_bounds(name, a, b, c):
    ours, theirs = FUNCTIONS[name]
    result = ours(Series([a, b, c, 0.0], [0.0] * 4))
    with mpmath.workdps(50):
        exact = mpmath.taylor(lambda t: theirs(a + b * t + c * t * t), 0, 3)
        for k in range(4):
            # Numerical differentiation at 50 digits is exact to far below double rounding.
            assert abs(mpmath.mpf(result.c[k]) - exact[k]) <= result.e[k] + mpmath.mpf(10) ** -20
            assert result.e[k] <= 1e-12 * (1 + abs(result.c[k])) * 10**k


def test_a_motion_is_expanded_order_by_order():
    def pendulum(_, y):
        return [y[1], -series.sin(y[0])]

    angle = series.along(pendulum, [0.5, 0.0], [0.0, 0.0], 4)[0]
    s, c = math.sin(0.5), math.cos(0.5)
    assert angle.c == pytest.approx([0.5, 0.0, -s / 2, 0.0, s * c / 24], abs=1e-15)


def test_leading_sign_ignores_what_is_below_its_error():
    assert Series([1e-18, -2.0], [1e-16, 1e-15]).leading() == (-1, 1)
    assert Series([0.0, 0.0], [0.0, 0.0]).leading() == (0, 2)


@pytest.mark.parametrize("name", [name for name, known in series.FUNCTIONS.items() if callable(known)])
def test_functions_travel_to_another_process_by_their_names(name):
    # What is compiled for series is kept on disk, and names them.
    assert pickle.loads(pickle.dumps(series.FUNCTIONS[name])) is series.FUNCTIONS[name]


@pytest.mark.parametrize("name", ["disc_in_circle", "eccentric_disc_on_line", "disc_on_spring"])
def test_compiled_series_are_those_of_python_within_both_bounds(name):
    pytest.importorskip("heyoka")
    case = cases.load(name)
    for now in (phase(case, regime) for regime in candidates(case)):
        compiled = series_code.compile_series(now.system, 2)
        y = [value + 0.1 for value in state_in(now, start_state(case))]
        bounds = [1e-12 * (k + 1) for k in range(len(y))]
        told = compiled(0.3, y, bounds, now.parameters)
        _, known = now.system.expand(0.3, y, bounds, now.parameters, 2)
        assert len(told) == len(known)
        for ours, theirs in zip(told, known, strict=True):
            if not isinstance(theirs, Series):
                theirs = Series([theirs, 0.0, 0.0], [0.0] * 3)  # a constant
            assert all(abs(a - b) <= e for a, b, e in zip(ours.c, theirs.c, theirs.e, strict=True))
            # The bounds themselves are sums of a few hundred terms of one sign.
            assert ours.e == pytest.approx(theirs.e, rel=1e-12)


def test_series_of_large_equations_are_not_compiled():
    # A superellipse's third of a second would be won back by a thousand motions.
    case = cases.load("superellipse_on_hill")
    assert all(series_code.compile_series(phase(case, r).system, 2) is None for r in candidates(case))
