"""Tracks whose surface runs: conveyors and drums. Gravity pulls along −Y."""

from math import pi

from cases import Belt, case, disc, moving_surface
from cases.catalogue.common_scenes import case_on_track, ellipse_plate
from cases.curves import sin
from cases.library import circle, line


@case(variants=[dict(), dict(speed=-2.0, mu=0.4)])
def disc_on_conveyor(speed=1.0, mu=0.1, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc at rest is set down on a conveyor: it slips until it rolls on the belt.

    Why: the first test of a surface velocity; engines call it a conveyor.
    Source: posed here; derived: friction μ m g gives the speed μ g t and slip 3 μ g t − speed (J = m r²/2).
    Known exactly: it rolls after |speed|/(3 μ g), at a third of the belt's speed, and then needs no friction.
    """
    return case_on_track(line(), disc(r, m), mu, g, duration, Belt(speed), slip=-speed)


@case
def disc_in_drum(speed=2.0, mu=0.3, R=1.0, r=0.1, m=1.0, g=9.81, duration=4.0):
    """A disc at rest is set down at the bottom of a turning drum: it climbs while it slips, then rolls to and fro.

    Why: a belt on a curved track; slip ends while the normal force changes.
    Source: posed here.
    Known exactly: while it rolls, a belt of constant speed changes nothing: a pendulum of length 3 (R − r)/2.
    """
    return case_on_track(circle(R), disc(r, m), mu, g, duration, Belt(speed), xi1=-pi / 2, slip=-speed)


@case
def ellipse_on_surging_belt(mean=0.5, surge=1.5, rate=4.0, mu=0.2, a=0.1, b=0.07, m=1.0, g=9.81, duration=2.0):
    """An elliptic plate on a belt of speed mean + surge sin(rate t): it sticks and slips both ways.

    Why: a belt whose acceleration alone makes the plate slip, under a plate that rocks.
    Source: posed here.
    """
    belt = Belt(mean + surge * sin(rate * moving_surface.TIME))
    return case_on_track(line(), ellipse_plate(a, b, m), mu, g, duration, belt, xi2=-pi / 2)
