"""Which modes follow: every combination of the touched contacts' modes is tried, and all consistent ones are compared.

A combination is consistent if its conditions hold just after the instant along its own motion (`minimal.decision`, by
series where values vanish). Several combinations that give the same accelerations are one motion; different ones are
reported as `not_unique`, none is chosen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import copysign, inf
from typing import NamedTuple

import numpy as np

from cases import Belt, Case, Mode

from ..minimal.assembly import _MOTION, PAINLEVE_LEAST
from ..minimal.decision import AT_BOUND, SLACK, Undecidable, _by_series, follows, slack_of
from ..minimal.effects import SLIP_SIGN, laws
from ..minimal.elimination import T
from ..minimal.grazing import depth_of_dip
from ..minimal.integrators.segment import Segment
from ..minimal.phase_end import LOCATION_ERROR
from ..scales import acceleration_scale, power_of_two
from . import forces
from .contact_law import STICKING, compliance, freedoms, slip_modes
from .equations import COLUMNS, FIRST_COLUMN
from .geometry import TOUCHES, TURNING_ROW, ContactPlace
from .regimes import SeveralPhase, SeveralRegime, body_of, regime_of, several_phase

# Velocities below this part of the motion's largest speed are the roundings of a constraint that has just begun.
STILL = 1e-11
# Accelerations that differ by less than this part of the largest are the same motion: series decide with 1e-12.
SAME = 1e-7
# A gap below this part of the plate's size may be the rounding of none.
NEAR = 1e-9
# Rows, in units of the radius of gyration, with a smaller singular value than this depend on each other.
INDEPENDENT = 1e-9
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
    away: tuple[int, ...]

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
    last_modes: tuple[Mode, ...] | None = None,
) -> SeveralDecision:
    """The regime that follows. `fixed` limits the modes of some contacts, by their places; `error` is the relative
    error of the state. `last_modes`: the modes of contacts whose forces have reached their limit; these may not go on,
    and no rest follows. Raises Undecidable."""
    motions = consistent_motions(case, now, error, fixed, last_modes)
    if not motions:
        return SeveralDecision(None, ())
    if len(motions) > 1 and len(now.touching) > 1:
        return SeveralDecision(None, tuple(regimes[0].modes for regimes in motions))
    best = max(motions[0], key=lambda r: (r.has_open_forces, len(r.closed), _sticking(r)))
    return SeveralDecision(best, (best.modes,))


def consistent_motions(
    case: Case,
    now: DecisionInstant,
    error: float,
    fixed: dict[int, tuple[Mode, ...]] | None = None,
    last_modes: tuple[Mode, ...] | None = None,
) -> list[list[SeveralRegime]]:
    """All motions that rigid Coulomb contact allows, each with every regime that gives its accelerations. Arguments as
    of `decide`. Raises Undecidable."""
    motions: list[tuple[SeveralRegime, np.ndarray]] = []
    singular: list[SeveralRegime] = []
    most = freedoms(case.plate)
    for modes, turn in _combinations(case, now, fixed or {}):
        regime = SeveralRegime(modes, now.names, now.limits, now.pairs, now.away, turn=turn)
        rows = sum(2 if mode in STICKING else mode is not Mode.FLIGHT for mode in modes) + (turn == 0)
        if rows > 2 and not _is_on_belt(now, modes):
            if last_modes is not None or not _rests(case, now, modes, turn):
                continue
            motions.append((regime._replace(rests=True), np.zeros(3)))
            continue
        if rows > 2:
            guides = _guides(case, now, modes)
            if guides is None or (rows > most and modes == last_modes):
                continue
            regime = regime._replace(guides=guides if rows > most else ())
        if not regime.has_open_forces and _is_singular(case, now, regime):
            if not _is_smooth(case, now, regime):
                singular.append(regime)
                continue
            regime = regime._replace(guides=_independent_rows(case, now, modes))
        phase = several_phase(case, regime)
        if _is_consistent(case, now, phase, error) and _has_forces(phase, now):
            rates = phase.system.rates_of_numbers(now.time, now.state, phase.parameters)
            motions.append((regime, np.array(rates[-3:])))
    for regime in singular:
        motions += _braced(case, now, regime, motions)
    if any(now.places[k].stick > now.places[k].mu for k in now.touching):
        # With static friction a contact that may stick does.
        most = max((_sticking(regime) for regime, _ in motions), default=0)
        motions = [(regime, a) for regime, a in motions if _sticking(regime) == most]
    return _clusters(case, now, motions)


def _sticking(regime: SeveralRegime) -> int:
    """How many contacts do not slip."""
    return sum(mode in STICKING for mode in regime.modes)


def _combinations(
    case: Case, now: DecisionInstant, fixed: dict[int, tuple[Mode, ...]]
) -> Iterator[tuple[tuple[Mode, ...], int | None]]:
    """The modes of all contacts with the sense of the plate's rotation (`SeveralRegime.turn`), 0 first."""
    omega = now.state[-1]
    turns = (int(copysign(1.0, omega)),) if abs(omega) * case.plate.gyration > STILL * now.speed else (0, 1, -1)
    for modes in product(*_options(now, fixed)):
        resists = any(mode is not Mode.FLIGHT and at.resisting_arm for at, mode in zip(now.places, modes, strict=True))
        for turn in turns if resists else (None,):
            yield tuple(Mode.REST if mode in STICKING and turn == 0 else mode for mode in modes), turn


def _options(now: DecisionInstant, fixed: dict[int, tuple[Mode, ...]]) -> list[tuple[Mode, ...]]:
    """The modes that each contact may have."""
    velocity, options = np.array(now.state[-3:]), list[tuple[Mode, ...]]()
    for k, at in enumerate(now.places):
        if k not in now.touching:
            options.append((Mode.FLIGHT,))
            continue
        slip, slipping = at.slip(velocity, now.time), slip_modes(at.contact)
        rolling: tuple[Mode, ...] = (Mode.ROLL,) if at.stick > 0.0 else ()
        if k in fixed:
            options.append(fixed[k])
        elif abs(slip) <= STILL * now.speed or len(slipping) < 2:
            options.append((*rolling, *slipping, Mode.FLIGHT))
        else:
            options.append((slipping[0] if slip > 0.0 else slipping[1], Mode.FLIGHT))
    return options


def _rests(case: Case, now: DecisionInstant, modes: tuple[Mode, ...], turn: int | None) -> bool:
    """Whether these contacts hold the plate: it is still, cannot move, and their forces balance the load."""
    closed = [k for k, mode in enumerate(modes) if mode is not Mode.FLIGHT]
    slips = any(mode in (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD) for mode in modes)
    if slips or turn or len(closed) < len(now.touching) or np.any(np.array(now.state[-3:])):
        return False
    some = [now.places[k] for k in closed]
    sticks = limits_of_friction(some, [modes[k] for k in closed], now.time, now.state)
    rows = [at.lift_row for at in some] + [now.places[k].slip_row for k in closed if modes[k] in STICKING]
    rows += [TURNING_ROW] if turn == 0 else []
    moving = np.array(rows)[:, : freedoms(case.plate)]
    if np.linalg.matrix_rank(moving, tol=1e-9 * case.plate.reach) < freedoms(case.plate):
        return False
    load = load_at(case, now.time, body_of(now.state))
    if not np.isfinite(load).all():
        raise Undecidable
    return forces.margin(some, load, forces.units_of(case.plate), sticks, limits_of_couples(some, turn)) >= BALANCED


def limits_of_friction(
    some: Sequence[ContactPlace], modes: Sequence[Mode], t: float, state: Sequence[float] | np.ndarray
) -> list[forces.Limit]:
    """What limits the friction of closed contacts in those modes, of a plate in that state."""
    velocity = np.array(state[-3:])
    limits: list[forces.Limit] = []
    for at, mode in zip(some, modes, strict=True):
        if mode in STICKING:
            limits.append(at.stick)
        else:
            limits.append(forces.Slipping(-SLIP_SIGN[mode] * at.mu_of(velocity, t)) if mode in SLIP_SIGN else 0.0)
    return limits


def limits_of_couples(some: Sequence[ContactPlace], turn: int | None) -> list[forces.Limit]:
    """What limits the rolling resistance of closed contacts of a plate that turns in that sense (`SeveralRegime.turn`);
    empty without any."""
    if turn is None:
        return []
    return [forces.Slipping(-turn * at.resisting_arm) if turn else at.resisting_arm for at in some]


def _is_on_belt(now: DecisionInstant, modes: tuple[Mode, ...]) -> bool:
    """Whether the surface of a closed contact runs."""
    return any(
        mode is not Mode.FLIGHT and at.contact.effect(Belt) is not None
        for at, mode in zip(now.places, modes, strict=True)
    )


def _guides(case: Case, now: DecisionInstant, modes: tuple[Mode, ...]) -> tuple[tuple[bool, bool], ...] | None:
    """The rows that determine the motion, if they are as many as the plate's velocities; None if there are fewer."""
    picks = _independent_rows(case, now, modes)
    return picks if sum(map(sum, picks)) == freedoms(case.plate) else None


def _independent_rows(case: Case, now: DecisionInstant, modes: tuple[Mode, ...]) -> tuple[tuple[bool, bool], ...]:
    """Normal and tangential rows of each contact in those modes, the first that are independent."""
    picks, rows = [[False, False] for _ in modes], list[np.ndarray]()
    normals = [(k, 0) for k, mode in enumerate(modes) if mode is not Mode.FLIGHT]
    tangents = [(k, 1) for k, mode in enumerate(modes) if mode in STICKING]
    units = forces.units_of(case.plate)
    for k, which in (*normals, *tangents):
        at = now.places[k]
        more = [*rows, (at.slip_row if which else at.lift_row) * units]
        if np.linalg.matrix_rank(np.array(more), tol=INDEPENDENT) == len(more) <= freedoms(case.plate):
            rows, picks[k][which] = more, True
    return tuple((normal, tangent) for normal, tangent in picks)


def _is_smooth(case: Case, now: DecisionInstant, regime: SeveralRegime) -> bool:
    """Whether no force of a regime depends on a normal force: what is not unique about its forces moves nothing."""
    rows, columns = _rows_and_columns(case, now, regime)
    return bool((rows == columns).all())


def _is_consistent(case: Case, now: DecisionInstant, phase: SeveralPhase, error: float) -> bool:
    """Whether the conditions of a regime hold just after the instant along its own motion."""
    if not now.touching:
        return True  # a gap of rounding that closes is an impact, at once
    size, still = abs(now.state[0]) + abs(now.state[1]) + case.plate.reach, STILL * now.speed
    near = [at.gap <= NEAR * size and not is_away for at, is_away in zip(now.places, now.away, strict=True)]
    is_touched = any(mode is Mode.FLIGHT and close for mode, close in zip(regime_of(phase).modes, near, strict=True))
    if is_touched or regime_of(phase).guides:
        # A gap, or what a row lacks, has no size with which its value can be compared.
        apart = {k for k, at in enumerate(now.places) if k not in now.touching and at.gap > TOUCHES * size}
        positive = frozenset(f"gap:{k}" for k in apart)
        return _by_series(phase, now.time, now.state, error, positive, still, weak_force(case, now))
    return follows(case, phase, now.time, now.state, error, still, weak_force(case, now))


def weak_force(case: Case, now: DecisionInstant) -> float:
    """The force per mass (m/s²) below which that of a contact is rounding: of a contact that nothing presses, all are
    that."""
    return AT_BOUND * acceleration_scale(case, now.time, body_of(now.state))


def with_slack(case: Case, now: DecisionInstant, regime: SeveralRegime, error: float) -> SeveralRegime:
    """The regime with a slack for conditions on its forces that vanish all the time: of a box at the tie of sliding and
    tipping, or a wall that a disc slides along without force."""
    if regime.has_open_forces or not regime.closed:
        return regime
    weak = weak_force(case, now)
    slack = slack_of(several_phase(case, regime), now.time, now.state, error, weak)
    return regime._replace(slack=slack) if slack else regime


def slack_of_dip(case: Case, segment: Segment, guard: str, rtol: float) -> float:
    """By how much (m/s²) a condition on a force, which has ended a segment, may be negative where it touches zero and
    grows again within the motion's accuracy, as in `minimal.grazing`; 0 if it falls."""
    event = segment.event
    depth = depth_of_dip(segment.phase, guard, event.time, event.state)
    size = acceleration_scale(case, event.time, body_of(event.state))
    within = max(rtol, LOCATION_ERROR) * size
    return power_of_two(max(depth, SLACK * AT_BOUND * size)) if depth <= within else 0.0


def _is_singular(case: Case, now: DecisionInstant, regime: SeveralRegime) -> bool:
    """Whether the rows of a regime depend on each other, by themselves, as those of a disc in a tube of its width, or
    by friction: its forces have no value, as those of a disc in a groove of the angle of friction, if it slipped inward
    on both flanks."""
    rows, columns = _rows_and_columns(case, now, regime)
    if len(rows) < 2:
        return False
    some_rows, some_columns = (each / np.linalg.norm(each, axis=1)[:, None] for each in (rows, columns))
    return bool(abs(np.linalg.det(some_rows @ some_columns.T)) <= PAINLEVE_LEAST)


def _rows_and_columns(case: Case, now: DecisionInstant, regime: SeveralRegime) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the velocities that vanish in a regime, and of the forces that belong to them, (n, 3) each, both by the
    roots of mass and moment of inertia."""
    some = [(now.places[k], regime.modes[k]) for k in regime.closed]
    limits = limits_of_friction([at for at, _ in some], [mode for _, mode in some], now.time, now.state)
    rows, columns = list[np.ndarray](), list[np.ndarray]()
    for (at, mode), limit in zip(some, limits, strict=True):
        ratio = limit.ratio if isinstance(limit, forces.Slipping) else 0.0
        rows.append(at.lift_row)
        columns.append(at.lift_row + ratio * at.slip_row - (regime.turn or 0) * at.resisting_arm * TURNING_ROW)
        if mode in STICKING:
            rows.append(at.slip_row)
            columns.append(at.slip_row)
    rows += [TURNING_ROW] if regime.turn == 0 else []
    columns += [TURNING_ROW] if regime.turn == 0 else []
    units = np.sqrt(compliance(case.plate))
    return np.array(rows).reshape(-1, 3) * units, np.array(columns).reshape(-1, 3) * units


def _braced(
    case: Case, now: DecisionInstant, regime: SeveralRegime, motions: Sequence[tuple[SeveralRegime, np.ndarray]]
) -> list[tuple[SeveralRegime, np.ndarray]]:
    """A regime in which two contacts that slip may press against each other as much as they like, with accelerations
    (3,) that differ by what their friction then does; none if there is no such force, or no motion to which it adds."""
    rows, columns = _rows_and_columns(case, now, regime)
    if len(rows) != 2 or len(regime.closed) != 2:
        return []
    matrix = rows @ columns.T
    _, sizes, basis = np.linalg.svd(matrix)
    pressing, units = basis[-1] * np.sign(basis[-1, 0]), np.sqrt(compliance(case.plate))
    extra = units * (columns.T @ pressing)
    if sizes[-1] > PAINLEVE_LEAST * sizes[0] or pressing.min() <= 0.0 or np.abs(extra).max() <= SAME:
        return []
    extra *= acceleration_scale(case, now.time, body_of(now.state)) / float(np.abs(extra).max())
    return [
        (regime, acceleration + extra) for other, acceleration in motions
        if all(one is mode or one is Mode.FLIGHT for one, mode in zip(other.modes, regime.modes, strict=True))
    ][:1]  # fmt: skip


def _has_forces(phase: SeveralPhase, now: DecisionInstant) -> bool:
    """Whether the forces of a regime are unique, not beyond Painlevé's paradox, or those of more than three rows are
    admissible."""
    if regime_of(phase).guides:
        return margin_on_belts(phase, now.time, now.state, now.places) >= BALANCED
    names = list(phase.system.guards)
    if "painleve" not in names:
        return True
    values = phase.system.guards_of_numbers(now.time, now.state, phase.parameters)
    return bool(values[names.index("painleve")] != 0.0)


def margin_on_belts(phase: SeveralPhase, t: float, state: Sequence[float], every: Sequence[ContactPlace]) -> float:
    """`forces.margin` of contacts with more than three rows at the places `every`; −inf if the rows contradict each
    other, as do those of a plate on two belts of different acceleration."""
    case, regime = phase.case, regime_of(phase)
    load, units = load_on_belts(phase, t, state), forces.units_of(case.plate)
    outputs = phase.system.outputs_of_numbers(t, tuple(state), phase.parameters)
    push, scale = float(np.abs(load * units).max()) / case.plate.mass, acceleration_scale(case, t, body_of(state))
    size = max(push, scale)
    firsts = [FIRST_COLUMN + len(COLUMNS) * k for k in regime.closed]
    if not max(abs(value) for first in firsts for value in outputs[first : first + 2]) <= SAME * size:
        return -inf
    if push <= AT_BOUND * scale:  # contacts of which nothing presses any
        return 0.0
    some = [every[k] for k in regime.closed]
    limits = limits_of_friction(some, [regime.modes[k] for k in regime.closed], t, state)
    return forces.margin(some, load, units, limits, limits_of_couples(some, regime.turn))


def load_on_belts(phase: SeveralPhase, t: float, state: Sequence[float] | np.ndarray) -> np.ndarray:
    """The force and moment (N, N, N m) that the contacts of a plate on belts balance: the load, less what gives the
    plate its acceleration."""
    case = phase.case
    acceleration = np.array(phase.system.rates_of_numbers(t, tuple(state), phase.parameters)[-3:])
    inertia = case.plate.mass * np.array([1.0, 1.0, case.plate.gyration**2])
    return load_at(case, t, body_of(state)) - inertia * acceleration


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
