"""Solvers by name: the reference and the engines. What is here may load an engine, so that it is called in workers."""

from __future__ import annotations

from types import ModuleType

import adapters

from .records import REFERENCE


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
        return str(solver(name).version())
    except ImportError:
        return "not installed"


def routes(name: str) -> tuple[str, ...]:
    """The routes of a solver; raises ImportError if it is not installed."""
    return tuple(map(str, solver(name).routes))
