"""Ctrl-C is said in one sentence, whatever a command is at; imports are most of the first second of all of them.

Each room imports this first of all. It does nothing but where Python was started with `-m`: in a script, a notebook or
a test, Ctrl-C is theirs.
"""

from __future__ import annotations

import sys
from types import TracebackType

# While `python -m` imports the packages of what it is to run, this stands where the program's name will.
_IMPORTING = "-m"


def say_so(command: str) -> None:
    """Let an interrupt that nobody catches end this process with a line that names the command."""
    usual = sys.excepthook

    def hook(kind: type[BaseException], problem: BaseException, trace: TracebackType | None) -> None:
        interrupt = _interrupt_behind(problem)
        if interrupt is None:
            usual(kind, problem, trace)
        else:
            print(f"\n{command}: stopped{str(interrupt) and f'; {interrupt}'}", file=sys.stderr)

    sys.excepthook = hook


def _interrupt_behind(problem: BaseException | None) -> KeyboardInterrupt | None:
    """The interrupt that brought a problem about: modules in C make an ImportError of one."""
    while problem is not None and not isinstance(problem, KeyboardInterrupt):
        problem = problem.__cause__ or problem.__context__
    return problem


if sys.argv[:1] == [_IMPORTING]:
    words = sys.orig_argv
    say_so(words[words.index(_IMPORTING) + 1] if _IMPORTING in words[:-1] else "python -m")
