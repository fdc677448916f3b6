"""Scales do not vanish with what is compared with them, and answers scale with the units of length, time and mass."""

from math import pi

import numpy as np
import pytest

import reference
from cases import Case, Flight, Gravity, Load, Start, Unilateral, disc
from cases.library import line
from reference.minimal.modes import candidates, phase_at, start_state, state_in
from reference.scales import approach_scale, inverse_mass_scale, looks_between, power_of_two
from tests.scenes.units import scene_in_units

G = 9.81
# Loads that cancel the weight, or themselves, at a time (s), and the size of what cancels (m/s²).
LOADS = {
    "linear": ((Gravity(G), Load(fy="79.52*t")), G / 79.52, 2 * G),
    "one formula": ((Load(fy="-9.81 + 79.52*t"),), G / 79.52, 2 * G),
    "a zero of a sine": ((Load(fy="-9.81*cos(30*t)"),), pi / 60, G * pi / 2),
    "the time itself": ((Gravity(G), Load(fy="t")), G, G),
}


@pytest.mark.parametrize("name", LOADS)
def test_approach_scale_is_that_of_the_terms(name):
    effects, time, size = LOADS[name]
    case = Case(line(), disc(0.1, 1.0), (*effects, Unilateral(), Flight()), Start(0.0), 20.0)
    phase = phase_at(case, candidates(case)[-1], start_state(case))
    state = state_in(phase, start_state(case))
    value = phase.system.record(*phase.system.outputs_of_numbers(time, state, phase.parameters))
    assert abs(value.free_approach) < 1e-14 * size
    assert 0.5 * size < approach_scale(phase, time, state) < 10.0 * size


def test_units_of_matrices_are_powers_of_two():
    assert [power_of_two(value) for value in (0.0, 1e-9, 0.75, 3.0)] == [0.0, 2.0**-29, 1.0, 4.0]
    assert inverse_mass_scale(np.diag([3e9, 1.0])) == 2.0**32 and inverse_mass_scale(np.zeros((0, 0))) == 1.0


def test_a_belt_that_stands_at_both_ends_of_a_step_has_a_speed_between():
    looks = looks_between(np.array([0.0, pi, 2 * pi]))
    assert np.abs(np.sin(looks)).max() > 0.9 and len(looks) == 16


def check(seed: int) -> None:
    """The motion in other units has the same modes and status, and times that are as many times as long."""
    case, other, _, time, _ = scene_in_units(seed)
    motions = [reference.simulate(one, rtol=1e-12, method="dop853") for one in (case, other)]
    assert motions[0].status == motions[1].status, (seed, motions)
    modes = [[(change.contact, change.before, change.after) for change in motion.transitions] for motion in motions]
    assert modes[0] == modes[1], seed
    times = [[change.time for change in motion.transitions] for motion in motions]
    assert [late / time for late in times[1]] == pytest.approx(times[0], abs=1e-9 * case.duration), seed


# Forces that touch their bound exactly: whether roundings pass it depended on the units.
TOUCHES_BOUND = [20, *(2474928864 + k for k in (4, 30, 102, 124, 146, 184, 190))]
# Plates with several contacts that leave as their weight and load cancel: they ended as `paradox` in some units.
CANCELS = [2474928864 + k for k in (15, 21, 47, 107, 137, 199)]


@pytest.mark.parametrize("seed", [*range(10), *TOUCHES_BOUND, *CANCELS])
def test_random_scenes_in_other_units(seed):
    check(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 200))
def test_more_random_scenes_in_other_units(seed):
    check(seed)
