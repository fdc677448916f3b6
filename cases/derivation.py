"""A lock for all derivations by SymPy, and for the results that all threads share: one thread at a time.

SymPy is not thread-safe: it stores assumptions about an expression (is it positive?), and before them an unknown, in
the expression itself, where another thread reads them (github.com/sympy/sympy/pull/30088). Two threads that derive the
same equations at once may get different formulas, whose motions differ in the last digits.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, Generic, ParamSpec, TypeVar, overload

P = ParamSpec("P")
T = TypeVar("T")

# One lock for all, so that no two threads can wait for each other; derivations are nested, so it is reentrant.
LOCK = threading.RLock()

if hasattr(os, "register_at_fork"):  # a forked process must not begin with a lock that nothing releases
    os.register_at_fork(before=LOCK.acquire, after_in_parent=LOCK.release, after_in_child=LOCK.release)


def in_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """The function, executed by only one thread at a time."""

    @wraps(function)
    def alone(*args: P.args, **kwargs: P.kwargs) -> T:
        with LOCK:
            return function(*args, **kwargs)

    return alone


class derived(Generic[T]):
    """A cached attribute, computed by one thread when it is first read.

    (In Python 3.11 each `functools.cached_property` has a lock of its own: a thread that holds it and a thread that
    holds `LOCK` would wait for each other.)
    """

    def __init__(self, make: Callable[[Any], T]) -> None:
        self._make, self._name, self.__doc__ = make, make.__name__, make.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, instance: None, owner: type | None = None) -> derived[T]: ...
    @overload
    def __get__(self, instance: object, owner: type | None = None) -> T: ...

    def __get__(self, instance: object, owner: type | None = None) -> derived[T] | T:
        if instance is None:
            return self
        with LOCK:
            attributes = vars(instance)  # once the value is stored, Python does not call this
            if self._name not in attributes:
                attributes[self._name] = self._make(instance)
            return attributes[self._name]
