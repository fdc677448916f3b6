"""Logarithmic axes of Matplotlib with few ticks.

This module does not select a Matplotlib backend: a notebook may already have one.
"""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

# Largest number of ticks on a logarithmic axis.
_MARKS = 6


class _Powers(LogLocator):
    """Ticks at powers of ten, and also at 2 and 5 times these where the axis has less than two decades."""

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        self.set_params(subs=(1.0, 2.0, 5.0) if 0.0 < vmax < 100.0 * vmin else (1.0,))
        return super().tick_values(vmin, vmax)


def logarithmic(ax: Axes, which: str) -> None:
    """Make axes ("x", "y" or both) logarithmic with a few plain tick labels: 1, 0.1, 10⁻²."""
    for name in which:
        ax.set(**{f"{name}scale": "log"})
        axis = ax.xaxis if name == "x" else ax.yaxis
        axis.set_major_locator(_Powers(numticks=_MARKS))
        axis.set_major_formatter(FuncFormatter(_power))
        axis.set_minor_locator(NullLocator())


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _power(value: float, _position: int | None = None) -> str:
    mantissa, exponent = f"{value:.0e}".split("e")
    power = int(exponent)
    if abs(power) < (2 if mantissa == "1" else 4):
        return f"{value:g}"
    return ("" if mantissa == "1" else f"{mantissa}·") + "10" + str(power).translate(_SUPERSCRIPTS)
