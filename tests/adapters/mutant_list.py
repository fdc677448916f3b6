"""All adapters with one mistake, by the part that is wrong: the law that catches each, and words of its message."""

from __future__ import annotations

from dataclasses import replace
from math import isinf, pi

import numpy as np

from cases import (
    Belt,
    CoulombFriction,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    RollingResistance,
    Unilateral,
)

from .mutants import (
    Mutant,
    case_mutant,
    centre,
    damped,
    effect,
    equations,
    friction,
    frozen,
    in_valley,
    late,
    load,
    motion_mutant,
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
from .plate_mutants import FREE_PLATES

G, MU, E = "g of Gravity", "mu of CoulombFriction", "restitution of Impact"
IN_CIRCLE, IN_VALLEY, LOADED = equations("disc in a circle"), equations("disc in a valley"), equations("loaded disc")
TURNED, STATIC = equations("off-centre disc"), equations("static friction")

GRAVITY = [
    case_mutant("g fixed at 9.81", IN_CIRCLE, G, effect(Gravity, lambda e: Gravity(9.81, e.direction))),
    case_mutant("g 3 % too strong", IN_VALLEY, G, effect(Gravity, lambda e: Gravity(1.03 * e.g, e.direction))),
    case_mutant("g doubled", IN_CIRCLE, G, effect(Gravity, lambda e: Gravity(2 * e.g, e.direction))),
    case_mutant(
        "no gravity in flight", "free_fall", G, where(lambda c: not c.start.in_contact, effect(Gravity, lambda e: None))
    ),
    case_mutant("gravity along -y always", TURNED, "equations of motion", effect(Gravity, lambda e: Gravity(e.g))),
    case_mutant(
        "gravity turned by 2 degrees",
        IN_CIRCLE,
        "direction of Gravity",
        effect(Gravity, lambda e: Gravity(e.g, e.direction + pi / 90)),
    ),
    case_mutant(
        "gravity mirrored", TURNED, "equations of motion", effect(Gravity, lambda e: Gravity(e.g, pi - e.direction))
    ),
]
FRICTION = [
    case_mutant("mu times the ground's default 0.5", IN_CIRCLE, MU, friction(lambda mu: 0.5 * mu)),
    case_mutant("mu by the geometric mean with 0.5", IN_CIRCLE, MU, friction(lambda mu: (0.5 * mu) ** 0.5)),
    case_mutant("mu of both bodies multiplied", IN_CIRCLE, MU, friction(lambda mu: mu * mu)),
    case_mutant("the larger mu of two bodies", IN_CIRCLE, MU, friction(lambda mu: max(mu, 0.5))),
    case_mutant("the mean mu of two bodies", IN_CIRCLE, MU, friction(lambda mu: 0.5 * (mu + 0.5))),
    case_mutant("mu fixed at 0.1", IN_CIRCLE, MU, friction(lambda mu: 0.1)),
    case_mutant("mu 2 % too large", "friction_torque", MU, friction(lambda mu: 1.02 * mu)),
    case_mutant("friction off", IN_CIRCLE, MU, effect(CoulombFriction, lambda e: None)),
    case_mutant("friction unbounded", "friction_torque", MU, effect(CoulombFriction, lambda e: CoulombFriction(1e3))),
    case_mutant("mu_static ignored", STATIC, "mu_static", effect(CoulombFriction, lambda e: CoulombFriction(e.mu))),
    case_mutant("mu_static for slip, too", STATIC, MU, effect(CoulombFriction, lambda e: CoulombFriction(e.stick))),
    case_mutant(
        "mu_static twice mu always",
        equations("breakaway"),
        MU,
        effect(CoulombFriction, lambda e: CoulombFriction(e.mu, 2 * e.mu)),
    ),
    case_mutant(
        "no friction on hills", equations("disc on a hill"), MU, where(on_hill, effect(CoulombFriction, lambda e: None))
    ),
    case_mutant("no friction in valleys", IN_VALLEY, MU, where(in_valley, effect(CoulombFriction, lambda e: None))),
    case_mutant("no friction on lines", "friction_torque", MU, where(on_line, effect(CoulombFriction, lambda e: None))),
    case_mutant(
        "less friction on bumps", equations("disc on a bump"), MU, where(on_hill, friction(lambda mu: 0.9 * mu))
    ),
    case_mutant(
        "backward friction 5 % less", IN_VALLEY, MU, where(lambda c: c.start.slip > 0, friction(lambda mu: 0.95 * mu))
    ),
    case_mutant(
        "mu of v = 0 at all speeds", "friction_by_speed", "formula of v", slip_law(lambda mu, v: mu.subs(v, 0))
    ),
    case_mutant(
        "slip speed doubled in mu", "friction_by_speed", "formula of v", slip_law(lambda mu, v: mu.subs(v, 2 * v))
    ),
    case_mutant(
        "slip speed 2 % off in mu",
        "friction_by_speed",
        "formula of v",
        slip_law(lambda mu, v: mu.subs(v, 1.02 * v)),
    ),
    case_mutant(
        "sticking threshold half a percent off", "sticking_threshold", "mu_static", friction(lambda mu: 1.005 * mu)
    ),
]
PLATES = [
    case_mutant("mass fixed at 1 kg", LOADED, "mass of the plate", plate(lambda p: replace(p, mass=1.0))),
    case_mutant("mass doubled", LOADED, "mass of the plate", plate(lambda p: replace(p, mass=2 * p.mass))),
    case_mutant(
        "inertia of a homogeneous disc",
        IN_CIRCLE,
        "inertia",
        plate(lambda p: replace(p, inertia=0.5 * p.mass * p.inner**2)),
    ),
    case_mutant("inertia of a hoop", IN_VALLEY, "inertia", plate(lambda p: replace(p, inertia=p.mass * p.inner**2))),
    case_mutant(
        "inertia about the contact",
        IN_CIRCLE,
        "inertia",
        plate(lambda p: replace(p, inertia=p.inertia + p.mass * p.inner**2)),
    ),
    case_mutant("inertia 5 % too large", IN_CIRCLE, "inertia", plate(lambda p: replace(p, inertia=1.05 * p.inertia))),
    case_mutant("inertia without units", LOADED, "inertia", plate(lambda p: replace(p, inertia=p.inertia / p.mass))),
    case_mutant(
        "centre of mass recentred",
        "starts_as_given[off-centre disc]",
        "centre of mass",
        outline(lambda x, y, c: (x - centre(c)[0], y - centre(c)[1])),
    ),
    case_mutant(
        "centre of mass mirrored",
        "starts_as_given[off-centre disc]",
        "centre of mass",
        outline(lambda x, y, c: (x - 2 * centre(c)[0], y), off_centre),
    ),
    case_mutant(
        "centre of mass turned",
        "starts_as_given[off-centre disc]",
        "centre of mass",
        outline(lambda x, y, c: (x - centre(c)[0] - centre(c)[1], y - centre(c)[1] + centre(c)[0]), off_centre),
    ),
    case_mutant(
        "radius 2 % too large", "on_its_track[disc in a circle]", "plate", outline(lambda x, y, c: (1.02 * x, 1.02 * y))
    ),
    case_mutant(
        "ellipse as a circle",
        "on_its_track[ellipse in a circle]",
        "outline",
        outline(
            lambda x, y, c: (0.5 * (x + y) + 0.5 * (x - y), y * c.plate.reach / c.plate.inner),
            lambda c: c.plate.radius is None,
        ),
    ),
    case_mutant(
        "ellipse 5 % too thick",
        "on_its_track[ellipse in a circle]",
        "outline",
        outline(lambda x, y, c: (x, 1.05 * y), lambda c: c.plate.radius is None),
    ),
]
STARTS = [
    case_mutant(
        "slip at the start ignored", "starts_as_given[disc in a circle]", "slip", start(lambda s: replace(s, slip=0.0))
    ),
    case_mutant(
        "slip at the start backwards",
        "starts_as_given[disc in a valley]",
        "slip",
        start(lambda s: replace(s, slip=-s.slip)),
    ),
    case_mutant(
        "spin at the start ignored",
        "starts_as_given[disc in a circle]",
        "omega",
        start(lambda s: replace(s, omega=0.0)),
    ),
    case_mutant(
        "spin at the start backwards",
        "starts_as_given[thrown disc]",
        "omega",
        start(lambda s: replace(s, omega=-s.omega)),
    ),
    case_mutant(
        "gap at the start ignored", "starts_as_given[thrown disc]", "gap", start(lambda s: replace(s, gap=0.5 * s.gap))
    ),
    case_mutant(
        "gap_rate at the start ignored",
        "starts_as_given[thrown disc]",
        "gap_rate",
        start(lambda s: replace(s, gap_rate=0.0)),
    ),
    case_mutant(
        "gap_rate at the start backwards", "free_fall", "gap_rate", start(lambda s: replace(s, gap_rate=-s.gap_rate))
    ),
    case_mutant(
        "place at the start 2 % off",
        "starts_as_given[disc in a valley]",
        "xi1",
        start(lambda s: replace(s, xi1=1.02 * s.xi1)),
    ),
    case_mutant(
        "orientation at the start ignored",
        "starts_as_given[ellipse in a circle]",
        "at the start",
        where(lambda c: c.plate.radius is None, start(lambda s: replace(s, xi2=(s.xi2 or 0.0) + 0.05))),
    ),
]
LOADS = [
    case_mutant("fx of the load dropped", LOADED, "fx of Load", load(lambda p, c: p | {"fx": 0})),
    case_mutant("fy of the load dropped", LOADED, "fy of Load", load(lambda p, c: p | {"fy": 0})),
    case_mutant("moment of the load dropped", LOADED, "moment of Load", load(lambda p, c: p | {"moment": 0})),
    case_mutant("fy dropped in flight", equations("thrown disc"), "fy of Load", load(lambda p, c: p | {"fy": 0})),
    case_mutant("fx 5 % too large", LOADED, "fx of Load", load(lambda p, c: p | {"fx": 1.05 * p["fx"]})),
    case_mutant("fy backwards", LOADED, "fy of Load", load(lambda p, c: p | {"fy": -p["fy"]})),
    case_mutant("moment backwards", LOADED, "moment of Load", load(lambda p, c: p | {"moment": -p["moment"]})),
    case_mutant(
        "fx and fy exchanged", LOADED, "equations of motion: v", load(lambda p, c: p | {"fx": p["fy"], "fy": p["fx"]})
    ),
    case_mutant("load frozen at its start", LOADED, "equations of motion: v", frozen(t=0.0)),
    case_mutant("load without vx", LOADED, "vx", frozen(vx=0.0)),
    case_mutant("load without place", equations("thrown disc"), "vy", frozen(x=0.0)),
    case_mutant("load without spin", LOADED, "omega", frozen(omega=0.0)),
    case_mutant("load without angle", LOADED, "omega", frozen(theta=0.0)),
    case_mutant(
        "load at the contact point",
        LOADED,
        "equations of motion",
        load(lambda p, c: p | {"moment": p["moment"] + p["fx"] * c.plate.inner}),
    ),
    case_mutant(
        "load taken as an acceleration",
        LOADED,
        "Load",
        load(lambda p, c: p | {"fx": p["fx"] * c.plate.mass, "fy": p["fy"] * c.plate.mass}),
    ),
    case_mutant(
        "no load in valleys",
        equations("loaded disc in a valley"),
        "equations of motion: v",
        where(in_valley, effect(Load, lambda e: None)),
    ),
    case_mutant(
        "couple of the load halved", "load", "moment of Load", load(lambda p, c: p | {"moment": 0.5 * p["moment"]})
    ),
]
IMPACTS = [
    case_mutant("restitution ignored", "bounce", E, effect(Impact, lambda e: Impact(0.0))),
    case_mutant("restitution fixed at 0.5", "bounce", E, effect(Impact, lambda e: Impact(0.5))),
    case_mutant("restitution squared", "bounce", E, effect(Impact, lambda e: Impact(e.restitution**2))),
    case_mutant("restitution by the geometric mean", "bounce", E, effect(Impact, lambda e: Impact(e.restitution**0.5))),
    case_mutant(
        "restitution of both bodies multiplied", "bounce", E, effect(Impact, lambda e: Impact(0.8 * e.restitution))
    ),
    case_mutant("a landing that rebounds", "landing", E, effect(Impact, lambda e: Impact(max(e.restitution, 0.3)))),
    case_mutant(
        "impacts without friction",
        "landing",
        MU,
        where(lambda c: c.effect(Impact) is not None, effect(CoulombFriction, lambda e: None)),
    ),
    case_mutant("impacts with half the friction", "bounce_with_friction", MU, friction(lambda mu: 0.5 * mu)),
]
CONTACTS = [
    case_mutant(
        "the track never pulls",
        "guide",
        "Unilateral",
        lambda c: replace(c, effects=(*(e for e in c.effects if not isinstance(e, Unilateral)), Unilateral())),
    ),
    case_mutant(
        "the track always pulls",
        "lift_off",
        "Unilateral",
        lambda c: c if c.effect(Flight) else effect(Unilateral, lambda e: None)(c),
    ),
    case_mutant(
        "rough contact with mu = 0.5",
        "perfectly_rough",
        "PerfectlyRough",
        effect(PerfectlyRough, lambda e: CoulombFriction(0.5)),
    ),
    case_mutant(
        "rough contact without friction",
        equations("rough valley"),
        "equations of motion",
        effect(PerfectlyRough, lambda e: None),
    ),
    case_mutant(
        "rolling resistance ignored",
        "rolling_resistance",
        "arm of RollingResistance",
        effect(RollingResistance, lambda e: None),
    ),
    case_mutant(
        "rolling resistance for the diameter",
        "rolling_resistance",
        "arm of RollingResistance",
        effect(RollingResistance, lambda e: RollingResistance(2 * e.arm)),
    ),
    case_mutant(
        "rolling resistance 10 % off",
        equations("resisted disc"),
        "arm of RollingResistance",
        effect(RollingResistance, lambda e: RollingResistance(1.1 * e.arm)),
    ),
    case_mutant("tracks as circles of curvature", "on_its_track[disc in a valley]", "track", osculating),
    case_mutant("tracks 2 % too deep", "on_its_track[disc in a valley]", "track", track(lambda x, y: (x, 1.02 * y))),
    case_mutant(
        "tracks moved by a centimetre",
        "starts_as_given[disc in a circle]",
        "at the start",
        track(lambda x, y: (x, y + 0.01)),
    ),
    case_mutant("linear damping of 0.04 1/s", "free_fall", "damping", damped(0.04, 0.0)),
    case_mutant("angular damping of 0.04 1/s", "no_friction_no_spin", "damping", damped(0.0, 0.04)),
]
COLUMNS = [
    motion_mutant(
        "velocities 20 steps late",
        IN_CIRCLE,
        "equations of motion",
        vx=lambda m: late(m.vx, 20),
        vy=lambda m: late(m.vy, 20),
        omega=lambda m: late(m.omega, 20),
    ),
    motion_mutant(
        "forces 20 steps late",
        "momentum_balance[disc in a circle]",
        "the reported forces",
        normal_force=lambda m: late(m.normal_force, 20),
        friction_force=lambda m: late(m.friction_force, 20),
    ),
    motion_mutant(
        "poses 20 steps late",
        "rates_of_pose[disc in a circle]",
        "time",
        x=lambda m: late(m.x, 20),
        y=lambda m: late(m.y, 20),
    ),
    motion_mutant(
        "clock 1 % slow",
        "rates_of_pose[disc in a circle]",
        "unit",
        vx=lambda m: 1.01 * m.vx,
        vy=lambda m: 1.01 * m.vy,
        omega=lambda m: 1.01 * m.omega,
    ),
    motion_mutant("angle backwards", "free_fall", "theta", theta=lambda m: -m.theta),
    motion_mutant("angle in degrees", "free_fall", "unit of the angle", theta=lambda m: np.degrees(m.theta)),
    motion_mutant("spin backwards", "starts_as_given[disc in a circle]", "omega", omega=lambda m: -m.omega),
    motion_mutant("spin in revolutions", "starts_as_given[thrown disc]", "omega", omega=lambda m: m.omega / (2 * pi)),
    motion_mutant("height downwards", "starts_as_given[disc in a circle]", "y at the start", y=lambda m: -m.y),
    motion_mutant("vertical velocity downwards", IN_CIRCLE, "equations of motion", vy=lambda m: -m.vy),
    motion_mutant("slip backwards", "on_its_track[disc in a circle]", "slip", slip=lambda m: -m.slip),
    motion_mutant(
        "slip of the plate's centre", "on_its_track[disc in a circle]", "slip", slip=lambda m: np.hypot(m.vx, m.vy)
    ),
    motion_mutant(
        "normal force backwards", "cone[disc in a circle]", "normal force", normal_force=lambda m: -m.normal_force
    ),
    motion_mutant(
        "friction backwards", "friction_opposes_slip[disc in a circle]", MU, friction_force=lambda m: -m.friction_force
    ),
    motion_mutant(
        "friction 10 % too large in the report",
        "cone[disc in a circle]",
        MU,
        friction_force=lambda m: 1.1 * m.friction_force,
    ),
    motion_mutant(
        "normal force 5 % too large in the report",
        "momentum_balance[disc in a circle]",
        "the reported forces",
        normal_force=lambda m: 1.05 * m.normal_force,
    ),
    motion_mutant(
        "velocities in the plate's frame",
        IN_CIRCLE,
        "equations of motion",
        vx=lambda m: m.vx * np.cos(m.theta) + m.vy * np.sin(m.theta),
        vy=lambda m: m.vy * np.cos(m.theta) - m.vx * np.sin(m.theta),
    ),
    motion_mutant(
        "poses in millimetres",
        "starts_as_given[disc in a circle]",
        "at the start",
        x=lambda m: 1e3 * m.x,
        y=lambda m: 1e3 * m.y,
    ),
    motion_mutant("drift along x", "turn_frame[disc in a circle]", "turned frame", x=lambda m: m.x + 0.05 * m.t),
    motion_mutant("speed limited", "free_fall", "vy", vy=lambda m: np.clip(m.vy, -0.8, 0.8)),
]
SPEED, DRIVEN, TURNING = "speed of Belt", "x of Drive", "inertia of the plate (infinite)"
BELTS = [
    case_mutant("belt runs backwards", "belt", SPEED, effect(Belt, lambda e: Belt(-e.expression))),
    case_mutant("belt 3 % too fast", "belt", SPEED, effect(Belt, lambda e: Belt(1.03 * e.expression))),
    case_mutant("belt ignored", "belt", SPEED, effect(Belt, lambda e: None)),
    case_mutant("drive ignored", "driven_track", DRIVEN, effect(Drive, lambda e: None)),
    case_mutant("drive 3 % too far", "driven_track", DRIVEN, effect(Drive, lambda e: Drive(1.03 * e.x, e.y, e.angle))),
    case_mutant("drive in -x", "driven_track", DRIVEN, effect(Drive, lambda e: Drive(-e.x, e.y, e.angle))),
    case_mutant(
        "infinite inertia read as a disc's",
        "fixed_rotation",
        TURNING,
        plate(lambda p: replace(p, inertia=0.5 * p.mass * p.inner**2) if isinf(p.inertia) else p),
    ),
    case_mutant(
        "friction 2 % too large on plates that do not turn",
        "fixed_rotation",
        MU,
        where(lambda c: isinf(c.plate.inertia), friction(lambda mu: 1.02 * mu)),
    ),
]

MUTANTS: list[Mutant] = [
    *GRAVITY, *FRICTION, *PLATES, *STARTS, *LOADS, *IMPACTS, *CONTACTS, *BELTS, *COLUMNS, *FREE_PLATES,
]  # fmt: skip
