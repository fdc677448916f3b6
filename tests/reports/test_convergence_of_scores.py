"""Scores of all routes over the catalogue: every case has a scale, and off falls with every finer setting within the
doubt; and what judging costs, as a number of readings."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import adapters
import cases
from reports.judging import score, transitions
from reports.judging.grades import LIMITS, Grade, grade
from reports.running import tasks
from reports.running.records import one_default
from reports.running.solvers import solver

# The last variant of each family; slow but for the paper's application.
PAPER = cases.load("disc_in_circle", mu=0.2)
FAMILIES = [case for name in cases.names(hard=False) if (case := cases.select(name)[-1]) != PAPER]
# Settings of a ladder that are run, from coarse to fine: convergence shows in them, and finer ones take long.
RUNGS = 5
# A route converges if its finest off is this part of its coarsest; the ladders of others do not refine what limits
# them.
CONVERGES = 0.2
# Off may rise by this share from a setting to the next: errors of opposite sign may cancel at one of both.
SCATTER = 0.5
# Smaller scores are not compared: of the reference for rounding; of an engine and of the paper's system under SciPy's
# integrators (augmented in disc_on_trochoid: 0.0008, 0.006 and 0.0009 %) because at a lucky setting its errors
# cancel to a fraction of a tenth of a percent (pymunk assisted in disc_in_catenary: 0.11, 0.02, 0.054 and 0.021 %;
# Exudyn native in disc_on_spring: 0.022, 0.008 and 0.018 %; integrator in disc_on_line: 0.0002 and 0.0008 %).
LEAST_OF_REFERENCE, LEAST_OF_ENGINES = 1e-5, 1e-3


def ladders(case, count=RUNGS):
    """Off and doubt of the coarsest settings of each installed route, by solver and route."""
    truth = tasks.find_truth(case)
    assert not truth.failure and truth.scale is not None
    found = {}
    for name in ("reference", *adapters.engines()):
        for offer in tasks.survey(case, name):
            settings = [setting for setting in one_default(offer.settings) if not setting.is_default][:count]
            runs = [tasks.perform(case, name, offer.route, setting, i, truth) for i, setting in enumerate(settings, 1)]
            found[name, offer.route] = [(run.score.off, run.score.doubt) for run in runs if run.score]
    return truth, found


@pytest.mark.parametrize(
    "case", [PAPER, *(pytest.param(case, marks=pytest.mark.slow) for case in FAMILIES)], ids=lambda case: case.label
)
def test_off_falls_with_finer_settings_of_a_convergent_route(case):
    truth, found = ladders(case, 3 if case is PAPER else RUNGS)
    scale = truth.scale
    assert scale.pose > 0.0 and scale.slip >= 0.0 and scale.time > 0.0 and np.isfinite(truth.friction_sensitivity)
    assert all(off >= 0.0 and doubt >= 0.0 for ladder in found.values() for off, doubt in ladder)
    for (name, route), ladder in found.items():
        least = LEAST_OF_REFERENCE if name == "reference" and route != "augmented" else LEAST_OF_ENGINES
        # Facets and corners of native routes catch the plate at some steps and not at others.
        pairs = pairwise(ladder) if route != "native" else [(ladder[0], ladder[-1])] if ladder else []
        if len(ladder) < 2 or not ladder[-1][0] <= CONVERGES * ladder[0][0]:
            continue
        for (coarse, coarse_doubt), (fine, fine_doubt) in pairs:
            # Beyond ignoring friction's law, how far off a motion is says nothing.
            if coarse <= LIMITS[Grade.POOR]:
                assert fine - fine_doubt <= (1.0 + SCATTER) * (coarse + coarse_doubt) + least, (name, route, ladder)


@pytest.mark.slow
def test_a_ladder_does_not_alternate_between_grades():
    """Facets that grow finer with the step: the sequence of transitions was right and wrong by turns, off only
    falls."""
    pytest.importorskip("pymunk")
    _, found = ladders(PAPER, 8)
    grades = [list(Grade).index(grade(off)) for off, _ in found["pymunk", "native"]]
    assert grades == sorted(grades, reverse=True) and grades[0] - grades[-1] >= 2


def test_judging_reads_a_motion_once_as_a_rule(monkeypatch):
    """More readings are made only where they could change the score: the time of judging is less than doubled."""
    counts = []
    original = transitions.read_motion

    def counted(*arguments):
        counts[-1] += 1
        return original(*arguments)

    monkeypatch.setattr(score.transitions, "read_motion", counted)
    truth = tasks.find_truth(PAPER)
    for name in adapters.engines():
        for offer in tasks.survey(PAPER, name):
            for setting in offer.settings[::4][:2]:
                counts.append(0)
                motion = tasks.run_on_clock(solver(name), PAPER, offer.route, setting)
                score.score(PAPER, motion, tasks.true_motion(PAPER, truth.method), truth.scale)
    if not counts:
        pytest.skip("no engine is installed")
    assert max(counts) <= 3 and np.mean(counts) <= 1.5
