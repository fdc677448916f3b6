"""Numbers that other people's programs publish: ours meet them within the publishers' own accuracy, or say why not."""

from dataclasses import replace

import pytest

import reference
from reports.studies.published.bouncing import thrown_stick
from reports.studies.published.readings import impact_times
from tests.authorities.published import COLUMNS, PUBLICATIONS, impacts, rows

BY_NAME = {publication.name: publication for publication in PUBLICATIONS}

# Rounding of a time of some seconds, added up over tens of impacts.
ROUNDING = 1e-13


def test_there_are_twelve_numbers_at_least_and_six_whole_motions():
    assert sum(len(publication.numbers) for publication in PUBLICATIONS) >= 12
    whole = [publication for publication in PUBLICATIONS if publication.whole]
    assert len(whole) >= 6
    assert all(len(publication.numbers) >= 4 for publication in whole)


def test_a_publication_says_where_it_stands_and_how_sure_it_is():
    assert len(BY_NAME) == len(PUBLICATIONS)
    for publication in PUBLICATIONS:
        assert publication.source.startswith("github.com/"), publication.name
        assert "commit" in publication.source and publication.accuracy, publication.name
        assert all(number.accuracy > 0.0 for number in publication.numbers), publication.name
        assert bool(publication.explanation) or not any(number.off for number in publication.numbers), publication.name


@pytest.mark.parametrize("publication", PUBLICATIONS, ids=lambda publication: publication.name)
def test_our_motion_has_the_published_numbers(publication, accuracy):
    table = rows([publication])
    for number, row in zip(publication.numbers, table, strict=True):
        assert list(row) == list(COLUMNS)
        # A disagreement that is claimed must be there, or the claim is out of date.
        claimed = number.off > number.accuracy
        assert row["verdict"] == ("known" if claimed else "agrees"), row
        accuracy(
            case=publication.name,
            solver=publication.program,
            route="published",
            quantity=number.quantity,
            error=row["difference"],
            tolerance=number.off if claimed else number.accuracy,
        )


def test_a_number_that_is_wrong_is_found():
    right = BY_NAME["DEM04, slip to roll, μ = 0.2"]
    shifted = tuple(replace(number, value=number.value + 3 * number.accuracy) for number in right.numbers)
    assert {row["verdict"] for row in rows([replace(right, numbers=shifted)])} == {"differs"}


@pytest.mark.parametrize(
    ("name", "count", "ball"),
    [
        ("BouncingBall", 11, (1.0, 0.0, 0.7, 9.81)),
        ("bouncing ball, event-driven", 25, (1.0, 0.0, 0.9, 9.81)),
        ("ball that begins with an impact", 14, (0.0, 0.9, 0.9, 9.81)),
        ("ball thrown up from 0 m", 10, (0.0, 20.0, 0.9, 9.8)),
        ("ball thrown up from 5 m", 8, (5.0, 20.0, 0.9, 9.8)),
    ],
)
@pytest.mark.parametrize("method", reference.METHODS)
def test_where_a_publisher_and_we_differ_the_closed_form_sides_with_us(name, count, ball, method):
    motion = reference.simulate(BY_NAME[name].case(), rtol=1e-13, method=method)
    assert impact_times(motion)[:count] == pytest.approx(impacts(count, *ball), abs=ROUNDING)


def test_the_reference_fmu_drifts_from_the_closed_form_by_a_millisecond():
    published = [number.value for number in BY_NAME["BouncingBall"].numbers if "impact" in number.quantity]
    late = [exact - time for time, exact in zip(published, impacts(11, 1.0, 0.0, 0.7, 9.81), strict=True)]
    assert late == sorted(late), "each bounce adds to it"
    assert late[-1] == pytest.approx(1.113e-3, abs=5e-6)  # its last digit is 1e-5 s


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_siconos_stick_is_told_from_other_laws_of_impact(law):
    # Its slip reverses within the impact: by Routh's construction friction turns with it, and the speed along is less.
    stick = BY_NAME["stick that hits with friction, e = 1"]
    found = {row["quantity"]: row["verdict"] for row in rows([replace(stick, case=lambda: thrown_stick(law))])}
    assert found["impact 1 / s"] == "agrees"
    assert found["speed along after it / (m/s)"] == "differs"
