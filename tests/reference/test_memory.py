"""Many scenes in one process: what is kept for the next one is bounded."""

import gc
from pathlib import Path

import pytest

import cases
import reference
from cases import Case, CoulombFriction, Curve, Gravity, Start, Unilateral, disc, library

# MB that a process may grow by once its caches are full: a tenth of what the second half would add at the least rate
# that a leak of one small object in each scene has been seen to have (0.02 MB), and above what allocators scatter.
GROWTH = 60.0


def resident() -> float:
    """MB of this process."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def parameters(i: int) -> None:
    reference.simulate(cases.load("disc_in_circle", mu=0.1 + 1e-6 * i), rtol=1e-6).transitions  # noqa: B018


def sizes(i: int) -> None:
    effects = (Gravity(9.81), CoulombFriction(0.2), Unilateral())
    made = Case(library.circle(1.0 + 1e-6 * i), disc(0.1 + 1e-7 * i, 1.0), effects, Start(-1.0), 0.3)
    reference.simulate(made, rtol=1e-6).transitions  # noqa: B018


def structures(i: int) -> None:
    # Whole numbers are part of a structure: each of these is derived and compiled anew.
    track = Curve(lambda s: (s, s**2 * (i + 2) / (i + 3)), (-1, 1))
    effects = (Gravity(9.81), CoulombFriction(0.2), Unilateral())
    reference.simulate(Case(track, disc(0.1, 1.0), effects, Start(-0.5), 0.1), rtol=1e-6).transitions  # noqa: B018


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="no /proc to read the process's size from")
@pytest.mark.slow
@pytest.mark.parametrize(
    "scene, first, count", [(parameters, 3000, 20_000), (sizes, 3000, 20_000), (structures, 280, 400)]
)
def test_a_process_does_not_grow_once_its_caches_are_full(scene, first, count):
    for i in range(first):
        scene(i)
    before = resident()
    for i in range(first, count):
        scene(i)
    assert resident() - before < GROWTH
