"""Scales do not vanish with what is compared with them, and answers scale with the units of length, time and mass."""

import pytest

import reference
from tests.scenes.units import scene_in_units


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
