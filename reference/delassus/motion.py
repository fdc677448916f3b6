"""A motion with several contacts by the second formulation: phases, events, impacts, and contacts at other places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from cases import Case, DoesNotFit, Flight, Impact, Mode, Transition
from cases.contact import start_motion
from cases.contact_pairs import PairCase, contact_name, pairs
from cases.overlap import first_overlap
from cases.trajectory import CONTACT

from ..contact_frame.equations import ContactScene
from ..contact_frame.impact import ImpactWithoutSolution, creates_energy, hit
from .complementarity import solutions
from .contacts import PairState, PlateDynamics, all_pairs, friction_of, frictions, is_rough, pair_at
from .phase import SeveralContactPhase, WatchedContact

EPS = float(np.finfo(float).eps)
# Guards are evaluated at this many places of each step; steps are at most this part of the plate's turn.
LOOKS, STEPS_PER_TURN = 4, 60
# Guards that are zero when a phase begins, or negative by rounding, count from where they have risen above this part of
# their scale.
RISEN = 1e-11
# A contact touches if its gap is below this part of the plate's size; it closes, slips or accelerates if the speed or
# acceleration exceeds this part of the motion's.
TOUCHES, MOVES = 1e-11, 1e-10
# A slip velocity below this part of the outline's own speed is rounding.
NO_SLIP = 1e-11
# Impacts that close with less than this part of the largest closing speed are small: they are listed only if the motion
# does not come to rest by them (the definition in `cases.Transition`).
SMALL_IMPACT = 7e-4
# They are extrapolated to their end where the plate moves by less than this part of its size until then.
SMALL_HOP = 1e-10
MOST_PHASES, MOST_STEPS = 5_000, 200_000
# An open contact whose clearance has fallen to this part of its value is not watched any more.
FORGOTTEN = 0.5
# The guard of a slip that has just begun is ignored for this part of the motion's time scale: an instant located to
# rounding may still lie inside the cone, where the slip would first go back by far less than the resolution.
BLIND = 1e-6
# Points of an open contact that move this many times as far as their rate between two looks allows have jumped.
JUMP = 4.0
# The names of contacts that have not touched yet begin with this.
OPEN_NAME = "open "
# Looks at a load in time while it may end a rest.
REST_LOOKS = 200


class SeveralMotion(NamedTuple):
    """Transitions, status, end (s), and (x, y, θ, vx, vy, ω, slip) at the requested times, shape (7, n): the slip is
    that of the first closed contact. NaN after the end."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    motions: np.ndarray


class _DenseStep(NamedTuple):
    """A step's dense output with its phase: times from `start` to `end`, s."""

    start: float
    end: float
    states: Callable[[float], np.ndarray]
    phase: SeveralContactPhase


class _MotionEnd(Exception):
    """The motion ends with a status."""


class _Simulation:
    """The state of one simulation."""

    def __init__(self, case: Case, t: float, body: Sequence[float] | np.ndarray, rtol: float):
        self.case, self.dynamics, self.rtol = case, PlateDynamics(case), max(rtol, 1e-13)
        self.t, self.body = t, np.array(body, dtype=float)
        self.contacts: list[WatchedContact] = []
        self.stretches: list[_DenseStep] = []
        self.ordinary: list[Transition] = []
        self.kept_back: list[Transition] = []
        self.strikes: list[tuple[float, float]] = []
        self.speed = self.fastest = 0.0
        self.small = False
        self.guess: tuple[float, float] = (inf, inf)
        self.last_guess = inf
        self.clearances: dict[str, float] = {}
        self.steps = 0
        self.touching: set[str] = set()
        self.stuck: set[str] = set()
        self.begins: dict[str, float] = {}
        self.beginning: set[str] = set()
        self.leaving: set[str] = set()
        self.at_rest = False
        self.struck: set[str] = set()
        self.is_start = t == 0.0
        self.goes_on = False
        self.searched = [pair for pair in pairs(case) if not pair.has_unique_points]

    # --- phases -------------------------------------------------------------------------------------------------------

    def simulate(self) -> str:
        try:
            self.settle(may_strike=True)
            for _ in range(MOST_PHASES):
                self.phase(self.same_modes() if self.goes_on else self.decide())
        except _MotionEnd as end:
            return str(end)
        except (DoesNotFit, np.linalg.LinAlgError):
            return "breakdown"
        return "unfinished"

    def same_modes(self) -> SeveralContactPhase:
        """The phase that continues after an open contact is no longer watched."""
        self.goes_on = False
        return SeveralContactPhase(self.dynamics, self.contacts)

    def pairs(self) -> list[PairState]:
        now = [pair_at(contact.case, self.body, contact.pair) for contact in self.contacts]
        self.contacts = [c._replace(pair=(p.xi1, p.xi2)) for c, p in zip(self.contacts, now, strict=True)]
        return now

    def size(self) -> float:
        return float(abs(self.body[0]) + abs(self.body[1]) + self.case.plate.reach)

    def decide(self) -> SeveralContactPhase:
        """The modes that follow, from the complementarity of forces and accelerations at the touched contacts."""
        now = self.pairs()
        closed = [k for k, c in enumerate(self.contacts) if c.name in self.touching - self.leaving]
        modes = self.modes(now, closed)
        if modes is None and self.leaving:
            closed = [k for k, c in enumerate(self.contacts) if c.name in self.touching]
            modes = self.modes(now, closed)
        if modes is None:
            raise _MotionEnd("paradox")
        rank = np.linalg.matrix_rank(
            np.array([now[k].lift_row for k in modes] + [now[k].slip_row for k, m in modes.items() if m is Mode.ROLL])
            / self.dynamics.units,
            tol=1e-9,
        ) if modes else 0  # fmt: skip
        rests = rank == 3 and not self.body[3:].any()
        changes = []
        for k, contact in enumerate(self.contacts):
            mode = modes.get(k, Mode.FLIGHT)
            if mode is not contact.mode or (mode is Mode.FLIGHT and contact.name in self.struck):
                xi1, xi2 = contact.pair
                changes.append(
                    Transition(
                        self.t, contact.mode, mode, xi1, float(contact.case.whole_xi2(xi2)), contact=contact.name
                    )
                )
            self.contacts[k] = contact._replace(mode=mode)
        self.list_changes([] if self.is_start else changes)  # the modes of a start are no changes
        self.is_start = False
        self.beginning = set(self.begins)
        self.begins, self.leaving, self.struck, self.stuck = {}, set(), set(), set()
        if not modes and self.case.effect(Flight) is None:
            raise _MotionEnd("lift_off")
        return SeveralContactPhase(self.dynamics, self.contacts, rests)

    def modes(self, now: Sequence[PairState], closed: list[int]) -> dict[int, Mode] | None:
        """The modes of the contacts that stay closed, by their places; None without a solution."""
        if not closed:
            return {}
        some = [now[k] for k in closed]
        slips: list[float | None] = []
        for k, pair in zip(closed, some, strict=True):
            begins = self.begins.get(self.contacts[k].name)
            still = abs(pair.slip) <= MOVES * self.speed
            slips.append(begins if begins is not None else None if still else float(np.sign(pair.slip)))
        delassus, rows = self.dynamics.delassus(some)
        free = self.dynamics.free_rates(self.t, self.body, some, rows)
        mu, stick = frictions(some)
        answers = solutions(delassus, free, slips, mu, stick)
        if not answers:
            return None
        if len(answers) > 1 and len(closed) > 1 and not (stick > mu).any():
            raise _MotionEnd("not_unique")
        force = min(answers, key=lambda f: float(np.abs((delassus @ f + free)[len(closed) :]).max()))
        rates = delassus @ force + free
        scale = max(float(np.abs(free).max()), float(np.abs(delassus).max() * np.abs(force).max()))
        modes = {}
        for i, k in enumerate(closed):
            if rates[i] > MOVES * scale:
                continue
            if mu[i] == 0.0:
                modes[k] = Mode.SLIDE
                continue
            sign = slips[i]
            if sign is None:
                rate = float(rates[len(closed) + i])
                sign = float(np.sign(rate)) if abs(rate) > MOVES * scale and not is_rough(some[i].contact) else 0.0
            modes[k] = Mode.ROLL if sign == 0.0 else Mode.SLIP_FORWARD if sign > 0.0 else Mode.SLIP_BACKWARD
        return modes

    def phase(self, phase: SeveralContactPhase) -> None:
        """Integrate until an event, and apply it."""
        self.contacts = [
            c for c, p in zip(self.contacts, self.pairs(), strict=True)
            if c.is_closed or c.case.has_unique_points or p.clearance > FORGOTTEN * self.clearances.get(c.name, inf)
        ]  # fmt: skip
        phase.contacts, phase.near = self.contacts, [c.pair for c in self.contacts]
        if phase.rests:
            self.rest(phase)
            return
        while True:
            hit_guards = self.integrate(phase)
            if hit_guards != ["retry"]:
                break
        self.apply(phase, hit_guards)

    def pace(self, phase: SeveralContactPhase) -> float:
        size = self.case.plate.gyration
        speeds = np.abs(self.body[3:]) / np.array([size, size, 1.0])
        accelerations = np.abs(phase.forces(self.t, self.body).acceleration) / np.array([size, size, 1.0])
        return max(float(speeds.max()), sqrt(float(accelerations.max())))

    def integrate(self, phase: SeveralContactPhase) -> list[tuple[str, str]]:
        """Integrate to the first zero of a guard; returns the guards that vanish there, none at the end."""
        end = self.case.duration
        scales = self.scales(phase)
        values = phase.guards(self.t, self.body)
        positive = {name: value > RISEN * scales[name[0]] for name, value in values.items()}
        pace = self.pace(phase)
        blind = self.t + (BLIND / pace if pace else 0.0)
        solver = DOP853(
            phase.rates, self.t, self.body, end, rtol=self.rtol, atol=1e-2 * self.rtol,
            max_step=2.0 * pi / (STEPS_PER_TURN * pace) if pace else end, first_step=None,
        )  # fmt: skip
        while solver.status == "running":
            solver.step()
            self.steps += 1
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                raise _MotionEnd("breakdown")
            if self.steps > MOST_STEPS:
                raise _MotionEnd("unfinished")
            dense = solver.dense_output()
            looks = np.linspace(solver.t_old, solver.t, LOOKS + 1)[1:]
            if not any(positive.values()) or solver.t_old == self.t:
                looks = np.union1d(looks, solver.t_old + (solver.t - solver.t_old) * np.geomspace(1e-8, 0.2, 24))
            before = solver.t_old
            for look in looks.tolist():
                if look > before and self.is_lost(phase, before, look, dense):
                    # At the last look the points were still the nearest ones.
                    self.stretches.append(_DenseStep(solver.t_old, before, dense, phase))
                    if before > solver.t_old and self.elsewhere(solver.t_old, before, dense):
                        return [("meeting", "")]
                    self.t, self.body = before, np.array(dense(before))
                    return [("forget", "")]
                values = phase.guards(look, dense(look))
                if look <= blind:
                    values = {n: v for n, v in values.items() if n[0] != "slip" or n[1] not in self.beginning}
                zeros = [
                    name for name, value in values.items()
                    if value <= (0.0 if positive[name] else -100.0 * RISEN * scales[name[0]])
                ]  # fmt: skip
                if zeros:
                    return self.locate(phase, dense, before, look, zeros, positive)
                for name, value in values.items():
                    positive[name] |= value > RISEN * scales[name[0]]
                before = look
            self.stretches.append(_DenseStep(solver.t_old, solver.t, dense, phase))
            if self.elsewhere(solver.t_old, solver.t, dense):
                return [("meeting", "")]
        self.t, self.body = solver.t, solver.y
        raise _MotionEnd("completed")

    def is_lost(self, phase: SeveralContactPhase, before: float, look: float, dense) -> bool:
        """Whether an open contact's points are no longer surely the nearest ones: the clearance has fallen, or they
        have moved farther between two looks than their rate allows."""
        earlier, now = phase.pairs(dense(before)), phase.pairs(dense(look))
        for contact, was, pair in zip(phase.contacts, earlier, now, strict=True):
            if contact.is_closed or contact.case.has_unique_points:
                continue
            farthest = JUMP * max(abs(was.xi1_rate), abs(pair.xi1_rate)) * (look - before) + JUMP * EPS
            jumps = abs(pair.xi1 - was.xi1) > farthest + JUMP * EPS * abs(pair.xi1)
            if jumps or pair.clearance < FORGOTTEN * self.clearances[contact.name]:
                return True
        return False

    def locate(self, phase, dense, before: float, look: float, zeros, positive) -> list[tuple[str, str]]:
        """The earliest zero between two looks."""
        roots = {}
        for name in zeros:

            def value(t: float, name=name) -> float:
                return phase.guards(t, dense(t))[name]

            falls = positive[name] and value(before) > 0.0
            roots[name] = float(brentq(value, before, look, xtol=1e-15, rtol=8.9e-16)) if falls else before
        first = min(roots.values())
        self.stretches.append(_DenseStep(self.stretches[-1].end if self.stretches else self.t, first, dense, phase))
        self.stretches[-1] = self.stretches[-1]._replace(start=min(before, first))
        if self.elsewhere(before, first, dense):
            return [("meeting", "")]
        self.t, self.body = first, dense(first)
        return [name for name, root in roots.items() if root - first <= 1e-11 * max(1.0, first)]

    def scales(self, phase: SeveralContactPhase) -> dict[str, float]:
        force = max(
            float(np.abs(self.dynamics.torsor(self.t, self.body) / self.dynamics.units).max()),
            float(np.abs(phase.forces(self.t, self.body).normal).max(initial=0.0)),
        )
        speed = max(self.speed, float(np.abs(self.body[3:]).max()), 1e-300)
        return {"gap": 1e-2 * self.size(), "slip": speed, "normal": force, "cone+": force, "cone-": force}

    # --- contacts at other places -------------------------------------------------------------------------------------

    def elsewhere(self, start: float, end: float, dense) -> bool:
        """Whether the plate overlaps its track at a place that is not watched; if so, the motion goes back to where it
        met it, and the contact is added."""
        looks = np.linspace(start, end, LOOKS + 1)[1:]
        poses = np.array([dense(t)[:3] for t in looks]).T
        earliest: tuple[int, PairCase, float] | None = None
        for case in self.searched:
            first = next((c.pair[0] for c in self.contacts if c.case is case), case.start.xi1)
            near = np.full(len(looks), first)
            overlap = first_overlap(case.track, case.plate.outline, poses[0], poses[1], poses[2], near)
            if overlap is not None and (earliest is None or overlap[0] < earliest[0]):
                earliest = overlap[0], case, overlap[1]
        if earliest is None:
            return False
        number, case, xi1 = earliest
        time = float(looks[number])
        pair = self.deepest(case, dense(time), xi1)
        if pair is None:
            return False

        def gap(t: float) -> float:
            stretch = next(s for s in reversed(self.stretches) if s.start <= t or s is self.stretches[0])
            return pair_at(case, stretch.states(t), pair).gap

        after = time
        for stretch in reversed(self.stretches):
            if stretch.start < after and gap(stretch.start) > 0.0:
                root = float(brentq(gap, stretch.start, min(after, stretch.end), xtol=1e-15, rtol=8.9e-16))
                break
            after = min(after, stretch.start)
        else:
            return False
        while self.stretches and self.stretches[-1].start >= root:
            self.stretches.pop()
        last = self.stretches[-1]
        self.stretches[-1] = last._replace(end=root)
        self.ordinary = [change for change in self.ordinary if change.time <= root]
        self.kept_back = [change for change in self.kept_back if change.time <= root]
        self.t, self.body, self.contacts = root, np.array(last.states(root)), list(last.phase.contacts)
        self.add(case, pair)
        return True

    def deepest(self, case: PairCase, body: np.ndarray, xi1: float) -> tuple[float, float] | None:
        """The pair of points at an overlap that is not watched."""
        known = [pair_at(case, body, contact.pair) for contact in self.contacts if contact.case == case]
        reach = self.case.plate.reach
        for pair in all_pairs(case, body, xi1):
            place = case.track.point(pair[0])
            is_new = all(np.hypot(*(place - case.track.point(k.xi1))) > 1e-3 * reach for k in known)
            if is_new and pair_at(case, body, pair).gap < 0.0:
                return pair
        return None

    def add(self, case: PairCase, pair: tuple[float, float]) -> None:
        name = self.free_name(case)
        self.contacts.append(WatchedContact(name, case, pair, Mode.FLIGHT))
        self.touching.add(name)

    def free_name(self, case: PairCase) -> str:
        """The name of a further contact with that support."""
        used = {contact.name for contact in self.contacts}
        names = (contact_name(case.support, i) for i in range(1, len(used) + 2))
        return next(name for name in names if name not in used)

    def name_touching(self) -> None:
        """Contacts that touch for the first time get their names, in the order of their pairs."""
        for k, contact in enumerate(self.contacts):
            if contact.name in self.touching and contact.name.startswith(OPEN_NAME):
                name = self.free_name(contact.case)
                self.contacts[k] = contact._replace(name=name)
                for names in (self.touching, self.stuck):
                    if contact.name in names:
                        names.discard(contact.name)
                        names.add(name)

    # --- events -------------------------------------------------------------------------------------------------------

    def apply(self, phase: SeveralContactPhase, guards: list[tuple[str, str]]) -> None:
        """The state after an event."""
        new = {c.name for c in self.contacts} - {c.name for c in phase.contacts}
        # Newton's method begins at the last points of the phase, not at its first ones.
        near = dict(zip((c.name for c in phase.contacts), phase.near, strict=True))
        self.contacts = [c._replace(pair=near.get(c.name, c.pair)) for c in self.contacts]
        self.touching = {c.name for c in self.contacts if c.is_closed} | new
        self.stuck = {c.name for c in self.contacts if c.mode is Mode.ROLL}
        kinds = {kind for kind, _ in guards}
        if kinds == {"forget"}:
            self.contacts = [c for c in self.contacts if c.is_closed]
            self.settle()
            self.goes_on = True
            return
        for kind, name in guards:
            if kind == "gap":
                self.touching.add(name)
            if kind == "slip":
                self.stuck.add(name)
            if kind == "normal":
                self.leaving.add(name)
            if kind in ("cone+", "cone-"):
                # Friction at its bound along the tangent begins a slip against it.
                self.begins[name] = 1.0 if kind == "cone+" else -1.0
        if kinds & {"cone+", "cone-"}:
            self.vanishing(phase)
        self.settle(may_strike=bool(kinds & {"gap", "meeting"}))

    def vanishing(self, phase: SeveralContactPhase) -> None:
        """Contacts whose normal force vanishes together with friction open, instead of slipping."""
        forces = phase.forces(self.t, self.body)
        scale = self.scales(phase)["normal"]
        for k, contact in enumerate(phase.contacts):
            if contact.name in self.begins and abs(float(forces.normal[k])) <= 1e-9 * scale:
                del self.begins[contact.name]
                self.leaving.add(contact.name)

    def settle(self, may_strike: bool = False) -> None:
        """Remove roundings: gaps of touching contacts, and velocities that are zero."""
        if may_strike:
            for contact, pair in zip(self.contacts, self.pairs(), strict=True):
                if pair.gap <= TOUCHES * self.size():
                    self.touching.add(contact.name)
        self.name_touching()
        self.close_gaps()
        now = self.pairs()
        for contact, pair in zip(self.contacts, now, strict=True):
            if contact.name in self.touching:
                self.clearances[contact.name] = pair.clearance
        self.speed = max(self.speed, float(np.abs(self.body[3:] * self.dynamics.units).max()))
        if may_strike:
            self.strike(now)
            self.come_to_rest()
        self.hold()

    def close_gaps(self) -> None:
        """Move the plate so that the touching contacts have no gap."""
        for _ in range(4):
            now = self.pairs()
            some = [p for p, c in zip(now, self.contacts, strict=True) if c.name in self.touching]
            if some:
                rows = np.array([p.lift_row for p in some]) / self.dynamics.units
                step = np.linalg.lstsq(rows, np.array([p.gap for p in some]), rcond=1e-10)[0]
                self.body[:3] -= step / self.dynamics.units

    def hold(self) -> None:
        """No velocity along the rows that are held."""
        now = self.pairs()
        touching = [p for p, c in zip(now, self.contacts, strict=True) if c.name in self.touching]
        sticking = [p for p, c in zip(now, self.contacts, strict=True) if c.name in self.stuck & self.touching]
        rows = np.array([p.lift_row for p in touching] + [p.slip_row for p in sticking])
        if not rows.size:
            return
        rows = rows / self.dynamics.units
        if np.linalg.matrix_rank(rows, tol=1e-9) == 3:
            self.body[3:] = 0.0
            return
        velocity = self.body[3:] * self.dynamics.units
        for _ in range(2):
            velocity = velocity - np.linalg.lstsq(rows, rows @ velocity, rcond=1e-10)[0]
        self.body[3:] = velocity / self.dynamics.units

    # --- impacts ------------------------------------------------------------------------------------------------------

    def strike(self, now: Sequence[PairState]) -> None:
        """The impact at the touched contacts, if one of them closes."""
        places_hit = [k for k, c in enumerate(self.contacts) if c.name in self.touching]
        small = MOVES * self.speed
        closing = [k for k in places_hit if now[k].lift < -small]
        places_hit = [k for k in places_hit if now[k].lift <= small]
        self.touching = {self.contacts[k].name for k in places_hit}
        if not closing:
            self.stuck |= {self.contacts[k].name for k in places_hit if abs(now[k].slip) <= small}
            return
        effect = self.case.effect(Impact)
        if effect is None:
            raise _MotionEnd("second_contact")
        self.count(max(-now[k].lift for k in closing))
        velocity, stuck = self.velocities(effect, [now[k] for k in places_hit])
        if effect.law == "newton":
            weights = 1.0 / self.dynamics.inverse
            if weights @ velocity**2 > (1.0 + 1e-12) * (weights @ self.body[3:] ** 2):
                raise _MotionEnd("energy_gain")
        self.body[3:] = velocity
        self.touching, self.stuck = set(), set()
        for i, k in enumerate(places_hit):
            name, lift = self.contacts[k].name, float(now[k].lift_row @ velocity)
            if k in closing:
                self.struck.add(name)
            if lift > small and not self.is_tiny(now[k], lift):
                continue
            if lift > small:
                self.at_rest = True
            self.touching.add(name)
            if stuck[i]:
                self.stuck.add(name)

    def velocities(self, effect: Impact, some: Sequence[PairState]) -> tuple[np.ndarray, list[bool]]:
        """Velocities after an impact, and which contacts do not slip."""
        velocity, laws = self.body[3:], [pair.contact.effect(Impact) for pair in some]
        restitution = np.array([law.restitution if law else 0.0 for law in laws])
        if len(some) == 1:
            law = laws[0]
            assert law is not None
            pair, scene = some[0], ContactScene(some[0].contact)
            q = scene.place(pair.xi1, pair.xi2)
            try:
                result = hit(scene, law, q, pair.slip, pair.lift, float(velocity[2]))
            except ImpactWithoutSolution:
                raise _MotionEnd("paradox") from None
            if effect.law == "newton" and creates_energy(result):
                raise _MotionEnd("energy_gain")
            rows = np.array([pair.slip_row, pair.lift_row, [0.0, 0.0, 1.0]])
            return np.linalg.solve(rows, np.array([result.slip, result.lift, result.spin])), [result.slip == 0.0]
        if effect.law != "poisson":
            after, _ = self.complementary(velocity, some, restitution, np.zeros(len(some)))
        else:
            nothing = np.zeros(len(some))
            after, impulses = self.complementary(velocity, some, nothing, nothing)
            if restitution.any():
                after, _ = self.complementary(after, some, nothing, restitution * impulses)
        mu, _ = frictions(some)
        slips = [abs(float(pair.slip_row @ after)) <= MOVES * self.speed and mu[i] > 0.0 for i, pair in enumerate(some)]
        return after, slips

    def complementary(
        self, velocity, some: Sequence[PairState], restitution: np.ndarray, least
    ) -> tuple[np.ndarray, np.ndarray]:
        """Velocities and normal impulses of Coulomb's law between impulses and velocities after the impact."""
        delassus, rows = self.dynamics.delassus(some)
        before = rows @ velocity
        free = before + np.concatenate([restitution * before[: len(some)], np.zeros(len(some))])
        mu, _ = frictions(some)
        answers = solutions(delassus, free, [None] * len(some), mu, mu, least)
        if len(answers) != 1:
            raise _MotionEnd("not_unique")
        return velocity + self.dynamics.inverse * (rows.T @ answers[0]), answers[0][: len(some)]

    def is_tiny(self, pair: PairState, lift: float) -> bool:
        pull = max(-float(pair.lift_row @ (self.dynamics.inverse * self.dynamics.torsor(self.t, self.body))), 0.0)
        return lift * lift <= 8.0 * pull * EPS * self.size()

    # --- small impacts ------------------------------------------------------------------------------------------------

    def count(self, closing: float) -> None:
        """Record an impact."""
        self.small = closing < SMALL_IMPACT * self.fastest
        if closing >= self.fastest:
            self.fastest, self.guess, self.last_guess = closing, (inf, inf), inf
        if not self.small:
            self.ordinary, self.kept_back = [*self.ordinary, *self.kept_back], []
        self.strikes = [*self.strikes[-4:], (self.t, float(self.body[2]))]
        end = self.aitken(0)
        if end is not None:
            self.guess, self.last_guess = min(self.guess, (abs(end - self.last_guess), end)), end

    def aitken(self, column: int) -> float | None:
        """The limit of the impacts' times (0) or angles (1), from every second of five."""
        if len(self.strikes) < 5:
            return None
        one, two = (self.strikes[i + 2][column] - self.strikes[i][column] for i in (0, 2))
        return self.strikes[4][column] + two * two / (one - two) if abs(two) < abs(one) else None

    def come_to_rest(self) -> None:
        """Stop a plate that small impacts bring to rest, at the extrapolated end of their series."""
        theta = self.aitken(1)
        if not self.small or theta is None or self.strikes[-1][0] != self.t or self.guess[1] == inf:
            return
        size = SMALL_HOP * self.size()
        if float(np.abs(self.body[3:] * self.dynamics.units).max()) * abs(self.last_guess - self.t) > size:
            return
        near = [k for k, pair in enumerate(self.pairs()) if pair.gap <= size]
        end = max(self.guess[1], self.t)
        if len(near) < 2 or end >= self.case.duration:
            return
        keep = self.body.copy(), set(self.touching)
        self.touching = {self.contacts[k].name for k in near}
        self.body[2:] = theta, 0.0, 0.0, 0.0
        self.close_gaps()
        some = [self.pairs()[k] for k in near]
        delassus, rows = self.dynamics.delassus(some)
        free = self.dynamics.free_rates(end, self.body, some, rows)
        mu, stick = frictions(some)
        answers = solutions(delassus, free, [None] * len(near), mu, stick)
        held = [*range(len(near)), *(len(near) + i for i in np.flatnonzero(stick > 0.0))]
        rank = np.linalg.matrix_rank(rows[held] / self.dynamics.units, tol=1e-9)
        if rank < 3 or not answers or np.abs(delassus @ answers[0] + free).max() > 1e-9 * np.abs(free).max():
            self.body, self.touching = keep
            return
        still = self.body.copy()
        if end > self.t:
            phase = SeveralContactPhase(self.dynamics, self.contacts, True)
            self.stretches.append(_DenseStep(self.t, end, lambda t: still, phase))
        self.t, self.stuck, self.at_rest = end, set(self.touching), True

    def list_changes(self, changes: list[Transition]) -> None:
        """Keep the changes of small impacts back until it is clear whether the motion comes to rest."""
        changes = sorted(changes, key=lambda change: change.contact)
        if self.at_rest:
            every = [*self.kept_back, *changes]
            before = {change.contact: change.before for change in reversed(every)}
            last = {change.contact: change for change in every}
            changes = [
                replace(change, time=self.t, before=before[name])
                for name, change in last.items() if before[name] is not change.after
            ]  # fmt: skip
            self.ordinary += sorted(changes, key=lambda change: change.contact)
            self.kept_back, self.at_rest, self.small, self.fastest, self.strikes = [], False, False, 0.0, []
        elif self.small:
            self.kept_back += changes
        else:
            self.ordinary, self.kept_back = [*self.ordinary, *self.kept_back, *changes], []

    # --- rest ---------------------------------------------------------------------------------------------------------

    def rest(self, phase: SeveralContactPhase) -> None:
        """A rest lasts until the load sets the plate in motion: where Coulomb's law gives it an acceleration."""
        still, end = self.body.copy(), self.case.duration
        closed = [p for p, c in zip(self.pairs(), self.contacts, strict=True) if c.is_closed]
        delassus, rows = self.dynamics.delassus(closed)
        mu, stick = frictions(closed)

        def moves(t: float) -> bool:
            free = self.dynamics.free_rates(t, still, closed, rows)
            answers = solutions(delassus, free, [None] * len(closed), mu, stick)
            return not answers or float(np.abs(delassus @ answers[0] + free).max()) > 1e-12 * float(np.abs(free).max())

        last = None
        if self.dynamics.load is not None:
            before = self.t
            for look in np.linspace(self.t, end, REST_LOOKS)[1:].tolist():
                if moves(look):
                    last = (before, look)
                    break
                before = look
        if last is None:
            self.stretches.append(_DenseStep(self.t, end, lambda t: still, phase))
            self.t = end
            raise _MotionEnd("completed")
        low, high = last
        while high - low > 4.0 * EPS * high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if moves(middle) else (middle, high)
            if middle in (low, high) and high - low <= 4.0 * EPS * high:
                break
        self.stretches.append(_DenseStep(self.t, high, lambda t: still, phase))
        self.t, self.touching = high, {c.name for c in self.contacts if c.is_closed}
        self.stuck = set(self.touching)


def touches_at_start(case: Case) -> bool:
    """Whether the plate touches its track in several places in its start, to rounding."""
    if not case.start.in_contact:
        return False
    begin = start_motion(case)
    body = [begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega]
    size = abs(begin.x) + abs(begin.y) + case.plate.reach
    track = pairs(case)[0]
    gaps = [pair_at(track, body, pair).gap for pair in all_pairs(track, body, begin.xi1)]
    return sum(abs(gap) <= 1e-12 * size for gap in gaps) > 1


def mode_of(case: Case, slip: float, omega: float) -> Mode:
    """The mode of a contact with that slip velocity (m/s); a slip of a few roundings of the spin is none."""
    if friction_of(case)[0] == 0.0:
        return Mode.SLIDE
    if abs(slip) <= NO_SLIP * (case.plate.reach * abs(omega) + abs(slip)):
        return Mode.ROLL
    return Mode.SLIP_FORWARD if slip > 0.0 else Mode.SLIP_BACKWARD


def continue_motion(
    case: Case, t: float, body: Sequence[float] | np.ndarray, own: tuple[float, float] | None, mode: Mode,
    rtol: float = 1e-13, times: Sequence[float] | np.ndarray = (),
) -> SeveralMotion:  # fmt: skip
    """Continue a motion whose plate (x, y, θ, vx, vy, ω) has a contact at the pair `own` in that mode, and touches its
    track in further places at time t (s)."""
    march = _Simulation(case, t, body, rtol)
    if own is not None:
        march.contacts.append(WatchedContact(CONTACT, pairs(case)[0], own, mode))
        march.touching.add(CONTACT)
        if mode is Mode.ROLL:
            march.stuck = {CONTACT}
    around, track = own[0] if own is not None else case.start.xi1, pairs(case)[0]
    for pair in all_pairs(track, body, around):
        place = case.track.point(pair[0])
        known = [case.track.point(contact.pair[0]) for contact in march.contacts]
        is_new = all(np.hypot(*(place - other)) > 1e-6 * case.plate.reach for other in known)
        if is_new and pair_at(track, body, pair).gap <= 1e-9 * case.plate.reach:
            march.add(track, pair)
    return _complete(march, times)


def from_start(case: Case, rtol: float = 1e-13, times: Sequence[float] | np.ndarray = ()) -> SeveralMotion:
    """The motion of a case whose contacts are pairs of a support and a feature from its start on."""
    begin = start_motion(case)
    body = [float(v) for v in (begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega)]
    march = _Simulation(case, 0.0, body, rtol)
    march.is_start = True
    for pair in pairs(case):
        near = pair.guess(*body[:3])
        if not pair.has_unique_points:
            try:
                gap = pair_at(pair, body, near).gap
            except DoesNotFit:
                continue
            if abs(gap) > TOUCHES * march.size():
                continue
        march.contacts.append(WatchedContact(f"{OPEN_NAME}{pair.number}", pair, near, Mode.FLIGHT))
    return _complete(march, times)


def _complete(march: _Simulation, times: Sequence[float] | np.ndarray) -> SeveralMotion:
    with np.errstate(all="ignore"):
        status = march.simulate()
    return SeveralMotion(
        (*march.ordinary, *march.kept_back), status, march.t, _sample(march, np.asarray(times, dtype=float))
    )


def _sample(march: _Simulation, times: np.ndarray) -> np.ndarray:
    motions = np.full((7, len(times)), np.nan)
    starts = np.array([stretch.start for stretch in march.stretches])
    for i, t in enumerate(times.tolist()):
        if not march.stretches or t > march.t:
            continue
        number = max(int(np.searchsorted(starts, t, side="right")) - 1, 0)
        stretch = march.stretches[number]
        motions[:6, i] = stretch.states(t)
        for contact in stretch.phase.contacts:
            if contact.is_closed:
                motions[6, i] = 0.0 if stretch.phase.rests else pair_at(contact.case, motions[:6, i], contact.pair).slip
                break
    return motions
