"""What every kind of hostile or unlucky input shares: it is run, or refused in one sentence, and none else."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import pkgutil
import random
import signal
import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from typing import Any

from cases import CaseError

# Characters: a sentence with the longest list of names in it.
ONE_SENTENCE = 600
# Seconds of CPU time an input may take (the longest took forty), and of wall time on a machine that is busy with other
# things, or where it waits for what never comes.
LATEST, LATEST_WALL = 120.0, 1200.0

Call = Callable[[], object]


@dataclass(frozen=True)
class Kind:
    """`draw` makes an input from a source of chance: what it is, in words, and the call that tries it. `found` are
    inputs that once did neither run nor say what is wrong: they are always tried, and `long` ones, which take ten
    seconds and more, in `make test-all`. `whole` inputs are drawn in `make test-all`, `sample` in `make test`. The
    result of a call that ran may be looked at by `check`."""

    name: str
    draw: Callable[[random.Random], tuple[str, Call]]
    whole: int
    sample: int
    found: tuple[tuple[str, Call], ...] = ()
    long: tuple[tuple[str, Call], ...] = ()


class Late(KeyboardInterrupt):
    """No Exception, so that nothing on the way takes it for one of its own."""


@contextlib.contextmanager
def within(seconds: float, wall: float):
    """Raises Late where the block takes longer: by CPU time, or by the clock on the wall."""
    assert threading.current_thread() is threading.main_thread()

    def late(number: int, _):
        raise Late(f"still running after {f'{wall:g}' if number == signal.SIGALRM else f'{seconds:g} CPU'} s")

    timers = ((signal.ITIMER_PROF, signal.SIGPROF, seconds), (signal.ITIMER_REAL, signal.SIGALRM, wall))
    before = [signal.signal(number, late) for _, number, _ in timers]
    for timer, _, most in timers:
        signal.setitimer(timer, most)
    try:
        yield
    finally:
        for (timer, number, _), handler in zip(timers, before, strict=True):
            signal.setitimer(timer, 0.0)
            signal.signal(number, handler)


def refused_well(problem: CaseError) -> None:
    """The error's text is one sentence that a person can read."""
    text = str(problem)
    assert 10 < len(text) <= ONE_SENTENCE, text[:200]
    assert "\n" not in text and "Traceback" not in text
    assert text.isprintable(), text


def tried(call: Call) -> str:
    """ "ran" or "refused"; anything else it may do is an error."""
    with within(LATEST, LATEST_WALL):
        try:
            call()
        except CaseError as problem:
            refused_well(problem)
            return "refused"
        return "ran"


def told_by(command: Callable[[list[str]], int], words) -> tuple[int, str, str]:
    """Exit status and what a command prints; SystemExit counts as its status."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status: Any = command(list(words))
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 1
    return status, out.getvalue(), err.getvalue()


def run_command(command: Callable[[list[str]], int], words) -> None:
    """A command does what it is asked, or raises CaseError with its one line, status 2."""
    status, _, err = told_by(command, words)
    assert status in (0, 2), (words, status, err)
    assert "Traceback" not in err and "usage:" not in err, err
    if status == 2:
        assert err.strip() and err.count("\n") == 1, err
        raise CaseError(err.strip())


def seed() -> int:
    """Of a whole run: another each night, or SLIP_TO_ROLL_FUZZ_SEED."""
    return int(os.environ.get("SLIP_TO_ROLL_FUZZ_SEED", date.today().toordinal()))


def kinds() -> tuple[Kind, ...]:
    """All kinds, by name."""
    from . import kinds as folder

    names = [module.name for module in pkgutil.iter_modules(folder.__path__)]
    return tuple(importlib.import_module(f"{folder.__name__}.{name}").KIND for name in sorted(names))


def trial(kind: Kind, number: int, chosen: int) -> tuple[str, Call]:
    """One input again: its number in the kind under a seed."""
    kept = kind.found + kind.long
    if number < len(kept):
        return kept[number]
    return kind.draw(random.Random(f"{kind.name} {chosen} {number}"))


def sweep(kind: Kind, count: int, chosen: int, long: bool) -> tuple[Counter[str], list[str]]:
    """Try the kept inputs of a kind, the long ones too if `long`, and `count` drawn ones: how many ran, were refused or
    did neither ("else"), and a line for each of these."""
    table: Counter[str] = Counter()
    failures = []
    found, kept = len(kind.found), len(kind.found) + len(kind.long)
    for number in (*range(kept if long else found), *range(kept, kept + count)):
        words, call = trial(kind, number, chosen)
        try:
            table[tried(call)] += 1
        except (Exception, Late, SystemExit) as problem:
            table["else"] += 1
            failures.append(f"{number}: {words[:300]} -> {type(problem).__name__}: {str(problem)[:300]}")
    return table, failures
