"""Which modes follow: for each group of plates that touch, every combination of modes is tried.

Numbers exclude most combinations; those that are left must hold just after the instant along their own motion
(`minimal.decision`, by series where values vanish). Several combinations that give the same accelerations are one
motion; different ones are reported, none is chosen.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from itertools import product
from math import copysign
from typing import NamedTuple

import numpy as np

from cases import Case, Mode
from cases.curves.corner import Corner
from cases.own_effects import own_effects

from ..effect_laws.friction import STICKING
from ..minimal.decision import AT_BOUND, _by_series, follows, slack_of
from .accelerations import BALANCE, KINDS, SAME, DecisionInstant, GroupRows, resisting, rest_margin
from .mode_program import ContactRates, mode_combinations
from .places import ContactPlace, place, plates_in, sharing
from .plate_numbers import Sides, Turns, bodies, rows_of, speed, turning_row
from .regimes import Guides, SolverPhase, SolverRegime, is_straight, join, key_of, solver_phase
from .touching import name_of, touching_contacts

# Relative error of a state that is given by formulas: a few roundings of its numbers.
ERROR = 1e-14


class Decision(NamedTuple):
    """The modes of a group's contacts that follow, whether its plates rest, and the conditions on forces that vanish
    all the time with their slack, by (name of the condition, place of the contact); None if there are none or several.

    `motions`: the modes of each different motion that is consistent; `is_singular`: whether modes were left out because
    their forces are not unique; `turns`, `guides`: as of `SolverRegime`.
    """

    modes: tuple[Mode, ...] | None
    rests: bool
    slack: tuple[tuple[str, float], ...]
    motions: tuple[tuple[Mode, ...], ...]
    is_singular: bool
    turns: Turns = ()
    guides: Guides = ()


class _Motion(NamedTuple):
    modes: tuple[Mode, ...]
    rests: bool
    acceleration: np.ndarray
    turns: Turns = ()
    guides: Guides = ()


def decide(
    now: DecisionInstant, contacts: Sequence[ContactPlace], fixed: Mapping[int, tuple[Mode, ...]],
    last_modes: tuple[Mode, ...] | None = None, was_closed: Collection[int] = (),
) -> Decision:  # fmt: skip
    """The modes of one group's contacts that follow; `fixed` limits those of some, by their places. `last_modes`: those
    in which forces that are not unique have reached their limit; `was_closed`: the contacts that were closed just
    before. Raises Undecidable."""
    clusters, is_singular = _consistent(now, contacts, fixed, last_modes, was_closed)
    if len(clusters) != 1:
        return Decision(None, False, (), tuple(some[0].modes for some in clusters), is_singular)
    best = max(clusters[0], key=lambda one: (one.rests, _closed(one.modes), _sticking(one.modes)))
    slack: tuple[tuple[str, float], ...] = ()
    if not best.rests:
        of_best = GroupModes(best.modes, best.turns, best.guides)
        phase, y = phase_of(now.case, contacts, of_best), variables(now.state, contacts)
        slack = slack_of(phase, now.time, y, now.error, AT_BOUND * now.scale)
    return Decision(best.modes, best.rests, slack, (best.modes,), is_singular, best.turns, best.guides)


def motions_of(now: DecisionInstant, contacts: Sequence[ContactPlace]) -> list[tuple[Mode, ...]]:
    """The consistent motions, each as the contacts' modes, of several with the same accelerations those with the most
    contacts. Raises Undecidable."""
    clusters, _ = _consistent(now, contacts, {}, None)
    return [max(some, key=lambda one: _closed(one.modes)).modes for some in clusters]


def _consistent(
    now: DecisionInstant,
    contacts: Sequence[ContactPlace],
    fixed: Mapping[int, tuple[Mode, ...]],
    last_modes: tuple[Mode, ...] | None,
    was_closed: Collection[int] = (),
) -> tuple[list[list[_Motion]], bool]:
    """The consistent motions, those of the same accelerations together, and `Decision.is_singular`."""
    motions, is_singular, plates = list[_Motion](), False, plates_in(contacts)
    own = np.zeros(len(now.state) // 2, dtype=bool)
    own[rows_of(plates)] = True
    if last_modes is None and rest_margin(now.case, now.state, contacts, now.time) >= BALANCE:
        turns = tuple((sides, 0) for sides in resisting(contacts))
        stuck = [Mode.REST if (at.sides, 0) in turns else at.without_slip for at in contacts]
        still = tuple(mode if at.stick > 0.0 else Mode.SLIDE for at, mode in zip(contacts, stuck, strict=True))
        motions.append(_Motion(still, True, np.zeros(len(own)), turns))
    rows = GroupRows(now, contacts)
    for modes, turns, answer in rows.answers(list(_combinations(now, contacts, fixed, rows.rates))):
        if answer is None:
            is_singular = True
            continue
        some = [
            _Motion(modes, False, np.where(own, acceleration, 0.0), turns, answer.guides)
            for acceleration in (answer.acceleration, answer.another) if acceleration is not None
        ]  # fmt: skip
        if (
            answer.is_possible
            and not (answer.guides and modes == last_modes)
            and not _are_known(now, motions, some)
            and _holds(now, contacts, GroupModes(modes, turns, answer.guides), answer.opens)
        ):
            motions += some
    if any(at.stick > at.mu for at in contacts):
        # With static friction a contact that may stick does.
        most = max((_sticking(one.modes) for one in motions), default=0)
        motions = [one for one in motions if _sticking(one.modes) == most]
    # An effect of the user's own acts as long as its contact is closed: it holds a contact that could open without it.
    held = [k for k in was_closed if own_effects(contacts[k].pair.effects)]
    staying = [one for one in motions if all(one.modes[k] is not Mode.FLIGHT for k in held)]
    return _clusters(now, staying or motions), is_singular


def variables(state: Sequence[float], contacts: Sequence[ContactPlace]) -> tuple[float, ...]:
    """The variables of a phase with those contacts."""
    return join(state, [(at.xi1, at.xi2) for at in contacts])


def shares_of(contacts: Sequence[ContactPlace], modes: Sequence[Mode]) -> dict[int, int]:
    """Contacts that stick with the one that has the friction force of both."""
    sticking = [k for k, mode in enumerate(modes) if mode in STICKING]
    return {sticking[i]: sticking[j] for i, j in sharing([contacts[k] for k in sticking]).items()}


def flat_of(contacts: Sequence[ContactPlace], modes: Sequence[Mode]) -> dict[int, int]:
    """Closed contacts with the first one of the same straight side: plates do not turn against each other there."""
    closed = [
        k for k, (at, mode) in enumerate(zip(contacts, modes, strict=True))
        if mode is not Mode.FLIGHT and all(isinstance(one, Corner) or is_straight(one) for one in at.pair.pieces)
    ]  # fmt: skip
    return {closed[i]: closed[j] for i, j in sharing([contacts[k] for k in closed]).items()}


class GroupModes(NamedTuple):
    """The modes of a group's contacts, with `turns` and `guides` as of `SolverRegime`."""

    modes: tuple[Mode, ...]
    turns: Turns = ()
    guides: Guides = ()

    def some(self, which: Sequence[int]) -> GroupModes:
        """The same for some of the contacts."""
        guides = tuple(self.guides[k] for k in which) if self.guides else ()
        return self._replace(modes=tuple(self.modes[k] for k in which), guides=guides)


def phase_of(case: Case, contacts: Sequence[ContactPlace], now: GroupModes) -> SolverPhase:
    """The equations of contacts in those modes."""
    shares = {} if now.guides else shares_of(contacts, now.modes)
    keys = tuple(key_of(at.pair, (at.xi1, at.xi2)) for at in contacts)
    own, along = (tuple(some.get(k) for k in range(len(keys))) for some in (shares, flat_of(contacts, now.modes)))
    regime = SolverRegime(keys, now.modes, shares=own, turns=now.turns, guides=now.guides, along=along)
    return solver_phase(case, regime)


def _holds(now: DecisionInstant, contacts: Sequence[ContactPlace], some: GroupModes, opens: bool) -> bool:
    """Whether conditions hold just after the instant along the motion in these modes; `opens`: whether the contacts
    that open certainly do, so that only those that stay are looked at."""
    still, weak = now.still, AT_BOUND * now.scale
    if opens:
        which = [k for k, mode in enumerate(some.modes) if mode is not Mode.FLIGHT]
        if not which:
            return True
        closed = [contacts[k] for k in which]
        phase, y = phase_of(now.case, closed, some.some(which)), variables(now.state, closed)
        return follows(now.case, phase, now.time, y, now.error, still, weak)
    phase = phase_of(now.case, contacts, some)
    return _by_series(phase, now.time, variables(now.state, contacts), now.error, still, weak)


def _sticking(modes: Sequence[Mode]) -> int:
    return sum(mode in STICKING for mode in modes)


def _combinations(
    now: DecisionInstant, contacts: Sequence[ContactPlace], fixed: Mapping[int, tuple[Mode, ...]],
    rates: Callable[[], ContactRates | None],
) -> Iterator[tuple[tuple[Mode, ...], Turns]]:  # fmt: skip
    """The modes that all contacts may have, with the senses of the rotations that they resist; contacts with one slip
    have one mode where both are closed."""
    options, velocity = list[tuple[Mode, ...]](), now.velocity
    for k, at in enumerate(contacts):
        slip, slipping = at.slip(velocity, now.time), at.law.friction.slip_modes
        rolling: tuple[Mode, ...] = (at.without_slip,) if at.stick > 0.0 else ()
        if k in fixed:
            options.append(fixed[k])
        elif abs(slip) <= now.still or len(slipping) < 2:
            options.append((*rolling, *slipping, Mode.FLIGHT))
        else:
            options.append((slipping[0] if slip > 0.0 else slipping[1], Mode.FLIGHT))
    same = sharing(contacts).items()
    for modes in mode_combinations(rates, options, lambda k, mode: KINDS[mode]):
        if not all(modes[i] is modes[j] or Mode.FLIGHT in (modes[i], modes[j]) for i, j in same):
            continue
        closed = [at for at, mode in zip(contacts, modes, strict=True) if mode is not Mode.FLIGHT]
        pairs = resisting(closed)
        for senses in product(*(_senses(now, sides) for sides in pairs)):
            turns = tuple(zip(pairs, senses, strict=True))
            yield (
                tuple(
                    Mode.REST if mode in STICKING and (at.sides, 0) in turns else mode
                    for at, mode in zip(contacts, modes, strict=True)
                ),
                turns,
            )


def _senses(now: DecisionInstant, sides: Sides) -> tuple[int, ...]:
    """The senses in which a plate may turn against another one, or against what is fixed."""
    spin = float(turning_row(sides, len(now.velocity)) @ now.velocity)
    if abs(spin) * float(bodies(now.case).lengths[3 * sides[0] + 2]) > now.still:
        return (int(copysign(1.0, spin)),)
    return 0, 1, -1


def _closed(modes: tuple[Mode, ...]) -> int:
    return len(modes) - modes.count(Mode.FLIGHT)


def _are_known(now: DecisionInstant, motions: Sequence[_Motion], some: Sequence[_Motion]) -> bool:
    """Whether earlier modes with as many contacts closed, and as many without slip, have given these motions: they
    would be preferred."""
    return all(
        any(
            _closed(one.modes) <= _closed(other.modes)
            and _sticking(one.modes) <= _sticking(other.modes)
            and _is_same(now, one, other)
            for other in motions
        )
        for one in some
    )


def _is_same(now: DecisionInstant, one: _Motion, other: _Motion) -> bool:
    """Whether two accelerations are the same."""
    lengths, least = bodies(now.case).lengths, now.scale
    largest = max(float(np.abs(motion.acceleration * lengths).max()) for motion in (one, other))
    return bool(np.abs((one.acceleration - other.acceleration) * lengths).max() <= SAME * max(least, largest))


def _clusters(now: DecisionInstant, motions: Sequence[_Motion]) -> list[list[_Motion]]:
    """Modes with the same accelerations together."""
    clusters = list[list[_Motion]]()
    for motion in motions:
        for some in clusters:
            if _is_same(now, motion, some[0]):
                some.append(motion)
                break
        else:
            clusters.append([motion])
    return clusters


def motions_in(case: Case, state: Sequence[float]) -> list[dict[str, Mode]]:
    """The motions that may follow a state of all plates, each as the modes of the contacts that touch.

    `state`: x, y (m), θ of every plate, then vx, vy (m/s), ω. Modes that give the same accelerations are one motion,
    listed with the most contacts. No contact may close: an impact is no motion. Raises Undecidable, and DoesNotFit for
    points not found.
    """
    touching, names = list(touching_contacts(case, np.asarray(state, dtype=float))), list[str]()
    for pair, _ in touching:
        names.append(name_of(pair, set(names)))
    now = DecisionInstant(case, 0.0, tuple(map(float, state)), speed(case, state), ERROR)
    motions = motions_of(now, [place(pair, state, points) for pair, points in touching])
    return [dict(zip(names, modes, strict=True)) for modes in motions]
