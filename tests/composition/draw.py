"""A scene from its seed: kinds of features by their weights, numbers by their ranges, as plain data (JSON).

Weights and ranges are added to and never changed, so that a seed keeps its scene as long as no kind is added. Only the
standard library is imported: the same scene is drawn in every environment. Geometry is this file's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, hypot, pi, sin, tan
from random import Random
from typing import Any

Spec = dict[str, Any]
Point = tuple[float, float]

# --- weights ----------------------------------------------------------------------------------------------------------

TRACKS = {
    "line": 6, "incline": 4, "parabola": 3, "wave": 3, "circle": 2, "hill": 2, "polyline": 3, "wedge": 2, "step": 2,
    "tiles": 2, "rounded": 2, "points": 3, "shelf": 2,
}  # fmt: skip
PLATES = {
    "disc": 6, "ellipse": 2, "egg": 2, "rectangle": 5, "triangle": 2, "pentagon": 1, "rounded": 2, "half_disc": 1,
    "reuleaux": 1,
}  # fmt: skip
FRICTION = {"none": 2, "coulomb": 8, "static": 2, "by_speed": 2, "rough": 2}
STARTS = {"contact": 5, "flight": 4, "two_contacts": 2, "flat": 3}
OTHERS = {0: 6, 1: 3, 2: 1}
SUPPORTS = {0: 5, 1: 3, 2: 2}
SUPPORT_CURVES = {"wall": 5, "incline": 3, "parabola": 1, "circle": 1, "polyline": 1}
PLACES = {"above": 3, "stacked": 2, "beside": 2}
IMPACTS = {"none": 2, "poisson": 2, "newton": 2, "moreau": 5}
LOADS = {"none": 10, "constant": 2, "periodic": 2, "spring": 1, "drag": 1}
MOTIONS = {"none": 10, "belt": 2, "belt_in_time": 1, "shaken": 2, "tilted": 1}
USES = {"simulated": 6, "resumed": 2, "exported": 1, "swept": 1}
METHODS = {"taylor": 1, "dop853": 1}
# Chances: the plate does not turn; rolling resistance; an effect of a package; a pair's own friction; no Unilateral.
FIXED, RESISTANCE, OWN, PAIR, BILATERAL = 0.1, 0.1, 0.05, 0.4, 0.06

G = 9.81
# Length of one roughly straight or curved track, to each side (m).
REACH = 3.0


def draw(seed: int, attempt: int = 0) -> Spec:
    """The scene of a seed: a dictionary of words and numbers, which `build.scene` makes a case of; `attempt`: which one
    of its scenes, where the first ones begin where they cannot."""
    numbers = Random(f"{seed}/{attempt}" if attempt else seed)
    track = draw_track(numbers)
    plates = [draw_plate(numbers) for _ in range(1 + choose(numbers, OTHERS))]
    supports = [draw_support(numbers, side) for side in range(choose(numbers, SUPPORTS))]
    spec = {
        "seed": seed,
        "attempt": attempt,
        "track": track,
        "plates": plates,
        "supports": supports,
        "effects": draw_effects(numbers),
        "start": choose(numbers, STARTS),
        "places": [choose(numbers, PLACES) for _ in plates[1:]],
        "velocity": [numbers.choice([0.0, numbers.uniform(-1.5, 1.5)]), numbers.choice([0.0, -numbers.random()])],
        "omega": numbers.choice([0.0, numbers.uniform(-6.0, 6.0)]),
        "height": numbers.uniform(0.02, 0.2),
        "angle": numbers.choice([0.0, numbers.uniform(-pi, pi)]),
        "at": numbers.uniform(-0.3, 0.3),
        "duration": numbers.uniform(0.3, 1.0),
        "use": choose(numbers, USES),
        "method": choose(numbers, METHODS),
    }
    _make_consistent(spec)
    spec["poses"] = poses(spec)
    return spec


# Tracks that a straight side may lie on.
CONVEX = ("line", "incline", "hill", "tiles", "shelf", "step")


def _make_consistent(spec: Spec) -> None:
    """Leave out what contradicts the rest by mechanics: a belt without friction, a flight without Flight, a side that
    begins flat in a valley, slip on a rough track, a spin or a resisted roll of a plate that does not turn."""
    effects, plate = spec["effects"], spec["plates"][0]
    if any(plate["fixed"] for plate in spec["plates"]):
        effects["resistance"] = spec["omega"] = 0.0
    if plate["kind"] not in ("disc", "ellipse", "egg") and spec["track"]["kind"] not in CONVEX:
        spec["start"] = "flight"
    if spec["start"] == "flight" or len(spec["plates"]) > 1 or spec["supports"]:
        effects["unilateral"] = effects["flight"] = True
    if effects["friction"]["kind"] == "none":
        effects["resistance"] = 0.0
    if effects["friction"]["kind"] == "rough":
        spec["velocity"] = [0.0, spec["velocity"][1]]
        if plate["kind"] == "disc" and spec["start"] != "flight":
            spec["omega"] = 0.0
    if effects["motion"]["kind"].startswith("belt"):
        effects["resistance"] = 0.0
        if effects["friction"]["kind"] == "none":
            effects["friction"]["kind"] = "coulomb"


def choose(numbers: Random, weights: Mapping) -> Any:
    """A key, as often as its weight says."""
    return numbers.choices(list(weights), list(weights.values()))[0]


def features(spec: Spec) -> list[str]:
    """The kinds of features in a scene, of which the table of pairs is made."""
    effects = spec["effects"]
    found = {
        f"track {spec['track']['kind']}", f"friction {effects['friction']['kind']}", f"impact {effects['impact']}",
        f"start {spec['start']}", f"use {spec['use']}", f"method {spec['method']}", f"plates {len(spec['plates'])}",
        *(f"plate {plate['kind']}" for plate in spec["plates"]), *(f"support {s['kind']}" for s in spec["supports"]),
    }  # fmt: skip
    found |= {f"{key} {effects[key]['kind']}" for key in ("load", "motion") if effects[key]["kind"] != "none"}
    more = {
        "resistance": effects["resistance"],
        "own": effects["own"],
        "bilateral": not effects["unilateral"],
        "fixed rotation": any(plate["fixed"] for plate in spec["plates"]),
        "pair friction": any("mu" in support for support in spec["supports"]),
    }
    return sorted(found | {name for name, present in more.items() if present})


# --- parts ------------------------------------------------------------------------------------------------------------


def draw_track(numbers: Random) -> Spec:
    """A track: its kind and its sizes in metres, radians and 1/m."""
    kind, u = choose(numbers, TRACKS), numbers.uniform
    sizes: dict[str, Callable[[], Spec]] = {
        "line": lambda: {},
        "incline": lambda: {"slope": u(-0.6, 0.6)},
        "parabola": lambda: {"bend": u(0.1, 1.0)},
        "wave": lambda: {"height": u(0.01, 0.15), "number": u(1.0, 5.0)},
        "circle": lambda: {"radius": u(0.8, 2.0)},
        "hill": lambda: {"radius": u(0.5, 2.0)},
        "polyline": lambda: {"points": _polyline(numbers)},
        "wedge": lambda: {"angle": u(0.2, 0.9)},
        "step": lambda: {"height": u(-0.15, 0.15), "place": u(0.3, 0.6)},
        "tiles": lambda: {"length": u(0.05, 0.3)},
        "rounded": lambda: {"angle": u(0.2, 0.9), "radius": u(0.2, 0.8)},
        "points": lambda: {"points": _measured(numbers)},
        "shelf": lambda: {"end": u(0.3, 0.8)},
    }
    return {"kind": kind, **sizes[kind]()}


def _polyline(numbers: Random) -> list[Point]:
    points = [(-REACH, numbers.uniform(0.0, 0.3))]
    while points[-1][0] < REACH:
        points.append((points[-1][0] + numbers.uniform(0.3, 1.2), numbers.uniform(-0.15, 0.15)))
    return points


def _measured(numbers: Random) -> list[Point]:
    a, k, phase = numbers.uniform(0.02, 0.1), numbers.uniform(1.0, 3.0), numbers.uniform(0.0, 2.0 * pi)
    return [(x, 0.2 * x * x / REACH + a * sin(k * x + phase)) for x in (REACH * i / 12.0 for i in range(-12, 13))]


def draw_plate(numbers: Random) -> Spec:
    """A plate: its kind, sizes (m) and mass (kg); `fixed` if it does not turn."""
    kind, u = choose(numbers, PLATES), numbers.uniform
    sizes: dict[str, Callable[[], Spec]] = {
        "disc": lambda: {"radius": u(0.05, 0.2)},
        "ellipse": lambda: {"a": u(0.08, 0.2), "b": u(0.05, 0.12)},
        "egg": lambda: {"radius": u(0.06, 0.15), "point": u(0.05, 0.25)},
        "rectangle": lambda: {"width": u(0.1, 0.4), "height": u(0.05, 0.3)},
        "triangle": lambda: {"points": [(0.0, 0.0), (u(0.1, 0.3), 0.0), (u(0.0, 0.1), u(0.1, 0.3))]},
        "pentagon": lambda: {"points": _regular(5, u(0.06, 0.2))},
        "rounded": lambda: {"width": u(0.15, 0.4), "height": u(0.1, 0.3), "radius": u(0.01, 0.04)},
        "half_disc": lambda: {"radius": u(0.08, 0.2)},
        "reuleaux": lambda: {"width": u(0.1, 0.3)},
    }
    return {
        "kind": kind,
        "mass": numbers.choice([1.0, u(0.2, 3.0)]),
        "fixed": numbers.random() < FIXED,
        **sizes[kind](),
    }


def _regular(number: int, radius: float) -> list[Point]:
    angles = [2.0 * pi * i / number - pi / 2.0 - pi / number for i in range(number)]
    return [(radius * cos(a), radius * sin(a)) for a in angles]


def draw_support(numbers: Random, side: int) -> Spec:
    """A support: on the right of the scene if `side` is 0, else on its left; `mu` is the friction of its own pairs."""
    kind, u = choose(numbers, SUPPORT_CURVES), numbers.uniform
    spec = {"kind": kind, "side": 1.0 if side == 0 else -1.0, "place": u(0.5, 1.0), "slope": u(0.3, 1.3)}
    if numbers.random() < PAIR:
        spec["mu"] = numbers.choice([0.0, u(0.05, 0.8)])
    return spec


def draw_effects(numbers: Random) -> Spec:
    """Effects of the whole scene."""
    u = numbers.uniform
    friction = choose(numbers, FRICTION)
    load, motion = choose(numbers, LOADS), choose(numbers, MOTIONS)
    return {
        "friction": {"kind": friction, "mu": u(0.05, 0.9)},
        "unilateral": numbers.random() >= BILATERAL,
        "flight": numbers.random() < 0.9,
        "impact": choose(numbers, IMPACTS),
        "restitution": numbers.choice([0.0, 0.0, u(0.1, 0.9)]),
        "resistance": u(0.001, 0.01) if numbers.random() < RESISTANCE else 0.0,
        "own": u(1.0, 20.0) if numbers.random() < OWN else 0.0,
        "load": {"kind": load, "size": u(0.5, 8.0), "number": u(3.0, 15.0)},
        "motion": {"kind": motion, "size": u(0.2, 1.0), "number": u(5.0, 20.0)},
    }


# --- poses ------------------------------------------------------------------------------------------------------------


def height_at(track: Spec, x: float) -> float:
    """The track's height (m) at x, for a place in flight above it."""
    kind = track["kind"]
    if kind == "incline":
        return -tan(track["slope"]) * x
    if kind == "parabola":
        return track["bend"] * x * x
    if kind == "wave":
        return track["height"] * sin(track["number"] * x)
    if kind == "circle":
        return -((max(track["radius"] ** 2 - x * x, 0.0)) ** 0.5)
    if kind == "hill":
        return max(track["radius"] ** 2 - x * x, 0.0) ** 0.5
    if kind in ("polyline", "points"):
        points = track["points"]
        pairs = [(a, b) for a, b in zip(points, points[1:], strict=False) if a[0] <= x <= b[0]]
        return max((a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]) for a, b in pairs), default=0.0)
    if kind in ("wedge", "rounded"):
        return abs(x) * tan(track["angle"])
    if kind == "step":
        return max(track["height"] if x > track["place"] else 0.0, 0.0)
    return 0.0


def half_length(plate: Spec) -> float:
    """A radius about the centre of mass (m) that the plate lies in."""
    if "points" in plate:
        points = plate["points"]
        return max(hypot(a[0] - b[0], a[1] - b[1]) for a in points for b in points)
    if plate["kind"] == "ellipse":
        return max(plate["a"], plate["b"])
    if plate["kind"] == "egg":
        return plate["radius"] * (1.0 + plate["point"])
    if "height" in plate:
        return hypot(plate["width"], plate["height"]) / 2.0
    return plate["width"] if plate["kind"] == "reuleaux" else 1.5 * plate["radius"]


def low_side(plate: Spec) -> float | None:
    """The centre's height (m) above a level floor that the plate stands on at angle 0; None if that is not simple."""
    if plate["kind"] == "disc":
        return plate["radius"]
    return plate["height"] / 2.0 if plate["kind"] in ("rectangle", "rounded") else None


def top_side(plate: Spec) -> float | None:
    """The height (m) above the centre at which another plate stands on the plate; None if it has no level side."""
    return plate["height"] / 2.0 if plate["kind"] in ("rectangle", "rounded") else None


def poses(spec: Spec) -> list[dict[str, float]]:
    """Pose and velocity of each plate at the start: x, y (m), theta (rad), vx, vy (m/s), omega (rad/s).

    The first plate has none, {}, where it begins on the track by parameters of both curves: they need the built curves.
    """
    first, track = spec["plates"][0], spec["track"]
    result, level = [_first(spec)], track["kind"] in ("line", "tiles", "shelf")
    x, top = spec["at"], height_at(track, spec["at"]) + 2.2 * half_length(first) + spec["height"]
    base = result[0].get("y") if level else None
    for plate, place in zip(spec["plates"][1:], spec["places"], strict=True):
        low, reach = low_side(plate), half_length(plate)
        if place == "stacked" and base is not None and low is not None and top_side(first) is not None:
            base += (top_side(first) or 0.0) + low
            result.append(_at_rest(result[0]["x"], base))
            base, first = (None, plate) if top_side(plate) is None else (base, plate)
            top = max(top, result[-1]["y"] + reach)
        elif place == "beside" and level and spec["plates"][0]["kind"] == plate["kind"] == "disc" and result[0]:
            r, radius = spec["plates"][0]["radius"], plate["radius"]
            side = -1.0 if any(pose["x"] > result[0]["x"] for pose in result[1:]) else 1.0
            dy = radius - result[0]["y"]
            result.append(_at_rest(result[0]["x"] + side * max((r + radius) ** 2 - dy * dy, 0.0) ** 0.5, radius))
        else:
            result.append({**_at_rest(x, top + reach), "vy": spec["velocity"][1], "omega": spec["omega"]})
            top += 2.2 * reach
    return result


def _at_rest(x: float, y: float) -> dict[str, float]:
    return {"x": x, "y": y, "theta": 0.0, "vx": 0.0, "vy": 0.0, "omega": 0.0}


def _first(spec: Spec) -> dict[str, float]:
    plate, track, kind = spec["plates"][0], spec["track"], spec["start"]
    low, (vx, vy) = low_side(plate), spec["velocity"]
    if kind == "flight":
        away = half_length(plate) + spec["height"]
        above = max(height_at(track, spec["at"] + away * i / 20.0) for i in range(-20, 21))
        return {"x": spec["at"], "y": above + away, "theta": spec["angle"], "vx": vx, "vy": vy, "omega": spec["omega"]}
    level = track["kind"] in ("line", "tiles", "shelf")
    walls = [support for support in spec["supports"] if support["kind"] == "wall"]
    if kind == "two_contacts" and track["kind"] == "wedge" and plate["kind"] == "disc":
        return _at_rest(0.0, plate["radius"] / cos(track["angle"]))
    if low is None or not level:
        return {}
    width = plate["radius"] if plate["kind"] == "disc" else plate["width"] / 2.0
    if kind == "two_contacts" and walls:
        return _at_rest(walls[0]["side"] * (walls[0]["place"] - width), low)
    spin = spec["omega"] if plate["kind"] == "disc" else 0.0
    return {**_at_rest(spec["at"], low), "vx": vx, "omega": spin}
