"""The page that goes through the paper line by line names every equation, and only places that exist."""

import importlib
import re
from functools import reduce
from math import isnan
from pathlib import Path

import numpy as np
import pytest

import cases
import reference
from reference.errata import errata
from reference.paper.equation_list import LINES
from tests.benchmarks import paper as study

PAGE = (Path(__file__).parent.parent.parent / "docs" / "paper.md").read_text(encoding="utf-8")


def rows_below(heading: str) -> list[list[str]]:
    """The cells of the first table below a heading."""
    section = PAGE.split(f"## {heading}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def test_every_numbered_equation_of_the_paper_has_its_line():
    assert [line.number for line in LINES] == list(range(1, 36))
    output = [[f"({n})", says, ", ".join(f"`{place}`" for place in places)] for n, says, places in LINES]
    assert rows_below("Equations") == output
    assert [[row["equation"], row["says"]] for row in study.equation_rows()] == [line[:2] for line in output]


@pytest.mark.parametrize("place", sorted({place for line in LINES for place in line.places}))
def test_every_place_of_the_code_that_is_named_exists(place):
    module, name = place.split(":")
    reduce(getattr, name.split("."), importlib.import_module(module))


def test_other_code_that_the_page_names_exists():
    words = set(re.findall(r"`(reference\.[a-z_.]+|tests/[a-z_/]+\.py)`", PAGE))
    assert {"reference.augmented_integrator", "reference.errata", "tests/reference/test_errata.py"} <= words
    for word in words - {"reference.simulate"}:
        if word.endswith(".py"):
            assert (Path(__file__).parent.parent.parent / word).exists(), word
        else:
            importlib.import_module(word)


def test_the_page_has_every_misprint_with_its_residual():
    output = rows_below("Misprints")
    known = [row for row in errata() if isnan(row.claim)]
    assert [cells[0] for cells in output] == [row.where for row in known]
    for (_, printed, corrected, residual, rest, _), row in zip(output, known, strict=True):
        assert (printed, corrected) == (row.printed, row.corrected)
        assert residual == ("no value" if isnan(row.printed_residual) else f"{row.printed_residual:.2g}")
        assert row.corrected_residual < {"0": 1e-15, "rounding": 1e-14, "below 1e-9": 1e-9}[rest]


def test_the_page_has_the_claim_for_each_coefficient():
    rows = study.claim_rows()
    output = rows_below("The claim that rolling follows")
    assert [float(cells[0]) for cells in output] == [row["mu"] for row in rows]
    for (_, time, xi1, needed, then, beyond), row in zip(output, rows, strict=True):
        assert float(time) == pytest.approx(row["time_unitless"], abs=1e-6)
        assert float(xi1) == pytest.approx(row["xi1"], abs=1e-6)
        assert float(needed) == pytest.approx(row["demand"], rel=1e-3)
        assert float(beyond) == pytest.approx(row["rolls_beyond"], abs=1e-5)
        assert then.startswith("it rolls") == row["claim_holds"] == (row["margin"] >= 0.0)


@pytest.mark.parametrize("mu", study.FIGURE_COEFFICIENTS)
def test_papers_diagrams_end_where_the_slip_vanishes_and_ours_go_on(mu):
    motion = reference.simulate(cases.load("disc_in_circle", mu=mu), rtol=1e-12)
    stop = motion.transitions[0].time
    paper, whole = motion(np.linspace(0.0, stop, 300)), motion(np.linspace(0.0, motion.t[-1], 300))
    assert stop < motion.t[-1] and abs(paper.slip[-1]) < 1e-9 and np.all(paper.slip[1:-1] > 0.0)
    # (35): ξ₂ = ξ₁ − θ, along the whole motion.
    assert whole.xi2 - whole.xi2[0] == pytest.approx(whole.xi1 - whole.theta, abs=1e-9)
