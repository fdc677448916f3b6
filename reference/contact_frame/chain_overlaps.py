"""Search for a second contact on curves with corners, for the second formulation."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil

import numpy as np

from cases import Case, DoesNotFit
from cases.overlap import span
from cases.piece_case import PieceCase
from cases.piece_contact import Chains, entry_time, excludes_second

from .sampling import bodies_in_contact

# Between two samples of a step the plate moves by this part of its size, and at most MOST samples are taken.
STEP, MOST = 0.02, 2000


class ChainOverlaps:
    """The search for a touch away from the contact, in each step of the integration on `pieces`."""

    def __init__(self, case: Case, pieces: PieceCase, reach: float, xi1: float):
        self.pieces, self.reach = pieces, reach
        low, high = span(case.track, np.array([xi1]), 4.0 * reach)
        self.chains = Chains(case.track, case.plate.outline, low, high)
        self.skip = excludes_second(case.track, case.plate.outline)
        self.time: float | None = None
        self.start: float | None = None
        self.step = 0.0

    def before(self, t: float, z) -> float:
        """The time from t to the touch, s, or to the start of the step in which it was seen if that is later; positive
        if none is found."""
        return 1.0 if self.time is None else max(self.time, self.step) - t

    def look(self, z_at: Callable[[np.ndarray], np.ndarray], start: float, end: float) -> None:
        """Search a step; `z_at` maps times to (ξ₁, ξ₂, ω, v) on the pieces, shape (4, n)."""
        if self.skip or self.time is not None:
            return
        self.step = start
        self.start = start if self.start is None else self.start

        def pose(t: float) -> tuple[float, float, float]:
            x, y, theta = bodies_in_contact(self.pieces, np.array([t]), z_at(np.array([t])), 0)[:3, 0].tolist()
            return x, y, theta

        both = np.array([start, end])
        ends = bodies_in_contact(self.pieces, both, z_at(both), 0)
        way = np.hypot(*np.diff(ends[:2])[:, 0]) + self.reach * abs(float(np.diff(ends[2])[0]))
        before = start
        for t in np.linspace(start, end, 1 + min(MOST, ceil(way / (STEP * self.chains.size)) + 1))[1:].tolist():
            z = z_at(np.array([t]))[:, 0]
            if not self._on_pieces(z):
                return  # the step goes on beyond the phase's end
            place = self.pieces.to_whole(z[0], z[1])[0]
            entry = self.chains.entry(*pose(t), place)
            if entry:
                try:
                    self.time = entry_time(pose, entry, before, t, self.start)
                except DoesNotFit:
                    self.time = t
                return
            before = t

    def _on_pieces(self, z: np.ndarray) -> bool:
        """Whether the contact is on its pieces."""
        for piece, s in zip(self.pieces.pieces, z[:2].tolist(), strict=True):
            if piece.domain is not None and not piece.period and not piece.domain[0] <= s <= piece.domain[1]:
                return False
        return True
