"""The first meeting of a plate and a boundary at a place that is not watched, in a phase's dense output.

All pairs of elements of both curves are searched by boxes (`minimal.element_meetings`), but those in which the in_view
contact is the only one. Plates that are far apart are excluded by the circles around them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from cases import Case, DoesNotFit
from cases.chain import Element
from cases.corner import Corner
from cases.couples import Couple, couples
from cases.piece_case import PieceCase, _piece_case, neighbour

from ..minimal.boxes import Cores
from ..minimal.contact_cores import cores
from ..minimal.element_meetings import ElementSearch, elements, fine
from ..minimal.integrators.segment import Segment
from ..minimal.modes import Phase
from ..minimal.windows import EPS
from .places import couple_of, in_round, nearest
from .plate_numbers import bodies
from .regimes import AT_END, pair_of, regime_of
from .shapes import Poses, Shapes, Straight, first_closings, guess, shapes
from .system import COLUMNS
from .touching import bends, inside, pairs_that_touch
from .watched_plates import APART

# A corner that comes to a line with a flat side of its own: a few of the coarsest tolerance's errors of an angle, rad.
# Nothing else than the corner meets the line first, as lines do not meet lines.
AT_FLAT = 0.1
# Plates move between two samples by at most this many times what their speeds there say.
FASTER = 2.0
# Points of an element that say where it is.
ON_ELEMENT = 17
# Couples with more pairs of lines and circles than this are looked at before gaps are polynomials.
FEW = 8
# Samples of a step at which far plates are looked at.
LOOKS = 16
# A contact at the end of an element has no gap in the pair beside either: its search begins as soon as this part of
# a step later.
LATER = 0.0, 1e-9, 1e-6, 1e-3
SOON = 2.0 * LATER[-1]
# Places in a window at which a contact is sampled, and how far it may go beyond them, as a part of their range.
PLACES, BEYOND = np.linspace(0.0, 1.0, 5), 0.1
# Windows in which a contact is not proven to be the only one in its surroundings are halved at most this many times.
HALVINGS = 16
# The interval around a meeting in which a zero of the gap is searched is widened by four, at most this many times.
MOST_WIDENINGS = 20


class CoupleMeeting(NamedTuple):
    """A meeting: its time (s), the pair of elements, and their own parameters."""

    time: float
    pair: PieceCase
    xi1: float
    xi2: float


class SegmentView(NamedTuple):
    """A segment as the search sees it: times (s) of its steps, times (n,) ↦ poses of all plates (3 plates, n); the
    pairs of elements with a contact that is watched, of each its number and times ↦ the parameters (2, n) and the gap
    (n,), m; and the plates at rest."""

    times: np.ndarray
    poses: Poses
    pairs: tuple[PieceCase, ...]
    points: Callable[[int, np.ndarray], np.ndarray]
    gap: Callable[[int, np.ndarray], np.ndarray]
    resting: frozenset[int]

    @property
    def start(self) -> float:
        """The start of the segment, s."""
        return float(self.times[0])


def view_of(segment: Segment) -> SegmentView:
    """The same of a segment in poses."""
    phase, states = segment.phase, _remember(segment.states)
    regime, half = regime_of(phase), 3 * len(bodies(phase.case).reaches)
    return SegmentView(
        segment.times,
        lambda times: states(times)[:half],
        tuple(pair_of(phase.case, key) for key in regime.pairs),
        lambda k, times: states(times)[half + 2 * k : half + 2 * k + 2],
        lambda k, times: gap_of(phase, k, times, states(times)),
        regime.resting,
    )


class Meetings:
    """The search for meetings in one motion; counts its work."""

    def __init__(self, case: Case):
        self.case = case
        self.searches = [CoupleSearch(couple) for couple in couples(case)]

    def first(self, view: SegmentView) -> CoupleMeeting | None:
        """The first meeting in a segment; None if there is none. Raises TooMuch at the limit on work."""
        edges, earliest = np.unique(view.times), None
        if len(edges) < 2:
            return None
        poses = _remember(view.poses)
        for search in self.searches:
            couple = search.couple
            if couple_rests(couple, view.resting) or _is_far(couple, poses, edges):
                continue
            some = edges if earliest is None else np.append(edges[edges < earliest.time], earliest.time)
            if len(some) < 2:
                continue
            meeting = search.first(view, poses, some)
            if meeting is not None and (earliest is None or meeting.time < earliest.time):
                earliest = meeting
        return earliest


class CoupleSearch:
    """The search for meetings of one plate and one boundary: pairs of lines and circles by the zeros of their gaps, the
    others by boxes."""

    def __init__(self, couple: Couple):
        self.couple = couple
        every = pairs_that_touch(couple)
        self.quick = [(pair, some) for pair in every if (some := shapes(pair)) is not None]
        self.has_others = len(self.quick) < len(every)
        self.quick_numbers = {in_round(pair) for pair, _ in self.quick}

    @cached_property
    def boxes(self) -> ElementSearch:
        """The search by boxes."""
        return ElementSearch(self.couple)

    def first(self, view: SegmentView, places: Poses, edges: np.ndarray) -> CoupleMeeting | None:
        """The first meeting in a segment between these times; `places`: poses of all plates at times."""
        couple = self.couple
        poses = _remember(lambda times: np.array(couple.relative_pose(places(times))))
        in_view = [(k, pair) for k, pair in enumerate(view.pairs) if couple_of(pair).number == couple.number]
        pairs, begin = [pair for _, pair in in_view], [view.points(k, view.times[:1])[:, 0] for k, _ in in_view]
        exclusions = _exclusions(pairs).union(*(_across_joints(*one) for one in zip(pairs, begin, strict=True)))

        def is_new(meeting: CoupleMeeting) -> bool:
            soon = meeting.time <= edges[0] + SOON * (edges[1] - edges[0])
            return not (soon and self._is_in_view(meeting, pairs, begin))

        earliest = self._first_of_shapes(poses, edges, exclusions, is_new)
        if not self.has_others:
            return earliest
        if earliest is not None:
            edges = np.append(edges[edges < earliest.time], earliest.time)
        if len(edges) < 2:
            return earliest

        smooth = [(k, p) for k, p in in_view if not isinstance(p.first.piece, Corner) and in_round(p) not in exclusions]
        edges = _provable(view, smooth, edges) if smooth else edges

        def around(first: Element, second: Element, ends: np.ndarray) -> list[Cores]:
            return _around(view, in_view, first, second, ends)

        for later in LATER:
            some = np.append(edges[0] + later * (edges[1] - edges[0]), edges[1:])
            first_box = self.boxes.first(poses, some, exclusions | self.quick_numbers, around)
            if first_box is None:
                return earliest
            pair = _piece_case(couple, first_box.first.number, first_box.second.number)
            near = first_box.xi1 - pair.first.shift, first_box.xi2 - pair.second.shift
            meeting = _locate(poses, view.start, pair, first_box.time, near)
            if is_new(meeting):
                return meeting
        return earliest

    def _is_in_view(self, meeting: CoupleMeeting, pairs: Sequence[PieceCase], points: Sequence[np.ndarray]) -> bool:
        """Whether a meeting is at the place of a contact that is watched, in a neighbour of its pair; `points`: their
        parameters, (2,) each, where the segment begins."""
        place, reach = meeting.pair.pieces[0].point(meeting.xi1), self.couple.plate.reach
        return any(
            np.hypot(*(one.pieces[0].point(xi1) - place)) <= APART * reach and _are_neighbours(one, meeting.pair)
            for one, (xi1, _) in zip(pairs, points, strict=True)
        )

    def _near_elements(self, places: np.ndarray) -> np.ndarray:
        """Which elements of the boundary the plate may reach on its way, given by poses (3, n) between which it moves
        by a part of its size."""
        steps = np.hypot(*np.diff(places[:2], axis=1)).max(initial=0.0)
        x, y, radius = self._circles
        away = np.hypot(x[:, None] - places[0], y[:, None] - places[1]).min(axis=1)
        return np.asarray(~(away > radius + self.couple.plate.reach + FASTER * steps))

    @cached_property
    def _circles(self) -> np.ndarray:
        """Circles (x, y, r) around the elements of the boundary, (3, elements); of infinite radius without ends."""
        rows = list[tuple[float, float, float]]()
        for element in elements(self.couple.track):
            piece = element.piece
            if isinstance(piece, Corner):
                rows.append((piece.x, piece.y, 0.0))
                continue
            if piece.ends is None and not piece.period:
                rows.append((0.0, 0.0, inf))
                continue
            points = piece.point(np.linspace(*piece.span, ON_ELEMENT))
            x, y = points.mean(axis=1)
            between = np.hypot(*np.diff(points, axis=1)).max()
            rows.append((float(x), float(y), float(np.hypot(points[0] - x, points[1] - y).max() + between)))
        return np.array(rows).T

    def _first_of_shapes(
        self, poses: Poses, edges: np.ndarray, exclusions: set[tuple[int, int]],
        is_new: Callable[[CoupleMeeting], bool],
    ) -> CoupleMeeting | None:  # fmt: skip
        earliest: CoupleMeeting | None = None
        times = fine(poses, edges)
        looks, near_elements = _looks(times), self._near_elements(poses(times))
        is_apart = _apart(looks, poses(looks)) if len(self.quick) > FEW else None
        for pair, some in self.quick:
            if in_round(pair) in exclusions or not near_elements[pair.first.number]:
                continue
            if is_apart is not None and is_apart(some):
                continue
            for time in first_closings(some, poses, times, self.couple.plate.reach):
                if earliest is not None and time >= earliest.time:
                    break
                x, y, theta = (float(v) for v in poses(np.array([time]))[:, 0])
                near = guess(pair, some, x, y, theta)
                if not inside(pair, *near, turn=AT_FLAT if isinstance(some.still, Straight) else AT_END):
                    continue
                meeting = _locate(poses, float(edges[0]), pair, time, near)
                if is_new(meeting):
                    earliest = meeting
                    break
        return earliest


def _apart(looks: np.ndarray, at_looks: np.ndarray) -> Callable[[Shapes], bool]:
    """Whether the gap of a corner or arc of the plate stays open, as it is larger at all looks than the way of its
    centre between two of them; `at_looks`: the plate's poses there."""

    def is_apart(some: Shapes) -> bool:
        if not some.from_base:
            return False
        x, y, _ = some.path(lambda _: at_looks)(looks)
        way = float(np.hypot(np.diff(x), np.diff(y)).max(initial=0.0))
        return bool(some.gap(x, y).min() > FASTER * way)

    return is_apart


def _looks(edges: np.ndarray) -> np.ndarray:
    """Instants at which steps are looked at."""
    parts = np.linspace(0.0, 1.0, LOOKS, endpoint=False)
    return np.append((edges[:-1, None] + np.diff(edges)[:, None] * parts).ravel(), edges[-1])


def _remember(poses: Poses) -> Poses:
    """The same function, which evaluates each times once: all pairs of elements ask for the same."""
    values = dict[bytes, np.ndarray]()

    def evaluate(times: np.ndarray) -> np.ndarray:
        key = times.tobytes()
        if key not in values:
            values[key] = poses(times)
        return values[key]

    return evaluate


def couple_rests(couple: Couple, resting: frozenset[int]) -> bool:
    """Whether neither side of a couple moves, given the plates at rest."""
    return couple.body in resting and (couple.base is None or couple.base in resting)


def _is_far(couple: Couple, poses: Poses, edges: np.ndarray) -> bool:
    """Whether the circles around both plates are apart between these times."""
    if couple.base is None:
        return False
    places, own, other = poses(_looks(edges)), 3 * couple.body, 3 * couple.base
    apart = places[own : own + 2] - places[other : other + 2]
    reaches, way = bodies(couple.whole).reaches, np.hypot(*np.diff(apart, axis=1)).max()
    return bool(np.hypot(*apart).min() > reaches[couple.body] + reaches[couple.base] + FASTER * way)


def _exclusions(in_view: Sequence[PieceCase]) -> set[tuple[int, int]]:
    """The numbers, within one round, of pairs in which no other contact than the watched one is possible: the pair
    itself, if its nearest points are unique, and those with a neighbour to which the contact passes smoothly."""
    result = set[tuple[int, int]]()
    for pair in in_view:
        if is_unique(pair) or shapes(pair) is not None:
            result.add(in_round(pair))
        for of_track in (True, False):
            for step in (-1, 1):
                other = neighbour(pair, of_track, step)
                if other is not None and _passes(pair, other, of_track):
                    result.add(in_round(other))
    return result


def _across_joints(pair: PieceCase, points: np.ndarray) -> set[tuple[int, int]]:
    """The numbers of the pair beyond the joints of both elements, if a contact is at both: it has the same place."""
    result = set[tuple[int, int]]()
    steps = [
        [step for step, end in zip((-1, 1), piece.ends or (), strict=False) if abs(s - end) <= AT_END]
        for piece, s in zip(pair.pieces, points, strict=True)
    ]
    for one in steps[0]:
        beside = neighbour(pair, True, one)
        across = [neighbour(beside, False, other) for other in steps[1]] if beside is not None else []
        result |= {in_round(other) for other in across if other is not None}
    return result


def _are_neighbours(one: PieceCase, other: PieceCase) -> bool:
    """Whether a contact of one pair passes to the other."""
    beside = (neighbour(one, of_track, step) for of_track in (True, False) for step in (-1, 1))
    return any(pair is not None and in_round(pair) == in_round(other) for pair in beside)


def is_unique(pair: PieceCase) -> bool:
    """Whether the nearest points of two elements are the only ones: that of the plate bulges, that of the track does
    not bend towards it."""
    track, outline = pair.pieces
    return bends(outline)[0] >= 0.0 and bends(track)[1] <= 0.0


def _passes(pair: PieceCase, other: PieceCase, of_track: bool) -> bool:
    """Whether a contact passes to a neighbour without another one before: at a corner that points to the other curve,
    if that does not bend towards it, or where the curves fit each other."""
    track, outline = other.pieces
    piece = track if of_track else outline
    if not isinstance(piece, Corner):
        return bends(outline)[0] > bends(track)[1]
    return piece.sign < 0 and bends(outline)[0] >= 0.0 if of_track else piece.sign > 0 and bends(track)[1] <= 0.0


def _around(
    view: SegmentView, in_view: Sequence[tuple[int, PieceCase]], first: Element, second: Element, ends: np.ndarray
) -> list[Cores]:
    """The surroundings of each watched contact of two elements in windows of time (2, m)."""
    return [
        _cores(view, k, pair, ends)[0]
        for k, pair in in_view
        if in_round(pair) == (first.number, second.number) and not isinstance(pair.first.piece, Corner)
    ]


def _cores(view: SegmentView, k: int, pair: PieceCase, ends: np.ndarray) -> tuple[Cores, np.ndarray]:
    """The surroundings of a watched contact in windows of time (2, m), and which of them shorter windows may still
    prove (m,)."""
    times, size = (ends[0][:, None] + (ends[1] - ends[0])[:, None] * PLACES).ravel(), (len(ends[0]), len(PLACES))
    places = view.points(k, times).reshape(2, *size)
    low, high = places.min(axis=2), places.max(axis=2)
    more = BEYOND * (high - low)
    xi1, xi2 = zip(low - more, high + more, strict=True)
    gap = view.gap(k, times).reshape(size)
    return cores(pair, np.array(xi1), np.array(xi2), np.maximum(gap.max(axis=1), 0.0))


def _provable(view: SegmentView, some: Sequence[tuple[int, PieceCase]], edges: np.ndarray) -> np.ndarray:
    """The times, and times between them, such that each contact is proven to be the only one in its surroundings: a
    feature of its curve that it passes in a window would count as the contact."""
    for _ in range(HALVINGS):
        unproven = edges[1:] - edges[:-1] > 64 * EPS * np.abs(edges[1:])
        unproven &= np.any([_cores(view, k, pair, np.array([edges[:-1], edges[1:]]))[1] for k, pair in some], axis=0)
        if not unproven.any():
            break
        edges = np.union1d(edges, 0.5 * (edges[:-1] + edges[1:])[unproven])
    return edges


def gap_of(phase: Phase, k: int, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    """The gap of contact k, m, at some instants."""
    columns = phase.system.outputs_of_arrays(times, states, phase.parameters)
    first = 2 + 3 * len(bodies(phase.case).reaches) + len(COLUMNS) * k
    return np.broadcast_to(np.asarray(columns[first + COLUMNS.index("gap")], dtype=float), times.shape)


def _locate(poses: Poses, start: float, pair: PieceCase, when: float, near: tuple[float, float]) -> CoupleMeeting:
    """The zero of the gap at a meeting, to rounding, with the elements' own parameters; `poses`: of the plate in the
    frame of the base."""
    from scipy.optimize import brentq  # slow to import, and many motions never come here

    def at_time(t: float):
        x, y, theta = poses(np.array([t]))[:, 0].tolist()
        return nearest(pair, x, y, theta, near)

    try:
        time = _zero(lambda t: at_time(t).gap, when, brentq)
    except (ValueError, DoesNotFit):
        time = when  # it touches without closing: two flat sides, or a start
    time = max(time, start)
    at = at_time(time)
    return CoupleMeeting(time, pair, at.xi1, at.xi2)


def _zero(gap: Callable[[float], float], near: float, root: Callable[..., float]) -> float:
    """A zero at which a gap closes. Raises ValueError if there is none near."""
    wide = max(4.0 * EPS * abs(near), 1e-300)
    for _ in range(MOST_WIDENINGS):
        if gap(near - wide) > 0.0 >= gap(near + wide):
            return float(root(gap, near - wide, near + wide, xtol=1e-15, rtol=8.9e-16))
        wide *= 4.0
    raise ValueError("the gap does not close")
