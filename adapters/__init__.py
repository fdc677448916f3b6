"""Adapters of physics engines to the suite's scenes: one module or package per engine.

An adapter imports `cases`, the code that engines share (`common`) and the definition of an adapter (`interface`), and
no other part of the suite.
"""

from .interface import (
    EngineFailure,
    Meaning,
    Refusal,
    Setting,
    other_laws,
    our_part,
    refusal,
    refusal_kind,
    refusal_of_several_contacts,
)
from .lookup import engine, engines

__all__ = [
    "EngineFailure",
    "Meaning",
    "Setting",
    "engine",
    "engines",
    "other_laws",
    "Refusal",
    "our_part",
    "refusal_kind",
    "refusal",
    "refusal_of_several_contacts",
]
