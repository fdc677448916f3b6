"""The permanent set of planted faults, by name; and changes by a billionth of the data of random scenes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import inf
from typing import Any

import numpy as np

from cases import (
    Belt,
    Case,
    Chain,
    CoulombFriction,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    Mode,
    Outline,
    Plate,
    RollingResistance,
    Start,
    StartPose,
    Trajectory,
    Unilateral,
    disc,
)
from tests.composition.build import drawn
from tests.scenes import loads, slip_laws
from tests.scenes.moving import Adhesion
from tests.scenes.planted_motions import (
    MORE,
    Change,
    Fault,
    G,
    at_rest,
    at_wall,
    catalogue,
    column,
    contact_column,
    effect,
    ends,
    flat,
    flies,
    floats,
    flown_over,
    formulas,
    friction,
    hump,
    in_units,
    jump,
    later,
    loaded,
    modes,
    nearly_lifted,
    nearly_stops,
    on_line,
    on_slope,
    other_plate,
    paradox_rod,
    presses_on,
    rest_at,
    rolled_over,
    scene,
    simulate,
    slips_on,
    start,
    through,
    transitions,
    with_effect,
)

CIRCLE, LINE, BOUNCE = (
    catalogue("disc_in_circle", mu=0.2),
    catalogue("disc_on_line", mu=0.1),
    catalogue("bouncing_disc", e=0.5),
)
HILL, ELLIPSE, INCLINE = (
    catalogue("disc_sliding_off_hill"),
    catalogue("tumbling_ellipse"),
    catalogue("disc_onto_incline", mu=0.5),
)
ROLLS, FREE = catalogue("disc_rolling_to_rest"), catalogue("disc_on_free_disc", mu=0.5)
LADDER, BOX = catalogue("ladder_at_wall", mu=0.1, mu_wall=0.2), catalogue("sliding_box", mu=0.4, slope=0.2)
WAVE = loaded(fx="3*sin(5*t)")


@cache
def driven() -> Case:
    """A disc on a track that is shaken."""
    return on_line(Drive(x="0.05*sin(12*t)"))


@cache
def sticky() -> Case:
    """A disc with an effect of a package."""
    return on_line(Adhesion(5.0, 0.2, 0.001), slip=1.0)


@cache
def stops_at_end() -> Case:
    """A disc that begins to roll where the motion ends."""
    return on_line(CoulombFriction(0.1), duration=1 / (3 * 0.1 * G), slip=1.0)


@cache
def off_an_edge() -> Case:
    """A box that does not turn slides off a table, its side on the edge."""
    box = Plate(Outline.polygon([(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)]), 1.0, inf)
    table = Chain.polyline([(-3.0, 0.0), (0.0, 0.0), (0.0, -3.0)])
    effects = Gravity(G), Unilateral(), Flight(), Impact(0.0)
    return Case(table, box, effects, StartPose(0.033882740115579096, 0.04185642032305351, -0.3), 0.5)


def _gravity(case: Case, factor: float = 1.0, turn: float = 0.0) -> Gravity:
    own = case.effect(Gravity)
    assert own is not None
    return Gravity(own.g * factor, own.direction + turn)


def _larger_disc(case: Case) -> Case:
    own = case.plate
    assert own.radius is not None
    return replace(case, plate=Plate(disc(own.radius * MORE, 1.0).outline, own.mass, own.inertia))


def _of_supports(change: Callable[[Any], Any]) -> Change:
    return lambda case: replace(case, supports=tuple(change(s) for s in case.supports))


def _heavier_other(case: Case) -> Case:
    others = (replace(o, plate=Plate(o.plate.outline, o.plate.mass * MORE, o.plate.inertia)) for o in case.others)
    return replace(case, others=tuple(others))


def _impact(e: float, law: str | None = None) -> Callable[[Case], Trajectory]:
    """The motion with so much more restitution, and another law."""

    def other(case: Case) -> Impact:
        own = case.effect(Impact)
        assert own is not None
        return Impact(own.restitution + e, law or own.law)

    return effect(other)


def _mu(factor: float) -> Callable[[Case], Trajectory]:
    """Friction by the slip speed that is larger."""

    def other(case: Case) -> CoulombFriction:
        own = case.effect(CoulombFriction)
        assert own is not None
        return CoulombFriction(own.mu * factor)

    return effect(other)


def _wall_friction(support: Any) -> Any:
    own = tuple(CoulombFriction(e.mu * MORE) if isinstance(e, CoulombFriction) else e for e in support.effects or ())
    return replace(support, effects=own) if support.effects else support


FAULTS = {
    # data of the case, a billionth off
    "friction a billionth larger": Fault(CIRCLE, friction(MORE)),
    "friction a trillionth larger": Fault(CIRCLE, friction(1 + 1e-12)),
    "static friction a billionth larger": Fault(CIRCLE, friction(1.0, 0.2 * MORE)),
    "gravity a billionth stronger": Fault(CIRCLE, effect(lambda c: _gravity(c, MORE))),
    "gravity turned by a billionth": Fault(CIRCLE, effect(lambda c: _gravity(c, turn=-1e-9))),
    "inertia a billionth larger": Fault(CIRCLE, other_plate(inertia=MORE)),
    "mass a billionth larger, in forces alone": Fault(CIRCLE, other_plate(MORE, MORE)),
    "disc a billionth larger": Fault(CIRCLE, scene(_larger_disc)),
    "track a billionth larger": Fault(
        CIRCLE, scene(lambda c: replace(c, track=catalogue("disc_in_circle", mu=0.2, R=MORE)().track))
    ),
    "start a billionth along the track": Fault(CIRCLE, start(xi1=1e-9)),
    "slip of the start a billionth off": Fault(LINE, start(slip=1e-9)),
    "spin of the start a billionth off": Fault(LINE, start(omega=1e-9)),
    "belt a billionth faster": Fault(
        catalogue("disc_on_conveyor"), effect(lambda c: Belt(c.effect(Belt).constant * MORE))
    ),
    "restitution a millionth off": Fault(BOUNCE, _impact(1e-6)),
    "restitution 1e-10 off": Fault(BOUNCE, _impact(1e-10)),
    "another law of impact": Fault(ELLIPSE, _impact(0.0, "moreau")),
    "friction in an impact a billionth larger": Fault(ELLIPSE, friction(MORE)),
    "static friction ignored": Fault(catalogue("block_on_conveyor"), friction(1.0)),
    "friction by the slip speed a billionth larger": Fault(catalogue("stribeck_disc"), _mu(MORE)),
    "rolling resistance a billionth larger": Fault(ROLLS, effect(lambda c: RollingResistance(0.005 * MORE))),
    "rolling resistance missing": Fault(ROLLS, scene(lambda c: with_effect(c, None, RollingResistance))),
    "load a billionth larger": Fault(WAVE, effect(lambda c: Load(fx=f"{3 * MORE!r}*sin(5*t)"))),
    "load a nanosecond late": Fault(WAVE, effect(lambda c: Load(fx="3*sin(5*(t-1e-9))"))),
    "amplitude of a drive a billionth larger": Fault(driven, effect(lambda c: Drive(x=f"{0.05 * MORE!r}*sin(12*t)"))),
    "effect of a package a billionth larger": Fault(sticky, effect(lambda c: Adhesion(5.0 * MORE, 0.2, 0.001))),
    "friction between plates a billionth larger": Fault(FREE, friction(MORE)),
    "mass of the other plate a billionth larger": Fault(FREE, scene(_heavier_other)),
    "friction at the ladder's wall a billionth larger": Fault(LADDER, scene(_of_supports(_wall_friction))),
    "friction of a box a billionth larger": Fault(BOX, friction(MORE)),
    "gravity on a pile a billionth stronger": Fault(catalogue("pile_of_discs"), effect(lambda c: _gravity(c, MORE))),
    "restitution of a rocking block a millionth": Fault(catalogue("rocking_block"), _impact(1e-6)),
    # loads and ripples that are stepped over
    "bump of a load in time stepped over": Fault(
        loaded(fx="20*exp(-((t-0.7)/1e-4)**2)"), scene(lambda c: with_effect(c, None, Load))
    ),
    "bump of a load in place stepped over": Fault(
        loaded(fx="20*exp(-((x-0.3)/1e-4)**2)"), scene(lambda c: with_effect(c, None, Load))
    ),
    "bump of a load in velocity stepped over": Fault(
        loaded(fx="5*exp(-((vx-0.4)/1e-4)**2)"), scene(lambda c: with_effect(c, None, Load))
    ),
    "bump of a load of a micrometre stepped over": Fault(
        loaded(fx="20*exp(-((x-0.3)/1e-6)**2)"), scene(lambda c: with_effect(c, None, Load))
    ),
    "ripple of a millimetre flown through": Fault(flown_over(1e-3, 1e-4), scene(flat)),
    "ripple of 0.6 mm, 10 um wide, flown through": Fault(flown_over(6e-4, 1e-5), scene(flat)),
    "ripple of a micrometre on the track ignored": Fault(rolled_over, scene(flat)),
    "second contact with a hump missed": Fault(hump, scene(flat)),
    "support passed through": Fault(at_wall, scene(lambda c: replace(c, supports=()))),
    "plates pass through each other": Fault(catalogue("row_of_discs"), through),
    # ends and statuses
    "lift-off a millisecond early": Fault(HILL, ends(lambda m: m.t[-1] - 1e-3, "lift_off")),
    "lift-off a nanosecond early": Fault(HILL, ends(lambda m: m.t[-1] - 1e-9, "lift_off")),
    "lift-off a microsecond late": Fault(
        HILL,
        ends(
            lambda m: simulate(HILL()).t[-1] + 1e-6,
            "lift_off",
            lambda c: with_effect(replace(c, duration=simulate(c).t[-1] + 1e-3), None, Unilateral),
        ),
    ),
    "completed before its duration": Fault(CIRCLE, ends(lambda m: 2.0)),
    "completed a picosecond early": Fault(stops_at_end, ends(lambda m: m.t[-1] - 1e-12)),
    "lift-off where the track presses": Fault(CIRCLE, ends(lambda m: 0.3, "lift_off")),
    "end of the track inside it": Fault(
        cache(lambda: replace(rolled_over(), track=flat(rolled_over()).track)), ends(lambda m: 0.25, "track_end")
    ),
    **{
        f"false status {status}": Fault(CIRCLE, ends(lambda m: 0.3, status))
        for status in ("paradox", "second_contact", "accumulation", "unfinished", "breakdown", "landing", "not_unique")
    },
    # transitions
    "a transition 1e-10 s late": Fault(CIRCLE, later(1e-10, 0)),
    "a transition 1e-12 s late": Fault(CIRCLE, later(1e-12, 0)),
    "a transition 1e-10 s early": Fault(CIRCLE, later(-1e-10, 1)),
    "a roll that is called slip": Fault(
        CIRCLE, modes({0: {"after": Mode.SLIP_FORWARD}, 1: {"before": Mode.SLIP_FORWARD}})
    ),
    "sense of slip": Fault(CIRCLE, modes({1: {"after": Mode.SLIP_FORWARD}, 2: {"before": Mode.SLIP_FORWARD}})),
    "transitions that are not listed": Fault(CIRCLE, transitions(lambda some: some[2:])),
    "sticks where it must reverse": Fault(catalogue("disc_in_circle", mu=0.1), friction(1.0, 5.0)),
    "a contact of the ladder opens a nanosecond late": Fault(LADDER, later(1e-9)),
    "a series of impacts ends a microsecond early": Fault(BOUNCE, rest_at(-1e-6, is_shifted=False)),
    **{
        f"a series of impacts ends {by:g} s late, with all data": Fault(BOUNCE, rest_at(by, is_shifted=True))
        for by in (1e-7, 1e-5, 1e-3)
    },
    # columns
    **{
        f"{name} a billionth off": Fault(CIRCLE, column(name, change))
        for name, change in {
            "xi1": lambda x, t: x + 1e-9,
            "xi2": lambda x, t: x + 1e-9,
            "slip": lambda x, t: x * MORE,
            "normal_force": lambda x, t: x * MORE,
            "friction_force": lambda x, t: x * MORE,
            "vx": lambda x, t: x * MORE,
            "omega": lambda x, t: x * MORE,
        }.items()
    },
    "friction of the wrong sign": Fault(CIRCLE, column("friction_force", lambda x, t: -x)),
    "angle drifts by 1e-10 rad/s": Fault(CIRCLE, column("theta", lambda x, t: x + 1e-10 * t)),
    "place jumps by 1e-10 m": Fault(CIRCLE, jump("x", 1e-10)),
    "spin jumps by 1e-9 rad/s": Fault(CIRCLE, jump("omega", 1e-9)),
    "an impulse where a corner leaves an edge": Fault(off_an_edge, jump("vy", 0.083, change=0)),
    "a side sinks into its track by a nanometre per second": Fault(BOX, column("y", lambda y, t: y - 1e-9 * t)),
    "force of one corner of a box": Fault(BOX, contact_column("plate/track 2", "normal_force", 0.9)),
    "integrated by DOP853 at 1e-6": Fault(CIRCLE, lambda c: simulate(c, 1e-6, "dop853")),
    "integrated at 1e-8": Fault(CIRCLE, lambda c: simulate(c, 1e-8, "dop853")),
    # impacts
    "an impact without friction": Fault(
        catalogue("thrown_with_spin", backspin=2), effect(lambda c: CoulombFriction(1e-12))
    ),
    "an impact that slips where it sticks": Fault(INCLINE, effect(lambda c: CoulombFriction(0.1))),
    "no friction at the second contact": Fault(
        catalogue("disc_between_belt_and_wall"), scene(_of_supports(lambda s: replace(s, effects=())))
    ),
    # motions by formulas
    "rests on a slope beyond its cone": Fault(on_slope(0.2, -0.3), formulas(Mode.REST, at_rest)),
    "creeps where it rests": Fault(on_slope(0.2, 0.1), formulas(Mode.REST, lambda c: at_rest(c, 1e-9))),
    "a slip that is negative for 32 us": Fault(
        cache(lambda: nearly_stops(1e-9)), formulas(Mode.SLIP_FORWARD, slips_on, (0, 0.35, 0.8))
    ),
    "a slip that is negative for 3 us": Fault(
        cache(lambda: nearly_stops(1e-11)), formulas(Mode.SLIP_FORWARD, slips_on, (0, 0.35, 0.8))
    ),
    "a normal force that is negative by a billionth": Fault(
        cache(lambda: nearly_lifted(1e-9)), formulas(Mode.SLIDE, presses_on, (0, 0.35, 0.8))
    ),
    "floats without a contact": Fault(
        cache(lambda: replace(at_wall(), supports=(), start=Start(0.0, slip=1.0), duration=0.5)),
        formulas(Mode.FLIGHT, floats),
    ),
    "flies off where a contact is consistent, too": Fault(paradox_rod, formulas(Mode.FLIGHT, flies)),
    "begins with static friction": Fault(on_slope(0.2, -0.3), friction(1.0, 0.4)),
    # units
    **{
        f"in units of {length:g} m, {mass:g} kg: {name}": Fault(in_units(length, mass), plant)
        for length, mass in ((1e-6, 1e-9), (1e6, 1e9), (1e-6, 1e9))
        for name, plant in {"friction": friction(MORE), "a transition 1e-10 s late": later(1e-10, 0)}.items()
    },
}  # fmt: skip


def _more_friction(case: Case, factor: float = MORE) -> Case | None:
    own = case.effect(CoulombFriction)
    if own is None:
        return None
    return with_effect(case, CoulombFriction(own.mu * factor, own.mu_static and own.mu_static * factor))


def _more_gravity(case: Case) -> Case | None:
    own = case.effect(Gravity)
    return with_effect(case, Gravity(own.g * MORE, own.direction)) if own else None


def _more_inertia(case: Case) -> Case | None:
    own = case.plate
    return replace(case, plate=Plate(own.outline, own.mass, own.inertia * MORE)) if own.turns else None


def _more_restitution(case: Case) -> Case | None:
    own = case.effect(Impact)
    return with_effect(case, Impact(min(1.0, own.restitution + 1e-9), own.law)) if own else None


def _no_friction(case: Case) -> Case | None:
    own = case.effect(CoulombFriction)
    return with_effect(case, CoulombFriction(1e-12)) if own and not case.effect(Belt) else None


# Families of random scenes whose data are changed, by seed.
FAMILIES: dict[str, Callable[[int], Case]] = {
    "loads": lambda seed: loads.scene(np.random.default_rng(seed))[0],
    "friction by the slip speed": lambda seed: slip_laws.random_scene(np.random.default_rng(seed)),
    "all features": drawn,
    "all features, others": lambda seed: drawn(seed + 100),
}

# What the check does not see, with the reason.
ESCAPES = {
    "false status unfinished": "it is a limit on work, and no law says that work is done",
    "gravity on a pile a billionth stronger": "at rest, with forces that are not unique, whose sum is checked to 1e-8",
}

# Changes of a scene's data; None where it has none of them.
MUTATIONS: dict[str, Callable[[Case], Case | None]] = {
    "friction": _more_friction,
    "gravity": _more_gravity,
    "inertia": _more_inertia,
    "restitution": _more_restitution,
    "no friction": _no_friction,
}


def distance(one: Trajectory, other: Trajectory) -> float:
    """How far two motions of the first plate are apart, in m, rad, m/s and rad/s, at 41 instants."""
    times = np.linspace(0.0, min(one.t[-1], other.t[-1]), 41)
    a, b = one(times), other(times)
    return max(
        float(np.nanmax(np.abs(getattr(a, n) - getattr(b, n)))) for n in ("x", "y", "theta", "vx", "vy", "omega")
    )
