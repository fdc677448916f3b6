"""No step passes over what a load in place or velocity does, however narrow that is: exact speeds, times and places."""

from math import log, pi, sqrt

import mpmath
import pytest

import reference
from cases import Case, Gravity, Load, Start, Unilateral, disc
from cases.library import line
from reference.minimal.integrators import dop853, taylor
from tests.scenes import second as second_states
from tests.scenes.limits import cpu_limit

pytestmark = pytest.mark.taylor

G, RADIUS = 9.81, 0.1
EVERY = (*reference.METHODS, "augmented")


def slowly(*values):
    """A parameter of the slow tests."""
    return pytest.param(*values, marks=pytest.mark.slow)


# The second formulation takes seconds for what the methods of the first do in a fraction of one.
FORMULATIONS = pytest.mark.parametrize("methods", [EVERY, slowly(("second",))], ids=["first", "second"])


def sliding(load: Load, *effects, speed=2.0, omega=0.0, duration=3.0) -> Case:
    """A disc of 1 kg that slides along a level line, without friction if no effect brings any."""
    start = Start(0.0, slip=speed + omega * RADIUS, omega=omega)
    return Case(line(), disc(RADIUS, 1.0), (Gravity(G), load, *effects, Unilateral()), start, duration)


def at_end(case: Case, method: str, rtol: float = 1e-10):
    """The state (with vx, x, …) at the end of a motion that has to complete, by one of the first formulation's methods
    or by the second formulation."""
    if method == "second":
        answer = second_states.motion(case, rtol=rtol)
        assert answer.status == "completed"
        return dict(zip(second_states.MOTION, answer.last.motion, strict=True))
    motion = reference.simulate(case, rtol=rtol, method=method)
    assert motion.status == "completed", motion.reason
    last = motion(case.duration)
    return {name: float(getattr(last, name)) for name in second_states.MOTION}


# --- exact motions: loads in velocity, spin and time ------------------------------------------------------------------


@pytest.mark.parametrize("width", [slowly(1.0), 0.05, slowly(1e-3)])
def test_a_brake_by_tanh(width):
    """v̇ = -2 tanh(v/w): sinh(v/w) falls by exp(-2 t/w). At 0.05 m/s the default method braked to -3.0 m/s."""
    case = sliding(Load(fx=f"-2*tanh(vx/{width!r})"), speed=3.0)
    with mpmath.workdps(30):
        w = mpmath.mpf(repr(width))

        def speed(t):
            return w * mpmath.asinh(mpmath.sinh(3 / w) * mpmath.exp(-2 * t / w))

        way = mpmath.quad(speed, [0, 1.4, 1.49, 1.5, 1.51, 1.6, 3])
        exact = float(speed(3)), float(way)
    for method in (*reference.METHODS, "second"):
        end = at_end(case, method)
        assert (end["vx"], end["x"]) == pytest.approx(exact, abs=5e-10), method


# --- normal force, friction, flight -----------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [slowly(0.1), 1e-3, slowly(1e-6)])
@FORMULATIONS
def test_a_narrow_lift_ends_the_contact(width, methods):
    """fy = 30 exp(-((x-2)/w)²) exceeds the weight from x = 2 - w √ln(30/9.81) on. No rate of the motion depends on it:
    only the normal force does."""
    case = sliding(Load(fy=f"30*exp(-((x-2)/{width!r})**2)"))
    exact = (2.0 - width * sqrt(log(30 / G))) / 2.0
    for method in methods:
        if method == "second":
            second = second_states.motion(case, rtol=1e-12)
            assert (second.status, second.end) == ("lift_off", pytest.approx(exact, abs=1e-11))
            continue
        motion = reference.simulate(case, method=method)
        assert (motion.status, float(motion.t[-1])) == ("lift_off", pytest.approx(exact, abs=1e-12)), method


# --- accuracy, cost, and what cannot be done --------------------------------------------------------------------------

SOME = {
    "hill": (Load(fx="20*exp(-((x-2)/0.2)**2)"), 2.0, sqrt(4.0 + 8.0 * sqrt(pi))),
    "narrow hill": (Load(fx="2000*exp(-((x-2)/0.001)**2)"), 2.0, sqrt(4.0 + 4.0 * sqrt(pi))),
    "soft wall": (Load(fx="-1e4*log(1+exp((x-2)*200))/200"), 2.0, -2.0),
    "brake": (Load(fx="-2*tanh(vx/0.05)"), 3.0, 0.0),
    "well": (Load(fx="-3*(x-1)/(0.0001+(x-1)**2)"), 2.0, None),
}


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", SOME)
@pytest.mark.parametrize("rtol", [slowly(1e-3), 1e-5, slowly(1e-7), slowly(1e-9), slowly(1e-11), 1e-13])
def test_the_default_is_as_accurate_as_its_tolerance_or_as_dop853(name, rtol):
    """Nowhere is its error both above the tolerance (of speeds of some metres per second) and above DOP853's."""
    load, speed, exact = SOME[name]
    case = sliding(load, speed=speed)
    errors = []
    for method in (reference.METHODS[0], "dop853"):
        end = at_end(case, method, rtol)
        if exact is None:  # ½ v² + ½·3·log(1e-4 + (x-1)²) is constant
            x = end["x"]
            errors.append(abs(end["vx"] ** 2 - (4.0 - 3.0 * log((1e-4 + (x - 1) ** 2) / (1e-4 + 1)))) / 4.0)
        else:
            errors.append(abs(end["vx"] - exact))
    assert errors[0] <= max(4.0 * rtol, errors[1], 1e-12), errors


@pytest.mark.sampled(2)
@pytest.mark.parametrize("method", reference.METHODS)
def test_a_load_that_is_too_fast_ends_with_a_status_or_is_right(method, monkeypatch):
    """A brake of a nanometre per second needs steps of a nanosecond once it holds, at 1 s, unless a step ends there at
    rest: then the plate stays at x = v²/(2 a) = 1 m."""
    monkeypatch.setattr(taylor, "MOST_TRIES", 500)
    monkeypatch.setattr(dop853, "MOST_TRIES", 500)
    with cpu_limit(20.0):
        motion = reference.simulate(sliding(Load(fx="-2*tanh(vx/1e-9)")), method=method)
    if motion.status == "completed":
        assert (float(motion.x[-1]), float(motion.vx[-1])) == pytest.approx((1.0, 0.0), abs=1e-9)
        return
    assert (motion.status, "steps" in motion.reason) == ("unfinished", True)
    assert float(motion.t[-1]) == pytest.approx(1.0, abs=1e-3)
