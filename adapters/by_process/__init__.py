"""Engines of any language, as executables: a scene goes in on standard input, the motion comes back on standard output.

`docs/process_protocol.md` has the protocol, `scene.schema.json` beside this file the form of a scene.
"""

from .bundle import FOLDER, BundledEngine, bundled_engines
from .engine import Engine
from .scene import SCHEMA, VERSION, as_json, scene

__all__ = ["FOLDER", "SCHEMA", "VERSION", "Engine", "BundledEngine", "as_json", "scene", "bundled_engines"]
