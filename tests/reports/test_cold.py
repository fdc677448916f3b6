"""A first call in a process: what counts as one, what it does not share with others, and what its failure says."""

import os
import signal
import sys
import time
from functools import partial
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import cases
from adapters import Setting
from reports.running.timing import cold_start
from reports.running.timing.clock import Contestant

from .watch import LOOP, Watch

pytestmark = pytest.mark.builds

LINE = cases.load("disc_on_line", mu=0.1)
BUILD, RUN, READ = 0.5, 0.25, 0.125
CALL = BUILD + RUN + READ


@pytest.fixture
def watch(monkeypatch) -> Watch:
    """A clock that work alone moves on; its copy in a process that is split off moves on there."""
    watch = Watch()
    monkeypatch.setattr(cold_start, "time", watch)
    monkeypatch.setattr(cold_start, "calibrate", lambda: LOOP)
    return watch


@pytest.fixture
def here(watch, monkeypatch) -> Watch:
    """Calls are made in this process."""
    monkeypatch.setattr(cold_start, "_in_child", lambda function, argument: function(argument))
    return watch


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


def test_samples_that_are_made_when_they_are_asked_for_belong_to_reading(here, monkeypatch):
    class Motion:
        @property
        def t(self):
            here.spend(READ)

    engine(monkeypatch, here.engine(BUILD, RUN, 0.0, read=lambda model: Motion()))
    assert first_call(*who(1.0)).read_s == pytest.approx(READ)


def test_it_is_the_median_of_three(here, monkeypatch):
    seconds = {"build": iter([1.0, 9.0, 2.0]), "run": iter([6.0, 5.0, 50.0])}
    adapter = here.engine(BUILD, RUN, READ)
    adapter.build = lambda case, route, setting: here.spend(next(seconds["build"])) or SimpleNamespace(cost=1.0)
    adapter.run = lambda model: here.spend(next(seconds["run"]))
    engine(monkeypatch, adapter)
    found = first_call(*who(1.0))
    assert (found.build_s, found.run_s) == pytest.approx((2.0, 6.0))


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


def test_where_each_call_of_a_contestant_is_disturbed_its_row_is_marked(here, monkeypatch):
    """By the loops of the others."""
    now = ["quiet"]
    monkeypatch.setattr(cold_start, "calibrate", lambda: {"quiet": LOOP, "loud": 2 * LOOP}[now[0]])
    adapter = here.engine(BUILD, RUN, READ)
    build = adapter.build

    def built(case, route, setting):
        now[0] = "loud" if setting["cost"] == 2.0 else "quiet"
        return build(case, route, setting)

    adapter.build = built
    engine(monkeypatch, adapter)
    found = cold_start.first_calls(who(1.0, 2.0), 1000.0)
    assert [value.disturbed for value, _ in found.values()] == [False, True]
    assert [value.repeats for value, _ in found.values()][1] == cold_start.LEAST_REPEATS


# --- in which order, for how long -------------------------------------------------------------------------------------


def test_the_first_call_of_a_route_is_for_its_imports_and_then_all_take_turns_cheapest_first(here, monkeypatch):
    """Where it had nothing to import it counts."""
    order: list[float] = []
    adapter = here.engine(BUILD, RUN, READ)
    build = adapter.build
    adapter.build = lambda *call: order.append(call[2]["cost"]) or build(*call)
    engine(monkeypatch, adapter)
    # The dearest is expected to take longer than the call for imports of its route did.
    some = [one._replace(expected_s=10.0 * one.setting["cost"]) for one in who(3.0, 1.0, 2.0)]
    found = cold_start.first_calls(some, 1e6)
    assert order == [3.0, 1.0, 2.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0]
    assert list(found) == [one.key for one in some]
    for one in some:
        assert found[one.key][0].run_s == pytest.approx(RUN * one.setting["cost"])


def test_what_does_not_fit_in_the_budget_has_nothing_but_the_call_for_imports(here, monkeypatch):
    engine(monkeypatch, here.engine(BUILD, RUN, READ))
    found = cold_start.first_calls(who(1.0, 100.0), 3.0 * CALL)
    (first, _), (second, why) = found.values()
    assert first.repeats == cold_start.LEAST_REPEATS and second is None and why == ""
    (alone, _), (none, _) = cold_start.first_calls(who(1.0, 100.0), 0.0).values()
    assert alone.repeats == 1 and none is None


def test_no_call_is_made_that_is_expected_to_outlast_the_budget(here, monkeypatch):
    """However little the call for the imports of its route took."""
    engine(monkeypatch, here.engine(BUILD, RUN, READ))
    ((value, _),) = cold_start.first_calls([who(1.0)[0]._replace(expected_s=50.0)], 10.0).values()
    assert value.repeats == 1


# --- a process of its own ---------------------------------------------------------------------------------------------


@pytest.fixture
def late_module(tmp_path, monkeypatch):
    """A module that nobody has imported."""
    (tmp_path / "imported_late_by_an_engine.py").write_text("x = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield "imported_late_by_an_engine"
    sys.modules.pop("imported_late_by_an_engine", None)


def imports(watch: Watch, name: str, lasts: float = 10.0) -> SimpleNamespace:
    """An engine that imports late, for `lasts` seconds, and makes a module that no file holds."""
    adapter = watch.engine(BUILD, RUN, READ)

    def build(case, route, setting):
        if name not in sys.modules:
            watch.spend(lasts)
        __import__(name)
        sys.modules.setdefault("made_by_an_engine", ModuleType("made_by_an_engine"))
        watch.spend(BUILD)
        return SimpleNamespace(cost=1.0)

    adapter.build = build
    return adapter


def test_imports_are_no_part_of_a_call(watch, monkeypatch, late_module):
    engine(monkeypatch, imports(watch, late_module))
    one, other = who(1.0, 2.0)
    found = cold_start.first_calls([one, other], 1000.0)
    assert late_module in sys.modules and "made_by_an_engine" not in sys.modules
    for value, failure in found.values():
        assert value.build_s == pytest.approx(BUILD) and value.repeats == cold_start.LEAST_REPEATS and not failure


@pytest.mark.parametrize("late, calls", [(True, 1 + cold_start.LEAST_REPEATS), (False, cold_start.LEAST_REPEATS)])
def test_a_call_counts_unless_it_imported_something_a_file_holds(watch, monkeypatch, late_module, late, calls):
    """A module that is made in the process is not imported."""
    made, apart = [], cold_start._in_child
    monkeypatch.setattr(cold_start, "_in_child", lambda *given: made.append(given) or apart(*given))
    engine(monkeypatch, imports(watch, late_module if late else "math"))
    first_call(*who(1.0))
    assert len(made) == calls


def test_a_short_call_that_imported_is_repeated_whatever_is_left_of_the_budget(watch, monkeypatch, late_module):
    """SciPy's integrators took half a second of a call of 30 ms, and the budget was spent."""
    engine(monkeypatch, imports(watch, late_module, lasts=0.5))
    ((value, _),) = cold_start.first_calls(who(1.0), 0.0).values()
    assert value.build_s == pytest.approx(BUILD) and value.repeats == 1


def test_a_long_call_that_imported_stands_in_where_no_other_fits(watch, monkeypatch, late_module):
    engine(monkeypatch, imports(watch, late_module))
    ((value, _),) = cold_start.first_calls(who(1.0), 0.0).values()
    assert value.build_s == pytest.approx(10.0 + BUILD) and value.repeats == 1


def test_no_call_leaves_anything_to_the_next_one(watch, monkeypatch):
    compiled: list[int] = []
    adapter = watch.engine(BUILD, RUN, READ)

    def run(model) -> None:
        watch.spend(RUN if not compiled else 0.0)
        compiled.append(1)

    adapter.run = run
    engine(monkeypatch, adapter)
    assert first_call(*who(1.0)).run_s == pytest.approx(RUN) and compiled == []


def test_a_route_that_fails_is_tried_once_and_others_go_on(here, monkeypatch):
    tried: list[float] = []

    def solver(name: str):
        if name == "engine":
            return here.engine(BUILD, RUN, READ)
        return SimpleNamespace(build=lambda case, route, setting: tried.append(setting["cost"]) or 1 / 0)

    def apart(function, argument):
        try:
            return function(argument)
        except ZeroDivisionError:
            return "no more"

    monkeypatch.setattr(cold_start, "solver", solver)
    monkeypatch.setattr(cold_start, "_in_child", apart)
    found = cold_start.first_calls([*who(1.0, 2.0, name="bad"), *who(1.0)], 1000.0)
    assert list(found.values())[:2] == [(None, "no more")] * 2 and tried == [1.0]
    assert list(found.values())[2][0].run_s == pytest.approx(RUN)


def children() -> set[str]:
    """This process's children, running or not: other tests may have left some, such as a server of forks."""
    return {pid for file in Path("/proc/self/task").glob("*/children") for pid in file.read_text().split()}


@pytest.mark.parametrize(
    "function, said",
    [
        (lambda _: 1 / 0, "ZeroDivisionError: division by zero"),
        (lambda _: sys.exit("had enough"), "SystemExit: had enough"),
        (lambda _: os._exit(7), "its first call ended its process, or took more than"),
        (lambda _: os.kill(os.getpid(), signal.SIGKILL), "its first call ended its process"),
        (lambda _: partial, partial),
    ],
)
def test_whatever_happens_in_the_process_split_off_comes_back_as_a_sentence(function, said):
    before = children()
    found = cold_start._in_child(function, None)
    assert found is said or found.startswith(said)
    assert children() <= before


def test_a_call_that_does_not_end_is_ended(monkeypatch):
    monkeypatch.setattr(cold_start, "_LIMIT", 0.3)
    before, began = children(), time.monotonic()
    assert "took more than 0.3 s" in cold_start._in_child(lambda _: time.sleep(600.0), None)
    assert children() <= before and time.monotonic() - began < 300.0
