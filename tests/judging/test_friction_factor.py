"""Friction ×: 1 for motions by the law, the planted factor for others, and no number where nothing slips."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cases import CoulombFriction
from tests.sampling import quick_every
from tests.scenes import planted_engines as planted
from tests.scenes.motions import sampled

PAPER = cases.load("disc_in_circle", mu=0.2)


@quick_every(2)
@pytest.mark.parametrize(
    "name",
    # A circle, a load that depends on time, a spring, no disc, a guide without lift-off, rolling resistance; a belt.
    [
        "disc_in_circle",
        "driven_disc",
        "ellipse_on_line",
        "slider_on_belt",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("disc_on_spring", "guided_loop", "disc_rolling_to_rest")
        ),
    ],  # fmt: skip
)
def test_motions_by_the_law_have_friction_1(name):
    truth = planted.judged(cases.select(name)[0])
    assert truth.friction(sampled(truth.truth, 2000)) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("factor", [0.5, 0.95, 2.0, 60.0])
def test_another_friction_is_found(factor):
    truth = planted.judged(PAPER)
    friction = PAPER.effect(CoulombFriction)
    other = planted.null_motions.with_friction(PAPER, mu=factor * friction.mu)
    motion = sampled(planted.reference.simulate(other, rtol=1e-12), 4000)
    # At friction × 60 the slip lasts 7 ms of 2.5 s: trapezoids of 11 samples.
    assert truth.friction(motion) == pytest.approx(factor, rel=2e-2 if factor > 10.0 else 2e-3)


def test_null_motions_have_no_friction_or_no_slip():
    truth = planted.judged(PAPER)
    assert truth.friction(sampled(truth.nulls["no friction"], 2000)) == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(truth.friction(sampled(truth.nulls["rolls from the start"], 2000)))
    assert np.isnan(truth.friction(truth.nulls["never moves"]))


@pytest.mark.parametrize("name", ["bouncing_disc", "frictionless_pendulum", "rolling_pendulum"])
def test_impacts_and_motions_without_slip_say_nothing_about_friction(name):
    truth = planted.judged(cases.select(name)[0])
    assert np.isnan(truth.friction(sampled(truth.truth, 1000)))
