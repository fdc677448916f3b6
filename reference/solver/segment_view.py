"""A segment as the search for meetings sees it: poses, and the contacts that are watched with their surroundings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cases.contact.shapes import Poses
from cases.scene.piece_case import PieceCase

from ..minimal.boxes import Cores, cores
from ..minimal.integrators.segment import Segment
from ..minimal.modes import Phase
from ..scales import EPS
from .plate_numbers import bodies
from .regimes import pair_of, regime_of
from .system import COLUMNS

# Places in a window at which a contact is sampled, and how far it may go beyond them, as a part of their range.
PLACES, BEYOND = np.linspace(0.0, 1.0, 5), 0.1
# Windows in which a contact is not proven to be the only one in its surroundings are halved at most this many times.
HALVINGS = 16


@dataclass
class SegmentView:
    """Times (s) of a segment's steps, times (n,) ↦ poses of all plates (3 plates, n); the pairs of elements with a
    contact that is watched, of each its number and times ↦ the parameters (2, n) and the gap (n,), m; the plates at
    rest; and the pairs that a contact has left over an end where the segment begins."""

    times: np.ndarray
    poses: Poses
    pairs: tuple[PieceCase, ...]
    points: Callable[[int, np.ndarray], np.ndarray]
    gap: Callable[[int, np.ndarray], np.ndarray]
    resting: frozenset[int]
    partings: tuple[PieceCase, ...] = ()
    cache: dict[tuple[int, bytes], tuple[Cores, np.ndarray]] = field(default_factory=dict)

    @property
    def start(self) -> float:
        """The start of the segment, s."""
        return float(self.times[0])

    def cores(self, k: int, ends: np.ndarray) -> tuple[Cores, np.ndarray]:
        """The surroundings of contact k in windows of time (2, m), and which of them shorter windows may still prove
        (m,)."""
        key = k, ends.tobytes()
        if key not in self.cache:
            times, size = (ends[0][:, None] + (ends[1] - ends[0])[:, None] * PLACES).ravel(), (-1, len(PLACES))
            places = self.points(k, times).reshape(2, *size)
            low, high = places.min(axis=2), places.max(axis=2)
            more, gap = BEYOND * (high - low), self.gap(k, times).reshape(size).max(axis=1)
            xi1, xi2 = zip(low - more, high + more, strict=True)
            self.cache[key] = cores(self.pairs[k], np.array(xi1), np.array(xi2), np.maximum(gap, 0.0))
        return self.cache[key]

    def provable(self, k: int, edges: np.ndarray) -> np.ndarray:
        """The times, and times between them, such that contact k is proven to be the only one in its surroundings: a
        feature of its curve that it passes in a window would count as the contact."""
        ends = np.array([edges[:-1], edges[1:]])
        around, unproven = self.cores(k, ends)
        for _ in range(HALVINGS):
            wide = unproven & (ends[1] - ends[0] > 64 * EPS * np.abs(ends[1]))
            if not wide.any():
                break
            start, end = ends[:, wide]
            middle = 0.5 * (start + end)
            parts = np.array([np.append(start, middle), np.append(middle, end)])
            halves, still = self.cores(k, parts)
            ends = np.append(ends[:, ~wide], parts, axis=1)
            around = Cores(*(np.append(old[:, ~wide], new, axis=1) for old, new in zip(around, halves, strict=True)))
            unproven = np.append(unproven[~wide], still)
        order = np.argsort(ends[0], kind="stable")
        ends = ends[:, order]
        self.cache[k, ends.tobytes()] = Cores(*(each[:, order] for each in around)), unproven[order]
        return np.append(ends[0], ends[1, -1])


def view_of(segment: Segment, partings: tuple[PieceCase, ...] = ()) -> SegmentView:
    """A segment in poses."""
    phase, states = segment.phase, remember(segment.states)
    regime, half = regime_of(phase), 3 * len(bodies(phase.case).reaches)
    return SegmentView(
        segment.times,
        lambda times: states(times)[:half],
        tuple(pair_of(phase.case, key) for key in regime.pairs),
        lambda k, times: states(times)[half + 2 * k : half + 2 * k + 2],
        lambda k, times: gap_of(phase, k, times, states(times)),
        regime.resting,
        partings,
    )


def gap_of(phase: Phase, k: int, times: np.ndarray, states: np.ndarray) -> np.ndarray:
    """The gap of contact k, m, at some instants."""
    columns = phase.system.outputs_of_arrays(times, states, phase.parameters)
    first = 2 + 3 * len(bodies(phase.case).reaches) + len(COLUMNS) * k
    return np.broadcast_to(np.asarray(columns[first + COLUMNS.index("gap")], dtype=float), times.shape)


def remember(poses: Poses) -> Poses:
    """The same function, which evaluates each times once: all pairs of elements ask for the same."""
    values = dict[bytes, np.ndarray]()

    def evaluate(times: np.ndarray) -> np.ndarray:
        key = times.tobytes()
        if key not in values:
            values[key] = poses(times)
        return values[key]

    return evaluate
