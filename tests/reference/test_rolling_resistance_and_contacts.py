"""Rolling resistance at several contacts: exact motions, two formulations, the paper's matrix, and what is rejected."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

from cases import (
    Belt,
    Case,
    CoulombFriction,
    Effect,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    RollingResistance,
    StartPose,
    Support,
    Unilateral,
    disc,
)  # fmt: skip
from cases.library import line
from tests.sampling import quick_every

from .test_belts_and_supports import METHODS, motion_by

G, R = 9.81, 0.2
INELASTIC = Gravity(G), Unilateral(), Flight(), Impact(0.0, "moreau")
# For a disc of 1 kg: its moment of inertia.
J = 0.5 * R * R
# A few roundings of the numbers that give a time of about a second.
EXACT = 1e-12


def begins_at(time: float, method: str):
    """A time at which a rest ends: the second formulation compares rates with 1e-12 of those without contact forces,
    which they exceed up to 1.3e-11 s later here."""
    return pytest.approx(time, abs=2e-11 if method == "second" else EXACT)


def surface(mu: float, arm: float, *more: Effect) -> tuple[Effect, ...]:
    """Friction and rolling resistance of a track or a support, and more."""
    return CoulombFriction(mu), RollingResistance(arm), *more


def corner(
    floor: tuple[Effect, ...], wall: tuple[Effect, ...], *more: Effect, slope=0.0, duration=2.0, away=0.0, **how
):
    """A disc of 1 kg, `away` from a wall on its left that is normal to the floor; the floor rises to the right."""
    s, n = R + away, R
    start = StartPose(s * cos(slope) - n * sin(slope), s * sin(slope) + n * cos(slope), **how)
    effects, support = (*INELASTIC, *floor, *more), Support(line(pi / 2 - slope), "wall", wall)
    return Case(line(-slope), disc(R, 1.0), effects, start, duration, supports=(support,))


# --- exact motions ----------------------------------------------------------------------------------------------------

# A V of two planes, inclined by these angles; friction and arm of each.
LEFT, RIGHT = (0.6, 0.3, 0.01), (0.9, 0.2, 0.03)


def disc_in_v(*more: Effect, omega: float = 0.0, duration: float = 2.0) -> Case:
    """A disc of 1 kg that touches both planes."""
    (a, *left), (b, *right) = LEFT, RIGHT
    far = R / sin(a + b)
    start = StartPose(far * (cos(b) - cos(a)), far * (sin(a) + sin(b)), omega=omega)
    effects, wall = (*INELASTIC, *surface(*left), *more), Support(line(-b), "right", surface(*right))
    return Case(line(a), disc(R, 1.0), effects, start, duration, supports=(wall,))


def forces_in_v(sense: float) -> tuple[np.ndarray, float]:
    """The normal forces of a disc that turns in that sense in the V, and the moment of both contacts against it.

    Its surface slips along both planes: N₁ (n₁ − s μ₁ t₁) + N₂ (n₂ − s μ₂ t₂) balances the weight, and each contact
    resists with μ R N and its own couple c N.
    """
    columns = []
    for angle, (_, mu, _) in ((-LEFT[0], LEFT), (RIGHT[0], RIGHT)):
        tangent, normal = np.array([cos(angle), sin(angle)]), np.array([-sin(angle), cos(angle)])
        columns.append(normal - sense * mu * tangent)
    normal_forces = np.linalg.solve(np.array(columns).T, [0.0, G])
    return normal_forces, float(
        sum(N * (mu * R + arm) for N, (_, mu, arm) in zip(normal_forces, (LEFT, RIGHT), strict=True))
    )


@quick_every(6)
@METHODS
@pytest.mark.parametrize("omega", [25.0, -25.0])
def test_a_disc_that_spins_in_a_v_is_stopped_by_friction_and_couples_of_both_contacts(method, omega):
    """J ω̇ = −Σ (μ R + c) N is constant."""
    motion = motion_by(disc_in_v(omega=omega), method)
    _, moment = forces_in_v(np.sign(omega))
    slips = Mode.SLIP_FORWARD if omega > 0.0 else Mode.SLIP_BACKWARD
    assert {(t.contact, t.before, t.after) for t in motion.transitions} == {
        ("plate/track", slips, Mode.REST), ("plate/right", slips, Mode.REST),
    }  # fmt: skip
    assert [t.time for t in motion.transitions] == pytest.approx([abs(omega) * J / moment] * 2, abs=EXACT)


@quick_every(2)
@METHODS
def test_a_disc_held_in_a_v_begins_to_turn_where_friction_and_couples_of_both_contacts_are_used_up(method):
    _, moment = forces_in_v(1.0)
    motion = motion_by(disc_in_v(Load(moment="0.9*t"), duration=1.2 * moment / 0.9), method)
    assert [(t.before, t.after) for t in motion.transitions] == [(Mode.REST, Mode.SLIP_FORWARD)] * 2
    assert all(t.time == begins_at(moment / 0.9, method) for t in motion.transitions)


@quick_every(2)
@METHODS
def test_a_disc_that_rolls_down_into_a_wall_is_lifted_by_it(method):
    """Rolling: (3/2) v̇ = g sin α − (c/R) g cos α. The wall takes the speed v with the impulse v per mass; its friction
    lifts the disc with μ v, and with its couple takes (μ R + c) v/J of the spin. Then the wall alone bears g sin α."""
    slope, arm, mu_wall, arm_wall, away = 0.3, 0.01, 0.15, 0.02, 0.5
    case = corner(surface(0.5, arm), surface(mu_wall, arm_wall), slope=slope, away=away)
    motion = motion_by(case, method)
    falls, presses = G * cos(slope), G * sin(slope)
    rate = (presses - arm / R * falls) / 1.5
    meets = sqrt(2.0 * away / rate)
    speed = rate * meets
    flies = 2.0 * mu_wall * speed / (falls - mu_wall * presses)
    changes = [(t.contact, t.before, t.after) for t in motion.transitions[:3]]
    assert changes[:2] == [
        ("plate/track", Mode.ROLL, Mode.FLIGHT), ("plate/wall", Mode.FLIGHT, Mode.SLIP_FORWARD),
    ]  # fmt: skip
    assert changes[2][:2] == ("plate/track", Mode.FLIGHT)
    assert [t.time for t in motion.transitions[:3]] == pytest.approx([meets, meets, meets + flies], abs=EXACT)
    if method != "second":  # whose states are not kept between events
        middle = meets + 0.5 * flies
        spin = speed / R - (mu_wall * R + arm_wall) / J * (speed + 0.5 * flies * presses)
        assert motion(middle).omega == pytest.approx(spin, abs=1e-11)


@quick_every(2)
@METHODS
def test_a_disc_between_belt_and_wall_begins_to_turn_where_the_wall_is_no_longer_pressed_enough(method):
    """It stands on the running belt while μ R N_b ≤ (μ_w R + c) N_w, with N_w = F + μ N_b and N_b = g + μ_w N_w."""
    mu, mu_wall, arm, rate = 0.2, 0.1, 0.01, 4.0
    limit = (mu_wall * R + arm) / (mu * R)  # N_b/N_w
    on_wall = G / (limit - mu_wall)
    press = on_wall * (1.0 - mu * limit)
    case = corner((CoulombFriction(mu), Belt(-5.0)), surface(mu_wall, arm), Load(fx=f"-{press + rate!r} + {rate!r}*t"))
    change = motion_by(case, method).transitions[0]
    assert (change.contact, change.before) == ("plate/wall", Mode.REST)
    assert change.time == begins_at(1.0, method)


# --- plates with corners ----------------------------------------------------------------------------------------------

WALL = Support(line(pi / 2), "wall")
