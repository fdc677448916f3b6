"""The clock: what is timed and what is not, in which order, until when, and what counts as disturbed."""

import gc
import time
from functools import partial
from itertools import groupby
from math import isnan
from types import SimpleNamespace

import pytest

import cases
from adapters import Setting
from reports.running import solvers
from reports.running.timing import clock
from reports.running.timing.clock import ClockEntry, Contestant, Repeat

from .watch import LOOP, Watch

LINE = cases.load("disc_on_line", mu=0.1)
# A wait on the wall of a tenth of the work: a fifth would count as a disturbance.
WAIT = 1.1


def contestant(name: str = "engine", expected: float = 0.01) -> Contestant:
    return Contestant(LINE, name, "native", Setting.of(h=0.1), expected)


def entry(name: str = "engine", build=lambda: None, run=lambda model: None, **more) -> ClockEntry:
    return ClockEntry(contestant(name), build, run, **more)


def timed(watch: Watch, one: ClockEntry, budget: float = 5.0) -> clock.Timing:
    return clock.timing(one, clock.take_turns([one], watch.wall + budget))


def works(watch: Watch, cpu: float):
    return watch.work(cpu, wall=WAIT * cpu)


def repeated(*repeats: Repeat, setup=(0.0,)) -> ClockEntry:
    one = entry("x")
    one.repeats, one.setup = list(repeats), list(setup)
    return one


def quiet(cpu: float) -> Repeat:
    return Repeat(cpu, cpu, LOOP, False)


# Ten times slower in CPU time too, as beside a greedy neighbour: whoever counts it sees it.
SLOW_LOOP, BESIDE_OTHERS, WAITED = (
    Repeat(10.0, 10.0, 1.5 * LOOP, False),
    Repeat(10.0, 10.0, LOOP, True),
    Repeat(10.0, 15.0, LOOP, False),
)


@pytest.mark.timed
def test_ratio_of_timings_is_the_ratio_of_work():
    entries = [entry(str(n), run=lambda model, n=n: sum(range(n))) for n in (100_000, 400_000)]
    clock.take_turns(entries, time.perf_counter() + 2.0)
    small, large = (clock.timing(e, LOOP).cpu_s for e in entries)
    # Four times the work; half of that and twice that leave room for a busy machine.
    assert 2.0 < large / small < 8.0


def test_contestants_take_turns(watch):
    order: list[str] = []
    entries = [entry(name, run=watch.work(0.005, partial(order.append, name))) for name in "abc"]
    clock.take_turns(entries, watch.wall + 1.0)
    turns = [name for name, _ in groupby(order)]
    assert turns[:9] == list("abcabcabc")


def test_interval_is_of_the_extremes_while_there_are_few_and_of_the_deciles_then():
    assert all(isnan(end) for end in clock.interval([1.0, 2.0]))
    assert clock.interval([3.0, 1.0, 2.0]) == (1.0, 3.0)
    assert clock.interval([float(i) for i in range(101)]) == (10.0, 90.0)


@pytest.mark.parametrize("repeats", [3, 30])
def test_no_interval_is_narrower_than_what_processes_differ_by(repeats):
    assert clock.interval([2.0] * repeats) == pytest.approx((2.0 * 0.97, 2.0 * 1.03))


@pytest.mark.parametrize("repeat", [SLOW_LOOP, BESIDE_OTHERS, WAITED])
def test_disturbed_repeats_are_seen_and_have_no_part_in_the_median(repeat):
    assert clock.is_disturbed(repeat, LOOP) and not clock.is_disturbed(quiet(1.0), LOOP)
    timing = clock.timing(repeated(*[repeat] * 5, quiet(1.0), quiet(1.1), quiet(1.2)), LOOP)
    assert (timing.cpu_s, timing.cpu_low_s, timing.cpu_high_s) == (1.1, 1.0, 1.2)
    assert (timing.repeats, timing.disturbed_repeats, timing.disturbed) == (3, 5, False)


def test_row_with_too_few_undisturbed_repeats_is_marked():
    timing = clock.timing(repeated(quiet(1.0), quiet(1.0), SLOW_LOOP, SLOW_LOOP), LOOP)
    assert timing.disturbed and timing.repeats == 4
    # Two repeats are few, but nothing disturbed them.
    assert not clock.timing(repeated(quiet(1.0), quiet(1.0)), LOOP).disturbed


# 1e-4 s: sixteen at most in a row, of which each is a tenth of a millisecond.
@pytest.mark.parametrize("run", [1e-4, 5e-3, 0.04])
def test_each_part_of_a_call_is_its_own_cpu_time(watch, run):
    found = timed(watch, entry(build=works(watch, 0.03), run=works(watch, run), read=works(watch, 0.02)))
    assert (found.setup_s, found.cpu_s, found.read_s) == pytest.approx((0.03, run, 0.02), rel=1e-4)
    assert found.call_s == pytest.approx(0.03 + run + 0.02, rel=1e-4)
    assert found.wall_s == pytest.approx(WAIT * run, rel=1e-4) and not found.disturbed


def test_what_the_first_build_compiles_is_apart_from_the_set_up(watch):
    once = iter([0.5])
    found = timed(watch, entry(build=lambda: watch.spend(next(once, 0.03)), run=works(watch, 0.04)))
    assert (found.setup_s, found.compile_s) == pytest.approx((0.03, 0.47), rel=1e-4)


def test_no_garbage_is_collected_on_the_clock_and_it_is_again_afterwards(watch):
    seen: list[bool] = []

    def run(model) -> None:
        seen.append(gc.isenabled())
        watch.spend(0.04)

    timed(watch, entry(run=run))
    assert seen and not any(seen) and gc.isenabled()


def test_what_an_engine_started_is_gone_before_the_next_repeat(watch, monkeypatch):
    order = []
    monkeypatch.setattr(clock, "reap", lambda: order.append("reap"))
    timed(watch, entry(run=watch.work(0.04, lambda: order.append("run"))))
    assert order == ["run", "reap"] * (len(order) // 2) and len(order) >= 6


@pytest.mark.parametrize("slow", ["before", "after"])
@pytest.mark.parametrize("what", ["loop", "neighbours"])
def test_what_is_seen_before_or_after_a_repeat_disturbs_it(watch, monkeypatch, slow, what):
    looks = {"before": 0, "after": 1}[slow]
    loops, others = [0], [0]

    def seen(counter: list[int]) -> bool:
        counter[0] += 1
        return counter[0] % 2 == looks

    one = entry(run=works(watch, 0.04))
    # A repeat looks twice at each; `take_turns` takes one look more at the loop, before all of them.
    if what == "loop":
        monkeypatch.setattr(clock, "calibrate", lambda: 2 * LOOP if seen(loops) else LOOP)
    else:
        monkeypatch.setattr(clock, "neighbours", lambda: seen(others))
    clock.take_turns([one], watch.wall + 1.0)
    assert len(one.repeats) >= 3 and all(clock.is_disturbed(repeat, LOOP) for repeat in one.repeats)


def test_a_median_is_known_to_a_fiftieth():
    """Of so many repeats on a line, the quartiles are half of its length apart: σ of the median is 0.464/√n of it."""
    for many, length, known in ((30, 0.3, False), (30, 0.2, True), (10, 0.2, False), (10, 0.1, True)):
        seconds = [1.0 + length * (i / (many - 1) - 0.5) for i in range(many)]
        assert clock.is_precise(seconds) == known, (many, length)


@pytest.mark.parametrize(
    "running, cores, seen",
    [(1, 1, False), (2, 1, True), (1, 2, False), (2, 2, True), (3, 4, False), (4, 4, True), (2, None, True)],
)
def test_neighbours_are_seen_when_they_take_all_other_cores(monkeypatch, running, cores, seen):
    """The process that asks is one of those that run."""
    loads = SimpleNamespace(read_text=lambda: f"0.1 0.2 0.3 {running}/500 12345\n")
    monkeypatch.setattr(clock, "Path", lambda name: loads)
    monkeypatch.setattr(clock.os, "cpu_count", lambda: cores)
    assert clock.neighbours() == seen


def test_all_are_timed_cheapest_first_each_route_imported_before(watch, monkeypatch):
    order: list[str] = []

    def engine(name: str) -> SimpleNamespace:
        def build(case, route, setting):
            # What it imports late, once for each route, takes longer than there is time.
            if (name, route) not in imported:
                imported.add((name, route))
                order.append(f"import {name} {route}")
                watch.spend(100.0)
            return f"{name} {route}"

        run = lambda model: (order.append(model), watch.spend(took[model]))  # noqa: E731
        return SimpleNamespace(build=build, run=run, read=lambda model: None)

    took = {"a native": 0.06, "a assisted": 0.05, "b native": 0.04}
    imported: set[tuple[str, str]] = set()
    monkeypatch.setattr(clock, "solver", engine)
    who = [
        contestant(name, expected)._replace(route=route)
        for name, route, expected in (("a", "native", 0.3), ("a", "assisted", 0.2), ("b", "native", 0.1))
    ]
    found = clock.time_all(who, 2.0)
    assert {key: failure for key, (_, failure) in found.items()} == {one.key: "" for one in who}
    assert sorted(order[:3]) == ["import a assisted", "import a native", "import b native"]
    assert order[3:6] == ["b native", "a assisted", "a native"]
    assert all(timing and timing.repeats >= clock.LEAST_REPEATS for timing, _ in found.values())
    assert {f"{key[1]} {key[2]}": timing.cpu_s for key, (timing, _) in found.items()} == pytest.approx(took)


def test_what_fails_or_does_not_fit_says_so_under_its_own_name(watch, monkeypatch):
    def fails(model) -> None:
        raise RuntimeError("no more")

    engines = {
        "good": watch.engine(0.01, 0.04, 0.01),
        "fails": watch.engine(0.01, 0.04, 0.01, run=fails),
        "unbuilt": SimpleNamespace(run=None, read=None),
        "long": watch.engine(0.01, 0.04, 0.01),
    }
    engines["unbuilt"].build = lambda case, route, setting: fails(None)
    monkeypatch.setattr(clock, "solver", lambda name: engines[name])
    who = [contestant(name, 99.0 if name == "long" else 0.1) for name in engines]
    who = [one._replace(setting=Setting.of(cost=1.0)) for one in who]
    began = watch.wall
    found = {key[1]: value for key, value in clock.time_all(who, 3.0).items()}
    assert found["good"][0].cpu_s == pytest.approx(0.04) and found["good"][1] == ""
    assert found["fails"] == found["unbuilt"] == (None, "RuntimeError: no more") and found["long"] == (None, "")
    assert watch.wall < began + 3.1


def test_reference_is_timed_without_its_sampling():
    case = cases.load("disc_on_line", mu=0.1)
    module = solvers.solver("reference")
    route = module.routes[0]
    model = module.build(case, route, module.ladder(case, route)[3])
    module.run(model)
    segments, *_ = model.solution
    assert segments and not any(isinstance(part, cases.Trajectory) for part in model.solution)
    assert module.read(model).transitions[0].time == pytest.approx(1.0 / (3 * 0.1 * 9.81), abs=1e-12)
