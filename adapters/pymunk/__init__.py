"""pymunk's adapter; `adapters.pymunk.adapter` says what it does."""

from .adapter import NAME, build, grid, ladder, read, refuses, routes, run, stripped, version, wide_grid
from .meanings import MEANINGS

__all__ = [
    "MEANINGS", "NAME", "build", "grid", "ladder", "read", "refuses", "routes", "run", "stripped", "version",
    "wide_grid",
]  # fmt: skip
