"""Parts of the equations that depend on parameters alone: on floats they have the bits that they have on arrays."""

from types import SimpleNamespace

import numpy as np
import pytest

import cases
from cases.formulas.expression_graph import call, sqrt, symbol
from reference.minimal.assembly import _constants
from reference.minimal.modes import candidates, phase
from reference.minimal.system import System


def system_of(expression) -> SimpleNamespace:
    """The part of a system that computes one constant of the parameters a and b."""
    names, constants = ("a", "b"), (expression,)
    some = SimpleNamespace(names=names, constants=constants, parameters=(symbol("a"), symbol("b"), expression))
    for name in ("constants_of_numbers", "constants_of_arrays"):
        setattr(some, name, getattr(System, name)._make(some))
    return some


A, B = symbol("a"), symbol("b")


@pytest.mark.parametrize("name", ["disc_in_circle", "ellipse_in_circle", "disc_in_cosine", "disc_off_ramp"])
def test_constants_of_a_case_have_the_bits_of_those_on_arrays(name):
    case = cases.load(name)
    for regime in candidates(case):
        now = phase(case, regime)
        given = [np.array([value]) for value in now.parameters[: len(now.system.names)]]
        assert now.system.constants and now.system.constants_of_numbers is not None
        constants = [float(np.broadcast_to(v, 1)[0]) for v in now.system.constants_of_arrays(given)]
        assert list(now.parameters[len(given) :]) == constants


def test_functions_are_numpys_whose_last_digit_may_differ():
    some = system_of(call("sin", A) * B)
    assert some.constants_of_numbers is None
    for a in np.random.default_rng(1).uniform(-10.0, 10.0, 100).tolist():
        assert list(_constants(some, [a, 3.0])) == [float(np.sin(np.float64(a)) * 3.0)]


@pytest.mark.parametrize(("expression", "value"), [(1 / A, np.inf), (sqrt(A - B), np.nan), ((B * 1e200) ** 2, np.inf)])
def test_a_constant_without_a_value_is_the_one_on_arrays(expression, value):
    some = system_of(expression)
    assert some.constants_of_numbers is not None
    assert list(_constants(some, [0.0, 1.0])) == pytest.approx([value], nan_ok=True)
