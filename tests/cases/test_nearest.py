"""The nearest points of smooth curves: far away, and on ripples."""

import numpy as np
import pytest

import reference
from cases import Case, Curve, Flight, Gravity, Plate, Start, Unilateral, disc, library
from cases.contact.nearest import nearest


@pytest.mark.parametrize("speed", [1e3, 1e17, 1e20])
def test_a_plate_that_flies_off_for_good_never_lands_however_far_it_is(speed):
    """Beyond 1e15 times a hill's size no double says which of its sides is the nearer."""
    effects = (Gravity(9.81), Unilateral(), Flight())
    motion = reference.simulate(Case(library.hill(0.1), disc(0.1, 1.0), effects, Start(0.8, slip=speed), 0.1))
    assert motion.status == "completed" and not motion.transitions
    assert np.hypot(motion.x[-1], motion.y[-1]) == pytest.approx(0.1 * speed, rel=1e-3)


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
