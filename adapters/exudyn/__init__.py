"""Exudyn's adapter; `adapters.exudyn.adapter` says what it does.

The engine is imported as a study would: its build without range checks, which its own wheel brings, and without the
settings that a user may keep in the home folder. An exudyn that was imported before stays as it is.
"""

import os
import sys
from contextlib import redirect_stdout
from io import StringIO

os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")
sys.exudynFast = True  # type: ignore[attr-defined]
with redirect_stdout(StringIO()):  # it says which build it is
    import exudyn as _  # noqa: F401

from .adapter import NAME, build, grid, ladder, read, refuses, routes, run, version, wide_grid  # noqa: E402
from .meanings import MEANINGS  # noqa: E402

__all__ = ["MEANINGS", "NAME", "build", "grid", "ladder", "read", "refuses", "routes", "run", "version", "wide_grid"]
