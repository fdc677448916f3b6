"""Places where a plate meets a curve at one instant, besides its contacts: pairs of points with a common normal, from
samples and Newton's method on both parameters. No search of a solver is used."""

from __future__ import annotations

import numpy as np

from cases import Chain, Curve, Plate

# Samples of an outline, and of the part of a curve that it may meet.
OUTLINE_SAMPLES, CURVE_SAMPLES = 1001, 8001
STEPS, LONGEST = 30, 0.1
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
    result = []
    apart = 1e-5 * reach / float(np.median(curve.speed(s)))
    for i, j in [*_lowest(there, points), *((j, i) for i, j in _lowest(points, there))]:
        pair = _common_normal(curve, outline, place, turn, float(s[j]), float(o[i]))
        if pair is not None and all(abs(pair[0] - xi1) > apart for xi1 in closed):
            result.append(pair[1])
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


def _common_normal(
    curve: Curve, outline: Curve, place: complex, turn: complex, s: float, o: float
) -> tuple[float, float] | None:
    """The curve's parameter and the distance of the pair that Newton's method finds from a guess: tangents are
    parallel,
    and the distance is along the normal."""
    for _ in range(STEPS):
        x, y, dx, dy, ddx, ddy = (float(np.asarray(v)[0]) for v in curve.jets(np.array([s]))[:6])
        u, v, du, dv, ddu, ddv = (float(np.asarray(w)[0]) for w in outline.jets(np.array([o]))[:6])
        rate, bend = complex(dx, dy), complex(ddx, ddy)
        own, own_rate, own_bend = (turn * complex(*pair) for pair in ((u, v), (du, dv), (ddu, ddv)))
        away = place + own - complex(x, y)
        along, across = (away * rate.conjugate()).real, (rate.conjugate() * own_rate).imag
        matrix = np.array(
            [
                [(away * bend.conjugate()).real - abs(rate) ** 2, (own_rate * rate.conjugate()).real],
                [(bend.conjugate() * own_rate).imag, (rate.conjugate() * own_bend).imag],
            ]
        )
        if not np.isfinite(matrix).all() or np.linalg.det(matrix) == 0.0:
            return None
        step = -np.linalg.solve(matrix, np.array([along, across]))
        longest = max(abs(step[0]) * abs(rate), abs(step[1]) * abs(own_rate)) / (abs(own) or 1.0)
        step *= min(1.0, LONGEST / longest) if longest > 0.0 else 1.0
        s, o = s + float(step[0]), o + float(step[1])
        if longest < 1e-13:
            break
    return (s, abs(away)) if longest < 1e-9 else None
