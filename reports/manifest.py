"""What a report was made with: versions, machine, commit."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from . import workers
from .trial import version as solver_version

_ROOT = Path(__file__).resolve().parent.parent
_PACKAGES = ("numpy", "scipy", "sympy", "mpmath", "pandas", "matplotlib", "exudyn", "pymunk", "heyoka")


def manifest(solvers: Sequence[str], jobs: int, limit: float) -> dict[str, Any]:
    """Versions, machine, commit and time; the solvers are asked for their versions in workers."""
    return {
        "made_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "python": sys.version.split()[0],
        "packages": {name: _installed(name) for name in _PACKAGES},
        "solvers": _versions(solvers, jobs, limit),
        "machine": f"{platform.platform()}, {_processor()}, {os.cpu_count()} cores",
        "commit": _commit(),
    }


def _installed(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _versions(solvers: Sequence[str], jobs: int, limit: float) -> dict[str, str]:
    told = dict.fromkeys(solvers, "")
    for index, answer in workers.run(solver_version, [(name,) for name in solvers], jobs, limit):
        told[solvers[index]] = answer.value if answer.outcome == "done" else f"unknown ({answer.reason})"
    return told


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _commit() -> str:
    """The commit this code is of, "" if it is not in a repository of its own; "+" if files differ from it."""
    try:
        if Path(_git("rev-parse", "--show-toplevel")).resolve() != _ROOT:
            return ""
        return _git("rev-parse", "HEAD") + ("+" if _git("status", "--porcelain", "--untracked-files=no") else "")
    except (OSError, subprocess.SubprocessError):
        return ""


def _git(*words: str) -> str:
    done = subprocess.run(["git", "-C", str(_ROOT), *words], capture_output=True, text=True, check=True, timeout=10)
    return done.stdout.strip()
