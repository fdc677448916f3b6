#!/usr/bin/env -S python3 -P
"""MuJoCo (wheel mujoco): a sphere, or the hull of a prism, on a plane, a sphere or a ring of boxes.

The scene's own MJCF with contact parameters. MuJoCo's contacts are soft by design: in a regularised convex problem a
sliding contact lifts off a little (its manual, "Computation", contact), and friction creeps. Its default step is
semi-implicit Euler; the ladder has its Runge-Kutta method of fourth order, which converges in a circle where Euler does
not. Poses and velocities are at the same times, as after `mj_step`.

No step makes two errors smaller. A contact is a spring and a damper that do not pull: what lands at v leaves it at e v,
see `damping_ratio`. A damping ratio of 1, the default and the ladder's where impacts have no restitution, leaves
exp(-2) = 13.5 % of the speed. And where a plate slides at v on a contact that pushes little, the convex cone lifts it
off with up to mu v.

A belt is `surfacevel` of the geoms of the track or of a support (from 3.11 on), set in each step: a velocity along a
plane or a box, in the geom's frame, and a rotation of a sphere's surface. A driven track is a heavy body whose place
and velocities are set in each step.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

sys.path.append(str(Path(__file__).parent / "shared"))
import plane

try:
    import mujoco
    import numpy as np
except ImportError:
    plane.exit_not_available("mujoco")
plane.print_version("mujoco")

# A friction coefficient that no force exceeds.
ROUGH = 1e3
# The mass of a driven track in those of the plate.
HEAVY = 1e9
# Half the side (m) of the box that is a driven line.
WIDE = 20.0

scene = plane.read_scene(
    "MuJoCo",
    (
        *("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Impact", "Belt", "Drive"),
        *("Supports", "FreePlates"),
    ),
    must_turn=False,
    rebounds=True,
)
_, h = plane.steps(scene)
drive = plane.drive_steps(scene, h)
effects, start, is_tuned = scene["effects"], scene["start"], scene["setting"].get("rung") != "defaults"
mu = plane.coefficient(effects, ROUGH)


def damping_ratio(e: float) -> float:
    """The damping ratio z of a contact with the restitution e, 0 < e <= 1; 1 for e = 0.

    A body on a spring and a damper, with the frequency w and s^2 = |1 - z^2|, is free where they stop pushing, at
    w s t = 2 arccos z (z < 1; 2 arccosh z for z > 1). Its speed there is e = exp(-2 (z/s) arccos z) of that before,
    which falls from 1 at z = 0 over exp(-2) at z = 1.
    """
    if e == 0.0:
        return 1.0
    low, high = 0.0, 1.0
    while restitution_of(high) > e:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if restitution_of(middle) > e else (low, middle)
    return low


def restitution_of(z: float) -> float:
    """The restitution of a contact with the damping ratio z > 0."""
    s = math.sqrt(abs(1.0 - z * z))
    angle = math.acos(z) if z < 1.0 else math.acosh(z)
    return math.exp(-2.0 * (z / s * angle if s > 0.0 else 1.0))


def part(whole: ElementTree.Element, name: str) -> ElementTree.Element:
    """The first element of that name, which the suite's MJCF has."""
    element = whole.find(name)
    assert element is not None, f"the scene's MJCF has a {name}"
    return element


root = ElementTree.fromstring(scene["mjcf"])
option = part(root, "option")
option.set("timestep", repr(h))
if is_tuned:
    option.set("integrator", scene["setting"].get("integrator", "RK4"))
    ratio = scene["setting"].get("impratio", 100)
    option.attrib.update(cone="elliptic", impratio=f"{ratio}", solver="Newton", tolerance="1e-12", iterations="100")
world, plates = part(root, "worldbody"), plane.plates(scene)
for box in world.findall("geom"):
    world.remove(box)
# The names of the geoms of each belt, its speed as a function of t, and 1 m/s there.
belts: list[tuple[list[str], Callable[[float], float], np.ndarray]] = []
# A surface velocity of 1 m/s in a geom's frame; that of a disc touched from outside is clockwise.
FLAT = np.array([1.0, 0, 0, 0, 0, 0])


def add_solid(solid: plane.Solid) -> ElementTree.Element:
    """Add a geom: a plane, a sphere or a box."""
    thick, place, angle = 0.1, (solid.x, solid.y), solid.angle
    c, s = plane.cos(angle), plane.sin(angle)
    if solid.kind == "line" and drive:
        # The engine's planes do not move: a box below the start.
        along = (start["x"] - solid.x) * c + (start["y"] - solid.y) * s
        solid = solid._replace(kind="box", x=solid.x + along * c, y=solid.y + along * s, size=WIDE)
        thick = WIDE
    shape: dict[str, str]
    if solid.kind == "line":
        shape = dict(type="plane", size="0 0 1", xyaxes=f"{c} {s} 0 0 0 -1")
    elif solid.kind == "disc":
        shape = dict(type="sphere", size=repr(solid.size))
    else:
        shape, place = dict(type="box", size=f"{solid.size} {thick} 1", euler=f"0 0 {angle}"), solid.middle(thick)
    own = plane.coefficient(solid.effects, ROUGH)
    shape |= dict(pos=f"{place[0]} {place[1]} 0", friction=f"{own} 0 0", condim="3" if own else "1")
    return ElementTree.SubElement(world, "geom", shape)


def run_surface(geoms: list[ElementTree.Element], of_effects, unit: np.ndarray) -> None:
    """Give the geoms the belt of the effects, if they have one."""
    if "Belt" not in of_effects:
        return
    if not hasattr(mujoco.MjModel, "geom_surfacevel"):
        plane.refuse("MuJoCo has surface velocities from version 3.11 on, and an older one is installed.")
    names = [f"belt {len(belts)}, {number}" for number in range(len(geoms))]
    for geom, name in zip(geoms, names, strict=True):
        geom.attrib.update(name=name, surfacevel=" ".join(map(repr, unit.tolist())))
    belts.append((names, plane.formula(str(of_effects["Belt"]["speed"])), unit))


solid_geoms = [(add_solid(solid), solid) for solid in plane.solids(scene)]
surfaces_of: dict[int, tuple[list[ElementTree.Element], plane.Solid]] = {}
for geom, solid in solid_geoms:
    surfaces_of.setdefault(id(solid.effects), ([], solid))[0].append(geom)
for geoms, solid in surfaces_of.values():
    run_surface(geoms, solid.effects, np.array([0, 0, 0, 0, 0, -1 / solid.size]) if solid.kind == "disc" else FLAT)
if drive:
    # Bodies of a mocap kind have no velocity for the engine's contacts: the track has joints, and so much mass that no
    # contact force changes the velocities that are set in each step.
    heavy = repr(HEAVY * max(plates[0].mass, plates[0].inertia or 0.0))
    carrier = ElementTree.SubElement(world, "body", name="track", gravcomp="1")
    ElementTree.SubElement(carrier, "inertial", pos="0 0 0", mass=heavy, diaginertia=f"{heavy} {heavy} {heavy}")
    for name, kind, axis in (("x", "slide", "1 0 0"), ("y", "slide", "0 1 0"), ("angle", "hinge", "0 0 1")):
        ElementTree.SubElement(carrier, "joint", name=f"track {name}", type=kind, axis=axis)
    for geom in world.findall("geom"):
        world.remove(geom)
        carrier.append(geom)
for own in plates:
    geom = part(part(world, f"body[@name='{own.name}']"), "geom")
    # The engine takes the larger of the two geoms' numbers.
    geom.attrib.update(name=own.name, friction="0 0 0", condim="1")
    if geom.get("type") == "cylinder":
        geom.attrib.update(type="sphere", size=repr(own.radius))
pairs = ElementTree.SubElement(root, "contact")


def add_pair(one: str, other: str, own: float, e: float) -> None:
    """Add the contact of two geoms, with a friction coefficient and a restitution.

    A pair has numbers of its own: friction along both tangents, then the moments of 3D contacts; and a spring and a
    damper along the tangents that are not those along the normal, of which a restitution of 1 has no damper.
    """
    pair = ElementTree.SubElement(
        pairs, "pair", geom1=one, geom2=other, friction=f"{own} {own} 0 0 0", condim="3" if own else "1"
    )
    if e > 0.0:
        stiffness = timeconst**-2
        pair.set("solref", f"{-stiffness!r} {-2.0 * damping_ratio(e) * math.sqrt(stiffness)!r}")
        pair.set("solreffriction", f"{timeconst!r} 1")


# Twice the step is the stiffest value that the engine considers safe; 0.02 s its default.
timeconst = scene["setting"].get("timeconst", 2) * h if is_tuned else 0.02
for one, other in combinations([own.name for own in plates], 2):
    add_pair(one, other, mu, plane.restitution(effects))
for number, (geom, solid) in enumerate(solid_geoms):
    if (e := plane.restitution(solid.effects)) > 0.0:
        geom.set("name", geom.get("name", f"solid {number}"))
        for own in plates:
            add_pair(own.name, geom.attrib["name"], plane.coefficient(solid.effects, ROUGH), e)
for geom in (*root.iter("geom"), *pairs):
    if is_tuned:
        if "solreffriction" not in geom.attrib:
            geom.set("solref", f"{timeconst!r} 1")
        geom.set("solimp", "0.9999 0.9999 0.001 0.5 2")

model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
data = mujoco.MjData(model)


def joints_of(of: plane.MovingPlate) -> list[int]:
    """The numbers of a plate's joints in the engine's coordinates, which all are of one number: x, y and, if it turns,
    theta."""
    names = plane.POSE if of.inertia is not None else plane.POSE[:2]
    return [int(model.joint(name if of.name == "plate" else f"{name} of {of.name}").dofadr[0]) for name in names]


joints = [joints_of(own) for own in plates]
for own, numbers in zip(plates, joints, strict=True):
    data.qvel[numbers] = own.velocities[: len(numbers)]
rail = [int(model.joint(f"track {name}").dofadr[0]) for name in ("x", "y", "angle")] if drive else []
body_number = model.body("plate").id
surfaces = [([model.geom(name).id for name in names], speed, unit) for names, speed, unit in belts]


def touches() -> list[plane.PlaneContact]:
    """The contacts that pushed in the last step; the engine keeps those of the step's beginning."""
    contacts, force = [], np.zeros(6)
    for number, contact in enumerate(data.contact):
        mujoco.mj_contactForce(model, data, number, force)
        frame = contact.frame.reshape(3, 3)
        # Both the normal and the force are the second geom's.
        side = 1.0 if model.geom_bodyid[contact.geom2] == body_number else -1.0
        push, normal = side * force[:3] @ frame, side * frame[0]
        contacts.append(plane.PlaneContact(contact.pos[:2].tolist(), normal[:2].tolist(), push[:2].tolist()))
    return contacts


def creep() -> float:
    """The slip velocity (m/s) of the contacts that stuck in the last step.

    In the friction directions the constraint's acceleration is -b v - R f ("Computation", reference acceleration, and
    the identity R f = a_ref - a): steady slip under the friction f has v = R f / b. R and b are the engine's own
    numbers of the step; for a pyramid's edges, which are mu times as steep, the engine's number is 2 mu^2 R.
    """
    fastest, force = 0.0, np.zeros(6)
    for number, contact in enumerate(data.contact):
        if contact.dim == 1 or contact.efc_address < 0:
            continue
        mujoco.mj_contactForce(model, data, number, force)
        row, pyramid = contact.efc_address + 1, model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
        softness = data.efc_R[row] / (2 * contact.friction[0] ** 2 if pyramid else 1.0)
        fastest = max(fastest, softness * float(np.hypot(*force[1:3])) / data.efc_KBIP[row, 1])
    return fastest


def states() -> list[list[float]]:
    """(x, y, theta, vx, vy, omega) of every plate."""
    rows = []
    for own, numbers in zip(plates, joints, strict=True):
        moved, rates = np.zeros(3), np.zeros(3)
        moved[: len(numbers)], rates[: len(numbers)] = data.qpos[numbers], data.qvel[numbers]
        rows.append([*(moved + own.pose).tolist(), *rates.tolist()])
    return rows


def step(number: int) -> None:
    """Set the velocities of driven tracks and belts, then make a step of all."""
    if drive:
        data.qpos[rail], data.qvel[rail] = drive(number)
    for numbers, speed, unit in surfaces:
        model.geom_surfacevel[numbers] = speed((number + 0.5) * h) * unit
    mujoco.mj_step(model, data)


# Inside a rebound the slip changes from step to step.
from_poses = bool(drive) or "Supports" in effects or plane.restitution(effects) > 0.0
belt = surfaces[-1][1] if surfaces else None
plane.write_motion(scene, states, step, touches, creep, plane.MIDDLE, from_poses, belt)
