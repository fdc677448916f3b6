"""Formulas through samples: the functions they come from, their integrals, and scenes with them."""

from math import exp

import numpy as np
import pytest
import sympy as sp

import reference
from cases import CoulombFriction, fit_friction, fit_waves
from cases.formulas.effect_formulas import formula_in
from cases.moving_surface import TIME
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
