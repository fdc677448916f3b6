"""Edges and corners: a disc that rolls off a table, a block that rocks on a hill, a Reuleaux wheel. Gravity pulls along
−Y."""

from cases import Chain, Plate, case, disc
from cases.catalogue.common_scenes import case_on_track
from cases.errors import positive
from cases.library import hill, line


@case
def disc_over_edge(mu=0.4, v=0.2, way=0.1, r=0.1, m=1.0, g=9.81, duration=1.5):
    """A disc rolls over the edge of a table: it turns about the edge, slips on it, and leaves.

    Why: the contact stays at one point of the track, where the curvature is infinite; an engine that rounds the edge or
    cuts it into facets is wrong there. A disc faster than √(g r) leaves at once.
    Source: derived; the sphere on a sphere's limit of a small one, in many textbooks (known to us, not looked up).
    Known exactly: the edge is reached after way/v; there r φ̇² = v²/r + (4/3) g (1 − cos φ) while it does not slip.
    """
    r, v = positive("radius of the disc", r), positive("v of disc_over_edge", v)
    way = positive("way of disc_over_edge", way)
    track = Chain.polyline([(-way - 4 * r, 0.0), (0.0, 0.0), (0.0, -4 * r)])
    return case_on_track(track, disc(r, m), mu, g, duration, xi1=4 * r, omega=-v / r)


@case
def block_on_hill(mu=0.5, R=1.0, width=0.3, height=0.1, offset=0.1, m=1.0, g=9.81, duration=2.0):
    """A block rocks on a hill: its base rolls, and at its ends its corner slides.

    Why: the curvature of the outline jumps from zero to infinity, and the contact passes between them.
    Source: a rectangular block on a cylinder is a textbook problem of stability (known to us, not looked up); the scene
    with friction and corners is this suite's.
    Known exactly: balanced on top it is stable while height < 2 R. The inertia is m (width² + height²)/12.
    """
    return case_on_track(hill(R), Plate.rectangle(width, height, m), mu, g, duration, xi1=offset)


@case
def reuleaux_on_slope(mu=0.4, slope=0.1, width=0.3, omega=-5.0, m=1.0, g=9.81, duration=1.5):
    """A Reuleaux triangle on a slope: a wheel of constant width with three corners.

    Why: it rolls on arcs, turns about its corners, and slips where the force on them is steep.
    Source: Reuleaux's triangle (known to us, not looked up); the scene is this suite's.
    Known exactly: its width is the same in all directions, its area is (π − √3) width²/2.
    """
    return case_on_track(line(slope), Plate.reuleaux(width, m), mu, g, duration, omega=omega)
