"""Every scene that the reference simulates: its export is compared with itself, and engines answer or refuse it.

The scenes: all cases of the catalogue, and random ones of every kind that `tests/scenes` draws. A true motion may be in
doubt by its samples, but is never farther off than that. Nor does `compare` say so of any, as it reads the truth from
the same samples; so the readers themselves are tested without that, except on the scenes that they are known to read as
another motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import count, islice

import numpy as np
import pandas as pd
import pytest

import cases
import reference
from adapters import Setting
from adapters.common import motion_table
from cases import (
    Case,
    CaseError,
    CoulombFriction,
)
from reports import export
from reports.judging.grades import LIMITS, Grade, is_within
from reports.judging.null_motions import with_friction
from reports.running.external_motions import judge_motion, of_table
from reports.running.records import Run, Truth
from reports.running.tasks import find_truth, judge, measure, survey
from reports.running.true_motions import true_motion
from tests.composition.build import first_scene
from tests.scenes import hard, lifted_plates, loads, ripples, slip_laws, ties, walled_plates

# Samples per second of exports: of a film, of a game, of an engine.
RATES = (60.0, 100.0, 1000.0)
# Of a file with more samples the test takes too long: a disc of 1 cm that slides for an hour.
MOST = 20_001
# Of a motion with more transitions the certificate takes too long. It computes the motion 19 times: 0.2 to 0.7 s of CPU
# for each transition of a polygon that bounces (seed 1 has 506).
MOST_TRANSITIONS = 100
# Scenes of each kind.
NUMBER = 2
# Kinds whose scenes take a second, and cases of the catalogue: with supports, flights, several contacts, slow slip.
QUICK_KINDS = ("all features", "slip laws")
QUICK_CASES = ("disc_in_circle[mu=0.2]", "bouncing_disc[e=0.5]", "sliding_box")
# At few samples per second a contact that opens by less than gravity closes within two samples is read as closed, for
# longer than its samples alone leave in doubt.
SMALL_OPENINGS = (
    "block_on_conveyor[speed=0.8,mu_static=0,stiffness=0]",
    "box_on_shaken_table[mu=0.8,width=0.075]",
    "disc_off_free_block",
    "disc_off_ramp",
)
# So is, at 1 kHz, a polygon that hops to rest, ever lower; a disc next to a wall before it touches it; and a plate that
# lands within 5 µm and then has ended. Kinds of which a scene among the first is known to be one.
LOW_FLIGHTS = ("ripples",)
# The sentence for a file with too few samples.
TOO_FEW = ("give at least", "give more samples", "too few for a slope")


def of_one_plate(seed: int) -> Case:
    """A drawn scene of one plate: files of several plates have contacts of some shapes only."""
    return next(case for case in map(first_scene, count(10 * seed)) if not case.others)


# By kind a scene from its seed.
KINDS: dict[str, Callable[[int], Case]] = {
    "all features": of_one_plate,
    "ellipses": lambda seed: hard.hard_scene(np.random.default_rng(seed))[1],
    "lifted plates": lambda seed: lifted_plates.lifted_plate(seed).case,
    "loads": lambda seed: loads.scene(np.random.default_rng(seed))[0],
    "ripples": ripples.rippled,
    "slip laws": lambda seed: slip_laws.random_scene(np.random.default_rng(seed)),
    "ties": lambda seed: ties.tie(seed).case,
    "walled plates": walled_plates.random_walled_plates,
}
ENGINES = ("pymunk", "exudyn")
CATALOGUE = {case.label: case for name in cases.names(hard=False) for case in cases.select(name)}


def scenes_of(kind: str, number: int) -> Iterator[Case]:
    """So many scenes of a kind that the reference simulates, with few enough transitions, from the seeds 0, 1, …"""

    def admissible() -> Iterator[Case]:
        for seed in range(20 * number):
            try:
                case = KINDS[kind](seed)
                motion = reference.simulate(case)
            except CaseError:  # an overlap, or a scene without an answer
                continue
            if len(motion.transitions) <= MOST_TRANSITIONS:
                yield case

    return islice(admissible(), number)


def samples_of(case: Case, rate: float) -> int:
    """The samples of an export with this many per second."""
    return int(min(MOST, np.ceil(rate * case.duration))) + 1


def judgement(
    case: Case, truth: Truth, rate: float, has_forces: bool = True, alone: bool = True, source: Case | None = None
) -> Run:
    """The judgement of the case's own export, or of another `source`'s, by the doubt of its samples `alone` or as
    `compare` makes it; raises CaseError where the file is refused."""
    names, rows = export.motion(export.true_motion(source or case), samples_of(case, rate))
    frame = pd.DataFrame(rows, columns=list(names))
    if not has_forces:
        frame = frame.drop(columns=["normal_force", "friction_force"])
    table = motion_table.parse(frame.to_csv(index=False), "motion.csv")
    external = of_table("file", case, table)
    if alone:
        row = Run(case.label, "file", "", Setting.of(), 0, outcome="")
        return judge(row, case, external.motion, true_motion(case, truth.method), truth)
    return judge_motion(external, 1, truth)


def fault_of_export(case: Case, truth: Truth, rate: float, has_forces: bool = True, alone: bool = True) -> str:
    """What is wrong with the comparison of a case's export with itself: that it is surely not excellent, or refused
    for another reason than too few samples; "" if nothing."""
    try:
        run = judgement(case, truth, rate, has_forces, alone)
    except CaseError as problem:
        return "" if any(words in str(problem) for words in TOO_FEW) else f"refused: {problem}"
    if run.score is not None and is_within(run.score, LIMITS[Grade.EXCELLENT]) is not False:
        return ""
    return f"{run.grade}, {run.reason}"


def fault_of_engine(case: Case, engine: str, truth: Truth) -> str:
    """What is wrong with an engine's coarsest run, which is answered, or refused in one sentence; "" if nothing."""
    offers = [offer for offer in survey(case, engine) if offer.route in ("native", "")]
    assert offers, f"{engine} says nothing of its own route"
    outcome, reason = offers[0].outcome, offers[0].reason
    if not outcome:
        call = (case, engine, "native", offers[0].settings[0], 1, truth)
        run = measure(*call)
        outcome, reason = run.outcome, run.reason
    is_sentence = reason.endswith(".") and "\n" not in reason
    return "" if outcome == "answered" or (outcome == "unsupported" and is_sentence) else f"{outcome}: {reason}"


def faults_of_exports(case: Case, truth: Truth, alone: bool, rates: Sequence[float] = RATES) -> dict:
    """What is wrong with the exports at these rates, with and without forces."""
    every = [(rate, forces) for rate in rates for forces in (True, False)]
    faults = {each: fault_of_export(case, truth, *each, alone=alone) for each in every}
    return {each: fault for each, fault in faults.items() if fault}


def check(case: Case, alone: bool = True) -> str:
    """Compare a scene's export with itself, and give the scene to the engines. What is wrong with the export by the
    doubt of its samples alone, which may be something only if these are not enough (`alone`: they are)."""
    truth = find_truth(case)
    if truth.failure:
        return ""  # nothing is judged by it
    fault = fault_of_export(case, truth, 1000.0)
    assert (fault if alone else fault and fault_of_export(case, truth, 1000.0, alone=False)) == ""
    assert not any(fault_of_engine(case, engine, truth) for engine in ENGINES)
    return fault


def slow_but(quick: Sequence[str], every: Iterable[str]) -> list:
    """Parameters of which only these are quick."""
    return [pytest.param(name, marks=() if name in quick else (pytest.mark.slow,)) for name in every]


@pytest.mark.parametrize("label", slow_but(QUICK_CASES, CATALOGUE))
def test_every_case_of_the_catalogue_is_compared_with_itself_and_given_to_engines(label):
    check(CATALOGUE[label])


@pytest.mark.parametrize("kind", slow_but(QUICK_KINDS, KINDS))
def test_random_scenes_of_every_kind_are_compared_with_themselves_and_given_to_engines(kind):
    scenes = list(scenes_of(kind, NUMBER))
    assert len(scenes) == NUMBER, "too few seeds give a scene that the reference simulates"
    faults = [check(case, kind not in LOW_FLIGHTS) for case in scenes]
    assert any(faults) == (kind in LOW_FLIGHTS), "its samples alone are enough: no longer one of LOW_FLIGHTS"


@pytest.mark.parametrize("label", slow_but((*QUICK_CASES, "disc_off_ramp"), CATALOGUE))
def test_the_same_truth_is_never_worse_than_not_decided(label):
    """At every rate, with and without forces."""
    case = CATALOGUE[label]
    truth = find_truth(case)
    if truth.failure:
        pytest.skip("no truth, so nothing is judged by it")
    faults = faults_of_exports(case, truth, alone=True)
    assert bool(faults) == (label in SMALL_OPENINGS), faults
    assert not faults or faults_of_exports(case, truth, alone=False) == {}


@pytest.mark.parametrize("label", slow_but(SMALL_OPENINGS[:1], SMALL_OPENINGS))
def test_half_of_the_friction_is_surely_wrong(label):
    """Also at a rate at which the modes of the truth are not decided: the poses show it."""
    case = CATALOGUE[label]
    friction = case.effect(CoulombFriction)
    assert friction is not None
    other = with_friction(case, mu=0.5 * friction.mu)
    score = judgement(case, find_truth(case), RATES[0], has_forces=False, alone=False, source=other).score
    assert score is not None and is_within(score, LIMITS[Grade.EXCELLENT]) is False
