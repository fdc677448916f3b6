"""A limit on the CPU time of a block: a loop without end fails a test instead of holding it up."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager


class TooLong(BaseException):
    """No Exception, so that no `except Exception` of the code under test catches it."""


@contextmanager
def cpu_limit(seconds: float) -> Iterator[None]:
    """Raises TooLong where the block takes more CPU time of this process; what else the machine does is not counted.

    A loop inside one call of compiled code is not interrupted.
    """

    def late(*_):
        raise TooLong(f"still running after {seconds:g} s of CPU time")

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
