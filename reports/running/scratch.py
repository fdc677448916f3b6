"""Files and folders that a process needs for a while: locked while it lives, so that what it left when it was killed is
told from what another one is at, and removed.

The lock is the system's (flock) and ends with the process, however it ends. POSIX only. Where a file system has no
locks nothing is locked, and only what is older than a day is removed.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

# What cannot be locked is somebody's as long as it is younger than this (s): no build takes a day.
_LEFT_BEHIND = 86400.0


class Folder:
    """A new folder of a name that begins and ends so, in a given folder (the system's temporary one), locked."""

    def __init__(self, prefix: str, suffix: str = "", inside: Path | None = None):
        while True:
            self.path = Path(tempfile.mkdtemp(prefix=prefix, suffix=suffix, dir=inside))
            self._lock = _locked(self.path)
            if self.path.exists():  # another process may have swept it before it was locked
                return

    def remove(self) -> None:
        """Remove the folder, if it is still there, and its lock."""
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


def sweep(found: Iterable[Path]) -> None:
    """Remove those of the files and folders that are this user's and that no living process has locked."""
    for path in found:
        with suppress(OSError):  # it is gone meanwhile, or cannot be removed: it harms nobody
            if path.is_symlink() or path.stat().st_uid != os.getuid():
                continue
            lock = os.open(path, os.O_RDONLY)
            try:
                if _free(lock, path):
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
            finally:
                os.close(lock)


def lock(file: int) -> None:
    """Lock an open file as long as it is open here; nothing where the file system has no locks."""
    with suppress(OSError):
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _locked(folder: Path) -> int | None:
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return None
    lock(handle)
    return handle


def _free(handle: int, path: Path) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return time.time() - path.stat().st_mtime > _LEFT_BEHIND
    return True
