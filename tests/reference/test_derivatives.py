"""Derivatives of motions by parameters, exact ones through slip, roll, impact and rest; and where there is none."""

import math
from fractions import Fraction

import numpy as np
import pytest

import cases
import reference

pytest.importorskip("heyoka")  # the bars are those of motions by the Taylor method
G = 9.81


def agrees(found, exact, most=1e-9):
    """Whether a derivative has its exact value within its bar, which is small."""
    assert found.bar <= most * max(1.0, abs(exact))
    assert found.value == pytest.approx(exact, abs=found.bar)


def test_bowling_by_friction_start_and_gravity():
    """The disc rolls from t = v/(3 μ g) on."""
    mu, v = 0.1, 1.0
    case = cases.load("disc_on_line", mu=mu)
    t = v / (3 * mu * G)
    for parameter, exact in {"mu": -t / mu, "start.slip": t / v, "g": -t / G}.items():
        (change,) = reference.derivatives(case, parameter).transitions
        assert (change.before, change.after) == ("slip_forward", "roll")
        agrees(change.derivative, exact)


def test_states_by_friction():
    """While it slips x = v t − μ g t²/2 and ω = −2 μ g t/r; when it rolls v = 2/3 whatever μ is."""
    case = cases.load("disc_on_line", mu=0.1)
    found = reference.derivatives(case, "mu")
    times, start = np.array(found.times), found.transitions[0].time
    for t, x, omega in zip(times, found.states["x"], found.states["omega"], strict=True):
        if t < start - 1e-3:
            agrees(x, -G * t**2 / 2)
            agrees(omega, -2 * G * t / 0.1)
        elif t > start + 1e-3:  # x = 2/3 t + const, where the constant is v²/(18 μ g)
            agrees(x, -1.0 / (18 * 0.1**2 * G))
            agrees(omega, 0.0, most=1e-8)


def test_a_velocity_at_a_transition_has_a_kink():
    """The case lasts twice the time of slip: its middle instant is the transition."""
    found = reference.derivatives(cases.load("disc_on_line", mu=0.1), "mu")
    middle = found.states["omega"][5]
    assert math.isnan(middle.value) and math.isinf(middle.bar)
    agrees(found.states["x"][5], -G * found.times[5] ** 2 / 2, most=1e-2)  # its second derivative jumps there


def test_a_bouncing_disc_by_its_restitution():
    """Impact n is at t₁ + 2 t₁ (e + … + eⁿ⁻¹), the rest at t₁ (1 + e)/(1 − e)."""
    e = 0.5
    found = reference.derivatives(cases.load("bouncing_disc", e=e), "e").transitions
    first = found[0].time
    for n, change in enumerate(found[:6], start=1):
        agrees(change.derivative, 2 * first * sum(k * e ** (k - 1) for k in range(1, n)))
    agrees(found[-1].derivative, 2 * first / (1 - e) ** 2, most=1e-8)


def proved_times(case):
    """The times of a case's transitions by validated integration, with twenty digits."""
    from reference.proofs import prove  # needs python-flint

    return [
        (Fraction(change.time.low) + Fraction(change.time.high)) / 2 for change in prove(case, digits=20).transitions
    ]


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [("disc_in_circle", "mu", 0.2), pytest.param("ellipse_on_hill", "mu", 0.1, marks=pytest.mark.slow)],
)
def test_against_differences_of_proved_times(name, parameter, value):
    """Central differences with twenty digits of times that theorems enclose, extrapolated to the step zero: their error
    of fourth order is a thousandth of the bar."""
    pytest.importorskip("flint")

    def difference(step):
        ends = [value * (1.0 + step), value * (1.0 - step)]
        after, before = (proved_times(cases.load(name, **{parameter: end})) for end in ends)
        assert len(after) == len(before) > 0
        width = Fraction(ends[0]) - Fraction(ends[1])
        return [(one - other) / width for one, other in zip(after, before, strict=True)]

    coarse, fine = difference(2.0**-10), difference(2.0**-11)
    found = reference.derivatives(cases.load(name, **{parameter: value}), parameter).transitions
    assert len(found) == len(fine)
    for change, one, other in zip(found, coarse, fine, strict=True):
        agrees(change.derivative, float((4 * other - one) / 3))


def test_no_derivative_where_the_sequence_changes():
    with pytest.raises(reference.NoDerivative, match="sequence of transitions changes"):
        reference.derivatives(cases.load("touching_slip", above=0.0), "above")
    with pytest.raises(reference.NoDerivative, match="mu"):  # a negative coefficient is none
        reference.derivatives(cases.load("rebound_with_spin", e=1.0, mu=0.0), "mu")
