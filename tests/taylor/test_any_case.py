"""Acceptance: what every case of the catalogue must pass.

`pytest --case-file=FILE` (with the =, or pytest takes the file for tests) runs these tests with the cases of that file.
"""

import numpy as np
import pytest

import cases
import reference
from cases import Case, Drive, Flight, Load, Mode
from cases.contact import overlap, start_motion
from cases.motion.trajectory import CONTACT
from cases.scene.contact_limits import touches_by_features
from cases.scene.supports import has_belt
from tests.own_cases import any_case
from tests.scenes import second as second_states
from tests.scenes.motions import energy, in_other_units, mirrored, motion_of, work_done

SWAPPED = {Mode.SLIP_FORWARD: Mode.SLIP_BACKWARD, Mode.SLIP_BACKWARD: Mode.SLIP_FORWARD}


def second(case: Case, times) -> second_states.SecondStates:
    """The second formulation with one contact."""
    if case.supports:
        pytest.skip("supports: both formulations are compared in tests/reference/test_agreement.py")
    if case.others:
        pytest.skip("several plates: both formulations are compared in tests/reference/test_agreement.py")
    if touches_by_features(case):
        pytest.skip("flat sides: both formulations are compared in tests/reference/test_agreement.py")
    return second_states.solve(case, rtol=1e-12, times=times)


def compare(case: Case, answer: second_states.SecondStates, times, accuracy, sign=1.0, time=1.0, velocity=1.0) -> None:
    """Asserts that an answer is the reference's motion of `case`, seen with that sign and in those units, and notes by
    `accuracy` how close it is."""
    motion = motion_of(case)
    swapped = SWAPPED if sign < 0 else {}
    expected = [(swapped.get(t.before, t.before), swapped.get(t.after, t.after)) for t in motion.transitions]
    assert [(t.before, t.after) for t in answer.transitions] == expected
    assert answer.status == motion.status
    # Transitions and states of two integrations at 1e-12; a grazing slip loses the square root of that.
    late = [t.time / time - own.time for t, own in zip(answer.transitions, motion.transitions, strict=True)]
    who = dict(case=case.label, solver="second formulation", route="contact frame", tolerance=1e-8)
    accuracy(**who, quantity="transitions / s", error=max(map(abs, late), default=0.0))
    # In flight there is no contact; an instant that the two put on different sides of an impact is left out.
    state = motion(times)
    there = sign * np.array([state.xi1, state.xi2, state.omega / time, velocity * state.slip])
    assert np.mean(np.isnan(there[0]) != np.isnan(answer.states[0])) <= 0.1
    size = np.nanmax(np.abs(there), axis=1, keepdims=True) + np.array([[1.0], [1.0], [1 / time], [velocity]])
    off = np.abs(answer.states - there) / size
    worst = max(np.max(off[:, np.isfinite(off[0])], initial=0.0), np.max(off[2]))
    accuracy(**who, quantity="contact and velocities, of the largest", error=worst)


def times_of(case: Case) -> np.ndarray:
    # Just short of the end: where contact ends there, the two formulations' ends differ by a rounding.
    return np.linspace(0.0, (1 - 1e-9) * motion_of(case).t[-1], 30)


@any_case()
def test_a_case_says_why_it_is_there_and_who_posed_it(any_case):
    text = cases.entry(any_case.name).function.__doc__ or ""
    assert text.strip().splitlines()[0].endswith((".", "?", ":")), "the docstring begins with one sentence"
    assert "Source:" in text, "the docstring names the source"


@any_case()
def test_the_start_is_an_admissible_contact(any_case):
    start = start_motion(any_case)
    assert overlap(any_case, start.x, start.y, start.theta) is None
    assert start.slip == any_case.start.slip


@any_case(6)
def test_the_reference_runs_and_says_how_it_ended(any_case):
    motion = motion_of(any_case)
    assert motion.reason.endswith(".")
    assert len(motion.t) > 1 and motion.t[-1] <= any_case.duration
    for name in ("x", "y", "theta"):
        assert np.all(np.isfinite(getattr(motion, name)))
    unique = np.isfinite(motion.normal_force)
    if not unique.all():  # the forces that hold a plate at rest may be open: their range is given
        low, high = motion.contacts[CONTACT].normal_range
        assert np.all(low[~unique] < high[~unique])
    off_the_track = ~np.isfinite(motion.slip)
    assert np.all(motion.normal_force[off_the_track] == 0.0)
    assert any_case.effect(Flight) is not None or not off_the_track.any()


def apart(one: np.ndarray, other: np.ndarray, period: float | None) -> np.ndarray:
    """Distances of parameters, whole turns of a closed curve aside: how many they are is a matter of counting."""
    difference = one - other
    return difference - period * np.round(difference / period) if period else difference


@any_case(6)
def test_two_formulations_agree(any_case, accuracy):
    if len(motion_of(any_case).contact_names) > 1:
        pytest.skip("several contacts: both formulations are compared in tests/reference/test_agreement.py")
    times = times_of(any_case)[::5]
    theirs = second(any_case, times)
    compare(any_case, theirs, times, accuracy)
    state = motion_of(any_case)(times)
    motions = np.array([getattr(state, quantity) for quantity in second_states.MOTION])
    assert np.array_equal(np.isnan(motions), np.isnan(theirs.motions))
    # Two integrations at 1e-12 over a few seconds, with spins of up to a hundred radians per second.
    common = dict(case=any_case.label, solver="reference", route="contact_frame", tolerance=1e-8)
    accuracy(**common, quantity="largest difference of motions", error=np.nanmax(np.abs(theirs.motions - motions)))
    for i, curve, own in ((0, any_case.track, state.xi1), (1, any_case.plate.outline, state.xi2)):
        worst = np.nanmax(np.abs(apart(theirs.states[i], own, curve.period)), initial=0.0)
        accuracy(**common, quantity=f"largest difference of xi{i + 1}", error=worst)


@any_case(6)
def test_the_energy_that_is_gained_is_the_work_that_is_done(any_case, accuracy):
    motion = motion_of(any_case)
    if any_case.effect(Flight) and any_case.effect(Drive):
        pytest.skip("a track that moves does work in every impact")
    if any_case.effect(Flight) and not any_case.effect(Load) and not has_belt(any_case):
        energies = energy(any_case, motion)
        # Rounding of sums of a few terms; DOP853's errors over a phase are some hundred times that.
        share = {"taylor": 8 * np.finfo(float).eps, "dop853": 1e-12}[reference.METHODS[0]]
        assert np.all(np.diff(energies) <= 1e-9 * np.ptp(energies) + share * np.abs(energies).max()), (
            "no impact and no mode adds energy"
        )
        return
    work = work_done(any_case, motion)
    if np.isnan(work):
        pytest.skip("the forces of several contacts are not unique, so the work of each is not known")
    gained = energy(any_case, motion(float(motion.t[-1]))) - energy(any_case, motion(0.0))
    state = motion(times_of(any_case))
    scale = float(np.ptp(energy(any_case, state))) + float(np.max(state.vx**2 + state.vy**2)) * any_case.plate.mass
    # The reference's 1e-12 and Gauss's rule over forty panels a phase; what is left is far above either.
    # A plate at rest: the rounding of its height, m g r, is all that changes.
    moves = scale > 1e-12 * any_case.plate.mass * 9.81 * any_case.plate.reach
    error = (gained - work) / scale if moves else gained
    who = dict(case=any_case.label, solver="reference", route="best", quantity="energy, of what moves")
    accuracy(**who, error=error, tolerance=1e-9)


UNITS = dict(length=2.5, time=1.7, mass=3.1, turn=0.7)


@any_case(16, first=10)
def test_the_mirror_image_turned_and_in_other_units_moves_alike(any_case, accuracy):
    times = times_of(any_case)
    seen = dict(sign=-1.0, time=UNITS["time"], velocity=UNITS["length"] / UNITS["time"])
    other = second(in_other_units(mirrored(any_case), **UNITS), times * UNITS["time"])
    compare(any_case, other, times, accuracy, **seen)
