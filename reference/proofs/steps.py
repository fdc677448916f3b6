"""One validated step of Taylor's method: existence, uniqueness and enclosure of a solution on a time interval; and the
sign of a guard on it: proved positive, or its first zero enclosed with existence and uniqueness.

Theorem (Corliss & Rihm 1996; Nedialkov, Jackson & Corliss 1999; both known to us, not looked up; the proof is short).
Let c_k(x) be the k-th Taylor coefficient of the solution of ẋ = f(x) through x. If for a box B and all s in [0, h]

    P(s) = Σ_{k<n} c_k([x0]) s^k + c_n(B) s^n   lies in the interior of B,

then every solution with x(0) in [x0] exists on [0, h], is unique, and has x(s) in P(s). Proof: x0 = P(0) is interior.
As long as the solution is in B, f is analytic there and Taylor's theorem with remainder gives, for each component, x(s)
in P(s), which is interior; so there is no first time at which it leaves B, and it can be continued to h.

A quantity g(x), analytic on B, obeys g(x(s)) in Σ_{k<n} γ_k s^k + γ_n(B) s^n by the same theorem, and so do its
derivatives. Set and remainder are balls of Arb, whose every operation rounds outward. The set [x0] is a box, without a
rotating frame: the wrapping effect costs digits, which the working precision provides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import exp, inf
from typing import NamedTuple

from flint import arb, arb_poly, arb_series, ctx

# Series of a box have radii of the step's size, so that more digits in them have no use.
BOX_PRECISION = 64
MOST_TRIALS = 60
# A remainder grows faster than the step's power, because the box grows with the step; found by trying.
BOX_SHARE = 1.6
# Parts into which a step is divided before a sign counts as not proved, and refinements of a zero.
MOST_PARTS, MOST_REFINEMENTS = 5000, 200


class NotProved(ArithmeticError):
    """A condition could not be proved; the message says which one, and where."""


class NotCovered(NotProved):
    """The same, where more digits are of no use."""


class StateExpansion(NamedTuple):
    """A function of the time s since a step's start: Taylor coefficients, of which the last encloses the remainder.

    `zeros` is the number of leading coefficients that are exactly 0; `quotient` is the function divided by s^zeros.
    """

    coefficients: tuple[arb, ...]
    zeros: int = 0

    def __call__(self, s: arb) -> arb:
        return arb_poly(list(self.coefficients))(s)

    def rate(self) -> StateExpansion:
        """Its derivative."""
        return StateExpansion(tuple(k * c for k, c in enumerate(self.coefficients))[1:], max(self.zeros - 1, 0))

    def quotient(self) -> StateExpansion:
        return StateExpansion(self.coefficients[self.zeros :])


class ValidStep(NamedTuple):
    """A validated step: its length, a guess for the next one's, and the states and the guards as functions of the time
    since its start."""

    length: arb
    next_length: float
    states: tuple[StateExpansion, ...]
    guards: dict[str, StateExpansion]

    def state(self, s: arb) -> list[arb]:
        return [expansion(s) for expansion in self.states]


# States as series -> rates of the states, and guards by name.
Field = Callable[[Sequence[arb_series]], tuple[Sequence[arb_series], dict[str, arb_series]]]


def expand(field: Field, x0: Sequence[arb], order: int) -> tuple[list[list[arb]], dict[str, list[arb]]]:
    """Taylor coefficients 0 … order of the solutions through the box x0, and of the guards along them."""
    x = [[c] for c in x0]
    rows: dict[str, list[arb]] = {}
    cap = ctx.cap
    try:
        for k in range(order + 1):
            ctx.cap = k + 1
            try:
                rates, guards = field([arb_series(c) for c in x])
            except (ValueError, ZeroDivisionError) as problem:  # python-flint's errors for a division by a ball with 0
                raise NotProved("the equations have no finite value at a state") from problem
            if k == order:
                rows = {name: [coefficient(guard, i) for i in range(k + 1)] for name, guard in guards.items()}
                break
            for c, rate in zip(x, rates, strict=True):
                c.append(coefficient(rate, k) / (k + 1))
    finally:
        ctx.cap = cap
    return x, rows


def coefficient(series: arb_series, k: int) -> arb:
    """A coefficient; a series that does not reach it has none, and python-flint would return 0."""
    if series.prec <= k:
        raise NotProved("a series is shorter than the order of the integration")
    return series[k]


def interval(low: arb, high: arb) -> arb:
    """The ball of all numbers between two balls."""
    return low.union(high)


def step(field: Field, x0: Sequence[arb], longest: arb, guess: float, order: int, tolerance: arb) -> ValidStep:
    """A validated step no longer than `longest` (exact), with a remainder of about `tolerance` of the state's size.

    `guess` is a length to begin with (0: none is known). Raises NotProved if no step could be validated.
    """
    centre, guards = expand(field, x0, order - 1)
    if not all(c.is_finite() for row in centre for c in row):
        raise NotProved("the equations have no finite value at a state")
    h = min(exact(arb(guess)) if guess else _first_length(centre, longest, order, tolerance), longest, key=_log)
    for _ in range(MOST_TRIALS):
        found = _validate(field, centre, h, order)
        if found is None:
            h = exact(h * 0.6)
            continue
        last, last_guards = found
        excess = max(_excess(row, c, h, order) for row, c in zip(centre, last, strict=True)) - _log(tolerance)
        change = 0.95 * exp(max(-2.0, min(-excess / (BOX_SHARE * order), 0.5)))
        if excess <= 0.0:
            states = tuple(StateExpansion((*row, c)) for row, c in zip(centre, last, strict=True))
            rows = {name: StateExpansion((*guards[name], last_guards[name])) for name in guards}
            return ValidStep(h, float(h) * change, states, rows)
        h = exact(h * change)
    raise NotProved("no step of the integration could be validated")


def exact(x: arb) -> arb:
    return x.mid()


def _first_length(centre: Sequence[Sequence[arb]], longest: arb, order: int, tolerance: arb) -> arb:
    """A step at which the last known terms are about the tolerance of the largest one; a guess, which is validated."""
    goal = _log(tolerance)
    rows = [[(k, _log(c)) for k, c in enumerate(row) if not c.mid() == 0] for row in centre]
    length = _log(longest)
    for _ in range(MOST_TRIALS * 20):
        if all(_tail(row, length, order) <= goal for row in rows):
            break
        length -= 0.2
    return min(exact(arb(length).exp()), longest, key=lambda h: _log(h))


def _tail(row: Sequence[tuple[int, float]], length: float, order: int) -> float:
    """The logarithm of the last two terms over the largest of the first half, at a step with that logarithm."""
    size = max((c + k * length for k, c in row if k <= order // 2), default=None)
    tail = max((c + k * length for k, c in row if k >= order - 2), default=None)
    return -inf if tail is None else inf if size is None else tail - size


def _log(x: arb) -> float:
    return float(abs(x.mid()).log()) if not x.mid() == 0 else -inf


def _validate(field: Field, centre, h: arb, order: int):
    """The remainder's coefficients over a box that the theorem confirms, or None."""
    s = interval(arb(0), h)
    precision, ctx.prec = ctx.prec, BOX_PRECISION
    try:
        inner = [arb_poly(list(row))(s) for row in centre]
        box = [arb(c.mid(), 1.25 * c.rad() + abs(c.mid()) * arb(2) ** (20 - BOX_PRECISION)) for c in inner]
        box = [b if b.rad() > 0 else arb(b.mid(), h) for b in box]
        try:
            x, rows = expand(field, box, order)
        except NotProved:
            return None
        last = [row[order] for row in x]
        if not all(c.is_finite() for c in (*last, *(row[order] for row in rows.values()))):
            return None
        power = s**order
        for b, row, c in zip(box, inner, last, strict=True):
            if not b.contains_interior(row + c * power):
                return None
        return last, {name: row[order] for name, row in rows.items()}
    finally:
        ctx.prec = precision


def _excess(row: Sequence[arb], last: arb, h: arb, order: int) -> float:
    """The logarithm of the remainder at the step's end over the largest term of the state."""
    terms = [_log(c) + k * _log(h) for k, c in enumerate(row)]
    remainder = _log(abs(last).upper()) + order * _log(h)
    return remainder - max(terms) if max(terms) > -inf else remainder


# --- signs of a guard on a step ---------------------------------------------------------------------------------------


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
