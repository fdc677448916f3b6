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
        if issubclass(kind, KeyboardInterrupt):
            print(f"\n{command}: stopped{str(problem) and f'; {problem}'}", file=sys.stderr)
        else:
            usual(kind, problem, trace)

    sys.excepthook = hook


if sys.argv[:1] == [_IMPORTING]:
    words = sys.orig_argv
    say_so(words[words.index(_IMPORTING) + 1] if _IMPORTING in words[:-1] else "python -m")
