"""The application of Ogaru & Pandrea, section 4.2."""

from math import pi

from cases import Case, CoulombFriction, Gravity, Start, Unilateral, case, disc
from cases.library import circle


@case(variants=[dict(mu=0.01), dict(mu=0.1), dict(mu=0.2)])
def disc_in_circle(R=1.0, r=0.1, m=1.0, mu=0.1, xi1=0.0, g=9.81, duration=2.5):
    """A disc let go inside a circle: the paper's application, its equations (35).

    Source: Ogaru & Pandrea, "On the motion of a plate forced to move with friction over a fixed curve", 4.2. The
    paper gives μ₀ = 0.01, 0.1, 0.2 and neither sizes nor start; R = 1 m, r = 0.1 m, m = 1 kg and release at rest at
    the horizontal radius are this suite's. The Y axis points down, as (35) implies: gravity pulls along +Y.

    Known exactly: while v > 0, u = ξ̇₁² obeys a linear equation in ξ₁, so the first zero of v is a quadrature. What
    follows depends on μ₀: the slip reverses for 0.01 and 0.1, the disc rolls for 0.2 (the paper says it always
    rolls). A hard start: v = 0 and N = 0 at the same time.
    """
    return Case(
        track=circle(R),
        plate=disc(radius=r, mass=m),
        effects=(Gravity(g, direction=pi / 2), CoulombFriction(mu), Unilateral()),
        start=Start(xi1=xi1),
        duration=duration,
    )
