"""Contacts computed from the poses of a motion: of discs in a groove, of plates on supports, of several plates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
import reference
from adapters import EngineFailure, gate
from adapters.common import contacts_from_poses, several_contacts
from cases import Case, Trajectory
from cases.motion.mechanics import gravity
from cases.scene.free_plates import names_of, plates_of
from reports.judging.several_contacts import same_contacts
from tests.sampling import quick_every

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


@pytest.mark.parametrize(
    ("corners", "twice"),
    [([(-1, 0), (0, 0), (1, 0)], False), ([(-1, 0), (0, 0), (1, -0.5)], False), ([(-1, 0.5), (0, 0), (1, 0.5)], True)],
)
def test_a_disc_touches_twice_only_where_a_chain_has_a_hollow_corner(corners, twice):
    """On tiles in line each search of the whole chain would take 5 ms a sample, and find one contact."""
    case = cases.load("disc_over_seams")
    start = cases.StartPose(-0.5, 0.1 if corners[0][1] == 0 else 0.4)
    case = replace(case, track=cases.Chain.polyline(corners), start=start)
    assert several_contacts.may_touch_twice(case) is twice


# --- supports ---------------------------------------------------------------------------------------------------------


@quick_every(6)
@pytest.mark.parametrize(
    "label",
    ["rocking_block", "rod_in_bowl", "block_into_bowl", "ladder_at_wall", "round_ladder_at_wall", "disc_spinning_in_v"],
)
def test_contacts_on_supports_follow_from_the_poses(label):
    case = cases.load(label)
    truth = reference.simulate(case, rtol=1e-10)
    motion = contacts_from_poses.with_contacts(case, samples_of(case, truth, 1201), 1e-9)
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


def test_the_momentum_gives_the_normal_forces_of_two_corners():
    """Three equations for the forces of two corners on one line: their normal forces are unique, their frictions have
    only a sum."""
    case = cases.load("sliding_box")
    truth = reference.simulate(case, rtol=1e-10)
    motion = samples_of(case, truth, 4001, 0.4)
    found = contacts_from_poses.with_contacts(case, motion, 1e-9, torsor(case, motion))
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
        motion = contacts_from_poses.with_plates(case, t, poses, rates, 1e-7, given)
        partners = same_contacts(motion, truth)
        assert all(partners.values())
        for name in truth.contact_names:
            own, exact = motion.contacts[partners[name]], truth.contact_columns(name, t)
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
