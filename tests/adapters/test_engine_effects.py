"""What each engine does with loads, rough contact, guides, flight and impact: closed forms, and the reference."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

import numpy as np
import pytest

import reference
from adapters import EngineFailure, Setting, engine
from cases import (
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    Trajectory,
    Unilateral,
    disc,
)
from cases.library import circle, hill, line
from tests.scenes.elliptic import ellipse

G, PUSH = Gravity(9.81), Unilateral()
# An inertia of its own, so that ½ m r² cannot hide.
DISC = disc(0.1, 2.0, inertia=0.012)
ROLLING = 1 + 0.012 / (2.0 * 0.1**2)
PLATE = Plate(ellipse(0.2, 0.12), 1.0, (0.2**2 + 0.12**2) / 4)
ROUTES = [("exudyn", "native"), ("exudyn", "integrator"), ("pymunk", "native"), ("pymunk", "assisted")]
DRIVEN = Load("3*sin(4*t) - 0.5*vx", "-0.3*vy", "0.1*cos(3*t) - 0.01*omega")


def play(name: str, route: str, case: Case, rung: int = -1, setting: Setting | None = None) -> Trajectory:
    pytest.importorskip(f"adapters.{name}")
    adapter = engine(name)
    refusal = adapter.refuses(case, route)
    assert refusal is None, refusal
    model = adapter.build(case, route, setting or adapter.ladder(case, route)[rung])
    adapter.run(model)
    return adapter.read(model)


def off(case: Case, moved: Trajectory) -> tuple[float, float]:
    """Largest distance of the centre (m) and of the angle (rad) from the reference's."""
    exact = reference.simulate(case, rtol=1e-11)(moved.t)
    turned = (moved.theta - moved.theta[0]) - (exact.theta - exact.theta[0])
    return float(np.hypot(moved.x - exact.x, moved.y - exact.y).max()), float(np.abs(turned).max())


# --- perfectly rough -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("effects", [(PUSH,), ()], ids=["pushes", "guides"])
@pytest.mark.parametrize(("name", "route", "tolerance"), [
    ("exudyn", "native", 1e-11), ("exudyn", "integrator", 1e-4),
    ("pymunk", "native", 1e-11), ("pymunk", "assisted", 1e-7),
])  # fmt: skip
@pytest.mark.sampled(3)
def test_perfectly_rough_disc_rolls_down_any_incline(name, route, tolerance, effects):
    slope = 1.2  # far beyond what friction of an ordinary coefficient would hold
    case = Case(line(slope), DISC, (G, PerfectlyRough(), *effects), Start(0.0), 0.5)
    refusal = engine(name).refuses(case, route)
    if refusal:
        pytest.skip(refusal)
    moved = play(name, route, case)
    pull = 9.81 * sin(slope) / ROLLING
    assert moved.xi1[-1] == pytest.approx(0.5 * pull * 0.5**2, abs=tolerance)
    assert moved.omega[-1] == pytest.approx(-pull * 0.5 / 0.1, abs=tolerance / 0.01)
    # A constraint leaves the rounding of some thousand steps; pymunk learns what changes in a step, after the first.
    assert np.abs(moved.slip[2:]).max() <= max(moved.slip_resolution, 1e-7 if name == "pymunk" else 1e-11)
    assert np.median(moved.normal_force) == pytest.approx(2.0 * 9.81 * cos(slope), abs=1e-6)
    friction = 2.0 * (pull - 9.81 * sin(slope))
    assert np.median(moved.friction_force) == pytest.approx(friction, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "route", "tolerance"), [
    ("exudyn", "integrator", 1e-5), ("pymunk", "assisted", 1e-6), ("pymunk", "native", 1e-3),
])  # fmt: skip
def test_perfectly_rough_disc_rolls_in_a_circle_as_the_reference_does(name, route, tolerance):
    case = Case(circle(1.0), DISC, (G, PerfectlyRough(), PUSH), Start(-2.6), 1.5)
    assert off(case, play(name, route, case))[0] < tolerance


# --- guides on both sides --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "route", "tolerance"), [
    ("exudyn", "native", 2e-6), ("exudyn", "integrator", 1e-5), ("pymunk", "assisted", 1e-6),
])  # fmt: skip
@pytest.mark.sampled(3)
def test_frictionless_guide_holds_a_disc_beyond_lift_off_and_leaves_its_spin(name, route, tolerance):
    case = Case(hill(1.0), DISC, (G,), Start(0.2, omega=1.0), 1.5)
    moved = play(name, route, case)
    assert moved.normal_force.min() < -10.0 and moved.normal_force.max() > 10.0
    assert np.abs(moved.omega - 1.0).max() < 1e-9
    assert off(case, moved)[0] < tolerance
    # N = m (g cos φ − v²/L), v² = 2 g L (cos φ₀ − cos φ).
    exact = 2.0 * 9.81 * (3 * np.cos(moved.xi1) - 2 * cos(0.2))
    # A penalty contact is set down without its deflection, and rings for some steps.
    assert np.abs(moved.normal_force - exact)[50:].max() < 1e-3 * np.abs(exact).max()


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("name", "route"), [("exudyn", "native"), ("exudyn", "integrator"), ("pymunk", "assisted")])
def test_frictionless_disc_slides_along_a_straight_guide_with_its_spin(name, route):
    case = Case(line(0.3), DISC, (G,), Start(0.0, slip=1.0, omega=1.0), 1.0)
    moved = play(name, route, case)
    # The slip is the centre's speed and the rim's: 1 = v + ω r.
    assert moved.xi1[-1] == pytest.approx(0.9 + 0.5 * 9.81 * sin(0.3), abs=1e-6)
    assert np.abs(moved.omega - 1.0).max() < 1e-9
    assert np.abs(moved.friction_force).max() < 1e-9


# --- loads -----------------------------------------------------------------------------------------------------------

LOADED = {
    "disc on a line": Case(line(0.1), DISC, (G, CoulombFriction(0.1), PUSH, DRIVEN), Start(0.0, slip=1.0), 1.0),
    "disc in a circle": Case(circle(1.0), DISC, (G, CoulombFriction(0.1), PUSH, DRIVEN), Start(-2.6), 1.0),
    "ellipse in a circle": Case(circle(1.0), PLATE, (G, CoulombFriction(0.2), PUSH, DRIVEN), Start(-2.4, -1.2), 1.2),
}


@pytest.mark.parametrize("scene", [
    pytest.param("disc on a line", marks=pytest.mark.slow), "disc in a circle", "ellipse in a circle",
])  # fmt: skip
@pytest.mark.parametrize(("name", "route", "tolerance"), [
    ("exudyn", "native", 2e-4), ("exudyn", "integrator", 2e-4),
    ("pymunk", "assisted", 2e-4), ("pymunk", "native", 5e-3),
])  # fmt: skip
@pytest.mark.sampled(4)
def test_load_of_time_and_velocity_moves_the_plate_as_it_moves_the_reference(name, route, tolerance, scene):
    case = LOADED[scene]
    if engine(name).refuses(case, route):
        pytest.skip(engine(name).refuses(case, route))
    coarse, fine = (off(case, play(name, route, case, rung)) for rung in (1, 6 if name == "exudyn" else 5))
    assert fine[0] < tolerance and fine[1] < 10 * tolerance
    assert fine[0] < 0.3 * coarse[0]
    # Without the load it would be elsewhere: the test can fail.
    without = replace(case, effects=tuple(effect for effect in case.effects if effect is not DRIVEN))
    assert off(case, play(name, route, without, 4))[0] > 10 * tolerance


@pytest.mark.parametrize("route", ["native", "assisted"])
def test_a_load_of_pymunk_has_the_velocity_of_its_pose(route):
    """The engine's own is half a step older. The load of a plate that falls freely is a trillionth of its velocity."""
    pymunk, load = engine("pymunk"), Load("1e-12*vx", "1e-12*vy", "1e-12*omega")
    case = Case(line(), DISC, (G, PUSH, Flight(), load), Start(0.0, gap=5.0, slip=1.0, omega=2.0), 0.5)
    model = pymunk.build(case, route, pymunk.ladder(case, route)[0])
    pymunk.run(model)
    velocities = 1e12 * np.array(model.drive.rows)
    falls = -9.81 * model.h * np.arange(len(velocities))
    # The load itself adds 1e-10 to the velocities.
    assert velocities == pytest.approx(np.array([[0.8, v, 2.0] for v in falls]), abs=1e-9)


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_load_that_grows_lifts_a_rough_disc_off_when_it_carries_the_weight(name, route):
    case = Case(line(0.0), DISC, (G, PerfectlyRough(), PUSH, Load(fy="30*t")), Start(0.0, omega=-3.0), 1.0)
    moved = play(name, route, case, 4)
    assert moved.status == "lift_off"
    assert moved.t[-1] == pytest.approx(2.0 * 9.81 / 30.0, abs=1e-5)


@pytest.mark.parametrize("route", ["native", "assisted"])
def test_load_without_a_value_is_a_failure_with_its_reason(route):
    pytest.importorskip("adapters.pymunk")
    case = Case(line(0.0), DISC, (G, PUSH, Load(fx="sqrt(0.1 - t)")), Start(0.0), 0.3)
    with pytest.raises(EngineFailure, match="load has no value"):
        play("pymunk", route, case, 1)


# --- flight and impact -----------------------------------------------------------------------------------------------

FLIES = (PUSH, Flight())
FALL = (2 * 0.5 / 9.81) ** 0.5  # s, from 0.5 m


@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_plate_that_no_impact_is_asked_of_ends_where_it_lands(name, route):
    case = Case(line(0.0), DISC, (G, *FLIES), Start(0.0, gap=0.5, slip=1.0, omega=3.0), 1.0)
    moved = play(name, route, case, 3)
    assert moved.status == "landing" and "no Impact" in moved.reason
    # The gap is followed to its end by a line through two samples: half of g h² over the speed.
    assert moved.t[-1] == pytest.approx(FALL, abs=1e-5)
    assert np.isnan(moved.slip).all() and np.isnan(moved.xi1).all()
    assert not moved.normal_force.any() and not moved.friction_force.any()
    assert moved.vx == pytest.approx(np.full(len(moved.t), 1.0 - 0.3), abs=1e-9)


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_disc_that_flies_off_a_hill_falls_free(name, route):
    case = Case(hill(1.0), disc(0.1, 1.0), (G, *FLIES), Start(0.3), 1.2)
    moved = play(name, route, case, 3)
    flies = np.isnan(moved.slip)
    # From where cos φ is two thirds of its start's on; before, there is contact.
    exact = reference.simulate(case, rtol=1e-11).transitions[0].time
    assert moved.status == "completed"
    assert moved.t[int(np.argmax(flies))] == pytest.approx(exact, abs=0.02)
    assert flies[-1] and not flies[0]
    # The last push may reach into the first step of flight, and exudyn's damper pulls for some steps at a release.
    assert np.diff(moved.vy[flies])[5:] == pytest.approx(-9.81 * np.diff(moved.t[flies])[5:], abs=1e-9)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("e", [0.0, 0.3, 0.8])
@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_dropped_disc_bounces_with_its_restitution(name, route, e):
    case = Case(line(0.0), DISC, (G, *FLIES, Impact(e)), Start(0.0, gap=0.5), 0.9)
    if engine(name).refuses(case, route):
        pytest.skip(engine(name).refuses(case, route))
    moved = play(name, route, case, 4)
    height = moved.y - 0.1
    # After the first landing it rises to e² of its height, or stays.
    top = height[moved.t > FALL + 1e-3].max()
    assert top == pytest.approx(0.5 * e**2, abs=4e-3)
    exact = reference.simulate(case, rtol=1e-11)(moved.t)
    assert np.abs(moved.y - exact.y).max() < 4e-3


@pytest.mark.sampled(2, first=1)
@pytest.mark.parametrize("e", [0.0, 0.6])
@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_friction_of_an_impact_turns_spin_into_speed(name, route, e):
    case = Case(line(0.0), DISC, (G, CoulombFriction(0.3), *FLIES, Impact(e)), Start(0.0, gap=0.3, omega=-20.0), 0.45)
    if engine(name).refuses(case, route):
        pytest.skip(engine(name).refuses(case, route))
    moved, exact = play(name, route, case, -1), reference.simulate(case, rtol=1e-11)
    # The impulse, from the engine's own speed of landing, is what the reference's construction gives.
    assert moved.vx[-1] == pytest.approx(exact.vx[-1], abs=2e-3)
    assert moved.omega[-1] == pytest.approx(exact.omega[-1], abs=0.05)
    assert abs(exact.vx[-1]) > 0.5


@pytest.mark.slow
@pytest.mark.parametrize(("name", "tolerance"), [("exudyn", 2e-3), ("pymunk", 5e-3)])
def test_disc_that_falls_out_of_a_loop_lands_on_its_other_side(name, tolerance):
    start = Start(-np.pi / 2, slip=float(np.sqrt(4.5 * 9.81 * 0.9)))
    case = Case(circle(1.0), disc(0.1, 1.0), (G, CoulombFriction(0.2), *FLIES, Impact(0.4)), start, 1.15)
    moved = play(name, "native", case, -1)
    exact = reference.simulate(case, rtol=1e-11)
    there = exact(moved.t)
    assert np.hypot(moved.x - there.x, moved.y - there.y).max() < tolerance
    flies = np.isnan(there.slip)
    assert 0.3 < flies.mean() < 0.9
    assert np.mean(np.isnan(moved.slip) != flies) < 0.02


def test_impact_that_an_engine_cannot_do_is_refused_with_the_reason():
    def reason(name: str, route: str, plate=DISC, e=0.5) -> str | None:
        case = Case(circle(1.0), plate, (G, *FLIES, Impact(e)), Start(-2.0, -1.2), 1.0)
        return engine(name).refuses(case, route)

    pytest.importorskip("adapters.exudyn")
    pytest.importorskip("adapters.pymunk")
    assert "restitution" in (reason("exudyn", "integrator") or "")
    assert "restitution" in (reason("pymunk", "assisted") or "")
    assert reason("pymunk", "assisted", e=0.0) is None
    assert reason("pymunk", "native", PLATE) is None  # by a law of its own, which its row tells


@pytest.mark.slow
def test_the_law_handed_to_exudyn_makes_no_impact_as_its_refusal_tells():
    """A critically damped spring that may not pull lets go where its force is none: at e^-2 of the speed it met with,
    if steps are far shorter than its time. Those of the ladder are longer, and the spring gives more than it took."""
    adapter, met = pytest.importorskip("adapters.exudyn"), np.sqrt(2 * 9.81 * 0.1)
    case = Case(line(0.0), DISC, (G, *FLIES, Impact(0.0)), Start(0.0, gap=0.1), 0.16)
    assert "faster than it arrived" in adapter.refuses(case, "integrator")
    finest = adapter.ladder(case, "integrator")[-1]

    def left(setting: Setting) -> float:
        model = adapter.build(case, "integrator", setting)
        adapter.run(model)
        return float(adapter.read(model).vy.max()) / met

    assert left(finest) > 1.0
    # Its time is 1.4 ms; gravity takes a hundredth of the speed in it.
    assert left(finest.but(k=1e6, h=5e-5)) == pytest.approx(np.exp(-2.0), rel=5e-2)


@pytest.mark.parametrize(("name", "route"), ROUTES)
def test_rolling_resistance_is_refused_by_its_name(name, route):
    pytest.importorskip(f"adapters.{name}")
    case = Case(line(0.1), DISC, (G, CoulombFriction(0.2), RollingResistance(0.01), PUSH), Start(0.0), 1.0)
    assert "RollingResistance" in (engine(name).refuses(case, route) or "")


# --- what a case does not name is not built --------------------------------------------------------------------------


def items(system, kind: str) -> list[dict]:
    """The Exudyn items of one kind: "Object", "Load"."""
    count = getattr(system.systemData, f"NumberOf{kind}s")()
    return [getattr(system, f"Get{kind}")(number) for number in range(count)]


def products(model, name: str) -> set[float]:
    """The coefficients of its contacts, as the engine multiplies those of two shapes."""
    plate, shapes = model.bodies[0], model.space.shapes
    return {getattr(s, name) * getattr(t, name) for s in plate.shapes for t in shapes if t.body is not plate}


def test_pymunk_builds_nothing_that_the_case_does_not_name():
    adapter = pytest.importorskip("adapters.pymunk")
    plain = pymunk_model(adapter, PUSH)
    assert tuple(plain.space.gravity) == (0.0, 0.0) and plain.drive is None
    assert products(plain, "friction") == products(plain, "elasticity") == {0.0}
    driven = pymunk_model(adapter, PUSH, Load(fx=1.0), Flight(), Impact(0.5))
    assert driven.drive is not None and products(driven, "elasticity") == {0.5}


def pymunk_model(adapter, *effects):
    case = Case(circle(1.0), DISC, effects, Start(-2.0), 1.0)
    return adapter.build(case, "native", adapter.ladder(case, "native")[1])


def test_exudyn_builds_nothing_that_the_case_does_not_name():
    adapter = pytest.importorskip("adapters.exudyn")

    def built(*effects, track=None) -> tuple[list[str], list[str], list[dict]]:
        case = Case(track or circle(1.0), DISC, effects, Start(-2.0), 1.0)
        model = adapter.build(case, "native", adapter.ladder(case, "native")[1])
        objects, loads = (items(model.system.system, kind) for kind in ("Object", "Load"))
        return [o["objectType"] for o in objects], [load["loadType"] for load in loads], objects

    kinds, loads, objects = built(PUSH)
    assert kinds == ["RigidBody2D", "Ground", "ContactSphereSphere"] and loads == []
    assert objects[-1]["dynamicFriction"] == 0.0
    kinds, loads, objects = built(G, CoulombFriction(0.3), PUSH)
    assert loads == ["MassProportional"] and objects[-1]["dynamicFriction"] == 0.3
    kinds, loads, _ = built(G)
    assert kinds == ["RigidBody2D", "Ground", "ConnectorDistance"]
    kinds, loads, _ = built(PerfectlyRough(), Load(fx=1.0), track=line(0.0))
    assert kinds == ["RigidBody2D", "Ground", "JointRollingDisc"] and loads == ["ForceVector", "TorqueVector"]
