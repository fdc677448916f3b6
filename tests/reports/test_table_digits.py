"""Digits of the numbers in tables."""

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.page.table_files import with_short_numbers


@given(st.floats(1e-300, 1e300))
def test_an_error_bar_has_four_digits_and_is_never_smaller(bar):
    short = with_short_numbers(pd.DataFrame({"truth_error_bar": [bar]}))["truth_error_bar"][0]
    assert bar <= short == pytest.approx(bar, rel=1e-3)
    assert float(f"{short:.3e}") == short


def test_errors_keep_all_digits_and_other_values_stay():
    row = {"error": 1 / 3, "doubt": 1e-3, "floor_error": "a word", "reading_doubt": None, "off_doubt": 2 / 3}
    short = with_short_numbers(pd.DataFrame([row], dtype=object)).to_dict("records")
    assert short == [row]
