"""The paper's misprints are shown by residuals, and its claims judged for every size."""

from math import isnan, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cases
import reference
from cases import Case, CoulombFriction, Gravity, Mode, Start, Unilateral, disc
from cases.library import circle
from reference.errata import errata
from reference.paper.application import rolls_beyond, slip_end
from tests.authorities.paper_application import FIRST_TRANSITION
from tests.sampling import quick_every

ROWS = {row.where: row for row in errata()}
MISPRINTS = [row for row in ROWS.values() if isnan(row.claim)]


@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_corrected_formula_leaves_no_residual(row):
    # Rounding, but for the row that differentiates numerically with steps of 1e-6.
    assert row.corrected_residual < (1e-9 if row.where == "after (6)" else 1e-14)


@pytest.mark.parametrize("row", [row for row in MISPRINTS if row.where != "(20)"], ids=lambda row: row.where)
def test_printed_formula_leaves_a_large_residual_or_has_no_value(row):
    assert isnan(row.printed_residual) or row.printed_residual > 0.1


def test_claim_that_rolling_follows_holds_for_one_of_the_papers_three_coefficients():
    excess = {row.claim: row.printed_residual for row in ROWS.values() if not isnan(row.claim)}
    assert excess[0.01] > 1
    assert excess[0.1] > 0.5
    assert excess[0.2] == 0.0


# --- what the claim depends on ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("mu", FIRST_TRANSITION)
def test_unitless_35_meets_the_twenty_digit_values(mu):
    time, xi1, after = FIRST_TRANSITION[mu]
    end = slip_end(mu)
    # Of the tolerance 1e-12 the event's location leaves 1e-11.
    assert end.time * sqrt(0.9 / 9.81) == pytest.approx(time, rel=1e-11)
    assert end.xi1 == pytest.approx(xi1, rel=1e-11)
    assert (end.demand <= 1.0) == (after is Mode.ROLL)


sizes = st.floats(-3.0, 3.0).map(lambda power: 10.0**power)


@given(R=sizes, part=st.floats(0.02, 0.95), m=sizes, g=sizes, k=st.floats(0.05, 1.0), mu=st.floats(0.02, 0.5))
@settings(max_examples=25, deadline=None)
def test_where_the_slip_ends_and_what_follows_do_not_depend_on_sizes(R, part, m, g, k, mu):
    r = part * R
    unit, end = sqrt((R - r) / g), slip_end(mu, 0.0, k)
    effects = (Gravity(g, pi / 2), CoulombFriction(mu), Unilateral())
    case = Case(circle(R), disc(r, m, k * m * r * r), effects, Start(0.0), 1.01 * end.time * unit)
    first = reference.simulate(case, rtol=1e-12).transitions[0]
    assert first.time / unit == pytest.approx(end.time, rel=1e-10)
    assert first.xi1 == pytest.approx(end.xi1, rel=1e-10)
    if abs(end.demand - 1.0) > 1e-8:
        assert (first.after is Mode.ROLL) == (end.demand <= 1.0)


@quick_every(2)
@pytest.mark.parametrize("mu, bound", [(0.1, 0.629156), (0.01, 1.499867)])
def test_released_further_down_the_smaller_coefficients_roll_as_well(mu, bound):
    assert rolls_beyond(mu) == pytest.approx(bound, abs=1e-6)
    for side, after in ((-1e-4, Mode.SLIP_BACKWARD), (1e-4, Mode.ROLL)):
        case = cases.load("disc_in_circle", mu=mu, xi1=bound + side)
        assert reference.simulate(case, rtol=1e-12).transitions[0].after is after
    # One bound: reversal before it, rolling after it, down to where the disc does not slip at all.
    releases = np.linspace(0.0, np.arctan(1 / (3 * mu)) - 0.01 * mu, 40)
    rolls = [slip_end(mu, release).demand <= 1.0 for release in releases]
    assert rolls == [release > bound for release in releases]


@pytest.mark.slow
def test_closing_remark_more_friction_ends_the_slip_earlier_and_at_a_smaller_angle():
    # The paper compares 0.01 and 0.1 (its figures 3 to 6); 200 coefficients over four decades say the same.
    ends = [slip_end(mu) for mu in np.geomspace(1e-3, 10.0, 200)]
    assert all(np.diff([end.time for end in ends]) < 0.0)
    assert all(np.diff([end.xi1 for end in ends]) < 0.0)
