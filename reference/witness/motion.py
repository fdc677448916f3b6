"""A motion by the second formulation: modes, events and rests until it ends."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

import numpy as np

from cases import Belt, Case, DoesNotFit, Flight, Impact, Mode, Transition, Unilateral
from cases.motion.trajectory import CONTACT
from cases.own_effects import own_effects
from cases.scene.contact_limits import limitation

from ..time_limit import check_time
from .complementarity import MOVES, pressing_forces, slips_at_rough_contact, solutions
from .contacts import (
    PairState,
    Sides,
    friction_of,
    frictions,
    is_rough,
    is_watched_always,
    on_side,
    on_whole_curves,
    resisting_sides,
)
from .impact_simulation import ImpactSimulation
from .integration import FORGOTTEN
from .phase import CURVE_ENDS, OWN, STICKS, SeveralContactPhase, rotation_name
from .plate_state import TOUCHES, SimulationEnd
from .watched_pairs import common_slips, groups, sides_of

# Far more phases than any motion has in such a part of its duration; a loop without progress ends with a status.
MOST_PHASES, PART = 5_000, 1e-3
# Forces that have just reached their limit are compared after this part of the motion's time scale.
AHEAD = 1e-6
# Accelerations below this part of the load are roundings of an equilibrium.
BALANCED = 1e-10


class Simulation(ImpactSimulation):
    """The state of one simulation."""

    def __init__(self, case: Case, t: float, body: Sequence[float] | np.ndarray, rtol: float):
        super().__init__(case, t, body, rtol)
        self.begins: dict[str, float] = {}
        self.rotation: dict[Sides, int] = {}  # the sense of a rotation that is resisted; 0: it is prevented
        self.is_start, self.goes_on = True, False
        self.may_continue = not limitation(self.case)  # where several contacts touch at once

    # --- phases -------------------------------------------------------------------------------------------------------

    def simulate(self) -> str:
        """Simulate phases until the motion ends; returns its status."""
        try:
            self.settle(may_strike=True)
            count, until = 0, 0.0
            while count < MOST_PHASES:
                check_time()
                count, until = (0, self.t + PART * self.case.duration) if self.t >= until else (count + 1, until)
                self.phase(self.same_modes() if self.goes_on else self.decide())
        except SimulationEnd as end:
            return str(end)
        except (DoesNotFit, np.linalg.LinAlgError):
            return "breakdown"
        return "unfinished"

    def same_modes(self) -> SeveralContactPhase:
        """The phase that continues after an open contact is no longer watched."""
        self.goes_on = False
        return SeveralContactPhase(self.dynamics, self.contacts, turns=self.rotation)

    def decide(self) -> SeveralContactPhase:
        """The modes that follow, from the complementarity of forces and accelerations at the touched contacts, for each
        group of contacts that share plates."""
        now, modes, resting, is_carried = self.pairs(), dict[int, Mode](), set[int](), False
        self.rotation = {}
        touching = [k for k, contact in enumerate(self.contacts) if contact.name in self.touching]
        for group in groups([self.contacts[k].case for k in touching]):
            every = [touching[i] for i in group]
            next_modes, plates, has_open_forces = self.decide_group(now, every)
            modes |= next_modes
            resting |= plates
            is_carried |= has_open_forces
        hits = [] if self.case.others else zip(self.contacts, now, strict=True)
        self.begin(modes, frozenset(c.name for c, pair in hits if self.bounces_on(c, pair)))
        if not modes and self.case.effect(Flight) is None:
            raise SimulationEnd("lift_off")
        return SeveralContactPhase(self.dynamics, self.contacts, is_carried, self.rotation, frozenset(resting))

    def decide_group(self, now: Sequence[PairState], every: list[int]) -> tuple[dict[int, Mode], set[int], bool]:
        """The modes of a group of contacts, which of their plates are at rest, and whether their forces are open."""
        closed = [k for k in every if self.contacts[k].name not in self.leaving]
        modes, forces = self.modes(now, closed, every)
        if self.is_carried(now, modes):
            contacts = [c._replace(mode=modes.get(k, Mode.FLIGHT)) for k, c in enumerate(self.contacts)]
            if self.start(SeveralContactPhase(self.dynamics, contacts, True, self.rotation)):
                closed = [k for k in closed if self.contacts[k].name not in self.leaving]
                modes, forces = self.modes(now, closed, every)
        plates = set().union(*(sides_of(self.contacts[k].case) for k in every))
        places = closed if len(forces) in (2 * len(closed), 3 * len(closed)) else every
        is_balanced = self.is_balanced(now, places, forces, plates) and not _is_on_belt(now, modes)
        sticking, turning = [k for k, m in modes.items() if m in STICKS], self.still_sides()
        rows = [now[k].lift_row for k in modes] + [now[k].slip_row for k in sticking]
        every_row = rows + self.turning_rows([now[k] for k in modes], turning)
        rank, most = self.rank(every_row), int(self.dynamics.moves.reshape(-1, 3)[sorted(plates)].sum())
        # With one contact guards show the end of a rest more exactly.
        is_whole = rank == most and len(every_row) > 2 and len(modes) > 1
        if is_balanced and (is_whole or (self.case.others and self.dynamics.is_constant)):
            return modes, plates, not self.dynamics.is_constant
        # Two corners on a line prevent a rotation by themselves: what they share with a couple is open.
        count = len(rows) if rank == self.rank(rows) else len(every_row)
        count -= common_slips([now[k].contact for k in sticking]) if self.case.others else 0
        if rank < min(count, most) and not is_balanced:  # they hold one point, about which the plate turns
            raise SimulationEnd("breakdown")
        return modes, set(), rank < len(every_row)

    def begin(self, modes: dict[int, Mode], goes_on: frozenset[str] = frozenset()) -> None:
        """Begin a phase in these modes, by the places of contacts; those that change are listed."""
        self.check_lift(modes)
        changes = []
        for k, contact in enumerate(self.contacts):
            mode = modes.get(k, Mode.FLIGHT)
            if mode is not contact.mode or (mode is Mode.FLIGHT and contact.name in self.struck):
                place = on_whole_curves(contact.case, contact.pair)
                changes.append(Transition(self.t, contact.mode, mode, *place, contact=contact.name))
            self.contacts[k] = contact._replace(mode=mode)
        self.is_several |= any(contact.is_closed and contact.name != CONTACT for contact in self.contacts)
        self.impacts.list_changes(self.t, [] if self.is_start else changes, goes_on)  # a start's modes are no changes
        self.is_start, self.beginning = False, set(self.begins) - self.slow
        self.slow = set()
        self.begins, self.leaving, self.struck, self.stuck, self.still = {}, set(), set(), set(), set()

    def check_lift(self, modes: dict[int, Mode]) -> None:
        """Where effects of packages lift a plate, which end with the contact, it comes down at once."""
        touching = {k for k, c in enumerate(self.contacts) if c.is_closed or c.name in self.touching}
        some = touching - modes.keys()
        opened = [pair for k, pair in enumerate(self.pairs()) if k in some and own_effects(pair.contact.effects)]
        if not opened or self.case.effect(Flight) is None:
            return
        load = self.dynamics.inverse * self.dynamics.torsor(self.t, self.body)
        rates = [float(pair.lift_row @ load) + pair.lift_bias for pair in opened]
        if min(rates) < -MOVES * float(np.abs(load * self.dynamics.units).max()):
            raise SimulationEnd("accumulation" if self.case.effect(Impact) else "landing")

    def is_balanced(self, now: Sequence[PairState], closed: list[int], forces: np.ndarray, plates: set[int]) -> bool:
        """Whether these plates are still, and the forces at the contacts balance the load."""
        parts = [3 * b + i for b in plates for i in range(3)]
        if self.body[self.half :][parts].any():
            return False
        some = [now[k] for k in closed]
        _, rows = self.dynamics.delassus(some)
        load = self.dynamics.inverse * self.dynamics.torsor(self.t, self.body)
        acceleration = load + self.dynamics.inverse * (rows.T @ forces if len(rows) else 0.0)
        size = float(np.abs(load * self.dynamics.units).max())
        return bool(np.abs((acceleration * self.dynamics.units)[parts]).max() <= BALANCED * size)

    def rank(self, rows: list[np.ndarray]) -> int:
        """How many of some rows of velocities are independent."""
        scale = self.dynamics.moves / self.dynamics.units
        return int(np.linalg.matrix_rank(np.array(rows) * scale, tol=1e-9)) if rows else 0

    def still_sides(self) -> set[Sides]:
        """The plates that contacts prevent from turning against each other."""
        return {sides for sides, sense in self.rotation.items() if sense == 0}

    def is_carried(self, now: Sequence[PairState], modes: dict[int, Mode]) -> bool:
        """Whether contacts in these modes, some of them on belts, have more rows than the plate velocities."""
        count = len(modes) + sum(mode in STICKS for mode in modes.values()) + len(self.still_sides())
        return _is_on_belt(now, modes) and count > int(self.dynamics.moves.sum())

    def modes(
        self, now: Sequence[PairState], closed: list[int], every: list[int]
    ) -> tuple[dict[int, Mode], np.ndarray]:
        """The modes of the contacts that stay closed, by their places, and the forces at `closed`, or at `every`
        contact that touches if those have no solution. Raises SimulationEnd."""
        answer = self.solution(now, closed)
        if every and not closed and self._must_pull([now[k] for k in every]):
            raise SimulationEnd("paradox")
        if answer is None and len(every) > len(closed):
            answer = self.solution(now, every)
        if answer is None:
            raise SimulationEnd("paradox")
        return answer

    def _must_pull(self, some: Sequence[PairState]) -> bool:
        """Whether a perfectly rough contact that can no longer press could not open: the free plate would move into its
        support."""
        _, rows = self.dynamics.delassus(some)
        free = self.dynamics.free_rates(self.t, self.body, some, rows)
        small = MOVES * float(np.abs(free).max())
        return any(is_rough(pair.contact) and rate < -small for pair, rate in zip(some, free, strict=False))

    def solution(self, now: Sequence[PairState], closed: list[int]) -> tuple[dict[int, Mode], np.ndarray] | None:
        """The modes of the contacts that stay closed, by their places, and the forces; None without a solution. A guide
        holds its one contact from both sides."""
        if len(closed) != 1 or now[closed[0]].contact.effect(Unilateral) is not None:
            return self.one_sided(now, closed)
        (k,) = closed
        for side in (now[k].side, -now[k].side):
            answer = self.one_sided([on_side(pair, side) for pair in now], closed)
            if answer is not None and answer[0]:
                self.contacts[k] = self.contacts[k]._replace(side=side)
                return answer
        return None

    def one_sided(self, now: Sequence[PairState], closed: list[int]) -> tuple[dict[int, Mode], np.ndarray] | None:
        """The same where contacts only push."""
        self.rotation = {sides: v for sides, v in self.rotation.items() if sides not in {now[k].sides for k in closed}}
        if not closed:
            return {}, np.zeros(0)
        some = [now[k] for k in closed]
        slips: list[float | None] = []
        for k, pair in zip(closed, some, strict=True):
            begins = self.begins.get(self.contacts[k].name)
            still = abs(pair.slip) <= MOVES * self.speed
            slips.append(begins if begins is not None else None if still else float(np.sign(pair.slip)))
        delassus, rows = self.dynamics.delassus(some)
        free = self.dynamics.free_rates(self.t, self.body, some, rows)
        mu, stick = frictions(some)
        slips += [self.sense_of_rotation(pair) for pair in some[: len(mu) - len(some)]]
        rough = np.array([is_rough(pair.contact) for pair in some])
        answers = [
            one
            for one in solutions(delassus, free, slips, mu, stick)
            if not slips_at_rough_contact(delassus, free, one, rough)
        ]
        if len(closed) == 1 and rough[0] and slips[0] is None:
            # It stays where it can, as in the first formulation, even if the plate could leave it, too.
            is_guide = some[0].contact.effect(Unilateral) is None
            answers += pressing_forces(delassus, free, slips[1:], mu[1:], is_guide)
        if not answers:
            return None
        holds_better = any(friction_of(pair.contact)[1] > friction_of(pair.contact)[0] for pair in some)
        if len(answers) > 1 and len(closed) > 1 and not holds_better:
            raise SimulationEnd("not_unique")
        # Of several the one with the least beginning of a slip, and of a rotation that may be prevented.
        least = slice(len(closed), None if slips[-1] is None else 2 * len(closed))
        force = min(answers, key=lambda f: float(np.abs((delassus @ f + free)[least]).max()))
        rates = delassus @ force + free
        scale = max(float(np.abs(free).max()), float(np.abs(delassus).max() * np.abs(force).max()))
        # A load may cancel with the weight.
        scale = max(scale, float(np.abs(self.dynamics.inverse * self.dynamics.weight).max()))
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
        for i, k in enumerate(closed):
            if k in modes and now[k].sides in resisting_sides([now[j] for j in modes]):
                rate, sense = float(rates[2 * len(closed) + i]), slips[len(closed) + i]
                self.rotation[now[k].sides] = int(sense or (np.sign(rate) if abs(rate) > MOVES * scale else 0.0))
        is_slider = not (self.case.plate.turns or self.case.others or self.case.supports)
        resting = {k for k in modes if self.rotation.get(now[k].sides) == 0 or is_slider}
        return {k: Mode.REST if mode is Mode.ROLL and k in resting else mode for k, mode in modes.items()}, force

    def sense_of_rotation(self, pair: PairState) -> float | None:
        """The sign of the rotation of a contact's plates; None if there is none, and resistance may prevent one."""
        rotation = float(pair.turning_row @ self.body[self.half :])
        still = abs(rotation) <= MOVES * self.speed
        return self.begins.get(rotation_name(pair.sides), None if still else float(np.sign(rotation)))

    def phase(self, phase: SeveralContactPhase) -> None:
        """Integrate until an event, and apply it."""
        self.contacts = [
            c for c, p in zip(self.contacts, self.pairs(), strict=True)
            if c.is_closed or is_watched_always(c.case) or p.clearance > FORGOTTEN * self.clearances.get(c.name, inf)
        ]  # fmt: skip
        phase.contacts, phase.near = self.contacts, [c.pair for c in self.contacts]
        if self.impacts.strikes and self.impacts.strikes[-1].time == self.t:
            tiny = {name for name, (lift, pull) in self.hops(phase).items() if self.is_tiny(lift, pull)}
            if tiny:  # the other contacts' forces drive the plate back
                self.touching = {c.name for c in self.contacts if c.is_closed} | tiny
                self.stuck = {c.name for c in self.contacts if c.mode in STICKS}
                self.still = self.still_sides()
                self.impacts.at_rest = True
                end, body = self.impacts.low_end(self.t, self.body, frozenset(self.touching))
                if self.t < end < self.case.duration:
                    names, noise = frozenset(self.touching), 2.0 * self.impacts.strikes[-1].closing
                    self.come_to_rest(end, body, names, noise)
                self.settle()
                return
        self.apply(phase, self.integrate(phase))

    # --- events -------------------------------------------------------------------------------------------------------

    def apply(self, phase: SeveralContactPhase, guards: list[tuple[str, str]]) -> None:
        """The state after an event."""
        new = {c.name for c in self.contacts} - {c.name for c in phase.contacts}
        # Newton's method begins at the last points of the phase, not at its first ones.
        near = dict(zip((c.name for c in phase.contacts), phase.near, strict=True))
        self.contacts = [c._replace(pair=near.get(c.name, c.pair)) for c in self.contacts]
        self.touching = {c.name for c in self.contacts if c.is_closed} | new
        self.stuck = {c.name for c in self.contacts if c.mode in STICKS}
        self.still = self.still_sides()
        kinds = {kind for kind, _ in guards}
        for kind in kinds:
            if kind in CURVE_ENDS or kind.startswith(OWN):
                raise SimulationEnd(kind.removeprefix(OWN))
        if kinds == {"forget"}:
            self.contacts = [c for c in self.contacts if c.is_closed or is_watched_always(c.case)]
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
            if kind == "side":
                self.contacts = [c._replace(side=-c.side) if c.name == name else c for c in self.contacts]
            if kind == "rotation":
                self.still |= {sides for sides in phase.turns if rotation_name(sides) == name}
            if kind in ("cone+", "cone-", "couple+", "couple-"):
                # Friction at its bound along the tangent begins a slip against it, and a couple a rotation.
                self.begins[name] = 1.0 if kind.endswith("+") else -1.0
        if kinds & {"cone+", "cone-"}:
            self.vanishing(phase)
        if "held" in kinds:
            self.start(phase)
        for name in [name for kind, name in guards if kind == "turn"]:
            self.turn(name)
        self.settle(may_strike=bool(kinds & {"gap", "meeting"}))

    def start(self, phase: SeveralContactPhase) -> bool:
        """Let contacts slip or open if they can no longer carry the plate; returns whether they do. They are compared
        a little later, when their rates are more than rounding."""
        load = self.dynamics.inverse * self.dynamics.torsor(self.t, self.body) * self.dynamics.units
        fastest = float(np.abs(load).max())
        if not fastest:
            return False
        starts = phase.starts_after(AHEAD * sqrt(self.case.plate.reach / fastest), self.t, self.body)
        self.begins |= {name: sign for name, sign in starts.items() if sign}
        self.leaving |= {name for name, sign in starts.items() if not sign}
        return bool(starts)

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
                if pair.gap <= TOUCHES * self.size() and not contact.is_away:
                    self.touching.add(contact.name)
        self.name_touching()
        if len(self.touching) > 1:
            self.is_several |= not self.is_start  # in a start the second one may open at once
            if not self.may_continue:
                raise SimulationEnd("second_contact")
        self.close_gaps()
        now = self.pairs()
        for contact, pair in zip(self.contacts, now, strict=True):
            if contact.name in self.touching:
                self.clearances[contact.name] = pair.clearance
        fastest = float(np.abs(self.body[self.half :] * self.dynamics.units).max())
        self.speed = max(self.speed, fastest, self.surface_speed(self.t))
        if may_strike and not self.strike_all(now):
            self.end_bouncing()
        self.hold()


def _is_on_belt(now: Sequence[PairState], modes: dict[int, Mode]) -> bool:
    """Whether the support of a closed contact runs."""
    return any(now[k].contact.effect(Belt) is not None for k in modes)
