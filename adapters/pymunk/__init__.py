"""pymunk's adapter; `adapters.pymunk.adapter` says what it does."""

from .adapter import NAME, build, grid, ladder, read, refuses, routes, run, stripped, version

__all__ = ["NAME", "build", "grid", "ladder", "read", "refuses", "routes", "run", "stripped", "version"]
