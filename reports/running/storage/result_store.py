"""The store of finished results on disk, one file each, from which a stopped build continues.

A file is a zip archive with `record.json` (key, time, record) and the bytes of the record's arrays: no pickle, a
checksum for every part. Files are written atomically, and two builds may use one store. (They are not flushed to the
disk: a power failure may truncate a file, which its checksums then show.) A file that cannot be read counts as absent.
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
from pathlib import Path
from typing import Any, TypeVar

from cases import UnknownName
from cases.files import owned_folder, user_files

from ..records import now
from .fingerprint import Key, digest
from .packing import pack, unpack

T = TypeVar("T")

# Size limit: a dozen default reports. Beyond it the least recently used results are removed.
BOUND_BYTES = 2 * 2**30
_FILE = re.compile(r"[a-z]+-[0-9a-f]{64}\.npz")
_FOREIGN = re.compile(rf"(?!({_FILE.pattern}|\.gitignore|\.slip-to-roll-.*)$).*")
_RECORD = "record.json"
# Size limit of an unpacked file in bytes. The largest record, a case's figures, has some megabytes.
_MOST_BYTES = 2**28


class Store:
    """Results by kind ("run", "truth", "timing") and key in a folder. The folder's content never raises an error.

    `fresh`: nothing is read from it. `folder=None`: nothing is stored.
    """

    def __init__(self, folder: Path | None, fresh: bool = False):
        self.folder, self.fresh = folder, fresh
        self._reuse_counts: Counter[str] = Counter()
        self._write_counts: Counter[str] = Counter()
        self._oldest = ""
        self._read_errors: list[str] = []
        self._write_errors: list[str] = []
        self._used: set[Path] = set()

    def problem(self) -> str:
        """Why nothing can be stored here, as a sentence; "" if it can. Creates the folder."""
        try:
            self._open()
            if self.folder is not None:
                owned_folder.TemporaryFolder(self.folder).remove()
        except OSError as problem:
            return f"finished results cannot be stored: {_sentence(problem)}; give --store with another folder"
        return ""

    def get(self, kind: str, key: Key | None, record: type[T]) -> T | None:
        """The stored record of type `record` with that key; None if there is none."""
        if self.folder is None or key is None or self.fresh:
            return None
        path = self._path(kind, key)
        try:
            data, arrays = _read(path)
            if data["key"] != key:
                raise ValueError("it has another key")
            value, when = unpack(record, data["record"], arrays), unpack(str, data["when"], ())
            if not when.isprintable():
                raise ValueError("its time is no text that a command writes")
            with suppress(OSError):
                os.utime(path)  # marks the file as used recently
        except UnknownName:
            return None
        except Exception as problem:  # damage can raise anything; it is reported
            self._read_errors.append(f"{path.name} ({_sentence(problem)})")
            return None
        self._reuse_counts[kind] += 1
        self._used.add(path)
        self._oldest = min(filter(None, (self._oldest, when)))
        return value

    def put(self, kind: str, key: Key | None, value: T, record: type[T]) -> None:
        """Store a value of type `record`; `trouble` reports a failure."""
        if self.folder is None or key is None:
            return
        try:
            plain, arrays = pack(record, value)
            content = _archive({"key": key, "when": now(), "record": plain}, arrays)
            self._open()
            owned_folder.write(self._path(kind, key), content, durable=False)
            self._write_counts[kind] += 1
            self._used.add(self._path(kind, key))
        except (OSError, ValueError) as problem:  # also an adapter's value that no file can contain
            self._write_errors.append(_sentence(problem))

    def trim(self, bound: int = BOUND_BYTES) -> None:
        """Remove the least recently used results, except this build's, until the others fit into `bound` bytes."""
        if self.folder is not None:
            owned_folder.remove_longest_unused(self.folder, _FILE, bound, self._used)

    def summary(self) -> dict[str, Any]:
        """The counts and problems for the manifest."""
        return {
            "taken": dict(self._reuse_counts),
            "oldest_taken": self._oldest,
            "kept": dict(self._write_counts),
            "trouble": self.trouble(),
        }

    def taken_words(self) -> str:
        """How many results of the build were reused, as a sentence."""
        if not self._reuse_counts:
            return "no result was taken from the store"
        hits, new = _count(self._reuse_counts), _count(self._write_counts)
        return f"{hits} taken from the store (since {self._oldest}), {new} made now"

    def kept_words(self) -> str:
        """What is stored if the build stops now, as a sentence."""
        counts = self._reuse_counts + self._write_counts
        if not counts:
            return "no result was stored"
        command = "the same command" + (" without --fresh" if self.fresh else "")
        return f"{_count(counts)} stored in {self.folder}; {command} continues from there"

    def size_words(self) -> str:
        """The size of the store and how to delete it, as a sentence."""
        size = sum(about.st_size for _, about in self._files(_FILE))
        return f"{self.folder} holds {size / 1e6:.0f} MB and may be deleted; --fresh runs everything again"

    def trouble(self) -> list[str]:
        """A line for each kind of problem, and for foreign files in the folder."""
        foreign = [path.name for path, _ in self._files(_FOREIGN)]
        data = {
            "could not be read, and were made again": self._read_errors,
            "could not be stored": self._write_errors,
            "foreign files, not touched": foreign,
        }
        return [f"{fate}: {len(what)}, such as {what[0]}" for fate, what in data.items() if what]

    def _open(self) -> None:
        if self.folder is not None and not self.folder.is_dir():
            self.folder.mkdir(parents=True, exist_ok=True)
            owned_folder.write(self.folder / ".gitignore", "*\n")  # not in a folder of the user's

    def _files(self, name: re.Pattern[str]) -> list[tuple[Path, os.stat_result]]:
        return owned_folder.files_in(self.folder, name) if self.folder is not None else []

    def _path(self, kind: str, key: Key) -> Path:
        assert self.folder is not None
        return self.folder / f"{kind}-{digest(key)}.npz"


def _count(kinds: Counter[str]) -> str:
    return " and ".join(f"{n} {kind}{'s' * (n != 1)}" for kind, n in sorted(kinds.items())) or "nothing"


def _archive(data: Mapping[str, Any], arrays: Sequence[bytes]) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(_RECORD, json.dumps(data, ensure_ascii=False, indent=1))
        for place, array in enumerate(arrays):
            # Not compressed: to compress a run's numbers to two thirds takes twenty times as long.
            archive.writestr(zipfile.ZipInfo(str(place)), array)
    return content.getvalue()


def _read(path: Path) -> tuple[dict[str, Any], list[bytes]]:
    """Read the content of an archive; a damaged file can raise anything."""
    with zipfile.ZipFile(io.BytesIO(user_files.content("stored result", path, _MOST_BYTES, follow=False))) as archive:
        # A member is read up to its declared size only.
        if sum(member.file_size for member in archive.infolist()) > _MOST_BYTES:
            raise ValueError(f"it claims to hold more than {_MOST_BYTES / 1e6:.0f} MB")
        # Each member is read completely, so that its checksum is verified.
        return json.loads(archive.read(_RECORD)), [archive.read(str(i)) for i in range(len(archive.namelist()) - 1)]


def _sentence(problem: Exception) -> str:
    return f"{type(problem).__name__}: {' '.join(str(problem).split())}"
