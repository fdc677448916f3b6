"""Numbers that other people's programs publish: ours meet them within the publishers' own accuracy, or say why not."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import DOP853

import reference
from reports.studies import Request
from reports.studies.published import study as published
from tests.authorities.published import COLUMNS, PUBLICATIONS, impacts, rows
from tests.authorities.published_numbers.bouncing import thrown_stick
from tests.authorities.published_numbers.publications import verdict
from tests.authorities.published_numbers.readings import impact_times

BY_NAME = {publication.name: publication for publication in PUBLICATIONS}

# Rounding of a time of some seconds, added up over tens of impacts.
ROUNDING = 1e-13

# A step of DOP853 covers twice a hop's duration T. Its weighted sums round a height by up to S g (2 T)²/2, and with it
# the speed g T/2 by 8 S of itself; the sums of the stages before them as much again. Some processors round less.
SPEED_ROUNDING = 16 * float(np.abs(DOP853.B).sum()) * np.finfo(float).eps


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
        assert all(number.reason for number in publication.numbers if number.off), publication.name


@pytest.mark.parametrize("publication", PUBLICATIONS, ids=lambda publication: publication.name)
def test_our_motion_has_the_published_numbers(publication, accuracy):
    table = rows([publication])
    for number, row in zip(publication.numbers, table, strict=True):
        assert list(row) == list(COLUMNS)
        # A disagreement that is claimed must be there, or the claim is out of date.
        claimed = number.off > number.accuracy
        expected = "reproduces its error" if number.distance else "known" if claimed else "agrees"
        assert row["verdict"] == expected, row
        assert bool(row["note"]) == (expected != "agrees"), row
        accuracy(
            case=publication.name,
            solver=publication.program,
            route="published",
            quantity=number.quantity,
            error=abs(row["difference"]) - number.distance if number.distance else row["difference"],
            tolerance=number.off if claimed else number.accuracy,
        )


def test_the_table_of_a_report_has_what_is_computed_here():
    stored = published.run(Request(), None)
    assert len(stored) == sum(len(publication.numbers) for publication in PUBLICATIONS)
    computed = rows(PUBLICATIONS[:3])
    words = set(COLUMNS) - {"ours", "difference"}
    for row, own in zip(stored, computed, strict=False):
        assert {name: row[name] for name in words} == {name: own[name] for name in words}
        assert float(row["ours"]) == pytest.approx(float(own["ours"]), abs=own["accuracy"])
    numbers = [(publication.name, n.quantity) for publication in PUBLICATIONS for n in publication.numbers]
    assert [(row["scene"], row["quantity"]) for row in stored] == numbers


def test_a_number_that_is_wrong_is_found():
    right = BY_NAME["DEM04, slip to roll, μ = 0.2"]
    shifted = tuple(replace(number, value=number.value + 3 * number.accuracy) for number in right.numbers)
    assert {row["verdict"] for row in rows([replace(right, numbers=shifted)])} == {"differs"}


def test_nine_numbers_are_compared_with_their_printed_errors_and_a_smaller_error_differs():
    numbers = [number for publication in PUBLICATIONS for number in publication.numbers if number.distance]
    assert len(numbers) == 9
    for number in numbers:
        assert number.distance > 10 * number.accuracy  # the comparison can fail
        assert verdict(number, number.value) == "differs"  # the published number itself is not the exact one


def test_published_and_ours_have_the_digits_that_show_the_agreement():
    table = rows([BY_NAME["bouncing ball, event-driven"]])
    assert table[0]["published"] == "0.4515236409857" and table[0]["ours"] == "0.4515236409857"


def test_each_known_disagreement_has_its_own_reason():
    known = [number for publication in PUBLICATIONS for number in publication.numbers if number.off > number.accuracy]
    assert len(known) == 19
    assert len({number.reason for number in known}) == 19


def test_heights_of_the_reference_fmu_follow_from_its_own_impacts():
    numbers = BY_NAME["BouncingBall"].numbers
    times = [number.value for number in numbers if "impact" in number.quantity]
    for number in numbers[len(times) :]:
        own = float(re.search(r"free flight is at (\S+) m", number.reason)[1])
        # The impacts are printed to 5e-6 s, the closing speed is below 4 m/s.
        assert own == pytest.approx(number.value, abs=2e-5)


@pytest.mark.parametrize("degrees", [20, 30])
def test_speed_and_spin_of_a_sticking_sphere_follow_from_one_rebound(degrees):
    spin, speed = BY_NAME[f"sphere thrown at a wall at {degrees}°"].numbers
    predicted = float(re.search(r"5/7 - 2/7 β = (\S+) of", speed.reason)[1])
    assert predicted == pytest.approx(speed.value, rel=0.016)  # the publisher's bound on the speed
    assert abs(predicted - 5 / 7) > 0.016 * speed.value, "rigid friction is outside that bound"


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
    exact = np.array(impacts(count, *ball))
    # Each hop begins with the speed that the one before ended with, so that roundings of speeds add up.
    added = np.cumsum(np.arange(count) * np.diff(exact, prepend=0.0)) * SPEED_ROUNDING
    rounding = ROUNDING + (added if method == "dop853" else 0.0)
    assert np.all(np.abs(impact_times(motion)[:count] - exact) <= rounding)


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
