"""Files and folders that the suite writes: files are written atomically, and no user file is deleted or overwritten.

`atomic_path` and `write` make one file, a `TemporaryFolder` serves one process, an `OwnedFolder` holds results and a
list of the files that belong to the suite. Locks are the system's (flock, POSIX) and end with their process.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import secrets
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from typing import Any

from ..errors import BadValue, CaseError
from . import user_files

# The list of our files in a folder, in the format of `sha256sum`: `sha256sum -c slip-to-roll.sha256` checks them.
LIST = "slip-to-roll.sha256"
_LARGEST_LIST = 100 * 2**20  # bytes: a million files
_ENTRY = re.compile(r"([0-9a-f]{64})  (\S|\S.*\S)")
# Names of unfinished files and folders, which no other program uses.
_PARTIAL = re.compile(r"\.slip-to-roll-[0-9a-f]{16}\.partial(\.\w+)?")
# On a file system without locks, an unfinished file belongs to a running process if it is younger than this (s): no
# command takes a day.
_TEMPORARY_NAME = 86400.0
# What the folder of a call must have room for: the output of a worker, and a scene.
_PROBE_BYTES = 2**16
# Seconds to wait for another process that puts finished files into a folder: to rename a thousand takes one.
_PATIENCE = 60.0


# --- one file ---------------------------------------------------------------------------------------------------------


def check_new(path: Path, force: bool = False) -> None:
    """Raise BadValue if the path of a new file exists; with `force`, it may be a regular file."""
    if path.is_dir():
        raise BadValue(f"{path} is a folder; give another name")
    if os.path.lexists(path) and not (force and _is_file(path)):
        advice = ", or --force to overwrite it" if _is_file(path) else ""
        raise BadValue(f"{path} exists already; give another name{advice}")
    remove_leftovers(path.parent)


def write(path: Path, content: str | bytes, replace: bool = True, **how: Any) -> None:
    """Write a file atomically, as `atomic_path` does; text in UTF-8."""
    with atomic_path(path, replace, **how) as partial:
        partial.write_bytes(content if isinstance(content, bytes) else content.encode(errors="backslashreplace"))


@contextmanager
def atomic_path(
    path: Path, replace: bool = True, mode: int = 0o666, durable: bool = True, inside: Path | None = None
) -> Iterator[Path]:
    """A path to write to, with the same ending; the file is moved to `path` when the block ends well, else removed.

    `replace`: whether a file may be there; if not, FileExistsError is raised. `mode`: permissions, less the umask.
    `durable`: whether the file is on the disk before it is moved. A cache, which checks what it reads, saves that time.
    `inside`: the folder of the unfinished file (default: that of `path`).
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
    partial, lock = _claim(inside or path.parent, path.suffix, lambda new: os.close(os.open(new, flags, mode)))
    try:
        yield partial
        if durable:
            _sync(partial)
        _move(partial, path, replace)
        if durable:
            _sync(path.parent)
    finally:
        partial.unlink(missing_ok=True)
        _own_partials.discard(partial)
        os.close(lock)


def digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _move(partial: Path, path: Path, replace: bool) -> None:
    if replace:
        os.replace(partial, path)
        return
    try:
        os.link(partial, path)  # fails if the file exists; renaming would not
    except OSError:
        if os.path.lexists(path):
            raise FileExistsError(f"{path} exists already") from None
        os.replace(partial, path)  # a file system without links


def _is_file(path: Path) -> bool:
    """Whether it is a regular file, and no link to one."""
    with suppress(OSError, ValueError):
        return stat.S_ISREG(path.lstat().st_mode)
    return False


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError:
        if not path.is_dir():  # some file systems cannot flush a folder
            raise
    finally:
        os.close(handle)


# --- unfinished files -------------------------------------------------------------------------------------------------


# Unfinished files and temporary folders of this process.
_own_partials: set[Path] = set()


class TemporaryFolder:
    """A new folder inside another (default: the system's temporary folder), locked while this process needs it."""

    def __init__(self, inside: Path | None = None, mode: int = 0o700):
        self.path, self._lock = _claim(inside or Path(tempfile.gettempdir()), "", lambda new: new.mkdir(mode))

    def __enter__(self) -> Path:
        return self.path

    def __exit__(self, *_) -> None:
        self.remove()

    def remove(self) -> None:
        """Remove the folder and its content. May be called again."""
        shutil.rmtree(self.path, ignore_errors=True)
        _own_partials.discard(self.path)
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1


def check_usable(folder: Path) -> None:
    """Raise OSError unless a new file in the folder can take the text of a run."""
    with tempfile.TemporaryFile(dir=folder) as file:
        file.write(bytes(_PROBE_BYTES))


def remove_partials() -> None:
    """Remove the unfinished files and folders of this process: a signal may have come before their own end was set."""
    while _own_partials:
        path = _own_partials.pop()
        shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)


def remove_leftovers(folder: Path | None = None) -> None:
    """Remove the unfinished files and folders that killed processes of this user left in a folder."""
    for path, about in files_in(folder or Path(tempfile.gettempdir()), _PARTIAL):
        with suppress(OSError):  # it no longer exists, or cannot be removed: harmless
            if about.st_uid != os.getuid() or not (stat.S_ISREG(about.st_mode) or stat.S_ISDIR(about.st_mode)):
                continue
            handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
            try:
                if _locks(handle, wait=False, otherwise=time.time() - about.st_mtime > _TEMPORARY_NAME):
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
            finally:
                os.close(handle)


def _claim(folder: Path, suffix: str, make: Callable[[Path], None]) -> tuple[Path, int]:
    """A new unfinished file or folder, and the open handle that locks it."""
    for _ in range(10):
        path = folder / f".slip-to-roll-{secrets.token_hex(8)}.partial{suffix}"
        _own_partials.add(path)
        make(path)
        with suppress(FileNotFoundError):  # another process may remove it before it is locked
            handle = os.open(path, os.O_RDONLY)
            _locks(handle, wait=True)
            if path.exists():
                return path, handle
            os.close(handle)
    raise OSError(f"nothing stays in {folder}; give another folder")


def _locks(handle: int, wait: bool, otherwise: bool = True) -> bool:
    """Lock an open file or folder; returns whether it is locked, or `otherwise` on a file system without locks."""
    import fcntl  # POSIX only, and not needed for reading

    try:
        fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return otherwise
    return True


# --- a cache ----------------------------------------------------------------------------------------------------------


def files_in(folder: Path, name: re.Pattern[str]) -> list[tuple[Path, os.stat_result]]:
    """Paths and status of a folder's entries with such a name; empty if there is no folder."""
    files = []
    with suppress(OSError):
        for entry in os.scandir(folder):
            if name.fullmatch(entry.name):
                with suppress(FileNotFoundError):  # another process removed it
                    files.append((Path(entry.path), entry.stat(follow_symlinks=False)))
    return files


def remove_longest_unused(
    folder: Path, name: re.Pattern[str], most_bytes: float, exceptions: Iterable[Path] = ()
) -> None:
    """Remove the least recently used files with such a name until the others are within the limit.

    Also removes unfinished files of killed processes. Files in `exceptions` are kept.
    """
    remove_leftovers(folder)
    files = sorted((f for f in files_in(folder, name) if stat.S_ISREG(f[1].st_mode)), key=lambda f: f[1].st_mtime_ns)
    size, exceptions = sum(about.st_size for _, about in files), set(exceptions)
    for path, about in files:
        if size <= most_bytes:
            return
        if path not in exceptions:
            with suppress(OSError):  # what cannot be removed stays
                path.unlink()
                size -= about.st_size


# --- a folder of results ----------------------------------------------------------------------------------------------


class OwnedFolder:
    """A folder that one command writes, with a list of its files and their digests.

    All other files are the user's, and so is a listed file whose content has changed: none of them is ever touched.

    `kind`: what it is, for example "report". `claims`: patterns of all names that may be written. `last`: files without
    which the folder counts as unfinished. `unread`: a pattern of listed files that `check` does not read, because they
    will not change.
    """

    def __init__(self, path: Path, kind: str, claims: Sequence[str] = (), last: Sequence[str] = (), unread: str = ""):
        self.path, self.kind, self.claims, self.last, self.unread = path, kind, claims, last, unread
        self._digests: dict[str, set[str]] = {}
        self._is_locked = False

    def check(self) -> None:
        """Raise BadValue unless the folder is new, empty, or of this kind without user files in the place of ours."""
        if os.path.lexists(self.path) and not self.path.is_dir():
            raise BadValue(f"--out is {self.path}, which is a file; give a folder")
        remove_leftovers(self.path)
        if not self._read():
            names = os.listdir(self.path) if self.path.is_dir() else []
            other = min((name for name in names if not _PARTIAL.fullmatch(name)), default="")
            if other:
                raise BadValue(f"--out is {self.path}, which holds {other} and is no {self.kind}; give another folder")
            return
        matches = {file.relative_to(self.path).as_posix() for claim in self.claims for file in self.path.glob(claim)}
        for name in sorted(matches | {*self._digests}):
            if not (name in self._digests and fnmatchcase(name, self.unread)):
                self._check_free(name)

    @property
    def is_empty(self) -> bool:
        """Whether it has none of our files; valid inside `locked`."""
        return not self._digests

    def names(self) -> list[str]:
        """The names of our files; raises BadValue if one of them is missing or has changed."""
        if not self._read():
            raise BadValue(f"{self.path} holds no {self.kind}")
        for name in self._digests:
            if not os.path.lexists(self.path / name):
                raise BadValue(f"the {self.kind} in {self.path} is without {name}")
            if self._is_foreign(name):
                raise BadValue(f"{name} in {self.path} has changed since it was written")
        return sorted(self._digests)

    @contextmanager
    def write_lock(self, patience: float = _PATIENCE) -> Iterator[None]:
        """Create, check and lock the folder: inside, no other process writes to it.

        Raises BadValue if another process still holds the lock after `patience` seconds, and as `check`.
        """
        if self._is_locked:
            yield
            return
        with suppress(FileExistsError):  # a file: `check` reports it
            self.path.mkdir(parents=True, exist_ok=True)
        handle, deadline = os.open(self.path, os.O_RDONLY), time.monotonic() + patience
        try:
            while not _locks(handle, wait=False):
                if time.monotonic() >= deadline:
                    raise BadValue(f"another command writes to {self.path}; wait for it, or give another --out")
                time.sleep(0.05)
            self.check()
            self._digests = {n: digests for n, digests in self._digests.items() if os.path.lexists(self.path / n)}
            self._save()
            self._is_locked = True
            yield
        finally:
            self._is_locked = False
            os.close(handle)

    def write(self, name: str, content: bytes) -> None:
        """Write one of our files. Raises BadValue if a user file is in its place."""
        with self.write_lock():
            self._check_free(name)
            content_digest = hashlib.sha256(content).hexdigest()
            # List it first: whenever the process ends, none of our files is mistaken for the user's.
            _append(self.path / LIST, f"{content_digest}  {name}\n".encode())
            (self.path / name).parent.mkdir(parents=True, exist_ok=True)
            write(self.path / name, content, inside=self.path)
            self._digests[name] = {content_digest}

    @contextmanager
    def staging(self, whole: bool = False) -> Iterator[Path]:
        """A temporary folder to write files into; they are moved to their places if the block succeeds, else removed.

        `whole`: these are all files of the folder; our other files are removed. Raises BadValue if a user file is in
        the place of one of them: then nothing is moved.
        """
        is_new = not self.path.exists()
        self.path.mkdir(parents=True, exist_ok=True)
        try:
            with TemporaryFolder(self.path, 0o777) as place:
                yield place
                self._put(place, whole)
        except BaseException:
            if is_new:
                with suppress(OSError):  # it holds something
                    self.path.rmdir()
            raise

    def remove(self, names: Iterable[str]) -> None:
        """Remove these of our files, and folders that become empty."""
        with self.write_lock():
            for name in [*names]:
                if not self._is_foreign(name):
                    (self.path / name).unlink(missing_ok=True)
                    for folder in PurePosixPath(name).parents[:-1]:
                        with suppress(OSError):  # it holds something
                            (self.path / folder).rmdir()
                self._digests.pop(name, None)
            self._save()

    def clear(self) -> None:
        """Remove all of our files."""
        with self.write_lock():
            self.remove(self._digests)

    def _put(self, place: Path, whole: bool) -> None:
        new = {path.relative_to(place).as_posix(): path for path in sorted(place.rglob("*")) if path.is_file()}
        for path in new.values():
            _sync(path)
        with self.write_lock():
            for name in new:
                self._check_free(name)
            digests = {name: {digest(path)} for name, path in new.items()}
            self._digests |= {name: digests[name] | self._digests.get(name, set()) for name in digests}
            self._save()
            for name in {*self.last} & {*self._digests}:
                (self.path / name).unlink(missing_ok=True)
            for name in sorted(new, key=lambda name: name in self.last):
                (self.path / name).parent.mkdir(parents=True, exist_ok=True)
                os.replace(new[name], self.path / name)
            self._digests |= digests
            self.remove(self._digests.keys() - new.keys() if whole else ())

    # The list: a heading with the kind of folder, and the digests of each file; those of earlier content stay until the
    # new file is in its place.

    @property
    def _head(self) -> str:
        return f"# slip-to-roll {self.kind}"

    def _read(self) -> bool:
        """Read the list; returns whether there is one for this kind of folder."""
        self._digests = {}
        try:
            lines = user_files.text("list of files", self.path / LIST, _LARGEST_LIST).split("\n")
        except CaseError:
            return False
        if lines[0] != self._head or not _is_file(self.path / LIST):
            return False
        for entry in filter(None, map(_ENTRY.fullmatch, lines[1:])):  # a loss of power may cut a line short
            if _is_inside(entry[2]):
                self._digests.setdefault(entry[2], set()).add(entry[1])
        return True

    def _save(self) -> None:
        entries = [f"{each}  {name}\n" for name in sorted(self._digests) for each in sorted(self._digests[name])]
        write(self.path / LIST, "".join([f"{self._head}\n", *entries]))

    def _check_free(self, name: str) -> None:
        if self._is_foreign(name):
            what = "was not written by this command, or has changed since"
            raise BadValue(f"{self.path / name} {what}; move it, or give another --out")

    def _is_foreign(self, name: str) -> bool:
        """Whether the path of that name holds anything but one of our unchanged files."""
        path = self.path / name
        above = [self.path / folder for folder in PurePosixPath(name).parents if folder.name]
        if not _is_inside(name) or any(os.path.lexists(p) and (p.is_symlink() or not p.is_dir()) for p in above):
            return True
        try:
            return os.path.lexists(path) and not (_is_file(path) and digest(path) in self._digests.get(name, ()))
        except OSError:  # it cannot be read
            return True


def _is_inside(name: str) -> bool:
    """Whether a name is a normalised relative path of a file below a folder, and not that of the list."""
    parts = PurePosixPath(name).parts
    return str(PurePosixPath(name)) == name and not {"/", "//", ".."} & {*parts} and parts not in ((), (LIST,))


def _append(file: Path, line: bytes) -> None:
    """Append a line to a file, completely or not at all."""
    with file.open("ab", buffering=0) as stream:
        before = stream.tell()
        try:
            if stream.write(line) < len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(file))
            os.fsync(stream.fileno())
        except BaseException:
            os.ftruncate(stream.fileno(), before)
            raise
