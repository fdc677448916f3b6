"""Rolling resistance at several contacts: exact motions, two formulations, the paper's matrix, and what is rejected."""

from itertools import product
from math import cos, pi, sin, sqrt

import numpy as np
import pytest

import adapters
import reference
from adapters import lookup
from cases import (
    BadValue,
    Belt,
    Case,
    CoulombFriction,
    DoesNotFit,
    Effect,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    Plate,
    RollingResistance,
    StartPose,
    Support,
    Unilateral,
    disc,
)  # fmt: skip
from cases.contact import start_motion
from cases.library import line
from cases.scene.contact_pairs import pairs
from reference.solver.plate_numbers import senses_of
from reference.witness import complementarity
from reference.witness.contacts import PlateDynamics, frictions, pair_at
from tests.scenes.agreement import agree
from tests.scenes.decisions import accelerations_of, decision_in
from tests.scenes.supports import compare_with_matrix

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


@pytest.mark.sampled(6)
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


def test_each_contact_of_a_spinning_disc_has_the_force_of_its_own_couple():
    motion = reference.simulate(disc_in_v(omega=25.0), rtol=1e-14)
    normal_forces, _ = forces_in_v(1.0)
    spinning = [
        motion.contact_columns(name, np.array([0.1])).normal_force[0] for name in ("plate/track", "plate/right")
    ]
    assert spinning == pytest.approx(normal_forces.tolist(), abs=EXACT)
    end = motion.contact_columns("plate/track", np.array([1.9]))
    assert np.isnan(end.normal_force[0]) and end.normal_range[0, 0] < end.normal_range[1, 0]
    assert motion(1.9).omega == 0.0


@pytest.mark.sampled(2)
@METHODS
def test_a_disc_held_in_a_v_begins_to_turn_where_friction_and_couples_of_both_contacts_are_used_up(method):
    _, moment = forces_in_v(1.0)
    motion = motion_by(disc_in_v(Load(moment="0.9*t"), duration=1.2 * moment / 0.9), method)
    assert [(t.before, t.after) for t in motion.transitions] == [(Mode.REST, Mode.SLIP_FORWARD)] * 2
    assert all(t.time == begins_at(moment / 0.9, method) for t in motion.transitions)


@pytest.mark.sampled(2)
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


@pytest.mark.slow
@METHODS
def test_a_belt_spins_a_disc_up_against_friction_and_couple_of_a_wall(method):
    """The belt runs to the wall and presses the disc on it: N_w = F + μ N_b and N_b = g + μ_w N_w. With
    J ω̇ = μ R N_b − (μ_w R + c) N_w its surface reaches the belt's speed."""
    mu, mu_wall, arm, press, belt = 0.4, 0.2, 0.01, 1.0, -1.5
    case = corner((CoulombFriction(mu), Belt(belt)), surface(mu_wall, arm), Load(fx=-press))
    motion = motion_by(case, method)
    on_belt = (G + mu_wall * press) / (1.0 - mu * mu_wall)
    on_wall = press + mu * on_belt
    rate = (mu * R * on_belt - (mu_wall * R + arm) * on_wall) / J
    (change,) = motion.transitions
    assert (change.contact, change.after) == ("plate/track", Mode.ROLL)
    assert change.time == pytest.approx(-belt / R / rate, abs=EXACT)


@pytest.mark.sampled(2)
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


@pytest.mark.slow
def test_a_wall_that_is_not_touched_changes_nothing():
    """A disc slides, rolls and rests as with one contact."""
    away = corner(surface(0.3, 0.01), (), away=1.0, vx=1.5, duration=4.0)
    alone = Case(away.track, away.plate, away.effects, away.start, 4.0)
    here, there = (reference.simulate(case, rtol=1e-14) for case in (alone, away))
    assert [t.after for t in there.transitions] == [Mode.ROLL, Mode.REST]
    assert [t.time for t in there.transitions] == pytest.approx([t.time for t in here.transitions], abs=2e-15)


# --- two formulations, and the paper's matrix -------------------------------------------------------------------------


def _random_state(seed: int):
    """A disc in a V of two planes at rest or turning, under a random load, with random friction and resistance."""
    numbers = np.random.default_rng(seed)
    (a, b), (mu, mu_right), arms = (
        numbers.uniform(0.3, 1.1, 2),
        numbers.uniform(0.05, 1.2, 2),
        numbers.uniform(0.0, R, 2),
    )
    omega = float(numbers.choice([0.0, numbers.uniform(-5.0, 5.0)]))
    fx, fy, moment = numbers.uniform(-15.0, 15.0, 3) * (1.0, 1.0, R)
    far = R / sin(a + b)
    start = StartPose(far * (cos(b) - cos(a)), far * (sin(a) + sin(b)), omega=omega)
    effects = (*INELASTIC, *surface(mu, arms[0]), Load(fx=fx, fy=fy, moment=moment))
    wall = Support(line(-b), "right", surface(mu_right, arms[1]))
    case = Case(line(a), disc(R, 1.0), effects, start, 1.0, supports=(wall,))
    begin = start_motion(case)
    body = [float(v) for v in (begin.x, begin.y, begin.theta, 0.0, 0.0, omega)]
    return case, decision_in(case, body, max(abs(omega) * R, 1.0))


def _compare_decisions(seeds) -> dict[str, int]:
    """Compare accelerations by enumeration with those by Lemke's method and by projected Gauss-Seidel."""
    counts = {"one": 0, "still": 0, "turns": 0, "projected": 0}
    for seed in seeds:
        case, (now, contacts, decision) = _random_state(seed)
        if decision.modes is None:
            continue
        (rates,) = accelerations_of(now, contacts, decision)
        dynamics, body = PlateDynamics(case), list(now.state)
        some = [pair_at(pairs(case)[k], body, (at.xi1, at.xi2)) for k, at in enumerate(contacts)]
        matrix, rows = dynamics.delassus(some)
        free, law, omega = dynamics.free_rates(0.0, body, some, rows), frictions(some), body[-1]
        slips = [float(np.sign(omega)) if omega else None] * 4
        second = complementarity.solutions(matrix, free, slips, *law)
        assert len(second) == 1, seed
        forces = [*second, complementarity.gauss_seidel(matrix, free, slips, *law, np.zeros(6), sweeps=20_000)]
        for force, within in zip(forces, (1e-8, 1e-6), strict=True):
            if force is not None:
                move = dynamics.inverse * (dynamics.torsor(0.0, body) + rows.T @ force)
                assert move == pytest.approx(rates, rel=within, abs=within), seed
        counts["one"] += 1
        counts["projected"] += forces[1] is not None
        counts["still" if decision.turn == 0 else "turns"] += 1
    return counts


@pytest.mark.slow
def test_decisions_are_those_of_lemkes_method_and_of_projected_gauss_seidel():
    counts = _compare_decisions(range(150))
    assert counts["one"] > 120 and counts["projected"] > 100 and min(counts["still"], counts["turns"]) > 20


def test_the_papers_matrix_with_couples_gives_the_same_accelerations_and_forces():
    slides = corner(surface(0.1, 0.05), (), away=0.5, vx=1.5)  # the couple prevents the rotation
    assert compare_with_matrix([disc_in_v(omega=25.0), slides]) == [[Mode.SLIP_FORWARD] * 2, [Mode.SLIP_FORWARD]]


# --- what is rejected -------------------------------------------------------------------------------------------------


def test_a_supports_own_resistance_is_checked():
    with pytest.raises(DoesNotFit, match="nothing makes a plate without friction roll"):
        corner((), (RollingResistance(0.01),))
    with pytest.raises(DoesNotFit, match="no established law"):
        corner((), surface(0.3, 0.01, Belt(1.0)))
    with pytest.raises(BadValue, match="arm of RollingResistance"):
        corner((), surface(0.3, 1e12))


@pytest.mark.parametrize("of_wall", [False, True])
def test_adapters_reject_rolling_resistance_on_supports_in_one_sentence(of_wall):
    case, count = corner(surface(0.3, 0.01), ()) if not of_wall else corner((), surface(0.3, 0.01)), 0
    for engine in lookup.engines():
        try:
            module = lookup.engine(engine)
        except Exception:  # not installed here
            continue
        for route in module.routes:
            reason = adapters.refusal(module, case, route)
            assert reason and reason.endswith(".") and ("rolling resistance" in reason or "supports" in reason)
            one_only = adapters.refusal_of_several_contacts(module, case, route)
            assert one_only.endswith("several contacts with rolling resistance.") or "several places" in one_only
            count += 1
    assert count


# --- plates with corners ----------------------------------------------------------------------------------------------

WALL = Support(line(pi / 2), "wall")
MORE = (0.1, 0.0, 0.005), (0.1, 0.3, 0.03), (0.5, 0.3, 0.005)
# A block that lands on a corner and then on its side, on an incline; one that slides against a wall; a half disc.
CORNERS = {
    "incline": (line(-0.2), Plate.rectangle(1.0, 0.6, 1.0), StartPose(0.0, 0.9, 0.3, omega=1.0), ()),
    "wall": (line(), Plate.rectangle(1.0, 0.6, 1.0), StartPose(2.0, 0.9, 0.3, vx=-2.0, omega=1.0), (WALL,)),
    "half disc": (line(-0.1), Plate.half_disc(0.5, 1.0), StartPose(0.0, 0.9, 0.3, omega=1.0), ()),
}


@pytest.mark.parametrize("mu, e, arm", [(0.5, 0.0, 0.03), *(pytest.param(*m, marks=pytest.mark.slow) for m in MORE)])
@pytest.mark.parametrize("name", CORNERS)
def test_both_formulations_agree_for_corners_that_resist_rolling(name, mu, e, arm):
    """Two corners on a line prevent a rotation by themselves: what they share with the couple is open."""
    track, plate, start, supports = CORNERS[name]
    effects = (*INELASTIC[:3], Impact(e, "moreau"), *surface(mu, arm))
    agree(Case(track, plate, effects, start, 1.5, supports=supports))


@pytest.mark.parametrize(
    "turning", [[(0,)], [(0,), (1, 0)], [(0,), (1,), (1, 0)], [(0,), (1, 0), (2, 1), (2, 0)], [(1, 0), (2, 1), (3, 2)]]
)
def test_rotations_have_the_senses_of_an_order_of_spins(turning):
    """Those of all spins between −3 and 3, where what is fixed has none."""
    bodies = 1 + max(body for sides in turning for body in sides)
    expected = {
        tuple(int(np.sign(spins[sides[0]] - (spins[sides[1]] if len(sides) > 1 else 0))) for sides in turning)
        for spins in product(range(-3, 4), repeat=bodies)
    }
    senses = senses_of(tuple(turning))
    assert len(senses) == len(set(senses)) and set(senses) == expected
