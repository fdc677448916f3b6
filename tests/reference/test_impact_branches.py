"""Routh's impact with Poisson's restitution, branch by branch; `test_moreau` has the second formulation's impacts."""

from math import pi
from typing import NamedTuple

import numpy as np
import pytest

from cases import Plate, disc
from cases.library import ellipse
from reference.minimal.impact import ContactVelocity, Law, collide


class Velocities(NamedTuple):
    slip: float
    lift: float
    spin: float


def arms(plate: Plate, xi2: float) -> tuple[float, float]:
    """The contact point from the centre of mass, along the line and its normal."""
    tangent, point = plate.outline.tangent(xi2), plate.outline.point(xi2)
    return float(tangent @ point), float(tangent[0] * point[1] - tangent[1] * point[0])


def routh(plate: Plate, xi2: float, before: Velocities, mu: float, e: float) -> tuple[str, Velocities]:
    """Routh's construction with Poisson's restitution, branch by branch, and the branch's name.

    Per impulse (dT, dP): dv_t = A dT − C dP, dv_n = B dP − C dT. Slip in the direction σ has dT = −σ μ dP and ends at
    P_s = |v_t|/(μ A + σ C); from there it sticks (dT = C/A dP, if that is within ±μ) or slips the other way.
    """
    m, J, (a, b) = plate.mass, plate.inertia, arms(plate, xi2)
    A, B, C = 1 / m + b * b / J, 1 / m + a * a / J, a * b / J
    slip, lift, spin = before
    sigma = np.sign(slip)
    ends = abs(slip) / (mu * A + sigma * C) if mu * A + sigma * C > 0 else np.inf
    held = abs(C) <= mu * A
    first, then = -sigma * mu, C / A if held else np.sign(C) * mu
    if slip == 0.0:
        ends, first = 0.0, then
    compressed = -lift / (B - C * first)
    if compressed > ends:
        compressed = ends - (lift + (B - C * first) * ends) / (B - C * then)
    P = (1 + e) * compressed
    T = first * min(P, ends) + then * max(P - ends, 0.0)
    if slip == 0.0:
        name = "stick from the start" if held else "slip from rest"
    elif P <= ends:
        name = "slip throughout"
    else:
        name = ("slip, stick" if held else "slip, reversed") + (" in restitution" if compressed < ends else "")
    return name, Velocities(slip + A * T - C * P, lift + B * P - C * T, spin + (a * P - b * T) / J)


DISC, PLATE = disc(0.1, 2.0), Plate(ellipse(0.3, 0.05), 1.0, (0.3**2 + 0.05**2) / 4)


@pytest.mark.parametrize(
    "branch, plate, xi2, before, mu, e",
    [
        ("slip throughout", DISC, -pi / 2, (3.0, -1.0, 0.0), 0.2, 0.5),
        ("slip throughout", DISC, -pi / 2, (-3.0, -1.0, 20.0), 0.2, 0.9),
        ("slip, stick", DISC, -pi / 2, (0.5, -2.0, 10.0), 0.3, 0.5),
        ("slip, stick in restitution", DISC, -pi / 2, (1.5, -2.0, 10.0), 0.2, 0.8),
        ("stick from the start", DISC, -pi / 2, (0.0, -2.0, 10.0), 0.2, 0.8),
        ("slip throughout", PLATE, -1.2, (2.0, -1.0, 3.0), 0.2, 0.5),
        ("slip, stick", PLATE, -1.2, (0.3, -1.0, 3.0), 0.8, 0.5),
        ("slip, stick", PLATE, -1.9, (-0.3, -1.0, 3.0), 0.8, 0.5),
        ("slip, reversed", PLATE, -2.4, (0.2, -1.0, 0.0), 0.2, 0.5),
        ("slip, reversed", PLATE, -1.2, (-0.2, -1.0, -3.0), 0.2, 0.5),
        ("slip, reversed in restitution", PLATE, -0.9, (-0.6, -1.0, -3.0), 0.3, 0.9),
        ("slip, stick in restitution", PLATE, -1.2, (-0.6, -1.0, -3.0), 0.4, 0.9),
        ("stick from the start", PLATE, -1.2, (0.0, -1.0, 2.0), 0.9, 0.5),
        ("slip from rest", PLATE, -0.9, (0.0, -1.0, 2.0), 0.3, 0.5),
    ],
)
def test_an_oblique_impact_is_rouths_in_each_of_its_branches(branch, plate, xi2, before, mu, e, accuracy):
    name, exact = routh(plate, xi2, Velocities(*before), mu, e)
    assert name == branch
    law = Law(*arms(plate, xi2), plate.inertia / plate.mass, mu, mu, 0.0, e, "poisson")
    after = collide(law, ContactVelocity(*before))
    accuracy(
        case=f"{branch}, mu={mu:g}, e={e:g}, {before}", solver="reference", route="best",
        quantity="velocities after impact", error=np.max(np.abs(np.subtract(after, exact))), tolerance=1e-12,
    )  # fmt: skip
