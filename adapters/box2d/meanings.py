"""The laws of friction, restitution and rolling that Box2D's parameters stand for, as measured in `tests/adapters`."""

from cases import Belt, Case, CoulombFriction, Drive, Impact, PerfectlyRough, RollingResistance

from ..common.impacts import has_friction, not_moreaus, plates_touch
from ..interface import Meaning


def _differs(case: Case) -> bool:
    impact = case.effect(Impact)
    own = has_friction(case) or not case.plate.radius or plates_touch(case)
    return not_moreaus(case) or bool(impact and impact.restitution and own)


MEANINGS = (
    Meaning(
        CoulombFriction,
        "friction, the geometric mean of both shapes' values; here mu and mu, with supports 1 and mu^2, of free plates "
        "mu and mu_support^2/mu",
        "Coulomb's cone for the impulses of a substep, one coefficient for slip and stick; mu(v) is not supported",
    ),
    Meaning(PerfectlyRough, "friction", "Coulomb's cone with a coefficient of 1e6"),
    Meaning(
        Impact,
        "restitution, the larger of both shapes' values; none below restitution_threshold (default 1 m/s)",
        "friction bounded by the impulse of compression, then Newton's restitution without friction (measured on "
        "circles; polygons deviate more); through discs that touch contact by contact (1 m/s becomes -0.12, 0.24, "
        "0.88)",
        differs=_differs,
        duration="compression in one substep, restitution at the end of the step",
    ),
    Meaning(
        RollingResistance,
        "rolling_resistance, the larger of both shapes' values, times the circle's radius; here arm/r",
        "a couple of at most this lever arm times the normal impulse; circles only",
    ),
    Meaning(
        Belt,
        "tangent_speed of the track's shapes; where the speed changes with time, a line or circle on a kinematic body",
        "Coulomb's law for the slip on that surface; a kinematic body moves with the speed in the middle of each step",
    ),
    Meaning(
        Drive,
        "a kinematic body, its place and velocities set in each step",
        "the track is where it is at the beginning of each step",
    ),
)
