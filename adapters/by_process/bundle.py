"""The executables that come with the suite, in `adapters/executables`: each an engine by its short name.

Asked with --version they tell their engine's version, or end with what has to be installed.
"""

from __future__ import annotations

import subprocess
from functools import lru_cache
from pathlib import Path

from .engine import Engine

FOLDER = Path(__file__).parents[1] / "executables"
# The steps (s) that the engines themselves begin with: Drake's MultibodyPlantConfig.time_step, MuJoCo's option
# timestep, DART's World.getTimeStep; Rapier's IntegrationParameters.dt and planck's first example have a game's.
OWN_STEPS = {"drake": 1e-3, "mujoco": 2e-3, "dartpy": 1e-3}
# Seconds in which an engine has to tell its version; importing one takes a few where the disk is cold.
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
        """The step (s) of the engine as it comes."""
        return OWN_STEPS.get(self.NAME, super().own_step())

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
