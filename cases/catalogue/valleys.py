"""Discs let go at rest on the flanks of valleys that are no circles. Gravity pulls along −Y.

Known exactly for each (derived: (3/2) s″ = −g s/(ρ − r) for the centre's arc s): a disc rolling
near the bottom, where the radius of curvature is ρ, swings with 2π √(3(ρ − r)/(2g)) in the limit of small swings.
"""

from cases import case, disc
from cases.catalogue.common_scenes import case_on_track
from cases.library import catenary, cosine, ellipse, parabola, trochoid


@case
def disc_in_ellipse(xi1=-2.8, mu=0.1, a=1.0, b=0.6, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc in an elliptic bowl: the simplest track whose curvature changes, tightest where the disc starts.

    Source: posed here. ρ = a²/b.
    """
    return case_on_track(ellipse(a, b), disc(r, m), mu, g, duration, xi1=xi1)


@case
def disc_in_parabola(xi1=-0.8, mu=0.15, focus=0.4, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc in a parabolic valley: curvature falls off quickly, and so does the normal force's share.

    Source: this suite's; a particle on a parabola, here with size and friction. ρ = 2·focus.
    """
    return case_on_track(parabola(focus), disc(r, m), mu, g, duration, xi1=xi1)


@case
def disc_in_cosine(xi1=-1.0, mu=0.1, depth=0.3, wavenumber=2.0, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc let go on the flank of a cosine: the normal force changes with a curvature that changes its sign.

    Source: this suite's standard corrugated track. ρ = 1/(depth·wavenumber²).
    """
    return case_on_track(cosine(depth, wavenumber), disc(r, m), mu, g, duration, xi1=xi1)


@case
def disc_in_catenary(xi1=-0.7, mu=0.1, a=0.5, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc in a hanging chain's valley: a transcendental track, for engines that need it as points.

    Source: this suite's. ρ = a, derived from y″ = 1/a at the bottom.
    """
    return case_on_track(catenary(a), disc(r, m), mu, g, duration, xi1=xi1)


@case
def disc_on_trochoid(xi1=-2.0, mu=0.1, a=0.5, arm=0.3, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc on a bumpy road, the path of a point inside a wheel: wide valleys and sharp crests.

    Source: this suite's. ρ = (a + arm)²/arm, derived from x′ = a + arm and y″ = arm at the bottom.
    """
    return case_on_track(trochoid(a, arm), disc(r, m), mu, g, duration, xi1=xi1)
