"""How far a list of calls has come, on the terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

# What shows progress: it is given a step's name, the number of answers and the answers, and hands these on.
Progress = Callable[[str, int, Iterator], Iterator]


def silent(step: str, total: int, answers: Iterator) -> Iterator:
    """Shows nothing."""
    return answers


def bar(step: str, total: int, answers: Iterator) -> Iterator:
    """A bar: how many of `total` answers are there, and the time left."""
    from tqdm import tqdm

    # A terminal sees the bar move; a log file gets a line now and then.
    often = 0.2 if sys.stderr.isatty() else 10.0
    return iter(tqdm(answers, desc=step, total=total, mininterval=often, dynamic_ncols=True))
