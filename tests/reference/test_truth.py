"""The kept truth: rebuilt in part, and small bars."""

import re
from pathlib import Path

import pytest

import cases
from cases import Impact
from reference import certify
from reference.certification import read
from tests.authorities.paper_application import FIRST_TRANSITION

KEPT = read()


def test_every_case_of_the_catalogue_has_kept_truth():
    ordinary, hard = (
        {case.label for name in cases.names(hard=kind) for case in cases.select(name)} for kind in (False, True)
    )
    # A hard case that hangs on the last bit has no truth to keep.
    assert ordinary <= KEPT.keys() <= ordinary | hard, "rebuild the truth with `python -m reference`"


def test_cases_without_a_certificate_have_their_reason_in_the_documentation():
    page = Path(cases.__file__).parents[1] / "docs" / "truth.md"
    named = re.findall(r"`(\w+\[[^`]+\])`", page.read_text().split("no certificate:")[1].split("##")[0])
    assert {*named} == {case.label for name in cases.names() for case in cases.select(name)} - {*KEPT}


@pytest.mark.sampled(2, first=1)
@pytest.mark.parametrize("label", ["disc_in_circle[mu=0.2]", "disc_on_line[mu=0.1]"])
def test_rebuilt_truth_agrees_with_the_kept_one_within_its_bars(label):
    kept, rebuilt = KEPT[label], certify(cases.load(label))
    assert [t[:2] for t in rebuilt.transitions] == [t[:2] for t in kept.transitions]
    for one, other in zip(rebuilt.transitions, kept.transitions, strict=True):
        assert abs(one[2].value - other[2].value) <= one[2].bar + other[2].bar
    for quantity, bars in kept.samples.items():
        for one, other in zip(rebuilt.samples[quantity], bars, strict=True):
            assert abs(one.value - other.value) <= one.bar + other.bar


@pytest.mark.parametrize("mu", FIRST_TRANSITION)
def test_exact_value_lies_within_the_bar(mu):
    _, after, time, xi1 = KEPT[f"disc_in_circle[mu={mu:g}]"].transitions[0]
    exact_time, exact_xi1, follows = FIRST_TRANSITION[mu]
    assert after is follows
    assert abs(time.value - exact_time) <= time.bar
    assert abs(xi1.value - exact_xi1) <= xi1.bar


@pytest.mark.parametrize("label", [label for label in KEPT if not cases.entry(label.partition("[")[0]).hard])
def test_bars_are_far_below_any_error_worth_reporting(label):
    name, _, _ = label.partition("[")
    bounces = cases.select(name)[0].effect(Impact) is not None
    # Ten bars are the smallest error a report shows; a picosecond resolves every engine there is. Where bouncing comes
    # to rest, the instants of its last impacts are the rounding of a position over a speed of some 1e-4 m/s.
    assert all(t[2].bar < (1e-10 if bounces else 1e-12) for t in KEPT[label].transitions)
