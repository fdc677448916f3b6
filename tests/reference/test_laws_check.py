"""The check of laws: it finds planted faults of right motions, and none in the motions of the catalogue."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import cos, sin

import numpy as np
import pytest

import cases
import reference
from cases import (
    BadValue,
    Case,
    CoulombFriction,
    Curve,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Mode,
    Plate,
    StartPose,
    State,
    Support,
    Trajectory,
    Unilateral,
    disc,
)
from cases.library import line
from cases.motion.trajectory import ContactColumns
from reference import solve
from reference.laws_check.samples import of_motion


@cache
def right(label: str) -> Trajectory:
    """The motion of a case, which breaks no law."""
    motion = reference.simulate(cases.load(label))
    assert reference.check(cases.load(label), motion) == ()
    return motion


def of_scene(label: str, change: Callable[[Case], Case]) -> Callable[[], Trajectory]:
    """The motion of another scene, returned for this one."""
    return lambda: replace(reference.simulate(change(cases.load(label))), case=cases.load(label))


def of_state(label: str, change: Callable[[State, np.ndarray], State]) -> Callable[[], Trajectory]:
    """The right motion with other states."""

    def faulty() -> Trajectory:
        motion = right(label)
        dense = motion.dense
        return replace(motion, dense=lambda t: change(dense(t), t))

    return faulty


def of_contact(label: str, name: str, change: Callable[[ContactColumns], ContactColumns]) -> Callable[[], Trajectory]:
    """The right motion with other columns of one contact."""

    def faulty() -> Trajectory:
        motion = right(label)
        columns = motion.contact_columns
        return replace(motion, contact_columns=lambda n, t: change(columns(n, t)) if n == name else columns(n, t))

    return faulty


def of_transitions(label: str, change: Callable[[tuple], tuple]) -> Callable[[], Trajectory]:
    """The right motion with other transitions."""
    return lambda: replace(right(label), transitions=change(right(label).transitions))


def friction(mu: float, stick: float | None = None) -> Callable[[Case], Case]:
    """The scene with another friction."""
    return lambda case: with_effect(case, CoulombFriction(mu, stick))


def with_effect(case: Case, effect) -> Case:
    """The scene with an effect in the place of that of its kind."""
    return replace(case, effects=(*(e for e in case.effects if type(e) is not type(effect)), effect))


def heavier(case: Case) -> Case:
    """A plate of another mass and the same inertia."""
    return replace(case, plate=Plate(case.plate.outline, 1.001 * case.plate.mass, case.plate.inertia))


CIRCLE, BOX, FREE = "disc_in_circle[mu=0.2]", "sliding_box[mu=0.4,slope=0.2]", "disc_on_free_disc[mu=0.5]"
INCLINE, BOUNCE, ROW = "disc_onto_incline[mu=0.5]", "bouncing_disc[e=0.5]", "row_of_discs"


def after(time: float, **steps: float) -> Callable[[State, np.ndarray], State]:
    """States with something added from a time on."""
    return lambda s, t: s._replace(**{name: getattr(s, name) + step * (t >= time) for name, step in steps.items()})


def times(**factors: float) -> Callable[[State, np.ndarray], State]:
    """States with some columns multiplied."""
    return lambda s, t: s._replace(**{name: getattr(s, name) * factor for name, factor in factors.items()})


def plus(**rates: float) -> Callable[[State, np.ndarray], State]:
    """States with some columns that drift."""
    return lambda s, t: s._replace(**{name: getattr(s, name) + rate * t for name, rate in rates.items()})


def as_first(mode: Mode) -> Callable[[], Trajectory]:
    """A motion whose first phase has another mode."""
    first = right(CIRCLE).transitions[0]
    return replace(
        right(CIRCLE), first_mode=mode, transitions=(replace(first, before=mode), *right(CIRCLE).transitions[1:])
    )


def through() -> Trajectory:
    """Discs that go on as if they did not meet."""
    motion = right(ROW)
    columns = motion.plate_columns

    def of(name: str, t: np.ndarray) -> State:
        first = columns(name, np.zeros(1))
        s = columns(name, t)
        return s._replace(
            x=first.x + first.vx * t, vx=first.vx + 0.0 * t, omega=first.omega + 0.0 * t, theta=first.omega * t
        )

    return replace(motion, transitions=(), dense=lambda t: of("plate", t), plate_columns=of)


def of_plate(label: str, name: str, change: Callable[[State, np.ndarray], State]) -> Callable[[], Trajectory]:
    """The right motion with other states of one further plate."""

    def faulty() -> Trajectory:
        motion = right(label)
        columns = motion.plate_columns
        return replace(motion, plate_columns=lambda n, t: change(columns(n, t), t) if n == name else columns(n, t))

    return faulty


FAULTS = {
    "friction a millionth larger": (CIRCLE, of_scene(CIRCLE, friction(0.2 * (1 + 1e-6)))),
    "friction of a slip a tenth smaller": (CIRCLE, of_scene(CIRCLE, friction(0.18))),
    "no friction": (CIRCLE, of_scene(CIRCLE, friction(1e-12))),
    "sticks beyond its cone": (CIRCLE, of_scene(CIRCLE, friction(0.2, 0.4))),
    "mass in the forces": (CIRCLE, of_scene(CIRCLE, heavier)),
    "gravity a millionth stronger": (CIRCLE, of_scene(CIRCLE, lambda c: with_effect(c, Gravity(9.81 * (1 + 1e-6))))),
    "gravity is turned": (CIRCLE, of_scene(CIRCLE, lambda c: with_effect(c, Gravity(9.81, -1.57)))),
    "inertia a thousandth larger": (
        CIRCLE,
        of_scene(CIRCLE, lambda c: replace(c, plate=Plate(c.plate.outline, c.plate.mass, 1.001 * c.plate.inertia))),
    ),
    "a larger disc": (CIRCLE, of_scene(CIRCLE, lambda c: replace(c, plate=disc(1.001 * c.plate.radius, c.plate.mass)))),
    "friction of the wrong sign": (CIRCLE, of_state(CIRCLE, times(friction_force=-1.0))),
    "normal force of the wrong sign": (CIRCLE, of_state(CIRCLE, times(normal_force=-1.0))),
    "normal force a millionth larger": (CIRCLE, of_state(CIRCLE, times(normal_force=1 + 1e-6))),
    "friction force a millionth larger": (CIRCLE, of_state(CIRCLE, times(friction_force=1 + 1e-6))),
    "slip a millionth larger": (CIRCLE, of_state(CIRCLE, times(slip=1 + 1e-5))),
    "velocity a millionth larger": (CIRCLE, of_state(CIRCLE, times(vx=1 + 1e-6, vy=1 + 1e-6))),
    "spin a millionth larger": (CIRCLE, of_state(CIRCLE, times(omega=1 + 1e-6))),
    "angle drifts": (CIRCLE, of_state(CIRCLE, plus(theta=1e-5))),
    "place drifts": (CIRCLE, of_state(CIRCLE, plus(x=1e-5))),
    "place a micrometre off": (CIRCLE, of_state(CIRCLE, after(-1.0, y=-1e-5))),
    "place jumps": (CIRCLE, of_state(CIRCLE, after(1.0, x=1e-5))),
    "velocity jumps": (CIRCLE, of_state(CIRCLE, after(1.0, vx=1e-5))),
    "spin jumps": (CIRCLE, of_state(CIRCLE, after(1.0, omega=1e-3))),
    "slips in a roll": (
        CIRCLE,
        of_state(CIRCLE, lambda s, t: s._replace(slip=np.where((t > 0.7) & (t < 0.8), 1e-5, s.slip))),
    ),
    "times are shifted": (
        CIRCLE,
        lambda: replace(right(CIRCLE), dense=lambda t: right(CIRCLE).dense(np.maximum(t - 1e-4, 0.0))),
    ),
    "time runs faster": (CIRCLE, lambda: replace(right(CIRCLE), dense=lambda t: right(CIRCLE).dense(t * (1 - 1e-6)))),
    "contact parameter off": (CIRCLE, of_state(CIRCLE, after(-1.0, xi1=1e-5))),
    "outline's parameter off": (CIRCLE, of_state(CIRCLE, after(-1.0, xi2=1e-4))),
    "a transition a millisecond late": (
        CIRCLE,
        of_transitions(CIRCLE, lambda some: (replace(some[0], time=some[0].time + 1e-3), *some[1:])),
    ),
    "a transition that is not listed": (CIRCLE, of_transitions(CIRCLE, lambda some: some[2:])),
    "sense of slip": (CIRCLE, lambda: as_first(Mode.SLIP_BACKWARD)),
    "a slip that is called roll": (CIRCLE, lambda: as_first(Mode.ROLL)),
    "lost impact": (
        INCLINE,
        of_state(
            INCLINE,
            lambda s, t: (
                right(INCLINE)
                .dense(np.minimum(t, 0.15))
                ._replace(y=right(INCLINE).dense(np.array([0.0])).y - 0.5 * 9.81 * t**2)
            ),
        ),
    ),
    "an impact without friction": (INCLINE, of_scene(INCLINE, friction(1e-12))),
    "an impact beyond its cone": ("disc_onto_incline[mu=0.1]", of_scene("disc_onto_incline[mu=0.1]", friction(0.12))),
    "impacts that give energy": (
        BOUNCE,
        of_state(
            BOUNCE,
            lambda s, t: s._replace(
                vy=np.where((t > 0.32) & (t < 0.63), s.vy + 3.0, s.vy),
                y=np.where((t > 0.32) & (t < 0.63), s.y + 3.0 * (t - 0.3192754284070505), s.y),
            ),
        ),
    ),
    "a plate below its track": (BOUNCE, of_state(BOUNCE, after(-1.0, y=-1e-4))),
    "friction of a box a thousandth smaller": (BOX, of_scene(BOX, friction(0.4 * 0.999))),
    "slip of one corner of a box": (BOX, of_contact(BOX, "plate/track 2", lambda c: c._replace(slip=c.slip * 1.001))),
    "force of one corner of a box": (
        BOX,
        of_contact(BOX, "plate/track", lambda c: c._replace(normal_force=0.9 * c.normal_force)),
    ),
    "friction between plates": (FREE, of_scene(FREE, friction(0.5 * (1 + 1e-5)))),
    "the second plate's mass": (
        FREE,
        of_scene(
            FREE,
            lambda c: replace(
                c,
                others=tuple(
                    replace(o, plate=Plate(o.plate.outline, 1.001 * o.plate.mass, o.plate.inertia)) for o in c.others
                ),
            ),
        ),
    ),
    "a plate that enters another": (FREE, of_plate(FREE, "upper", after(-1.0, y=-1e-4))),
    "plates pass through each other": (ROW, through),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_a_broken_law(fault):
    label, faulty = FAULTS[fault]
    right(label)
    assert reference.check(cases.load(label), faulty())


def test_samples_are_read_only():
    """Of a motion, of one that travels, and of a solver's own arrays, which stay its own."""
    motion = right(CIRCLE)
    own = np.zeros(2)
    rows = [own] * len(State._fields)
    for one in (motion, pickle.loads(pickle.dumps(motion)), Trajectory(np.array([0.0, 1.0]), *rows)):
        with pytest.raises(ValueError, match="read-only"):
            one.x[0] = 1.0
    own[0] = 1.0


# A wedge of two discs on a floor, at a wall: (mass of the upper disc, friction, angle of the line of centres).
WEDGES = [
    (0.5, 0.3, 0.6),
    (0.2, 0.3, 0.9),
    (1.0, 0.3, 0.9),
    (0.2, 0.6, 0.6),
    (0.5, 0.6, 0.6),
    (1.0, 0.6, 0.6),
    (0.2, 0.6, 0.9),
]


@pytest.mark.parametrize("method", reference.METHODS)
@pytest.mark.parametrize("mass, mu, phi", WEDGES)
def test_a_disc_that_falls_through_the_floor_is_never_completed(mass, mu, phi, method):
    motion = reference.simulate(wedge(mass, mu, phi), method=method)
    lowest = float(motion.plate("b").y.min())
    assert lowest > 0.1 - 1e-9 or motion.status == "broken_law"
    if motion.status == "broken_law":
        assert "no overlap at b/track" in motion.reason and "completed" in motion.reason


def wedge(mass: float, mu: float, phi: float) -> Case:
    """A disc on another one, at a wall."""
    effects = Gravity(9.81), CoulombFriction(mu), Unilateral(), Flight(), Impact(0.0, "moreau")
    wall = Support(Curve(("0", "-s")), "wall")
    upper = FreePlate(disc(0.1, mass), StartPose(0.1, 0.2 + 0.3 * cos(phi)), "b")
    return Case(
        line(), disc(0.2, 1.0), effects, StartPose(0.1 + 0.3 * sin(phi), 0.2), 1.5, supports=(wall,), others=(upper,)
    )


def test_a_planted_solver_is_caught(monkeypatch):
    """A solver whose floor is lower than the case's: the check says so, and where."""
    right_one = solve.solve_motion

    def lower(case, *arguments):
        return right_one(replace(case, track=Curve(("s", "-0.05"))), *arguments)

    monkeypatch.setattr(solve, "solve_motion", lower)
    case = wedge(0.2, 0.3, 0.6)
    laws = reference.check(case, reference.simulate(case, method="dop853"))
    assert any("no overlap" in str(law) and "/track" in str(law) for law in laws), laws


@pytest.mark.parametrize("name", cases.names()[::9])
@pytest.mark.parametrize("rtol", [1e-10, 1e-6])
def test_motions_of_the_catalogue_break_no_law(name, rtol):
    for case in cases.select(name):
        motion = reference.simulate(case, rtol=rtol)
        assert motion.status != "broken_law", motion.reason
        if motion.dense is not None:
            assert reference.check(case, motion, rtol) == ()


def test_the_last_instant_of_a_step_is_before_its_end():
    """An impact may be there, and start + (end − start) may lie past the end."""
    knots = np.sort(np.random.default_rng(1).uniform(0.0, 3.0, (10_000, 2)), axis=1)
    samples = of_motion(right(BOUNCE).case, right(BOUNCE), *knots.T)
    assert (samples.times[:, -1] < knots[:, 1]).all() and (samples.times[:, 0] == knots[:, 0]).all()
    assert (samples.start + samples.length > samples.end).any()


def test_check_needs_a_dense_motion():
    with pytest.raises(BadValue, match="dense"):
        reference.check(cases.load(CIRCLE), replace(right(CIRCLE), dense=None))
