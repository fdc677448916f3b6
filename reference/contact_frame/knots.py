"""Knots of curves in pieces, for the second formulation: a phase is computed by the formulas of one piece each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from math import inf

from .equations import ContactScene

# With this many continuous derivatives the forces are continuous at a knot.
SMOOTH = 2


class KnotEnds:
    """The pieces on which a phase begins; `inside` is positive while the contact stays on them."""

    def __init__(self, scene: ContactScene, z):
        self.scene = scene
        self.pieces = [scene.track.parts, scene.outline.parts]
        self.numbers = [pieces.number(z[i]) if pieces else 0 for i, pieces in enumerate(self.pieces)]
        self.limits = [self._limits(i) for i in range(2)]

    def _limits(self, i: int) -> tuple[float, float]:
        pieces, number = self.pieces[i], self.numbers[i]
        if pieces is None:
            return -inf, inf
        low, high = pieces.part(number).domain
        return (
            low if pieces.has_neighbour(number, -1) else -inf,
            high if pieces.has_neighbour(number, 1) else inf,
        )

    @property
    def any(self) -> bool:
        """Whether a curve is in pieces."""
        return any(pieces is not None for pieces in self.pieces)

    def inside(self, t: float, z) -> float:
        return min(min(z[i] - low, high - z[i]) for i, (low, high) in enumerate(self.limits))

    @contextmanager
    def formulas(self) -> Iterator[None]:
        """Inside, the scene has the geometry of these pieces, also in stages of a step beyond their knots."""
        scene, before = self.scene, (self.scene.track_jet, self.scene.outline_jet)
        jets: list[Callable] = [
            partial(pieces.jet_on, number=number) if pieces else own
            for pieces, number, own in zip(self.pieces, self.numbers, before, strict=True)
        ]
        scene.track_jet, scene.outline_jet = jets
        try:
            yield
        finally:
            scene.track_jet, scene.outline_jet = before

    def beyond(self, z: list[float]) -> bool:
        """Move a state at the end of a piece to the next piece; returns whether the forces are continuous there."""
        is_smooth = True
        for i, (low, high) in enumerate(self.limits):
            step = -1 if z[i] - low <= high - z[i] else 1
            pieces = self.pieces[i]
            # Of both curves the one that ended the phase; at the other's knot the next phase ends at once.
            if pieces is not None and min(z[i] - low, high - z[i]) <= self.inside(0.0, z):
                z[i] = pieces.across(self.numbers[i], step, z[i])
                is_smooth = is_smooth and pieces.order >= SMOOTH
        return is_smooth
