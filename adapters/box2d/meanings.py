"""What Box2D's parameters make of friction, restitution and rolling, as measured here (`tests/adapters`)."""

from cases import Case, CoulombFriction, Impact, PerfectlyRough, RollingResistance

from ..common.impacts import has_friction, not_moreaus
from ..interface import Meaning


def _differs(case: Case) -> bool:
    impact = case.effect(Impact)
    return not_moreaus(case) or bool(impact and impact.restitution and (has_friction(case) or not case.plate.radius))


MEANINGS = (
    Meaning(
        CoulombFriction,
        "friction, the root of both shapes' product; here mu twice",
        "Coulomb's cone on the impulses of a substep, one coefficient for slip and stick",
    ),
    Meaning(PerfectlyRough, "friction", "Coulomb's cone with a coefficient of 1e6"),
    Meaning(
        Impact,
        "restitution, the larger of both shapes'; none slower than restitution_threshold (1 m/s as it comes)",
        "friction bounded by the impulse of compression, then Newton's restitution without friction (measured on "
        "circles; polygons are further off)",
        differs=_differs,
    ),
    Meaning(
        RollingResistance,
        "rolling_resistance, the larger of both shapes', times the circle's radius; here arm/r",
        "a couple of at most that lever times the normal impulse; circles alone",
    ),
)
