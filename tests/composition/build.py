"""A case of a drawn scene, by public names of the suite only: the same file makes it in every build of the suite."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, inf, pi, sin
from typing import Any

from cases import (
    Belt,
    Case,
    CaseError,
    Chain,
    ContactEffect,
    ContactForce,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    FreePlate,
    Gravity,
    Impact,
    Load,
    Outline,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    StartPose,
    Support,
    Unilateral,
    arc,
    disc,
    library,
)

from .draw import REACH, G, Spec, draw

# Scenes of a seed that are drawn until one begins where it can: of those of one in ten seeds the first does not.
ATTEMPTS = 10


@dataclass(frozen=True)
class Magnet(ContactEffect):
    """An effect of a package: it pulls the plate to its track with `pull` (N)."""

    pull: float

    def force(self) -> ContactForce:
        return ContactForce(across=-self.pull)


def first_scene(seed: int) -> Case:
    """The first scene of a seed that begins where it can; raises CaseError where none does."""
    for attempt in range(ATTEMPTS - 1):
        try:
            return scene(draw(seed, attempt))
        except CaseError:
            continue
    return scene(draw(seed, ATTEMPTS - 1))


def scene(spec: Spec) -> Case:
    """The case of a drawn scene; raises CaseError where the build of the suite has no such scene."""
    plates = [plate(one) for one in spec["plates"]]
    first, others = spec["poses"][0], zip(plates[1:], spec["poses"][1:], strict=True)
    curve = track(spec["track"])
    return Case(
        track=curve,
        plate=plates[0],
        effects=effects(spec["effects"]),
        start=StartPose(**first) if first else on_track(spec, curve),
        duration=spec["duration"],
        name=f"composed_{spec['seed']}",
        supports=tuple(support(one, f"support{i}") for i, one in enumerate(spec["supports"], start=1)),
        others=tuple(FreePlate(one, StartPose(**pose), f"other{i}") for i, (one, pose) in enumerate(others, start=1)),
    )


def on_track(spec: Spec, curve: Curve) -> Start:
    """The first plate on its track, by parameters: a side in its middle, a smooth outline at angle 0."""
    kind, plate = spec["track"]["kind"], spec["plates"][0]
    places = {"circle": -pi / 2 + spec["at"], "wedge": REACH / cos(spec["track"].get("angle", 0.0)) + 0.5}
    xi1 = places.get(kind, spec["at"] if curve.domain is None or curve.domain[0] < 0.0 else sum(curve.domain) / 2.0)
    if plate["kind"] in ("disc", "ellipse", "egg"):
        return Start(xi1, slip=spec["velocity"][0], omega=0.0 if plate["fixed"] else spec["omega"])
    return Start(xi1, xi2=side(plate), slip=spec["velocity"][0])


def side(plate: Spec) -> float:
    """The outline's parameter in the middle of its first side."""
    if "points" in plate:
        (x, y), (u, v) = plate["points"][:2]
        return float(((u - x) ** 2 + (v - y) ** 2) ** 0.5) / 2.0
    if "height" in plate:
        return (plate["width"] - 2.0 * plate.get("radius", 0.0)) / 2.0
    return 0.1


def track(spec: Spec) -> Curve:
    """The track of a drawn scene; the plate is on its left."""
    kind = spec["kind"]
    if kind in ("line", "incline"):
        return library.line(spec.get("slope", 0.0))
    if kind == "parabola":
        return Curve(("s", f"{spec['bend']!r}*s**2"), (-REACH, REACH))
    if kind == "wave":
        return Curve(("s", f"{spec['height']!r}*sin({spec['number']!r}*s)"), (-REACH, REACH))
    if kind in ("circle", "hill"):
        return getattr(library, kind)(spec["radius"])
    if kind == "points":
        return Curve.spline(spec["points"])
    if kind == "shelf":
        return Curve(("s", "0"), (-REACH, spec["end"]))
    return _chain(spec)


def _chain(spec: Spec) -> Chain:
    if spec["kind"] == "polyline":
        return Chain.polyline(spec["points"])
    if spec["kind"] == "tiles":
        count = int(2.0 * REACH / spec["length"])
        return Chain.polyline([(-REACH + i * spec["length"], 0.0) for i in range(count + 1)])
    if spec["kind"] == "step":
        x, h = spec["place"], spec["height"]
        return Chain.polyline([(-REACH, 0.0), (x, 0.0), (x, h), (REACH, h)])
    a = spec["angle"]
    x, y = REACH * cos(a), REACH * sin(a)
    if spec["kind"] == "wedge":
        return Chain.polyline([(-x, y), (0.0, 0.0), (x, y)])
    r = spec["radius"]  # two straight flanks that an arc joins smoothly
    flank = Curve((f"{-r * sin(a) - x!r} + s*{cos(a)!r}", f"{r * (1.0 - cos(a)) + y!r} - s*{sin(a)!r}"), (0.0, REACH))
    other = Curve((f"{r * sin(a)!r} + s*{cos(a)!r}", f"{r * (1.0 - cos(a))!r} + s*{sin(a)!r}"), (0.0, REACH))
    return Chain([flank, arc((0.0, r), r, -pi / 2 - a, -pi / 2 + a), other])


def plate(spec: Spec) -> Plate:
    """A homogeneous plate of a drawn scene."""
    kind, mass = spec["kind"], spec["mass"]
    if kind == "disc":
        result = disc(spec["radius"], mass)
    elif kind == "ellipse":
        result = Plate.homogeneous(library.ellipse(spec["a"], spec["b"]), mass)
    elif kind == "egg":
        r, p = spec["radius"], spec["point"]
        places = [2.0 * pi * i / 24.0 for i in range(25)]
        points = [(r * (1.0 + p * cos(t)) * cos(t), r * (1.0 + p * cos(t)) * sin(t)) for t in places[:-1]]
        result = Plate.homogeneous(Curve.spline([*points, points[0]], closed=True), mass)
    elif kind in ("rectangle", "rounded"):
        result = Plate.rectangle(spec["width"], spec["height"], mass, radius=spec.get("radius", 0.0))
    elif kind == "half_disc":
        result = Plate.half_disc(spec["radius"], mass)
    elif kind == "reuleaux":
        result = Plate.reuleaux(spec["width"], mass)
    else:
        result = Plate.homogeneous(Outline.polygon(spec["points"]), mass)
    return replace(result, inertia=inf) if spec["fixed"] else result


def support(spec: Spec, name: str) -> Support:
    """A support next to the scene: a wall, an incline, or a curve that bends to the plate's side or away from it."""
    right, x = spec["side"] > 0.0, spec["side"] * spec["place"]
    c, s = (0.0, 1.0) if spec["kind"] == "wall" else (cos(spec["slope"]), sin(spec["slope"]))
    if spec["kind"] in ("wall", "incline"):  # a straight line through (x, 0)
        upward = 1.0 if right else -1.0
        curve: Curve = Curve((f"{x!r} + s*{c!r}", f"{upward!r}*s*{s!r}"))
    elif spec["kind"] == "parabola":
        curve = Curve((f"s + {x!r}", "s**2"), (-REACH, REACH))
    elif spec["kind"] == "circle":  # the outside of a round post
        curve = Curve((f"{x!r} + 0.2*sin(s)", "0.3 + 0.2*cos(s)"))
    else:
        ends = [(x, 0.0), (x + spec["side"] * 0.5, 0.3), (x + spec["side"] * 0.6, 1.5)]
        curve = Chain.polyline(ends if right else ends[::-1])
    own: tuple[Any, ...] | None = None
    if "mu" in spec:
        own = (CoulombFriction(spec["mu"]),) if spec["mu"] else ()
    return Support(curve, name, effects=own)


def effects(spec: Spec) -> tuple:
    """The effects of a drawn scene."""
    friction, load, motion = spec["friction"], spec["load"], spec["motion"]
    mu, a, w = friction["mu"], load["size"], load["number"]
    b, n = motion["size"], motion["number"]
    parts: list[Any] = [Gravity(G)]
    parts += {
        "none": [],
        "coulomb": [CoulombFriction(mu)],
        "static": [CoulombFriction(mu, mu_static=1.3 * mu)],
        "by_speed": [CoulombFriction(f"{mu!r} + {0.5 * mu!r}*exp(-v/0.1) + 0.02*v")],
        "rough": [PerfectlyRough()],
    }[friction["kind"]]
    parts += [Unilateral()] if spec["unilateral"] else []
    parts += [Flight()] if spec["flight"] and spec["unilateral"] else []
    lands = spec["impact"] != "none" and spec["flight"] and spec["unilateral"]
    parts += [Impact(spec["restitution"], spec["impact"])] if lands else []
    parts += [RollingResistance(spec["resistance"])] if spec["resistance"] else []
    parts += [Magnet(spec["own"])] if spec["own"] else []
    parts += {
        "none": [],
        "constant": [Load(fx=a)],
        "periodic": [Load(fx=f"{a!r}*sin({w!r}*t)", fy=f"{0.5 * a!r}*cos({w!r}*t)")],
        "spring": [Load(fx=f"-{4.0 * a!r}*x")],
        "drag": [Load(fx=f"-{0.2 * a!r}*vx", fy=f"-{0.2 * a!r}*vy", moment=f"-{0.002 * a!r}*omega")],
    }[load["kind"]]
    parts += {
        "none": [],
        "belt": [Belt(b)],
        "belt_in_time": [Belt(f"{b!r}*sin({n!r}*t)")],
        "shaken": [Drive(y=f"{0.02 * b!r}*sin({n!r}*t)")],
        "tilted": [Drive(angle=f"-{0.3 * b!r}*t")],
    }[motion["kind"]]
    return tuple(parts)
