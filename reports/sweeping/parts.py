"""A part of a sweep, as a worker does it: scenarios start … stop − 1 in, the bytes of a Parquet file out.

The same functions run in a worker of this machine and in one of a cluster; all they are given is the plan.
"""

from __future__ import annotations

import platform
import time
from io import BytesIO
from typing import NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import parquet

import reference
from adapters import EngineFailure
from cases import BadValue, NotSupported
from reference.sweeping import MANY, Plan, table

from ..judging import soundness
from ..running import fingerprint, tasks
from ..running.records import REFERENCE
from ..running.solvers import solver


class Work(NamedTuple):
    """What is to be done with a plan's scenarios: by which solver and route ("reference" and "": the reference), with
    certified error bars or not."""

    plan: Plan
    solver: str = REFERENCE
    route: str = ""
    certified: bool = False


def made_with() -> dict[str, str]:
    """What decides the reference's rows on a machine: versions and code."""
    packages = ("numpy", "scipy", "sympy", "heyoka")
    told = {"python": platform.python_version(), "method of the reference": reference.METHODS[0]}
    told |= {package: fingerprint.installed(package) for package in packages}
    return dict(sorted((told | {"code of the suite": fingerprint.sources(table)[:16]}).items()))


def perform(work: Work, start: int, stop: int) -> bytes:
    """The rows of some scenarios as the bytes of a Parquet file."""
    if work.solver == REFERENCE:
        return packed(table.solved(work.plan, start, stop, len(work.plan) >= MANY, work.certified))
    return packed(of_engine(work, start, stop))


def packed(rows: pa.Table) -> bytes:
    """Rows as the bytes of a Parquet file."""
    stream = BytesIO()
    parquet.write_table(rows, stream, compression="zstd")
    return stream.getvalue()


def rate(work: Work) -> float:
    """Scenarios a second, CPU time of one core, of a few stretches of the plan; what is compiled is not counted."""
    n, few = len(work.plan), 1 if work.solver != REFERENCE else 64
    starts = sorted({0, n // 3, 2 * n // 3, max(n - few, 0)})
    perform(work, starts[0], min(starts[0] + few, n))
    began, done = time.process_time(), 0
    for start in starts:
        perform(work, start, min(start + few, n))
        done += min(start + few, n) - start
        if time.process_time() - began > 5.0:
            break
    return done / max(time.process_time() - began, 1e-6)


def failed(work: Work, number: int, outcome: str, reason: str) -> bytes:
    """The row of a scenario that ended its worker, or ran out of time."""
    parameters = work.plan.columns(number, number + 1)
    schema = table.schema(work.plan) if work.solver == REFERENCE else engine_schema(work.plan)
    known = {"scenario": number, "outcome": outcome, "reason": reason}
    known |= {name: float(column[0]) for name, column in parameters.items()}
    return packed(pa.Table.from_pylist([{field.name: known.get(field.name) for field in schema}], schema=schema))


# --- engines ----------------------------------------------------------------------------------------------------------

ENGINE_COLUMNS = {
    "outcome": (pa.string(), "done, refused, crashed or bad_case"),
    "reason": (pa.string(), "why it is not done"),
    "setting": (pa.string(), "the engine as it comes"),
    "first_mode": (pa.string(), "the mode it begins with"),
    "first_time": (pa.float64(), "when its first transition is, s"),
    "first_after": (pa.string(), "and what follows"),
    "reference_time": (pa.float64(), "the same of the reference, s"),
    "reference_after": (pa.string(), "and what follows there"),
    "error": (pa.float64(), "the engine's time minus the reference's, s, where both have one"),
    "verdict": (pa.string(), "right, or wrong: another first mode, or another mode or none after it"),
    "cpu_s": (pa.float64(), "CPU time of the engine's run, s"),
}


def engine_schema(plan: Plan) -> pa.Schema:
    """The columns of an engine's rows."""
    fields = [("scenario", pa.int64()), *((axis.name, pa.float64()) for axis in plan.axes)]
    return pa.schema([*fields, *((name, kind) for name, (kind, _) in ENGINE_COLUMNS.items())])


def of_engine(work: Work, start: int, stop: int) -> pa.Table:
    """An engine as it comes, scenario by scenario, beside the reference."""
    truth = table.solved(work.plan, start, stop).to_pylist()
    names = [axis.name for axis in work.plan.axes]
    rows = []
    for known in truth:
        row = {name: known[name] for name in ("scenario", *names)}
        row |= {"reference_time": known["first_time"], "reference_after": known["first_after"] or ""}
        if known["outcome"] in (table.BAD, table.FAILED):
            row |= {"outcome": known["outcome"], "reason": known["reason"]}
        else:
            row |= _engine_run(work, {name: known[name] for name in names}, known)
        rows.append({name: row.get(name) for name in engine_schema(work.plan).names})
    return pa.Table.from_pylist(rows, schema=engine_schema(work.plan))


def _engine_run(work: Work, parameters: dict[str, float], known: dict) -> dict:
    """What came of one run at the engine's own settings."""
    case, engine = work.plan.make(**parameters), solver(work.solver)
    refusal = engine.refuses(case, work.route)
    if refusal:
        return {"outcome": "refused", "reason": str(refusal)}
    setting = next((s for s in engine.ladder(case, work.route) if s.is_default), None)
    if setting is None:
        raise BadValue(f"{work.solver} has no default setting by the route {work.route}")
    row: dict = {"setting": str(setting)}
    try:
        motion = tasks.timed(engine, case, work.route, setting)
    except NotSupported as problem:
        return row | {"outcome": "refused", "reason": str(problem)}
    except EngineFailure as problem:
        return row | {"outcome": "crashed", "reason": str(problem)}
    except Exception as problem:
        return row | {"outcome": "crashed", "reason": tasks.sentence(problem)}
    if not soundness.sound(motion):
        return row | {"outcome": "crashed", "reason": f"it gave {soundness.UNSOUND}"}
    told = tasks.reading_of(case, motion)
    first = told.transitions[0] if told.transitions else None
    row |= {"outcome": "done", "first_mode": str(told.first_mode), "cpu_s": motion.cost.cpu_s}
    row |= {"first_time": first.time if first else np.nan, "first_after": str(first.after) if first else ""}
    row["error"] = row["first_time"] - (np.nan if known["first_time"] is None else known["first_time"])
    sequence = known["sequence"].split(table.ARROW)[:2]
    own = [row["first_mode"], *([row["first_after"]] if first else [])]
    inside = first is None or 0.0 <= first.time <= case.duration  # a slip may be extrapolated to beyond its end
    return row | {"verdict": "right" if own == sequence and inside else "wrong"}
