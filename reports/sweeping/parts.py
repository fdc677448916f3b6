"""Functions that compute a part of a sweep in a worker: scenarios start … stop − 1 in, bytes of a Parquet file out.

The same functions run in a worker of this machine and of a cluster; their only input is the plan.
"""

from __future__ import annotations

import time
from collections import Counter
from io import BytesIO
from math import isfinite
from typing import NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import parquet

import reference
from adapters import refusal
from adapters.processes.worker import at_once
from cases import BadValue
from reference.sweeping import MANY, Plan, table

from ..running import tasks
from ..running.names import REFERENCE
from ..running.solvers import solver
from ..running.storage import fingerprint

# A trial of a plan: at most so many ranges of 1, 2, 4 … scenarios, the last one of a second or more (CPU time).
PLACES, ENOUGH = 7, 1.0


class SweepWork(NamedTuple):
    """The computation for a plan's scenarios: solver and route ("reference" and "" for the reference), and whether with
    certified error bars."""

    plan: Plan
    solver: str = REFERENCE
    route: str = ""
    certified: bool = False


def environment() -> dict[str, str]:
    """Versions and code that determine the reference's rows on a machine."""
    around = fingerprint.surroundings()
    facts = {"python": around["python"], **around["packages"], "method of the reference": reference.METHODS[0]}
    return dict(sorted((facts | {"code of the suite": fingerprint.sources(table)[:16]}).items()))


def perform(work: SweepWork, start: int, stop: int) -> bytes:
    """The rows of some scenarios as the bytes of a Parquet file."""
    return pack(_rows(work, start, stop))


def _rows(work: SweepWork, start: int, stop: int) -> pa.Table:
    if work.solver == REFERENCE:
        return table.scenario_rows(work.plan, start, stop, len(work.plan) >= MANY, work.certified)
    return of_engine(work, start, stop)


def pack(rows: pa.Table) -> bytes:
    """Rows as the bytes of a Parquet file."""
    stream = BytesIO()
    parquet.write_table(rows, stream, compression="zstd")
    return stream.getvalue()


class Pilot(NamedTuple):
    """What a few scenarios of a plan show: seconds of CPU time for each, whether they are simulated one by one, how
    many were tried, and if none of them is a scene the most frequent reason."""

    seconds: float
    one_by_one: bool
    trials: int
    no_scene: str


def pilot(work: SweepWork) -> Pilot:
    """Try ranges of a plan at PLACES even places, each twice as long as the one before: only long ones show the pace of
    scenarios that are simulated together. It ends once a range took ENOUGH seconds and has a scene. The first one also
    compiles, so its time does not count if there is another."""
    n, size, trials, reasons = len(work.plan), 1, 0, Counter[str]()
    for place in range(PLACES):
        start, began = max(min(place * n // PLACES, n - size), 0), time.process_time()
        rows = _rows(work, start, min(start + size, n)).to_pylist()
        seconds = time.process_time() - began
        trials += len(rows)
        reasons.update(row["reason"] for row in rows if row["outcome"] == table.BAD)
        if trials >= n or (place > 0 and seconds > ENOUGH and reasons.total() < trials):
            break
        size *= 2
    text = reasons.most_common(1)[0][0] if reasons.total() == trials else ""
    return Pilot(seconds / len(rows), all(row.get("alone", True) for row in rows), min(trials, n), text)


def failure_text(work: SweepWork, number: int, outcome: str, reason: str) -> bytes:
    """The row of a scenario that ended its worker or exceeded its time limit, as the bytes of a Parquet file."""
    parameters = work.plan.columns(number, number + 1)
    schema = table.schema(work.plan) if work.solver == REFERENCE else engine_schema(work.plan)
    values = {"scenario": number, "outcome": outcome, "reason": reason}
    values |= {name: float(column[0]) for name, column in parameters.items()}
    return pack(pa.Table.from_pylist([{field.name: values.get(field.name) for field in schema}], schema=schema))


# --- engines ----------------------------------------------------------------------------------------------------------

ENGINE_COLUMNS = {
    "outcome": (pa.string(), "answered, unsupported, crashed or bad_case"),
    "grade": (pa.string(), "off in words, from excellent to unusable; empty: no answer"),
    "off": (pa.float64(), "error as a share of the error of ignoring friction's law"),
    "off_doubt": (pa.float64(), "how much of off may be due to the samples"),
    "friction_factor": (pa.float64(), "friction and other losses over those of the law"),
    "reason": (pa.string(), "why an answer has its grade, or the reason of any other outcome"),
    "setting": (pa.string(), "the engine's default settings"),
    "first_mode": (pa.string(), "the first mode"),
    "first_time": (pa.float64(), "time of the first transition, s"),
    "first_after": (pa.string(), "the mode after it"),
    "reference_time": (pa.float64(), "time of the reference's first transition, s"),
    "reference_after": (pa.string(), "the reference's mode after it"),
    "error": (pa.float64(), "the engine's time minus the reference's, s, if both have one"),
    "cpu_s": (pa.float64(), "CPU time of the engine's run, s"),
}


def engine_schema(plan: Plan) -> pa.Schema:
    """The columns of an engine's rows."""
    fields = [("scenario", pa.int64()), *((axis.name, pa.float64()) for axis in plan.axes)]
    return pa.schema([*fields, *((name, kind) for name, (kind, _) in ENGINE_COLUMNS.items())])


def of_engine(work: SweepWork, start: int, stop: int) -> pa.Table:
    """The rows of an engine with default settings, compared with the reference, scenario by scenario."""
    truth = table.scenario_rows(work.plan, start, stop).to_pylist()
    names = [axis.name for axis in work.plan.axes]
    rows = []
    for reference_row in truth:
        row = {name: reference_row[name] for name in ("scenario", *names)}
        row |= {"reference_time": reference_row["first_time"], "reference_after": reference_row["first_after"] or ""}
        if reference_row["outcome"] in (table.BAD, table.FAILED):
            row |= {"outcome": reference_row["outcome"], "reason": reference_row["reason"]}
        else:
            row |= _engine_run(work, {name: reference_row[name] for name in names}, reference_row)
        rows.append({name: row.get(name) for name in engine_schema(work.plan).names})
    return pa.Table.from_pylist(rows, schema=engine_schema(work.plan))


def _engine_run(work: SweepWork, parameters: dict[str, float], reference_row: dict) -> dict:
    """The columns of one run with the engine's default settings."""
    case, engine = work.plan.make(**parameters), solver(work.solver)
    reason = refusal(engine, case, work.route)
    if reason:
        return {"outcome": "unsupported", "reason": str(reason)}
    setting = next((s for s in engine.ladder(case, work.route) if s.is_default), None)
    if setting is None:
        raise BadValue(f"{work.solver} has no default setting by the route {work.route}")
    true = reference.simulate(case, rtol=work.plan.rtol)
    truth = tasks.truth_of(case, true, true.transitions, reference.METHODS[0])
    run = at_once(tasks.measure(case, work.solver, work.route, setting, 1, truth, true=true))
    row: dict = {"setting": str(setting), "outcome": run.outcome, "reason": run.reason}
    if run.outcome != "answered" or run.score is None:
        return row
    own = [event for event in run.ledger if isfinite(event.time)]
    first = min(own, key=lambda event: event.time, default=None)
    time = first.time if first else np.nan
    return row | {
        "grade": run.grade,
        "off": run.score.off,
        "off_doubt": run.score.doubt,
        "friction_factor": run.friction_factor,
        "first_mode": run.first_mode,
        "first_time": time,
        "first_after": str(first.after) if first else "",
        "error": time - (np.nan if reference_row["first_time"] is None else reference_row["first_time"]),
        "cpu_s": run.cost.cpu_s,
    }
