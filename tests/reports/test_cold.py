"""A first call in a process: what counts as one, what it does not share with others, and what its failure says."""

import sys
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import cases
from adapters import Setting
from adapters.processes.worker import CallResult, call_in_copy
from reports.running.timing import cold_start
from reports.running.timing.clock import Contestant

from .watch import LOOP

LINE = cases.load("disc_on_line", mu=0.1)
BUILD, RUN, READ = 0.5, 0.25, 0.125
CALL = BUILD + RUN + READ


def who(*costs: float, name: str = "engine") -> list[Contestant]:
    return [Contestant(LINE, name, "native", Setting.of(cost=cost), CALL * cost) for cost in costs]


def engine(monkeypatch, adapter) -> None:
    monkeypatch.setattr(cold_start, "solver", lambda name: adapter)


def first_call(one: Contestant) -> cold_start.ColdStart:
    ((found, failure),) = cold_start.first_calls([one], 1000.0).values()
    assert failure == "" and found is not None
    return found


# --- what is measured -------------------------------------------------------------------------------------------------


def test_build_run_and_read_are_cpu_seconds_of_each_and_the_call_is_all_of_them(here, monkeypatch):
    parts = dict(zip(("build", "run", "read"), (BUILD, RUN, READ), strict=True))
    works = {name: here.work(seconds, wall=3 * seconds) for name, seconds in parts.items()}
    works["read"] = lambda model: here.spend(READ, 3 * READ) or SimpleNamespace(t=())
    engine(monkeypatch, SimpleNamespace(**works))
    found = first_call(*who(1.0))
    assert (found.build_s, found.run_s, found.read_s) == pytest.approx((BUILD, RUN, READ))
    assert found.call_s == pytest.approx(CALL)
    assert (found.repeats, found.disturbed) == (cold_start.LEAST_REPEATS, False)


@pytest.mark.parametrize("slow", [0, 1])
def test_a_call_with_a_slow_loop_before_or_after_it_is_disturbed(here, monkeypatch, slow):
    """Of three calls the second is, and takes twice as long: it has no part in the medians."""
    looks, calls = iter(range(100)), iter(range(100))
    monkeypatch.setattr(cold_start, "calibrate", lambda: 2 * LOOP if next(looks) == 2 + slow else LOOP)
    adapter = here.engine(0.0, RUN, READ)
    adapter.run = lambda model: here.spend(2 * RUN if next(calls) == 1 else RUN)
    engine(monkeypatch, adapter)
    found = first_call(*who(1.0))
    assert (found.run_s, found.repeats, found.disturbed) == (pytest.approx(RUN), 2, False)


# --- in which order, for how long -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("budget", "order"),
    [(1e6, [3.0, *3 * [1.0, 2.0, 3.0]]), (3.5 * CALL, [3.0, 1.0, 2.0]), (0.0, [3.0])],
)
def test_a_first_call_of_the_route_is_for_its_imports_and_then_all_take_turns_cheapest_first(
    here, monkeypatch, budget, order
):
    """As far as the budget goes: what is expected to outlast it is not begun, and has no time."""
    called: list[float] = []
    adapter = here.engine(BUILD, RUN, READ)
    build = adapter.build
    adapter.build = lambda *call: called.append(call[2]["cost"]) or build(*call)
    engine(monkeypatch, adapter)
    some = who(3.0, 1.0, 2.0)
    found = cold_start.first_calls(some, budget)
    assert called == order and list(found) == [one.key for one in some]
    for one in some:
        times, (value, why) = order[1:].count(one.setting["cost"]), found[one.key]
        assert (value.repeats if value else 0, why) == (times, "")
        assert not times or value.run_s == pytest.approx(RUN * one.setting["cost"])


# --- a process of its own ---------------------------------------------------------------------------------------------


@pytest.fixture
def late_module(tmp_path, monkeypatch):
    """A module that nobody has imported."""
    (tmp_path / "imported_late_by_an_engine.py").write_text("x = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield "imported_late_by_an_engine"
    sys.modules.pop("imported_late_by_an_engine", None)


def test_imports_are_no_part_of_a_call_and_no_call_leaves_anything_to_the_next(watch, monkeypatch, late_module):
    """A module that is made in the process, which no file holds, is not imported."""
    adapter, compiled = watch.engine(BUILD, RUN, READ), list[int]()

    def build(case, route, setting):
        if late_module not in sys.modules:
            watch.spend(10.0)
        __import__(late_module)
        sys.modules.setdefault("made_by_an_engine", ModuleType("made_by_an_engine"))
        watch.spend(BUILD)
        return SimpleNamespace(cost=1.0)

    def run(model) -> None:
        watch.spend(RUN if not compiled else 0.0)
        compiled.append(1)

    adapter.build, adapter.run = build, run
    engine(monkeypatch, adapter)
    found = cold_start.first_calls(who(1.0, 2.0), 1000.0)
    assert late_module in sys.modules and "made_by_an_engine" not in sys.modules and compiled == []
    for value, failure in found.values():
        assert (value.build_s, value.run_s) == pytest.approx((BUILD, RUN)) and not failure
        assert value.repeats == cold_start.LEAST_REPEATS


def test_a_route_that_fails_is_tried_once_and_others_go_on(here, monkeypatch):
    tried: list[float] = []

    def solver(name: str):
        if name == "engine":
            return here.engine(BUILD, RUN, READ)
        return SimpleNamespace(build=lambda case, route, setting: tried.append(setting["cost"]) or 1 / 0)

    def apart(function, argument, _):
        try:
            return CallResult("done", function(argument))
        except ZeroDivisionError:
            return CallResult("raised", reason="no more")

    monkeypatch.setattr(cold_start, "solver", solver)
    monkeypatch.setattr(cold_start, "call_in_copy", apart)
    found = cold_start.first_calls([*who(1.0, 2.0, name="bad"), *who(1.0)], 1000.0)
    assert list(found.values())[:2] == [(None, "no more")] * 2 and tried == [1.0]
    assert list(found.values())[2][0].run_s == pytest.approx(RUN)


def children() -> set[str]:
    """This process's children, running or not: other tests may have left some, such as a server of forks."""
    return {pid for file in Path("/proc/self/task").glob("*/children") for pid in file.read_text().split()}


def test_a_call_that_does_not_end_is_ended():
    before, began = children(), time.monotonic()
    assert "took more than 0.3 s" in call_in_copy(lambda _: time.sleep(600.0), None, 0.3).reason
    assert children() <= before and time.monotonic() - began < 300.0
