"""Plates with several contacts on curves: a rod and a block in bowls, a disc between two hills. Gravity pulls along
−Y."""

from math import cos, pi, sin, sqrt

from cases import Curve, Outline, Plate, StartPose, Support, case, disc
from cases.catalogue.common_scenes import case_with_impacts
from cases.curves import cos as cosine
from cases.curves import sin as sine
from cases.errors import positive
from cases.library import circle, parabola


def _hill(radius: float, x: float) -> Curve:
    """The outside of a circle about (x, 0)."""
    return Curve(lambda s: (x + radius * sine(s), radius * cosine(s)))


@case(variants=[dict(), dict(angle=0.7, mu=0.2)])
def rod_in_bowl(angle=0.5, mu=0.0, R=2.0, half=1.0, m=1.0, g=9.81, duration=3.0):
    """A rod stands with both ends in a circular bowl and is let go at an angle: it swings, or slides until it stops.

    Why: two corners slide on one curve; the contacts' frames turn while the plate does.
    Source: textbook problems of mechanics (known to us, not looked up); derived by moments about the bowl's centre.
    Known exactly: without friction it is a physical pendulum, with the period 4 K(sin θ₀/2)/ω₀; with friction it rests
    up to an angle in closed form, and stops at a time by quadrature.
    """
    half, radius = positive("half of rod_in_bowl", half), positive("R of rod_in_bowl", R)
    low = 0.02 * half
    outline = Outline.polygon([(-half, -low), (half, -low), (half, low), (-half, low)])
    depth = sqrt(radius * radius - half * half) - low
    start = StartPose(depth * sin(angle), -depth * cos(angle), angle)
    return case_with_impacts(circle(radius), Plate(outline, m, m * half * half / 3), mu, g, start, duration)


@case
def block_into_bowl(tilt=0.4, omega=1.0, mu=0.2, focus=0.5, width=0.8, height=0.5, m=1.0, g=9.81, duration=2.5):
    """A block falls into a parabolic bowl, lands on one corner and then on the other, slides and stops.

    Why: landings of corners on a curve with ends, the second one while the first corner slides.
    Source: derived: the time of its first landing is that of a free fall with constant spin.
    """
    plate = Plate.rectangle(width, height, m)
    return case_with_impacts(parabola(focus), plate, mu, g, StartPose(0.2, 3.0 * focus, tilt, omega=omega), duration)


@case
def disc_between_hills(tilt=0.3 * pi, mu=0.3, omega=20.0, R=1.0, r=0.5, m=1.0, g=9.81, duration=2.0):
    """A disc spins in the notch between two round hills and stops.

    Why: two slipping contacts on two curved supports share the load, and end together.
    Source: derived: friction μN at both contacts, S (1 + μ²) cos α = m g for the sum S of the normal forces, with the
    normals inclined by ±α (`tilt`).
    Known exactly: it stops after r ω₀ (1 + μ²) cos α/(2 μ g), as long as μ < tan α.
    """
    far = (positive("R of disc_between_hills", R) + positive("r of disc_between_hills", r)) * sin(tilt)
    start = StartPose(0.0, far * cos(tilt) / sin(tilt), omega=omega)
    track = _hill(R, -far)
    return case_with_impacts(track, disc(r, m), mu, g, start, duration, supports=(Support(_hill(R, far), "right"),))
