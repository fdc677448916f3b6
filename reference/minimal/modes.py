"""Regimes of the contact, and their equations with numbers (phases).

A `Regime` is a mode, the side of the track that presses (−1 only in a bilateral guide) and, with resistance to
rotation, the direction of rotation. It determines the runtime parameters of the mode's equations.

The full state in contact is (ξ₁, ξ₂, ξ̇₁, ξ̇₂), followed by θ if a load depends on the angle; in flight it is
(x, y, θ, vx, vy, ω).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import copysign
from typing import NamedTuple

from cases import Belt, Case, Curve, Load, Mode, Plate, Start
from cases.contact import belt_speed, pose, start_motion, velocity
from cases.contact.geometry import MotionPoint
from cases.contact.geometry import velocity as velocity_on
from cases.curves.corner import Corner
from cases.curves.pieces import CurvePart
from cases.formulas.features import Features
from cases.scene.piece_case import PieceCase, has_pieces, neighbour, pieces_at

from ..effect_laws import Laws, laws
from ..effect_laws.friction import SLIP_SIGN, STICKING
from ..effect_laws.scene_laws import effects_in_time
from .assembly import THETA, Kind, contact_system, parameter_values, sizes_of
from .elimination import U1, U2, X1, X2
from .system import System, slack_name

_PLACES = {X1: 0, X2: 1, U1: 2, U2: 3, THETA: 4}


class Regime(NamedTuple):
    """A mode of contact (or flight), the side of the track that presses, and the direction of rotation.

    `turn` is None without resistance to rotation, 0 if resistance prevents rotation. `slack`: the conditions on forces
    that vanish all the time, and how far below zero they may be (m/s²): their rounding.
    """

    mode: Mode
    side: int = 1
    turn: int | None = None
    slack: tuple[tuple[str, float], ...] = ()

    @property
    def kind(self) -> Kind:
        """The kind of equations: which rows they have."""
        return Kind(self.mode not in STICKING, self.turn == 0)


FLIGHT = Regime(Mode.FLIGHT)

# Of curves that are not in pieces: their only parts.
WHOLE = (0, 0)


class Phase(NamedTuple):
    """A regime of a case with its equations and their parameters: everything that an integrator needs.

    `size` is the plate's radius of gyration (m), `lengths` are the same in units of each position: a change of order
    one. `places` are the rows of its variables in the full state. `features` are those that a step could pass over,
    each with its row of the state (None: time); `checks_load`: whether a step could pass over a change of a load in
    place or velocity. `parts`: the numbers of the pieces of track and outline, of curves in pieces. `is_past`: whether
    a state is beyond the phase's end, so that no further steps are needed; `flies`: whether it is the flight of the
    only plate; `follows`: whether the gap of its contact is a variable.
    """

    regime: Regime
    system: System
    parameters: tuple[float, ...]
    size: float
    lengths: tuple[float, ...]
    places: tuple[int, ...]
    case: Case
    features: tuple[tuple[int | None, Features], ...] = ()
    checks_load: bool = False
    parts: tuple[int, int] = WHOLE
    is_past: Callable[[Sequence[float]], bool] | None = None
    flies: bool = False
    follows: bool = False

    @property
    def checks_steps(self) -> bool:
        """Whether each step must be checked for features and loads."""
        return bool(self.features) or self.checks_load

    def __reduce__(self):
        """Pickle case, regime and pieces only: everything else is derived from these."""
        return phase, (self.case, self.regime, self.parts)


def candidates(case: Case) -> tuple[Regime, ...]:
    """The regimes that the case's effects allow; if two are possible (static friction) the earlier one is taken."""
    return _regimes(laws(case))


@lru_cache(maxsize=256)
def _regimes(law: Laws) -> tuple[Regime, ...]:
    sides = (1, -1) if law.depends_on_side else (1,)
    return tuple(
        Regime(Mode.REST if mode is Mode.ROLL and turn == 0 else mode, side, turn)
        for mode in law.friction.modes
        for turn in law.resistance.turns
        for side in sides
    )


def able(case: Case, slip: float, turn: float) -> tuple[Regime, ...]:
    """The regimes that allow a slip and a rotation of those signs; with 0 it may begin in either direction."""
    return _able(laws(case), slip, turn)


@lru_cache(maxsize=1024)
def _able(law: Laws, slip: float, turn: float) -> tuple[Regime, ...]:
    return tuple(
        r
        for r in _regimes(law)
        if (not slip or SLIP_SIGN.get(r.mode, slip) == slip and r.mode not in STICKING)
        and (not turn or r.turn is None or r.turn == turn or law.resistance.is_fixed)
    )


def senses(case: Case, t: float, y: Sequence[float], slip: float, omega: float, error: float) -> tuple[float, float]:
    """The signs of slip and spin of a full state in contact; 0 if the value is below the state's error.

    The state contains slip (12) and spin (9) as differences of the contact point's two speeds (and a belt's), the
    latter weighted by the curvatures; the speeds have the relative `error`.
    """
    if not slip and not omega:
        return 0.0, 0.0
    along, turning = contact_speeds(case, y)
    slips = abs(slip) > error * max(*map(abs, along), abs(belt_speed(case, t)))
    turns = abs(omega) > error * max(map(abs, turning))
    return (copysign(1.0, slip) if slips else 0.0), (copysign(1.0, omega) if turns else 0.0)


def contact_speeds(case: Case, y: Sequence[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """How fast the contact point of a full state moves along track and outline (m/s), and their tangents turn with it
    (rad/s)."""
    (track, outline), (xi1, xi2, u1, u2) = (case.track, case.plate.outline), y[:4]
    along = u1 * float(track.speed(xi1)), u2 * float(outline.speed(xi2))
    return along, (_turn_rate(track, xi1, along[0], u1), _turn_rate(outline, xi2, along[1], u2))


def _turn_rate(curve: Curve, s: float, speed: float, rate: float) -> float:
    return curve.sign * rate if isinstance(curve, Corner) else float(curve.curvature(s)) * speed


def slip_and_spin(case: Case, t: float, y: Sequence[float]) -> tuple[float, float]:
    """Slip velocity (12), relative to a belt, and spin (9) of a full state in contact at time t."""
    along, turning = contact_speeds(case, y)
    return along[0] - along[1] - belt_speed(case, t), turning[0] - turning[1]


def phase_at(case: Case, regime: Regime, y: Sequence[float]) -> Phase:
    """The equations of that regime at a full state: of curves in pieces, on those that it belongs to."""
    track, outline = case.track.parts, case.plate.outline.parts
    if track is None and outline is None:
        return phase(case, regime, WHOLE)
    return phase(case, regime, (track.number(y[0]) if track else 0, outline.number(y[1]) if outline else 0))


# A phase holds its compiled equations, half a megabyte for each structure; those on further pieces, and with other
# numbers, have equations of the first.
@lru_cache(maxsize=1024)
def phase(case: Case, regime: Regime, parts: tuple[int, int] = WHOLE) -> Phase:
    """The equations of that regime with the case's parameters, on pieces of curves in pieces."""
    track, outline, size = case.track.part(parts[0]), case.plate.outline.part(parts[1]), case.plate.gyration
    law = laws(case)
    vanishing = tuple(name for name, _ in regime.slack)
    form = _form(law, regime.kind, track, outline, case.track, case.plate, case.start, effects_in_time(case), vanishing)
    numbers = form.sizes | {"nu": float(regime.side)} | {slack_name(name): size for name, size in regime.slack}
    numbers |= law.friction.values(case, regime.mode, regime.side)
    numbers |= law.resistance.values(case, regime.turn, regime.side)
    parameters = parameter_values(case, numbers, form.system)
    return Phase(
        regime, form.system, parameters, size, form.lengths, form.places, case, form.features, form.checks_load, parts
    )


class _PhaseForm(NamedTuple):
    """What phases of contact share whose cases differ in numbers of friction, gravity or resistance only; `sizes`: the
    parameters of curves and plate, by name."""

    system: System
    sizes: dict[str, float]
    lengths: tuple[float, ...]
    places: tuple[int, ...]
    features: tuple[tuple[int | None, Features], ...]
    checks_load: bool


# Scenes are often made again with another friction: of a phase only its numbers are new then.
@lru_cache(maxsize=1024)
def _form(
    law: Laws,
    kind: Kind,
    track: Curve | CurvePart,
    outline: Curve | CurvePart,
    whole: Curve,
    plate: Plate,
    start: Start,
    in_time: tuple[Load | Belt, ...],
    vanishing: tuple[str, ...],
) -> _PhaseForm:
    """The form of phases on these parts of a `whole` track and of the plate's outline."""
    system = contact_system(law, kind, track, outline, vanishing)
    lengths = _lengths(start, whole, plate)[: system.positions]
    if U2 in system.variables and U1 not in system.variables:
        lengths = (lengths[1], *lengths[1:])  # the only velocity is ξ̇₂
    places, features = tuple(_PLACES[v] for v in system.variables), _features(in_time, track, outline)
    sizes = sizes_of(track, outline, plate)
    return _PhaseForm(system, sizes, lengths, places, features, bool(system.load_quantities))


def _lengths(start: Start, track: Curve, plate: Plate) -> tuple[float, float, float]:
    """The radius of gyration in units of ξ₁ and ξ₂ where the motion starts, and one radian: the unit of a corner."""
    size, xi2 = plate.gyration, start.motion(track, plate.outline).xi2 if start.xi2 is None else start.xi2
    along_track, along_outline = float(track.speed(start.xi1)), float(plate.outline.speed(xi2))
    return size / along_track if along_track else 1.0, size / along_outline if along_outline else 1.0, 1.0


@lru_cache(maxsize=1024)
def _features(in_time: tuple[Load | Belt, ...], *curves: Curve | CurvePart) -> tuple[tuple[int | None, Features], ...]:
    """The features that no step may pass over: of effects and, in contact, of track and outline, if they have any."""
    all_features: list[tuple[int | None, Features | None]] = [(None, effect.features) for effect in in_time]
    all_features += [(row, curve.features) for row, curve in enumerate(curves)]
    return tuple((row, feature) for row, feature in all_features if feature is not None and not feature.plain)


def state_in(phase: Phase, y: Sequence[float]) -> tuple[float, ...]:
    """The values of the mode's own variables in a full state."""
    return tuple([y[place] for place in phase.places])


def full_state(case: Case, phase: Phase, t: float, y: Sequence[float]) -> tuple[float, ...]:
    """A mode's own variables at time t as the full state."""
    values = dict(zip(phase.places, map(float, y), strict=True))
    xi1, xi2 = values[0], values[1]
    u1 = values[2] if 2 in values else conveyance(case, t, xi1, xi2)
    u2 = values[3] if 3 in values else without_slip(case, t, xi1, xi2, u1)
    return (xi1, xi2, u1, u2, values[4]) if 4 in values else (xi1, xi2, u1, u2)


def without_slip(case: Case, t: float, xi1: float, xi2: float, u1: float) -> float:
    """ξ̇₂ of a plate that does not slip: v = 0 in (12). On a corner of the outline the plate is at rest."""
    if isinstance(case.plate.outline, Corner):
        return 0.0
    along = u1 * float(case.track.speed(xi1)) - belt_speed(case, t)
    return along / float(case.plate.outline.speed(xi2))


def conveyance(case: Case, t: float, xi1: float, xi2: float) -> float:
    """ξ̇₁ of a plate that neither slips nor turns: 0 but on a belt."""
    speed = belt_speed(case, t)
    return float(velocity(case, xi1, xi2, speed, 0.0).xi1_dot) if speed else 0.0


def constrained(case: Case, t: float, y: tuple[float, ...], kind: Kind) -> tuple[float, ...]:
    """The full state in contact without the slip and the rotation that a kind of equations excludes: of a plate that
    stops to slip on its own corner ξ̇₂ stays as it is, on a curve ξ̇₁."""
    u1 = y[2]
    if kind.slips:
        return without_turning(case, y) if kind.holds else y
    if kind.holds:  # the rounding left in the slip would be the plate's largest velocity
        u1 = conveyance(case, t, y[0], y[1])
    elif isinstance(case.plate.outline, Corner):
        return (*y[:2], belt_speed(case, t) / float(case.track.speed(y[0])), *y[3:])
    return (*y[:2], u1, without_slip(case, t, y[0], y[1], u1), *y[4:])


def without_turning(case: Case, y: Sequence[float]) -> tuple[float, ...]:
    """The full state in contact with the same slip and no rotation: ω = 0 in (9)."""
    slip = y[2] * float(case.track.speed(y[0])) - y[3] * float(case.plate.outline.speed(y[1]))
    still = velocity(case, y[0], y[1], slip, 0.0)
    return (y[0], y[1], still.xi1_dot, still.xi2_dot, *y[4:])


@lru_cache(maxsize=1024)
def start_state(case: Case) -> tuple[float, ...]:
    """The case's start as a full state, of contact or of flight."""
    start = start_motion(case)
    if not case.start.in_contact:
        return start.x, start.y, start.theta, start.vx, start.vy, start.omega
    angle = (start.theta,) if laws(case).needs_angle else ()
    if has_pieces(case):
        return (*_start_on(_first_pieces(case), start), *angle)
    return start.xi1, start.xi2, start.xi1_dot, start.xi2_dot, *angle


def start_pieces(case: Case) -> Case:
    """The case on the pieces of its curves on which it starts: where two meet, those towards which the contact moves.
    The case itself if its curves have no pieces."""
    return _first_pieces(case) if has_pieces(case) else case


@lru_cache(maxsize=1024)
def _first_pieces(case: Case) -> PieceCase:
    """The same for a case with pieces."""
    start = start_motion(case)
    here = pieces_at(case, start.xi1, start.xi2)
    if not case.start.in_contact:
        return here
    for of_track in (True, False):
        place = _start_on(here, start)[1 - of_track]
        speed = _start_on(here, start)[3 - of_track]
        following = neighbour(here, of_track, 1)
        if following and speed > 0.0 and place >= here.pieces[1 - of_track].span[1]:
            here = following
    return here


def _start_on(here: PieceCase, start: MotionPoint) -> tuple[float, float, float, float]:
    """(ξ₁, ξ₂, ξ̇₁, ξ̇₂) of a case's start on these pieces."""
    (low1, high1), (low2, high2) = (piece.span for piece in here.pieces)
    xi1 = min(max(start.xi1 - here.first.shift, low1), high1) if here.track.ends else start.xi1
    xi2 = min(max(start.xi2 - here.second.shift, low2), high2) if here.plate.outline.ends else start.xi2
    slip = start.slip + belt_speed(here, 0.0)
    motion = velocity_on(here.track, here.plate.outline, xi1, xi2, slip, start.omega)
    return xi1, xi2, motion.xi1_dot, motion.xi2_dot


def in_contact(
    case: Case, t: float, xi1: float, xi2: float, slip: float, omega: float, theta: float
) -> tuple[float, ...]:
    """The full state of a contact with that slip and spin at time t."""
    motion = velocity(case, xi1, xi2, slip + belt_speed(case, t), omega)
    return (xi1, xi2, motion.xi1_dot, motion.xi2_dot, *((theta,) if laws(case).needs_angle else ()))


def in_flight(case: Case, t: float, y: Sequence[float], slip: float, omega: float, lift: float) -> tuple[float, ...]:
    """The full state of flight that begins at a contact's place with its slip, spin and `lift`, Start's gap_rate."""
    slip += belt_speed(case, t)
    x, y0, theta = (float(v) for v in pose(case, y[0], y[1]))
    theta += case.turn if isinstance(case, PieceCase) else 0.0
    (tx, ty), (X, Y) = case.track.tangent(y[0]), case.track.point(y[0])
    vx = slip * tx - lift * ty + omega * (Y - y0)
    vy = slip * ty + lift * tx - omega * (X - x)
    return x, y0, y[4] if len(y) > 4 else theta, float(vx), float(vy), omega
