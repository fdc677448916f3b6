"""All adapters with one mistake, by the part that is wrong: the law that catches each, and words of its message."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isinf, pi

import numpy as np

from cases import (
    Belt,
    Case,
    CoulombFriction,
    Drive,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    RollingResistance,
    Trajectory,
    Unilateral,
)
from cases.motion.sampled_contacts import SampledPlates
from cases.scene.free_plates import names_of

from .mutants import (
    Mutant,
    centre,
    damped,
    effect,
    friction,
    frozen,
    in_valley,
    late,
    load,
    of_case,
    of_motion,
    off_centre,
    on_hill,
    on_line,
    osculating,
    outline,
    plate,
    slip_law,
    start,
    track,
    where,
)

G, MU, E = "g of Gravity", "mu of CoulombFriction", "restitution of Impact"
SPEED, DRIVEN, TURNING = "speed of Belt", "x of Drive", "inertia of the plate (infinite)"
FORCES, REACTION = "the reported forces", "the reaction on the other plate"
EOM = "equations of motion"


def equations(scene: str) -> str:
    """The name of the law of the equations of motion in that scene."""
    return f"equations_of_motion[{scene}]"


CIRCLE, VALLEY, LOADED, TURNED = map(
    equations, ("disc in a circle", "disc in a valley", "loaded disc", "off-centre disc")
)


def in_circle(law: str) -> str:
    """The law's entry in the first of its scenes."""
    return f"{law}[disc in a circle]"


def given(scene: str) -> str:
    """The law of starts in that scene."""
    return f"starts_as_given[{scene}]"


AT_START, IN_VALLEY, THROWN = map(given, ("disc in a circle", "disc in a valley", "thrown disc"))


def mutant(row: Mutant | tuple) -> Mutant:
    """A row (name, law, words, what is wrong) as a mutant: one that runs another case or, of a dict of functions of the
    motion, one that reports other columns."""
    if isinstance(row, Mutant):
        return row
    *texts, wrong = row
    return Mutant(*texts, lambda: of_motion(**wrong) if isinstance(wrong, dict) else of_case(wrong))


def gravity(change: Callable[[Gravity], Gravity | None]) -> Callable[[Case], Case]:
    """The case with another gravity."""
    return effect(Gravity, change)


def other(change: Callable[[float], float]) -> Callable[[Case], Case]:
    """The case with another restitution."""
    return effect(Impact, lambda e: Impact(change(e.restitution)))


def flat(x: float = 1.0, y: float = 1.0, of_discs: bool = True) -> Callable[[Case], Case]:
    """The case with its outline stretched along its axes."""
    return outline(lambda u, v, c: (x * u, y * v), lambda c: of_discs or c.plate.radius is None)


GRAVITY = [
    ("g fixed at 9.81", CIRCLE, G, gravity(lambda e: Gravity(9.81, e.direction))),
    ("g doubled", CIRCLE, G, gravity(lambda e: Gravity(2 * e.g, e.direction))),
    ("g 3 % too strong", VALLEY, G, gravity(lambda e: Gravity(1.03 * e.g, e.direction))),
    ("g 5 % too strong without friction", in_circle("energy_conservation"), "energy conservation",
     gravity(lambda e: Gravity(1.05 * e.g, e.direction))),
    ("no gravity in flight", "free_fall", G, where(lambda c: c.start.gap > 0.0, gravity(lambda e: None))),
    ("gravity along -y always", TURNED, EOM, gravity(lambda e: Gravity(e.g))),
    ("gravity mirrored", TURNED, EOM, gravity(lambda e: Gravity(e.g, pi - e.direction))),
    ("gravity turned by 2 degrees", CIRCLE, "direction of Gravity",
     gravity(lambda e: Gravity(e.g, e.direction + pi / 90))),
]  # fmt: skip
FRICTION = [
    ("mu times the ground's default 0.5", CIRCLE, MU, friction(lambda mu: 0.5 * mu)),
    ("mu by the geometric mean with 0.5", CIRCLE, MU, friction(lambda mu: (0.5 * mu) ** 0.5)),
    ("mu of both bodies multiplied", CIRCLE, MU, friction(lambda mu: mu * mu)),
    ("the larger mu of two bodies", CIRCLE, MU, friction(lambda mu: max(mu, 0.5))),
    ("the mean mu of two bodies", CIRCLE, MU, friction(lambda mu: 0.5 * (mu + 0.5))),
    ("mu fixed at 0.1", CIRCLE, MU, friction(lambda mu: 0.1)),
    ("friction off", CIRCLE, MU, effect(CoulombFriction, lambda e: None)),
    ("mu 2 % too large", "friction_torque", MU, friction(lambda mu: 1.02 * mu)),
    ("friction unbounded", "friction_torque", MU, effect(CoulombFriction, lambda e: CoulombFriction(1e3))),
    ("no friction on lines", "friction_torque", MU, where(on_line, effect(CoulombFriction, lambda e: None))),
    ("friction without a torque", "friction_torque", MU, plate(lambda p: replace(p, inertia=1e6 * p.inertia))),
    ("mu_static ignored", equations("static friction"), "mu_static",
     effect(CoulombFriction, lambda e: CoulombFriction(e.mu))),
    ("mu_static for slip, too", equations("static friction"), MU,
     effect(CoulombFriction, lambda e: CoulombFriction(e.stick))),
    ("mu_static twice mu always", equations("breakaway"), MU,
     effect(CoulombFriction, lambda e: CoulombFriction(e.mu, 2 * e.mu))),
    ("no friction on hills", equations("disc on a hill"), MU, where(on_hill, effect(CoulombFriction, lambda e: None))),
    ("no friction in valleys", VALLEY, MU, where(in_valley, effect(CoulombFriction, lambda e: None))),
    ("backward friction 5 % less", VALLEY, MU, where(lambda c: c.start.slip > 0, friction(lambda mu: 0.95 * mu))),
    ("less friction on bumps", equations("disc on a bump"), MU, where(on_hill, friction(lambda mu: 0.9 * mu))),
    ("mu of v = 0 at all speeds", "friction_by_speed", "formula of v", slip_law(lambda mu, v: mu.subs(v, 0))),
    ("slip speed doubled in mu", "friction_by_speed", "formula of v", slip_law(lambda mu, v: mu.subs(v, 2 * v))),
    ("slip speed 2 % off in mu", "friction_by_speed", "formula of v", slip_law(lambda mu, v: mu.subs(v, 1.02 * v))),
    ("sticking threshold half a percent off", "sticking_threshold", "mu_static", friction(lambda mu: 1.005 * mu)),
]  # fmt: skip
PLATES = [
    ("mass fixed at 1 kg", LOADED, "mass of the plate", plate(lambda p: replace(p, mass=1.0))),
    ("mass doubled", LOADED, "mass of the plate", plate(lambda p: replace(p, mass=2 * p.mass))),
    ("inertia of a homogeneous disc", CIRCLE, "inertia",
     plate(lambda p: replace(p, inertia=0.5 * p.mass * p.inner**2))),
    ("inertia about the contact", CIRCLE, "inertia",
     plate(lambda p: replace(p, inertia=p.inertia + p.mass * p.inner**2))),
    ("inertia 5 % too large", CIRCLE, "inertia", plate(lambda p: replace(p, inertia=1.05 * p.inertia))),
    ("inertia of a hoop", VALLEY, "inertia", plate(lambda p: replace(p, inertia=p.mass * p.inner**2))),
    ("inertia without units", LOADED, "inertia", plate(lambda p: replace(p, inertia=p.inertia / p.mass))),
    ("centre of mass recentred", given("off-centre disc"), "centre of mass",
     outline(lambda x, y, c: (x - centre(c)[0], y - centre(c)[1]))),
    ("centre of mass mirrored", given("off-centre disc"), "centre of mass",
     outline(lambda x, y, c: (x - 2 * centre(c)[0], y), off_centre)),
    ("centre of mass turned", given("off-centre disc"), "centre of mass",
     outline(lambda x, y, c: (x - centre(c)[0] - centre(c)[1], y - centre(c)[1] + centre(c)[0]), off_centre)),
    ("radius 2 % too large", in_circle("on_its_track"), "plate", flat(1.02, 1.02)),
    ("ellipse as a circle", "on_its_track[ellipse in a circle]", "outline",
     outline(lambda x, y, c: (x, y * c.plate.reach / c.plate.inner), lambda c: c.plate.radius is None)),
    ("ellipse 5 % too thick", "on_its_track[ellipse in a circle]", "outline", flat(1.0, 1.05, of_discs=False)),
]  # fmt: skip
STARTS = [
    ("slip at the start ignored", AT_START, "slip", start(lambda s: replace(s, slip=0.0))),
    ("slip at the start backwards", IN_VALLEY, "slip", start(lambda s: replace(s, slip=-s.slip))),
    ("spin at the start ignored", AT_START, "omega", start(lambda s: replace(s, omega=0.0))),
    ("spin at the start backwards", THROWN, "omega", start(lambda s: replace(s, omega=-s.omega))),
    ("gap at the start ignored", THROWN, "gap", start(lambda s: replace(s, gap=0.5 * s.gap))),
    ("gap_rate at the start ignored", THROWN, "gap_rate", start(lambda s: replace(s, gap_rate=0.0))),
    ("gap_rate at the start backwards", "free_fall", "gap_rate", start(lambda s: replace(s, gap_rate=-s.gap_rate))),
    ("place at the start 2 % off", IN_VALLEY, "xi1", start(lambda s: replace(s, xi1=1.02 * s.xi1))),
    ("orientation at the start ignored", given("ellipse in a circle"), "at the start",
     where(lambda c: c.plate.radius is None, start(lambda s: replace(s, xi2=(s.xi2 or 0.0) + 0.05)))),
]  # fmt: skip
LOADS = [
    ("fx of the load dropped", LOADED, "fx of Load", load(lambda p, c: p | {"fx": 0})),
    ("fx 5 % too large", LOADED, "fx of Load", load(lambda p, c: p | {"fx": 1.05 * p["fx"]})),
    ("fy of the load dropped", LOADED, "fy of Load", load(lambda p, c: p | {"fy": 0})),
    ("fy backwards", LOADED, "fy of Load", load(lambda p, c: p | {"fy": -p["fy"]})),
    ("moment of the load dropped", LOADED, "moment of Load", load(lambda p, c: p | {"moment": 0})),
    ("moment backwards", LOADED, "moment of Load", load(lambda p, c: p | {"moment": -p["moment"]})),
    ("fy dropped in flight", equations("thrown disc"), "fy of Load", load(lambda p, c: p | {"fy": 0})),
    ("fx and fy exchanged", LOADED, f"{EOM}: v", load(lambda p, c: p | {"fx": p["fy"], "fy": p["fx"]})),
    ("load frozen at its start", LOADED, f"{EOM}: v", frozen(t=0.0)),
    ("load without vx", LOADED, "vx", frozen(vx=0.0)),
    ("load without place", equations("thrown disc"), "vy", frozen(x=0.0)),
    ("load without spin", LOADED, "omega", frozen(omega=0.0)),
    ("load without angle", LOADED, "omega", frozen(theta=0.0)),
    ("load at the contact point", LOADED, EOM,
     load(lambda p, c: p | {"moment": p["moment"] + p["fx"] * c.plate.inner})),
    ("load taken as an acceleration", LOADED, "Load",
     load(lambda p, c: p | {"fx": p["fx"] * c.plate.mass, "fy": p["fy"] * c.plate.mass})),
    ("no load in valleys", equations("loaded disc in a valley"), f"{EOM}: v",
     where(in_valley, effect(Load, lambda e: None))),
    ("couple of the load halved", "load", "moment of Load", load(lambda p, c: p | {"moment": 0.5 * p["moment"]})),
    ("couple of the load 10 % too large", "load", "moment of Load",
     load(lambda p, c: p | {"moment": 1.1 * p["moment"]})),
    ("no load at all", "load", "fx of Load", effect(Load, lambda e: None)),
]  # fmt: skip
IMPACTS = [
    ("restitution ignored", "bounce", E, other(lambda e: 0.0)),
    ("restitution fixed at 0.5", "bounce", E, other(lambda e: 0.5)),
    ("restitution squared", "bounce", E, other(lambda e: e**2)),
    ("restitution by the geometric mean", "bounce", E, other(lambda e: e**0.5)),
    ("restitution of both bodies multiplied", "bounce", E, other(lambda e: 0.8 * e)),
    ("a landing that rebounds", "landing", E, other(lambda e: max(e, 0.3))),
    ("impacts without friction", "landing", MU,
     where(lambda c: c.effect(Impact) is not None, effect(CoulombFriction, lambda e: None))),
    ("impacts with half the friction", "bounce_with_friction", MU, friction(lambda mu: 0.5 * mu)),
    ("impacts with less friction by restitution", "bounce_with_friction", E, other(lambda e: 0.8 * e)),
]  # fmt: skip
CONTACTS = [
    ("the track never pulls", "guide", "Unilateral",
     lambda c: replace(c, effects=(*(e for e in c.effects if not isinstance(e, Unilateral)), Unilateral()))),
    ("the track always pulls", "lift_off", "Unilateral",
     where(lambda c: not c.effect(Flight), effect(Unilateral, lambda e: None))),
    ("rough contact with mu = 0.5", "perfectly_rough", "PerfectlyRough",
     effect(PerfectlyRough, lambda e: CoulombFriction(0.5))),
    ("rough contact without friction", equations("rough valley"), EOM, effect(PerfectlyRough, lambda e: None)),
    ("rolling resistance ignored", "rolling_resistance", "arm of RollingResistance",
     effect(RollingResistance, lambda e: None)),
    ("rolling resistance for the diameter", "rolling_resistance", "arm of RollingResistance",
     effect(RollingResistance, lambda e: RollingResistance(2 * e.arm))),
    ("rolling resistance 10 % off", equations("resisted disc"), "arm of RollingResistance",
     effect(RollingResistance, lambda e: RollingResistance(1.1 * e.arm))),
    ("tracks as circles of curvature", "on_its_track[disc in a valley]", "track", osculating),
    ("tracks 2 % too deep", "on_its_track[disc in a valley]", "track", track(lambda x, y: (x, 1.02 * y))),
    ("tracks moved by a centimetre", AT_START, "at the start", track(lambda x, y: (x, y + 0.01))),
    ("linear damping of 0.04 1/s", "free_fall", "damping", damped(0.04, 0.0)),
    ("angular damping of 0.04 1/s", "no_friction_no_spin", "damping", damped(0.0, 0.04)),
]  # fmt: skip
BELTS = [
    ("belt runs backwards", "belt", SPEED, effect(Belt, lambda e: Belt(-e.expression))),
    ("belt 3 % too fast", "belt", SPEED, effect(Belt, lambda e: Belt(1.03 * e.expression))),
    ("belt ignored", "belt", SPEED, effect(Belt, lambda e: None)),
    ("drive ignored", "driven_track", DRIVEN, effect(Drive, lambda e: None)),
    ("drive 3 % too far", "driven_track", DRIVEN, effect(Drive, lambda e: Drive(1.03 * e.x, e.y, e.angle))),
    ("drive in -x", "driven_track", DRIVEN, effect(Drive, lambda e: Drive(-e.x, e.y, e.angle))),
    ("infinite inertia read as a disc's", "fixed_rotation", TURNING,
     plate(lambda p: replace(p, inertia=0.5 * p.mass * p.inner**2) if isinf(p.inertia) else p)),
    ("friction 2 % too large on plates that do not turn", "fixed_rotation", MU,
     where(lambda c: isinf(c.plate.inertia), friction(lambda mu: 1.02 * mu))),
]  # fmt: skip
RATES = ("vx", "vy", "omega")
COLUMNS = [
    ("velocities 20 steps late", CIRCLE, EOM,
     {name: lambda m, name=name: late(getattr(m, name), 20) for name in RATES}),
    ("vertical velocity downwards", CIRCLE, EOM, {"vy": lambda m: -m.vy}),
    ("velocities in the plate's frame", CIRCLE, EOM, {
        "vx": lambda m: m.vx * np.cos(m.theta) + m.vy * np.sin(m.theta),
        "vy": lambda m: m.vy * np.cos(m.theta) - m.vx * np.sin(m.theta),
    }),
    ("forces 20 steps late", in_circle("momentum_balance"), FORCES,
     {name: lambda m, name=name: late(getattr(m, name), 20) for name in ("normal_force", "friction_force")}),
    ("normal force 5 % too large in the report", in_circle("momentum_balance"), FORCES,
     {"normal_force": lambda m: 1.05 * m.normal_force}),
    ("poses 20 steps late", in_circle("rates_of_pose"), "time",
     {"x": lambda m: late(m.x, 20), "y": lambda m: late(m.y, 20)}),
    ("clock 1 % slow", in_circle("rates_of_pose"), "unit",
     {name: lambda m, name=name: 1.01 * getattr(m, name) for name in RATES}),
    ("angle backwards", "free_fall", "theta", {"theta": lambda m: -m.theta}),
    ("angle in degrees", "free_fall", "unit of the angle", {"theta": lambda m: np.degrees(m.theta)}),
    ("speed limited", "free_fall", "vy", {"vy": lambda m: np.clip(m.vy, -0.8, 0.8)}),
    ("speed of fall 1 % too large", "free_fall", "vy", {"vy": lambda m: 1.01 * m.vy}),
    ("way that shrinks in flight", "free_fall", "x", {"x": lambda m: m.x * (1 - 1e-3 * m.t)}),
    ("spin that fades in flight", "free_fall", "omega", {"omega": lambda m: m.omega * (1 - 0.04 * m.t)}),
    ("spin backwards", AT_START, "omega", {"omega": lambda m: -m.omega}),
    ("spin in revolutions", THROWN, "omega", {"omega": lambda m: m.omega / (2 * pi)}),
    ("height downwards", AT_START, "y at the start", {"y": lambda m: -m.y}),
    ("poses in millimetres", AT_START, "at the start", {"x": lambda m: 1e3 * m.x, "y": lambda m: 1e3 * m.y}),
    ("slip backwards", in_circle("on_its_track"), "slip", {"slip": lambda m: -m.slip}),
    ("slip of the plate's centre", in_circle("on_its_track"), "slip", {"slip": lambda m: np.hypot(m.vx, m.vy)}),
    ("slip 0.2 m/s too large", in_circle("on_its_track"), "slip", {"slip": lambda m: m.slip + 0.2}),
    ("plate that rises", in_circle("on_its_track"), "the gap", {"y": lambda m: m.y + 0.01 * m.t}),
    ("slip that creeps", "sticking_threshold", "slip", {"slip": lambda m: m.slip + 2e-3 * m.t}),
    ("spin that grows", "no_friction_no_spin", "the spin", {"omega": lambda m: m.omega * (1 + 1e-6 * m.t)}),
    ("normal force backwards", in_circle("cone"), "normal force", {"normal_force": lambda m: -m.normal_force}),
    ("normal force without sign", "guide", "the normal force", {"normal_force": lambda m: np.abs(m.normal_force)}),
    ("friction backwards", in_circle("friction_opposes_slip"), MU, {"friction_force": lambda m: -m.friction_force}),
    ("half the friction in the report", in_circle("friction_opposes_slip"), MU,
     {"friction_force": lambda m: 0.5 * m.friction_force}),
    ("friction 10 % too large in the report", in_circle("cone"), MU,
     {"friction_force": lambda m: 1.1 * m.friction_force}),
    ("velocities that grow", in_circle("energy_never_grows"), "energy never grows",
     {name: lambda m, name=name: getattr(m, name) * (1 + 2 * m.t) for name in RATES[:2]}),
    ("drift along x", in_circle("turn_frame"), "turned frame", {"x": lambda m: m.x + 0.05 * m.t}),
    ("drift to the right", in_circle("mirror_image"), "mirror image", {"x": lambda m: m.x + 0.05 * m.t}),
    ("lift-off 0.02 rad too far", "lift_off", "cos phi", {"xi1": lambda m: m.xi1 + 0.02}),
    ("no lift-off", "lift_off", "lift-off: the motion should end", {"status": lambda m: "completed"}),
]  # fmt: skip


# --- several free plates ---------------------------------------------------------------------------------------------


def _of_others(change: Callable[[FreePlate], FreePlate]) -> Callable[[Case], Case]:
    return lambda case: replace(case, others=tuple(map(change, case.others)))


def _alone(rows: list[int]) -> Callable[[Case, Trajectory], Trajectory]:
    """A change of a motion: these rows of free plates (x, y, theta, vx, vy, omega) stay as at the start."""

    def spoil(case: Case, motion: Trajectory) -> Trajectory:
        own = {name: _columns(motion, name) for name in names_of(case)}
        for name in names_of(case)[1:]:
            own[name][rows] = own[name][rows, :1]
        return replace(motion, plate_columns=SampledPlates(motion.t, own))

    return spoil


def _columns(motion: Trajectory, name: str) -> np.ndarray:
    own = motion.plate(name)
    return np.array([getattr(own, column) for column in ("x", "y", "theta", *RATES)])


def _swapped(case: Case, motion: Trajectory) -> Trajectory:
    """The motion with the last two plates taken for each other."""
    *_, first, last = names_of(case)
    own = {name: _columns(motion, name) for name in names_of(case)}
    own[first], own[last] = own[last], own[first]
    return replace(motion, plate_columns=SampledPlates(motion.t, own))


HEAVY = _of_others(lambda o: replace(o, plate=replace(o.plate, mass=1.05 * o.plate.mass)))
COLLISION, RUBBING = "collision_of_free_plates", "friction_of_free_plates"
FREE_PLATES = [
    Mutant("free plates swapped", "row_of_free_plates", "vx of", lambda: of_case(spoil=_swapped)),
    Mutant("no friction on the other plate", RUBBING, REACTION, lambda: of_case(spoil=_alone([2, 5]))),
    Mutant("no force on the other plate", COLLISION, REACTION, lambda: of_case(spoil=_alone([0, 2, 3, 5]))),
    ("mass of free plates 5 % too large", COLLISION, "mass of each", HEAVY),
    ("mass of a free polygon 5 % too large", "wedge_of_free_plates", "mass of the", HEAVY),
    ("inertia of free plates that of the first", RUBBING, "inertia of each",
     lambda case: _of_others(lambda o: replace(o, plate=replace(o.plate, inertia=case.plate.inertia)))(case)),
    ("mu of two discs multiplied", RUBBING, MU, effect(CoulombFriction, lambda e: CoulombFriction(e.mu**2))),
    ("a pair rubs as the others do", "friction_of_a_pair", MU, lambda case: replace(case, pairs=())),
    ("restitution of two discs multiplied", COLLISION, E,
     effect(Impact, lambda e: replace(e, restitution=e.restitution**2))),
    ("a pile without friction between plates", "pile_of_free_plates", "the way of",
     effect(CoulombFriction, lambda e: None)),
]  # fmt: skip

MUTANTS: list[Mutant] = [*map(mutant, (
    *GRAVITY, *FRICTION, *PLATES, *STARTS, *LOADS, *IMPACTS, *CONTACTS, *BELTS, *COLUMNS, *FREE_PLATES,
))]  # fmt: skip
