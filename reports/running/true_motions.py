"""The motions that runs are compared with: computed in one worker of a pool, read in the others."""

from __future__ import annotations

import pickle
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

import numpy as np

from adapters import Setting
from cases import Case, Trajectory, owned_folder

from . import reference_adapter
from .clocked_run import run_on_clock
from .processes import worker_process
from .records import TRUTH_RTOL
from .storage.fingerprint import content, digest


@lru_cache(maxsize=2)
def true_motion(case: Case, method: str) -> Trajectory:
    """The motion that runs are compared with, made and timed as a run of the reference: it is one of its runs.

    A worker without engines writes it to its pool's folder, where the other workers read it: to compile the equations
    in each of them takes ten times as long. An engine may change how its process computes, so its worker writes none.
    """
    file = _file(case, method)
    if file and file.exists():
        return pickle.loads(file.read_bytes())
    with np.errstate(all="ignore"):  # non-finite values end the motion with a reason
        motion = run_on_clock(reference_adapter, case, method, Setting.of(rtol=TRUTH_RTOL))
    if file and worker_process.group == "":
        with suppress(OSError):  # the disk is full, or the file too large: the others then compute the motion
            owned_folder.write(file, pickle.dumps(motion), durable=False)
    return motion


def _file(case: Case, method: str) -> Path | None:
    """The motion's file; None outside workers, and for a case that cannot be compared."""
    folder, same = worker_process.pool_folder, content(case)
    return folder / f"{digest([same, method])}.motion" if folder and same else None
