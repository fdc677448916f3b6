"""All adapters with one mistake, by the part that is wrong: the law that catches each, and words of its message."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isinf, pi
from typing import Any

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


def by_case(law: str, words: str, changes: dict[str, Callable[[Case], Case]]) -> list[Mutant]:
    """Mutants that run another case."""
    return [Mutant(name, law, words, lambda change=change: of_case(change)) for name, change in changes.items()]


def by_motion(law: str, words: str, changes: dict[str, dict[str, Callable[[Trajectory], Any]]]) -> list[Mutant]:
    """Mutants that report other columns."""
    return [Mutant(name, law, words, lambda own=own: of_motion(**own)) for name, own in changes.items()]


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
    *by_case(CIRCLE, G, {
        "g fixed at 9.81": gravity(lambda e: Gravity(9.81, e.direction)),
        "g doubled": gravity(lambda e: Gravity(2 * e.g, e.direction)),
    }),
    *by_case(VALLEY, G, {"g 3 % too strong": gravity(lambda e: Gravity(1.03 * e.g, e.direction))}),
    *by_case(in_circle("energy_conservation"), "energy conservation", {
        "g 5 % too strong without friction": gravity(lambda e: Gravity(1.05 * e.g, e.direction)),
    }),
    *by_case("free_fall", G, {"no gravity in flight": where(lambda c: c.start.gap > 0.0, gravity(lambda e: None))}),
    *by_case(TURNED, EOM, {
        "gravity along -y always": gravity(lambda e: Gravity(e.g)),
        "gravity mirrored": gravity(lambda e: Gravity(e.g, pi - e.direction)),
    }),
    *by_case(CIRCLE, "direction of Gravity", {
        "gravity turned by 2 degrees": gravity(lambda e: Gravity(e.g, e.direction + pi / 90)),
    }),
]  # fmt: skip
FRICTION = [
    *by_case(CIRCLE, MU, {
        "mu times the ground's default 0.5": friction(lambda mu: 0.5 * mu),
        "mu by the geometric mean with 0.5": friction(lambda mu: (0.5 * mu) ** 0.5),
        "mu of both bodies multiplied": friction(lambda mu: mu * mu),
        "the larger mu of two bodies": friction(lambda mu: max(mu, 0.5)),
        "the mean mu of two bodies": friction(lambda mu: 0.5 * (mu + 0.5)),
        "mu fixed at 0.1": friction(lambda mu: 0.1),
        "friction off": effect(CoulombFriction, lambda e: None),
    }),
    *by_case("friction_torque", MU, {
        "mu 2 % too large": friction(lambda mu: 1.02 * mu),
        "friction unbounded": effect(CoulombFriction, lambda e: CoulombFriction(1e3)),
        "no friction on lines": where(on_line, effect(CoulombFriction, lambda e: None)),
        "friction without a torque": plate(lambda p: replace(p, inertia=1e6 * p.inertia)),
    }),
    *by_case(equations("static friction"), "mu_static", {
        "mu_static ignored": effect(CoulombFriction, lambda e: CoulombFriction(e.mu)),
    }),
    *by_case(equations("static friction"), MU, {
        "mu_static for slip, too": effect(CoulombFriction, lambda e: CoulombFriction(e.stick)),
    }),
    *by_case(equations("breakaway"), MU, {
        "mu_static twice mu always": effect(CoulombFriction, lambda e: CoulombFriction(e.mu, 2 * e.mu)),
    }),
    *by_case(equations("disc on a hill"), MU, {
        "no friction on hills": where(on_hill, effect(CoulombFriction, lambda e: None)),
    }),
    *by_case(VALLEY, MU, {
        "no friction in valleys": where(in_valley, effect(CoulombFriction, lambda e: None)),
        "backward friction 5 % less": where(lambda c: c.start.slip > 0, friction(lambda mu: 0.95 * mu)),
    }),
    *by_case(equations("disc on a bump"), MU, {
        "less friction on bumps": where(on_hill, friction(lambda mu: 0.9 * mu)),
    }),
    *by_case("friction_by_speed", "formula of v", {
        "mu of v = 0 at all speeds": slip_law(lambda mu, v: mu.subs(v, 0)),
        "slip speed doubled in mu": slip_law(lambda mu, v: mu.subs(v, 2 * v)),
        "slip speed 2 % off in mu": slip_law(lambda mu, v: mu.subs(v, 1.02 * v)),
    }),
    *by_case("sticking_threshold", "mu_static", {
        "sticking threshold half a percent off": friction(lambda mu: 1.005 * mu),
    }),
]  # fmt: skip
PLATES = [
    *by_case(LOADED, "mass of the plate", {
        "mass fixed at 1 kg": plate(lambda p: replace(p, mass=1.0)),
        "mass doubled": plate(lambda p: replace(p, mass=2 * p.mass)),
    }),
    *by_case(CIRCLE, "inertia", {
        "inertia of a homogeneous disc": plate(lambda p: replace(p, inertia=0.5 * p.mass * p.inner**2)),
        "inertia about the contact": plate(lambda p: replace(p, inertia=p.inertia + p.mass * p.inner**2)),
        "inertia 5 % too large": plate(lambda p: replace(p, inertia=1.05 * p.inertia)),
    }),
    *by_case(VALLEY, "inertia", {"inertia of a hoop": plate(lambda p: replace(p, inertia=p.mass * p.inner**2))}),
    *by_case(LOADED, "inertia", {"inertia without units": plate(lambda p: replace(p, inertia=p.inertia / p.mass))}),
    *by_case(given("off-centre disc"), "centre of mass", {
        "centre of mass recentred": outline(lambda x, y, c: (x - centre(c)[0], y - centre(c)[1])),
        "centre of mass mirrored": outline(lambda x, y, c: (x - 2 * centre(c)[0], y), off_centre),
        "centre of mass turned": outline(
            lambda x, y, c: (x - centre(c)[0] - centre(c)[1], y - centre(c)[1] + centre(c)[0]), off_centre
        ),
    }),
    *by_case(in_circle("on_its_track"), "plate", {"radius 2 % too large": flat(1.02, 1.02)}),
    *by_case("on_its_track[ellipse in a circle]", "outline", {
        "ellipse as a circle": outline(
            lambda x, y, c: (0.5 * (x + y) + 0.5 * (x - y), y * c.plate.reach / c.plate.inner),
            lambda c: c.plate.radius is None,
        ),
        "ellipse 5 % too thick": flat(1.0, 1.05, of_discs=False),
    }),
]  # fmt: skip
STARTS = [
    *by_case(AT_START, "slip", {"slip at the start ignored": start(lambda s: replace(s, slip=0.0))}),
    *by_case(IN_VALLEY, "slip", {"slip at the start backwards": start(lambda s: replace(s, slip=-s.slip))}),
    *by_case(AT_START, "omega", {"spin at the start ignored": start(lambda s: replace(s, omega=0.0))}),
    *by_case(THROWN, "omega", {
        "spin at the start backwards": start(lambda s: replace(s, omega=-s.omega)),
    }),
    *by_case(THROWN, "gap", {"gap at the start ignored": start(lambda s: replace(s, gap=0.5 * s.gap))}),
    *by_case(THROWN, "gap_rate", {
        "gap_rate at the start ignored": start(lambda s: replace(s, gap_rate=0.0)),
    }),
    *by_case("free_fall", "gap_rate", {
        "gap_rate at the start backwards": start(lambda s: replace(s, gap_rate=-s.gap_rate)),
    }),
    *by_case(IN_VALLEY, "xi1", {"place at the start 2 % off": start(lambda s: replace(s, xi1=1.02 * s.xi1))}),
    *by_case(given("ellipse in a circle"), "at the start", {
        "orientation at the start ignored": where(
            lambda c: c.plate.radius is None, start(lambda s: replace(s, xi2=(s.xi2 or 0.0) + 0.05))
        ),
    }),
]  # fmt: skip
LOADS = [
    *by_case(LOADED, "fx of Load", {
        "fx of the load dropped": load(lambda p, c: p | {"fx": 0}),
        "fx 5 % too large": load(lambda p, c: p | {"fx": 1.05 * p["fx"]}),
    }),
    *by_case(LOADED, "fy of Load", {
        "fy of the load dropped": load(lambda p, c: p | {"fy": 0}),
        "fy backwards": load(lambda p, c: p | {"fy": -p["fy"]}),
    }),
    *by_case(LOADED, "moment of Load", {
        "moment of the load dropped": load(lambda p, c: p | {"moment": 0}),
        "moment backwards": load(lambda p, c: p | {"moment": -p["moment"]}),
    }),
    *by_case(equations("thrown disc"), "fy of Load", {"fy dropped in flight": load(lambda p, c: p | {"fy": 0})}),
    *by_case(LOADED, f"{EOM}: v", {
        "fx and fy exchanged": load(lambda p, c: p | {"fx": p["fy"], "fy": p["fx"]}),
        "load frozen at its start": frozen(t=0.0),
    }),
    *by_case(LOADED, "vx", {"load without vx": frozen(vx=0.0)}),
    *by_case(equations("thrown disc"), "vy", {"load without place": frozen(x=0.0)}),
    *by_case(LOADED, "omega", {"load without spin": frozen(omega=0.0), "load without angle": frozen(theta=0.0)}),
    *by_case(LOADED, EOM, {
        "load at the contact point": load(lambda p, c: p | {"moment": p["moment"] + p["fx"] * c.plate.inner}),
    }),
    *by_case(LOADED, "Load", {
        "load taken as an acceleration": load(
            lambda p, c: p | {"fx": p["fx"] * c.plate.mass, "fy": p["fy"] * c.plate.mass}
        ),
    }),
    *by_case(equations("loaded disc in a valley"), f"{EOM}: v", {
        "no load in valleys": where(in_valley, effect(Load, lambda e: None)),
    }),
    *by_case("load", "moment of Load", {
        "couple of the load halved": load(lambda p, c: p | {"moment": 0.5 * p["moment"]}),
        "couple of the load 10 % too large": load(lambda p, c: p | {"moment": 1.1 * p["moment"]}),
    }),
    *by_case("load", "fx of Load", {"no load at all": effect(Load, lambda e: None)}),
]  # fmt: skip
IMPACTS = [
    *by_case("bounce", E, {
        "restitution ignored": other(lambda e: 0.0), "restitution fixed at 0.5": other(lambda e: 0.5),
        "restitution squared": other(lambda e: e**2), "restitution by the geometric mean": other(lambda e: e**0.5),
        "restitution of both bodies multiplied": other(lambda e: 0.8 * e),
    }),
    *by_case("landing", E, {"a landing that rebounds": other(lambda e: max(e, 0.3))}),
    *by_case("landing", MU, {
        "impacts without friction": where(
            lambda c: c.effect(Impact) is not None, effect(CoulombFriction, lambda e: None)
        ),
    }),
    *by_case("bounce_with_friction", MU, {"impacts with half the friction": friction(lambda mu: 0.5 * mu)}),
    *by_case("bounce_with_friction", E, {"impacts with less friction by restitution": other(lambda e: 0.8 * e)}),
]  # fmt: skip
CONTACTS = [
    *by_case("guide", "Unilateral", {
        "the track never pulls": lambda c: replace(
            c, effects=(*(e for e in c.effects if not isinstance(e, Unilateral)), Unilateral())
        ),
    }),
    *by_case("lift_off", "Unilateral", {
        "the track always pulls": where(lambda c: not c.effect(Flight), effect(Unilateral, lambda e: None)),
    }),
    *by_case("perfectly_rough", "PerfectlyRough", {
        "rough contact with mu = 0.5": effect(PerfectlyRough, lambda e: CoulombFriction(0.5)),
    }),
    *by_case(equations("rough valley"), EOM, {
        "rough contact without friction": effect(PerfectlyRough, lambda e: None),
    }),
    *by_case("rolling_resistance", "arm of RollingResistance", {
        "rolling resistance ignored": effect(RollingResistance, lambda e: None),
        "rolling resistance for the diameter": effect(RollingResistance, lambda e: RollingResistance(2 * e.arm)),
    }),
    *by_case(equations("resisted disc"), "arm of RollingResistance", {
        "rolling resistance 10 % off": effect(RollingResistance, lambda e: RollingResistance(1.1 * e.arm)),
    }),
    *by_case("on_its_track[disc in a valley]", "track", {
        "tracks as circles of curvature": osculating, "tracks 2 % too deep": track(lambda x, y: (x, 1.02 * y)),
    }),
    *by_case(AT_START, "at the start", {
        "tracks moved by a centimetre": track(lambda x, y: (x, y + 0.01)),
    }),
    *by_case("free_fall", "damping", {"linear damping of 0.04 1/s": damped(0.04, 0.0)}),
    *by_case("no_friction_no_spin", "damping", {"angular damping of 0.04 1/s": damped(0.0, 0.04)}),
]  # fmt: skip
BELTS = [
    *by_case("belt", SPEED, {
        "belt runs backwards": effect(Belt, lambda e: Belt(-e.expression)),
        "belt 3 % too fast": effect(Belt, lambda e: Belt(1.03 * e.expression)),
        "belt ignored": effect(Belt, lambda e: None),
    }),
    *by_case("driven_track", DRIVEN, {
        "drive ignored": effect(Drive, lambda e: None),
        "drive 3 % too far": effect(Drive, lambda e: Drive(1.03 * e.x, e.y, e.angle)),
        "drive in -x": effect(Drive, lambda e: Drive(-e.x, e.y, e.angle)),
    }),
    *by_case("fixed_rotation", TURNING, {
        "infinite inertia read as a disc's": plate(
            lambda p: replace(p, inertia=0.5 * p.mass * p.inner**2) if isinf(p.inertia) else p
        ),
    }),
    *by_case("fixed_rotation", MU, {
        "friction 2 % too large on plates that do not turn": where(
            lambda c: isinf(c.plate.inertia), friction(lambda mu: 1.02 * mu)
        ),
    }),
]  # fmt: skip
RATES = ("vx", "vy", "omega")
COLUMNS = [
    *by_motion(CIRCLE, EOM, {
        "velocities 20 steps late": {name: lambda m, name=name: late(getattr(m, name), 20) for name in RATES},
        "vertical velocity downwards": {"vy": lambda m: -m.vy},
        "velocities in the plate's frame": {
            "vx": lambda m: m.vx * np.cos(m.theta) + m.vy * np.sin(m.theta),
            "vy": lambda m: m.vy * np.cos(m.theta) - m.vx * np.sin(m.theta),
        },
    }),
    *by_motion(in_circle("momentum_balance"), FORCES, {
        "forces 20 steps late": {
            name: lambda m, name=name: late(getattr(m, name), 20) for name in ("normal_force", "friction_force")
        },
        "normal force 5 % too large in the report": {"normal_force": lambda m: 1.05 * m.normal_force},
    }),
    *by_motion(in_circle("rates_of_pose"), "time", {
        "poses 20 steps late": {"x": lambda m: late(m.x, 20), "y": lambda m: late(m.y, 20)},
    }),
    *by_motion(in_circle("rates_of_pose"), "unit", {
        "clock 1 % slow": {name: lambda m, name=name: 1.01 * getattr(m, name) for name in RATES},
    }),
    *by_motion("free_fall", "theta", {"angle backwards": {"theta": lambda m: -m.theta}}),
    *by_motion("free_fall", "unit of the angle", {"angle in degrees": {"theta": lambda m: np.degrees(m.theta)}}),
    *by_motion("free_fall", "vy", {
        "speed limited": {"vy": lambda m: np.clip(m.vy, -0.8, 0.8)},
        "speed of fall 1 % too large": {"vy": lambda m: 1.01 * m.vy},
    }),
    *by_motion("free_fall", "x", {"way that shrinks in flight": {"x": lambda m: m.x * (1 - 1e-3 * m.t)}}),
    *by_motion("free_fall", "omega", {"spin that fades in flight": {"omega": lambda m: m.omega * (1 - 0.04 * m.t)}}),
    *by_motion(AT_START, "omega", {"spin backwards": {"omega": lambda m: -m.omega}}),
    *by_motion(THROWN, "omega", {"spin in revolutions": {"omega": lambda m: m.omega / (2 * pi)}}),
    *by_motion(AT_START, "y at the start", {"height downwards": {"y": lambda m: -m.y}}),
    *by_motion(AT_START, "at the start", {
        "poses in millimetres": {"x": lambda m: 1e3 * m.x, "y": lambda m: 1e3 * m.y},
    }),
    *by_motion(in_circle("on_its_track"), "slip", {
        "slip backwards": {"slip": lambda m: -m.slip},
        "slip of the plate's centre": {"slip": lambda m: np.hypot(m.vx, m.vy)},
        "slip 0.2 m/s too large": {"slip": lambda m: m.slip + 0.2},
    }),
    *by_motion(in_circle("on_its_track"), "the gap", {"plate that rises": {"y": lambda m: m.y + 0.01 * m.t}}),
    *by_motion("sticking_threshold", "slip", {"slip that creeps": {"slip": lambda m: m.slip + 2e-3 * m.t}}),
    *by_motion("no_friction_no_spin", "the spin", {"spin that grows": {"omega": lambda m: m.omega * (1 + 1e-6 * m.t)}}),
    *by_motion(in_circle("cone"), "normal force", {
        "normal force backwards": {"normal_force": lambda m: -m.normal_force},
    }),
    *by_motion("guide", "the normal force", {
        "normal force without sign": {"normal_force": lambda m: np.abs(m.normal_force)},
    }),
    *by_motion(in_circle("friction_opposes_slip"), MU, {
        "friction backwards": {"friction_force": lambda m: -m.friction_force},
        "half the friction in the report": {"friction_force": lambda m: 0.5 * m.friction_force},
    }),
    *by_motion(in_circle("cone"), MU, {
        "friction 10 % too large in the report": {"friction_force": lambda m: 1.1 * m.friction_force},
    }),
    *by_motion(in_circle("energy_never_grows"), "energy never grows", {
        "velocities that grow": {name: lambda m, name=name: getattr(m, name) * (1 + 2 * m.t) for name in RATES[:2]},
    }),
    *by_motion(in_circle("turn_frame"), "turned frame", {"drift along x": {"x": lambda m: m.x + 0.05 * m.t}}),
    *by_motion(in_circle("mirror_image"), "mirror image", {"drift to the right": {"x": lambda m: m.x + 0.05 * m.t}}),
    *by_motion("lift_off", "cos phi", {"lift-off 0.02 rad too far": {"xi1": lambda m: m.xi1 + 0.02}}),
    *by_motion("lift_off", "lift-off: the motion should end", {"no lift-off": {"status": lambda m: "completed"}}),
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
    *by_case(COLLISION, "mass of each", {"mass of free plates 5 % too large": HEAVY}),
    *by_case("wedge_of_free_plates", "mass of the", {"mass of a free polygon 5 % too large": HEAVY}),
    *by_case(RUBBING, "inertia of each", {
        "inertia of free plates that of the first": lambda case: _of_others(
            lambda o: replace(o, plate=replace(o.plate, inertia=case.plate.inertia))
        )(case),
    }),
    *by_case(RUBBING, MU, {
        "mu of two discs multiplied": effect(CoulombFriction, lambda e: CoulombFriction(e.mu**2)),
    }),
    *by_case(COLLISION, E, {
        "restitution of two discs multiplied": effect(Impact, lambda e: replace(e, restitution=e.restitution**2)),
    }),
    *by_case("pile_of_free_plates", "the way of", {
        "a pile without friction between plates": effect(CoulombFriction, lambda e: None),
    }),
]  # fmt: skip

MUTANTS: list[Mutant] = [
    *GRAVITY, *FRICTION, *PLATES, *STARTS, *LOADS, *IMPACTS, *CONTACTS, *BELTS, *COLUMNS, *FREE_PLATES,
]  # fmt: skip
