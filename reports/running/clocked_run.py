"""A run of a solver with its cost: building, running and reading are timed apart."""

from __future__ import annotations

import time
from dataclasses import replace
from types import ModuleType

from adapters import Setting, gate
from cases import Case, Trajectory

from . import reference_adapter
from .processes.worker_process import reap
from .third_party import third_party


def run_on_clock(module: ModuleType, case: Case, route: str, setting: Setting) -> Trajectory:
    """Build, run and read; only `run` is timed as a run, build and read count as set-up. Raises EngineFailure if the
    engine's motion does not pass `adapters.gate`."""
    with third_party():
        began = time.perf_counter()
        model = module.build(case, route, setting)
        setup = time.perf_counter() - began
        cpu, wall = time.process_time(), time.perf_counter()
        module.run(model)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        began = time.perf_counter()
        trajectory = module.read(model)
        setup += time.perf_counter() - began
    reap()
    if getattr(module, "__name__", "") != reference_adapter.__name__:
        trajectory = gate.motion(trajectory, case)
    steps = trajectory.cost.steps or len(trajectory.t) - 1
    if getattr(module, "TELLS_COST", False):
        cpu = trajectory.cost.cpu_s
    return replace(trajectory, cost=replace(trajectory.cost, cpu_s=cpu, wall_s=wall, setup_s=setup, steps=steps))
