"""The motion of several plates: phases, events and impacts until the end of the time span or a status."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import prod

import numpy as np

from cases import Case, Impact, Mode, Transition
from cases.free_plates import plate_contacts, start_poses

from ..minimal.bouncing import StraightStates
from ..minimal.flight_end import REBOUND_ROUNDINGS
from ..minimal.integrators.segment import BREAKDOWN, OUT_OF_STEPS, Event, Segment
from ..minimal.phase_end import (
    CAUSES,
    COMPLETION,
    ENDS,
    ENERGY,
    NO_MODE,
    Ending,
    singular_ending,
    work_limit_ending,
)
from ..minimal.series import EPS
from ..scales import doubt_of_closing, frequency, speed_scale
from ..several.hops import NestedSeries, Strike
from ..several.impact import Inertia, NoImpact, impact_of_all
from ..several.phase_loop import PhaseLoop, several_motions
from ..several.watched_plate import CLOSES, NO_GAP, SOME_ROUNDINGS, TOUCHES, MotionEnds
from .group_decision import GroupDecision, decide
from .held_plates import end_of_hold, held_plates, inner_contacts
from .plate_places import (
    PlateContactPlace,
    groups,
    numbers_of,
    place,
    places,
    plates_in,
    project,
    regions_of,
    size,
    speed,
    without_velocity,
)
from .plates_phase import PlatesPhase, PlatesRegime, moving_contacts, plates_phase

# Impacts are extrapolated to their end where plates move by less than this part of their size until then.
SMALL_HOP = 1e-9
# Bouncing with a fixed ratio ends far above this part of the largest speed; slower rebounds have no known end.
ACCUMULATES = 1e-7
# Modes and impulses are enumerated, four for each contact with friction: so many combinations take a second.
MOST_COMBINATIONS = 4**6


class PlatesSimulation(PhaseLoop):
    """A simulation of several plates."""

    def __init__(self, case: Case, rtol: float, integrate: Callable[..., Segment]):
        poses = start_poses(case)
        self.case, self.rtol, self.integrate = case, rtol, integrate
        self.contacts, self.t = plate_contacts(case), 0.0
        self.state: tuple[float, ...] = (*poses[:, :3].ravel().tolist(), *poses[:, 3:].ravel().tolist())
        self.half = len(self.state) // 2
        self.modes = dict.fromkeys(range(len(self.contacts)), Mode.FLIGHT)
        self.touching: set[int] = set()
        self.segments: list[Segment] = []
        self.hops = NestedSeries()
        self.causes: dict[int, str] = {}
        self.fixed: dict[int, tuple[Mode, ...]] = {}
        self.loose = frozenset[int]()
        numbers = numbers_of(case)
        self.speed = speed_scale(float(np.abs(numbers.load).max()), min(numbers.radii))
        self.idle, self.work, self.begins = 0, 0, True

    @property
    def transitions(self) -> list[Transition]:
        """All transitions so far."""
        return self.hops.all

    def _begin(self) -> None:
        self._settle(set(), closing=self.touching)

    def _next_phase(self) -> Ending | None:
        return self._phase(self._decide())

    # --- one phase ----------------------------------------------------------------------------------------------------

    def _decide(self) -> PlatesRegime:
        self._end_bouncing()
        error = self._decision_error()
        modes, resting, idle = dict.fromkeys(self.modes, Mode.FLIGHT), set[int](), set[int]()
        for group in groups(self.case, sorted(self.touching)):
            self._check_count(group)
            decision = decide(self.case, self.t, self.state, group, self.speed, error, self.fixed, self.loose)
            if decision.modes is None and (self.fixed or self.loose) and not decision.motions:
                decision = decide(self.case, self.t, self.state, group, self.speed, error, {})
            if decision.modes is None and self.fixed and not decision.motions:
                # Where a force has vanished within the event's error, the gap may seem to close.
                opening = frozenset(self.fixed)
                decision = decide(self.case, self.t, self.state, group, self.speed, error, self.fixed, opening=opening)
            if decision.modes is None:
                raise MotionEnds(self._no_modes(group, decision))
            modes |= dict(zip(group, decision.modes, strict=True))
            idle |= decision.idle
            resting |= decision.resting
            if decision.resting:
                continue
            for part in self._resting_parts(group, decision.modes, error):
                modes |= part
                resting |= plates_in(self.case, list(part))
                idle -= set(part)
        changes = list[Transition]()
        for number, mode in modes.items():
            bounced = self.causes.get(number) == CAUSES["landing"]
            if mode is not self.modes[number] or (bounced and mode is Mode.FLIGHT):
                at = place(self.case, number, self.state)
                cause = self.causes.get(number, "the motion of another contact changed")
                before, name = self.modes[number], self.contacts[number].name
                changes.append(Transition(self.t, before, mode, at.xi1, at.xi2, cause, name))
        if self.begins:  # the modes of a start are no changes
            changes, self.begins = [], False
        came_to_rest = CAUSES["rest"] in self.causes.values()
        self.hops.record(self.t, changes, CAUSES["rest"] if came_to_rest else "")
        self.modes, self.causes, self.fixed, self.loose = modes, {}, {}, frozenset()
        return PlatesRegime(
            tuple(modes), tuple(modes.values()), frozenset(resting), frozenset(idle), self._regions(modes, self.state)
        )

    def _resting_parts(self, group: Sequence[int], modes: Sequence[Mode], error: float) -> list[dict[int, Mode]]:
        """The modes of parts of a group that rest by themselves, as contacts that open no longer link them to plates
        that move."""
        speeds = np.array(self.state[self.half :]).reshape(-1, 3)
        still = {b for b in plates_in(self.case, group) if not speeds[b].any()}
        apart = [n for n in group if plates_in(self.case, [n]) <= still]
        if len(apart) == len(group):
            return []
        links = {n for n, mode in zip(group, modes, strict=True) if n not in apart and mode is not Mode.FLIGHT}
        parts = list[dict[int, Mode]]()
        for part in groups(self.case, apart):
            if links and plates_in(self.case, part) & plates_in(self.case, list(links)):
                continue  # a plate that moves presses on it
            decision = decide(self.case, self.t, self.state, part, self.speed, error, {})
            if decision.modes is not None and decision.resting == plates_in(self.case, part):
                parts.append(dict(zip(part, decision.modes, strict=True)))
        return parts

    def _regions(self, contacts: Iterable[int], state: Sequence[float]) -> tuple[tuple[int, int], ...]:
        """The regions of polygons in which contacts are."""
        return regions_of(self.case, contacts, places(self.case, list(contacts), state))

    def _check_count(self, group: Sequence[int]) -> None:
        count = prod(4 if at.stick > 0.0 else 2 for at in places(self.case, group, self.state))
        if count > MOST_COMBINATIONS:
            names = ", ".join(self.contacts[number].name for number in group)
            raise MotionEnds(
                (
                    "unfinished",
                    f"{names} touch together at t = {self.t:.9g} s: {count} combinations of modes, more than the "
                    f"{MOST_COMBINATIONS} that are tried.",
                )
            )

    def _no_modes(self, group: Sequence[int], decision: GroupDecision) -> Ending:
        names = [self.contacts[number].name for number in group]
        if decision.motions:
            return several_motions(self.t, names, decision.motions)
        if decision.is_singular:
            return BREAKDOWN, (
                f"At t = {self.t:.9g} s the forces of {', '.join(names)} are not unique while the plates move, and "
                "this motion is not computed."
            )
        return NO_MODE

    def _phase(self, regime: PlatesRegime) -> Ending | None:
        """Integrate one phase and apply its event; returns an ending, or None."""
        phase = plates_phase(self.case, regime)
        low = self._low_hops(phase)
        if low:
            self.touching = set(regime.closed) | low
            self.causes = dict.fromkeys(low, CAUSES["rest"])
            self._settle({n for n, mode in self.modes.items() if mode is Mode.ROLL})
            return None
        segment = self.integrate(phase, self.t, self.state, self.case.duration, self.rtol)
        limit = end_of_hold(segment)
        segment = segment if limit is None else segment.cut(limit, "hold")
        self._advance(segment)
        guard = segment.event.guard
        self.touching = set(regime.closed)
        stuck = {n for n, mode in self.modes.items() if mode is Mode.ROLL}
        if guard is None:
            return COMPLETION
        if guard == OUT_OF_STEPS:
            return work_limit_ending(self.t, segment.steps)
        if guard == BREAKDOWN:
            return singular_ending(self.t)
        kind, _, index = guard.partition(":")
        if kind in ENDS:
            return ENDS[kind]
        if kind == "hold":
            self.loose = held_plates(phase)
            inner = inner_contacts(self.case, regime.closed, self.loose)
            self.causes |= dict.fromkeys(inner, "the forces reached their limit")
            self._settle(stuck, self._closing())
            return None
        number, _ = moving_contacts(self.case, regime)[int(index)]
        if kind == "gap":
            self._wait_for_sharper(phase, number)
            self._settle(stuck, closing={number})
            return None
        closing = self._closing()  # an impact at the same instant
        if kind in ("low", "high"):  # the contact passes a corner of a polygon, or a disc flies past it
            self.causes[number] = "the contact passed a corner"
            self._settle(stuck, closing)
            return None
        self.causes[number] = CAUSES["normal_force" if kind == "normal" else kind]
        if kind == "slip":
            stuck.add(number)
        if kind == "normal" and not closing:
            self.fixed = {number: (Mode.FLIGHT,)}
        self._settle(stuck, closing)
        return None

    def _closing(self) -> set[int] | None:
        """The open contacts without a gap that close; None if there are none."""
        velocity, least = np.array(self.state[self.half :]), NO_GAP * size(self.case, self.state)
        every = [(n, place(self.case, n, self.state)) for n in self.modes if n not in self.touching]
        fast = CLOSES * self.speed
        return {n for n, at in every if at.gap <= least and float(at.lift_row @ velocity) < -fast} or None

    def _low_hops(self, phase: PlatesPhase) -> set[int]:
        """The contacts that an impact has just opened, whose hops rise no higher than positions' rounding: the other
        contacts' forces may drive plates together that their loads do not.

        Where impacts follow each other ever faster without a fixed ratio, all of their contacts: which of them open is
        a question of forces then. Raises MotionEnds if one of these opens faster."""
        if not self.hops.strikes or self.hops.strikes[-1].time != self.t:
            return set()
        velocity, extent = np.array(self.state[self.half :]), size(self.case, self.state)
        acceleration = np.array(phase.system.rates_of_numbers(0.0, self.state, phase.parameters)[self.half :])
        slow = ACCUMULATES * self.speed
        recent = self.hops.recent(self.t) if self.hops.strikes[-1].closing < slow else frozenset[str]()
        low = set[int]()
        for number in set(self.modes) - self.touching:
            at, name = place(self.case, number, self.state), self.contacts[number].name
            lift, pull = float(at.lift_row @ velocity), -float(at.lift_row @ acceleration + at.lift_bias)
            if at.gap > TOUCHES * extent:
                continue
            if (lift > 0.0 and self._is_unresolved(lift, pull)) or (name in recent and abs(lift) <= slow):
                low.add(number)
            elif name in recent:
                self._end_accumulation(name)
        return low

    def _end_accumulation(self, name: str) -> None:
        """Raises MotionEnds: no end of impacts is known."""
        raise MotionEnds(
            (
                "accumulation",
                f"Impacts at {', '.join(sorted(self.hops.strikes[-1].contacts))} follow each other ever faster at t = "
                f"{self.t:.9g} s, without a fixed ratio, and {name} opens: their end is not computed.",
            )
        )

    def _advance(self, segment: Segment) -> None:
        self._count(segment)
        self.t, self.state = segment.event.time, tuple(segment.event.state)
        self.speed = max(self.speed, speed(self.case, self.state))

    def _wait_for_sharper(self, phase: PlatesPhase, number: int) -> None:
        """Go on to a contact that closes within the time by which rounding of its gap may move the closing of `number`.

        A gap that closes slowly has no sharper time: where its rate vanishes as another contact closes, both close at
        once, and the faster one gives the instant."""
        velocity, rounding = np.array(self.state[self.half :]), REBOUND_ROUNDINGS * EPS * size(self.case, self.state)
        accelerations = np.array(phase.system.rates_of_numbers(0.0, self.state, phase.parameters)[self.half :])
        closer = place(self.case, number, self.state)
        slow, bend = -float(closer.lift_row @ velocity), float(closer.lift_row @ accelerations) + closer.lift_bias
        doubt = doubt_of_closing(rounding, max(slow, 0.0), bend, frequency(phase, self.t, self.state))
        waits = list[float]()
        for other in set(self.modes) - self.touching - {number}:
            at = place(self.case, other, self.state)
            closing = -float(at.lift_row @ velocity)
            if at.gap > rounding and closing > max(slow, 0.0) and at.gap <= doubt * closing:
                waits.append(at.gap / closing)
        if not waits or not self.t + min(waits) < self.case.duration:
            return
        wait, position = min(waits), np.array(self.state[: self.half])
        position += wait * (velocity + 0.5 * wait * accelerations)
        state = (*position.tolist(), *(velocity + wait * accelerations).tolist())
        end = self.t + wait
        states = StraightStates(self.t, end, self.state, state)
        self._advance(Segment.of(phase, np.array([self.t, end]), states, Event(None, end, state), 0))

    # --- states without roundings, and impacts ------------------------------------------------------------------------

    def _settle(self, stuck: set[int], closing: set[int] | None = None) -> None:
        """Remove errors of the integration: no gap at contacts that touch, and no velocity where there is none.

        `closing`: contacts that may have closed with a velocity, which is an impact, as may others without a gap; the
        velocities of those that touched before are no part of it. None: no contact has closed."""
        stuck, closed = set(stuck), self.touching - (closing or set())
        if closing is not None:
            least = TOUCHES * size(self.case, self.state)
            self.touching |= closing | {n for n in self.modes if place(self.case, n, self.state).gap <= least}
        self.state = project(self.case, self.state, sorted(self.touching))
        self.speed = max(self.speed, speed(self.case, self.state))
        if closing is not None:
            self.state = without_velocity(self.case, self.state, sorted(closed), sorted(stuck & closed))
            stuck = self._impacts(stuck)
        self.state = without_velocity(self.case, self.state, sorted(self.touching), sorted(stuck & self.touching))
        self._still()

    def _still(self) -> None:
        """Take roundings of a velocity from plates that touch: decisions would see a motion in them."""
        velocity, lengths = np.array(self.state[self.half :]), numbers_of(self.case).lengths
        for body in plates_in(self.case, sorted(self.touching)):
            own = slice(3 * body, 3 * body + 3)
            if np.abs(velocity[own] * lengths[own]).max() <= SOME_ROUNDINGS * EPS * self.speed:
                velocity[own] = 0.0
        self.state = (*self.state[: self.half], *velocity.tolist())

    def _impacts(self, stuck: set[int]) -> set[int]:
        """Apply the impacts of all groups with a contact that closes; returns the contacts that do not slip, and leaves
        those that open out of `touching`."""
        staying, sticking = set[int](), set[int]()
        strikes: list[tuple[list[int], list[int], float]] = []
        for group in groups(self.case, sorted(self.touching)):
            velocity = np.array(self.state[self.half :])
            now = dict(zip(group, places(self.case, group, self.state), strict=True))
            lifts = {n: float(at.lift_row @ velocity) for n, at in now.items()}
            closing = [n for n in group if lifts[n] < -CLOSES * self.speed]
            near = [n for n in group if lifts[n] <= CLOSES * self.speed]
            if not closing:
                staying |= set(near)
                still = 1e-11 * self.speed
                sticking |= {n for n in near if n in stuck or abs(float(now[n].slip_row @ velocity)) <= still}
                continue
            for part in groups(self.case, near):  # contacts that part already share no impulses
                part_closing = [n for n in part if n in closing]
                if not part_closing:
                    staying |= set(part)
                    sticking |= {n for n in part if n in stuck}
                    continue
                stays, sticks = self._strike(part, now, part_closing)
                staying, sticking = staying | stays, sticking | sticks
                strikes.append((part, part_closing, max(-lifts[n] for n in part_closing)))
        self.touching = staying
        if strikes:
            names = frozenset(self.contacts[n].name for part, _, _ in strikes for n in part)
            closers = frozenset(self.contacts[n].name for _, closing, _ in strikes for n in closing)
            self.hops.strike(Strike(self.t, self.state, max(fastest for *_, fastest in strikes), names, closers))
        return sticking

    def _strike(
        self, part: list[int], now: dict[int, PlateContactPlace], closing: list[int]
    ) -> tuple[set[int], set[int]]:
        """The impact of one group: the contacts that stay closed, and those that do not slip."""
        self._check_count(part)
        law, numbers = self.case.effect(Impact), numbers_of(self.case)
        assert law is not None
        before = np.array(self.state[self.half :])
        try:
            outcome = impact_of_all(
                law.law, Inertia(numbers.inverse, numbers.lengths), before, [now[n] for n in part], self.speed
            )
        except NoImpact as problem:
            raise MotionEnds(("not_unique", f"At t = {self.t:.9g} s {problem}.")) from problem
        mass = np.divide(1.0, numbers.inverse, out=np.zeros(self.half), where=numbers.inverse > 0.0)
        if law.law == "newton" and mass @ outcome.velocity**2 > (1.0 + 1e-12) * (mass @ before**2):
            raise MotionEnds(ENERGY)
        self.state = (*self.state[: self.half], *outcome.velocity.tolist())
        stays, sticks = set[int](), set[int]()
        for i, number in enumerate(part):
            lift = float(outcome.lift[i])
            if number in closing:
                self.causes[number] = CAUSES["landing"]
            load = max(-float(now[number].lift_row @ numbers_of(self.case).load), 0.0)
            if lift > 0.0 and not self._is_unresolved(lift, load):
                continue
            if lift > 0.0:
                self.causes[number] = CAUSES["rest"]
            stays.add(number)
            if outcome.slip[i] == 0.0:
                sticks.add(number)
        return stays, sticks

    def _is_unresolved(self, lift: float, pull: float) -> bool:
        """Whether a rebound with that speed (m/s), pulled back by that acceleration (m/s²), rises no higher than
        positions' rounding."""
        return lift * lift <= 2.0 * pull * REBOUND_ROUNDINGS * EPS * size(self.case, self.state)

    def _end_bouncing(self) -> None:
        """Go to the instant at which impacts that accumulate end, if they do: plates move by less than rounding until
        then, and all contacts of the last impacts touch."""
        small = SMALL_HOP * size(self.case, self.state)
        end = self.hops.limit(self.t, small)
        if end is None and CAUSES["rest"] in self.causes.values():
            end = self.hops.lowest(frozenset(self.contacts[n].name for n in self.touching))
        if end is None or not end.time < self.case.duration:
            return
        limit, values = end.time, end.body
        hit = [n for n, contact in enumerate(self.contacts) if contact.name in end.contacts]
        near, moving = sorted({*hit, *self.touching}), np.array(values[self.half :])
        others = [(n, place(self.case, n, values)) for n in range(len(self.contacts)) if n not in near]
        closings = [(n, at.gap, float(at.lift_row @ moving)) for n, at in others]
        landing = end.landing(closings, TOUCHES * size(self.case, self.state))
        if landing is None:
            return
        state = project(self.case, tuple(values), near)
        velocity = np.array(state[self.half :])
        stuck = [n for n in near if self._slips_less(n, state, end.error)]
        still = {c for b in plates_in(self.case, near) for c in range(3 * b, 3 * b + 3)}
        lengths = numbers_of(self.case).lengths
        if all(abs(velocity[c]) * lengths[c] <= end.error for c in still):
            velocity[sorted(still)] = 0.0
        state = without_velocity(self.case, (*state[: self.half], *velocity.tolist()), near, stuck)
        if limit > self.t:
            self._advance(self._straight(near, limit, state))
        if end.ends_cascade:
            self.hops.end_cascade()
        self.state, self.touching = state, set(near)
        self.causes = {number: CAUSES["rest"] for number in hit if number in near}
        if landing:
            self.hops.record(self.t, [], CAUSES["rest"])
            self.causes = {}
            self._settle(set(stuck), closing=landing)

    def _slips_less(self, number: int, state: tuple[float, ...], remains: float) -> bool:
        at = place(self.case, number, state)
        return at.stick > 0.0 and abs(float(at.slip_row @ np.array(state[self.half :]))) <= remains

    def _straight(self, near: list[int], limit: float, state: tuple[float, ...]) -> Segment:
        """The segment between the last impact that is simulated and the end of all of them."""
        modes = tuple(Mode.SLIDE if n in near else mode for n, mode in self.modes.items())
        bodies = frozenset(range(self.half // 3))
        phase: PlatesPhase = plates_phase(
            self.case, PlatesRegime(tuple(self.modes), modes, bodies, regions=self._regions(self.modes, state))
        )
        states = StraightStates(self.t, limit, self.state, state)
        return Segment.of(phase, np.array([self.t, limit]), states, Event(None, limit, state), 0)


def simulate(
    case: Case, rtol: float, integrate: Callable[..., Segment]
) -> tuple[list[Segment], list[Transition], Ending]:
    """The motion of several plates: (segments, transitions, (status, sentence))."""
    simulation = PlatesSimulation(case, rtol, integrate)
    ending = simulation.simulate_phases()
    return simulation.segments, simulation.transitions, ending
