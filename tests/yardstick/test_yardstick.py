"""The tables of the yardstick keep what they have: rows, tests that exist, patches that apply, values in tests."""

import csv
import re
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

from tests.authorities.published import PUBLICATIONS

from .plant import CHOICES, HERE, ROOT, faults, read_results, with_patch

# The least numbers of rows: those of the tables at the commit 43ab33a3.
ROOMS = {"cases": 16, "reference": 18, "adapters": 15, "reports": 24}
CLAIMS, WITH_TEST, PAGES, VALUES = 211, 200, 26, 287


def rows(name: str) -> list[dict[str, str]]:
    with (HERE / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@cache
def text(place: str) -> str:
    """The text of a file, or of all Python files of a folder, without spaces."""
    path = ROOT / place
    files = sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return re.sub(r"\s+", "", "".join(file.read_text(encoding="utf-8") for file in files))


def absent(node: str) -> str:
    """The node if its file or its function is not there, else ""."""
    file, _, function = node.partition("::")
    path = ROOT / file
    return "" if path.is_file() and f"def{function}(" in text(file) or path.is_file() and not function else node


def test_every_fault_can_be_planted_and_names_a_test_that_exists():
    every = faults()
    assert len({fault.id for fault in every}) == len(every)
    for fault in every:
        with_patch(fault, (ROOT / fault.file).read_text(encoding="utf-8"))
    assert not [node for fault in every if (node := absent(fault.test))]


def test_a_room_keeps_its_faults_and_each_has_a_result():
    every, results = faults(), read_results()
    for room, least in ROOMS.items():
        assert sum(fault.room == room for fault in every) >= least
    assert list(results) == [fault.id for fault in every]
    assert set(results.values()) <= {"found", "not found"}
    assert {fault.choice for fault in every} <= set(CHOICES)


def test_the_page_has_the_counts_of_the_results():
    every, results, page = faults(), read_results(), (HERE / "README.md").read_text(encoding="utf-8")
    for room in ROOMS:
        own = [fault for fault in every if fault.room == room]
        by = Counter(fault.choice for fault in own if results[fault.id] == "found")
        counts = [len(own), *(by[choice] for choice in CHOICES), len(own) - by.total()]
        assert f"| {room} | {' | '.join(map(str, counts))} |" in page


def test_each_claim_names_a_test_that_exists_or_none():
    claims = rows("claims.csv")
    tests = [row["test"] for row in claims if row["test"] != "none"]
    assert len(claims) >= CLAIMS and len(tests) >= WITH_TEST
    assert not [node for test in tests if (node := absent(test))]
    pages = {row["page"] for row in claims}
    assert len(pages) >= PAGES and all((ROOT / page).is_file() for page in pages)


def test_each_value_from_outside_still_stands_in_the_tests():
    values, numbers = rows("values.csv"), {float(n.value) for one in PUBLICATIONS for n in one.numbers}
    assert len(values) >= VALUES
    losses = []
    for row in values:
        if row["place"].endswith("published.py"):
            stands = float(row["value"]) in numbers
        else:
            digits = re.sub(r"\s+", "", row["value"])
            if len(digits) < 6:  # a short number stands anywhere: next to its quantity
                digits = re.sub(r"\s+", "", f'{row["quantity"]}",{digits},')
            stands = any(digits in text(place) for place in (row["place"], "tests") if Path(ROOT / place).exists())
        losses += [] if stands else [row]
    assert not losses


@pytest.mark.parametrize("node", ["tests/docs/test_docs.py::test_none", "tests/no_file.py", "tests/no_file.py::test_a"])
def test_a_test_that_is_not_there_is_seen(node):
    assert absent(node) == node
