#!/usr/bin/env python3
"""A complete engine for `--engine`: a disc with Coulomb friction on a line or a circle. Replace `step` by your engine.

It reads one scene as JSON and writes the motion as CSV (docs/process_protocol.md). SI units, radians.
"""

import json
import sys
from math import atan2, ceil, cos, inf, sin


def main() -> int:
    scene = json.load(sys.stdin)
    if not is_supported(scene):
        print("Only discs in contact with a line or a circle, with one coefficient of friction, are supported.",
              file=sys.stderr)  # fmt: skip
        return 3  # unsupported; any other status but 0 is a crash
    steps = max(60, ceil(scene["duration"] / scene["setting"]["h"]))
    h, state = scene["duration"] / steps, start(scene)
    # An engine whose contacts creep while they stick may report the speed: print("# creep = 5e-3")
    print("t,x,y,theta,vx,vy,omega,normal_force,friction_force")
    for k in range(steps + 1):
        after, normal, tangential = step(scene, state, h)
        if normal < 0.0 and "Unilateral" in scene["effects"]:
            break  # the disc leaves the track: the output ends
        x, y, heading, u, theta, omega = state
        row = k * h, x, y, theta, u * cos(heading), u * sin(heading), omega, normal, tangential
        print(",".join(map(repr, row)))
        state = after
    return 0


def is_supported(scene) -> bool:
    effects, bends = scene["effects"], scene["points"]["track"]["curvature"]
    return (
        scene["plate"]["radius"] is not None
        and scene["start"]["xi1"] is not None
        and not set(effects) - {"Gravity", "CoulombFriction", "Unilateral"}
        and not effects.get("CoulombFriction", {}).get("mu_static")
        and isinstance(effects.get("CoulombFriction", {"mu": 0.0})["mu"], int | float)  # not a formula
        and max(bends) - min(bends) <= 1e-9 * abs(bends[0])
    )


def start(scene):
    """Place of the centre, direction and size of its velocity along the track, angle and its rate."""
    first, at = {name: values[0] for name, values in scene["points"]["track"].items()}, scene["start"]
    nx, ny, bend = first["normal_x"], first["normal_y"], first["curvature"]
    if bend:  # the track's left normal; of a circle, along the line from the disc's centre to the circle's
        nx, ny = (first["x"] - at["x"]) * bend + nx, (first["y"] - at["y"]) * bend + ny
    heading = atan2(-nx, ny)
    u = at["vx"] * cos(heading) + at["vy"] * sin(heading)
    return at["x"], at["y"], heading, u, at["theta"], at["omega"]


def step(scene, state, h):
    """The next state by the midpoint rule, and both forces at this one. Friction is as large as sticking until the end
    of the step needs, up to mu times the normal force."""
    m, r = scene["plate"]["mass"], scene["plate"]["radius"]
    inertia = scene["plate"]["inertia"] or inf  # null: the disc does not turn
    gravity = scene["effects"].get("Gravity", {"g": 0.0, "direction": 0.0})
    gx, gy = gravity["g"] * cos(gravity["direction"]), gravity["g"] * sin(gravity["direction"])
    mu = scene["effects"].get("CoulombFriction", {"mu": 0.0})["mu"]
    bend = scene["points"]["track"]["curvature"][0]
    x, y, heading, u, theta, omega = state

    def rates(direction, speed):
        tx, ty = cos(direction), sin(direction)
        turning, along = bend * speed / (1.0 - bend * r), gx * tx + gy * ty
        normal = m * (turning * speed - (gy * tx - gx * ty))
        stop = -((u + r * omega) / h + along) / (1.0 / m + r * r / inertia)
        tangential = max(-mu * abs(normal), min(mu * abs(normal), stop))
        return turning, along + tangential / m, r * tangential / inertia, normal, tangential

    turning, du, _, normal, tangential = rates(heading, u)
    direction, speed = heading + 0.5 * h * turning, u + 0.5 * h * du
    turning, du, domega, *_ = rates(direction, speed)
    x, y = x + h * speed * cos(direction), y + h * speed * sin(direction)
    after = x, y, heading + h * turning, u + h * du, theta + h * (omega + 0.5 * h * domega), omega + h * domega
    return after, normal, tangential


if __name__ == "__main__":
    sys.exit(main())
