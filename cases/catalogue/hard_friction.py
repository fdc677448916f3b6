"""Hard: friction from next to none to more than rigid contact bears. Gravity pulls along −Y."""

from math import pi

from cases import case, disc
from cases.catalogue.common_scenes import case_on_track, ellipse_plate
from cases.catalogue.odd_wheels import rod_on_tip
from cases.errors import positive
from cases.library import circle, line


@case(
    hard="friction of a millionth: nine hours and seventeen kilometres of slip before the disc rolls",
    outcome="rolls from v0/(3 μ g) on",
)
def long_slide(mu=1e-6, v0=1.0, r=0.1, m=1.0, g=9.81):
    """Bowling on ice: a disc thrown along a level line that hardly brakes it.

    Why: a step that resolves the disc's own time, √(r/g), is taken half a million times.
    Source: derived, as for `disc_on_line`.
    Known exactly: it rolls from t = v0/(3 μ g) on, at 2 v0/3, after 5 v0²/(18 μ g). The case lasts a tenth longer.
    """
    positive("mu of long_slide", mu)
    return case_on_track(line(), disc(r, m), mu, g, 1.1 * v0 / (3.0 * mu * g), slip=positive("v0 of long_slide", v0))


@case(
    hard="friction of a millionth: the slip reverses at the end of each swing with next to no spin to show for it",
    outcome="the slip reverses near each end of the swing; it never rolls",
)
def nearly_smooth(mu=1e-6, amplitude=1.0, R=1.0, r=0.1, m=1.0, g=9.81, duration=6.0):
    """A disc swinging in a circle that is all but smooth.

    Source: the paper's application, Ogaru & Pandrea 4.2, in the limit of small μ₀.
    Known exactly: as μ → 0 a pendulum of length R − r, the slip reversing where it turns.
    """
    return case_on_track(circle(R), disc(r, m), mu, g, duration, xi1=-pi / 2 - amplitude)


@case(
    variants=[dict(mu=1.0), dict(mu=3.0), dict(mu=10.0)],
    hard="friction many times the normal force: what slips jams within milliseconds, or pole-vaults",
    outcome="slips for an instant, then rolls; a long plate meets the paradox or leaves, reported with its place",
)
def sticky_ellipse(mu=3.0, a=0.15, b=0.1, slip=-1.0, omega=0.0, tilt=0.4, m=1.0, g=9.81, duration=0.6):
    """An elliptic plate thrown along a level line with very much friction.

    Source: this suite's.
    Known exactly: 1 + (h_t² − h_t h_n k)m/J, with h the arm to the contact and k = ∓μ, must stay positive.
    """
    return case_on_track(line(), ellipse_plate(a, b, m), mu, g, duration, xi2=-pi / 2 + tilt, slip=slip, omega=omega)


@case(
    variants=[dict(mu=1.0), dict(mu=1.34), dict(mu=5.0), dict(mu=10.0), dict(mu=2.0)],
    hard="Painlevé: above μ = 4/3 there are angles at which rigid Coulomb contact has no unique force",
    outcome="below 4/3 it slides on or sticks; above, it leaves the line or meets the paradox, reported with its place",
)
def rod_into_the_paradox(mu=2.0, angle=0.1, omega=5.0, v0=10.0, length=1.0, tip=1e-3, m=1.0, g=9.81, duration=0.5):
    """Painlevé's rod, its tip leading, turning up from a flat angle towards the angles of the paradox, tan φ = 2.

    Source: Painlevé (1895), Génot & Brogliato, Eur. J. Mech. A/Solids (1999) (known to us, not looked up); derived as
    in
    `sliding_rod`.
    Known exactly: the paradox's angles are those with 1 + 3 cos²φ ≤ 3 μ cos φ (sin φ + 2 tip/length): none below
    μ = 4/3, atan 2 alone at 4/3 (for tip → 0).
    """
    half, tip = positive("length of rod_into_the_paradox", length) / 2, positive("tip of rod_into_the_paradox", tip)
    return case_on_track(line(), rod_on_tip(half, tip, m), mu, g, duration, xi2=-pi / 2 - angle, slip=-v0, omega=omega)
