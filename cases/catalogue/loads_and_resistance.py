"""Loads, rolling resistance, contacts that never slip, guides that never let go. Gravity pulls along −Y."""

from math import pi, sqrt

from cases import Case, CoulombFriction, Gravity, Load, PerfectlyRough, RollingResistance, Start, case, disc
from cases.catalogue.common_scenes import case_on_track
from cases.library import circle, cosine, line


@case
def disc_rolling_to_rest(v0=1.0, mu=0.3, arm=0.005, r=0.1, m=1.0, g=9.81, duration=4.0):
    """A sliding disc begins to roll, slows down and stops: rolling resistance on a level line.

    Why: three modes and an end at which everything is exactly zero.
    Source: Popov, Contact Mechanics and Friction (2010, known to us, not looked up); derived from the law as stated.
    Known exactly: it rolls after v0/(g (3 μ − 2 arm/r)), then slows down by (2/3) g arm/r and stops.
    """
    return case_on_track(line(), disc(r, m), mu, g, duration, RollingResistance(arm), slip=v0)


@case
def disc_in_sticky_valley(arm=0.01, mu=0.5, xi1=-0.6, r=0.1, m=1.0, g=9.81, duration=6.0):
    """A disc rolls to and fro in y = −0.1 cos 2x and is held where the slope is below arm/r.

    Why: it comes to rest off the bottom, at a place that only the resistance decides.
    Source: posed here.
    Known exactly: it stops where |tan of the slope| is at most arm/r.
    """
    return case_on_track(cosine(0.1, 2.0), disc(r, m), mu, g, duration, RollingResistance(arm), xi1=xi1)


@case
def disc_on_spring(k=40.0, mu=0.1, stretch=0.2, r=0.1, m=1.0, g=9.81, duration=3.0):
    """A disc on a level line at the end of a spring: friction decides at which stretch it begins to slip.

    Why: a load that depends on the pose; rolling and slipping alternate while the amplitude falls.
    Source: posed here; textbook oscillator.
    Known exactly: while it rolls, ω² = 2 k/(3 m); it rolls while k |x|/3 is at most μ m g.
    """
    return case_on_track(line(), disc(r, m), mu, g, duration, Load(fx=f"-{k}*x"), xi1=stretch)


@case
def driven_disc(torque=0.4, frequency=6.0, mu=0.15, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A wheel driven to and fro by a moment in time: it spins where the moment is too much for friction.

    Why: a load in time; slip begins and ends twice in each period.
    Source: posed here.
    Known exactly: while it rolls, friction is two thirds of the moment over r: it slips beyond (3/2) μ m g r.
    """
    return case_on_track(line(), disc(r, m), mu, g, duration, Load(moment=f"-{torque}*sin({frequency}*t)"))


@case
def rough_disc_in_circle(R=1.0, r=0.1, m=1.0, xi1=0.0, g=9.81, duration=2.5):
    """The disc of `disc_in_circle` without a bound on friction: it rolls from the start, also on a vertical wall.

    Why: what rolling alone would do; the difference to `disc_in_circle` is all slip.
    Source: posed here; Ogaru & Pandrea, 4.2, have the disc in the circle with bounded friction.
    Known exactly: (3/4)(R − r) ξ̇² + g sin ξ is constant: a pendulum of length (3/2)(R − r).
    """
    return Case(
        track=circle(R),
        plate=disc(r, m),
        effects=(Gravity(g), PerfectlyRough()),
        start=Start(xi1=xi1),
        duration=duration,
    )


@case
def guided_loop(ratio=4.0, mu=0.05, R=1.0, r=0.1, m=1.0, g=9.81, duration=1.5):
    """A disc in a bilateral guide goes through the top of a loop, too slow for a unilateral one.

    Why: the normal force changes sign, and friction goes on with its magnitude.
    Source: posed here; the roller coaster with wheels on both sides of its rail.
    Known exactly: without friction it passes the top if v0² is at least 4 g (R − r).
    """
    return Case(
        track=circle(R),
        plate=disc(r, m),
        effects=(Gravity(g), CoulombFriction(mu)),
        start=Start(xi1=-pi / 2, slip=sqrt(ratio * g * (R - r))),
        duration=duration,
    )
