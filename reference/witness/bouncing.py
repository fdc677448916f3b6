"""The limit of ever smaller bounces, by extrapolation instead of stepping through them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Bounces used in one extrapolation; each must be smaller than the one before by this factor, otherwise rounding grows.
NODES = 8
RATIO = 1.6

# Slip or spin that decreases with the bounces is zero in the limit. The remainder after extrapolation is below this
# part of the last bounce's velocity, and would vanish in a millionth of its duration. (A slip that shrinks by a factor
# of its own, no power of the bounces', leaves 5e-8 of it in a scene whose bounces were all resolved; one that shrinks
# in proportion 1e-9.)
NEGLIGIBLE = 1e-6


class Bounce(NamedTuple):
    """One impact: time, contact state (ξ₁, ξ₂, ω, v) and normal velocity after it, and the phase in which it ended."""

    time: float
    z: tuple[float, float, float, float]
    lift: float
    kind: object


class BounceLimit(NamedTuple):
    """The limit of a sequence of bounces: time and state, and the error of the time (s)."""

    time: float
    z: list[float]
    error: float


def limit(bounces: list[Bounce]) -> BounceLimit | None:
    """The limit of the latest bounces that ended in the same phase; None if there are too few or they do not shrink.

    Along such a sequence time and state are smooth functions of the velocity with which the plate leaves its track
    (that velocity shrinks by a factor which is itself a smooth function of the state). The polynomial through some of
    them is evaluated at velocity zero: Neville's scheme, that is Richardson's extrapolation with the actual ratios.
    """
    alike = [bounces[-1]]
    for earlier in reversed(bounces[:-1]):
        if earlier.kind != bounces[-1].kind or earlier.lift <= alike[-1].lift:
            break
        alike.append(earlier)
    nodes = alike[:1]
    for earlier in alike[1:]:
        if earlier.lift >= RATIO * nodes[-1].lift and len(nodes) < NODES:
            nodes.append(earlier)
    if len(nodes) < 4:
        return None
    lifts = np.array([node.lift for node in nodes])
    # Times relative to the latest bounce, so that their rounding is that of the small remaining times.
    rows = np.array([[node.time - nodes[0].time, *(np.array(node.z) - nodes[0].z)] for node in nodes])
    diagonal = [rows[0]]
    for order in range(1, len(nodes)):
        far, near = lifts[order:, None], lifts[:-order, None]
        rows = (far * rows[:-1] - near * rows[1:]) / (far - near)
        diagonal.append(rows[0])
    # Higher orders are better until rounding dominates: at the smallest difference between two successive orders.
    steps = [abs(float(b[0] - a[0])) for a, b in zip(diagonal[:-1], diagonal[1:], strict=True)]
    best = int(np.argmin(steps[1:])) + 1
    best_row = diagonal[best + 1]
    z = (np.array(nodes[0].z) + best_row[1:]).tolist()
    for velocity in (2, 3):
        if abs(z[velocity]) <= NEGLIGIBLE * nodes[0].lift:
            z[velocity] = 0.0
    return BounceLimit(nodes[0].time + float(best_row[0]), z, steps[best])
