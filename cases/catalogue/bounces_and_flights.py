"""Plates that leave their track and come back: flight, landing, impact, bouncing to rest. Gravity pulls along −Y."""

from math import pi, sqrt

from cases import Case, CoulombFriction, Curve, Flight, Gravity, Impact, Plate, Start, Unilateral, case, disc
from cases import curves as c
from cases.library import circle, ellipse, line

from .odd_wheels import eccentric


@case(variants=[dict(e=0.5), dict(e=0.8)])
def bouncing_disc(e=0.5, mu=0.2, height=0.5, slip=1.0, omega=0.0, r=0.1, m=1.0, g=9.81, duration=4.0):
    """A disc thrown flat over a level floor: it bounces until it does not, slipping at first, then rolling.

    Why: infinitely many impacts in a finite time; friction acts in instants.
    Source: Routh, Dynamics of a System of Rigid Bodies (1905), impacts; Zeno's bouncing ball.
    Known exactly: it comes to rest at sqrt(2 h/g) (1 + e)/(1 − e); the flights are a geometric series.
    """
    return Case(
        track=line(),
        plate=disc(r, m),
        effects=(Gravity(g), CoulombFriction(mu), Unilateral(), Flight(), Impact(e)),
        start=Start(xi1=0.0, gap=height, slip=slip, omega=omega),
        duration=duration,
    )


@case
def disc_off_ramp(e=0.3, mu=0.4, speed=1.3, r=0.05, m=1.0, g=9.81, duration=1.5):
    """A disc rolls over the crest of y = exp(−4 x²), leaves it, lands on the flank, bounces and rolls on.

    Why: lift-off, a search for the landing, oblique impacts and an accumulation, one after the other.
    Source: the smooth cousin of the ski jump; posed here.
    Known exactly: each flight's centre runs on a parabola.
    """
    return Case(
        track=Curve(lambda s: (s, c.exp(-4.0 * s**2)), domain=(-8, 8)),
        plate=disc(r, m),
        effects=(Gravity(g), CoulombFriction(mu), Unilateral(), Flight(), Impact(e)),
        start=Start(xi1=0.0, omega=-speed / r),
        duration=duration,
    )


@case
def disc_across_circle(e=0.6, mu=0.3, xi1=0.5, r=0.1, m=1.0, g=9.81, duration=3.0):
    """A disc let go against the upper wall of a circle falls off at once, crosses it and bounces on the other side.

    Why: contact is lost at time zero and found again in another place.
    Source: posed here.
    Known exactly: the fall until the first impact is a parabola inside a circle of radius R − r.
    """
    return Case(
        track=circle(1.0),
        plate=disc(r, m),
        effects=(Gravity(g), CoulombFriction(mu), Unilateral(), Flight(), Impact(e)),
        start=Start(xi1=xi1),
        duration=duration,
    )


@case
def tumbling_ellipse(e=0.4, mu=0.3, height=0.4, omega=4.0, a=0.2, b=0.1, m=1.0, g=9.81, duration=1.0):
    """A spinning ellipse dropped on a line: impacts off the centre, where friction and spin trade places.

    Why: slip reverses within an impact; what follows depends on the angle at which it lands.
    Source: Wang & Mason, "Two-dimensional rigid-body collisions with friction", J. Appl. Mech. 59 (1992).
    Known exactly: it lands when its centre is sqrt(a² sin² θ + b² cos² θ) high; no impact adds energy.
    """
    return Case(
        track=line(),
        plate=Plate(ellipse(a, b), m, 0.25 * m * (a * a + b * b)),
        effects=(Gravity(g), CoulombFriction(mu), Unilateral(), Flight(), Impact(e)),
        start=Start(xi1=0.0, xi2=-pi / 2, gap=height, omega=omega),
        duration=duration,
    )


@case
def hopping_hoop(mu=0.6, share=0.7, angle=0.4, push=1.0, e=0.0, r=0.5, m=1.0, g=9.81, duration=1.2):
    """Littlewood's hoop, pushed: it rolls, slips both ways, hops when the weight comes down, lands and slips on.

    Why: the hop that was argued about for a century, and the landing nobody computed. `share` is the weight's share of
    the mass, `angle` its place from the top, `push` the spin at the start in units of sqrt(g/r). Let go at the top it
    does not hop (`littlewood_hoop`).
    Source: Littlewood, A Mathematician's Miscellany (1953); Tokieda, "The hopping hoop", Am. Math. Monthly 104 (1997);
    Butler, "Hopping hoops don't hop", Am. Math. Monthly 106 (1999).
    Known exactly: while it rolls, (1 + share cos φ) ω² + share (g/r) cos φ is constant, φ from the top.
    """
    offset = share * r
    return Case(
        track=line(),
        plate=Plate(eccentric(r, offset), m, m * (r**2 - offset**2)),
        effects=(Gravity(g), CoulombFriction(mu), Unilateral(), Flight(), Impact(e)),
        start=Start(xi1=0.0, xi2=angle - pi, omega=-push * sqrt(g / r)),
        duration=duration,
    )
