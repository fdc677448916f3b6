"""The paper's rows (8)″, (9)′ and (27) for several contacts of one plate, eliminated by hand.

In the frame of contact i (t along the track, n = U t towards the plate, arm h = θr from the centre of mass) the rows
(8)″ along n read  a·n + ω̇ h_t = C_n  (`minimal.elimination` has C_n), and where the contact does not slip those along t
a·t − ω̇ h_n = ω² h_t + ḃ, with the speed b of the support's surface along t: a belt changes C alone. With q̈₁ from (16),
(19), they are linear in the contacts' forces, and solved by Cramer's rule. A plate has three degrees of freedom: three
rows or more hold it at rest, or determine its motion by the belts that it sticks to. Of more than three, whose forces
are not unique, three are used. One of infinite inertia has two: moments over an infinite ρ² vanish.
Rolling resistance adds a couple −τ c N to each contact's force, against the rotation ω of sign τ that all contacts
resist; while they prevent it, the row ω̇ = 0 has the sum of their couples, at most the sum of all c N.
ξ̇ follows from the velocities by (8)′ and (9)′, for an open contact with its gap.
"""

from __future__ import annotations

from collections import namedtuple
from enum import Enum
from functools import lru_cache
from typing import Any, NamedTuple

from cases.derivation import in_one_thread
from cases.expression_graph import ONE, ZERO, Node, sqrt, symbol

from ..minimal.assembly import _MOTION, PAINLEVE_LEAST
from ..minimal.effects import MASS, Coulomb, CoulombBySpeed, FixedSurface, Frictionless, Laws
from ..minimal.elimination import GYRATION, Surface
from ..minimal.frames import Frame, frame
from ..minimal.system import LOAD_FORCES, CheckLayout, Equations, System

_, X, Y, THETA, VX, VY, OMEGA = _MOTION
# Columns of the outputs for each contact. Where more than three rows determine the motion, the first two are by how
# much the acceleration misses the contact's rows.
COLUMNS = ("normal", "friction", "slip", "gap", "lift")
# Those of the first contact begin after the applied force and the accelerations.
FIRST_COLUMN = 5
# The radius of gyration, m.
RADIUS = sqrt(GYRATION)


class Rotation(Enum):
    """How the contacts resist the plate's rotation: not at all, against its direction, or so that it does not turn."""

    FREE = "free"
    RESISTED = "resisted"
    HELD = "held"


class ContactRows(Enum):
    """What a contact contributes to the equations: nothing, a normal row, or a normal and a tangential row. A contact
    that is away cannot close until its arc turns to the support."""

    AWAY = "away"
    OPEN = "open"
    SLIP = "slip"
    STICK = "stick"


NO_ROWS = ContactRows.AWAY, ContactRows.OPEN


class _ContactTerms(NamedTuple):
    """One contact's expressions: frames of track and outline, slip and lift velocities, gap, rates of ξ₁ and ξ₂ along
    the curves (m/s), and the clearance of its curvatures (1/m)."""

    f: Frame
    h: Frame
    slip: Node
    lift: Node
    gap: Node
    along_track: Node
    along_outline: Node
    clearance: Node


class _EquationRow(NamedTuple):
    """A row of the equations: the unit direction (x, y), its moment arm, the right-hand side, and the force column: a
    direction with its moment arm."""

    direction: tuple[Node, Node]
    lever: Node
    right: Node
    force: tuple[Node, Node]
    moment: Node


class ContactForm(NamedTuple):
    """What the equations of one contact depend on: the structures of its support's curve and of its feature of the
    outline (a corner's is the sign of its turn), its rows, its law of friction, whether the two curves have ends,
    whether its nearest points are unique in every pose, and whether its arc has a range.

    `surface`: its support's surface, which may run. `guides`: where more rows than three determine the motion, which of
    its normal and tangential row are used; no row has a force of its own then.
    `resists`: whether it resists rolling; `along`: an earlier contact of the same straight side.
    """

    track: Any
    outline: Any
    kind: ContactRows
    friction: Frictionless
    has_ends: tuple[bool, bool]
    stays: bool
    turns: bool
    surface: FixedSurface = FixedSurface()
    guides: tuple[bool, bool] | None = None
    resists: bool = False
    along: int | None = None

    @property
    def rubs(self) -> bool:
        """Whether there is friction with a bound."""
        return isinstance(self.friction, Coulomb)


def several_system(
    forms: tuple[ContactForm, ...], law: Laws, rotation: Rotation = Rotation.FREE, vanishing: tuple[str, ...] = ()
) -> System:
    """The equations of contacts of those forms, derived once; `vanishing`: guards that stay at zero, which have a slack
    (a parameter, m/s²)."""
    return _several_system(forms, law, rotation, vanishing)


@lru_cache(maxsize=256)
@in_one_thread
def _several_system(
    forms: tuple[ContactForm, ...], law: Laws, rotation: Rotation, vanishing: tuple[str, ...]
) -> System:
    return System(_equations(forms, law, rotation).with_slack(vanishing))


def _contact(form: ContactForm, k: int) -> _ContactTerms:
    kind = form.kind
    f = frame(form.track, symbol(f"xi1_{k}"), f"track_{k}_")
    h = frame(form.outline, symbol(f"xi2_{k}"), f"outline_{k}_")
    slip = VX * f.tx + VY * f.ty - OMEGA * h.hn
    lift = VY * f.tx - VX * f.ty + OMEGA * h.ht
    gap = (Y - f.y) * f.tx - (X - f.x) * f.ty + h.hn
    apart = gap if kind in NO_ROWS else ZERO
    shrink = ONE - apart * f.curvature
    if h.sign:  # the point is fixed, and ξ₂ follows from ω + sign ξ̇₂ = κ₁ ṡ₁
        return _ContactTerms(f, h, slip, lift, gap, slip / shrink, ZERO, shrink)
    clearance = h.curvature * shrink - f.curvature
    # Tangents turn together, ω + κ₂ ṡ₂ = κ₁ ṡ₁, and the gap keeps to the normal, v + ṡ₂ = ṡ₁ (1 − g κ₁).
    along_track = (h.curvature * slip - OMEGA) / clearance
    return _ContactTerms(f, h, slip, lift, gap, along_track, along_track * shrink - slip, clearance)


def _rows(contact: _ContactTerms, form: ContactForm, surface: Surface, ratio: Node, couple: Node) -> list[_EquationRow]:
    """The rows of one contact, the normal one first; `couple`: that of rolling resistance per normal force."""
    if form.guides is None:
        rows = _rows_of_kind(contact, form.kind, surface, ratio)
        return rows if couple is ZERO else [rows[0]._replace(moment=rows[0].moment + couple), *rows[1:]]
    both = _rows_of_kind(contact, ContactRows.STICK, surface, ZERO)
    return [row for row, is_used in zip(both, form.guides, strict=True) if is_used]


def _rows_of_kind(contact: _ContactTerms, kind: ContactRows, surface: Surface, ratio: Node) -> list[_EquationRow]:
    if kind in NO_ROWS:
        return []
    f, h = contact.f, contact.h
    u1 = contact.along_track / f.P
    # At a corner the outline's point does not move along it.
    outline = ZERO if h.sign else 2 * OMEGA * contact.along_outline + (contact.along_outline / h.P) ** 2 * h.b
    right_n = OMEGA**2 * h.hn - outline + u1**2 * f.b
    t, n = (f.tx, f.ty), (-f.ty, f.tx)
    if kind is ContactRows.STICK:
        right_t = OMEGA**2 * h.ht + surface.rate
        return [_EquationRow(n, h.ht, right_n, n, h.ht), _EquationRow(t, -h.hn, right_t, t, -h.hn)]
    force = n[0] + ratio * t[0], n[1] + ratio * t[1]
    return [_EquationRow(n, h.ht, right_n, force, h.ht - ratio * h.hn)]


def _turning_of_side(forms: tuple[ContactForm, ...], contacts: list[_ContactTerms]) -> Node:
    """ω̇ of a side that lies flat, from the difference of two normal rows (8)″, in which translation vanishes."""
    second, first = next((k, form.along) for k, form in enumerate(forms) if form.along is not None)
    one, other = (contacts[k].h for k in (first, second))
    return OMEGA**2 * (other.hn - one.hn) / (other.ht - one.ht)


def _multipliers(rows: list[_EquationRow], torsor: tuple[Node, Node, Node]) -> tuple[list[Node], Node]:
    """The forces per mass that satisfy the rows, and the determinant in units of its value without the coupling of
    translation and rotation, which Painlevé's paradox makes 0."""

    def weight(row: _EquationRow, other: _EquationRow) -> Node:
        (x, y), (u, v) = row.direction, other.force
        return x * u + y * v + row.lever * other.moment / GYRATION

    def free(row: _EquationRow) -> Node:
        (x, y), (fx, fy, moment) = row.direction, torsor
        return row.right - x * fx - y * fy - row.lever * moment / GYRATION

    if not rows:
        return [], ONE
    if len(rows) == 1:
        determinant = weight(rows[0], rows[0])
        return [free(rows[0]) / determinant], determinant
    weights = [[weight(row, other) for other in rows] for row in rows]
    if len(rows) == 3:
        return _solve_three(weights, [free(row) for row in rows])
    (a, b), (c, d) = weights
    determinant = a * d - b * c
    first, second = free(rows[0]), free(rows[1])
    return [(d * first - b * second) / determinant, (a * second - c * first) / determinant], determinant


def _solve_three(weights: list[list[Node]], right: list[Node]) -> tuple[list[Node], Node]:
    """The solution of three equations by cofactors, and their determinant."""

    def cofactor(i: int, j: int) -> Node:
        (a, b), (c, d) = ([row[n % 3] for n in (j + 1, j + 2)] for row in (weights[(i + k) % 3] for k in (1, 2)))
        return a * d - b * c

    determinant = weights[0][0] * cofactor(0, 0) + weights[0][1] * cofactor(0, 1) + weights[0][2] * cofactor(0, 2)
    values = [sum((cofactor(i, j) * right[i] for i in range(3)), ZERO) / determinant for j in range(3)]
    return values, determinant


def _equations(forms: tuple[ContactForm, ...], law: Laws, rotation: Rotation) -> Equations:
    count = len(forms)
    contacts = [_contact(form, k) for k, form in enumerate(forms)]
    surfaces = [form.surface.of_contact(k).surface for k, form in enumerate(forms)]
    slips = [contact.slip - surface.speed for contact, surface in zip(contacts, surfaces, strict=True)]
    ratios = [_ratio(form, k, slip) for k, (form, slip) in enumerate(zip(forms, slips, strict=True))]
    resisted = [k for k, form in enumerate(forms) if form.resists and form.kind not in NO_ROWS]
    couples = [symbol(f"rho_{k}") if rotation is Rotation.RESISTED and k in resisted else ZERO for k in range(count)]
    flat = [row for each in zip(contacts, forms, surfaces, ratios, couples, strict=True) for row in _rows(*each)]
    is_guided = any(form.guides is not None for form in forms)
    if rotation is Rotation.HELD and not is_guided:
        flat.append(_EquationRow((ZERO, ZERO), RADIUS, ZERO, (ZERO, ZERO), RADIUS))
    if len(flat) > 3:
        raise ValueError("a plate has at most three rows of contact with forces of their own")
    torsor = law.torsor
    multipliers, determinant = _multipliers(flat, torsor)
    acceleration = list(torsor[:2]) + [torsor[2] / GYRATION]
    for row, value in zip(flat, multipliers, strict=True):
        acceleration[0] = acceleration[0] + row.force[0] * value
        acceleration[1] = acceleration[1] + row.force[1] * value
        acceleration[2] = acceleration[2] + row.moment * value / GYRATION
    # Exactly, so that no rotation of roundings begins.
    if rotation is Rotation.HELD and not is_guided:
        acceleration[2] = ZERO
    elif any(form.along is not None for form in forms):
        acceleration[2] = _turning_of_side(forms, contacts)
    conditions: dict[str, Node] = {}
    slip_rates: dict[str, Node] = {}
    limits: dict[str, Node] = {}
    equalities: dict[str, Node] = {}
    columns: list[Node] = []
    rest = iter(multipliers)
    bound = ZERO  # of the contacts' couples together
    frictions: dict[int, Node] = {}
    for k, (contact, form, ratio, surface) in enumerate(zip(contacts, forms, ratios, surfaces, strict=True)):
        kind, rubs, slip = form.kind, form.rubs, slips[k]
        has_force = kind not in NO_ROWS and not is_guided
        normal = next(rest) if has_force else ZERO
        friction = next(rest) if has_force and kind is ContactRows.STICK else ratio * normal
        frictions[k] = friction
        if k in resisted:
            bound = bound + symbol(f"arm_{k}") * normal
        columns += [normal, friction, slip, contact.gap, contact.lift]
        if is_guided and kind not in NO_ROWS:
            off = _contradictions(contact, kind, surface, acceleration)
            columns[-len(COLUMNS) : 2 - len(COLUMNS)] = off
            for i, value in enumerate(off):
                equalities |= {f"row_{i}_above:{k}": value, f"row_{i}_below:{k}": -value}
        if form.turns:
            xi2 = symbol(f"xi2_{k}")
            limits |= {f"turn_low:{k}": xi2 - symbol(f"turn_low_{k}"), f"turn_high:{k}": symbol(f"turn_high_{k}") - xi2}
        if kind is ContactRows.AWAY:
            continue
        if kind is ContactRows.OPEN:
            conditions[f"gap:{k}"] = contact.gap
            if not form.stays:
                limits[f"lost:{k}"] = contact.clearance - symbol(f"lost_{k}")
                limits |= _ends(form.has_ends, k, "lost_")
            continue
        if not is_guided:  # its force is not unique there
            conditions |= _force_conditions(form, k, normal, friction)
        if kind is ContactRows.SLIP and rubs:
            sigma, (tx, ty) = symbol(f"sigma_{k}"), (contact.f.tx, contact.f.ty)
            conditions[f"slip:{k}"] = sigma * slip
            along = acceleration[0] * tx + acceleration[1] * ty
            rate = along - acceleration[2] * contact.h.hn - OMEGA**2 * contact.h.ht - surface.rate
            slip_rates[f"slip:{k}"] = sigma * rate
        if not form.stays:
            limits[f"fit:{k}"] = contact.clearance
            limits |= _ends(form.has_ends, k, "")
    rotating, rotating_rates, held = _resistance(
        rotation, acceleration[2], bound, None if is_guided else next(rest, None)
    )
    conditions |= rotating
    slip_rates |= rotating_rates
    equalities |= held
    if flat and not is_guided and any(form.rubs and form.kind is ContactRows.SLIP for form in forms):
        # As many rows as velocities determine the motion whatever the sign of their determinant.
        most = 2 if law.rotation_fixed else 3
        size, least = (determinant, PAINLEVE_LEAST) if len(flat) < most else (determinant**2, PAINLEVE_LEAST**2)
        limits["painleve"] = size - least
    positions = [X, Y, THETA]
    rates = [VX, VY, OMEGA]
    for k, contact in enumerate(contacts):
        positions += [symbol(f"xi1_{k}"), symbol(f"xi2_{k}")]
        rates += [contact.along_track / contact.f.P, _outline_rate(contact)]
    variables = (*positions, VX, VY, OMEGA)
    outputs = _outputs(count)(*torsor[:2], *acceleration, *columns)
    guards = {name: g for name, g in (conditions | limits).items() if g.symbols & {*variables, _MOTION[0]}}
    by_speed = [] if is_guided else [k for k, form in enumerate(forms) if _slips_by_speed(form)]
    checked, layout = _checked(law, {k: (forms[k], slips[k], frictions[k]) for k in by_speed})
    return Equations(
        variables, len(positions), (*rates, *acceleration), outputs, conditions | equalities, slip_rates, guards,
        checked, layout,
    )  # fmt: skip


def _resistance(
    rotation: Rotation, turning: Node, bound: Node, couple: Node | None
) -> tuple[dict[str, Node], dict[str, Node], dict[str, Node]]:
    """The conditions of rolling resistance, the rates of those that are velocities, and what vanishes in addition where
    the forces are not unique; `couple`: what prevents the rotation, in units of a force (None: not unique)."""
    if rotation is Rotation.RESISTED:
        tau = symbol("tau")
        return {"turn": tau * OMEGA * RADIUS}, {"turn": tau * turning * RADIUS}, {}
    if rotation is Rotation.FREE:
        return {}, {}, {}
    if couple is None:
        return {}, {}, {"turning_above": turning * RADIUS, "turning_below": -turning * RADIUS}
    # Forward is the direction in which the plate begins to turn when the couple reaches its bound.
    return {"couple_forward": bound / RADIUS + couple, "couple_backward": bound / RADIUS - couple}, {}, {}


def _slips_by_speed(form: ContactForm) -> bool:
    return form.kind is ContactRows.SLIP and isinstance(form.friction, CoulombBySpeed)


def _ratio(form: ContactForm, k: int, slip: Node) -> Node:
    """The friction force per normal force of a contact with that slip."""
    friction = form.friction.of_contact(k)
    if not isinstance(friction, CoulombBySpeed):
        return symbol(f"k_{k}") if form.rubs else ZERO
    sigma = symbol(f"sigma_{k}")
    return -sigma * friction.coefficient(sigma * slip) if form.kind is ContactRows.SLIP else ZERO


def _checked(law: Laws, slipping: dict[int, tuple[ContactForm, Node, Node]]) -> tuple[tuple[Node, ...], CheckLayout]:
    """What is checked along each step (`minimal.assembly`): arguments of laws of friction and of the load, then the
    friction forces of slipping contacts, given with slip and friction, and the load's."""
    first, others, forces = list[Node](), list[Node](), list[Node]()
    for k, (form, slip, friction) in slipping.items():
        arguments, of_order_one = form.friction.of_contact(k).checked_arguments(symbol(f"sigma_{k}") * slip)
        if arguments:
            first += arguments[:of_order_one]
            others += arguments[of_order_one:]
            forces.append(MASS * friction)
    by_load = law.checked_quantities
    if not forces:
        return by_load, CheckLayout()
    of_load = by_load[-LOAD_FORCES:] or (ZERO,) * LOAD_FORCES
    every = (*first, *others, *by_load[:-LOAD_FORCES], *forces, *of_load)
    return every, CheckLayout(len(first), len(forces) + LOAD_FORCES)


def _contradictions(
    contact: _ContactTerms, kind: ContactRows, surface: Surface, acceleration: list[Node]
) -> list[Node]:
    """By how much an acceleration misses the normal and the tangential row of a contact (m/s²)."""
    ax, ay, turning = acceleration
    rows = _rows_of_kind(contact, kind, surface, ZERO)
    off = [row.direction[0] * ax + row.direction[1] * ay + row.lever * turning - row.right for row in rows]
    return [*off, ZERO][:2]


def _force_conditions(form: ContactForm, k: int, normal: Node, friction: Node) -> dict[str, Node]:
    """The conditions on the force of a closed contact."""
    if form.kind is not ContactRows.STICK or not form.rubs:
        return {f"normal:{k}": normal}
    bound = symbol(f"stick_{k}") * normal
    return {f"cone_forward:{k}": bound + friction, f"cone_backward:{k}": bound - friction}


def _outline_rate(contact: _ContactTerms) -> Node:
    """ξ̇₂; at a corner from the turning of the tangents."""
    f, h = contact.f, contact.h
    return (contact.along_track * f.curvature - OMEGA) * h.sign if h.sign else contact.along_outline / h.P


@lru_cache(maxsize=32)
def _outputs(count: int) -> Any:
    """The columns of the outputs of that many contacts: the applied force per mass, accelerations, and each contact's
    `COLUMNS`. The first two have the names under which integrators look for the largest force."""
    names = [f"{column}_{k}" for k in range(count) for column in COLUMNS]
    return namedtuple("SeveralOutputs", ["normal", "friction", "ax", "ay", "omega_dot", *names])


def _ends(has_ends: tuple[bool, bool], k: int, prefix: str) -> dict[str, Node]:
    """Guards for the ends of the curves at contact k."""
    guards = dict[str, Node]()
    for name, bound, variable in zip(("track", "outline"), has_ends, ("xi1", "xi2"), strict=True):
        if bound:
            low, high, at = symbol(f"{name}_{k}_low"), symbol(f"{name}_{k}_high"), symbol(f"{variable}_{k}")
            guards |= {f"{prefix}{name}_start:{k}": at - low, f"{prefix}{name}_end:{k}": high - at}
    return guards
