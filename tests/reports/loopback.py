"""A Dask scheduler and workers on loopback, for tests."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]


class Processes:
    """A scheduler and workers in processes of their own, so that they can be killed."""

    def __init__(self, folder: Path):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.folder, self.address = folder, f"tcp://127.0.0.1:{self.port}"
        self.workers: list[subprocess.Popen] = []
        self.start_scheduler()

    def _start(self, module: str, *words: str, path: str = "") -> subprocess.Popen:
        where = os.pathsep.join(filter(None, [path, str(ROOT)]))
        environment = {**os.environ, "PYTHONPATH": where}
        command = [sys.executable, "-m", f"distributed.cli.{module}", *words, "--no-dashboard"]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen(command, env=environment, cwd=self.folder, **quiet)

    def start_scheduler(self) -> None:
        self.scheduler = self._start("dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port))

    def restart_scheduler(self) -> None:
        """End the scheduler for longer than a client tries to reconnect by itself; it comes back with two workers."""
        self.scheduler.kill()
        self.scheduler.wait()
        time.sleep(12.0)
        self.start_scheduler()
        self.start_worker(), self.start_worker()

    def start_worker(self, path: str = "") -> subprocess.Popen:
        words = [self.address, "--nthreads", "1", "--no-nanny", "--local-directory", str(self.folder)]
        self.workers.append(self._start("dask_worker", *words, path=path))
        return self.workers[-1]

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.send_signal(signal.SIGKILL)
            process.wait()
