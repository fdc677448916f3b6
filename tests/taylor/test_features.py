"""No step and no search passes over a bump, a step, a notch or a pulse that its start knows nothing of."""

from math import pi, sqrt

import mpmath
import numpy as np
import pytest

import cases
import reference
from cases import Case, CoulombFriction, Curve, Flight, Gravity, Load, Start, Unilateral, disc
from cases.contact import start_motion
from cases.curves import cos, exp, sin, tanh
from cases.library import line
from reference.certification.truth_file import stored_or_new
from tests.sampling import quick_every
from tests.scenes import second as second_states

METHODS = reference.METHODS
RADIUS, G = 0.1, 9.81


def scene(track, *effects, start=None, duration=4.0) -> Case:
    return Case(track, disc(RADIUS, 1.0), (Gravity(G), *effects), start or Start(0.0), duration)


def rolling_over(track, duration=4.0) -> Case:
    return scene(track, CoulombFriction(0.5), Unilateral(), start=Start(0.0, omega=-20.0), duration=duration)


def gauss(height: float, centre: float, width: float) -> Curve:
    return Curve(lambda s: (s, height * exp(-(((s - centre) / width) ** 2))))


STEP = Curve(lambda s: (s, -0.05 * tanh(8 * (s - 3))))


def test_over_a_step_it_slips_and_rolls_again():
    """Both formulations at several tolerances, none of which alone decides where the two transitions are."""
    case = rolling_over(STEP)
    second = second_states.motion(case, rtol=1e-12)
    times = [t.time for t in second.transitions]
    assert times == pytest.approx([1.469117, 1.490443], abs=5e-7)
    for method in METHODS:
        for rtol, error in ((1e-6, 2e-6), (1e-12, 1e-11)):
            found = reference.simulate(case, rtol=rtol, method=method).transitions
            assert [t.time for t in found] == pytest.approx(times, abs=error), (method, rtol)
            assert [t.after for t in found] == [t.after for t in second.transitions]


@quick_every(4)
@pytest.mark.parametrize("width", [0.1, 1e-2, 1e-3, 1e-5])
def test_a_pulse_of_a_load_is_felt(width):
    """A force F exp(-((t - 1.3)/w)²) along a level line without friction leaves F w √π / m behind."""
    load = Load(fx=f"{0.5 / width!r}*exp(-((t - 1.3)/{width!r})**2)")
    case = scene(line(), load, Unilateral(), duration=3.0)
    for method in METHODS:
        for rtol, error in ((1e-4, 2e-5), (1e-10, 2e-10)):
            motion = reference.simulate(case, rtol=rtol, method=method)
            assert float(motion.vx[-1]) == pytest.approx(0.5 * sqrt(pi), abs=error), (method, rtol)
    second = second_states.motion(case, rtol=1e-12, until=3.0)
    # Times around 1.3 are known to a rounding, and the force goes up to 0.5/w and down again.
    known = 2 * 0.5 / width * np.spacing(1.3)
    assert second.last.motion[3] == pytest.approx(0.5 * sqrt(pi), abs=1e-11 + known)


@quick_every(2)
@pytest.mark.parametrize("method", METHODS)
def test_a_pulse_is_felt_whatever_the_duration(method):
    """Features in time are resolved in absolute time: a thousand times the duration begins with the same motion."""
    load = Load(fx="5*exp(-((t - 1.3)/0.05)**2)")
    speeds = [
        float(reference.simulate(scene(line(), load, Unilateral(), duration=T), method=method)(3.0).vx)
        for T in (3.0, 30.0, 3000.0)
    ]
    assert speeds == pytest.approx([0.25 * sqrt(pi)] * 3, abs=1e-9)


def landing(height: float, width: float, slip: float) -> tuple[Case, float]:
    """A disc that flies at that speed while it falls onto a bump, and the exact instant, in 30 digits: a point of the
    bump lies on the disc, and the line from the centre to it along the bump's normal."""
    place = 0.7
    track = gauss(height, place, width)
    start = Start(place - slip * 0.2, gap=0.2, slip=slip)
    case = scene(track, Unilateral(), Flight(), start=start, duration=1.0)
    begin = start_motion(case)
    with mpmath.workdps(30):
        f = lambda s: height * mpmath.exp(-(((s - place) / mpmath.mpf(width)) ** 2))  # noqa: E731

        def misses(t, s):
            x, y = begin.x + begin.vx * t, begin.y + begin.vy * t - mpmath.mpf(G) * t**2 / 2
            return [(s - x) + (f(s) - y) * mpmath.diff(f, s), (s - x) ** 2 + (f(s) - y) ** 2 - mpmath.mpf(RADIUS) ** 2]

        t, _ = mpmath.findroot(misses, (mpmath.mpf("0.19"), mpmath.mpf(place) - width / 20))
    return case, float(t)


@quick_every(3)
@pytest.mark.parametrize("height, width, slip", [(0.01, 0.005, 1.0), (0.01, 0.002, 1.0), (0.005, 0.0005, 2.0)])
def test_a_landing_on_a_narrow_bump_is_seen(height, width, slip):
    case, exact = landing(height, width, slip)
    for method in METHODS:
        motion = reference.simulate(case, method=method)
        assert motion.status == "landing"
        assert float(motion.t[-1]) == pytest.approx(exact, abs=1e-12)
    second = second_states.motion(case, rtol=1e-12)
    assert (second.status, second.end) == ("landing", pytest.approx(exact, abs=1e-12))


@quick_every(3, first=2)
@pytest.mark.parametrize("height, width", [(0.18, 0.05), (0.02, 0.002), (0.01, 1e-4)])
def test_a_second_contact_with_a_bump_narrower_than_the_plate_is_seen(height, width):
    """A disc of 0.3 m slides at 1 m/s towards a bump; where its side meets the bump is solved for in 30 digits."""
    place, radius = 3.1, 0.3
    track = gauss(height, place, width)
    case = Case(track, disc(radius, 1.0), (Gravity(G), Unilateral()), Start(0.0, slip=1.0), 5.0)
    with mpmath.workdps(30):
        f = lambda s: height * mpmath.exp(-(((s - place) / mpmath.mpf(width)) ** 2))  # noqa: E731

        def misses(x, s):
            return [(s - x) + (f(s) - radius) * mpmath.diff(f, s), (s - x) ** 2 + (f(s) - radius) ** 2 - radius**2]

        # The top is met about where a point of that height would be.
        guess = place - sqrt(radius**2 - (radius - height) ** 2)
        if width > 0.01:
            guess += 0.007
        x, s = mpmath.findroot(misses, (guess, place - width / 3))
    for method in METHODS:
        motion = reference.simulate(case, method=method)
        assert motion.status == "second_contact"
        assert float(motion.t[-1]) == pytest.approx(float(x), abs=1e-10), float(s)


# --- what features cost, and what they are ----------------------------------------------------------------------------


@quick_every(2)
@pytest.mark.skipif(len(METHODS) < 2, reason="heyoka is not installed")
@pytest.mark.parametrize("rtol", [1e-7, 1e-9])
def test_on_a_sliver_the_default_is_as_accurate_as_its_tolerance(rtol):
    """At the sharp ends a radian of the outline's parameter is fifty of the tangent: steps were judged by the former.

    The times were 130 tolerances off, 250 times as much as DOP853's. (Truth: certified to 2.5e-10 s.)
    """
    case = cases.load("sliver", mu=0.5, omega=-12.0)
    times = np.array([event[2].value for event in stored_or_new(case).transitions])
    default, dop853_motion = (reference.simulate(case, rtol=rtol, method=method) for method in METHODS)
    errors = [np.abs([t.time for t in motion.transitions] - times).max() for motion in (default, dop853_motion)]
    assert errors[0] <= max(rtol * case.duration, 2 * errors[1])


def test_features_are_where_the_bump_is():
    """Nothing where the line is straight to rounding, strides of the bump's own size within, found at any width."""
    for width in (0.3, 1e-2, 1e-4, 1e-7):
        found = gauss(0.05 * width, 4.0, width).features
        assert found.finest(0.0, 4.0 - 8 * width) == np.inf
        assert width / 50 < found.finest(3.0, 5.0) < width
        assert found.clear(4.0 - 20 * width, 5.0) < 4.0 - 3 * width
        assert found.clear(4.0, 5.0) - 4.0 < width
        assert found.clear(4.0 + 20 * width, 3.0) > 4.0 + 3 * width


def test_the_tail_of_a_step_is_no_feature():
    """Where tanh is 1 but for rounding, so are its derivatives, 1 - tanh² among them: a road's tail in a window of its
    own was resolved to the last bit of that rounding, by a step every 20 µm, and so was a load's."""
    for curve in (Curve(lambda s: (s, 0.5 * tanh(4.9 * (s - 1.3)))), Curve(lambda s: (s, 0.5 * tanh(4.9 * (s - 99))))):
        assert curve.features.finest(-16.0, 0.0) > 1e-2
    load = Load(fx="1 - tanh((t - 2)/2)**2")
    assert load.features.finest(16.0, 64.0) > 0.1


def test_features_of_a_closed_curve_come_again():
    """A notch in a circle, in every turn."""
    curve = Curve(lambda s: ((1 - 1e-3 * exp(200 * (cos(s - 1) - 1))) * cos(s), sin(s)))
    found = curve.features
    assert not found.plain
    for turn in (-7, 0, 40):
        start = 2 * pi * turn + 3.0
        stride = found.clear(start, start - 3.0) - start
        assert stride == pytest.approx(found.clear(3.0, 0.0) - 3.0, rel=1e-9)
        assert stride > -2.0
