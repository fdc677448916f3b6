"""The shares of a run's time, by a clock that work alone moves on: which difference is whose, and how often."""

from math import inf, isnan, nan
from types import SimpleNamespace

import pytest

import cases
from adapters import Setting
from reports.running.timing import time_breakdown
from reports.running.timing.clock import Contestant

from .watch import LEFT

LINE = cases.load("disc_on_line", mu=0.1)
RUN = 0.04


def contestant(name: str = "engine", expected: float = 0.01, cost: float = 1.0) -> Contestant:
    return Contestant(LINE, name, "native", Setting.of(cost=cost), expected)


def shares(monkeypatch, adapter, deadline: float = 1000.0) -> time_breakdown.TimeBreakdown | None:
    monkeypatch.setattr(time_breakdown, "solver", lambda name: adapter)
    return time_breakdown.parts(contestant(), deadline)


# --- by difference ----------------------------------------------------------------------------------------------------


def test_a_part_is_what_a_run_is_cheaper_by_without_it(watch, monkeypatch):
    """Building is on no clock, and seconds on the wall are not."""
    whole = watch.work(RUN, wall=9 * RUN)
    found = shares(monkeypatch, watch.engine(5.0, RUN, 5.0, run=whole))
    assert found.engine == pytest.approx(LEFT["binding"])
    assert found.binding == pytest.approx(LEFT["callback"] - LEFT["binding"])
    assert found.callback == pytest.approx(LEFT["notes"] - LEFT["callback"])
    assert found.notes == pytest.approx(1.0 - LEFT["notes"])


@pytest.mark.parametrize(
    "run, deadline, turns",
    [
        (1e-6, inf, time_breakdown._MOST_TURNS),
        (1.0, inf, 1 + time_breakdown._LEAST_TURNS),  # many short runs say as much as one long one
        (1e-6, 0.0, 1 + time_breakdown._LEAST_TURNS),
    ],
)
def test_turns_end_after_the_most_or_when_enough_time_is_spent(watch, monkeypatch, run, deadline, turns):
    ran = []
    shares(monkeypatch, watch.engine(0.0, run, 0.0, run=watch.work(run, lambda: ran.append(1))), deadline)
    assert len(ran) == turns


# --- by profile -------------------------------------------------------------------------------------------------------


class Profiled:
    """An adapter without bare runs whose engine is Python's own `list.extend`, and a clock that its length is."""

    NAME, ENGINE = "profiled", "builtins"

    def __init__(self, engine_s: int, ours_s: int, in_callback_s: int = 0):
        self.seconds: list[int] = []
        self.looks = 0
        self.engine_s, self.ours_s, self.in_callback_s = engine_s, ours_s, in_callback_s

    def build(self, case, route, setting) -> str:
        return "model"

    def run(self, model: str) -> None:
        if self.engine_s is not None:
            self.seconds.extend(range(self.engine_s))
        self.seconds += [0] * self.ours_s
        if self.in_callback_s:
            # To the profiler `sorted` is the engine, and calls us back.
            sorted([0], key=self.called_back)

    def called_back(self, item: int) -> int:
        self.seconds += [0] * self.in_callback_s
        return item

    def clock(self, of_processor: float = 1.0) -> SimpleNamespace:
        """By the thread's clock a look itself takes a second."""

        def thread_time() -> int:
            self.looks += 1
            return len(self.seconds) + self.looks

        now = lambda: of_processor * len(self.seconds)  # noqa: E731
        return SimpleNamespace(process_time=now, thread_time=thread_time, perf_counter=now)


def profiled(monkeypatch, adapter: Profiled, of_processor: float = 1.0) -> time_breakdown.TimeBreakdown | None:
    monkeypatch.setattr(time_breakdown, "time", adapter.clock(of_processor))
    return shares(monkeypatch, adapter, 0.0)


def test_an_engine_s_share_is_what_its_compiled_functions_take(monkeypatch):
    found = profiled(monkeypatch, Profiled(30, 10))
    assert (found.engine, found.callback) == (0.75, 0.25) and isnan(found.binding) and isnan(found.notes)


def test_what_an_engine_calls_back_is_ours(monkeypatch):
    assert profiled(monkeypatch, Profiled(30, 0, 10)).engine == 0.75


# --- all contestants --------------------------------------------------------------------------------------------------


def test_parts_are_found_cheapest_first_and_reported_under_each_one_s_name(watch, monkeypatch):
    order = []

    def of_one(one, deadline):
        order.append(one.solver)
        if one.solver == "fails":
            raise RuntimeError("no more")
        watch.spend(1.0)
        return time_breakdown.TimeBreakdown(one.expected_s, nan, nan, nan)

    monkeypatch.setattr(time_breakdown, "parts", of_one)
    who = [contestant(name, expected) for name, expected in (("dear", 0.5), ("fails", 0.2), ("cheap", 0.1))]
    found = {key[1]: value for key, value in time_breakdown.parts_of_all([*who, contestant("long", 5.0)], 6.0).items()}
    assert order == ["cheap", "fails", "dear"]
    assert found["dear"][0].engine == 0.5 and found["cheap"][0].engine == 0.1 and found["dear"][1] == ""
    assert found["fails"] == (None, "RuntimeError: no more")
    assert found["long"] == (None, "the time budget was used up before")
