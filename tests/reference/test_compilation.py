"""What heyoka compiles: large systems without optimising, and nothing is left in the user's home."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import cases
from reference.minimal.integrators import taylor
from reference.minimal.modes import candidates, phase

pytestmark = pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")


@pytest.mark.parametrize(
    "name, optimised, level",
    [
        ("disc_on_line", False, 3),
        ("disc_in_circle", False, 0),
        ("ellipse_in_circle", False, 0),
        ("disc_in_circle", True, 3),
    ],
)
def test_small_systems_and_those_of_many_runs_are_optimised(name, optimised, level):
    case = cases.load(name)
    system = phase(case, candidates(case)[0]).system
    integrator = taylor.integrators_of(system, 1e-10, float, optimised).call(lambda one: one)
    assert integrator.llvm_state.opt_level == level


def test_in_quadruple_precision_nothing_is_written_out_nor_optimised():
    case = cases.load("disc_in_circle")
    integrator = taylor.integrators_of(
        phase(case, candidates(case)[0]).system, taylor.QUADRUPLE_TOLERANCE, taylor.hy.real128
    ).call(lambda one: one)
    assert integrator.compact_mode and integrator.llvm_state.opt_level == 0


def test_nothing_is_left_in_the_home_folder(tmp_path):
    simulate = "import cases, reference; reference.simulate(cases.load('disc_in_circle'), method='taylor')"
    environment = {k: v for k, v in os.environ.items() if not k.startswith("XDG_")} | {"HOME": str(tmp_path)}
    subprocess.run(
        [sys.executable, "-c", simulate], cwd=Path(__file__).parent.parent.parent, env=environment, check=True
    )
    assert [file for file in tmp_path.rglob("*heyoka*") if file.is_file() or any(file.iterdir())] == []


def test_the_users_own_setting_of_the_cache_stands():
    before = taylor.hy.llvm_state.get_diskcache_enabled()
    taylor._compile(phase(case := cases.load("disc_on_line"), candidates(case)[0]).system, 1e-9, float, True)
    assert taylor.hy.llvm_state.get_diskcache_enabled() == before
