"""Bounds on the curvature and speed of a curve between two parameters, for the second formulation.

A few samples bound a function only within one piece that resolves it (`cases.formulas.features`). Over a longer range
the bounds are those of all its pieces: ripples finer than the samples would be missed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import Curve

# Speed and curvature are sampled at these places of a range no longer than its shortest piece; between them they exceed
# the samples by less than BETWEEN times the largest difference of two neighbours. (A parabola does so by an eighth of
# it, if its top is half-way between two samples. A piece is half a wavelength of a ripple, whose curvature exceeds the
# samples by 0.5 % of it, and the bound by 5 %.)
PLACES, BETWEEN = np.linspace(0.0, 1.0, 17), 0.25


class Extremes(NamedTuple):
    """The largest and the smallest curvature (1/m, towards the left) and the largest speed on n ranges."""

    most: np.ndarray
    least: np.ndarray
    speed: np.ndarray


class CurveBounds:
    """Bounds for any ranges of one curve's parameter; those of a curve without ends are resolved on demand."""

    def __init__(self, curve: Curve):
        self.curve = curve
        self._build(*curve.span)

    def _build(self, low: float, high: float) -> None:
        """Tabulate the pieces between two parameters, and the extremes over 2, 4, 8 … consecutive ones."""
        # A range that crosses the end of a closed curve goes on in the next turn.
        last = high + (self.curve.period or 0.0)
        edges = self.curve.features.edges(low, last) if self.curve.features else np.array([low, last])
        bounds = _extremes(self.curve, edges[:-1], edges[1:])
        table = np.array([bounds.most, -bounds.least, bounds.speed, -np.diff(edges)])
        self._low, self._high, self._edges, self._tables = low, high, edges, [table]
        while (step := 2 ** (len(self._tables) - 1)) < table.shape[1]:
            table = np.maximum(table[:, :-step], table[:, step:])
            self._tables.append(table)

    def extremes(self, low: np.ndarray, high: np.ndarray) -> Extremes:
        """Bounds on the ranges from `low` to `high`, each of shape (n,)."""
        most, least, speed, length = self._of_pieces(low, high)
        bounds, short = _extremes(self.curve, low, high), high - low <= -length
        return Extremes(
            np.where(short, bounds.most, most), np.where(short, bounds.least, -least),
            np.where(short, bounds.speed, speed),
        )  # fmt: skip

    def over(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The largest and the smallest curvature on n ranges, 1/m, and the tangent's turn at most, rad."""
        most, least, speed = self.extremes(low, high)
        return most, least, np.maximum(most, -least) * speed * (high - low)

    def _of_pieces(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """The largest values of the table over all pieces that the ranges meet, shape (4, n)."""
        if period := self.curve.period:
            turns = np.floor((low - self._low) / period)
            low, high = low - turns * period, np.minimum(high, low + period) - turns * period
        elif self.curve.domain is None and (low.min() < self._low or high.max() > self._high):
            width = self._high - self._low
            self._build(min(self._low, float(low.min()) - width), max(self._high, float(high.max()) + width))
        last = len(self._edges) - 2
        first = np.clip(np.searchsorted(self._edges, low, side="right") - 1, 0, last)
        final = np.clip(np.searchsorted(self._edges, high, side="left") - 1, first, last)
        level = np.frexp(final - first + 1)[1] - 1
        result = np.empty((4, len(low)))
        for k in np.unique(level):
            these, table = level == k, self._tables[k]
            result[:, these] = np.maximum(table[:, first[these]], table[:, final[these] + 1 - 2**k])
        return result


def _extremes(curve: Curve, low: np.ndarray, high: np.ndarray) -> Extremes:
    """Bounds on ranges no longer than one piece, by samples."""
    at = low + (high - low) * PLACES[:, None]
    jets = curve.jets(at.ravel()).reshape(8, *at.shape)
    speed = np.hypot(jets[2], jets[3])
    bends = (jets[2] * jets[5] - jets[3] * jets[4]) / speed**3
    more, faster = (BETWEEN * np.abs(np.diff(values, axis=0)).max(axis=0) for values in (bends, speed))
    return Extremes(bends.max(axis=0) + more, bends.min(axis=0) - more, speed.max(axis=0) + faster)
