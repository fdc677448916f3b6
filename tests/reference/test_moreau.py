"""Moreau's law of impact: its conditions, its solution by other means, both formulations, what it does to motions."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cases
import reference
from cases import Case, CoulombFriction, Flight, Gravity, Impact, PerfectlyRough, Plate, Start, Unilateral
from cases import RollingResistance as Resistance
from cases.contact import start_motion
from cases.library import ellipse, line
from cases.scene.contact_pairs import pairs
from reference.minimal.impact import ContactVelocity, Law, collide, energy, law_of
from reference.solver.impact import Inertia, impact_of_all
from reference.witness.contacts import pair_at
from reference.witness.impact_laws import velocities
from reference.witness.motion import Simulation
from tests.scenes import second as second_states
from tests.scenes.elliptic import numbers

FLYING = (Gravity(9.81), Unilateral(), Flight())
PLATE = Plate(ellipse(0.3, 0.05), 1.0, (0.3**2 + 0.05**2) / 4)

arms = st.floats(-2.0, 2.0, allow_subnormal=False)
impacts = dict(
    law=st.builds(
        lambda arm_t, arm_n, gyration, mu, e: Law(arm_t, arm_n, gyration, mu, mu, 0.0, e, "moreau"),
        arms, arms, st.floats(0.01, 2.0), st.floats(0.0, 3.0), st.floats(0.0, 1.0),
    ),
    before=st.builds(ContactVelocity, arms, st.floats(-3.0, -1e-3), arms),
)  # fmt: skip


def drawn(whole: int) -> settings:
    """So many examples; a quarter of them in the quick tests."""
    return settings(deadline=None, max_examples=whole // 4 if settings().derandomize else whole)


def matrix(law: Law) -> tuple[float, float, float]:
    """(a, b, c): slip grows by a T + b P, the normal velocity by b T + c P."""
    return (
        1 + law.arm_n**2 / law.gyration,
        -law.arm_t * law.arm_n / law.gyration,
        1 + law.arm_t**2 / law.gyration,
    )


def impulse(law: Law, before: ContactVelocity, after: ContactVelocity) -> tuple[float, float]:
    """(T, P) that makes the one of the other."""
    a, b, c = matrix(law)
    slip, lift = after.slip - before.slip, after.lift - before.lift
    return (c * slip - b * lift) / (a * c - b * b), (a * lift - b * slip) / (a * c - b * b)


class OneContact(NamedTuple):
    """A contact of `solver.impact` between a plate and what is fixed; velocities are along its tangent and normal."""

    lift_row: np.ndarray
    slip_row: np.ndarray
    restitution: float
    sides = (0,)
    turning_row = np.array([0.0, 0.0, 1.0])


@drawn(300)
@given(arm=st.sampled_from([0.0, 0.1]), **impacts)
def test_one_contact_has_the_law_of_several(law, before, arm):
    law = law._replace(arm=arm)
    (slip, lift, omega), arms = before, np.array([arm])
    at = OneContact(np.array([0.0, 1.0, law.arm_t]), np.array([1.0, 0.0, -law.arm_n]), law.restitution)
    inertia = Inertia(np.array([1.0, 1.0, 1.0 / law.gyration]), np.array([1.0, 1.0, law.gyration**0.5]))
    velocity = np.array([slip + omega * law.arm_n, lift - omega * law.arm_t, omega])
    several = impact_of_all("moreau", inertia, velocity, [at], [law.mu], float(np.abs(velocity).max()), arms=arms)
    after = several.slip[0], several.lift[0], several.velocity[2]
    assert after == pytest.approx(collide(law, before), abs=1e-8 * float(np.abs(velocity).max()))


@drawn(300)
@given(**impacts)
def test_the_velocities_after_an_impact_obey_restitution_cone_and_dissipation(law, before):
    after = collide(law, before)
    friction, normal = impulse(law, before, after)
    size = abs(friction) + abs(normal)
    assert after.lift == -law.restitution * before.lift
    assert normal > -1e-9 * size
    assert abs(friction) <= law.mu * normal + 1e-9 * size
    # Friction is at its bound and against the slip where slip is left, up to the rounding of the impulse.
    assert friction * after.slip <= -law.mu * normal * abs(after.slip) + 1e-9 * size * abs(after.slip)
    # What the impulse does to the spin.
    assert after.omega - before.omega == pytest.approx(
        (law.arm_t * normal - law.arm_n * friction) / law.gyration, abs=1e-9 * size / law.gyration
    )


@drawn(300)
@given(**impacts)
def test_the_slip_after_an_impact_is_that_of_a_bisection_over_the_ratio_of_friction(law, before):
    # The slip falls as T/P = −τ goes from −μ to μ wherever P is positive, so that one crossing tells it.
    a, b, c = matrix(law)
    Q = -(1 + law.restitution) * before.lift

    def slip(tau):
        if c - b * tau <= 0.0:  # beyond the pole of P
            return -1.0 if b > 0 else 1.0
        return before.slip + Q * (b - a * tau) / (c - b * tau)

    low, high = -law.mu, law.mu
    if slip(high) >= 0.0:
        tau = high
    elif slip(low) <= 0.0:
        tau = low
    else:
        for _ in range(200):
            tau = 0.5 * (low + high)
            low, high = (tau, high) if slip(tau) > 0.0 else (low, tau)
    scale = abs(before.slip) + Q * (a + abs(b)) * (1 + law.mu) * (1 + abs(b * tau)) / (c - b * tau) ** 2
    assert collide(law, before).slip == pytest.approx(slip(tau), abs=1e-12 * scale)


@pytest.mark.parametrize("lift", [-1.0, -0.3])
@pytest.mark.parametrize("law", cases.effects.IMPACT_LAWS)
def test_a_restitution_that_underflows_is_none(law, lift):
    # Newton's goal, e times the closing speed, is 0 or so small that its product with a rate is.
    before = ContactVelocity(1.0, lift, 0.5)
    least, none = (collide(Law(0.3, 0.2, 0.05, 0.3, 0.3, 0.0, e, law), before) for e in (5e-324, 0.0))
    assert least == pytest.approx(none, rel=1e-14, abs=1e-300)


def test_a_slip_that_routh_reverses_may_stick_by_moreau():
    # What is held is held over the whole impulse here; with Routh it slips first, then is carried on.
    law = Law(-0.5, -0.6, 0.1, 0.6, 0.6, 0.0, 0.0, "moreau")
    before = ContactVelocity(0.3, -1.0, 0.0)
    held = collide(law, before)
    assert held.slip == 0.0
    assert collide(law._replace(name="newton"), before).slip < 0.0


def test_friction_that_wedges_slips_whatever_its_coefficient():
    # The slip alone lifts the contact faster than restitution asks: to stick, the track would have to pull.
    law = Law(1.0, -0.5, 0.1, 1e6, 1e6, 0.0, 0.0, "moreau")
    a, b, c = matrix(law)
    assert b > 0.0
    before = ContactVelocity(-2.0 * a / b, -1.0, 0.0)
    after = collide(law, before)
    assert after.slip < 0.0 and after.lift == 0.0
    rough = collide(law._replace(mu=float("inf"), stick=float("inf")), before)
    assert rough.slip == 0.0 and rough.lift == pytest.approx(-1.0 + 2.0, rel=1e-14)


# --- two formulations -------------------------------------------------------------------------------------------------


def struck(slip: float, lift: float, spin: float, xi2: float, *effects) -> Case:
    start = Start(0.0, xi2, slip=slip, omega=spin, gap_rate=lift)
    return Case(line(), PLATE, (*FLYING, *effects), start, 1e-3)


@drawn(300)
@given(
    slip=numbers(-3, 3), lift=numbers(-3, -0.01), spin=numbers(-10, 10), xi2=numbers(-3.1, 3.1), mu=numbers(0.01, 1.5),
    more=st.sampled_from([1.0, 1.5]), e=numbers(0.0, 1.0), arm=st.none() | numbers(1e-3, 0.1), rough=st.booleans(),
    name=st.sampled_from(cases.effects.IMPACT_LAWS),
)  # fmt: skip
def test_both_formulations_have_the_same_impact(slip, lift, spin, xi2, mu, more, e, arm, rough, name):
    friction = PerfectlyRough() if rough else CoulombFriction(mu, more * mu)
    case = struck(slip, lift, spin, xi2, friction, *((Resistance(arm),) if arm else ()), Impact(e, name))
    arms, other = by_second(case)
    law, before = law_of(case, *arms, slip), ContactVelocity(slip, lift, spin)
    # Impulses of an inertia of 0.023 kg m² at most 0.3 m off: rounding of some units, magnified by a hundred, in parts
    # of the largest velocity.
    size = 1e-11 * max(abs(slip), abs(lift), abs(spin))
    assert other == pytest.approx(collide(law, before), rel=1e-11, abs=max(size, 1e-11))


def by_second(case: Case) -> tuple[tuple[float, float], tuple[float, float, float]]:
    """The arm of the contact in a start along tangent and normal, and slip, normal velocity and spin after its impact,
    by the second formulation."""
    begin = start_motion(case)
    simulation = Simulation(case, 0.0, begin[:6], 1e-13)
    pair = pair_at(pairs(case)[0], simulation.body, (begin.xi1, begin.xi2))
    after, _ = velocities(simulation, case.effect(Impact), [pair])
    arms = float(pair.lift_row[2]), -float(pair.slip_row[2])
    return arms, (float(pair.slip_row @ after), float(pair.lift_row @ after), float(after[2]))


def test_a_restitution_that_creates_energy_goes_on_as_engines_do():
    effects = CoulombFriction(0.76), Impact(0.94, "moreau")
    case = struck(0.96, -2.7, -0.14, -2.9, *effects)
    law, before = law_of(case, *by_second(case)[0], 0.96), ContactVelocity(0.96, -2.7, -0.14)
    assert energy(law, collide(law, before)) > energy(law, before)
    assert (reference.simulate(case).status, second_states.motion(case, rtol=1e-13).status) == (
        "completed",
        "completed",
    )
