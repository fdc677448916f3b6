"""How far a command has come: one live line on a terminal with the time left for the whole, little in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars

# What shows progress: it is given a step's name, the number of answers and the answers, and hands these on.
Progress = Callable[[str, int, Iterator], Iterator]

# A log file gets a line so many seconds after the last one: a sign of life, not a film.
LOG_SECONDS = 60.0
# Seconds that are thought to have passed as expected before anything has: a first step of a second tells little of the
# pace of minutes.
_DOUBT = 10.0

# Seconds of each step of a default report of 62 cases on two cores, in their order: for each case, and for all. What
# they are worth on another machine is seen as the steps pass.
_EACH = {"versions": 0.0, "truth": 0.3, "survey": 0.05, "runs": 1.1}
_TIMED = {"timings": 45.0, "null scores": 5.0, "cold starts and parts": 30.0}
_STUDIED = {
    "effects": 15.0, "error parts": 8.0, "formulations": 3.0, "map of": 1.0, "the paper": 1.0, "published numbers": 1.0,
    "scenes": 9.0, "reference": 17.0, "engines": 13.0, "unstable steps": 1.0,
}  # fmt: skip
_DRAWN = {"figures": 0.35, "other figures": 0.1}


def usual(cases: int, timed: bool, studied: bool) -> dict[str, float]:
    """The steps of a report and the seconds each takes as a rule, for `Display`."""
    each, drawn = ({name: cases * seconds for name, seconds in some.items()} for some in (_EACH, _DRAWN))
    return each | (_TIMED if timed else {}) | (_STUDIED if studied else {}) | drawn


def silent(step: str, total: int, answers: Iterator) -> Iterator:
    """Shows nothing."""
    return answers


class Display:
    """One display for all steps of a command; a context manager that is itself what shows progress.

    `usual`: the steps in their order and the seconds each takes as a rule; a step that comes again, as "survey" does,
    counts where it stands first. The time left is that of the step that runs, at its own pace, and that of the steps
    to come, at the pace the others have had; without `usual` that of the step alone.
    """

    def __init__(self, usual: Mapping[str, float] | None = None, console: Console | None = None):
        self._usual = dict(usual or {})
        self._console = console or Console(stderr=True)
        self._bars = Bars(
            TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[left]}"), TimeElapsedColumn(),
            console=self._console, transient=True, disable=not self._console.is_terminal,
        )  # fmt: skip
        self._logged = self._began = time.monotonic()
        self._passed: set[str] = set()

    def __enter__(self) -> Self:
        self._bars.start()
        self._line = self._bars.add_task("", total=1.0, left="")
        return self

    def __exit__(self, *_) -> None:
        self._bars.stop()

    def __call__(self, step: str, total: int, answers: Iterator) -> Iterator:
        """Hands on the answers of a step and shows how far they are."""
        name, began = step.partition(" (")[0], time.monotonic()
        name = next((usual for usual in self._usual if name == usual or name.startswith(f"{usual} ")), name)
        if name in self._usual:  # what stands before it has passed, if only because nothing was left of it to do
            names = list(self._usual)
            self._passed |= {*names[: names.index(name)]}
        self._show(step, 0, total, self._left(name, 0, total, 0.0))
        for done, answer in enumerate(answers, start=1):
            yield answer
            self._show(step, done, total, self._left(name, done, total, time.monotonic() - began))
        self._passed |= {name} & self._usual.keys()

    def _left(self, name: str, done: int, total: int, spent: float) -> float:
        """Seconds left for the whole; NaN while nobody can know."""
        before = sum(self._usual[n] for n in self._passed - {name})
        usual = self._usual.get(name, 0.0) if name not in self._passed else 0.0
        elapsed = time.monotonic() - self._began
        pace = (elapsed - spent + _DOUBT) / (before + _DOUBT)
        own = spent * (total - done) / done if done else pace * usual if usual else float("nan")
        to_come = sum(self._usual[n] for n in self._usual.keys() - self._passed - {name})
        return own + pace * to_come

    def _show(self, step: str, done: int, total: int, left: float) -> None:
        now = time.monotonic()
        told = f"about {in_words(left)} left" if left > 0.0 else ""
        share = (now - self._began) / (now - self._began + left) if left == left and now > self._began else 0.0
        if self._console.is_terminal:
            self._bars.update(self._line, description=f"{step} {done}/{total}", completed=share, left=told)
        elif now - self._logged > LOG_SECONDS:
            self._logged = now
            print(f"{step}: {done} of {total}{told and f', {told}'}", file=sys.stderr, flush=True)


def in_words(seconds: float) -> str:
    """A duration as one says it: 40 s, 3 min, 2 h 10 min."""
    if seconds < 90:
        return f"{max(5 * round(seconds / 5), 5):.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"
