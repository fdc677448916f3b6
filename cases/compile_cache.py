"""A cache on disk for derived and compiled code, in a folder that belongs to the user alone.

Loading a pickle executes code. So the folder and every file must belong to the user and be inaccessible to others; any
other folder or file is not used, and the log has one line about it. `SLIP_TO_ROLL_CACHE` names another folder, or is
"off".
"""

from __future__ import annotations

import hashlib
import logging
import marshal
import os
import pickle
import platform
import re
import stat
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

import numpy as np
import sympy as sp

from . import owned_folder
from .derivation import in_one_thread

T = TypeVar("T")

VARIABLE = "SLIP_TO_ROLL_CACHE"
OFF = "off"
# A report of the whole catalogue writes 130 MB. The files that were used longest ago are removed first.
LARGEST_BYTES = 512 * 2**20
# Most files: a report writes two thousand, and a folder of many more is slow to list.
MOST_FILES = 20_000
# The folder's size is checked after so many bytes written by a process, and at its first write.
_LOOK_BYTES, _LOOK_FILES = 32 * 2**20, 1000
_DIGEST = hashlib.sha256().digest_size
_SUFFIX = ".kept"
_FILE = re.compile(rf"[0-9a-f]{{64}}{re.escape(_SUFFIX)}")

# Results that this process loaded from the folder and results that it made, by kind.
hits: Counter[str] = Counter()
misses: Counter[str] = Counter()
_bytes_since_trim = -1
# Results that are not written yet, inside `withheld`.
_pending: list[tuple[Path, bytes]] | None = None


@in_one_thread
def cached(kind: str, decided_by: Any, code: Path, make: Callable[[], T]) -> T:
    """`make()`, or its cached result from a process with the same code, versions and processor.

    `decided_by` contains everything that determines the result: expressions, numbers, texts, types, and tuples or
    dataclasses of these; `code` is a folder whose modules determine it too, in addition to those of `cases`. Results
    that cannot be cached are made each time.
    """
    folder = place()
    if folder is None:
        return make()
    try:
        key = "\n".join((kind, _as_text(decided_by), _surroundings(), _code(code), _code(Path(__file__).parent)))
    except OSError as error:  # without the source files there is no key
        _log().warning("nothing is kept: %s", error)
        return make()
    file = folder / (hashlib.sha256(key.encode()).hexdigest() + _SUFFIX)
    result = _read(file)
    if result is not None:
        hits[kind] += 1
        return result[0]
    value = make()
    misses[kind] += 1
    _write(file, value)
    return value


@in_one_thread
def counters() -> tuple[Counter[str], Counter[str]]:
    """The hits and misses since the last call; workers report them to the process that started them."""
    since = Counter(hits), Counter(misses)
    hits.clear()
    misses.clear()
    return since


def words() -> str:
    """How many compiled parts came from the cache, for a report; without the folder's path, since others read it."""
    if place() is None:
        return "compiled parts were neither kept nor taken from disk"
    return f"{hits.total()} compiled parts taken from the cache, {misses.total()} made and kept there"


def place() -> Path | None:
    """The cache folder, created if it does not exist; None if there is no cache."""
    text = os.environ.get(VARIABLE)
    if text is None:
        above = os.environ.get("XDG_CACHE_HOME", "")
        text = str(Path(above if os.path.isabs(above) else "~/.cache") / "slip-to-roll")
    return None if text in (OFF, "") else _safe_folder(text)


@contextmanager
def off() -> Iterator[None]:
    """Disable the cache inside the block, to measure how long derivation and compilation take."""
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = OFF
    try:
        yield
    finally:
        del os.environ[VARIABLE]
        if before is not None:
            os.environ[VARIABLE] = before


@contextmanager
def withheld() -> Iterator[Callable[[], None]]:
    """Delay writing inside the block; the yielded function writes all results, if it is called before the end.

    For a process in which third-party code runs: other processes load the cache, so it is checked first whether this
    process still computes correctly.
    """
    global _pending
    _pending = []
    try:
        yield _write_pending
    finally:
        _pending = None


@lru_cache(maxsize=8)
def _safe_folder(text: str) -> Path | None:
    """The folder if it is safe to read from; else None, with one warning in the log."""
    folder = Path(text)
    try:
        folder = folder.expanduser().absolute()
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        # Check the folder itself, not the target of a link, which others might change.
        problem = _not_ours(folder.lstat(), stat.S_ISDIR, "a folder", 0o077)
    except (OSError, RuntimeError) as error:  # RuntimeError: a user without a home directory
        problem = str(error)
    if not problem:
        return folder
    _log().warning(
        "nothing is kept in %s (%s): give %s a folder of your own that nobody else can read, or %s",
        folder, problem, VARIABLE, OFF,
    )  # fmt: skip
    return None


def _not_ours(about: os.stat_result, is_kind: Callable[[int], bool], kind: str, closed: int) -> str:
    """Why a file or folder is not private to the user, "" if it is."""
    if not is_kind(about.st_mode):
        return f"it is not {kind}"
    if not hasattr(os, "geteuid") or about.st_uid != os.geteuid():
        return "it belongs to somebody else"
    return "others have access to it" if about.st_mode & closed else ""


def _read(file: Path) -> tuple[Any] | None:
    """The file's value, in a tuple; None if there is no file, or it is incomplete or not private."""
    try:
        with open(os.open(file, os.O_RDONLY | os.O_NOFOLLOW), "rb") as stream:
            problem = _not_ours(os.fstat(stream.fileno()), stat.S_ISREG, "a file", 0o077)
            content = b"" if problem else stream.read()
        digest, rest = content[:_DIGEST], content[_DIGEST:]
        if problem or hashlib.sha256(rest).digest() != digest:
            _log().warning("%s is made anew: %s", file, problem or "it is not whole")
            return None
        os.utime(file)
        return (pickle.loads(rest),)
    except FileNotFoundError:
        return None
    except Exception as error:  # a pickle may raise anything; the value can be made again
        _log().warning("%s is made anew: %s", file, error)
        return None


def _write(file: Path, value: Any) -> None:
    """Write the value to the file atomically; inside `withheld`, later."""
    stream = BytesIO()
    try:
        _Pickler(stream, protocol=5).dump(value)
    except (pickle.PicklingError, AttributeError, TypeError, ValueError) as error:
        _log().warning("%s could not be kept: %s", file, error)
        return
    if _pending is None:
        _put(file, stream.getvalue())
    else:
        _pending.append((file, stream.getvalue()))


def _write_pending() -> None:
    for file, content in _pending or ():
        _put(file, content)


def _put(file: Path, content: bytes) -> None:
    global _bytes_since_trim
    try:
        owned_folder.write(file, hashlib.sha256(content).digest() + content, mode=0o600, durable=False)
        if _bytes_since_trim < 0 or _bytes_since_trim > _LOOK_BYTES:
            _bytes_since_trim = 0
            _trim(file.parent)
        _bytes_since_trim += max(len(content), _LOOK_BYTES // _LOOK_FILES)  # so that small files count too
    except OSError as error:
        _log().warning("%s could not be kept: %s", file, error)


def _trim(folder: Path) -> None:
    """If the folder exceeds its limits, remove the least recently used files down to three quarters of them."""
    files = owned_folder.files_in(folder, _FILE)
    part = 0.75 if len(files) > MOST_FILES or sum(about.st_size for _, about in files) > LARGEST_BYTES else 1.0
    owned_folder.remove_longest_unused(folder, _FILE, part * LARGEST_BYTES, part * MOST_FILES)


def _log() -> logging.Logger:
    return logging.getLogger("cases")


# --- keys -------------------------------------------------------------------------------------------------------------


def _as_text(part: Any) -> str:
    """A text of all its parts in their order: SymPy's own text sorts sums, and rounding depends on the order."""
    if isinstance(part, sp.Basic):
        inner = ",".join(map(_as_text, part.args))
        return f"{type(part).__name__}({inner})" if part.args else sp.srepr(part)
    if isinstance(part, tuple | list):
        return f"{type(part).__name__}[{','.join(map(_as_text, part))}]"
    if is_dataclass(part) and not isinstance(part, type):
        return f"{type(part).__qualname__}{_as_text([getattr(part, f.name) for f in fields(part)])}"
    return part.__qualname__ if isinstance(part, type) else repr(part)


@lru_cache(maxsize=8)
def _code(folder: Path) -> str:
    """A digest of the modules of a folder and its subfolders, without the catalogue's cases and the pictures."""
    digest = hashlib.sha256()
    for file in sorted(folder.rglob("*.py")):
        if not {"catalogue", "pictures"} & {*file.relative_to(folder).parts}:
            digest.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


@lru_cache(maxsize=1)
def _surroundings() -> str:
    """Versions and the processor, since machine code is specific to the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        processor = sorted({line for line in lines if line.startswith(("model name", "flags", "Features", "CPU"))})
    except OSError:
        processor = [platform.platform(), platform.processor(), platform.node()]
    return "\n".join([sys.version, sp.__version__, np.__version__, platform.machine(), *processor])


# --- functions made by SymPy ------------------------------------------------------------------------------------------


class _Pickler(pickle.Pickler):
    """Pickles functions made by lambdify as their code and the functions that they call."""

    def reducer_override(self, thing):
        if isinstance(thing, FunctionType) and thing.__code__.co_filename.startswith("<lambdifygenerated"):
            scope = thing.__globals__
            return _function, (
                marshal.dumps(thing.__code__),
                {n: scope[n] for n in thing.__code__.co_names if n in scope},
            )
        return NotImplemented


def _function(code: bytes, scope: dict[str, Any]) -> FunctionType:
    return FunctionType(marshal.loads(code), scope)
