"""Signs of a guard on a step: proved positive, or its first zero enclosed with existence and uniqueness."""

from __future__ import annotations

from typing import NamedTuple

from flint import arb

from .steps import NotProved, StateExpansion, exact, interval

# Parts into which a step is divided before a sign counts as not proved, and refinements of a zero.
MOST_PARTS, MOST_REFINEMENTS = 5000, 200


class Zero(NamedTuple):
    """The first zero of a guard on a step: in (low, high), unique there, the guard positive before and decreasing."""

    name: str
    low: arb
    high: arb

    @property
    def enclosure(self) -> arb:
        return interval(self.low, self.high)


def first_zero(guard: StateExpansion, length: arb, name: str) -> Zero | None:
    """The guard's first zero on (0, length], or None if it is proved positive there.

    Leading coefficients that are exactly 0 (`guard.zeros`) are divided out, so the zero at the start itself does not
    count. Raises NotProved where neither can be proved.
    """
    value = guard.quotient()
    rate = value.rate()
    parts = [(arb(0), length)]
    for _ in range(MOST_PARTS):
        if not parts:
            return None
        low, high = parts.pop()
        part = interval(low, high)
        if value(part) > 0:
            continue
        slope = rate(part)
        if slope < 0 and value(low) > 0:
            end = value(high)
            if end > 0:
                continue
            if end < 0:
                return _refine(name, value, rate, low, high)
        if slope > 0 and value(low) > 0:
            continue
        middle = exact((low + high) / 2)
        if not low < middle or not middle < high:
            break
        parts += [(middle, high), (low, middle)]
    raise NotProved(f"the sign of {name} could not be proved: it comes too close to zero (grazing)")


def _refine(name: str, value: StateExpansion, rate: StateExpansion, low: arb, high: arb) -> Zero:
    """The zero in (low, high), where the function decreases from positive to negative, in a small interval."""
    for _ in range(MOST_REFINEMENTS):
        part = interval(low, high)
        middle = exact(part)
        newton = middle - value(middle) / rate(part)  # interval Newton: the zero is in it
        new_low = max(low, exact(newton.lower()))
        new_high = min(high, exact(newton.upper()))
        if value(middle) > 0:
            new_low = max(new_low, middle)
        elif value(middle) < 0:
            new_high = min(new_high, middle)
        if not new_high - new_low < (high - low) * 0.9:
            break
        low, high = new_low, new_high
    return Zero(name, low, high)
