"""DOP853's search for the zeros of guards, on guards that are given by a formula."""

from types import SimpleNamespace

import numpy as np
import pytest

import cases
import reference
from reference.minimal.integrators import step_zeros


def step_with_guard(guard):
    """A step of the variable y = t from 0 to 1 s, and a phase with that one guard of it."""
    piece = SimpleNamespace(t_old=0.0, t=1.0, h=1.0, y_old=np.zeros(1), F=np.array([[1.0], *[[0.0]] * 6]))
    system = SimpleNamespace(guards={"slip": None}, guards_of_numbers=lambda t, y, parameters: (guard(y[0]),))
    return SimpleNamespace(system=system, parameters=()), piece


def test_a_dip_that_begins_below_zero_is_located_at_its_beginning():
    """The interpolation is positive where the guard is below zero by a rounding; that was an error."""
    edge, lowest = 63, 64
    begins = float(step_zeros.FINE[edge])
    phase, piece = step_with_guard(lambda y: (y - begins) * (y - begins - 1e-3) - 1e-30)
    interpolated = np.full(len(step_zeros.FINE), 1e-20)
    interpolated[lowest] = 1e-21
    assert step_zeros._zero_of_one(phase, piece, 0, interpolated, first=False) == begins


@pytest.mark.parametrize("rtol", [pytest.param(1e-6, marks=pytest.mark.slow), 1e-9])
def test_a_zero_at_which_other_guards_have_no_value_is_located(rtol):
    """Where the curvatures are equal, the forces are quotients by zero; the search raised an error of SciPy's."""
    motion = reference.simulate(cases.load("disc_rocking_in_groove"), rtol=rtol, method="dop853")
    assert motion.status == "completed" and len(motion.transitions) == 8
