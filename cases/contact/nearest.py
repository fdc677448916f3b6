"""Where a plate off its track is nearest to it, over the whole of both curves: what a landing is looked for with."""

from __future__ import annotations

from math import copysign, cos, hypot, inf, pi, remainder, sin
from typing import Any, NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Piece
from ..curves.curve_samples import ROUNDING, CurveSamples, course, osculating_distances, squares
from ..curves.outline import sizes_of
from ..errors import DoesNotFit
from .element_pairs import SAME_PLACE, common_normals, nearest_on_elements, pairs_from
from .geometry import Contact, find
from .nearest_samples import (
    CurvesInPose,
    nearest_samples,
    opposite_samples,
    outline_samples,
    sample_gaps,
    samples_below,
)
from .nearest_track_point import nearest_track_point

# Newton's method has found the pair that the samples show if it is no more of their distances away from them.
NEIGHBOURS = 4.0
# Else the pair is looked for among samples as far to either side as this, in their distances, ever closer by this
# factor, so often at most; until they are so close, in parts of the plate's size: gaps are level there to rounding.
WINDOW, CLOSER, ROUNDS, LEVEL = 1.5, 8.0, 100, 1e-9
# Where no track is any more, m: squares of distances overflow there.
FARTHEST = 1e150
# Steps of Newton's method for a direction of the outline's tangent, from anywhere: of a circle the first is exact.
NEWTON = 32
# From so many times a closed track's size away it is a point: which of its points is the nearest drowns in rounding.
SIGHT = 1e12


class _Guess(NamedTuple):
    """A pair of samples of track and outline, how far they are apart along the track's normal (m), and how far the next
    samples are: in the two parameters, and both together in m."""

    xi1: float
    xi2: float
    apart: float
    width1: float
    width2: float
    spacing: float


def nearest(case: Any, x: float, y: float, theta: float) -> Contact | None:
    """`nearest_pair` of a case, whose start says where a track without ends is looked at."""
    return nearest_pair(case.track, case.plate.outline, x, y, theta, case.start.xi1)


def nearest_pair(track: Curve, outline: Curve, x: float, y: float, theta: float, xi1: float) -> Contact | None:
    """The pair of points of outline and track with the smallest gap (m, signed), or None if the nearest points of the
    track are ends of it or lie on ends of an open outline, or if it is out of sight: there is nothing to land on.

    `xi1`: a parameter of the track, near which one without ends is looked at first. Raises DoesNotFit if there is such
    a pair and it is not found.
    """
    scene = CurvesInPose(track, outline, x, y, theta, xi1)
    if max(abs(x), abs(y)) > FARTHEST or _out_of_sight(scene):
        return None
    if isinstance(track, Chain) or isinstance(outline, Chain):
        some = nearest_on_elements(track, outline, x, y, theta)
        return some[0] if some else None
    radius = sizes_of(outline).radius
    samples, guess = _of_disc(scene, radius) if radius is not None else (None, None)
    if samples is None or guess is None:
        samples, guess = _of_outline(scene)
    # A nearest sample of the outline is within `spacing` of the nearest pair, and may be above another ripple.
    most = inf if guess is None else guess.apart + guess.spacing
    among_ripples = _of_track(scene, samples, most)
    if among_ripples is not None and among_ripples.apart <= most:
        guess = among_ripples
    return None if guess is None else _refined(scene, guess)


def contacts(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[Contact]:
    """Pairs of nearest points of the track and each element of the outline, between the ends of both; where there are
    none, other pairs with a common normal, from which the pose is as well determined."""
    pose = (x, y, theta)
    if isinstance(track, Chain) or isinstance(outline, Chain):
        return nearest_on_elements(track, outline, *pose) or common_normals(track, outline, *pose)
    both = (track, track.elements[0]), (outline, outline.elements[0])
    nearest_ones = pairs_from(*both, pose, nearest_samples(track, outline, *pose)[:1])
    results = nearest_ones or pairs_from(*both, pose, opposite_samples(track, outline, *pose))
    return results or _equidistant(track, outline, *pose)


def _equidistant(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[Contact]:
    """The middle of a track whose normals all meet the outline's in this pose, as at the centre of a round bowl, where
    no nearest point is the only one; none on another track."""
    xi1 = 0.5 * sum(track.span)
    direction, xi2 = float(track.tangent_angle(xi1)) - theta, float(outline.span[0])
    for _ in range(NEWTON):
        off = remainder(direction - float(outline.tangent_angle(xi2)), 2.0 * pi)
        xi2 += off / float(outline.curvature(xi2) * outline.speed(xi2))
    (u, v), c, s = outline.point(xi2), cos(theta), sin(theta)
    away = np.array([x + c * u - s * v, y + s * u + c * v]) - track.point(xi1)
    aside, gap = float(away @ track.tangent(xi1)), float(away @ track.normal(xi1))
    size = abs(x) + abs(y) + outline.sizes[0]
    return [Contact(xi1, xi2, gap)] if abs(aside) <= SAME_PLACE * size and gap > 0.0 else []


def _of_track(scene: CurvesInPose, track: CurveSamples, most: float) -> _Guess | None:
    """The pair with the smallest gap among the points of the track, at most that (m); None if there is none, or if the
    track has no features that the outline's samples could miss."""
    outline = scene.outline
    if not scene.track.features or not outline.period:
        return None
    point = nearest_track_point(scene.track, track, outline, outline_samples(outline), scene.frame, most)
    if point is None:
        return None
    xi1, xi2, gap, width, spacing = point
    return _Guess(xi1, xi2, gap, width, spacing / float(outline.speed(xi2)), 2.0 * spacing)


def _refined(scene: CurvesInPose, guess: _Guess) -> Contact | None:
    """The pair that a guess shows; None if it lies at an end. Raises DoesNotFit if it is not found."""
    nearer: list[Contact] = []
    for _ in range(ROUNDS):
        pair, is_neighbour = _pair_from(scene, guess)
        if pair is not None and is_neighbour:
            if _at_an_end(scene, pair):
                return None
            return min([pair, *nearer], key=_gap)
        if pair is not None and pair.gap <= guess.apart and not _at_an_end(scene, pair):
            nearer.append(pair)
        if _at_an_end(scene, guess):
            return None
        if guess.spacing <= LEVEL * sizes_of(scene.outline).width:
            return min([Contact(*guess[:3]), *nearer], key=_gap)
        guess = _closer(scene, guess)
    pose = f"({scene.x:.6g}, {scene.y:.6g}), theta = {scene.theta:.6g}"
    raise DoesNotFit(f"the point of the track nearest to the pose {pose} is not found")


def _pair_from(scene: CurvesInPose, guess: _Guess) -> tuple[Contact | None, bool]:
    """What Newton's method finds from a pair of samples, and whether that is the pair which they show; None if it finds
    none, or one far from them.

    The foot on ripples of samples of the outline is as far away as these are apart, and may be on another ripple.
    """
    try:
        contact = find(scene.track, scene.outline, scene.x, scene.y, scene.theta, guess[:2])
    except DoesNotFit:
        return None, False
    along, around = abs(contact.xi1 - guess.xi1), abs(contact.xi2 - guess.xi2)
    away = along * float(scene.track.speed(guess.xi1))
    # A gap that differs by more than the samples are apart is another pair's, or that of no nearest pair at all.
    if abs(contact.gap - guess.apart) > guess.spacing or not around <= NEIGHBOURS * guess.width2:
        return None, False
    is_neighbour = along <= NEIGHBOURS * guess.width1
    return (contact, is_neighbour) if is_neighbour or away <= NEIGHBOURS * guess.spacing else (None, False)


def _gap(contact: Contact) -> float:
    return contact.gap


def _closer(scene: CurvesInPose, guess: _Guess) -> _Guess:
    """The nearest pair among closer samples around a pair; as far apart as before where it lies at their edge."""
    track, outline = scene.track, scene.outline
    xi1, xi2 = _window(track, guess.xi1, guess.width1), _window(outline, guess.xi2, guess.width2)
    there = scene.frame.place(outline.point(xi2).T)
    points, normals, bends, _ = course(track, xi1)
    feet = squares(there[:, None], points[None]).argmin(axis=1)
    apart = osculating_distances(there - points[feet], normals[feet], bends[feet])
    best = int(np.argmin(apart))
    foot = int(feet[best])
    inside = 0 < best < len(xi2) - 1 and 0 < foot < len(xi1) - 1
    inside = inside or bool(
        apart[best] >= guess.apart - ROUNDING * (abs(scene.x) + abs(scene.y) + sizes_of(outline).width)
    )
    widths = (width / CLOSER if inside else width for width in guess[3:])
    return _Guess(float(xi1[foot]), float(xi2[best]), float(apart[best]), *widths)


def _window(curve: Piece, middle: float, width: float) -> np.ndarray:
    """Parameters around one, as far as the curve goes."""
    count = int(2 * WINDOW * CLOSER) + 1
    low, high = middle - WINDOW * width, middle + WINDOW * width
    if curve.ends:
        low, high = max(low, curve.ends[0]), min(high, curve.ends[1])
    return np.linspace(low, high, count)


def _at_an_end(scene: CurvesInPose, pair: Contact | _Guess) -> bool:
    """Whether it lies at or beyond an end of track or outline."""
    return _ends(scene.track, pair.xi1) or _ends(scene.outline, pair.xi2)


def _ends(curve: Piece, parameter: float) -> bool:
    return curve.ends is not None and not curve.ends[0] < parameter < curve.ends[1]


def _out_of_sight(scene: CurvesInPose) -> bool:
    """Whether a closed track is so far away that it has no sides any more."""
    if not scene.track.period:
        return False
    px, py = scene.track.point(0.0)
    size = sizes_of(scene.track).width + sizes_of(scene.outline).width
    return hypot(scene.x - px, scene.y - py) > SIGHT * size


def _of_outline(scene: CurvesInPose) -> tuple[CurveSamples, _Guess | None]:
    """Samples of the track and the nearest pair with any outline; no pair if those of the track are ends of it."""
    outline, track, places, ends, apart = sample_gaps(scene)
    # Past an end of the track, the gap along its normal means nothing.
    best = int(np.argmin(np.where(ends, inf, apart)))
    return track, None if ends[best] else _pair(track, int(places[best]), outline, best, float(apart[best]))


def _of_disc(scene: CurvesInPose, radius: float) -> tuple[CurveSamples, _Guess | None]:
    """The same of a disc, which is as far from its track as its centre less its radius: one point is looked up and not
    all of its outline."""
    x, y, c, s = scene.frame
    track, places, ends = samples_below(scene, np.array([[x, y]]), (x, y, 0.0))
    if ends[0]:
        return track, None
    place, outline = int(places[0]), outline_samples(scene.outline)
    (px, py), (nx, ny) = track.points[place].tolist(), track.normals[place].tolist()
    u, v = outline.points.T
    against = int(np.argmin((c * nx + s * ny) * u + (c * ny - s * nx) * v))
    dx, dy = x - px, y - py
    apart = copysign(hypot(dx, dy), dx * nx + dy * ny) - radius
    return track, _pair(track, place, outline, against, apart)


def _pair(track: CurveSamples, place: int, outline: CurveSamples, on_outline: int, apart: float) -> _Guess:
    return _Guess(
        float(track.parameters[place]),
        float(outline.parameters[on_outline]),
        apart,
        float(track.widths[place]),
        float(outline.widths[on_outline]),
        float(track.spacings[place] + outline.spacings[on_outline]),
    )
