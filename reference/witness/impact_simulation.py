"""The impacts of a motion by the second formulation, and the ends of their series."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases import Case, Impact
from cases.scene.piece_case import PieceCase, corners_meet, lies_flat

from ..time_limit import check_time
from .complementarity import MOVES
from .contacts import PairState, Sides, friction_of, is_of_couple, is_watched_always, resisting_sides
from .impact_laws import velocities
from .integration import PhaseIntegration
from .phase import WatchedContact
from .plate_state import EPS, TOUCHES, SimulationEnd
from .small_impacts import SMALL_IMPACT, TURNS, ImpactRecord
from .watched_pairs import groups

# Small impacts are extrapolated to their end where the plate moves by less than this part of its size until then.
SMALL_HOP = 1e-9
# Velocities at their end below this part of the last closing speed are the error of the fit.
ENDS = 1e-3
# Impacts of which no cubic shows the end are over where no hop is higher than this part of the plate's size.
LOWEST = 1e-12
# Bouncing with a fixed ratio ends far above this part of the largest speed; slower rebounds have no known end.
ACCUMULATES = 1e-7
# A gap below this part of the plate's size is its rounding.
NO_GAP = 64 * EPS


class ImpactSimulation(PhaseIntegration):
    """A simulation's impacts: what happens at one instant."""

    def __init__(self, case: Case, t: float, body: Sequence[float] | np.ndarray, rtol: float):
        super().__init__(case, t, body, rtol)
        self.struck: set[str] = set()
        self.slow: set[str] = set()  # contacts that slip in the start by less than a rounding of speeds
        self.landing: set[str] = set()

    def strike_all(self, now: Sequence[PairState]) -> bool:
        """The impact at the contacts without a gap. Returns whether it ended a series: gaps that the next ones close
        are rounding there."""
        self.strike(now)
        return self.end_series()

    def strike(self, now: Sequence[PairState]) -> None:
        """The impact at the touched contacts, if one of them closes."""
        check_time()
        places_hit = [k for k, c in enumerate(self.contacts) if c.name in self.touching]
        small = MOVES * self.speed
        # A plate that leaves its track in the start by less than a rounding comes down at once, as fast.
        leaps = self.t == 0.0 and not (self.case.start.in_contact or self.case.others or self.impacts.strikes)
        closing = [k for k in places_hit if now[k].lift < -small]
        closing += [k for k in places_hit if leaps and now[k].lift >= -small
                    and self.is_tiny(max(now[k].lift, 0.0), self.pull(now[k]))]  # fmt: skip
        places_hit = [k for k in places_hit if now[k].lift <= small]
        self.touching = {self.contacts[k].name for k in places_hit}
        if not closing:
            still = {self.contacts[k].name for k in places_hit if abs(now[k].slip) <= small}
            self.stuck |= still - self.slow
            return
        effect = self.case.effect(Impact)
        if effect is None:
            is_first = self.case.others or not any(contact.is_closed for contact in self.contacts)
            raise SimulationEnd("landing" if is_first else "second_contact")
        for pair in (now[k] for k in closing):
            if isinstance(pair.contact, PieceCase) and not is_of_couple(pair.contact):
                if lies_flat(pair.contact, pair.xi1, pair.xi2):
                    raise SimulationEnd("second_contact")
                if corners_meet(pair.contact, pair.xi1, pair.xi2):
                    raise SimulationEnd("landing")
        if any(now[k].clearance <= 0.0 and not is_watched_always(now[k].contact) for k in closing):
            raise SimulationEnd("no_fit")
        velocity, stuck = self.velocities_after(effect, now, places_hit, closing)
        # Contacts that open before the impact, but would close at the same instant, are hit together with the others.
        for _ in self.contacts:
            more = [
                k for k, (contact, pair) in enumerate(zip(self.contacts, now, strict=True))
                if k not in places_hit and not contact.is_away and pair.gap <= NO_GAP * self.size()
                and float(pair.lift_row @ velocity) < -small
            ]  # fmt: skip
            if not more:
                break
            places_hit = sorted([*places_hit, *more])
            velocity, stuck = self.velocities_after(effect, now, places_hit, closing)
        if effect.law == "newton":
            turns = self.dynamics.inverse > 0.0
            weights = 1.0 / self.dynamics.inverse[turns]
            if weights @ velocity[turns] ** 2 > (1.0 + 1e-12) * (weights @ self.body[self.half :][turns] ** 2):
                raise SimulationEnd("energy_gain")
        self.body[self.half :] = velocity
        names, closers = (frozenset(self.contacts[k].name for k in those) for those in (places_hit, closing))
        record = ImpactRecord(self.t, max(abs(now[k].lift) for k in closing), names, closers, self.body.copy())
        self.impacts.count(record)
        self.still = self.still_in([now[k] for k in places_hit], velocity, small)
        self.touching, self.stuck, tiny = set(), set(), False
        for i, k in enumerate(places_hit):
            name, lift = self.contacts[k].name, float(now[k].lift_row @ velocity)
            if k in closing:
                self.struck.add(name)
            if lift > small and not self.is_tiny(lift, self.pull(now[k])):
                continue
            tiny |= lift > small
            self.touching.add(name)
            if stuck[i]:
                self.stuck.add(name)
        self.impacts.at_rest |= tiny
        self.name_touching()

    def still_in(self, some: Sequence[PairState], velocity: np.ndarray, none: float) -> set[Sides]:
        """The plates whose rotation these contacts resist and that have none: below that speed (m/s) at the radius of
        gyration."""
        sides = resisting_sides(some)
        return {p.sides for p in some if p.sides in sides and abs(float(p.turning_row @ velocity)) <= none}

    def velocities_after(
        self, effect: Impact, now: Sequence[PairState], hit: Sequence[int], closing: Sequence[int]
    ) -> tuple[np.ndarray, list[bool]]:
        """Velocities after an impact at the contacts `hit`, of which those in `closing` close, and which of them do not
        slip."""
        before, small, some = self.body.copy(), MOVES * self.speed, [now[k] for k in hit]
        stuck = [abs(pair.slip) <= small for pair in some]
        for group in groups([pair.contact for pair in some]):
            if not any(hit[i] in closing for i in group):
                continue
            self.body[self.half :], sticks = velocities(self, effect, [some[i] for i in group])
            for i, sticking in zip(group, sticks, strict=True):
                stuck[i] = sticking
        velocity, self.body = self.body[self.half :].copy(), before
        return velocity, stuck

    def pull(self, pair: PairState) -> float:
        """The acceleration of the load towards a contact's support, m/s²."""
        free = self.dynamics.inverse * self.dynamics.torsor(self.t, self.body)
        return max(-float(pair.lift_row @ free), 0.0)

    # --- series of impacts --------------------------------------------------------------------------------------------

    def is_low(self, height: float) -> bool:
        """Whether the hops at all contacts of the last impacts are at most that high, m."""
        names = {name for record in self.impacts.strikes[-TURNS:] for name in record.names}
        now = [p for c, p in zip(self.contacts, self.pairs(), strict=True) if c.name in names]
        return all(2.0 * self.pull(pair) * (height - pair.gap) >= pair.lift**2 for pair in now)

    def bounces_on(self, contact: WatchedContact, pair: PairState) -> bool:
        """Whether small impacts have hit an open contact lately, and go on to."""
        is_hit = any(contact.name in record.closers for record in self.impacts.strikes[-TURNS:])
        is_near = contact.name not in self.touching and not contact.is_away and pair.gap <= SMALL_HOP * self.size()
        return is_hit and is_near and abs(pair.lift) < SMALL_IMPACT * self.impacts.fastest

    def end_series(self) -> bool:
        """Go to the end of a series of small impacts, where its contacts touch; others may bounce on. Returns whether
        there is one."""
        last = self.impacts.strikes[-1] if self.impacts.strikes else None
        if last is None or last.time != self.t:
            return False
        small, noise = SMALL_HOP * self.size(), ENDS * last.closing
        if self.impacts.is_first() and self.go_to_end(self.impacts.firsts.end(self.t, small), noise):
            self.impacts.end_all()
        elif not self.go_to_end(self.impacts.end(self.t, small), noise):
            return False
        self.land()
        return True

    def go_to_end(self, answer: tuple[float, np.ndarray, frozenset[str], float] | None, noise: float) -> bool:
        """Go to the end of a series, if there is one within the motion; returns whether it does."""
        if answer is None or answer[0] >= self.case.duration:
            return False
        end, body, names, doubt = answer
        return self.come_to_rest(end, body, names, noise, doubt)

    def land(self) -> None:
        """The impact of the contacts that close where a series ends: its small changes are over before."""
        if self.landing:
            self.impacts.list_changes(self.t, [])
            self.touching |= self.landing
            self.landing = set()
            self.name_touching()
            self.close_gaps()
            self.strike_all(self.pairs())

    def end_bouncing(self) -> None:
        """Go to the end of small impacts of which no series shows the end, where their hops are rounding. A motion of
        several plates ends where impacts follow each other ever faster, and no end of them is found."""
        last = self.impacts.strikes[-1] if self.impacts.strikes else None
        self.end_hops(last)
        if self.case.others and last is not None and last.time == self.t and last.names - self.touching:
            if last.closing < ACCUMULATES * self.speed:
                raise SimulationEnd("accumulation")

    def end_hops(self, last: ImpactRecord | None) -> None:
        """Go to the end of hops that are rounding, the last impact of which is given."""
        if last is None or last.time != self.t or not (self.impacts.small or self.impacts.at_rest):
            return
        size = self.size()
        if self.impacts.end(self.t, SMALL_HOP * size) is not None:
            return  # another contact closes before
        if self.impacts.is_driven():
            raise SimulationEnd("accumulation")
        # The gap of one contact is integrated, and hops are resolved down to its rounding.
        is_low = (self.is_several or bool(self.case.others)) and self.is_low(LOWEST * size)
        if is_low or self.impacts.at_rest:
            some = zip(self.contacts, self.pairs(), strict=True)
            low = frozenset(c.name for c, p in some if p.gap <= LOWEST * size and (is_low or c.name in self.touching))
            end, body = self.impacts.low_end(self.t, self.body, low)
            if (is_low or end > self.t) and end < self.case.duration:
                self.come_to_rest(end, body, low, 2.0 * last.closing)

    def come_to_rest(
        self, end: float, body: np.ndarray, names: frozenset[str], noise: float, doubt: float = 0.0
    ) -> bool:
        """Go to a time (s) and state where contacts touch, unless others meet their supports before: by more than the
        time may be off, `doubt` (s); otherwise they are `landing`. Velocities below `noise` (m/s) are none. Returns
        whether it does."""
        before, self.body = self.body.copy(), body
        bouncing = {c.name for c in self.contacts if c.name in names and not c.is_away}
        others = [(c.name, p) for c, p in zip(self.contacts, self.pairs(), strict=True) if not c.is_away]
        least = TOUCHES * self.size()
        landing = {name for name, p in others if p.lift < 0.0 and abs(p.gap) <= least - p.lift * doubt} - bouncing
        if any(p.gap <= 0.0 for name, p in others if name not in landing | bouncing):
            self.body = before
            return False
        self.touching, self.landing = bouncing, landing
        self.close_gaps()
        if np.abs(self.body[self.half :] * self.dynamics.units).max() <= noise:
            self.body[self.half :] = 0.0
        self.stuck = {
            c.name for c, pair in zip(self.contacts, self.pairs(), strict=True)
            if c.name in self.touching and abs(pair.slip) <= noise and friction_of(pair.contact)[1] > 0.0
        }  # fmt: skip
        some = [pair for c, pair in zip(self.contacts, self.pairs(), strict=True) if c.name in self.touching]
        self.still = self.still_in(some, self.body[self.half :], noise)
        self.hold()
        self.t, self.impacts.at_rest = end, True
        return True
