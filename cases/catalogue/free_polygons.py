"""A free polygon and a disc on a straight line. Gravity pulls along −Y."""

from math import atan, cos, sin

from cases import FreePlate, Plate, StartPose, case, disc
from cases.catalogue.common_scenes import case_with_impacts
from cases.errors import positive
from cases.library import line


@case(variants=[dict(), dict(mu=0.12)])
def disc_on_free_wedge(mu=0.0, width=2.0, height=1.0, r=0.1, m_wedge=3.0, m=1.0, g=9.81, duration=0.5):
    """A disc is let go on the slope of a wedge that lies on the floor and gives way.

    Why: a plate with corners and edges that moves; with friction it may stick to the floor, where the share of each
    corner in the friction force is not unique.
    Source: a textbook problem of rigid-body dynamics (known to us, not looked up); derived by momentum and energy.
    Known exactly: without friction the wedge accelerates by m g sin α cos α/(M + m sin²α), α the angle of its slope.
    """
    w, h = positive("width of disc_on_free_wedge", width), positive("height of disc_on_free_wedge", height)
    wedge, angle = Plate.polygon([(0.0, 0.0), (w, 0.0), (0.0, h)], m_wedge), atan(h / w)
    high = positive("r of disc_on_free_wedge", r)
    # The centroid is a third of both sides from the right angle; the disc touches a quarter of the slope from the top.
    place = StartPose(0.25 * w + high * sin(angle), 0.75 * h + high * cos(angle))
    start = StartPose(w / 3.0, h / 3.0)
    return case_with_impacts(line(), wedge, mu, g, start, duration, others=(FreePlate(disc(r, m), place, "disc"),))


@case(variants=[dict(), dict(speed=1.5)])
def disc_off_free_block(mu=0.3, speed=0.5, width=1.0, height=0.4, r=0.1, m_block=2.0, m=1.0, g=9.81, duration=1.0):
    """A disc rolls off a block on the floor, over its edge, and lands next to it.

    Why: the contact passes from the flat top to the corner, about which the disc turns until it slips and leaves; a
    faster one leaves at the corner. The block sticks to the floor at two corners.
    Source: this suite.
    """
    w, h = positive("width of disc_off_free_block", width), positive("height of disc_off_free_block", height)
    high = positive("r of disc_off_free_block", r)
    place = StartPose(0.25 * w, h + high, vx=speed, omega=-speed / high)
    others = (FreePlate(disc(r, m), place, "disc"),)
    start = StartPose(0.0, 0.5 * h)
    return case_with_impacts(line(), Plate.rectangle(w, h, m_block), mu, g, start, duration, others=others)


@case(variants=[dict()])
def disc_pushes_block(
    angle=0.4, mu=0.3, spin=20.0, width=0.4, height=0.3, r=0.1, m_block=2.0, m=1.0, g=9.81, duration=0.5
):
    """A disc that spins forwards pushes a block down a slope; both begin at rest.

    Why: one plate drives another through a contact that slips, while the disc slips and rolls on the slope and the
    block slides on two corners.
    Source: this suite; derived by momentum.
    Known exactly: the disc rolls after r spin/(a + 2 mu (N + N_d)/m), where N = 2 mu g cos(angle)/((1 + mu^2)/m +
    (1 - mu^2)/m_block) is the force between both, N_d = m g cos(angle) - mu N that of the slope on the disc, and
    a = g sin(angle) + (mu N_d - N)/m the acceleration of both.
    """
    w, h = positive("width of disc_pushes_block", width), positive("height of disc_pushes_block", height)
    high = positive("r of disc_pushes_block", r)

    def pose_on_slope(along: float, above: float, omega: float = 0.0, theta: float = 0.0) -> StartPose:
        return StartPose(
            along * cos(angle) + above * sin(angle), above * cos(angle) - along * sin(angle), theta, omega=omega
        )

    others = (FreePlate(disc(r, m), pose_on_slope(-0.5 * w - high, high, omega=-spin), "disc"),)
    start = pose_on_slope(0.0, 0.5 * h, theta=-angle)
    return case_with_impacts(line(angle), Plate.rectangle(w, h, m_block), mu, g, start, duration, others=others)
