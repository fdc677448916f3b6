"""What is exported of a true motion: a file that is compared as the truth, and its steps as polynomials."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from numpy.polynomial.chebyshev import chebval

import cases
from reports import compare, export


def test_an_exported_box_is_compared(tmp_path):
    # Its outline has no single formula, which the list of laws broken asked for.
    case = cases.load("block_on_incline", slope=0.3, mu=0.2)
    export.export(case, tmp_path)
    text = compare.compare(case, tmp_path / "motion.csv")
    assert "excellent" in text and "Laws broken\nnone" in text


@pytest.mark.parametrize("label", ["disc_in_circle[mu=0.2]", "row_of_discs", "disc_between_belt_and_wall"])
def test_polynomials_of_the_exported_steps_are_the_motion(label, tmp_path):
    """Evaluated by NumPy's Chebyshev series alone; of both plates, and of closed contacts."""
    case = cases.load(label)
    export.export(case, tmp_path, points=11)
    steps, true = pd.read_csv(tmp_path / "motion_steps.csv"), export.true_motion(case)
    # A contact of impacts alone is never closed.
    assert {*true.plate_names} < {*steps["of"]} <= {*true.plate_names, *true.contact_names}
    for row in steps.sample(60, random_state=1).itertuples():
        t = row.start + (row.end - row.start) * 0.37
        value = chebval(2.0 * (t - row.start) / (row.end - row.start) - 1.0, np.array(row[5:]))
        state = true if row.of in true.plate_names else true.of(row.of)
        state = state.plate(row.of) if true.plate_columns is not None and row.of in true.plate_names else state
        assert value == pytest.approx(getattr(state(t), row.quantity), rel=1e-10, abs=1e-10), (row.of, row.quantity)
