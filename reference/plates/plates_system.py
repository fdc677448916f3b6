"""The rows (8)″ and (27) for several plates with contacts, eliminated by hand.

A contact's frame is that of a line, of an edge or of two centres of circles, where a corner is a circle of radius 0:
n from its base to its plate, t with n = U t. Of two discs the lift velocity is n·(v_B − v_A), the slip
t·(v_B − v_A) + r_A ω_A + r_B ω_B, and their rates have, besides those of the velocities, (t·(v_B − v_A))²/(r_A + r_B)
along n, as the frame turns with the centres. A corner at a from its centre of mass has the velocity v + ω U a and the
acceleration −ω² a besides. An edge turns with its plate: with d between the centres of mass, the gap's rate is
n·(v_B − v_A) − ω_A t·d, and both rates have −2 ω_A t·(v_B − v_A) − ω_A² n·d and
2 ω_A n·(v_B − v_A) − ω_A² t·d. With q̈₁ from (16),
(19) they are linear in the contacts' forces, which are eliminated one after the other (derived here).
"""

from __future__ import annotations

from collections import namedtuple
from functools import lru_cache
from typing import Any, NamedTuple

from cases.derivation import in_one_thread
from cases.expression_graph import ONE, ZERO, Node, call, node, symbol

from ..minimal.assembly import PAINLEVE_LEAST
from ..minimal.system import Equations, System
from ..several.equations import ContactRows

# Columns of the outputs for each contact.
COLUMNS = ("normal", "friction", "slip", "gap")

# A sum of velocities' or accelerations' components, by (plate, component).
Row = dict[tuple[int, int], Node]


class PlateContactForm(NamedTuple):
    """What the equations of one contact depend on: the numbers of its plate and of its base (None: a line), its rows,
    whether friction has a bound, whether its plate touches with a corner, what of its base does: "line", "disc",
    "edge" or "corner", and the contact (its place among all) that has the friction force of both where two corners of a
    plate stick to one line: only its sum is unique. Forces within both bounds exist if the sum is within theirs.
    """

    body: int
    base: int | None
    kind: ContactRows
    rubs: bool
    is_corner: bool = False
    side: str = "line"
    shares: int | None = None


class _PlateContactTerms(NamedTuple):
    """One contact's expressions: rows of the lift and slip velocity, both velocities, the gap, the parts of both rates
    that the velocities give, and the borders of a polygon's region, which are positive inside."""

    lift_row: Row
    slip_row: Row
    lift: Node
    slip: Node
    gap: Node
    turning: Node
    slip_turning: Node
    borders: tuple[Node, ...]


@lru_cache(maxsize=256)
@in_one_thread
def plates_system(forms: tuple[PlateContactForm, ...], count: int, resting: frozenset[int]) -> System:
    """The equations of that many plates with contacts of those forms; those that rest do not move."""
    return System(_equations(forms, count, resting))


def _at(name: str, body: int) -> tuple[Node, Node, Node]:
    """Three variables of a plate."""
    x, y, angle = (("x", "y", "theta"), ("vx", "vy", "omega"))[name == "velocity"]
    return symbol(f"{x}_{body}"), symbol(f"{y}_{body}"), symbol(f"{angle}_{body}")


def _rotate(x: Node, y: Node, theta: Node) -> tuple[Node, Node]:
    """A vector of a plate's frame in the fixed one."""
    c, s = call("cos", theta), call("sin", theta)
    return c * x - s * y, s * x + c * y


def _contact(form: PlateContactForm, k: int, resting: frozenset[int]) -> _PlateContactTerms:
    """One contact's expressions; plates at rest have no part in its rows, as a line has none."""
    body = form.body
    (x, y, theta), spin = _at("position", body), _at("velocity", body)[2]
    radius: Node = ZERO if form.is_corner else symbol(f"radius_{body}")
    if form.is_corner:
        ax, ay = _rotate(symbol(f"cx_{k}"), symbol(f"cy_{k}"), theta)
        x, y = x + ax, y + ay
    make = {"line": _on_line, "edge": _on_edge}.get(form.side, _on_circle)
    tx, ty, gap, lift_row, slip_row, turning, slip_turning, borders = make(form, k, x, y, radius)
    own: Row = {(body, 0): -ty, (body, 1): tx}
    slip: Row = {(body, 0): tx, (body, 1): ty, (body, 2): radius}
    if form.is_corner:
        across, along = ty * ax - tx * ay, tx * ax + ty * ay
        own[body, 2], slip[body, 2] = along, across
        turning, slip_turning = turning + spin * spin * across, slip_turning - spin * spin * along
    lift_row, slip_row = (
        {place: entry for place, entry in row.items() if place[0] not in resting}
        for row in (own | lift_row, slip | slip_row)
    )
    lift_now, slip_now = (_apply(row, lambda one: _at("velocity", one[0])[one[1]]) for row in (lift_row, slip_row))
    return _PlateContactTerms(lift_row, slip_row, lift_now, slip_now, gap, turning, slip_turning, borders)


class _Base(NamedTuple):
    """What the base gives: the tangent, the gap, the base's rows, both parts of the rates, and borders."""

    tx: Node
    ty: Node
    gap: Node
    lift_row: Row
    slip_row: Row
    turning: Node
    slip_turning: Node
    borders: tuple[Node, ...] = ()


def _on_line(form: PlateContactForm, k: int, x: Node, y: Node, radius: Node) -> _Base:
    tx, ty = symbol(f"tx_{k}"), symbol(f"ty_{k}")
    gap = (y - symbol(f"py_{k}")) * tx - (x - symbol(f"px_{k}")) * ty - radius
    return _Base(tx, ty, gap, {}, {}, ZERO, ZERO)


def _on_circle(form: PlateContactForm, k: int, x: Node, y: Node, radius: Node) -> _Base:
    """A disc on a disc, or on a corner of the base."""
    base, (vx, vy, _) = form.base, _at("velocity", form.body)
    assert base is not None
    (u, v, turn), (ux, uy, spin) = _at("position", base), _at("velocity", base)
    far, borders = radius, tuple[Node, ...]()
    if form.side == "disc":
        far = radius + symbol(f"radius_{base}")
    else:
        ax, ay = _rotate(symbol(f"ex_{k}"), symbol(f"ey_{k}"), turn)
        borders = _borders(form, k, x, y)
        u, v, ux, uy = u + ax, v + ay, ux - spin * ay, uy + spin * ax
    dx, dy = x - u, y - v
    # Of closed contacts this is the unit normal; the gap of open ones has the zeros of the distance's.
    tx, ty = dy / far, -dx / far
    gap = (dx * dx + dy * dy - far * far) / (2 * far)
    turning = (tx * (vx - ux) + ty * (vy - uy)) ** 2 / far
    lift_row: Row = {(base, 0): ty, (base, 1): -tx}
    slip_row: Row = {(base, 0): -tx, (base, 1): -ty}
    if form.side == "disc":
        return _Base(tx, ty, gap, lift_row, slip_row | {(base, 2): symbol(f"radius_{base}")}, turning, ZERO)
    out, aside = tx * ay - ty * ax, tx * ax + ty * ay
    lift_row[base, 2], slip_row[base, 2] = -aside, out
    return _Base(tx, ty, gap, lift_row, slip_row, turning + spin * spin * out, spin * spin * aside, borders)


def _on_edge(form: PlateContactForm, k: int, x: Node, y: Node, radius: Node) -> _Base:
    """A disc on a straight edge of the base."""
    base, (vx, vy, _) = form.base, _at("velocity", form.body)
    assert base is not None
    (u, v, turn), (ux, uy, spin) = _at("position", base), _at("velocity", base)
    tx, ty = _rotate(symbol(f"ex_{k}"), symbol(f"ey_{k}"), turn)
    dx, dy, wx, wy = x - u, y - v, vx - ux, vy - uy
    out, aside = dy * tx - dx * ty, dx * tx + dy * ty
    along, across = wx * tx + wy * ty, wy * tx - wx * ty
    lift_row: Row = {(base, 0): ty, (base, 1): -tx, (base, 2): -aside}
    slip_row: Row = {(base, 0): -tx, (base, 1): -ty, (base, 2): out - radius}
    turning = -2 * spin * along - spin * spin * out
    slip_turning = 2 * spin * across - spin * spin * aside
    gap = out - symbol(f"height_{k}") - radius
    return _Base(tx, ty, gap, lift_row, slip_row, turning, slip_turning, _borders(form, k, x, y))


def _borders(form: PlateContactForm, k: int, x: Node, y: Node) -> tuple[Node, ...]:
    """The values of both borders of the region of the base in which the disc is, m."""
    assert form.base is not None
    u, v, turn = _at("position", form.base)
    values = []
    for end in ("low", "high"):
        nx, ny = _rotate(symbol(f"{end}x_{k}"), symbol(f"{end}y_{k}"), turn)
        values.append((x - u) * nx + (y - v) * ny + symbol(f"{end}_{k}"))
    return tuple(values)


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
    contacts = [_contact(form, k, resting) for k, form in enumerate(forms)]
    gravity = symbol("gx"), symbol("gy"), ZERO
    rows, columns, right = list[Row](), list[Row](), list[Node]()
    ratios = [symbol(f"k_{k}") if form.rubs else ZERO for k, form in enumerate(forms)]
    for contact, form, ratio in zip(contacts, forms, ratios, strict=True):
        if form.kind is ContactRows.OPEN:
            continue
        sticks = form.kind is ContactRows.STICK and form.shares is None
        alone = form.shares is not None
        column = contact.lift_row if sticks or alone else {
            place: contact.lift_row.get(place, ZERO) + ratio * entry for place, entry in contact.slip_row.items()
        }  # fmt: skip
        free = _apply(contact.lift_row, lambda place: gravity[place[1]])
        rows, columns, right = [*rows, contact.lift_row], [*columns, column], [*right, -free - contact.turning]
        if sticks:
            free = _apply(contact.slip_row, lambda place: gravity[place[1]])
            rows, columns = [*rows, contact.slip_row], [*columns, contact.slip_row]
            right = [*right, -free - contact.slip_turning]
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
    forces = list[tuple[Node, Node]]()
    for form, ratio in zip(forms, ratios, strict=True):
        normal = next(values) if form.kind is not ContactRows.OPEN else ZERO
        alone = form.kind is ContactRows.STICK and form.shares is None
        forces.append((normal, next(values) if alone else ZERO if form.shares is not None else ratio * normal))
    for k, (contact, form) in enumerate(zip(contacts, forms, strict=True)):
        normal, friction = forces[k]
        outputs += [normal, friction, contact.slip, contact.gap]
        if form.kind is ContactRows.OPEN:
            conditions[f"gap:{k}"] = contact.gap
        elif form.kind is ContactRows.STICK and form.rubs and form.shares is None:
            others = [forces[j][0] for j, one in enumerate(forms) if one.shares == k]
            bound = symbol(f"stick_{k}") * sum(others, normal)
            conditions |= {f"normal:{k}": normal} if others else {}
            conditions[f"cone_forward:{k}"], conditions[f"cone_backward:{k}"] = bound + friction, bound - friction
        else:
            conditions[f"normal:{k}"] = normal
        if form.kind is ContactRows.SLIP and form.rubs:
            sigma = symbol(f"sigma_{k}")
            conditions[f"slip:{k}"] = sigma * contact.slip
            slip_rates[f"slip:{k}"] = sigma * (
                _apply(contact.slip_row, lambda place: acceleration[place]) + contact.slip_turning
            )
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
    for k, contact in enumerate(contacts):
        guards |= {f"{end}:{k}": value for end, value in zip(("low", "high"), contact.borders, strict=False)}
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
