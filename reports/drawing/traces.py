"""A figure as data: panels of traces. `svg_writer` draws it in the page and `matplotlib_writer` in files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import ceil, floor, isfinite, log10
from typing import NamedTuple

from ..judging.grades import percent

# Most ticks of an axis.
_TICKS = 8


class PlotAxis(NamedTuple):
    """An axis: its label, whether it is logarithmic, its ends (None: those of the data; what is beyond them is an arrow
    at the edge), whether its numbers are shares written in percent, and names in place of numbers, by their places."""

    label: str = ""
    is_log: bool = False
    low: float | None = None
    high: float | None = None
    is_percent: bool = False
    names: tuple[tuple[float, str], ...] = ()


class Trace(NamedTuple):
    """The points of one solver's route ("" for the truth): `is_line` joins them, `is_marked` draws each.

    `low` and `high`: the ends of the error bars along y; `hollow`, `pale`: places of points that look so; `tips` and
    `links`: texts and addresses of the points; `label` stands at the point of the place `label_at`.
    """

    solver: str
    route: str
    x: Sequence[float]
    y: Sequence[float]
    is_line: bool = True
    is_marked: bool = False
    low: Sequence[float] = ()
    high: Sequence[float] = ()
    hollow: frozenset[int] = frozenset()
    pale: frozenset[int] = frozenset()
    tips: Sequence[str] = ()
    links: Sequence[str] = ()
    label: str = ""
    label_at: int = -1

    @property
    def label_point(self) -> tuple[float, float]:
        """Where the label stands: the point `label_at`, or the last one that is finite."""
        finite = [i for i, value in enumerate(self.y) if isfinite(value)] or [0]
        place = self.label_at if self.label_at in finite else finite[-1]
        return self.x[place], self.y[place]


class Span(NamedTuple):
    """A part of the x axis between two vertical lines, and its name."""

    low: float
    high: float
    name: str
    is_shaded: bool = False


class Panel(NamedTuple):
    """Traces on a pair of axes; `spans` divide the x axis; `levels`: horizontal lines; `medians`: short vertical ones
    of a solver's row, as solver, route, x, y and text."""

    x: PlotAxis
    y: PlotAxis
    traces: tuple[Trace, ...]
    title: str = ""
    spans: tuple[Span, ...] = ()
    levels: tuple[float, ...] = ()
    medians: tuple[tuple[str, str, float, float, str], ...] = ()


class Diagram(NamedTuple):
    """A figure: its panels in rows, and its words."""

    title: str
    caption: str
    rows: tuple[tuple[Panel, ...], ...]


class PlotScale:
    """An axis from numbers to positions between two ends, in any unit."""

    def __init__(self, axis: PlotAxis, values: Iterable[float], begin: float, end: float):
        self.axis, self.begin, self.end = axis, begin, end
        finite = [v for v in values if isfinite(v) and (v > 0.0 or not axis.is_log)]
        low = min(finite, default=0.1 if axis.is_log else 0.0) if axis.low is None else axis.low
        high = max(finite, default=1.0) if axis.high is None else axis.high
        if axis.is_log:
            first = floor(log10(low) + 1e-9)
            self.low, self.high = 10.0**first, 10.0 ** max(ceil(log10(high) - 1e-9), first + 1)
        else:
            self.low, self.high = low, high if high > low else low + 1.0

    def side(self, value: float) -> int:
        """-1 for a value below the axis, 1 for one above it, else 0."""
        return -1 if value < self.low else 1 if value > self.high else 0

    def __call__(self, value: float) -> float:
        value = min(max(value, self.low), self.high)
        if self.axis.is_log:
            share = log10(value / self.low) / log10(self.high / self.low)
        else:
            share = (value - self.low) / (self.high - self.low)
        return round(self.begin + share * (self.end - self.begin), 1)

    def ticks(self) -> list[tuple[float, str]]:
        """Places of ticks and their texts: powers of ten, or multiples of 1, 2 or 5."""
        if self.axis.names:
            return list(self.axis.names)
        if self.axis.is_log:
            powers = range(round(log10(self.low)), round(log10(self.high)) + 1)
            values = [10.0**power for power in powers[:: ceil(len(powers) / _TICKS)]]
        else:
            step = 10.0 ** floor(log10((self.high - self.low) / 4))
            step *= next(m for m in (1, 2, 5, 10) if (self.high - self.low) / (m * step) <= 5)
            values = [i * step for i in range(ceil(self.low / step), floor(self.high / step) + 1)]
        return [(value, self._text(value)) for value in values]

    def _text(self, value: float) -> str:
        if self.axis.is_percent:
            return percent(value)
        return f"{value:.6g}" if not self.axis.is_log or 1e-3 <= value < 1e4 else f"1e{round(log10(value))}"


def apart(places: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Places of labels along an axis, moved apart to be at least `gap` from each other, between two ends."""
    order = sorted(range(len(places)), key=places.__getitem__)
    result = list(places)
    for before, i in zip([None, *order], order, strict=False):
        result[i] = max(low, places[i] if before is None else max(places[i], result[before] + gap))
    for rank, i in enumerate(reversed(order)):
        result[i] = min(result[i], high - rank * gap)
    return result
