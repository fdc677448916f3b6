"""Every command ends with one line on Ctrl-C, also during imports, which take most of its first second.

Each room imports this module first. It has an effect only where Python was started with `-m` or as the console command,
not in a script, a notebook or a test.
"""

from __future__ import annotations

import _thread
import atexit
import signal
import sys
import time
from types import FrameType, TracebackType

# While `python -m` imports packages, this is in the place of the program's name.
_IMPORTING = "-m"
# The name of the file that pip makes of the console command.
_CONSOLE = "slip-to-roll"
# Long enough for a callback of Python's own (microseconds) to return before the interrupt is raised again.
_PAUSE = 0.01


def say_so(command: str) -> None:
    """Make an uncaught interrupt end this process with a line that names the command."""
    usual, came = sys.excepthook, False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = True
        signal.default_int_handler(number, frame)

    def hook(kind: type[BaseException], problem: BaseException, trace: TracebackType | None) -> None:
        interrupt = _interrupt_behind(problem)
        if interrupt is not None or came:  # modules in C may replace it by an error of their own
            print(f"\n{command}: stopped{f'; {interrupt}' if str(interrupt or '') else ''}", file=sys.stderr)
        else:
            usual(kind, problem, trace)

    usual_unraisable = sys.unraisablehook

    def unraisable(given) -> None:
        if isinstance(given.exc_value, KeyboardInterrupt):  # in a callback, where Python prints and ignores it
            _thread.start_new_thread(_interrupt_again, ())
        else:
            usual_unraisable(given)

    sys.excepthook, sys.unraisablehook = hook, unraisable
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, note)
        # Ignore an interrupt while Python shuts down, after the command's last output.
        atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)


def _interrupt_again() -> None:
    time.sleep(_PAUSE)
    _thread.interrupt_main()


def _interrupt_behind(problem: BaseException | None) -> KeyboardInterrupt | None:
    """The interrupt that caused an exception: modules in C turn one into an ImportError."""
    while problem is not None and not isinstance(problem, KeyboardInterrupt):
        problem = problem.__cause__ or problem.__context__
    return problem


if sys.argv[:1] == [_IMPORTING]:
    words = sys.orig_argv
    say_so(words[words.index(_IMPORTING) + 1] if _IMPORTING in words[:-1] else "python -m")
elif sys.argv and sys.argv[0].endswith(_CONSOLE):
    say_so(_CONSOLE)
