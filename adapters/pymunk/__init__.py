"""pymunk's adapter; `adapters.pymunk.adapter` says what it does."""

from .adapter import NAME, build, grid, ladder, read, refuses, routes, run, version, wide_grid

__all__ = ["NAME", "build", "grid", "ladder", "read", "refuses", "routes", "run", "version", "wide_grid"]
