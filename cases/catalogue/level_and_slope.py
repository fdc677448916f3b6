"""Discs on straight tracks: bowling and the inclined plane."""

from cases import Case, CoulombFriction, Curve, Gravity, Start, Unilateral, case, disc
from cases.curves import cos, sin
from cases.errors import positive


@case(variants=[dict(mu=0.1), dict(mu=0.3)])
def disc_on_line(v0=1.0, mu=0.1, r=0.1, m=1.0, g=9.81):
    """Bowling: a disc thrown along a level line at v0 without spin slips, then rolls.

    Source: a textbook exercise, e.g. Goldstein, Poole & Safko, Classical Mechanics (rolling with slipping); also
    Drake's benchmark `bowling_ball`.
    Known exactly: it rolls from t = v0/(3 μ g) on, at 2 v0/3 (for J = m r²/2). The case lasts twice that time.
    """
    positive("mu of disc_on_line", mu)
    positive("v0 of disc_on_line", v0)
    positive("g of disc_on_line", g)
    return Case(
        track=Curve(lambda s: (s, 0)),
        plate=disc(radius=r, mass=m),
        effects=(Gravity(g), CoulombFriction(mu), Unilateral()),
        start=Start(xi1=0.0, slip=v0),
        duration=2.0 * v0 / (3.0 * mu * g),
    )


@case(variants=[dict(slope=0.2), dict(slope=0.4)])
def disc_on_incline(slope=0.2, mu=0.1, r=0.1, m=1.0, g=9.81, duration=1.0):
    """A disc let go on an incline of angle `slope` (rad): it rolls or it slips for ever.

    Source: the textbook problem; also Drake's benchmark `inclined_plane`.
    Known exactly: it rolls if tan(slope) ≤ 3 μ, with acceleration (2/3) g sin(slope); else it slips with
    g (sin(slope) − μ cos(slope)).
    """
    slope = float(slope)
    return Case(
        track=Curve(lambda s: (s * cos(slope), -s * sin(slope))),
        plate=disc(radius=r, mass=m),
        effects=(Gravity(g), CoulombFriction(mu), Unilateral()),
        start=Start(xi1=0.0),
        duration=duration,
    )
