"""The laws of friction, restitution and rolling that pymunk's parameters stand for.

`Shape.friction` and `Shape.elasticity` as in pymunk's manual; the laws are as measured in
`tests/adapters/test_impact_laws.py`.
"""

from cases import Belt, CoulombFriction, Drive, Impact, PerfectlyRough, RollingResistance

from ..common.impacts import MOREAU, not_moreaus
from ..interface import Meaning

MEANINGS = (
    Meaning(
        CoulombFriction,
        "friction of both shapes, multiplied; here mu and 1, with supports 1 and mu, of free plates the root of mu "
        "each; a support's own, and mu(v), are friction of the contact, set in each step",
        "Coulomb's cone for the impulses of a step, one coefficient for slip and stick; mu(v) at the slip velocity "
        "predicted for its middle",
        routes=("native",),
    ),
    Meaning(
        CoulombFriction,
        "friction of both shapes, multiplied; here mu and 1; mu(v) is friction of the contact, set in each step",
        "Coulomb's cone for the impulses of a step, with mu at the slip velocity predicted for its middle",
        routes=("assisted",),
    ),
    Meaning(PerfectlyRough, "friction", "Coulomb's cone with a coefficient of 1e9"),
    Meaning(
        Impact,
        "elasticity of both shapes, multiplied; here e and 1, of free plates the root of e each",
        MOREAU,
        routes=("native",),
        differs=not_moreaus,
        duration="one step",
    ),
    Meaning(
        Impact,
        "none: a contact that the adapter sets closes without restitution",
        f"{MOREAU}, e = 0",
        routes=("assisted",),
        differs=not_moreaus,
        duration="one step",
    ),
    Meaning(RollingResistance, "none", "not supported"),
    Meaning(
        Belt,
        "surface_velocity of the segments; of each contact where the speed changes with time, on a hill, or on a "
        "track that turns",
        "Coulomb's law for the slip on that surface, its speed in the middle of each step",
        routes=("native",),
    ),
    Meaning(
        Belt,
        "surface_velocity of the contact",
        "Coulomb's law for the slip on that surface, its speed in the middle of each step",
        routes=("assisted",),
    ),
    Meaning(
        Drive,
        "a kinematic body, its velocities set in each step by velocity_func",
        "the track is where it is at the beginning of each step",
        routes=("native",),
    ),
    Meaning(
        Drive,
        "none: the engine computes in the frame of the track",
        "the loads of the track's motion on the plate",
        routes=("assisted",),
    ),
)
