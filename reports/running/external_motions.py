"""External trajectories in the full report: `python -m reports.build --trajectory NAME@CASE=FILE.csv`.

NAME becomes a solver of its own, its route is "file" and its setting the file's name; several files of one name are
its rungs, from coarse to fine in the order given. They are read and judged as by `reports.compare`. Nobody saw them
run, so they have no time and are ranked nowhere by it.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from adapters import Setting
from adapters.common import motion_file
from cases import BadValue, Case, CaseError, Cost, DoesNotFit, Trajectory
from cases.errors import unknown_name

from ..judging import diagnosis
from .records import Experiment, Run, Truth
from .tasks import judge, true_motion

ROUTE = "file"
LONGEST_NAME = 60
FORM = "--trajectory NAME=FILE.csv, or NAME@CASE=FILE.csv in a report of several cases"
# NAME, then perhaps @CASE, whose brackets may hold the equals signs of its parameters, then =FILE.
_FORM = re.compile(r"(?P<name>[^@=]+)(@(?P<case>[^=\[]+(\[[^\]]*\])?))?=(?P<file>.+)", re.DOTALL)


@dataclass(frozen=True)
class External:
    """One trajectory: its solver's name, its case, where it came from (with a digest of the file), and its motion."""

    name: str
    case: Case
    file: str
    digest: str
    motion: Trajectory
    columns: dict[str, np.ndarray]  # as the file has them
    route: str = ROUTE


def from_options(texts: Sequence[str], cases: Sequence[Case], solvers: Sequence[str]) -> tuple[External, ...]:
    """The trajectories of the options, read and checked; raises CaseError with one sentence that names the option."""
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
    """The trajectory of a file, which creeps so much (m/s) while it sticks; raises CaseError, in one sentence, if it is
    none of the case's."""
    table = motion_file.read_table(file)
    motion = motion_file.trajectory_of(case, table, creep)
    # A dollar sign begins a formula in a figure.
    shown = "".join(c if c.isprintable() and c not in "$<>" else "_" for c in file.name)[-LONGEST_NAME:]
    digest = hashlib.sha256(file.read_bytes()).hexdigest()[:12]
    return External(name, case, shown, digest, motion, motion_file.columns_of(table), route)


def _case(text: str, label: str | None, cases: Sequence[Case]) -> Case:
    """The one case of the report that is meant."""
    if label is None:
        if len(cases) != 1:
            raise BadValue(f"--trajectory {text!r} names no case, and the report has {len(cases)}; give {FORM}")
        return cases[0]
    found = [case for case in cases if label.strip() in (case.label, case.name)]
    if len(found) > 1:
        labels = ", ".join(case.label for case in found)
        raise BadValue(f"--trajectory {text!r} fits {len(found)} cases; give one of {labels}")
    if not found:
        raise unknown_name("case in this report", label.strip(), [case.label for case in cases])
    return found[0]


def join_external(experiment: Experiment, trajectories: Sequence[External]) -> Experiment:
    """The experiment with the trajectories' runs after the solvers' of their case."""
    runs = list(experiment.runs)
    rungs: dict[tuple[str, str], int] = {}
    for given in trajectories:
        rung = rungs[given.name, given.case.label] = rungs.get((given.name, given.case.label), 0) + 1
        run = judge_motion(given, rung, experiment.truths[given.case.label])
        after = max((i for i, other in enumerate(runs) if other.case == run.case), default=len(runs) - 1)
        runs.insert(after + 1, run)
    return replace(experiment, runs=tuple(runs))


def judge_motion(given: External, rung: int, truth: Truth) -> Run:
    """The trajectory's row, judged like any solver's."""
    row = Run(given.case.label, given.name, given.route, Setting.of(file=given.file), rung, outcome="")
    row = replace(row, cost=Cost(steps=len(given.motion.t) - 1), status=given.motion.status)
    try:
        return judge_external(row, given.case, given.motion, truth, given.columns)
    except DoesNotFit as problem:
        return replace(row, outcome="refused", reason=str(problem))


def judge_external(row: Run, case: Case, motion: Trajectory, truth: Truth, columns: diagnosis.Columns) -> Run:
    """The row with its verdict, ledger and errors, and what is noticed about its columns; raises DoesNotFit if there is
    no truth to judge it by."""
    if truth.failure:
        raise DoesNotFit(f"there is no truth to judge it by: {truth.failure}")
    true = true_motion(case, truth.method)
    run = judge(row, case, motion, true, truth)
    said = [run.reason, diagnosis.half_step(columns), diagnosis.slip_half_a_step_beside(case, motion)]
    said += [diagnosis.mirror_axis(columns, true), diagnosis.other_unit(columns, true)]
    return replace(run, reason="; ".join(text for text in said if text))


def sources(trajectories: Sequence[External]) -> dict[str, str]:
    """What the manifest tells in place of a version, by solver's name: the files and their digests."""
    told: dict[str, list[str]] = {}
    for given in trajectories:
        told.setdefault(given.name, []).append(f"{given.file} (sha256 {given.digest})")
    return {name: "a trajectory from " + ", ".join(files) for name, files in told.items()}
