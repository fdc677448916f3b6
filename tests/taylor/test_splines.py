"""Motions on splines: both formulations, both integrators, convergence, knots, landings, and how much is compiled."""

import numpy as np
import pytest
from scipy.optimize import brentq

import reference
from cases import Case, CoulombFriction, Curve, Flight, Gravity, Impact, Plate, Start, Unilateral, disc
from cases.library import line
from reference.minimal import assembly
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.agreement import agree

GRIP = (Gravity(9.81), CoulombFriction(0.1), Unilateral())


def valley(count):
    x = np.linspace(-3.0, 3.0, count)
    return Curve.spline(np.column_stack([x, -0.3 * np.cos(2 * x)]))


def released(track, x, effects=GRIP, plate=None, duration=3.0):
    """A disc released at rest where the track has that x."""
    xi1 = brentq(lambda s: float(track.point(s)[0]) - x, *track.domain, xtol=1e-15)
    return Case(track, plate or disc(0.1, 1.0), effects, Start(xi1=xi1), duration)


def names(transitions):
    return [(t.before, t.after) for t in transitions]


@pytest.mark.slow
def test_motions_on_splines_of_a_cosine_converge_to_the_motion_on_the_cosine():
    """The forces hold the curvature, which converges with order 4; where only heights matter it is 6."""
    exact = Curve(("s", "-0.3*cos(2*s)"), domain=(-3, 3))
    times = [
        t.time
        for t in reference.simulate(Case(exact, disc(0.1, 1.0), GRIP, Start(xi1=-1.0), 3.0), rtol=1e-12).transitions
    ]
    off = []
    for count in (50, 100, 200):
        found = reference.simulate(released(valley(count), -1.0), rtol=1e-12).transitions
        off.append([abs(t.time - time) for t, time in zip(found, times, strict=True)])
    orders = np.log2(np.array(off[:-1]) / np.array(off[1:]))
    assert np.all(orders > 4.0), (orders, off)
    assert max(off[-1]) < 1e-8


def test_a_long_spline_is_compiled_once():
    """500 points derive and compile no more equations than 12."""
    start = released(valley(12), -1.0)
    reference.simulate(start)
    before = assembly._in_contact.cache_info().misses
    reference.simulate(released(valley(500), -1.0))
    assert assembly._in_contact.cache_info().misses == before


@quick_every(2, first=1)
@pytest.mark.parametrize("place", ["knot", "rest"])
def test_a_motion_may_begin_or_rest_at_a_knot(place):
    x = np.linspace(-2.0, 2.0, 41)
    track = Curve.spline(np.column_stack([x, 0.5 * x**2]))
    xi1 = track.domain[1] / 2 if place == "rest" else track.knots[9]
    motion = agree(Case(track, disc(0.1, 1.0), GRIP, Start(xi1=xi1), 2.0), 1e-11)
    assert motion.status == "completed"
    if place == "rest":
        assert abs(motion(2.0).x) < 1e-12


def test_the_end_of_an_open_spline_ends_the_motion():
    track = Curve.spline(np.column_stack([np.linspace(0, 1, 12), -0.2 * np.linspace(0, 1, 12)]))
    motion = agree(Case(track, disc(0.1, 1.0), GRIP, Start(xi1=0.2), 9.0), 1e-11)
    assert motion.status == "track_end" and motion(motion.t[-1]).xi1 == pytest.approx(track.domain[1], abs=1e-12)


@pytest.mark.slow
def test_a_closed_spline_as_an_outline_rolls_through_many_turns():
    """The points of a circle: the motion of a disc, to the error of the interpolation."""
    angle = np.linspace(0.0, 2 * np.pi, 80, endpoint=False)
    outline = Curve.spline(0.1 * np.column_stack([np.cos(angle), np.sin(angle)]), closed=True)
    effects = (Gravity(9.81), CoulombFriction(0.5), Unilateral())
    plates = disc(0.1, 1.0), Plate(outline, 1.0, 0.005)
    ends = [
        reference.simulate(Case(line(0.2), plate, effects, Start(xi1=0.0, xi2=xi2), 2.0), rtol=1e-11)(2.0)
        for plate, xi2 in zip(plates, (-np.pi / 2, 0.75 * outline.period), strict=True)
    ]
    assert ends[0].x - 0.0 > 2.0 and ends[1].x == pytest.approx(ends[0].x, abs=1e-7)
    # The tangent's angle counts from the start of each outline.
    assert (ends[1].theta - ends[0].theta) % (2 * np.pi) == pytest.approx(2 * np.pi, abs=1e-6)


X = np.linspace(-3.0, 3.0, 60)
WAVY = Curve.spline(np.column_stack([X, 0.3 * X**2 + 0.15 * np.sin(5 * X)]))
BOUNCING = (Gravity(9.81), CoulombFriction(0.15), Unilateral(), Flight(), Impact(0.5))


@pytest.mark.slow
def test_a_plate_flies_from_a_spline_and_lands_on_it():
    motion = agree(released(WAVY, -1.8, BOUNCING, disc(0.05, 1.0), 1.5), 1e-9)
    assert any(t.cause == "impact" for t in motion.transitions)


def test_a_plate_that_is_dropped_lands_on_a_spline():
    dropped = Case(WAVY, disc(0.05, 1.0), BOUNCING, Start(xi1=0.8 * WAVY.domain[1], gap=0.4), 1.0)
    assert agree(dropped, 1e-9).transitions


@pytest.mark.slow
def test_a_second_contact_on_a_spline_ends_the_motion_where_both_formulations_find_it():
    """A disc rolls against a step with a foot of a smaller radius than its own: it meets the step there first."""
    x = np.linspace(-1.5, 1.5, 90)
    track = Curve.spline(np.column_stack([x, 0.25 * (1 + np.tanh((x - 0.5) / 0.08))]))
    case = Case(track, disc(0.3, 1.0), GRIP, Start(xi1=0.4, slip=0.0, omega=-4.0), 2.0)
    motion = agree(case, 1e-9)
    assert motion.status == "second_contact"
    assert motion.t[-1] == pytest.approx(second_states.motion(case, rtol=1e-11).end, abs=1e-9)


def test_a_sweep_on_a_spline_has_the_single_motions():
    track = valley(40)

    def disc_in_measured_valley(mu=0.1):
        return Case(track, disc(0.1, 1.0), (Gravity(9.81), CoulombFriction(mu), Unilateral()), Start(1.3), 1.5)

    values = [0.05, 0.1, 0.3]
    rows = reference.sweep(disc_in_measured_valley, mu=values)
    for value, outcome in zip(values, rows["outcome"], strict=True):
        assert outcome == reference.simulate(disc_in_measured_valley(value)).status


@pytest.mark.slow
def test_a_motion_on_a_spline_is_certified_by_all_witnesses():
    certificate = reference.certify(released(valley(40), -1.0, duration=1.5))
    assert not certificate.missing and len(certificate.transitions) == 2
    assert all(bar.bar < 1e-12 for _, _, bar, _ in certificate.transitions)
