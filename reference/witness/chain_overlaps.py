"""Search for a second contact on curves with corners, for the second formulation."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, cos, inf, sin

import numpy as np
from scipy.optimize import brentq

from cases import Case, Chain, DoesNotFit
from cases.contact.overlap_search import span
from cases.contact.piece_contact import Entry, excludes_second, piece_gap
from cases.curves.corner import Corner
from cases.curves.element import Element
from cases.scene.piece_case import PieceCase

from .chain_entries import Chains, entry_time
from .plate_motion import bodies_in_contact

# Between two samples of a step the plate moves by this part of its size, and at most MOST samples are taken.
STEP, MOST = 0.02, 2000


def _free_corners(pieces: PieceCase) -> list[Element]:
    """The corners of the outline that bulge and are not at the contact or next to it, on a smooth track."""
    outline = pieces.whole.plate.outline
    if isinstance(pieces.whole.track, Chain) or not isinstance(outline, Chain):
        return []
    count, own = len(outline.elements), pieces.second.number
    near = {(own + i) % count for i in (-1, 0, 1)}
    return [e for e in outline.elements if isinstance(e.piece, Corner) and e.piece.turn > 0.0 and e.number not in near]


class ChainOverlaps:
    """The search for a touch away from the contact, in each step of the integration on `pieces`."""

    def __init__(self, case: Case, pieces: PieceCase, reach: float, xi1: float):
        self.pieces, self.reach = pieces, reach
        low, high = span(case.track, np.array([xi1]), 4.0 * reach)
        self.chains = Chains(case.track, case.plate.outline, low, high)
        self.skip = excludes_second(case.track, case.plate.outline)
        self.corners = _free_corners(pieces)
        self.gaps: list[float] = []
        self.time: float | None = None
        self.state: list[float] | None = None  # (ξ₁, ξ₂, ω, v) then
        self.steps: list[tuple[float, Callable[[np.ndarray], np.ndarray]]] = []
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
        self.steps.append((start, z_at))
        self._look(z_at, start, end)
        if self.time is not None:
            self.state = self._at(self.time).tolist()

    def _at(self, t: float) -> np.ndarray:
        """(ξ₁, ξ₂, ω, v) at a time in one of the steps."""
        z_at = next((z_at for start, z_at in reversed(self.steps) if start <= t), self.steps[0][1])
        return z_at(np.array([t]))[:, 0]

    def _look(self, z_at: Callable[[np.ndarray], np.ndarray], start: float, end: float) -> None:
        self.step = start
        self.start = start if self.start is None else self.start

        def pose(t: float) -> tuple[float, float, float]:
            x, y, theta = bodies_in_contact(self.pieces, np.array([t]), self._at(t)[:, None], 0)[:3, 0].tolist()
            return x, y, theta

        both = np.array([start, end])
        ends = bodies_in_contact(self.pieces, both, z_at(both), 0)
        way = np.hypot(*np.diff(ends[:2])[:, 0]) + self.reach * abs(float(np.diff(ends[2])[0]))
        before = start
        self.gaps = [self._corner_gap(corner, *pose(start)) for corner in self.corners]
        for t in np.linspace(start, end, 1 + min(MOST, ceil(way / (STEP * self.chains.size)) + 1))[1:].tolist():
            z = z_at(np.array([t]))[:, 0]
            if (time := self._corner_touch(pose, before, t)) is not None:
                self.time = time
                return
            goes_on = self._on_pieces(z)
            if not goes_on:  # the step continues beyond the phase's end
                t = self._last_on_pieces(z_at, before, t)
                z = z_at(np.array([t]))[:, 0]
            place = self.pieces.to_whole(z[0], z[1])[0]
            entry = self.chains.entry(*pose(t), place)
            if entry:
                try:
                    self.time = entry_time(pose, entry, before, t, self.start)
                except DoesNotFit:
                    self.time = t
            if entry or not goes_on:
                return
            before = t

    def _last_on_pieces(self, z_at: Callable[[np.ndarray], np.ndarray], low: float, high: float) -> float:
        """The last time at which the contact is on its pieces, by halves: 60 of them leave a rounding."""
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._on_pieces(z_at(np.array([middle]))[:, 0]) else (low, middle)
        return low

    def _corner_touch(self, pose: Callable[[float], tuple[float, float, float]], before: float, t: float):
        """When the first corner of the outline goes through a smooth track between two samples, s; None if none does:
        by the corner's own distance from the track, however little it enters."""
        last, self.gaps = self.gaps, [self._corner_gap(corner, *pose(t)) for corner in self.corners]
        times = [
            float(brentq(lambda s, c=corner: self._corner_gap(c, *pose(s)), before, t, xtol=1e-15, rtol=8.9e-16))
            for corner, old, new in zip(self.corners, last, self.gaps, strict=True)
            if old > 0.0 >= new
        ]
        return min(times, default=None)

    def _corner_gap(self, corner: Element, x: float, y: float, theta: float) -> float:
        """The distance of a corner of the outline from a smooth track, m; infinite where the track has no foot."""
        u, v = corner.piece.point(0.0)
        point = np.array([x + cos(theta) * u - sin(theta) * v, y + sin(theta) * u + cos(theta) * v])
        near = self.chains.s1[int(np.argmin(np.hypot(*(self.chains.points1 - point[:, None]))))]
        track = self.pieces.whole.track
        try:
            foot = piece_gap(Entry(self.pieces.first, corner, float(near), corner.start), x, y, theta)
        except DoesNotFit:
            return inf
        is_inside = track.ends is None or track.ends[0] <= foot.xi1 <= track.ends[1]
        return foot.gap if is_inside else inf

    def _on_pieces(self, z: np.ndarray) -> bool:
        """Whether the contact is on its pieces."""
        for piece, s in zip(self.pieces.pieces, z[:2].tolist(), strict=True):
            if piece.ends and not piece.ends[0] <= s <= piece.ends[1]:
                return False
        return True
