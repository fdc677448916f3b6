"""Motions travel: to another process and back, by a copy or by cloudpickle, they stay the same to the last bit."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import cloudpickle
import pytest

import cases
import reference
from cases import Case, CoulombFriction, Curve, Gravity, Load, Start, Unilateral, disc
from cases.curves import cos
from reference.solve import METHODS
from tests.scenes import bits
from tests.taylor.conftest import default_method  # noqa: F401 - a fixture

# Slip and roll, an outline that is no disc, flights and impacts that come to rest, a load, ends of all kinds, no step.
LABELS = [
    "disc_in_circle[mu=0.2]", "ellipse_in_circle", "bouncing_disc", "hopping_hoop", "driven_disc", "disc_off_ramp",
    "rod_into_the_paradox", "almost_rolling[slip=-1e-17]",
]  # fmt: skip


def by_hand() -> Case:
    """A case no catalogue knows, with a formula that no other process can import."""
    return Case(
        Curve(lambda s: (s, -0.3 * cos(2 * s)), domain=(-3, 3)),
        disc(radius=0.1, mass=1.0),
        (Gravity(9.81), CoulombFriction(0.1), Unilateral(), Load(fx="0.2*sin(3*t) - 0.1*vx")),
        Start(xi1=-1.0),
        duration=1.0,
    )


@pytest.fixture(scope="module")
def elsewhere():
    """A process that shares nothing with this one."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        yield pool


@pytest.fixture(scope="module")
def chosen() -> list[Case]:
    return [by_hand(), *map(cases.load, LABELS)]


def test_a_motion_is_the_same_in_another_process(elsewhere, chosen):
    motions = [reference.simulate(case) for case in chosen]
    for motion, output in zip(motions, elsewhere.map(bits.of_motion, motions), strict=True):
        assert output == bits.of_motion(motion), motion


@pytest.mark.parametrize("method", [*METHODS, "augmented"])
@pytest.mark.parametrize(
    "trip",
    [
        lambda motion: pickle.loads(pickle.dumps(motion)),
        pytest.param(
            lambda motion: pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(motion)))), marks=pytest.mark.slow
        ),
        lambda motion: pickle.loads(cloudpickle.dumps(motion)),
        copy.deepcopy,
        copy.copy,
    ],
    ids=["pickle", "twice", "cloudpickle", "deepcopy", "copy"],
)
def test_a_copy_is_the_same(trip: Callable, method, chosen):
    some = chosen if method in METHODS else [chosen[0], cases.load("hopping_hoop"), chosen[-1]]
    for case in some:
        motion = reference.simulate(case, method=method)
        assert bits.of_motion(trip(motion)) == bits.of_motion(motion), case.label


def test_a_motion_is_small_and_arrives_before_anything_is_derived(chosen):
    for case in chosen:
        motion = reference.simulate(case)
        letter = pickle.dumps(motion)
        # A step of the Taylor method is some twenty terms of four variables, 0.7 kB; samples take 0.1 kB more.
        assert len(letter) < 5000 + 1200 * len(motion.t), case.label
        assert pickle.loads(letter).dense._segment_list == []  # who reads transitions alone waits for no equations
