"""Random scenes with every effect that takes no work from outside: what must hold in every mode and at every impact."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import reference
from cases import (
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Mode,
    PerfectlyRough,
    RollingResistance,
    Start,
    Unilateral,
)
from cases.contact import slip_velocity
from cases.contact.nearest import nearest
from tests.reference.test_two_formulations import check_agreement
from tests.scenes import second as second_states
from tests.scenes.elliptic import ellipse_in_ellipse, numbers
from tests.scenes.motions import energy

# Each set of effects has equations of its own to derive and compile, a second or two; to shrink a failing scene would
# take minutes, and it is a few numbers already.
UNHURRIED = dict(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
)

QUICK = settings.get_current_profile_name() == "same"


def with_effects(base: Case, law, resistance, sided, e, gap, lift) -> Case:
    """The scene with that contact law: friction, arm of rolling resistance, "guide", "ends", "lands" or "bounces"."""
    effects = [base.effect(Gravity), *law]
    if resistance and law:
        effects.append(RollingResistance(resistance))
    if sided != "guide":
        effects.append(Unilateral())
    if sided in ("lands", "bounces"):
        effects.append(Flight())
    if sided == "bounces":
        effects.append(Impact(e))
    flies = sided == "bounces"
    start = Start(
        base.start.xi1,
        base.start.xi2,
        0.0 if PerfectlyRough() in law and not (flies and gap) else base.start.slip,
        base.start.omega,
        gap if flies else 0.0,
        lift if flies and gap else 0.0,
    )
    return Case(base.track, base.plate, tuple(effects), start, 1.0)


laws = (
    st.just(())
    | st.just((PerfectlyRough(),))
    | st.builds(lambda mu, more: (CoulombFriction(mu, mu * more),), numbers(0.01, 1.0), st.sampled_from([1.0, 1.3]))
)
bases = st.builds(
    ellipse_in_ellipse,
    A=numbers(1.0, 1.2), B=numbers(0.8, 1.0), a=numbers(0.18, 0.3), b=numbers(0.18, 0.3), xi1=numbers(-3.0, 3.0),
    xi2=numbers(-3.0, 3.0), mu=st.just(0.0), slip=st.just(0.0) | numbers(0.01, 2.0) | numbers(-2.0, -0.01),
    omega=numbers(-5.0, 5.0), direction=numbers(-3.0, 3.0), shift=numbers(-0.05, 0.05),
)  # fmt: skip
scenes = st.builds(
    with_effects,
    bases,
    law=laws,
    resistance=st.just(0.0) | numbers(1e-3, 0.05),
    sided=st.sampled_from(["guide", "ends", "lands", "bounces"]),
    e=st.sampled_from([0.0, 0.3, 0.6]) | numbers(0.0, 0.8),
    gap=st.just(0.0) | numbers(0.01, 0.1),
    lift=numbers(-1.0, 1.0),
)


def check_physics(case: Case) -> None:
    """Energy, one-sidedness, the cone, no overlap: at the integrator's steps and between."""
    motion = reference.simulate(case, rtol=1e-11, method="dop853")
    assert all(np.all(np.isfinite(row)) for row in (motion.x, motion.y, motion.theta, motion.vx, motion.omega))
    times = np.unique(np.concatenate([motion.t, np.linspace(motion.t[0], motion.t[-1], 200)]))
    state = motion(times)
    energies = energy(case, state)
    scale = np.ptp(energies) + case.plate.mass * float(np.max(state.vx**2 + state.vy**2) + 1e-6)
    # An energy is a difference of terms as large as the plate's weight times a metre, each rounded.
    rounding = 8 * np.finfo(float).eps * case.plate.mass * 9.81
    allowed = np.full(len(times) - 1, 1e-9)
    # Between the last bounce that is stepped through and the limit a state lies on the chord of both: the energy of a
    # chord dips by an eighth of its length squared, 1e-8 in a millisecond.
    for last, rest in pairwise(motion.transitions):
        if rest.cause == "bouncing came to rest":
            settling = (times[1:] > last.time) & (times[1:] <= rest.time)
            allowed[settling] = 1e-8 * max(1.0, ((rest.time - last.time) / 1e-3) ** 2)
    assert np.all(np.diff(energies) <= allowed * scale + rounding)
    weight = case.plate.mass * (9.81 + float(np.max(state.vx**2 + state.vy**2)) / 0.1)
    if case.effect(Unilateral):
        assert np.all(state.normal_force >= -1e-8 * weight)
    friction = case.effect(CoulombFriction)
    if friction:
        bound = friction.stick * np.abs(state.normal_force)
        assert np.all(np.abs(state.friction_force) <= bound + 1e-8 * weight)
    flying = np.isnan(state.xi1)
    for i in np.flatnonzero(flying)[::7]:
        contact = nearest(case, float(state.x[i]), float(state.y[i]), float(state.theta[i]))
        # Between the last bounces that are stepped through and their limit the plate is taken as lying on its track.
        assert contact is None or contact.gap >= -1e-6
    slip = slip_velocity(case, state.x, state.y, state.vx, state.vy, state.omega, np.where(flying, 0.0, state.xi1))
    assert np.allclose(slip[~flying], state.slip[~flying], atol=1e-9 * (1 + np.max(np.abs(state.omega))))


@settings(max_examples=4 if QUICK else 20, **UNHURRIED)
@given(scenes)
def test_energy_never_grows_the_track_never_pulls_and_nothing_overlaps(case):
    check_physics(case)


@settings(max_examples=2 if QUICK else 8, **UNHURRIED)
@given(scenes)
def test_both_formulations_agree_with_every_effect(case):
    check_agreement(case)


rough_scenes = st.builds(
    with_effects, bases, law=st.just((PerfectlyRough(),)), resistance=st.just(0.0),
    sided=st.sampled_from(["ends", "lands"]), e=st.just(0.0), gap=st.just(0.0), lift=st.just(0.0),
)  # fmt: skip


@settings(max_examples=3 if QUICK else 12, **UNHURRIED)
@given(rough_scenes)
def test_a_rough_contact_ends_in_a_paradox_exactly_where_its_friction_held_the_plate_off_the_track(case):
    # Where N vanishes, the free plate's gap has the acceleration a b T/J: (a, b) the arm from the centre of mass to the
    # contact along tangent and normal, T the friction that acts until then.
    both = reference.simulate(case, rtol=1e-11, method="dop853"), second_states.motion(case, rtol=1e-11)
    assert both[0].status == both[1].status
    if both[0].first_mode is not Mode.ROLL or not (both[0].transitions or both[0].status == "paradox"):
        return  # it flies from the first instant, or nothing ends the contact
    end = both[0].transitions[0].time if both[0].transitions else float(both[0].t[-1])
    state = both[0](np.array([end * (1 - 1e-9)]))
    arm = case.track.point(state.xi1)[:, 0] - [state.x[0], state.y[0]]
    tangent, normal = case.track.tangent(state.xi1)[:, 0], case.track.normal(state.xi1)[:, 0]
    away = (arm @ tangent) * (arm @ normal) * state.friction_force[0] / case.plate.inertia
    if abs(away) > 1e-5:  # the friction is seen a billionth of the time before the end
        assert (both[0].status == "paradox") == (away < 0.0)


@pytest.mark.slow
@settings(max_examples=1000, **UNHURRIED)
@given(scenes)
def test_physics_and_agreement_in_a_thousand_random_scenes(case):
    check_physics(case)
    check_agreement(case)


def test_bouncing_in_a_bowl_ends_in_contact():
    base = ellipse_in_ellipse(1.1, 0.9, 0.25, 0.2, -1.5, -1.5, 0.0, 0.5, 1.0)
    case = with_effects(base, (CoulombFriction(0.3),), 0.0, "bounces", 0.4, 0.05, 0.0)
    motion = reference.simulate(case)
    assert motion.first_mode is Mode.FLIGHT and motion.transitions[-1].after is not Mode.FLIGHT
