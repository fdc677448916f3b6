"""What each engine does with loads, rough contact, guides, flight and impact: closed forms, and the reference."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

import numpy as np
import pytest

import reference
from adapters import Setting, engine
from cases import Case, CoulombFriction, Gravity, Load, PerfectlyRough, Plate, Start, Trajectory, Unilateral, disc
from cases.library import circle, hill, line

from .scenes import ellipse

G, PUSH = Gravity(9.81), Unilateral()
# An inertia of its own, so that ½ m r² cannot hide.
DISC = disc(0.1, 2.0, inertia=0.012)
ROLLING = 1 + 0.012 / (2.0 * 0.1**2)
PLATE = Plate(ellipse(0.2, 0.12), 1.0, (0.2**2 + 0.12**2) / 4)
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
@pytest.mark.parametrize(("name", "route", "tolerance"), [("exudyn", "native", 1e-11), ("exudyn", "assisted", 1e-4)])
def test_perfectly_rough_disc_rolls_down_any_incline(name, route, tolerance, effects):
    slope = 1.2  # far beyond what friction of an ordinary coefficient would hold
    case = Case(line(slope), DISC, (G, PerfectlyRough(), *effects), Start(0.0), 0.5)
    moved = play(name, route, case)
    pull = 9.81 * sin(slope) / ROLLING
    assert moved.xi1[-1] == pytest.approx(0.5 * pull * 0.5**2, abs=tolerance)
    assert moved.omega[-1] == pytest.approx(-pull * 0.5 / 0.1, abs=tolerance / 0.01)
    # A constraint leaves the rounding of some thousand steps.
    assert np.abs(moved.slip).max() <= max(moved.slip_resolution, 1e-11)
    assert np.median(moved.normal_force) == pytest.approx(2.0 * 9.81 * cos(slope), abs=1e-6)
    friction = 2.0 * (pull - 9.81 * sin(slope))
    assert np.median(moved.friction_force) == pytest.approx(friction, rel=1e-4)


@pytest.mark.parametrize(("name", "route", "tolerance"), [("exudyn", "assisted", 1e-5)])
def test_perfectly_rough_disc_rolls_in_a_circle_as_the_reference_does(name, route, tolerance):
    case = Case(circle(1.0), DISC, (G, PerfectlyRough(), PUSH), Start(-2.6), 1.5)
    assert off(case, play(name, route, case))[0] < tolerance


# --- guides on both sides --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "route", "tolerance"), [("exudyn", "native", 2e-6), ("exudyn", "assisted", 1e-5)])
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


@pytest.mark.parametrize(("name", "route"), [("exudyn", "native"), ("exudyn", "assisted")])
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


@pytest.mark.parametrize("scene", LOADED)
@pytest.mark.parametrize(("name", "route", "tolerance"), [("exudyn", "native", 2e-4), ("exudyn", "assisted", 2e-4)])
def test_load_of_time_and_velocity_moves_the_plate_as_it_moves_the_reference(name, route, tolerance, scene):
    case = LOADED[scene]
    if engine(name).refuses(case, route):
        pytest.skip(engine(name).refuses(case, route))
    coarse, fine = (off(case, play(name, route, case, rung)) for rung in (1, 4))
    assert fine[0] < tolerance and fine[1] < 10 * tolerance
    assert fine[0] < 0.2 * coarse[0]
    # Without the load it would be elsewhere: the test can fail.
    without = replace(case, effects=tuple(effect for effect in case.effects if effect is not DRIVEN))
    assert off(case, play(name, route, without, 4))[0] > 100 * tolerance


@pytest.mark.parametrize(("name", "route"), [("exudyn", "native"), ("exudyn", "assisted")])
def test_load_that_grows_lifts_a_rough_disc_off_when_it_carries_the_weight(name, route):
    case = Case(line(0.0), DISC, (G, PerfectlyRough(), PUSH, Load(fy="30*t")), Start(0.0, omega=-3.0), 1.0)
    moved = play(name, route, case, 4)
    assert moved.status == "lift_off"
    assert moved.t[-1] == pytest.approx(2.0 * 9.81 / 30.0, abs=1e-5)


# --- what a case does not name is not built --------------------------------------------------------------------------


def items(system, kind: str) -> list[dict]:
    """The Exudyn items of one kind: "Object", "Load"."""
    count = getattr(system.systemData, f"NumberOf{kind}s")()
    return [getattr(system, f"Get{kind}")(number) for number in range(count)]


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
