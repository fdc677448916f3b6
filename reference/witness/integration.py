"""Integration of one phase to its first event: guards at places of each step, and contacts at other places."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from cases import Case, DoesNotFit
from cases.scene.contact_pairs import pairs
from cases.scene.free_plates import plates_of

from .advancement import TooManyRounds
from .complementarity import MOVES
from .contacts import AnyPair, is_watched_always, pair_at
from .dips import Dips
from .phase import CURVE_ENDS, SIGN, SeveralContactPhase
from .plate_motion import Motion
from .plate_state import TOUCHES, PlateState, SimulationEnd
from .small_impacts import ImpactsOnTwoLevels
from .steps import FrequencyLimitedDOP853, WorkBudget
from .touches import Touches

EPS = float(np.finfo(float).eps)
# Guards are evaluated at this many places of each step; steps are at most this part of the plate's turn.
LOOKS, STEPS_PER_TURN = 4, 60
# Guards that are zero when a phase begins, or negative by rounding, count from where they have risen above this part of
# their scale.
RISEN = 1e-11
MOST_STEPS = 200_000
# A hop is short if it takes less than this part of the motion: other steps are the integrator's own.
SHORT = 1e-2
# An open contact whose clearance has fallen to this part of its value is not watched any more.
FORGOTTEN = 0.5
# The guard of a slip that has just begun is ignored for this part of the motion's time scale: an instant located to
# rounding may still lie inside the cone, where the slip would first go back by far less than the resolution.
BLIND = 1e-6
# A plate whose pace is below this part of that of its load is at rest.
AT_REST = 1e-5
# Points of an open contact that move this many times as far as their rate between two looks allows have jumped.
JUMP = 4.0


States = Callable[[Any], np.ndarray]


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
        searched = [] if case.others else [pair for pair in pairs(self.case) if not is_watched_always(pair)]
        self.searches = [Touches(pair, self.case.start.xi1) for pair in searched]
        self.earlier: DenseStep | None = None

    def pace(self, phase: SeveralContactPhase) -> float:
        """How fast the plate moves or begins to, 1/s. From rest a slip may begin without acceleration: speed and
        acceleration are all rounding then, and the load gives the pace that the plate may reach."""
        lengths = np.array([part for p in plates_of(self.case) for part in (p.gyration, p.gyration, 1.0)])
        speeds = np.abs(self.body[self.half :]) / lengths
        accelerations = np.abs(phase.forces(self.t, self.body).acceleration) / lengths
        load = self.dynamics.inverse * self.dynamics.torsor(self.t, self.body) / lengths
        pace, most = max(float(speeds.max()), sqrt(float(accelerations.max()))), sqrt(float(np.abs(load).max()))
        return most if pace < AT_REST * most and not phase.resting else pace

    def integrate(self, phase: SeveralContactPhase) -> list[tuple[str, str]]:
        """Integrate to the first zero of a guard; returns the guards that vanish there, none at the end."""
        end = self.case.duration
        scales = self.scales(phase)
        values = phase.guards(self.t, self.body)
        positive = {name: value > RISEN * scales[name[0]] for name, value in values.items()}
        for contact, pair in zip(phase.contacts, phase.pairs(self.t, self.body), strict=True):
            # The contact may be low in a hop where the phase begins.
            falls = not contact.is_closed and pair.gap > 0.0 and pair.lift < -MOVES * self.speed
            if falls and ("gap", contact.name) in positive:
                positive["gap", contact.name] = True
        pace = self.pace(phase)
        blind = self.t + (BLIND / pace if pace else 0.0)
        tops = self.tops(phase)
        solver = FrequencyLimitedDOP853(
            phase.rates, self.t, self.body, end, pace=lambda t, y: pace, steps_per_turn=STEPS_PER_TURN,
            work=WorkBudget(), load_allows=phase.slips_allow if any(c.mode in SIGN for c in phase.contacts) else None,
            rtol=self.rtol, atol=1e-2 * self.rtol, first_step=self.first_step(tops.values()),
        )  # fmt: skip
        dips = Dips(blind)
        while solver.status == "running":
            solver.step()
            self.steps += 1
            self.speed = max(self.speed, self.surface_speed(solver.t))
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                raise SimulationEnd("breakdown")
            if self.steps > MOST_STEPS:
                raise SimulationEnd("unfinished")
            dense = solver.dense_output()
            looks = np.linspace(solver.t_old, solver.t, LOOKS + 1)[1:]
            if not any(positive.values()) or solver.t_old == self.t:
                looks = np.union1d(looks, solver.t_old + (solver.t - solver.t_old) * np.geomspace(1e-8, 0.2, 24))
            hops = [t for top in tops.values() for t in (top, 3.0 * top - 2.0 * self.t)]
            looks = np.union1d(looks, [t for t in hops if solver.t_old < t < solver.t])
            before = solver.t_old
            for look in looks.tolist():
                if look > before and self.is_lost(phase, before, look, dense):
                    # At the last look the points were still the nearest ones.
                    if before > solver.t_old and self.meets(phase, solver.t_old, before, dense):
                        return [("meeting", "")]
                    self.t, self.body = before, np.array(dense(before))
                    return [("forget", "")]
                values = self.watched(phase, look, dense, blind)
                watched = {name: value for name, value in values.items() if positive[name]}

                guards_at = lru_cache(maxsize=None)(lambda t, dense=dense: phase.guards(t, dense(t)))
                near = phase.near  # Newton's method goes on from this look
                dip = dips.first(lambda name, t, at=guards_at: at(t)[name], before, look, watched)  # type: ignore[misc]
                phase.near = near
                if dip is not None:
                    look, values = dip, self.watched(phase, dip, dense, blind)
                zeros = [
                    name for name, value in values.items()
                    if value <= (0.0 if positive[name] else -100.0 * RISEN * scales[name[0]])
                ]  # fmt: skip
                if zeros:
                    return self.locate(phase, dense, (solver.t_old, before, look), zeros, positive)
                for name, value in values.items():
                    positive[name] |= value > (0.0 if look >= tops.get(name, inf) else RISEN * scales[name[0]])
                before = look
            if self.meets(phase, solver.t_old, solver.t, dense):
                return [("meeting", "")]
            self.earlier = DenseStep(solver.t_old, solver.t, dense)
        self.t, self.body = solver.t, solver.y
        raise SimulationEnd("completed")

    def watched(self, phase: SeveralContactPhase, t: float, dense, blind: float) -> dict[tuple[str, str], float]:
        """The guards at a time of a step, until `blind` without those of slips that have just begun."""
        return {
            name: value for name, value in phase.guards(t, dense(t)).items()
            if t > blind or name[0] not in ("slip", "rotation") or name[1] not in self.beginning
        }  # fmt: skip

    def hops(self, phase: SeveralContactPhase) -> dict[str, tuple[float, float]]:
        """Of contacts that open with a velocity, and are going to close again: that velocity (m/s), and the
        acceleration with which it falls (m/s²)."""
        hops, acceleration = {}, phase.forces(self.t, self.body).acceleration
        for contact, pair in zip(phase.contacts, phase.pairs(self.t, self.body), strict=True):
            pull = -float(pair.lift_row @ acceleration + pair.lift_bias)
            may_hop = not contact.is_closed and not contact.is_away
            if may_hop and pull > 0.0 and pair.lift > 0.0 and pair.gap <= TOUCHES * self.size():
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
        return min(hop, self.case.duration - self.t) if 0.0 < hop < SHORT * self.case.duration else None

    def is_lost(self, phase: SeveralContactPhase, before: float, look: float, dense) -> bool:
        """Whether an open contact's points are no longer surely the nearest ones: the clearance has fallen, they have
        moved farther between two looks than their rate allows, or there are none any more."""
        if all(contact.is_closed or is_watched_always(contact.case) for contact in phase.contacts):
            return False
        earlier = phase.pairs(before, dense(before))
        try:
            now = phase.pairs(look, dense(look))
        except DoesNotFit:
            phase.closed_pairs(look, dense(look))
            return True
        for contact, was, pair in zip(phase.contacts, earlier, now, strict=True):
            if contact.is_closed or is_watched_always(contact.case):
                continue
            farthest = JUMP * max(abs(was.xi1_rate), abs(pair.xi1_rate)) * (look - before) + JUMP * EPS
            jumps = abs(pair.xi1 - was.xi1) > farthest + JUMP * EPS * abs(pair.xi1)
            if jumps or pair.clearance < FORGOTTEN * self.clearances[contact.name]:
                return True
        return False

    def locate(self, phase, dense, times: tuple[float, float, float], zeros, positive) -> list[tuple[str, str]]:
        """The earliest zero between the last two of three times: the step's start, and two looks."""
        roots, (start, before, look) = {}, times
        for name in zeros:

            def value(t: float, name=name) -> float:
                return phase.guards(t, dense(t))[name]

            falls = positive[name] and value(before) > 0.0
            roots[name] = float(brentq(value, before, look, xtol=1e-15, rtol=8.9e-16)) if falls else before
        first = min(roots.values())
        if self.meets(phase, start, first, dense):
            return [("meeting", "")]
        self.t, self.body = first, dense(first)
        return [name for name, root in roots.items() if root - first <= 1e-11 * max(1.0, first)]

    def scales(self, phase: SeveralContactPhase) -> dict[str, float]:
        """The sizes of the guards of each kind."""
        force = max(
            float(np.abs(self.dynamics.torsor(self.t, self.body) / self.dynamics.units).max()),
            float(np.abs(phase.forces(self.t, self.body).normal).max(initial=0.0)),
        )
        speed = max(self.speed, float(np.abs(self.body[self.half :]).max()), 1e-300)
        by_force = dict.fromkeys(("normal", "cone+", "cone-", "couple+", "couple-"), force)
        by_place = dict.fromkeys(("turn", "held", *CURVE_ENDS), 1.0)
        return {"gap": 1e-2 * self.size(), "slip": speed, "rotation": speed} | by_place | by_force

    # --- contacts at other places -------------------------------------------------------------------------------------

    def meets(self, phase: SeveralContactPhase, start: float, end: float, dense: States) -> bool:
        """Whether the plate touches a curve in a step at a place that is not watched; if so, the motion goes on from
        there, and the contact is added."""
        steps = [DenseStep(start, end, dense)]
        if self.earlier is not None and self.earlier.end == start:
            steps.insert(0, self.earlier)
        motion, touches = Motion(partial(_bodies, steps), np.array([*(one.start for one in steps), end])), []
        for search in self.searches if end > start else []:
            mine = [(c.case, near, c.is_closed) for c, near in zip(phase.contacts, phase.near, strict=True)
                    if c.case == search.case]  # fmt: skip
            places = partial(_places, dense, [(case, near) for case, near, _ in mine])
            try:
                touch = search.first(motion, (start, end), places, any(is_closed for *_, is_closed in mine))
            except TooManyRounds:
                raise SimulationEnd("unfinished") from None
            if touch is not None:
                touches.append((touch.time, search.case.number, touch, search.case))
        if not touches:
            return False
        time, _, touch, case = min(touches)
        self.t, self.body, self.contacts = time, np.array(dense(time)), list(phase.contacts)
        self.add(case, (touch.xi1, touch.xi2))
        return True


def _bodies(steps: Sequence[DenseStep], times: np.ndarray) -> np.ndarray:
    """(x, y, θ, vx, vy, ω) at times (n,) in one step or two, shape (6, n)."""
    if len(steps) == 1:
        return steps[0].states(times)
    return np.where(times < steps[1].start, steps[0].states(times), steps[1].states(times))


def _places(dense: States, contacts: Sequence[tuple[AnyPair, tuple[float, float]]], times: np.ndarray) -> np.ndarray:
    """The parameters of some contacts at times (n,) of a step, shape (contacts, 2, n), from points near the last."""
    result = np.empty((len(contacts), 2, len(times)))
    for i, (case, near) in enumerate(contacts):
        for k in range(len(times) - 1, -1, -1):
            near = pair_at(case, dense(float(times[k])), near)[1:3]
            result[i, :, k] = near
    return result
