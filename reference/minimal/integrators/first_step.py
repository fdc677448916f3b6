"""The first short step of a phase, by its Taylor polynomial alone.

A phase begins with a guard at zero that is known to grow, often with the square of time. Event detection would find
that root again, and a cool-down after it would hide the next. So a first step leaves the start.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import exp, inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from ...endings import BREAKDOWN
from ...scales import EPS, TOUCHES
from ..defect_check import Expansion, clear_part
from ..modes import Phase
from ..series import Series

# Length of the first step as a part of its polynomial's range: the polynomial is exact there to rounding, and a
# quantity that grows with the fourth power of time is still well above its own rounding.
PART = 1e-3
# Highest power used there: later terms are less than (NEAR + 2) PART**(NEAR + 1) of the plate's size.
NEAR = 8
# Any guard is positive at the start above this part of its value at the step's end: a guard that grows from a rounding
# of zero with the third power of time is 1e-9 of its size at the end.
NOT_ZERO = 1e-6
# The bounds on terms that the largest root sets are lowered by more than their rounding. Roots below SLOWEST (1/s) set
# none: their powers may be subnormal.
BELOW, SLOWEST = 1.0 - 1e-9, 1e-9
# Roundings of a gap, in those of the plate's size and place: a dozen operations.
ROUNDINGS = 16
# A gap whose rate is rounding at the step's end is looked at again in a step LATER times as long: the rate of a contact
# that opens grows with the second power of time. The polynomial is exact there, too, to 1e-17.
LATER = 10.0
# The step is shortened tenfold this many times if a guard is not positive at its end: the rest is then rounding.
SHORTER = 9


class FirstStep(NamedTuple):
    """The result of the first step: time (s), state, number of steps (0 or 1), the longest step (s) that may follow,
    and the guard that is at zero, if any."""

    time: float
    state: tuple[float, ...] | list[float]
    steps: int
    longest: float
    guard: str | None = None


def leave(phase: Phase, coefficients: np.ndarray, t: float, y, end: float, tolerance: float) -> FirstStep:
    """Take the first step from t; all guards are positive at its end and half-way, or the result names one that is not.

    A guard that is positive at t may also fall below zero and rise again in between: such a step is shortened, so that
    event detection finds the zero.

    `coefficients` (variables, order + 1) are those of the phase's Taylor polynomial at (t, y).
    """
    system, parameters, lengths = phase.system, phase.parameters, phase.lengths
    rows, guards = coefficients.tolist(), system.guards_of_numbers
    # If all terms vanish, the forces balance, and a load may change them: they enter by the time in which they would
    # move the plate by its size.
    normal, friction, *starts = system.forces_and_guards_of_numbers(t, y, parameters)
    if normal != normal:  # one of the guards may have no value here
        (normal, friction), starts = system.forces_of_numbers(t, y, parameters), guards(t, y, parameters)
    travel = (max(abs(normal), abs(friction)) / phase.size) ** 0.5
    states = _states(len(rows), len(lengths), len(rows[0]))
    part, span, zero = PART, end - t, 0
    longest, often, h, half, state, check = states(rows, lengths, travel, part, span)
    if not isfinite(check) and not np.isfinite(coefficients).all():  # the sum of large ones may overflow
        return FirstStep(t, y, 0, inf, BREAKDOWN)
    if not starts or not 0.0 < often < inf:
        return FirstStep(t, y, 0, longest)  # no motion and no contact force: no guard leaves zero
    growing: set[int] = set()
    for _ in range(SHORTER):
        clear = 1.0
        if phase.features or phase.checks_load:
            clear = clear_part(phase, Expansion(t, h, coefficients), tolerance)
            if clear < 1.0:
                _, _, h, half, state, _ = states(rows, lengths, travel, part, clear * h)
        halves, ends = guards(t + 0.5 * h, half, parameters), guards(t + h, state, parameters)
        if growing:
            halves, ends = (_without_rounding(phase, y, values, growing) for values in (halves, ends))
        # A guard that is positive at the end and half-way has left zero and not come back; else the step is shortened
        # until the event lies behind it.
        for i, start in enumerate(starts):  # it takes half as long as a zip
            middle, last = halves[i], ends[i]
            slope = 4.0 * middle - 3.0 * start - last
            if not (middle > 0.0 and last > 0.0) or 0.0 < -slope < 4.0 * (start - 2.0 * middle + last):
                break
        else:
            return FirstStep(t + h, state, 1, longest)
        values = halves + ends
        for i, place in _lowest_places(starts, halves, ends) if all(v > 0.0 for v in values) else ():
            if not guards(t + place * h, states(rows, lengths, travel, part, place * h)[-2], parameters)[i] > 0.0:
                values = [*starts[:i], 0.0]
                break
        zero = next((i for i, value in enumerate(values) if not value > 0.0), -1)
        if zero < 0:
            return FirstStep(t + h, state, 1, longest)
        opening = opening_gaps(phase, y, starts, ((t + 0.5 * h, half), (t + h, state))) - growing
        if not opening and clear == 1.0:
            _, _, later, before, after, _ = states(rows, lengths, travel, LATER * part, span)
            opening = opening_gaps(phase, y, starts, ((t + 0.5 * later, before), (t + later, after))) - growing
        growing |= opening | {i for i, pair in enumerate(zip(halves, ends, strict=True)) if min(pair) > 0.0}
        if not opening:
            part *= 0.1
            _, _, h, half, state, _ = states(rows, lengths, travel, part, span)
    return FirstStep(t, y, 0, longest, tuple(system.guards)[zero % len(starts)])


def _without_rounding(phase: Phase, y, values: Sequence[float], growing: set[int]) -> list[float]:
    """The guards' values with those gaps positive that are known to grow and are rounding in this step: a contact that
    opens as its force vanishes has a gap that grows with the third power of time."""
    least = gap_rounding(phase, y)
    gaps = {i for i, name in enumerate(phase.system.guards) if i in growing and name.startswith("gap")}
    return [least if i in gaps and abs(value) <= least else value for i, value in enumerate(values)]


def opening_gaps(phase: Phase, y, starts: Sequence[float], later: Sequence[tuple[float, list[float]]]) -> set[int]:
    """The guards that are gaps of rounding at the start and grow at all of these later times and states: their rates
    are thousands of times more precise than they are."""
    least, names = gap_rounding(phase, y), tuple(phase.system.guards)
    gaps = {i for i, name in enumerate(names) if name.startswith("gap") and abs(starts[i]) <= least}
    conditions = tuple(phase.system.conditions)
    for time, state in later if gaps else ():
        bounds = [EPS * abs(value) for value in state]
        series = phase.system.expand(time, state, bounds, phase.parameters, 1)[1]
        for i in list(gaps):
            value = series[conditions.index(names[i])]
            if not (isinstance(value, Series) and value.c[1] > value.e[1]):
                gaps.remove(i)
    return gaps


def gap_rounding(phase: Phase, y) -> float:
    """The rounding of a gap, m, in a state: none of one that is followed, as it is a variable that grows from zero."""
    if phase.follows:
        return 0.0
    return ROUNDINGS * EPS * (phase.size + abs(y[0]) + abs(y[1]))


def runge_kutta(rates: Callable, t, y: np.ndarray, h) -> np.ndarray:
    """One step of the classical method of order four."""
    k1 = np.asarray(rates(t, y))
    k2 = np.asarray(rates(t + h / 2, y + h / 2 * k1))
    k3 = np.asarray(rates(t + h / 2, y + h / 2 * k2))
    k4 = np.asarray(rates(t + h, y + h * k3))
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def dip(start, half, end):
    """Whether a guard that is positive at a step's start, half-way and at its end may reach zero between, by the
    parabola through these values; its second derivative and its slope at the start, per step. Of numbers or arrays."""
    bend, slope = 2.0 * (start - 2.0 * half + end), 4.0 * half - 3.0 * start - end
    dips = (slope < 0.0) & (start > NOT_ZERO * end) & (-slope < 2.0 * bend) & (slope * slope >= 4.0 * bend * start)
    return dips, bend, slope


def _lowest_places(starts: Sequence[float], halves: Sequence[float], ends: Sequence[float]) -> list[tuple[int, float]]:
    """The guards that may reach zero inside a step, by number, and the part of the step at which they are lowest: by
    the parabola through their values at its start, half-way and at its end."""
    places = []
    for i, (start, half, end) in enumerate(zip(starts, halves, ends, strict=True)):
        dips, bend, slope = dip(start, half, end)
        if dips:
            places.append((i, -0.5 * slope / bend))
    return places


def open_gaps(phase: Phase, t: float, y) -> list[tuple[int, float]]:
    """The gaps (m) of several contacts that are open at t, with the numbers of their guards."""
    numbers = [i for i, name in enumerate(phase.system.guards) if name.startswith("gap")]
    if not numbers:
        return []
    values = phase.system.guards_of_numbers(t, y, phase.parameters)
    least = TOUCHES * (phase.size + abs(y[0]) + abs(y[1]))
    return [(i, values[i]) for i in numbers if values[i] > least]


@lru_cache(maxsize=64)
def _states(variables: int, positions: int, terms: int) -> Callable[..., tuple[float, float, float, list, list, float]]:
    """(coefficients, lengths, travel, part, span) -> the longest step (s) that the upper half of the coefficients
    allows; the rate (1/s) at which a term grows to the plate's size, at least `travel`; h = part/rate, at most `span`;
    the polynomials' values at h/2 and at h; and a sum that is finite only if all coefficients are. Written out: loops,
    and calls of max, take twice as long.

    heyoka's rule (said to be of Jorba & Zou 2005; known to us, not looked up) uses the last two terms. A motion from
    rest at a symmetric place has only every fourth power, and both may vanish; so may all even or all odd ones.
    """
    names = [[f"c{i}_{k}" for k in range(terms)] for i in range(variables)]
    # Those that are compared with no bound; the others are summed where they are not within their bounds.
    upper_half = terms // 2
    unbounded = [c for i, row in enumerate(names) for c in row[: 1 if i < positions else upper_half]]
    units = [f"length_{i}" for i in range(positions)]
    bounds = [f"bound_{i}" for i in range(positions)]
    lines = [
        "def states(coefficients, lengths, travel, part, span):",
        f"    {', '.join('(' + ', '.join(row) + ')' for row in names)}, = coefficients",
        f"    {', '.join(units)}, = lengths",
        "    largest = 1.0",
        f"    check = {' + '.join(unbounded)}",
        *(f"    if abs({row[0]}) > largest: largest = abs({row[0]})" for row in names),
        "    upper = ratio = bound_0 = 0.0",
        *_largest_root("upper", names, [], range(terms - 1, upper_half - 1, -1), " / largest"),
        "    check += bound_0",  # no coefficient exceeds an infinite bound
        f"    often = ratio = {' = '.join(bounds)} = 0.0",
        *_largest_root("often", names[:positions], units, range(1, upper_half), ""),
        # Terms of the upper half are at most largest upper^k: mostly below those that were found.
        f"    shortest = min({', '.join(units)})",
        f"    most = upper * (largest / shortest) ** {1.0 / upper_half!r} if largest > shortest else upper",
        f"    if not most <= {BELOW!r} * often:",
        *("    " + line for line in _largest_root("often", names[:positions], units, range(upper_half, terms), "")),
        f"    check += {' + '.join(bounds)}",
        f"    longest = {exp(-2.0)!r} / upper if upper else inf",
        "    if not often > travel: often = travel",
        "    h = part / often if 0.0 < often < inf else span",
        "    if span < h: h = span",
        "    half = 0.5 * h",
    ]
    for time in ("half", "h"):
        for i, row in enumerate(names):
            value, *lower = row[NEAR::-1]
            for term in lower:
                value = f"({value}) * {time} + {term}"
            lines.append(f"    {time}{i} = {value}")
    half, end = (", ".join(f"{time}{i}" for i in range(variables)) for time in ("half", "h"))
    lines.append(f"    return longest, often, h, [{half}], [{end}], check")
    scope: dict[str, Any] = {"inf": inf}
    exec("\n".join(lines), scope)
    return scope["states"]


def _largest_root(name: str, rows: list[list[str]], units: list[str], powers: range, divisor: str) -> list[str]:
    """Lines that raise `name` to the largest k-th root, over these k, of the largest term k, in parts of its unit if
    there are units. Most terms are within the bounds that the largest root so far sets: theirs are not computed. In the
    upper half the last roots are often the largest, of all terms the first."""
    bounds = [f"bound_{i}" for i in range(len(units) or 1)]
    sizes_of_bounds = [f"{BELOW!r} * size * {unit}" for unit in units] or [f"{BELOW!r} * size"]
    lines = []
    for k in powers:
        column = [row[k] for row in rows]
        # Two comparisons: Python takes nearly twice as long for one that is a chain.
        limits = zip(column, bounds if units else bounds * len(rows), strict=False)
        within = [f"{c} <= {b} and {c} >= low_{b}" for c, b in limits]
        sizes = [f"abs({c}) / {unit}" for c, unit in zip(column, units, strict=False)] or [f"abs({c})" for c in column]
        lines += [
            *(f"    {bound} *= ratio; low_{bound} = -{bound}" for bound in bounds),
            f"    if not ({' and '.join(within)}):",
            f"        check += {' + '.join(column)}",
            f"        size = {sizes[0]}",
            *(f"        if {size} > size: size = {size}" for size in sizes[1:]),
            f"        root = (size{divisor}) ** {1.0 / k!r}",
            f"        if root > {name}:",
            f"            {name} = root",
            f"            if root > {SLOWEST!r}:",
            f"                ratio = {'root' if powers.step > 0 else '1.0 / root'}",
            *(f"                {b} = {value}" for b, value in zip(bounds, sizes_of_bounds, strict=True)),
        ]
    return lines
