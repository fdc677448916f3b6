"""Cases and motions travel: to another process and back, by a copy or by cloudpickle, they stay the same."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from math import inf
from multiprocessing import get_context

import cloudpickle
import numpy as np
import pytest
import sympy as sp

import cases
import reference
from cases import Case, CoulombFriction, Curve, Drive, Gravity, Load, Plate, Start, Unilateral, disc
from cases.contact import start_motion
from cases.curves import cos, sin
from cases.library import line
from cases.moving_frame import relative_case
from reference.solve import METHODS
from reports.running.storage.fingerprint import content
from tests.scenes import bits
from tests.taylor.conftest import default_method  # noqa: F401 - a fixture

# Slip and roll, an outline that is no disc, flights and impacts that come to rest, a load, ends of all kinds, no step.
LABELS = [
    "disc_in_circle[mu=0.2]", "ellipse_in_circle", "bouncing_disc", "hopping_hoop", "driven_disc", "disc_off_ramp",
    "rod_into_the_paradox", "almost_rolling[slip=-1e-17]",
]  # fmt: skip


# --- cases ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def elsewhere():
    """A process that shares nothing with this one."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        yield pool


def seen(some: list[Case]) -> list[tuple]:
    """What a process that was sent cases makes of them, and the cases."""
    return [(case.label, content(case), case) for case in some]


def begun(case: Case) -> tuple:
    """The start and the load there: what needs the compiled curves and formulas."""
    load = case.effect(Load)
    return tuple(start_motion(case)), load and load.at(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)


def by_hand() -> Case:
    """A case no catalogue knows, made of functions that no other process can import, in forms that SymPy's own
    pickles multiply out."""
    track = Curve(lambda s: (s, -sp.Rational(1, 3) * cos(2 * s) * sp.Mul(2, s + 5.5, evaluate=False)), domain=(-1, 3))
    outline = Curve(lambda s: (0.1 * cos(s), (sp.pi / 40) * sin(s)))
    load = Load(fx="-0.2*vx + sin(3*t)", moment=sp.Symbol("omega", real=True) / 3)
    assert load.at(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3.0) == [-0.2, 0.0, 1.0]  # compiled: that stays here
    effects = (Gravity(9.81), load, CoulombFriction(0.2), Unilateral())
    return Case(track, Plate(outline, 1.0, 0.01), effects, Start(0.5), duration=1.0, parameters={"size": 0.1})


def on_turning_track() -> Case:
    """A disc that does not turn, as its track sees it that does."""
    effects = Gravity(9.81), CoulombFriction(0.2), Unilateral(), Drive(angle="0.1*t")
    return relative_case(Case(line(), disc(0.1, 1.0, inf), effects, Start(0.0), 1.0))


def all_cases() -> list[Case]:
    return [by_hand(), on_turning_track(), *(case for name in cases.names() for case in cases.select(name, long=True))]


def test_every_case_arrives_as_it_was_sent(elsewhere):
    sent = all_cases()
    for case, (label, digest, back) in zip(sent, elsewhere.submit(seen, sent).result(), strict=True):
        assert label == case.label
        assert digest == content(case) is not None
        assert (back, hash(back)) == (case, hash(case))
        assert dict(back.parameters) == dict(case.parameters)
        assert back.track.residual == case.track.residual


def test_an_arrived_case_has_the_same_motion_to_the_last_digit(elsewhere):
    points = np.array([[np.cos(a), 0.8 * np.sin(a)] for a in np.linspace(0, 2 * np.pi, 41)[:-1]])
    measured = Case(
        Curve.spline(points, closed=True),
        cases.disc(0.1, 1.0),
        (Gravity(9.81), CoulombFriction(0.2), Unilateral()),
        Start(0.0),
        duration=1.0,
    )
    for case in (by_hand(), measured, cases.load("disc_in_circle")):
        assert repr(elsewhere.submit(begun, case).result()) == repr(begun(case))


# --- motions ----------------------------------------------------------------------------------------------------------


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
