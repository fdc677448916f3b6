"""The error of friction's law of a sampled motion, without a truth."""

from __future__ import annotations

from dataclasses import replace
from math import isnan

import pytest

import cases
import reference
from cases import CoulombFriction
from reports.judging.law_error import law_error
from tests.scenes.motions import sampled

LABELS = ["disc_in_circle[mu=0.2]", "disc_on_line[mu=0.1]", "stribeck_disc"]


def with_friction(case, factor):
    """The scene with friction that is larger by a factor."""
    own = case.effect(CoulombFriction)
    effects = tuple(CoulombFriction(own.mu * factor) if e is own else e for e in case.effects)
    return replace(case, effects=effects)


@pytest.mark.parametrize("label", LABELS)
def test_a_true_motion_has_none(label):
    """The error of differences over a sample's step is of its second order but at a transition."""
    case = cases.load(label)
    coarse, fine = (law_error(case, sampled(reference.simulate(case, 1e-12), count)) for count in (501, 2001))
    assert fine.median < 1e-4 and fine.median <= coarse.median + 1e-9


@pytest.mark.parametrize("label", LABELS)
@pytest.mark.parametrize("factor", [0.97, 1.03])
def test_friction_that_is_three_percent_off_is_read(label, factor):
    case = cases.load(label)
    wrong = sampled(reference.simulate(with_friction(case, factor), 1e-12), 2001)
    assert law_error(case, wrong).median == pytest.approx(0.03, abs=1e-3)


@pytest.mark.parametrize("label", ["row_of_discs", "disc_between_belt_and_wall"])
def test_of_several_plates_or_contacts_it_is_not_known(label):
    case = cases.load(label)
    assert isnan(law_error(case, sampled(reference.simulate(case), 101)).median)
