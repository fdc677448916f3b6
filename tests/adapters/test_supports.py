"""Plates on several supports in engines: contacts computed from poses, and motions compared with exact answers."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin
from types import SimpleNamespace

import numpy as np
import pytest

import cases
import reference
from adapters import engine, refusal, refusal_of_several_contacts
from adapters.common import feature_contacts, motion_file, motion_table
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    Gravity,
    Impact,
    Plate,
    StartPose,
    Support,
    Trajectory,
    Unilateral,
    disc,
)
from cases.curves import cos as cosine_of
from cases.curves import sin as sine_of
from cases.library import circle, cosine, line
from cases.motion.mechanics import gravity
from reports import export
from tests.adapters.test_engine_effects import off, play

NATIVE = ("pymunk", "box2d")
EACH = pytest.mark.parametrize("name", NATIVE)


def from_poses(case: Case, truth: Trajectory, count: int = 1201) -> Trajectory:
    """The motion with its contacts computed from poses and velocities alone."""
    t = np.linspace(0.0, truth.t[-1], count)
    poses = Trajectory(t=t, **truth(t)._asdict(), case=case)
    return feature_contacts.with_contacts(case, poses, 1e-9)


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    "label",
    ["rocking_block", "rod_in_bowl", "block_into_bowl", "ladder_at_wall", "round_ladder_at_wall", "disc_spinning_in_v"],
)
def test_contacts_on_supports_follow_from_the_poses(label):
    case = cases.load(label)
    truth = reference.simulate(case, rtol=1e-10)
    motion = from_poses(case, truth)
    assert motion.contact_names == tuple(sorted(truth.contact_names, key=list(motion.contact_names).index))
    for name in motion.contact_names:
        own, exact = motion.contacts[name], truth.contact_columns(name, motion.t)
        closed = np.isfinite(exact.slip)
        assert np.mean(np.isfinite(own.slip) == closed) > 0.95
        both = closed & np.isfinite(own.slip)
        for column in ("gap", "slip", "xi1"):
            np.testing.assert_allclose(getattr(own, column)[both], getattr(exact, column)[both], atol=1e-7)
        rounds = (own.xi2 - exact.xi2)[both] / case.plate.outline.period
        np.testing.assert_allclose(rounds, np.round(rounds), atol=1e-7)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("label", ["sliding_box", "dropped_box"])
def test_an_exported_motion_of_a_box_is_read_back(label, tmp_path):
    case = cases.load(label)
    file = next(path for path in export.export(case, tmp_path) if path.name == "motion.csv")
    motion, truth = motion_file.trajectory_of(case, motion_table.read(file)), reference.simulate(case)
    assert motion.status == "completed" and motion.contact_names == truth.contact_names
    for name in truth.contact_names:
        exact = truth.contact_columns(name, motion.t).slip
        np.testing.assert_allclose(motion.contacts[name].slip, exact, atol=1e-9)


def test_a_contact_that_does_not_push_is_open():
    """The momentum says where the ladder leaves its wall: its gap grows with the cube of the time, 1 µm in 10 ms."""
    case = cases.load("ladder_at_wall")
    truth = reference.simulate(case, rtol=1e-10)
    t = np.linspace(0.0, 0.8, 801)
    state = truth(t)
    motion = Trajectory(t=t, **state._asdict(), case=case)
    rates = np.array([state.vx, state.vy, state.omega])
    change = np.gradient(rates, t, axis=1) * np.array([[case.plate.mass], [case.plate.mass], [case.plate.inertia]])
    torsor = (change + np.array([[0.0], [case.plate.mass * 9.81], [0.0]])).T
    leaves = next(event.time for event in truth.transitions)
    for given, late in ((None, 2e-2), (torsor, 3e-3)):
        found = feature_contacts.with_contacts(case, motion, 1e-5, given)
        last = t[np.flatnonzero(np.isfinite(found.contacts["plate/wall"].slip))[-1]]
        assert abs(last - leaves) < late
    assert abs(last - leaves) < 3e-3
    alone = found.contacts["plate/track"].normal_force[t > leaves + 3e-3]
    # Differences of samples 1 ms apart.
    np.testing.assert_allclose(alone[5:-5], state.normal_force[t > leaves + 3e-3][5:-5], rtol=1e-3)


def test_the_momentum_gives_the_normal_forces_of_two_corners():
    """Three equations for the forces of two corners on one line: their normal forces are unique, their frictions have
    only a sum."""
    case = cases.load("sliding_box")
    truth = reference.simulate(case, rtol=1e-10)
    t = np.linspace(0.0, 0.4, 4001)
    state = truth(t)
    motion = Trajectory(t=t, **state._asdict(), case=case)
    inertia = np.array([case.plate.mass, case.plate.mass, case.plate.inertia])
    change = inertia * np.gradient(np.array([state.vx, state.vy, state.omega]), t, axis=1).T
    found = feature_contacts.with_contacts(case, motion, 1e-9, change - inertia * np.append(gravity(case), 0.0))
    for name in truth.contact_names[:2]:
        exact = truth.contact_columns(name, t)
        closed = np.isfinite(exact.slip)
        # The samples next to a transition have differences across it; others of steps of 0.1 ms are good to 1e-8.
        steady = closed & (np.convolve(closed, np.ones(5), mode="same") == 5.0)
        assert np.sum(steady) > 1000
        error = np.abs(found.contacts[name].normal_force - exact.normal_force)[steady]
        assert np.median(error) < 1e-6 * case.plate.mass * 9.81
        assert np.isnan(found.contacts[name].friction_force[steady]).all()


def turns_at(motion: Trajectory, times: list[float]) -> list[float]:
    """The largest angle (rad) that the plate reaches between each of these times and the next."""
    return [
        float(np.abs(motion.theta[(motion.t >= a) & (motion.t <= b)]).max())
        for a, b in zip(times, times[1:], strict=False)
    ]


# Rung, and the relative error of swings and the error of impact times (s) allowed there: twice what was measured.
ROCKING = {"pymunk": (4, 0.02, 0.01), "box2d": (5, 0.15, 0.12)}


@EACH
def test_housners_block_rocks_impact_by_impact(name):
    """Each impact multiplies the spin by 1 − (3/2) sin² α."""
    pytest.importorskip(f"adapters.{name}")
    case = cases.load("rocking_block")
    truth = reference.simulate(case, rtol=1e-9)
    impacts = [event.time for event in truth.transitions if event.cause == "impact"]
    # The largest angle after each impact; the true motion's steps are few.
    times = np.linspace(0.0, truth.t[-1], 3001)
    swings = turns_at(Trajectory(t=times, **truth(times)._asdict()), impacts)
    rung, least, late = ROCKING[name]

    def errors(rung: int) -> tuple[float, float]:
        motion = play(name, "native", case, rung)
        assert motion.contact_names == ("plate/track", "plate/track 2")
        own = [float(motion.t[i + 1]) for i in np.flatnonzero(np.diff(np.sign(motion.theta)) != 0)]
        assert len(own) >= len(impacts)
        low = [abs(1.0 - a / b) for a, b in zip(turns_at(motion, own), swings, strict=False)]
        return max(low), max(abs(a - b) for a, b in zip(own, impacts, strict=False))

    fine = errors(rung)
    assert fine[0] < least and fine[1] < late
    if name == "box2d":  # a polygon of pymunk's depends on where in a step the corner lands, more than on the step
        assert fine[0] < 0.6 * errors(3)[0]


@EACH
def test_a_ladder_leaves_its_wall_and_a_disc_in_a_v_stops(name):
    pytest.importorskip(f"adapters.{name}")
    ladder = cases.load("ladder_at_wall[mu=0.1,mu_wall=0.2]")
    motion = play(name, "native", ladder, 3)
    exact = reference.simulate(ladder)(motion.t)
    assert np.hypot(motion.x - exact.x, motion.y - exact.y).max() < 1e-2
    # With the floor's friction at the wall it would be elsewhere: the test can fail.
    other = reference.simulate(replace(ladder, supports=(Support(line(pi / 2), "wall"),)))(motion.t)
    assert np.hypot(other.x - exact.x, other.y - exact.y).max() > 2e-2
    wall = motion.contacts["plate/wall"]
    assert motion.t[np.flatnonzero(np.isfinite(wall.slip))[-1]] == pytest.approx(0.827987362, abs=0.03)
    spinning = cases.load("disc_spinning_in_v")
    motion = play(name, "native", spinning, 3)
    assert {"plate/track", "plate/right"} == set(motion.contact_names)
    assert motion.t[np.argmax(np.abs(motion.omega) < 1e-2)] == pytest.approx(1.60375075, rel=5e-3)


@EACH
def test_a_box_lands_and_slides_on_one_track(name):
    """Without supports its contacts are read from its poses, too."""
    pytest.importorskip(f"adapters.{name}")
    case = on_a_slope(Plate.rectangle(0.4, 0.2, 1.0), 0.3)
    truth = reference.simulate(case)
    motion = play(name, "native", case, 4)
    assert motion.contact_names == truth.contact_names == ("plate/track", "plate/track 2")
    end = truth(1.0)
    # 0.2 mm off with steps of 0.5 ms; with longer ones another corner of pymunk's hits last, and it is 7 cm off.
    assert (motion.x[-1], motion.y[-1], motion.theta[-1]) == pytest.approx((end.x, end.y, end.theta), abs=1e-3)
    assert "which contacts from poses do not support" in refusal_of_several_contacts(
        engine(name), on_a_slope(Plate.half_disc(0.2, 1.0), 3.4, flat=True), "native"
    )


def on_a_slope(plate: Plate, theta: float, flat: bool = False) -> Case:
    """A plate that falls onto a slope, or lies on it with its flat side."""
    effects = Gravity(9.81), Unilateral(), CoulombFriction(0.3), Flight(), Impact(0.0, "moreau")
    low = float(plate.outline.bounds[3])
    flat_start = StartPose(low * sin(0.2), low * cos(0.2), pi - 0.2)
    return Case(line(0.2), plate, effects, flat_start if flat else StartPose(0.0, 0.3, theta), 1.0)


def groove(**changes) -> Case:
    """A disc that rocks in a V of two planes, from a place on the left one."""
    alpha, r, up = np.pi / 9, 0.5, 0.6
    x, y = -up * np.cos(alpha) + r * np.sin(alpha), up * np.sin(alpha) + r * np.cos(alpha)
    effects = (Gravity(9.81), CoulombFriction(1.0), Unilateral(), Flight(), Impact(0.0, "moreau"))
    case = Case(line(alpha), disc(r, 1.0), effects, StartPose(x, y), 3.0, supports=(Support(line(-alpha), "right"),))
    return replace(case, **changes)


def test_exudyn_spins_and_rocks_in_a_v():
    """A contact of its own for each plane; the hand-over is an impact of a spring and a damper."""
    pytest.importorskip("adapters.exudyn")
    spinning = cases.load("disc_spinning_in_v")
    coarse, fine = (off(spinning, play("exudyn", "native", spinning, rung))[0] for rung in (1, 5))
    assert fine < 5e-7 and fine < 0.02 * coarse
    motions = [play("exudyn", "native", groove(), rung) for rung in (1, 5)]
    coarse, fine = (off(groove(), motion)[0] for motion in motions)
    assert fine < 8e-3 and fine < 0.2 * coarse
    truth = reference.simulate(groove())
    impact = next(event.time for event in truth.transitions)
    motion = motions[-1]
    assert motion.contact_names == ("plate/track", "plate/right")
    assert motion.t[np.argmax(np.isfinite(motion.contacts["plate/right"].slip))] == pytest.approx(impact, abs=5e-3)
    # The disc rolls on one plane until then: the force of the only closed contact is known.
    alone = (motion.t > 0.1) & (motion.t < impact - 0.1)
    assert motion.contacts["plate/track"].normal_force[alone] == pytest.approx(9.81 * np.cos(pi / 9), rel=1e-3)


def test_routes_without_supports_reject_them_in_one_sentence():
    sentence = "The assisted route does not support several fixed curves (supports)."
    assert refusal(engine("pymunk"), groove(), "assisted") == sentence
    wave = groove(supports=(Support(cosine(0.1, 9.0), "wave"),), start=StartPose(0.0, 2.0))
    why = "A plate may touch the support 'wave' in several places, which are not distinguished here."
    assert refusal(engine("pymunk"), wave, "native") == why
    assert refusal_of_several_contacts(engine("pymunk"), wave, "native") == why
    endless = groove(supports=(Support(Curve(lambda s: (s, 0.1 * s * s - 3.0)), "valley"),))
    why = "Curved supports have ends or are closed here, and 'valley' is neither."
    assert refusal(engine("pymunk"), endless, "native") == why
    bowl = groove(supports=(Support(circle(3.0), "bowl"),))
    for name in ("exudyn", "pymunk"):
        assert refusal(engine(name), bowl, "native") is None
    belt = groove(supports=(Support(circle(3.0), "bowl", (CoulombFriction(0.3), Belt(1.0))),))
    why = "Belts run on straight supports only here, and 'bowl' is none."
    assert refusal(engine("pymunk"), belt, "native") == why
    on_belt = groove(effects=(*groove().effects, Belt(1.0)))
    for name in ("exudyn", "pymunk"):
        assert refusal(engine(name), on_belt, "native") is None


def in_bowl() -> Case:
    """A disc that rolls along a plane into a bowl."""
    effects = (Gravity(9.81), CoulombFriction(0.2), Unilateral(), Flight(), Impact(0.0, "moreau"))
    bowl = Support(Curve(lambda s: (1.4 * cosine_of(s), 1.0 + 1.4 * sine_of(s))), "bowl")
    return Case(line(), disc(0.3, 1.0), effects, StartPose(0.0, 0.3, vx=2.0), 1.2, supports=(bowl,))


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("name", "make", "least"),
    # Distance (m) allowed at the fifth rung: twice what was measured.
    [
        ("pymunk", lambda: cases.load("disc_between_hills"), 2.5e-6),
        ("pymunk", lambda: cases.load("rod_in_bowl", angle=0.7, mu=0.2), 4e-3),
        ("pymunk", lambda: cases.load("block_into_bowl"), 1.2e-2),
        ("pymunk", in_bowl, 6.2e-4),
        ("box2d", lambda: cases.load("disc_between_hills"), 1.1e-3),
        ("box2d", lambda: cases.load("rod_in_bowl", angle=0.7, mu=0.2), 6e-4),
        ("box2d", lambda: cases.load("block_into_bowl"), 1e-2),
        ("box2d", in_bowl, 1.4e-3),
    ],
)
def test_engines_have_curved_supports_as_facets_and_circles(name, make, least):
    pytest.importorskip(f"adapters.{name}")
    case, module = make(), engine(name)
    assert refusal(module, case, "native") is None and not refusal_of_several_contacts(module, case, "native")
    coarse, fine = (play(name, "native", case, rung) for rung in (0, 4))
    assert off(case, fine)[0] < least and off(case, fine)[0] < 0.2 * off(case, coarse)[0]
    assert fine.contact_names == reference.simulate(case).contact_names


def belts_in_v(left: str, right: str) -> Case:
    """A disc at rest in a V of two planes that are belts with these speeds."""
    case = cases.load("disc_in_v_of_belts")
    effects = tuple(effect for effect in case.effects if not isinstance(effect, Belt))
    start = StartPose(0.0, 0.5 / cos(pi / 6))
    own = Support(line(-pi / 6), "right", (CoulombFriction(0.3), Belt(right)))
    return replace(case, effects=(*effects, Belt(left)), start=start, supports=(own,))


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("name", "speeds", "least"),
    # Distance (m) allowed at the fourth rung: twice what was measured.
    [
        ("pymunk", ("1.5", "1.5"), 4e-7),
        ("pymunk", ("1.5 + 0.5*sin(5*t)", "1.5 - t"), 4e-4),
        ("box2d", ("1.5", "1.5"), 1e-5),
    ],
)
def test_each_support_is_a_belt_of_its_own(name, speeds, least):
    """Two belts of one speed leave the disc where it is; others drive it up one of the planes and back."""
    case = belts_in_v(*speeds)
    coarse, fine = (np.hypot(*np.array(off(case, play(name, "native", case, rung))) * [1, 0.5]) for rung in (2, 4))
    assert fine < least and fine < 0.5 * coarse


def test_box2d_rejects_belts_with_supports_whose_speed_changes():
    pytest.importorskip("adapters.box2d")
    why = "box2d's shapes keep the tangent speed that they are made with, and a belt here has another speed later."
    for speeds in (("1", "1 - t"), ("1 - t", "1")):
        assert refusal(engine("box2d"), belts_in_v(*speeds), "native") == why


def test_two_contacts_with_a_wall_push_although_either_of_them_would_do():
    # The belt slips below the block and presses both of its corners to the wall, in shares that are not unique.
    case = cases.load("block_on_conveyor", speed=0.8, mu_static=0.0, stiffness=0.0)
    motion = play("pymunk", "native", case, 0)
    # It rides after 0.8/(0.2 g), and its front corner begins 0.7 m from the wall.
    impact = 0.5 * 0.8 / (0.2 * 9.81) + 0.7 / 0.8
    for name in ("plate/wall", "plate/wall 2"):
        closed = np.isfinite(motion.contacts[name].slip)
        assert closed[motion.t > impact + 0.1].all() and not closed[motion.t < impact - 0.1].any()


@pytest.mark.parametrize(("name", "least"), [("pymunk", 1.3e-4), ("box2d", 2.2e-4)])
def test_a_box_slides_on_a_shaken_table(name, least):
    """`least`: distance (m) allowed at the fourth rung, twice what was measured."""
    case = cases.load("box_on_shaken_table")
    coarse, fine = (np.hypot(*off(case, play(name, "native", case, rung))) for rung in (2, 4))
    assert fine < least and fine < 0.4 * coarse


@pytest.mark.slow
@pytest.mark.parametrize(("name", "least"), [("pymunk", 7.2e-6), ("box2d", 4.6e-5)])
def test_supports_move_with_a_driven_track(name, least):
    """A V that is shaken and tilted carries a disc. `least`: as above."""
    drive = Drive(x="0.05-0.05*cos(9*t)", angle="0.05-0.05*cos(7*t)")
    effects = Gravity(9.81), Unilateral(), Flight(), Impact(0.0, "moreau"), CoulombFriction(0.3), drive
    start, right = StartPose(0.0, 0.5 / cos(pi / 6)), Support(line(-pi / 6), "right")
    case = Case(line(pi / 6), disc(0.5, 1.0), effects, start, 1.0, supports=(right,))
    assert not reference.simulate(case).transitions
    coarse, fine = (np.hypot(*np.array(off(case, play(name, "native", case, rung))) * [1, 0.5]) for rung in (2, 4))
    assert fine < least and fine < 0.5 * coarse


def test_other_routes_reject_a_box_on_a_shaken_table_in_one_sentence():
    pymunk, case = engine("pymunk"), cases.load("box_on_shaken_table")
    assert refusal(pymunk, case, "assisted") == "The assisted route does not support curves with corners."
    without = SimpleNamespace(**{name: getattr(pymunk, name) for name in ("CORNERS", "refuses")})
    why = "The native route does not support a driven track together with corners or supports."
    assert refusal(without, case, "native") == why
