"""The timed pass: every time belongs to the contestant it was measured of, whatever the order and wherever from."""

from dataclasses import replace
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

import cases
from adapters import Setting, lookup
from cases import Cost, Mode, Transition
from reports.judging.score import Score
from reports.running.records import Experiment, Run, Truth
from reports.running.storage.result_store import Store
from reports.running.timing import clock, cold_start, time_breakdown, timed_pass
from reports.running.timing.clock import Contestant

from .watch import LEFT, CallsHere, Watch

LINES = tuple(cases.load("disc_on_line", mu=mu) for mu in (0.1, 0.2))
VERSIONS = {"pymunk": "7.2.0", "exudyn": "1.9.0", "reference": "0.1.0"}
VERSIONS |= {"pymunk@6.11.1": "6.11.1", "pymunk@7.0.0": "7.0.0"}
# How many times as long as the cheapest each takes: no two contestants may be confused without a difference.
COSTS = {"reference": 1, "pymunk": 2, "exudyn": 4}
WHO = [
    Contestant(case, name, route, Setting.of(cost=cost * (1.0 if route == "native" else 1.25) * (1 + place)), 0.01)
    for place, case in enumerate(LINES)
    for name, cost in COSTS.items()
    for route in ("native", "assisted")
]
BUILD, RUN, READ = 0.04, 0.02, 0.01
SHARES = (LEFT["binding"], LEFT["callback"] - LEFT["binding"], LEFT["notes"] - LEFT["callback"], 1.0 - LEFT["notes"])


@pytest.fixture
def engines(here, monkeypatch) -> Watch:
    """Engines of known cost at a clock that only they move on, in this process."""
    engine = here.engine(BUILD, RUN, READ)
    for module in (clock, cold_start, time_breakdown):
        monkeypatch.setattr(module, "solver", lambda name: engine)
    monkeypatch.setattr(timed_pass, "time", here)
    return here


def calls(folder=None) -> CallsHere:
    return CallsHere(1, store=Store(folder), versions=VERSIONS)


def fit(result, cost: float) -> bool:
    """Whether a Timing, Cold or Parts is of a contestant of that cost."""
    if isinstance(result, time_breakdown.TimeBreakdown):
        return tuple(result) == pytest.approx(SHARES, rel=1e-3)
    run = result.cpu_s if isinstance(result, clock.Timing) else result.run_s
    build = result.setup_s if isinstance(result, clock.Timing) else result.build_s
    expected = (BUILD * cost, RUN * cost, READ * cost, (BUILD + RUN + READ) * cost)
    return (build, run, result.read_s, result.call_s) == pytest.approx(expected, rel=1e-3)


def timed(who, made) -> dict:
    found, failed = timed_pass.together(clock.time_all, who, inf, 10.0, made, "timings")
    assert not failed and [*found] == [one.key for one in who]
    return found


def started_cold(who, made) -> dict:
    return timed_pass.together(cold_start.first_calls, who, 1000.0, 1000.0, made, "timings")[0]


@pytest.mark.parametrize("measured", [timed, started_cold])
def test_each_time_is_its_contestant_s_in_every_order_and_from_the_store(measured, engines, tmp_path):
    """As after `--solver pymunk exudyn reference` on the store of a default build."""

    @given(st.permutations(WHO))
    def holds(who):
        with calls(tmp_path) as made:
            found = measured(who, made)
        assert all(fit(found[one.key], one.setting["cost"]) for one in who)
        times_made.append(len(made.made))

    times_made: list[int] = []
    holds()
    # The first made them, and the others took them from the store: else their order would prove nothing.
    assert times_made == [1, *[0] * (len(times_made) - 1)] and len(times_made) > 10


# --- what is kept under which key -------------------------------------------------------------------------------------

AB = [
    Contestant(LINES[0], "pymunk", "native", Setting.of(cost=1.0), 0.01),
    Contestant(LINES[1], "exudyn", "native", Setting.of(cost=2.0), 0.01),
]


@pytest.mark.parametrize(
    "other, new",
    [
        (AB, 0),
        (AB[::-1], 0),
        ([one._replace(expected_s=9.0) for one in AB], 0),
        ([AB[0]._replace(setting=Setting.of(cost=1.0 + 1e-15)), AB[1]], 1),
        ([AB[0]._replace(setting=Setting.of(cost=1)), AB[1]], 1),
        ([AB[0]._replace(route="assisted"), AB[1]], 1),
        ([AB[0]._replace(solver="reference"), AB[1]], 1),
        # The same cases, solvers and settings, but each solver on the other's case.
        ([AB[0]._replace(case=LINES[1]), AB[1]._replace(case=LINES[0])], 1),
        ([AB[0]._replace(case=replace(LINES[0], duration=0.5)), AB[1]], 1),
        (AB[:1], 1),
    ],
)
def test_timings_are_taken_of_the_same_contestants_alone(other, new, engines, tmp_path):
    for who, made_now in ((AB, 1), (other, new)):
        with calls(tmp_path) as made:
            timed(who, made)
        assert len(made.made) == made_now


@pytest.mark.parametrize("disturbed", [(True, True), (True, False), (False, True)])
def test_nothing_is_kept_that_was_disturbed_anywhere(disturbed, engines, tmp_path, monkeypatch):
    timing = replace(clock.NO_TIMING, cpu_s=1.0)
    answers = {one.key: (replace(timing, disturbed=d), "") for one, d in zip(AB, disturbed, strict=True)}

    def time_all(contestants, budget) -> dict[clock.Key, tuple[clock.Timing | None, str]]:
        return answers

    time_all.__module__ = clock.__name__
    monkeypatch.setattr(clock, "time_all", time_all)
    for _ in range(2):
        with calls(tmp_path) as made:
            timed(AB, made)
        assert len(made.made) == 1


def test_versions_of_an_engine_are_timed_apart_each_with_its_share_of_the_time(engines):
    versions = [AB[0]._replace(solver=f"pymunk@{version}") for version in ("6.11.1", "7.0.0")]
    with calls() as made:
        found, _ = timed_pass.together(clock.time_all, [*AB, *versions], 8.0, 8.0, made, "timings")
    assert [*found] == [one.key for one in [*AB, *versions]]
    assert [(list(who), budget) for who, budget in made.made] == [
        (AB, 4.0), ([versions[0]], 2.0), ([versions[1]], 2.0),
    ]  # fmt: skip


# --- what is timed ----------------------------------------------------------------------------------------------------


def run_of(case, solver="pymunk", cost=1.0, rung=1, outcome="answered", route="native", off=0.01) -> Run:
    took = Cost(wall_s=0.01 * cost, setup_s=0.02 * cost)
    score = Score(off, 0.0, off, 0.0, 0.0, 0.0, 0.0, 1e-3, False) if outcome == "answered" else None
    return Run(case.label, solver, route, Setting.of(cost=cost), rung, outcome, cost=took, score=score)


def experiment(*given, runs=None, events=None) -> Experiment:
    """Cases with ladders of six usable runs by default; `events` of each."""
    ladders = [run_of(case, cost=1.0 + rung, rung=rung) for case in given for rung in range(1, 7)]
    truths = {
        case.label: Truth(transitions=(Transition(1.0, Mode.SLIDE, Mode.ROLL),) * (events or {}).get(case.label, 1))
        for case in given
    }
    return Experiment(given, truths, tuple(ladders if runs is None else runs))


def named(count: int, family: str = "") -> list[cases.Case]:
    """Cases of as many families, or of one."""
    return [replace(LINES[0], name=family or f"family_{i}", parameters={"mu": i / 100}) for i in range(count)]


def test_contestants_are_the_usable_runs_of_engines_that_the_clock_can_see(monkeypatch):
    runs = [
        run_of(LINES[0], cost=1.0), run_of(LINES[0], cost=2.0, off=0.6), run_of(LINES[0], "outside", 3.0),
        run_of(LINES[1], cost=4.0), run_of(LINES[0], cost=5.0, outcome="crashed"),
    ]  # fmt: skip
    monkeypatch.setattr(timed_pass, "executables", lambda: {"outside": None})
    (one,) = timed_pass.contestants(experiment(*LINES, runs=runs), LINES[0])
    assert one.key == (LINES[0].label, "pymunk", "native", Setting.of(cost=1.0))
    assert one.case == LINES[0] and one.expected_s == pytest.approx(0.03)  # a build and a run
    assert lookup.executables() == {}


def test_a_default_report_times_of_each_family_the_variant_with_most_transitions():
    variants = named(3, "valley")
    found = experiment(*variants, events={variants[1].label: 3})
    assert timed_pass.cases_to_time(found, full=False) == [variants[1]]
    assert timed_pass.cases_to_time(found, full=True) == variants


def test_what_could_not_be_timed_is_reported_with_its_reason(engines, monkeypatch):
    def breaks(model):
        raise RuntimeError("no more")

    monkeypatch.setattr(clock, "solver", lambda name: engines.engine(BUILD, RUN, READ, run=breaks))
    with calls() as made:
        found = timed_pass.measure(experiment(LINES[0], runs=[run_of(LINES[0])]), True, made)
    assert found.timings == {} and found.cases == (LINES[0],)
    assert found.failures == {f"{LINES[0].label}, pymunk native cost=1": "RuntimeError: no more"}


def test_cold_starts_and_parts_are_measured_of_those_that_are_wanted(engines):
    runs = [run_of(case, cost=cost) for case in LINES for cost in (1.0, 2.0)]
    wanted = {(run.case, run.solver, run.route, run.setting) for run in runs[1:3]}
    with calls() as made:
        found = timed_pass.measure_extra(experiment(*LINES, runs=runs), wanted, False, made)
    assert set(found.cold) == set(found.parts) == wanted
    assert all(
        isinstance(value, cold_start.ColdStart) and fit(value, key[3]["cost"]) for key, value in found.cold.items()
    )
    assert all(isinstance(value, time_breakdown.TimeBreakdown) and fit(value, 1.0) for value in found.parts.values())
