"""The score of motions on supports, contact by contact: exact ones, null motions, engines with a planted error."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import cases
import reference
from cases import Case, CoulombFriction, Mode, Trajectory
from cases.motion.sampled_contacts import SampledContacts
from reports.judging import friction_sensitivity, several_contacts
from reports.judging.grades import Grade, grade
from reports.judging.null_motions import null_motions, with_friction
from reports.judging.score import Scale
from tests.scenes import planted_engines as planted

NAMES = ("ladder_at_wall", "round_ladder_at_wall", "rocking_block", "block_on_incline")
# Rounding of scores that are zero.
ROUNDING = 1e-9
pytestmark = pytest.mark.slow


class Judged(NamedTuple):
    """A case with its truth and the scale of each contact."""

    case: Case
    truth: Trajectory
    nulls: dict[str, Trajectory]
    scales: dict[str, Scale]

    def judge(self, motion: Trajectory) -> several_contacts.Judgement:
        """The comparison of a motion with the truth."""
        return several_contacts.judge(self.case, motion, self.truth, self.scales, self.truth.transitions)

    def sampled(self, samples: int, creep: float = 0.0, wrong: str = "", slip: float = 0.0) -> Trajectory:
        """The exact motion at even times; `creep` (m/s) is added to the slip of contacts that roll, `slip` (m/s) to
        that of the contact `wrong`, always."""
        t, columns = np.linspace(0.0, self.truth.t[-1], samples), {}
        for name in self.truth.contact_names:
            own = self.truth.contact_columns(name, t)
            values = own.slip + (slip if name == wrong else 0.0)
            for phase in self.scales[name].phases:
                if phase.mode in (Mode.ROLL, Mode.REST):
                    values[(t >= phase.begin) & (t <= phase.end)] += creep
            columns[name] = own._replace(slip=values)
        contacts = dict(contact_names=self.truth.contact_names, contact_columns=SampledContacts(t, columns))
        return Trajectory(t=t, **self.truth(t)._asdict(), **contacts)


@pytest.fixture(scope="module", params=NAMES)
def all_judged(request) -> list[Judged]:
    """The cases of a name that have several contacts."""
    found = []
    for case in cases.select(request.param):
        truth = reference.simulate(case, rtol=1e-12)
        if len(truth.contact_names) > 1:
            nulls = null_motions(case)
            found.append(Judged(case, truth, nulls, several_contacts.scales(case, truth, truth.transitions, nulls)))
    assert found
    return found


def test_null_motions_are_as_wrong_as_ignoring_friction(all_judged):
    for one in all_judged:
        for name, motion in one.nulls.items():
            score = one.judge(motion).score
            assert score.off >= 1.0 - ROUNDING or score.pose <= 1e-6, (one.case.label, name, score)


def test_exact_motions_are_within_their_doubt(all_judged):
    for one in all_judged:
        assert one.judge(one.truth).score.off <= ROUNDING
        for samples in (100, 300, 1000, 4000):
            score = one.judge(one.sampled(samples)).score
            assert score.off <= score.doubt + ROUNDING, (one.case.label, samples, score)


def test_engines_with_planted_friction_get_what_a_physicist_would_say(all_judged):
    for one in all_judged:
        friction = one.case.effect(CoulombFriction)
        if friction is None:
            continue
        much, less = (
            one.judge(reference.simulate(with_friction(one.case, mu=part * friction.mu))).score.off
            for part in (planted.FRICTION, planted.LESS_FRICTION)
        )
        if friction_sensitivity.friction_sensitivity(one.case, one.truth, one.scales) >= friction_sensitivity.LEAST:
            assert grade(much) is Grade.UNUSABLE and 0.02 <= less <= 0.15, (one.case.label, much, less)
        else:  # a block that rocks without slip: friction may be anything that is enough
            assert max(much, less) <= 1e-3, (one.case.label, much, less)


def test_a_motion_is_as_good_as_its_worst_contact(all_judged):
    for one in all_judged:
        for name, scale in one.scales.items():
            times = np.linspace(0.0, one.truth.t[-1], 1000)
            share = np.mean(np.isfinite(one.truth.contact_columns(name, times).slip))  # of the time, while it is closed
            judgement = one.judge(one.sampled(1000, wrong=name, slip=0.5 * scale.slip))
            # A tenth less: at ends of phases samples are left out.
            assert judgement.score.off >= 0.9 * 0.5 * share, (one.case.label, name, judgement.score)
            assert judgement.worst == name or share < 0.1
