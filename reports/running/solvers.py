"""Solvers by name: the reference and the engines. `solver` and `version` load an engine, so that they are called in
workers."""

from __future__ import annotations

from types import ModuleType

import adapters

from . import code
from .records import REFERENCE, legible

_LONGEST_VERSION = 100


def names() -> tuple[str, ...]:
    """Every solver's name: the reference first, then the engines in alphabetical order. Loads none of them."""
    return (REFERENCE, *adapters.engines())


def solver(name: str) -> ModuleType:
    """A solver by name, an engine or the reference; raises ImportError if it is not installed."""
    if name == REFERENCE:
        from . import reference_adapter

        return reference_adapter
    return adapters.engine(name)


def version(name: str) -> str:
    """The version of a solver."""
    try:
        return legible(solver(name).version(), _LONGEST_VERSION)
    except ImportError:
        return "not installed"


def routes(name: str) -> tuple[str, ...]:
    """The routes of a solver, () where its code does not say them; loads no engine.

    Raises ImportError if what the adapter imports is not installed, LookupError if it has no code to read.
    """
    return tuple(map(str, solver(name).routes)) if name == REFERENCE else code.routes_of(name)
