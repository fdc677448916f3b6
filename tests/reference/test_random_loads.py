"""Random loads of every width in every variable: motions end within a CPU limit, conserve energy and agree with a fine
integration."""

import numpy as np
import pytest

import reference
from cases import Case, Gravity, Load, Start, Unilateral, disc
from cases.contact import start_motion
from cases.library import line
from tests.scenes.limits import cpu_limit
from tests.scenes.loads import ALONG, G, by_hand, distance, growth, scene

# CPU seconds for one motion, with what it derives and compiles; most take half of one. A stiff moment (seed 1283: the
# spin decays at 14,000/s, and DOP853 tries steps beyond its limit of stability) takes eleven.
PATIENCE = 20.0
NAMES = ("x", "y", "theta", "vx", "vy", "omega")
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


def check(seed: int) -> None:
    """Hold one random load's motion, by both methods and at a random tolerance, to the motion by hand and to energy."""
    rng = np.random.default_rng(seed)
    case, terms = scene(rng)
    rtol = float(rng.choice(TOLERANCES))
    begin = start_motion(case)
    with cpu_limit(2.0 * PATIENCE):
        hand = by_hand(case, terms)
    allowed = 30.0 * rtol + 1e-10
    for method in reference.METHODS:
        about = (seed, method, rtol, [(term.component, term.formula) for term in terms])
        with cpu_limit(PATIENCE):
            motion = reference.simulate(case, rtol=rtol, method=method)
            status, time = motion.status, float(motion.t[-1])
            state = [float(getattr(motion(motion.t[-1]), name)) for name in NAMES]
        # A speed of the centre is a difference of two in the contact, which turn with the angle and its rounding.
        rounding = 4.0 * np.finfo(float).eps * abs(hand.state[2])
        if status == "unfinished" or (status == "breakdown" and rounding > 30.0 * rtol):
            # It ended with a sentence, and is held to energy up to there. (A moment may spin a plate to 1e15 rad/s: no
            # step has the tolerance any more.)
            assert rtol <= 1e-10 or rounding > 30.0 * rtol, about
        else:
            assert status == hand.status, about
            off = distance(hand, state, time)
            assert off <= allowed or off <= allowed * growth(case, terms, hand), (off, about)
        if all(term.conservative for term in terms):
            places = {name: (float(getattr(begin, name)), state[NAMES.index(name)]) for name in ALONG.values()}
            work = [term.work(*places[term.variable]) for term in terms]
            first, last = (energy(case, values) for values in ([getattr(begin, n) for n in NAMES], state))
            size = abs(first) + abs(last) + sum(map(abs, work))
            assert abs(last - first - sum(work)) <= 10.0 * allowed * size, (last - first - sum(work), about)


def energy(case, state) -> float:
    """Kinetic energy and that of the height, J."""
    _, y, _, vx, vy, omega = state
    return 0.5 * case.plate.mass * (vx**2 + vy**2 + 2.0 * G * y) + 0.5 * case.plate.inertia * omega**2


def test_moment_far_in_the_tail_of_tanh_is_constant():
    """The argument of this load's tanh grows to 1e9; roundings of its series were a hundredth of the moment."""
    check(463)


@pytest.mark.sampled(10, first=5)
@pytest.mark.parametrize("seed", [333, 422, 831, 1139, 1323, 1374])
def test_plates_that_a_load_spins_up_to_1e8_rad_per_s_and_more(seed):
    """The speed of the centre is a difference of speeds up to 1e14 m/s, and the angle has its own rounding: neither is
    a load that no step resolves."""
    check(seed)


@pytest.mark.parametrize("method", reference.METHODS)
def test_plate_spun_by_1e12_rad_keeps_its_place(method):
    """The angle is rounded to 1e-4 rad there, and its cosine and sine would move the centre by 1e-5 m."""
    effects = Gravity(G), Load(moment=2e9), Unilateral()
    case = Case(line(), disc(0.1, 1.0), effects, Start(0.0, slip=0.5, omega=-5.0), 2.0)
    end = reference.simulate(case, method=method)(2.0)  # the centre goes at 1 m/s
    assert end.theta > 7e11
    assert (end.x, end.y) == pytest.approx((2.0, 0.1), abs=1e-12)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", [1610, 2032])
def test_narrow_loads_keep_their_digits_in_the_equations(seed):
    """((x - c)/w)² + 1 multiplied out loses the digits of (c/w)²: 1e8 and more in these."""
    check(seed)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("seed", range(12))
def test_motions_under_random_loads(seed):
    check(seed)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(40))
def test_motions_under_two_thousand_random_loads(block):
    for seed in range(100 + 50 * block, 150 + 50 * block):
        check(seed)
