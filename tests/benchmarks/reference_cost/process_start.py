"""The cost of a new process: import of the reference, and its first motion."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cases

_IMPORT = "import time; began = time.process_time(); import reference; print(time.process_time() - began)"
_FIRST = """
import sys, time
import cases, reference
began = time.process_time()
reference.simulate(cases.load(sys.argv[1])).transitions
print(time.process_time() - began)
"""
# The result is the minimum over this many new processes: other load can only add time.
PROCESSES = 3
# The folder of the suite: `python -c` imports from its working directory first, which might contain another `cases`.
_HOME = Path(cases.__file__).parents[1]


def _measure(program: str, *words: str) -> float:
    argv = [sys.executable, "-c", program, *words]
    process = subprocess.run(argv, check=True, capture_output=True, text=True, cwd=_HOME)
    return float(process.stdout)


def import_seconds() -> float:
    """CPU seconds of `import reference` in a new process."""
    return min(_measure(_IMPORT) for _ in range(PROCESSES))


def first_motion(label: str) -> float:
    """CPU seconds of a case's first motion in a new process, after the imports."""
    return min(_measure(_FIRST, label) for _ in range(PROCESSES))


def labels(full: bool) -> list[str]:
    """The first variant of every eighth case of the catalogue; of every case in a `full` study."""
    names = cases.names()
    return [cases.select(name)[0].label for name in (names if full else names[::8])]
