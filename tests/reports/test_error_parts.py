"""The parts of an error: made-up grids whose parts are known, and pymunk's trap in real runs."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from adapters import Setting
from reports import study
from reports.running.records import Run
from reports.studies import error_parts
from reports.studies.error_parts import ErrorCell


def made_up(error, steps=(4.0, 2.0, 1.0), facets=(10, 20, 40), **extra) -> list[ErrorCell]:
    """Cells of a grid h × facets with the first transition's error given by a function of both."""
    cells = []
    for h in steps:
        for n in facets:
            found = {"first_transition_time": np.array([error(h, n)])}
            found |= {"energy_lost": np.array([np.nan]), "final_centre": np.array([np.nan, np.nan])}
            setting = Setting.of(h=h, facets=n, slop=1e-6, **extra)
            cells.append(ErrorCell(Run("case", "engine", "native", setting, 1, "answered"), found))
    return cells


def rows_of(cells: list[ErrorCell]) -> list[dict]:
    """The rows of the table."""
    return error_parts.rows(cells)["error_parts"]


def output(cells: list[ErrorCell], h: float, n: int, quantity: str = "first_transition_time") -> dict:
    """The row of one setting."""
    rows = rows_of(cells)
    return next(r for r in rows if r["quantity"] == quantity and str(r["setting"]) == f"h={h:g} facets={n}")


def test_parts_of_a_separable_error_are_its_terms():
    cells = made_up(lambda h, n: 3e-3 * h**2 - 1.0 / n)
    row = output(cells, 4.0, 10)
    assert row["step_part"] == pytest.approx(3e-3 * (4.0**2 - 1.0))
    assert row["model_part"] == pytest.approx(-1 / 10 + 1 / 40)
    assert row["finest_error"] == pytest.approx(3e-3 - 1 / 40)
    assert row["interaction"] == pytest.approx(0.0, abs=1e-15)


def test_parts_always_add_up_to_the_error():
    cells = made_up(lambda h, n: h * n * 1e-3 + np.sin(h + n))
    for row in rows_of(cells):
        if row["quantity"] == "first_transition_time":
            parts = row["finest_error"] + row["step_part"] + row["model_part"] + row["interaction"]
            assert parts == pytest.approx(row["total"], abs=1e-15)


def test_parts_of_a_distance_are_told_along_it():
    cells = made_up(lambda h, n: 0.0)
    for cell in cells:
        h, n = cell.run.setting["h"], cell.run.setting["facets"]
        cell.errors["final_centre"] = np.array([0.3 * h, 4.0 / n])
    row = output(cells, 4.0, 10, "final_centre")
    assert row["total"] == pytest.approx(np.hypot(1.2, 0.4))
    along = np.array([1.2, 0.4]) / row["total"]
    assert row["step_part"] == pytest.approx(0.9 * along[0])
    assert row["model_part"] == pytest.approx(0.3 * along[1])


def test_knob_to_turn_is_the_one_whose_notch_helps_most():
    cells = made_up(lambda h, n: h + 1.0 / n)
    assert output(cells, 4.0, 10)["turn_next"] == "h"
    assert output(cells, 1.0, 10)["turn_next"] == "facets"
    assert output(cells, 1.0, 40)["turn_next"] == "none"


def test_failed_run_is_a_row_and_no_advice():
    cells = made_up(lambda h, n: h if (h, n) != (2.0, 10) else np.nan)
    cells[3] = ErrorCell(replace(cells[3].run, outcome="crashed", reason="It blew up."))
    row = output(cells, 2.0, 10)
    assert (row["outcome"], row["reason"], row["turn_next"]) == ("crashed", "It blew up.", "none")
    assert np.isnan(row["total"])
    # The notch towards the failed run is neither good nor bad.
    assert output(cells, 4.0, 10)["turn_next"] == "all"


# --- the command -----------------------------------------------------------------------------------------------------


def test_command_writes_a_row_for_every_setting_and_says_what_each_parameter_changes(tmp_path, capsys, in_process):
    pytest.importorskip("adapters.pymunk")
    out = tmp_path / "parts"
    argv = ["error_parts", "--case", "disc_on_line[mu=0.1]", "--solver", "pymunk", "--out", str(out)]
    with in_process():
        assert study.main([*argv, "--store", str(tmp_path / "store")]) == 0
    said = capsys.readouterr().out
    assert str(out / "error_parts.csv") in said
    assert re.search(r"pymunk native in disc_on_line\[mu=0.1\]: [\d.]+ % off; h \S+ to \S+: ÷ [\d.,]+;", said)
    lines = (out / "error_parts.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + 2 * 16 * len(error_parts.QUANTITIES)
