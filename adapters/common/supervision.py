"""Supervise an engine's process and its child processes: limit their resident memory, and end them together.

The process to be supervised forks. The copy continues as before; the original process becomes its supervisor, which
runs no code of an engine. The supervisor is the reaper of all processes that the copy starts
(PR_SET_CHILD_SUBREAPER, prctl(2)): a process that opens a session of its own, or whose parent ends, becomes the
supervisor's child, and is ended with it. Linux only; on other systems processes that leave their group are not found,
and memory is not limited.
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
# Seconds between two checks of the copy's memory, and of the memory of its descendants. The latter reads all processes,
# in 3 ms, where the kernel does not list children.
_LOOK, _LOOK_AT_ALL = 0.25, 1.0
# Seconds until killed processes have ended; a process inside a system call may take that long.
_KILL_SECONDS = 5.0
# The signal by which a supervisor ends if its copy exceeds the memory limit; neither the suite nor an engine sends it.
TOO_MUCH_MEMORY = signal.SIGRTMAX if hasattr(signal, "SIGRTMAX") else signal.SIGUSR2


def supervise(memory: int, first: Callable[[], None] = lambda: None) -> None:
    """Fork: return in the copy; supervise it in this process, and end with the copy's exit status.

    All processes are ended when the copy ends, when this process gets SIGTERM or its parent ends, and when the copy and
    its descendants hold more than `memory` bytes (the supervisor then ends by the signal TOO_MUCH_MEMORY). `first` is
    called in the supervisor, to close files that belong to the copy.
    """
    signals = {signal.SIGCHLD, signal.SIGTERM}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    be_reaper()
    own = os.getpid()
    copy = os.fork()
    if copy == 0:
        end_with_parent(own)
        be_reaper()  # so that it inherits the processes that its calls leave behind
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        return
    first()
    _stay(copy, memory, signals)


def end_with_parent(parent: int, by: int = signal.SIGKILL) -> None:
    """Make the system send this process a signal when its parent ends; end it now if the parent has ended (Linux)."""
    if _prctl(_PR_SET_PDEATHSIG, by) and os.getppid() != parent:
        os._exit(1)


def be_reaper() -> None:
    """Become the parent of orphaned descendants of this process (Linux)."""
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)


def _prctl(option: int, value: int) -> bool:
    if sys.platform != "linux":
        return False
    import ctypes

    ctypes.CDLL(None).prctl(option, value, 0, 0, 0)
    return True


def _stay(copy: int, memory: int, signals: set[signal.Signals]) -> NoReturn:
    """Wait for the copy's end, or end it; then end this process in the same way."""
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
        # Count shared pages once; this is slower to read, so only where it can decide.
        if _sum(family, _resident) > memory and _sum(family, _share) > memory:
            _end_all()
            _end_as(-TOO_MUCH_MEMORY)


def _reap_child(copy: int) -> int | None:
    """Reap children that have ended; the status of the copy if it is one of them."""
    copy_status = None
    with suppress(ChildProcessError):
        while (pid_and_status := os.waitpid(-1, os.WNOHANG))[0]:
            if pid_and_status[0] == copy:
                copy_status = pid_and_status[1]
    return copy_status


def _end_all() -> None:
    """Kill all descendants of this process, repeatedly: orphans become its children."""
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


# --- information on processes -----------------------------------------------------------------------------------------


def descendants(process: int) -> list[int]:
    """All descendants of a process, nearest first; empty where the system has no /proc (it has on Linux).

    The kernel lists the children of each thread in a file, if it is configured so; else all processes are read, which
    takes as long as a hundred such files. A list may lack a process while one of its siblings ends."""
    children_of = _listed_children if _LISTED.exists() else _scanned_children()
    processes = children_of(process)
    for each in processes:
        processes += children_of(each)
    return processes


# This thread's own list, whose presence shows whether the kernel makes them (proc_pid_task(5)).
_LISTED = Path("/proc/thread-self/children")


def _listed_children(process: int) -> list[int]:
    children: list[int] = []
    for file in Path(f"/proc/{process}/task").glob("*/children"):
        with suppress(OSError):  # the thread has ended
            children += map(int, file.read_text().split())
    return children


def _scanned_children() -> Callable[[int], list[int]]:
    """The children of processes by one reading of all processes."""
    below: dict[int, list[int]] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        fields = _fields(entry)
        if fields:
            below.setdefault(int(fields[1]), []).append(int(entry.name))
    return lambda process: list(below.get(process, ()))


def _fields(entry: Path) -> list[str]:
    """The fields of /proc/PID/stat after the program's name, which may contain anything (proc(5)): state, parent, …"""
    try:
        return (entry / "stat").read_text(errors="replace").rpartition(")")[2].split()
    except OSError:  # it has ended
        return []


def _resident(process: int) -> int:
    """The memory of a process in bytes, shared pages included."""
    fields = _fields(Path("/proc") / str(process))
    return int(fields[21]) * os.sysconf("SC_PAGE_SIZE") if fields else 0


def _share(process: int) -> int:
    """The memory of a process in bytes, with its share of shared pages (Pss of smaps_rollup)."""
    try:
        lines = (Path("/proc") / str(process) / "smaps_rollup").read_text().splitlines()
    except OSError:
        return _resident(process)
    return next((int(line.split()[1]) * 1024 for line in lines if line.startswith("Pss:")), 0)


def _sum(family: list[int], of: Callable[[int], int]) -> int:
    return sum(map(of, family))
