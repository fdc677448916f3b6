"""Plates on a track and further supports, and blocks on a plane: several contacts, with corners. Gravity pulls along
−Y."""

from math import cos, pi, sin

from cases import CoulombFriction, Curve, Outline, Plate, StartPose, Support, arc, case, disc
from cases.catalogue.common_scenes import case_with_impacts
from cases.errors import not_negative, positive
from cases.library import line


def _stop(x: float, y: float, slope: float) -> Support:
    """A straight support through (x, y) across a plane that falls to the right; the plate is uphill of it."""
    return Support(Curve(lambda s: (x + s * sin(slope), y + s * cos(slope))), "stop")


def _rod(half: float, thickness: float, m: float) -> Plate:
    """A homogeneous rod whose centre of mass is on its upper side: thin, but for its outline."""
    outline = Outline.polygon([(-half, -thickness), (half, -thickness), (half, 0.0), (-half, 0.0)])
    return Plate(outline, m, m * half * half / 3)


def _capsule(half: float, radius: float, m: float) -> Plate:
    """A rod with round ends, their centres `half` from its middle, with the inertia of a thin rod of length 2 half."""
    right = arc((half, 0.0), radius, -pi / 2, pi / 2)
    left = arc((-half, 0.0), radius, pi / 2, 3 * pi / 2)
    top = Outline.polygon([(half, radius), (-half, radius), (-half, -radius), (half, -radius)]).pieces
    return Plate(Outline((right, top[0], left, top[2])), m, m * half * half / 3)


@case(variants=[dict(), dict(mu=0.1, mu_wall=0.2)])
def ladder_at_wall(angle=1.2, mu=0.0, mu_wall=0.0, half=1.0, m=1.0, g=9.81, duration=1.2):
    """A ladder slides down a wall: its lower end on the floor, its upper end at the wall, until it leaves the wall.

    Why: two contacts with corners on two supports of different friction; one of them opens by the motion of both.
    Source: a textbook problem of rigid-body dynamics (known to us, not looked up); derived by the energy.
    Known exactly: without friction it leaves the wall where sin θ = (2/3) sin θ₀, at a time by quadrature.
    """
    half = positive("half of ladder_at_wall", half)
    own = (CoulombFriction(mu_wall),) if not_negative("mu_wall", mu_wall) else ()
    start = StartPose(half * cos(angle), half * sin(angle), pi - angle)
    plate = _rod(half, 0.02 * half, m)
    return case_with_impacts(line(), plate, mu, g, start, duration, supports=(Support(line(pi / 2), "wall", own),))


@case
def round_ladder_at_wall(angle=1.2, half=1.0, radius=0.05, m=1.0, g=9.81, duration=1.2):
    """A ladder with round ends slides down a wall without friction.

    Why: the contacts lie on arcs, and move along them.
    Source: derived: both forces point to the centres of the ends, so these move as the ends of a thin ladder.
    Known exactly: it leaves the wall where sin θ = (2/3) sin θ₀, at the time of the ladder with sharp ends.
    """
    half, radius = positive("half of round_ladder_at_wall", half), positive("radius of round_ladder_at_wall", radius)
    start = StartPose(radius + half * cos(angle), radius + half * sin(angle), pi - angle)
    plate = _capsule(half, radius, m)
    return case_with_impacts(line(), plate, 0.0, g, start, duration, supports=(Support(line(pi / 2), "wall"),))


@case(variants=[dict(slope=0.3, mu=0.2), dict(slope=0.6, mu=0.9), dict(slope=0.6, mu=0.52)])
def block_on_incline(slope=0.3, mu=0.2, width=1.0, height=2.0, m=1.0, g=9.81, duration=1.0):
    """A block stands flat on an incline with a stop far below and is let go: it rests, slides, tips, or does both.

    Why: two corners share the load; where one lifts, the friction of the other decides.
    Source: a textbook problem of statics (known to us, not looked up); derived. The variants slide, tip, and do both.
    Known exactly: it slides by g (sin α − μ cos α) if μ < tan α and μ < width/height; it rests below both limits.
    """
    half = 0.5 * positive("width of block_on_incline", width)
    high = 0.5 * positive("height of block_on_incline", height)
    supports = (_stop(10 * high * cos(slope), -10 * high * sin(slope), slope),)
    start = StartPose(high * sin(slope), high * cos(slope), -slope)
    plate = Plate.rectangle(2 * half, 2 * high, m)
    return case_with_impacts(line(slope), plate, mu, g, start, duration, supports=supports)


@case(variants=[dict(), dict(slenderness=1.0, height=0.5, duration=0.5)])
def rocking_block(tilt=0.1, slenderness=0.25, height=2.0, mu=2.0, m=1.0, g=9.81, duration=3.0):
    """A slender block rocks on a plane from one lower corner to the other, away from a wall.

    Why: each impact hands the load from corner to corner; engines with a fixed step lose another part of the spin. A
    square block, which keeps a quarter of it, comes to rest.
    Source: Housner 1963 (Bull. Seism. Soc. Am. 53, 403; known to us, not looked up); derived by angular momentum.
    Known exactly: each impact multiplies the spin by 1 − (3/2) sin² α, tan α = width/height.
    """
    high = 0.5 * positive("height of rocking_block", height)
    half = high * positive("slenderness of rocking_block", slenderness)
    # It stands on its lower left corner, which is at the origin less half its width.
    x, y = cos(tilt) * half - sin(tilt) * high, sin(tilt) * half + cos(tilt) * high
    plate = Plate.rectangle(2 * half, 2 * high, m)
    supports = (_stop(5 * high, 0.0, 0.0),)
    return case_with_impacts(line(), plate, mu, g, StartPose(x - half, y, tilt), duration, supports=supports)


@case
def disc_spinning_in_v(incline=pi / 6, mu=0.3, omega=20.0, r=0.5, m=1.0, g=9.81, duration=2.0):
    """A disc spins in a V of two planes and stops.

    Why: two slipping contacts share the load, and end together.
    Source: derived: friction μN at both contacts, S (1 + μ²) cos α = m g for the sum S of the normal forces.
    Known exactly: it stops after r ω₀ (1 + μ²) cos α/(2 μ g), as long as μ < tan α.
    """
    start = StartPose(0.0, r / cos(incline), omega=omega)
    supports = (Support(line(-incline), "right"),)
    return case_with_impacts(line(incline), disc(r, m), mu, g, start, duration, supports=supports)
