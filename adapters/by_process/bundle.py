"""The executables that come with the suite, in `adapters/executables`: each an engine by its short name.

With --version they print their engine's version, or end with the name of the package to install.
"""

from __future__ import annotations

import subprocess
from functools import lru_cache
from itertools import product
from pathlib import Path

from cases import Case

from ..common.facets import stretch, track_kind
from ..interface import Setting
from .engine import Engine

FOLDER = Path(__file__).parents[1] / "executables"
# The steps (s) that the engines themselves begin with: Drake's MultibodyPlantConfig.time_step, MuJoCo's option
# timestep, DART's World.getTimeStep, SAPIEN's PhysxCpuSystem.timestep; Rapier's IntegrationParameters.dt and planck's
# first example have a game's, and Siconos' example of a bouncing ball has 5 ms.
OWN_STEPS = {"drake": 1e-3, "mujoco": 2e-3, "dartpy": 1e-3, "physx": 1e-2, "siconos": 5e-3}
# The facets of a curved track are as long as the plate's displacement in a step, by the rule of the adapters of pymunk
# and Box2D, and not more than these: each box costs time in every step, most of all in cannon-es, a corner of a chain
# none. The engine's default settings have the facets of a first-time user, as pymunk's.
MODEST, MOST_FACETS = 64, 8000
# Engines that take the curve itself.
WITHOUT_FACETS = {"siconos"}
MOST_BOXES = {"cannon": 200, "dartpy": 800, "drake": 800, "matter": 800, "mujoco": 800, "newton": 3200}
# Engines that run outlines with corners. (The programs of planck.js and Rapier do so alone, with errors of first order;
# no report has compared them yet.)
WITH_CORNERS = {"mujoco"}
# The knobs of an engine besides the step and the facets, for the study of settings; the first values are the ladder's.
KNOBS: dict[str, dict[str, tuple[float | str, ...]]] = {
    "cannon": {"iterations": (50, 10)},
    "dartpy": {"solver": ("dantzig", "pgs", "nsgs"), "split_impulse": ("off", "on")},
    "drake": {"approximation": ("tamsi", "similar", "lagged"), "stiction": (1e-5, 1e-4)},
    "jolt": {"slop": (1e-6, 1e-4), "iterations": (20, 10)},
    "matter": {"velocity_iterations": (10, 4)},
    "mujoco": {"integrator": ("RK4", "Euler", "implicitfast"), "timeconst": (2, 4)},
    "newton": {"solver": ("xpbd", "semi_implicit", "vbd"), "iterations": (4, 20)},
    "physx": {"solver": ("pgs", "tgs"), "iterations": (10, 40)},
    "planck": {"iterations": (8, 20)},
    "rapier": {"iterations": (16, 4)},
    "siconos": {"theta": (0.5, 0.75, 1.0)},
}
# Steps (s) of that study.
GRID_STEPS = (4e-3, 2e-3, 1e-3)
# Time limit (s) for printing the version; importing an engine takes a few seconds where the disk cache is empty.
MOST_SECONDS = 60.0


def bundled_engines() -> dict[str, Path]:
    """The executables by name."""
    return {path.stem: path for path in sorted(FOLDER.iterdir()) if path.is_file() and _is_engine(path)}


def adapter_of(path: Path) -> Engine:
    """The adapter of an executable: of one of the suite's, or of another file."""
    return (BundledEngine if path.resolve().parent == FOLDER else Engine)(path)


def _is_engine(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(2) == b"#!"


class BundledEngine(Engine):
    """The adapter of one of them; raises ImportError, with what to install, if its engine is not there."""

    def __init__(self, path: Path):
        super().__init__(path)
        self._version = version_of(self.path)
        if self.NAME not in WITH_CORNERS:
            words = Engine.CAPABILITIES["process"]
            self.CAPABILITIES = {"process": tuple(word for word in words if word != "corners")}

    @staticmethod
    def runs(path: Path) -> bool:
        """Any file of the folder: a wheel keeps no Python file executable."""
        return path.is_file()

    @staticmethod
    def command(path: Path) -> list[str]:
        """What its first line says."""
        first = path.read_text(encoding="utf-8").partition("\n")[0]
        return [*first.removeprefix("#!").split(), str(path)]

    def own_step(self) -> float:
        """The engine's default step (s)."""
        return OWN_STEPS.get(self.NAME, super().own_step())

    def ladder(self, case: Case, route: str) -> tuple[Setting, ...]:
        """Steps from coarse to fine, with as many facets as each step needs; the engine's default settings first."""
        return tuple(self._with_facets(case, setting) for setting in super().ladder(case, route))

    def wide_grid(self, case: Case, route: str) -> tuple[Setting, ...]:
        """Every combination of three steps, three numbers of facets and the engine's own knobs."""
        knobs = KNOBS.get(self.NAME, {})
        curved = track_kind(case) == "chain"
        shares = (0.25, 1.0, 4.0) if curved else (1.0,)
        settings = (
            self._with_facets(case, Setting.of(h=h, **dict(zip(knobs, values, strict=True))), share)
            for h, share, values in product(GRID_STEPS, shares, product(*knobs.values()))
        )
        return tuple(dict.fromkeys(settings))  # at the least and the most facets two shares agree

    def _with_facets(self, case: Case, setting: Setting, share: float = 1.0) -> Setting:
        """The setting with a number of facets, if the track is curved and no whole circle."""
        if track_kind(case) != "chain" or self.NAME in WITHOUT_FACETS:
            return setting
        part, most = stretch(case), MOST_BOXES.get(self.NAME, MOST_FACETS)
        way = part.top_speed * float(setting["h"])
        count = MODEST if setting.is_default or not way else round(share * part.length / way)
        return setting.but(facets=min(max(count, MODEST), most))

    def version(self) -> str:
        """The engine's own version, and the digest of the file."""
        return f"{self._version}, {super().version()}"


@lru_cache
def version_of(path: Path) -> str:
    """What an executable says of its version; raises ImportError."""
    try:
        process = subprocess.run(
            [*BundledEngine.command(path), "--version"], capture_output=True, text=True, timeout=MOST_SECONDS
        )
    except (OSError, subprocess.TimeoutExpired) as problem:
        raise ImportError(f"{path.stem} cannot be started: {problem}", name=path.stem) from problem
    if process.returncode:
        last = process.stderr.strip().rpartition("\n")[2]
        raise ImportError(last or f"{path.stem} does not start", name=path.stem)
    return process.stdout.strip()
