"""The wheel, and an environment that pip makes of it: nothing in it comes from where the sources are."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp

ROOT = Path(__file__).parents[2]
# Versions that were tried together: what is tested here is the wheel, not what was published since.
CONSTRAINTS = ROOT / "constraints" / "current.txt"
ROOMS = ("cases", "reference", "adapters", "reports")
# Of a command of the pages; the dearest, a study, takes some minutes.
MOST_SECONDS = 1800.0


@lru_cache(maxsize=1)
def wheel() -> Path:
    """The wheel, built from a copy of the sources so that nothing is left among them."""
    source, out = Path(mkdtemp(prefix="slip-to-roll-source-")), Path(mkdtemp(prefix="slip-to-roll-wheel-"))
    for room in ROOMS:
        shutil.copytree(ROOT / room, source / room, ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("pyproject.toml", "README.md", "LICENSE", "pytest_slip_to_roll.py"):
        shutil.copy(ROOT / file, source)
    build = f"from setuptools import build_meta; print(build_meta.build_wheel({str(out)!r}))"
    subprocess.run([sys.executable, "-c", build], cwd=source, check=True, capture_output=True)
    shutil.rmtree(source)
    (built,) = out.glob("*.whl")
    return built


class Environment:
    """An environment that holds the wheel and what pip installs with it from the package index."""

    def __init__(self, folder: Path, extras: str = "taylor"):
        self.folder = folder
        venv.create(folder, with_pip=True)
        words = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile", "-c", CONSTRAINTS]
        subprocess.run([folder / "bin" / "python", *words, f"{wheel()}[{extras}]"], check=True, env=self.variables())

    @classmethod
    def existing(cls, folder: Path) -> Environment:
        """One that has what is installed in it, and is left as it is."""
        environment = cls.__new__(cls)
        environment.folder = folder
        return environment

    def variables(self, **more: str) -> dict[str, str]:
        """The variables of a shell in which it is active."""
        outside = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
        return {**outside, "PATH": f"{self.folder / 'bin'}{os.pathsep}{os.environ['PATH']}", **more}

    def run(self, command: str, desk: Path, more: Mapping[str, str] | None = None) -> subprocess.CompletedProcess[str]:
        """A line of a shell, in a folder."""
        return subprocess.run(
            ["bash", "-c", command], cwd=desk, env=self.variables(**(more or {})), timeout=MOST_SECONDS,
            stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
        )  # fmt: skip
