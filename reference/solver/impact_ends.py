"""Impacts that accumulate: where they end, and the state then."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases import Mode
from cases.curves.corner import Corner

from ..endings import CAUSES
from ..minimal.bouncing import is_unresolved, straight
from ..minimal.integrators.segment import Segment
from ..scales import TOUCHES
from .hops import SMALL_HOP, SeriesEnd
from .places import place, plates_in, project, without_velocity
from .plate_numbers import bodies, load_at, load_scale, rows_of, size
from .regimes import SolverPhase, SolverRegime, join, key_of, regime_of, solver_phase
from .touching import touching_contacts
from .watched_plates import CLOSES, NO_GAP, Watch, WatchedPlates, is_same_contact

# Impacts are extrapolated to an end until which plates move by less than this part of their size, of a turn and of what
# they pass.
SMALL = 2e-2
# Bouncing with a fixed ratio ends far above this part of the largest speed; slower rebounds have no known end.
ACCUMULATES = 1e-7
# Contacts that may close at the end of impacts, whose time has a doubt, have gaps below this part of the plates' size.
MAY_LAND = 1e-6


class ImpactEnds(WatchedPlates):
    """Plates whose impacts may follow each other ever faster. A subclass advances them along a segment."""

    def _advance(self, segment: Segment) -> None:
        raise NotImplementedError

    def _variables(self, phase: SolverPhase) -> tuple[float, ...]:
        """The variables of a phase in the present state."""
        some = [watch for watch, room in zip(self.watches, regime_of(phase).rooms, strict=True) if room]
        least = NO_GAP * size(self.case, self.state)
        gaps = [at.gap if at.gap > least else 0.0 for at in self._places(some)]
        return join(self.state, [watch.points for watch in self.watches], gaps)

    def _low_hops(self, phase: SolverPhase) -> set[str]:
        """The contacts that an impact has just opened, whose hops rise no higher than positions' rounding: the other
        contacts' forces may drive plates together that their loads do not. A contact that touched in the decision has
        been opened by its forces, and stays open.

        Where impacts follow each other ever faster without a fixed ratio, all of their contacts that open no faster:
        which of them open is a question of forces then."""
        if self.impact_time != self.t:
            return set()
        y = self._variables(phase)
        rates = phase.system.rates_of_numbers(self.t, y, phase.parameters)
        acceleration, velocity, low = np.array(rates[len(rates) - self.half :]), self.velocity, set[str]()
        slow, far = ACCUMULATES * self.speed, size(self.case, self.state)
        recent = self.hops.recent(self.t)
        if recent and self.hops.strikes[-1].closing >= slow:
            recent = frozenset()
        opened = [watch for watch in self.watches if watch.mode is Mode.FLIGHT and watch.name not in self.touching]
        for watch, at in zip(opened, self._places(opened), strict=True):
            lift, pull = float(at.lift_row @ velocity), -float(at.lift_row @ acceleration + at.lift_bias)
            if at.gap > TOUCHES * far:
                continue
            is_slow = watch.name in recent and CLOSES * self.speed < abs(lift) <= slow
            if is_slow or (lift > 0.0 and is_unresolved(lift, pull, far)):
                low.add(watch.name)
        return low

    def _end_bouncing(self) -> None:
        """Go to the instant at which impacts that accumulate end, if they do: plates move by less than rounding until
        then, and all contacts of the last impacts touch."""
        end = self._end_of_impacts()
        if end is None or not end.time < self.case.duration:
            return
        limit, values = end.time, tuple(end.body)
        places = [(watch.pair, place(watch.pair, values, watch.points)) for watch in self.watches]
        far = size(self.case, self.state)
        ways = np.abs(np.array(values[: self.half]) - self.state[: self.half]) * bodies(self.case).lengths
        for pair, points in touching_contacts(self.case, np.array(values), max(MAY_LAND, float(ways.sum()) / far)):
            if any(is_same_contact(one, (at.xi1, at.xi2), pair, points) for one, at in places):
                continue
            gap = place(pair, values, points).gap
            if gap < -MAY_LAND * far:
                return  # it closes before
            if gap <= MAY_LAND * far:
                self._watch(pair, points)
        of_series = [watch for watch in self.watches if watch.name in end.contacts]
        near = [watch for watch in self.watches if watch.name in end.contacts or watch.name in self.touching]
        moving, others = np.array(values[self.half :]), [watch for watch in self.watches if watch not in near]
        ats = [(watch.name, place(watch.pair, values, watch.points)) for watch in others]
        closings = [(name, at.gap, float(at.lift_row @ moving)) for name, at in ats]
        landing = end.landing(closings, TOUCHES * far)
        if landing is None:
            return
        state, now = project(self.case, values, [place(watch.pair, values, watch.points) for watch in near])
        velocity, lengths = np.array(state[self.half :]), bodies(self.case).lengths
        stuck = {
            watch.name for watch, at in zip(near, now, strict=True)
            if at.stick > 0.0 and abs(at.slip(velocity, limit)) <= end.error
        }  # fmt: skip
        still = rows_of(plates_in(now))
        if all(abs(velocity[c]) * lengths[c] <= end.error for c in still):
            velocity[still] = 0.0
        sticking = [at for watch, at in zip(near, now, strict=True) if watch.name in stuck]
        state = without_velocity(self.case, limit, (*state[: self.half], *velocity.tolist()), now, sticking)
        if limit > self.t:
            self._advance(self._straight(near, limit, state))
        for watch, at in zip(near, now, strict=True):
            watch.points = at.xi1, at.xi2
        if end.ends_cascade:
            self.hops.end_cascade()
        self.state, self.touching = state, {watch.name for watch in near}
        self.causes = {watch.name: CAUSES["rest"] for watch in of_series}
        if landing:
            self.hops.record(self.t, [], CAUSES["rest"])
            self.causes = {}
            self._settle(stuck, closing=set(landing))

    def _end_of_impacts(self) -> SeriesEnd | None:
        """The end of small impacts. Those that alternate between two corners without a fixed ratio end where all hops
        are lower than what counts as touching."""
        far = size(self.case, self.state)
        end = self.hops.limit(self.t, far)
        if end is not None and not self._is_smooth(end):
            end = None
        if end is None and CAUSES["rest"] in self.causes.values():
            end = self._last(frozenset(self.touching))
            if end is None and self.hops.is_small:
                end = self._lowest(frozenset(self.touching))
        # Of a contact that is followed hops are known until a rebound is a rounding.
        if end is None and not any(watch.room for watch in self.watches) and self._is_low(TOUCHES * far):
            places_now = zip(self.watches, self._places(self.watches), strict=True)
            touching = frozenset(watch.name for watch, at in places_now if at.gap <= TOUCHES * far)
            return self._last(touching) or self._lowest(touching) or self._now(touching)
        return end

    def _last(self, touching: frozenset[str]) -> SeriesEnd | None:
        """The end of impacts at these contacts whose rebounds are roundings."""
        if not self.hops.strikes or self.hops.strikes[-1].time != self.t:
            return None
        end = self.hops.limit(self.t, size(self.case, self.state), is_last=True)
        return end if end is not None and end.contacts <= touching else None

    def _is_smooth(self, end: SeriesEnd) -> bool:
        """Whether plates fall, turn and pass features by small parts only until that end: impacts before it show how
        they move."""
        lasts, least = end.time - self.t, min(bodies(self.case).reaches)
        turns = float(np.abs(self.velocity[2::3]).max()) * lasts
        if max(load_scale(self.case, self.t, self.state) * lasts**2 / least, turns**2) > SMALL**2:
            return False
        for watch, at in zip(self.watches, self._places(self.watches), strict=True):
            if watch.name not in end.contacts:
                continue
            last = place(watch.pair, end.body, watch.points)
            for curve, before, after in zip(watch.pair.pieces, (at.xi1, at.xi2), (last.xi1, last.xi2), strict=True):
                if isinstance(curve, Corner) or curve.features is None:
                    continue
                if abs(after - before) > SMALL * curve.features.piece_length(before):
                    return False
        return True

    def _lowest(self, touching: frozenset[str]) -> SeriesEnd | None:
        """The end of low hops on the line through the last two; at once, if plates that do not bounce would leave that
        line by more than what counts as touching."""
        end, far = self.hops.lowest(touching), size(self.case, self.state)
        if end is None:
            return None
        bend = load_scale(self.case, self.t, self.state) * (end.time - self.t) ** 2
        return end if bend <= TOUCHES * far else self._now(touching)

    def _now(self, touching: frozenset[str]) -> SeriesEnd:
        return SeriesEnd(self.t, list(self.state), touching, 2.0 * self.hops.strikes[-1].closing)

    def _is_low(self, height: float) -> bool:
        """Whether a small impact ends hops of at most that height, m, at all contacts of the last impacts."""
        recent, velocity = self.hops.recent(self.t), self.velocity
        if not recent:
            return False
        load, hops = load_at(self.case, self.t, self.state), list[float]()
        for watch, at in zip(self.watches, self._places(self.watches), strict=True):
            pull = -float(at.lift_row @ load)
            if watch.name in recent and pull > 0.0:
                hops.append(at.gap + float(at.lift_row @ velocity) ** 2 / (2.0 * pull))
        return 0 < len(hops) == len(recent) and max(hops) <= height

    def _bouncing(self) -> frozenset[str]:
        """The contacts that small impacts go on to hit, while others have come to rest."""
        height, velocity = SMALL_HOP * size(self.case, self.state), self.velocity
        near = [(w, at) for w, at in zip(self.watches, self._places(self.watches), strict=True) if at.gap <= height]
        return self.hops.bouncing(
            {watch.name: float(at.lift_row @ velocity) for watch, at in near if watch.name not in self.touching}
        )

    def _straight(self, near: Sequence[Watch], limit: float, state: tuple[float, ...]) -> Segment:
        """The segment between the last impact that is simulated and the end of all of them."""
        names = {watch.name for watch in near}
        every = frozenset(range(self.half // 3))
        modes = tuple(Mode.SLIDE if watch.name in names else watch.mode for watch in self.watches)
        keys, own = (
            tuple(key_of(watch.pair, watch.points) for watch in self.watches),
            tuple(watch.name for watch in self.watches),
        )
        phase = solver_phase(self.case, SolverRegime(keys, modes, own, every))
        first = join(self.state, [watch.points for watch in self.watches])
        at_end = [place(watch.pair, state, watch.points) for watch in self.watches]
        last = join(state, [(at.xi1, at.xi2) for at in at_end])  # plates that do not bounce may be fast
        return straight(phase, self.t, limit, first, last)
