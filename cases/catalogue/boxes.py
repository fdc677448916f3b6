"""Plates with a flat side on one straight track: they slide, tip, fall, lie down and rock. Gravity pulls along −Y."""

from math import cos, pi, sin

from cases import Drive, Plate, StartPose, case, moving_surface
from cases.catalogue.common_scenes import case_on_track, case_with_impacts
from cases.curves import sin as sin_of
from cases.errors import positive
from cases.library import line


@case(variants=[dict(), dict(mu=0.4, slope=0.2), dict(mu=0.9, width=0.2, height=0.4, v=1.5)])
def sliding_box(mu=0.3, slope=0.0, v=1.0, width=0.4, height=0.2, m=1.0, g=9.81, duration=1.0):
    """A box slides on its flat side until friction stops it. A slender one tips about its front corner and overturns.

    Why: two corners share the load, the front one carries more, and both stop at one instant.
    Source: a textbook problem of dynamics (known to us, not looked up); derived. The last variant overturns.
    Known exactly: it stops after v/(g (μ cos α − sin α)) if μ < width/height; the front corner carries
    m g cos α (1 + μ height/width)/2. A box that tips stops to slide while it tips.
    """
    half = 0.5 * positive("width of sliding_box", width)
    high = 0.5 * positive("height of sliding_box", height)
    start = StartPose(high * sin(slope), high * cos(slope), -slope, v * cos(slope), -v * sin(slope))
    return case_with_impacts(line(slope), Plate.rectangle(2 * half, 2 * high, m), mu, g, start, duration)


@case(variants=[dict(), dict(tilt=-0.5, drop=0.3, slope=0.2, mu=0.15)])
def dropped_box(tilt=0.3, drop=0.2, slope=0.0, mu=0.9, width=0.4, height=0.2, m=1.0, g=9.81, duration=1.0):
    """A tilted box falls onto a straight track, lands on a corner, turns about it and lies down.

    Why: an impact on a corner, then one along a side; how an engine makes them decides where and when the box rests.
    Source: derived by the angular momentum about the corner, and the energy. The last variant slides on.
    Known exactly: where the corner sticks, and without friction, the box lies down at a time by quadrature.
    """
    plate = Plate.rectangle(positive("width of dropped_box", width), positive("height of dropped_box", height), m)
    start = StartPose(0.0, positive("drop of dropped_box", drop), tilt)
    return case_with_impacts(line(slope), plate, mu, g, start, duration)


@case(variants=[dict(), dict(mu=0.8, width=0.075)])
def box_on_shaken_table(amplitude=0.05, rate=9.0, mu=0.2, width=0.4, height=0.2, m=1.0, g=9.81, duration=1.5):
    """A box stands on a table shaken to and fro, x = amplitude sin(rate t): it slides, a slender one rocks.

    Why: the table's acceleration grows until friction, or the width of the base, no longer holds the box.
    Source: a textbook problem of dynamics (known to us, not looked up); derived. The last variant rocks and overturns.
    Known exactly: with a = amplitude rate² it rests until a sin(rate t) = min(μ, width/height) g.
    """
    high = 0.5 * positive("height of box_on_shaken_table", height)
    plate = Plate.rectangle(positive("width of box_on_shaken_table", width), 2 * high, m)
    start = StartPose(0.0, high, 0.0, amplitude * rate)
    drive = Drive(x=amplitude * sin_of(rate * moving_surface.TIME))
    return case_with_impacts(line(), plate, mu, g, start, duration, drive)


@case(variants=[dict(), dict(mu=0.5)])
def half_disc_rocking(tilt=1.2, mu=0.3, r=0.2, m=1.0, g=9.81, duration=1.5):
    """A half disc rocks on its round side; with little friction it slips in every swing.

    Why: its centre of mass is not the centre of its arc, so the normal force swings, and slip begins and ends twice
    in each period.
    Source: a textbook problem of dynamics (known to us, not looked up); derived. The last variant rolls only.
    Known exactly: while it rolls, (J + m d²) ω²/2 + m g y is constant, d the distance of the centre of mass from the
    contact; J = m r² (1/2 − (4/(3π))²).
    """
    plate = Plate.half_disc(positive("r of half_disc_rocking", r), m)
    return case_on_track(line(), plate, mu, g, duration, xi2=plate.outline.span[0] + pi / 2 + tilt)
