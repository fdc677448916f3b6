"""Impulses of impacts: exact ones by momenta, their work by the change of kinetic energy."""

import pickle
from math import isnan, nan, sqrt

import numpy as np
import pytest

import cases
import reference
from cases import (
    Case,
    CoulombFriction,
    Flight,
    Gravity,
    Impact,
    Plate,
    StartPose,
    State,
    Trajectory,
    Unilateral,
    disc,
    library,
)
from cases.motion.sampled_contacts import SampledPlates
from cases.scene.free_plates import plates_of
from reference.impulses import impacts_of_samples

G = 9.81
ROUNDING = 1e-11  # relative: of the velocities at an impact, which an integration gives


def falls(plate, mu, e, x_rate=0.0, height=1.0, tilt=0.0):
    friction = (CoulombFriction(mu),) if mu else ()
    effects = (Gravity(G), *friction, Unilateral(), Flight(), Impact(e))
    return Case(library.line(), plate, effects, StartPose(0.0, height, tilt, vx=x_rate), 0.6)


def impulses(case, **how):
    return reference.impacts(case, reference.simulate(case, **how))


def test_a_disc_that_falls():
    m, r, e, speed = 1.5, 0.1, 0.5, sqrt(2 * G * 0.9)
    (first, *_) = impulses(falls(disc(r, m), 0.0, e))
    assert first.time == pytest.approx(speed / G, rel=ROUNDING)
    assert first.normal == pytest.approx((1 + e) * m * speed, rel=ROUNDING)
    assert first.friction == pytest.approx(0.0, abs=ROUNDING)
    assert first.work == pytest.approx(-0.5 * m * speed**2 * (1 - e**2), rel=ROUNDING)


def test_friction_of_an_oblique_impact_slides_or_grips():
    m, r, speed = 1.0, 0.1, sqrt(2 * G * 0.9)
    slides = impulses(falls(disc(r, m), 0.1, 0.5, x_rate=5.0))[0]
    assert slides.friction == pytest.approx(-0.1 * slides.normal, rel=ROUNDING)
    grips = impulses(falls(disc(r, m), 5.0, 0.5, x_rate=0.3))[0]  # a third of the slip is taken by the spin: P = m v/3
    assert grips.friction == pytest.approx(-m * 0.3 / 3, rel=ROUNDING) and abs(grips.normal) > speed


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("mu, sticks", [(0.4, True), (0.1, False)])
def test_a_motion_that_begins_with_an_impact_has_its_impulse(mu, sticks, method):
    # Backspin of 30 rad/s: the slip of 6 m/s needs 2 N s to vanish, as a third of it is the disc's own velocity.
    r, e = 0.1, 0.9
    effects = (Gravity(G), CoulombFriction(mu), Unilateral(), Flight(), Impact(e))
    case = Case(library.line(), disc(r, 1.0), effects, StartPose(0.0, r, vx=3.0, vy=-4.0, omega=30.0), 0.1)
    motion = reference.simulate(case, method=method)
    (impact,), (change,) = motion.impacts, motion.transitions
    friction = -2.0 if sticks else -mu * 4.0 * (1 + e)
    assert (impact.normal, impact.friction) == pytest.approx((4.0 * (1 + e), friction), rel=ROUNDING)
    slips = 6.0, 6.0 + 3.0 * friction
    assert impact.work == pytest.approx(-8.0 * (1 - e**2) + friction * np.mean(slips), rel=ROUNDING)
    assert motion.impulse_at(change) == impact and reference.check(case, motion) == ()


def test_a_box_that_lands_flat_has_one_friction_for_both_corners():
    case = falls(Plate.rectangle(0.4, 0.2, 1.0), 0.3, 0.0, x_rate=5.0)
    ends = impulses(case)
    assert len(ends) == 2 and all(isnan(one.friction) for one in ends)
    # Friction −0.3·P at the height 0.1 turns the box: N₁ + N₂ = P, and the moment 0.2 (N₂ − N₁) = 0.03 P.
    speed = sqrt(2 * G * 0.9)
    assert sorted(one.normal for one in ends) == pytest.approx([speed * 0.425, speed * 0.575], rel=1e-9)


@pytest.mark.parametrize("name", ["bouncing_disc", "row_of_discs", "disc_on_free_disc", "disc_onto_incline"])
@pytest.mark.parametrize("method", ["dop853", "taylor"])
def test_their_work_is_the_change_of_energy(name, method):
    if method == "taylor":
        pytest.importorskip("heyoka")
    case = cases.load(name)
    motion = reference.simulate(case, method=method)
    found = reference.impacts(case, motion)
    assert found and all(one.normal >= -ROUNDING for one in found)
    times = {one.time for one in found}
    lost = sum(one.work for one in found)
    jumps = sum(kinetic(case, motion, t, 1) - kinetic(case, motion, t, -1) for t in times)
    assert lost == pytest.approx(jumps, rel=1e-6, abs=1e-9)  # velocities 1e-9 s beside the impact


def kinetic(case, motion, t, side):
    total = 0.0
    for name, plate in zip(motion.plate_names, plates_of(case), strict=True):
        now = motion.plate(name)(min(max(t + 1e-9 * side, 0.0), motion.t[-1]))
        total += 0.5 * plate.mass * (now.vx**2 + now.vy**2) + 0.5 * plate.inertia * now.omega**2
    return total


def test_a_motion_without_impacts_has_none():
    case = cases.load("disc_in_circle")
    motion = reference.simulate(case)
    assert reference.impacts(case, motion) == motion.impacts == ()
    assert motion.transition_frame()["normal_impulse"].isna().all()


def test_a_motion_and_its_table_of_transitions_have_them():
    case = cases.load("dropped_box")
    motion = reference.simulate(case)
    assert repr(motion.impacts) == repr(reference.impacts(case, motion))  # NaN is not itself
    table = motion.transition_frame()
    hits = table[table.cause == "impact"]
    by_contact = {(one.time, one.contact): one.normal for one in motion.impacts}
    assert [by_contact[row.time, row.contact] for row in hits.itertuples()] == hits["normal_impulse"].tolist()
    alone = motion.of("plate/track 2")
    assert [one.contact for one in alone.impacts] == ["plate/track 2"]
    assert repr(pickle.loads(pickle.dumps(motion)).impacts) == repr(motion.impacts)
    with pytest.raises(cases.BadValue, match=r"one of reference.simulate has"):
        Trajectory(t=[0.0], **{name: [0.0] for name in State._fields}).impacts  # noqa: B018  (a property that raises)


@pytest.mark.parametrize("name", ["bouncing_disc", "disc_onto_incline", "disc_on_free_disc"])
def test_impulses_from_samples_beside_the_impacts(name):
    case = cases.load(name)
    truth = reference.simulate(case)
    t = np.linspace(0.0, truth.t[-1], 4001)
    plates = {one: np.array(truth.plate(one)(t)[:6]) for one in truth.plate_names}
    further = dict(plate_names=truth.plate_names, plate_columns=SampledPlates(t, plates)) if len(plates) > 1 else {}
    motion = Trajectory(t=t, **truth(t)._asdict(), **further)
    own = impacts_of_samples(case, truth, motion, lambda time: time)
    rest = 20.0 * sum(plate.mass for plate in plates_of(case)) * t[1]  # of contacts that go on, between two samples
    assert len(own) == len(truth.impacts) > 0
    times = [one.time for one in truth.impacts]
    for ours, exact in zip(own, truth.impacts, strict=True):
        if isnan(ours.normal):  # no sample between it and the next impact
            assert any(0.0 < abs(time - exact.time) < t[1] for time in times)
        else:
            assert ours[2:4] == pytest.approx(exact[2:4], rel=1e-6, abs=rest, nan_ok=True)
    late = impacts_of_samples(case, truth, motion, lambda time: 2.0 * truth.t[-1])
    assert all(isnan(one.normal) for one in late)


@pytest.mark.parametrize("force", [0.0, nan])
def test_samples_inside_an_impact_of_finite_duration_are_passed_over(force):
    """In 4 ms the velocities go evenly from those before the impact to those after it."""
    case = cases.load("rebound_with_spin")
    truth = reference.simulate(case)
    exact, t = truth.impacts[0], np.linspace(0.0, 0.8, 8001)
    columns, span = truth(t)._asdict(), exact.time + np.array([-1e-9, 4e-3])
    inside = (t > span[0]) & (t < span[1])
    for name in ("vx", "vy", "omega"):
        columns[name] = np.where(inside, np.interp(t, span, getattr(truth(span), name)), columns[name])
    for name in ("normal_force", "friction_force"):
        columns[name] = np.where(inside, force, columns[name])
    (own, *_) = impacts_of_samples(case, truth, Trajectory(t=t, **columns), lambda time: time)
    # Gravity is not that of a free fall inside it.
    assert own[2:4] == pytest.approx(exact[2:4], rel=1e-9, abs=4e-3 * 9.81 * case.plate.mass)
