"""The motions that runs are compared with: computed in one worker of a pool, read in the others."""

from __future__ import annotations

import pickle
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

import numpy as np

from adapters import Setting
from adapters.common.motion_table import of_plate
from adapters.processes import worker
from cases import Case, Trajectory
from cases.files import owned_folder
from cases.scene.free_plates import POSE

from . import reference_adapter
from .clocked_run import run_on_clock
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
    if file and worker.group == "":
        with suppress(OSError):  # the disk is full, or the file too large: the others then compute the motion
            owned_folder.write(file, pickle.dumps(motion), durable=False)
    return motion


def _file(case: Case, method: str) -> Path | None:
    """The motion's file; None outside workers, and for a case that cannot be compared."""
    folder, same = worker.pool_folder, content(case)
    return folder / f"{digest([same, method])}.motion" if folder and same else None


def columns_at(motion: Trajectory, times: np.ndarray) -> dict[str, np.ndarray]:
    """The columns of a motion with dense output at some times, in the format of `reports.compare`; forces are zero in
    flight."""
    state = motion(times)
    columns = {"t": times, **{name: getattr(state, name) for name in (*POSE, "normal_force", "friction_force")}}
    for plate in motion.plate_names[1:]:
        own = motion.plate(plate)(times)
        columns |= {of_plate(name, plate): getattr(own, name) for name in POSE}
    return {name: np.nan_to_num(values) for name, values in columns.items()}
