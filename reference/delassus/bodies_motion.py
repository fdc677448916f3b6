"""A motion of several plates by the second formulation: the frames of `bodies`, modes by complementarity, DOP853."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan2, hypot, pi
from typing import NamedTuple, cast

import numpy as np

from cases import Case, Curve, Impact, Mode, NotSupported, Plate, Start, Transition
from cases.contact.polygon_features import size_of_plate
from cases.library import hill
from cases.scene.free_plates import PlateContact, parameter, plate_contacts, plates_of, start_poses
from cases.scene.limits import without_certificate

from .bodies import FIXED, ContactOfBodies, _frame
from .contacts import PairState, PlateDynamics, pair_at
from .impact_laws import by_whole_impulses
from .integration import DenseStep
from .motion import Simulation
from .phase import ContactSolution, SeveralContactPhase, WatchedContact
from .plate_state import MOVES, SimulationEnd
from .polygon_pairs import PolygonPair, polygon_pair

# Bouncing with a fixed ratio ends far above this part of the largest speed; slower rebounds have no known end.
ACCUMULATES = 1e-7
# Accelerations below this part of the load are roundings of an equilibrium.
BALANCED = 1e-10


class PlatesMotion(NamedTuple):
    """Transitions, status, end (s), and (x, y, θ) of all plates, then (vx, vy, ω) of all, at the requested times, and
    the slip of the first plate's first closed contact with track or support, shape (6 plates + 1, n): NaN after
    the end."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    motions: np.ndarray


@dataclass(frozen=True, eq=False)
class PairOfBodies:
    """A contact of two plates, or of a plate and a line, as a pair of curves: `base` is the plate whose boundary, run
    through clockwise, is the track, None for a line."""

    contact: PlateContact
    pair: Case
    base: Plate | None
    has_unique_points = True
    arc_range = None

    @property
    def track(self) -> Curve:
        """The line, or the boundary of the base."""
        return self.pair.track

    @property
    def plate(self) -> Plate:
        """The plate."""
        return self.pair.plate

    @property
    def sides(self) -> set[int]:
        """The numbers of the plates."""
        return {side for side in (self.contact.body, self.contact.base) if side is not None}

    def effect(self, kind):
        """The effect of that kind between the two, or None."""
        return self.contact.effect(kind)

    def whole_xi2(self, xi2: float) -> float:
        """A parameter of the outline as one of the outline."""
        return xi2

    def whole_xi1(self, xi1: float) -> float:
        """A parameter of the track as one of the base's outline; of a line as it is."""
        return xi1 if self.base is None else float(parameter(self.base.outline, 0.5 * pi - xi1))


class BodiesDynamics(PlateDynamics):
    """Masses of all plates, and the forces applied to them."""

    def __init__(self, case: Case):
        super().__init__(case)
        plates, each = plates_of(case), list[PlateDynamics]()
        for plate in plates:
            each.append(
                PlateDynamics(replace(case, plate=plate, start=_anywhere(case.track), others=(), supports=(), pairs=()))
            )
        self.inverse = np.concatenate([one.inverse for one in each])
        self.weight = np.concatenate([one.weight for one in each])
        self.units = np.array([value for plate in plates for value in (1.0, 1.0, size_of_plate(plate))])
        self.turns = np.array([value for plate in plates for value in (True, True, plate.turns)])


def _anywhere(track: Curve) -> Start:
    return Start(float(track.span[0]), 0.0)


@pair_at.register(PairOfBodies)
def _pair_of_bodies_at(pair: PairOfBodies, body: Sequence[float] | np.ndarray, near: tuple[float, float]) -> PairState:
    """The contact in a state of all plates; the nearest points of discs and lines need no guess."""
    half = len(body) // 2
    values = np.asarray(body, dtype=float)
    states = [(*values[i : i + 3], *values[half + i : half + i + 3]) for i in range(0, half, 3)]
    own, base = pair.contact.body, pair.contact.base
    x, y, theta, *_ = states[own]
    if base is None:
        low = float(pair.track.span[0])
        point, tangent = pair.track.point(low), pair.track.tangent(low)
        xi1 = low + float((np.array([x, y]) - point) @ tangent) / float(pair.track.speed(low))
        turn = atan2(tangent[1], tangent[0])
        other = FIXED
    else:
        other = states[base]
        turn = -atan2(x - other[0], y - other[1])
        xi1 = -turn + other[2]
    xi2 = float(parameter(pair.plate.outline, turn - 0.5 * pi - theta))
    xi1 += 2.0 * pi * round((near[0] - xi1) / (2.0 * pi)) if base is not None else 0.0
    one = ContactOfBodies(pair.pair, xi1, xi2, own, base)
    lift_row, slip_row, lift_bias, slip_bias = _frame(one, states)
    velocity = values[half:]
    # Both points lie on the line of the centres, or on the normal through the centre.
    if base is None:
        px, py = pair.track.point(xi1)
        gap = float(hypot(x - px, y - py)) * np.sign(lift_row[3 * own : 3 * own + 2] @ (x - px, y - py))
    else:
        gap = hypot(x - other[0], y - other[1]) - float(pair.track.point(0.0)[1])
    gap -= float(np.hypot(*pair.plate.outline.point(xi2)))
    lift, slip = float(lift_row @ velocity), float(slip_row @ velocity)
    return PairState(pair, xi1, xi2, float(gap), lift, slip, lift_row, slip_row, lift_bias, slip_bias, 0.0)  # type: ignore[arg-type]


class BodiesPhase(SeveralContactPhase):
    """A phase in which the plates of some contacts rest: these have no accelerations and no guards."""

    def __init__(
        self, dynamics: BodiesDynamics, contacts: Sequence[WatchedContact], resting: frozenset[int], is_carried: bool
    ):
        super().__init__(dynamics, contacts, is_carried=is_carried)
        self.resting = resting
        self.frozen = {contact.name for contact in contacts if _sides(contact) <= resting}

    def forces(
        self, t: float, body: Sequence[float] | np.ndarray, now: Sequence[PairState | None] | None = None
    ) -> ContactSolution:
        """Accelerations and forces; those at contacts of plates at rest count as 0."""
        now = self.closed_pairs(t, body) if now is None else now
        moving = [None if c.name in self.frozen else pair for c, pair in zip(self.contacts, now, strict=True)]
        answer = super().forces(t, body, moving)
        still = [3 * b + i for b in self.resting for i in range(3)]
        acceleration = np.array(answer.acceleration)
        acceleration[still] = 0.0
        return answer._replace(acceleration=acceleration)

    def guards(self, t: float, y: np.ndarray) -> dict[tuple[str, str], float]:
        """As of any phase, without contacts of plates at rest; with the ends of edges and corners that discs touch."""
        values = super().guards(t, y)
        for contact, (xi1, _) in zip(self.contacts, self.near, strict=True):
            if isinstance(contact.case, PolygonPair) and contact.case.disc is not None:
                values["turn", contact.name] = min(contact.case.inside(xi1))
        return {key: value for key, value in values.items() if key[1] not in self.frozen}


def _sides(contact: WatchedContact) -> set[int]:
    """The numbers of the plates at a contact."""
    return cast(PairOfBodies, contact.case).sides


def _common_slips(pairs: Sequence[PairOfBodies]) -> int:
    """How many of some contacts are second corners of a plate on one line: the friction of both is not unique."""
    lines = [(pair.contact.body, id(pair.contact.curve)) for pair in pairs if pair.contact.base is None]
    return len(lines) - len(set(lines))


def groups(pairs: Sequence[PairOfBodies]) -> list[list[int]]:
    """The places of contacts in groups that share plates."""
    results = list[list[int]]()
    for k, pair in enumerate(pairs):
        own = [some for some in results if any(pairs[i].sides & pair.sides for i in some)]
        results = [some for some in results if some not in own] + [sorted([k, *(i for some in own for i in some)])]
    return results


class BodiesSimulation(Simulation):
    """The simulation of several plates."""

    def __init__(self, case: Case, rtol: float):
        poses = start_poses(case)
        super().__init__(case, 0.0, np.concatenate([poses[:, :3].ravel(), poses[:, 3:].ravel()]), rtol)
        self.dynamics = BodiesDynamics(case)
        self.searched = []
        for contact in plate_contacts(case):
            plates = plates_of(case)
            around = polygon_pair(contact, plates, poses)
            if around is not None:
                self.contacts.append(WatchedContact(contact.name, around, (0.0, 0.0), Mode.FLIGHT))  # type: ignore[arg-type]
                continue
            base = None if contact.base is None else plates[contact.base]
            track = contact.curve if base is None else hill(cast(float, base.radius))
            assert track is not None
            pair = replace(
                case, track=track, plate=plates[contact.body], effects=contact.effects, start=_anywhere(track),
                supports=(), others=(), pairs=(),
            )  # fmt: skip
            watched = WatchedContact(contact.name, PairOfBodies(contact, pair, base), (0.0, 0.0), Mode.FLIGHT)  # type: ignore[arg-type]
            self.contacts.append(watched)

    def size(self) -> float:
        """The size of the poses' numbers, m."""
        centres = self.body[: self.half].reshape(-1, 3)[:, :2]
        return float(np.abs(centres).max() + max(map(size_of_plate, plates_of(self.case))))

    def pace(self, phase: SeveralContactPhase) -> float:
        """How fast the plates move or begin to, 1/s."""
        lengths = np.array([v for p in plates_of(self.case) for v in (size_of_plate(p), size_of_plate(p), 1.0)])
        accelerations = np.abs(phase.forces(self.t, self.body).acceleration) / lengths
        return max(float((np.abs(self.body[self.half :]) / lengths).max()), float(np.sqrt(accelerations.max())))

    def turn(self, name: str) -> None:
        """A disc passes from an edge of a polygon to a corner, or the other way."""
        for k, contact in enumerate(self.contacts):
            if contact.name == name:
                pair = cast(PolygonPair, contact.case)
                before, after = pair.inside(contact.pair[0])
                self.contacts[k] = contact._replace(case=pair.neighbour(1 if after < before else -1))  # type: ignore[arg-type]

    def is_lost(self, phase: SeveralContactPhase, before: float, look: float, dense) -> bool:
        """Nearest points of discs and lines are never lost."""
        return False

    def velocities_after(self, effect: Impact, some: Sequence[PairState]) -> tuple[np.ndarray, list[bool]]:
        """Velocities after an impact at some contacts, and which of these do not slip."""
        before, small = self.body.copy(), MOVES * self.speed
        stuck = [abs(pair.slip) <= small for pair in some]
        for group in groups([cast(PairOfBodies, pair.contact) for pair in some]):
            if all(some[i].lift >= -small for i in group):
                continue
            laws = [some[i].contact.effect(Impact) for i in group]
            restitution = np.array([law.restitution if law else 0.0 for law in laws])
            after, sticks = by_whole_impulses(self, effect, [some[i] for i in group], restitution)
            self.body[self.half :] = after
            for i, sticking in zip(group, sticks, strict=True):
                stuck[i] = sticking
        velocity, self.body = self.body[self.half :].copy(), before
        return velocity, stuck

    def end_bouncing(self) -> None:
        """As of one plate; the motion ends where impacts follow each other ever faster, and no end of them is found."""
        super().end_bouncing()
        last = self.impacts.strikes[-1] if self.impacts.strikes else None
        if last is not None and last.time == self.t and last.names - self.touching:
            if last.closing < ACCUMULATES * self.speed:
                raise SimulationEnd("accumulation")

    def decide(self) -> SeveralContactPhase:
        """The modes that follow, group by group of contacts that share plates."""
        now, modes, resting, is_carried = self.pairs(), dict[int, Mode](), set[int](), False
        touching = [k for k, contact in enumerate(self.contacts) if contact.name in self.touching]
        for group in groups([cast(PairOfBodies, self.contacts[k].case) for k in touching]):
            every = [touching[i] for i in group]
            closed = [k for k in every if self.contacts[k].name not in self.leaving]
            chosen, forces = self.modes(now, closed, every)
            modes |= chosen
            plates = set().union(*(_sides(self.contacts[k]) for k in every))
            if self.is_balanced(now, closed if len(forces) == 2 * len(closed) else every, forces, plates):
                resting |= plates
                continue
            rows = [now[k].lift_row for k in chosen] + [now[k].slip_row for k, m in chosen.items() if m is Mode.ROLL]
            shared = _common_slips([cast(PairOfBodies, now[k].contact) for k, m in chosen.items() if m is Mode.ROLL])
            is_carried |= shared > 0
            if rows and np.linalg.matrix_rank(np.array(rows) / self.dynamics.units, tol=1e-9) < len(rows) - shared:
                raise SimulationEnd("breakdown")
        changes = []
        for k, contact in enumerate(self.contacts):
            mode, pair = modes.get(k, Mode.FLIGHT), cast(PairOfBodies, contact.case)
            if mode is not contact.mode or (mode is Mode.FLIGHT and contact.name in self.struck):
                xi1, xi2 = contact.pair
                changes.append(
                    Transition(self.t, contact.mode, mode, pair.whole_xi1(xi1), float(xi2), contact=contact.name)
                )
            self.contacts[k] = contact._replace(mode=mode)
        self.impacts.list_changes(self.t, [] if self.is_start else changes)  # the modes of a start are no changes
        self.is_start, self.beginning = False, set(self.begins)
        self.begins, self.leaving, self.struck, self.stuck = {}, set(), set(), set()
        return BodiesPhase(cast(BodiesDynamics, self.dynamics), self.contacts, frozenset(resting), is_carried)

    def is_balanced(self, now: Sequence[PairState], closed: list[int], forces: np.ndarray, plates: set[int]) -> bool:
        """Whether these plates are still, and the forces at the contacts balance the load."""
        parts = [3 * b + i for b in plates for i in range(3)]
        if self.body[self.half :][parts].any():
            return False
        rows = np.array([now[k].lift_row for k in closed] + [now[k].slip_row for k in closed])
        load = self.dynamics.inverse * self.dynamics.torsor(self.t, self.body)
        acceleration = load + self.dynamics.inverse * (rows.T @ forces if len(rows) else 0.0)
        size = float(np.abs(load * self.dynamics.units).max())
        return bool(np.abs((acceleration * self.dynamics.units)[parts]).max() <= BALANCED * size)


def bodies_motion(case: Case, rtol: float = 1e-13, times: Sequence[float] | np.ndarray = ()) -> PlatesMotion:
    """The motion of several plates from their start. Raises NotSupported for what these equations do not have."""
    if reason := without_certificate(case):
        raise NotSupported(reason)
    motion = BodiesSimulation(case, rtol)
    with np.errstate(all="ignore"):
        status = motion.simulate()
    return PlatesMotion(
        motion.impacts.all, status, motion.t,
        _sample(motion.stretches, np.asarray(times, dtype=float), motion),
    )  # fmt: skip


def _sample(stretches: Sequence[DenseStep], times: np.ndarray, motion: BodiesSimulation) -> np.ndarray:
    states = np.full((len(motion.body) + 1, len(times)), np.nan)
    starts = np.array([stretch.start for stretch in stretches])
    for i, t in enumerate(times.tolist()):
        if not stretches or t > motion.t:
            continue
        stretch = stretches[max(int(np.searchsorted(starts, t, side="right")) - 1, 0)]
        states[:-1, i] = stretch.states(t)
        for contact in stretch.phase.contacts:
            if contact.is_closed and _sides(contact) == {0}:
                still = contact.mode is Mode.ROLL or contact.name in cast(BodiesPhase, stretch.phase).frozen
                states[-1, i] = 0.0 if still else pair_at(contact.case, states[:-1, i], contact.pair).slip
                break
    return states
