"""The atlas of hard scenes: what the reference does there."""

import signal
from contextlib import contextmanager

import numpy as np
import pytest

import cases
import reference
from cases import Mode

# A hard scene of a second or so takes the reference well below a second; on a busy machine, and with the derivation of
# its equations, a few.
PATIENCE = 20


@contextmanager
def within(seconds: int):
    """Raises TimeoutError where the block takes longer (a loop in Python, as the reference's is)."""

    def late(*_):
        raise TimeoutError(f"still running after {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("slip", [1e-12, -1e-12])
@pytest.mark.xfail(
    strict=True,
    reason="solve.first_regime takes 1e-12 m/s for slip (above 8 eps of the speeds), transitions._by_value for slip that "
    "has just vanished (below 1e3 eps of the rates): it asks whether it grows, it does not, and nothing follows: "
    "`lift_off` at time zero, on a level incline",
)
def test_a_slip_just_above_rounding_ends_and_does_not_lift_the_plate_off(slip, method):
    motion = reference.simulate(cases.load("almost_rolling", slip=slip), method=method)
    assert motion.status == "completed"
    assert [t.after for t in motion.transitions] == [Mode.ROLL]


@pytest.mark.skipif("taylor" not in reference.METHODS, reason="needs heyoka")
@pytest.mark.xfail(
    strict=True,
    reason="heyoka's power of zero: s**5 at s = 0 has NaN for Taylor coefficients (s**3 has not); taylor._leave_start "
    "takes NaN guards for zeros, so 100,000 phases of no length follow in a minute, with a flood of heyoka's warnings",
)
def test_a_track_of_fifth_power_can_be_started_at_its_inflection(capfd):
    case = cases.load("released_at_an_inflection", power=5.0)
    with within(PATIENCE):
        motion = reference.simulate(case, rtol=1e-10, method="taylor")
    exact = reference.simulate(case, rtol=1e-10, method="dop853")
    assert motion.status == exact.status == "completed"
    assert motion.x[-1] == pytest.approx(exact.x[-1], abs=1e-8)


@pytest.mark.skipif("taylor" not in reference.METHODS, reason="needs heyoka")
@pytest.mark.xfail(
    strict=True,
    reason="taylor._integrate: towards the paradox the normal force grows without bound and steps shrink until time "
    "stands still; `while integrator.time < end` then runs for ever (dop853 says paradox at 0.0597567881 s)",
)
def test_a_rod_on_its_way_into_the_paradox_does_not_hang():
    with within(PATIENCE):
        motion = reference.simulate(cases.load("rod_into_the_paradox", mu=2.0), rtol=1e-9, method="taylor")
    assert motion.status == "paradox"
    assert motion.t[-1] == pytest.approx(0.05975678, abs=1e-6)
    assert np.all(np.isfinite(motion.normal_force))
