"""No step passes over what a load in place or velocity does, however narrow that is: exact speeds, times and places."""

from math import asinh, erf, exp, log, pi, sinh, sqrt

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import reference
from cases import Case, CoulombFriction, Flight, Gravity, Load, Start, Unilateral, disc
from cases.library import circle, line
from reference.minimal.integrators import dop853, taylor
from reference.minimal.modes import candidates, phase
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
    "steep wall": ("-exp((x-2)*300)", lambda x: (exp((x - 2) * 300) - exp(-600)) / 300),
    "logistic": ("-100/(1+exp(-(x-2)*100))", lambda x: _softplus(100 * (x - 2)) - _softplus(-200.0)),
    "kink": ("-3*sqrt(1e-12+(x-2)**2)", lambda x: 1.5 * (_root(x - 2) - _root(-2.0))),
    "arc tangent": ("-3*atan((x-2)/1e-6)", lambda x: 3e-6 * (_of_atan((x - 2) / 1e-6) - _of_atan(-2e6))),
    "high power": ("-5*(x/2)**60", lambda x: 10 / 61 * (x / 2) ** 61),
    "many hills": (
        "20*exp(-(sin(x)/0.001)**2)",
        lambda x: -20 * mpmath.quad(lambda s: mpmath.exp(-((mpmath.sin(s) / 0.001) ** 2)), _about_pi(x)),
    ),
    "narrow plateau": (
        "1000*(tanh((x-2)/1e-4)-tanh((x-2.0005)/1e-4))",
        lambda x: -0.1 * (_logcosh((x - 2) / 1e-4) - _logcosh((x - 2.0005) / 1e-4) + 5.0),
    ),
    "bell": ("50*(1+((x-2)/1e-3)**2)**(-1.5)", lambda x: -0.05 * (_sine((x - 2) / 1e-3) - _sine(-2e3))),
    "quartic hill": (
        "500*exp(-((x-2)/1e-3)**4)",
        lambda x: -mpmath.quad(lambda s: 500 * mpmath.exp(-(((s - 2) * 1000) ** 4)), [1.99, 2, min(x, 2.01)]),
    ),
}


def _logcosh(u):
    return abs(u) + log((1 + exp(-2 * abs(u))) / 2)


def _softplus(u):
    return max(u, 0.0) + log(1 + exp(-abs(u)))


def _root(u):
    return u * sqrt(u * u + 1e-12) + 1e-12 * asinh(u / 1e-6)


def _of_atan(u):
    return u * np.arctan(u) - 0.5 * log(1 + u * u)


def _sine(u):
    return u / sqrt(1 + u * u)


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


@pytest.mark.slow
def test_a_narrow_hill_in_the_plane():
    """In x and y together: what lies beside the line by its own width is e times lower."""
    for beside in (0.0, 0.01):  # the same structure
        case = sliding(Load(fx=f"200*exp(-((x-2)**2+(y-{0.1 + beside!r})**2)/0.01**2)"))
        exact = sqrt(4.0 + 4.0 * sqrt(pi) * exp(-((beside / 0.01) ** 2)))
        for method in (*reference.METHODS, "second"):
            assert at_end(case, method)["vx"] == pytest.approx(exact, abs=2e-10), method


@pytest.mark.slow
def test_a_hill_that_moves():
    """Seen from the hill, which moves at 2.1 m/s, energy is conserved: the disc is overtaken at 0.1 m/s and thrown
    back from it."""
    case = sliding(Load(fx="20*exp(-((x-2.1*t+0.1)/0.001)**2)"))
    work = 20.0 * 0.001 * sqrt(pi)
    for method in (*reference.METHODS, "second"):
        # It comes to the hill from above and is pushed on by it: q = x - 2.1 t + 0.1 falls from 0.1 at 0.1 m/s.
        expected = 2.1 + 0.1 if work > 0.1**2 / 2 else 2.1 - sqrt(0.1**2 - 2 * work)
        assert at_end(case, method)["vx"] == pytest.approx(expected, abs=1e-9), method


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


@pytest.mark.slow
def test_a_spin_that_is_braked():
    """J ω̇ = -0.05 tanh(ω/w) on a disc that slides without friction."""
    for width in (0.1, 1e-3):
        case = sliding(Load(moment=f"-0.05*tanh(omega/{width!r})"), omega=4.0, duration=0.3)
        exact = width * asinh(sinh(min(4.0 / width, 700.0)) * exp(-10.0 / width * 0.3)) if width == 0.1 else 1.0
        for method in (*reference.METHODS, "second"):
            assert at_end(case, method)["omega"] == pytest.approx(exact, abs=2e-10), method


@pytest.mark.slow
def test_a_kick_at_an_angle():
    """A moment A exp(-((θ + 3)/w)²) turns a disc that spins at -4 rad/s: J ω²/2 falls by A w √π."""
    case = sliding(Load(moment="20*exp(-((theta+3)/0.0001)**2)"), omega=-4.0)
    exact = -sqrt(16.0 - 2.0 * 20.0 * 1e-4 * sqrt(pi) / 0.005)
    for method in (*reference.METHODS, "second"):
        assert at_end(case, method)["omega"] == pytest.approx(exact, abs=2e-9), method


@pytest.mark.slow
def test_pulses_in_time_that_no_polynomial_tells_of():
    """2000 exp(-(sin(3 t)/1e-4)²) at t = 0, π/3 and 2π/3: 2.5 times A w √π/3, the first being halved."""
    case = sliding(Load(fx="2000*exp(-(sin(3*t)/0.0001)**2)"))
    with mpmath.workdps(30):
        one = 2 * mpmath.quad(lambda t: 2000 * mpmath.exp(-((mpmath.sin(3 * t) * 10000) ** 2)), [0, 1e-4, 3e-4, 1e-3])
    for method in (*reference.METHODS, "second"):
        assert at_end(case, method)["vx"] == pytest.approx(2.0 + 2.5 * float(one), abs=2e-9), method


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


@pytest.mark.slow
@pytest.mark.parametrize("width", [0.05, 1e-4])
@FORMULATIONS
def test_a_narrow_press_is_felt_by_friction(width, methods):
    """While it slides, v dv = -μ (g - fy/m) dx: a press of -A exp(-((x-0.5)/w)²) takes μ A w √π more."""
    strength = 2.0 / width
    case = sliding(Load(fy=f"-{strength!r}*exp(-((x-0.5)/{width!r})**2)"), CoulombFriction(0.1), speed=4.0)
    for method in methods:
        when = 0.3
        if method == "second":
            x, _, _, vx, *_ = second_states.motion(case, rtol=1e-12, until=when).last.motion
        else:
            state = reference.simulate(case, method=method)(when)
            x, vx = float(state.x), float(state.vx)
        exact = sqrt(16.0 - 0.2 * (G * x + 2.0 * sqrt(pi)))
        assert (x > 0.9, vx) == (True, pytest.approx(exact, abs=2e-9)), method


def trampoline() -> Case:
    """A disc that falls on a force in y that begins 0.4 m above the line."""
    load = Load(fy="400*log(1+exp(-(y-0.5)*100))/100")
    start = Start(0.0, gap=1.0, slip=0.5)
    return Case(line(), disc(RADIUS, 1.0), (Gravity(G), load, Unilateral(), Flight()), start, 2.0)


@pytest.mark.slow
def test_a_trampoline_in_the_air_throws_the_plate_back():
    """Energy bounds how deep the disc falls, and it never lands. The default method was a metre too high after two
    seconds."""

    def potential(y):
        return G * y + 4.0 * float(
            mpmath.quad(lambda s: mpmath.log1p(mpmath.exp(-100 * (s - 0.5))), [y, max(y, 0.6), 3])
        )

    energy = potential(1.1)
    for method in EVERY:
        motion = reference.simulate(trampoline(), method=method)
        assert (motion.status, motion.transitions) == ("completed", ()), method
        for t in (0.3, 0.5, 0.9, 1.5, 2.0):
            state = motion(t)
            assert 0.5 * float(state.vy) ** 2 + potential(float(state.y)) == pytest.approx(energy, abs=2e-9)


@pytest.mark.slow
def test_a_trampoline_throws_the_plate_back_in_the_second_formulation():
    motion = reference.simulate(trampoline())
    second = second_states.motion(trampoline(), rtol=1e-12)
    assert (second.status, second.last.motion[1]) == ("completed", pytest.approx(float(motion.y[-1]), abs=1e-8))


@pytest.mark.slow
@pytest.mark.parametrize(("width", "duration"), [(0.1, 5.0), (0.02, 5.0), (0.02, 1.5)])
@FORMULATIONS
def test_a_moment_in_the_spin_brakes_a_rolling_disc(width, duration, methods):
    """A disc that rolls to and fro in a circle of 1 m, braked by -0.05 tanh(ω/w): after five seconds the default method
    was 0.4 mm off with w = 0.1 rad/s, 16 mm with 0.02. It rolls throughout: one equation is left, of Lagrange for the
    contact's angle s, which is integrated in steps of a millisecond."""
    arm = 1.0 - RADIUS
    effects = (Gravity(G), Load(moment=f"-0.05*tanh(omega/{width!r})"), CoulombFriction(0.9), Unilateral())
    case = Case(circle(1.0), disc(RADIUS, 1.0), effects, Start(4.0), duration)

    def rolling(_, z):
        moment = -0.05 * np.tanh(-arm * z[1] / RADIUS / width)
        return [z[1], -(G * np.cos(z[0]) + moment / RADIUS) / (1.5 * arm)]

    exact = solve_ivp(rolling, (0.0, duration), [4.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-14, max_step=1e-3)
    for method in methods:
        assert at_end(case, method)["x"] == pytest.approx(arm * np.cos(exact.y[0, -1]), abs=1e-9), method


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


def test_springs_and_dampers_cost_no_check():
    """A load that is a polynomial of second degree in place and velocity hides nothing; its formula in time has
    features of its own."""
    simple = ("-40*x", "-0.2*vx", "-0.1*vx*omega + 3*x", "sin(3*t)*x", "exp(-t)*vx**2")
    for formula in simple:
        now = phase(sliding(Load(fx=formula)), candidates(sliding(Load(fx=formula)))[0])
        assert not now.checks_load, formula
    for formula in ("x**3", "sin(x)", "tanh(vx)", "x*y*vx", "exp(-(sin(t)/0.01)**2)", "1/(2+omega**2)"):
        now = phase(sliding(Load(fx=formula)), candidates(sliding(Load(fx=formula)))[0])
        assert now.checks_load and now.checks_steps, formula


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


def test_a_load_without_a_value_ends_with_a_status():
    for method in EVERY:
        motion = reference.simulate(sliding(Load(fx="sqrt(2-x)")), method=method)
        assert motion.status == "breakdown" and "t = " in motion.reason
        # v²/2 = 2 + (2/3)(2^(3/2) - (2 - x)^(3/2)) until x = 2.
        assert float(motion.x[-1]) == pytest.approx(2.0, abs=1e-6)


@pytest.mark.slow
def test_a_function_may_overflow_where_the_load_vanishes():
    """exp(300 (2 - x)) is no double at x = -0.4, to which the wall has thrown the disc back. The Taylor method goes on
    without force; Python's exp raises an error, which ends DOP853's motion with a status."""
    case = sliding(Load(fx="-100/(1+exp(-(x-2)*300))"))
    for method in reference.METHODS:
        with cpu_limit(20.0):
            motion = reference.simulate(case, method=method)
        assert motion.status == {"taylor": "completed", "dop853": "breakdown"}[method]
        assert float(motion.x[-1]) < -0.36 and float(motion(motion.t[-1]).vx) == pytest.approx(-2.0, abs=1e-9)


@pytest.mark.slow
def test_a_sweep_feels_what_simulate_feels():
    """Scenarios whose load has to be checked are not moved in waves."""

    def make(width=0.01, speed=2.0):
        return sliding(Load(fx=f"20*exp(-((x-2)/{width})**2)"), speed=speed)

    rows = reference.sweep(make, width="0.001:0.1:4", speed=(1.0, 2.0))
    for _, row in rows.iterrows():
        work = 20.0 * row["width"] * sqrt(pi)
        assert row["energy_end"] - row["energy_start"] == pytest.approx(work, abs=1e-9)


@pytest.mark.slow
def test_a_certificate_of_a_narrow_hill_holds_the_exact_speed():
    case = sliding(Load(fx="20*exp(-((x-2)/0.01)**2)"), CoulombFriction(0.05), speed=4.0, duration=1.0)
    certificate = reference.certify(case)
    # It slides throughout: v²/2 falls by μ g x and grows by A w √π.
    slip, x, omega = (certificate.samples[q][-1] for q in ("slip", "x", "omega"))
    exact = sqrt(16.0 - 0.1 * G * x.value + 0.4 * sqrt(pi))
    assert slip.value + omega.value * -RADIUS == pytest.approx(exact, abs=1e-11 + slip.bar)
    assert len(certificate.witnesses) >= 2 and slip.bar < 1e-9
