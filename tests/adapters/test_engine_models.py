"""What single engines do that no law shows: how they are set up, and the faults of theirs that their pages describe."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from adapters import EngineFailure, Setting, engine
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    Start,
    Unilateral,
    disc,
)
from cases.library import circle, line
from reports.judging import slip_phases

from .engines import off, play

G, PUSH = Gravity(9.81), Unilateral()
DISC = disc(0.1, 2.0, inertia=0.012)


# --- exudyn -----------------------------------------------------------------------------------------------------------


@pytest.mark.sampled(3, first=1)
@pytest.mark.parametrize("rung", [1, 3, 6])
def test_wheel_driven_to_and_fro_rolls_in_between_if_steps_are_cut_where_its_slip_ends(rung):
    case = cases.load("driven_disc")
    setting = pytest.importorskip("adapters.exudyn").ladder(case, "integrator")[rung]
    exact = [(event.before, event.after) for event in reference.simulate(case).transitions]
    found, without = (
        [
            (event.before, event.after)
            for event in slip_phases.read_transitions(play("exudyn", "integrator", case, setting=s), 0.15)
        ]
        for s in (setting, setting.but(cut=None))
    )
    assert found == exact and without != exact


def crossings(motion) -> int:
    """How often the slip, where it surely is one, turns to the other side."""
    signs = np.sign(motion.slip[np.abs(motion.slip) > 2 * motion.slip_resolution])
    return int(np.sum(np.diff(signs) != 0))


@pytest.mark.parametrize("rung", [1, 2, 3])
def test_slip_that_ends_in_stick_does_not_overshoot_to_the_other_side(rung):
    # In the valley the cone is used up to 0.87 where the slip ends: an overshoot would last for tens of steps.
    case = replace(cases.load("disc_in_cosine"), duration=0.885)
    setting = pytest.importorskip("adapters.exudyn").ladder(case, "integrator")[rung]
    assert crossings(play("exudyn", "integrator", case, setting=setting.but(cut=None))) == 1
    assert crossings(play("exudyn", "integrator", case, setting=setting)) == 0


@pytest.mark.slow
def test_slip_that_reverses_leaves_less_error_if_steps_are_cut_there():
    case, exudyn = cases.load("disc_in_circle", mu=0.1), pytest.importorskip("adapters.exudyn")
    assert not any("cut" in setting for setting in exudyn.ladder(case, "native"))
    setting, truth = exudyn.ladder(case, "integrator")[-1], reference.simulate(case, rtol=1e-12)
    motions = [play("exudyn", "integrator", case, setting=s) for s in (setting.but(cut=None), setting)]
    uncut, cut = (float(np.hypot(m.x[-1] - truth.x[-1], m.y[-1] - truth.y[-1])) for m in motions)
    # Measured 1.1e-4 and 2.4e-5 m.
    assert cut < 0.3 * uncut


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "label", ["driven_disc", "rolling_loop[ratio=3.5]", "disc_rolling_off_hill", "ellipse_on_hill"]
)
def test_first_step_presses_and_rubs_as_the_rigid_plate_does(label):
    (case,), exudyn = cases.select(label), pytest.importorskip("adapters.exudyn")
    route, begin = "integrator" if exudyn.refuses(case, "native") else "native", slice(1, 6)
    motion, exact = play("exudyn", route, case, 3), reference.simulate(case)
    # Within the curvature of the path in five steps; set down by hand it is off by several times the weight.
    for name in ("normal_force", "friction_force"):
        apart = getattr(motion, name)[begin] - getattr(exact(motion.t[begin]), name)
        assert np.abs(apart).max() < 0.05 * case.plate.mass * 9.81, name


@pytest.mark.sampled(2)
@pytest.mark.parametrize("route", ["native", "integrator"])
def test_rounding_of_the_penetration_ends_no_rung(route):
    """With 1e-10 N, less than what the stiffest springs round by, Newton's method gave up on three rungs."""
    case = cases.load("disc_on_line", mu=0.3)
    for setting in pytest.importorskip("adapters.exudyn").ladder(case, route)[1:]:
        assert play("exudyn", route, case, setting=setting).vx[-1] == pytest.approx(2 / 3, abs=1e-3)


def test_steps_of_exudyn_are_those_that_it_took():
    """Newton's method fails at the kinks of the contact law, and the engine halves its steps there."""
    case = cases.load("eccentric_disc_on_line")
    setting = pytest.importorskip("adapters.exudyn").ladder(case, "integrator")[4]
    motion = play("exudyn", "integrator", case, setting=setting)
    assert motion.cost.steps == pytest.approx(len(motion.t), abs=1)
    assert motion.cost.steps > 1.5 * round(case.duration / setting["h"])
    # By default the engine makes a hundred steps.
    first = play("exudyn", "native", cases.load("disc_in_circle", mu=0.1), 0)
    assert first.cost.steps >= 100 and first.slip_resolution == 1e-3


def test_a_long_motion_of_exudyn_has_at_most_so_many_samples():
    setting = Setting.of(rung="long", solver="TrapezoidalIndex2", newton="full", h=5e-5, k=1e6, vreg=1e-4)
    motion = play("exudyn", "native", cases.load("disc_in_circle", mu=0.1), setting=setting)
    assert motion.cost.steps >= 50_000
    # The engine writes a sample at the first step past each period.
    assert 15_000 < len(motion.t) <= engine("exudyn").adapter.MOST_SAMPLES + 1
    assert motion.t[-1] == pytest.approx(2.5, abs=1e-9)


@pytest.mark.parametrize("track", [line(0.2), circle(1.0)])
def test_a_belt_s_surface_keeps_its_speed(track):
    """The plate's friction changes the speed of the heavy body by less than 1e-7 m/s."""
    effects = (G, CoulombFriction(0.3), PUSH, Belt(2.0))
    start, exudyn = Start(-np.pi / 2 if track.period else 0.0, slip=-2.0), pytest.importorskip("adapters.exudyn")
    case = Case(track, disc(0.1, 2.0), effects, start, 1.0)
    model = exudyn.build(case, "native", exudyn.ladder(case, "native")[2])
    exudyn.run(model)
    velocities = model.system.system.systemData.GetODE2Coordinates_t()
    speed = np.hypot(*velocities[3:5]) if not track.period else abs(velocities[5])
    assert speed == pytest.approx(2.0, abs=1e-7)


@pytest.mark.parametrize(
    ("mu", "law"),
    [
        ("0.1 + 0.1*exp(-v/0.05) + 0.02*v", (0.1, 0.1, 0.05, 0.02)),
        ("0.2 + 0.3*v", (0.2, 0.0, 1.0, 0.3)),
        ("0.4*exp(-10*v)", (0.0, 0.4, 0.1, 0.0)),
        ("0.2 + 0.2/(1 + v/0.1)", None),
        ("0.3 - 0.1*exp(-v)", None),
        ("0.1 + 0.1*exp(-v) + 0.1*exp(-2*v)", None),
    ],
)
def test_stribeck_s_law_is_recognised(mu, law):
    pytest.importorskip("adapters.exudyn")
    from adapters.exudyn.rolls import stribeck_law

    read = stribeck_law(CoulombFriction(mu))
    assert read is None if law is None else read == pytest.approx(law)


def test_a_corner_s_sphere_shrinks_with_the_setting_and_leaves_no_gap():
    case = cases.load("sliding_box")
    motions = [play("exudyn", "native", case, rung) for rung in (2, 6)]
    # It stands on the line, whatever the sphere: its centre stays at half the height within the deflection.
    assert all(np.abs(motion.y - 0.1).max() < 1e-3 for motion in motions)
    coarse, fine = (off(case, motion)[0] for motion in motions)
    assert fine < 0.3 * coarse


# --- pymunk -----------------------------------------------------------------------------------------------------------


def test_force_read_from_the_momentum_is_the_engines_own_impulse():
    adapter, case = pytest.importorskip("adapters.pymunk"), cases.load("disc_in_circle", mu=0.1, duration=0.2)
    model, impulses = adapter.build(case, "native", adapter.ladder(case, "native")[3]), list[tuple[float, float]]()
    model.space.on_collision(2, 1, post_solve=lambda arbiter, space, data: impulses.append(arbiter.total_impulse))
    adapter.run(model)
    # The plate touches in the first step, of h/2. The second, of h, begins with twice that impulse and reports it once:
    # its velocity changes by 3.184e-7 m/s, of which the engine tells 1.592e-7.
    output = np.hypot(*np.sum([*impulses, impulses[0]], axis=0))
    moved = adapter.read(model)
    kicks = np.full(len(moved.t), model.h)
    kicks[0] /= 2
    force = moved.normal_force * case.track.normal(moved.xi1) + moved.friction_force * case.track.tangent(moved.xi1)
    assert np.hypot(*np.sum(kicks * force, axis=1)) == pytest.approx(output, rel=1e-9)


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


@pytest.mark.parametrize("route", ["native", "assisted"])
def test_load_without_a_value_is_a_failure_with_its_reason(route):
    case = Case(line(0.0), DISC, (G, PUSH, Load(fx="sqrt(0.1 - t)")), Start(0.0), 0.3)
    with pytest.raises(EngineFailure, match="load has no value"):
        play("pymunk", route, case, 1)


# --- box2d ------------------------------------------------------------------------------------------------------------


def test_ladder_of_box2d_ends_before_rounding_scatters_forces_more_than_facets_do():
    """Forces are differences of velocities over h, of positions over h². Scatter by rounding adds to that by facets,
    which coarser steps show alone, as independent errors do."""
    case, scatter = cases.load("disc_in_circle", mu=0.2), []
    ladder = pytest.importorskip("adapters.box2d").ladder(case, "native")
    h = ladder[-1]["h"] / 1.5
    finer = ladder[-1].but(h=h, hertz=0.25 / h, facets=round(1.5 * ladder[-1]["facets"]))
    for setting in (ladder[-3], ladder[-1], finer):
        motion = play("box2d", "native", case, setting=setting)
        scatter.append(float(np.percentile(np.abs(np.diff(motion.normal_force)), 95)))
    by_facets, at_end, beyond = scatter
    # Measured: 11.5, 13.5 and 24 N, where the track pushes with 30 N at most.
    assert at_end < np.sqrt(2) * by_facets < beyond


@pytest.mark.parametrize("rung", [0, 3])
def test_poses_and_velocities_of_box2d_stand_at_the_same_times(rung):
    """The engine accelerates before it moves; read the other way round, the spin is late by a step."""
    case = Case(line(), disc(0.1, 1.0), (G, CoulombFriction(0.1), PUSH), Start(0.0, slip=2.0), 0.6)
    motion = play("box2d", "native", case, rung)
    # Before its spin is large enough for its fault; half a step's acceleration is ten times what is allowed here.
    early, rate, h = motion.t < 0.1, 0.1 * 9.81, engine("box2d").ladder(case, "native")[rung]["h"]
    exact = 2.0 * motion.t - 0.5 * rate * motion.t**2
    assert np.abs(motion.x - exact)[early].max() < 0.05 * rate * h
    assert np.abs(motion.vx - (2.0 - rate * motion.t))[early].max() < 0.05 * rate * h
    assert np.abs(motion.theta + rate / 0.1 * motion.t**2)[early].max() < 0.05 * rate / 0.1 * h
    # Half a turn later, which the engine's angle forgets.
    assert motion.theta[-1] == pytest.approx(-rate / 0.1 * 0.6**2, rel=1e-2)


def test_rolling_contact_of_box2d_presses_too_little_by_its_fault():
    """By half of m r ω ω̇ h, since the plate's own point of contact rises while it rolls (see the module)."""
    angle = 0.2
    track = Curve(lambda s: (s * np.cos(angle), -s * np.sin(angle)))
    case = Case(track, disc(0.1, 1.0), (G, CoulombFriction(0.5), PUSH), Start(0.0), 1.0)
    for h in (2e-3, 1e-3):
        motion = play("box2d", "native", case, setting=Setting.of(h=h, substeps=1, scale=1000.0, hertz=0.25 / h))
        late = slice(len(motion.t) // 2, -1)
        missing = 9.81 * np.cos(angle) - motion.normal_force[late]
        fault = 0.1 * motion.omega[late] * np.gradient(motion.omega, motion.t)[late] * h
        assert missing.mean() == pytest.approx(0.5 * fault.mean(), rel=0.1)


def test_box2d_as_it_comes_rebounds_from_no_landing_below_its_threshold():
    case = Case(line(), disc(0.1, 1.0), (G, PUSH, Flight(), Impact(0.5)), Start(0.0, gap=0.04), 0.4)
    assert np.sqrt(2 * 9.81 * 0.04) < 1.0
    assert np.nanmax(play("box2d", "native", case, 0).vy) < 0.1
    assert np.nanmax(play("box2d", "native", case, -1).vy) > 0.4


def test_hop_that_rounding_causes_is_no_flight():
    # With the finest steps the plate, half as large as its circle, was thrown off by 33 µm and caught again.
    assert play("box2d", "native", cases.load("cardano_disc"), -1).status == "completed"


# --- what a case does not name is not built ---------------------------------------------------------------------------


def model_of(name: str, *effects, track=None):
    """The model of a disc with these effects alone."""
    adapter = pytest.importorskip(f"adapters.{name}")
    case = Case(track or circle(1.0), DISC, effects, Start(-2.0), 1.0)
    return adapter.build(case, "native", adapter.ladder(case, "native")[1])


def products(model, name: str) -> set[float]:
    """The coefficients of pymunk's contacts, as the engine multiplies those of two shapes."""
    plate, shapes = model.bodies[0], model.space.shapes
    return {getattr(s, name) * getattr(t, name) for s in plate.shapes for t in shapes if t.body is not plate}


def test_pymunk_builds_nothing_that_the_case_does_not_name():
    plain = model_of("pymunk", PUSH)
    assert tuple(plain.space.gravity) == (0.0, 0.0) and plain.drive is None
    assert products(plain, "friction") == products(plain, "elasticity") == {0.0}
    driven = model_of("pymunk", PUSH, Load(fx=1.0), Flight(), Impact(0.5))
    assert driven.drive is not None and products(driven, "elasticity") == {0.5}


def test_exudyn_builds_nothing_that_the_case_does_not_name():
    def items(*effects, track=None) -> tuple[list[str], list[str], float]:
        """Its objects and loads, and the friction of the last object."""
        system = model_of("exudyn", *effects, track=track).system.system
        data = system.systemData
        objects, loads = (
            [getattr(system, f"Get{kind}")(number) for number in range(getattr(data, f"NumberOf{kind}s")())]
            for kind in ("Object", "Load")
        )
        mu = objects[-1].get("dynamicFriction", 0.0)
        return [one["objectType"] for one in objects], [one["loadType"] for one in loads], mu

    assert items(PUSH) == (["RigidBody2D", "Ground", "ContactSphereSphere"], [], 0.0)
    assert items(G, CoulombFriction(0.3), PUSH)[1:] == (["MassProportional"], 0.3)
    assert items(G)[0] == ["RigidBody2D", "Ground", "ConnectorDistance"]
    kinds, loads, _ = items(PerfectlyRough(), Load(fx=1.0), track=line(0.0))
    assert kinds == ["RigidBody2D", "Ground", "JointRollingDisc"] and loads == ["ForceVector", "TorqueVector"]
