"""`python -m adapters.laws`: somebody else's adapter held to the laws, by name, file or module."""

from __future__ import annotations

import pytest

from adapters.laws.__main__ import main

ADAPTER = '''
"""A formula for a disc that slides on a level line; its torque is {torque} of what it should be."""
import numpy as np
from adapters import Setting
from cases import CoulombFriction, Gravity, Trajectory
from cases.contact import start_motion
from cases.curves.line_or_circle import as_line

NAME = "formula"
routes = ("native",)


def refuses(case, route):
    line = as_line(case.track)
    known = line and line.direction[1] == 0.0 and case.plate.radius and case.effect(CoulombFriction)
    return None if known and case.start.in_contact else "It knows level lines alone."


def ladder(case, route):
    return Setting.of(rung="defaults"), Setting.of(rung=1)


def build(case, route, setting):
    return case


def run(model):
    pass


def read(case):
    mu, g, start, plate = case.effect(CoulombFriction).mu, case.effect(Gravity).g, start_motion(case), case.plate
    t = np.linspace(0.0, case.duration, 1001)
    spin = {torque} * plate.mass * plate.radius / plate.inertia
    x, one = start.x + start.vx * t - 0.5 * mu * g * t**2, np.ones_like(t)
    vx, omega = start.vx - mu * g * t, -spin * mu * g * t
    push = plate.mass * g * one
    return Trajectory(t, x, start.y * one, -0.5 * spin * mu * g * t**2, vx, 0 * t, omega, vx + plate.radius * omega,
                      push, -mu * push, x, start.xi2 * one)


def version():
    return "1.0"
'''


@pytest.fixture
def adapter_file(tmp_path):
    def write(torque: float) -> str:
        path = tmp_path / f"formula_{str(torque).replace('.', '_')}.py"
        path.write_text(ADAPTER.format(torque=torque))
        return str(path)

    return write


def test_right_adapter_of_somebody_else_keeps_the_law(adapter_file, capsys):
    assert main([adapter_file(1.0), "--law", "friction_torque", "lift_off"]) == 0
    out = capsys.readouterr().out
    assert "native  friction_torque: kept" in out
    assert "native  lift_off: refused: It knows level lines alone." in out
    assert out.endswith("formula: 1 kept, 1 refused\n")


def test_wrong_adapter_of_somebody_else_is_told_which_law_and_by_how_much(adapter_file, capsys):
    assert main([adapter_file(0.9), "--law", "friction_torque"]) == 1
    assert "friction_torque: broken: friction torque: the spin of a sliding disc is off by" in capsys.readouterr().out


def test_engine_that_is_not_installed_says_so(tmp_path, capsys):
    (tmp_path / "absent.py").write_text("import no_such_engine\n")
    assert main([str(tmp_path / "absent.py")]) == 2
    assert "no_such_engine" in capsys.readouterr().err
