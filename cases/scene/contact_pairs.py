"""Pairs of a support and a feature of the outline: each is a case of its own with one smooth contact.

A motion with several contacts has one such pair for each; its track is the support's curve, its outline the feature,
and its effects are those of the support.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from math import cos, inf, pi, sin
from typing import NamedTuple, cast

import numpy as np

from ..contact import find
from ..contact.close_pairs import close_pairs, nearest_on
from ..contact.outline_features import ArcRange, arc_ranges, features, side_ranges, sides
from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner, Edge, turning
from ..curves.line_or_circle import as_line
from .case_class import Case
from .case_part import CasePart, with_outline
from .contact_names import FIRST
from .plate import is_convex
from .start import Start
from .start_pose import TOUCHES
from .supports import TRACK, Support, effects_at, is_hill, is_straight

# Newton's method for a guess on a line: quadratic, so that these are many, and how close the guess is to be.
MOST_STEPS, NEAR = 20, 1e-6
# Pairs of points are the same one if those on the support are closer than this part of the plate's size.
APART = 1e-6
# An edge whose gap is below minus this part of the plate's reach has a hill behind it: it does not overlap that much.
BEHIND = 1e-3
# Samples of a hill, of which one has nearly the direction of an edge.
HILL_SAMPLES = 2_000
# Parameters so many lengths of an edge away are not reached.
FAR = 1e6


class PairCase(CasePart):
    """A case whose track is one support and whose outline is one feature of that of `whole`.

    `number`: which of `pairs(whole)` it is; `first`: which is the first of the same support, of that name;
    `has_unique_points`: whether the nearest points are the only ones in every pose, so that the pair can be watched all
    the time; `arc_range`: where an arc, or an edge on a hill, is compared with the support, None if everywhere. It is
    made by `pairs`.
    """

    number: int
    first: int
    support: str
    has_unique_points: bool
    arc_range: ArcRange | None

    def __reduce__(self):
        return _pair, (self.whole, self.number)

    def guess(self, x: float, y: float, theta: float) -> tuple[float, float]:
        """Parameters near the nearest points in a pose; of several pairs of nearest points the ones with the least
        gap."""
        line, feature = as_line(self.track), self.plate.outline
        c, s = cos(theta), sin(theta)
        if isinstance(feature, Edge):
            return self._beside_edge(feature, x, y, theta)
        if line is None or self.track.domain is not None:
            centre, middle = self.centre, 0.5 * sum(feature.span)
            if centre is None and (some := close_pairs(self.track, feature, (x, y, theta))):
                return some[0][:2]
            u, v = (centre.x, centre.y) if centre is not None else (0.0, 0.0)
            xi1 = nearest_on(self.track, x + c * u - s * v, y + s * u + c * v)
            if isinstance(feature, Corner) or centre is None:
                return xi1, middle
            turn = float(self.track.tangent_angle(xi1)) - theta - float(feature.tangent_angle(middle))
            return xi1, middle + (turn - 2.0 * pi * round(turn / (2.0 * pi))) / turning(feature, middle)
        angle = float(np.arctan2(line.direction[1], line.direction[0])) - theta
        if isinstance(feature, Corner):
            point = np.array([x + c * feature.x - s * feature.y, y + s * feature.x + c * feature.y])
            xi2 = (angle - feature.start) % (2.0 * pi)
        elif isinstance(self.whole.plate.outline, Chain):
            middle = 0.5 * sum(feature.span)
            xi2 = middle + (angle - float(feature.tangent_angle(middle))) / turning(feature, middle)
            xi2 = self.in_round(xi2, self.is_away(xi2))
            u, v = feature.point(xi2)
            point = np.array([x + c * u - s * v, y + s * u + c * v])
        else:
            grid = np.linspace(*feature.span, 721)
            turns = (np.asarray(feature.tangent_angle(grid)) - angle) / (2.0 * pi)
            xi2 = float(grid[np.argmin(np.abs(turns - np.round(turns)))])
            u, v = feature.point(xi2)
            point = np.array([x + c * u - s * v, y + s * u + c * v])
        xi1 = float(self.track.span[0])
        for _ in range(MOST_STEPS):  # one step, unless the line's parameter runs unevenly
            step = float((point - self.track.point(xi1)) @ line.direction) / float(self.track.speed(xi1))
            xi1 += step
            if abs(step) <= NEAR * (1.0 + abs(xi1)):
                break
        return xi1, xi2

    def _beside_edge(self, edge: Edge, x: float, y: float, theta: float) -> tuple[float, float]:
        """Parameters of a hill's sample with the direction of an edge, and of that point's foot on the edge's line."""
        parameters = np.linspace(*self.track.span, HILL_SAMPLES)
        off = self.track.tangent_angle(parameters) - theta - float(edge.tangent_angle(0.0))
        number = int(np.argmin(np.abs(off - 2.0 * pi * np.round(off / (2.0 * pi)))))
        c, s = cos(theta), sin(theta)
        px, py = self.track.point(float(parameters[number])) - np.array([x, y])
        return float(parameters[number]), float(
            (np.array([c * px + s * py, c * py - s * px]) - edge.point(0.0)) @ edge.tangent(0.0)
        )

    def whole_xi2(self, xi2):
        """A parameter of the feature as one of the whole outline, numbers or arrays; it is counted on from round to
        round. Beyond the feature's own ends the result lies as far beyond them."""
        outline, feature = self.whole.plate.outline, self.plate.outline
        if not isinstance(outline, Chain):
            return xi2
        (element,) = [one for one in outline.elements if one.piece == feature]
        if isinstance(feature, Edge):
            return xi2 + element.shift
        middle = 0.5 * sum(feature.span)
        round_length = 2.0 * pi / turning(feature, middle)
        rounds = np.round((xi2 - middle) / round_length)
        return xi2 - rounds * round_length + element.shift + rounds * (outline.period or 0.0)

    def is_away(self, xi2: float) -> bool:
        """Whether an arc is turned away from the support: a parameter outside its range, in any round."""
        limits = self.arc_range
        return limits is not None and not limits.low <= self.in_round(xi2, False) < limits.high

    def away_in_pose(self, x: float, y: float, theta: float, points: tuple[float, float]) -> int:
        """Whether an arc or an edge is turned away from the support in a pose: 0 if it faces it. An edge is away where
        its nearest point lies before its start (-1) or beyond its end (1), or the support is behind it (2)."""
        if not isinstance(self.plate.outline, Edge):
            return int(self.is_away(points[1]))
        _, xi2, gap = find(self, x, y, theta, points)
        low, high = self.plate.outline.span
        return -1 if xi2 < low else 1 if xi2 >= high else self._behind(gap)

    def _behind(self, gap: float) -> int:
        """0 if an edge with that gap (m) faces the support, 2 if the support is behind it: more than a rounding."""
        return 0 if gap > -BEHIND * self.whole.plate.reach else 2

    def after_turn(self, is_away: int, xi2: float, gap: float) -> int:
        """What `away_in_pose` is after an arc or an edge has reached an end of its range, with that gap (m)."""
        if not isinstance(self.plate.outline, Edge):
            return int(not is_away)
        if is_away in (0, 2):
            return -1 if xi2 < 0.5 * sum(self.plate.outline.span) else 1
        return self._behind(gap)

    def in_round(self, xi2: float, is_away: bool) -> float:
        """A parameter of the feature in the round in which its range is, or what follows its end if it is away."""
        if isinstance(self.plate.outline, Edge):
            return xi2
        low, high = (self.arc_range.low, self.arc_range.high) if self.arc_range else self.plate.outline.span
        length = 2.0 * pi / turning(self.plate.outline, 0.5 * sum(self.plate.outline.span))
        middle = 0.5 * (low + high) + 0.5 * length * is_away
        return float(xi2 - length * np.round((xi2 - middle) / length))

    def limits_of_turn(self, is_away: int) -> tuple[float, float]:
        """The parameters between which an arc or an edge keeps facing the support, or stays turned away from it."""
        if self.arc_range is None:
            return -inf, inf
        if isinstance(self.plate.outline, Edge):
            low, high = self.plate.outline.span
            far = FAR * (high - low)
            return {-1: (low - far, low), 1: (high, high + far)}.get(is_away, (low, high))
        length = 2.0 * pi / turning(self.plate.outline, 0.5 * sum(self.plate.outline.span))
        low, high = self.arc_range.low, self.arc_range.high
        return (high, low + length) if is_away else (low, high)

    def successor(self, xi2: float) -> PairCase | None:
        """The pair to which a contact passes that leaves an arc at the end of its range next to a parameter."""
        assert self.arc_range is not None
        low, high, before, after = self.arc_range
        number = before if self.in_round(xi2, False) < 0.5 * (low + high) else after
        return None if number is None else pairs(self.whole)[self.first + number]

    @cached_property
    def centre(self) -> Corner | None:
        """A corner itself, or the centre of an arc, as a corner without an angle; None for a smooth outline."""
        feature = self.plate.outline
        if isinstance(feature, Corner) or not isinstance(self.whole.plate.outline, Chain):
            return feature if isinstance(feature, Corner) else None
        middle = 0.5 * sum(feature.span)
        x, y = feature.point(middle) + feature.normal(middle) / float(feature.curvature(middle))
        return Corner(float(x), float(y), 0.0, 0.0)

    @property
    def is_point_on_curve(self) -> bool:
        """Whether it is a corner or an arc on a curved support: its nearest points may jump, its distance does not."""
        return not self.has_unique_points and self.centre is not None

    def touching_points(self, x: float, y: float, theta: float) -> list[tuple[float, float]]:
        """Parameters of all pairs of nearest points without a gap in a pose, on the support and inside its ends."""
        points = list[tuple[float, float]]()
        least, (low, high) = TOUCHES * (abs(x) + abs(y) + self.whole.plate.reach), self.track.domain or (-inf, inf)
        for xi1, xi2, gap in close_pairs(self.track, self.plate.outline, (x, y, theta), least):
            if abs(gap) > least or not low <= xi1 <= high:
                continue
            places = [self.track.point(one) for one, _ in points]
            if all(np.hypot(*(place - self.track.point(xi1))) > APART * self.plate.reach for place in places):
                points.append((xi1, xi2))
        return points

    def gap(self, x: float, y: float, theta: float) -> float:
        """The distance of the nearest points in a pose, m. Raises DoesNotFit."""
        return find(self, x, y, theta, self.guess(x, y, theta)).gap


@lru_cache(maxsize=256)
def pairs(case: Case) -> tuple[PairCase, ...]:
    """All pairs of a support, the track first, and a feature of the outline."""
    every, outline = list[PairCase](), case.plate.outline
    for support in (Support(case.track, "_track"), *case.supports):
        on_hill = bool(sides(outline)) and is_hill(support.curve)
        some = sides(outline) if on_hill else features(outline)
        ranges = side_ranges(outline) if on_hill else arc_ranges(outline) if is_straight(support.curve) else None
        first = len(every)
        for index, feature in enumerate(some):
            limits = ranges[index] if ranges else None
            every.append(_make(case, support, cast(Curve, feature), first + index, first, on_hill, limits))
    return tuple(every)


class WatchedPair(NamedTuple):
    """A pair that is watched, parameters near its nearest points, and whether it is an arc that is turned away from the
    support."""

    pair: PairCase
    points: tuple[float, float]
    is_away: int


def pairs_in_pose(case: Case, x: float, y: float, theta: float) -> list[WatchedPair]:
    """The pairs with unique nearest points that are watched in a pose: all but the features next to an arc that faces
    the support, which touch after it has turned away."""
    unique = [(pair, pair.guess(x, y, theta)) for pair in pairs(case) if pair.has_unique_points]
    return facing_pairs([WatchedPair(pair, near, pair.away_in_pose(x, y, theta, near)) for pair, near in unique])


def facing_pairs(some: Sequence[WatchedPair]) -> list[WatchedPair]:
    """Those of some pairs that are not next to an arc of them that faces the support."""
    hidden = set[int]()
    for pair, _, is_away in some:
        if pair.arc_range is not None and not is_away:
            hidden |= {pair.first + number for number in pair.arc_range.neighbours}
    return [one for one in some if one.pair.number not in hidden]


def _make(
    whole: Case, support: Support, feature: Curve, number: int, first: int, on_hill: bool, limits: ArcRange | None
) -> PairCase:
    outline = whole.plate.outline
    is_track, is_feature = first == 0, isinstance(outline, Chain)
    middle = [0.5 * sum(piece.span) for piece in (support.curve, feature)]
    is_unique = is_straight(support.curve) and (is_feature or (is_convex(feature) and bool(whole.supports)))
    name = TRACK if is_track else support.name
    return PairCase.of(
        whole, (number,), track=support.curve, plate=with_outline(whole.plate, feature), supports=(), others=(),
        start=whole.start if is_track and not is_feature else Start(*middle), pairs=(),
        effects=effects_at(whole, f"{FIRST}/{name}"), number=number, first=first, support=name,
        has_unique_points=is_unique or on_hill, arc_range=limits,
    )  # fmt: skip


def _pair(whole: Case, number: int) -> PairCase:
    return pairs(whole)[number]
