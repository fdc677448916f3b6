"""The first meeting of a plate and a boundary at a place that is not watched, in a phase's dense output.

All pairs of elements of both curves are searched by boxes (`minimal.element_meetings`), but those in which a contact
in view is the only one. Plates that are far apart are excluded by the circles around them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from math import sqrt

import numpy as np

from cases import Case, DoesNotFit
from cases.contact.close_pairs import circles_around
from cases.contact.geometry import clearance, find
from cases.contact.shapes import Poses, Shapes, Straight, guess, shapes
from cases.curves.corner import Corner
from cases.scene.couples import Couple, couples
from cases.scene.piece_case import PieceCase, is_concave, neighbour

from ..minimal.boxes import Cores
from ..minimal.element_meetings import ElementMeeting, ElementSearch, fine
from ..minimal.integrators.segment import Segment
from ..scales import EPS
from .closings import first_closings
from .places import couple_of, in_round, place
from .plate_numbers import bodies
from .regimes import AT_END
from .segment_view import SegmentView, remember
from .touching import SAME_PLACE, bend_bounds, inside, pairs_that_touch

# A corner that comes to a line with a flat side of its own: a few of the coarsest tolerance's errors of an angle, rad.
# Nothing else than the corner meets the line first, as lines do not meet lines.
AT_FLAT = 0.1
# Plates move between two samples by at most this many times what their speeds there say.
FASTER = 2.0
# Couples with more pairs of lines and circles than this are looked at before gaps are polynomials.
FEW = 8
# After each step at most so many pairs of a couple are looked at that were clearly apart: from this part of the plate's
# reach on.
MOST_AFTER_STEP, FAR = 8, 1e-3
# Samples of a step at which far plates are looked at.
LOOKS = 16
# A contact at the end of an element has no gap in the neighbouring pair either: the search goes on this part of a step
# later.
LATER = 0.0, 1e-9, 1e-6, 1e-3
# A contact that has left its pair over an end of it has no gap there for as long.
SOON = 2.0 * LATER[-1]
# The interval around a meeting in which a zero of the gap is searched is widened by four, at most this many times.
MOST_WIDENINGS = 20
# A contact has a gap of at most this part of the plate's reach, by roundings; places farther apart than MOST_WIDE of it
# are two.
DRIFT, MOST_WIDE = 1e-11, 1e-4
# The times of meetings inside steps are corrected so often, by less than this part of the segment: by the error of its
# dense output; and no more where it is rounding, in parts of the time.
CORRECTIONS, NEWTON, FINEST = 3, 1e-3, 4 * EPS


class Meetings:
    """The search for meetings in one motion; counts its work."""

    def __init__(self, case: Case):
        self.case = case
        self.searches = [CoupleSearch(couple) for couple in couples(case)]

    def first(self, view: SegmentView) -> ElementMeeting | None:
        """The first meeting in a segment; None if there is none. Raises TooMuch at the limit on work."""
        searches = [search for search in self.searches if not search.excludes_all(view.pairs, view.resting)]
        if not searches:
            return None
        edges, earliest = np.unique(view.times), None
        if len(edges) < 2:
            return None
        poses = remember(view.poses)
        for search in searches:
            some = edges if earliest is None else np.append(edges[edges < earliest.time], earliest.time)
            if len(some) < 2:
                continue
            meeting = search.first(view, poses, some)
            if meeting is not None and (earliest is None or meeting.time < earliest.time):
                earliest = meeting
        return earliest

    def past_of(self, state: Sequence[float], resting: frozenset[int]) -> Callable[[Sequence[float]], bool]:
        """Whether a plate is, in the variables of a phase, beyond a line or circle from which it is apart in a state of
        all plates: they have met before, and more steps would be cut off."""
        half = len(state) // 2
        apart = [
            (search.couple, pairs) for search in self.searches
            if not couple_rests(search.couple, resting) and (pairs := search.far_pairs(np.array(state[:half])))
        ]  # fmt: skip

        def is_past(y: Sequence[float]) -> bool:
            poses = np.array(y[:half])
            for couple, pairs in apart:
                pose = couple.relative_pose(poses)
                for pair, some in pairs:
                    if some.gap(*some.centre(*pose)) < 0.0 and _place_inside(pair, some, *pose) is not None:
                        return True
            return False

        return is_past


def until_meeting(
    segment: Segment, meeting: ElementMeeting, integrate: Callable[..., Segment], rtol: float,
    state_of: Callable[[Segment], Sequence[float]],
) -> Segment:  # fmt: skip
    """A segment until elements meet. Where their gap at the end of a step is another one than inside it, the time is
    corrected by Newton's method. `integrate` (t, y, end, rtol); `state_of`: the plates' state at a segment's end."""
    result, time = segment.cut(meeting.time, None), meeting.time
    for _ in range(CORRECTIONS if segment.ends_in_steps() else 0):
        again = segment.step_to(time, lambda t, y, end: integrate(t, y, end, rtol))
        if again is None:
            break
        result, state = again, state_of(again)
        at = place(meeting.pair, state, (meeting.xi1, meeting.xi2))
        closing = float(at.lift_row @ np.array(state[len(state) // 2 :]))
        change = -at.gap / closing if closing < 0.0 else 0.0
        if not FINEST * abs(time) < abs(change) < NEWTON * (time - segment.start):
            break
        time += change
    return result


class CoupleSearch:
    """The search for meetings of one plate and one boundary: pairs of lines and circles by the zeros of their gaps, the
    others by boxes."""

    def __init__(self, couple: Couple):
        self.couple = couple
        every = pairs_that_touch(couple)
        self.quick = [(pair, some) for pair in every if (some := shapes(*pair.pieces)) is not None]
        self.others = [pair for pair in every if shapes(*pair.pieces) is None]
        self.complete = dict[tuple[tuple[int, int], ...], bool]()

    def excludes_all(self, in_view: Sequence[PieceCase], resting: frozenset[int]) -> bool:
        """Whether plates at rest, or contacts of these pairs that are watched, exclude every meeting."""
        if couple_rests(self.couple, resting):
            return True
        own = [pair for pair in in_view if couple_of(pair).number == self.couple.number]
        if not own:
            return False
        key = tuple(map(in_round, own))
        if key not in self.complete:
            exclusions = _exclusions(own)
            every = [*(pair for pair, _ in self.quick), *self.others]
            self.complete[key] = all(in_round(pair) in exclusions for pair in every)
        return self.complete[key]

    def far_pairs(self, poses: np.ndarray) -> list[tuple[PieceCase, Shapes]]:
        """Pairs of lines and circles, if there are few, that are clearly apart in poses of all plates, (3n,)."""
        pose, least = self.couple.relative_pose(poses), FAR * self.couple.plate.reach
        quick = self.quick if len(self.quick) <= MOST_AFTER_STEP else []
        return [(pair, some) for pair, some in quick if some.gap(*some.centre(*pose)) > least]

    @cached_property
    def boxes(self) -> ElementSearch:
        """The search by boxes."""
        return ElementSearch(self.others)

    def first(self, view: SegmentView, places: Poses, edges: np.ndarray) -> ElementMeeting | None:
        """The first meeting in a segment between these times; `places`: poses of all plates at times."""
        couple = self.couple
        poses = remember(lambda times: np.array(couple.relative_pose(places(times))))
        in_view = [(k, pair) for k, pair in enumerate(view.pairs) if couple_of(pair).number == couple.number]
        pairs, begin = [pair for _, pair in in_view], [view.points(k, view.times[:1])[:, 0] for k, _ in in_view]
        exclusions = _exclusions(pairs).union(*(_across_joints(*one) for one in zip(pairs, begin, strict=True)))
        quick = [one for one in self.quick if in_round(one[0]) not in exclusions]
        if not (quick or self.others) or _is_far(couple, places, edges):
            return None

        def is_new(meeting: ElementMeeting) -> bool:
            soon = meeting.time <= edges[0] + SOON * (edges[1] - edges[0])
            if soon and any(one.whole == couple and in_round(one) == in_round(meeting.pair) for one in view.partings):
                return False
            # Where the gap is a largest one in place, as at a bend next to an inflection, no contact begins.
            if clearance(*meeting.pair.pieces, meeting.xi1, meeting.xi2) < 0.0:
                return False
            points = [view.points(k, np.array([meeting.time]))[:, 0] for k, _ in in_view]
            return not self._is_in_view(meeting, pairs, points)

        earliest = self._first_of_shapes(quick, poses, edges, is_new) if quick else None
        if not self.others:
            return earliest
        if earliest is not None:
            edges = np.append(edges[edges < earliest.time], earliest.time)
        if len(edges) < 2:
            return earliest

        smooth = {k: in_round(pair) for k, pair in in_view if not isinstance(pair.first.piece, Corner)}
        for k, numbers in smooth.items():
            edges = view.provable(k, edges) if numbers not in exclusions else edges

        def around(pair: PieceCase, ends: np.ndarray) -> list[Cores]:
            return [view.cores(k, ends)[0] for k, numbers in smooth.items() if numbers == in_round(pair)]

        start, step = edges[0], edges[1] - edges[0]
        for later in LATER:
            since = start + later * step
            some = np.append(since, edges[edges > since])
            if len(some) < 2:
                break
            near = self.boxes.first(poses, some, exclusions, around)
            if near is None:
                return earliest
            meeting = _locate(poses, view.start, near.pair, near.time, near[2:])
            if is_new(meeting):
                return meeting
            start = max(start, meeting.time)
        return earliest

    def _is_in_view(self, meeting: ElementMeeting, pairs: Sequence[PieceCase], points: Sequence[np.ndarray]) -> bool:
        """Whether a meeting is at the place of a contact that is watched, in its pair, a neighbour or across the
        joints of both elements, or anywhere but in an inner corner: it passes there. As near as roundings of a gap that
        curvatures open, places are one. `points`: the contacts' parameters, (2,) each, at that time."""
        place, reach, other = meeting.pair.pieces[0].point(meeting.xi1), self.couple.plate.reach, meeting.pair

        def within(one: PieceCase, at: np.ndarray) -> float:
            bend = clearance(*one.pieces, *at)
            wide = sqrt(2.0 * DRIFT / (bend * reach)) if bend * reach > DRIFT else 0.0
            return reach * max(SAME_PLACE, min(wide, MOST_WIDE))

        return any(
            np.hypot(*(one.pieces[0].point(at[0]) - place)) <= within(one, at)
            and (
                in_round(one) == in_round(other)
                or _are_neighbours(one, other)
                or in_round(other) in _across_joints(one, at)
                or not _is_at_inner_corner(other, meeting.xi1, meeting.xi2)
            )
            for one, at in zip(pairs, points, strict=True)
        )

    def _near_elements(self, places: np.ndarray) -> np.ndarray:
        """Which elements of the boundary the plate may reach on its way, given by poses (3, n) between which it moves
        by a part of its size."""
        steps = np.hypot(*np.diff(places[:2], axis=1)).max(initial=0.0)
        x, y, radius = circles_around(self.couple.track)
        away = np.hypot(x[:, None] - places[0], y[:, None] - places[1]).min(axis=1)
        return np.asarray(~(away > radius + self.couple.plate.reach + FASTER * steps))

    def _first_of_shapes(
        self, quick: Sequence[tuple[PieceCase, Shapes]], poses: Poses, edges: np.ndarray,
        is_new: Callable[[ElementMeeting], bool],
    ) -> ElementMeeting | None:  # fmt: skip
        earliest: ElementMeeting | None = None
        times = fine(poses, edges)
        near_elements = self._near_elements(poses(times))
        is_apart = _apart(looks := _looks(times), poses(looks)) if len(quick) > FEW else None
        for pair, some in quick:
            if not near_elements[pair.first.number]:
                continue
            if is_apart is not None and is_apart(some):
                continue
            for time in first_closings(some, poses, times, self.couple.plate.reach):
                if earliest is not None and time >= earliest.time:
                    break
                near = _place_inside(pair, some, *poses(np.array([time]))[:, 0].tolist())
                if near is None:
                    continue
                meeting = _locate(poses, float(edges[0]), pair, time, near)
                if is_new(meeting):
                    earliest = meeting
                    break
        return earliest


def _place_inside(pair: PieceCase, some: Shapes, x: float, y: float, theta: float) -> tuple[float, float] | None:
    """The elements' own parameters at the nearest points in a pose of the plate in the frame of the base; None beyond
    an end."""
    near = guess(*pair.pieces, some, x, y, theta)
    return near if inside(pair, *near, turn=AT_FLAT if isinstance(some.still, Straight) else AT_END) else None


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
    itself, if its nearest points are unique, and then those with a neighbour to which the contact passes smoothly."""
    result = set[tuple[int, int]]()
    for pair in in_view:
        if is_unique(pair) or shapes(*pair.pieces) is not None:
            result.add(in_round(pair))
        elif not fits_everywhere(pair):
            continue  # a second contact may be at the other end
        for of_track in (True, False):
            for step in (-1, 1):
                other = neighbour(pair, of_track, step)
                if other is not None and _passes(pair, other, of_track):
                    result.add(in_round(other))
    return result


def _across_joints(pair: PieceCase, points: np.ndarray) -> set[tuple[int, int]]:
    """The numbers of the pairs beyond the joints of both elements, if a contact is at both: it has the same place. A
    corner is one place, a joint on both sides."""
    result = set[tuple[int, int]]()
    steps = [
        [
            step
            for step, end in zip((-1, 1), piece.ends or (), strict=False)
            if isinstance(piece, Corner) or abs(s - end) <= AT_END
        ]
        for piece, s in zip(pair.pieces, points, strict=True)
    ]
    for one in steps[0]:
        beside = neighbour(pair, True, one)
        across = [neighbour(beside, False, other) for other in steps[1]] if beside is not None else []
        result |= {in_round(other) for other in across if other is not None}
    return result


def _is_at_inner_corner(pair: PieceCase, *points: float) -> bool:
    """Whether a contact lies at an end of an element that joins a corner inside which curves touch on both sides."""
    ends = [
        neighbour(pair, k == 0, step)
        for k, (piece, s) in enumerate(zip(pair.pieces, points, strict=True))
        for step, end in zip((-1, 1), piece.ends or (), strict=False)
        if abs(s - end) <= AT_END
    ]
    return any(one is not None and is_concave(one) for one in ends)


def _are_neighbours(one: PieceCase, other: PieceCase) -> bool:
    """Whether a contact of one pair passes to the other."""
    beside = (neighbour(one, of_track, step) for of_track in (True, False) for step in (-1, 1))
    return any(pair is not None and in_round(pair) == in_round(other) for pair in beside)


def is_unique(pair: PieceCase) -> bool:
    """Whether the nearest points of two elements are the only ones: that of the plate bulges, that of the track does
    not bend towards it."""
    track, outline = pair.pieces
    return bend_bounds(outline)[0] >= 0.0 and bend_bounds(track)[1] <= 0.0


def fits_everywhere(pair: PieceCase) -> bool:
    """Whether the element of the plate bends more than that of the track, wherever they touch."""
    track, outline = pair.pieces
    return bend_bounds(outline)[0] > bend_bounds(track)[1]


def _passes(pair: PieceCase, other: PieceCase, of_track: bool) -> bool:
    """Whether a contact passes to a neighbour without another one before: at a corner that points to the other curve,
    if that does not bend towards it, or where the curves fit each other."""
    track, outline = other.pieces
    piece = track if of_track else outline
    if not isinstance(piece, Corner):
        return fits_everywhere(other)
    if of_track:
        return piece.sign < 0 and bend_bounds(outline)[0] >= 0.0
    return piece.sign > 0 and bend_bounds(track)[1] <= 0.0


def _locate(poses: Poses, start: float, pair: PieceCase, when: float, near: tuple[float, float]) -> ElementMeeting:
    """The zero of the gap at a meeting, to rounding, with the elements' own parameters; `poses`: of the plate in the
    frame of the base."""
    from scipy.optimize import brentq  # slow to import, and many motions never come here

    def at_time(t: float):
        x, y, theta = poses(np.array([t]))[:, 0].tolist()
        return find(*pair.pieces, x, y, theta, near)

    try:
        time = _zero(lambda t: at_time(t).gap, when, brentq)
    except (ValueError, DoesNotFit):
        time = when  # it touches without closing: two flat sides, or a start
    time = max(time, start)
    at = at_time(time)
    return ElementMeeting(time, pair, at.xi1, at.xi2)


def _zero(gap: Callable[[float], float], near: float, root: Callable[..., float]) -> float:
    """A zero at which a gap closes. Raises ValueError if there is none near."""
    wide = max(4.0 * EPS * abs(near), 1e-300)
    for _ in range(MOST_WIDENINGS):
        if gap(near - wide) > 0.0 >= gap(near + wide):
            return float(root(gap, near - wide, near + wide, xtol=1e-15, rtol=8.9e-16))
        wide *= 4.0
    raise ValueError("the gap does not close")
