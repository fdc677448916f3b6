"""What was derived and compiled, on disk for the next process: the user's own folder, where reading it is safe.

To read a pickle is to run code. So the folder must belong to the user and be closed to everybody else, and so must
every file; whatever it is that does not, it is left alone, and one sentence in the log says so. `SLIP_TO_ROLL_CACHE`
names another folder, or is "off".
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
# A report of the whole catalogue keeps 130 MB. What was used longest ago goes first.
LARGEST_BYTES = 512 * 2**20
# So many files at most: a report keeps two thousand, and a folder of many more is slow to look through.
MOST_FILES = 20_000
# The folder is looked at when a process has written so much to it, and when it writes first.
_LOOK_BYTES, _LOOK_FILES = 32 * 2**20, 1000
_DIGEST = hashlib.sha256().digest_size
_SUFFIX = ".kept"
_FILE = re.compile(rf"[0-9a-f]{{64}}{re.escape(_SUFFIX)}")

# What this process took from the folder and what it put there, by kind.
hits: Counter[str] = Counter()
misses: Counter[str] = Counter()
_bytes_since_trim = -1
# What is made and not written yet, inside `withheld`.
_pending: list[tuple[Path, bytes]] | None = None


@in_one_thread
def cached(kind: str, decided_by: Any, code: Path, make: Callable[[], T]) -> T:
    """`make()`, or what it returned before in a process of the same code, versions and processor.

    `decided_by` is all that decides the result: expressions, numbers, texts, types, and tuples or dataclasses of such;
    `code` is a folder whose modules decide it too, beside those of `cases`. What cannot be kept is made.
    """
    folder = place()
    if folder is None:
        return make()
    try:
        key = "\n".join((kind, _as_text(decided_by), _surroundings(), _code(code), _code(Path(__file__).parent)))
    except OSError as error:  # modules that cannot be read as files cannot be told from others
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
    """What was taken and made since it was asked last: how a worker reports to the process that asks it."""
    since = Counter(hits), Counter(misses)
    hits.clear()
    misses.clear()
    return since


def words() -> str:
    """How much of what this process and its workers compiled came from disk; a report, which others read, does not say
    from which of the user's folders."""
    if place() is None:
        return "compiled parts were neither kept nor taken from disk"
    return f"{hits.total()} compiled parts taken from the cache, {misses.total()} made and kept there"


def place() -> Path | None:
    """The folder, made if need be; None where nothing is kept."""
    text = os.environ.get(VARIABLE)
    if text is None:
        above = os.environ.get("XDG_CACHE_HOME", "")
        text = str(Path(above if os.path.isabs(above) else "~/.cache") / "slip-to-roll")
    return None if text in (OFF, "") else _safe_folder(text)


@contextmanager
def off() -> Iterator[None]:
    """Inside, everything is derived and compiled anew: for what tells how long that takes."""
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
    """Inside, what is made is not written; the function that is given writes it, if it is called before the end. For a
    process in which third-party code runs: other processes take what is kept, so it is looked first whether this one
    still computes as it should."""
    global _pending
    _pending = []
    try:
        yield _write_pending
    finally:
        _pending = None


@lru_cache(maxsize=8)
def _safe_folder(text: str) -> Path | None:
    """The folder if it is safe to read from; else the log says once what is wrong."""
    folder = Path(text)
    try:
        folder = folder.expanduser().absolute()
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        # Not what a link leads to: who may change the link could lead it elsewhere.
        problem = _not_ours(folder.lstat(), stat.S_ISDIR, "a folder", 0o077)
    except (OSError, RuntimeError) as error:  # of RuntimeError: a user without a home directory
        problem = str(error)
    if not problem:
        return folder
    _log().warning(
        "nothing is kept in %s (%s): give %s a folder of your own that nobody else can read, or %s",
        folder, problem, VARIABLE, OFF,
    )  # fmt: skip
    return None


def _not_ours(about: os.stat_result, is_kind: Callable[[int], bool], kind: str, closed: int) -> str:
    """What is wrong with a file or folder that has to be the user's alone, "" if nothing."""
    if not is_kind(about.st_mode):
        return f"it is not {kind}"
    if not hasattr(os, "geteuid") or about.st_uid != os.geteuid():
        return "it belongs to somebody else"
    return "others have access to it" if about.st_mode & closed else ""


def _read(file: Path) -> tuple[Any] | None:
    """What the file holds, in a tuple; None if there is none, or it is not whole, or not ours."""
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
    except Exception as error:  # whatever a pickle may raise: what it holds can be made anew
        _log().warning("%s is made anew: %s", file, error)
        return None


def _write(file: Path, value: Any) -> None:
    """Put it there at once and whole, or not at all; inside `withheld`, later."""
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
        _bytes_since_trim += max(len(content), _LOOK_BYTES // _LOOK_FILES)  # small files count, too
    except OSError as error:
        _log().warning("%s could not be kept: %s", file, error)


def _trim(folder: Path) -> None:
    """If the folder holds more than it may, leave three quarters of that: the files that were used last."""
    files = owned_folder.files_in(folder, _FILE)
    part = 0.75 if len(files) > MOST_FILES or sum(about.st_size for _, about in files) > LARGEST_BYTES else 1.0
    owned_folder.remove_longest_unused(folder, _FILE, part * LARGEST_BYTES, part * MOST_FILES)


def _log() -> logging.Logger:
    return logging.getLogger("cases")


# --- what decides a result --------------------------------------------------------------------------------------------


def _as_text(part: Any) -> str:
    """All of it, in the order in which it stands: SymPy's own text sorts sums, and rounding depends on the order."""
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
    """A digest of the modules of a folder and of what lies in it, but for the catalogue's cases and the pictures."""
    digest = hashlib.sha256()
    for file in sorted(folder.rglob("*.py")):
        if not {"catalogue", "pictures"} & {*file.relative_to(folder).parts}:
            digest.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


@lru_cache(maxsize=1)
def _surroundings() -> str:
    """Versions and the processor: machine code serves the processor it was made for."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        processor = sorted({line for line in lines if line.startswith(("model name", "flags", "Features", "CPU"))})
    except OSError:
        processor = [platform.platform(), platform.processor(), platform.node()]
    return "\n".join([sys.version, sp.__version__, np.__version__, platform.machine(), *processor])


# --- functions that SymPy wrote ---------------------------------------------------------------------------------------


class _Pickler(pickle.Pickler):
    """Takes functions that lambdify made as their code and the functions they call."""

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
