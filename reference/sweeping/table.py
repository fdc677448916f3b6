"""The table of a sweep: one row per scenario, in Arrow columns, which Parquet stores and pandas reads."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping

import numpy as np
import pyarrow as pa

from cases import BadValue, CaseError, Mode

from .batches import move
from .motions import MODES, Motions, simulate_rows
from .plan import Plan
from .scenario_values import RejectedScenario, ScenarioGroup, scenes, straight

# Separates the modes of a sequence.
ARROW, OF = ">", ": "
# Outcomes without a motion: invalid parameters, and a scenario in which the solver failed.
BAD, FAILED = "bad_case", "failed"

_WORDS = pa.dictionary(pa.int32(), pa.string())
# Every column after the parameters, with its meaning.
COLUMNS: dict[str, tuple[pa.DataType, str]] = {
    "outcome": (_WORDS, "how the motion ended: the trajectory's status, bad_case, or failed"),
    "reason": (_WORDS, "why the motion ended, in one sentence"),
    "sequence": (
        _WORDS,
        "the modes in their order: at the start and after each transition; of several contacts with their names",
    ),
    "transitions": (pa.int32(), "number of changes of mode"),
    "first_time": (pa.float64(), "time of the first transition, s"),
    "first_xi1": (pa.float64(), "track parameter of the first transition"),
    "first_after": (_WORDS, "the mode after the first transition"),
    "times": (pa.list_(pa.float64()), "times of all transitions, s"),
    "at_xi1": (pa.list_(pa.float64()), "track parameters of all transitions"),
    "at_xi2": (pa.list_(pa.float64()), "outline parameters of all transitions"),
    "error_bars": (pa.list_(pa.float64()), "error bars of the times, s, where they were certified"),
    "end": (pa.float64(), "end time of the motion, s"),
    "energy_start": (pa.float64(), "kinetic energy and potential of gravity at the start, J"),
    "energy_end": (pa.float64(), "kinetic energy and potential of gravity at the end, J"),
    "steps": (pa.int32(), "number of integration steps"),
    "cpu_s": (pa.float64(), "CPU time, s: that of its chunk of the sweep, divided evenly"),
    "alone": (pa.bool_(), "whether it was simulated alone, not in a wave"),
}


def check_names(plan: Plan) -> None:
    """Raise BadValue if a parameter has the name of a column of the table."""
    for axis in plan.axes:
        if axis.name in COLUMNS or axis.name == "scenario":
            raise BadValue(f"the parameter {axis.name} has the name of a column of the table; give it another name")


def scenario_rows(plan: Plan, start: int, stop: int, optimised: bool = False, certified: bool = False) -> pa.Table:
    """The table of scenarios start … stop − 1 of a plan."""
    return rows(plan, plan.columns(start, stop), start, optimised, certified)


def rows(
    plan: Plan, parameters: Mapping[str, np.ndarray], start: int = 0, optimised: bool = False, certified: bool = False
) -> pa.Table:
    """The table of scenarios of the plan's case with any parameters, numbered from `start`."""
    began, n = time.thread_time(), len(next(iter(parameters.values())))
    groups, bad = scenes(plan.make, parameters, straight(plan.function))
    results = [(group, _motions(group, plan.rtol, optimised)) for group in groups]
    columns = _columns(n, results, bad)
    columns["error_bars"] = _bars(plan, parameters, columns) if certified else pa.nulls(n, COLUMNS["error_bars"][0])
    columns["cpu_s"] = np.full(n, (time.thread_time() - began) / n)
    inputs = {"scenario": np.arange(start, start + n), **parameters}
    arrays = [pa.array(column) for column in inputs.values()]
    arrays += [_arrow(columns[name], kind) for name, (kind, _) in COLUMNS.items()]
    return pa.Table.from_arrays(arrays, schema=schema(plan))


def schema(plan: Plan) -> pa.Schema:
    """The Arrow schema of a plan's table."""
    fields = [("scenario", pa.int64()), *((axis.name, pa.float64()) for axis in plan.axes)]
    return pa.schema([*fields, *((name, kind) for name, (kind, _) in COLUMNS.items())])


def _arrow(column, kind: pa.DataType) -> pa.Array:
    if isinstance(column, pa.Array):
        return column
    if kind == _WORDS:
        return pa.array(column, pa.string()).dictionary_encode()
    return pa.array(column, kind, from_pandas=True)  # unknown values are null, not NaN


def _motions(group: ScenarioGroup, rtol: float, optimised: bool) -> Motions:
    """Simulate a group; if that fails, simulate its scenarios one by one and mark those that fail."""
    try:
        return move(group, rtol, optimised)
    except Exception as problem:  # one failure must not affect other scenarios
        logging.getLogger("reference").warning("a wave failed (%s: %s); one by one", type(problem).__name__, problem)
    motions = Motions.none(len(group.rows))
    for i in range(len(group.rows)):
        try:
            simulate_rows(group, np.array([i]), rtol, motions)
        except Exception as problem:
            motions.status[i], motions.reason[i] = FAILED, f"{type(problem).__name__}: {problem}"
    return motions


def _columns(n: int, results: list[tuple[ScenarioGroup, Motions]], bad: list[RejectedScenario]) -> dict:
    """The columns of n scenarios, from the results of their groups."""
    nan, nothing = np.full(n, np.nan), np.full(n, "", dtype=object)
    columns: dict = {name: nothing.copy() for name in ("outcome", "reason", "sequence", "first_after")}
    columns |= {name: nan.copy() for name in ("first_time", "first_xi1", "end", "energy_start", "energy_end")}
    columns |= {
        "transitions": np.zeros(n, dtype=int),
        "steps": np.zeros(n, dtype=int),
        "alone": np.zeros(n, dtype=bool),
    }
    for row, reason in bad:
        columns["outcome"][row], columns["reason"][row] = BAD, reason
    owners, events = [np.empty(0, dtype=int)], [np.empty((3, 0))]
    for group, motions in results:
        rows, all_of_it = group.rows, motions.events
        columns["outcome"][rows], columns["reason"][rows] = motions.status, motions.reason
        for name in ("end", "energy_start", "energy_end", "steps", "alone"):
            columns[name][rows] = getattr(motions, name)
        indices, first = np.unique(all_of_it.scenario, return_index=True)
        columns["transitions"][rows] = np.bincount(all_of_it.scenario, minlength=len(rows))
        columns["first_time"][rows[indices]], columns["first_xi1"][rows[indices]] = (
            all_of_it.time[first],
            all_of_it.xi1[first],
        )
        names = np.array([*map(str, MODES)], dtype=object)
        columns["first_after"][rows[indices]] = names[all_of_it.after[first]]
        columns["sequence"][rows] = _sequences(motions, len(rows))
        owners.append(rows[all_of_it.scenario])
        events.append(np.array([all_of_it.time, all_of_it.xi1, all_of_it.xi2]))
    owner, flat = np.concatenate(owners), np.concatenate(events, axis=1)
    order = np.argsort(owner, kind="stable")
    offsets = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=n))]).astype(np.int32)
    for name, row in zip(("times", "at_xi1", "at_xi2"), flat, strict=True):
        columns[name] = pa.ListArray.from_arrays(offsets, row[order])
    return columns


def _sequences(motions: Motions, n: int) -> np.ndarray:
    """The sequence of modes of each scenario, as text."""
    offsets = np.concatenate([[0], np.cumsum(np.bincount(motions.events.scenario, minlength=n))]).tolist()
    changes = [*zip(motions.events.after.tolist(), motions.events.contact.tolist(), strict=True)]
    texts = np.full(n, "", dtype=object)
    cache: dict[tuple[tuple[int, str], ...], str] = {}
    for i, first in enumerate(motions.first.tolist()):
        codes = ((first, ""), *changes[offsets[i] : offsets[i + 1]])
        if codes not in cache:
            cache[codes] = ARROW.join(f"{name and name + OF}{MODES[code]}" for code, name in codes if code >= 0)
        texts[i] = cache[codes]
    return texts


def mode_of(phase: str) -> tuple[Mode, str]:
    """The mode of a phase in a sequence, and the contact that has it ("" of a single one and at the start)."""
    contact, _, mode = phase.rpartition(OF)
    return Mode(mode), contact


def _bars(plan: Plan, parameters: Mapping[str, np.ndarray], columns: dict) -> pa.Array:
    """The certified error bars of each scenario's transitions; none where the witnesses do not agree with it."""
    from ..certification.certificate import certify  # imports the second formulation, which is slow

    bars: list[list[float] | None] = []
    for i, sequence in enumerate(columns["sequence"].tolist()):
        bars.append(None)
        if columns["outcome"][i] in (BAD, FAILED):
            continue
        try:
            certificate = certify(plan.make(**{name: float(column[i]) for name, column in parameters.items()}))
        except CaseError as problem:
            columns["reason"][i] += f" Not certified: {problem}"
            continue
        modes = [after for _, after, *_ in certificate.transitions]
        if modes == [mode_of(phase)[0] for phase in sequence.split(ARROW)[1:]]:
            bars[-1] = [time.bar for _, _, time, _ in certificate.transitions]
        else:
            columns["reason"][i] += f" Not certified: the witnesses find {ARROW.join(modes) or 'no transition'}."
    return pa.array(bars, COLUMNS["error_bars"][0])
