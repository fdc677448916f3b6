"""A process of an engine and what it starts: bounded in resident memory, and ended together.

The process that is to be supervised forks. The copy goes on as before; the process itself stays as its supervisor,
which runs no code of an engine. It is the reaper of all that the copy starts (PR_SET_CHILD_SUBREAPER, prctl(2)): what
opens a session of its own, or is left by its parent, becomes the supervisor's child, and is ended with it. Linux;
elsewhere processes that leave their group are not found, and memory is not bounded.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

# <linux/prctl.h>
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36
# Seconds between two looks at the copy's memory, and at that of what it started, for which all processes are read, in
# 3 ms.
_LOOK, _LOOK_AT_ALL = 0.25, 1.0
# Seconds in which processes that are killed are gone; one in the midst of a system call may take that long.
_KILL_SECONDS = 5.0
# By this signal a supervisor ends whose copy held too much memory: no program of ours or of an engine's sends it.
TOO_MUCH_MEMORY = signal.SIGRTMAX if hasattr(signal, "SIGRTMAX") else signal.SIGUSR2


def supervise(memory: int, first: Callable[[], None] = lambda: None) -> None:
    """Fork: return in the copy; stay as its supervisor in this process, and end as the copy does.

    When the copy has ended, when this process gets SIGTERM or its parent ends, and when the copy and what it started
    hold more than `memory` bytes (the supervisor then ends by the signal TOO_MUCH_MEMORY), all of them are ended.
    `first` is called in the supervisor: to close what is the copy's.
    """
    signals = {signal.SIGCHLD, signal.SIGTERM}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    be_reaper()
    own = os.getpid()
    copy = os.fork()
    if copy == 0:
        end_with_parent(own)
        be_reaper()  # so that it sees what its calls leave behind
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        return
    first()
    _stay(copy, memory, signals)


def end_with_parent(parent: int, by: int = signal.SIGKILL) -> None:
    """Let the system send this process a signal when its parent ends; end it now if that is gone (Linux)."""
    if _prctl(_PR_SET_PDEATHSIG, by) and os.getppid() != parent:
        os._exit(1)


def be_reaper() -> None:
    """Become the parent of what the descendants of this process leave behind (Linux)."""
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)


def _prctl(option: int, value: int) -> bool:
    if sys.platform != "linux":
        return False
    import ctypes

    ctypes.CDLL(None).prctl(option, value, 0, 0, 0)
    return True


def _stay(copy: int, memory: int, signals: set[signal.Signals]) -> NoReturn:
    """Wait for the copy's end, or end it; then this process ends in the same way."""
    last_scan = time.monotonic()
    while True:
        came = signal.sigtimedwait(signals, _LOOK) if hasattr(signal, "sigtimedwait") else signal.sigwait(signals)
        status = _reap_child(copy)
        if status is not None:
            _end_all()
            _end_as(os.waitstatus_to_exitcode(status))
        if came is not None and (came == signal.SIGTERM or getattr(came, "si_signo", 0) == signal.SIGTERM):
            _end_all()
            _end_as(-signal.SIGTERM)
        every = time.monotonic() - last_scan > _LOOK_AT_ALL
        last_scan = time.monotonic() if every else last_scan
        family = [copy, *descendants(copy)] if every else [copy]
        # Pages that processes share count once; that is slower to learn, and asked only where it may matter.
        if _sum(family, _resident) > memory and _sum(family, _share) > memory:
            _end_all()
            _end_as(-TOO_MUCH_MEMORY)


def _reap_child(copy: int) -> int | None:
    """Let children that have ended be gone; the status of the copy if it is among them."""
    found = None
    with suppress(ChildProcessError):
        while (pid_and_status := os.waitpid(-1, os.WNOHANG))[0]:
            if pid_and_status[0] == copy:
                found = pid_and_status[1]
    return found


def _end_all() -> None:
    """Kill everything below this process, until there is nothing: what is left by its parent becomes its child."""
    until = time.monotonic() + _KILL_SECONDS
    while time.monotonic() < until:
        for process in descendants(os.getpid()):
            with suppress(ProcessLookupError, PermissionError):
                os.kill(process, signal.SIGKILL)
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return
        time.sleep(0.002)


def _end_as(exitcode: int) -> NoReturn:
    """End this process with an exit status, or by a signal (less than 0)."""
    if exitcode >= 0:
        os._exit(exitcode)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with suppress(OSError, ValueError):  # SIGKILL has no handler
        signal.signal(-exitcode, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {-exitcode})
    os.kill(os.getpid(), -exitcode)
    time.sleep(1.0)
    os._exit(1)


# --- what the system says of processes --------------------------------------------------------------------------------


def descendants(process: int) -> list[int]:
    """All processes below one, nearest first; none where the system does not say (it does on Linux)."""
    below: dict[int, list[int]] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        fields = _fields(entry)
        if fields:
            below.setdefault(int(fields[1]), []).append(int(entry.name))
    found = list(below.get(process, ()))
    for each in found:
        found += below.get(each, ())
    return found


def _fields(entry: Path) -> list[str]:
    """The fields of /proc/PID/stat after the program's name, which may hold anything (proc(5)): state, parent, …"""
    try:
        return (entry / "stat").read_text(errors="replace").rpartition(")")[2].split()
    except OSError:  # it has ended
        return []


def _resident(process: int) -> int:
    """Bytes of memory that a process holds, shared pages included."""
    fields = _fields(Path("/proc") / str(process))
    return int(fields[21]) * os.sysconf("SC_PAGE_SIZE") if fields else 0


def _share(process: int) -> int:
    """Bytes of memory that a process holds, with its share of shared pages (Pss of smaps_rollup)."""
    try:
        lines = (Path("/proc") / str(process) / "smaps_rollup").read_text().splitlines()
    except OSError:
        return _resident(process)
    return next((int(line.split()[1]) * 1024 for line in lines if line.startswith("Pss:")), 0)


def _sum(family: list[int], of: Callable[[int], int]) -> int:
    return sum(map(of, family))
