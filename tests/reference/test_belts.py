"""A belt: exact values, agreement of three assemblies of the equations, the work that it does, and wrong input."""

import random
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

import reference
from cases import (
    BadValue,
    Belt,
    Case,
    CaseError,
    CoulombFriction,
    Curve,
    DoesNotFit,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Unilateral,
    contact,
    disc,
)
from cases.curves import cos
from cases.library import circle, ellipse, line
from tests.scenes.agreement import check_same_sequence
from tests.scenes.motions import energy, in_other_units, mirrored, work_done

G, R, M = 9.81, 0.1, 1.0
METHODS = pytest.mark.parametrize("method", [*reference.METHODS, "augmented"])
# Tolerance 1e-13 and rounding in a few hundred operations.
EXACT = 1e-12


def level(belt, mu=0.2, duration=2.0, slope=0.0, **start):
    effects = (Gravity(G), CoulombFriction(mu), Unilateral(), *belt)
    return Case(line(slope), disc(R, M), effects, Start(0.0, **start), duration)


@METHODS
@pytest.mark.parametrize("speed", [0.7, -1.3])
def test_disc_set_down_on_a_conveyor_rolls_after_its_speed_over_3_mu_g(method, speed):
    """Friction μ m g drives the centre with μ g and the spin with μ m g r/J = 2 μ g/r: the slip changes by 3 μ g."""
    motion = reference.simulate(level([Belt(speed)], slip=-speed), rtol=1e-13, method=method)
    (change,) = motion.transitions
    assert change.time == pytest.approx(abs(speed) / (3 * 0.2 * G), abs=EXACT)
    assert change.after is Mode.ROLL
    end = motion(2.0)
    assert end.vx == pytest.approx(speed / 3, abs=EXACT)
    assert end.omega == pytest.approx(2 * speed / (3 * R), abs=10 * EXACT)
    assert end.friction_force == pytest.approx(0.0, abs=EXACT)


@METHODS
def test_disc_on_a_belt_that_accelerates_more_and_more_rolls_until_three_mu_g(method):
    """Rolling on a belt of acceleration a: J ω̇ = T r, m v̇ = T and v̇ + r ω̇ = a give T = m a/3 ≤ μ m g."""
    mu, jerk = 0.2, 4.0
    motion = reference.simulate(level([Belt(f"{jerk / 2}*t**2")], mu), rtol=1e-13, method=method)
    (change,) = motion.transitions
    assert (change.before, change.after) == (Mode.ROLL, Mode.SLIP_BACKWARD)
    assert change.time == pytest.approx(3 * mu * G / jerk, abs=EXACT)
    at = motion(1.0)
    assert at.friction_force == pytest.approx(M * jerk / 3, abs=10 * EXACT)
    assert at.vx == pytest.approx(jerk / 6, abs=EXACT)


@METHODS
def test_belt_of_constant_speed_changes_nothing_for_a_rolling_pendulum(method):
    """In v = b the belt's acceleration does not occur: (3/2) (R − r) φ̈ = −g sin φ, with the period of its swing."""
    swing, length = 0.5, 1.5 * 0.9
    effects = (Gravity(G), CoulombFriction(0.8), Unilateral(), Belt(1.7))
    case = Case(circle(1.0), disc(R, M), effects, Start(-pi / 2 + swing, omega=17.0), 2.0)
    motion = reference.simulate(case, rtol=1e-13, method=method)
    assert not motion.transitions
    # The period of a pendulum by the arithmetic-geometric mean.
    a, b = 1.0, np.cos(swing / 2)
    while abs(a - b) > 1e-16:
        a, b = (a + b) / 2, sqrt(a * b)
    quarter = pi / (2 * a) * sqrt(length / G)
    assert motion(quarter).xi1 == pytest.approx(-pi / 2, abs=10 * EXACT)


@pytest.mark.parametrize("speed", [0.8, -2.0])
def test_uniform_belt_on_a_line_is_the_scene_without_it_in_a_moving_frame(speed):
    """Galilei: subtract the belt's speed from all velocities."""
    effects = (Gravity(G), CoulombFriction(0.4), Unilateral(), Flight(), Impact(0.4))
    plate = Plate(ellipse(0.1, 0.06), M, 0.004)
    still = Case(line(0.2), plate, effects, Start(0.0, 1.0, slip=1.0, omega=9.0), 1.0)
    moving = replace(still, effects=(*effects, Belt(speed)))
    here, there = (reference.simulate(case, rtol=1e-13) for case in (still, moving))
    assert len(here.transitions) > 3
    assert [(t.before, t.after) for t in here.transitions] == [(t.before, t.after) for t in there.transitions]
    times = np.linspace(0.0, 1.0, 50)
    a, b = here(times), there(times)
    assert [t.time for t in there.transitions] == pytest.approx([t.time for t in here.transitions], abs=1e-11)
    assert b.x - a.x == pytest.approx(
        speed * np.cos(0.2) * times * np.sign(b.x[-1] - a.x[-1]) * np.sign(speed), abs=1e-9
    )
    assert b.theta == pytest.approx(a.theta, abs=1e-8)


def random_scene(chance: random.Random) -> Case:
    """A disc or an ellipse on a belt along a circle, a slope or a wave, in contact or landing."""

    def between(low, high):
        return chance.uniform(low, high)

    r, kind = between(0.05, 0.2), chance.choice(["circle", "bottom", "line", "slope", "wave"])
    track = {"line": line(), "slope": line(between(-0.3, 0.3))}.get(kind, circle(1.0))
    if kind == "wave":
        track = Curve(lambda s: (s, -0.3 * cos(2 * s)), domain=(-3, 3))
    round_plate = chance.random() < 0.6
    plate = (
        disc(r, 1.0) if round_plate else Plate(ellipse(r, r * between(0.6, 0.95)), 1.0, 0.5 * r * r * between(0.4, 1))
    )
    speed = chance.choice(
        [
            f"{between(-2, 2):.3f}",
            f"{between(-1, 1):.3f} + {between(0.1, 1):.3f}*sin({between(1, 8):.2f}*t)",
            f"{between(-1, 1):.3f}*tanh({between(1, 30):.2f}*(t - 0.3))",
        ]
    )
    friction = CoulombFriction(between(0.05, 0.8)) if chance.random() < 0.85 else PerfectlyRough()
    effects = [Gravity(G), friction, Belt(speed)]
    if chance.random() < 0.7:
        effects.append(Unilateral())
    if chance.random() < 0.3:
        effects.append(Load(fx=f"{between(-1, 1):.2f}*vx + {between(-1, 1):.2f}*sin(3*t)"))
    bounces = Unilateral() in effects and chance.random() < 0.6
    if bounces:
        effects += [Flight(), Impact(chance.choice([0.0, 0.3, 0.6]), chance.choice(["poisson", "moreau"]))]
    width = {"circle": 1.2, "bottom": 0.5}.get(kind)
    xi1 = -pi / 2 + between(-width, width) if width else between(-1, 1)
    slip = 0.0 if isinstance(friction, PerfectlyRough) else chance.choice([0.0, between(-1, 1)])
    lift = dict(gap=between(0, 0.1), gap_rate=between(-1, 1)) if bounces and chance.random() < 0.4 else {}
    xi2 = None if round_plate else between(0.0, 2 * pi)
    return Case(track, plate, tuple(effects), Start(xi1, xi2, slip=slip, omega=between(-3, 3), **lift), 1.5)


def random_scenes(seed: int, count: int):
    """Scenes of `random_scene` that are admissible."""
    chance = random.Random(seed)
    while count:
        try:
            yield random_scene(chance)
        except CaseError:  # the plate does not fit there
            continue
        count -= 1


def test_formulations_agree_on_random_belts():
    for case in random_scenes(seed=11, count=3):
        check_same_sequence(case, literal=True)


@pytest.mark.slow
def test_formulations_agree_on_two_thousand_random_belts():
    for number, case in enumerate(random_scenes(seed=1, count=2000)):
        check_same_sequence(case, literal=number % 20 == 0)


def check_work(case: Case) -> None:
    """The energy that a motion without impact gains is the work of friction, belt and load."""
    motion = reference.simulate(case, rtol=1e-13)
    times = np.linspace(motion.t[0], motion.t[-1], 200)
    gained = energy(case, motion(float(motion.t[-1]))) - energy(case, motion(0.0))
    scale = np.ptp(energy(case, motion(times))) + np.max(np.hypot(motion.vx, motion.vy)) ** 2 * case.plate.mass
    assert abs(gained - work_done(case, motion)) <= 1e-10 * scale, case


def test_work_of_friction_and_belt_is_the_energy_gained():
    for case in random_scenes(seed=5, count=12):
        if case.effect(Flight) is None:
            check_work(case)


@pytest.mark.parametrize("change", [mirrored, lambda case: in_other_units(case, 2.5, 1.7, 3.1, 0.7)])
def test_mirror_image_rotation_and_units_change_no_transition_on_belts(change):
    for case in random_scenes(seed=7, count=5):
        here, there = reference.simulate(case, rtol=1e-13), reference.simulate(change(case), rtol=1e-13)
        unit = change(case).duration / case.duration
        assert there.status == here.status
        assert [t.time / unit for t in there.transitions] == pytest.approx(
            [t.time for t in here.transitions], abs=1e-10
        )


def test_pulse_of_a_belt_is_not_stepped_over():
    """A belt that jerks for a microsecond at t = 1 s, otherwise at rest, sets a rolling disc in motion."""
    case = level([Belt("0.5*(1 + tanh((t - 1)/1e-6))")], mu=0.3)
    motion = reference.simulate(case, rtol=1e-12)
    assert [t.after for t in motion.transitions] == [Mode.SLIP_BACKWARD, Mode.ROLL]
    assert motion.transitions[0].time == pytest.approx(1.0, abs=1e-5)
    assert motion.transitions[1].time == pytest.approx(1.0 + 1.0 / (3 * 0.3 * G), abs=1e-5)
    check_same_sequence(case)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (lambda: Belt("v"), "use t"),
        (lambda: Belt(0.0), "leave Belt out"),
        (lambda: Belt(None), "speed of Belt"),
        (lambda: level([Belt("1/t")]), "at t = 0"),
    ],
)
def test_wrong_belts_are_rejected_with_what_to_give(wrong, sentence):
    with pytest.raises(BadValue, match=sentence):
        wrong()


def test_belts_need_friction_and_exclude_rolling_resistance():
    with pytest.raises(DoesNotFit, match="CoulombFriction or PerfectlyRough"):
        Case(line(), disc(R, M), (Gravity(G), Belt(1.0)), Start(0.0), 1.0)
    with pytest.raises(DoesNotFit, match="no established law"):
        level([Belt(1.0), RollingResistance(0.01)])


def test_slip_of_a_belt_needs_times():
    case = level([Belt("t")])
    with pytest.raises(BadValue, match="give the times"):
        contact.slip_velocity(case, 0.0, R, 1.0, 0.0, 0.0, 0.0)
    assert contact.slip_velocity(case, 0.0, R, 1.0, 0.0, 0.0, 0.0, 0.25) == pytest.approx(0.75)


def test_sweep_simulates_belts_one_by_one():
    """One by one, with the same times."""
    rows = reference.sweep("disc_on_conveyor", speed=[0.5, 1.0, 2.0])
    assert list(rows["first_time"]) == pytest.approx([v / (3 * 0.1 * G) for v in (0.5, 1.0, 2.0)], abs=EXACT)
