"""The console command: the suite's commands under one name."""

import subprocess
import sys

import pytest

import cases
from reports import cli


def test_a_sub_command_is_its_module(capsys):
    assert cli.main(["compare", "disc_in_circle[mu=0.2]", "nowhere.csv"]) == 2
    assert "nowhere.csv" in capsys.readouterr().err
    assert cli.main(["cases"]) == 0
    assert "disc_in_circle" in capsys.readouterr().out


def test_a_wrong_word_is_told_the_right_one(capsys):
    assert cli.main(["repot"]) == 2
    assert capsys.readouterr().err == "slip-to-roll: there is no command 'repot'; did you mean report?\n"


def test_help_names_every_command(capsys):
    assert cli.main([]) == 0
    told = capsys.readouterr().out
    assert all(f"\n  {name} " in told for name in cli.COMMANDS)
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"slip-to-roll {cases.__version__}\n"


@pytest.mark.parametrize("name", [name for name, (module, _) in cli.COMMANDS.items() if module])
def test_completion_offers_the_options_that_help_tells(name):
    assert name in cli.following([])
    assert "--help" in cli.following([name, ""]) or name == "cases"


def test_completion_offers_cases_and_solvers():
    assert "disc_in_circle" in cli.following(["report", "--case"])
    assert {"reference", "pymunk"} <= set(cli.following(["report", "--solver"]))
    assert cli.following(["cases"]) == ["new", "check", "show", "export"]
    assert cli.following(["nonsense"]) == []


def test_bash_completes_a_word():
    """The printed function in a real bash, the command itself stood in for by this environment's."""
    script = cli._SHELLS["bash"].format(name="slip-to-roll")
    asked = f"""
slip-to-roll() {{ {sys.executable} -m reports.cli "$@"; }}
{script}
COMP_WORDS=(slip-to-roll com); COMP_CWORD=1; _slip_to_roll; echo "${{COMPREPLY[@]}}"
COMP_WORDS=(slip-to-roll report --case disc_in_cir); COMP_CWORD=3; _slip_to_roll; echo "${{COMPREPLY[@]}}"
"""
    told = subprocess.run(["bash", "-c", asked], capture_output=True, text=True, check=True).stdout.splitlines()
    assert told[0].split() == ["compare", "completion"]
    assert "disc_in_circle" in told[1].split()
