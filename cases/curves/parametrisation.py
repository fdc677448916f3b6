"""What the parameter of a curve means: the period of a formula, and the unit in which the curve changes.

A curve may be written in any parameter: metres, radians, a millionth of either. Whatever is searched or sampled takes
its scale from here, never from the parameter's own unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import reduce
from math import lcm, log10, pi
from typing import NamedTuple

import numpy as np

from ..formulas import features
from ..formulas.expression_graph import Node
from .jets import S

# Frequencies of one formula whose ratios are fractions of numbers up to this have a common period; and so many times
# at most a curve may repeat itself within it.
MOST_ROUNDS = 24
# Decades of distance from 0 at which a curve without ends is looked at.
DECADES = 10.0 ** np.arange(-12.0, 13.0)
# A ratio is such a fraction to the rounding of the numbers that an author writes.
FRACTION = 1e-12


class _Frequencies(NamedTuple):
    """A formula as slope·s plus what repeats itself with those angular frequencies (1 over the parameter's unit)."""

    slope: float
    frequencies: frozenset[float]


def period(formulas: Sequence[Node]) -> float | None:
    """A period that all the formulas of `S` have by their form, None if they show none.

    By its form sin(2 s) repeats itself, and so does cos(s + 0.3 sin(s)); a period that needs more than sums, products
    and functions of what repeats itself is not seen.
    """
    frequencies: set[float] = set()
    for formula in formulas:
        course = _course(formula)
        if course is None or course.slope:
            return None
        frequencies |= course.frequencies
    if not frequencies:
        return None
    slowest = min(frequencies)
    ratios = [Fraction(w / slowest).limit_denominator(MOST_ROUNDS) for w in frequencies]
    if any(abs(w / slowest - r) > FRACTION * r for w, r in zip(frequencies, ratios, strict=True)):
        return None
    return 2 * pi / slowest * reduce(lcm, (r.denominator for r in ratios), 1)


def _course(formula: Node) -> _Frequencies | None:
    """The formula's course; None if it neither repeats itself nor grows evenly."""
    if S not in formula.symbols:
        return _Frequencies(0.0, frozenset())
    if formula is S:
        return _Frequencies(1.0, frozenset())
    courses = [_course(part) for part in formula.args]
    if None in courses:
        return None
    slopes = [course.slope for course in courses if course]
    frequencies = frozenset[float]().union(*(course.frequencies for course in courses if course))
    if formula.op in ("+", "-"):
        return _Frequencies(slopes[0] + slopes[1] if formula.op == "+" else slopes[0] - slopes[1], frequencies)
    if formula.op in ("*", "/"):
        first, second = (features.coefficients(part, S) if S not in part.symbols else None for part in formula.args)
        if second is not None:
            slope = slopes[0] * second[0] if formula.op == "*" else slopes[0] / second[0]
            return _Frequencies(float(slope), frequencies)
        if first is not None and formula.op == "*":
            return _Frequencies(float(first[0] * slopes[1]), frequencies)
    if formula.op in ("sin", "cos", "tan") and slopes[0]:
        return _Frequencies(0.0, frequencies | {abs(slopes[0])})
    return None if any(slopes) else _Frequencies(0.0, frequencies)


def places(centres: tuple[float, ...]) -> np.ndarray:
    """Where a curve without ends is looked at: at 0, at all distances from it, and where its formula has a centre."""
    return np.concatenate([[0.0], DECADES, -DECADES, centres])


def unit(places: np.ndarray, jets: np.ndarray) -> float:
    """The unit, in powers of a thousand of the parameter's own, in which a curve without ends changes near 0.

    So far from 0 its tangent has turned, or its speed has changed, by about as much as it is, by its jets (8, n) at
    some places; a curve that is straight and even at all of them covers a metre. Windows begin with it and grow, so
    that a rough one will do: that of a curve of ordinary size in an ordinary parameter is 1.
    """
    with np.errstate(all="ignore"):
        speed, bend, change = (np.hypot(*jets[2 * order : 2 * order + 2]) for order in (1, 2, 3))
        rates = np.maximum(bend / speed, np.sqrt(change / speed))
        far = np.maximum(np.abs(places), 1.0 / rates)
    far = far[np.isfinite(far) & (far > 0.0)]
    speed = speed[np.isfinite(speed) & (speed > 0.0)]
    if not len(far):
        far = 1.0 / speed if len(speed) else np.ones(1)
    return float(10.0 ** (3 * round(log10(far.min()) / 3)))


def scale(jets: np.ndarray, unit: float) -> np.ndarray:
    """Positions and derivatives (8, …) by a parameter in that unit of it: all are lengths, in m."""
    orders = unit ** np.repeat(np.arange(4.0), 2)
    return jets * orders.reshape(-1, *(1,) * (jets.ndim - 1))
