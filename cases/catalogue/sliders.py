"""Plates that do not turn: blocks, sliders, particles. Gravity pulls along −Y."""

from math import inf, pi

from cases import Belt, Case, CoulombFriction, Load, Start, Unilateral, case, disc, effects
from cases.catalogue.common_scenes import case_on_track
from cases.library import circle, line

# Slopes (rad) and coefficients of a grid, on both sides of tan(slope) = mu.
GRID = [dict(), *(dict(slope=slope, mu=mu) for slope in (0.1, 0.3) for mu in (0.2, 0.5))]


@case(variants=GRID)
def block_on_ramp(v0=1.0, slope=0.0, mu=0.25, r=0.1, m=1.0, g=9.81, duration=1.5):
    """A block pushed up a ramp: it stops, and stays if tan(slope) <= mu, else it slides back.

    Why: the first friction test of every engine; a block is a disc that cannot turn.
    Source: Galileo's incline with Coulomb's law; derived: v̇ = −g (sin slope + mu cos slope).
    Known exactly: it stops after v0/(g (sin slope + mu cos slope)); on the level at v0²/(2 mu g).
    """
    return case_on_track(line(-slope), disc(r, m, inf), mu, g, duration, slip=v0)


@case
def particle_around_capstan(v0=2.0, mu=0.2, R=1.0, r=0.1, m=1.0, duration=4.0):
    """A particle slides around the inside of a ring without gravity: its speed falls as a rope's force on a capstan.

    Why: only the curvature presses; friction falls with the square of the speed, and it never stops.
    Source: derived: m v dv/ds = −mu m v²/R, as for the rope of Eytelwein and Euler.
    Known exactly: v = v0 exp(−mu φ) after the angle φ, v = v0/(1 + mu v0 t/(R − r)).
    """
    return Case(
        track=circle(R),
        plate=disc(r, m, inf),
        effects=(CoulombFriction(mu), Unilateral()),
        start=Start(xi1=0.0, slip=v0),
        duration=duration,
    )


@case
def slider_on_spring(k=40.0, mu=0.1, stretch=0.5, r=0.1, m=1.0, g=9.81, duration=6.0):
    """A block on a level line at the end of a spring: half swings about ±mu m g/k until friction holds it.

    Why: every half swing loses the same amplitude; where it stops is decided by friction alone.
    Source: textbook oscillator with dry friction; derived.
    Known exactly: it turns every π √(m/k), each time nearer by 2 mu m g/k, and rests where k |x| ≤ mu m g.
    """
    return case_on_track(line(), disc(r, m, inf), mu, g, duration, Load(fx=-k * effects.MOTION[1]), xi1=stretch)


@case
def particle_in_bowl(mu=0.15, xi1=-0.3, R=1.0, r=0.1, m=1.0, g=9.81, duration=4.0):
    """A particle released in a circular bowl swings with friction until it rests off the bottom.

    Why: the paper's scene without rotation: the normal force depends on speed and place.
    Source: derived: u = φ̇² obeys du/dφ ± 2 mu u = …, linear, in each half swing.
    """
    return case_on_track(circle(R), disc(r, m, inf), mu, g, duration, xi1=xi1)


@case
def slider_on_belt(speed=0.2, k=40.0, mu=0.2, mu_static=0.4, r=0.1, m=1.0, g=9.81, duration=6.0):
    """A block held by a spring on a belt sticks, is carried along, and slips back: stick-slip.

    Why: the standard oscillator of stick-slip; its period is exact.
    Source: known to us from texts on friction oscillators, not looked up; derived.
    Known exactly: the slip phase is a half swing about mu m g/k, the stick phase ends at mu_static m g/k.
    """
    load, friction = Load(fx=-k * effects.MOTION[1]), CoulombFriction(mu, mu_static)
    return case_on_track(line(), disc(r, m, inf), friction, g, duration, load, Belt(speed), xi1=pi / 100)
