"""Which sample of a curve is nearest: the same as by looking at all of them."""

import sys
from subprocess import run

import numpy as np
import pytest

import reference
from cases import Case, Curve, DoesNotFit, Flight, Gravity, Plate, Start, Unilateral, disc, library
from cases.contact import find, pair_search, start_motion
from cases.contact.nearest import nearest
from cases.curves.curve_samples import SampleStretches
from tests.scenes.ripples import rippled


@pytest.mark.parametrize("count", [1, 2, 17, 720, 5000])
@pytest.mark.parametrize("far", [0.1, 1.0, 1e8])
def test_stretches_find_the_nearest_of_all_samples(count, far):
    random = np.random.default_rng(count)
    s = np.linspace(0.0, 6.0, count)
    samples = np.column_stack([np.cos(s), 0.7 * np.sin(3 * s)])
    there = random.normal(size=(40, 2)) * far
    found = SampleStretches.of(samples).nearest(there)
    apart = np.hypot(*(there[:, None] - samples).T)
    np.testing.assert_allclose(apart[found, range(40)], apart.min(axis=0), rtol=1e-14)
    if far <= 1.0:  # from far away all are equally near, to rounding
        np.testing.assert_array_equal(found, apart.argmin(axis=0))


@pytest.mark.parametrize("track", [library.cosine(0.3, 2.0), library.circle(1.0), library.line(0.2)])
def test_the_search_written_for_two_formulas_has_the_digits_of_one_that_calls_the_curves(track):
    plate = Curve(("0.2*cos(s)", "0.1*sin(s) + 0.01*cos(s)**2"), domain=(0.0, 2.0 * np.pi))
    search = pair_search.pair_search(track, plate)
    furthest = pair_search.STRAIGHTER * plate.sizes[0] if track.features else np.inf
    generic = pair_search._search_maker(None, None)(track.jet, plate.jet, *plate.sizes, furthest)
    random, found = np.random.default_rng(0), 0
    for xi1, xi2, away, turn in random.uniform(-0.5, 0.5, (200, 4)).tolist():
        (x, y), near = (track.point(xi1) + 0.3 * away).tolist(), (xi1, xi2)
        try:
            contact = generic(x, y, turn, near)
        except DoesNotFit:
            with pytest.raises(DoesNotFit):
                search(x, y, turn, near)
            continue
        assert search(x, y, turn, near) == contact
        found += 1
    assert 50 < found


@pytest.mark.parametrize("speed", [1e3, 1e17, 1e30])
def test_a_plate_that_flies_off_for_good_never_lands_however_far_it_is(speed):
    """Beyond 1e15 times a hill's size no double says which of its sides is the nearer."""
    effects = (Gravity(9.81), Unilateral(), Flight())
    motion = reference.simulate(Case(library.hill(0.1), disc(0.1, 1.0), effects, Start(0.8, slip=speed), 0.1))
    assert motion.status == "completed" and not motion.transitions
    assert np.hypot(motion.x[-1], motion.y[-1]) == pytest.approx(0.1 * speed, rel=1e-3)


@pytest.mark.slow
@pytest.mark.skipif("taylor" not in reference.METHODS, reason="without heyoka SciPy's DOP853 integrates")
def test_a_first_flight_imports_no_scipy():
    """Its trees and root finders take a fifth of a second to import, more than the motion."""
    program = (
        "import sys, cases, reference\n"
        "assert reference.simulate(cases.load('bouncing_disc')).transitions\n"
        "print([name for name in sys.modules if name.startswith('scipy.')])"
    )
    assert run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.strip() == "[]"


@pytest.mark.parametrize("far", [10.0, 1e3, 1e6])
def test_the_contact_with_a_straight_line_is_found_from_any_distance(far):
    """Steps of Newton's method were 0.8 m at most, where a plate of 0.1 m flies kilometres between two looks."""
    case = Case(library.line(), disc(0.1, 1.0), (Gravity(9.81), Unilateral()), Start(0.0), 1.0)
    contact = find(case, far, 0.3, 0.0, (0.0, -np.pi / 2))
    assert (contact.xi1, contact.gap) == pytest.approx((far, 0.2), rel=1e-14)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", [18, 34, 62, 91])
def test_over_ripples_the_nearest_pair_is_at_most_as_far_as_that_of_the_start(seed):
    case = rippled(seed).case
    begun = start_motion(case)
    pair = nearest(case, begun.x, begun.y, begun.theta)
    assert 0.0 < pair.gap <= case.start.gap * (1.0 + 1e-12)


def test_foot_on_ripples_may_be_several_ripples_from_that_of_a_sample():
    """Flight 111, whose start is the only pair of a gap of its size: ripples bend less than the plate. Samples of the
    outline are 4 mm apart, ripples 0.4 mm, and the pair found from them was not taken: it was 0.05 µm farther."""
    case = rippled(111).case
    start = start_motion(case)
    assert nearest(case, start.x, start.y, start.theta).gap == pytest.approx(case.start.gap, abs=1e-15)


@pytest.mark.parametrize("turn", [0.0, 0.4, 0.8, 1.2])
def test_no_ripple_is_nearer_than_that_of_the_nearest_pair(turn):
    """Ripples of 0.16 mm under samples of an ellipse 4 mm apart, 41 nm high: halfway between two samples the ellipse is
    farther than that from the circles that osculate it. The pair was 12 nm too far, two ripples from the nearest."""
    wave, number = "(0.5+4.11346e-8*cos(19394*s))", 19394.0
    track = Curve((f"{wave}*cos(s)", f"{wave}*sin(s)"))
    effects = (Gravity(9.81), Unilateral(), Flight())
    plate = Plate(library.ellipse(0.1, 0.0705141), 1.0, 0.004)
    case = Case(track, plate, effects, Start(0.2, gap=0.1), 1.0)
    pose = (0.39733757859665687, 0.06266951521787896, 0.8864264202164328 + turn)
    pair = nearest(case, *pose)
    # Distances of samples of both curves, which are never too small.
    xi1 = pair.xi1 + 2.0 * np.pi / number * np.linspace(-20.0, 20.0, 601)
    u, v = plate.outline.point(pair.xi2 + np.linspace(-0.1, 0.1, 4001))
    (x, y, theta), (px, py) = pose, track.point(xi1)[..., None]
    c, s = np.cos(theta), np.sin(theta)
    apart = np.hypot(x + c * u - s * v - px, y + s * u + c * v - py)
    assert pair.gap <= apart.min() + 1e-15
    assert pair.gap == pytest.approx(apart.min(), abs=1e-9)
