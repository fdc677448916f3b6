"""`slip-to-roll laws FILE`: the starter as somebody else's adapter, right and with a mistake."""

from __future__ import annotations

from pathlib import Path

import pytest

from adapters.laws.__main__ import main

STARTER = (Path(__file__).parents[2] / "starter" / "adapter.py").read_text(encoding="utf-8")
TORQUE = "omega + push * r / inertia"


@pytest.fixture
def adapter_file(tmp_path):
    def write(torque: str) -> str:
        assert TORQUE in STARTER
        path = tmp_path / "theirs.py"
        path.write_text(STARTER.replace(TORQUE, torque))
        return str(path)

    return write


def test_right_adapter_of_somebody_else_keeps_the_law(adapter_file, capsys):
    assert main([adapter_file(TORQUE), "--law", "friction_torque", "lift_off"]) == 0
    out = capsys.readouterr().out
    assert "native  friction_torque: kept" in out and "native  lift_off: refused: my_engine has discs on" in out
    assert out.endswith("my_engine: 1 kept, 1 refused\n")


def test_wrong_adapter_of_somebody_else_is_told_which_law_and_by_how_much(adapter_file, capsys):
    assert main([adapter_file("omega + 0.9 * push * r / inertia"), "--law", "friction_torque"]) == 1
    assert "friction_torque: broken: friction torque: the spin of a sliding disc is off by" in capsys.readouterr().out


def test_engine_that_is_not_installed_says_so(tmp_path, capsys):
    (tmp_path / "absent.py").write_text("import no_such_engine\n")
    assert main([str(tmp_path / "absent.py")]) == 2
    assert "no_such_engine" in capsys.readouterr().err
