"""Other people's engines on the suite's scenes: a module or a package per engine, which imports `cases` and
nothing else of ours but what engines share (`common`) and what an adapter is (`interface`)."""

from .interface import EngineFailure, Meaning, Setting, engine, engines, other_laws

__all__ = ["EngineFailure", "Meaning", "Setting", "engine", "engines", "other_laws"]
