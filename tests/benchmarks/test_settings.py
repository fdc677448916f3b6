"""Every rung lies on the lower envelope of a grid over the knobs; and a rung that does not is found."""

import numpy as np
import pytest

import cases
import reference
from adapters import Setting, lookup
from cases import NotSupported
from reports.running.calls import Calls
from reports.running.tasks import find_truth
from reports.studies import Request
from tests.benchmarks import settings
from tests.benchmarks.settings import SettingCell, beats, points


def cell(place: str, cpu: float, off: float, case: str = "a") -> SettingCell:
    return SettingCell(case, "engine", "native", place, Setting.of(h=cpu), "answered", cpu, off)


def on_envelope(*cells: SettingCell) -> dict[str, bool]:
    return {row["place"]: row["on_envelope"] for row in settings.table(cells) if row["place"].startswith("rung")}


def test_rung_that_costs_twice_as_much_as_one_as_good_is_found():
    assert on_envelope(cell("rung 1", 2.0, 1e-2), cell("grid 0", 1.0, 1e-2)) == {"rung 1": False}
    assert on_envelope(cell("rung 1", 1.0, 1e-2), cell("grid 0", 1.0, 1e-3)) == {"rung 1": False}


def test_rung_that_is_cheaper_or_better_or_nearly_as_good_stands():
    for rival in (cell("grid 0", 2.0, 1e-3), cell("grid 0", 0.1, 1e-1), cell("grid 0", 0.9, 1e-2)):
        assert on_envelope(cell("rung 1", 1.0, 1e-2), rival) == {"rung 1": True}


def test_differences_below_four_digits_do_not_count():
    assert on_envelope(cell("rung 1", 1.0, 5e-5), cell("grid 0", 1.0, 1e-8)) == {"rung 1": True}


def test_scenes_count_alike_whatever_they_cost():
    cells = [
        cell(place, cpu * scale, error, case)
        for case, scale in (("cheap", 1e-3), ("dear", 10.0))
        for place, cpu, error in (("rung 1", 2.0, 1e-2), ("grid 0", 1.0, 1e-2))
    ]
    (found,) = points(cells).values()
    rung, rival = found
    assert rung.cost / rival.cost == pytest.approx(2.0) and beats(rival, rung)


COLUMNS = ("t", "x", "y", "theta", "vx", "vy", "omega")


def run_executable(folder, cost: str):
    """Outcome, CPU time and off of an executable that prints the true motion and that line, after a sleep."""
    case = cases.load("disc_on_line[mu=0.1]")
    times = np.linspace(0.0, case.duration, 200)
    state = reference.simulate(case)(times)._asdict()
    np.savetxt(
        folder / "motion.csv", np.column_stack([times, *(state[name] for name in COLUMNS[1:])]), delimiter=",",
        header=",".join(COLUMNS), comments="",
    )  # fmt: skip
    engine = folder / "replaying"
    engine.write_text(f"#!/bin/sh\ncat {folder / 'motion.csv'}\necho '{cost}'\n")
    engine.chmod(0o755)
    return settings.run_setting(case, lookup.register(engine), "process", Setting.of(h=1e-2), find_truth(case))


def test_cost_of_an_executable_is_the_time_of_its_own_process(tmp_path, monkeypatch):
    monkeypatch.setenv(lookup.EXECUTABLES, "")
    outcome, seconds, off = run_executable(tmp_path, "# cost cpu_s=12.5 steps=199")
    assert (outcome, seconds) == ("answered", 12.5) and off < 1e-3


def test_executable_without_a_cost_has_no_place_in_the_comparison(tmp_path, monkeypatch):
    monkeypatch.setenv(lookup.EXECUTABLES, "")
    with pytest.raises(NotSupported, match="reports no CPU time"):
        run_executable(tmp_path, "")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["exudyn", "pymunk"])
def test_every_rung_of_the_native_ladders_lies_on_the_envelope_of_its_grid(name):
    with Calls() as calls:
        calls.ask_versions([name])
        cells = settings.run(Request(solvers=(name,)), calls)
    beaten = [row for row in settings.table(cells) if row["route"] == "native" and row["beaten_by"]]
    assert not beaten, beaten
