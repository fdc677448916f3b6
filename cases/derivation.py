"""One thread at a time derives: a lock for everything that SymPy works out, and for what is then shared by all threads.

SymPy is not made for threads: it stores the answers to its questions about an expression (is it positive?), and an
unknown before them, in the expression itself, where another thread reads them (github.com/sympy/sympy/pull/30088).
Two threads that derive the same equations at once may get different formulas, whose motions differ in the last digits.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, Generic, ParamSpec, TypeVar, overload

P = ParamSpec("P")
T = TypeVar("T")

# One lock for all, so that no two threads can wait for each other; a derivation asks for others, so it is reentrant.
LOCK = threading.RLock()

if hasattr(os, "register_at_fork"):  # a copy of the process must not begin with a lock that nobody will release
    os.register_at_fork(before=LOCK.acquire, after_in_parent=LOCK.release, after_in_child=LOCK.release)


def in_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """The same function, which only one thread at a time is in."""

    @wraps(function)
    def alone(*args: P.args, **kwargs: P.kwargs) -> T:
        with LOCK:
            return function(*args, **kwargs)

    return alone


class derived(Generic[T]):
    """An attribute that is worked out, by one thread for all, when it is first read.

    (Of `functools.cached_property` each attribute holds a lock of its own in Python 3.11: a thread that holds that one
    and a thread that holds `LOCK` would wait for each other.)
    """

    def __init__(self, make: Callable[[Any], T]) -> None:
        self._make, self._name, self.__doc__ = make, make.__name__, make.__doc__

    @overload
    def __get__(self, instance: None, owner: type | None = None) -> derived[T]: ...
    @overload
    def __get__(self, instance: object, owner: type | None = None) -> T: ...

    def __get__(self, instance: object, owner: type | None = None) -> derived[T] | T:
        if instance is None:
            return self
        with LOCK:
            attributes = vars(instance)  # once the value is there Python finds it before it comes here
            if self._name not in attributes:
                attributes[self._name] = self._make(instance)
            return attributes[self._name]
