"""One step of Taylor's method with a proof, and the first zero of a condition in it.

A step is validated by Taylor's theorem with remainder over a box that contains the step's states in its interior.
"""

from __future__ import annotations

from math import ceil, exp, frexp, log, log2
from typing import NamedTuple

from .balls import Ball, FixedPoint, hull, negative, positive
from .system import System

MOST_TRIALS, MOST_PARTS, MOST_REFINEMENTS = 60, 4000, 200
# A remainder grows faster than the step's power, because the box grows with the step; found by trying.
BOX_SHARE = 1.4
# A step's length is so many times 2^-LENGTH of the unit of its series.
LENGTH = 10
# States below 2^-SMALLEST_BITS count as that large: a state may be 0 but for its radius, as in an equilibrium.
SMALLEST_BITS = 40
# Series are computed again where a step is shorter than this part of their unit.
SHORTEST = 2.0**-4


class NotConfirmed(ValueError):
    """A claim of the record that the checker could not confirm."""


class Zero(NamedTuple):
    """The first zero of a condition in a step, in parts of the series' unit, and the condition's name."""

    name: str
    low: int
    high: int


class Step(NamedTuple):
    """A validated step: its length in parts of the unit 2^exponent s of its series, and the series with remainders."""

    length: int
    exponent: int
    states: list[list[Ball]]
    conditions: dict[str, list[Ball]]

    def seconds(self, arithmetic: FixedPoint) -> float:
        return self.length / arithmetic.one * 2.0**self.exponent


def take(system: System, state: list[Ball], time: Ball, guess: float, order: int, tolerance: float) -> Step:
    """A validated step of about the length `guess`, s; `tolerance` is a logarithm, of remainders over states."""
    f, h, unit = system.arithmetic, guess, None
    for _ in range(MOST_TRIALS):
        if unit is None or h < SHORTEST * 2.0**unit or h > 2.0**unit:
            unit = frexp(h)[1]
            states, conditions = system.expand(state, time, order, unit)
        parts = max(1, min(1 << LENGTH, ceil(h / 2.0**unit * (1 << LENGTH)) - 1))
        length, change = parts << (f.bits - LENGTH), 0.6
        last = _remainder(system, states, time, length, order, unit)
        if last is not None:
            excess = _excess(f, states, last[0], length, order)
            change = 0.9 * exp(max(-2.0, min(0.3, tolerance - excess) / (BOX_SHARE * order)))
            if excess <= tolerance:
                ends = [[*row[:order], c] for row, c in zip(states, last[0], strict=True)]
                return Step(length, unit, ends, {n: [*row[:order], last[1][n]] for n, row in conditions.items()})
        h = length / f.one * 2.0**unit * change
    raise NotConfirmed("a step of the integration could not be validated")


def _remainder(system: System, states: list[list[Ball]], time: Ball, length: int, order: int, unit: int):
    """The coefficients of that order over a box that contains the step's states in its interior, or None."""
    f, part = system.arithmetic, hull(0, length)
    inner = [f.polynomial(row[:order], part) for row in states]
    boxes = [(m, r + (r >> 2) + (abs(m) >> 40) + (f.one >> 90)) for m, r in inner]
    passed = f.times_power(part, unit)
    try:
        rows, conditions = system.expand(boxes, (time[0] + passed[0], time[1] + passed[1]), order, unit)
    except ZeroDivisionError:
        return None
    power = (length**order >> f.bits * (order - 1)) + 1
    for (m, r), inside, row in zip(boxes, inner, rows, strict=True):
        more = f.mul(row[order], hull(0, power))
        if not abs(inside[0] + more[0] - m) + inside[1] + more[1] < r:
            return None
    return [row[order] for row in rows], {name: row[order] for name, row in conditions.items()}


def _excess(f: FixedPoint, states: list[list[Ball]], last: list[Ball], length: int, order: int) -> float:
    """The logarithm of the largest remainder over its state's largest term."""
    step, worst = log2(length) - f.bits, -1e9
    for row, (m, r) in zip(states, last, strict=True):
        sizes = [log2(abs(c) + q) + k * step for k, (c, q) in enumerate(row[:order]) if c or q] or [0.0]
        if abs(m) + r:
            worst = max(worst, log2(abs(m) + r) + order * step - max(*sizes, f.bits - SMALLEST_BITS))
    return worst * log(2.0)


def first_zero(f: FixedPoint, name: str, row: list[Ball], zeros: int, length: int) -> Zero | None:
    """The first zero of a condition in (0, length], unique and from positive to negative; None if it stays positive.

    The first `zeros` coefficients are exactly 0 and are divided out.
    """
    value = row[zeros:]
    slope = [(k * m, k * r) for k, (m, r) in enumerate(value)][1:]
    parts = [(0, length)]
    for _ in range(MOST_PARTS):
        if not parts:
            return None
        low, high = parts.pop()
        if positive(f.polynomial(value, hull(low, high))):
            continue
        if positive(f.polynomial(value, (low, 0))):
            rate, end = f.polynomial(slope, hull(low, high)), f.polynomial(value, (high, 0))
            if positive(rate) or (negative(rate) and positive(end)):
                continue
            if negative(rate) and negative(end):
                return _narrow(f, name, value, slope, low, high)
        middle = (low + high) >> 1
        if not low < middle < high:
            break
        parts += [(middle, high), (low, middle)]
    raise NotConfirmed(f"the sign of {name} could not be confirmed")


def _narrow(f: FixedPoint, name: str, value: list[Ball], slope: list[Ball], low: int, high: int) -> Zero:
    """The zero in a small interval, by interval Newton and by halves."""
    for _ in range(MOST_REFINEMENTS):
        middle = (low + high) >> 1
        there = f.polynomial(value, (middle, 0))
        m, r = f.div(there, f.polynomial(slope, hull(low, high)))
        new_low, new_high = max(low, middle - m - r), min(high, middle - m + r)
        if positive(there):
            new_low = max(new_low, middle)
        elif negative(there):
            new_high = min(new_high, middle)
        if not new_high - new_low < 0.9 * (high - low):
            break
        low, high = new_low, new_high
    return Zero(name, low, high)
