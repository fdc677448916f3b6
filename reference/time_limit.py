"""A limit on the CPU time of long computations, which they check themselves."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from time import thread_time

_END: ContextVar[float] = ContextVar("end", default=inf)


class OutOfTime(Exception):
    """A computation has reached its limit on CPU time."""


@contextmanager
def cpu_limit(seconds: float) -> Iterator[None]:
    """Within it `check_time` raises OutOfTime after so many CPU seconds of this thread."""
    token = _END.set(min(_END.get(), thread_time() + seconds))
    try:
        yield
    finally:
        _END.reset(token)


def check_time() -> None:
    """Raise OutOfTime if the limit, if there is any, is reached."""
    if (end := _END.get()) < inf and thread_time() > end:
        raise OutOfTime
