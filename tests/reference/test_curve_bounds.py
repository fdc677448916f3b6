"""The second formulation's bounds on curvature and speed hold on whole ranges, however fine a curve's ripples."""

import numpy as np
import pytest

from cases import Curve
from cases.library import circle, line
from reference.witness.curve_bounds import CurveBounds
from tests.sampling import quick_every

# Functions, since making them takes half a second in each process that collects tests.
CURVES = {
    "line": lambda: line(),
    "circle": lambda: circle(0.3),
    "even ripples": lambda: Curve(("s", "1.15e-7*sin(28693.8*s+4.433)"), (-1.0, 1.0)),
    "endless ripples": lambda: Curve(("s", "1.8e-6*sin(442.1*s+2.35)")),
    "lobes": lambda: Curve(("0.1*(1+1.3e-4*cos(102*s))*cos(s)", "0.1*(1+1.3e-4*cos(102*s))*sin(s)")),
    "bump": lambda: Curve(("s", "1e-6*exp(-((s-0.3)/1e-4)**2)"), (-1.0, 1.0)),
    "uneven parameter": lambda: Curve(("s + 0.3*sin(s)", "0.01*cos(7*s)")),
}


@quick_every(2)
@pytest.mark.parametrize("name", CURVES)
def test_no_curvature_or_speed_is_beyond_its_bounds(name):
    """Ranges of every length: a bound from five samples of a range with many ripples was 60 times too small."""
    curve, random = CURVES[name](), np.random.default_rng(1)
    bounds, (low, high) = CurveBounds(curve), curve.span
    length = (high - low) * 10.0 ** random.uniform(-6, 0, 60)
    start = low + (high - low - length) * random.uniform(0, 1, 60)
    if curve.domain is None:  # beyond the first window, or around the end of a closed curve
        start += (high - low) * random.integers(-3, 4, 60)
    most, least, speed = bounds.extremes(start, start + length)
    for i, (a, wide) in enumerate(zip(start, length, strict=True)):
        s = a + wide * random.uniform(0, 1, 2000)
        bend, fast = np.asarray(curve.curvature(s)), np.asarray(curve.speed(s))
        rounding = 1e-9 * (1.0 + np.abs(bend).max())
        assert bend.max() <= most[i] + rounding and bend.min() >= least[i] - rounding, (a, wide)
        assert fast.max() <= speed[i] * (1.0 + 1e-9), (a, wide)
