"""A run of a solver with its cost: building, running and reading are timed apart."""

from __future__ import annotations

import ctypes
import ctypes.util
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter, process_time  # by name, so that an engine cannot replace them
from types import ModuleType
from typing import Any

import numpy as np

from adapters import Setting, gate
from adapters.processes.worker import reap
from cases import Case, Trajectory

from . import reference_adapter

# Bytes of the C library's fenv_t; the largest, of x86-64, has 32.
_FENV_BYTES = 512


def _floating_point() -> tuple[Any, Any] | None:
    """The C math library and the floating-point environment of this process; None if there is none."""
    try:
        maths = ctypes.CDLL(ctypes.util.find_library("m"))
        environment = ctypes.create_string_buffer(_FENV_BYTES)
        return None if maths.fegetenv(environment) else (maths, environment)
    except (OSError, AttributeError):
        return None


# State at the start of a process: rounding to nearest, subnormal numbers enabled.
_AT_FIRST = _floating_point()


@contextmanager
def engine_code() -> Iterator[None]:
    """A context manager for an engine's code, after which the process computes as before: its rounding and NumPy's
    handling of errors are restored. Other state may stay changed, in the engine's own workers."""
    with np.errstate():
        try:
            yield
        finally:
            if _AT_FIRST is not None:
                maths, environment = _AT_FIRST
                maths.fesetenv(environment)


def run_on_clock(module: ModuleType, case: Case, route: str, setting: Setting) -> Trajectory:
    """Build, run and read; only `run` is timed as a run, build and read count as set-up. Raises EngineFailure if the
    engine's motion does not pass `adapters.gate`."""
    with engine_code():
        began = perf_counter()
        model = module.build(case, route, setting)
        setup = perf_counter() - began
        cpu, wall = process_time(), perf_counter()
        module.run(model)
        cpu, wall = process_time() - cpu, perf_counter() - wall
        began = perf_counter()
        trajectory = module.read(model)
        setup += perf_counter() - began
    reap()
    if getattr(module, "__name__", "") != reference_adapter.__name__:
        trajectory = gate.motion(trajectory, case)
    steps = trajectory.cost.steps or len(trajectory.t) - 1
    if getattr(module, "TELLS_COST", False):
        cpu = trajectory.cost.cpu_s
    return replace(trajectory, cost=replace(trajectory.cost, cpu_s=cpu, wall_s=wall, setup_s=setup, steps=steps))
