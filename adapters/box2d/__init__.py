"""Box2D's adapter; `adapters.box2d.adapter` describes it."""

from .adapter import NAME, ROUNDING, build, default_grid, grid, ladder, read, refuses, routes, run, version
from .meanings import MEANINGS

__all__ = [
    "MEANINGS",
    "NAME",
    "ROUNDING",
    "build",
    "default_grid",
    "grid",
    "ladder",
    "read",
    "refuses",
    "routes",
    "run",
    "version",
]
