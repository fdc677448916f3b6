"""The unit of a curve's parameter changes no answer: contacts, gaps, landings, periods."""

from math import pi

import numpy as np
import pytest

import reference
from cases import Case, CoulombFriction, Curve, DoesNotFit, Flight, Gravity, Impact, Plate, Start, Unilateral, library
from cases import contact as contacts
from cases.contact import nearest as search
from cases.contact.nearest import nearest
from cases.curves import cos, exp
from cases.curves import sin as sine
from reference.minimal import gap, meetings

ELLIPSE = library.ellipse(0.2, 0.1)
TRACKS = {
    "parabola": Curve(("s", "s**2/2")),
    "circle": library.circle(1.0),
    "waves": Curve(lambda s: (s, -0.05 * cos(4.0 * s)), (-3.0, 3.0)),
    "bump": Curve(lambda s: (s, 0.02 * exp(-((s - 0.1) ** 2) / 1e-4)), (-3.0, 3.0)),
}
UNITS = [1e-6, 1e6]


def in_units_of(curve: Curve, unit: float) -> Curve:
    """The same curve by a parameter of which there are so many to the old one."""
    return Curve(lambda s: curve.at(s / unit), curve.domain and tuple(unit * end for end in curve.domain))


def thrown(track: Curve, outline: Curve = ELLIPSE, xi1: float = -0.8, xi2: float = -1.5) -> Case:
    """An ellipse thrown into a valley, spinning."""
    effects = (Gravity(9.81), CoulombFriction(0.2), Unilateral(), Flight(), Impact(0.5, law="poisson"))
    return Case(track, Plate(outline, 1.0, 0.02), effects, Start(xi1, xi2, 0.5, 3.0, gap=0.6), 3.0)


@pytest.fixture(scope="module")
def in_metres():
    return reference.simulate(thrown(TRACKS["parabola"]), rtol=1e-13)


@pytest.mark.slow
@pytest.mark.sampled(2, first=1)
@pytest.mark.parametrize("unit", UNITS)
def test_an_ellipse_thrown_into_a_parabola_moves_alike_in_every_unit_of_the_parameters(unit, in_metres):
    here = thrown(in_units_of(TRACKS["parabola"], unit), in_units_of(ELLIPSE, unit), -0.8 * unit, -1.5 * unit)
    motion = reference.simulate(here, rtol=1e-13)
    assert [(t.before, t.after) for t in motion.transitions] == [(t.before, t.after) for t in in_metres.transitions]
    assert len(motion.transitions) > 10
    # Two motions of the same tolerance: what rounds differently grows over a dozen impacts.
    expected = [t.time for t in in_metres.transitions]
    assert [t.time for t in motion.transitions] == pytest.approx(expected, rel=1e-13, abs=1e-13)
    times = np.linspace(0.0, 3.0, 40)
    assert motion(times).theta == pytest.approx(in_metres(times).theta, abs=1e-10)


def poses(track: Curve, outline: Curve, count: int = 60):
    """Poses near the track and off it, and a pair of parameters near the contact of the same pose on the track."""
    random = np.random.default_rng(7)
    for _ in range(count):
        xi1, xi2 = random.uniform(-0.9, 0.9), random.uniform(-pi, pi)
        x, y, theta = (float(v) for v in contacts.geometry.pose(track, outline, xi1, xi2))
        nx, ny = track.normal(xi1)
        gap = float(random.choice([0.0, 1e-9, 1e-3, 0.05]))
        yield (x + gap * nx, y + gap * ny, theta), (xi1 + random.uniform(-0.02, 0.02), xi2 + random.uniform(-0.1, 0.1))


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("name", TRACKS)
def test_the_contact_of_a_pose_is_the_same_in_every_unit(name, unit):
    track, outline = TRACKS[name], ELLIPSE
    others = in_units_of(track, unit), in_units_of(outline, 1 / unit)
    for pose, near in poses(track, outline):
        try:
            here = contacts.geometry.find(track, outline, *pose, near)
        except DoesNotFit:
            continue  # beside a bump narrower than the plate a pair need not be one
        there = contacts.geometry.find(*others, *pose, (near[0] * unit, near[1] / unit))
        assert there.gap == pytest.approx(here.gap, abs=1e-14)
        assert (there.xi1 / unit, there.xi2 * unit) == pytest.approx((here.xi1, here.xi2), abs=1e-11)


def warped(curve: Curve) -> Curve:
    """The same curve by a parameter that runs fast and slowly in turns."""
    low, high = curve.domain or (0.0, curve.period or 2 * pi)
    often = 2 * pi / (high - low)
    return Curve(lambda s: curve.at(s + 0.9 / often * sine(often * (s - low))), curve.domain)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", TRACKS)
@pytest.mark.parametrize("how", [lambda c: in_units_of(c, 1e6), lambda c: in_units_of(c, 1e-6), warped])
def test_the_nearest_pair_is_the_same_in_every_parametrisation(name, how):
    here = thrown(TRACKS[name])
    start = here.start.motion(here.track, here.plate.outline)
    other, outline = how(here.track), how(ELLIPSE)
    begun = Start(nearest_parameter(other, here.track.point(-0.8)), 0.0, gap=1.0)
    there = Case(other, Plate(outline, 1.0, 0.02), here.effects, begun, 3.0)
    for pose in [(start.x, start.y, start.theta), *(pose for pose, _ in poses(here.track, ELLIPSE, 30))]:
        ours, theirs = nearest(here, *pose), nearest(there, *pose)
        assert theirs.gap == pytest.approx(ours.gap, abs=1e-13)


def nearest_parameter(curve: Curve, point: np.ndarray) -> float:
    low, high = curve.span
    for _ in range(12):
        grid = np.linspace(low, high, 1001)
        best = int(np.argmin(np.hypot(*(curve.point(grid) - point[:, None]))))
        low, high = grid[max(best - 1, 0)], grid[min(best + 1, 1000)]
    return float(0.5 * (low + high))


def test_where_newtons_method_fails_closer_samples_find_the_pair(monkeypatch):
    """A disc in the middle of its circle, where every pair is the nearest; and any pose, without Newton's method."""
    here = thrown(library.circle(1.0), library.circle(0.2), 0.3, None)
    assert nearest(here, 0.0, 0.0, 0.3).gap == pytest.approx(0.8, abs=1e-15)
    for name, track in TRACKS.items():
        case = thrown(track)
        places = [pose for pose, _ in poses(track, ELLIPSE, 10)]
        found = [nearest(case, *pose).gap for pose in places]
        with monkeypatch.context() as patch:
            patch.setattr(search, "find", lambda *given: (_ for _ in ()).throw(DoesNotFit("none")))
            assert [nearest(case, *pose).gap for pose in places] == pytest.approx(found, abs=1e-13), name


def test_a_search_that_fails_is_an_error_and_no_sample(monkeypatch):
    case = thrown(TRACKS["parabola"])
    monkeypatch.setattr(search, "find", lambda *given: (_ for _ in ()).throw(DoesNotFit("none")))
    monkeypatch.setattr(search, "_closer", lambda scene, guess: guess)
    with pytest.raises(DoesNotFit, match="nearest to the pose"):
        nearest(case, 0.0, 0.5, 0.0)


def test_landings_whose_pair_of_points_is_not_found_are_found_by_boxes_or_the_motion_is_unfinished(monkeypatch):
    case = thrown(TRACKS["parabola"])
    expected = [t.time for t in reference.simulate(case).transitions]
    monkeypatch.setattr(gap, "find", lambda *given: (_ for _ in ()).throw(DoesNotFit("none")))
    motion = reference.simulate(case)
    assert motion.status == "completed"
    # Boxes are narrowed to rounding; what rounds differently grows over a dozen impacts.
    assert [t.time for t in motion.transitions] == pytest.approx(expected, abs=1e-11)
    monkeypatch.setattr(meetings, "MOST_WORK", 1000)
    motion = reference.simulate(case)
    assert motion.status == "unfinished" and motion.reason.startswith("The search for landings reached the limit")
    assert [t.time for t in motion.transitions] == pytest.approx(expected[: len(motion.transitions)], abs=1e-11)


@pytest.mark.parametrize("unit", [1e-6, 0.3, 1.0, 1e6])
def test_a_curve_without_a_domain_is_closed_by_its_formula_whatever_its_period(unit):
    circle = Curve((f"cos(s/{unit!r})", f"sin(s/{unit!r})"))
    assert circle.period == pytest.approx(2 * pi * unit, rel=1e-15)
    thrice = Curve(lambda s: (cos(3 * s / unit), sine(3 * s / unit)))
    assert thrice.period == pytest.approx(2 * pi / 3 * unit, rel=1e-15)
    warp = Curve(lambda s: (cos(s / unit + 0.2 * sine(2 * s / unit)), sine(s / unit + 0.2 * sine(2 * s / unit))))
    assert warp.period == pytest.approx(2 * pi * unit, rel=1e-15)
    assert Curve((f"s/{unit!r}", f"cos(s/{unit!r})")).period is None


def test_frequencies_without_a_common_period_make_no_closed_curve():
    # Within its domain of one turn it neither closes nor crosses itself.
    spiral = Curve(lambda s: (cos(s) + 0.01 * s, sine(s)), (0.0, 5.0))
    assert spiral.period is None
    assert Curve(lambda s: (s, cos(s) + cos(2**0.5 * s))).period is None


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_a_curve_without_ends_is_looked_at_in_its_own_unit(unit):
    """A cusp and a hole at twice the unit: both were seen only where the unit of the parameter is that of the curve."""
    with pytest.raises(Exception, match="cusp|not finite"):
        Curve((f"(s/{unit!r} - 2)**2", f"(s/{unit!r} - 2)**3"))
    with pytest.raises(Exception, match="not finite"):
        Curve((f"s/{unit!r}", f"1/(s/{unit!r} - 2)"))


@pytest.mark.slow
def test_the_tangents_angle_counts_every_turn_however_fast_the_parameter_runs():
    """A spiral of a hundred turns, four fifths of them in a fiftieth of its parameter."""
    spiral = Curve(
        lambda s: ((1.0 + 0.2 * turns(s)) * cos(turns(s)), (1.0 + 0.2 * turns(s)) * sine(turns(s))), (0.0, 1.0)
    )
    angle = spiral.tangent_angle(1.0) - spiral.tangent_angle(0.0)
    assert angle == pytest.approx(turned(1.0) - turned(0.0), abs=1e-9)


def turns(s):
    return 40 * pi * s + 160 * pi * s**40


def turned(s: float) -> float:
    """The tangent of r = 1 + 0.2 φ is atan(r/r') ahead of φ."""
    phi = 40 * pi * s + 160 * pi * s**40
    return phi + np.arctan2(1.0 + 0.2 * phi, 0.2)


def from_below(unit: float) -> Curve:
    """An ellipse by a parameter that is 0 at its lowest point, with so many to a radian."""
    return Curve(lambda s: (0.2 * sine(s / unit), -0.1 * cos(s / unit)))


@pytest.mark.parametrize("unit", [1e-10, 1.0, 1e10])
def test_a_level_start_is_found_once_in_every_unit_of_the_outlines_parameter(unit):
    """It lies on the seam, where it is found from both sides, a rounding of the parameter apart."""
    level = contacts.geometry.level_parameter(library.line(), from_below(unit), 0.0)
    assert np.remainder(level / unit + pi, 2 * pi) - pi == pytest.approx(0.0, abs=1e-12)
    # The bean's hollow side fits the line's direction three times.
    bean = Curve(lambda s: tuple((0.2 + 0.09 * cos(2 * s / unit)) * part(s / unit) for part in (cos, sine)))
    with pytest.raises(DoesNotFit, match="3 points"):
        contacts.geometry.level_parameter(library.line(), bean, 0.0)
