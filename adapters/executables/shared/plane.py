"""Functions shared by the executables in Python: read the scene, report unsupported ones, write the motion.

Needs NumPy and nothing of the suite, so that an engine can have an environment of its own.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from math import atan2, ceil, cos, hypot, pi, sin
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, Protocol

try:
    import numpy as np
except ImportError:
    # Each of the engines requires NumPy.
    engine = Path(sys.argv[0]).stem
    print(f"{engine} is not installed: pip install {engine}, for the python3 that is first on PATH", file=sys.stderr)
    sys.exit(1)


def refuse(why: str, limit: str = "") -> NoReturn:
    """End the program with the exit status for an unsupported scene, and one sentence with the reason; `limit`: the
    engine's documented limit that says so, if the engine cannot."""
    print(f"{why}\nlimit: {limit}" if limit else why, file=sys.stderr)
    sys.exit(3)


def print_version(name: str) -> None:
    """With the option --version, print the package's name and version and end the program."""
    if "--version" in sys.argv:
        print(name, version(name))
        sys.exit(0)


def exit_not_available(name: str, package: str = "") -> NoReturn:
    """End the program with a message that says what to install: the package, where it has another name."""
    print(
        f"{name} is not installed: pip install {package or name}, for the python3 that is first on PATH",
        file=sys.stderr,
    )
    sys.exit(1)


# Effects whose name in a scene is not the one that a case has.
WORDS = {"CoulombFrictionBySpeed": "friction that depends on the slip velocity"}


def read_scene(
    engine: str,
    names: tuple[str, ...],
    reasons: dict[str, str] | None = None,
    must_turn: bool = True,
    rebounds: bool = False,
) -> dict[str, Any]:
    """The scene. Ends the program for an effect that is not in `names`, with the effect's sentence of `reasons` if it
    has one, or that no engine with contacts supports; with `must_turn`, for a plate that does not turn; without
    `rebounds`, for an impact with a restitution."""
    scene = json.load(sys.stdin)
    effects = scene["effects"]
    everywhere = [effects, *(support["effects"] for support in effects.get("Supports", {}).values())]
    used = dict.fromkeys(name for own in everywhere for name in own)
    for name, reason in (reasons or {}).items():
        if name in used:
            refuse(reason)
    missing = [name for name in used if name not in names]
    if missing:
        refuse(f"{engine} has no implementation here of {' and '.join(WORDS.get(name, name) for name in missing)}.")
    if must_turn and any(plate.inertia is None for plate in plates(scene)):
        refuse(f"{engine}'s bodies have a finite inertia here, and this plate does not turn.")
    if "Unilateral" not in effects:
        refuse(f"{engine}'s contacts only push, and this plate is guided from both sides.")
    for own in everywhere:
        if restitution(own) != 0.0 and not rebounds:
            refuse(f"{engine} is given inelastic impacts only here, and this Impact has a restitution.")
        friction = own.get("CoulombFriction")
        if friction and friction["mu_static"] not in (None, friction["mu"]):
            refuse(f"{engine} has one friction coefficient for slip and stick.")
    return scene


def restitution(effects) -> float:
    """The restitution of impacts, 0 without one: Newton's, whatever law the case has."""
    return float(effects.get("Impact", {}).get("restitution", 0.0))


def coefficient(effects, rough: float) -> float:
    """The friction coefficient of a track's or a support's effects; `rough` for a perfectly rough one."""
    return rough if "PerfectlyRough" in effects else effects.get("CoulombFriction", {}).get("mu", 0.0)


# The functions and numbers of formulas in t.
FUNCTIONS = {name: getattr(math, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "atan", "pi")}


def formula(text: str) -> Callable[[float], float]:
    """A function of t for a formula of the scene. Ends the program for one with unknown functions."""
    code = compile(text, "formula", "eval")
    unknown = set(code.co_names) - {*FUNCTIONS, "t"}
    if unknown:
        refuse(f"Formulas in t have {', '.join(FUNCTIONS)} here, and this one has {', '.join(sorted(unknown))}.")
    return lambda t: float(eval(code, {"__builtins__": {}, **FUNCTIONS, "t": t}))


Triple = tuple[float, float, float]
POSE, RATES = ("x", "y", "theta"), ("vx", "vy", "omega")
FORCES = ("slip", "normal_force", "friction_force")


def drive_steps(scene, h: float) -> Callable[[int], tuple[Triple, Triple]] | None:
    """For a driven track, a function of a step's number: the track's place (m) and angle where the step of h (s)
    begins, and the velocities that move it to its place at the next one. None for a track at rest."""
    drive = scene["effects"].get("Drive")
    if drive is None:
        return None
    x, y, angle = (formula(str(drive[name])) for name in ("x", "y", "angle"))

    def step(number: int) -> tuple[Triple, Triple]:
        here, there = ((x(t), y(t), angle(t)) for t in (number * h, (number + 1) * h))
        vx, vy, spin = ((b - a) / h for a, b in zip(here, there, strict=True))
        return here, (vx, vy, spin)

    return step


class MovingPlate(NamedTuple):
    """A plate: its name, mass (kg), inertia (kg m², None if it does not turn), radius (m, None if it is no disc), pose
    and velocities at time zero."""

    name: str
    mass: float
    inertia: float | None
    radius: float | None
    pose: Triple
    velocities: Triple


def plates(scene) -> list[MovingPlate]:
    """All plates: the scene's own, called "plate", and the further ones."""
    every = [("plate", scene["plate"], scene["start"])]
    every += [(name, one, one["start"]) for name, one in scene["effects"].get("FreePlates", {}).items()]
    return [
        MovingPlate(
            name, one["mass"], one["inertia"], one["radius"],
            (start["x"], start["y"], start["theta"]), (start["vx"], start["vy"], start["omega"]),
        )
        for name, one, start in every
    ]  # fmt: skip


def gravity(scene) -> tuple[float, float, float]:
    """The acceleration of gravity as a vector in space, m/s²."""
    pull = scene["effects"].get("Gravity", dict(g=0.0, direction=0.0))
    return pull["g"] * cos(pull["direction"]), pull["g"] * sin(pull["direction"]), 0.0


class Solid(NamedTuple):
    """A fixed body: "line", what lies to the right of a straight line without ends; "disc", touched from outside; or
    "box", to the right of a chord of the track. A point of the line, the centre, or the middle of the face that the
    plate touches (m), the angle of the direction, the radius or half the length (m), and the effects on it."""

    kind: str
    name: str
    x: float
    y: float
    angle: float
    size: float
    effects: dict[str, Any]

    def middle(self, thick: float) -> tuple[float, float]:
        """The middle of the box, which is `thick` (m) behind its face."""
        return self.x + thick * sin(self.angle), self.y - thick * cos(self.angle)


def solids(scene) -> list[Solid]:
    """The track, as one box for each facet if it is neither straight nor a disc, and the further supports."""
    effects, every = scene["effects"], list[Solid]()
    for one in scene["solids"]:
        name, acting = one["name"], effects.get("Supports", {}).get(one["name"], scene)["effects"]
        if one["kind"] == "chain":
            places = corners(one)
            for number, ((ax, ay), (bx, by)) in enumerate(zip(places[:-1], places[1:], strict=True)):
                middle, size = (float(ax + bx) / 2, float(ay + by) / 2), 0.5 * hypot(bx - ax, by - ay)
                every.append(Solid("box", f"chord {number}", *middle, atan2(by - ay, bx - ax), size, acting))
        else:
            every.append(Solid(one["kind"], name, one["x"], one["y"], one["angle"], one["radius"], acting))
    return every


def corners(chain) -> np.ndarray:
    """The ends of the facets of a track, shape (n, 2), m."""
    return np.column_stack([chain["x"], chain["y"]])


def steps(scene) -> tuple[int, float]:
    """How many steps, and the step (s), which divides the duration evenly."""
    count = max(60, ceil(scene["duration"] / scene["setting"]["h"] - 1e-9))
    return count, scene["duration"] / count


# Friction below this share of the cone is sticking: solvers leave at most a thousandth.
INSIDE = 0.999


class PlaneContact(NamedTuple):
    """A place where a step of the engine's pushed the plate: the point (m), the contact's unit normal towards the
    plate, and the force on the plate (N)."""

    point: tuple[float, float]
    normal: tuple[float, float]
    force: tuple[float, float]

    @property
    def along(self) -> tuple[float, float]:
        """The tangent on whose left the plate is."""
        return self.normal[1], -self.normal[0]

    @property
    def normal_force(self) -> float:
        """N."""
        return self.force[0] * self.normal[0] + self.force[1] * self.normal[1]

    @property
    def friction_force(self) -> float:
        """N, along the tangent."""
        return self.force[0] * self.along[0] + self.force[1] * self.along[1]


class Stepper(Protocol):
    """An engine with a disc in the plane."""

    def state(self) -> tuple[Sequence[float], Sequence[float]]:
        """Pose (x, y, theta) and velocities (vx, vy, omega); the angle may forget whole turns."""

    def set_state(self, pose: Sequence[float], velocities: Sequence[float]) -> None:
        """Set both."""

    def step(self) -> None:
        """One step."""


# Roundings of a velocity in one step.
ROUNDINGS = 10


def run_half_steps(scene, stepper: Stepper, rounding: float, of_places: float = 0.0) -> None:
    """Run an engine with semi-implicit Euler's step and rigid friction, and write the motion of a disc.

    Such a step is leapfrog if the velocities belong to half a step after the poses. So the start's velocities are set
    back by half of what the first step adds to them, which a trial step measures; a row has the means. The force of the
    contact is what the momentum gains beyond gravity, up to the relative `rounding` of the engine's numbers, and to
    that `of_places` over the step, where the engine's velocities follow from places.
    """
    (count, h), start, pull, normal_at = steps(scene), scene["start"], gravity(scene), nearest_normal(scene)
    mass, radius = scene["plate"]["mass"], scene["plate"]["radius"]
    pose, velocities = (tuple(start[name] for name in names) for names in (("x", "y", "theta"), ("vx", "vy", "omega")))
    stepper.set_state(pose, velocities)
    stepper.step()
    trial = stepper.state()[1]
    stepper.set_state(pose, [1.5 * v - 0.5 * w for v, w in zip(velocities, trial, strict=True)])
    motion, (_, before), creep = MotionRows(scene), stepper.state(), 0.0
    for k in range(count + 1):
        stepper.step()
        following, after = stepper.state()
        speed = hypot(after[0], after[1]) + radius * abs(after[2])
        noise = ROUNDINGS * rounding * speed + of_places * hypot(pose[0], pose[1]) / h
        creep = max(creep, noise)
        force = mass * ((after[0] - before[0]) / h - pull[0]), mass * ((after[1] - before[1]) / h - pull[1])
        touches = []
        if hypot(*force) * h > mass * (noise + ROUNDINGS * rounding * h * hypot(*pull)):
            nx, ny = normal_at(pose[0], pose[1])
            touches.append(PlaneContact((pose[0] - radius * nx, pose[1] - radius * ny), (nx, ny), force))
        motion.note_half_step(k * h, pose, before, touches, after)
        turns = round((pose[2] - following[2]) / (2 * pi))
        pose, before = (following[0], following[1], following[2] + 2 * pi * turns), after
    motion.write(creep)


def nearest_normal(scene) -> Callable[[float, float], tuple[float, float]]:
    """The track's left unit normal at the point nearest to (x, y), from the nearest sample and its curvature."""
    track = {name: np.array(column) for name, column in scene["points"]["track"].items()}

    def normal(x: float, y: float) -> tuple[float, float]:
        dx, dy = x - track["x"], y - track["y"]
        i = int(np.argmin(dx**2 + dy**2))
        nx, ny, bend = (float(track[name][i]) for name in ("normal_x", "normal_y", "curvature"))
        away, along = dx[i] * nx + dy[i] * ny, dx[i] * ny - dy[i] * nx
        turn = bend * along / (1.0 - bend * away)
        c, s = cos(turn), sin(turn)
        return nx * c - ny * s, ny * c + nx * s

    return normal


# The share of an overlap at which friction acts, in engines with the contact point in its middle.
MIDDLE = 0.5


def write_motion(
    scene, states: Callable[[], list[list[float]]], step: Callable[[int], object], touches: Callable, creep: Callable,
    lever: float = 0.0, from_poses: bool = False, belt: Callable[[float], float] | None = None,
) -> None:  # fmt: skip
    """Make all steps of a scene by `step(number)`, and print the motion.

    `states()`: (x, y, theta, vx, vy, omega) of every plate now; `touches()`: the contacts that pushed the only plate in
    the last step; `creep()`: the slip velocity (m/s) of contacts that stuck in it. With `from_poses` the suite computes
    the slip, as for several plates; friction acts at the share `lever` of an overlap from the plate. `belt(t)` is the
    speed (m/s) of the track's surface.
    """
    (count, h), fastest, motion = steps(scene), 0.0, MotionRows(scene)
    for k in range(count + 1):
        before = states()
        step(k)
        if len(before) > 1:
            motion.rows.append((k * h, *(value for state in before for value in state)))
        else:
            motion.belt = belt((k + 1) * h) if belt else 0.0
            motion.note(k * h, before[0][:3], before[0][3:], touches(), states()[0][3:])
            motion.slip = None if from_poses else motion.slip
        fastest = max(fastest, creep())
    motion.write(fastest, lever)


class MotionRows:
    """The rows of a motion, and the CPU time since this object was made.

    Poses and velocities are at the same times; of several plates there is nothing else, and the suite computes their
    contacts. The forces of a row are those of the step that begins there. Its slip is that of the step that ends there,
    at the engine's own contact points, where its friction acts, relative to a surface that runs along the track with
    `belt` m/s.
    """

    def __init__(self, scene, belt: float = 0.0):
        self.scene, self.belt, self.cpu_start = scene, belt, time.process_time()
        names = [plate.name for plate in plates(scene)]
        columns = [name if plate == "plate" else f"{name} of {plate}" for plate in names for name in POSE + RATES]
        self.names = ["t", *columns, *(FORCES if len(names) == 1 else ())]
        self.rows: list[tuple] = []
        # Slip at the end of the last step.
        self.slip: float | None = scene["start"]["slip"]

    def note(self, t: float, pose, velocities, touches: list[PlaneContact], after) -> None:
        """Add a row: pose and velocities where a step begins, the step's contacts, and the velocities `after` it."""
        push = sum(touch.normal_force for touch in touches)
        self.rows.append((t, *pose, *velocities, self.slip, push, sum(touch.friction_force for touch in touches)))
        self.slip = self._slip(pose, touches, after)

    def note_half_step(self, t: float, pose, before, touches: list[PlaneContact], after) -> None:
        """The same for an engine whose velocities are half a step before and after the pose: a row has their means."""
        last, self.slip = self.slip, self._slip(pose, touches, after)
        slip = None if last is None or self.slip is None else 0.5 * (last + self.slip)
        velocities = [0.5 * (u + v) for u, v in zip(before, after, strict=True)]
        push = sum(touch.normal_force for touch in touches)
        if not self.rows:  # the start has its own velocities and slip
            velocities, slip = [self.scene["start"][name] for name in ("vx", "vy", "omega")], last
        self.rows.append((t, *pose, *velocities, slip, push, sum(touch.friction_force for touch in touches)))

    def _slip(self, pose, touches: list[PlaneContact], velocities) -> float | None:
        """The slip velocity (m/s), weighted by the normal forces; None without contact, where it follows from the
        pose."""
        push = sum(touch.normal_force for touch in touches)
        vx, vy, omega = velocities
        slips = [
            touch.normal_force * ((vx - omega * dy) * touch.along[0] + (vy + omega * dx) * touch.along[1])
            for touch in touches
            for dx, dy in [(touch.point[0] - pose[0], touch.point[1] - pose[1])]
        ]
        return sum(slips) / push - self.belt if push > 0.0 else None

    def write(self, creep: float, lever: float = 0.0) -> None:
        """Print the motion as comma-separated values, with its cost and the slip (m/s) below which it counts as
        sticking: `creep` from the engine's own law, plus what missing friction leaves. Friction acts at the share
        `lever` of an overlap from the plate; this is for slips that the suite computes from the poses."""
        cpu = time.process_time() - self.cpu_start
        print(f"# creep = {creep + self._missing():.6g}\n# lever = {lever:g}")
        lines = (",".join("" if value is None else repr(float(value)) for value in row) for row in self.rows)
        print(",".join(self.names), *lines, sep="\n")
        print(f"# cost cpu_s={cpu:.6g} steps={len(self.rows)}")

    def _missing(self) -> float:
        """The slip velocity (m/s) that one step leaves where the normal force is too small; 99th percentile.

        On corners the normal force scatters from step to step, and friction with it. Half the difference of two
        neighbours, one of them inside its cone, is their distance from the mean; μ times as much force is missing for
        one step.
        """
        plate, friction = self.scene["plate"], self.scene["effects"].get("CoulombFriction")
        if not friction or len(self.rows) < 3 or FORCES[0] not in self.names:
            return 0.0
        t, push, rub = np.array([(row[0], *row[8:]) for row in self.rows]).T
        sticks = (push > 0.0) & (np.abs(rub) < INSIDE * friction["mu"] * push)
        scatter = 0.5 * np.abs(np.diff(push))[sticks[1:] | sticks[:-1]]
        outline = self.scene["points"]["outline"]
        reach = float(np.hypot(outline["x"], outline["y"]).max())
        ease = 1 / plate["mass"] + (reach**2 / plate["inertia"] if plate["inertia"] else 0.0)
        return friction["mu"] * ease * (t[1] - t[0]) * (float(np.percentile(scatter, 99)) if scatter.size else 0.0)
