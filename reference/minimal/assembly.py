"""The equations of a mode, assembled from a case's curves and the contributions of its effects, once per structure."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from math import isfinite
from typing import NamedTuple

import numpy as np

from cases import Case, Curve, Plate
from cases.curves.corner import Corner, Piece
from cases.curves.pieces import CurvePart
from cases.derivation import in_one_thread
from cases.formulas.expression_graph import ZERO, Node, in_order, sqrt, substitute, symbol
from cases.formulas.formula_symbols import NAMES

from ..effect_laws import Laws, laws
from ..effect_laws.applied_forces import MASS
from ..effect_laws.belt import Surface
from ..effect_laws.lifted_formulas import Conditions
from ..effect_laws.scene_laws import THETA
from .elimination import (
    GYRATION,
    LOAD,
    U1,
    U2,
    X1,
    X2,
    Elimination,
    T,
    Torsor,
    eliminate,
    speeds,
    spin,
)
from .frames import CORNER, Frame, frame
from .system import LOAD_FORCES, Equations, System, checked_with_friction

_MOTION = tuple(map(symbol, NAMES["MOTION"]))

# The normal force grows like a power of 1/p towards Painlevé's p = 0, and p has the rounding of its terms: below this
# value forces have no digits left; the place changes by less than that.
PAINLEVE_LEAST = 1e-9


class Kind(NamedTuple):
    """The constraint rows of a contact: `slips` without the rolling row, `holds` with a row against rotation."""

    slips: bool
    holds: bool


_STATES = {
    Kind(slips=True, holds=False): (U1, U2),
    Kind(slips=True, holds=True): (U1, U2),
    Kind(slips=False, holds=False): (U1,),
    Kind(slips=False, holds=True): (),
}


def structure(curve: Curve | Piece | CurvePart):
    """What the equations of a contact depend on: a curve's formula without its sizes, or a corner's sign."""
    return curve.sign if isinstance(curve, Corner) else curve.structure


def contact_system(
    law: Laws, kind: Kind, track: Curve | CurvePart, outline: Curve | CurvePart, vanishing: tuple[str, ...] = ()
) -> System:
    """The equations of one kind of contact on parts of a case's curves, derived once per structure; `vanishing`: guards
    that stay at zero and have a slack."""
    sides = [side for side, curve in (("track", track), ("outline", outline)) if curve.ends is not None]
    ends = tuple(f"{side}_{end}" for side in sides for end in ("start", "end"))
    return _in_contact(structure(track), structure(outline), ends, law, kind, vanishing)


@lru_cache(maxsize=256)
@in_one_thread
def _in_contact(track, outline, ends: tuple[str, ...], law: Laws, kind: Kind, vanishing: tuple[str, ...]) -> System:
    return System(_contact_equations(track, outline, ends, law, kind).with_slack(vanishing))


def _contact_equations(track, outline, ends: tuple[str, ...], law: Laws, kind: Kind) -> Equations:
    f = frame(track, X1, "track_")
    h = frame(outline, X2, "outline_")
    belt = law.belt.surface
    own_speeds = speeds(f, h, belt, *kind)
    pose = _motion(f, h, belt, kind, own_speeds)
    slip = U1 * f.P - U2 * h.P - belt.speed if kind.slips else ZERO
    load = _load(law, pose)
    force = _at_contact(_force(f, law, pose, load), h, law, slip, pose[_MOTION[6]])
    motion = eliminate(f, h, force, belt, *kind, law.friction.ratio, law.resistance.couple)
    motion = Elimination(*substitute(motion, load))
    ratio = law.friction.ratio_at(motion.slip, law.side) if kind.slips else law.friction.ratio
    if ratio is not law.friction.ratio:
        motion = Elimination(*substitute(motion, {law.friction.ratio: ratio}))
    conditions, rates_of = _conditions(law, kind, motion)
    if (law.unilateral or law.depends_on_side) and "cone_forward" not in conditions:
        conditions["normal_force"] = law.side * motion.normal  # inside the cone it is not negative
    positions = (X1, X2, *([THETA] if law.needs_angle else []))
    variables = (*positions, *_velocities(kind, h))
    rate_of = {X1: own_speeds[0], X2: own_speeds[1], THETA: motion.omega, U1: motion.u1_dot, U2: motion.u2_dot}
    rests = not _STATES[kind] and belt.speed is ZERO
    rates = tuple(rate_of[v] for v in variables)
    moving = {T} if rests else {*variables, T}
    fit = {} if f.sign or h.sign else {"fit": h.curvature - f.curvature}  # a corner fits on every smooth curve
    limits = {**fit, "painleve": motion.inverse_mass - PAINLEVE_LEAST, **end_guards(ends)}
    for own in law.own:
        limits |= own.ends(slip, pose[_MOTION[6]])
    guards = {name: g for name, g in (conditions | limits).items() if g.symbols & moving}
    by_load = tuple(substitute(law.checked_quantities, pose))
    frictions = [(*law.friction.checked_arguments(motion.slip), MASS * motion.friction)] if kind.slips else []
    checked, layout = checked_with_friction(frictions, by_load[:-LOAD_FORCES], by_load[-LOAD_FORCES:])
    return Equations(variables, len(positions), rates, motion, conditions, rates_of, guards, checked, layout)


def _conditions(law: Laws, kind: Kind, motion: Elimination) -> tuple[Conditions, Conditions]:
    """The conditions of friction and resistance, and the rates of those that are velocities."""
    friction, resistance, size, side = law.friction, law.resistance, sqrt(GYRATION), law.side
    conditions, rates = dict[str, Node](), dict[str, Node]()
    if kind.slips:
        conditions, rates = friction.slip_conditions(motion.slip), friction.slip_conditions(motion.slip_dot)
    else:
        conditions = friction.stick_conditions(motion.normal, motion.friction, side)
    if kind.holds:
        return conditions | resistance.hold_conditions(
            resistance.bound(motion.normal, side), motion.couple, size
        ), rates
    turns, turn_rates = (resistance.turn_conditions(spin, size) for spin in (motion.omega, motion.omega_dot))
    return conditions | turns, rates | turn_rates


def _velocities(kind: Kind, h: Frame) -> tuple[Node, ...]:
    """The velocities among the variables; ξ̇₂ where a plate turns about its own corner without slip."""
    return (U2,) if h.sign and kind == Kind(slips=False, holds=False) else _STATES[kind]


def _motion(f: Frame, h: Frame, belt: Surface, kind: Kind, own: tuple[Node, Node]) -> dict[Node, Node]:
    """Pose and velocities of the plate, the arguments of a load, in terms of the contact's state."""
    omega = ZERO if kind.holds else spin(f, h, *own)
    point = U1 * f.P - U2 * h.P if kind.slips else belt.speed
    along, across = point + omega * h.hn, -omega * h.ht
    _, x, y, _, vx, vy, w = _MOTION
    return {
        x: f.x - h.ht * f.tx + h.hn * f.ty,  # the centre is the contact minus the arm (5)
        y: f.y - h.ht * f.ty - h.hn * f.tx,
        vx: along * f.tx - across * f.ty,
        vy: along * f.ty + across * f.tx,
        w: omega,
    }


def _load(law: Laws, pose: dict[Node, Node]) -> dict[Node, Node]:
    """The components of the applied torsor that must not be multiplied out, by their symbols in the elimination, with
    pose and velocities written in the contact's state."""
    components = dict(zip(LOAD, law.torsor, strict=True))
    names = [name for name, component in components.items() if _has_products(component)]
    return dict(zip(names, substitute([components[name] for name in names], pose), strict=True))


def _has_products(component: Node) -> bool:
    """Whether it contains a power, or a product of two parts, that time, pose or velocities change."""
    moving = {T, *_MOTION}
    return any(
        part.op == "**"
        and part.symbols & moving
        or part.op in ("*", "/")
        and all(isinstance(factor, Node) and factor.symbols & moving for factor in part.args)
        for part in in_order([component])
    )


def _force(f: Frame, law: Laws, pose: dict[Node, Node], load: dict[Node, Node]) -> Torsor:
    """The applied torsor in the frame of the contact, with pose and velocities written in the contact's state, and the
    symbols of a `load` that must not be multiplied out."""
    components = zip(LOAD, substitute(law.torsor, pose), strict=True)
    fx, fy, moment = (name if name in load else component for name, component in components)
    return Torsor(fx * f.tx + fy * f.ty, fy * f.tx - fx * f.ty, moment)


def _at_contact(force: Torsor, h: Frame, law: Laws, slip: Node, omega: Node) -> Torsor:
    """The applied torsor with the forces of the user's own effects, which act at the contact."""
    for own in law.own:
        along, across, couple = (part / MASS for part in own.force(slip, omega))
        moment = force.moment + h.ht * across - h.hn * along + couple
        force = Torsor(force.t + along, force.n + across, moment)
    return force


# Guards at the ends of a piece: whether it is the track's, and which way the contact leaves it.
PIECE_ENDS = {
    "track_start": (True, -1),
    "track_end": (True, 1),
    "outline_start": (False, -1),
    "outline_end": (False, 1),
}


def end_guards(ends: Iterable[str], of_contact: str = "") -> Conditions:
    """Guards for ends of the elements, by the names of PIECE_ENDS; `of_contact`: with what the names of a
    contact's symbols end."""
    guards = dict[str, Node]()
    for name in ends:
        side, _, end = name.partition("_")
        xi = symbol(f"xi{1 if side == 'track' else 2}{of_contact}")
        low, high = (symbol(f"{side}{of_contact}_{bound}") for bound in ("low", "high"))
        guards[name] = xi - low if end == "start" else high - xi
    return guards


def parameter_values(case: Case, numbers: dict[str, float], system: System) -> tuple[float, ...]:
    """The runtime parameters in the system's order: the `numbers` of curves, plate and mode, by name, those of the
    case's effects, which are added to them, and the system's constants."""
    law = laws(case)
    for part in (*law.loads, law.belt, *law.own):
        numbers |= part.values(case)
    parameters = [numbers[name] for name in system.names]
    return (*parameters, *_constants(system, parameters))


def _constants(system: System, parameters: list[float]) -> Iterable[float]:
    """The values of the system's constants; one without a value is NaN, as it is on arrays."""
    if not system.constants:
        return ()
    if system.constants_of_numbers is not None:
        values = system.constants_of_numbers(parameters)
        if isfinite(sum(values)):
            return map(float, values)
    with np.errstate(all="ignore"):
        return map(float, system.constants_of_arrays([np.float64(value) for value in parameters]))


def sizes_of(track: Curve | CurvePart, outline: Curve | CurvePart, plate: Plate) -> dict[str, float]:
    """The parameters of parts of the curves and of the plate in all modes, by name."""
    own = {"G": plate.inertia / plate.mass, "m": plate.mass}
    return own | curve_sizes(track, "track_") | curve_sizes(outline, "outline_")


def curve_sizes(curve: Curve | Piece | CurvePart, prefix: str) -> dict[str, float]:
    """The parameters of a curve, by names that begin with `prefix`."""
    names = CORNER if isinstance(curve, Corner) else [size.name for size in curve.structure[1]]
    sizes = {prefix + name: value for name, value in zip(names, curve.constants, strict=True)}
    return sizes | ({f"{prefix}low": curve.domain[0], f"{prefix}high": curve.domain[1]} if curve.domain else {})
