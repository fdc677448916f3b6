"""What Exudyn's parameters make of friction, restitution and rolling (its manual's items ObjectContactSphereSphere and
ObjectContactSphereTriangle, whose names stand here; the laws as measured in `tests/adapters`)."""

from cases import CoulombFriction, Impact, PerfectlyRough, RollingResistance

from ..interface import Meaning

MEANINGS = (
    Meaning(
        CoulombFriction,
        "dynamicFriction of the contact; frictionProportionalZone (m/s)",
        "Coulomb's, regularised: below the zone's slip velocity friction grows in proportion, so what sticks creeps",
        routes=("native",),
    ),
    Meaning(
        CoulombFriction,
        "none: the law handed over is this suite's",
        "of the same form, in Python: only its integration is the engine's",
        routes=("integrator",),
    ),
    Meaning(PerfectlyRough, "a constraint on lines (ObjectJointRollingDisc), else friction without bound", "no slip"),
    Meaning(
        Impact,
        "restitutionCoefficient with impactModel 2 and minimumImpactVelocity; for e = 0 contactDamping, critical",
        "a spring and a damper for some periods of the spring; Coulomb's friction along its course; e as a ratio of "
        "velocities",
        routes=("native",),
    ),
    Meaning(Impact, "none: the law handed over has a damper", "refused", routes=("integrator",)),
    Meaning(RollingResistance, "none", "refused"),
)
