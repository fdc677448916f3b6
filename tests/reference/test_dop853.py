"""DOP853's search for the zeros of guards, on guards that are given by a formula."""

import pytest

import cases
import reference


@pytest.mark.parametrize("rtol", [pytest.param(1e-6, marks=pytest.mark.slow), 1e-9])
def test_a_zero_at_which_other_guards_have_no_value_is_located(rtol):
    """Where the curvatures are equal, the forces are quotients by zero; the search raised an error of SciPy's."""
    motion = reference.simulate(cases.load("disc_rocking_in_groove"), rtol=rtol, method="dop853")
    assert motion.status == "completed" and len(motion.transitions) == 8
