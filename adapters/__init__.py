"""Other people's engines on the suite's scenes: one file per engine, which imports `cases` and nothing else of ours."""

from .interface import EngineFailure, Setting, engine, engines

__all__ = ["EngineFailure", "Setting", "engine", "engines"]
