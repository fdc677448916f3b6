"""Plates with the contacts that are watched, at one instant: states without roundings, and impacts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from cases import Case, Mode
from cases.curves.chain import Chain
from cases.curves.corner import Corner
from cases.scene.piece_case import PieceCase
from cases.scene.supports import TRACK

from ..effect_laws.restitution import creates_energy, impact_law
from ..endings import (
    CAUSES,
    ENERGY,
    LANDING_END,
    Ending,
    combination_limit_ending,
    no_impact_law,
    several_impacts,
)
from ..minimal.bouncing import is_unresolved
from ..scales import EPS, STILL, TOUCHES, speed_scale
from .hops import NestedSeries, Strike
from .impact import NoImpact, strike
from .mode_program import TooManyModes
from .places import (
    ContactPlace,
    couple_of,
    groups,
    in_round,
    place,
    plates_in,
    project,
    who_and_which,
    without_velocity,
)
from .plate_numbers import Sides, bodies, load_at, rows_of, size, speed
from .regimes import LOST
from .touching import SAME_PLACE, name_of, place_on_track

# A contact closes if it does so faster than this part of the largest speed so far; slower is rounding.
CLOSES = 1e-10
# A gap below this part of the plates' size is its rounding.
NO_GAP = 64 * EPS
# Velocities that follow from those of belts have a few roundings.
SOME_ROUNDINGS = 8


class MotionEnds(Exception):
    """The motion ends, with a status and a sentence."""

    def __init__(self, ending: Ending):
        super().__init__(ending[1])
        self.ending = ending


@dataclass
class Watch:
    """A contact: its name, pair of elements with their own parameters, mode, the clearance (1/m) at which it is lost
    while open, when it last passed to another element (s), whether it stays where two elements join, and the gap (m) up
    to which it is the only one of its plate; and its place in the state that was last asked for."""

    name: str
    pair: PieceCase
    points: tuple[float, float]
    mode: Mode = Mode.FLIGHT
    lost: float = 0.0
    pass_time: float = -1.0
    at_joint: bool = False
    room: float = 0.0
    last: tuple[PieceCase, tuple[float, ...], ContactPlace] | None = None

    def is_at(self, pair: PieceCase, points: tuple[float, float]) -> bool:
        """Whether it is of that pair at that place, in any round of closed curves."""
        return is_same_contact(self.pair, self.points, pair, points)


def is_same_contact(one: PieceCase, points: tuple[float, float], other: PieceCase, others: tuple[float, float]) -> bool:
    """Whether two contacts are one, in any round of closed curves: of one pair in one place, as curves may touch in
    several."""
    return (couple_of(one), in_round(one)) == (couple_of(other), in_round(other)) and any(
        not isinstance(piece, Corner) and np.hypot(*(piece.point(s) - piece.point(z))) <= SAME_PLACE * other.plate.reach
        for piece, s, z in zip(other.pieces, points, others, strict=True)
    )


class WatchedPlates:
    """The state of all plates at time t (s), the contacts that are watched, and which of them touch.

    `still`: plates that do not turn against each other, as rolling resistance has ended their rotation; `speed`: the
    largest so far, m/s; `impact_time`: of the last impact, s.
    """

    def __init__(self, case: Case, state: tuple[float, ...], hops: NestedSeries):
        self.case, self.t, self.state, self.half = case, 0.0, state, len(state) // 2
        self.watches, self.touching, self.still = list[Watch](), set[str](), list[Sides]()
        self.hops, self.causes, self.names = hops, dict[str, str](), dict[tuple[int, int], str]()
        self.impact_time = -inf
        reaches = bodies(case).reaches
        self.speed = speed_scale(float(np.abs(load_at(case, 0.0, state)).max()), min(reaches))

    @property
    def velocity(self) -> np.ndarray:
        """The velocities of all plates, (3n,)."""
        return np.array(self.state[self.half :])

    def _watch(self, pair: PieceCase, points: tuple[float, float]) -> Watch:
        """The watch of a pair at a place; a new one if there is none. At a joint of two elements both have one contact,
        that of the element which has just closed."""
        for watch in self.watches:
            if watch.is_at(pair, points):
                return watch
        for watch in self.watches:
            if watch.pair.whole == pair.whole and self._is_at_joint(watch, pair, points):
                if watch.mode is Mode.FLIGHT:
                    watch.pair, watch.points = pair, points
                return watch
        period = pair.pieces[0].period
        if period:  # in the first round, whichever the search came to
            points = points[0] - period * round(points[0] / period), points[1]
        watch = Watch(self._name_of(pair), pair, points)
        self.watches.append(watch)
        return watch

    def _name_of(self, pair: PieceCase) -> str:
        """The name of a contact that begins; elements of an outline keep theirs while they are not watched."""
        outline, used = pair.whole.plate.outline, {watch.name for watch in self.watches}
        if not isinstance(outline, Chain):
            return name_of(pair, used | set(self.names.values()))
        key = couple_of(pair).number, pair.second.number % len(outline.elements)
        if self.names.get(key, "") in used | {""}:
            self.names[key] = name_of(pair, used | set(self.names.values()))
        return self.names[key]

    @staticmethod
    def _is_at_joint(watch: Watch, pair: PieceCase, points: tuple[float, float]) -> bool:
        """Whether a contact is where its element joins that of another pair, at that pair's place."""
        off = place_on_track(watch.pair, watch.points[0]) - place_on_track(pair, points[0])
        return bool(np.abs(off).max() <= SAME_PLACE)

    def _places(self, some: Iterable[Watch]) -> list[ContactPlace]:
        """The contacts in the present state; their parameters are updated."""
        result = list[ContactPlace]()
        for watch in some:
            last = watch.last
            if last is None or last[0] is not watch.pair or last[1] is not self.state:
                last = watch.last = watch.pair, self.state, place(watch.pair, self.state, watch.points)
            watch.points = last[2].xi1, last[2].xi2
            result.append(last[2])
        return result

    def _closed(self) -> list[Watch]:
        return [watch for watch in self.watches if watch.name in self.touching]

    def _closing(self) -> set[str] | None:
        """The open contacts without a gap that close; None if there are none."""
        velocity, least = self.velocity, NO_GAP * size(self.case, self.state)
        some = [watch for watch in self.watches if watch.name not in self.touching]
        return {
            watch.name for watch, at in zip(some, self._places(some), strict=True)
            if at.gap <= least and float(at.lift_row @ velocity) < -CLOSES * self.speed
        } or None  # fmt: skip

    def _settle(self, stuck: set[str], closing: set[str] | None = None) -> None:
        """Remove errors of the integration: no gap at contacts that touch, and no velocity where there is none.

        `closing`: contacts that may have closed with a velocity, which is an impact, as may others without a gap; the
        velocities of those that touched before are no part of it. None: no contact has closed."""
        closed = self.touching - (closing or set())
        self.touching |= closing or set()
        for _ in range(len(self.watches) + 1):
            touching = self._closed()
            self.state, now = project(self.case, self.state, self._places(touching))
            if closing is None:
                break
            # Others without a gap close at the same instant, also where the projection has closed them.
            least, near = TOUCHES * size(self.case, self.state), self._places(self.watches)
            more = {watch.name for watch, at in zip(self.watches, near, strict=True) if at.gap <= least}
            if more <= self.touching:
                break
            self.touching |= more
        for watch, at in zip(touching, now, strict=True):
            watch.points, watch.last = (at.xi1, at.xi2), (watch.pair, self.state, at)
            watch.lost = LOST * at.clearance if np.isfinite(at.clearance) else 0.0  # also of one that rebounds
        self.speed = max(self.speed, speed(self.case, self.state))
        if closing is not None:
            contacts_before = [(watch, at) for watch, at in zip(touching, now, strict=True) if watch.name in closed]
            self._remove_velocities(contacts_before, stuck)
            stuck = self._impacts(touching, now, stuck)
        self._remove_velocities(
            [(watch, at) for watch, at in zip(touching, now, strict=True) if watch.name in self.touching], stuck
        )
        self._still([at for watch, at in zip(touching, now, strict=True) if watch.name in self.touching])

    def _remove_velocities(self, some: Sequence[tuple[Watch, ContactPlace]], stuck: set[str]) -> None:
        sticking = [at for watch, at in some if watch.name in stuck]
        places_of = [at for _, at in some]
        self.state = without_velocity(self.case, self.t, self.state, places_of, sticking, self.still)

    def _still(self, some: Sequence[ContactPlace]) -> None:
        """Take velocities that are roundings from plates that touch: decisions, and contacts at the joint of two
        elements, would see a motion in them."""
        velocity, lengths = self.velocity, bodies(self.case).lengths
        own = rows_of(plates_in(some))
        small = np.abs(velocity[own] * lengths[own]) <= SOME_ROUNDINGS * EPS * self.speed
        velocity[own] = np.where(small, 0.0, velocity[own])
        self.state = (*self.state[: self.half], *velocity.tolist())

    def _impacts(self, touching: Sequence[Watch], now: Sequence[ContactPlace], stuck: set[str]) -> set[str]:
        """Apply the impacts of all groups with a contact that closes; returns the contacts that do not slip, and leaves
        those that open out of `touching`. A contact that opens has no impulse; where it would close at the same
        instant, it is hit together with the others."""
        state, present, causes, still, hit = self.state, set(self.touching), dict(self.causes), self.still, set[str]()
        for _ in range(len(touching) + 1):
            sticking, strikes = self._impacts_once(touching, now, stuck, hit)
            velocity = self.velocity
            again = {
                watch.name
                for watch, at in zip(touching, now, strict=True)
                if float(at.lift_row @ velocity) < -CLOSES * self.speed
            } - hit
            if not again:
                break
            hit |= again
            self.state, self.touching, self.causes, self.still = state, present | hit, dict(causes), still
        if strikes:
            self.impact_time = self.t
            every = frozenset(name for names, _, _ in strikes for name in names)
            closers_all = frozenset(name for _, closing_names, _ in strikes for name in closing_names)
            self.hops.strike(Strike(self.t, self.state, max(fastest for *_, fastest in strikes), every, closers_all))
        return sticking

    def _impacts_once(
        self, touching: Sequence[Watch], now: Sequence[ContactPlace], stuck: set[str], hit: set[str]
    ) -> tuple[set[str], list[tuple[list[str], list[str], float]]]:
        """The contacts that do not slip after the impacts of all groups, and of each impact its contacts, those that
        closed, and the fastest closing speed; `hit`: contacts that are hit although they open."""
        staying, sticking = set[str](), set[str]()
        strikes: list[tuple[list[str], list[str], float]] = []
        present = [k for k, watch in enumerate(touching) if watch.name in self.touching]
        for places_of_group in groups([now[k] for k in present]):
            group = [present[i] for i in places_of_group]
            velocity = self.velocity
            lifts = {k: float(now[k].lift_row @ velocity) for k in group}
            closing = [k for k in group if lifts[k] < -CLOSES * self.speed]
            near = [k for k in group if lifts[k] <= CLOSES * self.speed or touching[k].name in hit]
            if not closing:
                still = STILL * self.speed
                staying |= {touching[k].name for k in near}
                sticking |= {
                    touching[k].name for k in near
                    if touching[k].name in stuck or abs(now[k].slip(velocity, self.t)) <= still
                }  # fmt: skip
                continue
            for part_places in groups([now[k] for k in near]):  # contacts that part already share no impulses
                part = [near[i] for i in part_places]
                part_closing = [k for k in part if k in closing]
                names = [touching[k].name for k in part]
                if not part_closing:
                    staying, sticking = staying | set(names), sticking | (set(names) & stuck)
                    continue
                closed = {touching[k].name for k in part_closing} | (hit & set(names))
                stays, sticks = self._strike([now[k] for k in part], names, closed)
                staying, sticking = staying | stays, sticking | sticks
                closers = [touching[k].name for k in part_closing]
                strikes.append((names, closers, max(-lifts[k] for k in part_closing)))
        self.touching = staying
        return sticking, strikes

    def _no_impact(self, at: ContactPlace) -> Ending:
        couple = couple_of(at.pair)
        who, which = who_and_which(couple)
        alone = not self.case.others and couple.pair_name.endswith(f"/{TRACK}")
        xi1 = float(couple.whole_xi1(at.pair.to_whole(at.xi1, at.xi2)[0]))
        flew = all(watch.mode is Mode.FLIGHT for watch in self.watches)
        if flew and alone:
            return LANDING_END
        which += " in a second place" * alone
        return no_impact_law(self.t, who, which, xi1, flew or bool(self.case.others))

    def _strike(
        self, part: Sequence[ContactPlace], names: Sequence[str], closing: set[str]
    ) -> tuple[set[str], set[str]]:
        """The impact of one group: the contacts that stay closed, and those that do not slip."""
        law, some = impact_law(self.case), bodies(self.case)
        if not law:
            raise MotionEnds(self._no_impact(next(at for at, name in zip(part, names, strict=True) if name in closing)))
        before = self.velocity
        try:
            outcome = strike(self.case, self.t, before, part, self.speed)
        except NoImpact as problem:
            raise MotionEnds(several_impacts(self.t, problem)) from problem
        except TooManyModes as problem:
            raise MotionEnds(combination_limit_ending(self.t, names)) from problem
        mass = some.masses
        if creates_energy(law, mass @ before**2, mass @ outcome.velocity**2):
            raise MotionEnds(ENERGY)
        self.state, plates = (*self.state[: self.half], *outcome.velocity.tolist()), plates_in(part)
        self.still = [*(sides for sides in self.still if not plates & set(sides)), *outcome.still]
        stays, sticks, load = set[str](), set[str](), load_at(self.case, self.t, self.state)
        far = size(self.case, self.state)
        for i, (at, name) in enumerate(zip(part, names, strict=True)):
            lift = float(outcome.lift[i])
            if name in closing:
                self.causes[name] = CAUSES["landing"]
            if lift > 0.0 and not is_unresolved(lift, max(-float(at.lift_row @ load), 0.0), far):
                continue
            if lift > 0.0:
                self.causes[name] = CAUSES["rest"]
            stays.add(name)
            if outcome.slip[i] == 0.0:
                sticks.add(name)
        return stays, sticks
