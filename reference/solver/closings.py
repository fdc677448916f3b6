"""Times at which the gap of two elements closes that are parts of lines and circles (`cases.contact.shapes`)."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev

from cases.contact.shapes import Poses, Shapes, Straight

from ..minimal.windows import Windows, derivative, windows
from ..scales import TOUCHES

# A root of a gap's polynomial that is imaginary by this is a double one's rounding, where a gap only touches zero.
IMAGINARY = 1e-7


def first_closings(some: Shapes, poses: Poses, edges: np.ndarray, size: float) -> list[float]:
    """The times (s), in order, at which a gap closes between the first and the last of `edges`, to the accuracy of its
    polynomials; also the first edge if the gap is a rounding below zero there and shrinks. `size`: the plate's, m."""
    motion = windows(some.path(poses), edges, size)
    rows, far = _gap_rows(some, motion), size + float(np.abs(motion.places[0, :2, 0]).sum())
    times = list[float]()
    rates = derivative(rows)
    first, last = rows @ (-1.0) ** np.arange(rows.shape[1]), rows.sum(axis=1)
    sizes = np.abs(rates[:, 1:]).sum(axis=1)
    crosses = rows[:, 0] - np.abs(rows[:, 1:]).sum(axis=1) <= motion.error
    # A gap that grows, or shrinks from one side of zero to the same side, does not close.
    crosses &= (rates[:, 0] - sizes <= 0.0) & ((rates[:, 0] + sizes >= 0.0) | (first * last <= 0.0))
    for k in np.flatnonzero(crosses).tolist():
        row, rate, start, end = rows[k], rates[k], float(motion.start[k]), float(motion.end[k])
        roots = chebyshev.chebroots(row[: _length(row)])
        real = np.sort(roots.real[np.abs(roots.imag) <= IMAGINARY])
        real = np.clip(real[np.abs(real) <= 1.0 + 1e-9], -1.0, 1.0)
        times += [0.5 * (start + end) + 0.5 * (end - start) * z for z in real if chebyshev.chebval(z, rate) < 0.0]
    if -TOUCHES * far <= first[0] <= 0.0 and chebyshev.chebval(-1.0, rates[0]) < 0.0:
        times.append(float(motion.start[0]))
    return sorted(times)


def _length(row: np.ndarray) -> int:
    """How many coefficients are no rounding: at least two."""
    large = np.flatnonzero(np.abs(row) > 1e-18 * np.abs(row).max())
    return max(2, int(large[-1]) + 1) if large.size else 2


def _gap_rows(some: Shapes, motion: Windows) -> np.ndarray:
    """Chebyshev coefficients (windows, k) of something with the sign of the gap: of a line the gap itself, of a circle
    the difference of the squares of both distances, over twice the larger one."""
    x, y = motion.places[:, 0], motion.places[:, 1]
    still, r = some.still, some.moving.radius
    if isinstance(still, Straight):
        rows = still.nx * x + still.ny * y
        rows[:, 0] -= still.nx * still.x + still.ny * still.y + r
        return rows
    degree = 2 * (x.shape[1] - 1)
    nodes = chebyshev.chebpts1(degree + 1)
    to_coefficients = np.linalg.inv(chebyshev.chebvander(nodes, degree))
    dx, dy = chebyshev.chebval(nodes, x.T) - still.x, chebyshev.chebval(nodes, y.T) - still.y
    touch = still.radius - r if still.is_hollow else still.radius + r
    squares = (dx * dx + dy * dy - touch * touch) / (2.0 * touch if touch else 1.0)
    return (-squares if still.is_hollow else squares) @ to_coefficients.T
