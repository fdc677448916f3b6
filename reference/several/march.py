"""The motion from a second contact on: phases, events and impacts until the end of the time span or a status."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

import numpy as np

from cases import Case, Flight, Mode, Transition
from cases.contact_pairs import PairCase, pairs
from cases.supports import has_belt

from ..minimal.bouncing import StraightStates
from ..minimal.curve_pieces import TooMuch
from ..minimal.integrators.segment import BREAKDOWN, OUT_OF_STEPS, Event, Segment
from ..minimal.meetings import Meeting
from ..minimal.phase_end import (
    CAUSES,
    COMPLETION,
    ENDS,
    LIFT_OFF,
    LOCATION_ERROR,
    NO_MODE,
    NO_SLIP,
    Ending,
    singular_ending,
    work_limit_ending,
)
from ..scales import frequency, looks_between, speed_scale
from .contact_law import STICKING, compliance, freedoms
from .decision import DecisionInstant, SeveralDecision, depends_on_time, load_at, slack_of_dip, with_slack
from .geometry import TOUCHES, places, project, without_velocity
from .hops import SeriesEnd
from .meetings import first_meeting, search_of
from .near_contacts import decide_near
from .phase_loop import PhaseLoop, several_motions
from .regimes import SeveralPhase, SeveralRegime, body_of, join, pairs_of, regime_of, several_phase
from .rest import RestStates, limit_of_rest, limit_on_belts
from .watched_plate import MotionEnds, WatchedPlate, WatchState

# Impacts are extrapolated to their end where the plate moves by less than this part of its size until then: gaps of
# larger hops have five digits.
SMALL_HOP = 1e-9
# Impacts that alternate between two corners and have no fixed ratio end where no hop is higher than this part of the
# plate's size, the gap at which contacts count as touching.
LOW_HOP = 1e-12
# A flight is integrated over this many of its time scales at once.
FLIES = 4.0
# Accelerations of gaps are differences of their speeds over this part of the motion's time scale.
LOOK_AHEAD = 1e-6
# Guards that are conditions on the force of one contact.
OF_FORCES = ("normal", "cone_forward", "cone_backward")
# Guards of the plate's rotation, which belong to all contacts that resist rolling.
OF_ROTATION = ("turn", "couple_forward", "couple_backward")


class SeveralSimulation(WatchedPlate, PhaseLoop):
    """A simulation with several contacts; `simulate` continues it until an ending."""

    def __init__(
        self,
        case: Case,
        rtol: float,
        integrate: Callable[..., Segment],
        t: float,
        body: list[float],
        watches: list[WatchState],
    ):
        super().__init__(case, t, body, watches)
        self.rtol, self.integrate = rtol, integrate
        compliances = compliance(case.plate) / case.plate.mass * np.array([1.0, 1.0, case.plate.gyration])
        self.speed = speed_scale(float(np.abs(compliances * load_at(case, t, body)).max()), case.plate.gyration)
        self.segments: list[Segment] = []
        self.transitions: list[Transition] = []
        self.idle = self.work = 0
        self.fixed: dict[str, tuple[Mode, ...]] = {}
        self.begins = self.held_out = False
        self.same: SeveralRegime | None = None
        self.searches = [(pair, search_of(pair)) for pair in pairs(case) if not pair.has_unique_points]

    # --- one phase ----------------------------------------------------------------------------------------------------

    def simulate(self) -> Ending:
        """Simulate phases until the end."""
        try:
            ending = self.simulate_phases()
        except TooMuch:
            ending = "unfinished", f"The search for further contacts reached its limit at {self.t:.9g} s."
        self.transitions = self.hops.all
        return ending

    def _begin(self) -> None:
        self.settle(self.stuck, closing=self.touching)

    def _next_phase(self) -> Ending | None:
        same, self.same = self.same, None
        return self._phase(same or self._decide())

    def _decide(self) -> SeveralRegime:
        now = self.instant()
        now = self._end_bouncing(now)
        error = self._decision_error()
        fixed = {k: self.fixed[name] for k, name in enumerate(now.names) if name in self.fixed}
        last_modes = tuple(watch.mode for watch in self.watches) if self.held_out else None
        decision = decide_near(self.case, now, error, fixed, last_modes)
        self.held_out = False
        if decision.regime is None and fixed and not decision.motions:
            decision = decide_near(self.case, now, error)
        if decision.regime is None and not decision.motions and self.touches_more():
            # A slip vanished where a gap is that small, too.
            self.settle({watch.name for watch in self.watches if watch.mode in STICKING} | self.stuck)
            now = self.instant()
            decision = decide_near(self.case, now, error)
        if decision.regime is None:
            raise MotionEnds(self._no_regime(now, decision))
        regime, changes = decision.regime, list[Transition]()
        if self._turns_about_a_corner(now, regime):
            raise MotionEnds(self._held_point(now))
        for watch, mode, at in zip(self.watches, regime.modes, now.places, strict=True):
            bounced = watch.name in self.causes and self.causes[watch.name] == CAUSES["landing"]
            if mode is not watch.mode or (bounced and mode is Mode.FLIGHT):
                cause = self.causes.get(watch.name, "the motion of another contact changed")
                xi2 = float(at.contact.whole_xi2(at.xi2))
                changes.append(Transition(self.t, watch.mode, mode, at.xi1, xi2, cause, watch.name))
            watch.mode = mode
        if self.begins:  # the modes of a start are no changes
            changes, self.begins = [], False
        came_to_rest = CAUSES["rest"] in self.causes.values()
        bouncing = self._bouncing(now) if came_to_rest else frozenset()
        self.hops.record(self.t, changes, CAUSES["rest"] if came_to_rest else "", bouncing)
        self.causes, self.fixed, self.stuck, self.turns = {}, {}, set(), True
        if not regime.closed and self.case.effect(Flight) is None:
            raise MotionEnds(LIFT_OFF)
        # Every closed contact has its own limit, and numbers with many digits would make every phase a new one.
        self.watches = [watch for watch in self.watches if watch.mode is not Mode.FLIGHT or self._is_watched(watch)]
        self.watches.sort(key=lambda watch: (watch.mode is Mode.FLIGHT, watch.contact.number))
        limits = tuple(float(np.float32(watch.limit)) for watch in self.watches)
        numbers = tuple(watch.contact.number for watch in self.watches)
        away = tuple(watch.is_away for watch in self.watches)
        used = dict(zip(regime.names, regime.guides, strict=False))
        guides = tuple(used[watch.name] for watch in self.watches) if used else ()
        modes = tuple(watch.mode for watch in self.watches)
        regime = SeveralRegime(
            modes, tuple(watch.name for watch in self.watches), limits, numbers, away, regime.rests, guides, regime.turn
        )
        return with_slack(self.case, self.instant_in_order(), regime, error)

    def _end_bouncing(self, now: DecisionInstant) -> DecisionInstant:
        """The instant at which impacts that accumulate end, if they do; the same instant otherwise.

        The plate moves by less than rounding until then, and all contacts of the last impacts touch. Others may bounce
        on: the end is none if one of them would have met its support before; one that closes at the end lands."""
        end = self._end_of_impacts(now)
        if end is None or not end.time < self.case.duration:
            return now
        limit, body = end.time, end.body
        watched, pairs = self.contacts(), [(at.xi1, at.xi2) for at in now.places]
        near, velocity = [k for k, name in enumerate(now.names) if name in end.contacts], np.array(body[3:])
        others = [
            (now.names[k], at.gap, float(at.lift_row @ velocity))
            for k, at in enumerate(places(watched, body, pairs))
            if not (k in near or now.away[k])
        ]
        landing = end.landing(others, TOUCHES * self._size())
        if landing is None:
            return now
        if np.abs(np.array(body[3:]) * np.array([1.0, 1.0, self.case.plate.gyration])).max() <= end.error:
            body[3:] = 0.0, 0.0, 0.0
        body, at = project(self.case, watched, body, pairs, near)
        stuck = [k for k in near if at[k].stick > 0.0 and abs(at[k].slip(np.array(body[3:]), limit)) <= end.error]
        resists = any(at[k].resisting_arm for k in near)
        turns = not resists or abs(body[5]) * self.case.plate.gyration > end.error
        body = without_velocity(self.case, limit, body, at, near, stuck, turns)
        state = join(body, [(one.xi1, one.xi2) for one in at])
        decision = decide_near(
            self.case, now._replace(time=limit, state=state, places=at, touching=tuple(near)), LOCATION_ERROR
        )
        regime = decision.regime
        if regime is None and (end.ends_cascade or decision.motions or landing):  # the motion ends or an impact follows
            regime = SeveralRegime((Mode.FLIGHT,) * len(at), now.names, now.limits, now.pairs, now.away)
        if regime is None:
            return now
        if limit > self.t:
            short = several_phase(self.case, regime)
            states = StraightStates(self.t, limit, now.state, state)
            self._advance(Segment.of(short, np.array([self.t, limit]), states, Event(None, limit, state), 0))
        if end.ends_cascade:
            self.hops.end_cascade()
        self.body, self.touching = body, {self.watches[k].name for k in near}
        self.causes = {name: CAUSES["rest"] for name in self.touching}
        if landing:
            self.hops.record(self.t, [], CAUSES["rest"])
            self.causes = {}
            self.settle({self.watches[k].name for k in stuck}, closing=landing)
        return self.instant()

    def _end_of_impacts(self, now: DecisionInstant) -> SeriesEnd | None:
        """The end of small impacts. Those that alternate between two corners without a fixed ratio end where all hops
        are lower than what counts as touching."""
        end, low = self.hops.limit(self.t, SMALL_HOP * self._size()), LOW_HOP * self._size()
        if end is None and self._is_low(now, low):
            near = zip(now.places, now.names, now.away, strict=True)
            touching = frozenset(name for at, name, is_away in near if at.gap <= low and not is_away)
            error = 2.0 * self.hops.strikes[-1].closing
            return self.hops.lowest(touching) or SeriesEnd(self.t, list(self.body), touching, error)
        return end

    def _is_low(self, now: DecisionInstant, height: float) -> bool:
        """Whether a small impact ends hops of at most that height, m, at all contacts of the last impacts."""
        recent, velocity = self.hops.recent(self.t), np.array(self.body[3:])
        hops = [
            at.gap + float(at.lift_row @ velocity) ** 2 / (2.0 * self.pull(at))
            for at, name in zip(now.places, now.names, strict=True) if name in recent and self.pull(at) > 0.0
        ]  # fmt: skip
        return 0 < len(hops) == len(recent) and max(hops) <= height

    def _bouncing(self, now: DecisionInstant) -> frozenset[str]:
        """The contacts that small impacts go on to hit, while others have come to rest."""
        height, velocity = SMALL_HOP * self._size(), np.array(self.body[3:])
        near = [k for k, at in enumerate(now.places) if k not in now.touching and at.gap <= height and not now.away[k]]
        return self.hops.bouncing({now.names[k]: float(now.places[k].lift_row @ velocity) for k in near})

    def _is_watched(self, watch: WatchState) -> bool:
        if watch.contact.has_unique_points:
            return True
        at = places([watch.contact], self.body, [watch.pair])[0]
        return at.clearance > 2.0 * watch.limit

    def _no_regime(self, now: DecisionInstant, decision: SeveralDecision) -> Ending:
        if decision.motions:
            return several_motions(self.t, now.names, decision.motions)
        touching = [now.places[k] for k in now.touching]
        rows = np.array([at.lift_row for at in touching] + [at.slip_row for at in touching if at.stick > 0.0])
        rows, most = rows[:, : freedoms(self.case.plate)], freedoms(self.case.plate)
        if len(touching) > 1 and np.linalg.matrix_rank(rows, tol=1e-9 * self.case.plate.reach) < min(len(rows), most):
            return self._held_point(now)
        return NO_SLIP if any(now.places[k].stick == inf for k in now.touching) else NO_MODE

    def _held_point(self, now: DecisionInstant) -> Ending:
        return BREAKDOWN, (
            f"At t = {self.t:.9g} s {' and '.join(now.names[k] for k in now.touching)} hold one point of the "
            "plate, which turns about it: their forces are not unique, and this motion is not computed."
        )

    def _turns_about_a_corner(self, now: DecisionInstant, regime: SeveralRegime) -> bool:
        """Whether the plate turns about a point that one contact holds and another touches, whose gap stays zero."""
        rolls = [k for k in regime.closed if regime.modes[k] in STICKING and not regime.has_open_forces]
        held = [now.places[k] for k in rolls]
        leaving = [now.places[k] for k in now.touching if regime.modes[k] is Mode.FLIGHT]
        close = 1e-9 * self.case.plate.reach
        return any(np.hypot(*np.subtract(one.arm, other.arm)) <= close for one in held for other in leaving)

    def _phase(self, regime: SeveralRegime) -> Ending | None:
        """Integrate one phase and apply its event; returns an ending, or None."""
        phase = several_phase(self.case, regime)
        y = join(self.body, [watch.pair for watch in self.watches])
        low = self._low_hops(phase, y)
        if low:
            self.touching = {regime.names[k] for k in regime.closed} | low
            self.causes = dict.fromkeys(low, CAUSES["rest"])
            self.turns = regime.turn != 0
            self.settle({regime.names[k] for k in regime.closed if regime.modes[k] in STICKING})
            return None
        if regime.rests:
            segment = self._rest(phase, y)
        else:
            segment, meeting = self._move(phase, y)
            limit = limit_on_belts(segment) if regime.guides else None
            if limit is not None:
                segment, meeting = segment.cut(limit, "rest"), None
            if meeting is not None:
                self._advance(segment)
                return self._meet(*meeting)
        self._advance(segment)
        return self._event(segment, regime)

    def _low_hops(self, phase: SeveralPhase, y: tuple[float, ...]) -> set[str]:
        """The contacts that an impact has just opened, whose hops rise no higher than positions' rounding: the other
        contacts' forces may drive the plate to a support from which its load pulls it away."""
        if not self.hops.strikes or self.hops.strikes[-1].time != self.t:
            return set()
        step = LOOK_AHEAD * (frequency(phase, self.t, y) or 1.0) ** -1
        rates = phase.system.rates_of_numbers(self.t, y, phase.parameters)
        ahead = body_of([value + step * rate for value, rate in zip(y, rates, strict=True)])
        now, low = self.places(), set[str]()
        then = places(self.contacts(), ahead, [watch.pair for watch in self.watches])
        for watch, at, later in zip(self.watches, now, then, strict=True):
            lift = float(at.lift_row @ np.array(self.body[3:]))
            pull = (lift - float(later.lift_row @ np.array(ahead[3:]))) / step
            may_hop = watch.mode is Mode.FLIGHT and not watch.is_away and at.gap <= TOUCHES * self._size()
            if may_hop and lift > 0.0 and self._is_unresolved(lift, pull):
                low.add(watch.name)
        return low

    def _first_meeting(self, segment: Segment) -> tuple[PairCase, Meeting] | None:
        """The first contact at a place that is not watched, with its pair."""
        if not segment.event.time > self.t:
            return None
        first = None
        for pair, search in self.searches:
            meeting = first_meeting(pair, search, segment)
            if meeting is not None and (first is None or meeting.time < first[1].time):
                first = pair, meeting
        return first

    def _move(self, phase, y) -> tuple[Segment, tuple[PairCase, Meeting] | None]:
        end = self.case.duration
        if not regime_of(phase).closed:
            often = frequency(phase, self.t, y)
            end = min(end, max(self.t + FLIES / often if often else end, self.t + 1e3 * np.spacing(self.t)))
        segment = self.integrate(phase, self.t, y, end, self.rtol)
        first = self._first_meeting(segment)
        if first is None:
            return segment, None
        return segment.cut(first[1].time, None), first

    def _rest(self, phase, y) -> Segment:
        """A rest: it ends where the forces cannot balance the load any more."""
        end, guard = self.case.duration, None
        if depends_on_time(self.case):
            last = limit_of_rest(
                self.case, [self.places()[k] for k in phase.regime.closed], self.t, y, phase.regime.turn
            )
            end, guard = (last, "rest") if last is not None else (end, None)
        return Segment.of(phase, np.array([self.t, end]), RestStates(y), Event(guard, end, y), 0)

    def _advance(self, segment: Segment) -> None:
        self._count(segment)
        self.t, state = segment.event.time, segment.event.state
        self.body = body_of(state)
        for watch, pair in zip(self.watches, pairs_of(state), strict=True):
            watch.pair = pair
        self.speed = max(self.speed, self.present_speed(), *map(self.belt_speed, segment.times.tolist()))
        if has_belt(self.case):  # it may stop, or turn back, at both ends of a step
            self.speed = max(self.speed, *map(self.belt_speed, looks_between(segment.times).tolist()))

    # --- events -------------------------------------------------------------------------------------------------------

    def _event(self, segment: Segment, regime: SeveralRegime) -> Ending | None:
        guard = segment.event.guard
        self.touching, self.turns = {regime.names[k] for k in regime.closed}, regime.turn != 0
        if guard is None:
            if self.t >= self.case.duration:
                return COMPLETION
            self.settle()
            return None
        if guard == OUT_OF_STEPS:
            return work_limit_ending(self.t, segment.steps)
        if guard == BREAKDOWN:
            return singular_ending(self.t)
        if guard == "rest":
            # The contacts no longer hold the plate: some contact slips or opens.
            self.causes = {name: "the forces at rest reached their limit" for name in self.touching}
            if regime.guides:
                self.causes = {name: "the forces reached their limit" for name in self.touching}
            rolls = {regime.names[k] for k in regime.closed if regime.modes[k] in STICKING}
            self.settle(stuck=rolls if regime.guides else self.touching)
            self.held_out = True
            return None
        kind, _, number = guard.partition(":")
        stuck = {regime.names[k] for k, mode in enumerate(regime.modes) if mode in STICKING}
        if kind in OF_ROTATION:
            self.causes |= dict.fromkeys(self.touching, CAUSES[kind])
            self.turns = False
            self.settle(stuck)
            return None
        if kind.startswith("lost"):
            del self.watches[int(number)]
            self.settle(stuck)
            return None
        if kind in ("turn_low", "turn_high"):
            self.turn(self.watches[int(number)])
            self.settle(stuck)
            return None
        if kind in ENDS:
            return ENDS[kind]
        slack = slack_of_dip(self.case, segment, guard, self.rtol) if kind in OF_FORCES else 0.0
        if slack:
            self.settle(stuck)
            self.same = regime._replace(slack=tuple((dict(regime.slack) | {guard: slack}).items()))
            return None
        name = regime.names[int(number)]
        if kind == "gap":
            self.settle(stuck, closing={name})
            return None
        cause = {"normal": "normal_force"}.get(kind, kind)
        self.causes[name] = CAUSES[cause]
        if kind == "slip":
            stuck.add(name)
        now = places(self.contacts(), self.body, [watch.pair for watch in self.watches])
        closing = self.closing(now) - self.touching  # the event and an impact at the same instant
        if kind == "normal" and not closing and guard not in dict(regime.slack):
            self.fixed = {name: (Mode.FLIGHT,)}
        self.settle(stuck, closing or None)
        return None

    def _meet(self, contact: PairCase, meeting: Meeting) -> Ending | None:
        """A contact at a place that is not watched."""
        regime = regime_of(self.segments[-1].phase)
        self.touching, self.turns = {regime.names[k] for k in regime.closed}, regime.turn != 0
        watch = self.new_watch(contact, (meeting.xi1, meeting.xi2))
        self.settle({n for n, m in zip(regime.names, regime.modes, strict=True) if m in STICKING}, {watch.name})
        return None
