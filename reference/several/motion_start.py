"""Where a motion with several contacts begins: at a second contact of a motion with one, or at a case's start."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cases import Case, DoesNotFit, Mode, Transition
from cases.contact import start_motion
from cases.contact_pairs import WatchedPair, contact_name, pairs, pairs_in_pose
from cases.supports import TRACK
from cases.trajectory import CONTACT

from ..minimal.integrators.segment import Segment
from ..minimal.phase_end import Ending
from .contact_law import STICKING
from .geometry import TOUCHES, places
from .march import SeveralSimulation
from .watched_plate import WatchState, open_watches

# A plate that came to lie flat touches with all contacts within this part of its size: a side counts as flat within a
# turn of 1e-11 (`cases.piece_case.LEVEL`).
MEETS = 1e-11
# Two contacts are different ones if their points on the track are farther apart than this part of the plate's size.
APART = 1e-6


def touches_at_start(case: Case, pair: tuple[float, float]) -> bool:
    """Whether the plate touches its track at that pair, too, in its start, to rounding."""
    if not case.start.in_contact:
        return False
    begin = start_motion(case)
    try:
        at = places(pairs(case)[:1], [begin.x, begin.y, begin.theta], [pair])[0]
    except DoesNotFit:  # it is far away
        return False
    off = case.track.point(at.xi1) - case.track.point(begin.xi1)
    if float(np.hypot(*off)) <= APART * case.plate.reach:
        return False  # Newton's method has come to the start's own contact
    return abs(at.gap) <= TOUCHES * (abs(begin.x) + abs(begin.y) + case.plate.reach)


def until_end(
    case: Case, t: float, body: Sequence[float], own: tuple[float, float], mode: Mode, other: tuple[float, float],
    rtol: float, integrate: Callable[..., Segment],
) -> tuple[list[Segment], list[Transition], Ending]:  # fmt: skip
    """Continue a motion whose plate (x, y, θ, vx, vy, ω) has a contact at the pair `own`, in that mode, and meets its
    track at the pair `other`: (segments, transitions, (status, sentence))."""
    track, further = pairs(case)[0], contact_name(TRACK, 2)
    watches = [WatchState(CONTACT, track, own, mode, 0.0), WatchState(further, track, other, Mode.FLIGHT, 0.0)]
    march = SeveralSimulation(case, rtol, integrate, t, list(body), watches)
    march.touching = {CONTACT, further}
    march.begins = t == 0.0
    if mode in STICKING:
        march.stuck = {CONTACT}
    ending = march.simulate()
    return march.segments, march.transitions, ending


def from_start(
    case: Case, rtol: float, integrate: Callable[..., Segment]
) -> tuple[list[Segment], list[Transition], Ending]:
    """The motion of a case whose contacts are pairs of a support and a feature from its start on: (segments,
    transitions, (status, sentence))."""
    begin = start_motion(case)
    body = [float(v) for v in (begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega)]
    march = SeveralSimulation(case, rtol, integrate, 0.0, body, _all_watches(case, body))
    march.begins = True
    ending = march.simulate()
    return march.segments, march.transitions, ending


def from_flat_side(
    case: Case, t: float, body: Sequence[float], xi1: float, mode: Mode, rtol: float, integrate: Callable[..., Segment]
) -> tuple[list[Segment], list[Transition], Ending]:
    """Continue a motion whose plate (x, y, θ, vx, vy, ω) has come to touch its track with a flat side, or with two
    corners, at time t: (segments, transitions, (status, sentence)).

    `mode`: that of the contact at `xi1` until then, FLIGHT if there was none.
    """
    watches, size = _all_watches(case, body), abs(body[0]) + abs(body[1]) + case.plate.reach
    now = places([watch.contact for watch in watches], body, [watch.pair for watch in watches])
    touching = [w for w, at in zip(watches, now, strict=True) if abs(at.gap) <= MEETS * size and not w.is_away]
    march = SeveralSimulation(case, rtol, integrate, t, list(body), watches)
    march.begins = t == 0.0
    if mode is not Mode.FLIGHT:
        place = case.track.point(xi1)
        away = [float(np.hypot(*(case.track.point(watch.pair[0]) - place))) for watch in touching]
        own = touching[int(np.argmin(away))]
        own.name, own.mode = CONTACT, mode
        march.stuck = {CONTACT} if mode in STICKING else set()
    march.touching = {watch.name for watch in touching}
    ending = march.simulate()
    return march.segments, march.transitions, ending


def _all_watches(case: Case, body: Sequence[float]) -> list[WatchState]:
    """The contacts that are watched from a pose on: all pairs with unique nearest points, and others that touch."""
    watches = pairs_in_pose(case, *body[:3])
    searched = (pair for pair in pairs(case) if not pair.has_unique_points)
    watches += [WatchedPair(pair, points, False) for pair in searched for points in pair.touching_points(*body[:3])]
    return open_watches(sorted(watches, key=lambda one: one.pair.number))
