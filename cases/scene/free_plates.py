"""Free plates: further plates of a case, each of which moves by itself and touches the others, the track and supports.

Of discs and at most one convex polygon on straight lines without ends the contacts have closed forms: each disc and
each corner has one with each line in every pose, and each disc with every other plate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from .. import effects as all_effects
from ..contact.outline_features import is_arc
from ..contact.overlap_search import OVERLAPS, overlaps
from ..contact.polygon_features import (
    TouchCircle,
    circles,
    is_polygon,
    local_centre,
    polygon_distance,
    size_of_plate,
)
from ..curves import Curve
from ..curves.backwards import backwards
from ..curves.chain import Chain
from ..curves.line_or_circle import Line, as_line
from ..effects import Drive, E, Effect, Load
from ..errors import BadValue, DoesNotFit, NotSupported
from .contact_names import FIRST, TRACK, check_word, contact_name
from .pair_effects import check_law
from .plate import Plate, contains, is_convex
from .start_pose import StartPose
from .supports import Support, check_side, effects_at, is_straight

# Pose and velocities of a plate, in the order of rows.
POSE = ("x", "y", "theta", "vx", "vy", "omega")


@dataclass(frozen=True)
class FreePlate:
    """A further plate of a case: its pose and velocities at time zero, a name for its contacts, such as "upper/plate"
    or "upper/track", and a load of its own. The Load of the case acts on the case's own plate. Raises BadValue."""

    plate: Plate
    start: StartPose
    name: str
    load: Load | None = None

    def __post_init__(self):
        if not isinstance(self.plate, Plate) or not isinstance(self.start, StartPose):
            raise BadValue(
                f"FreePlate was given {self.plate!r} and {self.start!r}; give a plate such as disc(0.1, 1.0), and "
                "StartPose(x, y)"
            )
        check_word("FreePlate", self.name, "upper", FIRST, TRACK)


class PlateContact(NamedTuple):
    """A contact that plates may have: its name, the number of its plate (0: the case's plate), that of the plate on
    whose boundary it lies or that support's line, the effects between them, and the circle of its plate that touches:
    a disc or a corner. Of the plate on whose boundary it lies: the radius of a disc, m, or the corners of a polygon."""

    name: str
    body: int
    base: int | None
    line: Line | None
    curve: Curve | None
    effects: tuple[Effect, ...]
    circle: TouchCircle
    base_radius: float = 0.0
    around: tuple[TouchCircle, ...] = ()

    def effect(self, kind: type[E]) -> E | None:
        """The effect of that kind, or None."""
        return all_effects.one(self.effects, kind)


def plates_of(case: Any) -> tuple[Plate, ...]:
    """All plates of a case."""
    return (case.plate, *(other.plate for other in case.others))


def loads_of(case: Any) -> tuple[Load | None, ...]:
    """The loads of all plates."""
    return (case.effect(Load), *(other.load for other in case.others))


def names_of(case: Any) -> tuple[str, ...]:
    """The names of all plates."""
    return (FIRST, *(other.name for other in case.others))


@lru_cache(maxsize=256)
def why_not_closed_forms(case: Any) -> str:
    """Why the contacts of several plates are not those of `plate_contacts`, in a phrase; "" if they are: of discs and
    at most one convex polygon on straight lines."""
    polygons = [name for name, plate in zip(names_of(case), plates_of(case), strict=True) if is_polygon(plate)]
    if len(polygons) > 1:
        return f"{polygons[0]!r} and {polygons[1]!r} are polygons"
    for name, plate in zip(names_of(case), plates_of(case), strict=True):
        is_disc = plate.radius is not None and is_arc(plate.outline)  # run through evenly
        if not is_disc and not is_polygon(plate):
            return f"{name!r} is no disc and no convex polygon"
    for name, curve in ((TRACK, case.track), *((s.name, s.curve) for s in case.supports)):
        if not is_straight(curve):
            return f"{name!r} is no straight line without ends"
    return ""


def why_not_convex(case: Any) -> str:
    """Why several plates are no smooth convex outlines on straight lines, nor those of `plate_contacts`, in a phrase;
    "" if they are."""
    if any(isinstance(plate.outline, Chain) or not is_convex(plate.outline) for plate in plates_of(case)):
        return why_not_closed_forms(case)
    curves = ((TRACK, case.track), *((s.name, s.curve) for s in case.supports))
    bent = next((name for name, curve in curves if not is_straight(curve)), "")
    return f"{bent!r} is no straight line without ends" if bent else ""


@lru_cache(maxsize=256)
def plate_contacts(case: Any) -> tuple[PlateContact, ...]:
    """All contacts that the plates of a case may have: with the track, each support, and each other. Those of a
    polygon's corners with a line are numbered in the outline's order; a disc's with a polygon lies on the polygon.
    Raises NotSupported for other shapes (`why_not_closed_forms`)."""
    if reason := why_not_closed_forms(case):
        raise NotSupported(f"contacts of several plates have closed forms for discs, one polygon and lines; {reason}")
    names, plates, contacts = names_of(case), plates_of(case), list[PlateContact]()
    supports = ((TRACK, case.track), *((s.name, s.curve) for s in case.supports))
    for body, name in enumerate(names):
        for support, curve in supports:
            acting = effects_at(case, f"{name}/{support}")
            for i, circle in enumerate(circles(plates[body])):
                contact = contact_name(name, support, i + 1)
                contacts.append(PlateContact(contact, body, None, as_line(curve), curve, acting, circle))
        for other in range(body):
            own, base = (body, other) if plates[body].radius is not None else (other, body)
            (circle,) = circles(plates[own])
            name, size = f"{names[own]}/{names[base]}", size_of_plate(plates[base])
            around = circles(plates[base]) if plates[base].radius is None else ()
            contacts.append(PlateContact(name, own, base, None, None, effects_at(case, name), circle, size, around))
    return tuple(contacts)


def start_poses(case: Any) -> np.ndarray:
    """(x, y, θ, vx, vy, ω) of every plate at time zero, as the track sees it, shape (plates, 6)."""
    first, drive = case.start.motion(case.track, case.plate.outline), case.effect(Drive)
    own = np.array([_row(s) for s in (first, *(other.start for other in case.others))], dtype=float)
    if drive is not None:
        place = drive.at(0.0)
        x, y, theta, vx, vy, omega = own[1:].T
        x, y, vx, vy, omega = place.seen_from_track(x, y, vx, vy, omega)
        own[1:] = np.array([x, y, theta - place.angle, vx, vy, omega]).T
        own[0, 5] -= place.spin
    return own


def _row(start: Any) -> tuple[float, ...]:
    return start.x, start.y, start.theta, start.vx, start.vy, start.omega


def gap_of(contact: PlateContact, poses: np.ndarray | list[list[float]]) -> float:
    """The distance between the curves of a contact, m; `poses` (plates, 3 or more) begin with (x, y, θ). Lists are
    faster than an array."""
    body, radius = poses[contact.body], contact.circle.radius
    arm = contact.circle.arm(float(body[2]))
    x, y = float(body[0]) + arm[0], float(body[1]) + arm[1]
    if contact.base is not None:
        base, around = poses[contact.base], contact.around
        if around:
            return polygon_distance(around, *map(float, local_centre(base, x, y))) - radius
        return hypot(x - float(base[0]), y - float(base[1])) - radius - contact.base_radius
    line = contact.line
    assert line is not None
    (px, py), (tx, ty) = line.point.tolist(), line.direction.tolist()
    return float((y - py) * tx - (x - px) * ty) - radius


def check_parts(case: Any) -> None:
    """Raise BadValue for supports and free plates that the case cannot have."""
    taken = {TRACK}
    for what, parts, kind, example in (
        ("supports", case.supports, Support, 'Support(curve, "name")'),
        ("others", case.others, FreePlate, 'FreePlate(plate, StartPose(x, y), "name")'),
    ):
        if not isinstance(parts, tuple):
            raise BadValue(f"{what} is {parts!r}; give a tuple such as ({example},)")
        for part in parts:
            if not isinstance(part, kind):
                raise BadValue(f"{part!r} is no {kind.__name__}; give {example}")
            if part.name in taken:
                raise BadValue(f"two supports or plates have the name {part.name!r}; give each its own")
            taken.add(part.name)
    for support in case.supports:
        all_effects.check_formula(support.acting(case.effects))
        check_law(case, f"support {support.name!r}", support.effects or ())


def _holds_centre(one: Plate, other: Plate, x: float, y: float) -> bool:
    """Whether a plate's centre, at a place in another one's frame, is inside that: a small plate may lie wholly in it,
    where no points of both outlines are nearest."""
    are_closed = one.outline.period and other.outline.period
    return bool(are_closed and other.encloses_centre and contains(one.outline, ((x, y),)))


def check_places(case: Any) -> None:
    """Raise DoesNotFit if plates overlap each other or a support, or lie behind one, where the motion begins."""
    names, plates, poses = names_of(case), plates_of(case), start_poses(case)
    for name, (x, y, *_) in zip(names, poses.tolist(), strict=True):
        for support in case.supports:
            check_side(support, repr(name) if case.others else "the plate", x, y)
    if case.others and not why_not_closed_forms(case):
        for contact in plate_contacts(case):
            gap = gap_of(contact, poses)
            if gap < -OVERLAPS * size_of(poses, tuple(map(size_of_plate, plates))):
                raise DoesNotFit(f"{contact.name} overlap by {-gap:.6g} m where they begin; give another StartPose")
        return
    fixed = {support.name: support.curve for support in case.supports} | ({TRACK: case.track} if case.others else {})
    for b, plate in enumerate(plates):
        x, y, theta, *_ = poses[b].tolist()
        bases = [name for name, curve in fixed.items() if overlaps(curve, plate.outline, x, y, theta)]
        for a, base in enumerate(plates[:b]):
            u, v = local_centre(poses[a], x, y)
            turn, is_near = theta - float(poses[a, 2]), hypot(u, v) <= plate.reach + base.reach
            is_inside = _holds_centre(base, plate, float(u), float(v)) or _holds_centre(
                plate, base, *map(float, local_centre(poses[b], *poses[a, :2].tolist()))
            )
            if is_near and (is_inside or overlaps(backwards(base.outline), plate.outline, float(u), float(v), turn)):
                bases.append(names[a])
        if bases:
            both, alone = f"{names[b]}/{bases[0]} overlap where they begin", f"the plate overlaps support {bases[0]!r}"
            raise DoesNotFit(f"{both if case.others else alone + ' where it begins'}; give another start")


def size_of(poses: np.ndarray, radii: tuple[float, ...]) -> float:
    """The size of the poses' numbers, m."""
    return float(np.abs(poses[:, :2]).max() + max(radii))
