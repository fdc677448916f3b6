"""The stored proofs: how much they prove, and that the certified truth agrees with them. Reads files only."""

from __future__ import annotations

from pathlib import Path

import pytest

import cases
from reference.certification import PROVED, read
from reference.proofs import catalogue

ROOT = Path(__file__).parents[2]
PROOFS, TRUTH = catalogue.read(), read()
# A slip of 1e-17 m/s is below the rounding of the speeds, so the witnesses do not have it; in exact numbers it ends.
BELOW_ROUNDING = {"almost_rolling[slip=1e-17]", "almost_rolling[slip=-1e-17]"}


def first_transitions() -> list[str]:
    return [label for label, proof in PROOFS.items() if proof.transitions and proof.transitions[0].time.width < 1e-12]


def whole_sequences() -> list[str]:
    return [label for label, proof in PROOFS.items() if proof.complete]


def test_first_transitions_of_thirty_cases_and_ten_whole_sequences_are_proved():
    assert len(first_transitions()) >= 30
    assert len(whole_sequences()) >= 10
    assert len([label for label in whole_sequences() if PROOFS[label].transitions]) >= 10


def test_every_record_belongs_to_a_case():
    labels = {case.label for name in cases.names() for case in cases.select(name)}
    assert PROOFS.keys() <= labels


@pytest.mark.parametrize("label", sorted(PROOFS.keys() & TRUTH.keys() - BELOW_ROUNDING))
def test_proved_intervals_lie_inside_the_witnessed_bars(label):
    proof, truth = PROOFS[label], TRUTH[label]
    for claim, (before, after, time, xi1) in zip(proof.transitions, truth.transitions, strict=proof.complete):
        assert (claim.before, claim.after) == (str(before), str(after))
        assert claim.time.inside(*time)
        assert claim.xi1.inside(*xi1)
    assert truth.kinds == (PROVED,) * len(proof.transitions) + ("witnessed",) * (
        len(truth.transitions) - len(proof.transitions)
    )
    if proof.complete:
        assert proof.status == truth.status


@pytest.mark.parametrize("mu, least", [(0.01, 453.87), (0.1, 1.6932)])
def test_papers_claim_is_refuted(mu, least):
    """Where the slip vanishes rolling needs friction outside the cone; the slip reverses."""
    first = PROOFS[f"disc_in_circle[mu={mu:g}]"].transitions[0]
    assert float(first.rolling_share.low) > least and first.after == "slip_backward"
    assert "rolling would need more than" in PROOFS[f"disc_in_circle[mu={mu:g}]"].statement


def test_page_has_the_numbers_of_the_file():
    page = " ".join((ROOT / "docs" / "proofs.md").read_text(encoding="utf-8").split())
    begun, whole = [p for p in PROOFS.values() if p.transitions], [p for p in PROOFS.values() if p.complete]
    count, both = sum(len(p.transitions) for p in begun), sum(bool(p.transitions) for p in whole)
    numbers = (
        f"It has {len(PROOFS)} records with {count} proved transitions: the first transition of {len(begun)} cases"
    )
    assert f"{numbers}, and {len(whole)} whole motions, of which {both} have transitions." in page


def test_page_counts_narrow_intervals_and_those_inside_the_bars():
    narrow = [
        p for p in PROOFS.values() if p.complete and p.transitions and all(t.time.width < 1e-12 for t in p.transitions)
    ]
    certified = {label: proof for label, proof in PROOFS.items() if label in TRUTH and label not in BELOW_ROUNDING}
    others = [len(p.transitions) for label, p in PROOFS.items() if label not in TRUTH and p.transitions]
    inside = sum(
        claim.time.inside(*row[2])
        for label, proof in certified.items()
        for claim, row in zip(proof.transitions, TRUTH[label].transitions, strict=proof.complete)
    )
    page = " ".join((ROOT / "docs" / "proofs.md").read_text(encoding="utf-8").split())
    assert (
        f"{len(first_transitions())} of the first transitions and all transitions of {len(narrow)} whole motions"
        in page
    )
    assert f"{inside} proved transitions lie inside the bars" in page and inside == sum(
        len(p.transitions) for p in certified.values()
    )
    assert f"{sum(others)} belong to {('one case', 'two cases')[len(others) - 1]} without a certificate" in page
