"""Exact solutions against outside figures, and the reference against exact solutions, by both integrators."""

from functools import lru_cache

import mpmath as mp
import pytest

import cases
import reference
from reference.paper import closed_form
from tests.authorities.paper_application import FIRST_TRANSITION


@pytest.mark.slow
@pytest.mark.parametrize("mu", FIRST_TRANSITION)
def test_quadrature_reproduces_the_published_digits(mu):
    time, xi1, after = FIRST_TRANSITION[mu]
    # Decimal sizes here, binary ones in the solver: they differ by 1e-17.
    found = closed_form.sliding_disc_in_circle("1", "0.1", str(mu), "9.81")
    assert abs(found.time - mp.mpf(time)) < 1e-15
    assert abs(found.xi1 - mp.mpf(xi1)) < 1e-15
    assert found.after is after


@lru_cache
def quadrature(mu: float) -> closed_form.FirstZero:
    """Of a disc of 0.25 m in a circle of 1.5 m; once for all methods, as it takes seconds."""
    return closed_form.sliding_disc_in_circle(1.5, 0.25, mu, 9.81, digits=16)


@pytest.mark.slow
@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("mu", [0.03, 0.15, 0.4])
def test_first_transition_of_other_sliding_discs_is_the_quadratures(mu, method, accuracy):
    case = cases.load("disc_in_circle", R=1.5, r=0.25, mu=mu)
    exact = quadrature(mu)
    first = reference.simulate(case, rtol=1e-14, method=method).transitions[0]
    accuracy(
        case=case.label, solver="reference", route=method, quantity="first transition / s",
        error=float(mp.mpf(first.time) - exact.time),
        # Taylor: a few units in the last place of one second; DOP853: its own bound of 1e-13, accumulated.
        tolerance=1e-14 if method == "taylor" else 1e-12,
    )  # fmt: skip
    assert first.after is exact.after
