"""First meeting of a moving plate and its track: branch and bound over time, track and outline.

Boxes in which a meeting is excluded are dropped; the time ranges of the others are narrowed (an interval Newton step),
and the direction that contributes most to the gap's uncertainty is halved. So no meeting is missed, however fine the
geometry is. If the outline bends more than the track and the gap closes throughout a box, it contains at most one
meeting, and Newton's method finds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, hypot, isnan, nan, sin, sqrt
from typing import NamedTuple

import numpy as np

from cases.curves.curve_pieces import HIGH, LOW, REACH, TooMuch, X, Y

from ..scales import EPS
from .boxes import Bounds, Boxes, Cores, Geometry
from .windows import Windows

# Work is counted in boxes that are bounded and divided among many others, about 3 µs each. A round takes as long as so
# many more, however few its boxes are, and so does Newton's method in one box (on one core, 1.6 ms and 1 ms in 5,000
# rounds).
ROUND, ONE_BY_ONE = 500, 300
# Limit on the work of one motion's search, six seconds, before the plate has moved, and for each time in which it moves
# by its size, or would fall by it: a long motion may take longer, one that hardly goes on may not.
MOST_WORK = 2_000_000
# Boxes processed together: a hundred megabytes.
TOGETHER = 60_000
# Fewer boxes than these are halved once more before they are bounded: the bounds of twice as many take hardly longer.
FEW = 200
# Newton's method is tried in at most MOST_TRIES boxes per round, with at most STEPS steps.
MOST_TRIES, STEPS = 4, 20
# A meeting outside a box by less than this part of it counts as inside, because the neighbour may assign it to this
# box.
BEYOND = 1e-6


class Meeting(NamedTuple):
    """A meeting of outline and track: time (s) and parameters; `xi2` is NaN for a disc."""

    time: float
    xi1: float
    xi2: float


class MeetingSearch:
    """The search for first meetings of one track and one outline, or point; counts its work."""

    def __init__(self, geometry: Geometry, fall: float):
        """`fall`: the acceleration (m/s²) of a free plate by its weight."""
        self.geometry, self.fall = geometry, fall
        self.work, self.limit, self.since = 0, 0.0, nan

    def first(self, motion: Windows, cores: Sequence[Cores] = ()) -> Meeting | None:
        """The first meeting in the windows outside all cores, to the accuracy of their polynomials; None if there is
        none. Raises TooMuch."""
        self._extend_limit(motion)
        earliest: Meeting | None = None
        todo = [self._first_boxes(motion)]
        while todo:
            boxes = todo.pop()
            if earliest:
                boxes = boxes.some(boxes.start < earliest.time)
            if not boxes.number:
                continue
            if boxes.number > TOGETHER:
                order = np.argsort(boxes.start, kind="stable")
                todo += [boxes.some(part) for part in reversed(np.array_split(order, 2))]
                continue
            self._spend(ROUND + boxes.number)
            box_bounds = self.geometry.bounds(motion, boxes)
            for some_cores in cores:
                box_bounds = self._outside(boxes, box_bounds, some_cores)
            rest = np.flatnonzero(box_bounds.possible)
            boxes = boxes.some(rest)._replace(start=box_bounds.start[rest], end=box_bounds.end[rest])
            complete, earliest = self._complete_boxes(motion, boxes, box_bounds, rest, earliest)
            some = np.flatnonzero(~complete)
            if some.size:
                parts, blur = self.geometry.divide(boxes.some(some), box_bounds.blur[:, rest[some]])
                if parts.number < FEW:
                    parts, _ = self.geometry.divide(parts, blur)
                todo.append(parts)
        return earliest

    def _extend_limit(self, motion: Windows) -> None:
        """Extend the limit on work by the plate's motion since the first search."""
        start, size = float(motion.start[0]), self.geometry.reach
        self.since = start if isnan(self.since) else self.since
        rate = max(float(motion.speed[0]) / size + float(motion.spin[0]), sqrt(self.fall / size))
        self.limit = max(self.limit, MOST_WORK * (1.0 + rate * (start - self.since)))

    def _spend(self, boxes: int) -> None:
        self.work += boxes
        if self.work > self.limit:
            raise TooMuch

    def _first_boxes(self, motion: Windows) -> Boxes:
        """The first boxes: the curves' initial pieces, for the track those that the plate may reach in a window."""
        track, outline = self.geometry.track, self.geometry.outline
        (x, y, _), _ = motion.at(np.arange(len(motion.start)), 0.5 * (motion.start + motion.end))
        reach = self.geometry.farthest + 0.5 * (motion.end - motion.start) * motion.speed
        roots = track.around(x, y, reach)
        t = track.table(roots)
        away = np.hypot(x[:, None] - t[X], y[:, None] - t[Y])
        window, i = np.nonzero(~(away > (1.0 + 1e-12) * (t[REACH] + reach[:, None])))
        places = outline.roots[:1] if self.geometry.radius is not None else outline.roots
        i, j = np.repeat(roots[i], len(places)), np.tile(places, len(window))
        window = np.repeat(window, len(places))
        return Boxes(window, i, j, motion.start[window], motion.end[window])

    def _outside(self, boxes: Boxes, box_bounds: Bounds, cores: Cores) -> Bounds:
        """The bounds without boxes inside the cores; a box that is partly inside is divided further."""
        inside, across, blur = self.geometry.against(boxes, cores)
        return box_bounds._replace(
            possible=box_bounds.possible & ~inside,
            single=box_bounds.single & ~across,
            blur=np.where(across, np.maximum(box_bounds.blur, blur), box_bounds.blur),
        )

    def _complete_boxes(
        self, motion: Windows, boxes: Boxes, box_bounds: Bounds, rest: np.ndarray, earliest: Meeting | None
    ) -> tuple[np.ndarray, Meeting | None]:
        """Which boxes need no further division, and the earliest meeting so far."""
        complete = np.zeros(boxes.number, dtype=bool)
        order = np.argsort(boxes.start, kind="stable")
        for k in order[box_bounds.single[rest][order]][:MOST_TRIES].tolist():
            meeting = self._locate(motion, boxes, k)
            complete[k] = meeting is not None
            earliest = _first(earliest, meeting)
        # Bounds that are no wider than rounding cannot improve.
        narrow = ~complete & (box_bounds.blur[:, rest].sum(axis=0) <= box_bounds.rounding[rest])
        for k in order[narrow[order]].tolist():
            if earliest and boxes.start[k] >= earliest.time:
                break
            earliest = _first(earliest, self._touching(motion, boxes, k))
        return complete | narrow, earliest

    # --- one box ------------------------------------------------------------------------------------------------------

    def _locate(self, motion: Windows, boxes: Boxes, k: int) -> Meeting | None:
        """The meeting in one box by Newton's method; None if it does not find it there."""
        self._spend(ONE_BY_ONE)
        low, high = self._corners(boxes, k)
        wide = high - low
        at = 0.5 * (low + high)
        window, before = int(boxes.window[k]), np.full(len(at), np.inf)
        for _ in range(STEPS):
            step = self._step(motion, window, at)
            if step is None:
                return None
            at, size = at + step, np.abs(step)
            if np.any(np.abs(at - 0.5 * (low + high)) > 2.0 * wide + 1e-9 * np.abs(at)):
                return None
            beyond = BEYOND * wide + 8.0 * EPS * np.abs(at)
            # Where the plate hardly fits, roundings of the gap are more than those of the parameters.
            is_rounding = np.all(size <= beyond) and np.all(size >= before)
            if is_rounding or np.all(size <= 1e-10 * wide + 4.0 * EPS * np.abs(at)):
                inside = np.all((low - beyond <= at) & (at <= high + beyond))
                return self._meeting(at) if inside else None
            before = size
        return None

    def _touching(self, motion: Windows, boxes: Boxes, k: int) -> Meeting | None:
        """The meeting in a box in which the gap is only rounding, if the gap does not grow there; else None."""
        self._spend(ONE_BY_ONE)
        low, high = self._corners(boxes, k)
        at = 0.5 * (low + high)
        for _ in range(STEPS):
            step = self._step(motion, int(boxes.window[k]), at, still=True)
            if step is None:
                break
            at = np.clip(at + step, low, high)
        _, rates = self._apart(motion, int(boxes.window[k]), at)
        return self._meeting(at) if rates[1, 0] <= 0.0 else None

    def _corners(self, boxes: Boxes, k: int) -> tuple[np.ndarray, np.ndarray]:
        """The ranges of time, track and (unless it is a disc's) outline of one box."""
        tables = [self.geometry.track.table(boxes.track[k : k + 1])]
        if self.geometry.radius is None:
            tables.append(self.geometry.outline.table(boxes.outline[k : k + 1]))
        low = [float(boxes.start[k]), *(float(table[LOW, 0]) for table in tables)]
        high = [float(boxes.end[k]), *(float(table[HIGH, 0]) for table in tables)]
        return np.array(low), np.array(high)

    def _meeting(self, at: np.ndarray) -> Meeting:
        return Meeting(float(at[0]), float(at[1]), float(at[2]) if len(at) > 2 else np.nan)

    def _step(self, motion: Windows, window: int, at: np.ndarray, still: bool = False) -> np.ndarray | None:
        """Newton's step for the time and the parameters at which the two points coincide with parallel tangents; if
        `still`, for the parameters at which the points are opposite each other at fixed time. None if singular."""
        off, rates = self._apart(motion, window, at)
        if still:  # time and gap are fixed
            rates[:, 0], rates[1], off[1] = 0.0, 0.0, 0.0
            rates[1, 0] = 1.0
        try:
            step = np.linalg.solve(rates, -off)
        except np.linalg.LinAlgError:
            return None
        return step if np.isfinite(step).all() else None

    def _apart(self, motion: Windows, window: int, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far the two points are apart along the track's tangent and its normal (m), the angle between both
        tangents (not of a disc, whose point has the track's), and their derivatives by time and both parameters."""
        (x, y, theta), (vx, vy, omega) = (row[:, 0].tolist() for row in motion.at(np.array([window]), at[:1]))
        X0, Y0, Xp, Yp, Xs, Ys, _, _ = self.geometry.track.jet(float(at[1]))
        P = hypot(Xp, Yp)
        bend = (Xp * Ys - Yp * Xs) / P**3
        tx, ty = Xp / P, Yp / P
        if self.geometry.radius is not None:
            r = self.geometry.radius
            off = np.array([(x - X0) * tx + (y - Y0) * ty, (y - Y0) * tx - (x - X0) * ty - r])
            rates = np.array(
                [[vx * tx + vy * ty, P * (bend * (off[1] + r) - 1.0)], [vy * tx - vx * ty, -P * bend * off[0]]]
            )
        else:
            a, b, ap, bp, as_, bs, _, _ = self.geometry.outline.jet(float(at[2]))
            c, s, p = cos(theta), sin(theta), hypot(ap, bp)
            rx, ry, ox, oy = c * a - s * b, s * a + c * b, c * ap - s * bp, s * ap + c * bp
            dx, dy, ux, uy = x + rx - X0, y + ry - Y0, vx - omega * ry, vy + omega * rx
            off = np.array([
                dx * tx + dy * ty, dy * tx - dx * ty, atan2(tx * oy - ty * ox, tx * ox + ty * oy)
            ])  # fmt: skip
            rates = np.array([
                [ux * tx + uy * ty, P * (bend * off[1] - 1.0), tx * ox + ty * oy],
                [uy * tx - ux * ty, -P * bend * off[0], tx * oy - ty * ox],
                [omega, -P * bend, (ap * bs - bp * as_) / p**2],
            ])  # fmt: skip
        return off, rates


def _first(one: Meeting | None, other: Meeting | None) -> Meeting | None:
    if one is None or other is None:
        return one or other
    return one if one.time <= other.time else other
