"""What an adapter does to its process changes no digit of another's rows, and its own row says what happened."""

import ctypes
import decimal
import gc
import importlib
import os
import platform
import resource
import signal
import sys
from collections.abc import Iterable
from copy import deepcopy
from dataclasses import replace
from types import FunctionType

import numpy as np
import pytest

import cases
import reference
from reports.running import experiment, solvers, tasks
from reports.running.calls import Calls
from reports.running.canary import Canary
from reports.running.processes import worker_process
from reports.running.records import Experiment, Run
from reports.running.third_party import third_party

from .. import fake_adapter, side_effects
from .identical import identical

pytestmark = pytest.mark.builds

CASE = cases.load(fake_adapter.CASE)


def comparable(runs: Iterable[Run]) -> list[Run]:
    """Runs without their times."""
    return [replace(run, when="", cost=replace(run.cost, cpu_s=0.0, wall_s=0.0, setup_s=0.0)) for run in runs]


def rows(names: tuple[str, ...], rungs: int | None = None) -> Experiment:
    with Calls(2) as calls:
        return experiment.run_cases((CASE,), names, calls, thin=lambda case, solver, route, settings: settings[:rungs])


def check_own_rows(name: str, runs: Iterable[Run]) -> None:
    _, outcome, reason = side_effects.EFFECTS[name]
    said = [(run.outcome, run.reason) for run in runs if run.solver == name]
    assert len(said) == 2 and all(o == outcome and reason in why for o, why in said), (name, said)


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
        again = tasks.perform(CASE, run.solver, run.route, run.setting, run.rung, truth)
        if not run.samples:  # only the finest run of a route keeps all that figures draw
            again = replace(again, samples={}, off=again.off if run.off else {})
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
    runs = rows((*names, *others), rungs=3).runs
    for name in names:
        check_own_rows(name, runs)
    assert sum(run.outcome == "answered" for run in undisturbed.runs) > 10
    assert identical(comparable(run for run in runs if run.solver in others), comparable(undisturbed.runs))


def test_no_engine_is_loaded_among_the_references_calls(monkeypatch):
    monkeypatch.setattr(worker_process, "group", "")
    with pytest.raises(RuntimeError, match="must not load an engine"):
        solvers.solver("pymunk")
    monkeypatch.setattr(worker_process, "group", "pymunk")
    assert solvers.solver("pymunk").NAME == "pymunk"


@pytest.fixture(scope="module")
def canary():
    return Canary()


@pytest.mark.parametrize(
    "place, name",
    [("numpy", "hypot"), ("cases.motion.trajectory", "Trajectory.__call__"), ("reference", "simulate")],
)
def test_a_replaced_function_is_named(place, name, canary, monkeypatch):
    owner, _, attribute = f"{place}.{name}".rpartition(".")
    assert canary.change() == ""
    with monkeypatch.context() as patch:
        patch.setattr(f"{owner}.{attribute}", lambda *given: None)
        assert canary.change().endswith(f"{name} was replaced")
    assert canary.change() == ""


@pytest.mark.parametrize(
    ("module", "name", "value"), [("grades", "LIMITS", {"excellent": 1e9}), ("grades", "USUAL_FRICTION", (0.0, 9.0))]
)
def test_a_changed_limit_of_judging_is_named(module, name, value, canary, monkeypatch):
    """Of a table the content counts, too: with the first an engine 13 % off was excellent."""
    judging = importlib.import_module(f"reports.judging.{module}")
    assert canary.change() == ""
    with monkeypatch.context() as patch:
        if isinstance(value, dict):
            patch.setitem(getattr(judging, name), judging.Grade.EXCELLENT, 1e9)
        else:
            patch.setattr(judging, name, value)
        assert canary.change().startswith(f"reports.judging.{module}.{name} was ")
    assert canary.change() == ""


def double(values: np.ndarray) -> None:
    values.flags.writeable = True
    values *= 2.0


@pytest.mark.parametrize(
    ("place", "change"),
    [
        (
            "reports.judging.score.score_and_reading",
            lambda score: setattr(score, "__code__", (lambda *_: None).__code__),
        ),
        ("reports.judging.grades.grade", lambda grade: setattr(grade, "__defaults__", (1e9, 0.0))),
        ("reports.judging.residuals._GAUSS", lambda nodes: double(nodes[1])),
    ],
)
def test_what_is_exchanged_inside_a_function_or_a_table_is_named(place, change, monkeypatch):
    """The objects are the same as before."""
    module, _, name = place.rpartition(".")
    value = getattr(importlib.import_module(module), name)
    copies = deepcopy(value) if isinstance(value, tuple) else FunctionType(value.__code__, vars(sys.modules[module]))
    monkeypatch.setattr(f"{module}.{name}", copies)
    canary = Canary(known_run=False)
    assert canary.change() == ""
    change(copies)
    assert canary.change().endswith(f"{name} was changed")


def test_a_late_import_that_is_stored_as_it_is_is_no_replacement(canary, monkeypatch):
    monkeypatch.setitem(vars(reference), "simulate", reference.simulate)
    assert canary.change() == ""


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the constant is that processor's")
def test_a_known_run_gives_other_numbers_where_rounding_has_changed(canary):
    with third_party():
        ctypes.CDLL("libm.so.6").fesetround(0x800)  # upwards
        assert canary.change() == "a known run gives other numbers"
    assert canary.change() == ""


def test_settings_of_the_process_are_restored_after_an_engines_code(tmp_path):
    def settings():
        context, handler = decimal.getcontext().prec, signal.getsignal(signal.SIGUSR2)
        limit = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
        return os.getcwd(), context, handler, limit, sys.getrecursionlimit(), gc.isenabled(), np.geterr()

    before = settings()
    with third_party():
        os.chdir(tmp_path)
        decimal.getcontext().prec = 2
        signal.signal(signal.SIGUSR2, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_NOFILE, (64, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
        sys.setrecursionlimit(500)
        gc.disable()
        np.seterr(all="raise")
        assert all(now != then for now, then in zip(settings(), before, strict=True))
    assert settings() == before


def test_imports_find_what_they_found_before_and_then_what_an_engine_added(tmp_path):
    """NumPy imports its masked arrays at the first median, and an engine may import its own parts later."""
    (tmp_path / "part_of_an_engine.py").write_text("")
    (tmp_path / "colorsys.py").write_text("raise AssertionError")
    lists = sys.path, sys.path_hooks, sys.meta_path
    before = [list(one) for one in lists]
    finder = type("Fails", (), {"find_spec": lambda *given: 1 / 0})()
    try:
        with third_party():
            sys.path = [str(tmp_path), sys.path[0]]
            sys.path_hooks.clear()
            sys.meta_path.insert(0, finder)
        assert sys.path == [*before[0], str(tmp_path)]
        assert sys.path_hooks == before[1] and sys.meta_path == [*before[2], finder]
        for name in ("colorsys", "part_of_an_engine"):
            sys.modules.pop(name, None)
            importlib.import_module(name)
    finally:
        sys.path, sys.path_hooks, sys.meta_path = lists
        for one, entries in zip(lists, before, strict=True):
            one[:] = entries
