"""What follows the event at the end of a phase, in poses: a contact that passes on, opens or closes."""

from __future__ import annotations

import numpy as np

from cases import Belt, Case, Mode
from cases.contact import clearance
from cases.scene.piece_case import PieceCase, corner_on_corner, is_concave, neighbour

from ..effect_laws.friction import STICKING
from ..endings import CAUSES, COMPLETION, ENDS, Ending
from ..minimal.assembly import PIECE_ENDS
from ..minimal.contact_end import ending_by
from ..minimal.grazing import may_touch, over_touch
from ..minimal.integrators.segment import Segment
from ..scales import LOCATION_ERROR, TOUCHES
from .couple_search import AT_FLAT
from .hops import NestedSeries
from .meet import Meetings
from .mode_changes import ModeChanges
from .places import couple_of, sides_of
from .regimes import AT_END, ends_flat, is_flat_beyond
from .segment_view import view_of
from .touching import SAME_PLACE, inside, touching_contacts
from .watched_plates import Watch

# Guards of a rotation of plates against each other, which belong to all their contacts.
OF_ROTATION = ("turn", "couple_forward", "couple_backward")
# Guards of forces at their bounds.
OF_FORCES = ("normal", "cone_forward", "cone_backward")
# A contact does not pass to an element on which the clearance of its curvatures is below this part of 1/reach: its
# nearest points would not be next to it.
FITS = 1e-6


class PhaseEvents(ModeChanges):
    """Plates after the events of their phases; a subclass integrates these."""

    def __init__(self, case: Case, state: tuple[float, ...], hops: NestedSeries, rtol: float):
        super().__init__(case, state, hops)
        self.rtol, self.meetings = rtol, Meetings(case)
        # When (s) a contact has left a pair over an end.
        self.partings = list[tuple[float, PieceCase]]()

    def _is_proven(self, segment: Segment) -> bool:
        """Whether a contact that is followed in a segment is the only one that may close."""
        raise NotImplementedError

    def _watch_touching(self, part: float = TOUCHES, of: int | None = None) -> None:
        """Watch also others that close at the same instant, in the order of their elements; `part`, `of` as of
        `touching_contacts`."""
        for pair, points in touching_contacts(self.case, np.array(self.state), part, of):
            self._watch(pair, points)

    def _event(self, segment: Segment, stuck: set[str]) -> Ending | None:
        guard = segment.event.guard
        if guard is None:
            if self.t >= self.case.duration:
                return COMPLETION
            self._settle(stuck)
            return None
        kind, _, number = guard.partition(":")
        if kind in PIECE_ENDS:
            return self._pass_on(self.watches[int(number)], kind, stuck)
        ending = ending_by(self.case, segment, kind)
        if ending is not None:
            return ending
        if kind in OF_ROTATION:
            sides = sides_of(self.watches[int(number)].pair)
            together = {watch.name for watch in self._closed() if sides_of(watch.pair) == sides}
            self.causes |= dict.fromkeys(together, CAUSES[kind])
            self.still = [*self.still, sides]
            self._settle(stuck, self._closing())
            return None
        watch = self.watches[int(number)]
        if kind in OF_FORCES:
            begin = segment.states(np.array([segment.start]))[:, 0].tolist()
            self.may_float = may_touch(segment.phase, segment, guard, begin)
            if self.may_float and self._is_touch(segment, guard):
                self._settle(stuck)
                return None
        # A corner that opened where its side lay flat may have left its directions: then it is no contact that closes.
        if kind in ("lost", "room") or (kind == "gap" and self._is_no_meeting(watch)):
            self.watches.remove(watch)
            self._settle(stuck)
            return None
        if kind == "gap":
            if not self._is_proven(segment):  # the other corner of a side that lies flat
                self._watch_touching(of=couple_of(watch.pair).number)
            self._settle(stuck, closing={watch.name})
            return None
        closing = self._closing()  # an impact at the same instant
        self.causes[watch.name] = CAUSES["normal_force" if kind == "normal" else kind]
        if kind == "slip":
            stuck.add(watch.name)
        if kind == "normal" and not closing:
            self.fixed = {watch.name: (Mode.FLIGHT,)}
        self._settle(stuck, closing)
        return None

    def _is_no_meeting(self, watch: Watch) -> bool:
        """Whether an open contact without a gap is beyond an end of its elements, or at the place of a closed one of
        the same couple, which comes to the same end and passes on from there."""
        if not inside(watch.pair, *watch.points, turn=AT_FLAT):
            return True
        place, reach = watch.pair.pieces[0].point(watch.points[0]), watch.pair.plate.reach
        return any(
            one.pair.whole == watch.pair.whole
            and np.hypot(*(one.pair.pieces[0].point(one.points[0]) - place)) <= SAME_PLACE * reach
            for one in self._closed()
        )

    def _is_touch(self, segment: Segment, guard: str) -> bool:
        """Whether a force that ends a segment at its bound only touches that: the motion goes on beyond."""
        error = max(self.rtol, LOCATION_ERROR)
        across = over_touch(segment.phase, segment, guard, error, self.case.duration)
        if across is None or self.meetings.first(view_of(across)) is not None:
            return False
        self._advance(across)
        return True

    def _pass_on(self, watch: Watch, kind: str, stuck: set[str]) -> Ending | None:
        """The contact has reached an end of an element: it passes to the next one, or ends."""
        of_track, step = PIECE_ENDS[kind]
        piece, s = watch.pair.pieces[0 if of_track else 1], watch.points[0 if of_track else 1]
        if piece.parts is not None and (piece.ends is None or piece.ends[0] < s < piece.ends[1]):
            self.causes[watch.name] = CAUSES[kind]  # a knot
            self._settle(stuck)
            return None
        if watch.pass_time == self.t and not watch.at_joint:  # it came from there at this instant
            watch.at_joint = True
            self._settle(stuck)
            return None
        was_at_joint, watch.pass_time, watch.at_joint = watch.at_joint, self.t, False
        following = neighbour(watch.pair, of_track, step)
        if watch.mode is Mode.FLIGHT and not was_at_joint and is_flat_beyond(watch.pair, of_track, step):
            watch.at_joint = True  # a side that lies flat to rounding may turn back
            self._settle(stuck)
            return None
        if watch.mode is Mode.FLIGHT:
            self.watches.remove(watch)
            self.partings.append((self.t, watch.pair))
            self._settle(stuck)
            return None
        if following is None:
            return ENDS[kind]
        if ends_flat(watch.pair, of_track, step):  # the side reaches the other curve's end
            return ENDS[kind.replace("outline", "track") if not of_track else kind.replace("track", "outline")]
        whole = watch.pair.to_whole(*watch.points)
        if is_concave(following):  # it comes to the next piece at the same place
            beyond = neighbour(following, of_track, step)
            if beyond is None:
                return ENDS[kind]
            other = self._watch(beyond, self._start_of(beyond, whole, of_track, step))
            if other.name in self.touching:  # a corner inside a corner stays there
                watch.at_joint = True
                self._settle(stuck)
                return None
            self._watch_touching()
            self._settle(stuck, closing={other.name})
            return None
        self.causes[watch.name] = CAUSES["piece"]
        runs = watch.pair.effect(Belt) is not None  # a contact that sticks moves with its belt
        if corner_on_corner(following) and watch.mode in STICKING and not runs:  # it met that corner, and stays
            watch.at_joint = True
            self._settle(stuck)
            return None
        corner = watch.pair.pieces[1 if of_track else 0]
        off = watch.points[1 if of_track else 0] - corner.span[1 if step < 0 else 0]
        if corner_on_corner(following) and abs(off) <= AT_END:
            # The side behind that corner lies flat, and goes on over the other curve's corner.
            following, of_track, step = neighbour(following, not of_track, -step) or following, not of_track, -step
        if corner_on_corner(following):  # the plate's corner passes the other curve's
            self.fixed = {watch.name: (Mode.FLIGHT,)}
            self._record({one.name: one.mode for one in self.watches if one is not watch})
            self.watches = [one for one in self.watches if one is not watch]
            self.touching.discard(watch.name)
            # It moves along the side that touched: beyond the end of the other curve's element before, away from the
            # next.
            neighbours = (neighbour(following, is_track, way) for is_track in (True, False) for way in (-1, 1))
            self.partings += [(self.t, pair) for pair in (watch.pair, *neighbours) if pair is not None]
            self._settle(stuck - {watch.name})
            return None
        points = self._start_of(following, whole, of_track, step)
        if not clearance(following, *points) > FITS / following.plate.reach:
            return ENDS["fit"]
        for one in [one for one in self.watches if one is not watch and one.is_at(following, points)]:
            self.watches.remove(one)  # it had opened there
            self.touching.discard(one.name)
        watch.pair, watch.points = following, points
        self._settle(stuck)
        return None

    @staticmethod
    def _start_of(pair: PieceCase, whole: tuple[float, float], of_track: bool, step: int) -> tuple[float, float]:
        """Parameters of a contact that has just come to an element."""
        points = [whole[0] - pair.first.shift, whole[1] - pair.second.shift]
        span = pair.pieces[0 if of_track else 1].span
        points[0 if of_track else 1] = span[0 if step > 0 else 1]
        return points[0], points[1]
