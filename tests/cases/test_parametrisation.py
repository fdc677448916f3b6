"""The unit of a curve's parameter changes no answer: contacts, gaps, landings, periods."""

from math import pi

import numpy as np
import pytest

from cases import Curve, DoesNotFit, library
from cases import contact as contacts
from cases.curves import cos, exp
from cases.curves import sin as sine

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


@pytest.mark.parametrize("unit", [1e-6, 0.3, 1.0, 1e6])
def test_a_curve_without_a_domain_is_closed_by_its_formula_whatever_its_period(unit):
    circle = Curve((f"cos(s/{unit!r})", f"sin(s/{unit!r})"))
    assert circle.period == pytest.approx(2 * pi * unit, rel=1e-15)
    thrice = Curve(lambda s: (cos(3 * s / unit), sine(3 * s / unit)))
    assert thrice.period == pytest.approx(2 * pi / 3 * unit, rel=1e-15)
    warp = Curve(lambda s: (cos(s / unit + 0.2 * sine(2 * s / unit)), sine(s / unit + 0.2 * sine(2 * s / unit))))
    assert warp.period == pytest.approx(2 * pi * unit, rel=1e-15)
    assert Curve((f"s/{unit!r}", f"cos(s/{unit!r})")).period is None


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
