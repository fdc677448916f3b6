"""Checks of curves when they are made: holes, jumps, cusps and self-intersections are errors of one sentence.

A curve is checked at samples, and more closely near special points of its formula and where two samples are farther
apart than the curve's speed explains.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import BadCurve
from ..formulas import features
from .plane_curve import SAMPLES, PlaneCurve

# Distance from a special point of the formula, in spans: a jump shows as a step there, a smooth curve has none.
SIDE_DISTANCE = 1e-9
# A chord that exceeds the length by the speeds at both ends by this factor is checked closely: smooth curves stay below
# two.
LONG_CHORD = 10.0
# The length of such a chord after thirty halvings of its interval, relative to the curve's size, above which it is a
# jump: a slope as steep as that is no track either.
JUMP = 1e-6
# Sides of the polygon for the search of self-intersections: the fewest, per radian of turning for a curve with many
# loops, and the most, each with at most two radians: near longer ones lie most others, each of which is then checked
# closely. The pairs are processed in blocks of rows, those that are near each other in groups of PAIRS.
FEWEST_SIDES, SIDES_A_RADIAN, MOST_SIDES, BLOCK, PAIRS = 240, 8.0, 2400, 200, 2000
# Where two sides cross, each is divided into so many pieces, so many times.
PIECES, CLOSER = 16, 3
# The included part of the neighbours, so that two stretches with one between them stay separate.
AROUND = 0.25
# The fraction of uneven samples: multiples of it modulo 1 have no common period with a curve.
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
# How a curve meets itself that a track may do.
CROSSES = "crosses itself"
# Parts of a curve closer than this fraction of its size coincide: a circle traversed again differs by rounding.
TOGETHER = 1e-9


def check_regular(curve: PlaneCurve) -> None:
    """Raise BadCurve where the curve or a derivative is not finite, jumps, or has zero speed."""
    low, high = curve.domain or (0.0, curve.period or 2 * np.pi * curve.unit)
    _check_changes(curve, *curve.span)
    try:
        places = _places(curve, low, high)
        jets = curve.jets(places)
    except Exception as problem:
        raise BadCurve(f"the curve cannot be evaluated ({problem}); use the functions of cases.curves") from problem
    bad = ~np.all(np.isfinite(jets), axis=0)
    if bad.any():
        raise BadCurve(
            f"the curve or a derivative is not finite at s = {places[bad][0]:.6g}; give a domain that leaves it out"
        )
    speed = np.hypot(jets[2], jets[3])
    _check_speed(curve, places, speed, int(np.argmin(speed)), "has a cusp (R_p = 0)", sign=1.0)
    _check_speed(curve, places, speed, int(np.argmax(speed)), "is not finite", sign=-1.0)
    _check_jumps(curve, places, jets[:2], speed)


def _check_changes(curve: PlaneCurve, low: float, high: float) -> None:
    """Raise BadCurve if the curve changes direction or speed more often than the tables of its features can hold.

    Of |R_s|/|R_p| (per unit of the parameter) over uneven samples the median counts: few sharp bends do not move it.
    """
    places = low + (high - low) * (GOLDEN * np.arange(SAMPLES) % 1.0)
    with np.errstate(all="ignore"):
        try:
            _, _, xp, yp, xs, ys, _, _ = curve.jets(places)
        except Exception:  # `check_regular` evaluates it again and says so
            return
        changes = (high - low) * np.hypot(xs, ys) / np.hypot(xp, yp)
    most = features.MOST_PIECES // 2  # a radian of change takes two pieces or more
    if np.count_nonzero(changes > most) > SAMPLES / 2:
        raise BadCurve(
            f"the curve changes more than {most} times between s = {low:g} and {high:g}, which no "
            "table resolves; give a shorter domain, or a formula that oscillates less"
        )


def _places(curve: PlaneCurve, low: float, high: float) -> np.ndarray:
    """Even samples, and the special points of the formula with both sides of each."""
    centres = np.array(curve.centres)
    shift = SIDE_DISTANCE * (high - low)
    centres = np.concatenate([centres - shift, centres, centres + shift])
    return features.union(np.linspace(low, high, SAMPLES), centres[(centres > low) & (centres < high)])


def _check_speed(curve: PlaneCurve, s: np.ndarray, speed: np.ndarray, index: int, what: str, sign: float) -> None:
    """Raise BadCurve if the speed goes to zero (sign 1) or to infinity (sign −1) near the sample `index`."""
    typical = np.partition(speed, len(speed) // 2)[len(speed) // 2]  # `np.median` imports masked arrays
    if not 0.0 < typical < np.inf:
        raise BadCurve(f"the curve's speed |R_p| is {typical:g} m; give a curve with an extent a double can hold")
    # Only extreme samples are checked closely; a regular curve's speed varies by a few orders of magnitude, and seven
    # of them within one sample's width is a cusp or a pole.
    if abs(np.log10(speed[index] / typical)) < 2:
        return
    from scipy.optimize import minimize_scalar  # slow to import, seldom needed

    low, high = s[max(index - 1, 0)], s[min(index + 1, len(s) - 1)]
    minimum = minimize_scalar(
        lambda v: curve.speed(np.array([v]))[0] ** (2 * sign),
        bounds=(low, high), method="bounded", options={"xatol": 1e-12 * (high - low)},
    )  # fmt: skip
    extreme = curve.speed(np.array([minimum.x]))[0]
    if not abs(np.log10(extreme / typical)) < 7:
        raise BadCurve(f"the curve {what} near s = {minimum.x:.6g}; give a domain that leaves it out")


def _check_jumps(curve: PlaneCurve, s: np.ndarray, points: np.ndarray, speed: np.ndarray) -> None:
    """Raise BadCurve if two neighbouring samples stay apart as their parameters approach each other."""
    chords = np.hypot(*np.diff(points, axis=1))
    bound = np.diff(s) * np.maximum(speed[1:], speed[:-1])
    size = float(np.ptp(points, axis=1).max())
    suspicious = np.flatnonzero((chords > LONG_CHORD * bound) & (chords > JUMP * size))
    low, high = s[suspicious], s[suspicious + 1]
    for _ in range(30 if len(suspicious) else 0):  # each towards the half that holds more of its chord
        middle = 0.5 * (low + high)
        a, b, c = (curve.point(place) for place in (low, middle, high))
        first = np.hypot(*(b - a)) >= np.hypot(*(c - b))
        low, high = np.where(first, low, middle), np.where(first, middle, high)
    apart = np.hypot(*(curve.point(high) - curve.point(low))) if len(suspicious) else np.zeros(0)
    if (~(apart <= JUMP * size)).any():
        worst = int(np.argmax(~(apart <= JUMP * size)))
        raise BadCurve(
            f"the curve jumps by {apart[worst]:.3g} m at s = {low[worst]:.6g}; give a domain that leaves it out"
        )


# --- curves that meet themselves --------------------------------------------------------------------------------------


def check_simple(curve: PlaneCurve) -> None:
    """Raise BadCurve if the curve crosses itself or runs over itself.

    A closed curve that does neither turns once (Hopf's theorem of turning tangents: not looked up). A curve without
    ends is checked on `Curve.span`, if it is finite there.
    """
    if curve.may_cross:
        return
    with np.errstate(all="ignore"):  # a lower bound of the total turn: between even samples it is less than half a turn
        _, _, xp, yp, *_ = curve.jets(np.linspace(*curve.span, 2 * MOST_SIDES + 1))
        turning = float(np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(yp, xp))))).sum())
    if not turning > 2 * MOST_SIDES:  # else the tables would take seconds
        turning = float(np.abs(np.diff(curve.angle_table(curve.span)[1])).sum())
    if not np.isfinite(turning):
        return
    low, high = curve.span
    if curve.period:
        times = float(curve.tangent_angle(high) - curve.tangent_angle(low)) / (2 * np.pi)
        if round(abs(times)) > 1:
            raise BadCurve(
                f"the closed curve turns {round(abs(times))} times in its period {curve.period:.6g}, so that it meets "
                "itself; give one round"
            )
    if turning > 2 * MOST_SIDES:
        raise BadCurve(
            f"the curve turns by {turning:.3g} rad or more, and whether it meets itself is known up to "
            f"{2 * MOST_SIDES} rad; give a shorter domain, or may_cross=True"
        )
    # An open curve comes back to itself only if it turns by more than half a turn, a closed one that turns by exactly
    # one is convex; 0.1 is well below what a loop adds.
    if turning < (2 * np.pi + 0.1 if curve.period else np.pi):
        return
    sides = int(min(MOST_SIDES, max(FEWEST_SIDES, SIDES_A_RADIAN * turning)))
    # So that symmetric curves do not cross exactly at two corners.
    grid = _corners(curve, sides, offset=0.37 if curve.period else 0.0)
    meeting = _meeting(curve, grid)
    if meeting:
        how, first, second = meeting
        x, y = curve.point(first)
        crossing = f"the curve {how} near ({x:.4g}, {y:.4g}) m, at s = {first:.4g} and s = {second:.4g}"
        allowed = "allow it with may_cross=True, or " if how == CROSSES else ""
        raise BadCurve(f"{crossing}; {allowed}give a shorter domain")


def _corners(curve: PlaneCurve, count: int, offset: float) -> np.ndarray:
    """Parameters of the corners of a polygon of `count` sides along the whole curve, denser where it bends.

    For a closed curve the first corner is shifted by the fraction `offset` of a side.
    """
    grid, angle = curve.angle_table(curve.span)
    steps = np.hypot(*np.diff(curve.point(grid), axis=1))
    turns = np.abs(np.diff(angle))
    # Half of the sides are distributed by length, half by turning.
    parts = np.insert(np.cumsum(steps / steps.sum() + turns / max(float(turns.sum()), 1e-300)), 0, 0.0)
    values = np.interp((np.arange(count + 1) + offset) / count * parts[-1], parts, grid)
    if offset:
        values[-1] = values[0] + (grid[-1] - grid[0])
    return values


def _meeting(curve: PlaneCurve, grid: np.ndarray) -> tuple[str, float, float] | None:
    """How, and at which two parameters, the curve meets itself; None if it does not."""
    polygon = _Polygon.of(curve, grid)
    if polygon is None:
        return None
    size = float(np.ptp(polygon.start, axis=0).max())
    last = len(polygon.lengths) - 1
    low, high = (-np.inf, np.inf) if curve.period else (grid[0], grid[-1])
    for first in range(0, last, BLOCK):
        rows = slice(first, first + BLOCK)
        later = np.arange(last + 1)[None] - np.arange(last + 1)[rows, None] >= 2
        if curve.period and first == 0:
            later[0, -1] = False  # the first side's neighbour
        for i, j in zip(*np.nonzero(later & polygon.crossings(rows)), strict=True):
            if _crosses(curve, (grid[first + i], grid[first + i + 1]), (grid[j], grid[j + 1]), (low, high)):
                return CROSSES, float(grid[first + i]), float(grid[j])
        pairs = np.argwhere(later & polygon.beside(rows, TOGETHER * size))
        for i, j in (pairs[k : k + PAIRS].T for k in range(0, len(pairs), PAIRS)):
            meets = np.flatnonzero(_together(curve, grid[first + i], grid[j], grid[j + 1], size))
            if meets.size:
                return "runs over itself", float(grid[first + i[meets[0]]]), float(grid[j[meets[0]]])
    return None


class _Polygon(NamedTuple):
    """The sides of a polygon along a curve: ends (n, 2), lengths, directions, and the curve's turn in each."""

    start: np.ndarray
    end: np.ndarray
    lengths: np.ndarray
    directions: np.ndarray
    turns: np.ndarray

    @classmethod
    def of(cls, curve: PlaneCurve, grid: np.ndarray) -> _Polygon | None:
        """The polygon with corners at those parameters; None where it has no finite sides."""
        points, angles = curve.point(grid).T, curve.tangent_angle(grid)
        a, b = points[:-1], points[1:]
        lengths = np.hypot(*(b - a).T)
        if not np.all(np.isfinite(points)) or not np.all(lengths > 0.0):
            return None
        return cls(a, b, lengths, (b - a) / lengths[:, None], np.abs(np.diff(angles)))

    def crossings(self, rows: slice) -> np.ndarray:
        """Which of these sides cross which of all sides."""
        p, q, u, v = self.start[rows, None], self.end[rows, None], self.start[None], self.end[None]
        return (_side(p, q, u) * _side(p, q, v) < 0) & (_side(u, v, p) * _side(u, v, q) < 0)

    def beside(self, rows: slice, least: float) -> np.ndarray:
        """Which of these sides begin on or near which of all sides, within their distance from the curve."""
        p, u = self.start[rows, None], self.start[None]
        along = ((p - u) * self.directions[None]).sum(axis=2)
        off = np.abs(_side(u, self.end[None], p)) / self.lengths[None]
        strays = self.lengths * (0.25 * self.turns) + least
        return (along >= -strays) & (along <= self.lengths + strays) & (off <= strays)


def _crosses(
    curve: PlaneCurve, one: tuple[float, float], other: tuple[float, float], ends: tuple[float, float]
) -> bool:
    """Whether two stretches of a curve cross whose chords do: close stretches may cross only as polygons.

    Near a corner, chords may cross where the curve crosses in the next stretch: each is checked with a part of both its
    neighbours, within the curve's `ends`.
    """
    for _ in range(CLOSER):
        finer = []
        for low, high in (one, other):
            more = AROUND * (high - low)
            finer.append(np.linspace(max(low - more, ends[0]), min(high + more, ends[1]), PIECES + 1))
        first, second = (curve.point(grid).T for grid in finer)
        p, q, u, v = first[:-1, None], first[1:, None], second[None, :-1], second[None, 1:]
        i, j = np.nonzero((_side(p, q, u) * _side(p, q, v) <= 0) & (_side(u, v, p) * _side(u, v, q) <= 0))
        if not i.size:
            return False
        one, other = ((float(g[k]), float(g[k + 1])) for g, k in zip(finer, (i[0], j[0]), strict=True))
    return True


def _side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
    return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])


def _together(curve: PlaneCurve, s: np.ndarray, low: np.ndarray, high: np.ndarray, size: float) -> np.ndarray:
    """Which of the curve's points at s (n,) lie on the curve between two later parameters, each with its own (n,)."""
    here, width = curve.point(s), high - low
    low, high, away = low - 0.5 * width, high + 0.5 * width, np.zeros_like(s)
    near = np.arange(len(s))
    for _ in range(8):  # ever closer around the nearest of seventeen
        places = np.linspace(np.maximum(low[near], s[near] + width[near]), high[near], 17, axis=1)
        points = curve.point(places.ravel()).reshape(2, -1, 17)
        distances = np.hypot(*(points - here[:, near, None]))
        away[near] = distances.min(axis=1)
        nearest, step = places[np.arange(len(near)), np.argmin(distances, axis=1)], places[:, 1] - places[:, 0]
        low[near], high[near] = nearest - step, nearest + step
        # Between two samples, the curve is no farther from them than its length there: less than two chords.
        chords = np.hypot(*np.diff(points, axis=2)).max(axis=1)
        near = near[away[near] <= 2.0 * chords + TOGETHER * size]
    return np.isin(np.arange(len(s)), near) & (away <= TOGETHER * size)
