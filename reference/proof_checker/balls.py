"""Numbers as fixed-point balls: a middle and a radius, integers in units of 2^-bits. Every operation rounds outward.

Products of integers are exact, so that a sum of products is rounded once. mpmath's intervals give the sine, cosine,
exponential and logarithm of a ball.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt
from typing import Any

from mpmath import iv
from mpmath.libmp import from_man_exp

# A middle and a radius.
Ball = tuple[int, int]
ZERO: Ball = (0, 0)


class FixedPoint:
    """Arithmetic on balls with so many bits after the point."""

    def __init__(self, bits: int):
        self.bits = bits
        self.one = 1 << bits

    # --- numbers and balls ------------------------------------------------------------------------------------------

    def of(self, value: Fraction | int) -> Ball:
        """The smallest ball that contains a rational number."""
        above, below = Fraction(value).as_integer_ratio()
        middle, rest = divmod(above << self.bits, below)
        return middle, int(rest != 0)

    def low(self, a: Ball) -> Fraction:
        return Fraction(a[0] - a[1], self.one)

    def high(self, a: Ball) -> Fraction:
        return Fraction(a[0] + a[1], self.one)

    def text(self, a: Ball) -> str:
        return f"[{float(self.low(a)):.17g}, {float(self.high(a)):.17g}]"

    # --- operations -------------------------------------------------------------------------------------------------

    def rounded(self, middle: int, radius: int) -> Ball:
        """A ball from a middle and a radius with twice the bits, as products have."""
        rounding = int(middle & (self.one - 1) != 0) + int(radius != 0)
        return middle >> self.bits, (radius >> self.bits) + rounding

    def mul(self, a: Ball, b: Ball) -> Ball:
        (m, r), (n, q) = a, b
        return self.rounded(m * n, (abs(m) + r) * q + r * abs(n))

    def div(self, a: Ball, b: Ball) -> Ball:
        """a/b; raises ZeroDivisionError if b contains 0."""
        (m, r), (n, q) = a, b
        least = abs(n) - q
        if least <= 0:
            raise ZeroDivisionError("division by a ball that contains 0")
        if m == r == 0:
            return ZERO
        middle, rest = divmod(m << self.bits, n)
        if r == q == 0:
            return middle, int(rest != 0)
        # |x/y - m/n| <= (r + |m/n| q)/least for x in a, y in b.
        return middle, -(-((r << self.bits) + (abs(middle) + 1) * q) // least) + 1

    def over(self, a: Ball, n: int) -> Ball:
        """A ball divided by a positive integer."""
        middle, rest = divmod(a[0], n)
        return middle, -(-a[1] // n) + int(rest != 0)

    def times_power(self, a: Ball, exponent: int) -> Ball:
        """A ball times a power of two."""
        m, r = a
        if exponent >= 0:
            return m << exponent, r << exponent
        part = (1 << -exponent) - 1
        return m >> -exponent, (r >> -exponent) + int(m & part != 0) + int(r != 0)

    def sqrt(self, a: Ball) -> Ball:
        """A root; raises ZeroDivisionError if the ball is not positive."""
        m, r = a
        if m - r <= 0:
            raise ZeroDivisionError("a root of a ball that is not positive")
        return hull(isqrt((m - r) << self.bits), isqrt((m + r) << self.bits) + 1)

    def function(self, name: str, a: Ball) -> Ball:
        """sin, cos, exp or log, by mpmath's intervals."""
        m, r = a
        if name == "log" and m - r <= 0:
            raise ZeroDivisionError("a logarithm of a ball that is not positive")
        ends = tuple(from_man_exp(end, -self.bits) for end in (m - r, m + r))
        precision, iv.prec = iv.prec, self.bits + max(0, m.bit_length() - self.bits) + 32
        try:
            return self._of_interval(getattr(iv, name)(iv.make_mpf(ends)))
        finally:
            iv.prec = precision

    def pi(self) -> Ball:
        precision, iv.prec = iv.prec, self.bits + 32
        try:
            return self._of_interval(iv.mpf(iv.pi))
        finally:
            iv.prec = precision

    def _of_interval(self, interval: Any) -> Ball:
        low, high = (self._scaled(end) for end in interval._mpi_)
        return hull(low.numerator // low.denominator, -(-high.numerator // high.denominator))

    def _scaled(self, end: Any) -> Fraction:
        """An end of one of mpmath's intervals in units of 2^-bits."""
        sign, mantissa, exponent, _ = end
        if not mantissa and exponent:
            raise ZeroDivisionError("a function of a ball is not finite")
        return (-1 if sign else 1) * Fraction(int(mantissa)) * Fraction(2) ** (exponent + self.bits)

    def polynomial(self, row: list[Ball], at: Ball) -> Ball:
        """A polynomial at a ball, by Horner's rule."""
        total = ZERO
        for c in reversed(row):
            product = self.mul(total, at)
            total = product[0] + c[0], product[1] + c[1]
        return total


def hull(low: int, high: int) -> Ball:
    """A ball that contains two numbers and all between them."""
    middle = (low + high) >> 1
    return middle, high - middle


def add(a: Ball, b: Ball) -> Ball:
    return a[0] + b[0], a[1] + b[1]


def sub(a: Ball, b: Ball) -> Ball:
    return a[0] - b[0], a[1] + b[1]


def positive(a: Ball) -> bool:
    return a[0] - a[1] > 0


def negative(a: Ball) -> bool:
    return a[0] + a[1] < 0
