"""Elliptic plates: the contact point moves in the plate, so mass, curvature and normal force work together.

`tilt` is the outline's parameter from the end of the short half-axis b, which is down at tilt = 0. Gravity pulls
along −Y.

Known exactly (derived: rolled by the arc s the plate turns by θ = s/q and its centre rises by (q − b) θ²/2; Routh's and
Lamb's rocking stones, known to us, not looked up): flat on its long side, with contact
radius ρ = a²/b and track radius ρ′ (positive for a hill), a plate that rolls is stable if 1/b > 1/ρ + 1/ρ′ and rocks
with ω² = g (q − b)/(k² + b²), 1/q = 1/ρ + 1/ρ′, k² = (a² + b²)/4, in the limit of small swings.
"""

from math import pi

from cases import case
from cases.catalogue.common_scenes import case_on_track, ellipse_plate
from cases.library import circle, hill, line


@case(variants=[dict(mu=0.05), dict(mu=1.0)])
def ellipse_on_line(mu=1.0, tilt=0.6, a=0.3, b=0.2, m=1.0, g=9.81, duration=2.0):
    """An elliptic plate rocking on a level line: it rolls where friction is high, else slip comes and goes.

    Source: derived above. Small swings that roll have ω² = 4 g (a² − b²)/(b (a² + 5 b²)).
    """
    return case_on_track(line(), ellipse_plate(a, b, m), mu, g, duration, xi2=-pi / 2 + tilt)


@case
def ellipse_on_ice(tilt=0.6, a=0.3, b=0.2, m=1.0, g=9.81, duration=2.0):
    """The same without friction: the centre of mass moves up and down only.

    Source: derived above. Known exactly: x is constant and energy is; small swings have
    ω² = 4 g (a² − b²)/(b (a² + b²)).
    """
    return case_on_track(line(), ellipse_plate(a, b, m), None, g, duration, xi2=-pi / 2 + tilt)


@case
def ellipse_on_incline(slope=0.2, mu=0.08, tilt=0.2, a=0.2, b=0.17, m=1.0, g=9.81, duration=1.2):
    """An elliptic plate let go on an incline: it tumbles down, faster at each turn.

    Source: this suite's; a plate of changing radius on Galileo's plane.
    """
    return case_on_track(line(slope), ellipse_plate(a, b, m), mu, g, duration, xi2=-pi / 2 + tilt)


@case
def ellipse_in_circle(mu=0.2, xi1=-2.4, tilt=0.3, R=1.0, a=0.3, b=0.2, m=1.0, g=9.81, duration=2.0):
    """An elliptic plate let go inside a circle: the paper's general case, both contact parameters at work.

    Source: Ogaru & Pandrea, sections 2 to 4.1, whose equations are written for any two curves.
    """
    return case_on_track(circle(R), ellipse_plate(a, b, m), mu, g, duration, xi1=xi1, xi2=-pi / 2 + tilt)


@case
def ellipse_on_hill(mu=1.0, tilt=0.3, R=1.0, a=0.3, b=0.2, m=1.0, g=9.81, duration=2.0):
    """A rocking stone: an elliptic plate on a round hill, stable although it stands on a summit.

    Source: derived above. It falls off if 1/b < b/a² + 1/R.
    """
    return case_on_track(hill(R), ellipse_plate(a, b, m), mu, g, duration, xi2=-pi / 2 + tilt)
