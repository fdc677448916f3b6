"""What the reference conserves, and how exactly it keeps the contact."""

from math import pi

import numpy as np
import pytest

import reference
from cases import Case, Curve, Gravity, Start, disc
from cases import curves as c
from cases.contact import find
from tests.sampling import quick_every
from tests.scenes.elliptic import ellipse_in_ellipse
from tests.scenes.motions import energy


def eccentric(mu, duration=2.0):
    """An eccentric ellipse sliding to and fro at the bottom of an ellipse."""
    case = ellipse_in_ellipse(1.2, 1.0, 0.25, 0.2, -pi / 2 + 0.4, 0.3, mu, 0.8, -1.0, shift=0.03)
    return Case(case.track, case.plate, case.effects, case.start, duration)


@pytest.mark.skipif("taylor" not in reference.METHODS, reason="needs heyoka")
def test_energy_without_friction_drifts_less_than_1e_11_over_a_thousand_periods():
    circle = Curve(lambda s: (c.cos(s), c.sin(s)))
    case = Case(circle, disc(0.1, 1.0), (Gravity(9.81),), Start(-pi / 2 + 1.0), 2000.0)  # a period is 2.04 s
    motion = reference.simulate(case, rtol=1e-14)
    state = motion(np.linspace(0.0, 2000.0, 500))
    total = energy(case, state)
    assert np.ptp(total) <= 1e-11 * np.abs(total).max()


@quick_every(3)
@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_gap_and_tangency_stay_at_rounding(mu, method):
    case = eccentric(mu)
    motion = reference.simulate(case, rtol=1e-8, method=method)  # a loose tolerance opens no gap either
    for t in np.linspace(0.0, motion.t[-1], 40):
        state = motion(t)
        contact = find(case, state.x, state.y, state.theta, (state.xi1, state.xi2))
        assert abs(contact.gap) <= 1e-13
        # Where the gap is smallest the tangents are parallel; the parameters found there are the motion's own.
        assert abs(contact.xi1 - state.xi1) + abs(contact.xi2 - state.xi2) <= 1e-12
