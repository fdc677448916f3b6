"""Impacts and bounces of the second formulation: Routh's closed forms, flight times, limits, energy."""

from math import cos, inf, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Mode,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases import curves as c
from cases.library import circle, ellipse, line
from reference.minimal.impact import ContactVelocity, Law, collide
from tests.scenes import second as second_states
from tests.scenes.elliptic import examples, numbers

G = 9.81
FLYING = (Gravity(G), Unilateral(), Flight())
# Closed forms of a handful of operations on numbers of the order of ten.
ROUNDING = 1e-13


def solve(case: Case, times=()):
    return second_states.solve(case, rtol=1e-13, times=times)


def modes(answer) -> list[tuple[Mode, Mode]]:
    return [(t.before, t.after) for t in answer.transitions]


# --- one impact -------------------------------------------------------------------------------------------------------


class Velocities(NamedTuple):
    slip: float
    lift: float
    spin: float


def hit(plate: Plate, xi2: float, before: Velocities, *effects) -> Velocities:
    """The velocities of the contact point right after an impact at time zero on a level line."""
    start = Start(0.0, xi2, slip=before.slip, omega=before.spin, gap_rate=before.lift)
    x, y, _, vx, vy, omega, _ = solve(Case(line(), plate, (*FLYING, *effects), start, 1e-3), [0.0]).motions[:, 0]
    return Velocities(vx + omega * y, vy - omega * x, omega)


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
    before = Velocities(*before)
    name, exact = routh(plate, xi2, before, mu, e)
    assert name == branch
    found = hit(plate, xi2, before, CoulombFriction(mu), Impact(e))
    shape = "disc" if plate is DISC else "plate"
    accuracy(
        case=f"{shape}: {branch}, mu={mu:g}", solver="reference", route="second",
        quantity="velocities after impact", error=np.max(np.abs(np.subtract(found, exact))), tolerance=ROUNDING * 10,
    )  # fmt: skip


def test_a_frictionless_impact_turns_the_normal_velocity_alone():
    before = Velocities(0.7, -1.5, 4.0)
    (a, b), e = arms(PLATE, -1.2), 0.6
    P = (1 + e) * 1.5 / (1 + a * a / PLATE.inertia)
    exact = (0.7 - a * b / PLATE.inertia * P, 0.9, 4.0 + a * P / PLATE.inertia)
    for law in ("poisson", "newton"):
        assert hit(PLATE, -1.2, before, Impact(e, law)) == pytest.approx(exact, abs=ROUNDING)


def test_both_laws_agree_where_the_slip_does_not_change_its_kind():
    before = Velocities(2.0, -1.0, 3.0)
    one = hit(PLATE, -1.2, before, CoulombFriction(0.2), Impact(0.5))
    assert hit(PLATE, -1.2, before, CoulombFriction(0.2), Impact(0.5, "newton")) == pytest.approx(one, abs=ROUNDING)


@pytest.mark.parametrize("law", ["poisson", "newton"])
def test_a_perfectly_rough_impact_leaves_no_slip(law):
    # Angular momentum about the contact is kept; the normal velocity turns to −e times what it is when the slip stops.
    before, e, (a, b), J = Velocities(1.0, -2.0, 3.0), 0.5, arms(PLATE, -1.2), PLATE.inertia
    A, B, C = 1 + b * b / J, 1 + a * a / J, a * b / J
    stopped = before.lift + C / A * before.slip
    lift = -e * (stopped if law == "poisson" else before.lift)
    P = (lift - stopped) / (B - C * C / A)
    T = (C * P - before.slip) / A
    exact = (0.0, lift, before.spin + (a * P - b * T) / J)
    assert hit(PLATE, -1.2, before, PerfectlyRough(), Impact(e, law)) == pytest.approx(exact, abs=ROUNDING)


@pytest.mark.parametrize("slip", [-3.0, -1.6, 1.0])
@pytest.mark.parametrize("law", ["poisson", "newton", "moreau"])
def test_both_formulations_agree_on_a_rough_impact_whose_friction_alone_opens_the_contact(law, slip):
    """By Newton's law and Moreau's a normal impulse is still due where what ends the slip lifts the contact more
    slowly than −e times its closing speed; by Poisson's none is, without compression."""
    before, e, (a, b), J = Velocities(slip, -0.1, 3.0), 0.6, arms(PLATE, -1.2), PLATE.inertia
    stopped = before.lift + a * b / J / (1 + b * b / J) * slip
    assert (stopped < 0.0) == (slip > 0.0)  # else the case is none
    law_of_it = Law(a, b, J / PLATE.mass, inf, inf, 0.0, e, law)
    ours = collide(law_of_it, ContactVelocity(slip, before.lift, before.spin))
    theirs = hit(PLATE, -1.2, before, PerfectlyRough(), Impact(e, law))
    assert (ours.slip, ours.lift, ours.omega) == pytest.approx(tuple(theirs), abs=ROUNDING)
    least = stopped if stopped >= 0.0 else -e * stopped
    assert ours.lift == pytest.approx(least if law == "poisson" else max(stopped, -e * before.lift), abs=ROUNDING)


def test_rolling_resistance_takes_spin_from_an_impact_and_can_stop_it():
    # A disc that falls without slip: dT keeps r ω + v = 0 against the couple arm dP, so dω = −arm P/(J + m r²).
    r, m, arm, e, fall = 0.1, 2.0, 0.01, 0.5, 1.0
    P, about_contact = (1 + e) * m * fall, 1.5 * m * r * r
    for spin, after in ((12.0, 12.0 - arm * P / about_contact), (0.5, 0.0)):
        before = Velocities(0.0, -fall, spin)
        found = hit(DISC, -pi / 2, before, CoulombFriction(0.9), RollingResistance(arm), Impact(e))
        assert found == pytest.approx((0.0, e * fall, after), abs=ROUNDING)


def kinetic(plate: Plate, xi2: float, v: Velocities) -> float:
    a, b = arms(plate, xi2)
    return (
        0.5 * plate.mass * ((v.slip + v.spin * b) ** 2 + (v.lift - v.spin * a) ** 2) + 0.5 * plate.inertia * v.spin**2
    )


impacts = dict(
    xi2=numbers(-3.1, 3.1),
    before=st.builds(Velocities, numbers(-3, 3), numbers(-3, -0.01), numbers(-10, 10)),
    mu=numbers(0.01, 1.5),
    e=numbers(0.0, 1.0),
    arm=st.none() | numbers(1e-3, 0.1),
)


@given(**impacts)
@examples(20, 60)
def test_poissons_law_never_creates_energy(xi2, before, mu, e, arm):
    resistance = (RollingResistance(arm),) if arm else ()
    after = hit(PLATE, xi2, before, CoulombFriction(mu), *resistance, Impact(e))
    lost = kinetic(PLATE, xi2, before) - kinetic(PLATE, xi2, after)
    assert lost >= -1e-12 * kinetic(PLATE, xi2, before)
    assert after.lift >= -ROUNDING


def test_newtons_law_that_creates_energy_ends_the_motion():
    # Kane & Levinson are said to have met it in a double pendulum (not looked up); a slender plate that sticks on the
    # way does as well.
    start = Start(0.0, -2.9, slip=0.96, omega=-0.14, gap_rate=-2.7)
    make = lambda law: Case(  # noqa: E731
        line(), PLATE, (*FLYING, CoulombFriction(0.76), Impact(0.94, law)), start, 0.1
    )
    ended = solve(make("newton"))
    assert (ended.status, ended.end, ended.transitions) == ("energy_gain", 0.0, ())
    assert solve(make("poisson")).status == "completed"


# --- many impacts -----------------------------------------------------------------------------------------------------


def falling(e: float, *effects, height=0.3, slope=0.0, duration=6.0, **start) -> Case:
    return Case(line(slope), DISC, (*FLYING, *effects, Impact(e)), Start(0.0, gap=height, **start), duration)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("e", [0.0, 0.5, pytest.param(0.9, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "rests, effects, start",
    [
        ((Mode.SLIDE,), (), dict(slip=0.3)),
        ((Mode.SLIP_FORWARD, Mode.ROLL), (CoulombFriction(0.1),), dict(omega=-30.0, slip=1.0)),
        ((Mode.ROLL,), (PerfectlyRough(),), dict(omega=-30.0, slip=1.0)),
    ],
    ids=["frictionless", "spinning on a rough line", "perfectly rough"],
)
def test_bounces_on_a_line_follow_a_geometric_series_to_its_limit(e, rests, effects, start, accuracy):
    # Falls t₀ = √(2h/g), then flights 2 t₀ eⁿ; they end at t₀ (1 + e)/(1 − e).
    case = falling(e, *effects, **start)
    answer = solve(case)
    fall = sqrt(2 * 0.3 / G)
    # Impacts that close with at least 7e-4 of the first, greatest speed are listed; the n-th closes with eⁿ⁻¹ of it.
    lasting = [2 * fall * e**n for n in range(1, 200) if e ** (n - 1) >= 7e-4 and e > 0.0]
    hits = fall + np.concatenate([[0.0], np.cumsum(lasting)])[: len(lasting)]
    landed = answer.transitions[len(lasting)]
    assert modes(answer)[: len(lasting)] == [(Mode.FLIGHT, Mode.FLIGHT)] * len(lasting)
    assert landed.before is Mode.FLIGHT and landed.after in rests
    assert answer.transitions[-1].after is rests[-1]
    kind = type(effects[0]).__name__ if effects else "frictionless"
    # The disc comes to turn by a hundred radians and to travel ten metres, which round at 1e-14; sixty impacts add up.
    common = dict(case=f"bouncing disc, e={e:g}, {kind}", solver="reference", route="second", tolerance=1e-11)
    if lasting:
        times = [t.time for t in answer.transitions[: len(lasting)]]
        accuracy(**common, quantity="impacts / s", error=np.max(np.abs(times - hits)))
    accuracy(**common, quantity="limit / s", error=landed.time - fall * (1 + e) / (1 - e))


@pytest.mark.slow
def test_after_its_last_bounce_a_spinning_disc_has_the_speed_of_a_disc_that_never_left(accuracy):
    # About the contact point angular momentum is kept through flight, impacts and rolling on a level line.
    case = falling(0.8, CoulombFriction(0.05), omega=-30.0, slip=2.0, duration=4.0)
    begin, end = solve(case, [0.0, 4.0]).motions.T
    # m r v − J ω about a point of the line, with v = −r ω at the end.
    speed = (begin[3] - 0.05 * begin[5]) / 1.5
    accuracy(
        case="bouncing and spinning, e=0.8", solver="reference", route="second",
        quantity="final speed / m/s", error=end[3] - speed, tolerance=1e-11,
    )  # fmt: skip


def test_bounces_down_an_incline_keep_the_fall_line_s_acceleration(accuracy):
    e, slope = 0.6, 0.3
    case = falling(e, slope=slope, duration=4.0)
    answer = solve(case, [3.9])
    fall = sqrt(2 * 0.3 / (G * cos(slope)))
    assert answer.transitions[-1].time == pytest.approx(fall * (1 + e) / (1 - e), abs=1e-12)
    speed = float(np.hypot(*answer.motions[3:5, 0]))
    accuracy(
        case="bouncing down an incline", solver="reference", route="second",
        quantity="speed / m/s", error=speed - G * sin(slope) * 3.9, tolerance=1e-11,
    )  # fmt: skip


def test_perfect_restitution_bounces_for_ever():
    case = falling(1.0, height=0.05, duration=3.0)
    answer = solve(case)
    fall = sqrt(2 * 0.05 / G)
    hits = np.arange(fall, 3.0, 2 * fall)
    assert answer.status == "completed"
    assert [t.time for t in answer.transitions] == pytest.approx(hits, abs=1e-12)


def rest_of(answer) -> float:
    return next(t.time for t in answer.transitions if t.after is not Mode.FLIGHT)


@pytest.mark.slow
@pytest.mark.parametrize("duration", [10.0, 300.0, 3600.0])
def test_bouncing_comes_to_rest_at_the_same_instant_whatever_the_duration(duration):
    # √(2h/g) (1 + e)/(1 − e) for e = 0.9 from half a metre.
    answer = solve(falling(0.9, height=0.5, duration=duration))
    assert rest_of(answer) == pytest.approx(6.066233139734, abs=2e-12)
    # All 69 impacts that close with at least 7e-4 of the first speed, 0.9⁶⁸ = 7.7e-4, are listed.
    assert len(answer.transitions) == 70


def check_that_it_rests(e: float, rests: float, duration: float) -> None:
    answer = solve(falling(e, height=0.05, duration=duration))
    assert rest_of(answer) == pytest.approx(rests, abs=1e-9)
    hits = sqrt(2 * 0.05 / G) * (1 + 2 * e * (1 - e ** np.arange(len(answer.transitions) - 1)) / (1 - e))
    assert len(hits) == 1 + int(np.log(7e-4) / np.log(e))
    assert [t.time for t in answer.transitions[:-1]] == pytest.approx(hits, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("e, rests", [(0.99, 20.0917873384), (0.999, 201.826547183)])
@pytest.mark.parametrize("longer", [1.1, 100.0])
def test_bouncing_that_hardly_loses_speed_comes_to_rest_on_time(e, rests, longer):
    check_that_it_rests(e, rests, longer * rests)


@pytest.mark.slow
def test_perfect_restitution_lists_every_bounce_of_minutes():
    fall = sqrt(2 * 0.05 / G)
    answer = solve(falling(1.0, height=0.05, duration=200.0))
    hits = np.arange(fall, 200.0, 2 * fall)
    assert answer.status == "completed"
    assert [t.time for t in answer.transitions] == pytest.approx(hits, abs=1e-9)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("law", ["poisson", "newton"])
@pytest.mark.parametrize("e", [0.5, 0.9, 1.0])
@pytest.mark.parametrize("speed", [1e-3, 1.0, 30.0])
def test_a_start_that_begins_with_an_impact_rebounds(speed, e, law):
    # Flights of 2 e v/g, 2 e² v/g, …, the first from time zero: at rest at 2 v e/(g (1 − e)).
    duration = 2.5 * speed * e / G
    start = Start(0.0, gap_rate=-speed)
    answer = solve(Case(line(), DISC, (*FLYING, Impact(e, law)), start, duration), [0.0])
    assert answer.motions[4, 0] == pytest.approx(e * speed, rel=1e-13)
    assert modes(answer)[:2] == [(Mode.FLIGHT, Mode.FLIGHT)] * 2
    assert [t.time for t in answer.transitions[:2]] == pytest.approx([0.0, 2 * e * speed / G], rel=1e-12)


def test_an_impact_is_listed_from_seven_ten_thousandths_of_the_greatest_closing_speed_on():
    for e, listed in ((7.1e-4, 2), (6.9e-4, 1)):
        answer = solve(falling(e, duration=1.0))
        assert modes(answer) == [(Mode.FLIGHT, Mode.FLIGHT)] * listed + [(Mode.FLIGHT, Mode.SLIDE)]


def test_slip_that_vanishes_with_the_bounces_ends_in_rolling():
    # Gravity along X holds an ellipse against the flank of another; each hop leaves slip in proportion to its height.
    plate = Plate(Curve(lambda s: (0.18 * c.cos(s) + 0.007, 0.29 * c.sin(s))), 1.0, 0.0292)
    effects = (Gravity(G, 0.0), Unilateral(), Flight(), CoulombFriction(0.23), Impact(0.52, "newton"))
    case = Case(ellipse(1.16, 0.8), plate, effects, Start(0.0, 0.0, omega=5.0, gap=0.01), 0.8)
    answer = solve(case)
    assert answer.transitions[-1].before is Mode.FLIGHT and answer.transitions[-1].after is Mode.ROLL
    assert len(answer.transitions) > 5


@given(
    e=numbers(0.0, 0.95),
    mu=numbers(0.01, 1.0),
    omega=numbers(-10, 10),
    slip=numbers(-2, 2),
    xi1=numbers(-2.2, -1.0),
    xi2=numbers(-3, 3),
)
@examples(3, 10)
def test_energy_never_grows_while_a_plate_bounces_and_comes_to_rest(e, mu, omega, slip, xi1, xi2):
    plate = Plate(ellipse(0.25, 0.15), 1.0, 0.02)
    start = Start(xi1, xi2, slip=slip, omega=omega, gap=0.1)
    case = Case(circle(1.0), plate, (*FLYING, CoulombFriction(mu), Impact(e)), start, 1.0)
    times = np.linspace(0, 1, 7)
    answer = solve(case, times)
    _, y, _, vx, vy, w, _ = answer.motions[:, times <= answer.end]
    energy = 0.5 * (vx**2 + vy**2) + 0.5 * 0.02 * w**2 + G * y
    # A dozen joules; the limit of an accumulation is followed from its last bounce at most a micron above the track.
    assert np.diff(energy).max() < 1e-9
