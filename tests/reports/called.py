"""What tests have workers call, apart from the tests: a worker that imports pytest begins a fifth of a second later."""

from __future__ import annotations

import mmap
import os
import shutil
import signal
import stat
import sys
import time
from contextlib import suppress
from pathlib import Path

from adapters.processes import worker

MAP_NORESERVE = 0x4000  # <sys/mman.h> of Linux
kept: list[bytes] = []


def misbehave(how: str):
    """One way each in which an engine may fail; "work" gives the folder it worked in."""
    if how == "work":
        print("said something")
        return os.getcwd(), os.listdir(".")
    if how == "raise":
        raise RuntimeError("two\nlines")
    if how == "exit":
        sys.exit(3)
    if how == "vanish":
        os._exit(7)
    if how == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    if how == "hang":
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGINT})
        while True:
            time.sleep(1.0)
    if how == "forks":
        os.fork()  # both come back
    if how == "garbage":
        for stream in range(3, 256):
            with suppress(OSError):
                if stat.S_ISSOCK(os.fstat(stream).st_mode):
                    os.write(stream, b"x" * 100)
    if how == "closes":
        os.closerange(3, 64)
    if how == "mumbles":
        raise RuntimeError("\ud800 \x00 \x1b[31m" + "x" * 100_000)
    if how == "unpicklable":
        return lambda: None
    if how == "flood":
        for _ in range(50_000):
            os.write(1, b"x" * 1000)
        with open("big", "wb") as file:
            file.write(b"x" * 40_000_000)
    return how


def reserve(gigabytes: int) -> int:
    """Reserve so much address space without using it, as WebAssembly engines do."""
    with mmap.mmap(-1, gigabytes * 2**30, mmap.MAP_PRIVATE | MAP_NORESERVE) as space:
        return len(space)


def leave_behind(then: str) -> int:
    """Leave a process with a session of its own and no parent here, and write its number down; then end as asked."""
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            Path("left").write_text(str(os.getpid()))
            time.sleep(600.0)
        os._exit(0)
    while not (Path("left").exists() and Path("left").read_text()):
        time.sleep(0.01)
    left = int(Path("left").read_text())
    os.write(2, f"left {left}\n".encode())
    Path(os.environ["LEFT_BEHIND"], then).write_text(str(left))
    return left if then == "return" else misbehave(then)  # type: ignore[return-value]


def ends_itself_at_first(folder: Path, times: int) -> int:
    """End this process as the system would, so many times; then count them."""
    ended = len(list(folder.iterdir()))
    if ended < times:
        (folder / str(ended)).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return ended


def remove_folder_above() -> str:
    """Remove the folder that holds the working folder, as an engine that cleans up too much does."""
    above = Path.cwd().parent
    shutil.rmtree(above)
    return str(above)


def remove_and_fail(folder: Path) -> None:
    """Remove a folder and raise an error that does not say so."""
    shutil.rmtree(folder)
    raise ValueError("no result")


def linger(folder: Path) -> None:
    """Tell where it runs, and stay."""
    (folder / "cwd").write_text(os.getcwd())
    (folder / "pid").write_text(str(os.getpid()))
    time.sleep(600.0)


def whose(thing, number):
    time.sleep(0.3)
    return os.getpid()


def group_of_rest(how: str) -> str | None:
    """The group of the worker that makes the rest of a call."""
    return worker.without_engines(own_group, how)


def own_group(how: str) -> str | None:
    """The group of this worker; or fail."""
    return worker.group if how == "work" else misbehave(how)


def grow(megabytes: int) -> int:
    """Keep so much memory, as a cache would; the process it is kept in."""
    kept.append(b"x" * (megabytes * 2**20))
    return os.getpid()
