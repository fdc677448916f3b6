"""The kept truth: rebuilt in part, and small bars."""

import re
from math import atan, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import cases
from cases import Impact
from reference import certify
from reference.certification import read
from tests.authorities.paper_application import FIRST_TRANSITION
from tests.sampling import quick_every

KEPT = read()
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def test_every_case_of_the_catalogue_has_kept_truth():
    ordinary, hard = (
        {case.label for name in cases.names(hard=kind) for case in cases.select(name)} for kind in (False, True)
    )
    # A hard case that hangs on the last bit has no truth to keep.
    assert ordinary <= KEPT.keys() <= ordinary | hard, "rebuild the truth with `python -m reference`"


def test_cases_without_a_certificate_have_their_reason_in_the_documentation():
    page = Path(cases.__file__).parents[1] / "docs" / "truth.md"
    named = re.findall(r"`(\w+\[[^`]+\])`", page.read_text().split("no certificate:")[1].split("##")[0])
    assert {*named} == {case.label for name in cases.names() for case in cases.select(name)} - {*KEPT}


@quick_every(2, first=1)
@pytest.mark.parametrize("label", ["disc_in_circle[mu=0.2]", "disc_on_line[mu=0.1]"])
def test_rebuilt_truth_agrees_with_the_kept_one_within_its_bars(label):
    kept, rebuilt = KEPT[label], certify(cases.load(label))
    assert [t[:2] for t in rebuilt.transitions] == [t[:2] for t in kept.transitions]
    for one, other in zip(rebuilt.transitions, kept.transitions, strict=True):
        assert abs(one[2].value - other[2].value) <= one[2].bar + other[2].bar
    for quantity, bars in kept.samples.items():
        for one, other in zip(rebuilt.samples[quantity], bars, strict=True):
            assert abs(one.value - other.value) <= one.bar + other.bar


@pytest.mark.parametrize("mu", FIRST_TRANSITION)
def test_exact_value_lies_within_the_bar(mu):
    _, after, time, xi1 = KEPT[f"disc_in_circle[mu={mu:g}]"].transitions[0]
    exact_time, exact_xi1, follows = FIRST_TRANSITION[mu]
    assert after is follows
    assert abs(time.value - exact_time) <= time.bar
    assert abs(xi1.value - exact_xi1) <= xi1.bar


@pytest.mark.parametrize("label", [label for label in KEPT if not cases.entry(label.partition("[")[0]).hard])
def test_bars_are_far_below_any_error_worth_reporting(label):
    name, _, _ = label.partition("[")
    bounces = cases.select(name)[0].effect(Impact) is not None
    # Ten bars are the smallest error a report shows; a picosecond resolves every engine there is. Where bouncing comes
    # to rest, the instants of its last impacts are the rounding of a position over a speed of some 1e-4 m/s.
    assert all(t[2].bar < (1e-10 if bounces else 1e-12) for t in KEPT[label].transitions)


def _rocking_times(alpha: float, diagonal: float, tilt: float, g: float) -> tuple[list[float], float]:
    """Times of 40 impacts of Housner's block, and the time at which it rests, s: a pendulum about a corner between
    them, θ̈ = −p² sin(α − θ) with p² = 3 g/(2 diagonal), and spins that each impact multiplies by 1 − (3/2) sin² α."""
    rate, factor = sqrt(1.5 * g / diagonal), 1.0 - 1.5 * sin(alpha) ** 2

    def fall(top: float, way: np.ndarray | float) -> np.ndarray | float:
        """cos(α − top) − cos(α − (top − way)), which is half the square of the spin over p²."""
        return 2.0 * np.sin(alpha - top + 0.5 * way) * np.sin(0.5 * way)

    def quarter(top: float) -> float:  # by Gauss-Legendre in u with way = top u²: smooth, as the root cancels dway/du
        u, weights = 0.5 + 0.5 * NODES, 0.5 * WEIGHTS
        return float(weights @ (2.0 * top * u / (rate * np.sqrt(2.0 * fall(top, top * u * u)))))

    times = [quarter(tilt)]
    for _ in range(40):
        height = factor**2 * fall(tilt, tilt)
        tilt = brentq(lambda top, height=height: fall(top, top) - height, 0.0, tilt, xtol=1e-16 * tilt)
        times.append(times[-1] + 2.0 * quarter(tilt))
    return times, times[-1] + 2.0 * quarter(tilt) * factor / (1.0 - factor)


def test_a_rocking_block_hits_and_rests_at_the_exact_times():
    """The square block's last time is the limit of a series whose intervals tend to a quarter of those before."""
    square = KEPT["rocking_block[slenderness=1,height=0.5,duration=0.5]"]
    times, rest = _rocking_times(0.25 * pi, 0.5 * sqrt(2.0), 0.1, 9.81)
    *impacts, last = sorted({time.value: time for _, _, time, _ in square.transitions}.values())
    assert len(impacts) == 6 and last.bar < 1e-10
    for one, exact in zip([*impacts, last], [*times[:6], rest], strict=True):
        assert abs(one.value - exact) < 1e-14 + one.bar
    slender, _ = _rocking_times(atan(0.25), sqrt(4.25), 0.1, 9.81)
    for (_, _, time, _), exact in zip(KEPT["rocking_block"].transitions[::2], slender[:5], strict=True):
        assert abs(time.value - exact) < 1e-14 + time.bar
