"""Other people's engines on the suite's scenes: a module or a package per engine, which imports `cases` and
nothing else of ours but what engines share (`common`) and what an adapter is (`interface`)."""

from .interface import EngineFailure, Setting, engine, engines

__all__ = ["EngineFailure", "Setting", "engine", "engines"]
