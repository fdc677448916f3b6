"""The quick chart: one plate with one contact, in the contact's own coordinates.

A second contact is excluded by curvatures, or searched along each phase (`meet`). Where it closes, the contact opens,
or, on a curve with corners, reaches an inner corner or a flat side, the motion departs to poses (`pose_chart`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache, partial
from typing import NamedTuple

import numpy as np

from cases import Case, Mode, Transition
from cases.contact import pose, start_motion
from cases.contact.overlap_search import span
from cases.contact.piece_contact import excludes_second
from cases.motion.trajectory import CONTACT
from cases.scene.couples import couples
from cases.scene.piece_case import PieceCase, lies_flat, piece_case_of

from ..curvature_proof import fits, room
from ..endings import CAUSES, FLAT, OFF, Ending, second_place
from ..minimal.contact_end import Step, after_contact, contact_step, leave
from ..minimal.decision import AT_BOUND, decide
from ..minimal.element_meetings import ElementMeeting
from ..minimal.impact import ContactVelocity
from ..minimal.integrators.segment import Segment, Segments
from ..minimal.modes import (
    FLIGHT,
    Regime,
    able,
    candidates,
    full_state,
    in_flight,
    phase_at,
    senses,
    slip_and_spin,
    start_pieces,
    start_state,
    state_in,
)
from ..scales import EPS, IDLE, LOCATION_ERROR, ROUGH
from .hops import NestedSeries
from .meet import Meetings, ending_at, until_meeting
from .places import start_of
from .plate_numbers import load_scale
from .segment_view import SegmentView
from .touching import contacts_at_start

# Meetings nearer to a phase's end than this part of it are the end's: both are events, located to 1e-12.
END = 1e-11


class Departure(NamedTuple):
    """Where a motion goes on in poses: time (s), the plate's state, the mode of its contact (None at a start without
    one), the pair of elements and their own parameters; whether the contact opens; the second contact that closes; and
    how the motion ends if it cannot go on."""

    time: float
    state: tuple[float, ...]
    mode: Mode | None
    pair: PieceCase
    points: tuple[float, float]
    opens: bool
    meeting: ElementMeeting | None
    ending: Ending


class ContactChart:
    """The motion of one plate with one contact at time `t` (s).

    `case`: on the elements of its curves where the contact is; `regime`, `y`: its regime and full state.
    """

    def __init__(
        self, case: Case, rtol: float, integrate: Callable[..., Segment], segments: Segments, hops: NestedSeries
    ):
        self.whole, self.case, self.rtol, self.integrate = case, start_pieces(case), rtol, integrate
        self.t, self.y, self.segments, self.hops, self.idle = 0.0, start_state(case), segments, hops, 0
        self.regime: Regime | None = None
        self.search: Meetings | None = None

    def begin(self, regime: Regime | None) -> None:
        """Begin with the start of the case; `regime`, if it is known."""
        self.regime = first_regime(self.whole, self.y) if regime is None else regime

    def enter(
        self, t: float, place: tuple[float, float], theta: float, touch: ContactVelocity, is_rest: bool
    ) -> Regime | None:
        """Take over a contact at that time, place, angle and velocity; returns its regime, or None if it has none here.
        `is_rest`: bouncing has come to rest."""
        place = self._with_turns(place, theta)
        step = contact_step(self.case, (), t, place, theta, touch, "rest" if is_rest else "landing")
        if step.regime is None or step.regime == FLIGHT:
            return None
        self.t, self.y, self.regime, self.idle = t, step.state, step.regime, 0
        return step.regime

    def _with_turns(self, place: tuple[float, float], theta: float) -> tuple[float, float]:
        """The parameters of a contact with the whole turns that give the angle itself by (6)."""
        (xi1, xi2), period = place, self.whole.plate.outline.period
        turns = round((float(pose(self.whole, xi1, xi2)[2]) - theta) / (2.0 * np.pi))
        return (xi1, xi2 + turns * period) if period else (xi1 - turns * (self.whole.track.period or 0.0), xi2)

    def excludes_second(self, xi1: Sequence[float]) -> bool:
        """Whether curvatures exclude a second contact while ξ₁ has these values."""
        track, outline = self.whole.track, self.whole.plate.outline
        if isinstance(self.case, PieceCase):
            return excludes_second(track, outline)
        return fits(track, outline, *span(track, [self.whole.start.xi1, *xi1], self.whole.plate.reach))

    def room(self, xi1: Sequence[float]) -> float:
        """The gap (m) up to which curvatures exclude a second place of contact, while ξ₁ has these values."""
        track, outline = self.whole.track, self.whole.plate.outline
        return room(track, outline, *span(track, [self.whole.start.xi1, *xi1], self.whole.plate.reach)).gap

    @property
    def is_bounded(self) -> bool:
        """Whether such a proof holds for all of the track."""
        track = self.whole.track
        return track.domain is not None or bool(track.period) or track.features is None

    @cached_property
    def is_alone(self) -> bool:
        """Whether curvatures exclude a second contact from the start on: everywhere, but on a curved track without
        ends."""
        return self.excludes_second(())

    def touches_once(self) -> bool:
        """Whether the motion begins with one contact, or in flight."""
        if isinstance(self.case, PieceCase) and (self.regime is None or lies_flat(self.case, self.y[0], self.y[1])):
            return False
        return self.is_alone or len(contacts_at_start(self.whole, start_of(self.whole))) < 2

    def phase(self) -> Ending | Departure | None:
        """Simulate one phase and what follows it. Raises Undecidable, DoesNotFit."""
        if self.regime is None:
            step = leave(self.case, (), self.t, self.y, "")
            if step.regime == FLIGHT:
                return self._opening(step, None)
            self.y, self.regime = step.state, step.regime
            return step.ending if step.regime is None else None
        now = phase_at(self.case, self.regime, self.y)
        self.y = state_in(now, self.y)
        segment = self.integrate(now, self.t, self.y, self.whole.duration, self.rtol)
        step = after_contact(self.case, segment, self.y, max(self.rtol, LOCATION_ERROR))
        second = self._second_contact(step)
        if second is not None:
            return second
        if step.time == self.t and self.idle >= IDLE and step.regime not in (None, FLIGHT):
            step = self._decide_roughly(step)
        return self._go_on(step)

    def _decide_roughly(self, step: Step) -> Step:
        """The step with another regime after phases of zero length: what began is too small to distinguish from
        rounding. Values within `ROUGH` of their bound count as being at it, and their rates decide."""
        assert self.regime is not None
        others = [r for r in candidates(self.case) if r != self.regime._replace(slack=())]
        following = decide(self.case, step.time, step.state, ROUGH, others)
        return step._replace(regime=following or step.regime)

    def _go_on(self, step: Step) -> Ending | Departure | None:
        """Record a step's segments and change of mode, and take its state."""
        regime, case = self.regime, self.case
        assert regime is not None
        is_at_second = step.ending[0] == FLAT[0] and step.regime is None
        for segment in step.segments:
            self.segments.add(segment)
        if is_at_second:
            return self._departure(self.segments[-1], None, step.ending)
        if step.regime == FLIGHT:
            return self._opening(step, regime.mode)
        following = step.regime.mode if step.regime else Mode.FLIGHT if step.ending in OFF else regime.mode
        self.t, self.case = step.time, step.pieces or case
        if following is not regime.mode:
            xi1, xi2 = self.case.to_whole(*step.place) if isinstance(self.case, PieceCase) else step.place
            change = Transition(self.t, regime.mode, following, xi1, xi2, CAUSES[step.cause], CONTACT)
            self.hops.outer.add([change])  # no impacts keep it back
        if step.regime is None:
            return step.ending
        self.y, self.regime = step.state, step.regime
        return None

    # --- to poses -----------------------------------------------------------------------------------------------------

    def _second_contact(self, step: Step) -> Ending | Departure | None:
        """The departure at the first second contact in a step's segments, which are recorded up to there, or how the
        motion ends there, at an end of the track."""
        for i, segment in enumerate(step.segments):
            if self._is_alone_in(segment):
                continue
            self.search = self.search or Meetings(self.whole)
            case, last = self.case, segment.event.time
            meeting = self.search.first(contact_view(case, self.pair, segment))
            ending = ending_at(meeting) if meeting else None
            if meeting is None or ((ending or isinstance(case, PieceCase)) and meeting.time >= last * (1.0 - END)):
                continue  # at the end of an element the contact meets the next one, or comes to the track's end
            for earlier in step.segments[:i]:
                self.segments.add(earlier)
            again = partial(self.integrate, segment.phase)
            cut = until_meeting(segment, meeting, again, self.rtol, lambda last: self._body_at(last)[0])
            self.segments.add(cut)
            if ending is not None:
                return ending
            xi1 = meeting.pair.to_whole(meeting.xi1, meeting.xi2)[0]
            return self._departure(cut, meeting, second_place(meeting.time, xi1))
        return None

    def _is_alone_in(self, segment: Segment) -> bool:
        """Whether curvatures exclude a second contact in a segment."""
        if isinstance(self.case, PieceCase) or self.is_bounded:
            return self.is_alone
        return self.excludes_second(segment.states(segment.times)[0].tolist())

    @property
    def pair(self) -> PieceCase:
        """The pair of elements of the contact, of the case's only couple."""
        return pair_in_couple(self.whole, self.case)

    def _opening(self, step: Step, mode: Mode | None) -> Departure:
        """The departure where the contact opens that had that mode."""
        return Departure(step.time, step.state, mode, self.pair, step.place, True, None, step.ending)

    def _departure(self, last: Segment, meeting: ElementMeeting | None, ending: Ending) -> Departure:
        """The departure at the end of the last segment, to a second contact."""
        (body, y), mode = self._body_at(last), last.phase.regime.mode
        return Departure(last.event.time, body, mode, self.pair, (y[0], y[1]), False, meeting, ending)

    def _body_at(self, last: Segment) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The plate's pose and velocities at the end of a segment of contact, and its full state."""
        case, t = self.case, last.event.time
        y = full_state(case, last.phase, t, last.event.state)
        return in_flight(case, t, y, *slip_and_spin(case, t, y), 0.0), y


def pair_in_couple(whole: Case, here: Case) -> PieceCase:
    """The pair of elements on which a case is, of the only couple of the whole one."""
    numbers = (here.first.number, here.second.number) if isinstance(here, PieceCase) else (0, 0)
    return piece_case_of(couples(whole)[0], *numbers)


def contact_view(case: Case, pair: PieceCase, segment: Segment) -> SegmentView:
    """A segment of contact as the search for meetings sees it."""

    def poses(times: np.ndarray) -> np.ndarray:
        x, y, theta = pose(case, *segment.states(times)[:2])
        return np.array([x, y, theta])

    def points(k: int, times: np.ndarray) -> np.ndarray:
        return segment.states(times)[:2]

    return SegmentView(segment.times, poses, (pair,), points, lambda k, times: np.zeros(len(times)), frozenset())


def first_regime(case: Case, y: Sequence[float]) -> Regime | None:
    """The regime at time zero of a state of contact: the start specifies the signs of slip and spin; a zero is decided
    as at any instant. None if no contact is consistent. Raises Undecidable."""
    here, weak = start_pieces(case), AT_BOUND * _start_scale(case)
    # Eight roundings lie between the start's values and the speeds of the state. A motion so slow that it ends at once
    # leaves no regime; speeds below an event's own error then count as zero, as after events.
    for error in (8 * EPS, LOCATION_ERROR):
        moves = senses(here, 0.0, y, case.start.slip, case.start.omega, error)
        regime = decide(here, 0.0, y, EPS, able(here, *moves), weak)
        if regime:
            return regime
    return None


@lru_cache(maxsize=1024)
def _start_scale(case: Case) -> float:
    """The size of accelerations (m/s²) at the start."""
    start = start_motion(case)
    return load_scale(case, 0.0, (start.x, start.y, start.theta, start.vx, start.vy, start.omega))
