"""Random loads of every width in every variable: motions end within a CPU limit and break no law."""

import numpy as np
import pytest

import reference
from cases import Case, Gravity, Load, Start, Unilateral, disc
from cases.library import line
from tests.sampling import quick_every
from tests.scenes.limits import cpu_limit
from tests.scenes.loads import G, scene

# CPU seconds for one motion, with what it derives and compiles; most take half of one. A stiff moment (seed 1283: the
# spin decays at 14,000/s, and DOP853 tries steps beyond its limit of stability) takes eleven.
PATIENCE = 20.0
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
ENDINGS = ("completed", "landing", "lift_off")


def check(seed: int) -> None:
    """The motion under one random load, by both methods and at a random tolerance, breaks no law. It may end with a
    sentence where a moment spins the plate to 1e15 rad/s: no step has the tolerance any more."""
    rng = np.random.default_rng(seed)
    case, terms = scene(rng)
    rtol = float(rng.choice(TOLERANCES))
    for method in reference.METHODS:
        about = (seed, method, rtol, [(term.component, term.formula) for term in terms])
        with cpu_limit(PATIENCE):
            motion = reference.simulate(case, rtol=rtol, method=method)
        spins = 4.0 * np.finfo(float).eps * abs(float(motion(motion.t[-1]).theta)) > 30.0 * rtol
        is_stopped = (
            motion.status == "unfinished" and rtol <= 1e-10 or motion.status in ("unfinished", "breakdown") and spins
        )
        assert motion.status in ENDINGS or is_stopped, (motion.status, about)
        assert not reference.check(case, motion, rtol), about


def test_moment_far_in_the_tail_of_tanh_is_constant():
    """The argument of this load's tanh grows to 1e9; roundings of its series were a hundredth of the moment."""
    check(463)


@quick_every(10, first=5)
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


@quick_every(2)
@pytest.mark.parametrize("seed", [1610, 2032])
def test_narrow_loads_keep_their_digits_in_the_equations(seed):
    """((x - c)/w)² + 1 multiplied out loses the digits of (c/w)²: 1e8 and more in these."""
    check(seed)


@quick_every(4)
@pytest.mark.parametrize("seed", range(12))
def test_motions_under_random_loads(seed):
    check(seed)
