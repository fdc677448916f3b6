"""Solvers by name: the reference and the engines. `solver` and `version` load an engine, so that they are called in
workers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, requires
from typing import Any

import adapters
from adapters.interface import ReturnsOnce, returns_once

from . import code, versions
from .records import REFERENCE, legible

_LONGEST_VERSION = 100


def names() -> tuple[str, ...]:
    """Every solver's name: the reference first, then the engines in alphabetical order. Loads none of them."""
    return (REFERENCE, *adapters.engines())


def solver(name: str) -> Any:
    """A solver by name, an engine or the reference; raises ImportError if it, or the version that its name asks for, is
    not installed."""
    if name == REFERENCE:
        from . import reference_adapter

        return ReturnsOnce(reference_adapter)  # like an engine, for the clock's sake
    versions.demand(name)
    return ReturnsOnce(returns_once(adapters.engine)(versions.parted(name)[0]))


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
    return tuple(map(str, solver(name).routes)) if name == REFERENCE else code.routes_of(versions.parted(name)[0])
