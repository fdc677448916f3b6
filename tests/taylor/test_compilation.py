"""What heyoka compiles: large systems without optimising, and nothing is left in the user's home."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import cases
import reference
from reference.minimal.integrators import taylor
from reference.minimal.modes import candidates, phase

pytestmark = pytest.mark.skipif(not taylor.AVAILABLE, reason="heyoka is not installed")


def test_nothing_is_left_in_the_home_folder(tmp_path):
    simulate = "import cases, reference; reference.simulate(cases.load('disc_in_circle'), method='taylor')"
    environment = {k: v for k, v in os.environ.items() if not k.startswith("XDG_")} | {"HOME": str(tmp_path)}
    subprocess.run(
        [sys.executable, "-c", simulate], cwd=Path(__file__).parent.parent.parent, env=environment, check=True
    )
    assert [file for file in tmp_path.rglob("*heyoka*") if file.is_file() or any(file.iterdir())] == []


def test_compiled_for_many_runs_a_motion_is_the_same_to_rounding_and_changes_no_other():
    case = cases.load("disc_in_cosine")
    before = reference.simulate(case)
    fast = reference.simulate(case, method="taylor_optimised")
    again = reference.simulate(case)
    # Both compute the same operations, fused differently.
    assert [t.time for t in fast.transitions] == pytest.approx([t.time for t in before.transitions], abs=1e-13)
    assert fast.x[-1] == pytest.approx(before.x[-1], abs=1e-13)
    assert [t.time for t in again.transitions] == [t.time for t in before.transitions]
    assert again.x.tolist() == before.x.tolist()
    system = phase(case, candidates(case)[0]).system
    level = taylor.integrators_of(system, taylor.tolerance_of(1e-10), float, True).call(
        lambda one: one.integrator.llvm_state.opt_level
    )
    assert level == 3
