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
# Lists of commands, and the program that checks proofs without the suite's code.
OTHER_PARSER = {"cases", "reports.cli", "reference.proof_checker.__main__"}
# What a command needs to run something. Each takes a good part of a second to import, so that help comes late.
SLOW = {"exudyn", "pymunk", "heyoka", "pybullet", "matplotlib", "pandas", "scipy", "sympy"}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_imports_nothing_slow_and_writes_nothing(command, tmp_path):
    output = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", command, "--help"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert re.search("python -m |slip-to-roll", output.stdout) and list(tmp_path.iterdir()) == []
    assert "--log-level" in output.stdout or command in OTHER_PARSER
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


def test_every_command_logs_at_the_level_asked_for(tmp_path):
    words = [sys.executable, "-m", "reports.cli", "cases", "export", "disc_on_line", "--out", str(tmp_path / "a")]
    info = subprocess.run([*words, "--log-level", "info"], capture_output=True, text=True, check=True)
    assert re.search("^reference: disc_on_line by .*: completed, 1 transitions, ", info.stderr, re.M)
    error = subprocess.run([*words, "--force", "--log-level", "error"], capture_output=True, text=True, check=True)
    assert error.stderr == ""


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
