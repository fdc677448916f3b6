"""A plate with its watched contacts at one instant: poses without roundings, and impacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from cases import Case, Impact, Mode
from cases.contact import belt_speed
from cases.contact_pairs import PairCase, WatchedPair, contact_name, facing_pairs, pairs
from cases.supports import TRACK, has_slip_law

from ..minimal.flight_end import REBOUND_ROUNDINGS
from ..minimal.phase_end import CAUSES, ENERGY, Ending
from ..minimal.series import EPS
from .contact_law import compliance
from .decision import DecisionInstant, load_at
from .geometry import TOUCHES, ContactPlace, places, project, without_velocity
from .hops import NestedSeries, Strike
from .impact import NoImpact, impact
from .regimes import LOST, join

# A contact closes if it does so faster than this part of the largest speed so far; slower is rounding.
CLOSES = 1e-10
# Impacts at one instant that follow from each other, at contacts whose gap is below this part of the plate's size: its
# rounding.
MOST_IMPACTS, NO_GAP = 50, 64 * EPS
# Velocities that follow from those of belts have a few roundings.
SOME_ROUNDINGS = 8
# The names of contacts that have not touched yet begin with this.
OPEN_NAME = "open "


class MotionEnds(Exception):
    """The motion ends, with a status and a sentence."""

    def __init__(self, ending: Ending):
        super().__init__(ending[1])
        self.ending = ending


@dataclass
class WatchState:
    """A watched contact: its name, its pair of a support and a feature, its pair of points and mode, the clearance
    (1/m) at which it is lost while open, and whether it is an arc or an edge that is
    turned away from the support (`PairCase.away_in_pose`)."""

    name: str
    contact: PairCase
    pair: tuple[float, float]
    mode: Mode
    limit: float
    is_away: int = 0


def open_name(pair: PairCase) -> str:
    """The name of a contact that has not touched yet."""
    return f"{OPEN_NAME}{pair.number}"


def open_watch(one: WatchedPair) -> WatchState:
    """An open contact at a pair."""
    return WatchState(open_name(one.pair), one.pair, one.points, Mode.FLIGHT, 0.0, one.is_away)


def open_watches(some: Sequence[WatchedPair]) -> list[WatchState]:
    """Open contacts at pairs; of several places of one pair each has a name of its own."""
    watches = [open_watch(one) for one in some]
    for k, watch in enumerate(watches):
        if k and watch.contact == watches[k - 1].contact:
            watch.name = f"{watches[k - 1].name}+"
    return watches


@dataclass
class WatchedPlate:
    """The plate (x, y, θ, vx, vy, ω) at time t (s), its watched contacts, and which of them touch or do not slip;
    `turns`: False where rolling resistance has ended the rotation; `named`: the names of corners and arcs, by their
    pairs' numbers, which they keep while they are not watched."""

    case: Case
    t: float
    body: list[float]
    watches: list[WatchState]
    speed: float = 0.0
    causes: dict[str, str] = field(default_factory=dict)
    stuck: set[str] = field(default_factory=set)
    turns: bool = True
    touching: set[str] = field(default_factory=set)
    hops: NestedSeries = field(default_factory=NestedSeries)
    named: dict[int, str] = field(default_factory=dict)

    def places(self) -> list[ContactPlace]:
        """The places of all watched contacts; their pairs are updated."""
        now = places(self.contacts(), self.body, [watch.pair for watch in self.watches])
        for watch, at in zip(self.watches, now, strict=True):
            watch.pair = at.xi1, at.xi2
        return now

    def contacts(self) -> list[PairCase]:
        """The pairs of all watched contacts."""
        return [watch.contact for watch in self.watches]

    def instant(self) -> DecisionInstant:
        """What a decision about the modes needs. Contacts that touch come first: equations with the same modes are then
        the same, whichever corner of a polygon touches."""
        self.watches.sort(key=lambda watch: (watch.name not in self.touching, watch.contact.number))
        return self.instant_in_order()

    def instant_in_order(self) -> DecisionInstant:
        """The same with the contacts in the order of the watches, as a regime has them that was made of them."""
        now = self.places()
        touching = tuple(k for k, watch in enumerate(self.watches) if watch.name in self.touching)
        names, limits = tuple(watch.name for watch in self.watches), tuple(watch.limit for watch in self.watches)
        pairs = [(at.xi1, at.xi2) for at in now]
        away = tuple(watch.is_away for watch in self.watches)
        return DecisionInstant(self.t, join(self.body, pairs), now, names, limits, touching, self.speed, away)

    def new_watch(self, contact: PairCase, pair: tuple[float, float]) -> WatchState:
        """Watch an open contact, too."""
        watch = WatchState(self._free_name(contact), contact, pair, Mode.FLIGHT, 0.0)
        self.watches.append(watch)
        return watch

    def turn(self, arc: WatchState) -> None:
        """Watch other pairs where an arc turns to its support or away; a contact there passes on with name and mode."""
        leaves, gap = not arc.is_away, places([arc.contact], self.body, [arc.pair])[0].gap
        successor = arc.contact.successor(arc.pair[1]) if leaves else None
        arc.is_away = arc.contact.after_turn(arc.is_away, arc.pair[1], gap)
        arc.pair = arc.pair[0], arc.contact.in_round(arc.pair[1], leaves)
        before = {watch.contact.number: watch for watch in self.watches}
        every = list[WatchedPair]()
        x, y, theta = self.body[:3]
        for pair in pairs(self.case):
            watch = before.get(pair.number)
            points = watch.pair if watch else pair.guess(x, y, theta)
            is_away = watch.is_away if watch else 0
            if watch is None and pair != successor:
                is_away = pair.away_in_pose(x, y, theta, points)
            every.append(WatchedPair(pair, points, is_away))
        self.watches = [before.get(one.pair.number) or open_watch(one) for one in facing_pairs(every)]
        left = [watch for watch in before.values() if watch not in self.watches and watch.mode is not Mode.FLIGHT]
        heirs = [watch for watch in self.watches if watch.contact == successor] if leaves else [arc]
        for giver, heir in zip([arc] if leaves else left, heirs, strict=False):
            if giver.mode is not Mode.FLIGHT:
                heir.name, heir.mode = giver.name, giver.mode
                self.causes[heir.name] = CAUSES["piece"]
        if leaves:
            arc.name, arc.mode = open_name(arc.contact), Mode.FLIGHT

    def settle(self, stuck: set[str] | None = None, closing: set[str] | None = None) -> None:
        """Remove errors of the integration from the state: no gap at contacts that touch, and no velocity where there
        is none.

        `closing`: contacts that may have closed with a velocity, which is an impact, as may others without a gap; the
        velocities of those that touched before are no part of it. None: no contact has closed."""
        stuck, closed = set(stuck or ()), self.touching - (closing or set())
        if closing is not None:
            self.touching |= closing
            self._add_touching()
        stuck = self._name_touching(stuck)
        indices = [k for k, watch in enumerate(self.watches) if watch.name in self.touching]
        self.body, now = project(self.case, self.contacts(), self.body, [watch.pair for watch in self.watches], indices)
        for watch, at in zip(self.watches, now, strict=True):
            watch.pair = at.xi1, at.xi2
        for k in indices:
            self.watches[k].limit = 0.0 if self.watches[k].contact.has_unique_points else LOST * now[k].clearance
        self.speed = max(self.speed, self.present_speed(), self.belt_speed(self.t))
        if closing is not None:
            kept = [k for k in indices if self.watches[k].name in closed]
            held = [k for k in kept if self.watches[k].name in stuck]
            self.body = without_velocity(self.case, self.t, self.body, now, kept, held, self.turns)
            stuck = self._impacts(now, stuck)
            indices = [k for k, watch in enumerate(self.watches) if watch.name in self.touching]
        sticking = [k for k in indices if self.watches[k].name in stuck]
        self.body = without_velocity(self.case, self.t, self.body, now, indices, sticking, self.turns)
        if self.present_speed() <= SOME_ROUNDINGS * EPS * self.speed:  # decisions would take them for a motion
            self.body[3:] = [0.0, 0.0, 0.0]

    def touches_more(self) -> bool:
        """Add contacts without a gap that do not open to those that touch; returns whether there are any."""
        before, opening, velocity = set(self.touching), CLOSES * self.speed, np.array(self.body[3:])
        for watch, at in zip(self.watches, self.places(), strict=True):
            has_gap = at.gap > TOUCHES * self._size() or watch.is_away
            if not has_gap and float(at.lift_row @ velocity) <= opening:
                self.touching.add(watch.name)
        return self.touching != before

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
        if contact.number in self.named:
            return self.named[contact.number]
        used = {watch.name for watch in self.watches} | set(self.named.values())
        name = next(name for i in range(1, len(used) + 2) if (name := contact_name(contact.support, i)) not in used)
        if contact.is_point_on_curve:
            self.named[contact.number] = name
        return name

    def _add_touching(self) -> None:
        for watch, at in zip(self.watches, self.places(), strict=True):
            if at.gap <= TOUCHES * self._size() and not watch.is_away:
                self.touching.add(watch.name)

    def _size(self) -> float:
        return abs(self.body[0]) + abs(self.body[1]) + self.case.plate.reach

    def closing(self, now: Sequence[ContactPlace]) -> set[str]:
        """The contacts without a gap that close."""
        velocity = np.array(self.body[3:])
        return {
            watch.name for watch, at in zip(self.watches, now, strict=True)
            if not watch.is_away and at.gap <= NO_GAP * self._size() and at.lift_row @ velocity < -CLOSES * self.speed
        }  # fmt: skip

    def _impacts(self, now: Sequence[ContactPlace], stuck: set[str]) -> set[str]:
        """Apply the impact of the touched contacts, and those that follow at the same instant: it may turn the plate so
        that another contact closes whose gap is rounding. Returns the contacts that do not slip afterwards."""
        for _ in range(MOST_IMPACTS):
            indices = [k for k, watch in enumerate(self.watches) if watch.name in self.touching]
            stuck = self._impact(now, indices, stuck)
            more = self.closing(now)
            if not more:
                return stuck
            self.touching |= more
            stuck = self._name_touching(stuck)
        raise MotionEnds(("accumulation", f"{MOST_IMPACTS} impacts took no time at t = {self.t:.9g} s."))

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
            number = "give mu as a number, and " if has_slip_law(self.case) else ""
            raise MotionEnds(
                (
                    "second_contact",
                    f"The plate meets {self._which(closing[0])}, xi1 = {now[closing[0]].xi1:.9g}, at t = "
                    f"{self.t:.9g} s, and the case names no Impact; {number}add Flight() and Impact(0.0) to go on.",
                )
            )
        places_hit = [k for k in indices if lifts[k] <= CLOSES * self.speed]
        try:
            outcome = impact(self.case, self.t, self.body[3:], [now[k] for k in places_hit], self.speed)
        except NoImpact as problem:
            raise MotionEnds(("not_unique", f"At t = {self.t:.9g} s {problem}.")) from problem
        self._check_energy(outcome.velocity)
        self.body[3:], self.turns = outcome.velocity.tolist(), outcome.turns
        touching, closers = (frozenset(self.watches[k].name for k in those) for those in (places_hit, closing))
        self.hops.strike(Strike(self.t, tuple(self.body), max(-lifts[k] for k in closing), touching, closers))
        self.touching, sticks = set(), set[str]()
        for i, k in enumerate(places_hit):
            watch, lift = self.watches[k], float(outcome.lift[i])
            if k in closing:
                self.causes[watch.name] = CAUSES["landing"]
            if lift > 0.0 and not self._is_unresolved(lift, self.pull(now[k])):
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
        weights = np.array([1.0, 1.0, self.case.plate.gyration**2])
        before = np.array(self.body[3:])
        law = self.case.effect(Impact)
        if law is not None and law.law == "newton" and weights @ after**2 > (1.0 + 1e-12) * (weights @ before**2):
            raise MotionEnds(ENERGY)

    def _is_still(self, at: ContactPlace, velocity: np.ndarray) -> bool:
        return abs(at.slip(velocity, self.t)) <= 1e-11 * self.speed

    def _is_unresolved(self, lift: float, pull: float) -> bool:
        """Whether a rebound with that speed (m/s), pulled back by that acceleration (m/s²), rises no higher than
        positions' rounding."""
        rounding = REBOUND_ROUNDINGS * EPS * self._size()
        return lift * lift <= 2.0 * pull * rounding

    def pull(self, at: ContactPlace) -> float:
        """The acceleration of the load towards a contact's support, m/s²."""
        load = load_at(self.case, self.t, self.body)
        weights = compliance(self.case.plate) / self.case.plate.mass
        return max(-float(at.lift_row @ (weights * load)), 0.0)

    def belt_speed(self, t: float) -> float:
        """The largest speed of the closed contacts' surfaces at a time (s), m/s: slips are differences from it."""
        return max((abs(belt_speed(w.contact, t)) for w in self.watches if w.mode is not Mode.FLIGHT), default=0.0)

    def present_speed(self) -> float:
        """The largest of the plate's speeds, m/s; that of the spin at the radius of gyration."""
        return float(np.abs(np.array(self.body[3:]) * np.array([1.0, 1.0, self.case.plate.gyration])).max())
