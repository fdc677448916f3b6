"""External trajectories in the full report: `slip-to-roll report --trajectory NAME@CASE=FILE.csv`.

NAME becomes a separate solver with the route "file" and the file's name as its setting; several files with one name are
its rungs, from coarse to fine in the order of the options. They are read and judged as by `reports.compare`. Their run
times are unknown, so they are not in rankings by time.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from adapters import Setting
from adapters.common import motion_file, motion_table
from cases import BadValue, Case, CaseError, Cost, DoesNotFit, Trajectory
from cases.errors import unknown_name

from ..judging import diagnosis
from ..judging.mean_errors import complete_times
from .records import Experiment, Run, Truth
from .tasks import judge
from .true_motions import columns_at, true_motion

if TYPE_CHECKING:
    import pandas as pd

ROUTE = "file"
LONGEST_NAME = 60
FORM = "--trajectory NAME=FILE.csv, or NAME@CASE=FILE.csv in a report of several cases"
# NAME, then perhaps @CASE, whose brackets may hold the equals signs of its parameters, then =FILE.
_FORM = re.compile(r"(?P<name>[^@=]+)(@(?P<case>[^=\[]+(\[[^\]]*\])?))?=(?P<file>.+)", re.DOTALL)


@dataclass(frozen=True)
class External:
    """An external trajectory: its solver's name, case, file with digest, and motion."""

    name: str
    case: Case
    file: str
    digest: str
    motion: Trajectory
    columns: dict[str, np.ndarray]  # as in the file
    route: str = ROUTE


def from_options(texts: Sequence[str], cases: Sequence[Case], solvers: Sequence[str]) -> tuple[External, ...]:
    """Read and check the trajectories of the options; raises CaseError with a message that names the option."""
    return tuple(_of_option(text, cases, solvers) for text in texts)


def _of_option(text: str, cases: Sequence[Case], solvers: Sequence[str]) -> External:
    parts = _FORM.fullmatch(text)
    if not parts:
        raise BadValue(f"--trajectory is {text!r}; give {FORM}")
    name, file = parts["name"].strip(), Path(parts["file"].strip()).expanduser()
    if not name.isprintable() or len(name) > LONGEST_NAME or set(name) & set("$<>/\\"):
        raise BadValue(f"--trajectory names {name!r}; give up to {LONGEST_NAME} letters, digits, spaces and hyphens")
    if name in solvers:
        raise BadValue(f"--trajectory {text!r} takes the name of the solver {name}; give another name")
    case = _case(text, parts["case"], cases)
    try:
        return read(name, case, file)
    except CaseError as problem:
        raise type(problem)(f"--trajectory {text!r}: {problem}") from problem


def read(name: str, case: Case, file: Path, route: str = ROUTE, creep: float = 0.0) -> External:
    """Read the trajectory in a file; raises CaseError if it is not a motion of the case.

    `creep`: creep velocity of the solver while it sticks, m/s."""
    external = of_table(name, case, motion_table.read(file), creep)
    # A dollar sign starts a formula in a figure.
    display_name = "".join(c if c.isprintable() and c not in "$<>" else "_" for c in file.name)[-LONGEST_NAME:]
    digest = hashlib.sha256(file.read_bytes()).hexdigest()[:12]
    return replace(external, file=display_name, digest=digest, route=route)


def of_table(name: str, case: Case, table: pd.DataFrame, creep: float = 0.0) -> External:
    """The trajectory in a table; raises CaseError if it is not a motion of the case."""
    return External(name, case, "", "", motion_file.trajectory_of(case, table, creep), motion_table.columns_of(table))


def _case(text: str, label: str | None, cases: Sequence[Case]) -> Case:
    """The case of the report that the option selects."""
    if label is None:
        if len(cases) != 1:
            raise BadValue(f"--trajectory {text!r} names no case, and the report has {len(cases)}; give {FORM}")
        return cases[0]
    matches = [case for case in cases if label.strip() in (case.label, case.name)]
    if len(matches) > 1:
        labels = ", ".join(case.label for case in matches)
        raise BadValue(f"--trajectory {text!r} fits {len(matches)} cases; give one of {labels}")
    if not matches:
        raise unknown_name("case in this report", label.strip(), [case.label for case in cases])
    return matches[0]


def join_external(experiment: Experiment, trajectories: Sequence[External]) -> Experiment:
    """The experiment with the runs of the trajectories, each after the solvers' runs of its case."""
    runs = list(experiment.runs)
    rungs: dict[tuple[str, str], int] = {}
    for external in trajectories:
        rung = rungs[external.name, external.case.label] = rungs.get((external.name, external.case.label), 0) + 1
        run = judge_motion(external, rung, experiment.truths[external.case.label])
        after = max((i for i, other in enumerate(runs) if other.case == run.case), default=len(runs) - 1)
        runs.insert(after + 1, run)
    return replace(experiment, runs=tuple(runs))


def judge_motion(external: External, rung: int, truth: Truth) -> Run:
    """The row of an external trajectory, judged like a solver's run."""
    case, motion, columns = external.case, external.motion, external.columns
    row = Run(case.label, external.name, external.route, Setting.of(file=external.file), rung, outcome="")
    row = replace(row, cost=Cost(steps=len(motion.t) - 1), status=motion.status)
    if truth.failure:
        return replace(row, outcome="unsupported", reason=f"there is no truth to judge it by: {truth.failure}")
    true = true_motion(case, truth.method)
    run = judge(row, case, motion, true, truth, same_samples=lambda: read_truth(case, motion, columns, true))
    remarks = [run.reason, *diagnosis.mistakes(case, columns, true), diagnosis.slip_half_a_step_beside(case, motion)]
    return replace(run, reason="; ".join(text for text in remarks if text))


def read_truth(case: Case, motion: Trajectory, columns: diagnosis.Columns, true: Trajectory) -> Trajectory | None:
    """The truth as it is read from a file with such columns at a motion's times; None where that is refused: it ends
    within too few samples, or turns too far between two."""
    import pandas as pd  # the import takes half a second, and most reports have no file

    times = complete_times(motion, float(true.t[-1]))
    if len(times) < motion_table.LEAST_SAMPLES:
        return None
    at_times = columns_at(true, times)
    if "slip" in columns:
        at_times["slip"] = np.asarray(true(times).slip)
    table = pd.DataFrame({name: at_times[name] for name in columns if name in at_times})
    try:
        return motion_file.trajectory_of(case, table)
    except DoesNotFit:
        return None


def sources(trajectories: Sequence[External]) -> dict[str, str]:
    """Files and digests by solver's name, for the manifest in place of versions."""
    files: dict[str, list[str]] = {}
    for external in trajectories:
        files.setdefault(external.name, []).append(f"{external.file} (sha256 {external.digest})")
    return {name: "a trajectory from " + ", ".join(files) for name, files in files.items()}
