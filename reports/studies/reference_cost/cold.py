"""What a new process pays: importing the reference, and its first motion, with a cache on disk and without."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import cases
from cases import kept

_IMPORT = "import time; began = time.process_time(); import reference; print(time.process_time() - began)"
_FIRST = """
import sys, time
import cases, reference
began = time.process_time()
reference.simulate(cases.load(sys.argv[1])).transitions
print(time.process_time() - began)
"""
# Of so many new processes the quickest tells: what else the machine does only adds.
PROCESSES = 3
# Where the suite lies: what is run by `python -c` imports first what lies where it is run, maybe somebody's `cases`.
_HOME = Path(cases.__file__).parents[1]


class Cold(NamedTuple):
    """CPU s beyond imports of the first motion of new processes: without a cache on disk, and with one."""

    without_s: float
    warm_s: float


def _told(program: str, *words: str) -> float:
    argv = [sys.executable, "-c", program, *words]
    told = subprocess.run(argv, check=True, capture_output=True, text=True, cwd=_HOME)
    return float(told.stdout)


def imported() -> float:
    """CPU s of `import reference` in a new process."""
    return min(_told(_IMPORT) for _ in range(PROCESSES))


def first_motion(label: str) -> Cold:
    """The case's first motion in new processes."""
    with kept.off():
        without = _told(_FIRST, label)
    # NaN where nothing is kept on this machine.
    if kept.place() is None:
        return Cold(without, float("nan"))
    _told(_FIRST, label)
    return Cold(without, min(_told(_FIRST, label) for _ in range(PROCESSES)))


def labels(full: bool) -> list[str]:
    """The first variant of every case of the catalogue; of every eighth unless it is a full study."""
    names = cases.names()
    return [cases.select(name)[0].label for name in (names if full else names[::8])]
