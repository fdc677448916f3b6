"""Taylor series with bounds on their rounding."""

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cases
from reference.minimal import series
from reference.minimal.modes import candidates, phase
from reference.minimal.series import Series
from reference.minimal.system import EXPANSIONS, QUICK
from tests.sampling import quick_every
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


@quick_every(4, first=2)
@pytest.mark.parametrize("name", ["disc_in_circle", "disc_on_line", "ellipse_in_circle", "disc_in_cosine"])
@given(values=st.lists(numbers(-1.5, 1.5), min_size=4, max_size=4), time=numbers(0.0, 3.0))
@settings(max_examples=25, deadline=None)
def test_the_written_function_has_the_bits_of_the_expansion(name, values, time):
    # The first decisions of a system expand, later ones call the function: a motion must not depend on what ran before.
    case = cases.load(name)
    for regime in candidates(case):
        candidate = phase(case, regime)
        system, y = candidate.system, values[: len(candidate.system.variables)]
        if system._quick_series is None:
            continue
        bounds = [1e-16 * abs(value) for value in y]
        system._expansions = 0
        ran = [system.condition_series(time, y, bounds, candidate.parameters, QUICK) for _ in range(EXPANSIONS + 1)]
        assert [_bits(value) for value in ran[0]] == [_bits(value) for value in ran[-1]]


def _bits(value) -> list[str]:
    numbers = [*value.c, *value.e] if isinstance(value, Series) else [value]
    return [float(number).hex() for number in numbers]
