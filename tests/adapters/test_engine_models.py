"""What single engines do that no law shows: how they are set up, and the faults of theirs that their pages describe."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from adapters import Setting, engine
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Flight,
    Gravity,
    Impact,
    Load,
    Start,
    Unilateral,
    disc,
)
from cases.library import line
from reports.judging import slip_phases
from tests.sampling import quick_every

from .engines import off, play

G, PUSH = Gravity(9.81), Unilateral()
DISC = disc(0.1, 2.0, inertia=0.012)


# --- exudyn -----------------------------------------------------------------------------------------------------------


@quick_every(3, first=1)
@pytest.mark.parametrize("rung", [1, 3, 6])
def test_wheel_driven_to_and_fro_rolls_in_between_if_steps_are_cut_where_its_slip_ends(rung):
    case = cases.load("driven_disc")
    setting = pytest.importorskip("adapters.exudyn").ladder(case, "integrator")[rung]
    exact = [(event.before, event.after) for event in reference.simulate(case).transitions]
    found, without = (
        [
            (event.before, event.after)
            for event in slip_phases.read_contact(play("exudyn", "integrator", case, setting=s), 0.15).transitions
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


@quick_every(2)
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
    velocities = 1e12 * np.array(model.drives[0].rows)
    falls = -9.81 * model.h * np.arange(len(velocities))
    # The load itself adds 1e-10 to the velocities.
    assert velocities == pytest.approx(np.array([[0.8, v, 2.0] for v in falls]), abs=1e-9)


# --- box2d ------------------------------------------------------------------------------------------------------------


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
