"""Code that all commands share: the argument parser, and the exit status with its message."""

from __future__ import annotations

import argparse
import io
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from contextvars import ContextVar
from typing import Any, NoReturn

from ..errors import BadValue, CaseError, choice, printable, unknown_name
from . import owned_folder

# Equations in quadruple precision need 1.5 GB of address space to compile. With less than 1 GB SciPy's BLAS waits for
# its buffers without end while it is imported.
_ADDRESS_BYTES = 2 * 2**30


# How the user called each command, by module, if not as `python -m MODULE`: the console command sets this.
PROGRAMS: ContextVar[Mapping[str, str]] = ContextVar("programs", default={})  # noqa: B039 - it is never changed


def program(command: str) -> str:
    """A command as the user types it: "reports.build" or, with a subcommand, "cases show"."""
    module, _, rest = command.partition(" ")
    return f"{PROGRAMS.get().get(module, f'python -m {module}')} {rest}".strip()


def label(command: str) -> str:
    """A command's name before its messages: "slip-to-roll sweep", or its module."""
    return program(command).removeprefix("python -m ")


# What --log-level accepts: messages of that kind and of those after it are printed.
LOG_LEVELS = ("debug", "info", "warning", "error")


class Parser(argparse.ArgumentParser):
    """An argument parser that reports errors as CaseError, in one sentence, and accepts no abbreviated options. All
    commands have its option --log-level, of the messages that this process logs."""

    def __init__(self, **how):
        super().__init__(allow_abbrev=False, **how)
        self.add_argument(
            "--log-level", metavar="LEVEL", help=f"messages to print: {', '.join(LOG_LEVELS)} (default: warning)"
        )

    def parse_args(self, args=None, namespace=None):
        """As argparse, which takes "--name=--" for an option without a value and then returns a list for it."""
        words = sys.argv[1:] if args is None else list(args)
        for word in words:
            if word.startswith("--") and word.endswith("=--"):
                self.error(f"{word.removesuffix('=--')} has no value but --")
        result = super().parse_args(words, namespace)
        level = vars(result).pop("log_level")
        if level is not None:
            level = choice("--log-level", level, LOG_LEVELS)
            logging.basicConfig(level=level.upper(), format="%(name)s: %(message)s", stream=sys.stderr, force=True)
        return result

    def error(self, message: str) -> NoReturn:
        """Raise UnknownName for an unknown option, BadValue for anything else."""
        stray = message.removeprefix("unrecognized arguments: ")
        if stray != message:
            word = (stray.split() or [""])[0]
            if word and not word.startswith("-"):
                raise BadValue(f"{word!r} is one argument too many; see {self.prog} --help")
            options = [o for action in self._actions for o in action.option_strings if o.startswith("--")]
            raise unknown_name("option", word, options)
        raise BadValue(f"{message}; see {self.prog} --help")


def status(command: str, work: Callable[[list[str]], int | None], argv: Sequence[str] | None) -> int:
    """Run a command and return its exit status.

    It is the result of `work`, or 0; 2 for an invalid request, 1 if files cannot be read or written, 130 on Ctrl-C. An
    error is printed in one line.
    """
    name = label(command)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # so that no character makes a command fail
    code = 130
    try:
        with _inert_streams(), _terminable() as terminations:
            try:
                return _status(name, work, list(sys.argv[1:] if argv is None else argv))
            finally:
                code = 143 if terminations else 130
    except KeyboardInterrupt as stop:
        owned_folder.remove_partials()
        print(f"\n{name}: stopped{str(stop) and f'; {stop}'}", file=sys.stderr)  # a progress bar may be on the line
        return code


def _status(name: str, work: Callable[[list[str]], int | None], words: list[str]) -> int:
    """The same, except for Ctrl-C."""
    try:
        _check_address_space()
        code = work(words) or 0
        sys.stdout.flush()  # so that a pipe that is closed shows here
        return code
    except BrokenPipeError:  # whoever reads has enough, as `head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE if hasattr(signal, "SIGPIPE") else 1
    except CaseError as problem:
        print(f"{name}: {problem}", file=sys.stderr)
        return 2
    except OSError as problem:
        print(f"{name}: {problem}", file=sys.stderr)
        return 1


class _InertStream:
    """A stream that spells out what a terminal acts on in everything that is printed; `direct` is the stream itself."""

    def __init__(self, stream: Any):
        self.direct = stream

    def write(self, text: str) -> int:
        """Write a text; returns its length."""
        self.direct.write(printable(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.direct, name)


@contextmanager
def _inert_streams() -> Iterator[None]:
    """A context manager in which names of files, and all else that a command prints, are only text."""
    with redirect_stdout(_InertStream(sys.stdout)), redirect_stderr(_InertStream(sys.stderr)):
        yield


@contextmanager
def _terminable() -> Iterator[list[int]]:
    """A context manager in which SIGTERM interrupts as Ctrl-C does, so that unfinished files are removed; yields the
    list of such signals so far."""
    came: list[int] = []

    def interrupt(number: int, frame: object) -> None:
        came.append(number)
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGTERM) != signal.SIG_DFL:
        yield came
        return
    signal.signal(signal.SIGTERM, interrupt)
    try:
        yield came
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _check_address_space() -> None:
    """Raise BadValue if the shell allows less address space than the suite needs."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    most = resource.getrlimit(resource.RLIMIT_AS)[0]
    if most != resource.RLIM_INFINITY and most < _ADDRESS_BYTES:
        raise BadValue(
            f"the shell limits the address space to {most / 2**30:.2g} GB, and {_ADDRESS_BYTES / 2**30:g} GB are "
            "needed; type: ulimit -v unlimited"
        )
