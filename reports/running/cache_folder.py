"""The user's cache folder, which holds the environments of engine versions.

Code from it is executed. So the folder must belong to the user and be inaccessible to others; any other folder is not
used, and the log has one line about it. `SLIP_TO_ROLL_CACHE` names another folder, or is "off".
"""

from __future__ import annotations

import logging
import os
import stat
from functools import lru_cache
from pathlib import Path

VARIABLE = "SLIP_TO_ROLL_CACHE"
OFF = "off"


def place() -> Path | None:
    """The cache folder, created if it does not exist; None if there is no cache."""
    text = os.environ.get(VARIABLE)
    if text is None:
        above = os.environ.get("XDG_CACHE_HOME", "")
        text = str(Path(above if os.path.isabs(above) else "~/.cache") / "slip-to-roll")
    return None if text in (OFF, "") else _safe_folder(text)


@lru_cache(maxsize=8)
def _safe_folder(text: str) -> Path | None:
    """The folder if it is safe to use; else None, with one warning in the log."""
    folder = Path(text)
    try:
        folder = folder.expanduser().absolute()
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        # Check the folder itself, not the target of a link, which others might change.
        problem = _problem(folder.lstat())
    except (OSError, RuntimeError) as error:  # RuntimeError: a user without a home directory
        problem = str(error)
    if not problem:
        return folder
    logging.getLogger("reports").warning(
        "%s is not used (%s): give %s a folder of your own that nobody else can read, or %s",
        folder, problem, VARIABLE, OFF,
    )  # fmt: skip
    return None


def _problem(about: os.stat_result) -> str:
    """Why a folder is not private to the user, "" if it is."""
    if not stat.S_ISDIR(about.st_mode):
        return "it is not a folder"
    if not hasattr(os, "geteuid") or about.st_uid != os.geteuid():
        return "it belongs to another user"
    return "others have access to it" if about.st_mode & 0o077 else ""
