"""Hard: starts where several things vanish at once, to the last bit or all but. Gravity pulls along −Y."""

from math import pi, sqrt

import numpy as np

from cases import case, disc
from cases.catalogue.common_scenes import case_on_track, ellipse_plate
from cases.errors import positive
from cases.library import circle, line


@case(
    variants=[dict(mu=0.001), dict(mu=0.3), dict(mu=3.0), dict(mu=0.3, tilt=0.5)],
    hard="v = 0 and N = 0 together: friction has no size and no direction; N grows with the square of time",
    outcome="slips downwards at once, pressed from the second derivative on; no lift-off at time zero",
)
def degenerate_release(mu=0.3, tilt=0.0, a=0.15, b=0.1, R=1.0, m=1.0, g=9.81, duration=0.8):
    """An elliptic plate let go at rest where the inside of a circle is vertical.

    Why: the start of `disc_in_circle`, for a plate that is no disc; `tilt` moves the contact off the plate's axis.
    Source: posed here; Ogaru & Pandrea, 4.2, have the disc in the circle and do not say where it starts.
    Known exactly: at rest with a vertical tangent N = 0 and N' = 0, whatever the plate.
    """
    return case_on_track(circle(R), ellipse_plate(a, b, m), mu, g, duration, xi2=tilt)


@case(
    variants=[dict(slip=1e-17), dict(slip=-1e-17), dict(slip=1e-12), dict(slip=-1e-12)],
    hard="the start slips by a rounding error of its speeds (1e-17 m/s at 1 m/s), or by little more",
    outcome="rolls: at once where the slip is below the speeds' rounding, after some 1e-12 s where it is above",
)
def almost_rolling(slip=1e-17, speed=1.0, slope=0.1, mu=0.2, r=0.1, m=1.0, g=9.81, duration=1.0):
    """A disc sent down an incline in rolling, its slip computed by hand and off by a rounding error.

    Why: independent coordinates have no gap to be wrong by; what a start can be off by is its slip. A solver that asks
    for v == 0 takes the wrong mode and stays in it.
    Source: this suite's; the rolling itself is the textbooks' (tan(slope) ≤ 3 μ).
    Known exactly: it rolls with acceleration (2/3) g sin(slope); a slip of 1e-12 m/s ends after
    slip/(3 μ g cos(slope) ∓ g sin(slope)).
    """
    spin = -speed / positive("r of almost_rolling", r)
    return case_on_track(line(slope), disc(r, m), mu, g, duration, slip=slip, omega=spin)


def touching_slip_velocity(mu: float, R: float, r: float, g: float, xi1: float, rate: float) -> float:
    """The slip velocity (m/s) that just comes down to zero without crossing it.

    A disc in a circle that slips forward while its contact runs back (`rate` < 0) obeys, with u = ξ̇₁² and L = R − r,
    du/dξ = (2g/L)(μ sin ξ − cos ξ) − 2μ u, which is linear, and v' = −g cos ξ − 3μ(L u − g sin ξ) does not depend on v:
    the lowest v is the start's plus an integral that ends where v' = 0.
    """
    L = R - r
    A = 2 * g / L * (2 * mu**2 - 1) / (1 + 4 * mu**2)
    B = 2 * mu * (A - g / L)
    C = (rate**2 - A * np.sin(xi1) - B * np.cos(xi1)) * np.exp(2 * mu * xi1)

    def u(xi):
        return A * np.sin(xi) + B * np.cos(xi) + C * np.exp(-2 * mu * xi)

    def slip_rate(xi):
        return -g * np.cos(xi) - 3 * mu * (L * u(xi) - g * np.sin(xi))

    low, high = -pi / 2 - 1.0, xi1  # v' is positive on the far flank and negative on the near one
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slip_rate(middle) > 0 else (low, middle)
    # Forty Gauss points are exact to rounding for an arc on which everything is smooth.
    nodes, weights = np.polynomial.legendre.leggauss(40)
    xi = xi1 + (nodes + 1) / 2 * (high - xi1)
    return float(-np.sum(weights * slip_rate(xi) / -np.sqrt(u(xi))) * (high - xi1) / 2)


@case(
    variants=[dict(above=1e-9), dict(above=-1e-9), dict(above=0.0)],
    hard="the slip velocity comes down to zero with its rate: it touches, misses or crosses by 1e-9 m/s",
    outcome="above: slips on, no transition; below: rolls for some 1e-5 s and slips on; at zero: nobody's to say",
)
def touching_slip(above=1e-9, mu=0.05, rate=-2.0, R=1.0, r=0.1, m=1.0, g=9.81, duration=1.0):
    """A spinning disc running through the bottom of a circle, its slip velocity coming down to `above` (m/s).

    Why: a double zero leaves no change of sign. Where v and v' vanish, rolling takes all the friction there is.
    Source: this suite's; the lowest slip is a quadrature of the linear equation of Ogaru & Pandrea's (35).
    Known exactly: the lowest slip velocity is `above`; where that is zero the answer hangs on the last bit.
    """
    xi1 = -pi / 2 + 0.6
    slip = touching_slip_velocity(mu, R, r, g, xi1, rate) + above
    return case_on_track(circle(R), disc(r, m), mu, g, duration, xi1=xi1, slip=slip, omega=(slip - (R - r) * rate) / r)


@case(
    variants=[dict(duration=1.0), dict(duration=6.0)],
    hard="an unstable equilibrium: every rounding error grows by a factor of 200 a second",
    outcome="stays for a second; after six, where it has gone hangs on the last bit",
)
def balanced_on_its_tip(a=0.2, b=0.1, mu=0.5, m=1.0, g=9.81, duration=1.0):
    """An elliptic plate at rest on the end of its long axis, on a level line.

    Why: nothing is wrong and nothing moves, and yet no solver can say for long where the plate is.
    Source: Routh, Elementary Rigid Dynamics (known to us, not looked up); the ellipse is this suite's.
    Known exactly: it stays; what disturbs it grows as e^(λt), λ² = g (a − b²/a)/(a² + (a² + b²)/4) while it rolls.
    """
    return case_on_track(line(), ellipse_plate(a, b, m), mu, g, duration, xi2=0.0)


@case(
    variants=[dict(part=1e-9), dict(part=-1e-9)],
    hard="at the start friction needs all the cone holds, but for a billionth",
    outcome="part > 0: rolls for ever; part < 0: slips for ever, at part·g·sin(slope)·t",
)
def incline_at_the_cone(part=1e-9, slope=0.3, r=0.1, m=1.0, g=9.81, duration=1.0):
    """A disc let go on an incline whose friction is just enough to roll, or just not: μ = tan(slope)/3·(1 + part).

    Source: derived (rolling takes a third of m g sin(slope), so tan(slope) ≤ 3 μ), at its threshold.
    Known exactly: rolling with (2/3) g sin(slope), or slipping with g (sin(slope) − μ cos(slope)).
    """
    return case_on_track(line(slope), disc(r, m), float(np.tan(slope)) / 3 * (1 + part), g, duration)


@case(
    variants=[dict(part=1e-9), dict(part=-1e-9)],
    hard="friction comes to within a billionth of its cone, or beyond it by as much, at the end of every swing",
    outcome="part > 0: rolls for ever; part < 0: slips for some 1e-5 s at the start, then rolls",
)
def pendulum_at_the_cone(part=1e-9, amplitude=0.8, R=1.0, r=0.1, m=1.0, g=9.81, duration=4.0):
    """A disc rolling to and fro in a circle, μ = tan(amplitude)/3·(1 + part).

    Why: the cone is touched again and again from inside, and nothing may come of it.
    Source: derived, the rolling pendulum at the threshold of slip.
    Known exactly: |T|/N is largest at rest, tan(amplitude)/3; period 4 √(3(R − r)/(2g)) K(sin²(amplitude/2)).
    """
    mu = float(np.tan(amplitude)) / 3 * (1 + part)
    return case_on_track(circle(R), disc(r, m), mu, g, duration, xi1=-pi / 2 - amplitude)


@case(
    variants=[dict(part=1e-9), dict(part=-1e-9)],
    hard="at the top of the loop the normal force is a billionth of its largest, and touches zero",
    outcome="part > 0: goes round and round; part < 0: leaves its track just before the top",
)
def grazing_loop(part=1e-9, R=1.0, r=0.1, m=1.0, g=9.81, duration=2.5):
    """A disc sent round a loop without friction at the critical speed, but for a billionth: v² = 5 g(R − r)(1 + part).

    Source: derived, the loop at its threshold, v² = g L at the top.
    Known exactly: at the top N = 5 part·m g; below the threshold it leaves where cos φ = −1 − 5 part/3, φ from the
    bottom.
    """
    return case_on_track(circle(R), disc(r, m), None, g, duration, xi1=-pi / 2, slip=sqrt(5 * g * (R - r) * (1 + part)))
