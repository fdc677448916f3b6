"""Every route of every installed engine: its ladder, its rows in an experiment, and what it must reach."""

from __future__ import annotations

import re

import numpy as np
import pytest

import adapters
import cases
from adapters import Setting
from cases import Case, Trajectory
from cases.contact import start_motion
from reports.judging import slip_phases
from reports.judging.transitions import read_motion
from reports.running import experiment, tasks
from reports.running.calls import Calls
from reports.running.records import one_default
from tests.authorities.paper_application import FIRST_TRANSITION, SEQUENCE

OUTCOMES = {"answered", "unsupported", "crashed", "timed_out"}
# A disc in a circle, on a line, in a valley, off a hill; a plate that is none on a line and on a hill; no gravity.
LADDER_CASES = (
    "disc_in_circle[mu=0.1]", "disc_on_line[mu=0.1]", "disc_in_cosine", "disc_sliding_off_hill",
    "ellipse_on_line[mu=1]", "ellipse_on_hill", "disc_in_weightless_ring",
)  # fmt: skip


def installed() -> list[str]:
    """The engines that can be imported here."""
    found = []
    for name in adapters.engines():
        try:
            adapters.engine(name)
        except ImportError:
            continue
        found.append(name)
    return found


ROUTES = [(name, route) for name in installed() for route in adapters.engine(name).routes]


def one(label: str) -> Case:
    [case] = cases.select(label)
    return case


def play(name: str, route: str, case: Case, setting: Setting) -> Trajectory:
    adapter = adapters.engine(name)
    model = adapter.build(case, route, setting)
    adapter.run(model)
    return adapter.read(model)


def first_error(name: str, route: str, mu: float, setting: Setting | None = None) -> float:
    """Error of the first transition of the paper's application, s; of the finest rung if no setting is given."""
    case = cases.load("disc_in_circle", mu=mu, duration=1.2)
    moved = play(name, route, case, setting or adapters.engine(name).ladder(case, route)[-1])
    return slip_phases.read_transitions(moved, mu)[0].time - FIRST_TRANSITION[mu][0]


# --- ladders ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("label", LADDER_CASES)
@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_ladder_begins_with_the_engine_as_it_comes_and_has_six_settings_or_more(name, route, label):
    adapter, case = adapters.engine(name), one(label)
    refusal = adapter.refuses(case, route)
    if refusal:
        pytest.skip(refusal)
    settings = adapter.ladder(case, route)
    assert [setting.is_default for setting in settings] == [True] + [False] * (len(settings) - 1)
    assert len(settings) >= 6
    # The tables tell settings by their text.
    assert len({str(setting) for setting in settings}) == len(settings)
    steps = [setting["h"] for setting in settings[1:]]
    assert all(coarse > fine > 0.0 for coarse, fine in zip(steps[:-1], steps[1:], strict=True))


@pytest.mark.parametrize("label", LADDER_CASES)
@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_default_settings_are_a_small_grid_that_begins_with_the_ladder(name, route, label):
    adapter, case = adapters.engine(name), one(label)
    if not hasattr(adapter, "default_grid") or adapter.refuses(case, route):
        pytest.skip("it has no grid of default settings for this case")
    grid, ladder = adapter.default_grid(case, route), adapter.ladder(case, route)
    assert grid[0] == ladder[0] and all(setting.is_default for setting in grid)
    assert 2 <= len(grid) <= 8 and len({str(setting) for setting in (*grid, *ladder)}) == len(grid) + len(ladder) - 1
    (offer,) = (offer for offer in tasks.survey(case, name) if offer.route == route)
    assert offer.settings == (*grid, *ladder[1:])


# --- rows ------------------------------------------------------------------------------------------------------------


def rows_of(chosen: tuple[Case, ...], most: int, jobs: int) -> None:
    """Run `most` settings of every route on the cases; fails unless each route has its row: a result or a reason."""
    names = tuple(installed())
    with Calls(jobs) as calls:
        found = experiment.run_cases(
            chosen, names, calls, thin=lambda case, solver, route, settings: tuple(one_default(settings))[:most]
        )
    for case in chosen:
        for name, route in ROUTES:
            rows = [r for r in found.runs if (r.case, r.solver, r.route) == (case.label, name, route)]
            assert rows, f"{case.label} has no row for {name}, {route}"
            for row in rows:
                assert row.outcome in OUTCOMES
                output = f"{case.label}, {name}, {route}, {row.setting}: {row.outcome}, {row.reason}"
                # A catalogue case may be unsupported or reported wrongly; nothing of ours may break on it.
                assert row.outcome not in ("crashed", "timed_out"), output
                assert row.outcome == "answered" or re.search(r"\w", row.reason), output
                assert row.outcome != "unsupported" or len(rows) == 1


def test_case_has_a_row_for_every_route_a_result_or_a_reason(in_process):
    with in_process():
        rows_of((one("disc_on_line[mu=0.1]"),), most=1, jobs=1)


@pytest.mark.slow
def test_every_catalogue_case_has_a_row_for_every_route_a_result_or_a_reason():
    rows_of(tuple(case for name in cases.names(hard=False) for case in cases.select(name)), most=3, jobs=2)


# --- what must be reached ---------------------------------------------------------------------------------------------

# The paper's application with mu = 0.1, first transition, finest rung, s.
WITHIN = {("exudyn", "native"): 1e-7, ("exudyn", "integrator"): 1e-5,
           ("pymunk", "native"): 5e-5, ("pymunk", "assisted"): 2e-8}  # fmt: skip


@pytest.mark.sampled(4, first=1)
@pytest.mark.parametrize(("name", "route"), WITHIN)
def test_finest_rung_reaches_what_the_route_can(name, route, accuracy):
    pytest.importorskip(f"adapters.{name}")
    accuracy(case="disc_in_circle[mu=0.1]", solver=name, route=route, quantity="first transition, finest rung (s)",
             error=first_error(name, route, 0.1), tolerance=WITHIN[name, route])  # fmt: skip


def order(errors: list[float], knob: tuple[float, ...]) -> float:
    """The slope of log |error| over log knob."""
    return float(np.polyfit(np.log(knob), np.log(np.abs(errors)), 1)[0])


def exudyn_setting(h: float, k: float) -> Setting:
    return Setting.of(solver="TrapezoidalIndex2", newton="full", h=h, k=k, vreg=1e-5)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", ["native", "integrator"])
def test_exudyn_converges_with_the_square_of_the_step_and_the_inverse_of_the_stiffness(route):
    pytest.importorskip("adapters.exudyn")
    # The error is C/k + O(h²), C of 40 to 90 s N/m: each is seen where the other is small.
    steps, stiffness = (2.1e-3, 1e-3, 5.2e-4), (1e5, 3e5, 1e6)
    of_step = [first_error("exudyn", route, 0.1, exudyn_setting(h, 1e9)) for h in steps]
    assert order(of_step, steps) == pytest.approx(2.0, abs=0.3)
    of_stiffness = [first_error("exudyn", route, 0.1, exudyn_setting(5e-4, k)) for k in stiffness]
    assert order(of_stiffness, stiffness) == pytest.approx(-1.0, abs=0.3)


@pytest.mark.sampled(2, first=1)
@pytest.mark.parametrize(("route", "expected", "rungs"), [("native", 1.0, (4, 5, 6)), ("assisted", 2.0, (1, 2, 3, 4))])
def test_pymunk_converges_with_its_order_of_the_step(route, expected, rungs):
    adapter = pytest.importorskip("adapters.pymunk")
    case = cases.load("disc_in_circle", mu=0.1, duration=1.2)
    settings = [adapter.ladder(case, route)[rung] for rung in rungs]
    errors = [first_error("pymunk", route, 0.1, setting) for setting in settings]
    assert order(errors, tuple(setting["h"] for setting in settings)) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize(("name", "route", "rungs"), [
    ("exudyn", "native", (1, 3, 8)), ("exudyn", "integrator", (1, 3, 7)), ("pymunk", "assisted", (1, 3, 5)),
])  # fmt: skip
@pytest.mark.sampled(3)
def test_four_transitions_none_missed_and_none_invented(name, route, rungs, accuracy):
    adapter = pytest.importorskip(f"adapters.{name}")
    case = cases.load("disc_in_circle", mu=0.2)
    for rung in rungs:
        moved = play(name, route, case, adapter.ladder(case, route)[rung])
        reading = read_motion(case, moved)
        assert [(str(e.before), str(e.after)) for e in reading.transitions] == [
            ("slip_forward", "roll"), ("roll", "slip_backward"), ("slip_backward", "roll"), ("roll", "slip_forward")
        ]  # fmt: skip
    worst = max(abs(event.time - time) for event, (time, *_) in zip(reading.transitions, SEQUENCE, strict=False))
    # Measured at the finest of these rungs: 6e-7, 2e-6 and 1e-7 s.
    accuracy(case=case.label, solver=name, route=route, quantity="worst of four transitions (s)", error=worst,
             tolerance=5e-6)  # fmt: skip


def test_first_rung_starts_where_the_case_does():
    case = one("disc_in_cosine")
    start = start_motion(case)
    for name, route in ROUTES:
        if adapters.engine(name).refuses(case, route):
            continue
        moved = play(name, route, case, adapters.engine(name).ladder(case, route)[0])
        rounding = max(1e-12, getattr(adapters.engine(name), "ROUNDING", 0.0))
        assert (moved.t[0], moved.x[0], moved.y[0]) == pytest.approx((0.0, start.x, start.y), abs=rounding)
