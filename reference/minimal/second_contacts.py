"""Second contacts: this formulation has one contact, so the motion ends if plate and track meet in a second place.

If curvatures exclude a second contact (`curvature_proof`), nothing is searched. Otherwise all phases of contact are
searched by boxes (`meetings`), except for the surroundings of the contact itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import isnan

import numpy as np

from cases import Case, Chain, DoesNotFit, Transition
from cases.contact import Contact, find, pose
from cases.overlap import span
from cases.piece_case import PieceCase, has_pieces
from cases.piece_contact import Chains, Entry, entry_time, excludes_second, piece_gap

from ..curvature_proof import fits
from ..endings import Ending, second_place, second_search_ending
from .boxes import Cores, Geometry
from .contact_cores import cores
from .curve_pieces import TooMuch
from .element_meetings import ElementSearch
from .gap import facing
from .integrators.segment import Segment
from .meetings import Meeting, MeetingSearch
from .modes import FLIGHT
from .windows import EPS, Windows, join_windows, windows

# Steps searched together, in order of time: the search stops at the first second contact.
TOGETHER = 32
# Windows in which the contact is not proven to be the only one in its surroundings are halved at most this many times.
HALVINGS = 16
# Places in a window at which the contact is sampled, and how far it may go beyond them, as a part of their range.
PLACES, BEYOND = np.linspace(0.0, 1.0, 5), 0.1
# The interval around a meeting in which a zero of the gap is searched is widened by four, at most this many times.
MOST_WIDENINGS = 20

# Samples of a motion on curves with corners: the plate moves by this part of its size between two, and a step has at
# most so many.
CHAIN_STEP, MOST_SAMPLES = 0.02, 2000

# Times nearer to a phase's end than this part of it are the end's: both are events, located to 1e-12.
END = 1e-11

Solution = tuple[list[Segment], list[Transition], tuple[str, str]]


def until_second_contact(case: Case, solution: Solution) -> tuple[Solution, Meeting | None]:
    """Segments, transitions and ending of a motion, cut where the plate meets its track in a second place, and that
    place; None if there is none."""
    segments, transitions, _ = solution
    touching = [segment for segment in segments if segment.phase.regime != FLIGHT]  # flights are searched for landings
    if touching and has_pieces(case):
        return _until_entry(case, solution, touching), None
    if not touching or _fits_everywhere(case, touching):
        return solution, None
    search = MeetingSearch(Geometry.of_case(case), case.weight / case.plate.mass)
    for lot, motion, around in _lots(case, touching):
        try:
            meeting = search.first(motion, [around])
        except TooMuch:
            return _cut(solution, lot[0].start, second_search_ending(lot[0].start)), None
        if meeting is not None:
            segment = next(segment for segment in reversed(lot) if segment.start <= meeting.time or segment is lot[0])
            touch = _locate(case, segment, meeting)
            return _cut(solution, touch.time, second_place(touch.time, touch.xi1)), touch
    return solution, None


def _fits_everywhere(case: Case, segments: list[Segment]) -> bool:
    """Whether the curvatures alone exclude a second contact during the motion."""
    track, outline = case.track, case.plate.outline
    xi1 = np.array([case.start.xi1])
    if track.domain is None and not track.period:  # a stretch of it, as long as the motion
        xi1 = np.concatenate([segment.states(segment.times)[0] for segment in segments])
    return fits(track, outline, *span(track, xi1, case.plate.reach))


def _until_entry(case: Case, solution: Solution, segments: list[Segment]) -> Solution:
    """The same for curves with corners: the first meeting of two elements. Those next to the contact's, whose gaps
    vanish with it, are searched at samples only."""
    if excludes_second(case.track, case.plate.outline):
        return solution
    whole = [_whole(segment) for segment in segments]
    xi1 = np.concatenate([states(segment.times)[3] for segment, states in zip(segments, whole, strict=True)])
    chains = Chains(case.track, case.plate.outline, *span(case.track, xi1, case.plate.reach))
    search = ElementSearch(case)
    for segment, states in zip(segments, whole, strict=True):
        entry = _sampled_entry(chains, segment, states)
        try:
            meeting = _meeting(case, search, segment, states, entry[0] if entry else float(segment.times[-1]))
        except TooMuch:
            return _cut(solution, segment.start, second_search_ending(segment.start))
        if first := meeting or entry:
            return _cut(solution, first[0], second_place(*first))
    return solution


def _meeting(
    case: Case, search: ElementSearch, segment: Segment, states: Callable[[np.ndarray], np.ndarray], until: float
) -> tuple[float, float] | None:
    """Time and ξ₁ of the first meeting, before a time, of elements that are not next to those of the contact."""
    from scipy.optimize import brentq  # slow to import, and most motions never come here

    edges = np.unique(np.minimum(segment.times, until))
    if len(edges) < 2:
        return None

    def poses(times: np.ndarray) -> np.ndarray:
        return states(times)[:3]

    meeting = search.first(poses, edges, _next_to_contact(case, segment))
    if meeting is None:
        return None
    pair = Entry(meeting.first, meeting.second, meeting.xi1, meeting.xi2)
    try:
        time = _zero(lambda t: piece_gap(pair, *poses(np.array([t]))[:, 0].tolist()).gap, meeting.time, brentq)
    except (DoesNotFit, ValueError):
        time = meeting.time  # no simple touch: accurate to the search only
    # At the end of the phase the contact itself reaches the end of its piece.
    return (time, meeting.xi1) if time < until * (1.0 - END) else None


def _next_to_contact(case: Case, segment: Segment) -> set[tuple[int, int]]:
    """The numbers of the pairs of elements that the contact may lie on during a phase, and of their neighbours."""
    pieces = segment.phase.case
    assert isinstance(pieces, PieceCase)
    numbers = []
    for curve, element in ((case.track, pieces.first), (case.plate.outline, pieces.second)):
        count = len(curve.elements) if isinstance(curve, Chain) else 1
        numbers.append({(element.number + i) % count for i in (-1, 0, 1)})
    return {(i, j) for i in numbers[0] for j in numbers[1]}


def _sampled_entry(
    chains: Chains, segment: Segment, states: Callable[[np.ndarray], np.ndarray]
) -> tuple[float, float] | None:
    """Time and ξ₁ at which a corner of track or plate has entered the other, seen at samples between which the plate
    moves by CHAIN_STEP of its size, then located to rounding. It sees elements next to the contact's, too."""
    times = _close_times(segment, states, CHAIN_STEP * chains.size)
    before = float(times[0])
    for t, (x, y, theta, place) in zip(times.tolist(), states(times).T.tolist(), strict=True):
        entry = chains.entry(x, y, theta, place)
        if entry is None:
            before = t
            continue

        def pose_at(time: float) -> tuple[float, float, float]:
            x, y, theta, _ = states(np.array([time]))[:, 0].tolist()
            return x, y, theta

        try:
            t = entry_time(pose_at, entry, before, t, segment.start) if t > before else t
        except DoesNotFit:
            pass  # no simple touch: known to the samples only
        return max(t, segment.start), entry.s1
    return None


def _whole(segment: Segment) -> Callable[[np.ndarray], np.ndarray]:
    """Times (n,) ↦ (x, y, θ, ξ₁) of a segment on pieces, with the parameter of the whole track, shape (4, n)."""
    pieces = segment.phase.case

    def states(times: np.ndarray) -> np.ndarray:
        xi1, xi2 = segment.states(times)[:2]
        x, y, theta = pose(pieces, xi1, xi2)
        return np.array([x, y, theta, xi1 + (pieces.first.shift if isinstance(pieces, PieceCase) else 0.0)])

    return states


def _close_times(segment: Segment, states: Callable[[np.ndarray], np.ndarray], way: float) -> np.ndarray:
    """Times of a segment between which the plate moves by about `way` (m) at most."""
    edges = np.unique(segment.times)
    ends = states(edges)
    reach = segment.phase.case.plate.reach
    moves = np.hypot(*np.diff(ends[:2], axis=1)) + reach * np.abs(np.diff(ends[2]))
    counts = 1 + np.minimum(np.ceil(moves / way), MOST_SAMPLES).astype(int)
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(edges[:-1], edges[1:], counts, strict=True)]
    return np.append(np.concatenate(parts), edges[-1]) if parts else edges


def _cut(solution: Solution, time: float, ending: Ending) -> Solution:
    """The motion up to that time."""
    segments, transitions, _ = solution
    # The motion may end at its start, before which there is no segment.
    number = max((i for i, segment in enumerate(segments) if segment.start < time), default=0)
    # Work beyond the cut counts, too.
    work = sum(segment.evaluations for segment in segments[number:])
    last = segments[number].until(time, work)
    last.event = last.event._replace(guard=None)  # beyond the cut the motion may have become singular
    parts = [*segments[:number], last]
    return parts, [t for t in transitions if t.time < time], ending


def _lots(case: Case, segments: list[Segment]) -> Iterator[tuple[list[Segment], Windows, Cores]]:
    """Segments of contact that are searched together, their windows, and the contact's surroundings in each."""
    lot: list[Segment] = []
    some: list[tuple[Windows, Cores]] = []
    steps = 0
    for segment in segments:
        edges = np.unique(segment.times)
        if len(edges) < 2:
            edges = np.append(edges, np.nextafter(edges, np.inf))
        for first in range(0, len(edges) - 1, TOGETHER):
            part = edges[first : first + TOGETHER + 1]
            lot.append(segment)
            some.append(_in_windows(case, segment, part))
            steps += len(part) - 1
            if steps >= TOGETHER or (segment is segments[-1] and part[-1] == edges[-1]):
                track, outline = (np.concatenate([around[i] for _, around in some], axis=1) for i in range(2))
                yield lot, join_windows([motion for motion, _ in some]), Cores(track, outline)
                lot, some, steps = [], [], 0


def _in_windows(case: Case, segment: Segment, edges: np.ndarray) -> tuple[Windows, Cores]:
    """Steps of a segment in windows so short that the contact is the only one in its surroundings."""
    for _ in range(HALVINGS):
        motion = windows(partial(_poses, case, segment), edges, case.plate.reach)
        times = motion.start[:, None] + (motion.end - motion.start)[:, None] * PLACES
        places = segment.states(times.ravel())[:2].reshape(2, *times.shape)
        low, high = places.min(axis=2), places.max(axis=2)
        more = BEYOND * (high - low)
        xi1, xi2 = zip(low - more, high + more, strict=True)
        around, unproven = cores(case, np.array(xi1), np.array(xi2), np.zeros(len(motion.start)))
        long = motion.end - motion.start > 64 * EPS * motion.end
        if not (long & unproven).any():
            break
        middle = 0.5 * (motion.start + motion.end)
        edges = np.sort(np.concatenate([motion.start, motion.end[-1:], middle[long & unproven]]))
    return motion, around


def _poses(case: Case, segment: Segment, times: np.ndarray) -> np.ndarray:
    """(x, y, θ) of the plate in contact, shape (3, n)."""
    states = segment.states(times)
    x, y, theta = pose(case, states[0], states[1])
    return np.array([x, y, theta])


def _locate(case: Case, segment: Segment, meeting: Meeting) -> Meeting:
    """The zero of the gap at a meeting's pair of points, to rounding."""
    from scipy.optimize import brentq  # slow to import, and most motions never come here

    pair = meeting.xi1, meeting.xi2
    if isnan(meeting.xi2):
        theta = float(_poses(case, segment, np.array([meeting.time]))[2, 0])
        pair = meeting.xi1, facing(case, meeting.xi1, theta)

    def contact(t: float) -> Contact:
        x, y, theta = _poses(case, segment, np.array([t]))[:, 0].tolist()
        return find(case, x, y, theta, pair)

    try:
        time = _zero(lambda t: contact(t).gap, meeting.time, brentq)
        at = contact(time)
        return Meeting(time, at.xi1, at.xi2)
    except (DoesNotFit, ValueError):
        return Meeting(meeting.time, *pair)  # no simple touch (two flat sides): accurate to the search only


def _zero(gap: Callable[[float], float], near: float, root: Callable[..., float]) -> float:
    """A zero at which a gap closes. Raises ValueError if there is none near."""
    wide = max(4.0 * EPS * abs(near), 1e-300)
    for _ in range(MOST_WIDENINGS):
        if gap(near - wide) > 0.0 >= gap(near + wide):
            return float(root(gap, near - wide, near + wide, xtol=1e-15, rtol=8.9e-16))
        wide *= 4.0
    raise ValueError("the gap does not close")
