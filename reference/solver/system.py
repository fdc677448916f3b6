"""The rows (8)″ and (9)′ of contacts of several plates, and (27) eliminated by hand.

The variables are (x, y, θ) of every plate, (ξ₁, ξ₂) of every contact, the gap of one that is followed, and (vx, vy, ω)
of every plate. `contact_terms` has a contact's rows. With q̈₁ from (16) and (19) they are linear in the forces of the
contacts, which are eliminated one after the other.
"""

from __future__ import annotations

from collections import namedtuple
from functools import lru_cache
from typing import Any, NamedTuple

from cases.derivation import in_one_thread
from cases.formulas.expression_graph import ONE, ZERO, Node, node, substitute, symbol

from ..effect_laws import Laws
from ..effect_laws.applied_forces import MASS, AppliedLoad
from ..effect_laws.lifted_formulas import Conditions
from ..minimal.assembly import _MOTION, PAINLEVE_LEAST, end_guards
from ..minimal.system import LOAD_FORCES, Equations, System, checked_with_friction
from .contact_terms import (
    NO_ROWS,
    ContactForm,
    ContactRows,
    ContactTerms,
    Row,
    apply_row,
    contact_terms,
    radius,
    variables_of,
)
from .plate_numbers import Sides, rigid_pairs

# Columns of the outputs for each contact.
COLUMNS = ("normal", "friction", "slip", "gap")


@lru_cache(maxsize=256)
@in_one_thread
def solver_system(
    forms: tuple[ContactForm, ...], count: int, resting: frozenset[int], law: Laws,
    idle: tuple[str, ...] = (), anchors: frozenset[int] = frozenset(),
    further: tuple[AppliedLoad | None, ...] = (),
) -> System:  # fmt: skip
    """The equations of that many plates with contacts of those forms; those that rest do not move. `idle`: guards that
    stay at zero, which have a slack (a parameter, m/s²); `anchors`: plates whose contacts have forces that keep them
    where they are; `further`: the loads of all plates but the first."""
    return System(_equations(forms, count, resting, law, anchors, further).with_slack(idle))


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
    """The solution by elimination, and the product of the pivots."""
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


class _Loads(NamedTuple):
    """The accelerations of all plates without contacts, and what is checked along each step: arguments of the loads'
    functions, and forces and moments (N, N m)."""

    acceleration: dict[tuple[int, int], Node]
    arguments: tuple[Node, ...]
    forces: tuple[Node, ...]


def _loads(law: Laws, count: int, further: tuple[AppliedLoad | None, ...]) -> _Loads:
    """The case's load acts on the first plate, weight on all."""

    def of_plate(body: int, expressions: tuple[Node, ...]) -> tuple[Node, ...]:
        own = (*variables_of("position", body), *variables_of("velocity", body))
        return tuple(substitute(expressions, dict(zip(_MOTION[1:], own, strict=True))))

    fx, fy, moment = of_plate(0, law.torsor)
    own_spin = [load.forces[2] for load in law.loads if isinstance(load, AppliedLoad) and load.gives_spin]
    result = {(0, 0): fx, (0, 1): fy, (0, 2): own_spin[0] if own_spin else moment * MASS * _inverse((0, 2))}
    gx, gy, _ = law.torsor_of_all
    quantities = [of_plate(0, law.checked_quantities)]
    for body in range(1, count):
        result |= {(body, 0): gx, (body, 1): gy, (body, 2): ZERO}
        load = further[body - 1] if further else None
        if load is not None:
            for c, force in enumerate(of_plate(body, load.forces)):
                turns = c == 2 and load.gives_spin
                result[body, c] = result[body, c] + (force if turns else force * _inverse((body, c)))
            quantities.append(of_plate(body, load.checked_quantities))
    arguments, forces = zip(*((some[:-LOAD_FORCES], some[-LOAD_FORCES:]) for some in quantities), strict=True)
    return _Loads(result, sum(arguments, ()), sum(forces, ()))


def _slip_and_spin(form: ContactForm, term: ContactTerms) -> tuple[Node, Node]:
    """Slip velocity and relative spin of a contact, zero where its mode has none."""
    spin = apply_row(form.turning_row, lambda one: variables_of("velocity", one[0])[2])
    return (
        ZERO if form.kind is ContactRows.STICK else term.slip,
        ZERO if form.holds else spin,
    )


def _add_own_force(
    free: dict[tuple[int, int], Node], form: ContactForm, term: ContactTerms, force: tuple[Node, Node, Node]
) -> None:
    """Add what a force of the user's own at a contact (N, N, N m) gives both plates."""
    along, across, couple = force
    for place, entry in term.slip_row.items():
        free[place] = free[place] + _inverse(place) * (entry * along + term.lift_row[place] * across)
    for place, sign in form.turning_row.items():
        free[place] = free[place] + _inverse(place) * sign * couple


class _Solution(NamedTuple):
    """Normal and friction force of each contact, the accelerations, Painlevé's determinant, which no friction makes
    vanish if it is None, and the couples that hold plates which do not turn against each other, over the radius of
    gyration."""

    forces: list[tuple[Node, Node]]
    acceleration: dict[tuple[int, int], Node]
    painleve: Node | None
    couples: dict[Sides, Node]


def _forces(forms: tuple[ContactForm, ...], terms: list[ContactTerms], free: dict[tuple[int, int], Node]) -> _Solution:
    rows, columns, right = list[Row](), list[Row](), list[Node]()
    ratios = [
        form.friction.ratio_at(term.slip) if form.kind is ContactRows.SLIP else ZERO
        for form, term in zip(forms, terms, strict=True)
    ]
    for term, form, ratio in zip(terms, forms, ratios, strict=True):
        if form.kind in NO_ROWS:
            continue
        sticks = form.kind is ContactRows.STICK
        column = dict(term.lift_row) if sticks else {
            place: term.lift_row[place] + ratio * term.slip_row[place] for place in term.lift_row
        }  # fmt: skip
        if not form.holds:
            for place, sign in form.turning_row.items():
                column[place] = column[place] + sign * form.resistance.couple
        if form.guides is not None:
            for row, force, bias, is_used in zip(
                (term.lift_row, term.slip_row), (column, term.slip_row), (term.lift_bias, term.slip_bias), form.guides,
                strict=True,
            ):  # fmt: skip
                if is_used:
                    rows, columns = [*rows, row], [*columns, force]
                    right.append(-apply_row(row, free.__getitem__) - bias)
            continue
        rows, columns = [*rows, term.lift_row], [*columns, column]
        right.append(-apply_row(term.lift_row, free.__getitem__) - term.lift_bias)
        if sticks and form.shares is None:
            rows, columns = [*rows, term.slip_row], [*columns, term.slip_row]
            right.append(-apply_row(term.slip_row, free.__getitem__) - term.slip_bias)
    still = rigid_pairs(tuple((form.sides, 0) for form in forms if form.holds))
    for sides in still:
        turning: Row = {(b, 2): s * radius(sides[0]) for b, s in zip(sides, (ONE, -ONE), strict=False)}
        rows, columns = [*rows, turning], [*columns, turning]
        right.append(-apply_row(turning, free.__getitem__))
    matrix = [[_product(row, column) for column in columns] for row in rows]
    multipliers, pivots = _solve(matrix, right)
    acceleration = dict(free)
    for column, value in zip(columns, multipliers, strict=True):
        for place, entry in column.items():
            acceleration[place] = acceleration[place] + _inverse(place) * entry * value
    values, forces = iter(multipliers), list[tuple[Node, Node]]()
    for form, ratio in zip(forms, ratios, strict=True):
        if form.guides is not None and form.kind not in NO_ROWS:
            forces.append((ZERO, ZERO))  # not unique
            for _ in range(sum(form.guides)):
                next(values)
            continue
        normal = next(values) if form.kind not in NO_ROWS else ZERO
        alone = form.kind is ContactRows.STICK and form.shares is None
        forces.append((normal, next(values) if alone else ZERO if form.shares is not None else ratio * normal))
    painleve = None
    if rows and any(form.friction.has_bound and form.kind is ContactRows.SLIP for form in forms):
        scale = ONE  # the determinant of rows that do not couple, without friction
        for row in rows:
            scale = scale * _product(row, row)
        painleve = pivots / scale
        if len(rows) >= 3 * len({body for row in rows for body, _ in row}):
            painleve = painleve * painleve  # as many rows as velocities determine the motion whatever its sign
    # Exactly, so that no rotation of roundings begins.
    for sides in sorted(still, key=len):
        acceleration[sides[0], 2] = acceleration[sides[1], 2] if len(sides) > 1 else ZERO
    for k, form in sorted(enumerate(forms), key=lambda each: each[1].base is not None):
        if form.along is not None:
            acceleration[form.body, 2] = _turning_of_side(form, terms[form.along], terms[k], acceleration)
    return _Solution(forces, acceleration, painleve, dict(zip(still, values, strict=True)))


def _turning_of_side(
    form: ContactForm, one: ContactTerms, other: ContactTerms, acceleration: dict[tuple[int, int], Node]
) -> Node:
    """ω̇ of a plate that lies flat, from the difference of both normal rows (8)″, in which translation vanishes: that
    of its base, and what centrifugal terms add."""
    lever = other.lift_row[form.body, 2] - one.lift_row[form.body, 2]
    own = ZERO if form.base is None else acceleration[form.base, 2]
    return own + (one.lift_bias - other.lift_bias) / lever


def _equations(
    forms: tuple[ContactForm, ...], count: int, resting: frozenset[int], law: Laws,
    anchors: frozenset[int], further: tuple[AppliedLoad | None, ...],
) -> Equations:  # fmt: skip
    terms, loads = [contact_terms(form, k) for k, form in enumerate(forms)], _loads(law, count, further)
    free, motions = loads.acceleration, [_slip_and_spin(form, term) for form, term in zip(forms, terms, strict=True)]
    for form, term, motion in zip(forms, terms, motions, strict=True):
        if form.kind not in NO_ROWS:
            for effect in law.own:
                _add_own_force(free, form, term, effect.force(*motion))
    forces, acceleration, painleve, couples = _forces(forms, terms, free)
    gaps = {k: symbol(f"gap_{k}") for k, form in enumerate(forms) if form.has_gap}
    acceleration |= {(b, c): ZERO for b in anchors for c in range(3)}  # exactly, so that no motion of roundings begins
    conditions, slip_rates, limits = dict[str, Node](), dict[str, Node](), dict[str, Node]()
    equalities = dict[str, Node]()
    outputs = list[Node]()
    per_mass = [[force * _inverse((form.body, 0)) for force in pair] for form, pair in zip(forms, forces, strict=True)]
    for k, (term, form) in enumerate(zip(terms, forms, strict=True)):
        outputs += [*forces[k], term.slip, gaps.get(k, term.gap)]
        normal, friction = per_mass[k]  # conditions have the units of accelerations, whatever that of mass
        if form.kind not in NO_ROWS:
            ends = [effect.ends(*motions[k]) for effect in law.own]
            limits |= {f"{name}:{k}": end for some in ends for name, end in some.items()}
        if form.kind is ContactRows.AWAY:  # of plates at rest
            continue
        limits |= _at(k, end_guards(form.ends, f"_{k}"))
        if form.kind is ContactRows.OPEN:
            conditions[f"gap:{k}"] = gaps.get(k, term.gap)
            if term.clearance is not None:
                limits[f"lost:{k}"] = term.clearance - symbol(f"lost_{k}")
            if form.has_room:
                limits[f"room:{k}"] = symbol(f"room_{k}") - gaps[k]
            continue
        if term.clearance is not None:
            limits[f"fit:{k}"] = term.clearance
        if form.guides is not None:  # its force is not unique
            equalities |= _contradictions(term, form, k, acceleration)
        elif form.kind is ContactRows.STICK and form.friction.has_bound and form.shares is None:
            others = [per_mass[j][0] for j, one in enumerate(forms) if one.shares == k]
            conditions |= {f"normal:{k}": normal} if others else {}
            conditions |= _at(k, form.friction.stick_conditions(sum(others, normal), friction))
        else:
            conditions[f"normal:{k}"] = normal
        if form.kind is ContactRows.SLIP:
            slip_rate = apply_row(term.slip_row, acceleration.__getitem__) + term.slip_bias
            conditions |= _at(k, form.friction.slip_conditions(term.slip))
            slip_rates |= _at(k, form.friction.slip_conditions(slip_rate))
    is_guided = any(form.guides is not None for form in forms)
    for k, form in enumerate(forms):
        own = [i for i, one in enumerate(forms) if one.resistance.has_bound and one.sides == form.sides]
        if not own or own[0] != k or (is_guided and form.holds):
            continue
        bound = sum((forms[i].resistance.bound(per_mass[i][0]) for i in own), ZERO)
        turns, turn_rates = _resistance(form, acceleration, bound, couples)
        conditions, slip_rates = conditions | _at(k, turns), slip_rates | _at(k, turn_rates)
    if painleve is not None and painleve.symbols:
        limits["painleve"] = painleve - node(PAINLEVE_LEAST**2)
    places = [symbol(f"xi{i}_{k}") for k in range(len(forms)) for i in (1, 2)]
    positions = [*(v for b in range(count) for v in variables_of("position", b)), *places, *gaps.values()]
    velocities = [v for b in range(count) for v in variables_of("velocity", b)]
    still = {symbol_ for b in resting for symbol_ in variables_of("velocity", b)}
    rates = [ZERO if v in still else v for v in velocities]
    for form, term in zip(forms, terms, strict=True):
        rates += term.rates if form.kind is not ContactRows.AWAY else (ZERO, ZERO)
    rates += [apply_row(terms[k].lift_row, lambda one: variables_of("velocity", one[0])[one[1]]) for k in gaps]
    rates += [ZERO if b in resting else acceleration[b, c] for b in range(count) for c in range(3)]
    variables = (*positions, *velocities)
    guards = {name: g for name, g in (conditions | limits).items() if g.symbols & {*variables, _MOTION[0]}}
    applied = [acceleration[b, c] if b not in resting else ZERO for b in range(count) for c in range(3)]
    record = _outputs(count, len(forms))(free[0, 0], free[0, 1], *applied, *outputs)
    frictions = [
        (*form.friction.checked_arguments(term.slip), force)
        for form, term, (_, force) in zip(forms, terms, forces, strict=True) if form.kind is ContactRows.SLIP
    ]  # fmt: skip
    checked, layout = checked_with_friction(frictions, loads.arguments, loads.forces)
    return Equations(
        variables, len(positions), tuple(rates), record, conditions | equalities, slip_rates, guards, checked, layout
    )  # fmt: skip


def _contradictions(
    term: ContactTerms, form: ContactForm, k: int, acceleration: dict[tuple[int, int], Node]
) -> dict[str, Node]:
    """By how much the acceleration misses the rows that are not used (m/s²), of both signs: it must not."""
    result = dict[str, Node]()
    rows = (term.lift_row, term.lift_bias), (term.slip_row, term.slip_bias)
    for i, (row, bias) in enumerate(rows[: 2 if form.kind is ContactRows.STICK else 1]):
        if form.guides is not None and not form.guides[i]:
            off = apply_row(row, acceleration.__getitem__) + bias
            result |= {f"row_{i}_above:{k}": off, f"row_{i}_below:{k}": -off}
    return result


def _at(k: int, conditions: Conditions) -> Conditions:
    """Conditions of contact k, by their names among those of all contacts."""
    return {f"{name}:{k}": condition for name, condition in conditions.items()}


def _resistance(
    form: ContactForm, acceleration: dict[tuple[int, int], Node], bound: Node, couples: dict[Sides, Node]
) -> tuple[Conditions, Conditions]:
    """The conditions of rolling resistance of two plates, of which this is the first contact, and the rates of those
    that are velocities."""
    length, row = radius(form.body), form.turning_row
    if not form.holds:
        spin = apply_row(row, lambda one: variables_of("velocity", one[0])[2])
        turning = apply_row(row, acceleration.__getitem__)
        return form.resistance.turn_conditions(spin, length), form.resistance.turn_conditions(turning, length)
    couple = couples[form.sides] * length * _inverse((form.body, 0))
    return form.resistance.hold_conditions(bound, couple, length), {}


@lru_cache(maxsize=64)
def _outputs(count: int, contacts: int) -> Any:
    """The columns of the outputs: the applied force per mass, under the names by which integrators look for the largest
    force, accelerations of all plates, and each contact's `COLUMNS`."""
    names = [f"{name}_{b}" for b in range(count) for name in ("ax", "ay", "omega_dot")]
    names += [f"{column}_{k}" for k in range(contacts) for column in COLUMNS]
    return namedtuple("SolverOutputs", ["normal", "friction", *names])
