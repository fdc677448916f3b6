"""The laws of friction, restitution and rolling that Exudyn's parameters stand for.

Parameter names are those of its manual's items ObjectContactSphereSphere and ObjectContactSphereTriangle; the laws are
as measured in `tests/adapters`.
"""

from cases import Belt, Case, CoulombFriction, Drive, Impact, PerfectlyRough, RollingResistance

from ..common.impacts import plates_touch
from ..interface import Meaning


def _differs(case: Case) -> bool:
    impact = case.effect(Impact)
    return bool(impact and impact.restitution and plates_touch(case))


MEANINGS = (
    Meaning(
        CoulombFriction,
        "dynamicFriction of the contact; frictionProportionalZone (m/s)",
        "Coulomb's law, regularised: below the zone's slip velocity friction is proportional to it, so stick creeps; "
        "mu(v) by Stribeck's law only (ObjectContactConvexRoll)",
        routes=("native",),
    ),
    Meaning(
        CoulombFriction,
        "none: this suite supplies the contact law",
        "the same form, with mu or mu(v), computed in Python; the engine only integrates it",
        routes=("integrator",),
    ),
    Meaning(PerfectlyRough, "a constraint on lines (ObjectJointRollingDisc), else unbounded friction", "no slip"),
    Meaning(
        Impact,
        "restitutionCoefficient with impactModel 2 and minimumImpactVelocity; for e = 0 contactDamping, critical",
        "a spring and a damper during some periods of the spring, with Coulomb's friction; e is a ratio of velocities; "
        "discs that touch are springs in a row",
        routes=("native",),
        differs=_differs,
        duration="some periods, 2 pi sqrt(m/k), of the contact's spring; the setting has its stiffness k",
    ),
    Meaning(
        Impact, "none: the suite's contact law has a damper and no restitution", "not supported", routes=("integrator",)
    ),
    Meaning(RollingResistance, "none", "not supported"),
    Meaning(
        Belt, "none: the surface is that of a heavy body", "its slip is that on the moving body", routes=("native",)
    ),
    Meaning(Belt, "none: this suite supplies the contact law", "its slip is that on the belt", routes=("integrator",)),
    Meaning(
        Drive,
        "none: the engine computes in the frame of the track",
        "the loads of the track's motion on the plate",
    ),
)
