"""Versions of an engine beside each other: the solver "pymunk@6.11.1" is pymunk's adapter with that version of it.

Each has an environment of its own, made once by venv and pip from the user's package index, in the user's own cache
folder, and kept. It holds the engine's package and borrows everything else from where the suite runs; the workers of
that version look into it first, and so differ in nothing but the engine. What is installed here already needs none.
"""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Callable, Iterable
from functools import lru_cache
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from pathlib import Path

from packaging.requirements import Requirement
from packaging.version import InvalidVersion, Version

from cases import BadValue, compile_cache, owned_folder
from cases.errors import UnknownName

from .records import REFERENCE, legible
from .storage import source_code

MARK = "@"
# Wall seconds in which pip answers: it fetches some megabytes and compiles nothing.
_PATIENCE = 300.0
# An index has a hundred versions of an engine; of those that are nearest so many are named.
_NAMED = 6


def split_version(name: str) -> tuple[str, str]:
    """A solver's engine and the version asked for, "" if none is."""
    engine, _, version = name.partition(MARK)
    return engine, version


@lru_cache(maxsize=64)
def needs(name: str) -> Requirement:
    """The package of a solver with a version, and that version.

    Raises BadValue, in one sentence, if it is no version, or none that its adapter knows.
    """
    engine, asked = split_version(name)
    if engine == REFERENCE:
        raise BadValue(f"{name}: the reference has one version, this suite's; leave out {MARK}{asked}")
    known = source_code.literal_of(engine, "KNOWN")
    if not isinstance(known, str):
        raise BadValue(f"{name}: the adapter of {engine} tells no versions that it knows; leave out {MARK}{asked}")
    try:
        version = Version(asked)
    except InvalidVersion:
        raise BadValue(f"{name}: {asked!r} is no version; the adapter of {engine} knows {known}") from None
    if not Requirement(known).specifier.contains(version, prereleases=True):
        raise BadValue(f"{name}: the adapter of {engine} knows {known}; ask for one of these")
    return Requirement(f"{Requirement(known).name}=={version}")


def check(name: str) -> None:
    """Raise BadValue, in one sentence, if a solver with a version cannot be asked for. Installs nothing."""
    package = needs(name)
    if not _is_here(package) and compile_cache.place() is None:
        raise BadValue(
            f"{name} needs an environment, and the cache is off; leave --no-cache out, and set "
            f"{compile_cache.VARIABLE} to a folder of your own"
        )


def make(names: Iterable[str], say: Callable[[str], None]) -> None:
    """Make the environments that solvers need and do not have, and say so; where one cannot be made, its solver says
    why when it is asked. Raises UnknownName for a version that the package index does not have."""
    for name in names:
        folder = _folder(name)
        if folder is None or _is_here(needs(name)):
            continue
        if folder.is_dir():
            say(f"{name}: its environment is taken from {folder}")
            continue
        say(f"{name}: its environment is made in {folder}, where it is kept; it may be deleted")
        problem = _make(needs(name), folder)
        if problem:
            owned_folder.write(_failure(folder), problem)
            say(f"{name} is not installed: {problem}")
        else:
            _failure(folder).unlink(missing_ok=True)


def paths(name: str) -> list[str]:
    """Where a process of a solver looks for packages first: its environment, if it has one."""
    folder = _folder(name)
    return [_packages(folder)] if folder is not None and folder.is_dir() else []


@lru_cache(maxsize=64)
def demand(name: str) -> None:
    """Raise ImportError unless this process finds the version that a solver's name asks for."""
    if split_version(name)[1] and not _is_here(needs(name)):
        folder = _folder(name)
        told = _failure(folder).read_text(encoding="utf-8") if folder and _failure(folder).is_file() else ""
        raise ImportError(f"{needs(name)}; {told or 'it has no environment'}")


# --- an environment ---------------------------------------------------------------------------------------------------


def _is_here(package: Requirement) -> bool:
    """Whether this process finds the package in the version wanted."""
    try:
        return package.specifier.contains(installed(package.name), prereleases=True)
    except PackageNotFoundError:
        return False


def _folder(name: str) -> Path | None:
    """The folder of a solver's environment, whether it is there or not; None if it has none to have.

    It borrows from the place where the suite runs, so that another place has another.
    """
    if not split_version(name)[1]:
        return None
    cache = compile_cache.place()
    if cache is None:
        return None
    package = str(needs(name)).replace("==", "-")
    place = hashlib.sha256("\n".join((sys.version, sys.prefix)).encode()).hexdigest()[:8]
    return cache / "versions" / f"{package}-{place}"


def _failure(folder: Path) -> Path:
    """The file that says why an environment could not be made."""
    return folder.with_name(f"{folder.name}.failed")


def _packages(folder: Path) -> str:
    return sysconfig.get_path("purelib", "venv", {"base": str(folder), "platbase": str(folder)})


def _make(package: Requirement, folder: Path) -> str:
    """Make an environment with a package, whole or not at all; why it could not be made, "" if it could."""
    try:
        folder.parent.mkdir(mode=0o700, exist_ok=True)
        owned_folder.remove_leftovers(folder.parent)
        with owned_folder.TemporaryFolder(folder.parent) as unfinished:
            made = unfinished / "made"
            venv.EnvBuilder(symlinks=True, with_pip=True).create(made)
            lenders = [path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")]
            Path(_packages(made), "borrowed.pth").write_text("\n".join(lenders) + "\n")
            words = ["install", "--only-binary=:all:", "--retries=1", "--no-input", str(package)]
            pip = subprocess.run(
                [made / "bin" / "python", "-m", "pip", *words],
                capture_output=True, text=True, errors="replace", timeout=_PATIENCE,
            )  # fmt: skip
            if pip.returncode:
                return _why(package, pip.stderr)
            if not folder.is_dir():  # another build may have been quicker
                made.rename(folder)
            return ""
    except subprocess.TimeoutExpired:
        return f"pip had not installed it after {_PATIENCE:g} s"
    except (OSError, subprocess.SubprocessError) as problem:
        return f"no environment could be made: {legible(problem)}"


def _why(package: Requirement, said: str) -> str:
    """Why pip failed, from what it said. Raises UnknownName if the index has other versions and not this."""
    found = re.search(r"\(from versions: ([^)]*)\)", said)
    others = [text for text in found[1].split(", ") if text not in ("", "none")] if found else []
    if others:
        (wanted,) = package.specifier
        near = sorted(others, key=lambda text: _apart(Version(text), Version(wanted.version)))[:_NAMED]
        raise UnknownName(
            f"the package index has no {package} for this Python; it has {', '.join(sorted(near, key=Version))}, …"
        )
    if re.search(r"Retrying \(|NewConnection|Connection(Reset|Refused)?Error|Max retries|getaddrinfo", said):
        return "the package index cannot be reached; connect, or set pip's index-url"
    lines = [line for line in said.splitlines() if line.startswith("ERROR")]
    return f"pip cannot install it: {legible((lines or said.splitlines() or ['it said nothing'])[-1])}"


def _apart(one: Version, other: Version) -> tuple[int, ...]:
    """How far versions are apart, part by part."""
    longest = max(len(one.release), len(other.release))
    parts = [(*v.release, *(0,) * (longest - len(v.release))) for v in (one, other)]
    return tuple(abs(a - b) for a, b in zip(*parts, strict=True))
