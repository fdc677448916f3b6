"""Decisions of all groups of contacts that touch, and the changes of mode that follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cases import Case, Flight, Mode, PerfectlyRough, Transition

from ..effect_laws.friction import STICKING
from ..endings import (
    CAUSES,
    LIFT_OFF,
    NO_MODE,
    NO_SLIP,
    Ending,
    combination_limit_ending,
    forces_not_unique,
    several_motions,
)
from ..scales import EPS
from .accelerations import DecisionInstant
from .decide import Decision, decide, flat_of, shares_of
from .hops import NestedSeries
from .impact_ends import ImpactEnds
from .mode_program import TooManyModes
from .places import ContactPlace, anchors_of, groups, plates_in
from .plate_numbers import Turns, size
from .regimes import SolverRegime, key_of
from .watched_plates import SOME_ROUNDINGS, MotionEnds, Watch

# A contact that has opened is watched as long as its gap is below this part of the plates' size where modes change.
NEAR = 1e-3


class ModeChanges(ImpactEnds):
    """Plates whose modes are decided, group by group.

    `fixed`: the modes that some contacts may have; `at_limit`: those whose forces have reached a limit at rest;
    `may_slide`: whether these may keep their modes, as those of plates without friction that begin to slide; `begins`:
    the modes of a start are no changes; `may_float`: whether the force that opens a contact may stay at zero.
    """

    def __init__(self, case: Case, state: tuple[float, ...], hops: NestedSeries):
        super().__init__(case, state, hops)
        self.fixed, self.at_limit, self.begins = dict[str, tuple[Mode, ...]](), set[str](), False
        self.may_float, self.may_slide = True, False

    def _decision_errors(self) -> Sequence[float]:
        """The parts of a bound within which values are at it: the least one that explains a motion decides."""
        raise NotImplementedError

    def _decide(self) -> SolverRegime:
        closed, errors = self._closed(), self._decision_errors()
        now, places = DecisionInstant(self.case, self.t, self.state, self.speed, errors[0]), self._places(closed)
        modes, resting, slack = dict[str, Mode](), set[int](), list[tuple[str, str, float]]()
        turns: Turns = ()
        guides = dict[str, tuple[bool, bool] | None]()
        for group in groups(places):
            some, names = [places[k] for k in group], [closed[k].name for k in group]
            fixed = {i: self.fixed[name] for i, name in enumerate(names) if name in self.fixed}
            last_modes: tuple[Mode, ...] | None = None
            if self.at_limit & set(names):
                last_modes = () if self.may_slide else tuple(closed[k].mode for k in group)
            was_closed = [i for i, k in enumerate(group) if closed[k].mode is not Mode.FLIGHT]
            try:
                decision = self._decide_group(now, some, fixed, last_modes, was_closed)
                for error in errors[1:]:
                    if decision.motions or decision.is_singular:
                        break
                    decision = self._decide_group(replace(now, error=error), some, fixed, last_modes, was_closed)
            except TooManyModes as problem:
                raise MotionEnds(combination_limit_ending(self.t, names)) from problem
            if decision.modes is None:
                raise MotionEnds(self._no_modes(names, decision))
            modes |= dict(zip(names, decision.modes, strict=True))
            turns += decision.turns
            guides |= dict(zip(names, decision.guides, strict=False))
            for condition, amount in decision.slack:
                kind, _, number = condition.partition(":")
                slack.append((kind, names[int(number)] if number else "", amount))
            if decision.rests:
                resting |= plates_in(some)
                continue
            for part in self._resting_parts(now, some, names, decision.modes):
                modes |= part
                resting |= plates_in([at for at, name in zip(some, names, strict=True) if name in part])
                slack = [one for one in slack if one[1] not in part]
        self.at_limit, self.still = set(), []
        remaining = [
            (watch, at) for watch, at in zip(closed, places, strict=True) if modes[watch.name] is not Mode.FLIGHT
        ]
        sticking = {watch.name for watch, _ in remaining if modes[watch.name] in STICKING}
        slips = [abs(at.slip(self.velocity, self.t)) for watch, at in remaining if watch.name in sticking]
        if max(slips, default=0.0) > SOME_ROUNDINGS * EPS * self.speed:  # an event's error
            self._remove_velocities(remaining, sticking)
            self._still([at for _, at in remaining])
        self._record(modes)
        return self._regime(resting, slack, turns, guides)

    def _follows(self, watch: Watch, gap: float) -> bool:
        """Whether an open contact with that gap (m) is followed, as it is the only one of its plate."""
        raise NotImplementedError

    def _decide_group(
        self, now: DecisionInstant, some: Sequence[ContactPlace], fixed: dict[int, tuple[Mode, ...]],
        last_modes: tuple[Mode, ...] | None, was_closed: Sequence[int],
    ) -> Decision:  # fmt: skip
        decision = decide(now, some, fixed, last_modes, was_closed)
        if not fixed or (decision.motions and not self.may_float):
            return decision
        free = decide(now, some, {}, None, was_closed)
        return free if not decision.motions or self._stays_without_force(free, fixed) else decision

    @staticmethod
    def _stays_without_force(free: Decision, fixed: dict[int, tuple[Mode, ...]]) -> bool:
        """Whether a contact that is to open, as its force has vanished, neither opens nor has a force from then on."""
        return any(f"normal:{k}" == name for k in fixed for name, _ in free.slack)

    def _record(self, modes: dict[str, Mode]) -> None:
        """List the changes of modes; contacts that have opened and are far away are no longer watched."""
        changes = list[Transition]()
        for watch in self.watches:
            mode = modes.get(watch.name, Mode.FLIGHT)
            bounced = self.causes.get(watch.name) == CAUSES["landing"]
            if mode is not watch.mode or (bounced and mode is Mode.FLIGHT):
                cause = self.causes.get(watch.name, "the motion of another contact changed")
                xi1, xi2 = watch.pair.to_whole(*watch.points)
                couple = watch.pair.whole
                changes.append(
                    Transition(self.t, watch.mode, mode, float(couple.whole_xi1(xi1)), xi2, cause, watch.name)  # type: ignore[attr-defined]
                )
            watch.mode = mode
        if self.begins:  # the modes of a start are no changes
            changes, self.begins = [], False
        came_to_rest = CAUSES["rest"] in self.causes.values()
        bouncing = self._bouncing() if came_to_rest else frozenset[str]()
        self.hops.record(self.t, changes, CAUSES["rest"] if came_to_rest else "", bouncing)
        self.causes, self.fixed, self.may_float = {}, {}, True
        if all(watch.mode is Mode.FLIGHT for watch in self.watches) and self.case.effect(Flight) is None:
            raise MotionEnds(LIFT_OFF)
        least = NEAR * size(self.case, self.state)
        remaining = list[Watch]()
        for watch, at in zip(self.watches, self._places(self.watches), strict=True):
            if watch.mode is not Mode.FLIGHT:
                remaining.append(watch)
            elif (self._follows(watch, at.gap) or at.gap <= least) and at.clearance > 2.0 * watch.lost:
                remaining.append(watch)
        self.watches = remaining

    def _regime(
        self, resting: set[int], slack: list[tuple[str, str, float]], turns: Turns,
        guides: dict[str, tuple[bool, bool] | None],
    ) -> SolverRegime:  # fmt: skip
        """The regime of all watched contacts, closed ones first."""
        self.watches.sort(key=lambda watch: (watch.mode is Mode.FLIGHT, key_of(watch.pair, watch.points)))
        places = self._places(self.watches)
        now = [watch.mode for watch in self.watches]
        shares, flat = shares_of(places, now), flat_of(places, now)
        shares = {k: first for k, first in shares.items() if self.watches[k].name not in guides}
        order = {watch.name: k for k, watch in enumerate(self.watches)}
        closed = [at for at, mode in zip(places, now, strict=True) if mode is not Mode.FLIGHT]
        stuck = [at for at, mode in zip(places, now, strict=True) if mode in STICKING]
        return SolverRegime(
            tuple(key_of(watch.pair, watch.points) for watch in self.watches),
            tuple(now),
            tuple(watch.name for watch in self.watches),
            frozenset(resting),
            tuple(shares.get(k) for k in range(len(now))),
            tuple(
                (f"{kind}:{order[name]}" if name else kind, amount)
                for kind, name, amount in slack
                if not name or name in order  # a contact that is no longer watched has no guard
            ),
            tuple(float(np.float32(watch.lost)) for watch in self.watches),
            turns,
            tuple(guides.get(watch.name) for watch in self.watches) if guides else (),
            tuple(flat.get(k) for k in range(len(now))),
            anchors_of(self.case, self.velocity, closed, stuck) - resting,
            tuple(watch.at_joint for watch in self.watches) if any(watch.at_joint for watch in self.watches) else (),
            tuple(watch.room if watch.mode is Mode.FLIGHT else 0.0 for watch in self.watches),
        )

    def _resting_parts(
        self, now: DecisionInstant, some: Sequence[ContactPlace], names: Sequence[str], modes: Sequence[Mode]
    ) -> list[dict[str, Mode]]:
        """The modes of parts of a group that rest by themselves, as contacts that open no longer link them to plates
        that move."""
        velocity = self.velocity.reshape(-1, 3)
        still = {b for b in plates_in(some) if not velocity[b].any()}
        apart = [k for k, at in enumerate(some) if set(at.sides) <= still]
        if len(apart) == len(some):
            return []
        links = [k for k in range(len(some)) if k not in apart and modes[k] is not Mode.FLIGHT]
        parts = list[dict[str, Mode]]()
        for group in groups([some[k] for k in apart]):
            part = [apart[i] for i in group]
            if plates_in([some[k] for k in part]) & plates_in([some[k] for k in links]):
                continue  # a plate that moves presses on it
            decision = decide(now, [some[k] for k in part], {})
            if decision.modes is not None and decision.rests:
                parts.append(dict(zip((names[k] for k in part), decision.modes, strict=True)))
        return parts

    def _no_modes(self, names: Sequence[str], decision: Decision) -> Ending:
        if decision.motions:
            return several_motions(self.t, names, decision.motions)
        if decision.is_singular:
            return forces_not_unique(self.t, names)
        return NO_MODE if self.case.effect(PerfectlyRough) is None else NO_SLIP
