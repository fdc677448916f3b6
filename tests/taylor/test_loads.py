"""No step passes over what a load in place or velocity does, however narrow that is: exact speeds, times and places."""

from math import asinh, erf, exp, log, pi, sqrt

import mpmath
import numpy as np
import pytest

import reference
from cases import Case, Gravity, Load, Start, Unilateral, disc
from cases.library import line
from reference.minimal.integrators import dop853, taylor
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.limits import cpu_limit

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


# --- exact speeds: by the work that a force in place does -------------------------------------------------------------


WIDTHS = (1.0, 0.2, 0.1, 1e-2, 1e-3, 1e-5, 1e-7)
HILLS = [(width, strength) for width in WIDTHS for strength in (20.0, 2.0 / width)]


@pytest.mark.parametrize(("width", "strength"), [hill if hill == (1e-2, 20.0) else slowly(*hill) for hill in HILLS])
@FORMULATIONS
def test_a_hill_of_force_is_felt(width, strength, methods):
    """m v²/2 grows by A w √π. At 0.2 m the default method felt nothing (2.000 for 4.264 m/s), at 0.01 m none did."""
    case = sliding(Load(fx=f"{strength!r}*exp(-((x-2)/{width!r})**2)"))
    # From x = 0 to the end: all of it but for the tails of the widest.
    last = float(reference.simulate(case).x[-1])
    work = strength * width * sqrt(pi) / 2 * (erf(2 / width) + erf((last - 2) / width))
    # The place is known to a rounding, and so the force on a slope: 4 eps 2 m A/w for as long as w/v.
    known = 2e-10 + 8 * np.finfo(float).eps * strength
    for method in methods:
        assert at_end(case, method)["vx"] == pytest.approx(sqrt(4.0 + 2.0 * work), abs=known), method


def soft_wall(x):
    """The potential of a force -1e4 log(1 + exp(200 (x - 2)))/200, J."""
    return 1e4 / 200 * mpmath.quad(lambda s: mpmath.log1p(mpmath.exp(200 * (s - 2))), [0, 1.9, x])


POTENTIALS = {
    "soft wall": ("-1e4*log(1+exp((x-2)*200))/200", soft_wall),
    "step": ("1.5*(1+tanh(20*(x-3)))", lambda x: -1.5 * (x + (_logcosh(20 * (x - 3)) - _logcosh(60.0)) / 20)),
    "kink": ("-3*sqrt(1e-12+(x-2)**2)", lambda x: 1.5 * (_root(x - 2) - _root(-2.0))),
    "high power": ("-5*(x/2)**60", lambda x: 10 / 61 * (x / 2) ** 61),
    "many hills": (
        "20*exp(-(sin(x)/0.001)**2)",
        lambda x: -20 * mpmath.quad(lambda s: mpmath.exp(-((mpmath.sin(s) / 0.001) ** 2)), _about_pi(x)),
    ),
    "narrow plateau": (
        "1000*(tanh((x-2)/1e-4)-tanh((x-2.0005)/1e-4))",
        lambda x: -0.1 * (_logcosh((x - 2) / 1e-4) - _logcosh((x - 2.0005) / 1e-4) + 5.0),
    ),
}


def _logcosh(u):
    return abs(u) + log((1 + exp(-2 * abs(u))) / 2)


def _root(u):
    return u * sqrt(u * u + 1e-12) + 1e-12 * asinh(u / 1e-6)


def _about_pi(x):
    return (
        [0, 0.005, 0.01, pi - 0.01, pi - 0.003, pi, pi + 0.003, pi + 0.01, x] if x > pi + 0.02 else [0, 0.005, 0.01, x]
    )


QUICK = ("step",)


@pytest.mark.parametrize("name", [name if name in QUICK else slowly(name) for name in POTENTIALS])
def test_a_force_in_place_conserves_energy(name):
    """At the place where each method ends its speed is that of energy: the soft wall was passed through, the step not
    felt."""
    formula, potential = POTENTIALS[name]
    case = sliding(Load(fx=formula))
    ends = {method: at_end(case, method) for method in (*reference.METHODS, "second")}
    for method, end in ends.items():
        exact = 4.0 - 2.0 * float(potential(end["x"]))
        assert end["vx"] ** 2 == pytest.approx(exact, abs=2e-8), method
    # And at the same time they are at the same place.
    for end in ends.values():
        assert end["x"] == pytest.approx(ends["second"]["x"], abs=5e-9)


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


@quick_every(4)
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


@quick_every(2)
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


def test_a_load_without_a_value_ends_with_a_status():
    for method in EVERY:
        motion = reference.simulate(sliding(Load(fx="sqrt(2-x)")), method=method)
        assert motion.status == "breakdown" and "t = " in motion.reason
        # v²/2 = 2 + (2/3)(2^(3/2) - (2 - x)^(3/2)) until x = 2.
        assert float(motion.x[-1]) == pytest.approx(2.0, abs=1e-6)
