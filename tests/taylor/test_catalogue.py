"""Where the cases of the catalogue come from, and the facts that books and papers state about them."""

import re

import pytest

import cases
from tests.authorities import bowling_and_inclines, odd_plates, pendulums_and_hills
from tests.authorities.facts import Basis
from tests.scenes.motions import motion_of

FACTS = [*bowling_and_inclines.FACTS, *pendulums_and_hills.FACTS, *odd_plates.FACTS]

# A source is derived or was looked up, or the docstring says that it was not; what is posed here needs none.
BASES = ("derived", "looked up", "this suite", "posed here", "dimensional analysis", "Ogaru & Pandrea", "the paper's")


@pytest.mark.parametrize("name", [*cases.names(hard=False), *cases.names(hard=True)])
def test_a_case_says_whether_its_source_was_looked_up(name):
    text = cases.entry(name).function.__doc__ or ""
    source = text[text.index("Source:") :].partition("Known exactly")[0].lower()
    assert any(basis.lower() in source for basis in BASES), source


@pytest.mark.parametrize("fact", FACTS, ids=lambda fact: f"{fact.case}-{fact.quantity}")
def test_a_fact_from_outside_holds(fact, accuracy):
    case = cases.load(fact.case, **fact.parameters)
    error = fact.measure(case, motion_of(case)) - fact.value
    common = dict(case=case.label, solver="reference", route="best")
    accuracy(**common, quantity=fact.quantity, error=error, tolerance=fact.tolerance)


def test_there_are_at_least_twenty_five_facts_and_each_says_what_it_rests_on():
    assert len(FACTS) >= 25
    for fact in FACTS:
        text = fact.source.text
        assert len(text) > 10 and text == text.strip(), fact
        if fact.source.basis is Basis.DERIVED:
            # A derivation states something: an equation, or what lies level, constant or straight.
            assert "=" in text or "level" in text, fact
        if fact.source.basis is Basis.LOOKED_UP:
            assert "github.com" in text or "arXiv" in text or re.search(r"\b(1[5-9]|20)\d\d\b", text), fact
