"""Several discs that move and touch each other on a straight line. Gravity pulls along −Y."""

from math import cos, inf, sin, sqrt

from cases import FreePlate, StartPose, case, disc
from cases.catalogue.common_scenes import case_with_impacts
from cases.errors import not_negative, positive
from cases.library import line


@case(variants=[dict(), dict(mu=0.5)])
def disc_on_free_disc(phi=0.3, mu=0.0, r_lower=0.5, r=0.4, m_lower=2.0, m=1.0, g=9.81, duration=1.3):
    """A disc is let go on top of a free disc on the floor, slides or rolls off, and lands on the floor.

    Why: the plate on which it slides gives way; with friction it rolls first, then slips, then leaves.
    Source: a textbook problem of rigid-body dynamics (known to us, not looked up); derived by momentum and energy.
    Known exactly: without friction it leaves where κ c³ − 3 c + 2 cos φ₀ = 0, c = cos φ, κ = m/(m + m_lower).
    """
    far = positive("r_lower of disc_on_free_disc", r_lower) + positive("r of disc_on_free_disc", r)
    upper = FreePlate(disc(r, m), StartPose(far * sin(phi), r_lower + far * cos(phi)), "upper")
    return case_with_impacts(line(), disc(r_lower, m_lower), mu, g, StartPose(0.0, r_lower), duration, others=(upper,))


@case
def disc_on_free_hemisphere(phi=0.3, mu=0.3, r_base=0.5, r=0.4, m_base=2.0, m=1.0, g=9.81, duration=1.3):
    """A disc is let go on a hemisphere that sticks or slides on the floor with friction.

    Why: a base that does not turn; it sticks to the floor until the disc pushes it off.
    Source: a textbook problem of rigid-body dynamics (known to us, not looked up).
    """
    far = positive("r_base of disc_on_free_hemisphere", r_base) + positive("r of disc_on_free_hemisphere", r)
    upper = FreePlate(disc(r, m), StartPose(far * sin(phi), r_base + far * cos(phi)), "upper")
    start = StartPose(0.0, r_base)
    return case_with_impacts(line(), disc(r_base, m_base, inertia=inf), mu, g, start, duration, others=(upper,))


@case(variants=[dict(), dict(gap=0.0)])
def row_of_discs(gap=0.01, restitution=1.0, speed=1.0, r=0.1, m=1.0, g=9.81, duration=0.95):
    """A disc slides without friction into a row of two equal discs at rest: Newton's cradle on the floor.

    Why: an impact that goes through bodies; apart and touching, the law of impact gives different speeds.
    Source: derived from momentum and the law of impact.
    Known exactly: 0, 0 and 1 times the speed if the discs are apart; −1/3, 2/3 and 2/3 if they touch, by Moreau's law.
    """
    apart = 2.0 * positive("r of row_of_discs", r) + not_negative("gap of row_of_discs", gap)
    others = (FreePlate(disc(r, m), StartPose(0.0, r), "second"), FreePlate(disc(r, m), StartPose(apart, r), "third"))
    start = StartPose(-5.0 * r, r, vx=speed)
    return case_with_impacts(line(), disc(r, m), 0.0, g, start, duration, restitution=restitution, others=others)


@case(variants=[dict(), dict(mu=0.08)])
def pile_of_discs(mu=0.3, r=0.5, m=1.0, g=9.81, duration=1.0):
    """Two discs on the floor that touch, and one on both: they rest, or are pushed apart.

    Why: five contacts hold three bodies, so that the forces are not unique; below the thresholds all of them move.
    Source: a textbook problem of statics (known to us, not looked up); derived by moments.
    Known exactly: it rests if mu ≥ 2 − √3 between the discs and (2 − √3)/3 at the floor.
    """
    r = positive("r of pile_of_discs", r)
    others = (
        FreePlate(disc(r, m), StartPose(r, r), "second"),
        FreePlate(disc(r, m), StartPose(0.0, (1.0 + sqrt(3.0)) * r), "upper"),
    )
    return case_with_impacts(line(), disc(r, m), mu, g, StartPose(-r, r), duration, others=others)
