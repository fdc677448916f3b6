"""The executables that come with the suite, in `adapters/executables`: each an engine by its short name.

With --version they print their engine's version, or end with the name of the package to install.
"""

from __future__ import annotations

import subprocess
from functools import lru_cache
from pathlib import Path

from cases import Case

from ..common.facets import facets_for, track_kind
from ..interface import Setting
from .engine import Engine

FOLDER = Path(__file__).parents[1] / "executables"
# The steps (s) that the engines themselves begin with: Drake's MultibodyPlantConfig.time_step, MuJoCo's option
# timestep, DART's World.getTimeStep, SAPIEN's PhysxCpuSystem.timestep; Rapier's IntegrationParameters.dt and planck's
# first example have a game's, and Siconos' example of a bouncing ball has 5 ms.
OWN_STEPS = {"drake": 1e-3, "mujoco": 2e-3, "dartpy": 1e-3, "physx": 1e-2, "siconos": 5e-3}
# The most facets of a curved track: each box costs time in every step, most of all in cannon-es, a corner of a chain
# none.
MOST_FACETS = 8000
# Engines that take the curve itself.
WITHOUT_FACETS = {"siconos"}
MOST_BOXES = {"cannon": 200, "dartpy": 800, "drake": 800, "matter": 800, "mujoco": 800, "newton": 3200}
# Engines that run outlines with corners. (The programs of planck.js and Rapier do so alone, with errors of first order;
# no report has compared them yet.)
WITH_CORNERS = {"mujoco"}
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

    def _with_facets(self, case: Case, setting: Setting) -> Setting:
        """The setting with a number of facets, if the track is curved and no whole circle."""
        if track_kind(case) != "chain" or self.NAME in WITHOUT_FACETS:
            return setting
        count = facets_for(case, None if setting.is_default else float(setting["h"]))
        return setting.but(facets=min(count, MOST_BOXES.get(self.NAME, MOST_FACETS)))

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
