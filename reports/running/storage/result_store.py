"""Finished results on disk, one file each, so that a stopped build goes on where it was.

A file is a zip archive with `record.json` (key, time, the record) and the bytes of the record's arrays: no pickle, a
checksum on every part. It is whole or absent whenever a process ends, and two builds may use one store. (It is not
flushed to the disk: a loss of power may cut it short, and its checksums then show that.) A file that cannot be read
counts as absent.
"""

from __future__ import annotations

import io
import json
import os
import re
import zipfile
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import Any, TypeVar

from cases import owned_folder

from ..records import now
from .fingerprint import Key, digest
from .packing import pack, unpack

T = TypeVar("T")

# A dozen default reports; beyond it the results longest unused are removed.
BOUND_BYTES = 2 * 2**30
_FILE = re.compile(r"[a-z]+-[0-9a-f]{64}\.npz")
_FOREIGN = re.compile(rf"(?!({_FILE.pattern}|\.gitignore|\.slip-to-roll-.*)$).*")
_RECORD = "record.json"
# The largest record is a case's figures, some megabytes; a few kilobytes that unfold to gigabytes are none.
_MOST_BYTES = 2**28


class Store:
    """Results by kind ("run", "truth", "timing") and key in a folder. Never raises for what it finds there.

    `fresh`: nothing is taken from it. `folder=None`: nothing is kept.
    """

    def __init__(self, folder: Path | None, fresh: bool = False):
        self.folder, self.fresh = folder, fresh
        self._taken: Counter[str] = Counter()
        self._put: Counter[str] = Counter()
        self._oldest = ""
        self._unreadable: list[str] = []
        self._unwritten: list[str] = []
        self._used: set[Path] = set()

    def problem(self) -> str:
        """Why nothing can be kept here, in a sentence; "" if all is well. Makes the folder."""
        try:
            self._open()
            if self.folder is not None:
                owned_folder.TemporaryFolder(self.folder).remove()
        except OSError as problem:
            return f"what is finished cannot be kept: {_sentence(problem)}; give --store with another folder"
        return ""

    def get(self, kind: str, key: Key | None, record: type[T]) -> T | None:
        """The record of type `record` kept under a key; None if there is none to be had."""
        if self.folder is None or key is None or self.fresh:
            return None
        path = self._path(kind, key)
        try:
            told, arrays = _read(path)
            if told["key"] != key:
                raise ValueError("it is another's")
            found, when = unpack(record, told["record"], arrays), str(told["when"])
            with suppress(OSError):
                os.utime(path)  # what is used is not what is removed first
        except (FileNotFoundError, NotADirectoryError):
            return None
        except Exception as problem:  # damage can raise anything; it is counted and told, and the result made again
            self._unreadable.append(f"{path.name} ({_sentence(problem)})")
            return None
        self._taken[kind] += 1
        self._used.add(path)
        self._oldest = min(filter(None, (self._oldest, when)))
        return found

    def put(self, kind: str, key: Key | None, value: T, record: type[T]) -> None:
        """Keep a value of type `record`; where that fails, `trouble` says so."""
        if self.folder is None or key is None:
            return
        try:
            plain, arrays = pack(record, value)
            content = _archive({"key": key, "when": now(), "record": plain}, arrays)
            self._open()
            owned_folder.write(self._path(kind, key), content, durable=False)
            self._put[kind] += 1
            self._used.add(self._path(kind, key))
        except (OSError, ValueError) as problem:  # also what an adapter gave that no file can hold
            self._unwritten.append(_sentence(problem))

    def trim(self, bound: int = BOUND_BYTES) -> None:
        """Remove the results longest unused, but none of this build's, until the others fit in `bound` bytes."""
        if self.folder is not None:
            owned_folder.remove_longest_unused(self.folder, _FILE, bound, inf, self._used)

    def told(self) -> dict[str, Any]:
        """What a manifest says of it."""
        return {
            "taken": dict(self._taken),
            "oldest_taken": self._oldest,
            "kept": dict(self._put),
            "trouble": self.trouble(),
        }

    def taken_words(self) -> str:
        """How much of the build was taken from here."""
        if not self._taken:
            return "nothing was taken from the store"
        return f"{_count(self._taken)} taken from the store (since {self._oldest}), {_count(self._put)} made now"

    def kept_words(self) -> str:
        """What a build that stops now leaves."""
        kept = self._taken + self._put
        if not kept:
            return "nothing was finished that could be kept"
        command = "the same command" + (" without --fresh" if self.fresh else "")
        return f"{_count(kept)} kept in {self.folder}; {command} goes on from there"

    def size_words(self) -> str:
        """What it takes, and how to be rid of it."""
        size = sum(about.st_size for _, about in self._listed(_FILE))
        return f"{self.folder} holds {size / 1e6:.0f} MB and may be deleted; --fresh runs all anew"

    def trouble(self) -> list[str]:
        """A line for each kind of thing that went wrong, or lies in the folder and is none of the store's."""
        foreign = [path.name for path, _ in self._listed(_FOREIGN)]
        told = {
            "could not be read, and made again": self._unreadable,
            "could not be kept": self._unwritten,
            "not its own, and left alone": foreign,
        }
        return [f"{fate}: {len(what)}, such as {what[0]}" for fate, what in told.items() if what]

    def _open(self) -> None:
        if self.folder is not None and not self.folder.is_dir():
            self.folder.mkdir(parents=True, exist_ok=True)
            owned_folder.write(self.folder / ".gitignore", "*\n")  # not into a folder of the user's

    def _listed(self, name: re.Pattern[str]) -> list[tuple[Path, os.stat_result]]:
        return owned_folder.files_in(self.folder, name) if self.folder is not None else []

    def _path(self, kind: str, key: Key) -> Path:
        assert self.folder is not None
        return self.folder / f"{kind}-{digest(key)}.npz"


def _count(kinds: Counter[str]) -> str:
    return " and ".join(f"{n} {kind}{'s' * (n != 1)}" for kind, n in sorted(kinds.items())) or "nothing"


def _archive(told: Mapping[str, Any], arrays: Sequence[bytes]) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(_RECORD, json.dumps(told, ensure_ascii=False, indent=1))
        for place, array in enumerate(arrays):
            # As it is: to compress a run's numbers to two thirds takes twenty times as long.
            archive.writestr(zipfile.ZipInfo(str(place)), array)
    return content.getvalue()


def _read(path: Path) -> tuple[dict[str, Any], list[bytes]]:
    """What `_archive` was given; raises whatever a damaged file may raise."""
    with zipfile.ZipFile(path) as archive:
        # A member is read to the size that it claims, and no further.
        if sum(member.file_size for member in archive.infolist()) > _MOST_BYTES:
            raise ValueError(f"it claims to hold more than {_MOST_BYTES / 1e6:.0f} MB")
        # Each is read as a whole, so that its checksum is looked at.
        return json.loads(archive.read(_RECORD)), [archive.read(str(i)) for i in range(len(archive.namelist()) - 1)]


def _sentence(problem: Exception) -> str:
    return f"{type(problem).__name__}: {' '.join(str(problem).split())}"
