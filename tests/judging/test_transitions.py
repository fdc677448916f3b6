"""Flights, landings, bounces and stick read from samples: of exact motions, of made-up ones, of engines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
from cases import (
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    PerfectlyRough,
    RollingResistance,
    Start,
    Trajectory,
    Unilateral,
    disc,
)
from cases.library import line
from reports.judging import ledger, slip_phases, transitions
from reports.running import tasks
from tests.scenes.motions import motion_of

FORWARD, ROLL, STICK, FLIGHT = Mode.SLIP_FORWARD, Mode.ROLL, Mode.REST, Mode.FLIGHT
G, R = 9.81, 0.1


def kinds(output: slip_phases.Reading) -> list[tuple[Mode, Mode]]:
    return [(event.before, event.after) for event in output.transitions]


def times(output: slip_phases.Reading) -> list[float]:
    return [event.time for event in output.transitions]


def sampled(exact: Trajectory, count: int) -> Trajectory:
    """The exact motion as an engine would give it: on a uniform grid, without its transitions and first mode."""
    t = np.linspace(exact.t[0], exact.t[-1], count)
    return Trajectory(t=t, **exact(t)._asdict(), status=exact.status)


# --- exact motions ----------------------------------------------------------------------------------------------------

# Constant forces: two parabolas meet, but for the rounding of their positions (1e-16 m over a jump of 0.1 m/s) and of
# the gap that the motion integrates, whose zero is the impact.
MEETING = 2e-13
# Slip, turning and leaving are extrapolated by polynomials; bounds ten times (gap / 0.3 s)^5 as in test_metrics.py,
# or, where a contact lasts less than that, so many gaps as the width of a local polynomial.
EXACT = {
    # Samples; bounds by kind of transition, in gaps for landings, else in s.
    ("bouncing_disc", 501): dict(rest=1e-9),
    ("bouncing_disc", 2001): dict(rest=1e-9),
    ("disc_off_ramp", 1501): dict(branch=1e-8),
    ("disc_off_ramp", 6001): dict(branch=1e-11),
    ("tumbling_ellipse", 501): dict(branch=1e-6),
    ("tumbling_ellipse", 2001): dict(branch=1e-9),
    ("disc_rolling_to_rest", 51): dict(branch=1e-13),
    ("disc_rolling_to_rest", 501): dict(branch=1e-13),
    ("disc_in_sticky_valley", 101): dict(branch=1e-2),
    ("disc_in_sticky_valley", 501): dict(branch=1e-6),
    ("disc_in_sticky_valley", 2001): dict(branch=1e-9),
}


@pytest.mark.parametrize(("name", "count"), EXACT)
def test_exact_motion_is_read_back(name, count, accuracy):
    case = cases.load(name)
    exact, bounds = motion_of(case), EXACT[name, count]
    output = transitions.read_motion(case, sampled(exact, count))
    assert output.first_mode is exact.first_mode
    gap = float(exact.t[-1]) / (count - 1)
    ends = [*(event.time for event in exact.transitions[1:]), float(exact.t[-1])]
    # Rebounds that fly for less than samples resolve are not read.
    seen = [
        event
        for event, end in zip(exact.transitions, ends, strict=True)
        if not event.before is event.after is FLIGHT or end - event.time >= slip_phases.RESOLVABLE_GAPS * gap
    ]
    assert kinds(output) == [(event.before, event.after) for event in seen]
    for found, true in zip(output.transitions, seen, strict=True):
        what, bound = "branch", bounds.get("branch", 0.0)
        if found.before is FLIGHT:
            # The last landing of a bouncing whose ratio is not constant lies somewhere in its gap, or in that before.
            what, bound = ("impact", MEETING) if found.after is FLIGHT else ("rest", bounds.get("rest", gap))
        accuracy(case=case.label, solver="reading", route="samples", error=found.time - true.time, tolerance=bound,
                 quantity=f"{what} read from {count} samples / s")  # fmt: skip


def test_rough_contact_rolls():
    case = cases.load("rough_disc_in_circle")
    output = transitions.read_motion(case, sampled(motion_of(case), 501))
    assert output.first_mode is ROLL and output.transitions == ()


# --- made-up motions --------------------------------------------------------------------------------------------------


def thrown(*effects, duration: float = 1.0) -> Case:
    effects = effects or (Gravity(G), Impact(0.5))
    return Case(
        line(), disc(R, 1.0), (CoulombFriction(0.2), Unilateral(), Flight(), *effects), Start(0.0, gap=1.0), duration
    )


def motion(t, y, vy, contact=None, omega=0.0, slip=0.0, vx=1.0, **how) -> Trajectory:
    """A plate at height y, in flight but where `contact` is true."""
    t = np.asarray(t, dtype=float)
    contact = np.zeros(len(t), dtype=bool) if contact is None else np.asarray(contact)
    zero, where = np.zeros(len(t)), np.where(contact, 0.0, np.nan)
    given = {"vx": vx + zero, "vy": vy + zero, "omega": omega + zero, "slip": slip + where, "xi1": where, "xi2": where}
    force = {"normal_force": np.where(contact, G, 0.0), "friction_force": zero}
    return Trajectory(t=t, x=vx * t, y=y + zero, theta=zero, **given, **force, **how)


def bounce(t, at: float, down: float, up: float, pull: float = G) -> tuple[np.ndarray, np.ndarray]:
    """Height and its rate: with the speed `down` onto the floor at a time, off it with `up`."""
    s = t - at
    v = np.where(s < 0.0, -down, up)
    return R + v * s - 0.5 * pull * s * s, v - pull * s


def test_impact_on_a_doubled_sample_is_there():
    t = np.sort(np.append(np.linspace(0.0, 0.6, 61), 0.30))
    y, v = bounce(t, 0.30, 3.0, 1.5)
    v[np.flatnonzero(np.diff(t) == 0.0)[0]] = -3.0
    # An engine's positions are off its parabola; the doubled time is its own landing all the same.
    output = transitions.read_motion(thrown(), motion(t, y + 1e-3 * np.sin(50 * t), v))
    assert kinds(output) == [(FLIGHT, FLIGHT)] and times(output) == [t[np.flatnonzero(np.diff(t) == 0.0)[0]]]


STEPS, FEWER, LONG = np.linspace(0.0, 0.6, 61), np.linspace(0.0, 0.6, 60), np.linspace(0.0, 3.0, 31)
# Air drag as strong as gravity at the end of the fall: the acceleration changes by all of it.
DRAG, END, DECAY = thrown(Gravity(G), Load(fy="-2*vy"), Impact(0.5), duration=3.0), G / 2.0, np.exp(-2.0 * LONG)
# Gravity is turned around at the impact: what hits the floor without a rebound leaves it at once.
TURNED = thrown(Gravity(G), Load(fy=f"{2 * G}*(1+tanh(1e6*(t-0.3)))/2"), Impact(0.0), duration=0.6)
DOWN, DOWN_RATE = bounce(FEWER, 0.3, 3.0, 0.0)
UP = np.maximum(FEWER - 0.3, 0.0)
AT, FALL, FALL_RATE = 0.3141592, *bounce(STEPS, 0.3141592, 3.0, 0.0)
WEIGHTLESS, RATE = bounce(STEPS, 0.3141, 3.0, 1.5, pull=0.0)
ROUNDING = 1e-7 * np.random.default_rng(1).standard_normal(61)
# The case, the motion, the modes after each change with its time, and the error allowed (s).
FALLS = {
    **{
        f"an impact at {at} between samples, where two parabolas meet": (
            thrown(), motion(STEPS, *bounce(STEPS, at, 3.0, 1.5)), [(FLIGHT, at)], 1e-14,
        )
        for at in (0.31, AT, 0.319999)
    },
    "one contact sample between two flights is an impact": (
        thrown(), motion(STEPS, *bounce(STEPS, 0.302, 3.0, 1.5), contact=np.arange(61) == 31), [(FLIGHT, 0.302)], 1e-14,
    ),
    "a flight without a jump has no impact even under a strong load": (
        DRAG, motion(LONG, 50.0 - END * LONG + END / 2.0 * (1.0 - DECAY), -END * (1.0 - DECAY)), [], 0.0,
    ),
    "an impact without gravity is seen and rounding is none": (
        thrown(Impact(0.5)), motion(STEPS, WEIGHTLESS, RATE + ROUNDING), [(FLIGHT, 0.3141)], 1e-7,
    ),
    "an impact without a rebound where the plate flies on": (
        TURNED, motion(FEWER, np.where(UP > 0.0, R + 0.5 * G * UP**2, DOWN), np.where(UP > 0.0, G * UP, DOWN_RATE)),
        [(FLIGHT, 0.3)], 1e-2,
    ),
    "a landing without a rebound where the fall meets the floor": (
        thrown(), motion(STEPS, np.where(STEPS > AT, R, FALL), np.where(STEPS > AT, 0.0, FALL_RATE), STEPS > AT),
        [(ROLL, AT)], 1e-14,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FALLS)
def test_a_fall_is_read_as_what_it_is(name):
    case, made, changes, error = FALLS[name]
    output = transitions.read_motion(case, made)
    assert output.first_mode is FLIGHT and kinds(output) == [(FLIGHT, mode) for mode, _ in changes]
    assert times(output) == pytest.approx([time for _, time in changes], abs=error)


def test_contacts_between_flights_are_read_each_for_itself():
    # Slip ends at 0.2 and at 0.7; between them a flight from 0.4 to 0.5, which the force and a doubled sample tell.
    t = np.sort(np.append(np.linspace(0.0, 1.0, 201), 0.5))
    second = int(np.flatnonzero(np.diff(t) == 0.0)[0]) + 1
    contact = (t < 0.4 - 1e-9) | (np.arange(len(t)) >= second)
    slip = np.where(np.arange(len(t)) < second, np.maximum(0.2 - t, 0.0), np.maximum(0.7 - t, 0.0))
    made = motion(t, R, np.where(contact, 0.0, -G * (t - 0.4)), contact=contact, slip=slip)
    made = replace(made, normal_force=np.where(contact & (t < 0.45), 40.0 * (0.4 - t), made.normal_force))
    output = transitions.read_motion(thrown(), made)
    assert output.first_mode is FORWARD
    assert kinds(output) == [(FORWARD, ROLL), (ROLL, FLIGHT), (FLIGHT, FORWARD), (FORWARD, ROLL)]
    assert times(output) == pytest.approx([0.2, 0.4, 0.5, 0.7], abs=1e-12)


def test_landing_that_ends_the_motion_is_no_contact():
    case = Case(line(), disc(R, 1.0), (Gravity(G), Unilateral(), Flight()), Start(0.0, gap=1.0), 1.0)
    t = np.append(np.linspace(0.0, 0.3, 31), 0.3)
    y, v = bounce(t, 0.3, 3.0, 0.0)
    output = transitions.read_motion(case, motion(t, y, v, contact=np.arange(32) == 31, status="landing"))
    assert output.first_mode is FLIGHT and output.transitions == ()


# --- turning ----------------------------------------------------------------------------------------------------------


def resisted(friction=None) -> Case:
    effects = (Gravity(G), friction or CoulombFriction(0.3), RollingResistance(0.005), Unilateral())
    return Case(line(), disc(R, 1.0), effects, Start(0.0, omega=-1.0), 2.0)


TURN, NOISE = np.linspace(0.0, 2.0, 201), np.random.default_rng(1).uniform(-1.0, 1.0, 201)
FREE = replace(resisted(), effects=(Gravity(G), CoulombFriction(0.3), Unilateral()))
# The case, its spin (rad/s) and slip (m/s), the first mode, and the transitions with their times.
TURNS = {
    "a roll that stops": (resisted(), np.minimum(0.4 * (TURN - 1.234), 0.0), 0.0, ROLL, [(ROLL, STICK, 1.234)]),
    "without slip": (
        resisted(PerfectlyRough()),
        np.minimum(0.4 * (TURN - 1.234), 0.0),
        0.0,
        ROLL,
        [(ROLL, STICK, 1.234)],
    ),
    "rest that gives way": (resisted(), 3.0 * np.maximum(TURN - 0.777, 0.0) ** 2, 0.0, STICK, [(STICK, ROLL, 0.777)]),
    "a roll that turns around": (resisted(), TURN - 1.0, 0.0, ROLL, []),
    "slip without spin": (resisted(), 0.0 * TURN, np.maximum(0.7 - TURN, 0.0), FORWARD, [(FORWARD, STICK, 0.7)]),
    "creep and spin below the resolution": (resisted(), 1e-3 * NOISE, 1e-4 * NOISE, STICK, []),
    "no resistance": (FREE, 0.0 * TURN, 0.0, ROLL, []),
}


@pytest.mark.parametrize("name", TURNS)
def test_turning_is_read_as_slip_is(name):
    case, omega, slip, first, changes = TURNS[name]
    how = {"slip_resolution": 1e-4} if "below" in name else {}
    made = motion(TURN, R, 0.0, contact=np.ones(201, dtype=bool), omega=omega, slip=slip, **how)
    output = transitions.read_motion(case, made)
    assert output.first_mode is first and kinds(output) == [change[:2] for change in changes]
    assert times(output) == pytest.approx([change[2] for change in changes], abs=1e-12)


# --- engines ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["box2d", "exudyn", "pymunk"])
def test_bounces_of_an_engine_are_read(name):
    adapter = pytest.importorskip(f"adapters.{name}")
    case = cases.load("bouncing_disc")
    refusal = adapter.refuses(case, "native")
    if refusal:
        pytest.skip(refusal)
    setting = adapter.ladder(case, "native")[3]
    output = transitions.read_motion(case, tasks.run_on_clock(adapter, case, "native", setting))
    rows = ledger.match(motion_of(case).transitions, output.transitions)
    assert output.first_mode is FLIGHT
    # The first five flights last more than ten of the engines' steps; what they make of the last ones is theirs.
    assert [row.pairing for row in rows if row.reference_time < 0.9] == ["paired"] * 4
    assert kinds(output)[-1][1] == ROLL  # exudyn's regularised friction may slip for a step after the last impact
    # An impact may come a step late, and leave with the speed of that step; the next comes later by twice as much.
    first = next(row for row in rows if row.pairing == "paired")
    assert abs(first.error) <= setting["h"]
