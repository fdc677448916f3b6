"""Supports: fixed curves that a plate may touch in addition to its track, each with its own friction and restitution.

A plate with pieces (a rod, a block) touches straight supports with its corners and round pieces only. The nearest
points of each such pair are unique in every pose, so that a solver can watch all of them for the whole motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import cos, inf, pi, sin
from typing import Any

import numpy as np

from . import effects as all_effects
from .chain import Chain
from .contact_names import TRACK
from .corner import Corner, Edge, Piece
from .curves import Curve
from .effects import CoulombFriction, Effect, Impact, RollingResistance
from .errors import BadValue, DoesNotFit, items
from .line_or_circle import as_line
from .moving_surface import Belt
from .nearest import nearest_samples
from .outline_features import features, sides
from .overlap import deepest_overlap, first_overlap, span
from .pair_effects import RESISTING, check_law, of_pair, own_effects_of, with_own
from .piece_contact import Chains, find
from .plate import Plate

# A plate overlaps a support where it begins if it lies deeper in it than this part of its size: far above rounding.
DEPTH = 1e-9
# A plate is behind a curve if the normal of the sample next to it points away from it by at least this (a cosine).
BEHIND = 0.1
# Newton's steps to the place of a line that is next to a plate; a line that is run through evenly takes one.
FOOT_STEPS = 8
# Samples at which the bend of a support is looked at.
HOLLOW_SAMPLES = 2_001
# Points of an outline by which overlaps of plates are seen, and how deep (in units of the reach): an arc is 1e-5 of its
# radius away from the chord of two points.
SAMPLES, SAMPLED_DEPTH = 721, 1e-4
# The centre of mass as a feature of the outline.
CENTRE = Corner(0.0, 0.0, 0.0, pi)
# Effects that a support may have of its own.
OWN = (*RESISTING, Impact, Belt)


@dataclass(frozen=True)
class Support:
    """A fixed curve that the plate may touch in addition to its track: a wall, the other side of a groove, a step.

    The plate lies on its left. `name` names its contacts: "plate/wall". `effects`: friction, rolling resistance and
    impact of these contacts instead of the case's: CoulombFriction or PerfectlyRough (neither: no friction),
    RollingResistance (not given: none), and Impact (not given: the case's). With effects=None they are as on the track.
    A Belt there is the support's own: that of the case is the track's alone. A Drive of the case moves the track with
    all supports. Raises BadValue.
    """

    curve: Curve
    name: str
    effects: tuple[Effect, ...] | None = None

    def __post_init__(self):
        if not isinstance(self.curve, Curve):
            raise BadValue(f"the curve of a Support is {self.curve!r}; give a Curve, such as library.line(pi/2)")
        name = self.name
        is_word = isinstance(name, str) and name.replace("_", "").replace("-", "").isalnum() and len(name) <= 30
        if not is_word or name == TRACK:
            raise BadValue(
                f'the name of a Support is {name!r}; give a word such as "wall" ("{TRACK}" is the case\'s track)'
            )
        if self.effects is None:
            return
        object.__setattr__(self, "effects", own_effects_of("Support", self.effects, OWN))

    def acting(self, of_case: tuple[Effect, ...]) -> tuple[Effect, ...]:
        """All effects at this support's contacts, given those of the case."""
        if self.effects is None:
            return tuple(effect for effect in items("effects", of_case) if not isinstance(effect, Belt))
        return with_own(of_case, self.effects, Belt)


def base_of(contact: str) -> str:
    """What a contact lies on, the name of a support, of the track or of another plate: "wall" of "plate/wall 2"."""
    return contact.partition("/")[2].partition(" ")[0]


def effects_at(case: Any, contact: str) -> tuple[Effect, ...]:
    """All effects at a contact, such as "plate/wall 2": those of the case, and those of its pair, or its support's own,
    in their places."""
    own = [support for support in case.supports if support.name == base_of(contact)]
    return of_pair(case, contact.partition(" ")[0], own[0].acting(case.effects) if own else case.effects)


def check_supports(case: Any) -> None:
    """Raise BadValue or DoesNotFit for supports that the case cannot have."""
    if not isinstance(case.supports, tuple):
        raise BadValue(f'supports is {case.supports!r}; give a tuple such as (Support(line(pi/2), "wall"),)')
    names = [TRACK]
    for support in case.supports:
        if not isinstance(support, Support):
            raise BadValue(f'{support!r} is no Support; give Support(curve, "name")')
        if support.name in names:
            raise BadValue(f"two supports have the name {support.name!r}; give each its own")
        names.append(support.name)
        all_effects.check_formula(support.acting(case.effects))
        check_law(case, f"support {support.name!r}", support.effects or ())


def has_belt(case: Any) -> bool:
    """Whether the surface of the track or of a support runs."""
    return any(isinstance(effect, Belt) for effect in _all_effects(case))


def has_rolling_resistance(case: Any) -> bool:
    """Whether the track or a support resists rolling."""
    return any(isinstance(effect, RollingResistance) for effect in _all_effects(case))


def has_slip_law(case: Any) -> bool:
    """Whether the friction of the track or of a support depends on the slip speed."""
    return any(isinstance(effect, CoulombFriction) and effect.by_speed for effect in _all_effects(case))


def _all_effects(case: Any) -> tuple[Effect, ...]:
    """The effects of a case, of its supports and of its pairs."""
    parts = (*case.supports, *case.pairs)
    return (*case.effects, *(effect for part in parts for effect in part.effects or ()))


def is_straight(curve: Curve) -> bool:
    """Whether a support is a straight line without ends."""
    return curve.domain is None and as_line(curve) is not None


@lru_cache(maxsize=256)
def is_hollow(curve: Curve) -> bool:
    """Whether a smooth support bends to its left everywhere, where the plate is: of an outline it touches corners and
    round pieces only. A line has no bend."""
    bend = np.asarray(curve.curvature(np.linspace(*curve.span, HOLLOW_SAMPLES)))
    return bool(np.all(bend > 0.0))


@lru_cache(maxsize=256)
def is_hill(curve: Curve) -> bool:
    """Whether a smooth support is closed and bends to its right everywhere, away from the plate: corners and edges of a
    convex polygon touch it, and the nearest points are unique."""
    bend = np.asarray(curve.curvature(np.linspace(*curve.span, HOLLOW_SAMPLES)))
    return bool(curve.period) and bool(np.all(bend < 0.0))


def check_start(case: Any, x: float, y: float, theta: float) -> None:
    """Raise DoesNotFit if the plate overlaps a support where the motion begins."""
    for support in case.supports:
        check_side(support, "the plate", x, y)
        if overlaps(support.curve, case.plate, x, y, theta):
            raise DoesNotFit(f"the plate overlaps support {support.name!r} where it begins; give another start")


def check_side(support: Support, who: str, x: float, y: float) -> None:
    """Raise DoesNotFit for a plate whose centre lies on the right of a support, where it would go through."""
    curve = support.curve
    near = nearest_samples(curve, CENTRE, x, y, 0.0)[0][0]
    is_end = curve.ends is not None and near in curve.ends
    away = np.array([x, y]) - curve.point(near)
    if not is_end and float(away @ curve.normal(near)) < -BEHIND * float(np.hypot(*away)):
        raise DoesNotFit(
            f"{who} lies behind support {support.name!r} where it begins, on its right; give another start, or turn "
            "its curve round"
        )


def overlaps(curve: Curve, plate: Plate, x: float, y: float, theta: float) -> bool:
    """Whether a plate in a pose lies deeper than DEPTH behind a curve, whose free side is its left."""
    outline, c, s = plate.outline, cos(theta), sin(theta)
    line = as_line(curve)
    if line is not None and curve.domain is None:
        u, v = outline.point(outline.vertices(0.01) if isinstance(outline, Chain) else np.linspace(*outline.span, 721))
        points = np.array([x + c * u - s * v, y + s * u + c * v])
        normal, near = np.array([-line.direction[1], line.direction[0]]), curve.span[0]
        is_deep = float((normal @ (points - line.point[:, None])).min()) < -DEPTH * plate.reach
        for _ in range(FOOT_STEPS):
            near += float((np.array([x, y]) - curve.point(near)) @ line.direction) / float(curve.speed(near))
    elif isinstance(curve, Chain):
        return bool(enters(curve, outline, x, y, theta))
    else:
        near = nearest_samples(curve, CENTRE, x, y, theta)[0][0]
        px, py, angle, at = (np.array([value]) for value in (x, y, theta, near))
        is_deep = first_overlap(curve, outline, px, py, angle, at) is not None
        is_deep |= isinstance(outline, Chain) and _crosses(curve, outline, x, y, theta)
    deepest = None if is_deep else deepest_overlap(curve, outline, x, y, theta, near)
    return is_deep or (deepest is not None and deepest.depth > DEPTH * plate.reach)


def cover(one: Plate, other: Plate, x: float, y: float, theta: float) -> bool:
    """Whether a plate in a pose in the frame of `one` has points deeper inside that, or the other way round, than
    SAMPLES points of both outlines show."""
    c, s = cos(theta), sin(theta)
    own, further = (_samples(plate.outline) for plate in (one, other))
    u, v = further
    placed = np.array([x + c * u - s * v, y + s * u + c * v])
    return _any_inside(own, placed, one.reach) or _any_inside(placed, own, other.reach)


def _samples(outline: Curve) -> np.ndarray:
    if isinstance(outline, Chain):
        return np.asarray(outline.point(outline.vertices(0.001)))
    return np.asarray(outline.point(np.linspace(*outline.span, SAMPLES)))


def _any_inside(closed: np.ndarray, points: np.ndarray, reach: float) -> bool:
    """Whether a point (2, n) is deep inside a closed line of points (2, m), by the number of its edges on one side."""
    (ax, ay), (bx, by) = closed, np.roll(closed, -1, axis=1)
    x, y = points[0][:, None], points[1][:, None]
    spans = (ay > y) != (by > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        left = x < ax + (y - ay) * (bx - ax) / (by - ay)
    inside = (spans & left).sum(axis=1) % 2 == 1
    if not inside.any():
        return False
    u, v, dx, dy = x[inside] - ax, y[inside] - ay, bx - ax, by - ay
    along = np.clip((u * dx + v * dy) / np.maximum(dx * dx + dy * dy, 1e-300), 0.0, 1.0)
    return bool(np.hypot(u - along * dx, v - along * dy).min(axis=1).max() > SAMPLED_DEPTH * reach)


def enters(curve: Curve, outline: Curve, x: float, y: float, theta: float) -> bool:
    """Whether a corner of a curve or of an outline lies deep inside the other, in a pose."""
    near = np.array([nearest_samples(curve, CENTRE, x, y, theta)[0][0]])
    reach = 1.01 * float(np.hypot(*outline.point(np.linspace(*outline.span, 721))).max())
    return Chains(curve, outline, *span(curve, near, reach)).entry(x, y, theta) is not None


def _crosses(curve: Curve, outline: Curve, x: float, y: float, theta: float) -> bool:
    """Whether a feature of an outline lies on the right of a curved support, and the centre of mass on its left."""
    away, *gaps = [_gap(curve, piece, x, y, theta) for piece in (CENTRE, *features(outline))]
    if is_hill(curve):
        gaps += [_gap(curve, piece, x, y, theta) for piece in sides(outline) if isinstance(piece, Edge)]
    return away > 0.0 and min(gaps) < -DEPTH * outline.sizes[0]


def _gap(curve: Curve, piece: Piece, x: float, y: float, theta: float) -> float:
    """The distance of the nearest points of a support and a feature, m; infinite where there are none, and for an edge
    whose nearest point is beyond its ends or that has the centre of mass on the support's side."""
    try:
        near = nearest_samples(curve, piece, x, y, theta)[0]
        xi1, xi2, gap = find(curve, piece, x, y, theta, near)
    except DoesNotFit:
        return inf
    low, high = piece.span
    is_side = not isinstance(piece, Edge) or (
        low <= xi2 <= high and float((np.array([x, y]) - curve.point(xi1)) @ curve.normal(xi1)) > 0.0
    )
    return gap if is_side else inf
