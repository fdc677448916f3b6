"""A plate that touches its track in several places. Gravity pulls along −Y."""

from math import pi, tan

from cases import Curve, Flight, Impact, case, disc
from cases.catalogue.common_scenes import case_on_track
from cases.curves import sqrt


def _groove(incline: float, rounding: float) -> Curve:
    """A hyperbola with asymptotes at ±incline (rad): a V whose bottom has the radius rounding/tan(incline)."""
    return Curve(lambda s: (s, tan(incline) * sqrt(s * s + rounding**2)), domain=(-4, 4))


@case(variants=[dict(), dict(incline=0.7, duration=1.5)])
def disc_rocking_in_groove(incline=pi / 9, rounding=0.01, mu=1.0, r=0.5, m=1.0, g=9.81, duration=4.0):
    """A disc rolls down a flank of a groove that it bridges, hits the other flank, and rolls up there: it rocks.

    Why: contacts that open and close in turn by inelastic impacts, ever faster. Between steep flanks it comes to rest.
    Source: posed here; derived: angular momentum about the new contact.
    Known exactly: every hand-over multiplies the spin by (1 + 2 cos 2α)/3, α the flanks' incline at the contacts.
    """
    track = _groove(incline, rounding)
    return case_on_track(track, disc(r, m), mu, g, duration, Flight(), Impact(0.0, "moreau"), xi1=-1.2 * r)
