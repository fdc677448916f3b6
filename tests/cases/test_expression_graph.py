"""Recorded expressions have the values and derivatives of SymPy's, and cost no more operations than are needed."""

from math import pi

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from cases import BadValue
from cases.curves import parametrisation
from cases.formulas import features
from cases.formulas.expression_code import ON_ARRAYS, ON_FLOATS, python_function
from cases.formulas.expression_graph import derivatives, from_sympy, symbol
from cases.formulas.expressions import PARAMETER
from cases.formulas.formula_text import parse
from tests.scenes.elliptic import examples

S, C = PARAMETER, sp.Symbol("c0", positive=True)
s, c = symbol("s"), symbol("c0")

FORMULAS = st.recursive(
    st.sampled_from([S, C, sp.Integer(2), sp.Rational(1, 3), sp.Rational(-3, 4), sp.pi, sp.sqrt(2)]),
    lambda inner: st.one_of(
        st.builds(lambda a, b: a + b, inner, inner),
        st.builds(lambda a, b: a * b, inner, inner),
        st.builds(lambda a, b: a / (2 + b**2), inner, inner),
        st.builds(lambda a, p: (1 + a**2) ** p, inner, st.sampled_from([2, 3, -1, sp.Rational(1, 2), C])),
        st.builds(
            lambda f, a: f(a), st.sampled_from([sp.sin, sp.cos, sp.tanh, sp.atan, lambda u: sp.exp(-(u**2))]), inner
        ),
    ),
    max_leaves=8,
)


@given(formula=FORMULAS, at=st.floats(-2.0, 2.0), size=st.floats(0.1, 2.0))
@examples(40, 150)
def test_values_and_derivatives_are_those_of_sympy_to_rounding(formula, at, size):
    rows, exact = [from_sympy(formula)], [formula]
    for _ in range(3):
        rows += derivatives(rows[-1:], s)
        exact.append(sp.diff(exact[-1], S))
    for functions, argument in ((ON_FLOATS, at), (ON_ARRAYS, np.array([at]))):
        values = python_function([s, [c]], rows, functions)(argument, (size,))
        with mpmath.workdps(40):
            for value, expression in zip(values, exact, strict=True):
                precise = sp.N(expression.subs({S: sp.Float(at, 40), C: sp.Float(size, 40)}), 30)
                # Terms of a derivative may cancel; none of these formulas has terms above 1e6.
                assert abs(float(np.ravel(value)[0]) - float(precise)) <= 1e-9 * (1.0 + abs(float(precise)))


def formula(text):
    return from_sympy(parse(text, {"s": PARAMETER}, "a formula", BadValue))


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("exp(-((s - 0.3)/1e-6)**2)", {0.3}),
        ("tanh((s + 2)/0.01)", {-2.0}),
        ("1/(1e-4 + (s - 0.7)**2)", {0.7}),
        ("1/(s - 0.25)**2", {0.25}),
        ("s/((s - 1)*(s + 3))", {-3.0, 1.0}),
        ("sqrt(s**2 - 4)", {-2.0, 0.0, 2.0}),
        ("log(3 - s)*sin(2*s)", {3.0}),
        ("cos(s**2 - s)", {0.0, 0.5, 1.0}),
        ("s**2 + sin(s)", set()),
    ],
)
def test_special_points_are_zeros_and_extremes_of_arguments(text, places):
    assert {round(place, 9) for place in features.centres([formula(text)], s)} == places


@pytest.mark.parametrize(
    ("text", "period"),
    [
        ("sin(2*s)*cos(3*s)", 2 * pi),
        ("cos(s/3 + 0.2*sin(s/3))", 6 * pi),
        ("1/(2 + sin(pi*s))", 2.0),
        ("tan(s*0.5 - s/4)", 8 * pi),
        ("s + sin(s)", None),
        ("sin(s)*exp(s)", None),
        ("sin(s)*cos(sqrt(2)*s)", None),
        ("s/(2 + cos(s))", None),
    ],
)
def test_a_period_is_read_off_a_formula(text, period):
    assert parametrisation.period([formula(text)]) == (period and pytest.approx(period, rel=1e-14))
