"""Places where a plate meets a curve at one instant, besides its contacts: pairs of points with a common normal, from
samples and Newton's method on both parameters (`cases.contact.pair_search`), whose pairs have (6).
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from cases import Chain, Curve, Plate
from cases.contact.pair_search import pair_search
from cases.errors import DoesNotFit

# Samples of an outline, and of the part of a curve that it may meet.
OUTLINE_SAMPLES, CURVE_SAMPLES = 1001, 8001
STEPS = 30
# Of the pairs of samples that are nearer than their neighbours the nearest are refined.
MOST_PAIRS = 8


def meeting_gaps(curve: Curve, plate: Plate, place: complex, turn: complex, closed: list[float]) -> list[float] | None:
    """The gaps (m, positive) of pairs of nearest points of a curve and an outline in a pose, but for those at the
    curve's parameters `closed`; None for chains and pieces, where this is not written."""
    outline = plate.outline
    if any(isinstance(each, Chain) or each.parts is not None for each in (curve, outline)):
        return None
    reach = float(np.abs(_complex(outline.point(np.linspace(*outline.span, OUTLINE_SAMPLES)))).max())
    s, o = _near_samples(curve, place, reach), np.linspace(*outline.span, OUTLINE_SAMPLES)
    if not len(s):
        return []
    if plate.radius is not None:
        return _disc_gaps(curve, plate.radius, place, s, closed)
    points, there = _complex(curve.point(s)), place + turn * _complex(outline.point(o))
    result, search = [], pair_search(curve, outline)
    apart = 1e-5 * reach / float(np.median(curve.speed(s)))
    for i, j in [*_lowest(there, points), *((j, i) for i, j in _lowest(points, there))]:
        with suppress(DoesNotFit):  # no common normal near there
            pair = search(place.real, place.imag, float(np.angle(turn)), (float(s[j]), float(o[i])))
            if all(abs(pair.xi1 - xi1) > apart for xi1 in closed):
                result.append(abs(pair.gap))
    return result


def _disc_gaps(curve: Curve, radius: float, place: complex, s: np.ndarray, closed: list[float]) -> list[float]:
    """The same of a disc: the points of the curve that are nearer to its centre than their neighbours."""
    distance = np.abs(_complex(curve.point(s)) - place)
    lowest = 1 + np.flatnonzero((distance[1:-1] <= distance[:-2]) & (distance[1:-1] <= distance[2:]))
    foot, low, high = s[lowest], s[lowest - 1], s[lowest + 1]
    for _ in range(STEPS):
        x, y, dx, dy, ddx, ddy = curve.jets(foot)[:6]
        away = x + 1j * y - place
        slope = (away * (dx - 1j * dy)).real
        bend = (away * (ddx - 1j * ddy)).real + dx**2 + dy**2
        foot = np.clip(foot - np.where(bend > 0.0, slope / np.where(bend > 0.0, bend, 1.0), 0.0), low, high)
    gaps = np.abs(np.abs(_complex(curve.point(foot)) - place) - radius)
    apart = 1e-9 + (high - low)
    return [
        float(gap)
        for one, gap, width in zip(foot, gaps, apart, strict=True)
        if all(abs(one - c) > width for c in closed)
    ]


def _lowest(some: np.ndarray, others: np.ndarray) -> list[tuple[int, int]]:
    """The nearest of the points that are nearer to the others than their neighbours are, each with its nearest one."""
    from scipy.spatial import cKDTree  # takes a tenth of a second to import

    tree = cKDTree(np.column_stack([others.real, others.imag]))
    distance, nearest = tree.query(np.column_stack([some.real, some.imag]))
    lowest = np.flatnonzero((distance <= np.roll(distance, 1)) & (distance <= np.roll(distance, -1)))
    lowest = lowest[np.argsort(distance[lowest])][:MOST_PAIRS]
    return [(int(i), int(nearest[i])) for i in lowest]


def _complex(rows: np.ndarray) -> np.ndarray:
    return rows[0] + 1j * rows[1]


def _near_samples(curve: Curve, place: complex, reach: float) -> np.ndarray:
    """Parameters of a curve next to a plate, where a curve without ends is looked at from its nearest sample on."""
    s = np.linspace(*curve.span, CURVE_SAMPLES)
    if curve.domain is None and not curve.period:
        for _ in range(60):  # a curve of any length is followed to the plate
            points = _complex(curve.point(s))
            i = int(np.argmin(np.abs(points - place)))
            if 0 < i < len(s) - 1:
                break
            s = s + (s[i] - 0.5 * (s[0] + s[-1])) * 2.0
        width = 3.0 * (reach + float(np.abs(points - place).min())) / float(np.median(curve.speed(s)))
        s = np.linspace(s[i] - width, s[i] + width, CURVE_SAMPLES)
    if curve.features is not None:
        s = np.union1d(s, curve.features.nodes(s[0], s[-1]))
    points = _complex(curve.point(s))
    return s[np.abs(points - place) < 1.2 * reach]
