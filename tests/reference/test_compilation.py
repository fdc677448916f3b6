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
    integrator = taylor.integrators_of(phase(case, candidates(case)[0]).system, 1e-10).call(lambda one: one)
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


MOTIONS = """
import sys, cases, reference
from cases import compile_cache
for method in sys.argv[2:]:
    motion = reference.simulate(cases.load(sys.argv[1]), method=method)
    samples = b"".join(getattr(motion, q).tobytes() for q in ("t", "x", "omega", "normal_force")).hex()
    taken, made = compile_cache.counters()
    print(taken.total(), made.total(), samples)
"""


@pytest.mark.parametrize(
    "name, methods",
    [
        ("disc_in_circle", ("taylor",)),
        pytest.param("disc_in_circle", ("dop853",), marks=pytest.mark.slow),
        pytest.param("ellipse_in_circle", ("dop853",), marks=pytest.mark.slow),
    ],
)
def test_a_motion_is_the_same_to_its_last_bit_from_disk(tmp_path, name, methods):
    """Derived and compiled anew, and kept by one process for the next."""

    def motions(folder: str) -> list[tuple[int, int, str]]:
        environment = os.environ | {"SLIP_TO_ROLL_CACHE": folder}
        run = [sys.executable, "-c", MOTIONS, name, *methods]
        told = subprocess.run(run, env=environment, check=True, capture_output=True, text=True).stdout
        each = [line.split() for line in told.splitlines()]
        return [(int(taken), int(made), samples) for taken, made, samples in each]

    runs = zip(motions("off"), *(motions(str(tmp_path / "kept")) for _ in range(2)), strict=True)
    for method, (anew, first, second) in zip(methods, runs, strict=True):
        assert (anew[0], anew[1]) == (0, 0) and second[1] == 0, method
        # What others were compiled from (a decision's series) is not asked for again.
        assert first[1] > 0 and first[0] + first[1] >= second[0] > 0, method
        assert anew[2] == first[2] == second[2], method
