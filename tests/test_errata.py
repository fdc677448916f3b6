"""The paper's misprints are shown by residuals."""

from math import isnan

import pytest

from reference.errata import errata

ROWS = errata()


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.where)
def test_corrected_formula_leaves_no_residual(row):
    # Rounding, but for the row that differentiates numerically with steps of 1e-6.
    assert row.corrected_residual < (1e-9 if row.where == "after (6)" else 1e-14)


@pytest.mark.parametrize("row", [row for row in ROWS if "μ₀" not in row.where], ids=lambda row: row.where)
def test_printed_formula_leaves_a_large_residual_or_has_no_value(row):
    assert isnan(row.printed_residual) or row.printed_residual > 0.1


def test_claim_that_rolling_follows_holds_for_one_of_the_papers_three_coefficients():
    excess = {row.where.rpartition("= ")[2]: row.printed_residual for row in ROWS if "μ₀" in row.where}
    assert excess["0.01"] > 1
    assert excess["0.1"] > 0.5
    assert excess["0.2"] == 0.0
