"""The permanent set of planted faults: each is a broken law, and the right motion of its scene breaks none.

A change of the check of laws runs all of it: `pytest tests/taylor/test_planted_faults.py -m "slow or not slow"`.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

import reference
from cases import CoulombFriction
from reference.minimal.integrators import taylor
from tests.sampling import quick_every
from tests.scenes.planted_faults import CIRCLE, ESCAPES, FAMILIES, FAULTS, MUTATIONS, distance
from tests.scenes.planted_motions import alter, scene, simulate

# The Taylor method's motions are exact to roundings, which is what the faults of a billionth need.
needs_heyoka = pytest.mark.skipif(
    not taylor.AVAILABLE, reason="heyoka is not installed: DOP853 leaves more than roundings"
)


@needs_heyoka
@quick_every(4)
@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_a_broken_law(name):
    fault = FAULTS[name]
    case = fault.scene()
    assert reference.check(case, simulate(case), 0.0) == ()
    assert bool(reference.check(case, fault.plant(case), 0.0)) == (name not in ESCAPES)


def test_few_faults_escape():
    assert set(ESCAPES) <= set(FAULTS) and len(ESCAPES) <= 0.02 * len(FAULTS)


def test_a_broken_law_of_friction_has_its_size_in_units_of_it():
    """A friction that is 3 % larger breaks Coulomb's law by 0.03 μ N."""
    case = CIRCLE()
    first = reference.check(case, scene(alter(CoulombFriction, mu=0.206))(case), 0.0)
    law = next(one for one in first if one.law == "Coulomb's law in slip")
    assert law.part_of_friction == pytest.approx(0.03, abs=1e-9)


# Random scenes whose data are changed by a billionth: a family, and seeds. What is not seen: the inertia of a triangle
# whose corner slides over a hill without friction, 1e-8 rad/s of its spin.
UNSEEN = [("all features, others", "inertia", 590102)]
MUTANTS = [(family, name, seed) for family in FAMILIES for name in MUTATIONS for seed in (590100, 590101, 590102)]


@needs_heyoka
@quick_every(9)
@pytest.mark.parametrize("family, name, seed", MUTANTS)
def test_a_billionth_of_the_data_is_seen(family, name, seed):
    """Of changes that move the plate by more than 1e-10; restitution at several contacts is seen to 1e-8 only."""
    case = FAMILIES[family](seed)
    right, wrong = simulate(case), simulate(MUTATIONS[name](case))
    assert reference.check(case, right, 0.0) == ()
    is_to_1e_8 = name == "restitution" and len(right.contact_names) > 1
    if distance(right, wrong) > 1e-10 and not is_to_1e_8:
        is_seen = (family, name, seed) not in UNSEEN
        assert bool(reference.check(case, replace(wrong, case=case), 0.0)) == is_seen
