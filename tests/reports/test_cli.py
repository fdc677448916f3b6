"""The console command: the suite's commands under one name."""

from pathlib import Path

import pytest

import cases
from reports import cli


def test_help_names_every_command(capsys):
    assert cli.main([]) == 0
    output = capsys.readouterr().out
    assert all(f"\n  {name} " in output for name in cli.COMMANDS)
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"slip-to-roll {cases.__version__}\n"


def test_every_command_of_the_suite_is_a_subcommand():
    root = Path(cli.__file__).parents[1]
    modules = {
        f"{file.parent.name}.{file.stem}"
        for file in (root / "reports").glob("*.py")
        if 'if __name__ == "__main__"' in file.read_text() and file.stem not in ("cli", "show", "export")
    }
    assert modules <= {*cli._MODULES.values()}  # show and export are `cases show` and `export`


@pytest.mark.parametrize(("old", "new"), cli.ALIASES.items())
def test_an_older_name_is_the_command_of_its_newer_one(old, new, monkeypatch):
    calls = []
    monkeypatch.setattr(cli, "_run", lambda name, words: calls.append((name, [*words])) or 0)
    assert cli.main([old, "--help"]) == cli.main([*new.split(), "--help"]) == 0
    assert calls == [(new, ["--help"])] * 2 and new in cli.COMMANDS


def test_the_citation_is_of_the_version_that_runs(capsys):
    assert cli.main(["cite"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("@software{slip_to_roll,") and f"version = {{{cases.__version__}}}" in out
    assert out.count("{") == out.count("}") and "@misc{ogaru_pandrea," in out
