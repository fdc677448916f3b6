"""One contact's part of the equations: its form, and the expressions of its rows (8)″ and (9)′ and places.

A contact's frame is that of its base's curve, turned with the base. For an open contact with the gap g the places
follow from the rows with the velocity of the base's frame at the plate's point: tangents stay parallel,
ω_A + κ_A ṡ_A = ω_B + κ_B ṡ_B, and the gap stays normal, v + ṡ_B − ṡ_A = −g (ω_A + κ_A ṡ_A).
"""

from __future__ import annotations

from enum import Enum
from typing import Any, NamedTuple

from cases.formulas.expression_graph import ONE, ZERO, Node, call, node, sqrt, symbol

from ..effect_laws.belt import FixedSurface
from ..effect_laws.friction import Frictionless
from ..effect_laws.rolling_resistance import NoResistance
from ..minimal.elimination import GYRATION
from ..minimal.frames import Frame, frame
from .plate_numbers import Sides


def radius(body: int) -> Node:
    """The radius of gyration of a plate, m; its reach if it does not turn."""
    return sqrt(GYRATION) if body == 0 else symbol(f"radius_{body}")


class ContactRows(Enum):
    """What a contact contributes to the equations: nothing, a normal row, or a normal and a tangential row. A contact
    that is away is one of plates at rest."""

    AWAY = "away"
    OPEN = "open"
    SLIP = "slip"
    STICK = "stick"


NO_ROWS = ContactRows.AWAY, ContactRows.OPEN

# A sum of velocities' or accelerations' components, by (plate, component).
Row = dict[tuple[int, int], Node]


class ContactForm(NamedTuple):
    """What the equations of one contact depend on: the numbers of its plate and of its base (None: fixed), the
    structures of both elements (a corner's is the sign of its turn), its rows, at which ends of both elements it
    passes on (`regimes.ends_of`), its law of friction, the surface of its base, and the contact (its place among all)
    that has the friction force of both where two contacts of the same plates stick on one line: only its sum is unique.
    `resistance`: of its rotation, `holds`: it prevents that; `guides`: where forces are not unique, which of its rows
    are used; `along`: an earlier contact of the same straight side. `has_gap`: the gap of an open one is a
    variable, as a low hop needs it more precisely than poses have it; `has_room`: up to a limit.
    """

    body: int
    base: int | None
    track: Any
    outline: Any
    kind: ContactRows
    ends: tuple[str, ...]
    friction: Frictionless = Frictionless()
    surface: FixedSurface = FixedSurface()
    shares: int | None = None
    resistance: NoResistance = NoResistance()
    holds: bool = False
    guides: tuple[bool, bool] | None = None
    along: int | None = None
    has_gap: bool = False
    has_room: bool = False

    @property
    def sides(self) -> Sides:
        """The numbers of the plates that touch."""
        return (self.body,) if self.base is None else (self.body, self.base)

    @property
    def turning_row(self) -> Row:
        """The row of the rotation of its plates against each other."""
        return {(body, 2): sign for body, sign in zip(self.sides, (ONE, -ONE), strict=False)}


class ContactTerms(NamedTuple):
    """One contact's expressions: frames of both elements, rows of lift and slip velocity, slip relative to the base's
    surface, gap, the parts of both rates that the velocities give, ṡ on both elements, the rates of ξ₁ and ξ₂, and the
    clearance of the curvatures (None at a corner)."""

    lift_row: Row
    slip_row: Row
    slip: Node
    gap: Node
    lift_bias: Node
    slip_bias: Node
    rates: tuple[Node, Node]
    clearance: Node | None


def variables_of(name: str, body: int | None) -> tuple[Node, Node, Node]:
    """Three variables of a plate, zeros for what is fixed."""
    if body is None:
        return ZERO, ZERO, ZERO
    x, y, angle = (("x", "y", "theta"), ("vx", "vy", "omega"))[name == "velocity"]
    return symbol(f"{x}_{body}"), symbol(f"{y}_{body}"), symbol(f"{angle}_{body}")


def apply_row(row: Row, value) -> Node:
    """The sum of a row's entries times the values of their components."""
    total = ZERO
    for place, entry in row.items():
        total = total + entry * value(place)
    return total


def contact_terms(form: ContactForm, k: int) -> ContactTerms:
    f = frame(form.track, symbol(f"xi1_{k}"), f"track_{k}_")
    h = frame(form.outline, symbol(f"xi2_{k}"), f"outline_{k}_")
    body, base = form.body, form.base
    (x, y, _), (u, v, turn) = variables_of("position", body), variables_of("position", base)
    spin, turning = variables_of("velocity", body)[2], variables_of("velocity", base)[2]
    tx, ty = f.tx, f.ty
    if base is not None:
        c, s = call("cos", turn), call("sin", turn)
        tx, ty = c * tx - s * ty, s * tx + c * ty
    lift_row: Row = {(body, 0): -ty, (body, 1): tx, (body, 2): h.ht}
    slip_row: Row = {(body, 0): tx, (body, 1): ty, (body, 2): -h.hn}
    if base is not None:
        lift_row |= {(base, 0): ty, (base, 1): -tx, (base, 2): -f.ht}
        slip_row |= {(base, 0): -tx, (base, 1): -ty, (base, 2): f.hn}
    velocity = lambda one: variables_of("velocity", one[0])[one[1]]  # noqa: E731
    slip = apply_row(slip_row, velocity)
    gap = (y - v) * tx - (x - u) * ty + h.hn - f.hn
    apart = gap if form.kind is ContactRows.OPEN else ZERO
    along_track, along_outline, tangent_rate, clearance = contact_rates(f, h, slip, spin, turning, apart)
    lift_bias = spin * along_outline - turning * along_track - spin * spin * h.hn - slip * tangent_rate
    slip_bias = -spin * spin * h.ht
    if base is not None:
        lift_bias, slip_bias = lift_bias + turning * turning * f.hn, slip_bias + turning * turning * f.ht
    rate1 = node(f.sign) * (tangent_rate - turning) if f.sign else along_track / f.P
    rate2 = node(h.sign) * (tangent_rate - spin) if h.sign else along_outline / h.P
    surface = form.surface.surface
    return ContactTerms(
        lift_row, slip_row, slip - surface.speed, gap, lift_bias, slip_bias - surface.rate, (rate1, rate2), clearance
    )


class Bend(NamedTuple):
    """What `contact_rates` needs of a curve, or of a corner, at a contact: the sign of its turn (0: it is a curve), and
    the curvature (1/m)."""

    sign: float
    curvature: float


def contact_rates(f: Frame | Bend, h: Frame | Bend, slip, spin, turning, gap=0) -> tuple[Any, Any, Any, Any]:
    """ṡ on both curves (m/s), the rate at which the common tangent turns (rad/s), and the clearance (1/m; None at a
    corner), as nodes or as numbers; `turning`: the spin of the base."""
    if f.sign:  # the base's point is a corner
        along = -(slip + gap * spin) / (1 + gap * h.curvature)
        return 0, along, spin + h.curvature * along, None
    seen = slip + gap * turning
    shrink = 1 - gap * f.curvature
    if h.sign:
        along = seen / shrink
        return along, 0, turning + f.curvature * along, None
    clearance = h.curvature * shrink - f.curvature
    along = (h.curvature * seen - (spin - turning)) / clearance if clearance else 0
    return along, along * shrink - seen, turning + f.curvature * along, clearance
