#!/usr/bin/env -S python3 -P
"""MuJoCo (wheel mujoco): a sphere, or the hull of a prism, on a plane, a sphere or a ring of boxes.

The scene's own MJCF with contact parameters. MuJoCo's contacts are soft by design: in a regularised convex problem a
sliding contact lifts off a little (its manual, "Computation", contact), and friction creeps. Its default step is
semi-implicit Euler; the ladder has its Runge-Kutta method of fourth order, which converges in a circle where Euler does
not. Poses and velocities are at the same times, as after `mj_step`.

A belt of constant speed is `surfacevel` of the track's geoms (from 3.11 on): a velocity along a plane or a box, in the
geom's frame, and a rotation of a sphere's surface.
"""

from __future__ import annotations

import sys
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

# Chords of a curved track; a friction coefficient that no force exceeds.
CHORDS, ROUGH = 800, 1e3

scene = plane.read_scene("MuJoCo", ("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight", "Belt"))
belt = plane.belt_speed(scene)
if belt is None:
    plane.refuse("MuJoCo's geoms are given a constant surface velocity, and this belt's speed changes with time.")
if belt and not hasattr(mujoco.MjModel, "geom_surfacevel"):
    plane.refuse("MuJoCo has surface velocities from version 3.11 on, and an older one is installed.")
count, h = plane.steps(scene)
effects, start, is_tuned = scene["effects"], scene["start"], scene["setting"].get("rung") != "defaults"
mu = ROUGH if "PerfectlyRough" in effects else effects.get("CoulombFriction", {}).get("mu", 0.0)


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
world = part(root, "worldbody")
body = part(world, "body")
for box in world.findall("geom"):
    world.remove(box)
track = plane.shape(scene)
if track.kind == "line":
    ElementTree.SubElement(
        world, "geom", type="plane", size="0 0 1", pos=f"{track.x} {track.y} 0",
        xyaxes=f"{plane.cos(track.angle)} {plane.sin(track.angle)} 0 0 0 -1",
    )  # fmt: skip
elif track.kind == "hill":
    ElementTree.SubElement(world, "geom", type="sphere", size=repr(track.radius), pos=f"{track.x} {track.y} 0")
else:
    thick = 0.1
    for box in plane.chords(scene, scene["setting"].get("facets", CHORDS)):
        x, y = box.x + thick * plane.sin(box.angle), box.y - thick * plane.cos(box.angle)
        ElementTree.SubElement(
            world, "geom", type="box", size=f"{box.half} {thick} 1", pos=f"{x} {y} 0", euler=f"0 0 {box.angle}"
        )
for geom in world.findall("geom"):
    # A hill is touched from outside, so its direction is clockwise.
    turns = f"0 0 0 0 0 {-belt / track.radius!r}" if track.kind == "hill" else f"{belt!r} 0 0 0 0 0"
    geom.attrib.update({"surfacevel": turns} if belt else {})
plate = part(body, "geom")
if plate.get("type") == "cylinder":
    plate.attrib.update(type="sphere", size=repr(scene["plate"]["radius"]))
for geom in root.iter("geom"):
    # The engine takes the larger of the two geoms' numbers.
    geom.attrib.update(friction=f"{mu} 0 0", condim="3" if mu else "1")
    if is_tuned:
        # Twice the step is the stiffest value that the engine considers safe.
        geom.set("solref", f"{scene['setting'].get('timeconst', 2) * h!r} 1")
        geom.set("solimp", "0.9999 0.9999 0.001 0.5 2")

model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
data = mujoco.MjData(model)
data.qvel[:] = start["vx"], start["vy"], start["omega"]


def touches() -> list[plane.PlaneContact]:
    """The contacts that pushed in the last step; the engine keeps those of the step's beginning."""
    contacts, force = [], np.zeros(6)
    for number, contact in enumerate(data.contact):
        mujoco.mj_contactForce(model, data, number, force)
        frame = contact.frame.reshape(3, 3)
        # Both the normal and the force are the second geom's.
        side = 1.0 if model.geom_bodyid[contact.geom2] else -1.0
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


motion, fastest = plane.MotionRows(scene, belt), 0.0
for k in range(count + 1):
    pose, velocities = data.qpos + (start["x"], start["y"], start["theta"]), data.qvel.tolist()
    mujoco.mj_step(model, data)
    motion.note(k * h, pose.tolist(), velocities, touches(), data.qvel.tolist())
    fastest = max(fastest, creep())
motion.write(fastest)
