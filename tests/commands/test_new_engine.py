"""A new engine: one file of at most 110 lines in a package of its own, which every command knows by its name."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from adapters.laws.__main__ import main

STARTER = Path(__file__).parents[2] / "starter" / "adapter.py"
MOST_LINES = 110
CASE = "disc_on_line[mu=0.1]"


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """A folder on the search path in which the starter is installed as another package's adapter, `my_engine`."""
    folder = tmp_path_factory.mktemp("packages")
    module = folder / "my_package"
    module.mkdir()
    (module / "__init__.py").touch()
    shutil.copy(STARTER, module / "adapter.py")
    metadata = folder / "my_package-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: my_package\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("[slip_to_roll.adapters]\nmy_engine = my_package.adapter\n")
    return folder


@pytest.fixture(scope="module")
def command(package):
    """Runs a command in which the package is installed; returns its exit status and its output."""

    def run(*words: str) -> tuple[int, str]:
        environment = os.environ | {"PYTHONPATH": str(package)}
        done = subprocess.run(
            [sys.executable, "-m", *words], capture_output=True, text=True, timeout=300, env=environment, cwd=package
        )
        return done.returncode, done.stdout + done.stderr

    return run


@pytest.fixture(scope="module")
def report(package, command) -> Path:
    words = ("--quick", "--case", CASE, "--solver", "reference", "my_engine", "--out", "report")
    status, output = command("reports.build", *words)
    assert status == 0, output
    return package / "report"


def rows(file: Path) -> list[dict[str, str]]:
    with open(file, newline="") as table:
        return [row for row in csv.DictReader(table) if "my_engine" in row.values()]


def test_it_is_one_file_of_at_most_110_lines():
    assert len(STARTER.read_text().splitlines()) <= MOST_LINES


def test_the_list_of_solvers_has_it_with_its_routes(command):
    status, output = command("reports.build", "--list")
    assert status == 0 and "my_engine: native" in output, output


def test_it_keeps_every_law_of_what_it_does_not_refuse(command):
    status, output = command("adapters.laws", "my_engine")
    last = output.splitlines()[-1]
    assert status == 0 and last.startswith("my_engine: ") and int(last.split()[1]) >= 3 and "kept" in last, output


def test_a_report_grades_it_and_has_it_in_its_tables(report):
    """Its steps are exact on a level line; the transition is within a step, which is excellent."""
    verdict, runs = rows(report / "tables" / "verdict.csv"), rows(report / "tables" / "trajectories.csv")
    assert [row["median_grade"] for row in verdict] == ["excellent"], verdict
    assert runs and {row["status"] for row in runs} == {"completed"}, runs


def test_two_reports_with_it_are_compared(report, command):
    status, output = command("reports.compare", str(report), str(report))
    assert status == 0, output


# --- a file, and mistakes ---------------------------------------------------------------------------------------------

TORQUE = "omega + push * r / inertia"


def test_a_wrong_one_is_told_which_law_and_by_how_much_and_which_it_does_not_support(tmp_path, capsys):
    assert TORQUE in (text := STARTER.read_text())
    (tmp_path / "theirs.py").write_text(text.replace(TORQUE, "omega + 0.9 * push * r / inertia"))
    assert main([str(tmp_path / "theirs.py"), "--law", "friction_torque", "rates_of_pose", "lift_off"]) == 1
    output = capsys.readouterr().out
    # Those that are refused for the same reason have one line.
    assert "\nnative  rates_of_pose (3 scenes), lift_off: refused: my_engine has discs on" in output
    assert output.endswith("my_engine: 4 refused, 1 broken\n")
    assert "friction_torque: broken: friction torque: the spin of a sliding disc is off by" in output


def test_engine_that_is_not_installed_says_so(tmp_path, capsys):
    (tmp_path / "absent.py").write_text("import no_such_engine\n")
    assert main([str(tmp_path / "absent.py")]) == 2
    assert "no_such_engine" in capsys.readouterr().err
