"""Progress of a command: one live line with the remaining time on a terminal, a line per minute in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars

# A progress display: takes a step's name, the number of answers and the answers, and yields the answers.
Progress = Callable[[str, int, Iterator], Iterator]

# Seconds between two lines in a log.
LOG_SECONDS = 60.0
# Seconds at the expected pace that are added to the measured time: a first step of one second says little about the
# pace of minutes.
_DOUBT = 10.0

# Seconds of each step of a default report of 62 cases on two cores, in their order: for each case, and for all. The
# pace on another machine is measured as the steps pass.
_CASE_SECONDS = {"versions": 0.0, "truth": 0.3, "survey": 0.03, "runs": 0.8}
_TIMING_SECONDS = {"timings": 15.0, "null scores": 3.0, "cold starts and parts": 15.0}
_STUDY_SECONDS = {"scenes": 9.0, "reference": 17.0, "engines": 13.0}
_FIGURE_SECONDS = {"figures": 6.0}


def usual(cases: int, timings: bool, studies: bool) -> dict[str, float]:
    """The steps of a report and their usual durations (s), for `Display`."""
    each = {name: cases * seconds for name, seconds in _CASE_SECONDS.items()}
    return each | (_TIMING_SECONDS if timings else {}) | (_STUDY_SECONDS if studies else {}) | _FIGURE_SECONDS


def silent(step: str, total: int, answers: Iterator) -> Iterator:
    """A progress display that shows nothing."""
    return answers


class Display:
    """The progress display for all steps of a command; a context manager.

    `usual`: the steps in their order with their usual durations (s); a step that occurs again, such as "survey", counts
    at its first place. The remaining time is that of the current step at its own pace, plus that of later steps at the
    pace of the earlier ones; without `usual` that of the current step alone.
    """

    def __init__(self, usual: Mapping[str, float] | None = None, console: Console | None = None):
        self._usual = dict(usual or {})
        self._console = console or Console(file=getattr(sys.stderr, "direct", sys.stderr))
        self._bars = Bars(
            TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[remaining]}"), TimeElapsedColumn(),
            console=self._console, transient=True, disable=not self._console.is_terminal,
        )  # fmt: skip
        self._last_log = self._began = time.monotonic()
        self._past_steps: set[str] = set()

    def __enter__(self) -> Self:
        self._bars.start()
        self._line = self._bars.add_task("", total=1.0, remaining="")
        return self

    def __exit__(self, *_) -> None:
        self._bars.stop()

    def __call__(self, step: str, total: int, answers: Iterator) -> Iterator:
        """Yield the answers of a step and show their count."""
        name, began = step.partition(" (")[0], time.monotonic()
        name = next((usual for usual in self._usual if name == usual or name.startswith(f"{usual} ")), name)
        if name in self._usual:  # earlier steps have passed, perhaps because they had nothing to do
            names = list(self._usual)
            self._past_steps |= {*names[: names.index(name)]}
        self._show(step, 0, total, self._remaining(name, 0, total, 0.0))
        for count, answer in enumerate(answers, start=1):
            yield answer
            self._show(step, count, total, self._remaining(name, count, total, time.monotonic() - began))
        self._past_steps |= {name} & self._usual.keys()

    def _remaining(self, name: str, count: int, total: int, seconds: float) -> float:
        """Remaining seconds of the command; NaN if no estimate is possible yet."""
        before = sum(self._usual[n] for n in self._past_steps - {name})
        usual = self._usual.get(name, 0.0) if name not in self._past_steps else 0.0
        elapsed_s = time.monotonic() - self._began
        pace = (elapsed_s - seconds + _DOUBT) / (before + _DOUBT)
        own = seconds * (total - count) / count if count else pace * usual if usual else float("nan")
        to_come = sum(self._usual[n] for n in self._usual.keys() - self._past_steps - {name})
        return own + pace * to_come

    def _show(self, step: str, count: int, total: int, remaining: float) -> None:
        now = time.monotonic()
        message = f"about {in_words(remaining)} left" if remaining > 0.0 else ""
        share = (
            (now - self._began) / (now - self._began + remaining)
            if remaining == remaining and now > self._began
            else 0.0
        )
        if self._console.is_terminal:
            self._bars.update(self._line, description=f"{step} {count}/{total}", completed=share, remaining=message)
        elif now - self._last_log > LOG_SECONDS:
            self._last_log = now
            print(f"{step}: {count} of {total}{message and f', {message}'}", file=sys.stderr, flush=True)


def in_words(seconds: float) -> str:
    """A rounded duration as text: 40 s, 3 min, 2 h 10 min."""
    if seconds < 90:
        return f"{max(5 * round(seconds / 5), 5):.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"
