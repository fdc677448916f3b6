"""One parser for all commands: help imports nothing slow and writes nothing, nonsense is refused in one sentence."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from cases.files.command_line import status
from reports import animate, build, cli, deposit, options, show, sweep

ROOT = Path(__file__).parents[2]
# As the argument of `python -m`; "" has no module.
COMMANDS = sorted({module for module, _ in cli.COMMANDS.values()} - {"", "cases.commands"} | {"cases", "reports.cli"})
# What a command needs to run something. Each takes a good part of a second to import, so that help comes late.
SLOW = {"exudyn", "pymunk", "heyoka", "pybullet", "matplotlib", "pandas", "scipy", "sympy"}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_imports_nothing_slow_and_writes_nothing(command, tmp_path):
    output = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", command, "--help"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert re.search("python -m |slip-to-roll", output.stdout) and list(tmp_path.iterdir()) == []
    imported = {line.rpartition("|")[2].strip().partition(".")[0] for line in output.stderr.splitlines()}
    assert not imported & SLOW


def show_main(words) -> int:
    return status("cases", show.run, words)


@pytest.mark.parametrize(("main", "kind"), [(show_main, "FILE"), (animate.main, "FILE"), (deposit.main, "FILE"),
                                            (build.main, "DIR"), (sweep.main, "DIR")])  # fmt: skip
def test_help_says_whether_out_is_a_file_or_a_folder(main, kind, capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    assert re.search(rf"--out {kind} +f(ile|older) to write", capsys.readouterr().out)


def test_an_option_means_the_same_in_every_command():
    assert all(set(how) <= {"metavar", "nargs", "action", "default", "help"} for how in options._OPTIONS.values())
    many = options.parser("x", "", "solver", "jobs").parse_args(["--solver", "a", "b", "--solver", "c"])
    assert (many.solver, many.jobs) == (["a", "b", "c"], options._OPTIONS["jobs"]["default"])


# --- cases made by hand -----------------------------------------------------------------------------------------------

SCRIPT = """
from cases import Case, CoulombFriction, Gravity, Start, Unilateral, disc
from cases.library import line
from cases.files.command_line import status
from reports.build import report

print("begins")
effects = (Gravity(9.81), CoulombFriction(0.2), Unilateral())
made = [
    # The second bears the name of a case of the catalogue, and is another.
    Case(line(), disc(0.1, 1.0), effects, Start(0.0, slip=v), 0.5, name=name)
    for name, v in (("bowled_by_hand", 1.0), ("disc_on_line", 0.8))
]
print(report(made, solvers=["reference", "pymunk"], out="report", effort="quick"))
"""


@pytest.mark.slow
def test_cases_made_by_hand_in_a_script_are_reported(tmp_path):
    import pandas as pd

    (tmp_path / "script.py").write_text(SCRIPT)
    output = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True,
    )  # fmt: skip
    assert output.returncode == 0, output.stderr
    assert output.stdout.startswith("begins\n") and output.stdout.count("begins") == 1
    assert output.stdout.endswith(f"{tmp_path}/report/index.html\n")
    rows = pd.read_csv(tmp_path / "report" / "tables" / "transitions.csv")
    for name, v in (("bowled_by_hand", 1.0), ("disc_on_line", 0.8)):
        own = rows[(rows.case == name) & (rows.solver == "reference")]
        assert own.reference_time.to_numpy() == pytest.approx(v / (3 * 0.2 * 9.81), abs=1e-12)
    assert set(rows.solver) == {"reference", "pymunk"}
