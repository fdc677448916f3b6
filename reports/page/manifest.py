"""The software and hardware with which a report was made: versions, machine, commit."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from ..running.storage.fingerprint import installed_packages, processor
from ..running.storage.result_store import now

# Format of a report's tables and manifest. 1, without this number: up to version 0.1.0, with the outcomes right, wrong
# and refused, and accuracies in m and s. 2: answered runs with grades, levels of off.
FORMAT = 2
_ROOT = Path(__file__).resolve().parents[2]
_PACKAGES = ("numpy", "scipy", "sympy", "mpmath", "pandas", "matplotlib", "exudyn", "pymunk", "heyoka")
# Extras of the suite that a report may use.
_EXTRAS = ("taylor", "box2d", "bullet")


def manifest(versions: Mapping[str, str]) -> dict[str, Any]:
    """Versions, machine, commit and time. `versions`: of the solvers, "" if unknown."""
    return {
        "format": FORMAT,
        "made_at": now(),
        "python": sys.version.split()[0],
        "packages": {name: installed_packages(name) for name in _PACKAGES},
        "installed": _required_versions(),
        "solvers": {name: version or "unknown" for name, version in versions.items()},
        "machine": f"{platform.platform()}, {processor()}, {os.cpu_count()} cores",
        "commit": _commit(),
    }


def _required_versions() -> dict[str, str]:
    """Versions of all installed direct and indirect dependencies of the suite; empty if the suite itself is not
    installed."""
    package_versions: dict[str, str] = {}
    past: set[tuple[str, str]] = set()
    waiting = [("slip-to-roll", extra) for extra in ("", *_EXTRAS)]
    while waiting:
        name, extra = waiting.pop()
        try:
            package = distribution(name)
        except PackageNotFoundError:
            continue
        package_versions[canonicalize_name(name)] = package.version
        for requirement in map(Requirement, package.requires or ()):
            if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
                new_requirements = {(requirement.name, more) for more in ("", *requirement.extras)} - past
                past |= new_requirements
                waiting += new_requirements
    package_versions.pop("slip-to-roll", None)
    return dict(sorted(package_versions.items()))


def _commit() -> str:
    """The commit of this code, with "+" if files differ from it; "" if the code is not in its own repository."""
    try:
        if Path(_git("rev-parse", "--show-toplevel")).resolve() != _ROOT:
            return ""
        return _git("rev-parse", "HEAD") + ("+" if _git("status", "--porcelain", "--untracked-files=no") else "")
    except (OSError, subprocess.SubprocessError):
        return ""


def _git(*words: str) -> str:
    process = subprocess.run(["git", "-C", str(_ROOT), *words], capture_output=True, text=True, check=True, timeout=10)
    return process.stdout.strip()
