"""Whose time a run takes: the engine's share by two ways that have nothing in common, and what adds up."""

import statistics
import time
from math import isnan
from types import SimpleNamespace

import numpy as np
import pytest

import cases
import reference
from adapters import Setting
from adapters.pymunk import adapter, assisted
from reports.running import tasks
from reports.running.timing import cold_start, time_breakdown
from reports.running.timing.clock import Contestant

pytestmark = pytest.mark.builds

CIRCLE = cases.load("disc_in_circle", mu=0.2)
SETTING = Setting.of(h=1e-3, iterations=10)


def by_empty_callback() -> float:
    """Microseconds of a step whose callback does nothing."""
    hollow = adapter.bare_run(CIRCLE, "assisted", SETTING, "callback")
    began = time.process_time()
    hollow()
    return (time.process_time() - began) / round(CIRCLE.duration / SETTING["h"]) * 1e6


def listened(callback) -> tuple[list[int], object]:
    """Marks of a clock, ns, where a callback begins and ends, and the callback that makes them."""
    marks: list[int] = []
    mark, clock = marks.append, time.perf_counter_ns

    def marking(arbiter, space, data) -> None:
        mark(clock())
        callback(arbiter, space, data)
        mark(clock())

    return marks, marking


def outside(marks: list[int]) -> float:
    """Microseconds between the end of one call and the beginning of the next; a median, so that whoever else had the
    processor meanwhile has no part in it."""
    pairs = np.array(marks).reshape(-1, 2)
    return float(np.median(pairs[1:, 0] - pairs[:-1, 1])) / 1e3


def by_profile() -> float:
    """Microseconds of a step outside our callback, that of the true run, without the clock's own part.

    Two clocks, one within the other: what the inner one sees more is what a clock adds, there and then.
    """
    model = adapter.build(CIRCLE, "assisted", SETTING)
    inner, marking = listened(model.guide.pre_solve)
    outer, twice = listened(marking)
    assisted.listen(model.space, twice)
    for _ in range(model.steps):
        model.space.step(model.h)
    return 2 * outside(outer) - outside(inner)


@pytest.mark.timed
def test_engine_and_binding_take_as_long_by_profile_as_with_an_empty_callback():
    """On pymunk's assisted route, where nearly all of a step is ours. By turns, and the medians of the turns."""
    turns = [(by_empty_callback(), by_profile()) for _ in range(9)]
    hollow, profiled = (statistics.median(column) for column in zip(*turns, strict=True))
    # Both were between 1.52 and 1.56 µs when it was written, on a busy machine; a tenth is what the tables claim.
    assert profiled == pytest.approx(hollow, rel=0.1)


@pytest.mark.timed
@pytest.mark.parametrize("route", ["native", "assisted"])
def test_parts_by_difference_are_the_whole(route):
    setting = adapter.ladder(CIRCLE, route)[3]
    output = time_breakdown.parts(Contestant(CIRCLE, "pymunk", route, setting, 0.1), time.perf_counter() + 2.0)
    assert sum(output) == pytest.approx(1.0, abs=0.1)  # differences of measured times, none below zero
    # The assisted route's callback is Python of ours and the most of it; the native one has none.
    assert output.callback > 0.7 if route == "assisted" else output.callback < 0.1
    assert 0.0 < output.engine < (0.1 if route == "assisted" else 0.7)


@pytest.mark.timed
@pytest.mark.skipif("taylor" not in reference.METHODS, reason="needs heyoka")
def test_a_profile_tells_an_engine_from_the_python_it_calls_back():
    """heyoka's own steps are less than half of a Taylor run of a few milliseconds."""
    output = time_breakdown.parts(
        Contestant(CIRCLE, "reference", "taylor", Setting.of(rtol=1e-9), 0.1), time.perf_counter() + 1.0
    )
    assert 0.0 < output.engine < 0.9 and output.engine + output.callback == 1.0 and isnan(output.binding)


def test_python_alone_has_no_engine():
    literal = Contestant(CIRCLE, "reference", "augmented", Setting.of(rtol=1e-3), 0.1)
    assert time_breakdown.parts(literal, time.perf_counter() + 1.0) is None


def test_what_python_does_within_an_engine_is_not_the_engine_s(monkeypatch):
    """By a clock that work alone moves on, so that no other load on the machine has a part in it."""
    seconds: list[int] = []
    monkeypatch.setattr(time_breakdown, "time", SimpleNamespace(thread_time=lambda: len(seconds)))

    def work(x: int) -> int:
        seconds.extend(range(10))
        return x

    # To the profiler an engine of the package "builtins": `sorted` calls its key back, `extend` works for 7 s itself.
    def run() -> None:
        sorted([3, 1, 2], key=work)
        seconds.extend(range(7))

    assert time_breakdown.engine_seconds("builtins", run) == 7
    assert isnan(time_breakdown.engine_seconds("an_engine_that_is_not_called", run))


def test_a_call_from_cold_that_has_nothing_left_to_import_is_a_repeat(monkeypatch):
    made, apart = [], cold_start._in_child
    monkeypatch.setattr(cold_start, "_in_child", lambda *arguments: made.append(arguments) or apart(*arguments))
    setting = tasks.survey(CIRCLE, "pymunk")[0].settings[1]
    who = [Contestant(CIRCLE, "pymunk", "native", setting, 0.1)]
    cold_start.first_calls(who, 60.0)
    made.clear()
    ((output, why),) = cold_start.first_calls(who, 60.0).values()
    assert output.repeats <= cold_start.LEAST_REPEATS == len(made) and not why  # of which a busy machine disturbs some
