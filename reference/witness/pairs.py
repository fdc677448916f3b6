"""Pairs of points of outline and track in the track's frame, and Newton's method for their meeting."""

from __future__ import annotations

from math import atan2, cos, hypot, inf, pi, sin
from typing import NamedTuple

import numpy as np

from cases import Case, DoesNotFit
from cases.contact import Contact, find, pose

from .plate_motion import Motion

# Steps of Newton's method; its largest distance from the starting point, in plate's sizes; and its required final error
# in roundings of a position.
STEPS, FURTHEST, ENDS = 30, 0.25, 256.0
EPS = 2.0**-52


class PairFrame(NamedTuple):
    """The outline's point relative to the track's, in the track's frame: offsets, angle, speeds, curvatures,
    velocities."""

    along: float
    gap: float
    angle: float
    P: float
    p: float
    bend_track: float
    bend_outline: float
    slip: float
    lift: float


class Touch(NamedTuple):
    """An instant at which the outline meets the track: time, (x, y, θ, vx, vy, ω), parameters, and the error of the
    time (s)."""

    time: float
    body: list[float]
    xi1: float
    xi2: float
    blur: float


def frame(case: Case, body, xi1: float, xi2: float) -> PairFrame:
    """Position and velocity of the outline's point xi2 relative to the track's point xi1."""
    x, y, theta, vx, vy, w = body
    X, Y, Xp, Yp, Xs, Ys, _, _ = case.track.jet(xi1)
    a, b, ap, bp, as_, bs, _, _ = case.plate.outline.jet(xi2)
    P, p, c, s = hypot(Xp, Yp), hypot(ap, bp), cos(theta), sin(theta)
    tx, ty = Xp / P, Yp / P
    rx, ry = c * a - s * b, s * a + c * b
    ox, oy = (c * ap - s * bp) / p, (s * ap + c * bp) / p
    dx, dy, ux, uy = x + rx - X, y + ry - Y, vx - w * ry, vy + w * rx
    return PairFrame(
        dx * tx + dy * ty, dy * tx - dx * ty, atan2(tx * oy - ty * ox, tx * ox + ty * oy), P, p,
        (Xp * Ys - Yp * Xs) / P**3, (ap * bs - bp * as_) / p**3, ux * tx + uy * ty, uy * tx - ux * ty,
    )  # fmt: skip


def nearest(case: Case, body, xi1: float, xi2: float) -> Contact | None:
    """The pair of nearest points next to parameters; None if there is none."""
    x, y, theta, *_ = body
    try:
        return find(case, x, y, theta, (xi1, xi2))
    except DoesNotFit:
        return None


def in_round(case: Case, theta: float, xi1: float, xi2: float) -> float:
    """The parameter ξ₂ of a contact in the round of the outline that belongs to the plate's angle (rad)."""
    return xi2 - round((theta - float(pose(case, xi1, xi2)[2])) / (2.0 * pi)) * (case.plate.outline.period or 0.0)


def meeting(case: Case, size: float, motion: Motion, time: float, xi1: float, xi2: float) -> Touch | None:
    """Newton's method for a time and both parameters: the points coincide, the tangents are parallel, and the gap
    closes. None if it ends elsewhere."""
    best: Touch | None = None
    smallest, (x0, y0) = inf, motion.bodies(np.array([time]))[:2, 0].tolist()
    for _ in range(STEPS):
        if not (motion.edges[0] <= time <= motion.edges[-1]):
            return None
        body = motion.bodies(np.array([time]))[:, 0].tolist()
        f = frame(case, body, xi1, xi2)
        miss, rounding = hypot(f.along, f.gap, size * f.angle), EPS * (size + abs(body[0]) + abs(body[1]))
        if miss < smallest:
            blur = 16.0 * rounding / max(abs(f.lift), 1e-300) + 4.0 * float(np.spacing(time))
            best, smallest = Touch(time, body, xi1, xi2, blur) if f.lift < 0.0 else None, miss
        elif smallest <= ENDS * rounding:
            break  # no better than before: rounding
        step = _step(f, body[5])
        if step is None or not hypot(body[0] - x0, body[1] - y0) <= FURTHEST * size:
            break
        time, xi1, xi2 = time + step[0], xi1 + step[1] / f.P, xi2 + step[2] / f.p
    return best if smallest <= ENDS * EPS * (size + abs(x0) + abs(y0)) else None


def _step(f: PairFrame, spin: float) -> list[float] | None:
    matrix = [
        [f.slip, f.bend_track * f.gap - 1.0, cos(f.angle)],
        [f.lift, -f.bend_track * f.along, sin(f.angle)],
        [spin, -f.bend_track, f.bend_outline],
    ]
    try:
        step = np.linalg.solve(matrix, [-f.along, -f.gap, -f.angle])
    except np.linalg.LinAlgError:
        return None
    return step.tolist() if np.isfinite(step).all() else None
