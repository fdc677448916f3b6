"""What engines in Python share: the scene from standard input, refusals, the track's shape, the motion as text.

It needs NumPy and nothing of the suite, so that an engine may live in an environment of its own.
"""

from __future__ import annotations

import json
import sys
import time
from importlib.metadata import version
from math import atan2, ceil, cos, hypot, pi, sin
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

try:
    import numpy as np
except ImportError:
    # It comes with each of the engines.
    engine = Path(sys.argv[0]).stem
    print(f"{engine} is not installed: pip install {engine}, for the python3 that is first on PATH", file=sys.stderr)
    sys.exit(1)


def refuse(why: str) -> NoReturn:
    """End the program by refusing the scene, in one sentence."""
    print(why, file=sys.stderr)
    sys.exit(3)


def tell_version(name: str) -> None:
    """Asked with --version, the program ends here with the package's name and version."""
    if "--version" in sys.argv:
        print(name, version(name))
        sys.exit(0)


def not_installed(name: str) -> NoReturn:
    """End the program by saying what has to be installed."""
    print(f"{name} is not installed: pip install {name}, for the python3 that is first on PATH", file=sys.stderr)
    sys.exit(1)


def read_scene(engine: str, known: tuple[str, ...]) -> dict[str, Any]:
    """The scene; refused if it has what `known` does not name, or what no engine of contacts has."""
    scene = json.load(sys.stdin)
    effects = scene["effects"]
    strange = [name for name in effects if name not in known]
    if strange:
        refuse(f"{engine} has not been told how to do {' and '.join(strange)}.")
    if "Unilateral" not in effects:
        refuse(f"{engine}'s contacts only push, and this plate is guided from both sides.")
    friction = effects.get("CoulombFriction")
    if friction and friction["mu_static"] not in (None, friction["mu"]):
        refuse(f"{engine} has one friction coefficient for slip and stick.")
    return scene


def gravity(scene) -> tuple[float, float, float]:
    """The acceleration of gravity, m/s², in space."""
    pull = scene["effects"].get("Gravity", dict(g=0.0, direction=0.0))
    return pull["g"] * cos(pull["direction"]), pull["g"] * sin(pull["direction"]), 0.0


class Shape(NamedTuple):
    """A track: "line" by a point and the angle of its direction; "hill", a whole circle met from outside, by centre and
    radius (m); or "chain"."""

    kind: str
    x: float = 0.0
    y: float = 0.0
    angle: float = 0.0
    radius: float = 0.0


def shape(scene) -> Shape:
    """What the track is to an engine with few shapes."""
    track = scene["points"]["track"]
    bend = np.array(track["curvature"])
    x, y, nx, ny = (track[name][0] for name in ("x", "y", "normal_x", "normal_y"))
    if not bend.any():
        return Shape("line", x, y, angle=atan2(-nx, ny))
    if scene["closed"]["track"] and bend.max() < 0.0 and np.ptp(bend) < 1e-9 * -bend.min():
        radius = -1.0 / float(bend.min())
        return Shape("hill", x - radius * nx, y - radius * ny, radius=radius)
    return Shape("chain")


class Box(NamedTuple):
    """A chord of the track: the middle of the face that the plate touches, its angle, and half its length (m)."""

    x: float
    y: float
    angle: float
    half: float


def chords(scene, count: int) -> list[Box]:
    """About `count` chords, moved outwards by a third of their sagitta, so that their mean distance is the curve's."""
    track = {name: np.array(column) for name, column in scene["points"]["track"].items()}
    s = np.linspace(track["s"][0], track["s"][-1], count + 1)
    corners = np.column_stack([_between(track, s, "x"), _between(track, s, "y")])
    bend = np.interp(0.5 * (s[1:] + s[:-1]), track["s"], track["curvature"])
    found = []
    for (ax, ay), (bx, by), curvature in zip(corners[:-1], corners[1:], bend, strict=True):
        length, angle = hypot(bx - ax, by - ay), atan2(by - ay, bx - ax)
        off = curvature * length**2 / 12
        x, y = 0.5 * (ax + bx) + off * sin(angle), 0.5 * (ay + by) - off * cos(angle)
        found.append(Box(float(x), float(y), angle, 0.5 * length))
    return found


def _between(track, s: np.ndarray, name: str) -> np.ndarray:
    """A coordinate between the samples, by the cubic with the curve's tangents at both."""
    i = np.clip(np.searchsorted(track["s"], s) - 1, 0, len(track["s"]) - 2)
    along = {"x": track["normal_y"], "y": -track["normal_x"]}[name]
    chord = np.hypot(np.diff(track["x"]), np.diff(track["y"]))[i]
    length = chord * (1 + (track["curvature"][i] * chord) ** 2 / 24)
    u = (s - track["s"][i]) / (track["s"][i + 1] - track["s"][i])
    w, p = 1 - u, track[name]
    ends = p[i] * w**2 * (1 + 2 * u) + p[i + 1] * u**2 * (3 - 2 * u)
    return ends + length * u * w * (along[i] * w - along[i + 1] * u)


def steps(scene) -> tuple[int, float]:
    """How many steps, and the step (s), which divides the duration evenly."""
    count = max(60, ceil(scene["duration"] / scene["setting"]["h"] - 1e-9))
    return count, scene["duration"] / count


class Motion:
    """The rows of a motion, and the time it took from here."""

    NAMES = "t,x,y,theta,vx,vy,omega"

    def __init__(self):
        self.rows, self.begun = [], time.process_time()

    def write(self, count: int, creep: float) -> None:
        """As comma-separated values, with its cost and the slip (m/s) below which it is declared to stick."""
        cpu = time.process_time() - self.begun
        print(f"# creep = {creep!r}")
        print(self.NAMES, *(",".join(map(repr, map(float, row))) for row in self.rows), sep="\n")
        print(f"# cost cpu_s={cpu:.6g} steps={count}")


def nearest_turn(angle: float, before: float) -> float:
    """The angle, with the whole turns that bring it next to the one before."""
    return angle + 2 * pi * round((before - angle) / (2 * pi))
