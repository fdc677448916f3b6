"""Stick and slip of a spring and a slider: exact instants, by a disc whose spring pulls at its contact.

A spring that pulls at the disc's own point of contact, displaced by u = x + r θ, moves it as a slider of the mass
1/(1/m + r²/J) on a fixed floor; without slip, friction balances the spring. A disc with a large inertia hardly turns. A
belt is a spring whose other end moves with V, in the frame of the belt.
"""

from dataclasses import replace
from math import atan, atan2, cos, exp, inf, log, pi, sin, sqrt, tan

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cases
import reference
from cases import Belt, Case, CoulombFriction, Gravity, Load, Mode, RollingResistance, Start, Unilateral, disc
from cases.library import line
from tests.authorities.published_numbers.oscillating import OSCILLATOR, OSCILLATOR_STEP, oscillator
from tests.sampling import quick_every
from tests.scenes import second as second_states

RADIUS = 0.1
TURNS = 1e-6  # m r²/J: how much of the contact's motion is rotation


def slider(friction: CoulombFriction, mass, stiffness, g, pulled=0.0, place=0.0, speed=0.0, duration=10.0) -> Case:
    """A slider of that mass at the end of a spring whose other end moves with `pulled` (m/s)."""
    force = f"{stiffness!r}*({pulled!r}*t - x - {RADIUS!r}*theta)"
    effects = (Gravity(g), Load(fx=force, moment=f"{RADIUS!r}*({force})"), friction, Unilateral())
    heavy = mass * (1.0 + TURNS)
    plate = disc(RADIUS, heavy, heavy * RADIUS**2 / TURNS)
    return Case(line(), plate, effects, Start(place, slip=speed, omega=speed * TURNS / RADIUS), duration)


def all_motions(case: Case, until: float = inf):
    """The motion by both integrators, and by the second formulation up to a time."""
    ours = [reference.simulate(case, 1e-14, method) for method in reference.METHODS]
    return [*ours, second_states.motion(case, rtol=1e-13, until=until)]


@pytest.mark.slow
def test_the_friction_oscillator_of_siconos_stops_after_its_arc_and_seven_half_turns():
    """x'' + x = −sign(x') from x = 12, x' = 6, as in Siconos' FrictionOscillator (m = k = 1, friction 1; parameters
    looked up in its source): arcs of circles around ∓1 in the plane of x and x'. It first stops at
    x₁ = √(13² + 6²) − 1 after atan(6/13); each half turn loses 2; it holds where |x| < 1."""
    case = slider(CoulombFriction(1.0 / (1.0 + TURNS)), 1.0, 1.0, 1.0, place=12.0, speed=6.0, duration=30.0)
    stops = [atan2(6.0, 13.0) + k * pi for k in range(8)]
    motion, *others = all_motions(case, until=4.0)
    assert len(motion.transitions) == 8 and motion.transitions[-1].after is Mode.ROLL
    for each in (motion, *others):
        times = [t.time for t in each.transitions]
        assert len(times) >= 2 and times == pytest.approx(stops[: len(times)], rel=1e-12, abs=1e-12)
    state = motion(np.array([motion.transitions[0].time, 30.0]))
    u = state.x + RADIUS * state.theta
    assert u == pytest.approx([sqrt(205.0) - 1.0, 15.0 - sqrt(205.0)], abs=1e-13 * sqrt(205.0))  # of the amplitude


def test_rows_of_the_friction_oscillator_of_siconos():
    """x'' + x = −sign(x') as above, by siconos-tutorials, examples/mechanics/FrictionOscillator/FrictionOscillator.ref.

    Its midpoint rule turns the plane of x and x' by exactly 2 atan(h/2) in a step, and friction is that of the step's
    end: where the velocity reverses, it is off by at most 2 h. Exact motions from two states do not separate, so after
    n reversals the rows are within 2 h n. (All 10,000 rows were compared so.)
    """
    h, motion = OSCILLATOR_STEP, reference.simulate(oscillator(), 1e-14)
    reversals = np.array([t.time for t in motion.transitions])
    for number, place, velocity in OSCILLATOR:
        time = 2 * number * atan(h / 2)
        state = motion(time)
        distance = np.hypot(state.x - place, state.vx - velocity)
        # A step is h long, so a reversal belongs to the rows from one step before it; DOP853's error between its steps
        # is 1e-12 of the amplitude.
        assert distance <= 2 * h * np.count_nonzero(reversals < time + h) + 1e-12 * sqrt(205.0)
        assert distance < 0.025


@quick_every(2)
@pytest.mark.parametrize("pulled", [0.2, 1.0])
def test_stick_and_slip_alternate_with_the_exact_periods(pulled):
    """With d = (μ_s − μ) N/k and w = √(k/m): sticks for 2 d/V, slips for (2/w)(π − atan(d w/V)), derived here from
    δ'' = −w² δ, δ(0) = d, δ'(0) = V for the spring's stretch δ beyond that of the sliding friction."""
    mass, stiffness, g, mu, mu_static = 1.0, 100.0, 10.0, 0.2, 0.5
    case = slider(CoulombFriction(mu, mu_static), mass, stiffness, g, pulled, duration=2.0)
    weight, w = mass * (1.0 + TURNS) * g, sqrt(stiffness / mass)
    d = (mu_static - mu) * weight / stiffness
    sticks, slips = 2.0 * d / pulled, 2.0 / w * (pi - atan(d * w / pulled))
    exact = [mu_static * weight / (stiffness * pulled)]
    while exact[-1] < case.duration:
        exact += [exact[-1] + slips, exact[-1] + slips + sticks]
    exact = [t for t in exact if t < case.duration]
    assert len(exact) >= 2
    for motion in all_motions(case):
        assert [t.time for t in motion.transitions] == pytest.approx(exact, abs=5e-12)


def test_viscous_friction_damps_the_slip_as_the_closed_form_says():
    """μ = μ₀ + c v: δ'' + 2 a δ' + w² δ = const while it slips, a damped oscillation; its end by mpmath's root."""
    mass, stiffness, g, pulled, mu, c, mu_static = 1.0, 100.0, 10.0, 0.2, 0.2, 0.05, 0.5
    case = slider(CoulombFriction(f"{mu} + {c}*v", mu_static), mass, stiffness, g, pulled, duration=1.0)
    with mpmath.workdps(30):
        m, k, V, weight = map(mpmath.mpf, (mass, stiffness, pulled, mass * (1.0 + TURNS) * g))
        a, w2 = c * weight / (2 * m), k / m
        w = mpmath.sqrt(w2 - a * a)
        # With u' = V − δ': m δ'' = −k δ + weight (μ₀ + c V) − c weight δ', about the centre z.
        z = weight * (mpmath.mpf("0.2") + mpmath.mpf("0.05") * V) / k
        begin = mpmath.mpf("0.5") * weight / k - z  # δ' = V there

        def slip(t):
            b = (V + a * begin) / w
            rate = mpmath.exp(-a * t) * (
                (b * w - a * begin) * mpmath.cos(w * t) - (begin * w + a * b) * mpmath.sin(w * t)
            )
            return V - rate

        first = mpmath.mpf("0.5") * weight / (k * V)
        exact = [float(first), float(first + mpmath.findroot(slip, (0.35, 0.5), solver="anderson"))]
    for motion in all_motions(case):
        assert [t.time for t in motion.transitions[:2]] == pytest.approx(exact, abs=2e-12)
        assert [t.after for t in motion.transitions[:2]] == [Mode.SLIP_FORWARD, Mode.ROLL]


def test_the_limit_cycle_of_leines_block_on_a_belt():
    """q'' + q = 1/(1 + 3 v) for the slip speed v = 0.2 − q' > 0: rleine/Keynote_Nonsmooth_Dynamics_ENOC2024 (looked up:
    parameters in stickslip_system/class_block_on_belt.m, start of the quasi-exact motion on the limit cycle, q = 1.135,
    q' = 0, in script.m: a semi-implicit scheme with 5,000 steps in 12.3). Every slip begins at q = 1. Its end, and the
    largest q, by SciPy's DOP853; the block then sticks until q = 1."""

    def slips(t, y):
        return [y[1], -y[0] + 1.0 / (1.0 + 3.0 * (0.2 - y[1]))]

    def reaches_belt(t, y):
        return y[1] - 0.2

    def turns(t, y):
        return y[1]

    reaches_belt.terminal, reaches_belt.direction, turns.direction = True, 1, -1
    # It begins below the belt's speed by what grows to about 1e-12·exp(3 t) within the first units of time.
    options = dict(method="DOP853", rtol=1e-13, atol=1e-14, events=(reaches_belt, turns))
    slip = solve_ivp(slips, (0.0, 10.0), [1.0, 0.2 - 1e-13], **options)
    (ends,), (farthest,) = slip.t_events[0], slip.y_events[1][:, 0]
    sticks = (1.0 - slip.y_events[0][0, 0]) / 0.2
    effects = (Gravity(1.0), CoulombFriction("1/(1 + 3*v)"), Belt(0.2), Load(fx="-x"), Unilateral())
    case = Case(line(), disc(RADIUS, 1.0, inf), effects, Start(0.5), 15.0)
    for motion in all_motions(case):
        assert [t.after for t in motion.transitions] == [Mode.SLIP_BACKWARD, Mode.REST, Mode.SLIP_BACKWARD]
        times = [t.time for t in motion.transitions]
        assert times == pytest.approx([2.5, 2.5 + ends, 2.5 + ends + sticks], abs=1e-9)
    ours = reference.simulate(case, 1e-13)
    assert np.max(ours(np.linspace(2.5, 6.0, 3501)).x) == pytest.approx(farthest, abs=1e-6)  # samples of 1 ms
    assert farthest == pytest.approx(1.135, abs=12.3 / 5000)  # one of its steps


def test_the_cases_of_the_catalogue_have_their_exact_instants():
    """t = log(1 + c v₀ cos/(sin + μ cos))/(c g cos) up the ramp; the belt's spring holds up to (low + more) m g/k."""
    slope, mu, c, g = 0.5, 0.2, 0.2, 9.81
    ramp = reference.simulate(cases.load("block_on_viscous_ramp"), 1e-13)
    exact = log(1.0 + c * cos(slope) / (sin(slope) + mu * cos(slope))) / (c * g * cos(slope))
    assert [t.after for t in ramp.transitions] == [Mode.SLIP_BACKWARD]
    assert ramp.transitions[0].time == pytest.approx(exact, abs=1e-13)
    rate, final = c * g * cos(slope), (tan(slope) - mu) / c
    assert ramp(3.0).slip == pytest.approx(-final * (1.0 - exp(-rate * (3.0 - exact))), abs=1e-12)
    slider_on_belt = reference.simulate(cases.load("slider_on_belt_falling_law"), 1e-13)
    assert slider_on_belt.transitions[0].time == pytest.approx(0.4 * 9.81 / 40.0 / 0.2, abs=1e-13)


def at_its_bound(kind: str, slope: float, slip: float) -> Case:
    """A plate on an incline that needs exactly the friction, or the couple, that the bound allows, up to rounding."""
    ratio, radius = tan(slope), RADIUS
    plate, effects = disc(radius, 1.0), [Gravity(9.81), CoulombFriction(ratio / 3), Unilateral()]
    if kind == "block":
        plate, effects[1] = disc(radius, 1.0, inf), CoulombFriction(ratio)
    if kind == "rolling resistance":
        effects[1:2] = [CoulombFriction(5 * ratio), RollingResistance(radius * ratio)]
    return Case(line(-slope), plate, tuple(effects), Start(0.0, slip=slip), 1.5)


@quick_every(5)
@pytest.mark.parametrize("slip", [0.0, 1.0])
@pytest.mark.parametrize("kind", ["block", "disc", "rolling resistance"])
def test_a_force_at_its_bound_holds(kind, slip):
    """Coulomb's law allows it: |T| = μ N, without slip. Which of the two is larger by a rounding means nothing: the
    default found a paradox at slopes of 0.1 and 0.3, the second formulation a slip after some time."""
    for slope in (0.1, 0.3, atan(0.25), 0.7, 1.3):
        case = at_its_bound(kind, slope, slip)
        motions = all_motions(case)
        changes = [[(t.before, t.after) for t in motion.transitions] for motion in motions]
        assert all(motion.status == "completed" for motion in motions)
        expected = 0 if not slip else 2 if kind == "rolling resistance" else 1
        assert changes[0] == changes[1] == changes[-1] and len(changes[0]) == expected, (slope, changes)


def test_a_force_beyond_its_bound_by_a_trillionth_does_not_hold():
    slope = 0.3
    case = replace(
        at_its_bound("block", slope, 0.0),
        effects=(Gravity(9.81), CoulombFriction(tan(slope) * (1 - 1e-12)), Unilateral()),
    )
    for method in reference.METHODS:
        assert reference.simulate(case, method=method).first_mode is Mode.SLIP_BACKWARD
