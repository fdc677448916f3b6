"""The numbers of many scenarios of one case as columns, without making each scenario as a `Case`.

A case function is Python code, so only calling it shows what a parameter changes. It is called for each value of each
parameter alone. If every number of the scene then depends on one parameter at most, the columns follow, and calls at
the corners and at random places must give the same numbers to the last bit. Otherwise it is called for every scenario.
"""

from __future__ import annotations

import dis
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from types import CodeType, FunctionType
from typing import Any, NamedTuple

import numpy as np

from cases import (
    Belt,
    Case,
    CaseError,
    Chain,
    CoulombFriction,
    Curve,
    Drive,
    Load,
    RollingResistance,
)
from cases.contact import start_motion
from cases.contact.overlap_search import deepest_overlap, first_overlap, span
from cases.own_effects import own_effects
from cases.scene.piece_case import has_pieces
from cases.scene.supports import has_slip_law

from ..curvature_proof import fits
from ..effect_laws import laws
from .geometry import level_parameters, places

# If a parameter has at most this many values (as a part of the number of scenarios), the function is called with each:
# beyond that, calling it for each scenario is as quick.
FEW = 0.25
# Of more values, this many are tried, including the smallest and the largest.
TRIES = 33
# This many random scenarios, in addition to the corners, must agree with the columns.
PROBES = 12

Make = Callable[..., Case]  # from parameters to a case; raises CaseError


class Structure(NamedTuple):
    """What scenarios must share to be simulated together: the equations, and how the start is specified."""

    track: Any
    outline: Any
    laws: Any
    ends: tuple
    kinds: tuple[type, ...]
    in_contact: bool
    level_start: bool  # whether ξ₂ follows from θ = 0
    plain: bool  # whether there is nothing a step could pass over
    general: bool  # whether each is simulated alone for what it has


@dataclass(frozen=True, eq=False)
class ScenarioGroup:
    """Scenarios of one structure: their `rows` in the chunk, and each of their numbers by name, shape (n,).

    `base` is one of them as a case; `same` is true if all have its curves. `alone(i)` makes the i-th as a case.
    """

    rows: np.ndarray
    base: Case
    same: bool
    numbers: dict[str, np.ndarray]
    alone: Callable[[int], Case] = field(repr=False)

    def constants(self, which: str) -> tuple[np.ndarray, ...]:
        """The sizes of the "track" or the "outline"."""
        count = len(self.base.track.constants if which == "track" else self.base.plate.outline.constants)
        return tuple(self.numbers[f"{which}_c{i}"] for i in range(count))

    def only(self, indices: np.ndarray) -> ScenarioGroup:
        """The group of some of these scenarios."""
        numbers = {name: column[indices] for name, column in self.numbers.items()}
        return ScenarioGroup(self.rows[indices], self.base, self.same, numbers, partial(_nth, self.alone, indices))


class RejectedScenario(NamedTuple):
    """A scenario with invalid parameters: its row and the error message."""

    row: int
    reason: str


def scenes(
    make: Make, columns: Mapping[str, np.ndarray], even: bool
) -> tuple[list[ScenarioGroup], list[RejectedScenario]]:
    """The scenarios with these parameters, `columns` of shape (n,), grouped by structure; and the rejected ones.

    `even`: whether the case's function does the same for all values (`straight`)."""
    n = len(next(iter(columns.values())))

    def alone(i: int) -> Case:
        return make(**{name: float(column[i]) for name, column in columns.items()})

    together = _together(make, columns, alone, n, even)
    if together is not None:
        return [together], []
    return _each(alone, n)


def structure(case: Case) -> Structure:
    """The structure of a case: what it must share with other scenarios to be simulated with them."""
    track, outline = case.track, case.plate.outline
    ends = tuple((c.domain is None, c.period is None) for c in (track, outline))
    kinds = tuple(type(effect) for effect in case.effects)
    level_start = case.start.xi2 is None
    load = case.effect(Load)
    features = (track.features, outline.features, load.features if load else None)
    plain = all(feature is None or feature.plain for feature in features) and not laws(case).checked_quantities
    plain = plain and case.effect(Belt) is None and case.plate.turns and not has_pieces(case)
    forms, in_contact, general = (_form(track), _form(outline)), case.start.in_contact, _is_general(case)
    return Structure(*forms, laws(case), ends, kinds, in_contact, level_start, plain and not general, general)


def _is_general(case: Case) -> bool:
    """Whether a case has what rules on arrays do not know: they are for one contact with a track at rest and constant
    coefficients."""
    further = case.supports, case.others, case.pairs, own_effects(case.effects), has_slip_law(case)
    return any(further) or case.effect(Drive) is not None


def _form(curve: Curve) -> Any:
    """What curves of one structure share; of a chain or a curve in pieces all of it: its numbers are no parameters."""
    if isinstance(curve, Chain):
        return curve
    return curve.structure if curve.parts is None else curve.parts.key


def numbers(case: Case) -> dict[str, float]:
    """Every number of a scenario by its name in the equations, without a ξ₂ and θ that follow from the others; none of
    a case that goes alone for what it has."""
    if _is_general(case):
        return {}
    start, plate = case.start, case.plate
    values = {"xi1": start.xi1, "slip": start.slip, "omega": start.omega, "duration": case.duration}
    values |= {"mass": plate.mass, "inertia": plate.inertia}
    values |= {} if start.xi2 is None else {"xi2": start.xi2}
    for law in (*laws(case).loads, laws(case).belt):
        values |= law.values(case)
    if friction := case.effect(CoulombFriction):
        values |= {"mu": friction.mu, "mu_stick": friction.stick}
    if resistance := case.effect(RollingResistance):
        values["arm"] = resistance.arm
    for name, curve in (("track", case.track), ("outline", plate.outline)):
        values |= {f"{name}_c{i}": value for i, value in enumerate(curve.constants)}
        if curve.domain:
            values |= {f"{name}_low": curve.domain[0], f"{name}_high": curve.domain[1]}
    return values


def _place(case: Case) -> dict[str, float]:
    """The numbers of a scenario including ξ₂ and θ; none of a case that goes alone for what it has."""
    if not (some := numbers(case)):
        return some
    initial = start_motion(case)
    return {**some, "xi2": initial.xi2, "theta": initial.theta}


# --- one by one -------------------------------------------------------------------------------------------------------


def _each(alone: Callable[[int], Case], n: int) -> tuple[list[ScenarioGroup], list[RejectedScenario]]:
    """Make every scenario as a case, and group them by structure."""
    groups: dict[Structure, list[tuple[int, dict[str, float], Case]]] = {}
    bad = []
    for i in range(n):
        try:
            case = alone(i)
            groups.setdefault(structure(case), []).append((i, _place(case), case))
        except CaseError as problem:
            bad.append(RejectedScenario(i, str(problem)))
        except Exception as problem:  # the function is user code
            bad.append(RejectedScenario(i, f"the case cannot be made: {type(problem).__name__}: {problem}"))
    scenario_groups = []
    for members in groups.values():
        rows = np.array([i for i, _, _ in members])
        base = members[0][2]
        same = all((c.track, c.plate.outline) == (base.track, base.plate.outline) for _, _, c in members)
        columns = {name: np.array([values[name] for _, values, _ in members]) for name in members[0][1]}
        scenario_groups.append(ScenarioGroup(rows, base, same, columns, partial(_nth, alone, rows)))
    return scenario_groups, bad


def _nth(alone: Callable[[int], Case], rows: np.ndarray, i: int) -> Case:
    return alone(int(rows[i]))


# --- all at once ------------------------------------------------------------------------------------------------------


class _Column(NamedTuple):
    """The effect of one parameter alone: the numbers it changes, each by scenario."""

    changes: dict[str, np.ndarray]
    is_complete: bool  # whether the function was called with each of its values


def _together(make: Make, columns: Mapping[str, np.ndarray], alone, n: int, even: bool) -> ScenarioGroup | None:
    """The columns of all scenarios; None if they cannot be derived without making each scenario."""
    if n < 4 * PROBES:
        return None
    first = {name: float(column[0]) for name, column in columns.items()}
    try:
        base = make(**first)
        base_values, base_structure = _place(base), structure(base)
        if not base_values:
            return None
        effects = {
            name: _alone(make, first, name, columns[name], base_values, base_structure, even) for name in columns
        }
        all_numbers = {name: np.full(n, value) for name, value in base_values.items()}
        for name, effect in effects.items():
            if effect is None or any(
                name in all_numbers and not _constant(all_numbers[name]) for name in effect.changes
            ):
                return None  # some number depends on two parameters
            all_numbers |= effect.changes
        of_place = {name for name, e in effects.items() if e is not None and any(map(_of_place, e.changes))}
        if len(of_place) > 1 or any(e is not None and not e.is_complete and not _simple(e) for e in effects.values()):
            return None
        same = all(_constant(all_numbers[name]) for name in all_numbers if name.startswith(("track_", "outline_")))
        is_incomplete = any(not effects[name].is_complete for name in of_place)  # type: ignore[union-attr]
        if is_incomplete and not _place_again(base, base_structure, all_numbers):
            return None
        for i in _probes(columns, n):
            case = alone(i)
            exact = numbers(case)
            if structure(case) != base_structure or any(all_numbers[name][i] != value for name, value in exact.items()):
                return None
    except Exception:
        return None  # some scenario is invalid: making each of them shows which
    return ScenarioGroup(np.arange(n), base, same, all_numbers, alone)


def _of_place(number: str) -> bool:
    """Whether a number belongs to the start's place or the curves, which together decide whether the plate fits."""
    return number in ("xi1", "xi2", "theta") or number.startswith(("track_", "outline_"))


def _simple(effect: _Column) -> bool:
    """Whether a parameter changes no number of the curves."""
    return not any(name.startswith(("track_", "outline_")) for name in effect.changes)


def _constant(column: np.ndarray) -> bool:
    return bool(np.all(column == column[0]))


def _alone(
    make: Make,
    first: dict[str, float],
    name: str,
    column: np.ndarray,
    base_values: dict[str, float],
    base_structure: Structure,
    even: bool,
) -> _Column | None:
    """The effect of one parameter while the others keep their first values; None if it cannot be derived."""
    values, which = np.unique(column, return_inverse=True)
    is_complete = len(values) <= FEW * len(column)
    if not is_complete:
        if not even:
            return None
        values = values[np.linspace(0, len(values) - 1, TRIES).round().astype(int)]
    samples = []
    for value in values.tolist():
        case = make(**{**first, name: value})
        if structure(case) != base_structure:
            return None
        samples.append(_place(case))
    changes = {}
    for number, value in base_values.items():
        column_of = np.array([row[number] for row in samples])
        if np.all(column_of == value):
            continue
        if is_complete:
            changes[number] = column_of[which.reshape(-1)]
        elif np.all(column_of == values):
            changes[number] = column
        elif not (number == "theta" or (number == "xi2" and base_structure.level_start)):
            return None
    return _Column(changes, is_complete)


def _place_again(base: Case, base_structure: Structure, all_numbers: dict[str, np.ndarray]) -> bool:
    """Compute ξ₂ and θ for starts that were not all made as cases; returns whether the plate fits at each."""
    track, outline = base.track, base.plate.outline
    xi1 = all_numbers["xi1"]
    if not base_structure.in_contact:
        return False
    if track.domain and not track.period and not np.all((track.domain[0] <= xi1) & (xi1 <= track.domain[1])):
        return False
    if base_structure.level_start:
        all_numbers["xi2"] = level_parameters(track, outline, xi1)
    xi2 = all_numbers["xi2"]
    if not np.isfinite(xi2).all():
        return False
    sizes = [tuple(np.full(len(xi1), c) for c in curve.constants) for curve in (track, outline)]
    f, h = places(track, sizes[0], xi1), places(outline, sizes[1], xi2)
    if not np.all(h.curvature > f.curvature):
        return False
    all_numbers["theta"] = track.tangent_angle(xi1) - outline.tangent_angle(xi2)
    c, s = np.cos(all_numbers["theta"]), np.sin(all_numbers["theta"])
    x, y = f.x - (c * h.x - s * h.y), f.y - (s * h.x + c * h.y)
    theta = all_numbers["theta"]
    if first_overlap(track, outline, x, y, theta, xi1) is not None:
        return False
    if fits(track, outline, *span(track, xi1, outline.sizes[0])):
        return True
    starts = dict.fromkeys(zip(x.tolist(), y.tolist(), theta.tolist(), xi1.tolist(), strict=True))
    return all(deepest_overlap(track, outline, *start) is None for start in starts)


def _probes(columns: Mapping[str, np.ndarray], n: int) -> Iterator[int]:
    """The numbers of scenarios at the corners, if there are any, and of random ones (always the same)."""
    ends = [(int(np.argmin(column)), int(np.argmax(column))) for column in columns.values()]
    yield from dict.fromkeys(i for pair in ends for i in pair)
    lows_highs = [(column.min(), column.max()) for column in columns.values()]
    for corner in product(*lows_highs) if len(lows_highs) <= 4 else ():
        there = np.all([c == v for c, v in zip(columns.values(), corner, strict=True)], axis=0)
        yield from np.flatnonzero(there)[:1].tolist()
    yield from np.random.default_rng(n).integers(0, n, PROBES).tolist()


def straight(function: Callable) -> bool:
    """Whether a function and the functions of its module that it calls have no branch and no loop, so that it does the
    same for all values."""
    waiting, visited_functions = [function], []
    while waiting:
        now = waiting.pop()
        if now in visited_functions:
            continue
        visited_functions.append(now)
        code = getattr(now, "__code__", None)
        if code is None or any(map(_jumps, _codes(code))):
            return False
        functions = (now.__globals__.get(name) for part in _codes(code) for name in part.co_names)
        waiting += [f for f in functions if isinstance(f, FunctionType) and f.__module__ == function.__module__]
    return True


_JUMPS = {*dis.hasjrel, *dis.hasjabs}


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _jumps(code: CodeType) -> bool:
    return any(step.opcode in _JUMPS for step in dis.get_instructions(code))
