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


@pytest.mark.parametrize("name, level", [("disc_in_circle", 3), ("disc_on_line", 3), ("ellipse_in_circle", 0)])
def test_small_systems_are_optimised_and_large_ones_are_not(name, level):
    case = cases.load(name)
    integrator = taylor.compiled(phase(case, candidates(case)[0]).system, 1e-10)
    assert integrator.llvm_state.opt_level == level


def test_nothing_is_left_in_the_home_folder(tmp_path):
    simulate = "import cases, reference; reference.simulate(cases.load('disc_in_circle'), method='taylor')"
    environment = {k: v for k, v in os.environ.items() if not k.startswith("XDG_")} | {"HOME": str(tmp_path)}
    subprocess.run(
        [sys.executable, "-c", simulate], cwd=Path(__file__).parent.parent.parent, env=environment, check=True
    )
    assert [file for file in tmp_path.rglob("*heyoka*") if file.is_file() or any(file.iterdir())] == []


def test_the_users_own_setting_of_the_cache_stands():
    before = taylor.hy.llvm_state.get_diskcache_enabled()
    taylor.compiled.__wrapped__(phase(case := cases.load("disc_on_line"), candidates(case)[0]).system, 1e-9)
    assert taylor.hy.llvm_state.get_diskcache_enabled() == before
