"""Regimes of the contacts of several plates, and their equations with numbers."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import inf
from typing import NamedTuple, cast

import numpy as np

from cases import Case, Curve, Mode
from cases.curves.corner import Corner, Piece
from cases.scene.couples import couples
from cases.scene.free_plates import loads_of, plates_of
from cases.scene.piece_case import PieceCase, neighbour, piece_case_of

from ..effect_laws import laws
from ..effect_laws.applied_forces import applied_load
from ..effect_laws.friction import STICKING
from ..effect_laws.rolling_resistance import NoResistance
from ..effect_laws.scene_laws import effects_in_time
from ..minimal.assembly import PIECE_ENDS, curve_sizes, parameter_values, structure
from ..minimal.modes import Phase, Regime, _features
from ..minimal.system import slack_name
from .contact_terms import NO_ROWS, ContactForm, ContactRows
from .places import couple_of, sides_of
from .plate_numbers import Turns, bodies
from .system import solver_system

# An open contact is watched until the clearance of its curvatures falls below this part of the outline's curvature: its
# nearest points then move fast, and may soon be lost.
LOST = 0.05


# A contact beyond an end of its elements by at most this (m or rad) is at the end: the rounding of a pose.
AT_END = 1e-9
# For each contact which of its normal and tangential row determine the motion, where more rows than velocities do.
Guides = tuple[tuple[bool, bool] | None, ...]


class PairKey(NamedTuple):
    """A pair of elements: the number of its couple, those of both elements, and those of their parts between knots."""

    couple: int
    first: int
    second: int
    parts: tuple[int, int] = (0, 0)


class SolverRegime(NamedTuple):
    """Contacts with their modes (FLIGHT: open), and the plates at rest, whose contacts have no equations.

    `shares`: for each contact the place of the one with its friction force, if another has it; `slack`: conditions on
    forces that vanish all the time, and how far below zero they may be (m/s²): their rounding; `lost`: of each contact
    the clearance (1/m) below which it is not watched any more; `turns`: the rotations that closed
    contacts resist. `guides`: where forces are not
    unique; (False, False) for contacts that are no part of it, or open. `along`: for each closed contact the place of
    the first one of the same straight side; `anchors`: plates that contacts hold while others press on them;
    `at_joint`: contacts that stay where two elements join, to rounding: they do not pass on within `AT_END`; `rooms`:
    of each contact the gap (m) up to which it is followed while it is open, 0 if it is not.
    """

    pairs: tuple[PairKey, ...]
    modes: tuple[Mode, ...]
    names: tuple[str, ...] = ()
    resting: frozenset[int] = frozenset()
    shares: tuple[int | None, ...] = ()
    slack: tuple[tuple[str, float], ...] = ()
    lost: tuple[float, ...] = ()
    turns: Turns = ()
    guides: Guides = ()
    along: tuple[int | None, ...] = ()
    anchors: frozenset[int] = frozenset()
    at_joint: tuple[bool, ...] = ()
    rooms: tuple[float, ...] = ()


class SolverPhase(Phase):
    """A regime with its equations and numbers; integrators read it as any other phase."""

    __slots__ = ()

    def __reduce__(self):
        return solver_phase, (self.case, self.regime)


def regime_of(phase: Phase) -> SolverRegime:
    """The regime of a phase."""
    return cast(SolverRegime, phase.regime)


def key_of(pair: PieceCase, points: tuple[float, float]) -> PairKey:
    """The numbers of a pair of elements, and of their parts at these parameters."""
    pieces = cast(tuple[Piece, Piece], pair.pieces)
    one, other = (piece.parts.number(s) if piece.parts else 0 for piece, s in zip(pieces, points, strict=True))
    return PairKey(couple_of(pair).number, pair.first.number, pair.second.number, (one, other))


def pair_of(case: Case, key: PairKey) -> PieceCase:
    """The pair of elements with those numbers."""
    return piece_case_of(couples(case)[key.couple], key.first, key.second)


def kind_of(mode: Mode) -> ContactRows:
    """The rows of a contact in that mode."""
    if mode is Mode.FLIGHT:
        return ContactRows.OPEN
    return ContactRows.STICK if mode in STICKING else ContactRows.SLIP


def ends_of(pair: PieceCase, is_open: bool) -> tuple[str, ...]:
    """The ends of both elements, or of their parts, at which a contact passes to the next one. Where that is straight,
    as the other element is, both lie on each other there, and the contact stays at the joint, unless it `ends_flat`, or
    is open and the element is no corner: beyond its end an arc is not part of the curve.
    """
    result = list[str]()
    for end, (of_track, step) in PIECE_ENDS.items():
        piece = cast(Piece, pair.pieces[0 if of_track else 1])
        lies_flat = is_flat_beyond(pair, of_track, step) and not ends_flat(pair, of_track, step)
        stays = piece.ends is None or (lies_flat and (not is_open or isinstance(piece, Corner)))
        if piece.parts is not None or not stays:
            result.append(end)
    return tuple(result)


def ends_flat(pair: PieceCase, of_track: bool, step: int) -> bool:
    """Whether a straight side lies down there on a straight element that ends on the same side without a neighbour.
    If the side's next corner does not meet the element first, the side reaches beyond that free end, and the contact
    with it."""
    other = cast(Piece, pair.pieces[1 if of_track else 0])
    is_free = other.ends is not None and neighbour(pair, not of_track, step) is None
    return is_free and is_flat_beyond(pair, of_track, step)


def is_flat_beyond(pair: PieceCase, of_track: bool, step: int) -> bool:
    """Whether both elements are straight where a contact passes to the next one."""
    following = neighbour(pair, of_track, step)
    return following is not None and all(is_straight(one) for one in following.pieces)


def is_straight(piece: Piece) -> bool:
    """Whether an element is a part of a line."""
    return not isinstance(piece, Corner) and piece.features is None


@lru_cache(maxsize=1024)
def solver_phase(case: Case, regime: SolverRegime) -> SolverPhase:
    """The equations of that regime with the case's parameters."""
    plates, some = plates_of(case), [pair_of(case, key) for key in regime.pairs]
    shares = regime.shares or (None,) * len(some)
    senses = dict(regime.turns)
    forms, closed = list[ContactForm](), list[PieceCase]()
    values = {slack_name(name): amount for name, amount in regime.slack}
    for k, (pair, mode) in enumerate(zip(some, regime.modes, strict=True)):
        couple, kind = couple_of(pair), kind_of(mode)
        if couple.body in regime.resting and (couple.base is None or couple.base in regime.resting):
            kind = ContactRows.AWAY  # it has no equations
        numbers = regime.pairs[k].parts
        track, outline = (
            piece.part(number) for piece, number in zip(cast(tuple[Piece, Piece], pair.pieces), numbers, strict=True)
        )
        form = ContactForm(
            couple.body, couple.base, structure(track), structure(outline), kind, ends_of(pair, mode is Mode.FLIGHT)
        )
        law, sense = laws(couple), senses.get(sides_of(pair))
        if kind not in NO_ROWS:
            closed.append(pair)
            resistance = law.resistance if law.resistance.has_bound and sense is not None else NoResistance()
            form = form._replace(
                friction=law.friction.of_contact(k), surface=law.belt.of_contact(k), shares=shares[k],
                resistance=resistance.of_contact(k), holds=resistance.has_bound and sense == 0,
                guides=regime.guides[k] if regime.guides else None, along=regime.along[k] if regime.along else None,
            )  # fmt: skip
        room = regime.rooms[k] if regime.rooms else 0.0
        forms.append(form._replace(has_gap=room > 0.0, has_room=0.0 < room < inf))
        values[f"room_{k}"] = room
        values |= form.friction.values(pair, mode) | form.resistance.values(pair, sense) | form.surface.values(pair)
        values |= curve_sizes(track, f"track_{k}_") | curve_sizes(outline, f"outline_{k}_")
        for of_track, step in PIECE_ENDS.values():
            # A contact that stays at a joint, and one of a side that lies flat, are at the end to rounding.
            if (regime.at_joint and regime.at_joint[k]) or ends_flat(pair, of_track, step):
                name = f"{'track' if of_track else 'outline'}_{k}_{'high' if step > 0 else 'low'}"
                values[name] = values.get(name, 0.0) + step * AT_END
        values[f"lost_{k}"] = regime.lost[k] if regime.lost else 0.0
    for b, plate in enumerate(plates):
        values |= {f"w_{b}": 1.0 / plate.mass, f"v_{b}": 1.0 / plate.inertia}
        values[f"radius_{b}"] = plate.gyration if plate.turns else plate.reach
    values |= {
        "m": plates[0].mass,
        "G": plates[0].inertia / plates[0].mass if plates[0].turns else plates[0].reach ** 2,
    }
    idle = tuple(name for name, _ in regime.slack)
    loads = loads_of(case)
    further = tuple(
        applied_load(load.expression, f"load{b}", plates[b].spins_by_load) if load is not None else None
        for b, load in enumerate(loads[1:], 1)
    )
    for form_of_load, load in zip(further, loads[1:], strict=True):
        values |= form_of_load.constants_of(load) if form_of_load is not None and load is not None else {}
    system = solver_system(tuple(forms), len(plates), regime.resting, laws(case), idle, regime.anchors, further)
    parameters = parameter_values(case, values, system)
    reaches = bodies(case).reaches
    lengths = [length for reach in reaches for length in (reach, reach, 1.0)]
    in_time = dict.fromkeys([*filter(None, loads), *(effect for pair in closed for effect in effects_in_time(pair))])
    features = list(_features(tuple(in_time)))
    for k, pair in enumerate(some):
        for i, piece in enumerate(cast(tuple[Piece, Piece], pair.pieces)):
            lengths.append(_angle(piece, reaches[couple_of(pair).body]))
            if isinstance(piece, Curve):
                features += [(3 * len(plates) + 2 * k + i, f) for _, f in _features((), piece)]
    lengths += [reaches[form.body] for form in forms if form.has_gap]
    places = tuple(range(len(system.variables)))
    return SolverPhase(
        cast(Regime, regime), system, parameters, min(reaches), tuple(lengths), places, case, tuple(features),
        bool(system.load_quantities), flies=len(plates) == 1 and all(mode is Mode.FLIGHT for mode in regime.modes),
        follows=any(regime.rooms),
    )  # fmt: skip


def _angle(piece: Piece, reach: float) -> float:
    """The change of a parameter that moves its point by the plate's reach; at a corner it is an angle."""
    return 1.0 if isinstance(piece, Corner) else reach / float(piece.speed(piece.span[0]))


def join(
    state: Sequence[float] | np.ndarray, points: Sequence[tuple[float, float]], gaps: Sequence[float] = ()
) -> tuple[float, ...]:
    """The variables of a phase: the plates' state with the parameters of its contacts, and the gap that is followed."""
    half = len(state) // 2
    return (*map(float, state[:half]), *(float(v) for pair in points for v in pair), *gaps, *map(float, state[half:]))


def split(case: Case, y: Sequence[float] | np.ndarray) -> tuple[tuple[float, ...], list[tuple[float, float]]]:
    """The plates' state, and the parameters of the contacts, of a phase's variables."""
    half = 3 * len(plates_of(case))
    inside = list(y[half : len(y) - half])  # the last of an odd number is a gap
    return (*map(float, y[:half]), *map(float, y[len(y) - half :])), list(zip(inside[::2], inside[1::2], strict=False))
