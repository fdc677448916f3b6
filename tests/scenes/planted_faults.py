"""The permanent set of planted faults, by name; and changes by a billionth of the data of random scenes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from math import cos, inf, pi, sin

import numpy as np

from cases import (
    Belt,
    Case,
    Chain,
    CoulombFriction,
    Curve,
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
    Support,
    Trajectory,
    Unilateral,
    disc,
)
from cases.effects import Effect
from cases.library import hill
from tests.composition.build import first_scene
from tests.reference.test_nested_series import disc_between_floor_and_wall
from tests.scenes import loads, slip_laws
from tests.scenes import planted_motions as planted
from tests.scenes.moving import Adhesion
from tests.scenes.planted_motions import (
    MORE,
    Fault,
    alter,
    catalogue,
    ends,
    instead,
    later,
    more,
    plus,
    scene,
    without,
)

CIRCLE, LINE = catalogue("disc_in_circle", mu=0.2), catalogue("disc_on_line", mu=0.1)
BOUNCE, INCLINE = catalogue("bouncing_disc", e=0.5), catalogue("disc_onto_incline", mu=0.5)
HILL, ELLIPSE = catalogue("disc_sliding_off_hill"), catalogue("tumbling_ellipse")
ROLLS, FREE = catalogue("disc_rolling_to_rest"), catalogue("disc_on_free_disc", mu=0.5)
LADDER, BOX = catalogue("ladder_at_wall", mu=0.1, mu_wall=0.2), catalogue("sliding_box", mu=0.4, slope=0.2)
WAVE = planted.loaded(fx="3*sin(5*t)")


DRIVEN = cache(lambda: planted.on_line(Drive(x="0.05*sin(12*t)")))
STICKY = cache(lambda: planted.on_line(Adhesion(5.0, 0.2, 0.001), slip=1.0))
# A disc that begins to roll where the motion ends.
STOPS_AT_END = cache(lambda: planted.on_line(CoulombFriction(0.1), duration=1 / (3 * 0.1 * planted.G), slip=1.0))


@cache
def off_an_edge() -> Case:
    """A box that does not turn slides off a table, its side on the edge."""
    box = Plate(Outline.polygon([(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)]), 1.0, inf)
    table = Chain.polyline([(-3.0, 0.0), (0.0, 0.0), (0.0, -3.0)])
    effects = Gravity(planted.G), Unilateral(), Flight(), Impact(0.0)
    return Case(table, box, effects, StartPose(0.033882740115579096, 0.04185642032305351, -0.3), 0.5)


def corner_off_corner(*effects: Effect) -> Case:
    """The same tilted, with its lowest corner on the table, from which it slides."""
    case = off_an_edge()
    start = StartPose(-0.3, 0.1 * sin(0.3) + 0.05 * cos(0.3), -0.3, vx=1.5)
    return replace(case, start=start, effects=(Gravity(planted.G), Unilateral(), *effects), duration=0.2)


@cache
def off_a_support(start: StartPose | None = None) -> Case:
    """A disc rolls to the end of a support, or falls on it."""
    shelf = Support(Curve(("s", "0"), (-3.0, 0.0)), "shelf")
    effects = Gravity(planted.G), CoulombFriction(0.3), Unilateral(), Flight(), Impact(0.0)
    start = start or StartPose(-0.3, 0.1, vx=1.5)
    return Case(Curve(("s", "-2")), disc(0.1, 1.0), effects, start, 0.4, supports=(shelf,))


@cache
def onto_a_side() -> Case:
    """A box on a hill whose corner is to touch with a side next; static friction holds it."""
    effects = Gravity(planted.G), CoulombFriction(0.05, mu_static=0.5), Unilateral()
    start = Start(0.05, xi2=0.2 + pi / 2, omega=-0.5)
    return Case(hill(1.0), Plate.rectangle(0.2, 0.1, 1.0), effects, start, 0.05)


def _heavier_other(case: Case) -> Case:
    return replace(case, others=tuple(planted.with_part("plate", mass=more)(other) for other in case.others))


def _supports(change: planted.Change) -> planted.Change:
    """A change of the supports alone."""
    return lambda case: replace(case, supports=change(case).supports)


MORE_FRICTION = alter(CoulombFriction, mu=more, mu_static=more)

# Data of the case that are off, most of them by a billionth, and loads and ripples that are stepped over: the scene
# and what is changed.
DATA: dict[str, tuple[Callable[[], Case], planted.Change]] = {
    "friction a billionth larger": (CIRCLE, MORE_FRICTION),
    "friction a trillionth larger": (CIRCLE, alter(CoulombFriction, mu=lambda mu: mu * (1 + 1e-12))),
    "static friction a billionth larger": (CIRCLE, alter(CoulombFriction, mu_static=0.2 * MORE)),
    "gravity a billionth stronger": (CIRCLE, alter(Gravity, g=more)),
    "gravity turned by a billionth": (CIRCLE, alter(Gravity, direction=plus(-1e-9))),
    "inertia a billionth larger": (CIRCLE, planted.with_part("plate", inertia=more)),
    "mass a billionth larger, in forces alone": (CIRCLE, planted.with_part("plate", mass=more, inertia=more)),
    "disc a billionth larger": (CIRCLE, planted.with_part("plate", outline=disc(0.1 * MORE, 1.0).outline)),
    "track a billionth larger": (
        CIRCLE, lambda c: replace(c, track=catalogue("disc_in_circle", mu=0.2, R=MORE)().track)
    ),
    **{
        f"{name} of the start a billionth off": (of, planted.with_part("start", **{name: plus(1e-9)}))
        for name, of in (("xi1", CIRCLE), ("slip", LINE), ("omega", LINE))
    },
    "belt a billionth faster": (
        catalogue("disc_on_conveyor"), lambda c: instead(Belt(c.effect(Belt).constant * MORE))(c)
    ),
    "restitution a millionth off": (BOUNCE, alter(Impact, restitution=plus(1e-6))),
    "restitution 1e-10 off": (BOUNCE, alter(Impact, restitution=plus(1e-10))),
    "another law of impact": (ELLIPSE, alter(Impact, law="moreau")),
    "friction in an impact a billionth larger": (ELLIPSE, MORE_FRICTION),
    "static friction ignored": (catalogue("block_on_conveyor"), alter(CoulombFriction, mu_static=None)),
    "friction by the slip speed a billionth larger": (catalogue("stribeck_disc"), MORE_FRICTION),
    "rolling resistance a billionth larger": (ROLLS, alter(RollingResistance, arm=more)),
    "rolling resistance missing": (ROLLS, without(RollingResistance)),
    "load a billionth larger": (WAVE, instead(Load(fx=f"{3 * MORE!r}*sin(5*t)"))),
    "load a nanosecond late": (WAVE, instead(Load(fx="3*sin(5*(t-1e-9))"))),
    "amplitude of a drive a billionth larger": (DRIVEN, instead(Drive(x=f"{0.05 * MORE!r}*sin(12*t)"))),
    "effect of a package a billionth larger": (STICKY, instead(Adhesion(5.0 * MORE, 0.2, 0.001))),
    "friction between plates a billionth larger": (FREE, MORE_FRICTION),
    "mass of the other plate a billionth larger": (FREE, _heavier_other),
    "friction at the ladder's wall a billionth larger": (LADDER, _supports(MORE_FRICTION)),
    "friction of a box a billionth larger": (BOX, MORE_FRICTION),
    "gravity on a pile a billionth stronger": (catalogue("pile_of_discs"), alter(Gravity, g=more)),
    "restitution of a rocking block a millionth": (catalogue("rocking_block"), alter(Impact, restitution=plus(1e-6))),
    # loads and ripples that are stepped over
    **{
        f"bump of a load {where} stepped over": (planted.loaded(fx=f"{size}*exp(-(({at})/{wide})**2)"), without(Load))
        for where, size, at, wide in (
            ("in time", 20, "t-0.7", 1e-4),
            ("in place", 20, "x-0.3", 1e-4),
            ("in velocity", 5, "vx-0.4", 1e-4),
            ("of a micrometre", 20, "x-0.3", 1e-6),
        )
    },
    "ripple of a millimetre flown through": (planted.flown_over(1e-3, 1e-4), planted.flat),
    "ripple of 0.6 mm, 10 um wide, flown through": (planted.flown_over(6e-4, 1e-5), planted.flat),
    "ripple of a micrometre on the track ignored": (planted.rolled_over, planted.flat),
    "second contact with a hump missed": (planted.hump, planted.flat),
    "support passed through": (planted.at_wall, lambda c: replace(c, supports=())),
    "passes through a support next to its end": (
        lambda: off_a_support(StartPose(-0.05, 0.15)), lambda c: replace(c, supports=())
    ),
    "sticks where it must reverse": (catalogue("disc_in_circle", mu=0.1), alter(CoulombFriction, mu_static=5.0)),
    # impacts
    "an impact without friction": (catalogue("thrown_with_spin", backspin=2), instead(CoulombFriction(1e-12))),
    "an impact that slips where it sticks": (INCLINE, instead(CoulombFriction(0.1))),
    "no friction at the second contact": (
        catalogue("disc_between_belt_and_wall"),
        lambda c: replace(c, supports=tuple(replace(one, effects=()) for one in c.supports)),
    ),
    "begins without static friction, with a side": (onto_a_side, alter(CoulombFriction, mu_static=None)),
    "restitution of a series within another one a millionth": (
        cache(disc_between_floor_and_wall), alter(Impact, restitution=plus(1e-6))
    ),
    "begins with static friction": (planted.on_slope(0.2, -0.3), alter(CoulombFriction, mu_static=0.4)),
}  # fmt: skip

FAULTS = {name: Fault(of, scene(change)) for name, (of, change) in DATA.items()} | {
    "plates pass through each other": Fault(catalogue("row_of_discs"), planted.through),
    # ends and statuses
    "lift-off a millisecond early": Fault(HILL, ends(-1e-3, "lift_off", after=True)),
    "lift-off a nanosecond early": Fault(HILL, ends(-1e-9, "lift_off", after=True)),
    "lift-off a microsecond late": Fault(HILL, ends(1e-6, "lift_off", after=True, of=without(Unilateral))),
    "a perfectly rough contact would pull, a microsecond early": Fault(
        lambda: first_scene(4091691), ends(-1e-6, "paradox", after=True)
    ),
    "completed before its duration": Fault(CIRCLE, ends(2.0)),
    "completed a picosecond early": Fault(STOPS_AT_END, ends(-1e-12, after=True)),
    "lift-off where the track presses": Fault(CIRCLE, ends(0.3, "lift_off")),
    "a corner lifts off a microsecond before its track's corner": Fault(
        cache(corner_off_corner), ends(-1e-6, "lift_off", after=True)
    ),
    "a corner leaves its track's corner a microsecond late": Fault(
        cache(lambda: corner_off_corner(Flight(), Impact(0.0))), later(1e-6, 0)
    ),
    "end of a support a nanosecond early": Fault(off_a_support, ends(-1e-9, "track_end", after=True)),
    "end of the track inside it": Fault(cache(lambda: planted.flat(planted.rolled_over())), ends(0.25, "track_end")),
    **{
        f"false status {status}": Fault(CIRCLE, ends(0.3, status))
        for status in ("paradox", "second_contact", "accumulation", "unfinished", "breakdown", "landing", "not_unique")
    },
    "false status landing of two plates": Fault(FREE, ends(0.1, "landing")),
    # transitions
    "a transition 1e-10 s late": Fault(CIRCLE, later(1e-10, 0)),
    "a transition 1e-12 s late": Fault(CIRCLE, later(1e-12, 0)),
    "a transition 1e-10 s early": Fault(CIRCLE, later(-1e-10, 1)),
    "a roll that is called slip": Fault(
        CIRCLE, planted.modes({0: {"after": Mode.SLIP_FORWARD}, 1: {"before": Mode.SLIP_FORWARD}})
    ),
    "sense of slip": Fault(CIRCLE, planted.modes({1: {"after": Mode.SLIP_FORWARD}, 2: {"before": Mode.SLIP_FORWARD}})),
    "transitions that are not listed": Fault(CIRCLE, planted.transitions(lambda some: some[2:])),
    "a contact of the ladder opens a nanosecond late": Fault(LADDER, later(1e-9)),
    "a series of impacts ends a microsecond early": Fault(BOUNCE, later(-1e-6, -1)),
    **{
        f"a series of impacts ends {by:g} s late, with all data": Fault(BOUNCE, planted.rest_later(by))
        for by in (1e-7, 1e-5, 1e-3)
    },
    # columns
    **{
        f"{name} a billionth off": Fault(CIRCLE, planted.column(name, change))
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
    "friction of the wrong sign": Fault(CIRCLE, planted.column("friction_force", lambda x, t: -x)),
    "angle drifts by 1e-10 rad/s": Fault(CIRCLE, planted.column("theta", lambda x, t: x + 1e-10 * t)),
    "place jumps by 1e-10 m": Fault(CIRCLE, planted.jump("x", 1e-10)),
    "spin jumps by 1e-9 rad/s": Fault(CIRCLE, planted.jump("omega", 1e-9)),
    "an impulse where a corner leaves an edge": Fault(off_an_edge, planted.jump("vy", 0.083, change=0)),
    "a side sinks into its track by a nanometre per second": Fault(BOX, planted.column("y", lambda y, t: y - 1e-9 * t)),
    "force of one corner of a box": Fault(BOX, planted.column("normal_force", lambda n, t: 0.9 * n, "plate/track 2")),
    "integrated by DOP853 at 1e-6": Fault(CIRCLE, lambda c: planted.simulate(c, 1e-6, "dop853")),
    "integrated at 1e-8": Fault(CIRCLE, lambda c: planted.simulate(c, 1e-8, "dop853")),
    # motions by formulas
    "rests on a slope beyond its cone": Fault(
        planted.on_slope(0.2, -0.3), planted.formulas(Mode.REST, planted.at_rest)
    ),
    "creeps where it rests": Fault(
        planted.on_slope(0.2, 0.1), planted.formulas(Mode.REST, lambda c: planted.at_rest(c, 1e-9))
    ),
    **{
        f"a slip that is negative for {time} us": Fault(
            cache(partial(planted.nearly_stops, least)),
            planted.formulas(Mode.SLIP_FORWARD, planted.slips_on, (0, 0.35, 0.8)),
        )
        for time, least in ((32, 1e-9), (3, 1e-11))
    },
    "a normal force that is negative by a billionth": Fault(
        cache(lambda: planted.nearly_lifted(1e-9)), planted.formulas(Mode.SLIDE, planted.presses_on, (0, 0.35, 0.8))
    ),
    "floats without a contact": Fault(
        cache(lambda: replace(planted.at_wall(), supports=(), start=Start(0.0, slip=1.0), duration=0.5)),
        planted.formulas(Mode.FLIGHT, lambda c: planted.flies(c, 0.0)),
    ),
    "flies off where a contact is consistent, too": Fault(
        planted.paradox_rod, planted.formulas(Mode.FLIGHT, planted.flies)
    ),
    # units
    **{
        f"in units of {length:g} m, {mass:g} kg: {name}": Fault(planted.in_units(length, mass), plant)
        for length, mass in ((1e-6, 1e-9), (1e6, 1e9), (1e-6, 1e9))
        for name, plant in {"friction": scene(MORE_FRICTION), "a transition 1e-10 s late": later(1e-10, 0)}.items()
    },
}  # fmt: skip


# Families of random scenes whose data are changed, by seed.
FAMILIES: dict[str, Callable[[int], Case]] = {
    "loads": lambda seed: loads.scene(np.random.default_rng(seed))[0],
    "friction by the slip speed": lambda seed: slip_laws.random_scene(np.random.default_rng(seed)),
    "all features": first_scene,
    "all features, others": lambda seed: first_scene(seed + 100),
}

# What the check does not see, with the reason.
ESCAPES = {
    "false status unfinished": "it is a limit on work, and no law says that work is done",
    "gravity on a pile a billionth stronger": "at rest, with forces that are not unique, whose sum is checked to 1e-8",
}

# Changes of a scene's data.
MUTATIONS: dict[str, planted.Change] = {
    "friction": MORE_FRICTION,
    "gravity": alter(Gravity, g=more),
    "inertia": planted.with_part("plate", inertia=more),
    "restitution": alter(Impact, restitution=lambda e: min(1.0, e + 1e-9)),
    "no friction": lambda case: case if case.effect(Belt) else alter(CoulombFriction, mu=1e-12, mu_static=None)(case),
}


def distance(one: Trajectory, other: Trajectory) -> float:
    """How far two motions of the first plate are apart, in m, rad, m/s and rad/s, at 41 instants."""
    times = np.linspace(0.0, min(one.t[-1], other.t[-1]), 41)
    a, b = one(times), other(times)
    return max(
        float(np.nanmax(np.abs(getattr(a, n) - getattr(b, n)))) for n in ("x", "y", "theta", "vx", "vy", "omega")
    )
