"""The general chart: plates with any contacts, in poses; the phases of their motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from math import inf
from typing import cast

import numpy as np

from cases import Belt, Case, Mode
from cases.contact import belt_speed, start_motion
from cases.curves.corner import Corner
from cases.motion.trajectory import CONTACT
from cases.scene.contact_limits import has_features
from cases.scene.free_plates import plates_of
from cases.scene.piece_case import LEVEL, is_concave, touching_corners

from ..effect_laws.friction import STICKING
from ..endings import (
    CAUSES,
    CORNERS_MEET,
    FLAT,
    Ending,
)
from ..minimal.assembly import PIECE_ENDS
from ..minimal.element_meetings import ElementMeeting, points_at
from ..minimal.impact import ContactVelocity
from ..minimal.integrators.segment import Segment, Segments
from ..minimal.modes import start_pieces, start_state
from ..scales import IDLE, ROUGH, STILL, TOUCHES, error_range, frequency, looks_between
from . import forces
from .accelerations import balance_of, first_loss, first_loss_in, is_steady, looks_at_load, rest_margin
from .contact_chart import ContactChart, Departure, pair_in_couple
from .hops import NestedSeries
from .impact_ends import MAY_LAND
from .meet import TIE, ending_at, until_meeting
from .phase_events import PhaseEvents
from .places import couple_of, groups, place, plates_in, sides_of, start_of
from .plate_numbers import rigid_pairs, size, speed
from .regimes import SolverPhase, SolverRegime, regime_of, solver_phase, split
from .segment_view import view_of
from .touching import contacts_at_start, touching_contacts
from .watched_plates import Watch

# A plate that came to lie flat touches with all contacts within this part of its size: a side counts as flat within a
# turn of 1e-11 (`cases.scene.piece_case.LEVEL`).
MEETS = 1e-11
# A motion with a plate in flight is integrated over this many of its time scales at once.
FLIES = 4.0
# The same where its contact is followed: a longer one would add up the errors of its gap.
FOLLOWS = 64.0
# A side lies down where a corner's direction is beyond its end by more than this, rad: errors of dense output are less.
LIES = 1e-6
# An open contact is followed up to this part of the gap beyond which it may no longer be the only one.
ALONE = 0.5


class PoseChart(PhaseEvents):
    """The motion of one or several plates from the start of a case, or from where it departed from its only contact's
    coordinates."""

    def __init__(
        self, case: Case, rtol: float, integrate: Callable[..., Segment], segments: Segments, hops: NestedSeries,
        contact: ContactChart | None, no_contacts: Callable[[], str],
    ):  # fmt: skip
        super().__init__(case, start_of(case), hops, rtol)
        self.integrate, self.segments, self.contact = integrate, segments, contact
        self.idle, self.errors, self.no_contacts = 0, error_range(rtol), no_contacts
        self.was_double = False  # whether the plate has touched in two places at once
        self.enter: Callable[[], None] | None = None

    def begin(self, before: Departure | None) -> PoseChart:
        """The chart, to begin with the start of the case or where the motion departs from its contact's coordinates."""
        if before is not None:
            self.t, self.state, self.watches, self.still = before.time, before.state, [], []
        self.idle, self.enter, self.begins = 0, partial(self._enter, before), before is None or before.mode is None
        if self.contact is not None and not self.case.start.in_contact:
            self.begins = False  # an impact at the start is a change of a flight
        return self

    def phase(self) -> Ending | ContactChart | None:
        """Simulate one phase and what follows it, or go over to the coordinates of the only contact. Raises MotionEnds,
        TooMuch, Undecidable, DoesNotFit, LinAlgError."""
        if self.enter is not None:
            enter, self.enter = self.enter, None
            enter()
        self._end_bouncing()
        if self._is_alone():
            assert self.contact is not None
            return self.contact
        regime = self._decide()
        if self.touching and (reason := self.no_contacts()):
            return FLAT[0], f"{FLAT[1]} {reason}"
        return self._phase(regime)

    def _is_alone(self) -> bool:
        """Whether the only contact that touches is the only one of its track, and follows in its own coordinates, which
        take its state then."""
        closed = self._closed()
        self.was_double |= len(closed) > 1
        if self.contact is None or len(closed) != 1 or self.fixed or self.at_limit or closed[0].name != CONTACT:
            return False
        (watch,), (at,) = closed, self._places(closed)
        xi1, xi2 = watch.pair.to_whole(*watch.points)
        if self.was_double and not self.contact.excludes_second([xi1]):
            return False
        slip, omega, still = at.slip(self.velocity, self.t), self.state[5], STILL * self.speed
        touch = ContactVelocity(
            slip if abs(slip) > still else 0.0, 0.0, omega if abs(omega) * self.case.plate.reach > still else 0.0
        )
        came_to_rest = self.causes.get(watch.name) == CAUSES["rest"]
        regime = self.contact.enter(self.t, (xi1, xi2), self.state[2], touch, came_to_rest)
        if regime is not None:
            self._record({watch.name: regime.mode})
        return regime is not None

    def _follows(self, watch: Watch, gap: float) -> bool:
        watch.room = ALONE * self.contact.room([watch.points[0]]) if self.contact is not None else 0.0
        return gap < watch.room

    def _is_proven(self, segment: Segment) -> bool:
        """Whether a contact that is followed in a segment is the only one that may close."""
        regime = regime_of(segment.phase)
        if self.contact is None or len(regime.rooms) != 1 or not regime.rooms[0] or regime.modes[0] is not Mode.FLIGHT:
            return False
        return self.contact.is_bounded or regime.rooms[0] <= ALONE * self.contact.room(
            segment.states(segment.times)[self.half].tolist()
        )

    def _decision_errors(self) -> Sequence[float]:
        return self.errors if self.idle <= IDLE else (ROUGH,)

    def _enter(self, before: Departure | None) -> None:
        """Watch all contacts of the first pose; that of a departure keeps the first name, its mode and its velocities.
        A plate that begins on two places of a smooth track has that name at its start's contact."""
        own, touching = cast(Watch | None, None), list[Watch]()
        if before is not None:
            self.was_double |= not before.opens
            own = self._watch(before.pair, before.points)
            touching.append(own)
            own.mode = before.mode or Mode.FLIGHT
            if before.opens and self.contact is not None:  # its force has vanished
                self.touching = {own.name}
                self._settle(set())
                self.touching, self.causes[own.name] = set(), CAUSES["normal_force"]
                return
        elif not self.case.others and not has_features(self.case):
            begin = start_motion(self.case)
            xi1, xi2 = start_state(self.case)[:2] if self.case.start.in_contact else (begin.xi1, begin.xi2)
            own_pair = pair_in_couple(self.case, start_pieces(self.case))
            if self.case.start.in_contact or self.contact is not None:
                watch = self._watch(own_pair, (xi1, xi2))
                (at,) = self._places([watch])
                if self.case.start.in_contact or self.case.start.gap <= 0.0:
                    touching.append(watch)
                elif self._follows(watch, at.gap) and at.gap > TOUCHES * size(self.case, self.state):
                    return
        if before is None:
            touching += [self._watch(*one) for one in contacts_at_start(self.case, self.state)]
        else:
            touching += [self._watch(*one) for one in touching_contacts(self.case, np.array(self.state), MEETS)]
        if before is not None and before.meeting is not None:
            touching.append(self._watch(before.meeting.pair, (before.meeting.xi1, before.meeting.xi2)))
        self.touching = {watch.name for watch in touching}
        stuck = {own.name} if own is not None and own.mode in STICKING else set[str]()
        self._settle(stuck, closing=self.touching - ({own.name} if own is not None else set()))
        if own is not None and before is not None and before.opens and own.name in self.touching:
            self.causes[own.name], self.fixed = CAUSES["normal_force"], {own.name: (Mode.FLIGHT,)}

    def _phase(self, regime: SolverRegime) -> Ending | None:
        """Integrate one phase and apply its event; returns an ending, or None."""
        phase = solver_phase(self.case, regime)
        low = self._low_hops(phase)
        if low:
            self.touching = {w.name for w in self.watches if w.mode is not Mode.FLIGHT} | low
            self.causes = dict.fromkeys(low, CAUSES["rest"])
            self._settle({w.name for w in self.watches if w.mode in STICKING})
            return None
        y = self._variables(phase)
        limit, holders = self._limit_of_rest(regime)
        phase = phase._replace(is_past=self.meetings.past_of(self.state, regime.resting))
        segment = self.integrate(phase, self.t, y, min(self._until(phase, y, regime), limit), self.rtol)
        loss = self._loss_of_guides(segment, regime)
        if loss is not None:
            segment = segment.cut(loss, None)
            limit, holders = (
                loss,
                {name for name, used in zip(regime.names, regime.guides, strict=True) if used is not None},
            )
        self.partings = [one for one in self.partings if one[0] == segment.start]
        meeting: ElementMeeting | None = None
        if not self._is_proven(segment):
            meeting = self.meetings.first(view_of(segment, tuple(pair for _, pair in self.partings)))
        is_event = segment.event.guard is not None
        if is_event and meeting and ending_at(meeting) and meeting.time >= segment.event.time * (1.0 - TIE):
            meeting = None  # a contact may come to that end, too
        over = self._lies_down(segment) if meeting is None or meeting.time > segment.event.time else None
        if over is not None:
            segment = segment.cut(over, None)
        if meeting is not None and meeting.time <= segment.event.time:
            segment = until_meeting(
                segment,
                meeting,
                partial(self.integrate, phase),
                self.rtol,
                lambda last: split(self.case, last.event.state)[0],
            )
        else:
            meeting = None
        self._advance(segment)
        self.touching = {watch.name for watch in self.watches if watch.mode is not Mode.FLIGHT}
        self.still = rigid_pairs(regime.turns)
        stuck = {watch.name for watch in self.watches if watch.mode in STICKING}
        if meeting is not None:
            if (ending := ending_at(meeting)) is not None:
                return ending
            if self._corners_meet(segment, meeting):
                return CORNERS_MEET
            if self.contact is not None and not self.touching:
                self.watches.clear()  # wherever the plate lands, it is its only contact
            self._watch_touching()
            watch = self._watch(meeting.pair, (meeting.xi1, meeting.xi2))
            self._settle(stuck, closing={watch.name})
            return None
        if over is not None:
            before = {watch.name for watch in self.watches}
            self._watch_touching(MAY_LAND)
            self._settle(stuck, closing={watch.name for watch in self.watches} - before)
            return None
        if segment.event.guard is None and self.t == limit:
            self.at_limit, self.causes = holders, dict.fromkeys(holders, "the forces at rest reached their limit")
            self.may_slide = loss is None and not stuck & holders
            self._settle(stuck, self._closing())
            return None
        return self._event(segment, stuck)

    def _lies_down(self, segment: Segment) -> float | None:
        """When a side lies down in a segment, s: the direction of a closed contact at a corner passes its end. Where
        dense output has an error, the gap of the side's other end may not be seen to close. None if none does."""
        ends = [
            (self.half + 2 * k + (0 if of_track else 1), step, corner.ends[1 if step > 0 else 0])
            for k, watch in enumerate(self.watches) if watch.mode is not Mode.FLIGHT
            for of_track, step in PIECE_ENDS.values()
            if isinstance(corner := watch.pair.pieces[0 if of_track else 1], Corner) and corner.ends is not None
        ]  # fmt: skip
        states = segment.states(np.array([segment.start, segment.event.time])) if ends else np.zeros((0, 2))
        for row, step, end in ends:
            if step * (states[row, 0] - end) < 0.0 and step * (states[row, 1] - end) > LIES:
                from scipy.optimize import brentq  # slow to import, and most motions never come here

                root = partial(lambda t, row, end: segment.states(np.array([t]))[row, 0] - end, row=row, end=end)
                return float(brentq(root, segment.start, segment.event.time))
        return None

    def _corners_meet(self, flight: Segment, meeting: ElementMeeting) -> bool:
        """Whether a corner meets a corner from which it has not just departed, and the plate touches nothing else. An
        inner corner is met on both sides, whose normals are the directions of the impact."""
        pair, least = meeting.pair, MEETS * size(self.case, self.state)
        corners = touching_corners(pair, meeting.xi1, meeting.xi2) if couple_of(pair).base is None else None
        if corners is None or is_concave(corners):
            return False
        place, state = pair.pieces[0].point(meeting.xi1), np.array(self.state)
        first = flight.states(np.array([flight.start]))[: self.half, 0]
        before = points_at(first[3 * couple_of(pair).body :][:3, None], *pair.pieces[1].point(meeting.xi2))[:2, 0]
        points = [one.pieces[0].point(xi1) for one, (xi1, _) in touching_contacts(self.case, state)]
        away = [float(np.hypot(*(point - place))) for point in (before, *points)]
        return away[0] > least and max(away[1:], default=0.0) <= LEVEL

    def _limit_of_rest(self, regime: SolverRegime) -> tuple[float, set[str]]:
        """When a load that depends on time can no longer be balanced by the contacts of plates at rest (s, infinite if
        they can to the end), and these contacts."""
        if is_steady(self.case, regime.resting):
            return inf, set()
        resting = [watch for watch in self._closed() if set(sides_of(watch.pair)) <= regime.resting]
        now, looks = self._places(resting), looks_at_load(self.case, self.t)
        for group in groups(now):
            some = [now[k] for k in group]
            if is_steady(self.case, plates_in(some)):
                continue
            last = first_loss(partial(rest_margin, self.case, self.state, some), looks)
            if last is not None:
                return last, {resting[k].name for k in group}
        return inf, set()

    def _loss_of_guides(self, segment: Segment, regime: SolverRegime) -> float | None:
        """When forces that are not unique reach their limit in a segment, s; None if they do not."""
        some = [k for k, used in enumerate(regime.guides) if used is not None and regime.modes[k] is not Mode.FLIGHT]
        if not some:
            return None
        phase, half = segment.phase, self.half
        pairs, modes = [self.watches[k].pair for k in some], [regime.modes[k] for k in some]

        def margin(t: float) -> float:
            y = segment.states(np.array([t]))[:, 0]
            state, points = split(self.case, y)
            rates = np.array(phase.system.rates_of_numbers(t, tuple(y.tolist()), phase.parameters))
            now = [place(pair, state, points[k]) for pair, k in zip(pairs, some, strict=True)]
            balance = balance_of(self.case, t, state, rates[len(rates) - half :], now, modes, regime.turns)
            return forces.margin(now, *balance)

        return first_loss_in(segment, margin)

    def _until(self, phase: SolverPhase, y: tuple[float, ...], regime: SolverRegime) -> float:
        """The end of a phase's integration: not far ahead where a plate flies, as it may land."""
        end, holders = self.case.duration, set[int](regime.resting)
        for watch in self.watches:
            if watch.mode is not Mode.FLIGHT:
                holders |= set(sides_of(watch.pair))
        if len(holders) == len(plates_of(self.case)):
            return end
        often, lasts = frequency(phase, self.t, y), FOLLOWS if any(regime.rooms) else FLIES
        # A plate that is far away from its only contact takes as long to come back.
        away = max((at.gap for at in self._places(self.watches)), default=0.0) if any(regime.rooms) else 0.0
        now = speed(self.case, self.state)
        lasts = max(lasts / often, away / now if now else 0.0) if often else end
        return min(end, self.t + max(lasts, 1e3 * float(np.spacing(self.t))))

    def _advance(self, segment: Segment) -> None:
        self.segments.add(segment)
        self.t = segment.event.time
        self.state, points = split(self.case, segment.event.state)
        for watch, pair in zip(self.watches, points, strict=True):
            watch.points = pair
        # A belt may stop, or turn back, at both ends of a step.
        belts = [watch.pair for watch in self.watches if watch.pair.effect(Belt) is not None]
        times = [self.t, *looks_between(segment.times).tolist()] if belts else []
        speeds = [abs(float(belt_speed(pair, t))) for pair in belts for t in times]
        self.speed = max(self.speed, speed(self.case, self.state), *speeds)
