"""Discs in circles and cycloids whose centres are pendulums, and a ring without gravity. Gravity pulls along −Y."""

from math import pi

from cases import Case, CoulombFriction, Start, Unilateral, case, disc
from cases.catalogue.common_scenes import case_on_track
from cases.library import circle, cycloid


@case
def frictionless_pendulum(amplitude=1.0, R=1.0, r=0.1, m=1.0, g=9.81, duration=2.5):
    """A disc sliding without friction in a circle: a simple pendulum of length R − r, whatever the disc's inertia.

    Why: no transition may be seen here, and the period tests the integration alone over a whole swing.
    Source: Landau & Lifshitz, Mechanics (known to us, not looked up); derived from energy.
    Known exactly: period 4 √((R − r)/g) K(sin²(amplitude/2)); at the bottom N = m g (3 − 2 cos amplitude).
    """
    return case_on_track(circle(R), disc(r, m), None, g, duration, xi1=-pi / 2 - amplitude)


@case
def rolling_pendulum(amplitude=1.0, mu=1.0, R=1.0, r=0.1, m=1.0, g=9.81, duration=2.5):
    """A disc rolling to and fro in a circle: a simple pendulum of length 3(R − r)/2.

    Why: an engine whose disc creeps while it should stick is late here, swing by swing.
    Source: Landau & Lifshitz, Mechanics (known to us, not looked up); derived from energy.
    Known exactly: period 4 √(3(R − r)/(2g)) K(sin²(amplitude/2)), while tan(amplitude) ≤ 3 μ.
    """
    return case_on_track(circle(R), disc(r, m), mu, g, duration, xi1=-pi / 2 - amplitude)


@case
def cardano_disc(amplitude=1.0, mu=1.0, R=1.0, m=1.0, g=9.81, duration=1.5):
    """A disc rolling in a circle of twice its size: every point of its rim runs to and fro on a straight line.

    Why: the whole path of a point of the plate is known, not only times.
    Source: Cardano's straight line (1570, known to us, not looked up); derived: two turns at opposite rates add to a
    line.
    Known exactly: the rim point that touches at the start stays on the track's diameter through that place.
    """
    return case_on_track(circle(R), disc(R / 2, m), mu, g, duration, xi1=-pi / 2 - amplitude)


@case(variants=[dict(s0=-0.5), dict(s0=-2.0)])
def cycloidal_pendulum(s0=-2.0, a=0.25, r=0.1, m=1.0, g=9.81, duration=2.2):
    """A disc sliding without friction with its centre on a cycloid: isochronous.

    Why: however far out it is let go (`s0`, the cycloid's parameter), it is back after the same time.
    Source: Huygens, Horologium oscillatorium (1673, known to us, not looked up); derived: the height is s²/(8a), s the
    arc.
    Known exactly: period 4π √(a/g), for every s0.
    """
    return case_on_track(cycloid(a, offset=r), disc(r, m), None, g, duration, xi1=s0)


@case
def rolling_on_cycloid(s0=-1.0, mu=0.5, a=0.25, r=0.1, m=1.0, g=9.81, duration=2.5):
    """The same disc rolling: still isochronous, √(3/2) slower.

    Source: derived, Huygens' property with the rolling disc's mass 3m/2 along the path.
    Known exactly: period 4π √(3a/(2g)), for every s0 from which it rolls.
    """
    return case_on_track(cycloid(a, offset=r), disc(r, m), mu, g, duration, xi1=s0)


@case
def disc_in_weightless_ring(v0=2.0, mu=0.3, shape=0.5, R=1.0, r=0.1, m=1.0):
    """A disc thrown along the inside of a ring on a smooth table: only its own path presses it against the ring.

    Why: the one slip with an exact solution on a curve in elementary functions; no gravity to hide behind.
    Source: Kleppner & Kolenkow, An Introduction to Mechanics (known to us, not looked up); derived: dv/dt = −μ v²/(R −
    r).
    Known exactly: v = v0/(1 + μ v0 t/(R − r)) while it slips, until v = v0/(1 + shape) at t = shape·(R − r)/(μ v0), an
    angle ln(1 + shape)/μ from the start; then it rolls at that speed for ever. The case lasts twice that time.
    """
    return Case(
        track=circle(R),
        plate=disc(r, m, shape * m * r**2),
        effects=(CoulombFriction(mu), Unilateral()),
        start=Start(xi1=0.0, slip=v0),
        duration=2.0 * shape * (R - r) / (mu * v0),
    )
