"""The laws catch adapters with one mistake each, in scenes drawn from a seed, and name the parameter or effect."""

from __future__ import annotations

import re

import pytest

import reference
from adapters.laws import LAWS, MORE_SCENES, SCENES, Route, scene
from cases import CoulombFriction, Gravity
from cases.effects import Effect
from tests.sampling import quick_every

from .mutant_list import MUTANTS
from .mutants import Mutant, effect, friction, of_case

# One mutant of each part takes seconds; all of them take two minutes.
SAMPLE = MUTANTS[::9]


def _is_caught(mutant: Mutant, seed: int) -> None:
    with pytest.raises(AssertionError) as violation:
        LAWS[mutant.law](Route(mutant.adapter(), "native", seed))
    assert mutant.words in str(violation.value)


@pytest.mark.parametrize("mutant", SAMPLE, ids=[mutant.name for mutant in SAMPLE])
def test_a_sample_of_mistakes_is_caught_by_name(mutant):
    _is_caught(mutant, seed=0)


@pytest.mark.slow
@pytest.mark.parametrize("mutant", MUTANTS, ids=[mutant.name for mutant in MUTANTS])
def test_every_mistake_is_caught_by_name(mutant):
    _is_caught(mutant, seed=0)


def test_the_collection_has_the_size_it_should():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS) >= 125
    assert {mutant.law for mutant in MUTANTS} <= LAWS.keys()
    # Every law has a wrong adapter that it catches.
    assert {mutant.law.partition("[")[0] for mutant in MUTANTS} == {law.partition("[")[0] for law in LAWS}


# Laws whose scene takes the reference more than a second.
_LONG = "pile_of_free_plates", "wedge_of_free_plates"


def _families() -> list:
    """The first entry of each law."""
    first: dict[str, str] = {}
    for law in LAWS:
        first.setdefault(law.partition("[")[0], law)
    return [pytest.param(law, marks=pytest.mark.slow) if law in _LONG else law for law in first.values()]


@quick_every(2)
@pytest.mark.parametrize("law", _families())
def test_the_adapter_without_a_mistake_keeps_the_law(law):
    LAWS[law](Route(of_case(), "native"))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_the_adapter_without_a_mistake_keeps_every_law_whatever_the_seed(seed):
    right = of_case()
    for law in LAWS:
        LAWS[law](Route(right, "native", seed))


def test_the_suspected_parameter_comes_with_the_value_that_fits():
    mutant = of_case(friction(lambda mu: 0.5 * mu))
    case = scene("disc in a circle")
    mu = case.effect(CoulombFriction).mu
    with pytest.raises(AssertionError) as violation:
        LAWS["equations_of_motion[disc in a circle]"](Route(mutant, "native"))
    found = re.search(r"suspect mu of CoulombFriction: (\S+) would fit, the case has (\S+)", str(violation.value))
    assert found and float(found[2]) == pytest.approx(mu, rel=1e-3)
    # The fit is as good as the samples: 2,000 of them.
    assert float(found[1]) == pytest.approx(0.5 * mu, rel=0.01)


def test_two_mistakes_at_once_are_not_blamed_on_one_parameter():
    def change(case):
        return effect(Gravity, lambda e: Gravity(1.3 * e.g, e.direction + 0.3))(friction(lambda mu: 0.3 * mu)(case))

    with pytest.raises(AssertionError, match="no single parameter explains it"):
        LAWS["equations_of_motion[loaded disc]"](Route(of_case(change), "native"))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, range(2, 40)])
def test_drawn_scenes_last_as_long_as_they_should(seed):
    for each in [seed] if isinstance(seed, int) else seed:
        for name in SCENES | MORE_SCENES:
            motion = reference.simulate(scene(name, each))
            assert motion.status == "completed", (each, name, motion.reason)


def test_a_seed_gives_the_same_scenes_and_another_seed_others():
    for name in SCENES | MORE_SCENES:
        assert scene(name, 5) == scene(name, 5)
        assert scene(name, 5).effects != scene(name, 6).effects


@pytest.mark.slow
def test_no_scene_has_a_value_that_a_solver_may_have_as_a_constant():
    for seed in range(20):
        for name in SCENES:
            case = scene(name, seed)
            gravity, coulomb = case.effect(Gravity), case.effect(CoulombFriction)
            assert abs(gravity.g - 9.81) > 1.0 and abs(coulomb.mu - 0.1) > 0.01


def test_every_effect_is_drawn():
    drawn: set[type[Effect]] = {type(e) for name in SCENES | MORE_SCENES for e in scene(name).effects}
    assert {kind.__name__ for kind in drawn} == {
        "Gravity",
        "CoulombFriction",
        "Unilateral",
        "Load",
        "PerfectlyRough",
        "RollingResistance",
        "Flight",
    }
