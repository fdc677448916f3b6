"""The motion from a second contact on: phases, events and impacts until the end of the time span or a status."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from cases import (
    Belt,
    Case,
    CoulombFriction,
    DoesNotFit,
    Drive,
    Flight,
    Impact,
    Mode,
    RollingResistance,
    Transition,
    Unilateral,
)
from cases.contact import start_motion
from cases.contact_pairs import PairCase, contact_name, pairs
from cases.own_effects import own_effects
from cases.piece_case import has_pieces
from cases.supports import TRACK, touches_by_features
from cases.trajectory import CONTACT

from ..minimal.boxes import Geometry
from ..minimal.curve_pieces import TooMuch
from ..minimal.decision import Undecidable
from ..minimal.flight_end import REBOUND_ROUNDINGS
from ..minimal.hybrid import MOST_PHASES
from ..minimal.integrators.segment import BREAKDOWN, OUT_OF_STEPS, Event, Segment
from ..minimal.meetings import Meeting, MeetingSearch
from ..minimal.phase_end import (
    CAUSES,
    COMPLETION,
    ENDS,
    LIFT_OFF,
    LOCATION_ERROR,
    MOST_STEPS,
    NO_MODE,
    NO_SLIP,
    ROUGH,
    Ending,
    undecidable,
    work_limit_ending,
)
from ..minimal.scales import frequency
from ..minimal.series import EPS
from . import forces
from .decision import DecisionInstant, SeveralDecision, decide, depends_on_time, load_at
from .geometry import ContactPlace, places, project, without_velocity
from .hops import ImpactSeries
from .impact import NoImpact, impact
from .meetings import first_meeting
from .regimes import LOST, SeveralRegime, body_of, join, pairs_of, regime_of, several_phase

# A contact touches if its gap is below this part of the plate's size: the rounding of an event's pose.
TOUCHES = 1e-12
# Two contacts are different ones if their points on the track are farther apart than this part of the plate's size.
APART = 1e-6
# A contact closes if it does so faster than this part of the largest speed so far; slower is rounding.
CLOSES = 1e-10
# This many phases of zero length in a row: values near a bound count as being at it; then the motion ends.
IDLE, STUCK = 4, 50
# Impacts are extrapolated to their end where the plate moves by less than this part of its size until then: gaps of
# larger hops have five digits.
SMALL_HOP = 1e-10
# A flight is integrated over this many of its time scales at once.
FLIES = 4.0
# The names of contacts that have not touched yet begin with this.
OPEN_NAME = "open "
# Looks at a load in time while it may end a rest, besides those that resolve its features.
LOOKS = 64


class MotionEnds(Exception):
    """The motion ends, with a status and a sentence."""

    def __init__(self, ending: Ending):
        super().__init__(ending[1])
        self.ending = ending


@dataclass
class WatchState:
    """A watched contact: its name, its pair of a support and a feature, its pair of points and mode, and the clearance
    (1/m) at which it is lost while open."""

    name: str
    contact: PairCase
    pair: tuple[float, float]
    mode: Mode
    limit: float


@dataclass(frozen=True)
class _Rests:
    """The dense output of a plate at rest."""

    state: tuple[float, ...]

    def __call__(self, times: np.ndarray) -> np.ndarray:
        return np.outer(self.state, np.ones_like(times))


def supports(case: Case) -> str:
    """Why a motion of this case with several contacts cannot be computed, in a sentence; "" if it can."""
    if case.effect(Unilateral) is None:
        return "A second contact needs Unilateral: a bilateral guide has no free side."
    if case.effect(RollingResistance) is not None:
        return "RollingResistance is not supported with several contacts."
    if case.effect(Belt) is not None:
        return "A belt is not supported with several contacts."
    if own := own_effects(case.effects):
        return f"{type(own[0]).__name__} is not supported with several contacts."
    if case.effect(Drive) is not None:
        return "A driven track is not supported with several contacts."
    if not case.plate.turns:
        return "A plate of infinite inertia is not supported with several contacts."
    friction = case.effect(CoulombFriction)
    if friction is not None and friction.by_speed:
        return "Friction that depends on the slip speed is not supported with several contacts."
    if touches_by_features(case):
        return ""
    if has_pieces(case) or case.track.parts is not None or case.plate.outline.parts is not None:
        return "Curves in pieces are not supported with several contacts."
    return ""


@dataclass
class SeveralSimulation:
    """The state of a simulation with several contacts; `simulate` continues it until an ending."""

    case: Case
    rtol: float
    integrate: Callable[..., Segment]
    t: float
    body: list[float]
    watches: list[WatchState]
    segments: list[Segment] = field(default_factory=list)
    transitions: list[Transition] = field(default_factory=list)
    speed: float = 0.0
    idle: int = 0
    causes: dict[str, str] = field(default_factory=dict)
    fixed: dict[str, tuple[Mode, ...]] = field(default_factory=dict)
    stuck: set[str] = field(default_factory=set)
    touching: set[str] = field(default_factory=set)
    hops: ImpactSeries = field(default_factory=ImpactSeries)
    begins: bool = False
    held_out: bool = False

    def __post_init__(self) -> None:
        self.searches = [
            (pair, MeetingSearch(Geometry.of_case(pair))) for pair in pairs(self.case) if not pair.has_unique_points
        ]
        self.work = 0

    # --- one phase ----------------------------------------------------------------------------------------------------

    def simulate(self) -> Ending:
        """Simulate phases until the end."""
        ending = self._simulate_phases()
        self.transitions = self.hops.all
        return ending

    def _simulate_phases(self) -> Ending:
        try:
            self._settle(self.stuck, struck=True)
            for _ in range(MOST_PHASES):
                ending = self._phase(self._decide())
                if ending:
                    return ending
                if self.work >= MOST_STEPS:
                    return work_limit_ending(self.t, self.work)
        except MotionEnds as end:
            return end.ending
        except Undecidable:
            return undecidable(self.t)
        except (DoesNotFit, np.linalg.LinAlgError) as problem:
            return BREAKDOWN, f"After t = {self.t:.9g} s {problem}."
        except TooMuch:
            return "unfinished", f"The search for further contacts reached its limit at {self.t:.9g} s."
        return "unfinished", f"The modes changed {MOST_PHASES} times until t = {self.t:.9g} s, the limit of a run."

    def _instant(self) -> DecisionInstant:
        now = self._places()
        touching = tuple(k for k, watch in enumerate(self.watches) if watch.name in self.touching)
        names, limits = tuple(watch.name for watch in self.watches), tuple(watch.limit for watch in self.watches)
        pairs = [(at.xi1, at.xi2) for at in now]
        return DecisionInstant(self.t, join(self.body, pairs), now, names, limits, touching, self.speed)

    def _places(self) -> list[ContactPlace]:
        now = places(self._contacts(), self.body, [watch.pair for watch in self.watches])
        for watch, at in zip(self.watches, now, strict=True):
            watch.pair = at.xi1, at.xi2
        return now

    def _contacts(self) -> list[PairCase]:
        return [watch.contact for watch in self.watches]

    def _decide(self) -> SeveralRegime:
        now = self._instant()
        now = self._come_to_rest(now)
        error = LOCATION_ERROR if self.idle <= IDLE else ROUGH
        fixed = {k: self.fixed[name] for k, name in enumerate(now.names) if name in self.fixed}
        decision = decide(self.case, now, error, fixed, may_rest=not self.held_out)
        self.held_out = False
        if decision.regime is None and fixed and not decision.motions:
            decision = decide(self.case, now, error)
        if decision.regime is None:
            raise MotionEnds(self._no_regime(now, decision))
        regime, changes = decision.regime, list[Transition]()
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
        self.hops.record(self.t, changes, CAUSES["rest"] if came_to_rest else "")
        self.causes, self.fixed, self.stuck = {}, {}, set()
        if not regime.closed and self.case.effect(Flight) is None:
            raise MotionEnds(LIFT_OFF)
        # Every closed contact has its own limit, and numbers with many digits would make every phase a new one.
        self.watches = [watch for watch in self.watches if watch.mode is not Mode.FLIGHT or self._is_watched(watch)]
        names = {watch.name for watch in self.watches}
        modes = tuple(mode for mode, name in zip(regime.modes, regime.names, strict=True) if name in names)
        limits = tuple(float(np.float32(watch.limit)) for watch in self.watches)
        numbers = tuple(watch.contact.number for watch in self.watches)
        return SeveralRegime(modes, tuple(watch.name for watch in self.watches), limits, numbers, regime.rests)

    def _come_to_rest(self, now: DecisionInstant) -> DecisionInstant:
        """The instant at which impacts that accumulate come to rest, if they do; the same instant otherwise.

        The plate is then moved by less than rounding, so that all contacts of the last impacts touch, and stopped."""
        x, y, *_ = self.body
        size = SMALL_HOP * (abs(x) + abs(y) + self.case.plate.reach)
        end = self.hops.limit(self.t, self._speed(), size)
        if end is None or not self.t <= end[0] < self.case.duration:
            return now
        limit, theta = end
        near = [k for k, at in enumerate(now.places) if at.gap <= size]
        body, at = project(
            self.case, self._contacts(), [x, y, theta, 0.0, 0.0, 0.0], [watch.pair for watch in self.watches], near
        )
        rows = [at[k].lift_row for k in near] + [at[k].slip_row for k in near if at[k].stick > 0.0]
        if len(near) < 2 or np.linalg.matrix_rank(np.array(rows), tol=1e-9 * self.case.plate.reach) < 3:
            return now
        pairs = [(one.xi1, one.xi2) for one in at]
        rest = now._replace(time=limit, state=join(body, pairs), places=at, touching=tuple(near))
        decision = decide(self.case, rest, LOCATION_ERROR)
        if decision.regime is None or not decision.regime.rests:
            return now
        if limit > self.t:
            still = several_phase(self.case, decision.regime)
            self._advance(
                Segment.of(still, np.array([self.t, limit]), _Rests(rest.state), Event(None, limit, rest.state), 0)
            )
        self.body, self.touching = body, {self.watches[k].name for k in near}
        self.causes = {name: CAUSES["rest"] for name in self.touching}
        return self._instant()

    def _is_watched(self, watch: WatchState) -> bool:
        if watch.contact.has_unique_points:
            return True
        at = places([watch.contact], self.body, [watch.pair])[0]
        return at.clearance > 2.0 * watch.limit

    def _no_regime(self, now: DecisionInstant, decision: SeveralDecision) -> Ending:
        if decision.motions:
            choices = "; ".join(
                ", ".join(f"{name} {mode}" for name, mode in zip(now.names, modes, strict=True))
                for modes in decision.motions
            )
            count = len(decision.motions)
            return (
                "not_unique",
                f"{count} motions of rigid Coulomb contact are consistent at {self.t:.9g} s: {choices}.",
            )
        return NO_SLIP if any(now.places[k].stick == inf for k in now.touching) else NO_MODE

    def _phase(self, regime: SeveralRegime) -> Ending | None:
        """Integrate one phase and apply its event; returns an ending, or None."""
        phase = several_phase(self.case, regime)
        y = join(self.body, [watch.pair for watch in self.watches])
        if regime.rests:
            segment = self._rest(phase, y)
        else:
            segment, meeting = self._move(phase, y)
            if meeting is not None:
                self._advance(segment)
                return self._meet(*meeting)
        self._advance(segment)
        return self._event(segment, regime)

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
        _, meeting = first
        cut = segment.until(meeting.time, segment.evaluations)
        state = tuple(segment.states(np.array([meeting.time]))[:, 0].tolist())
        return Segment.of(
            phase, cut.times, segment.states, Event(None, meeting.time, state), segment.evaluations
        ), first

    def _rest(self, phase, y) -> Segment:
        """A rest: it ends where the forces cannot balance the load any more."""
        end, guard = self.case.duration, None
        if depends_on_time(self.case):
            last = self._limit_of_rest(phase.regime, y)
            end, guard = (last, "rest") if last is not None else (end, None)
        return Segment.of(phase, np.array([self.t, end]), _Rests(y), Event(guard, end, y), 0)

    def _limit_of_rest(self, regime: SeveralRegime, y) -> float | None:
        from scipy.optimize import brentq

        from cases import Load

        at = [self._places()[k] for k in regime.closed]
        sticks, gyration = [one.stick for one in at], self.case.plate.gyration

        def margin(t: float) -> float:
            return forces.margin(at, load_at(self.case, t, body_of(y)), gyration, sticks)

        load, end = self.case.effect(Load), self.case.duration
        looks = np.linspace(self.t, end, LOOKS)
        if load is not None and load.features is not None:
            looks = np.union1d(looks, load.features.nodes(self.t, end))
        last = self.t
        for look in looks[1:].tolist():
            if margin(look) < 0.0:
                return float(brentq(margin, last, look, xtol=1e-15, rtol=8.9e-16)) if margin(last) > 0.0 else last
            last = look
        return None

    def _advance(self, segment: Segment) -> None:
        self.segments.append(segment)
        self.work += segment.steps
        self.idle = self.idle + 1 if segment.event.time == self.t else 0
        if self.idle > STUCK:
            raise MotionEnds(("accumulation", f"{STUCK} changes of mode took no time at t = {self.t:.9g} s."))
        self.t, state = segment.event.time, segment.event.state
        self.body = body_of(state)
        for watch, pair in zip(self.watches, pairs_of(state), strict=True):
            watch.pair = pair
        self.speed = max(self.speed, self._speed())

    def _speed(self) -> float:
        return float(np.abs(np.array(self.body[3:]) * np.array([1.0, 1.0, self.case.plate.gyration])).max())

    # --- events -------------------------------------------------------------------------------------------------------

    def _event(self, segment: Segment, regime: SeveralRegime) -> Ending | None:
        guard = segment.event.guard
        self.touching = {regime.names[k] for k in regime.closed}
        if guard is None:
            if self.t >= self.case.duration:
                return COMPLETION
            self._settle()
            return None
        if guard == OUT_OF_STEPS:
            return work_limit_ending(self.t, segment.steps)
        if guard == BREAKDOWN:
            return BREAKDOWN, f"The equations became singular at t = {self.t:.9g} s, and no step was small enough."
        if guard == "rest":
            # The contacts no longer hold the plate: some contact slips or opens.
            self.causes = {name: "the forces at rest reached their limit" for name in self.touching}
            self._settle(stuck=self.touching)
            self.held_out = True
            return None
        kind, _, number = guard.partition(":")
        stuck = {regime.names[k] for k, mode in enumerate(regime.modes) if mode is Mode.ROLL}
        if kind.startswith("lost"):
            del self.watches[int(number)]
            self._settle(stuck)
            return None
        if kind in ENDS:
            return ENDS[kind]
        name = regime.names[int(number)]
        if kind == "gap":
            self.touching.add(name)
            self._settle(stuck, struck=True)
            return None
        cause = {"normal": "normal_force"}.get(kind, kind)
        self.causes[name] = CAUSES[cause]
        if kind == "slip":
            stuck.add(name)
        if kind == "normal":
            self.fixed = {name: (Mode.FLIGHT,)}
        self._settle(stuck)
        return None

    def _meet(self, contact: PairCase, meeting: Meeting) -> Ending | None:
        """A contact at a place that is not watched."""
        regime = regime_of(self.segments[-1].phase)
        self.touching = {regime.names[k] for k in regime.closed}
        watch = self._new_watch(contact, (meeting.xi1, meeting.xi2))
        self.touching.add(watch.name)
        self._settle({n for n, m in zip(regime.names, regime.modes, strict=True) if m is Mode.ROLL}, struck=True)
        return None

    def _new_watch(self, contact: PairCase, pair: tuple[float, float]) -> WatchState:
        watch = WatchState(self._free_name(contact), contact, pair, Mode.FLIGHT, 0.0)
        self.watches.append(watch)
        return watch

    def _settle(self, stuck: set[str] | None = None, struck: bool = False) -> None:
        """Remove roundings from the state: no gap at contacts that touch, and no velocity where there is none.

        `struck`: a contact may have closed with a velocity, which is an impact."""
        stuck = set(stuck or ())
        if struck:
            self._add_touching()
        stuck = self._name_touching(stuck)
        indices = [k for k, watch in enumerate(self.watches) if watch.name in self.touching]
        self.body, now = project(
            self.case, self._contacts(), self.body, [watch.pair for watch in self.watches], indices
        )
        for watch, at in zip(self.watches, now, strict=True):
            watch.pair = at.xi1, at.xi2
        for k in indices:
            self.watches[k].limit = 0.0 if self.watches[k].contact.has_unique_points else LOST * now[k].clearance
        self.speed = max(self.speed, self._speed())
        if struck:
            stuck = self._impact(now, indices, stuck)
            indices = [k for k, watch in enumerate(self.watches) if watch.name in self.touching]
        sticking = [k for k in indices if self.watches[k].name in stuck]
        self.body = without_velocity(self.case, self.body, now, indices, sticking)

    def _name_touching(self, stuck: set[str]) -> set[str]:
        """Name the contacts that touch for the first time by their order; returns `stuck` with their names."""
        for watch in self.watches:
            if watch.name in self.touching and watch.name.startswith(OPEN_NAME):
                old = watch.name
                watch.name = self._free_name(watch.contact)
                self.touching = {watch.name if name == old else name for name in self.touching}
                stuck = {watch.name if name == old else name for name in stuck}
        return stuck

    def _free_name(self, contact: PairCase) -> str:
        """The name of a further contact of that support."""
        used = {watch.name for watch in self.watches}
        return next(name for i in range(1, len(used) + 2) if (name := contact_name(contact.support, i)) not in used)

    def _add_touching(self) -> None:
        size = abs(self.body[0]) + abs(self.body[1]) + self.case.plate.reach
        for watch, at in zip(self.watches, self._places(), strict=True):
            if at.gap <= TOUCHES * size:
                self.touching.add(watch.name)

    def _impact(self, now: Sequence[ContactPlace], indices: list[int], stuck: set[str]) -> set[str]:
        """Apply an impact if a touched contact closes; returns the names of contacts that do not slip after it (`stuck`
        before it), and leaves the ones that open out of `touching`."""
        velocity = np.array(self.body[3:])
        lifts = {k: float(now[k].lift_row @ velocity) for k in indices}
        closing = [k for k in indices if lifts[k] < -CLOSES * self.speed]
        if not closing:
            self.touching = {self.watches[k].name for k in indices if lifts[k] <= CLOSES * self.speed}
            return stuck | {self.watches[k].name for k in indices if self._is_still(now[k], velocity)}
        if self.case.effect(Impact) is None:
            raise MotionEnds(
                (
                    "second_contact",
                    f"The plate meets {self._which(closing[0])}, xi1 = {now[closing[0]].xi1:.9g}, at t = "
                    f"{self.t:.9g} s, and the case names no Impact; add Flight() and Impact(0.0) to go on.",
                )
            )
        places_hit = [k for k in indices if lifts[k] <= CLOSES * self.speed]
        try:
            outcome = impact(self.case, self.body[3:], [now[k] for k in places_hit], self.speed)
        except NoImpact as problem:
            raise MotionEnds(("not_unique", f"At t = {self.t:.9g} s {problem}.")) from problem
        self._check_energy(outcome.velocity)
        self.body[3:] = outcome.velocity.tolist()
        self.hops.strike(self.t, self.body[2], max(-lifts[k] for k in closing))
        self.touching, sticks = set(), set[str]()
        for i, k in enumerate(places_hit):
            watch, lift = self.watches[k], float(outcome.lift[i])
            if k in closing:
                self.causes[watch.name] = CAUSES["landing"]
            if lift > 0.0 and not self._is_unresolved(now[k], lift):
                continue
            if lift > 0.0:
                self.causes[watch.name] = CAUSES["rest"]
            self.touching.add(watch.name)
            if outcome.slip[i] == 0.0:
                sticks.add(watch.name)
        return sticks

    def _which(self, k: int) -> str:
        support = self.watches[k].contact.support
        return "its track in a second place" if support == TRACK else f"the support {support!r}"

    def _check_energy(self, after: np.ndarray) -> None:
        """Newton's law may create energy, which ends the motion."""
        from ..minimal.phase_end import ENERGY

        weights = np.array([1.0, 1.0, self.case.plate.gyration**2])
        before = np.array(self.body[3:])
        law = self.case.effect(Impact)
        if law is not None and law.law == "newton" and weights @ after**2 > (1.0 + 1e-12) * (weights @ before**2):
            raise MotionEnds(ENERGY)

    def _is_still(self, at: ContactPlace, velocity: np.ndarray) -> bool:
        return abs(float(at.slip_row @ velocity)) <= 1e-11 * self.speed

    def _is_unresolved(self, at: ContactPlace, lift: float) -> bool:
        """Whether a rebound rises no higher than positions' rounding."""
        load = load_at(self.case, self.t, self.body)
        weights = 1.0 / np.array([1.0, 1.0, self.case.plate.gyration**2]) / self.case.plate.mass
        pull = max(-float(at.lift_row @ (weights * load)), 0.0)
        rounding = REBOUND_ROUNDINGS * EPS * (abs(self.body[0]) + abs(self.body[1]) + self.case.plate.reach)
        return lift * lift <= 2.0 * pull * rounding


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
    if mode is Mode.ROLL:
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
    watches, size = list[WatchState](), abs(body[0]) + abs(body[1]) + case.plate.reach
    for pair in pairs(case):
        points = pair.guess(*body[:3])
        if not pair.has_unique_points:
            try:
                gap = places([pair], body, [points])[0].gap
            except DoesNotFit:
                continue
            if abs(gap) > TOUCHES * size:
                continue
        watches.append(WatchState(f"{OPEN_NAME}{pair.number}", pair, points, Mode.FLIGHT, 0.0))
    march = SeveralSimulation(case, rtol, integrate, 0.0, body, watches)
    march.begins = True
    ending = march.simulate()
    return march.segments, march.transitions, ending
