"""Where a plate off its track is nearest to it, over the whole of both curves: what a landing is looked for with."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import ceil, copysign, cos, hypot, inf, log2, pi, remainder, sin
from typing import Any, NamedTuple

import numpy as np

from ..curves import Curve
from ..curves.chain import Chain
from ..curves.corner import Corner, Piece
from ..curves.curve_samples import MOST, ROUNDING, CurveSamples, course, osculating_distances, squares
from ..curves.element import Element
from ..curves.outline import sizes_of
from ..errors import DoesNotFit
from .geometry import Contact
from .nearest_track_point import PlateFrame, nearest_track_point
from .piece_contact import find

# Number of samples of the outline: so dense that a smooth outline is unlikely to have a nearer point between two of
# them. Newton's method starts at the nearest sample.
OUTLINE_POINTS = 128
# Points of a piece of a chain: a piece is a simple curve.
PIECE_POINTS = 65
# Points of the track to a size of the plate.
POINTS_A_SIZE = 24
# A track without ends is looked at for at least so many sizes of the plate to either side of the start; while the plate
# is nearest to an end of that, for twice as many, so often at most.
AROUND, DOUBLINGS = 16.0, 40
# Around a corner alone samples of a track with ends are about this part of its size apart, times POINTS_A_SIZE.
PARTS = 32
# Newton's method has found the pair that the samples show if it is no more of their distances away from them.
NEIGHBOURS = 4.0
# Else the pair is looked for among samples as far to either side as this, in their distances, ever closer by this
# factor, so often at most; until they are so close, in parts of the plate's size: gaps are level there to rounding.
WINDOW, CLOSER, ROUNDS, LEVEL = 1.5, 8.0, 100, 1e-9
# Where no track is any more, m: squares of distances overflow there.
FARTHEST = 1e150
# A pair at an end of a track may be beyond it by this part of the track, a rounding, and normals meet within it, in
# parts of the plate's size and place.
SAME_PLACE = 1e-12
# Steps of Newton's method for a direction of the outline's tangent, from anywhere: of a circle the first is exact.
NEWTON = 32
# From so many times a closed track's size away it is a point: which of its points is the nearest drowns in rounding.
SIGHT = 1e12


class _Scene(NamedTuple):
    """A track and an outline in a pose, and a parameter of the track near which a track without ends is looked at."""

    track: Curve
    outline: Piece
    x: float
    y: float
    theta: float
    xi1: float

    @property
    def frame(self) -> PlateFrame:
        return PlateFrame(self.x, self.y, cos(self.theta), sin(self.theta))

    @property
    def size(self) -> float:
        """What the track's samples are close to, m: the outline's size; pieces and corners of an outline share those of
        another size."""
        if self.outline.period:
            return sizes_of(self.outline).width
        if self.track.domain is not None or self.track.period:
            return sizes_of(self.track).width / PARTS
        reach = float(np.hypot(*self.outline.point(self.outline.span[0])))
        away = hypot(*(self.track.point(self.xi1) - (self.x, self.y))) + reach
        return 2.0 ** ceil(log2(away)) if away else 1.0  # few sizes, as samples are kept

    def find(self, near: tuple[float, float]) -> Contact:
        """What Newton's method finds from a pair. Raises DoesNotFit."""
        return find(self.track, self.outline, self.x, self.y, self.theta, near)


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
    scene = _Scene(track, outline, x, y, theta, xi1)
    if max(abs(x), abs(y)) > FARTHEST or _out_of_sight(scene):
        return None
    if isinstance(track, Chain) or isinstance(outline, Chain):
        return _of_pieces(scene)
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


def nearest_samples(track: Curve, outline: Piece, x: float, y: float, theta: float) -> list[tuple[float, float]]:
    """Parameters of samples of a track and an outline, or a corner of one, that are nearest to each other in a pose:
    each pair with a smaller gap than its neighbours, the one with the least gap along the track's normal first."""
    scene = _Scene(track, outline, x, y, theta, 0.5 * sum(track.span))
    if isinstance(outline, Corner):
        there = scene.frame.place(np.array([[outline.x, outline.y]]))
        samples, places, _ = _below(scene, there, (*there[0].tolist(), 0.0))
        return [(float(samples.parameters[places[0]]), 0.5 * sum(outline.span))]
    own, samples, places, _, gaps = _gaps(scene)
    before, behind = np.roll(gaps, 1), np.roll(gaps, -1)
    if not outline.period:
        before[0] = behind[-1] = inf
    least = np.flatnonzero((gaps <= before) & (gaps <= behind))
    order = least[np.argsort(gaps[least], kind="stable")]
    return list(zip(samples.parameters[places[order]].tolist(), own.parameters[order].tolist(), strict=True))


def opposite_samples(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[tuple[float, float]]:
    """Parameters near which a track and a smooth outline have a common normal in a pose, the pair with the least gap
    first: that of the nearest points, and others from which the same pose is as well determined."""
    scene = _Scene(track, outline, x, y, theta, 0.5 * sum(track.span))
    own, samples, *_ = _gaps(scene)
    there, normals = scene.frame.place(own.points), samples.normals
    lowest = np.argmin(normals @ there.T, axis=1)  # the point of the outline that is nearest along each normal
    away = there[lowest] - samples.points
    along, gaps = away[:, 0] * normals[:, 1] - away[:, 1] * normals[:, 0], (away * normals).sum(axis=1)
    changes = np.flatnonzero(along[:-1] * along[1:] <= 0.0)
    order = changes[np.argsort(gaps[changes], kind="stable")]
    return [(float(samples.parameters[k]), float(own.parameters[lowest[k]])) for k in order if gaps[k] > 0.0]


def contacts(track: Curve, outline: Curve, x: float, y: float, theta: float) -> list[Contact]:
    """Pairs of nearest points of the track and each element of the outline, between the ends of both; where there are
    none, other pairs with a common normal, from which the pose is as well determined."""
    pose, elements = (x, y, theta), outline.elements
    results = [one for each in elements for one in _on_element(track, outline, each, pose, nearest_samples)]
    if results or (isinstance(track, Chain) and not isinstance(outline, Chain)):
        return results
    further = opposite_samples if not isinstance(outline, Chain) else _below_middle
    results = [one for each in elements for one in _on_element(track, outline, each, pose, further)]
    return results if results or isinstance(outline, Chain) else _equidistant(track, outline, x, y, theta)


def _below_middle(track: Curve, piece: Piece, x: float, y: float, theta: float) -> list[tuple[float, float]]:
    """The parameter of the sample of a track that is nearest to the middle of a piece, and that middle."""
    middle = 0.5 * sum(piece.span)
    u, v = piece.point(middle).tolist()
    return [(nearest_samples(track, Corner(u, v, 0.0, 0.0), x, y, theta)[0][0], middle)]


def _on_element(
    track: Curve,
    outline: Curve,
    element: Element,
    pose: tuple[float, float, float],
    samples: Callable[..., list[tuple[float, float]]],
) -> list[Contact]:
    """The contacts on one element of the outline and on the track to which Newton's method goes from samples: of the
    nearest ones only from the first pair."""
    results, ends = list[Contact](), track.ends or (-inf, inf)
    for guess in samples(track, element.piece, *pose)[: 1 if samples is nearest_samples else None]:
        try:
            xi1, xi2, gap = find(track, element.piece, *pose, guess)
        except DoesNotFit:  # it ends nowhere, or an edge faces the track
            continue
        on_track, on_outline = min(max(xi1, ends[0]), ends[1]), _on_outline(outline, element, xi2)
        # At an end of the track the contact may be beyond it by a rounding.
        is_on_track = on_track == xi1 or abs(xi1 - on_track) <= SAME_PLACE * (ends[1] - ends[0])
        if is_on_track and on_outline is not None:
            results.append(Contact(on_track, on_outline, gap))
    return results


def _on_outline(outline: Curve, element: Element, xi2: float) -> float | None:
    """The parameter of an outline at that of its element; None beyond the element's ends."""
    if not isinstance(outline, Chain):
        return xi2
    (low, high), piece = element.span, element.piece
    turn = 2.0 * pi if isinstance(piece, Corner) else piece.period or inf
    # The parameter of the middle of the piece, within its own range to rounding.
    xi2 = xi2 - turn * round((xi2 - element.middle) / turn) if turn < inf else xi2
    if not low - SAME_PLACE <= xi2 <= high + SAME_PLACE:
        return None
    # At a joint a parameter may belong to the neighbour: a rounding keeps it on this element.
    first, last = element.start, element.start + (high - low)
    return min(max(xi2 + element.shift, float(np.nextafter(first, inf))), float(np.nextafter(last, -inf)))


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


def _of_pieces(scene: _Scene) -> Contact | None:
    """`nearest` where a curve has pieces or corners: the nearest of the pairs that `find` reaches from each piece of
    the track. Behind a piece the gap along its normal is negative, so the one with the least size is it."""
    track, outline = scene.track, scene.outline
    there = scene.frame.place(outline.point(own := np.linspace(*outline.span, OUTLINE_POINTS + 1)).T)
    contacts: list[Contact] = []
    for element in track.elements:
        along = np.linspace(*element.span, PIECE_POINTS) + element.shift
        apart = squares(there[:, None], track.point(along).T[None])
        on_outline, on_track = np.unravel_index(int(np.argmin(apart)), apart.shape)
        try:
            contact = scene.find((float(along[on_track]), float(own[on_outline])))
        except DoesNotFit:  # two corners, or two edges, face each other
            continue
        if not _at_an_end(scene, contact):
            contacts.append(contact)
    return min(contacts, key=lambda contact: abs(contact.gap), default=None)


def _of_track(scene: _Scene, track: CurveSamples, most: float) -> _Guess | None:
    """The pair with the smallest gap among the points of the track, at most that (m); None if there is none, or if the
    track has no features that the outline's samples could miss."""
    outline = scene.outline
    if not scene.track.features or not outline.period:
        return None
    point = nearest_track_point(scene.track, track, outline, _outline(outline), scene.frame, most)
    if point is None:
        return None
    xi1, xi2, gap, width, spacing = point
    return _Guess(xi1, xi2, gap, width, spacing / float(outline.speed(xi2)), 2.0 * spacing)


def _refined(scene: _Scene, guess: _Guess) -> Contact | None:
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


def _pair_from(scene: _Scene, guess: _Guess) -> tuple[Contact | None, bool]:
    """What Newton's method finds from a pair of samples, and whether that is the pair which they show; None if it finds
    none, or one far from them.

    The foot on ripples of samples of the outline is as far away as these are apart, and may be on another ripple.
    """
    try:
        contact = scene.find(guess[:2])
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


def _closer(scene: _Scene, guess: _Guess) -> _Guess:
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


def _at_an_end(scene: _Scene, pair: Contact | _Guess) -> bool:
    """Whether it lies at or beyond an end of track or outline."""
    return _ends(scene.track, pair.xi1) or _ends(scene.outline, pair.xi2)


def _ends(curve: Piece, parameter: float) -> bool:
    return curve.ends is not None and not curve.ends[0] < parameter < curve.ends[1]


def _out_of_sight(scene: _Scene) -> bool:
    """Whether a closed track is so far away that it has no sides any more."""
    if not scene.track.period:
        return False
    px, py = scene.track.point(0.0)
    size = sizes_of(scene.track).width + sizes_of(scene.outline).width
    return hypot(scene.x - px, scene.y - py) > SIGHT * size


def _of_outline(scene: _Scene) -> tuple[CurveSamples, _Guess | None]:
    """Samples of the track and the nearest pair with any outline; no pair if those of the track are ends of it."""
    outline, track, places, ends, apart = _gaps(scene)
    # Past an end of the track, the gap along its normal means nothing.
    best = int(np.argmin(np.where(ends, inf, apart)))
    return track, None if ends[best] else _pair(track, int(places[best]), outline, best, float(apart[best]))


def _gaps(scene: _Scene) -> tuple[CurveSamples, CurveSamples, np.ndarray, np.ndarray, np.ndarray]:
    """Samples of the outline and of the track, which of these are nearest to each of those, whether they are ends, and
    how far they are apart along the track's normal, m."""
    outline, frame = _outline(scene.outline), scene.frame
    there, ((x, y),) = frame.place(outline.points), frame.place(np.array([outline.ball[:2]])).tolist()
    track, places, ends = _below(scene, there, (x, y, outline.ball[2]))
    return outline, track, places, ends, track.off(there, places)


def _of_disc(scene: _Scene, radius: float) -> tuple[CurveSamples, _Guess | None]:
    """The same of a disc, which is as far from its track as its centre less its radius: one point is looked up and not
    all of its outline."""
    x, y, c, s = scene.frame
    track, places, ends = _below(scene, np.array([[x, y]]), (x, y, 0.0))
    if ends[0]:
        return track, None
    place, outline = int(places[0]), _outline(scene.outline)
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


def _below(
    scene: _Scene, there: np.ndarray, ball: tuple[float, float, float]
) -> tuple[CurveSamples, np.ndarray, np.ndarray]:
    """Samples of the track, which of them are nearest to the points `there` (within that circle), and whether these
    are its ends."""
    curve, size = scene.track, scene.size
    endless = curve.domain is None and not curve.period
    low, high = _around(scene, ball, size) if endless else curve.span
    for _ in range(DOUBLINGS):
        track = _track(curve, low, high, size)
        places = track.stretches.nearest(there, ball)
        last = len(track.parameters) - 1
        ends = np.zeros(len(places), dtype=bool) if curve.period else (places == 0) | (places == last)
        whole = not endless or (track.parameters[0] > low and track.parameters[-1] < high)
        if whole or not ends.any():
            break
        low, high = low - 0.5 * (high - low), high + 0.5 * (high - low)
    return track, places, ends


def _around(scene: _Scene, ball: tuple[float, float, float], size: float) -> tuple[float, float]:
    """The stretch of a track without ends that is looked at first: some sizes of the plate to either side of the start,
    as many times doubled as the plate is farther away."""
    xi1, (x, y, _) = scene.xi1, ball
    X, Y, Xp, Yp = scene.track.jet(xi1)[:4]
    away = hypot(x - X, y - Y) / (AROUND * size)
    margin = AROUND * size / hypot(Xp, Yp) * 2.0 ** ceil(log2(max(2.0 * away, 1.0)))
    return xi1 - margin, xi1 + margin


@lru_cache(maxsize=64)
def _outline(outline: Curve) -> CurveSamples:
    return CurveSamples.of(outline, *outline.span, OUTLINE_POINTS + 1)


@lru_cache(maxsize=64)
def _track(track: Curve, low: float, high: float, size: float) -> CurveSamples:
    length = track.length(low, high)
    return CurveSamples.of(track, low, high, int(min(MOST, max(720, POINTS_A_SIZE * length / size))))
