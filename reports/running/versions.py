"""Several versions of an engine: the solver "pymunk@6.11.1" is pymunk's adapter with that version of pymunk.

Each version has its own environment, made once by venv and pip from the user's package index and kept in the user's
cache folder. It contains the engine's package and uses all other packages of the suite's environment; the workers of
that version search it first, and so differ only in the engine. The installed version needs no environment.
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
from importlib.metadata import version as installed_version
from importlib.util import find_spec
from pathlib import Path

from packaging.requirements import Requirement
from packaging.version import InvalidVersion, Version

from cases import BadValue
from cases.errors import UnknownName, legible
from cases.files import owned_folder

from . import cache_folder
from .names import REFERENCE
from .storage import source_code

MARK = "@"
# Time limit for pip, wall seconds: it downloads some megabytes, and on request compiles one engine.
_PATIENCE = 300.0
# Number of nearest versions in a message; an index has a hundred versions of an engine.
_MOST_NAMES = 6


def split_version(name: str) -> tuple[str, str]:
    """A solver's engine and the version in its name; "" if there is none."""
    engine, _, version = name.partition(MARK)
    return engine, version


@lru_cache(maxsize=64)
def needs(name: str) -> Requirement:
    """The package of a solver with a version, as a requirement.

    Raises BadValue if the version is not valid or not supported by the adapter.
    """
    engine, number = split_version(name)
    if engine == REFERENCE:
        raise BadValue(f"{name}: the reference has one version, this suite's; leave out {MARK}{number}")
    requirement = source_code.literal_of(engine, "KNOWN")
    if not isinstance(requirement, str):
        raise BadValue(f"{name}: the adapter of {engine} lists no versions; leave out {MARK}{number}")
    try:
        version = Version(number)
    except InvalidVersion:
        raise BadValue(f"{name}: {number!r} is not a version; the adapter of {engine} supports {requirement}") from None
    if not Requirement(requirement).specifier.contains(version, prereleases=True):
        raise BadValue(f"{name}: the adapter of {engine} supports {requirement}; select one of these")
    return Requirement(f"{Requirement(requirement).name}=={version}")


def check(name: str) -> None:
    """Raise BadValue if a solver with a version cannot be used. Installs nothing."""
    package = needs(name)
    if not _is_here(package) and cache_folder.place() is None:
        raise BadValue(
            f"{name} needs an environment, and the cache is off; set {cache_folder.VARIABLE} to a folder of your own"
        )


def make(names: Iterable[str], say: Callable[[str], None], from_source: bool = False) -> None:
    """Make the environments that solvers need, and report it; if one cannot be made, its solver's rows have the reason.

    `from_source`: a version without a wheel for this Python is compiled. Raises UnknownName for a version that the
    package index does not have."""
    for name in names:
        folder = _folder(name)
        if folder is None or _is_here(needs(name)):
            continue
        if folder.is_dir():
            say(f"{name}: using its environment in {folder}")
            continue
        say(f"{name}: making its environment in {folder}; it may be deleted")
        problem = _make(needs(name), folder, from_source)
        if problem:
            owned_folder.write(_failure(folder), problem)
            say(f"{name} is not installed: {problem}")
        else:
            _failure(folder).unlink(missing_ok=True)


def failure(name: str) -> str:
    """Why a solver with a version has no environment; "" if it has one or needs none."""
    if _is_here(needs(name)) or paths(name):
        return ""
    folder = _folder(name)
    return (
        _failure(folder).read_text(encoding="utf-8")
        if folder and _failure(folder).is_file()
        else "it has no environment"
    )


def paths(name: str) -> list[str]:
    """Folders that a solver's process searches first for packages: its environment, if it has one."""
    folder = _folder(name)
    return [_packages(folder)] if folder is not None and folder.is_dir() else []


@lru_cache(maxsize=64)
def demand(name: str) -> None:
    """Raise ImportError unless this process finds the version in a solver's name."""
    if split_version(name)[1] and not _is_here(needs(name)):
        raise ImportError(f"{needs(name)}; {failure(name)}")


def releases(engine: str) -> tuple[str, ...]:
    """The versions of an engine's package that the package index has and the adapter supports, oldest first, without
    pre-releases; some may have no wheel for this Python.

    Raises BadValue if the adapter lists no versions, the index cannot be reached, or it has no such version.
    """
    text = source_code.literal_of(engine, "KNOWN")
    if not isinstance(text, str):
        raise BadValue(f"the adapter of {engine} lists no versions; it has no history")
    package = Requirement(text)
    pip = subprocess.run(
        [sys.executable, "-m", "pip", "index", "versions", "--retries=1", "--no-input", package.name],
        capture_output=True, text=True, errors="replace", timeout=_PATIENCE,
    )  # fmt: skip
    match = re.search(r"Available versions: (.*)", pip.stdout)
    if pip.returncode or not match:
        raise BadValue(f"the versions of {package.name} are not known: {_failure_of(pip.stderr)}")
    versions = {text for text in map(str.strip, match[1].split(",")) if package.specifier.contains(text)}
    if not versions:
        raise BadValue(f"the package index has no version of {text}")
    return tuple(sorted(versions, key=Version))


# --- an environment ---------------------------------------------------------------------------------------------------


def _is_here(package: Requirement) -> bool:
    """Whether this process finds the package in the required version."""
    try:
        return package.specifier.contains(installed_version(package.name), prereleases=True)
    except PackageNotFoundError:
        return False


def _folder(name: str) -> Path | None:
    """The folder of a solver's environment, existing or not; None if the solver has no version or the cache is off.

    The environment uses packages of the suite's environment, so that another one of the suite has another folder.
    """
    if not split_version(name)[1]:
        return None
    cache = cache_folder.place()
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


def _make(package: Requirement, folder: Path, from_source: bool) -> str:
    """Make an environment with a package, atomically; returns why that failed, "" on success."""
    try:
        folder.parent.mkdir(mode=0o700, exist_ok=True)
        owned_folder.remove_leftovers(folder.parent)
        with owned_folder.TemporaryFolder(folder.parent) as scratch:
            environment = scratch / "made"
            # The suite's pip installs into it; a copy of pip in each environment would take three times as long.
            pip_is_here = find_spec("pip") is not None
            venv.EnvBuilder(symlinks=True, with_pip=not pip_is_here).create(environment)
            lenders = [path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")]
            Path(_packages(environment), "borrowed.pth").write_text("\n".join(lenders) + "\n")
            wheels = "--prefer-binary" if from_source else "--only-binary=:all:"
            words = ["install", wheels, "--retries=1", "--no-input", str(package)]
            python = str(environment / "bin" / "python")
            pip_of = [sys.executable, "-m", "pip", "--python", python] if pip_is_here else [python, "-m", "pip"]
            pip = subprocess.run(
                [*pip_of, *words],
                capture_output=True, text=True, errors="replace", timeout=_PATIENCE,
            )  # fmt: skip
            if pip.returncode:
                return _why(package, pip.stderr)
            if not folder.is_dir():  # another build may have made it meanwhile
                environment.rename(folder)
            return ""
    except subprocess.TimeoutExpired:
        return f"pip had not installed it after {_PATIENCE:g} s"
    except (OSError, subprocess.SubprocessError) as problem:
        return f"no environment could be made: {legible(problem)}"


def _why(package: Requirement, output: str) -> str:
    """Why pip failed, from its output. Raises UnknownName if the index has only other versions."""
    match = re.search(r"\(from versions: ([^)]*)\)", output)
    others = [text for text in match[1].split(", ") if text not in ("", "none")] if match else []
    if others:
        (specifier,) = package.specifier
        near = sorted(others, key=lambda text: _apart(Version(text), Version(specifier.version)))[:_MOST_NAMES]
        raise UnknownName(
            f"the package index has no {package} for this Python; it has {', '.join(sorted(near, key=Version))}, …"
        )
    return _failure_of(output)


def _failure_of(output: str) -> str:
    """Why pip failed, other than for want of a version."""
    if re.search(r"Retrying \(|NewConnection|Connection(Reset|Refused)?Error|Max retries|getaddrinfo", output):
        return "the package index cannot be reached; connect, or set pip's index-url"
    lines = [line for line in output.splitlines() if line.startswith("ERROR")]
    return f"pip cannot install it: {legible((lines or output.splitlines() or ['it printed nothing'])[-1])}"


def _apart(one: Version, other: Version) -> tuple[int, ...]:
    """The distance of two versions, part by part."""
    longest = max(len(one.release), len(other.release))
    parts = [(*v.release, *(0,) * (longest - len(v.release))) for v in (one, other)]
    return tuple(abs(a - b) for a, b in zip(*parts, strict=True))
