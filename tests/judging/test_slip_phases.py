"""Transitions read from samples, against motions whose transitions are known; matching."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import cases
import reference
from cases import Mode, State, Trajectory, Transition
from reports.judging import ledger, slip_phases
from tests.scenes.motions import sampled

MU, G = 0.1, 9.81
FORWARD, BACKWARD, ROLL, FLIGHT = Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD, Mode.ROLL, Mode.FLIGHT


def motion(t, slip, normal=None, friction=None, resolution=0.0, speed=1.0, status="completed") -> Trajectory:
    """A trajectory of which only what the reading looks at matters."""
    zero, unknown = np.zeros(len(t)), np.full(len(t), np.nan)
    forces = (unknown if force is None else force for force in (normal, friction))
    columns = dict.fromkeys(State._fields, zero) | {"vx": zero + speed, "slip": np.asarray(slip, dtype=float)}
    columns |= dict(zip(("normal_force", "friction_force"), forces, strict=True))
    return Trajectory(t=t, **columns, slip_resolution=resolution, status=status)


def bowling(t, v0=1.0, mu=MU) -> np.ndarray:
    """Slip of a disc on a level line: v0 − 3 μ g t until v0/(3 μ g), then none (textbook, J = m r²/2)."""
    return np.maximum(v0 - 3 * mu * G * t, 0.0)


def kinds(reading) -> list[tuple[Mode, Mode]]:
    return [(event.before, event.after) for event in reading.transitions]


@pytest.fixture(scope="module")
def circle():
    """The paper's application for μ = 0.1 (reversals) and 0.2 (rolls), by the reference at rtol 1e-13."""
    return {mu: reference.simulate(cases.load("disc_in_circle", mu=mu), rtol=1e-13) for mu in (0.1, 0.2)}


# --- reading ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [10, 30, 100, 3000])
def test_straight_branch_gives_the_exact_time(count):
    t = np.linspace(0.0, 0.68, count)
    reading = slip_phases.read_contact(motion(t, bowling(t)), MU)
    assert reading.first_mode is FORWARD and kinds(reading) == [(FORWARD, ROLL)]
    # A polynomial through a straight line is exact but for the rounding of v (1e-16) over its slope (3 μ g = 2.9).
    assert reading.transitions[0].time == pytest.approx(1.0 / (3 * MU * G), abs=1e-14)


def test_what_would_happen_after_the_last_sample_has_not_happened():
    """A slip that falls below what the solver resolves, and would end in half a minute."""
    t = np.linspace(0.0, 2.5, 501)
    slow = motion(t, 0.02 * (1.0 - t / 35.0), resolution=0.0095)
    reading = slip_phases.read_contact(slow, MU)
    assert slow.slip[-1] < slip_phases.SURELY * slow.slip_resolution < slow.slip[0]
    assert (reading.first_mode, reading.transitions, reading.spreads) == (FORWARD, (), ())
    whole = np.linspace(0.0, 50.0, 501)
    late = slip_phases.read_contact(motion(whole, np.maximum(0.02 * (1.0 - whole / 35.0), 0.0), resolution=0.0095), MU)
    assert [event.time for event in late.transitions] == [pytest.approx(35.0, abs=1e-9)]


@given(st.floats(0.1, 10.0), st.floats(0.02, 1.0), st.integers(12, 400), st.floats(1.2, 4.0))
def test_bowling_is_read_to_rounding_for_any_throw_and_grid(v0, mu, count, last):
    exact = v0 / (3 * mu * G)
    t = np.linspace(0.0, last * exact, count)
    reading = slip_phases.read_contact(motion(t, bowling(t, v0, mu), speed=v0), mu)
    assert kinds(reading) == [(FORWARD, ROLL)]
    assert reading.transitions[0].time == pytest.approx(exact, rel=1e-12)


# Bounds: half a gap of the samples where a branch has a handful of them, then ten times (gap / 0.3 s)^5: the error of a
# local polynomial of degree five with 0.3 s, half a slip phase, for the time over which the slip changes.
@pytest.mark.parametrize("mu", [0.1, 0.2])
@pytest.mark.parametrize("count, bound", [(31, 4.2e-2), (126, 1e-5), (501, 1e-8), (2501, 1e-11)])
def test_curved_branches_are_read_to_the_documented_error(circle, accuracy, mu, count, bound):
    exact = circle[mu]
    rows = ledger.match(exact.transitions, slip_phases.read_contact(sampled(exact, count), mu).transitions)
    assert [row.pairing for row in rows] == ["paired"] * len(exact.transitions)
    worst = max((row.error for row in rows), key=abs)
    output = f"transitions read from {count} samples / s"
    accuracy(
        case=f"disc_in_circle[mu={mu}]",
        solver="reading",
        route="samples",
        quantity=output,
        error=worst,
        tolerance=bound,
    )


@pytest.mark.parametrize("count", [126, 501, 2501])
def test_spread_tells_the_size_of_the_error(circle, count):
    exact = circle[0.2]
    reading = slip_phases.read_contact(sampled(exact, count), 0.2)
    for found, spread, true in zip(reading.transitions, reading.spreads, exact.transitions, strict=True):
        # The spread is a movement of the estimate, no bound; an error ten times as large would make it useless.
        assert abs(found.time - true.time) <= 10 * spread + 1e-15


def test_onset_of_slip_is_read_from_the_cone_where_the_slip_has_just_begun(circle):
    exact = circle[0.2]
    # Three slipping samples are too few for the root of the slip; the cone has all of the roll.
    t = np.arange(0.65, exact.transitions[1].time + 0.0035, 0.001)
    state = exact(t)
    reading = slip_phases.read_contact(motion(t, state.slip, state.normal_force, state.friction_force), 0.2)
    assert kinds(reading) == [(ROLL, BACKWARD)]
    assert reading.transitions[0].time == pytest.approx(exact.transitions[1].time, abs=1e-8)


SHAKEN = np.random.default_rng(1).standard_normal(1001)
# Noise of the slip (m/s), resolution (m/s), factor of the normal force, coefficient, and the largest error (s): without
# forces and with noisy ones, that of the samples; extrapolation over a few samples enlarges noise by about a hundred,
# and the slopes there are of the order one to ten.
POOR = {
    "no forces": (0.0, 0.0, np.nan, None, 1e-8),
    "noisy forces": (0.0, 0.0, np.abs(1.0 + 0.5 * SHAKEN), 0.2, 1e-8),
    "rounding": (1e-12, 0.0, 1.0, 0.2, 1e-9),
    "noise": (1e-7, 1e-6, 1.0, 0.2, 1e-5),
}


@pytest.mark.parametrize("how", POOR)
def test_poor_samples_move_transitions_no_more_than_their_size_allows(circle, how):
    noise, resolution, factor, mu, bound = POOR[how]
    clean = sampled(circle[0.2], 1001)
    friction = clean.friction_force + 0.0 * factor
    slip = clean.slip + noise * SHAKEN
    made = motion(clean.t, slip, factor * clean.normal_force, friction, resolution, speed=3.0)
    rows = ledger.match(circle[0.2].transitions, slip_phases.read_contact(made, mu).transitions)
    assert [row.pairing for row in rows] == ["paired"] * 4
    assert max(abs(row.error) for row in rows) <= bound


def test_time_does_not_depend_on_the_declared_resolution():
    # A threshold would be late by resolution / (3 μ g) = 3e-3 s.
    t = np.linspace(0.0, 0.68, 300)
    times = [
        slip_phases.read_contact(motion(t, bowling(t), resolution=r), MU).transitions[0].time for r in (0.0, 1e-4, 1e-2)
    ]
    assert np.ptp(times) <= 1e-14


def regularised(mu: float, creep: float, t: np.ndarray) -> Trajectory:
    """Disc in the paper's circle with friction −μ N v/creep while |v| < creep (m = 1 kg)."""
    length = 0.9

    def forces(y):
        normal = G * np.sin(y[0]) + length * y[1] ** 2
        return normal, -mu * normal * np.clip(y[2] / creep, -1.0, 1.0)

    def rates(_, y):
        friction = forces(y)[1]
        pull = G * np.cos(y[0])
        return [y[1], (pull + friction) / length, pull + 3 * friction]

    y = solve_ivp(rates, (0.0, t[-1]), np.zeros(3), method="Radau", t_eval=t, rtol=1e-9, atol=1e-12).y
    return motion(t, y[2], *forces(y), resolution=creep, speed=3.0)


def test_creep_in_stick_is_no_slip(circle):
    creep = 1e-4
    reading = slip_phases.read_contact(regularised(0.2, creep, np.linspace(0.0, 2.5, 1001)), 0.2)
    rows = ledger.match(circle[0.2].transitions, reading.transitions)
    assert [row.pairing for row in rows] == ["paired"] * 4
    # The regularised motion itself is another one: its events shift by a few tenths of creep over a slope of order one.
    assert max(abs(row.error) for row in rows) <= creep


def test_start_from_rest_without_normal_force_slips_from_the_first_instant(circle):
    reading = slip_phases.read_contact(sampled(circle[0.1], 501), 0.1)
    assert reading.first_mode is FORWARD
    assert kinds(reading) == [(FORWARD, BACKWARD), (BACKWARD, FORWARD)]


EVEN = np.linspace(0.0, 2.0, 201)
# One long step carries the slip past zero, short ones bring it back: an adaptive stepper meets stiff friction.
UNEVEN = np.concatenate([np.linspace(0.0, 1.0, 101), 1.01 + np.linspace(0.0, 0.004, 5), np.linspace(1.02, 2.0, 99)])
OVERSHOOT = np.concatenate([1.0051 - np.linspace(0.0, 1.0, 101), [-4e-3, -3e-3, -2e-3, -1e-3, 0.0], np.zeros(99)])
DOUBLED = np.sort(np.append(EVEN / 4, EVEN[80:120] / 4))
ENDS = 1.0 / (3 * MU * G)
# Times, slip, coefficient that bounds stick, first mode, and the transitions with their times (None: not looked at).
SHAPES = {
    "a reversal on a sample": (EVEN, np.where(EVEN == 1.0, 0.0, 1.0 - EVEN), MU, FORWARD, [(FORWARD, BACKWARD, 1.0)]),
    "a short roll of some samples": (
        EVEN, np.where(EVEN < 1.0, 1.0 - EVEN, -(np.maximum(EVEN - 1.05, 0.0) ** 2)), None, FORWARD,
        [(FORWARD, ROLL, None), (ROLL, BACKWARD, None)],
    ),
    "a roll throughout": (EVEN, 1e-12 * np.random.default_rng(0).standard_normal(201), MU, ROLL, []),
    "a roll that ends": (EVEN, 3.0 * np.maximum(EVEN - 0.4, 0.0) ** 2, MU, ROLL, [(ROLL, FORWARD, 0.4)]),
    "slip throughout": (EVEN, 0.5 * EVEN, MU, FORWARD, []),
    "an overshoot of one step": (UNEVEN, OVERSHOOT, None, FORWARD, [(FORWARD, ROLL, 1.0051)]),
    "doubled times": (DOUBLED, bowling(DOUBLED), MU, FORWARD, [(FORWARD, ROLL, ENDS)]),
    "no friction": (EVEN, np.cos(9 * EVEN), 0.0, Mode.SLIDE, []),
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES)
def test_a_shape_of_slip_is_read_as_what_it_is(shape):
    t, slip, bound, first, changes = SHAPES[shape]
    reading = slip_phases.read_contact(motion(t, slip), bound)
    assert reading.first_mode is first and kinds(reading) == [change[:2] for change in changes]
    for event, (*_, time) in zip(reading.transitions, changes, strict=True):
        assert time is None or event.time == pytest.approx(time, abs=1e-12)


def test_lift_off_ends_the_reading_in_flight():
    t = np.linspace(0.0, 0.5, 100)
    reading = slip_phases.read_contact(motion(t, bowling(t), status="lift_off"), MU)
    assert kinds(reading) == [(FORWARD, ROLL), (ROLL, FLIGHT)]
    assert reading.transitions[-1].time == 0.5


# --- matching ---------------------------------------------------------------------------------------------------------


def events(*rows) -> list[Transition]:
    return [Transition(*row) for row in rows]


TRUTH = events((1.0, FORWARD, ROLL), (2.0, ROLL, BACKWARD), (3.0, BACKWARD, ROLL))


def test_equal_sequences_match_with_signed_errors():
    found = events((1.1, FORWARD, ROLL), (1.9, ROLL, BACKWARD), (3.0, BACKWARD, ROLL))
    rows = ledger.match(TRUTH, found)
    assert [row.pairing for row in rows] == ["paired"] * 3
    assert [row.error for row in rows] == pytest.approx([0.1, -0.1, 0.0])
    assert [row.event for row in rows] == [1, 2, 3]


def test_extra_transitions_are_spurious_and_spoil_no_match():
    extra = events((1.5, ROLL, FORWARD), (1.6, FORWARD, ROLL))
    rows = ledger.match(TRUTH, [TRUTH[0], *extra, *TRUTH[1:]])
    assert sorted(row.pairing for row in rows) == ["paired"] * 3 + ["spurious"] * 2
    assert [row.error for row in rows if row.pairing == "paired"] == [0.0] * 3


def test_among_equal_matchings_the_nearest_in_time_is_taken():
    found = events((0.2, FORWARD, ROLL), (0.5, ROLL, FORWARD), (1.01, FORWARD, ROLL))
    rows = ledger.match(TRUTH[:1], found)
    matched = [row for row in rows if row.pairing == "paired"]
    assert len(matched) == 1 and matched[0].time == 1.01


def test_nothing_found_is_all_missed():
    rows = ledger.match(TRUTH, [])
    assert [row.pairing for row in rows] == ["missed"] * 3
    assert all(np.isnan(row.error) and np.isnan(row.time) for row in rows)
    # One of another kind is both missed and spurious.
    rows = ledger.match(TRUTH[:1], events((1.0, FORWARD, BACKWARD)))
    assert sorted(row.pairing for row in rows) == ["missed", "spurious"]


kind = st.sampled_from([(FORWARD, ROLL), (ROLL, BACKWARD), (ROLL, FORWARD), (BACKWARD, ROLL)])
sequences = st.lists(st.tuples(st.floats(0, 10), kind), max_size=6).map(
    lambda rows: [Transition(t, *k) for t, k in sorted(rows, key=lambda row: row[0])]
)


@given(sequences, sequences)
def test_ledger_accounts_for_every_transition_once(truth, found):
    rows = ledger.match(truth, found)
    count = {verdict: sum(row.pairing == verdict for row in rows) for verdict in ("paired", "missed", "spurious")}
    assert count["paired"] + count["missed"] == len(truth)
    assert count["paired"] + count["spurious"] == len(found)


def test_a_phase_too_short_for_the_samples_is_unresolved_and_not_missed():
    def at(*times):
        return [Transition(t, Mode.FLIGHT, Mode.FLIGHT) for t in times]

    truth = [*at(1.0, 1.5, 1.51), Transition(1.52, Mode.FLIGHT, Mode.ROLL)]
    coarse = ledger.match(truth, [*at(1.0, 1.5), truth[-1]], gap=0.01)
    assert [row.pairing for row in coarse] == ["paired", "paired", "unresolved", "paired"]
    assert [row.pairing for row in ledger.match(truth, [*at(1.0, 1.5), truth[-1]], gap=0.001)][2] == "missed"
    # A slip too short to be sampled as well; one that samples can have is missed.
    slips = [Transition(1.0, Mode.ROLL, Mode.SLIP_FORWARD), Transition(1.001, Mode.SLIP_FORWARD, Mode.ROLL)]
    assert [row.pairing for row in ledger.match(slips, [], gap=0.01)] == ["unresolved", "unresolved"]
    assert [row.pairing for row in ledger.match(slips, [], gap=0.0001)] == ["missed", "missed"]
