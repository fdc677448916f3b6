"""Formulas through samples: the functions they come from, their integrals, and scenes with them."""

from math import exp, sin

import numpy as np
import pytest
import sympy as sp

import reference
from cases import BadValue, Belt, CoulombFriction, Drive, Load, fit_friction, fit_waves
from cases.formulas.effect_formulas import formula_in
from cases.moving_surface import TIME
from tests.scenes.moving import on_line
from tests.scenes.slip_laws import sliding_disc

T = np.linspace(0.0, 2.0, 401)
V = np.linspace(0.0, 2.0, 41)


def test_a_record_is_fitted_within_its_tolerance_and_with_fewer_terms_where_that_is_larger():
    values = 8.0 * np.sin(9.0 * T) * np.exp(-T)
    coarse, fine = (fit_waves(T, values, within) for within in (0.1, 1e-5))
    for formula, within in ((coarse, 0.1), (fine, 1e-5)):
        function = sp.lambdify(TIME, formula_in((TIME,), "fit", formula))
        assert np.max(np.abs(function(T) - values)) <= within
    assert coarse.count("cos") < fine.count("cos")
    assert float(fit_waves(T, np.full(401, 0.3), 1e-12)) == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize("integrals", [1, 2])
def test_integrals_begin_at_zero(integrals):
    """∫ sin(3 t) = (1 − cos 3t)/3, and again t/3 − sin(3 t)/9."""
    formula = formula_in((TIME,), "fit", fit_waves(T, np.sin(3.0 * T), 1e-6, integrals))
    exact = {1: (1.0 - np.cos(3.0 * T)) / 3.0, 2: T / 3.0 - np.sin(3.0 * T) / 9.0}[integrals]
    assert sp.lambdify(TIME, formula)(T) == pytest.approx(exact, abs=1e-6 * T[-1] ** integrals)
    assert abs(formula.subs(TIME, 0.0)) < 1e-12


def test_a_belt_of_samples_carries_a_disc_as_the_belt_of_its_formula_does():
    speed = "0.8 + 0.5*sin(3*t)"
    samples = [0.8 + 0.5 * sin(3.0 * t) for t in T]
    exact, other = (reference.simulate(on_line(Belt(s), slip=-0.8)) for s in (speed, fit_waves(T, samples, 1e-6)))
    assert [t.after for t in other.transitions] == [t.after for t in exact.transitions]
    # The slip closes with 3 μ g − 1.5 m/s² and more, so that 1e-6 m/s of it take less than 1e-6 s.
    assert other.transitions[0].time == pytest.approx(exact.transitions[0].time, abs=1e-6)


def test_a_stribeck_curve_is_found_again_from_its_samples():
    """One decay has three factors and its speed, so that the formula of the samples is that of the law."""
    table = [0.1 + 0.1 * exp(-v / 0.05) + 0.02 * v for v in V]
    exact, other = (
        reference.simulate(sliding_disc(mu)) for mu in ("0.1 + 0.1*exp(-v/0.05) + 0.02*v", fit_friction(V, table, 1e-6))
    )
    assert other.transitions[0].time == pytest.approx(exact.transitions[0].time, abs=1e-10)


@pytest.mark.parametrize(
    "curve", [0.3 + 0.0 * V, 0.2 + 0.1 * V * np.exp(-V / 0.5), 0.4 - 0.1 * np.tanh(V / 0.3), 0.3 / (1.0 + V)]
)
def test_a_friction_curve_is_fitted_within_its_tolerance_and_can_be_used(curve):
    law = CoulombFriction(fit_friction(V, curve, 2e-3))
    assert [law.at(float(v)) for v in V] == pytest.approx(curve, abs=2e-3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: fit_waves(T, np.sin(200.0 * T), 0.1), "with frequencies up to"),
        (lambda: fit_friction(V, 0.3 + 0.1 * np.sin(20.0 * V), 1e-3), "with 4 decays it is"),
        (lambda: fit_waves(T, T[1:], 0.1), "t has 401 numbers, values 400"),
        (lambda: fit_waves(T[::-1], T, 0.1), "t does not increase"),
        (lambda: fit_waves(T, np.full(401, np.nan), 0.1), "holds NaN"),
        (lambda: fit_waves(T, ["fast"] * 401, 0.1), "other than numbers"),
        (lambda: fit_waves(T, T, 0.0), "within is 0"),
        (lambda: fit_waves(T, T, 0.1, 3), "integrals is 3"),
        (lambda: fit_friction(V - 1.0, V, 0.1), "not negative"),
    ],
)
def test_samples_that_cannot_be_fitted_get_one_line(make, words):
    with pytest.raises(BadValue, match=words) as output:
        make()
    assert "\n" not in str(output.value)


@pytest.mark.parametrize("value", [np.sin, lambda t: 0.1, V, V.tolist(), (T, T), {"t": 1.0}, None])
@pytest.mark.parametrize(
    ("make", "words"),
    [
        (Belt, r"speed of Belt is \w+; give a number, or a formula in t as text, such as .*fit_waves"),
        (lambda x: Drive(x=x), r"x of Drive is \w+; give .*fit_waves"),
        (lambda fx: Load(fx=fx), r"fx of Load is \w+; give .*in t, x, y, theta, vx, vy, omega as text.*fit_waves"),
        (CoulombFriction, r"mu of CoulombFriction is \w+; give .*in v, the slip speed, as text.*fit_friction"),
    ],
)
def test_samples_and_functions_are_rejected_with_what_to_type_instead(make, words, value):
    with pytest.raises(BadValue, match=words) as output:
        make(value)
    assert "\n" not in str(output.value) and len(str(output.value)) < 250
