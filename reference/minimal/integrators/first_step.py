"""The first short step of a phase, by its Taylor polynomial alone.

A phase begins with a guard at zero that is known to grow, often with the square of time. Event detection would find
that root again, and a cool-down after it would hide the next. So a first step leaves the start.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import exp, inf, isfinite
from typing import NamedTuple

import numpy as np

from ..defect_check import Expansion, clear_part
from ..modes import Phase
from .segment import BREAKDOWN

# Length of the first step as a part of its polynomial's range: the polynomial is exact there to rounding, and a
# quantity that grows with the fourth power of time is still well above its own rounding.
PART = 1e-3
# Highest power used there: later terms are less than (NEAR + 2) PART**(NEAR + 1) of the plate's size.
NEAR = 8
# A gap above this part of the plate's size and place is open: smaller ones are rounding, and grow.
OPEN = 1e-12
# Any guard is positive at the start above this part of its value at the step's end: a guard that grows from a rounding
# of zero with the third power of time is 1e-9 of its size at the end.
NOT_ZERO = 1e-6
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
    # One call instead of a check of each number; large ones may overflow in it.
    if not isfinite(np.vdot(coefficients, coefficients)) and not np.isfinite(coefficients).all():
        return FirstStep(t, y, 0, inf, BREAKDOWN)
    rows = coefficients.tolist()
    longest, often = _scales(phase, rows, t)
    if not phase.system.guards or not 0.0 < often < inf:
        return FirstStep(t, y, 0, longest)  # no motion and no contact force: no guard leaves zero
    states, guards, parameters = _states(len(rows), len(rows[0])), phase.system.guards_of_numbers, phase.parameters
    part, span, values = PART, end - t, [0.0]
    starts = guards(t, y, parameters)
    for _ in range(SHORTER):
        h = min(part / often, span)
        if phase.checks_steps:
            h = min(h, clear_part(phase, Expansion(t, h, coefficients), tolerance) * h)
        half, state = states(rows, 0.5 * h, h)
        values = guards(t + 0.5 * h, half, parameters) + guards(t + h, state, parameters)
        # A guard that is positive at the end and half-way has left zero and not come back; else the step is shortened
        # until the event lies behind it.
        for value in values:
            if not value > 0.0:
                break
        else:
            for i, place in _lowest_places(starts, values):
                if not guards(t + place * h, states(rows, place * h, h)[0], parameters)[i] > 0.0:
                    values = [*starts[:i], 0.0]
                    break
            else:
                return FirstStep(t + h, state, 1, longest)
        part *= 0.1
    names = tuple(phase.system.guards)
    zero = next(i for i, value in enumerate(values) if not value > 0.0)
    return FirstStep(t, y, 0, longest, names[zero % len(names)])


def _lowest_places(starts: Sequence[float], values: Sequence[float]) -> list[tuple[int, float]]:
    """The guards that may reach zero inside a step, by number, and the part of the step at which they are lowest: by
    the parabola through their values at its start, and half-way and at its end (`values`)."""
    places = []
    for i, (start, half, end) in enumerate(zip(starts, values, values[len(starts) :], strict=False)):
        bend, slope = 2.0 * (start - 2.0 * half + end), 4.0 * half - 3.0 * start - end
        if slope < 0.0 and start > NOT_ZERO * end and -slope < 2.0 * bend and slope * slope >= 4.0 * bend * start:
            places.append((i, -0.5 * slope / bend))
    return places


def open_gaps(phase: Phase, t: float, y) -> list[tuple[int, float]]:
    """The gaps (m) of several contacts that are open at t, with the numbers of their guards."""
    numbers = [i for i, name in enumerate(phase.system.guards) if name.startswith("gap")]
    if not numbers:
        return []
    values, least = phase.system.guards_of_numbers(t, y, phase.parameters), OPEN * (phase.size + abs(y[0]) + abs(y[1]))
    return [(i, values[i]) for i in numbers if values[i] > least]


def _scales(phase: Phase, rows: list[list[float]], t: float) -> tuple[float, float]:
    """The longest step (s) that the upper half of the coefficients allows, and the rate (1/s) at which a term grows to
    the plate's size or the forces move the plate that far."""
    # If all terms vanish, the forces balance, and a load may change them: they enter by the time in which they would
    # move the plate by its size.
    normal, friction = phase.system.forces_of_numbers(t, [row[0] for row in rows], phase.parameters)
    fastest, growth = _roots(len(rows), len(phase.lengths), len(rows[0]))(rows, phase.lengths)
    travel = (max(abs(normal), abs(friction)) / phase.size) ** 0.5
    return exp(-2.0) / fastest if fastest else inf, max(travel, growth)


@lru_cache(maxsize=64)
def _roots(variables: int, positions: int, terms: int) -> Callable[..., tuple[float, float]]:
    """(coefficients, lengths) -> the largest k-th root of the terms k in the upper half, in parts of the state or of 1;
    and that of all terms of positions, in parts of their lengths. Written out with comparisons: loops, and
    calls of max, take twice as long.

    heyoka's rule (said to be of Jorba & Zou 2005; known to us, not looked up) uses the last two terms. A motion from
    rest at a symmetric place has only every fourth power, and both may vanish; so may all even or all odd ones.
    """
    names = [[f"c{i}_{k}" for k in range(terms)] for i in range(variables)]
    units = [f"length_{i}" for i in range(positions)]
    lines = [
        "def roots(coefficients, lengths):",
        f"    {', '.join('(' + ', '.join(row) + ')' for row in names)} = coefficients",
        f"    {', '.join(units)}, = lengths",
        "    upper = growth = 0.0",
        "    largest = 1.0",
    ]
    for k in range(terms):
        column, power = [row[k] for row in names], f" ** {1.0 / max(k, 1)!r}"
        lines += [f"    {c} = abs({c})" for c in column]
        if k == 0:
            lines += [f"    if {c} > largest: largest = {c}" for c in column]
        if k >= terms // 2:
            lines += [f"    size = {column[0]}", *(f"    if {c} > size: size = {c}" for c in column[1:])]
            lines += [
                "    if size:",
                f"        size = (size / largest){power}",
                "        if size > upper: upper = size",
            ]
        if k >= 1:
            lines.append(f"    size = {column[0]} / {units[0]}")
            lines += [
                f"    if {c} / {unit} > size: size = {c} / {unit}"
                for c, unit in zip(column[1:], units[1:], strict=False)
            ]
            lines += ["    if size:", f"        size = size{power}", "        if size > growth: growth = size"]
    lines.append("    return upper, growth")
    scope: dict[str, Callable[..., tuple[float, float]]] = {}
    exec("\n".join(lines), scope)
    return scope["roots"]


@lru_cache(maxsize=64)
def _states(variables: int, terms: int) -> Callable[..., tuple[list[float], list[float]]]:
    """(coefficients, h, k) -> the polynomials' values at h and at k, by Horner's rule, written out."""
    used = [f"c{k}" for k in range(min(NEAR + 1, terms))]
    rest = ", *_" if terms > len(used) else ""
    lines = ["def states(coefficients, h, k):", f"    {', '.join(f'row{i}' for i in range(variables))}, = coefficients"]
    for i in range(variables):
        lines.append(f"    {', '.join(used)}{rest}, = row{i}")
        for at in ("h", "k"):
            value = used[-1]
            for lower in used[-2::-1]:
                value = f"({value}) * {at} + {lower}"
            lines.append(f"    {at}{i} = {value}")
    both = (", ".join(f"{at}{i}" for i in range(variables)) for at in ("h", "k"))
    lines.append("    return " + ", ".join(f"[{values}]" for values in both))
    scope: dict[str, Callable[..., tuple[list[float], list[float]]]] = {}
    exec("\n".join(lines), scope)
    return scope["states"]
