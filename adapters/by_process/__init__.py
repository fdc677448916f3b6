"""Engines as executables, in any language: they read a scene on standard input and write the motion to standard output.

`docs/process_protocol.md` describes the protocol, `scene.schema.json` in this folder the format of a scene.
"""

from .bundle import FOLDER, BundledEngine, adapter_of, bundled_engines
from .engine import Engine
from .scene_file import SCHEMA, VERSION, as_json, scene

__all__ = [
    "FOLDER",
    "SCHEMA",
    "VERSION",
    "Engine",
    "BundledEngine",
    "adapter_of",
    "as_json",
    "bundled_engines",
    "scene",
]
