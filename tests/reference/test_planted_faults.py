"""The permanent set of planted faults: each is a broken law, and the right motion of its scene breaks none.

A change of the check of laws runs all of it: `pytest tests/reference/test_planted_faults.py -m "slow or not slow"`.
"""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import pytest

import reference
from reference.minimal.integrators import taylor
from tests.scenes.planted_faults import CIRCLE, ESCAPES, FAMILIES, FAULTS, MUTATIONS, distance
from tests.scenes.planted_motions import at_wall, friction, nearly_lifted, simulate

# The Taylor method's motions are exact to roundings, which is what the faults of a billionth need.
pytestmark = pytest.mark.taylor
needs_heyoka = pytest.mark.skipif(
    not taylor.AVAILABLE, reason="heyoka is not installed: DOP853 leaves more than roundings"
)


@needs_heyoka
@pytest.mark.sampled(4)
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
    first = reference.check(case, friction(1.03)(case), 0.0)
    law = next(one for one in first if one.law == "Coulomb's law in slip")
    assert law.part_of_friction == pytest.approx(0.03, abs=1e-9)


@pytest.mark.parametrize("method", reference.METHODS)
def test_a_disc_that_rolls_into_a_wall_goes_on(method):
    """Changes of mode there once took no time: the motion ended as an accumulation at 0.44005 s."""
    motion = simulate(at_wall(), method=method)
    assert motion.status == "completed" and reference.check(at_wall(), motion, 1e-12) == ()
    impact = next(c for c in motion.transitions if c.contact == "plate/wall")
    # it slips until v = 2 − μ g t = (2/3)·2 and rolls the rest of 0.7 m
    first = 2.0 / (3.0 * 0.2 * 9.81)
    way = 2.0 * first - 0.5 * 0.2 * 9.81 * first**2
    assert impact.time == pytest.approx(first + (0.7 - way) / (4.0 / 3.0), abs=1e-12)


@pytest.mark.parametrize("method", reference.METHODS)
def test_a_plate_without_friction_lifts_off_where_its_load_is_its_weight(method):
    """g (1 + 1e-9) − 100 (t − 1/2)² = g at t = 1/2 − √(1e-11 g); it once ended as Painlevé's paradox."""
    case = nearly_lifted(1e-9)
    motion = simulate(case, method=method)
    assert motion.status == "lift_off" and reference.check(case, motion, 1e-12) == ()
    assert motion.t[-1] == pytest.approx(0.5 - sqrt(1e-11 * 9.81), abs=1e-11)


# Random scenes whose data are changed by a billionth: a family, and seeds.
MUTANTS = [(family, name, seed) for family in FAMILIES for name in MUTATIONS for seed in (590100, 590101)]


@needs_heyoka
@pytest.mark.sampled(9)
@pytest.mark.parametrize("family, name, seed", MUTANTS)
def test_a_billionth_of_the_data_is_seen(family, name, seed):
    """Of changes that move the plate by more than 1e-10; restitution at several contacts is seen to 1e-8 only."""
    case = FAMILIES[family](seed)
    other = MUTATIONS[name](case)
    if other is None:
        return
    right, wrong = simulate(case), simulate(other)
    assert reference.check(case, right, 0.0) == ()
    is_to_1e_8 = name == "restitution" and len(right.contact_names) > 1
    if distance(right, wrong) > 1e-10 and not is_to_1e_8:
        assert reference.check(case, replace(wrong, case=case), 0.0)
