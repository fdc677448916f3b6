"""Solvers by name: the reference and the engines. `solver` and `version` load an engine, so that they are called in
workers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, distribution, requires
from typing import Any

from packaging.requirements import Requirement

import adapters
from adapters.interface import ReturnsOnce, returns_once

from . import versions
from .processes import worker_process
from .records import REFERENCE, legible
from .storage import source_code

_LONGEST_VERSION = 100
# The worker groups of calls that name several engines, and of engines that are not installed.
_SEVERAL, _ABSENT = "several engines", "absent engines"


def names() -> tuple[str, ...]:
    """Every solver's name: the reference first, then the engines in alphabetical order. Loads none of them."""
    return (REFERENCE, *adapters.engines())


def solver(name: str) -> Any:
    """A solver by name, an engine or the reference; raises ImportError if it, or the version that its name asks for, is
    not installed."""
    if name == REFERENCE:
        from . import reference_adapter

        return ReturnsOnce(reference_adapter)  # like an engine, for the clock's sake
    if worker_process.group == "":
        raise RuntimeError(f"{name} is asked for in a worker whose calls load no engine")
    versions.demand(name)
    return ReturnsOnce(returns_once(adapters.engine)(versions.split_version(name)[0]))


# The outcome of an engine that is not there: it refuses nothing, and is counted nowhere.
NOT_INSTALLED = "not_installed"


def version(name: str) -> str:
    """The version of a solver; NOT_INSTALLED and what is missing if it is not there."""
    try:
        return legible(solver(name).version(), _LONGEST_VERSION)
    except ImportError as problem:
        return f"{NOT_INSTALLED}: {legible(problem.name or problem, _LONGEST_VERSION)}"


def is_missing(version: str) -> bool:
    """Whether what a solver said of its version says that it is not there."""
    return version.startswith(NOT_INSTALLED)


def groups_of(calls: Iterable[Iterable]) -> list[str]:
    """The worker group of each call, by the engines that its arguments name.

    Each engine, and each version of one, has its own workers, so that what it leaves in its process changes no digit of
    another. "" is for calls without engines. Engines that are not installed share a group, and so do calls that name
    several.
    """
    engines = names()[1:]

    def group(call: Iterable) -> str:
        named = sorted(named_in(call, lambda text: versions.split_version(text)[0] in engines))
        if len(named) == 1:
            return named[0] if is_installed(named[0]) else _ABSENT
        return _SEVERAL if named else ""

    return [group(call) for call in calls]


def named_in(arguments: Iterable, known: Callable[[str], bool]) -> set[str]:
    """The solvers that arguments name, within tuples and lists as well."""
    found: set[str] = set()
    for argument in arguments:
        if isinstance(argument, str) and known(argument):
            found.add(argument)
        elif isinstance(argument, tuple | list):
            found |= named_in(argument, known)
    return found


@lru_cache(maxsize=256)
def is_installed(name: str) -> bool:
    """Whether the package that an adapter names in `KNOWN` is installed here, or it names none; loads no engine."""
    engine, version = versions.split_version(name)
    try:
        package = source_code.literal_of(engine, "KNOWN")
        return bool(version) or not isinstance(package, str) or bool(distribution(Requirement(package).name))
    except PackageNotFoundError:
        return False
    except (SyntaxError, ValueError, LookupError, OSError, ImportError):  # its code cannot be read: it says so itself
        return True


def missing_words(versions: Mapping[str, str]) -> list[str]:
    """A line for each solver that is not there, and the command that adds those that are extras of this suite."""
    missing = {name: said.partition(": ")[2] for name, said in versions.items() if is_missing(said)}
    lines = [f"{name}: {NOT_INSTALLED} (it needs {needs})" for name, needs in missing.items()]
    packages = sorted({package for needs in missing.values() if (package := _package(needs))})
    if packages:
        lines.append(f"pip install {' '.join(packages)} adds {'them' if len(packages) > 1 else 'it'}")
    return lines


def _package(module: str) -> str:
    """The package of an extra of this suite that brings a module, "" if none does."""
    try:
        needs = requires("slip-to-roll") or []
    except PackageNotFoundError:
        return ""
    found = [re.fullmatch(r"([\w-]+).*;.*extra\s*==.*", need) for need in needs]
    own = {match[1].replace("-", "_"): match[1] for match in found if match}
    return own.get(module.partition(".")[0], "")


def routes(name: str) -> tuple[str, ...]:
    """The routes of a solver, () where its code does not say them; loads no engine.

    Raises ImportError if what the adapter imports is not installed, LookupError if it has no code to read.
    """
    return (
        tuple(map(str, solver(name).routes))
        if name == REFERENCE
        else source_code.routes_of(versions.split_version(name)[0])
    )
