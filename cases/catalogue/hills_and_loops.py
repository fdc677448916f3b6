"""Where contact ends: discs leaving a hill, and loops at and around the critical speed. Gravity pulls along −Y."""

from math import cos, pi, sqrt

from cases import case, disc
from cases.catalogue.common_scenes import case_on_track
from cases.library import circle, hill


@case
def disc_sliding_off_hill(angle=0.3, R=1.0, r=0.1, m=1.0, g=9.81, duration=2.0):
    """A disc sliding without friction down a round hill, as if let go at its top; it leaves the hill.

    Why: lift-off, undisturbed by anything else. It starts at `angle` from the top with the speed of a slide from rest.
    Source: Goldstein, Poole & Safko, Classical Mechanics (known to us, not looked up); derived from energy and N = 0.
    Known exactly: it leaves at cos φ = 2/3.
    """
    speed = sqrt(2 * g * (R + r) * (1 - cos(angle)))
    return case_on_track(hill(R), disc(r, m), None, g, duration, xi1=angle, slip=speed)


@case
def disc_rolling_off_hill(mu=0.3, angle=0.3, shape=0.5, R=1.0, r=0.1, m=1.0, g=9.81, duration=2.0):
    """The same disc rolling: before it leaves it must slip, because the normal force vanishes first.

    Why: roll, slip and flight follow each other closely; a solver that takes "rolls until it leaves" is wrong.
    Source: Goldstein, Poole & Safko, Classical Mechanics (known to us, not looked up); derived from energy, N = 0
    and the cone.
    Known exactly: slip begins where shape·sin φ = μ ((3 + shape) cos φ − 2); it leaves between cos φ = 2/3 (no
    friction) and 4/7 (disc that always rolls; 10/17 as a sphere).
    """
    speed = sqrt(2 * g * (R + r) * (1 - cos(angle)) / (1 + shape))
    return case_on_track(hill(R), disc(r, m, shape * m * r**2), mu, g, duration, xi1=angle, omega=-speed / r)


@case(variants=[dict(ratio=4.9), dict(ratio=5.1)])
def sliding_loop(ratio=5.1, R=1.0, r=0.1, m=1.0, g=9.81, duration=1.5):
    """A disc sent round a loop without friction, with v² = ratio·g(R − r) at the bottom.

    Why: on either side of the critical speed the same motion either ends in the air or goes round.
    Source: Halliday, Resnick & Walker, Fundamentals of Physics (known to us, not looked up); derived from energy.
    Known exactly: it goes round for ratio ≥ 5; below (and above 2) it leaves at the angle φ from the bottom with
    cos φ = (2 − ratio)/3. Bottom and top differ by 6 m g in normal force.
    """
    return case_on_track(circle(R), disc(r, m), None, g, duration, xi1=-pi / 2, slip=sqrt(ratio * g * (R - r)))


@case(variants=[dict(ratio=3.5), dict(ratio=5.0)])
def rolling_loop(ratio=5.0, mu=0.5, R=1.0, r=0.1, m=1.0, g=9.81, duration=1.5):
    """A disc rolling round a loop, with v² = ratio·g(R − r) at the bottom.

    Source: Halliday, Resnick & Walker, Fundamentals of Physics (known to us, not looked up); derived from energy.
    Known exactly: while it rolls N = m g (ratio − 4/3 + (7/3) cos φ), so 11/3 is critical for a disc; a slower one
    slips before it leaves, where sin φ = 3 μ (ratio − 4/3 + (7/3) cos φ).
    """
    return case_on_track(circle(R), disc(r, m), mu, g, duration, xi1=-pi / 2, omega=-sqrt(ratio * g * (R - r)) / r)
