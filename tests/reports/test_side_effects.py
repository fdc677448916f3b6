"""What an adapter does to its process changes no digit of another's rows, and its own row says what happened."""

import ctypes
import platform
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

import cases
from adapters.processes import worker
from reports.running import experiment, solvers, tasks
from reports.running.calls import Calls
from reports.running.clocked_run import engine_code
from reports.running.records import Experiment, Run

from .. import fake_adapter, side_effects
from .identical import identical

CASE = cases.load(fake_adapter.CASE)


def comparable(runs: Iterable[Run]) -> list[Run]:
    """Runs without their times."""
    return [replace(run, when="", cost=replace(run.cost, cpu_s=0.0, wall_s=0.0, setup_s=0.0)) for run in runs]


def rows(names: tuple[str, ...], rungs: int | None = None, own_rungs: int = 2) -> Experiment:
    """Of adapters with side effects `own_rungs` settings run, of others `rungs`."""

    def thin(case, solver, route, settings):
        return settings[: own_rungs if solver in side_effects.EFFECTS else rungs]

    with Calls(2) as calls:
        return experiment.run_cases((CASE,), names, calls, thin=thin)


def check_own_rows(name: str, runs: Iterable[Run], rungs: int = 2) -> None:
    _, outcome, reason = side_effects.EFFECTS[name]
    said = [(run.outcome, run.reason) for run in runs if run.solver == name]
    assert len(said) == rungs and all(o == outcome and reason in why for o, why in said), (name, said)


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Puts adapters with side effects where they are found."""

    def put(names):
        for name in names:
            side_effects.install(tmp_path, name)
        monkeypatch.syspath_prepend(tmp_path)  # last: adapters are searched once for each search path

    return put


def test_what_an_adapter_does_to_its_process_reaches_no_other_row(install):
    name = "numpy_hypot"
    install([name])
    found = rows((name, "pymunk"), rungs=2)
    check_own_rows(name, found.runs)
    others = [run for run in found.runs if run.solver == "pymunk"]
    truth = found.truths[CASE.label]
    for run in others:
        again = tasks.measure(CASE, run.solver, run.route, run.setting, run.rung, truth)
        assert identical(comparable([run]), comparable([again]))
    assert sum(run.outcome == "answered" for run in others) > 1


def test_what_judges_a_motion_is_out_of_reach_of_its_engine(install):
    """With limits, scores and functions of its own an engine that is far off was excellent, or crashed."""
    install(["wrong", "wrong_and_flattered"])
    runs = rows(("wrong", "wrong_and_flattered")).runs
    honest, other = runs[: len(runs) // 2], runs[len(runs) // 2 :]
    assert {run.solver for run in other} == {"wrong_and_flattered"} and len(other) == 2
    assert all(run.outcome == "answered" and run.grade != "excellent" for run in honest)
    assert identical(
        comparable(replace(run, solver="") for run in honest), comparable(replace(run, solver="") for run in other)
    )


@pytest.mark.slow
def test_no_side_effect_of_an_adapter_reaches_another_row(install):
    names, others = tuple(side_effects.EFFECTS), ("reference", "pymunk", "exudyn")
    assert len(names) >= 40
    # The first settings of each route: what an adapter leaves behind would show in any, and the finest take minutes.
    undisturbed = rows(others, rungs=3)
    install(names)
    # One run of each: a worker that a run has changed is replaced, which takes seconds.
    runs = rows((*names, *others), rungs=3, own_rungs=1).runs
    for name in names:
        check_own_rows(name, runs, rungs=1)
    assert sum(run.outcome == "answered" for run in undisturbed.runs) > 10
    assert identical(comparable(run for run in runs if run.solver in others), comparable(undisturbed.runs))


def test_no_engine_is_loaded_among_the_references_calls(monkeypatch):
    monkeypatch.setattr(worker, "group", "")
    with pytest.raises(RuntimeError, match="must not load an engine"):
        solvers.solver("pymunk")
    monkeypatch.setattr(worker, "group", "pymunk")
    assert solvers.solver("pymunk").NAME == "pymunk"


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the constant is that processor's")
def test_rounding_and_numpys_errors_are_restored_after_an_engines_code():
    least, errors = 5e-324, np.geterr()
    with engine_code():
        ctypes.CDLL("libm.so.6").fesetround(0x800)  # upwards
        np.seterr(all="raise")
        assert least * 0.5 > 0.0 and np.geterr() != errors
    assert least * 0.5 == 0.0 and np.geterr() == errors
