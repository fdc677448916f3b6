"""Random scenes with belts, driven tracks, plates that do not turn, friction by slip speed, effects of a user's own."""

from itertools import islice

import pytest

from cases import Flight, RollingResistance
from tests.scenes.agreement import check_same_sequence
from tests.scenes.moving import FAMILIES, check_invariance, check_work, random_scenes

EACH = pytest.mark.parametrize("family", FAMILIES)
# Families of several effects at once take longest; in the quick tests only the two formulations are compared on them.
SINGLE_EFFECTS = pytest.mark.parametrize(
    "family",
    [pytest.param(name, marks=pytest.mark.slow) if name.endswith("with the others") else name for name in FAMILIES],
)


@pytest.mark.sampled(3)
@EACH
def test_formulations_agree_on_random_scenes(family):
    for case in random_scenes(family, seed=11, number=1):
        check_same_sequence(case, literal=True)


@pytest.mark.slow
@EACH
def test_formulations_agree_on_two_thousand_random_scenes(family):
    for number, case in enumerate(random_scenes(family, seed=1, number=2000)):
        check_same_sequence(case, literal=number % 20 == 0)


@pytest.mark.sampled(3)
@EACH
@pytest.mark.parametrize("number", [1, pytest.param(12, marks=pytest.mark.slow)])
def test_work_of_friction_belt_and_drive_is_the_energy_gained(family, number):
    scenes = (
        case
        for case in random_scenes(family, seed=5, number=25)
        if case.effect(Flight) is None and case.effect(RollingResistance) is None
    )
    chosen = [*islice(scenes, number)]
    for case in chosen:
        check_work(case)
    assert len(chosen) == number


@pytest.mark.sampled(2)
@SINGLE_EFFECTS
def test_mirror_image_rotation_and_units_change_no_transition(family):
    assert sum(check_invariance(case) for case in random_scenes(family, seed=7, number=1)) > 0
