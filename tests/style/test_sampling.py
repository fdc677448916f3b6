"""Which rows of a claim over many scenes are quick."""

import pytest

from tests.sampling import quick_every


def test_of_the_rows_without_a_slow_value_every_so_many_th_is_quick():
    @quick_every(2, first=1)
    @pytest.mark.parametrize("a", [1, 2, 9])
    @pytest.mark.parametrize(("b", "c"), [(3, 4), pytest.param(5, 6, marks=pytest.mark.slow), (7, 8)])
    def claim(a, b, c):
        """Nothing: its parametrisation is looked at."""

    (mark,) = claim.pytestmark
    names, rows = mark.args
    assert names == ["b", "c", "a"]
    assert [row.values for row in rows] == [(*pair, a) for pair in ((3, 4), (5, 6), (7, 8)) for a in (1, 2, 9)]
    quick = [row.values for row in rows if not any(mark.name == "slow" for mark in row.marks)]
    assert quick == [(3, 4, 2), (7, 8, 1), (7, 8, 9)]
