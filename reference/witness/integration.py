"""Integration of one phase to its first event: guards at places of each step, and contacts at other places."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from math import inf, isinf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from cases import Case, Curve, DoesNotFit
from cases.curves.corner import Corner
from cases.curves.line_or_circle import as_circle, as_line
from cases.scene.contact_pairs import PairCase, pairs
from cases.scene.couples import curve_ends
from cases.scene.free_plates import plates_of
from cases.scene.piece_case import PieceCase, pieces_at

from .advancement import TooManyRounds
from .chain_touches import ChainTouches
from .complementarity import MOVES
from .contacts import PairState, is_constant_at, is_watched_always, on_whole_curves, pair_at
from .dips import Dips
from .end_touches import SAME, EndTouches, first_end
from .phase import CURVE_ENDS, OWN, SeveralContactPhase
from .plate_motion import Motion
from .plate_state import EPS, TOUCHES, PlateState, SimulationEnd
from .small_impacts import ImpactsOnTwoLevels
from .steps import FrequencyLimitedDOP853, WorkBudget
from .touches import Touches
from .watched_pairs import is_by_pieces, piece_end

# Guards are evaluated at this many places of each step; steps are at most this part of the plate's turn.
LOOKS, STEPS_PER_TURN = 4, 30
# Zeros of the dense output are off by less than this part of the step.
POLISH = 1e-3
# Guards that are zero when a phase begins, or negative by rounding, count from where they have risen above this part of
# their scale; slips above some roundings of the speeds whose difference they are.
RISEN, NO_SLIP = 1e-11, 64 * EPS
MOST_STEPS = 200_000
# An open contact whose clearance has fallen to this part of its value is not watched any more.
FORGOTTEN = 0.5
# The guard of a slip that has just begun is ignored for this part of the motion's time scale: an instant located to
# rounding may still lie inside the cone, where the slip would first go back by far less than the resolution.
BLIND = 1e-6
# Steps vanish at Painlevé's number p = 0 when it is about the root of a step over the motion's time, 1e-7, where
# friction grows as the slip falls; this part of its first value shows that p is what vanishes.
JAMMED = 1e-2
# A plate whose pace is below this part of that of its load is at rest.
AT_REST = 1e-5
# Points of an open contact that move this many times as far as their rate between two looks allows have jumped.
JUMP = 4.0
# Roundings of a velocity of lift, which is a sum of some products.
NOISE = 4.0


States = Callable[[Any], np.ndarray]
# The kind of a guard, and its contact.
Guard = tuple[str, str]


class DenseStep(NamedTuple):
    """A step's dense output: times from `start` to `end`, s."""

    start: float
    end: float
    states: States


class PhaseIntegration(PlateState):
    """A plate that is integrated phase by phase."""

    def __init__(self, case: Case, t: float, body: Sequence[float] | np.ndarray, rtol: float):
        super().__init__(case, t, body)
        self.rtol, self.steps = max(rtol, 1e-13), 0
        self.impacts = ImpactsOnTwoLevels()
        self.clearances: dict[str, float] = {}
        self.beginning: set[str] = set()
        self.searches: list[Touches | ChainTouches] = []
        if is_by_pieces(self.case):
            self.searches = [ChainTouches(self.case, self.case.start.xi1)]
        elif not case.others:
            searched = [pair for pair in pairs(self.case) if not is_watched_always(pair)]
            self.searches = [Touches(pair, self.case.start.xi1) for pair in searched]
        self.ends = [EndTouches(end) for end in curve_ends(self.case)]
        self.earlier: DenseStep | None = None
        self.work = WorkBudget()

    def pace(self, phase: SeveralContactPhase, t: float, y: np.ndarray) -> float:
        """How fast forces and gaps change, or begin to, 1/s. From rest a slip may begin without acceleration: speed and
        acceleration are all rounding then, and the load gives the pace that the plate may reach."""
        plates, now = plates_of(self.case), phase.pairs(t, y)
        lengths = np.array([part for p in plates for part in (p.gyration, p.gyration, 1.0)])
        speeds = np.abs(y[self.half : 2 * self.half]) / lengths
        is_alone = not self.case.others and not any(self.dynamics.loads)
        if is_alone:  # the place of one plate counts where a curve bends
            speeds[:2] = 0.0
        if is_alone and self.case.plate.radius is not None:  # how a disc turns matters where contacts are open
            speeds[2] *= 0.0 if all(c.is_closed for c in phase.contacts) else 1.0 / LOOKS
        along = [abs(p.xi1_rate) * float(p.contact.track.speed(p.xi1)) / self.grain(p) for p in now]
        accelerations = np.abs(phase.forces(t, y, now).acceleration) / lengths
        closed = [p for c, p in zip(phase.contacts, now, strict=True) if c.is_closed]
        if closed and self.case.plate.radius is not None and is_alone:
            # A disc moves as a pendulum: of the length of the difference of radii on a circle.
            length = min(min(self.grain(p), _pendulum(p)) for p in closed)
            accelerations = accelerations[:2] * lengths[:2] / length
        load = self.dynamics.inverse * self.dynamics.torsor(t, phase.plates(y)) / lengths
        pace = max(float(speeds.max()), *along, sqrt(float(accelerations.max())))
        most = sqrt(float(np.abs(load).max()))
        # The forces on a disc on endless lines are the same everywhere.
        is_even = self.dynamics.is_constant and all(p.radius is not None for p in plates)
        is_even = is_even and all(c.is_closed for c in phase.contacts)
        if is_even and all(isinf(self.grain(pair)) and is_constant_at(pair.contact) for pair in now):
            return 0.0
        return most if pace < AT_REST * most and not phase.frozen else pace

    def absolute(self, phase: SeveralContactPhase, pace: float) -> np.ndarray:
        """The absolute tolerances of a phase's state: of places by a tenth of the plates' reach, of velocities by a
        tenth of the speed that they have or reach over that length, so that roundings of a component that stays zero
        shorten no step; of gaps by the lowest hop, but for the roundings of speeds. What roundings of accelerations
        move a place by in a step of the longest length is no error of the step."""
        reach, longest = self.case.plate.reach, self.case.duration / STEPS_PER_TURN
        # A load that has just lifted a plate balances its weight now, and does not a little later.
        torsors = [self.dynamics.torsor(t, self.body) for t in (self.t, self.t + longest)]
        load = float(np.abs(self.dynamics.inverse * self.dynamics.units * torsors).max())
        speed = max(self.speed, sqrt(load * reach)) or 1.0
        lengths = 1.0 / np.where(self.dynamics.units == 1.0, 1.0, self.dynamics.units)
        longest = min(longest, 2.0 * pi / pace / STEPS_PER_TURN) if pace else longest
        moved = NOISE * EPS / self.rtol * (load + speed * speed / reach) * longest**2
        sizes = [max(0.1 * reach, moved) * lengths, 0.1 * speed * lengths]
        least, hops = NOISE * EPS / self.rtol * speed, self.hops(phase).values()
        lowest = min((lift / pull * max(lift, least) for lift, pull in hops), default=1.0)
        for contact in phase.contacts:
            hop = [0.1, 0.1, lowest] if contact.name in phase.hopping else []
            sizes.append(np.array([0.1, 0.1] if contact.is_closed else hop))
        return self.rtol * np.concatenate(sizes)

    def grain(self, pair: PairState) -> float:
        """The length (m) along a contact's track over which forces on the plate change: the radius of a line or a
        circle, on another curve at most the plate's reach."""
        track, reach = pair.contact.track, self.case.plate.reach
        if isinstance(track, Corner):
            return reach
        bend, is_even = abs(float(track.curvature(pair.xi1))), as_line(track) or as_circle(track)
        return min(1.0 / bend if bend and as_line(track) is None else inf, inf if is_even else reach)

    def integrate(self, phase: SeveralContactPhase) -> list[tuple[str, str]]:
        """Integrate to the first zero of a guard; returns the guards that vanish there, none at the end."""
        end = self.case.duration
        scales = self.scales(phase)
        values = phase.guards(self.t, self.body)
        risen = {kind: (NO_SLIP if kind == "slip" else RISEN) * scale for kind, scale in scales.items()}
        # The end of an element may come near during the phase: its guard is watched once it has been positive.
        positive = defaultdict(bool, {name: value > risen[name[0]] for name, value in values.items()})
        for contact, pair in zip(phase.contacts, phase.pairs(self.t, self.body), strict=True):
            # The contact may be low in a hop where the phase begins.
            falls = not contact.is_closed and pair.gap > 0.0 and pair.lift < -MOVES * self.speed
            if falls and ("gap", contact.name) in positive:
                positive["gap", contact.name] = True
        tops = self.tops(phase)
        phase.hopping = {name for _, name in tops}
        pace = self.pace(phase, self.t, phase.whole_state(self.body))
        blind = self.t + (BLIND / pace if pace else 0.0)
        solver = FrequencyLimitedDOP853(
            phase.rates, self.t, phase.whole_state(self.body), end, pace=partial(self.pace, phase),
            steps_per_turn=STEPS_PER_TURN, work=self.work, load_allows=phase.allows, features=phase.features(),
            curves=phase.curves(), rtol=self.rtol, atol=self.absolute(phase, pace),
            first_step=self.first_step(tops.values()),
        )  # fmt: skip
        dips = Dips(blind)
        while solver.status == "running":
            solver.step()
            self.steps += 1
            self.speed = max(self.speed, self.surface_speed(solver.t))
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                last = phase.forces(solver.t, solver.y).inverse_mass
                first = phase.forces(self.t, self.body).inverse_mass
                self.go_to(phase, solver.t, solver.y)
                if not self.work.used_up and last <= JAMMED * first:
                    raise SimulationEnd("paradox")
                raise SimulationEnd("unfinished" if self.work.used_up else "breakdown")
            if self.steps > MOST_STEPS:
                raise SimulationEnd("unfinished")
            dense = solver.dense_output()
            pairs_at = lru_cache(maxsize=None)(lambda t, dense=dense: phase.pairs(t, dense(t)))
            guards_at = lru_cache(maxsize=None)(lambda t, dense=dense, at=pairs_at: phase.guards(t, dense(t), at(t)))
            looks = np.linspace(solver.t_old, solver.t, LOOKS + 1)[1:]
            if not any(positive.values()) or solver.t_old == self.t:
                looks = np.union1d(looks, solver.t_old + (solver.t - solver.t_old) * np.geomspace(1e-8, 0.2, 24))
            hops = [t for top in tops.values() for t in (top, 3.0 * top - 2.0 * self.t)]
            looks = np.union1d(looks, [t for t in hops if solver.t_old < t < solver.t])
            before = solver.t_old
            for look in looks.tolist():
                if look > before and self.is_lost(phase, before, look, pairs_at):
                    # At the last look the points were still the nearest ones.
                    if before > solver.t_old and self.meets(phase, solver, before, dense):
                        return [("meeting", "")]
                    self.t, self.body = before, phase.plates(solver.exactly(before))
                    return [("forget", "")]
                values = self.watched(guards_at(look), look, blind)
                watched = {name: value for name, value in values.items() if positive[name]}
                near = phase.near  # Newton's method goes on from this look
                dip = dips.first(lambda name, t, at=guards_at: at(t).get(name, inf), before, look, watched)  # type: ignore[misc]
                phase.near = near
                if dip is not None:
                    look, values = dip, self.watched(guards_at(dip), dip, blind)
                zeros = [
                    name for name, value in values.items()
                    if value <= (0.0 if positive[name] else -100.0 * RISEN * scales[name[0]])
                ]  # fmt: skip
                if zeros:
                    return self.locate(phase, solver, guards_at, (before, look), zeros, positive)
                for name, value in values.items():
                    positive[name] |= value > (0.0 if name in tops else risen[name[0]])
                before = look
            if self.meets(phase, solver, solver.t, dense):
                return [("meeting", "")]
            self.earlier = DenseStep(solver.t_old, solver.t, dense)
        self.go_to(phase, solver.t, solver.y)
        raise SimulationEnd("completed")

    def go_to(self, phase: SeveralContactPhase, t: float, y: np.ndarray) -> None:
        """The state at a time (s) of a phase."""
        phase.pairs(t, y)
        self.t, self.body = t, phase.plates(y)
        self.contacts = [c._replace(pair=near) for c, near in zip(phase.contacts, phase.near, strict=True)]

    def watched(self, guards: dict[Guard, float], t: float, blind: float) -> dict[Guard, float]:
        """Guards at a time, until `blind` without those of slips that have just begun."""
        begin = self.beginning if t <= blind else set[str]()
        return {name: v for name, v in guards.items() if name[0] not in ("slip", "rotation") or name[1] not in begin}

    def hops(self, phase: SeveralContactPhase) -> dict[str, tuple[float, float]]:
        """Of contacts that open with a velocity, and are going to close again: that velocity (m/s), and the
        acceleration with which it falls (m/s²)."""
        hops, acceleration = {}, phase.forces(self.t, self.body).acceleration
        for contact, pair in zip(phase.contacts, phase.pairs(self.t, self.body), strict=True):
            pull = -float(pair.lift_row @ acceleration + pair.lift_bias)
            may_hop = not contact.is_closed and not contact.is_away
            if may_hop and pull > 0.0 and pair.lift > MOVES * self.speed and pair.gap <= TOUCHES * self.size():
                hops[contact.name] = pair.lift, pull
        return hops

    def tops(self, phase: SeveralContactPhase) -> dict[tuple[str, str], float]:
        """When contacts that open with a velocity are farthest from their supports, s: the gap of a small hop is
        resolved there, or nowhere."""
        return {("gap", name): self.t + lift / pull for name, (lift, pull) in self.hops(phase).items()}

    def is_tiny(self, lift: float, pull: float) -> bool:
        """Whether a rebound with that speed (m/s), pulled back by that acceleration (m/s²), is lower than rounding."""
        return lift * lift <= 8.0 * pull * EPS * self.size()

    def first_step(self, tops: Iterable[float]) -> float | None:
        """A first step about as long as the shortest hop: dense output of a longer one shows less of its small gap."""
        hop = 3.0 * (min(tops, default=inf) - self.t)
        return min(hop, self.case.duration - self.t) if 0.0 < hop < inf else None

    def is_lost(self, phase: SeveralContactPhase, before: float, look: float, pairs_at) -> bool:
        """Whether an open contact's points are no longer surely the nearest ones: the clearance has fallen, they have
        moved farther between two looks than their rate allows, or there are none any more."""
        if all(contact.is_closed or is_watched_always(contact.case) for contact in phase.contacts):
            return False
        earlier = pairs_at(before)
        try:
            now = pairs_at(look)
        except DoesNotFit:
            return True
        for contact, was, pair in zip(phase.contacts, earlier, now, strict=True):
            if contact.is_closed or is_watched_always(contact.case):
                continue
            ends = contact.case.track.ends
            if ends and not ends[0] <= pair.xi1 <= ends[1]:
                return True
            if isinstance(contact.case, PieceCase) and piece_end(contact.case, (pair.xi1, pair.xi2)).distance <= 0.0:
                return True
            farthest = JUMP * max(abs(was.xi1_rate), abs(pair.xi1_rate)) * (look - before) + JUMP * EPS
            jumps = abs(pair.xi1 - was.xi1) > farthest + JUMP * EPS * abs(pair.xi1)
            if jumps or pair.clearance < FORGOTTEN * self.clearances[contact.name]:
                return True
        return False

    def locate(self, phase, solver, guards_at, times: tuple[float, float], zeros, positive) -> list[Guard]:
        """The earliest zero between two looks in a step."""
        roots, (before, look) = {}, times
        for name in zeros:

            def value(t: float, name=name) -> float:
                return guards_at(t)[name]

            falls = positive[name] and value(before) > 0.0
            roots[name] = float(brentq(value, before, look, xtol=1e-15, rtol=8.9e-16)) if falls else before
        first = min(roots, key=roots.__getitem__)
        dense = solver.dense_output()
        if self.meets(phase, solver, roots[first], dense):
            return [("meeting", "")]
        time = roots[first]
        if time > before:
            time = self.polish(solver, dense, time, lambda t, y: phase.guards(t, y)[first])
        self.t, self.body = time, phase.plates(solver.exactly(time))
        return [name for name, root in roots.items() if root - roots[first] <= 1e-11 * max(1.0, time)]

    def polish(self, solver, dense: States, time: float, value: Callable[[float, np.ndarray], float]) -> float:
        """A zero (s) of a falling quantity of the dense output, in the step itself, by Newton's method."""
        earlier = time - POLISH * (solver.t - solver.t_old)
        rate = (value(time, dense(time)) - value(earlier, dense(earlier))) / (time - earlier)
        for _ in range(2):
            change = -value(time, solver.exactly(time)) / rate if rate < 0.0 else 0.0
            if abs(change) < POLISH * (solver.t - solver.t_old):  # otherwise it does not fall
                time = min(max(time + change, solver.t_old), solver.t)
        return float(time)

    def scales(self, phase: SeveralContactPhase) -> dict[str, float]:
        """The sizes of the guards of each kind."""
        force = max(  # a load may cancel with the weight
            float(np.abs(self.dynamics.weight).max()),
            float(np.abs(self.dynamics.torsor(self.t, self.body) / self.dynamics.units).max()),
            float(np.abs(phase.forces(self.t, self.body).normal).max(initial=0.0)),
        )
        speed = max(self.speed, float(np.abs(self.body[self.half :]).max()), 1e-300)
        by_force = dict.fromkeys(("normal", "side", "cone+", "cone-", "couple+", "couple-"), force)
        by_place = dict.fromkeys(("turn", "held", *CURVE_ENDS), 1.0)
        by_place |= {kind: 1.0 for kind, _ in phase.guards(self.t, self.body) if kind.startswith(OWN)}
        return {"gap": 1e-2 * self.size(), "slip": speed, "rotation": speed} | by_place | by_force

    # --- contacts at other places -------------------------------------------------------------------------------------

    def meets(self, phase: SeveralContactPhase, solver, end: float, dense: States) -> bool:
        """Whether the plate touches a curve in a step, until a time (s), at a place that is not watched; if so, the
        motion goes on from there, and the contact is added."""
        start = solver.t_old
        steps = [DenseStep(start, end, dense)]
        if self.earlier is not None and self.earlier.end == start:
            steps.insert(0, self.earlier)
        motion, touches = Motion(partial(_bodies, steps), np.array([*(one.start for one in steps), end])), list[Any]()
        for search in self.searches if end > start else []:
            mine = [k for k, c in enumerate(phase.contacts) if search.case in (c.case, getattr(c.case, "whole", None))]
            places = partial(_places, phase, dense, mine)
            try:
                touch = search.first(motion, (start, end), places, any(phase.contacts[k].is_closed for k in mine))
            except TooManyRounds:
                raise SimulationEnd("unfinished") from None
            if touch is not None:
                touches.append((touch.time, len(touches), touch, search.case))
        until = min([end, *(one[0] for one in touches)])
        new = [(one[3].track, one[2].xi1) for one in touches if one[0] == until]
        places_at = partial(_curve_places, phase, dense, new)
        meeting = first_end(self.ends, motion, (start, until), places_at) if self.ends and until > start else None
        if meeting is not None:
            time, touch_of_end = meeting
            time = self.polish(solver, dense, time, touch_of_end.gap_in(phase.plates)) if time > start else start
            self.go_to(phase, time, solver.exactly(time) if time > start else dense(time))
            raise SimulationEnd("track_end")
        if not touches:
            return False
        time, _, touch, case = min(touches)
        points = touch.xi1, touch.xi2
        if not isinstance(case, PairCase) and not np.isnan(touch.xi1):
            case = pieces_at(case, touch.xi1, touch.xi2)
            points = touch.xi1 - case.first.shift, touch.xi2 - case.second.shift
        if time > start and not np.isnan(touch.xi1):
            time = self.polish(solver, dense, time, lambda t, y: pair_at(case, phase.plates(y), points).gap)
        body = solver.exactly(time) if time > start else dense(time)
        self.t, self.body, self.contacts = time, phase.plates(body), list(phase.contacts)
        if np.isnan(touch.xi1):
            raise SimulationEnd("landing")
        if not self.is_several and not any(contact.is_closed for contact in self.contacts):
            self.contacts = [contact for contact in self.contacts if is_watched_always(contact.case)]
        self.add(case, points)
        return True


def _pendulum(pair: PairState) -> float:
    """The length (m) of a pendulum that moves as a disc on its track, from the curvatures at a contact."""
    bend = float(pair.contact.track.curvature(pair.xi1))
    return abs(1.0 / bend - 1.0 / float(pair.contact.plate.outline.curvature(pair.xi2))) if bend else inf


def _bodies(steps: Sequence[DenseStep], times: np.ndarray) -> np.ndarray:
    """(x, y, θ, vx, vy, ω) at times (n,) in one step or two, shape (6, n)."""
    if len(steps) == 1:
        return steps[0].states(times)[:6]
    return np.where(times < steps[1].start, steps[0].states(times)[:6], steps[1].states(times)[:6])


def _places(phase: SeveralContactPhase, dense: States, some: Sequence[int], times: np.ndarray) -> np.ndarray:
    """The parameters of some contacts at times (n,) of a step, shape (contacts, 2, n)."""
    near, result = phase.near, np.empty((len(some), 2, len(times)))
    for i in range(len(times) - 1, -1, -1) if some else ():
        phase.pairs(float(times[i]), dense(float(times[i])))
        result[:, :, i] = [phase.near[k] for k in some]
    phase.near = near
    return result


def _curve_places(
    phase: SeveralContactPhase, dense: States, new: Sequence[tuple[Curve, float]], t: float
) -> list[tuple[Curve, float]]:
    """The curves of the contacts that touch at a time of a step, with their parameters there, and of `new` ones."""
    near, now = phase.near, phase.pairs(t, dense(t))
    phase.near = near
    some = [(c.case, p) for c, p in zip(phase.contacts, now, strict=True) if p.gap <= SAME * c.case.plate.reach]
    places = [(case, on_whole_curves(case, (p.xi1, p.xi2))[0]) for case, p in some]
    return [*((case.whole.track if isinstance(case, PieceCase) else case.track, xi1) for case, xi1 in places), *new]
