"""Numbers in sentences: two digits and a unit; powers of ten only in a level of accuracy."""

from __future__ import annotations

from math import floor, isfinite, log10

# Times from here on are written in seconds: 0.5 s is easier to read than 500 ms, and 170 ms than 0.17 s.
_IN_SECONDS = 0.45


def number(value: float) -> str:
    """Two significant digits, without zeros at the end of a fraction: 0.29, 0.5, 9.7, 8, 660, 1,700."""
    if not isfinite(value) or value == 0.0:
        return "0" if value == 0.0 else "unknown"
    digits = 1 - floor(log10(abs(value)))
    approximation = round(value, digits)
    # 9.96 rounds to 10, which has one digit less behind the point.
    digits = max(0, 1 - floor(log10(abs(approximation))))
    text = f"{approximation:,.{digits}f}"
    return text.rstrip("0").removesuffix(".") if "." in text else text


def times(factor: float) -> str:
    """A ratio: 660 ×."""
    return f"{number(factor)} ×"


def seconds(value: float) -> str:
    """A time: 340 µs, 170 ms, 0.5 s."""
    if not isfinite(value):
        return "unknown"
    if value >= _IN_SECONDS:
        return f"{number(value)} s"
    # What would round to a thousand of a unit is one of the next.
    return f"{number(value * 1e3)} ms" if value >= 0.995e-3 else f"{number(value * 1e6)} µs"


def level(accuracy: float) -> str:
    """A level of accuracy: 1e-4, 0.01."""
    return f"{accuracy:g}" if accuracy >= 1e-3 else f"{accuracy:.0e}".replace("e-0", "e-")
