"""Which modes follow: every combination of the touched contacts' modes is tried, and all consistent ones are compared.

A combination is consistent if its conditions hold just after the instant along its own motion (`minimal.decision`, by
series where values vanish). Several combinations that give the same accelerations are one motion; different ones are
reported as `not_unique`, none is chosen.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from cases import Case, Mode

from ..minimal.assembly import _MOTION
from ..minimal.decision import Undecidable, _by_series, follows
from ..minimal.effects import laws
from ..minimal.elimination import T
from . import forces
from .contact_law import slip_modes
from .geometry import ContactPlace
from .regimes import SeveralPhase, SeveralRegime, body_of, regime_of, several_phase

# Velocities below this part of the motion's largest speed are the roundings of a constraint that has just begun.
STILL = 1e-11
# Accelerations that differ by less than this part of the largest are the same motion: series decide with 1e-12.
SAME = 1e-7
# A gap below this part of the plate's size may be the rounding of none.
NEAR = 1e-9
# A load is balanced if the least weight is no more negative than its rounding.
BALANCED = -1e-11


class DecisionInstant(NamedTuple):
    """What a decision needs: time, state, the contacts' places, names and limits, which of them touch, the largest
    speed of the motion so far (m/s), and which contacts are arcs turned away from their supports."""

    time: float
    state: tuple[float, ...]
    places: Sequence[ContactPlace]
    names: tuple[str, ...]
    limits: tuple[float, ...]
    touching: tuple[int, ...]
    speed: float
    away: tuple[bool, ...]

    @property
    def pairs(self) -> tuple[int, ...]:
        """The number of each contact's pair."""
        return tuple(at.contact.number for at in self.places)


class SeveralDecision(NamedTuple):
    """The regime that follows; None if there is none or several, with their modes in `motions`."""

    regime: SeveralRegime | None
    motions: tuple[tuple[Mode, ...], ...]


def load_at(case: Case, t: float, body: Sequence[float] | np.ndarray) -> np.ndarray:
    """The applied force and moment (N, N, N m)."""
    from ..paper.augmented import applied_torsor

    return applied_torsor(case, (t, *body))


def decide(
    case: Case,
    now: DecisionInstant,
    error: float,
    fixed: dict[int, tuple[Mode, ...]] | None = None,
    may_rest: bool = True,
) -> SeveralDecision:
    """The regime that follows. `fixed` limits the modes of some contacts, by their places; `error` is the relative
    error of the state; a rest whose limit is reached may not go on. Raises Undecidable."""
    motions = consistent_motions(case, now, error, fixed, may_rest)
    if not motions:
        return SeveralDecision(None, ())
    if len(motions) > 1 and len(now.touching) > 1:
        return SeveralDecision(None, tuple(regimes[0].modes for regimes in motions))
    best = max(motions[0], key=lambda r: (r.rests, len(r.closed), _sticking(r)))
    return SeveralDecision(best, (best.modes,))


def consistent_motions(
    case: Case,
    now: DecisionInstant,
    error: float,
    fixed: dict[int, tuple[Mode, ...]] | None = None,
    may_rest: bool = True,
) -> list[list[SeveralRegime]]:
    """All motions that rigid Coulomb contact allows, each with every regime that gives its accelerations. Arguments as
    of `decide`. Raises Undecidable."""
    motions: list[tuple[SeveralRegime, np.ndarray]] = []
    for modes in product(*_options(now, fixed or {})):
        regime = SeveralRegime(modes, now.names, now.limits, now.pairs, now.away)
        rows = sum(2 if mode is Mode.ROLL else mode is not Mode.FLIGHT for mode in modes)
        if rows > 2:
            if not may_rest or not _rests(case, now, modes):
                continue
            motions.append((regime._replace(rests=True), np.zeros(3)))
            continue
        phase = several_phase(case, regime)
        if _is_consistent(case, now, phase, error) and _has_unique_force(phase, now):
            rates = phase.system.rates_of_numbers(now.time, now.state, phase.parameters)
            motions.append((regime, np.array(rates[-3:])))
    if any(now.places[k].stick > now.places[k].mu for k in now.touching):
        # With static friction a contact that may stick does.
        most = max((_sticking(regime) for regime, _ in motions), default=0)
        motions = [(regime, a) for regime, a in motions if _sticking(regime) == most]
    return _clusters(case, now, motions)


def _sticking(regime: SeveralRegime) -> int:
    """How many contacts do not slip."""
    return sum(mode is Mode.ROLL for mode in regime.modes)


def _options(now: DecisionInstant, fixed: dict[int, tuple[Mode, ...]]) -> list[tuple[Mode, ...]]:
    """The modes that each contact may have."""
    velocity, options = np.array(now.state[-3:]), list[tuple[Mode, ...]]()
    for k, at in enumerate(now.places):
        if k not in now.touching:
            options.append((Mode.FLIGHT,))
            continue
        slip, slipping = float(at.slip_row @ velocity), slip_modes(at.contact)
        rolling: tuple[Mode, ...] = (Mode.ROLL,) if at.stick > 0.0 else ()
        if k in fixed:
            options.append(fixed[k])
        elif abs(slip) <= STILL * now.speed or len(slipping) < 2:
            options.append((*rolling, *slipping, Mode.FLIGHT))
        else:
            options.append((slipping[0] if slip > 0.0 else slipping[1], Mode.FLIGHT))
    return options


def _rests(case: Case, now: DecisionInstant, modes: tuple[Mode, ...]) -> bool:
    """Whether these contacts hold the plate: it is still, cannot move, and their forces balance the load."""
    closed = [k for k, mode in enumerate(modes) if mode is not Mode.FLIGHT]
    slips = any(mode in (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD) for mode in modes)
    if slips or len(closed) < len(now.touching) or np.any(np.array(now.state[-3:])):
        return False
    some = [now.places[k] for k in closed]
    sticks = [now.places[k].stick if modes[k] is Mode.ROLL else 0.0 for k in closed]
    rows = [at.lift_row for at in some] + [at.slip_row for at, stick in zip(some, sticks, strict=True) if stick > 0.0]
    if np.linalg.matrix_rank(np.array(rows), tol=1e-9 * case.plate.reach) < 3:
        return False
    load = load_at(case, now.time, body_of(now.state))
    if not np.isfinite(load).all():
        raise Undecidable
    return forces.margin(some, load, forces.units_of(case.plate.gyration), sticks) >= BALANCED


def _is_consistent(case: Case, now: DecisionInstant, phase: SeveralPhase, error: float) -> bool:
    """Whether the conditions of a regime hold just after the instant along its own motion."""
    size = abs(now.state[0]) + abs(now.state[1]) + case.plate.reach
    near = [at.gap <= NEAR * size and not is_away for at, is_away in zip(now.places, now.away, strict=True)]
    if any(mode is Mode.FLIGHT and close for mode, close in zip(regime_of(phase).modes, near, strict=True)):
        return _by_series(phase, now.time, now.state, error)  # a gap has no size with which its value can be compared
    return follows(case, phase, now.time, now.state, error)


def _has_unique_force(phase: SeveralPhase, now: DecisionInstant) -> bool:
    """Whether the forces of a slip are unique: not beyond Painlevé's paradox."""
    names = list(phase.system.guards)
    if "painleve" not in names:
        return True
    values = phase.system.guards_of_numbers(now.time, now.state, phase.parameters)
    return bool(values[names.index("painleve")] != 0.0)


def _clusters(case: Case, now: DecisionInstant, motions) -> list[list[SeveralRegime]]:
    """Regimes with the same accelerations together."""
    units = np.array([1.0, 1.0, case.plate.gyration])
    load = np.abs(load_at(case, now.time, body_of(now.state)) / np.array([1.0, 1.0, case.plate.gyration])).max()
    clusters: list[tuple[np.ndarray, list[SeveralRegime]]] = []
    for regime, acceleration in motions:
        size = max(load / case.plate.mass, float(np.abs(acceleration * units).max()))
        for other, regimes in clusters:
            if np.abs((acceleration - other) * units).max() <= SAME * size:
                regimes.append(regime)
                break
        else:
            clusters.append((acceleration, [regime]))
    return [regimes for _, regimes in clusters]


def depends_on_time(case: Case) -> bool:
    """Whether the load on a plate at rest changes."""
    return any(T in e.symbols or _MOTION[0] in e.symbols for e in laws(case).torsor)
