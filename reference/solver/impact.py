"""Impacts of plates that touch in several places: modes of impulses by enumeration.

Normal impulses P ≥ 0 and velocities after the impact obey v_n⁺ + e v_n⁻ ≥ 0, complementary to P, at every contact that
is touched, and friction Coulomb's law between whole impulses and velocities after the impact. Poisson's law has two
stages: e = 0, then impulses of at least e times those of the first. Rolling resistance adds impulses of couples, of the
arm times P against the rotation of the plates against each other after the impact, or, if there is none, of at most
that. Where one plate touches in one place, Routh's construction of `minimal.impact` is used instead (`strike`).
(Derived here; the laws differ where several contacts are touched.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations, islice
from math import inf, nan
from typing import NamedTuple

import numpy as np

from cases import Case

from ..effect_laws.restitution import impact_law
from ..minimal.impact import ContactVelocity, collide, law_of
from ..scales import power_of_two
from . import mode_program
from .exclusion import TOGETHER, ImpactModes, impact_exclusions
from .impact_modes import (
    BACKWARD,
    FORWARD,
    OPEN,
    ROUNDING,
    SIGN,
    STICK,
    ImpactLaw,
    ImpactVelocities,
    LeastSenses,
    TouchedContact,
    in_modes,
    senses_of_least,
)
from .mode_program import ContactRates, mode_combinations
from .places import ContactPlace, couple_of
from .plate_numbers import Sides, Turns, bodies, senses_of, turning_row

# The modes of all contacts, the senses of the rotations that they resist, and of the friction of least impulses.
ImpactCombination = tuple[tuple[str, ...], Turns, LeastSenses]
_KINDS = {OPEN: mode_program.OPEN, STICK: mode_program.STICKS, FORWARD: 1, BACKWARD: -1}


class NoImpact(ArithmeticError):
    """No impulses agree with the law of impact, or several do with different velocities after it."""


class Inertia(NamedTuple):
    """Of all velocities: the inverse masses, in units of one of them, and the lengths (m; 1 for translations) by which
    they are compared."""

    inverse: np.ndarray
    lengths: np.ndarray


def impact_of_all(
    law: str,
    inertia: Inertia,
    before: np.ndarray,
    contacts: Sequence[TouchedContact],
    mu: Sequence[float],
    speed: float,
    belts: np.ndarray | None = None,
    arms: np.ndarray | None = None,
) -> ImpactVelocities:
    """The velocities of one or several bodies after an impact at all touched contacts: by Newton's, Moreau's or
    Poisson's law ("newton", "moreau", "poisson") for whole impulses. `mu`: the coefficient of friction of each;
    `belts`: the speeds of the supports' surfaces (m/s; None: at rest); `arms`: those of the rolling resistance (m;
    None: there is none). Arguments and errors as of `impact`."""
    mu, nothing = list(mu), np.zeros(len(contacts))
    belts, arms = (nothing if some is None else some for some in (belts, arms))
    # A contact that opens before the impact has nothing to give back.
    is_opening = [float(at.lift_row @ before) > ROUNDING * speed for at in contacts]
    restitution = np.where(is_opening, 0.0, [at.restitution for at in contacts])
    if law != "poisson":
        return _collide(inertia, before, contacts, ImpactLaw(restitution, nothing, mu, belts, arms), speed)[0]
    compressed, impulses = _collide(inertia, before, contacts, ImpactLaw(nothing, nothing, mu, belts, arms), speed)
    if not restitution.any():
        return compressed
    second = ImpactLaw(nothing, restitution * impulses, mu, belts, arms)
    return _collide(inertia, compressed.velocity, contacts, second, speed)[0]


def _collide(
    inertia: Inertia, before: np.ndarray, places_hit: Sequence[TouchedContact], law: ImpactLaw, speed: float
) -> tuple[ImpactVelocities, np.ndarray]:
    """The outcome by enumeration, and the normal impulses, of a plate per mass."""
    options = [
        [OPEN, FORWARD] if mu == 0.0 else [OPEN, STICK] if mu == inf else [STICK, FORWARD, BACKWARD, OPEN]
        for mu in law.mu
    ]
    solutions: list[tuple[ImpactVelocities, np.ndarray]] = []
    law, known = law._replace(gyration=inertia.lengths[2]), set[tuple]()
    alike, hit = _with_one_slip(inertia, places_hit, law), _Hit.of(before, places_hit, law)

    def kind(k: int, mode: str) -> int:
        return _KINDS[mode] if law.mu[k] or mode == OPEN else 0

    possible = (
        (modes, turns, senses) for modes in mode_combinations(partial(hit.rates, inertia, law, speed), options, kind)
        if all(modes[i] == modes[j] or OPEN in (modes[i], modes[j]) for i, j in alike)
        for turns in _turns(modes, places_hit, law)
        for senses in senses_of_least(modes, law)
    )  # fmt: skip
    for modes, turns, senses in _possible(possible, inertia, hit, law, speed):
        if (modes, turns) in known:
            continue
        some = in_modes(modes, before, places_hit, law._replace(turns=turns), senses, inertia.inverse, speed)
        if some:
            known.add((modes, turns))
        for one in some:
            if all(_differ(one[0], other[0], inertia.lengths, speed) for other in solutions):
                solutions.append(one)
    if len(solutions) != 1:
        count = "no" if not solutions else f"{len(solutions)} different"
        raise NoImpact(f"{count} velocities after the impact agree with its law")
    return solutions[0]


class _Hit(NamedTuple):
    """What all combinations of an impact's modes share: the rotations that n contacts resist, the rows (2n + r, 3N) of
    lift and slip velocities and of these rotations, the velocities along them before the impact, and the arms (n, r) of
    the contacts' resistance."""

    resisting: list[Sides]
    rows: np.ndarray
    before: np.ndarray
    arms: np.ndarray

    @classmethod
    def of(cls, before: np.ndarray, places_hit: Sequence[TouchedContact], law: ImpactLaw) -> _Hit:
        """Those of an impact; `before`: the velocities of all plates, (3N,)."""
        both = list(zip(places_hit, law.arms.tolist(), strict=True))
        resisting = list(dict.fromkeys(at.sides for at, arm in both if arm))
        turning = [law.gyration * turning_row(sides, len(before)) for sides in resisting]
        rows = np.array([at.lift_row for at in places_hit] + [at.slip_row for at in places_hit] + turning)
        velocities = rows @ before
        velocities[len(places_hit) : 2 * len(places_hit)] -= law.belts
        return cls(
            resisting, rows, velocities, np.array([[arm * (at.sides == s) for s in resisting] for at, arm in both])
        )

    def rates(self, inertia: Inertia, law: ImpactLaw, speed: float) -> ContactRates:
        """What impulses do: a contact that stays has no velocity of lift above that of its rebound."""
        free, mu, n = self.before.copy(), np.array(law.mu), len(law.mu)
        free[:n] *= 1.0 + law.restitution
        delassus = self.rows * inertia.inverse @ self.rows.T
        arms, begins = self.arms.reshape(n, -1).T / law.gyration, np.ones(n, dtype=bool)
        sizes = np.sqrt(np.diag(delassus)[:n])
        rate = max(ROUNDING * speed, *(-free[:n] / sizes), *(law.least * sizes))
        return ContactRates(delassus, free, law.least, mu, mu, arms, begins, rate)


def _possible(
    modes: Iterator[ImpactCombination], inertia: Inertia, hit: _Hit, law: ImpactLaw, speed: float
) -> Iterator[ImpactCombination]:
    """The combinations, with the senses of resisted rotations and of the friction of least impulses, that their
    impulses and velocities do not exclude."""
    while some := list(islice(modes, TOGETHER)):
        without = impact_exclusions(
            _as_arrays(some, hit.resisting, law), inertia.inverse, hit.rows, hit.before, law.restitution, law.least,
            np.array(law.mu), hit.arms, law.gyration, ROUNDING * speed,
        )  # fmt: skip
        yield from (one for one, is_out in zip(some, without, strict=True) if not is_out)


def _as_arrays(some: Sequence[ImpactCombination], resisting: Sequence[Sides], law: ImpactLaw) -> ImpactModes:
    """The combinations as arrays."""
    closed = np.array([[mode != OPEN for mode in modes] for modes, _, _ in some])
    signs = np.array([[SIGN.get(mode, 0.0) for mode in modes] for modes, _, _ in some]) * (np.array(law.mu) > 0.0)
    sticking = np.array([[mode == STICK for mode in modes] for modes, _, _ in some])
    for i, (_, _, senses) in enumerate(some):
        for k, sense in senses:
            signs[i, k], sticking[i, k] = sense, sense == 0.0
    turning = np.array([[dict(turns).get(sides, nan) for sides in resisting] for _, turns, _ in some])
    return ImpactModes(closed, sticking, signs, turning)


def _turns(modes: Sequence[str], places_hit: Sequence[TouchedContact], law: ImpactLaw) -> list[Turns]:
    """The senses of the rotations that contacts with impulses in these modes resist."""
    resisting = dict.fromkeys(
        at.sides for at, mode, arm, least in zip(places_hit, modes, law.arms, law.least, strict=True)
        if arm and (mode != OPEN or least > 0.0)
    )  # fmt: skip
    return [tuple(zip(resisting, some, strict=True)) for some in senses_of(tuple(resisting))]


def _with_one_slip(inertia: Inertia, places_hit: Sequence[TouchedContact], law: ImpactLaw) -> list[tuple[int, int]]:
    """The pairs of contacts that always have one slip, as two corners of a plate on one line."""
    rows = np.array([at.slip_row / inertia.lengths for at in places_hit])
    return [
        (i, j) for i, j in combinations(range(len(rows)), 2)
        if np.abs(rows[i] - rows[j]).max() <= ROUNDING and law.belts[i] == law.belts[j] and law.mu[i] and law.mu[j]
    ]  # fmt: skip


def _differ(one: ImpactVelocities, other: ImpactVelocities, lengths: np.ndarray, speed: float) -> bool:
    off = np.abs((one.velocity - other.velocity) * lengths).max()
    return bool(off > 1e-8 * speed)


def strike(case: Case, t: float, velocity: np.ndarray, part: Sequence[ContactPlace], speed: float) -> ImpactVelocities:
    """The velocities (3n,) after an impact at time t (s) at all contacts of a group: by Routh's construction where one
    plate touches what is fixed in one place, else by the law for whole impulses. Raises NoImpact."""
    some = bodies(case)
    if len(part) == 1 and couple_of(part[0].pair).base is None:
        return _at_one_contact(t, velocity, part[0])
    belts, arms = (np.array(each) for each in zip(*((at.belt(t), at.resisting_arm) for at in part), strict=True))
    mu = [at.mu_of(velocity, t) for at in part]
    # Impulses in units of the lightest plate's mass are velocities, and have their rounding.
    inverse = some.inverse / power_of_two(float(some.inverse.reshape(-1, 3)[:, 0].max()))
    return impact_of_all(impact_law(case), Inertia(inverse, some.lengths), velocity, list(part), mu, speed, belts, arms)


def _at_one_contact(t: float, velocity: np.ndarray, at: ContactPlace) -> ImpactVelocities:
    body = couple_of(at.pair).body
    own = slice(3 * body, 3 * body + 3)
    (tx, ty), ht, hn = at.tangent, float(at.lift_row[own][2]), -float(at.slip_row[own][2])
    before = ContactVelocity(at.slip(velocity, t), float(at.lift_row @ velocity), float(velocity[own][2]))
    slip, lift, omega = collide(law_of(at.pair, ht, hn, before.slip), before)
    # The centre of mass follows from the contact's point, at the arm h.
    along, across = slip + at.belt(t) + omega * hn, lift - omega * ht
    after = velocity.copy()
    after[own] = along * tx - across * ty, along * ty + across * tx, omega
    still = (at.sides,) if omega == 0.0 and at.resisting_arm else ()
    return ImpactVelocities(after, np.array([lift]), np.array([slip]), still)
