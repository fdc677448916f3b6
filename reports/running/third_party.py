"""Restores the settings of the process after an engine's code has run."""

from __future__ import annotations

import ctypes
import ctypes.util
import decimal
import gc
import locale
import os
import resource
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

import numpy as np

# Bytes of the C library's fenv_t; the largest, of x86-64, has 32.
_FENV_BYTES = 512
# What decides which module an import finds.
_IMPORT_LISTS = ("path", "path_hooks", "meta_path")
LIMITS = [getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")]


@contextmanager
def third_party() -> Iterator[None]:
    """A context manager for an engine's code that restores the settings of the process afterwards.

    These are working folder, locale, decimal context, recursion limit, umask, resource limits, signal handlers, garbage
    collection, warning filters and NumPy's error handling; rounding returns to its state at the import of this module.
    Imports find again what they found before, because NumPy imports parts of itself at their first use. The engine's
    additions to the search path and the finders are searched after that, and environment variables stay changed: later
    imports of the engine may need them."""
    before = [(write, read()) for read, write in _SETTINGS]
    with warnings.catch_warnings(), np.errstate():
        try:
            yield
        finally:
            for write, value in before:
                with suppress(OSError, ValueError):  # a limit lowered for good; the canary or the call shows it
                    write(value)
            _restore_arithmetic()


def _limits() -> list[tuple[int, int]]:
    return [(limit, resource.getrlimit(limit)[0]) for limit in LIMITS]


def _set_limits(limits: list[tuple[int, int]]) -> None:
    for limit, soft in limits:
        now, hard = resource.getrlimit(limit)
        if now != soft:
            resource.setrlimit(limit, (soft, hard))


def _handlers() -> list[tuple[int, Any]]:
    return [(number, signal.getsignal(number)) for number in signal.valid_signals()]


def _set_handlers(handlers: list[tuple[int, Any]]) -> None:
    for number, handler in handlers:
        if handler is not None and signal.getsignal(number) is not handler:
            signal.signal(number, handler)


def _umask() -> int:
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def _set_collection(is_enabled: bool) -> None:
    (gc.enable if is_enabled else gc.disable)()


def _imports() -> list[tuple[list[Any], list[Any]]]:
    """The lists of the module search path and the finders, and their entries."""
    return [(getattr(sys, name), list(getattr(sys, name))) for name in _IMPORT_LISTS]


def _restore_imports(before: list[tuple[list[Any], list[Any]]]) -> None:
    """Set the lists to their entries before, in their order, followed by what was added since."""
    for name, (place, entries) in zip(_IMPORT_LISTS, before, strict=True):
        now = getattr(sys, name)
        added = [entry for entry in now if entry not in entries] if isinstance(now, list) else []
        place[:] = [*entries, *added]
        setattr(sys, name, place)


_SETTINGS: tuple[tuple[Callable[[], Any], Callable[[Any], Any]], ...] = (
    (os.getcwd, os.chdir),
    (lambda: locale.setlocale(locale.LC_ALL), lambda name: locale.setlocale(locale.LC_ALL, name)),
    (lambda: decimal.getcontext().copy(), decimal.setcontext),
    (sys.getrecursionlimit, sys.setrecursionlimit),
    (_limits, _set_limits),
    (_handlers, _set_handlers),
    (partial(signal.pthread_sigmask, signal.SIG_BLOCK, ()), partial(signal.pthread_sigmask, signal.SIG_SETMASK)),
    (_umask, os.umask),
    (gc.isenabled, _set_collection),
    (gc.get_threshold, lambda thresholds: gc.set_threshold(*thresholds)),
    (_imports, _restore_imports),
)  # fmt: skip


def _floating_point() -> tuple[Any, Any] | None:
    """The C math library and the floating-point environment of this process; None if there is none."""
    try:
        maths = ctypes.CDLL(ctypes.util.find_library("m"))
        environment = ctypes.create_string_buffer(_FENV_BYTES)
        return None if maths.fegetenv(environment) else (maths, environment)
    except (OSError, AttributeError):
        return None


# State at the start of a process: rounding to nearest, subnormal numbers enabled.
_AT_FIRST = _floating_point()


def _restore_arithmetic() -> None:
    if _AT_FIRST is not None:
        maths, environment = _AT_FIRST
        maths.fesetenv(environment)
