"""Discs on straight tracks: bowling and the inclined plane. `shape` is J/(m r²): ½ disc, 1 hoop, ⅖ as a sphere's."""

from cases import case, disc
from cases.catalogue.common_scenes import case_on_track
from cases.errors import positive
from cases.library import line


@case(variants=[dict(mu=0.1), dict(mu=0.3)])
def disc_on_line(v0=1.0, mu=0.1, r=0.1, m=1.0, g=9.81):
    """Bowling: a disc thrown along a level line at v0 without spin slips, then rolls.

    Source: a textbook exercise; Drake's `multibody/benchmarks/bowling_ball` has it with side-spin (looked up). Derived:
    friction brakes with μ g and spins up with 2 μ g/r.
    Known exactly: it rolls from t = v0/(3 μ g) on, at 2 v0/3 (for J = m r²/2). The case lasts twice that time.
    """
    positive("mu of disc_on_line", mu)
    positive("v0 of disc_on_line", v0)
    positive("g of disc_on_line", g)
    return case_on_track(line(), disc(radius=r, mass=m), mu, g, 2.0 * v0 / (3.0 * mu * g), slip=v0)


@case(
    variants=[
        dict(backspin=2.0),
        dict(backspin=-2.5),
        dict(backspin=1.0, shape=1.0),
        dict(shape=0.4),
    ]
)
def thrown_with_spin(v0=1.0, backspin=0.0, shape=0.5, mu=0.2, r=0.1, m=1.0, g=9.81):
    """A wheel thrown along a level line at v0 with back-spin (rim speed `backspin`, m/s; top-spin if negative).

    Why: friction may brake, drive or turn the wheel back; only the inertia's `shape` and the spin decide.
    Source: billiards; Coriolis (1835) and Sommerfeld, Mechanics (known to us, not looked up). Derived: v − shape·r ω is
    conserved.
    Known exactly: it rolls after abs(v0 + backspin)/(μ g (1 + 1/shape)), at (v0 − shape·backspin)/(1 + shape): 5/7 of
    v0 for a sphere without spin, and at rest for a hoop whose back-spin is v0. The case lasts twice that time.
    """
    slip = positive("v0 of thrown_with_spin", v0) + backspin
    positive("mu of thrown_with_spin", mu), positive("shape of thrown_with_spin", shape)
    plate, duration = disc(r, m, shape * m * r**2), 2.0 * abs(slip) / (mu * g * (1.0 + 1.0 / shape))
    return case_on_track(line(), plate, mu, g, duration, slip=slip, omega=backspin / r)


@case(variants=[dict(slope=0.2), dict(slope=0.29), dict(slope=0.3), dict(slope=0.4)])
def disc_on_incline(slope=0.2, mu=0.1, shape=0.5, r=0.1, m=1.0, g=9.81, duration=1.0):
    """A disc let go on an incline of angle `slope` (rad): it rolls or it slips for ever.

    Source: a textbook problem; Drake has it in `multibody/plant/test/inclined_plane_test.cc` (looked up). Derived:
    rolling takes a third of m g sin(slope) from friction.
    Known exactly: it rolls if tan(slope) ≤ 3 μ, with acceleration (2/3) g sin(slope); else it slips with
    g (sin(slope) − μ cos(slope)). For μ = 0.1 the two part at 0.29146 rad. In general tan(slope) ≤ μ (1 + 1/shape).
    """
    return case_on_track(line(slope), disc(r, m, shape * m * r**2), mu, g, duration)
