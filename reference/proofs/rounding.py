"""Balls as decimal intervals, rounded outward."""

from __future__ import annotations

from fractions import Fraction

from flint import arb

from .record import DecimalInterval


def outward(ball: arb, digits: int) -> DecimalInterval:
    """A decimal interval that contains the ball, with ends rounded outward to so many significant digits of its
    middle (more if the ball is narrower than that)."""
    low, high = _fraction(ball.lower()), _fraction(ball.upper())
    size = max(abs(low), abs(high))
    places = digits - _exponent(size) if size else 0
    return DecimalInterval(_decimal(low, places, up=False), _decimal(high, places, up=True))


def _fraction(exact: arb) -> Fraction:
    mantissa, exponent = (int(part) for part in exact.man_exp())
    return Fraction(mantissa) * Fraction(2) ** exponent


def _exponent(size: Fraction) -> int:
    """The power of ten above a positive number, give or take one."""
    return len(str(size.numerator)) - len(str(size.denominator)) + 1


def _decimal(number: Fraction, places: int, up: bool) -> str:
    """The number rounded down or up to so many decimal places, as text."""
    scaled = number * Fraction(10) ** places
    whole = -(-scaled.numerator // scaled.denominator) if up else scaled.numerator // scaled.denominator
    if places <= 0:
        return str(whole * 10**-places)
    text = f"{abs(whole):0{places + 1}d}"
    fraction = text[-places:].rstrip("0")
    sign = "-" if whole < 0 else ""
    return f"{sign}{text[:-places]}.{fraction}" if fraction else f"{sign}{text[:-places]}"
