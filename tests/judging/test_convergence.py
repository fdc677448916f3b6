"""The order of a ladder, its confidence interval, and where the ladder saturates and why."""

import numpy as np
import pytest

from reports.analysis import convergence
from reports.analysis.convergence import ConvergencePoint


def ladder(errors, truth=1e-15, reading=0.0, rounding=0.0) -> list[ConvergencePoint]:
    """Rungs with 100, 200, 400, … steps."""
    return [
        ConvergencePoint(f"n={100 * 2**i}", 100.0 * 2**i, e, truth, reading, rounding) for i, e in enumerate(errors)
    ]


def falling(count: int, order: float = 2.0) -> list[float]:
    return [3.0 * (100.0 * 2**i) ** -order for i in range(count)]


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0, 8.0])
def test_order_of_a_clean_ladder_is_its_power(power):
    fit = convergence.order(ladder(falling(4, power), truth=1e-30))
    assert (fit.order, fit.low, fit.high) == pytest.approx((power, power, power))
    assert len(fit.settings) == 4 and fit.note == ""


def test_interval_of_a_noisy_ladder_holds_its_order_about_as_often_as_promised():
    random = np.random.default_rng(7)
    held = 0
    for _ in range(1000):
        fit = convergence.order(ladder([e * np.exp(0.1 * random.standard_normal()) for e in falling(5)], truth=1e-30))
        held += fit.low <= 2.0 <= fit.high
    # 95 % of 1000, and four standard deviations (28) of that count.
    assert abs(held - 950) <= 28


def test_rungs_at_the_floor_do_not_count_towards_the_order():
    errors = [*falling(4), 1e-9, 2e-9]
    assert convergence.order(ladder(errors, truth=1e-9)).order == pytest.approx(2.0)
    assert np.isnan(convergence.order(ladder(falling(3), reading=1.0)).order)


def test_rungs_beyond_saturation_do_not_count_towards_the_order():
    errors = [*falling(4), *[falling(4)[-1]] * 4]
    fit = convergence.order(ladder(errors))
    assert fit.order == pytest.approx(2.0) and len(fit.settings) == 4


def test_where_no_order_can_be_fitted_the_table_says_why():
    assert "2 of 2 rungs" in convergence.order(ladder(falling(2))).note
    close = [ConvergencePoint(f"n={n}", n, 1e-3 / n) for n in (100.0, 110.0, 120.0)]
    fit = convergence.order(close)
    assert np.isnan(fit.order) and "differ by less" in fit.note


@pytest.mark.parametrize("cause", ["truth", "reading", "rounding"])
def test_ladder_within_a_known_limit_saturates_for_that_reason(cause):
    errors = [1e-3, 1e-5, 1e-8, 2e-8]
    output = convergence.saturation(ladder(errors, **{"truth": 1e-15, cause: 3e-9}))
    assert output == (cause, "n=400", 1e-8)


def test_level_ladder_far_from_every_known_limit_is_the_model_s():
    assert convergence.saturation(ladder([1e-3, 1e-4, 1.1e-5, 1e-5, 1.2e-5])) == ("model", "n=400", 1.1e-5)
    assert convergence.saturation(ladder([1e-3, 1e-5, 2e-5, 4e-5])).cause == "model"  # it even grows


@pytest.mark.parametrize(
    "errors",
    [
        falling(5),
        falling(6, 0.5),  # slow, but it falls
        [1e-3, 1e-7, 1e-4, 1e-5, 1e-6],  # a lucky rung in between: the error crosses zero
        [1e-3, 1e-4, 1e-5, 1e-5],  # two rungs alike are no tendency
    ],
)
def test_falling_ladder_does_not_saturate(errors):
    assert convergence.saturation(ladder(errors)).cause == ""


def test_rungs_without_an_error_are_left_out():
    output = convergence.saturation(ladder([1e-3, np.nan, 1e-5, 1e-5, np.nan, 1.1e-5]))
    assert output == ("model", "n=400", 1e-5)
    assert convergence.saturation(ladder([np.nan])) == convergence.saturation([])
