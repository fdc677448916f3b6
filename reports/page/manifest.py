"""What a report was made with: versions, machine, commit."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..running.fingerprint import installed, processor
from ..running.store import now

_ROOT = Path(__file__).resolve().parents[2]
_PACKAGES = ("numpy", "scipy", "sympy", "mpmath", "pandas", "matplotlib", "exudyn", "pymunk", "heyoka")


def manifest(versions: Mapping[str, str]) -> dict[str, Any]:
    """Versions, machine, commit and time. `versions` are the solvers' own, "" where one could not tell."""
    return {
        "made_at": now(),
        "python": sys.version.split()[0],
        "packages": {name: installed(name) for name in _PACKAGES},
        "solvers": {name: told or "unknown" for name, told in versions.items()},
        "machine": f"{platform.platform()}, {processor()}, {os.cpu_count()} cores",
        "commit": _commit(),
    }


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
