"""The rows (8)″ and (27) for several plates with contacts, eliminated by hand.

All plates are discs, so a contact's frame is that of a line or of two centres: n from its base to its plate, t with
n = U t. Its lift velocity is n·(v_B − v_A), its slip t·(v_B − v_A) + r_A ω_A + r_B ω_B, and their rates have, besides
those of the velocities, (t·(v_B − v_A))²/(r_A + r_B) along n, as the frame turns with the centres. With q̈₁ from (16),
(19) they are linear in the contacts' forces, which are eliminated one after the other (derived here).
"""

from __future__ import annotations

from collections import namedtuple
from functools import lru_cache
from typing import Any, NamedTuple

from cases.derivation import in_one_thread
from cases.expression_graph import ONE, ZERO, Node, node, symbol

from ..minimal.assembly import PAINLEVE_LEAST
from ..minimal.system import Equations, System
from ..several.equations import ContactRows

# Columns of the outputs for each contact.
COLUMNS = ("normal", "friction", "slip", "gap")

# A sum of velocities' or accelerations' components, by (plate, component).
Row = dict[tuple[int, int], Node]


class PlateContactForm(NamedTuple):
    """What the equations of one contact depend on: the numbers of its plate and of its base (None: a line), its rows,
    and whether friction has a bound."""

    body: int
    base: int | None
    kind: ContactRows
    rubs: bool


class _PlateContactTerms(NamedTuple):
    """One contact's expressions: rows of the lift and slip velocity, both velocities, the gap, and the part of the
    lift's rate that the velocities give."""

    lift_row: Row
    slip_row: Row
    lift: Node
    slip: Node
    gap: Node
    turning: Node


@lru_cache(maxsize=256)
@in_one_thread
def plates_system(forms: tuple[PlateContactForm, ...], count: int, resting: frozenset[int]) -> System:
    """The equations of that many plates with contacts of those forms; those that rest do not move."""
    return System(_equations(forms, count, resting))


def _at(name: str, body: int) -> tuple[Node, Node, Node]:
    """Three variables of a plate."""
    x, y, angle = (("x", "y", "theta"), ("vx", "vy", "omega"))[name == "velocity"]
    return symbol(f"{x}_{body}"), symbol(f"{y}_{body}"), symbol(f"{angle}_{body}")


def _contact(form: PlateContactForm, k: int) -> _PlateContactTerms:
    body, base = form.body, form.base
    (x, y, _), (vx, vy, _), radius = _at("position", body), _at("velocity", body), symbol(f"radius_{body}")
    if base is None:
        tx, ty = symbol(f"tx_{k}"), symbol(f"ty_{k}")
        gap = (y - symbol(f"py_{k}")) * tx - (x - symbol(f"px_{k}")) * ty - radius
        turning = ZERO
    else:
        (u, v, _), (ux, uy, _), far = _at("position", base), _at("velocity", base), radius + symbol(f"radius_{base}")
        dx, dy = x - u, y - v
        # Of closed contacts this is the unit normal; the gap of open ones has the zeros of the distance's.
        tx, ty = dy / far, -dx / far
        gap = (dx * dx + dy * dy - far * far) / (2 * far)
        turning = (tx * (vx - ux) + ty * (vy - uy)) ** 2 / far
    lift_row: Row = {(body, 0): -ty, (body, 1): tx}
    slip_row: Row = {(body, 0): tx, (body, 1): ty, (body, 2): radius}
    if base is not None:
        lift_row |= {(base, 0): ty, (base, 1): -tx}
        slip_row |= {(base, 0): -tx, (base, 1): -ty, (base, 2): symbol(f"radius_{base}")}
    lift, slip = (_apply(row, lambda one: _at("velocity", one[0])[one[1]]) for row in (lift_row, slip_row))
    return _PlateContactTerms(lift_row, slip_row, lift, slip, gap, turning)


def _apply(row: Row, value) -> Node:
    """The sum of a row's entries times the values of their components."""
    total = ZERO
    for place, entry in row.items():
        total = total + entry * value(place)
    return total


def _inverse(place: tuple[int, int]) -> Node:
    """The inverse mass, or inverse moment of inertia, of a component."""
    body, component = place
    return symbol(f"{'w' if component < 2 else 'v'}_{body}")


def _product(row: Row, column: Row) -> Node:
    """An entry of the Delassus matrix."""
    total = ZERO
    for place, entry in row.items():
        if place in column:
            total = total + entry * column[place] * _inverse(place)
    return total


def _solve(matrix: list[list[Node]], right: list[Node]) -> tuple[list[Node], Node]:
    """The solution by elimination, and the product of the pivots in units of the diagonal's."""
    n, determinant = len(right), ONE
    matrix, right = [list(row) for row in matrix], list(right)
    for i in range(n):
        for j in range(i + 1, n):
            if matrix[j][i] is ZERO:
                continue
            factor = matrix[j][i] / matrix[i][i]
            for k in range(i + 1, n):
                matrix[j][k] = matrix[j][k] - factor * matrix[i][k]
            right[j] = right[j] - factor * right[i]
    values: list[Node] = [ZERO] * n
    for i in reversed(range(n)):
        rest = right[i]
        for k in range(i + 1, n):
            rest = rest - matrix[i][k] * values[k]
        values[i] = rest / matrix[i][i]
        determinant = determinant * matrix[i][i]
    return values, determinant


def _equations(forms: tuple[PlateContactForm, ...], count: int, resting: frozenset[int]) -> Equations:
    contacts = [_contact(form, k) for k, form in enumerate(forms)]
    gravity = symbol("gx"), symbol("gy"), ZERO
    rows, columns, right = list[Row](), list[Row](), list[Node]()
    ratios = [symbol(f"k_{k}") if form.rubs else ZERO for k, form in enumerate(forms)]
    for contact, form, ratio in zip(contacts, forms, ratios, strict=True):
        if form.kind is ContactRows.OPEN:
            continue
        sticks = form.kind is ContactRows.STICK
        column = contact.lift_row if sticks else {
            place: contact.lift_row.get(place, ZERO) + ratio * entry for place, entry in contact.slip_row.items()
        }  # fmt: skip
        free = _apply(contact.lift_row, lambda place: gravity[place[1]])
        rows, columns, right = [*rows, contact.lift_row], [*columns, column], [*right, -free - contact.turning]
        if sticks:
            free = _apply(contact.slip_row, lambda place: gravity[place[1]])
            rows, columns, right = [*rows, contact.slip_row], [*columns, contact.slip_row], [*right, -free]
    matrix = [[_product(row, column) for column in columns] for row in rows]
    multipliers, pivots = _solve(matrix, right)
    acceleration: dict[tuple[int, int], Node] = {(b, c): gravity[c] for b in range(count) for c in range(3)}
    for column, value in zip(columns, multipliers, strict=True):
        for place, entry in column.items():
            acceleration[place] = acceleration[place] + _inverse(place) * entry * value
    conditions: dict[str, Node] = {}
    slip_rates: dict[str, Node] = {}
    outputs: list[Node] = []
    values = iter(multipliers)
    for k, (contact, form, ratio) in enumerate(zip(contacts, forms, ratios, strict=True)):
        normal = next(values) if form.kind is not ContactRows.OPEN else ZERO
        friction = next(values) if form.kind is ContactRows.STICK else ratio * normal
        outputs += [normal, friction, contact.slip, contact.gap]
        if form.kind is ContactRows.OPEN:
            conditions[f"gap:{k}"] = contact.gap
        elif form.kind is ContactRows.STICK and form.rubs:
            bound = symbol(f"stick_{k}") * normal
            conditions[f"cone_forward:{k}"], conditions[f"cone_backward:{k}"] = bound + friction, bound - friction
        else:
            conditions[f"normal:{k}"] = normal
        if form.kind is ContactRows.SLIP and form.rubs:
            sigma = symbol(f"sigma_{k}")
            conditions[f"slip:{k}"] = sigma * contact.slip
            slip_rates[f"slip:{k}"] = sigma * _apply(contact.slip_row, lambda place: acceleration[place])
    # A force that vanishes identically has the sign of its roundings: its guard is above 0 by more than these.
    pressing = ("normal", "cone_forward", "cone_backward")
    guards = {
        name: value + symbol(f"slack_{name.partition(':')[2]}") if name.partition(":")[0] in pressing else value
        for name, value in conditions.items()
    }
    if any(form.rubs and form.kind is ContactRows.SLIP for form in forms) and len(rows) > 1:
        scale = ONE
        for i in range(len(rows)):
            scale = scale * matrix[i][i]
        guards["painleve"] = pivots / scale - node(PAINLEVE_LEAST)
    variables = tuple(v for kind in ("position", "velocity") for b in range(count) for v in _at(kind, b))
    rates = [v for b in range(count) for v in (_at("velocity", b) if b not in resting else (ZERO,) * 3)]
    rates += [acceleration[b, c] if b not in resting else ZERO for b in range(count) for c in range(3)]
    guards = {name: g for name, g in guards.items() if g.symbols & set(variables)}
    record = _outputs(count, len(forms))(symbol("gx"), symbol("gy"), *rates[3 * count :], *outputs)
    return Equations(variables, 3 * count, tuple(rates), record, conditions, slip_rates, guards)


@lru_cache(maxsize=64)
def _outputs(count: int, contacts: int) -> Any:
    """The columns of the outputs: the applied force per mass, under the names by which integrators look for the largest
    force, accelerations of all plates, and each contact's `COLUMNS`."""
    names = [f"{name}_{b}" for b in range(count) for name in ("ax", "ay", "omega_dot")]
    names += [f"{column}_{k}" for k in range(contacts) for column in COLUMNS]
    return namedtuple("PlatesOutputs", ["normal", "friction", *names])
