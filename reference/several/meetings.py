"""Further contacts of a plate with several watched ones: the search by boxes outside the surroundings of these."""

from __future__ import annotations

from functools import partial

import numpy as np

from cases import Case
from cases.contact import find
from cases.contact_pairs import PairCase
from cases.corner import Corner

from ..minimal.boxes import Cores, Geometry
from ..minimal.contact_cores import cores
from ..minimal.curve_pieces import Pieces
from ..minimal.element_meetings import fine, points_at
from ..minimal.gap import facing
from ..minimal.integrators.segment import Segment
from ..minimal.meetings import Meeting, MeetingSearch
from ..minimal.second_contacts import BEYOND, HALVINGS, PLACES, TOGETHER, _zero
from ..minimal.windows import EPS, Windows, windows
from .regimes import regime_of


def first_meeting(contact: PairCase, search: MeetingSearch, segment: Segment) -> Meeting | None:
    """The first meeting of plate and support in a segment at another place than the watched contacts of that pair; None
    if there is none. Raises TooMuch."""
    edges = (
        fine(partial(_poses, segment), np.unique(segment.times)) if _is_corner(contact) else np.unique(segment.times)
    )
    for first in range(0, len(edges) - 1, TOGETHER):
        motion, around = _in_windows(contact, segment, edges[first : first + TOGETHER + 1])
        meeting = search.first(motion, around)
        if meeting is not None:
            return _locate(contact, segment, meeting)
    return None


def _in_windows(contact: PairCase, segment: Segment, edges: np.ndarray) -> tuple[Windows, list[Cores]]:
    """Steps in windows so short that every contact is the only one in its surroundings, and these."""
    watched = [k for k, number in enumerate(regime_of(segment.phase).pairs) if number == contact.number]
    for _ in range(HALVINGS):
        motion = windows(partial(_path, contact, segment), edges, contact.whole.plate.reach)
        times = motion.start[:, None] + (motion.end - motion.start)[:, None] * PLACES
        states = segment.states(times.ravel())
        around, unproven = [], np.zeros(len(motion.start), dtype=bool)
        for k in watched:
            places = states[3 + 2 * k : 5 + 2 * k].reshape(2, *times.shape)
            low, high = places.min(axis=2), places.max(axis=2)
            more = BEYOND * (high - low)
            gap = np.maximum(gaps(contact, states, k).reshape(times.shape).max(axis=1), 0.0)
            xi1, xi2 = zip(low - more, high + more, strict=True)
            one, doubtful = cores(contact, np.array(xi1), np.array(xi2), gap)
            around.append(one)
            unproven |= doubtful
        long = motion.end - motion.start > 64 * EPS * motion.end
        if not (long & unproven).any():
            break
        middle = 0.5 * (motion.start + motion.end)
        edges = np.sort(np.concatenate([motion.start, motion.end[-1:], middle[long & unproven]]))
    return motion, around


def gaps(contact: Case, states: np.ndarray, k: int) -> np.ndarray:
    """The distance (m) of contact k's points along the track's normal."""
    x, y, theta = states[:3]
    xi1, xi2 = states[3 + 2 * k : 5 + 2 * k]
    track = contact.track
    (X, Y), (u, v), (nx, ny) = track.point(xi1), contact.plate.outline.point(xi2), track.normal(xi1)
    c, s = np.cos(theta), np.sin(theta)
    return np.asarray((x + c * u - s * v - X) * nx + (y + s * u + c * v - Y) * ny)


def search_of(contact: PairCase) -> MeetingSearch:
    """The search for meetings of a pair; a corner is a point."""
    whole = contact.whole
    if _is_corner(contact):
        geometry = Geometry(Pieces(contact.track), None, 0.0, whole.plate.reach)
    else:
        geometry = Geometry.of_case(contact)
    return MeetingSearch(geometry, whole.weight / whole.plate.mass)


def _is_corner(contact: PairCase) -> bool:
    return isinstance(contact.plate.outline, Corner)


def _path(contact: PairCase, segment: Segment, times: np.ndarray) -> np.ndarray:
    """The poses of the plate, or the places of a corner as poses that do not turn, (3, n)."""
    poses, feature = _poses(segment, times), contact.plate.outline
    return points_at(poses, feature.x, feature.y) if isinstance(feature, Corner) else poses


def _poses(segment: Segment, times: np.ndarray) -> np.ndarray:
    return segment.states(times)[:3]


def _locate(contact: PairCase, segment: Segment, meeting: Meeting) -> Meeting:
    """The zero of the gap at a meeting's pair of points, to rounding, with both parameters."""
    from scipy.optimize import brentq

    pair = meeting.xi1, meeting.xi2
    if np.isnan(meeting.xi2):
        pair = meeting.xi1, facing(contact, meeting.xi1, float(_poses(segment, np.array([meeting.time]))[2, 0]))

    def at_time(t: float):
        x, y, theta = _poses(segment, np.array([t]))[:, 0].tolist()
        return find(contact, x, y, theta, pair)

    try:
        time = _zero(lambda t: at_time(t).gap, meeting.time, brentq)
    except ValueError:
        time = meeting.time  # it touches without closing: two flat sides, or a start
    at = at_time(max(time, segment.start))
    return Meeting(max(time, segment.start), at.xi1, at.xi2)
