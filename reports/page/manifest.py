"""What a report was made with: versions, machine, commit."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from ..running.fingerprint import installed, processor
from ..running.store import now

_ROOT = Path(__file__).resolve().parents[2]
_PACKAGES = ("numpy", "scipy", "sympy", "mpmath", "pandas", "matplotlib", "exudyn", "pymunk", "heyoka")
# What a report may be made with, of the suite's extras.
_EXTRAS = ("taylor", "box2d", "bullet")


def manifest(versions: Mapping[str, str]) -> dict[str, Any]:
    """Versions, machine, commit and time. `versions` are the solvers' own, "" where one could not tell."""
    return {
        "made_at": now(),
        "python": sys.version.split()[0],
        "packages": {name: installed(name) for name in _PACKAGES},
        "installed": needed(),
        "solvers": {name: told or "unknown" for name, told in versions.items()},
        "machine": f"{platform.platform()}, {processor()}, {os.cpu_count()} cores",
        "commit": _commit(),
    }


def needed(suite: str = "slip-to-roll", extras: Iterable[str] = _EXTRAS) -> dict[str, str]:
    """Versions of all that the suite needs here, and what that needs, as far as it is installed; none where the suite
    itself runs from a folder that was never installed."""
    found: dict[str, str] = {}
    asked: set[tuple[str, str]] = set()
    waiting = [(suite, extra) for extra in ("", *extras)]
    while waiting:
        name, extra = waiting.pop()
        try:
            told = distribution(name)
        except PackageNotFoundError:
            continue
        found[canonicalize_name(name)] = told.version
        for requirement in map(Requirement, told.requires or ()):
            if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
                of_it = {(requirement.name, more) for more in ("", *requirement.extras)} - asked
                asked |= of_it
                waiting += of_it
    found.pop(suite, None)
    return dict(sorted(found.items()))


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
