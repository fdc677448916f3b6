"""Flights over tracks and of plates with corners, for the second formulation: samples of the pose, then bisection.

Both curves are polygons here whose sides turn by a hundredth of a radian. Between two samples no point of the plate
moves farther than a small part of its size, or than its distance from the track. Where a vertex of one curve is inside
the other, the gap of a pair of elements has closed: its zero is located on the curves themselves.
"""

from __future__ import annotations

from math import hypot

import numpy as np

from cases import DoesNotFit
from cases.contact.overlap_search import span
from cases.contact.piece_contact import Entry, find_from
from cases.curves.corner import Corner
from cases.scene.piece_case import PieceCase, pieces_at

from .chain_entries import Chains
from .equations import ContactScene
from .flight import FlightCourse, time_to_move
from .motion_state import IN_PROGRESS, EndState, FlightState, LandingState, MotionState
from .short_flights import Hop
from .steps import WorkLimit

# Between two samples the plate's points move by this part of its size, or by so much of the distance from the track.
STEP, OF_DISTANCE = 0.02, 0.5
# The stretch between two samples is halved so often, to see which pair of elements touches first; the landing is then
# polished by Newton's method, with at most so many steps.
HALVINGS, MOST_POLISHES = 25, 20
# Samples of a hop close to the track.
HOP_SAMPLES = 9


def fly(course: MotionState, body: list[float]) -> LandingState | EndState:
    """Simulate a flight until the plate enters its track anywhere, or to the end of the motion."""
    path = FlightCourse(course.scene, course.t, body, course.end, course.rtol, course.steps_per_turn, course.work)
    reach, before, now = course.scene.reach, course.t, body
    chains, middle, spread = _chains(course, 0.0), body, 0.0
    passing = False  # a plate is not stopped by the ends of an open track, and overlaps it while it passes one
    try:
        while before < course.end:
            course.work.count += 1
            if course.work.used_up:
                raise WorkLimit
            now = path(before)
            if hypot(now[0] - middle[0], now[1] - middle[1]) > spread + reach:
                spread = 2.0 * (spread + reach)
                chains = _chains(course, spread)
            away = float(np.hypot(*(chains.points1 - np.array(now[:2])[:, None])).min()) - chains.reach - chains.longest
            way = max(STEP * chains.size, OF_DISTANCE * away)
            after = min(before + time_to_move(course.scene, before, now, reach, way), course.end)
            after = max(after, float(np.nextafter(before, course.end)))
            entry = chains.entry(*path(after)[:3])
            if entry is not None and not passing:
                landing = _landing(course, path, *_first(path, chains, entry, before, after))
                if landing is not None:
                    course.last = FlightState(path(course.t))
                    return landing
            before, passing = after, entry is not None
    except WorkLimit:
        course.t, course.last = before, FlightState(now)
        return EndState(IN_PROGRESS)
    course.t, course.last = course.end, FlightState(path(course.end))
    return EndState("completed")


def _chains(course: MotionState, spread: float) -> Chains:
    """The polygons of both curves, the track's as far as the plate comes near."""
    case, reach = course.case, course.scene.reach
    return Chains(
        case.track, case.plate.outline, *span(case.track, np.array([course.last_xi1]), 4.0 * (reach + spread))
    )


def _first(path: FlightCourse, chains: Chains, entry: Entry, before: float, after: float) -> tuple[float, Entry]:
    """The time at which the plate enters its track, to the accuracy of the polygons, and the pair of elements then."""
    for _ in range(HALVINGS):
        middle = 0.5 * (before + after)
        now = chains.entry(*path(middle)[:3])
        if now is None:
            before = middle
        else:
            after, entry = middle, now
    return after, entry


def _landing(course: MotionState, path: FlightCourse, time: float, entry: Entry) -> LandingState | EndState | None:
    """The landing at a pair of elements, polished with states integrated up to it; None beyond an open track's ends."""
    track, outline = course.case.track, course.case.plate.outline
    for _ in range(MOST_POLISHES):
        body = path.exactly(time)
        try:
            contact = find_from(track, outline, body[0], body[1], body[2], entry)
        except DoesNotFit:
            course.t = time
            return EndState("landing")  # a corner on a corner
        (X, Y), (tx, ty) = track.point(contact.xi1).tolist(), track.tangent(contact.xi1).tolist()
        rx, ry = X - contact.gap * ty - body[0], Y + contact.gap * tx - body[1]
        ux, uy = body[3] - body[5] * ry, body[4] + body[5] * rx
        slip, lift = ux * tx + uy * ty, uy * tx - ux * ty
        step = -contact.gap / lift if lift < 0.0 else 0.0
        if abs(step) <= float(np.spacing(time)):
            break
        time = max(time + step, path.nodes[0][0])
    if track.ends and not track.ends[0] <= contact.xi1 <= track.ends[1]:
        return None
    course.t = time
    xi1, xi2, turns = course.unwind(body[2], contact.xi1, contact.xi2)
    pieces = pieces_at(course.case, xi1, xi2)
    if course.pieces != pieces:
        course.bounces.clear()
        course.scene = ContactScene(pieces, course.drive_load)
    slip -= course.scene.surface(time)[0]
    return LandingState([xi1 - pieces.first.shift, xi2 - pieces.second.shift, body[5], slip], turns, lift)


def leaves_pieces(course: MotionState, pieces: PieceCase, hop: Hop) -> bool:
    """Whether the plate leaves its pieces during a hop, or enters the track elsewhere."""
    for piece, s in zip(pieces.pieces, hop.z[:2], strict=True):
        low, high = piece.span
        if (isinstance(piece, Corner) or not piece.period) and not low <= s <= high:
            return True
    chains, xi1 = _chains(course, 0.0), course.on_curves(hop.z)[0]
    bodies = hop.bodies(np.linspace(0.0, hop.duration, HOP_SAMPLES))
    return any(chains.entry(x, y, theta, xi1) is not None for x, y, theta in bodies[:3].T.tolist())
