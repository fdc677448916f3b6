"""The permanent set of planted faults: each is a broken law, and the right motion of its scene breaks none.

A change of the check of laws runs all of it: `pytest tests/reference/test_planted_faults.py -m "slow or not slow"`.
"""

from __future__ import annotations

import pytest

import reference
from tests.scenes.planted_faults import ESCAPES, FAULTS
from tests.scenes.planted_motions import simulate

# The Taylor method's motions are exact to roundings, which is what the faults of a billionth need.
pytestmark = pytest.mark.taylor


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_a_broken_law(name):
    fault = FAULTS[name]
    case = fault.scene()
    assert reference.check(case, simulate(case), 0.0) == ()
    assert bool(reference.check(case, fault.plant(case), 0.0)) == (name not in ESCAPES)


def test_few_faults_escape():
    assert set(ESCAPES) <= set(FAULTS) and len(ESCAPES) < 0.03 * len(FAULTS)
