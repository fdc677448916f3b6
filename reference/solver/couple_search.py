"""The search for meetings of one plate and one boundary in a phase's dense output: at places that are not watched.

All pairs of elements of both curves are searched by boxes (`minimal.element_meetings`), but those in which a contact
in view is the only one. Plates that are far apart are excluded by the circles around them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from math import sqrt

import numpy as np

from cases import DoesNotFit
from cases.contact.close_pairs import circles_around
from cases.contact.geometry import clearance, find
from cases.contact.shapes import Poses, Shapes, Straight, guess, shapes
from cases.curves.corner import Corner
from cases.scene.couples import Couple
from cases.scene.piece_case import PieceCase

from ..minimal.boxes import Cores
from ..minimal.element_meetings import ElementMeeting, ElementSearch, fine
from ..scales import EPS
from .closings import first_closings
from .pair_exclusions import across_joints, are_neighbours, excluded_by, is_at_inner_corner
from .places import couple_of, in_round
from .plate_numbers import bodies
from .regimes import AT_END
from .segment_view import SegmentView, remember
from .touching import SAME_PLACE, inside, pairs_that_touch

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
            exclusions = excluded_by(own)
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
        in_view = self._in_view(view)
        pairs, begin = [pair for _, pair in in_view], [view.points(k, view.times[:1])[:, 0] for k, _ in in_view]
        exclusions = excluded_by(pairs).union(*(across_joints(*one) for one in zip(pairs, begin, strict=True)))
        quick = [one for one in self.quick if in_round(one[0]) not in exclusions]
        if not (quick or self.others) or self._is_far(places, edges):
            return None

        def is_new(meeting: ElementMeeting) -> bool:
            soon = meeting.time <= edges[0] + SOON * (edges[1] - edges[0])
            if soon and any(one.whole == couple and in_round(one) == in_round(meeting.pair) for one in view.partings):
                return False
            # Where the gap is a largest one in place, as at a bend next to an inflection, no contact begins.
            if clearance(*meeting.pair.pieces, meeting.xi1, meeting.xi2) < 0.0:
                return False
            return not self._is_in_view(view, meeting)

        earliest = self._first_of_shapes(quick, poses, edges, is_new) if quick else None
        if not self.others:
            return earliest
        if earliest is not None:
            edges = until(edges, earliest.time)
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

    def _is_far(self, places: Poses, edges: np.ndarray) -> bool:
        """Whether the circles around both plates are apart between these times."""
        couple = self.couple
        if couple.base is None:
            return False
        poses, own, other = places(looks(edges)), 3 * couple.body, 3 * couple.base
        reaches = bodies(couple.whole).reaches
        reach = reaches[couple.body] + reaches[couple.base]
        return stays_apart(poses[own : own + 2] - poses[other : other + 2], reach)

    def _in_view(self, view: SegmentView) -> list[tuple[int, PieceCase]]:
        """The contacts of the couple that are watched, each with its number."""
        return [(k, pair) for k, pair in enumerate(view.pairs) if couple_of(pair).number == self.couple.number]

    def _is_in_view(self, view: SegmentView, meeting: ElementMeeting) -> bool:
        """Whether a meeting is at the place of a contact that is watched, in its pair, a neighbour or across the
        joints of both elements, or anywhere but in an inner corner: it passes there. As near as roundings of a gap that
        curvatures open, places are one."""
        place, reach, other = meeting.pair.pieces[0].point(meeting.xi1), self.couple.plate.reach, meeting.pair

        def within(one: PieceCase, at: np.ndarray) -> float:
            bend = clearance(*one.pieces, *at)
            wide = sqrt(2.0 * DRIFT / (bend * reach)) if bend * reach > DRIFT else 0.0
            return reach * max(SAME_PLACE, min(wide, MOST_WIDE))

        return any(
            np.hypot(*(one.pieces[0].point(at[0]) - place)) <= within(one, at)
            and (
                in_round(one) == in_round(other)
                or are_neighbours(one, other)
                or in_round(other) in across_joints(one, at)
                or not is_at_inner_corner(other, meeting.xi1, meeting.xi2)
            )
            for k, one in self._in_view(view)
            for at in (view.points(k, np.array([meeting.time]))[:, 0],)
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
        is_apart = _apart(instants := looks(times), poses(instants)) if len(quick) > FEW else None
        for pair, some in quick:
            if not near_elements[pair.first.number]:
                continue
            if is_apart is not None and is_apart(some):
                continue
            for time in first_closings(some, poses, times, self.couple.plate.reach):
                if earliest is not None and time >= earliest.time:
                    break
                near = place_inside(pair, some, *poses(np.array([time]))[:, 0].tolist())
                if near is None:
                    continue
                meeting = _locate(poses, float(edges[0]), pair, time, near)
                if is_new(meeting):
                    earliest = meeting
                    break
        return earliest


def until(edges: np.ndarray, time: float) -> np.ndarray:
    """The times of windows up to one time."""
    return np.append(edges[edges < time], time)


def place_inside(pair: PieceCase, some: Shapes, x: float, y: float, theta: float) -> tuple[float, float] | None:
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


def looks(edges: np.ndarray) -> np.ndarray:
    """Instants at which steps are looked at."""
    parts = np.linspace(0.0, 1.0, LOOKS, endpoint=False)
    return np.append((edges[:-1, None] + np.diff(edges)[:, None] * parts).ravel(), edges[-1])


def couple_rests(couple: Couple, resting: frozenset[int]) -> bool:
    """Whether neither side of a couple moves, given the plates at rest."""
    return couple.body in resting and (couple.base is None or couple.base in resting)


def stays_apart(way: np.ndarray, reach: float) -> bool:
    """Whether a distance stays above a reach (m), given by its looks (2, n)."""
    return bool(np.hypot(*way).min() > reach + FASTER * np.hypot(*np.diff(way)).max())


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
