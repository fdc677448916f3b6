"""Every route of every installed engine: its ladder, its rows in an experiment, and what it must reach."""

from __future__ import annotations

import re

import numpy as np
import pytest

import cases
from adapters import EngineFailure, Setting, engine
from cases import Case
from cases.contact import start_motion
from reports.judging import slip_phases
from reports.running import experiment
from reports.running.calls import Calls
from reports.running.records import one_default
from tests.authorities.paper_application import FIRST_TRANSITION
from tests.sampling import quick_every

from .engines import play, routes

OUTCOMES = {"answered", "unsupported", "crashed", "timed_out"}
# A disc in a circle, on a line, in a valley, off a hill; a plate that is none on a line and on a hill; no gravity.
LADDER_CASES = (
    "disc_in_circle[mu=0.1]", "disc_on_line[mu=0.1]", "disc_in_cosine", "disc_sliding_off_hill",
    "ellipse_on_line[mu=1]", "ellipse_on_hill", "disc_in_weightless_ring",
)  # fmt: skip
every_route = pytest.mark.parametrize(("name", "route"), routes())


def one(label: str) -> Case:
    [case] = cases.select(label)
    return case


# --- ladders ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("label", LADDER_CASES)
@every_route
def test_ladder_begins_with_the_engine_as_it_comes_and_tightens_every_knob(name, route, label):
    adapter, case = engine(name), one(label)
    if refusal := adapter.refuses(case, route):
        pytest.skip(refusal)
    settings = adapter.ladder(case, route)
    assert [setting.is_default for setting in settings] == [True] + [False] * (len(settings) - 1)
    assert len(settings) >= 6
    # The tables tell settings by their text.
    assert len({str(setting) for setting in settings}) == len(settings)
    steps = [setting["h"] for setting in settings[1:]]
    assert all(coarse > fine > 0.0 for coarse, fine in zip(steps[:-1], steps[1:], strict=True))
    for knob, sign in (("facets", 1), ("vertices", 1), ("k", 1), ("hertz", 1), ("vreg", -1)):
        values = [sign * setting.get(knob, 0) for setting in settings[1:]]
        assert values == sorted(values), knob


@pytest.mark.parametrize(("name", "label", "knob"), [
    ("box2d", "disc_in_circle", "facets"), ("box2d", "disc_on_line", "hertz"), ("pymunk", "disc_in_circle", "facets"),
])  # fmt: skip
def test_grid_has_every_step_with_every_model_and_ends_with_the_finest(name, label, knob):
    settings = pytest.importorskip(f"adapters.{name}").grid(cases.load(label), "native")
    pairs = [(setting["h"], setting[knob], setting.get("neighbors", 0)) for setting in settings]
    steps, models = {h for h, *_ in pairs}, {tuple(model) for _, *model in pairs}
    assert len(set(pairs)) == len(pairs) == len(steps) * len(models) >= 9
    assert pairs[-1] == (min(steps), *max(models))


# --- rows ------------------------------------------------------------------------------------------------------------


def rows_of(some: tuple[Case, ...], most: int, jobs: int) -> None:
    """Run `most` settings of every route on the cases; fails unless each route has its row: a result or a reason."""
    names = tuple(dict.fromkeys(name for name, _ in routes()))
    with Calls(jobs) as calls:
        found = experiment.run_cases(
            some, names, calls, thin=lambda case, solver, route, settings: tuple(one_default(settings))[:most]
        )
    for case in some:
        for name, route in routes():
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


# --- exact values -----------------------------------------------------------------------------------------------------


def first_error(name: str, route: str, mu: float, rung: int = -1, setting: Setting | None = None) -> float:
    """Error of the first transition of the paper's application, s."""
    moved = play(name, route, cases.load("disc_in_circle", mu=mu, duration=1.2), rung, setting)
    return slip_phases.read_contact(moved, mu).transitions[0].time - FIRST_TRANSITION[mu][0]


# Rung, and the largest error (s) of the first transition there.
WITHIN = {
    ("exudyn", "native", 0.1): (-1, 1e-7), ("exudyn", "integrator", 0.1): (-1, 1e-6),
    ("pymunk", "native", 0.1): (-1, 5e-5), ("pymunk", "native", 0.2): (6, 5e-5), ("pymunk", "native", 0.01): (-1, 1e-4),
    ("pymunk", "assisted", 0.01): (4, 9e-7), ("pymunk", "assisted", 0.1): (-1, 2e-8),
    ("pymunk", "assisted", 0.2): (4, 4e-7),
    ("box2d", "native", 0.2): (-1, 5e-5),
    # A second-order step is off by h² over the time scale of the motion, √(r/g) = 0.1 s; it was 1.1 h² per second.
    ("pybullet", "assisted", 0.1): (5, 4e-7),
}  # fmt: skip


@quick_every(4, first=1)
@pytest.mark.parametrize(("name", "route", "mu"), WITHIN)
def test_first_transition_of_the_paper_is_where_the_route_can_have_it(name, route, mu, accuracy):
    rung, most = WITHIN[name, route, mu]
    accuracy(case=f"disc_in_circle[mu={mu:g}]", solver=name, route=route, quantity="first transition (s)",
             error=first_error(name, route, mu, rung), tolerance=most)  # fmt: skip


# Constant forces: semi-implicit Euler has no error here, only the rounding of a few hundred steps. In Exudyn the
# deflection m g/k of the contact shortens the arm of friction: 4/3 of its share of the radius, 3e-7 of the time.
BOWLING = {
    ("pymunk", "native"): (2, 1e-12), ("pymunk", "assisted"): (2, 1e-12), ("exudyn", "native"): (-1, 1e-6),
    ("exudyn", "integrator"): (-1, 1e-6), ("box2d", "native"): (-1, 1e-5), ("pybullet", "assisted"): (2, 1e-9),
}  # fmt: skip


@pytest.mark.parametrize("mu", [0.1, 0.3])
@pytest.mark.parametrize(("name", "route"), BOWLING)
def test_bowling_disc_rolls_at_the_exact_time_with_two_thirds_of_its_speed(name, route, mu, accuracy):
    case, exact, (rung, most) = cases.load("disc_on_line", mu=mu), 1.0 / (3 * mu * 9.81), BOWLING[name, route]
    moved = play(name, route, case, rung)
    slipping = (moved.t < exact - 2 * np.max(np.diff(moved.t))) & (moved.slip > 2 * moved.slip_resolution)
    slope, first = np.polyfit(moved.t[slipping], moved.slip[slipping], 1)
    row = dict(case=case.label, solver=name, route=route)
    accuracy(**row, quantity="transition time (s)", error=-first / slope - exact, tolerance=most)
    accuracy(**row, quantity="final speed (m/s)", error=moved.vx[-1] - 2 / 3, tolerance=10 * most)
    assert np.abs(moved.slip[moved.t > exact + 2 * moved.t[1]]).max() <= max(2 * moved.slip_resolution, 1e-12)


def test_first_rung_starts_where_the_case_does():
    case = one("disc_in_cosine")
    start = start_motion(case)
    for name, route in routes():
        if engine(name).refuses(case, route):
            continue
        moved = play(name, route, case, 0)
        rounding = max(1e-12, getattr(engine(name), "ROUNDING", 0.0))
        assert (moved.t[0], moved.x[0], moved.y[0]) == pytest.approx((0.0, start.x, start.y), abs=rounding)


# --- runs -------------------------------------------------------------------------------------------------------------


@every_route
def test_a_run_prints_nothing_leaves_no_file_and_has_the_same_numbers_again(name, route, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    case = cases.load("disc_in_circle", mu=0.2, duration=0.5)
    first, second = (play(name, route, case, 2) for _ in range(2))
    assert np.array_equal(first.t, second.t) and np.array_equal(first.slip, second.slip)
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


# The contact's own period is 2 ms; Runge–Kutta of order 4 at 10 ms is far outside its region of stability.
UNSTABLE = Setting.of(rung="unstable", solver="RK44", newton="full", h=1e-2, k=1e7, vreg=1e-3)
# A stiffness at which the penetration is below the rounding of the position: no Newton iteration can converge.
HOPELESS = Setting.of(rung="hopeless", solver="TrapezoidalIndex2", newton="full", h=1e-3, k=1e16, vreg=1e-9)


@pytest.mark.parametrize(("setting", "words"), [(UNSTABLE, "not finite"), (HOPELESS, "terminated")])
def test_exudyn_that_blows_up_or_gives_up_is_a_failure(setting, words, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(EngineFailure, match=words):
        play("exudyn", "native", cases.load("disc_in_circle", mu=0.1), setting=setting)
    assert list(tmp_path.iterdir()) == [] and capfd.readouterr() == ("", "")


@pytest.mark.parametrize("route", ["native", "assisted"])
def test_numbers_of_pymunk_that_are_not_finite_are_a_failure(route):
    adapter, case = pytest.importorskip("adapters.pymunk"), cases.load("disc_in_circle", duration=0.1)
    model = adapter.build(case, route, adapter.ladder(case, route)[1])
    model.bodies[0].velocity = (float("nan"), 0.0)
    adapter.run(model)
    with pytest.raises(EngineFailure, match="not finite"):
        adapter.read(model)


def test_a_chain_that_would_fill_the_memory_is_refused():
    pymunk, case = engine("pymunk"), cases.load("nearly_conforming", gap=1e-8)
    fine = pymunk.ladder(case, "native")[3]
    assert fine["facets"] > 10**6
    with pytest.raises(cases.NotSupported, match="needs .* facets, .* give a coarser setting"):
        pymunk.build(case, "native", fine)
