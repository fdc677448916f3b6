"""What the clock reads, by one that work alone moves on: whose seconds, of which repeats, with what switched off."""

import gc
import weakref
from types import SimpleNamespace

import pytest

import cases
from adapters import Setting
from reports.running.timing import clock
from reports.running.timing.clock import ClockEntry, Contestant

from .watch import LOOP, Watch

LINE = cases.load("disc_on_line", mu=0.1)
# A wait on the wall of a tenth of the work: a fifth would count as a disturbance.
WAIT = 1.1


def contestant(name: str = "engine", expected: float = 0.01) -> Contestant:
    return Contestant(LINE, name, "native", Setting.of(h=0.1), expected)


def entry(build=lambda: None, run=lambda model: None, read=lambda model: None) -> ClockEntry:
    return ClockEntry(contestant(), build, run, read)


def timed(watch: Watch, one: ClockEntry, budget: float = 5.0) -> clock.Timing:
    return clock.timing(one, clock.take_turns([one], watch.wall + budget))


def works(watch: Watch, cpu: float):
    return watch.work(cpu, wall=WAIT * cpu)


# 1e-4 s: sixteen at most in a row, of which each is a tenth of a millisecond.
@pytest.mark.parametrize("run", [1e-4, 5e-3, 0.04])
def test_each_part_of_a_call_is_its_own_cpu_time(watch, run):
    found = timed(watch, entry(works(watch, 0.03), works(watch, run), works(watch, 0.02)))
    assert (found.setup_s, found.cpu_s, found.read_s) == pytest.approx((0.03, run, 0.02), rel=1e-4)
    assert found.call_s == pytest.approx(0.03 + run + 0.02, rel=1e-4)
    assert found.wall_s == pytest.approx(WAIT * run, rel=1e-4) and not found.disturbed


def test_what_the_first_build_compiles_is_apart_from_the_set_up(watch):
    once = iter([0.5])
    found = timed(watch, entry(lambda: watch.spend(next(once, 0.03)), works(watch, 0.04)))
    assert (found.setup_s, found.compile_s) == pytest.approx((0.03, 0.47), rel=1e-4)


def test_samples_that_are_made_when_they_are_asked_for_belong_to_reading(watch):
    class Motion:
        @property
        def t(self):
            watch.spend(0.02)

    assert timed(watch, entry(run=works(watch, 0.04), read=lambda model: Motion())).read_s == pytest.approx(0.02)


def test_reading_is_known_by_the_median_of_three(watch):
    seconds = iter([0.02, 0.5, 0.03])
    found = timed(watch, entry(run=works(watch, 0.04), read=lambda model: watch.spend(next(seconds))))
    assert found.read_s == pytest.approx(0.03)


def test_a_short_run_after_cold_caches_is_no_part_of_a_repeat(watch, monkeypatch):
    """Whatever ran before (here the calibration) left the caches to itself: the first short run pays for that."""
    cold = [True]

    def calibrate() -> float:
        cold[0] = True
        return LOOP

    def run(model) -> None:
        watch.spend(5e-3 if cold[0] else 1e-4)
        cold[0] = False

    monkeypatch.setattr(clock, "calibrate", calibrate)
    assert timed(watch, entry(run=run)).cpu_s == pytest.approx(1e-4, rel=1e-3)


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


def test_models_of_a_repeat_are_gone_after_it(watch):
    class Model:
        pass

    models: list[weakref.ref] = []

    def build() -> Model:
        assert not any(model() for model in models), "a model outlived its repeat"
        models.append(weakref.ref(model := Model()))
        return model

    timed(watch, entry(build, works(watch, 0.04)))
    assert len(models) >= 3


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


def test_a_disturbed_timing_says_of_how_many_repeats_it_is(watch, monkeypatch):
    """Two of five in three are disturbed, and slower: they have no part in any median."""
    turns = iter(range(10_000))
    disturbed = [False]

    def run(model) -> None:
        disturbed[0] = next(turns) % 5 in (1, 3)
        watch.spend(0.08 if disturbed[0] else 0.04)

    monkeypatch.setattr(clock, "neighbours", lambda: disturbed[0])
    one = entry(run=run)
    found = timed(watch, one, 1.0)
    bad = sum(repeat.beside_others for repeat in one.repeats)
    assert 0 < bad < len(one.repeats) and found.cpu_s == pytest.approx(0.04)
    assert (found.repeats, found.disturbed_repeats) == (len(one.repeats) - bad, bad) and not found.disturbed


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


@pytest.mark.parametrize("text", ["", "0.1 0.2", "0.1 0.2 0.3 many/500 1"])
def test_where_the_load_is_not_told_nobody_is_seen(monkeypatch, text):
    monkeypatch.setattr(clock, "Path", lambda name: SimpleNamespace(read_text=lambda: text))
    assert clock.neighbours() is False


# --- all contestants --------------------------------------------------------------------------------------------------


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


def test_no_more_repeats_than_the_most_are_taken(watch):
    """Of a run that is never known well enough, with all the time in the world."""
    seconds = iter([0.04, 0.1] * 1000)
    one = entry(run=lambda model: watch.spend(next(seconds)))
    timed(watch, one, 1000.0)
    assert len(one.repeats) == clock.MOST_REPEATS
