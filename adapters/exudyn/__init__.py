"""Exudyn's adapter; `adapters.exudyn.adapter` says what it does."""

from .adapter import NAME, build, grid, ladder, read, refuses, routes, run, version
from .meanings import MEANINGS

__all__ = ["MEANINGS", "NAME", "build", "grid", "ladder", "read", "refuses", "routes", "run", "version"]
