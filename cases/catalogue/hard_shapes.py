"""Hard: curves that all but coincide, all but vanish, or turn over. Gravity pulls along −Y."""

from math import pi, sqrt

from cases import Curve, Plate, case, disc
from cases.catalogue.common_scenes import case_on_track, ellipse_plate
from cases.errors import positive
from cases.library import circle, cosine, ellipse, hill, line, superellipse


@case(
    variants=[dict(gap=1e-2), dict(gap=1e-4), dict(gap=1e-6), dict(gap=1e-8)],
    hard="the curvatures of plate and track agree but for `gap` of themselves; what they differ by has few digits left",
    outcome="the paper's motion, with times that scale as √gap; no better than the digits of R − r",
)
def nearly_conforming(gap=1e-4, mu=0.2, R=1.0, g=9.81):
    """A disc that all but fills the circle it is let go in, r = R(1 − gap): a shaft in its bearing.

    Why: the contact runs round the circle while the plate hardly moves; ξ₁ and ξ₂ agree to as many digits as `gap` has.
    Source: the paper's application, Ogaru & Pandrea 4.2, where only R − r occurs; the limit is this suite's.
    Known exactly: all times are those of `disc_in_circle` times √((R − r)/0.9 m).
    """
    r = positive("R of nearly_conforming", R) * (1 - gap)
    return case_on_track(circle(R), disc(r, 1.0), mu, g, 2.5 * sqrt((R - r) / 0.9), xi1=-pi)


@case(
    variants=[dict(gap=1e-2), dict(gap=1e-4), dict(gap=1e-6)],
    hard="at the bottom the radii of curvature agree but for `gap`: there the contact runs 1/gap times as fast",
    outcome="swings through the bottom, pressed by up to v²/(gap·ρ), and slips there",
)
def tightest_fit(gap=1e-4, mu=0.2, amplitude=0.5, a=0.6, b=1.0, m=1.0, g=9.81, duration=1.0):
    """A disc in an elliptic bowl whose tightest place it fits by a hair: r = ρ(1 − gap), ρ = a²/b.

    Why: the centre's path has all but a corner at the bottom, where everything happens in a time ∝ gap.
    Source: this suite's; the small swings are derived as in `ellipse_on_line`.
    Known exactly: where the plate fits, its centre's path has the radius ρ − r.
    """
    r = a * a / b * (1 - gap)
    return case_on_track(ellipse(a, b), disc(r, m), mu, g, duration, xi1=-pi / 2 - amplitude)


@case(
    variants=[dict(mu=0.1), dict(mu=0.1, omega=-10.0), dict(mu=0.5, omega=-12.0)],
    hard="an outline fifty times as long as wide: its curvature changes by a factor of 125,000 round the plate",
    outcome="rocks and slips on its flat side, or falls over its sharp end",
)
def sliver(mu=0.1, tilt=0.02, slip=0.0, omega=0.0, a=0.5, b=0.01, m=1.0, g=9.81, duration=1.0):
    """An ellipse of half-axes 0.5 m and 0.01 m on a level line, let go a little off its flat side.

    Why: ξ₂ hardly moves while the contact runs from end to end, and the other way round at the ends.
    Source: this suite's; a flat stone.
    Known exactly: the curvature is b/a² = 0.04 1/m on the flat side and a/b² = 5000 1/m at the ends.
    """
    return case_on_track(line(), ellipse_plate(a, b, m), mu, g, duration, xi2=-pi / 2 + tilt, slip=slip, omega=omega)


@case(
    variants=[dict(exponent=16.0), dict(exponent=8.0)],
    hard="the outline's sides are flat to high order: their curvature is zero to rounding over half of their length",
    outcome="rocks on the hill, its contact running along the flat side",
)
def flat_sided(exponent=8.0, mu=0.6, tilt=0.3, R=1.0, a=0.2, b=0.15, m=1.0, g=9.81, duration=1.0):
    """A superellipse with nearly flat sides and tight corners, rocking on a round hill.

    Why: derivatives of the outline up to the third vanish on the side and are huge in the corners.
    Source: Lamé's curve, Piet Hein's superellipse (known to us, not looked up); the scene is this suite's.
    Known exactly: at the middle of a side the curvature and its derivative vanish for every exponent above 3.
    """
    plate = Plate(superellipse(a, b, int(exponent)), m, m * (a * a + b * b) / 3)
    return case_on_track(hill(R), plate, mu, g, duration, xi2=-pi / 2 + tilt)


@case(
    variants=[dict(mu=0.05), dict(mu=0.5)],
    hard="the track's curvature goes through zero, where R_s, and with it what hangs on it, vanishes or turns over",
    outcome="nothing is to be seen at an inflection: the motion is as smooth as the track",
)
def over_inflections(mu=0.05, depth=0.05, wavenumber=4.0, speed=0.6, a=0.1, b=0.06, m=1.0, g=9.81, duration=2.5):
    """An elliptic plate sent along a wavy road, over one inflection after another.

    Source: this suite's; the road is its standard corrugation.
    Known exactly: the inflections lie where cos(wavenumber·x) = 0.
    """
    plate = ellipse_plate(a, b, m)
    return case_on_track(cosine(depth, wavenumber), plate, mu, g, duration, xi1=-1.5, xi2=-pi / 2 + 0.2, slip=speed)


@case(
    variants=[dict(power=3.0), dict(power=5.0)],
    hard="at the start the track's curvature, and for power 5 its first two derivatives as well, vanish",
    outcome="the disc rolls or slips off as from a straight incline, and follows the bend",
)
def released_at_an_inflection(power=3.0, slope=0.5, mu=0.1, r=0.1, m=1.0, g=9.81, duration=0.7):
    """A disc let go on y = −slope·x + x^power, exactly at the inflection.

    Source: this suite's; the incline it begins with is the textbooks'.
    Known exactly: at the start it moves as on an incline: it slips for slope > 3 μ, with N = m g cos(atan slope).
    """
    n = int(power)
    return case_on_track(Curve(lambda s: (s, -slope * s + s**n), domain=(-1.5, 1.2)), disc(r, m), mu, g, duration)
