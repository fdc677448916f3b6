"""Landings: the first instant of a flight at which the outline meets the track again, at any place.

The flight itself is integrated like any phase, without regard to the track. If the curvatures allow only one pair of
nearest points (`curvature_proof`), that pair is followed in steps: bounds on the gap's rate and its changes exclude a
zero until the next step. Otherwise, or if that pair is lost, boxes of time, track and outline are searched
(`meetings`). A flight that ends before the first of these steps is a hop (`gap`).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property, partial
from math import inf, isnan, nan, sqrt
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.contact import Contact, belt_speed, pose
from cases.contact.overlap_search import span

from ..curvature_proof import Room, room
from ..effect_laws import laws
from ..scales import EPS, TOUCHES
from .boxes import Cores, Geometry, cores
from .gap import Look, Looks, facing, first_look, state, touch
from .impact import ContactVelocity
from .integrators.segment import Segment
from .meetings import Meeting, MeetingSearch
from .windows import DEGREE, PARABOLA, Windows, windows

# A pair is followed up to this part of the gap beyond which it may no longer be the only nearest one.
ALONE = 0.5
# A flight is searched in stretches of time; in the first the plate moves by this many of its sizes, then twice as far
# each time.
STRETCH = 4.0
# The plate's reach is computed from so many points that adding a thousandth makes it a bound.
REACH = 1.001
# Limit on the steps of Newton's method for the zero of a gap, from a start that is accurate to some digits.
STEPS = 20


class Landing(NamedTuple):
    """A landing: time (s), contact parameters, θ, the contact's velocity, and the arm to it (m; NaN at the end of
    bouncing)."""

    time: float
    xi1: float
    xi2: float
    theta: float
    touch: ContactVelocity
    arm_t: float = nan
    arm_n: float = nan


class Landings:
    """The search for landings in a motion; counts its work; until `flies_until` (s) the last flight has no landing."""

    def __init__(self, case: Case) -> None:
        self.case, self.looks, self.flies_until = case, Looks(case), nan
        self.size = REACH * case.plate.reach
        self.degree = PARABOLA if all(load.is_uniform for load in laws(case).loads) else DEGREE
        self.pair: tuple[float, float] | None = None  # the pair that is followed, between segments

    @cached_property
    def search(self) -> MeetingSearch:
        """The search by boxes, with its count of work."""
        return MeetingSearch(Geometry.of_case(self.case), self.case.weight / self.case.plate.mass)

    def start_impact(self, segment: Segment) -> Landing:
        """The impact of a start in contact with a closing velocity, also if gravity pulls the plate off its track; its
        velocities are the start's own, without rounding."""
        start = self.case.start
        xi1, xi2 = start.xi1, start.motion(self.case.track, self.case.plate.outline).xi2
        landing = self._landing(segment, Look(0.0, Contact(xi1, xi2, 0.0), nan, nan, nan, True), xi1)
        return landing._replace(touch=ContactVelocity(start.slip, start.gap_rate, start.omega))

    def first(self, segment: Segment, place: tuple[float, float], under_way: bool = False) -> Landing | None:
        """The first landing of a flight's segment; None if it flies on. Raises TooMuch at the limit on work.

        `place` is the pair of points of the last contact. `under_way`: the segment continues a flight that has not
        landed so far.
        """
        self.pair = self.pair if under_way else place
        start = float(segment.times[0])
        self.flies_until = start
        before = self.looks.at(segment, start, self.pair) if self.pair else None
        if before is not None and not self._on_track(before):
            before = None
        if before is not None and under_way and before.gap <= 0.0:
            return self._landing(segment, before, place[0])  # by a rounding
        if before is not None and not under_way and before.gap <= TOUCHES * self.size:
            landing, before = self._leave(segment, before, place[0])
            if landing:
                return landing
        since, motion = start, windows(partial(poses, segment), segment.times, self.size, self.degree)
        if before is not None:
            landing, since = self._follow(segment, motion, before, place[0])
            if landing or self.pair:
                return landing
        for some in self._stretches(segment, motion, since):
            self.flies_until = float(some.start[0])
            meeting = self.search.first(some)
            if meeting is not None:
                return self._landing_at(segment, meeting, place[0])
        return None

    # --- one pair of points -------------------------------------------------------------------------------------------

    def _leave(self, segment: Segment, start: Look, near: float) -> tuple[Landing | None, Look]:
        """The landing in a flight's first moments, which begin at a contact, and the look up to which they go."""
        first = first_look(self.looks, segment, start)
        look = first or start
        other = self._elsewhere(segment, start, look)
        if other is not None:
            return self._landing_at(segment, other, near), look
        if first is None or not isnan(first.beyond):
            return self._landing(segment, look, near), look
        return None, look

    def _follow(self, segment: Segment, motion: Windows, before: Look, near: float) -> tuple[Landing | None, float]:
        """The landing at the only nearest pair, and the time (s) until which there is none. If the pair is lost, or no
        longer the only one, `pair` is set to None."""
        window, end = 0, float(motion.end[-1])
        while before.time < end:
            self.flies_until = before.time
            while motion.end[window] <= before.time:
                window += 1
            free = self._room(before.contact.xi1)
            if not before.gap < ALONE * free.gap:
                return self._stop_following(before.time)
            step = self._clear(motion, window, before, free)
            now = self._ahead(segment, before, min(before.time + step, float(motion.end[window])), free)
            if now is None:
                return self._stop_following(before.time)
            still = now.time <= before.time  # the clear time is no more than a rounding
            if now.gap <= 0.0 or (now.rate < 0.0 and (still or now.gap <= self._rounding(segment, now))):
                return self._landing(segment, self._closed(segment, now), near), now.time
            if still:
                return self._stop_following(float(np.nextafter(before.time, inf)))
            before = now
        self.pair = before.pair
        return None, end

    def _stop_following(self, time: float) -> tuple[None, float]:
        """Stop following the pair at that time."""
        self.pair = None
        return None, time

    def _ahead(self, segment: Segment, before: Look, time: float, free: Room) -> Look | None:
        """The same pair at a later time, or at an earlier one if it is not found there; None if it is lost."""
        for _ in range(STEPS):
            now = self.looks.at(segment, time, before.pair, far_turn=True)
            if now is not None and self._on_track(now) and -ALONE * self.size < now.gap < free.gap:
                return now
            time = 0.5 * (before.time + time)
        return None

    def _clear(self, motion: Windows, window: int, look: Look, free: Room) -> float:
        """The time (s) after a look without a zero of the gap, by bounds on the gap's rate and its changes."""
        pull, spin, swing = (float(row[window]) for row in (motion.pull, motion.spin, motion.swing))
        rest = float(motion.end[window]) - look.time
        turns = 0.0 if self.case.plate.radius is not None else spin * self.size
        gap, sinking = max(look.gap, 0.0), look.centre + turns
        # Its rate is at most the speed of the plate's points.
        clear = 2.0 * gap / (sinking + sqrt(sinking**2 + 2.0 * pull * gap)) if gap else 0.0
        within = rest
        for _ in range(2):
            speed = min(float(motion.speed[window]), look.centre + pull * within) + turns
            spare_gap = ALONE * free.gap + 0.25 * free.gap - gap
            if speed * within > spare_gap:
                within = spare_gap / speed
            bend = self._bending(free, gap + speed * within, speed, spin, swing) + pull
            root = sqrt(look.rate**2 + 2.0 * bend * gap)
            if look.rate < 0.0:
                zero_time = 2.0 * gap / (root - look.rate)
            else:
                zero_time = (look.rate + root) / bend if bend else inf
            clear = max(clear, min(zero_time, within))
            within = min(within, 4.0 * clear)
        return min(clear, rest)

    def _bending(self, free: Room, gap: float, speed: float, spin: float, swing: float) -> float:
        """A bound on the acceleration (m/s²) with which the gap closes, without that of the centre of mass.

        With the curvatures a of the track and b of the outline, slip v and spin ω, arm (c, d), gap γ and n = 1 − a γ
        the gap's acceleration is the pull's + c ω' − d ω² − (n ω − a v)²/(n (b n − a)) − a v²/n; that of a disc whose
        centre has the speed u is the pull's − a u²/(1 − a (r + γ)). (Derived from the rates of the pair.)
        """
        (lowest, highest), least = free.track, free.outline[0]
        valley = max(highest, 0.0)
        if self.case.plate.radius is not None:
            return speed**2 * valley / (1.0 - valley * (self.case.plate.radius + gap))
        most, near, far = max(abs(lowest), abs(highest)), 1.0 - valley * gap, 1.0 + max(-lowest, 0.0) * gap
        fits = least - (highest * (1.0 + least * gap) if highest > 0.0 else highest)
        turning = (far * spin + most * speed) ** 2 / (near * fits)
        return (swing + spin**2) * self.size + turning + valley * speed**2 / near

    def _room(self, xi1: float) -> Room:
        """The room around a place of the track."""
        track, outline = self.case.track, self.case.plate.outline
        return room(track, outline, *span(track, np.array([self.case.start.xi1, xi1]), self.case.plate.reach))

    def _on_track(self, look: Look) -> bool:
        """Whether both points of a pair lie on their curves, and the plate on the track's left."""
        for curve, at in zip((self.case.track, self.case.plate.outline), look.pair, strict=True):
            if curve.ends and not curve.ends[0] <= at <= curve.ends[1]:
                return False
        return look.facing

    def _rounding(self, segment: Segment, look: Look) -> float:
        """The rounding of a gap, m."""
        x, y, *_ = state(segment, look.time)
        return 0.5 * EPS * (self.size + abs(x) + abs(y))

    # --- boxes --------------------------------------------------------------------------------------------------------

    def _elsewhere(self, segment: Segment, start: Look, look: Look) -> Meeting | None:
        """A meeting before a look at another pair than the one at which the flight began; None if there is none."""
        if not look.time > start.time or max(look.gap, 0.0) < ALONE * self._room(start.contact.xi1).gap:
            return None
        motion = windows(partial(poses, segment), np.array([start.time, look.time]), self.size, self.degree)
        ends = np.sort([start.pair, look.pair], axis=0)
        ends += np.array([[-0.5], [0.5]]) * np.diff(ends, axis=0)  # between the looks it may go a little beyond
        around, _ = cores(self.case, ends[:, :1], ends[:, 1:], np.array([max(look.gap, start.gap, 0.0)]))
        whole = Cores(*(np.repeat(column, len(motion.start), axis=1) for column in around))
        return self.search.first(motion, [whole])

    def _stretches(self, segment: Segment, motion: Windows, since: float) -> Iterator[Windows]:
        """The motion from time `since` on, in stretches in which the plate moves by some of its sizes, each twice as
        far as the last."""
        limit, distance, edges = STRETCH * self.size, 0.0, [since]
        speeds = motion.speed + motion.spin * self.size
        for start, end, speed in zip(motion.start.tolist(), motion.end.tolist(), speeds.tolist(), strict=True):
            time = max(start, since)
            while time < end:
                until = time + (limit - distance) / speed if speed > 0.0 else end
                until = end if not until < end - 1e-9 * (end - start) else until
                edges.append(until)
                distance += speed * (until - time)
                time = until
                if distance >= (1.0 - 1e-9) * limit:
                    yield windows(partial(poses, segment), np.array(edges), self.size, self.degree)
                    limit, distance, edges = 2.0 * limit, 0.0, [time]
        if len(edges) > 1:
            yield windows(partial(poses, segment), np.array(edges), self.size, self.degree)

    # --- the landing itself -------------------------------------------------------------------------------------------

    def _landing_at(self, segment: Segment, meeting: Meeting, near: float) -> Landing:
        """The landing at a meeting."""
        pair = meeting.xi1, meeting.xi2
        if isnan(meeting.xi2):
            pair = meeting.xi1, facing(self.case, meeting.xi1, state(segment, meeting.time)[2])
        look = self.looks.at(segment, meeting.time, pair)
        if look is None:
            look = Look(meeting.time, Contact(*pair, 0.0), nan, nan, nan, True)
        return self._landing(segment, self._closed(segment, look), near)

    def _closed(self, segment: Segment, look: Look) -> Look:
        """The zero of a pair's gap next to a look, by Newton's method."""
        for _ in range(STEPS):
            time = look.time - look.gap / look.rate if look.rate < 0.0 else look.time
            if abs(look.gap) <= self._rounding(segment, look) or abs(time - look.time) <= np.spacing(look.time):
                break
            now = self.looks.at(segment, max(time, segment.start), look.pair)
            if now is None or not abs(now.gap) < abs(look.gap):
                break
            look = now
        near_enough = look.rate < 0.0 and abs(look.gap) <= -4.0 * look.rate * np.spacing(look.time)
        return look._replace(beyond=-look.gap / look.rate if near_enough else nan)

    def _landing(self, segment: Segment, look: Look, near: float) -> Landing:
        """The landing at a look: the state is advanced by the difference between the exact and the rounded time.

        Rounded times alone would change the energy of a plate that bounces for long. The parameters on closed curves
        continue from `near`, where the track was touched last.
        """
        now = state(segment, look.time)
        if not isnan(look.beyond):
            rates = segment.phase.system.rates_of_numbers(look.time, now, segment.phase.parameters)
            now = [value + look.beyond * rate for value, rate in zip(now, rates, strict=True)]
        at, arm_t, arm_n = touch(self.case, now, look.contact)
        at = at._replace(slip=at.slip - belt_speed(self.case, look.time))
        return Landing(look.time, *_with_turns(self.case, look.contact, now[2], near), now[2], at, arm_t, arm_n)


def poses(segment: Segment, times: np.ndarray) -> np.ndarray:
    """(x, y, θ) of the plate in flight, shape (3, n)."""
    return segment.states(times)[:3]


def _with_turns(case: Case, contact: Contact, theta: float, near: float) -> tuple[float, float]:
    """The contact's parameters with the whole turns that bring the track's next to `near` and give θ itself by (6)."""
    period, again = case.track.period or 0.0, case.plate.outline.period or 0.0
    xi1 = contact.xi1 + period * round((near - contact.xi1) / period) if period and again else contact.xi1
    turns = round((float(pose(case, xi1, contact.xi2)[2]) - theta) / (2 * np.pi))
    return (xi1, contact.xi2 + turns * again) if again else (xi1 - turns * period, contact.xi2)
