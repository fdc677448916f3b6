"""Contacts computed from the poses of a motion: of discs in a groove, of plates on supports, of several plates."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi

import numpy as np
import pytest

import cases
import reference
from adapters import EngineFailure, engine, gate
from adapters.common import feature_contacts, motion_file, motion_table, several_contacts
from cases import Case, Support, Trajectory
from cases.library import line
from cases.motion.mechanics import gravity
from cases.scene.free_plates import names_of, plates_of
from reports import export

from .engines import play

ROCKING = cases.load("disc_rocking_in_groove")


def samples_of(case: Case, truth: Trajectory, count: int, end: float | None = None) -> Trajectory:
    """Poses and velocities of the true motion."""
    t = np.linspace(0.0, end or truth.t[-1], count)
    return Trajectory(t=t, **truth(t)._asdict(), case=case)


def torsor(case: Case, motion: Trajectory) -> np.ndarray:
    """Force and moment of the contacts of one plate by the differences of its velocities, shape (n, 3)."""
    inertia = np.array([case.plate.mass, case.plate.mass, case.plate.inertia])
    change = inertia * np.gradient(np.array([motion.vx, motion.vy, motion.omega]), motion.t, axis=1).T
    return change - inertia * np.append(gravity(case), 0.0)


def same_places(own: np.ndarray, exact: np.ndarray, period: float | None) -> None:
    """Fails for parameters of other places of a curve; whole rounds may be counted from another one."""
    rounds = np.round((own - exact) / period) if period else 0.0
    np.testing.assert_allclose(own - rounds * (period or 0.0), exact, atol=1e-7)


# --- a disc with one curve ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rocking() -> tuple[Trajectory, Trajectory]:
    """The reference's motion, and its contacts by its poses alone."""
    truth = reference.simulate(ROCKING, rtol=1e-10)
    poses = samples_of(ROCKING, truth, 801)
    return truth, several_contacts.with_contacts(ROCKING, poses, lambda xi1: np.full(len(xi1), 1e-9))


def test_contacts_of_a_disc_in_a_groove_follow_from_the_poses(rocking):
    truth, motion = rocking
    assert motion.contact_names == truth.contact_names == ("plate/track", "plate/track 2")
    for name in motion.contact_names:
        own, exact = motion.contacts[name], truth.contact_columns(name, motion.t)
        closed = np.isfinite(exact.slip)
        assert np.array_equal(np.isfinite(own.slip), closed)
        # Poses are good to the integrator's 1e-10, and places on a groove's straight flanks as good as the poses.
        for column in ("slip", "normal_force", "friction_force", "xi1"):
            np.testing.assert_allclose(getattr(own, column)[closed], getattr(exact, column)[closed], atol=1e-7)
        np.testing.assert_allclose(np.sin(own.xi2 - exact.xi2)[closed], 0.0, atol=1e-7)


def test_forces_of_two_closed_contacts_are_unknown(rocking):
    """The momentum gives their sum only."""
    wide = several_contacts.with_contacts(ROCKING, rocking[1], lambda xi1: np.full(len(xi1), 0.01))
    both = np.all([np.isfinite(columns.slip) for columns in wide.contacts.values()], axis=0)
    assert both.any() and not both.all()
    for columns in wide.contacts.values():
        assert np.isnan(columns.normal_force[both]).all() and np.isfinite(columns.normal_force[~both]).all()


@pytest.mark.parametrize("name", ["disc_in_circle", "disc_in_parabola", "tightest_fit"])
def test_a_disc_that_fits_everywhere_touches_once(name):
    """The track's curvature is less than the disc's: the search is not made, and the motion stays as it was."""
    assert not several_contacts.may_touch_twice(cases.load(name))
    assert several_contacts.may_touch_twice(ROCKING)


def test_pymunk_rocks_as_the_law_of_impact_says(rocking):
    """Each hand-over multiplies the spin by (1 + 2 cos 2α)/3, α the flanks' incline where they are touched."""
    h, motion = engine("pymunk").ladder(ROCKING, "native")[3]["h"], play("pymunk", "native", ROCKING, 3)
    assert motion.contact_names == ("plate/track", "plate/track 2")
    impact = next(event.time for event in rocking[0].transitions)
    first = int(np.argmax(np.isfinite(motion.contacts["plate/track 2"].slip)))
    # Two steps: the engine sees an overlap at the end of one, and its contact acts in the next.
    assert abs(motion.t[first] - impact) <= 2.0 * h
    before, after = motion.omega[first - 2], motion.omega[first + 3]
    slope = float(np.arctan2(*ROCKING.track.tangent(motion.contacts["plate/track 2"].xi1[first])[::-1]))
    assert 0.0 < slope < pi / 9
    # In the five steps between the two samples the spin changes by gravity: at most (2/3) g sin α/r each.
    change = 5.0 * h * (2.0 / 3.0) * 9.81 * np.sin(slope) / 0.5
    assert after / before == pytest.approx((1.0 + 2.0 * cos(2.0 * slope)) / 3.0, abs=change / abs(before))


def test_the_gate_copies_the_columns_of_each_contact(rocking):
    motion = rocking[1]
    plain = gate.motion(motion, ROCKING)
    assert plain.contact_names == motion.contact_names and plain.contact_columns is not motion.contact_columns
    for name, columns in motion.contacts.items():
        np.testing.assert_array_equal(plain.contacts[name].slip, columns.slip)
    short = {name: columns._replace(gap=columns.gap[1:]) for name, columns in motion.contacts.items()}
    for broken, words in (
        (dict(contact_columns=lambda name, times: short[name]), "gap of plate/track has 800 samples and its t has 801"),
        (dict(contact_names=("a", "a")), "names 2 contacts"),
    ):
        with pytest.raises(EngineFailure, match=words):
            gate.motion(replace(motion, **broken), ROCKING)


# --- supports ---------------------------------------------------------------------------------------------------------


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    "label",
    ["rocking_block", "rod_in_bowl", "block_into_bowl", "ladder_at_wall", "round_ladder_at_wall", "disc_spinning_in_v"],
)
def test_contacts_on_supports_follow_from_the_poses(label):
    case = cases.load(label)
    truth = reference.simulate(case, rtol=1e-10)
    motion = feature_contacts.with_contacts(case, samples_of(case, truth, 1201), 1e-9)
    assert motion.contact_names == tuple(sorted(truth.contact_names, key=list(motion.contact_names).index))
    for name in motion.contact_names:
        own, exact = motion.contacts[name], truth.contact_columns(name, motion.t)
        closed = np.isfinite(exact.slip)
        assert np.mean(np.isfinite(own.slip) == closed) > 0.95
        both = closed & np.isfinite(own.slip)
        for column in ("gap", "slip"):
            np.testing.assert_allclose(getattr(own, column)[both], getattr(exact, column)[both], atol=1e-7)
        same_places(own.xi1[both], exact.xi1[both], case.track.period)
        same_places(own.xi2[both], exact.xi2[both], case.plate.outline.period)


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
    motion, leaves = samples_of(case, truth, 801, 0.8), next(event.time for event in truth.transitions)
    for given, late in ((None, 2e-2), (torsor(case, motion), 3e-3)):
        found = feature_contacts.with_contacts(case, motion, 1e-5, given)
        last = motion.t[np.flatnonzero(np.isfinite(found.contacts["plate/wall"].slip))[-1]]
        assert abs(last - leaves) < late
    after = motion.t > leaves + 3e-3
    # Differences of samples 1 ms apart.
    alone, exact = found.contacts["plate/track"].normal_force[after], truth(motion.t).normal_force[after]
    np.testing.assert_allclose(alone[5:-5], exact[5:-5], rtol=1e-3)


def test_the_momentum_gives_the_normal_forces_of_two_corners():
    """Three equations for the forces of two corners on one line: their normal forces are unique, their frictions have
    only a sum."""
    case = cases.load("sliding_box")
    truth = reference.simulate(case, rtol=1e-10)
    motion = samples_of(case, truth, 4001, 0.4)
    found = feature_contacts.with_contacts(case, motion, 1e-9, torsor(case, motion))
    for name in truth.contact_names[:2]:
        exact = truth.contact_columns(name, motion.t)
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
ROCKING_BLOCK = {"pymunk": (4, 0.02, 0.01), "box2d": (5, 0.15, 0.12)}


@pytest.mark.parametrize("name", ROCKING_BLOCK)
def test_housners_block_rocks_impact_by_impact(name):
    """Each impact multiplies the spin by 1 − (3/2) sin² α."""
    case, (rung, least, late) = cases.load("rocking_block"), ROCKING_BLOCK[name]
    truth = reference.simulate(case, rtol=1e-9)
    impacts = [event.time for event in truth.transitions if event.cause == "impact"]
    # The largest angle after each impact; the true motion's steps are few.
    swings = turns_at(samples_of(case, truth, 3001), impacts)

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


@pytest.mark.parametrize("name", ["pymunk", "box2d"])
def test_a_ladder_leaves_its_wall_and_a_disc_in_a_v_stops(name):
    ladder = cases.load("ladder_at_wall[mu=0.1,mu_wall=0.2]")
    motion = play(name, "native", ladder, 3)
    # With the floor's friction at the wall it would be elsewhere: the rows of `test_motions` can fail.
    exact = reference.simulate(ladder)(motion.t)
    other = reference.simulate(replace(ladder, supports=(Support(line(pi / 2), "wall"),)))(motion.t)
    assert np.hypot(other.x - exact.x, other.y - exact.y).max() > 2e-2
    wall = motion.contacts["plate/wall"]
    assert motion.t[np.flatnonzero(np.isfinite(wall.slip))[-1]] == pytest.approx(0.827987362, abs=0.03)
    motion = play(name, "native", cases.load("disc_spinning_in_v"), 3)
    assert motion.t[np.argmax(np.abs(motion.omega) < 1e-2)] == pytest.approx(1.60375075, rel=5e-3)


def test_two_contacts_with_a_wall_push_although_either_of_them_would_do():
    # The belt slips below the block and presses both of its corners to the wall, in shares that are not unique.
    motion = play("pymunk", "native", cases.load("block_on_conveyor", speed=0.8, mu_static=0.0, stiffness=0.0), 0)
    # It rides after 0.8/(0.2 g), and its front corner begins 0.7 m from the wall.
    impact = 0.5 * 0.8 / (0.2 * 9.81) + 0.7 / 0.8
    for name in ("plate/wall", "plate/wall 2"):
        closed = np.isfinite(motion.contacts[name].slip)
        assert closed[motion.t > impact + 0.1].all() and not closed[motion.t < impact - 0.1].any()


# --- several plates ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("label", [
    "disc_on_free_disc[mu=0.5]", "disc_on_free_hemisphere", "pile_of_discs[mu=0.08]", "disc_off_free_block",
    "disc_on_free_wedge[mu=0.12]",
])  # fmt: skip
def test_contacts_of_free_plates_follow_from_the_poses(label):
    """The true motion's poses give its gaps, slips and parameters, and its momentum gives the forces."""
    case = cases.load(label)
    truth = reference.simulate(case, rtol=1e-10)
    t = np.linspace(0.0, truth.t[-1], 4001)
    state = np.array([np.array(truth.plate(name)(t)[:6]) for name in names_of(case)])
    poses, rates = state[:, :3].transpose(2, 0, 1), state[:, 3:].transpose(2, 0, 1)
    inertia = np.array([(p.mass, p.mass, p.inertia if p.turns else 1.0) for p in plates_of(case)])
    forces = inertia * (np.gradient(rates, t, axis=0) + [0.0, 9.81, 0.0])
    for given in (None, forces):
        motion = feature_contacts.with_plates(case, t, poses, rates, 1e-7, given)
        assert set(motion.contact_names) >= set(truth.contact_names)
        for name in truth.contact_names:
            own, exact = motion.contacts[name], truth.contact_columns(name, t)
            closed, is_closed = np.isfinite(exact.slip), np.isfinite(own.slip)
            assert np.mean(is_closed == closed) > 0.98
            both = closed & is_closed
            for column in ("gap", "slip"):
                np.testing.assert_allclose(getattr(own, column)[both], getattr(exact, column)[both], atol=1e-7)
            plate = plates_of(case)[names_of(case).index(name.partition("/")[0])]
            base = dict(zip(names_of(case), plates_of(case), strict=True)).get(name.partition("/")[2])
            same_places(own.xi1[both], exact.xi1[both], base.outline.period if base else None)
            same_places(own.xi2[both], exact.xi2[both], plate.outline.period)
            # Differences of samples 0.3 ms apart; at a change of mode they are of both sides.
            for column in ("normal_force", "friction_force") if given is not None else ():
                error = np.abs(getattr(own, column) - getattr(exact, column))[both]
                # Shares of the friction on two corners of one plate are not unique, all along.
                unique = error[np.isfinite(error)] if column == "friction_force" else error
                assert not len(unique) or np.mean(unique < 2e-2) > 0.99
