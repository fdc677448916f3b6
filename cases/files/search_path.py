"""Modules of the standard library come from the standard library, not from the user's working folder.

`python -m` searches the working folder first: a file queue.py there would be imported by other packages in place of
theirs. Each room imports this module first; worker processes inherit the order.
"""

from __future__ import annotations

import os
import sys

# The folder of the standard library, and that of its compiled modules.
_LIBRARY = os.path.dirname(os.__file__)
_STANDARD = (_LIBRARY, os.path.join(_LIBRARY, "lib-dynload"))


def after_standard_library(path: list[str], here: str) -> list[str]:
    """The search path with the working folder `here` behind the standard library, if it was the first entry."""
    last = max((place for place, entry in enumerate(path) if entry in _STANDARD), default=0)
    return [*path[1 : last + 1], path[0], *path[last + 1 :]] if path[:1] in ([here], [""]) else path


if sys.argv[:1] == ["-m"]:  # while `python -m` imports packages
    sys.path[:] = after_standard_library(sys.path, os.getcwd())
