#!/usr/bin/env -S python3 -P
"""MuJoCo (wheel mujoco): a sphere, or the hull of a prism, on a plane, a sphere or a ring of boxes.

The scene's own MJCF with contact parameters. MuJoCo's contacts are soft by design: in a regularised convex problem a
sliding contact lifts off a little (its manual, "Computation", contact), and friction creeps. Its step is semi-implicit
Euler; poses and velocities stand at the same times here, as `mj_step` leaves them.
"""

from __future__ import annotations

import sys
from pathlib import Path
from xml.etree import ElementTree

sys.path.append(str(Path(__file__).parent / "shared"))
import plane

try:
    import mujoco
except ImportError:
    plane.not_installed("mujoco")
plane.tell_version("mujoco")

# Of a curved track; friction that no forces exhaust.
CHORDS, ROUGH = 800, 1e3
# What is declared, m/s: its contacts are soft, and a ring of boxes is bumpy.
DECLARED = 5e-3

scene = plane.read_scene("MuJoCo", ("Gravity", "CoulombFriction", "PerfectlyRough", "Unilateral", "Flight"))
count, h = plane.steps(scene)
effects, start, tuned = scene["effects"], scene["start"], scene["setting"].get("rung") != "defaults"
mu = ROUGH if "PerfectlyRough" in effects else effects.get("CoulombFriction", {}).get("mu", 0.0)


def part(whole: ElementTree.Element, name: str) -> ElementTree.Element:
    """The first element of that name, which the suite's MJCF has."""
    found = whole.find(name)
    assert found is not None, f"the scene's MJCF has a {name}"
    return found


root = ElementTree.fromstring(scene["mjcf"])
option = part(root, "option")
option.set("timestep", repr(h))
if tuned:
    option.attrib.update(cone="elliptic", impratio="100", solver="Newton", tolerance="1e-12", iterations="100")
world = part(root, "worldbody")
body = part(world, "body")
for box in world.findall("geom"):
    world.remove(box)
track = plane.shape(scene)
if track.kind == "line":
    ElementTree.SubElement(
        world, "geom", type="plane", size="0 0 1", pos=f"{track.x} {track.y} 0",
        zaxis=f"{-plane.sin(track.angle)} {plane.cos(track.angle)} 0",
    )  # fmt: skip
elif track.kind == "hill":
    ElementTree.SubElement(world, "geom", type="sphere", size=repr(track.radius), pos=f"{track.x} {track.y} 0")
else:
    thick = 0.1
    for box in plane.chords(scene, CHORDS):
        x, y = box.x + thick * plane.sin(box.angle), box.y - thick * plane.cos(box.angle)
        ElementTree.SubElement(
            world, "geom", type="box", size=f"{box.half} {thick} 1", pos=f"{x} {y} 0", euler=f"0 0 {box.angle}"
        )
plate = part(body, "geom")
if plate.get("type") == "cylinder":
    plate.attrib.update(type="sphere", size=repr(scene["plate"]["radius"]))
for geom in root.iter("geom"):
    # Of two geoms' numbers the engine takes the larger.
    geom.attrib.update(friction=f"{mu} 0 0", condim="3" if mu else "1")
    if tuned:
        geom.set("solref", f"{2 * h!r} 1")  # twice the step is the stiffest that the engine takes for safe
        geom.set("solimp", "0.9999 0.9999 0.001 0.5 2")

model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
data = mujoco.MjData(model)
data.qvel[:] = start["vx"], start["vy"], start["omega"]
motion = plane.Motion()
for k in range(count + 1):
    (x, y, theta), velocities = data.qpos, data.qvel
    motion.rows.append((k * h, start["x"] + x, start["y"] + y, start["theta"] + theta, *velocities))
    mujoco.mj_step(model, data)
motion.write(count, DECLARED)
