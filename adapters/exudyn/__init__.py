"""Exudyn's adapter; `adapters.exudyn.adapter` describes it.

The engine is imported in its build without range checks, which is part of its wheel, and without the settings that a
user may have in the home folder. An exudyn that was imported before is not changed.
"""

import os
import sys
from contextlib import redirect_stdout
from io import StringIO

os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")
sys.exudynFast = True  # type: ignore[attr-defined]
with redirect_stdout(StringIO()):  # the import prints which build it is
    import exudyn as _  # noqa: F401

from .adapter import *  # noqa: E402, F403
from .adapter import __all__  # noqa: E402, F401
