"""The reference against exact values."""

import numpy as np
import pytest

import cases
import reference
from cases import Mode
from tests.authorities.paper_application import FIRST_TRANSITION, SEQUENCE

# DOP853's own bound is 1e-13 relative, accumulated over some dozens of steps; the Taylor method's is rounding.
METHOD_TOLERANCE = {"dop853": 1e-12, "taylor": 1e-14}


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("mu", FIRST_TRANSITION)
def test_first_zero_of_slip_in_the_papers_application_is_exact(mu, method, accuracy):
    time, xi1, follows = FIRST_TRANSITION[mu]
    case = cases.load("disc_in_circle", mu=mu)
    first = reference.simulate(case, rtol=1e-14, method=method).transitions[0]
    common = dict(case=case.label, solver="reference", route=method, tolerance=METHOD_TOLERANCE[method])
    accuracy(**common, quantity="first transition / s", error=first.time - time)
    accuracy(**common, quantity="xi1 there / rad", error=first.xi1 - xi1)
    assert first.before is Mode.SLIP_FORWARD
    assert first.after is follows


def test_sequence_after_the_first_roll_agrees_with_an_independent_solve():
    motion = reference.simulate(cases.load("disc_in_circle", mu=0.2))
    assert [t.after for t in motion.transitions] == [mode for _, mode in SEQUENCE]
    # The independent values are printed to six decimals.
    assert [t.time for t in motion.transitions] == pytest.approx([time for time, _ in SEQUENCE], abs=6e-7)


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize(("v0", "mu"), [(0.5, 0.05), (2.0, 0.1), (1.0, 0.3)])
def test_bowling_disc_rolls_after_v0_over_three_mu_g(mu, v0, method, accuracy):
    case = cases.load("disc_on_line", v0=v0, mu=mu)
    motion = reference.simulate(case, method=method)
    exact = v0 / (3 * mu * 9.81)
    transition = motion.transitions[0]
    assert (transition.before, transition.after) == (Mode.SLIP_FORWARD, Mode.ROLL)
    accuracy(
        case=case.label, solver="reference", route=method, quantity="first transition / s",
        error=transition.time - exact, tolerance=METHOD_TOLERANCE[method],
    )  # fmt: skip
    assert motion(case.duration).vx == pytest.approx(2 * v0 / 3, rel=1e-12)


def test_error_falls_with_the_tolerance_at_the_order_of_the_method():
    time = FIRST_TRANSITION[0.2][0]
    case = cases.load("disc_in_circle", mu=0.2)
    tolerances = np.array([1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
    errors = [abs(reference.simulate(case, rtol, "dop853").transitions[0].time - time) for rtol in tolerances]
    # Errors proportional to the tolerance: a method of its nominal order under step-size control.
    slope = np.polyfit(np.log10(tolerances), np.log10(np.maximum(errors, 1e-16)), 1)[0]
    assert 0.75 < slope < 1.3
