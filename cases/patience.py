"""How long an author's own code may take before it is stopped and told."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from .errors import BadValue

# Seconds. A case of the catalogue takes milliseconds, the worst formula that is admitted half a minute to derive.
PATIENCE = 60.0
# What runs in a C function for ever answers to no signal: then the process ends.
GRACE = 30.0


class TimeUp(BaseException):
    """No Exception: an author's own `except Exception` is not to catch it."""


@contextmanager
def patience(what: str, seconds: float = PATIENCE) -> Iterator[None]:
    """Inside, an author's code runs for so many seconds at most, else BadValue says so.

    For commands: it takes the process's alarm, and where no signal gets through, the process ends with the sentence
    and status 2. Outside the main thread, and where there are no alarms, nothing is bounded.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return
    sentence = f"{what} does not end within {seconds:g} s; look for a loop without end in it"

    def ring(*_) -> None:
        raise TimeUp

    def give_up() -> None:
        print(sentence, file=sys.stderr, flush=True)
        os._exit(2)

    before = signal.signal(signal.SIGALRM, ring)
    began = time.monotonic()
    left, _ = signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
    last = threading.Timer(seconds + GRACE, give_up)
    last.daemon = True
    last.start()
    try:
        yield
    except TimeUp:
        raise BadValue(sentence) from None
    finally:
        last.cancel()
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        if left:  # an alarm that was set before rings when it would have, or at once
            signal.setitimer(signal.ITIMER_REAL, max(left - (time.monotonic() - began), 1e-3))
