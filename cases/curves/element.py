"""Elements of a curve: the smooth pieces and corners of which it is made, one after the other."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import finite, whole

# Most rounds of a closed chain by which elements are counted, and most vertices of rounds whose length is summed.
MOST = 10_000_000


class Element(NamedTuple):
    """A piece or corner of a curve on its own.

    `start`, `low`: its first parameter in the chain and in the piece; `turns`: whole turns between the piece's tangent
    angle and the chain's; `number`: which one it is, counted on from round to round of a closed chain.
    """

    piece: Any
    start: float
    low: float
    turns: int
    number: int

    @property
    def shift(self) -> float:
        """The chain's parameter less the piece's."""
        return self.start - self.low

    @property
    def span(self) -> tuple[float, float]:
        """The range of the piece's own parameter."""
        low, high = self.piece.span
        return float(low), float(high)

    @property
    def middle(self) -> float:
        """The parameter in the middle of the piece, its own."""
        return 0.5 * sum(self.span)

    def clip(self, s: float) -> float:
        """The chain's parameter of the element that is nearest to one."""
        low, high = self.span
        return min(max(s, low + self.shift), high + self.shift)


class OneElement:
    """A smooth curve, or a corner, which is its own only element."""

    def point(self, s) -> np.ndarray:
        """Position, shape (2,) for a number, (2, n) for an array."""
        raise NotImplementedError

    def tangent(self, s) -> np.ndarray:
        """Unit tangent, shape (2,) for a number, (2, n) for an array."""
        raise NotImplementedError

    def tangent_angle(self, s):
        """Direction of the tangent in radians."""
        raise NotImplementedError

    def normal(self, s) -> np.ndarray:
        """Left unit normal U·tangent, shape (2,) for a number, (2, n) for an array."""
        tangent = self.tangent(s)
        return np.array([-tangent[1], tangent[0]])

    def place(self, s) -> tuple[Any, Any]:
        """`point` and `tangent_angle`."""
        return self.point(s), self.tangent_angle(s)

    @property
    def elements(self) -> tuple[Element, ...]:
        """Its elements in order, of one round of a closed curve."""
        return (Element(self, 0.0, 0.0, 0, 0),)

    def element(self, number: int) -> Element | None:
        """An element by its number, or None."""
        return None if whole("number of the element", number, -MOST, MOST) else self.elements[0]

    def element_at(self, s: float) -> Element:
        """The element on which a parameter lies."""
        finite("parameter of a curve", s)
        return self.elements[0]
