"""A plate with its watched contacts in numbers: which touch, and the removal of roundings from gaps and velocities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from cases import Belt, Case, Mode
from cases.contact import clearance
from cases.scene.contact_names import FIRST, contact_name
from cases.scene.contact_pairs import PairCase, WatchedPair, facing_pairs, pairs
from cases.scene.free_plates import plates_of
from cases.scene.piece_case import PieceCase, corner_on_corner, is_concave
from cases.scene.supports import TRACK

from .contacts import AnyPair, PairState, PlateDynamics, Sides, is_of_couple, pair_at
from .phase import WatchedContact
from .watched_pairs import piece_end

EPS = float(np.finfo(float).eps)
# A contact touches if its gap is below this part of the plate's size.
TOUCHES = 1e-12
# The names of contacts that have not touched yet begin with this.
OPEN_NAME = "open "


class SimulationEnd(Exception):
    """The motion ends with a status."""


class PlateState:
    """The plate (x, y, θ, vx, vy, ω) at time t (s), its watched contacts, and which of them touch or do not slip."""

    def __init__(self, case: Case, t: float, body: Sequence[float] | np.ndarray):
        self.case, self.dynamics = case, PlateDynamics(case)
        self.t, self.body = t, np.array(body, dtype=float)
        self.half = len(self.body) // 2  # velocities follow the positions
        self.contacts: list[WatchedContact] = []
        self.speed = 0.0
        self.touching: set[str] = set()
        self.stuck: set[str] = set()
        self.leaving: set[str] = set()
        self.is_several = False  # whether two contacts have touched at once
        self.still: set[Sides] = set()  # plates whose rotation against each other rolling resistance has ended

    def pairs(self) -> list[PairState]:
        """All contacts in this state; their points are updated."""
        now = [contact.at(self.t, self.body, contact.pair) for contact in self.contacts]
        self.contacts = [c._replace(pair=(p.xi1, p.xi2)) for c, p in zip(self.contacts, now, strict=True)]
        return now

    def size(self) -> float:
        """The size of the poses' numbers, m."""
        centres = np.abs(self.body[: self.half].reshape(-1, 3)[:, :2]).sum(axis=1)
        return float(max(far + p.reach for far, p in zip(centres, plates_of(self.case), strict=True)))

    def surface_speed(self, t: float) -> float:
        """The largest speed of the closed contacts' surfaces at a time (s), m/s: slips are differences from it."""
        belts = [c.case.effect(Belt) for c in self.contacts if c.is_closed]
        return max((abs(belt.at(t)[0]) for belt in belts if belt is not None), default=0.0)

    def add(self, case: AnyPair, pair: tuple[float, float]) -> None:
        """Add a contact that touches."""
        name = self.free_name(case)
        self.contacts.append(WatchedContact(name, case, pair, Mode.FLIGHT))
        self.touching.add(name)

    def free_name(self, case: AnyPair) -> str:
        """The name of a further contact with that support."""
        used = {contact.name for contact in self.contacts}
        support = TRACK if isinstance(case, PieceCase) else case.support
        names = (contact_name(FIRST, support, i) for i in range(1, len(used) + 2))
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

    def turn(self, name: str) -> None:
        """An arc has turned to its support, or away from it. A contact that lies at the end of the arc's range goes to
        the feature there, or comes from it, with its name and mode."""
        place = next(k for k, contact in enumerate(self.contacts) if contact.name == name)
        arc = self.contacts[place]
        if isinstance(arc.case, PieceCase):
            self.pass_on(place, arc)
            return
        number, follower = arc.case.number, arc.case.successor(arc.pair[1])
        xi2 = arc.case.in_round(arc.pair[1], not arc.is_away)
        is_away = arc.case.after_turn(arc.is_away, xi2, pair_at(arc.case, self.body, arc.pair).gap)
        every = {cast(PairCase, contact.case).number: contact for contact in self.contacts}
        every[number] = arc._replace(pair=(arc.pair[0], xi2), is_away=is_away)
        x, y, theta = self.body[:3].tolist()
        for pair in pairs(self.case):
            if pair.number not in every:
                near = pair.guess(x, y, theta)
                is_away = 0 if pair == follower else pair.away_in_pose(x, y, theta, near)
                every[pair.number] = WatchedContact(f"{OPEN_NAME}{pair.number}", pair, near, Mode.FLIGHT, is_away)
        if follower is not None and follower.number in every:
            giver, heir = (arc.case, follower) if not arc.is_away else (follower, arc.case)
            old = every[giver.number]
            if old.is_closed:
                every[heir.number] = every[heir.number]._replace(name=old.name, mode=old.mode)
                every[giver.number] = old._replace(name=f"{OPEN_NAME}{giver.number}", mode=Mode.FLIGHT)
        if not arc.is_away:
            every[number] = every[number]._replace(name=f"{OPEN_NAME}{number}")
        facing = facing_pairs([WatchedPair(cast(PairCase, c.case), c.pair, c.is_away) for c in every.values()])
        self.contacts = [every[one.pair.number] for one in sorted(facing, key=lambda one: one.pair.number)]

    def pass_on(self, place: int, contact: WatchedContact) -> None:
        """A contact has reached an end of its piece of one curve: it goes on on the next one, or leaves a corner from
        which another points away."""
        assert isinstance(contact.case, PieceCase)
        end = piece_end(contact.case, contact.pair)
        assert end.following is not None
        is_couple = is_of_couple(contact.case)
        if corner_on_corner(end.following) and not is_couple:
            self.leaving.add(contact.name)
        elif not is_couple and (is_concave(end.following) or not clearance(end.following, *end.points) > 0.0):
            raise SimulationEnd("second_contact")
        else:
            self.contacts[place] = contact._replace(case=end.following, pair=end.points)

    def close_gaps(self) -> None:
        """Move the plate so that the touching contacts have no gap."""
        for _ in range(4):
            now = self.pairs()
            some = [p for p, c in zip(now, self.contacts, strict=True) if c.name in self.touching]
            if some:
                rows = np.array([p.lift_row for p in some]) / self.dynamics.units * self.dynamics.moves
                step = np.linalg.lstsq(rows, np.array([p.gap for p in some]), rcond=1e-10)[0]
                self.body[: self.half] -= step / self.dynamics.units

    def turning_rows(self, now: Sequence[PairState], some: set[Sides]) -> list[np.ndarray]:
        """The rows of the rotations of these plates against each other."""
        return list({pair.sides: pair.turning_row for pair in now if pair.sides in some}.values())

    def hold(self) -> None:
        """No velocity along the rows that are held, relative to the supports' surfaces."""
        now = self.pairs()
        touching = [p for p, c in zip(now, self.contacts, strict=True) if c.name in self.touching]
        sticking = [p for p, c in zip(now, self.contacts, strict=True) if c.name in self.stuck & self.touching]
        turning = self.turning_rows(now, self.still)
        rows = np.array([p.lift_row for p in touching] + [p.slip_row for p in sticking] + turning)
        if not rows.size:
            return
        rows, goals = (
            rows / self.dynamics.units * self.dynamics.moves,
            np.array([0.0] * len(touching) + [p.surface for p in sticking] + [0.0] * len(turning)),
        )
        is_held = np.linalg.matrix_rank(rows, tol=1e-9) == np.count_nonzero(self.dynamics.inverse)
        if is_held and not goals.any():
            self.body[self.half :] = 0.0
            return
        velocity = self.body[self.half :] * self.dynamics.units
        off = np.abs(rows @ velocity - goals).max()
        if off > 4.0 * EPS * np.abs(velocity).max():  # otherwise only roundings would change
            for _ in range(2):
                velocity = velocity - np.linalg.lstsq(rows, rows @ velocity - goals, rcond=1e-10)[0]
            self.body[self.half :] = velocity / self.dynamics.units
