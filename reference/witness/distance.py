"""The signed distance of track points from the moving plate, and its rates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from cases import Case

from .plate_motion import Limits
from .stretches import Stretches, evenly

# Least number of outline points (Newton's method starts from the nearest of them), and the number of its steps.
OUTLINE_POINTS, STEPS = 512, 12
# Roundings of positions in a distance.
ROUNDINGS, EPS = 16, 2.0**-52
# Between two points of the outline its curvature exceeds both values by less than this part of their difference.
BETWEEN = 0.25
# The distance up to which the nearest point is unique is searched by this many halvings.
HALVINGS = 30
# A point that Newton's method leaves farther than this (in distances) from the foot of the perpendicular is not
# nearest.
PERPENDICULAR = 1e-7
# A distance above this many sagittas of the outline's polygon is reduced by one sagitta: another point may be nearer.
FAR = 100.0


class PointDistances(NamedTuple):
    """Distances of the middles of stretches from the plate, and bounds, each of shape (n,).

    The distance φ (m), its derivatives along the track and by time (m/s), the angle between its gradient and the
    track's right normal (0 to π rad); the outline's parameter there; the point's speed against the plate, and its part
    along the outline (m/s); bounds on that speed and on its change (m/s²); the rounding of φ (m).
    """

    phi: np.ndarray
    slope: np.ndarray
    rate: np.ndarray
    angle: np.ndarray
    foot: np.ndarray
    speed: np.ndarray
    along: np.ndarray
    most: np.ndarray
    pull: np.ndarray
    fuzz: np.ndarray


class TrackDistance:
    """The distance from one plate. `reach`: the largest distance of its points from its centre of mass; `size`: its
    diameter (m); bounds on its curvature (1/m): `sharpest` the largest, `bluntest` the smallest or 0, `hollow` the size
    of a negative one or 0; `single`: up to this distance (m) a point outside has a unique nearest outline point."""

    def __init__(self, case: Case):
        outline, self.radius = case.plate.outline, case.plate.radius
        self.outline = outline
        self.params, _ = evenly(outline, *outline.span, OUTLINE_POINTS)
        if outline.features:
            self.params = np.union1d(self.params, outline.features.nodes(*outline.span))
        jets = outline.jets(self.params)
        points, speed = jets[:2], np.hypot(jets[2], jets[3])
        bends = np.asarray(outline.curvature(self.params)) * np.ones(len(self.params))
        lengths = np.hypot(*np.diff(points, axis=1))
        self.closed = bool(outline.period)
        if self.closed:
            self.params = self.params[:-1]
        self.tree = cKDTree(points[:, : len(self.params)].T)
        swing = BETWEEN * np.abs(np.diff(bends))
        most, least = np.maximum(bends[1:], bends[:-1]) + swing, np.minimum(bends[1:], bends[:-1]) - swing
        self.sagitta = float((lengths**2 * np.maximum(most, -least)).max()) / 8.0
        self.spacing = float(lengths.max())
        self.reach = float(np.hypot(*points).max()) + self.sagitta
        self.size = float(np.ptp(points, axis=1).max())
        self.bluntest, self.hollow = max(float(least.min()), 0.0), max(-float(least.min()), 0.0)
        if self.hollow <= 1e-9 * float(most.max()):  # a flat side's curvature may be a rounding below zero
            self.hollow = 0.0
        # Up to `single` the gradient turns at most twice as fast as a hollow outline itself.
        self.sharpest = max(float(most.max()), 2.0 * self.hollow)
        self.single = self._single(points, np.array([jets[3], -jets[2]]) / speed) if self.hollow else np.inf

    def _single(self, points: np.ndarray, normals: np.ndarray) -> float:
        """The distance from a non-convex outline up to which its outer normals do not meet, m."""
        far = min(0.5 / self.hollow, self.size)
        for _ in range(HALVINGS):
            away, _ = self.tree.query((points + far * normals).T)
            if np.all(away >= (1.0 - 1e-3) * far - self.sagitta):
                return 0.5 * far
            far *= 0.5
        return 0.0

    def distances(self, bodies: np.ndarray, some: Stretches, bounds: Limits) -> PointDistances:
        """Distances of the stretches' middles, each at the time of its body (6, n)."""
        x, y, theta, vx, vy, spin = bodies
        dx, dy = some.x - x, some.y - y
        far = np.hypot(dx, dy)
        if self.radius is not None:  # only the disc's centre matters
            gx, gy = dx / np.maximum(far, 1e-300), dy / np.maximum(far, 1e-300)
            phi, u, v = far - self.radius, -vx, -vy
            most, pull = bounds.speed + 0.0 * far, bounds.pull + 0.0 * far
            foot = theta
        else:
            c, s = np.cos(theta), np.sin(theta)
            phi, nx, ny, foot = self._nearest(c * dx + s * dy, c * dy - s * dx)
            gx, gy, u, v = c * nx - s * ny, s * nx + c * ny, spin * dy - vx, -spin * dx - vy
            lever = far + some.half
            most = bounds.speed + bounds.spin * lever
            pull = bounds.pull + (bounds.swing + bounds.spin**2) * lever + 2.0 * bounds.spin * most
        slope = gx * some.tx + gy * some.ty
        return PointDistances(
            phi, slope, gx * u + gy * v, np.arctan2(np.abs(slope), gx * some.ty - gy * some.tx), foot,
            np.hypot(u, v), gx * v - gy * u, most, pull,
            ROUNDINGS * EPS * (np.abs(x) + np.abs(y) + np.abs(some.x) + np.abs(some.y) + self.reach),
        )  # fmt: skip

    def foot(self, body: np.ndarray, x: float, y: float) -> float:
        """The parameter of the outline's point nearest to a point."""
        c, s = np.cos(body[2]), np.sin(body[2])
        dx, dy = x - body[0], y - body[1]
        return float(self._nearest(np.array([c * dx + s * dy]), np.array([c * dy - s * dx]))[3][0])

    def _nearest(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The signed distance of points in the plate's frame, the outline's normal at the nearest, its parameter."""
        i = self.tree.query(np.column_stack([x, y]))[1]
        at, (low, high) = self.params[i], self._around(i)
        for _ in range(STEPS):
            a, b, ap, bp, as_, bs, _, _ = self.outline.jets(at)
            dx, dy = x - a, y - b
            bend = dx * as_ + dy * bs - ap * ap - bp * bp
            step = np.where(bend < 0.0, -(dx * ap + dy * bp) / np.where(bend < 0.0, bend, -1.0), 0.0)
            before, at = at, np.clip(at + step, low, high)
            if np.all(np.abs(at - before) <= 4.0 * EPS * (np.abs(low) + np.abs(high))):
                break
        a, b, ap, bp, *_ = self.outline.jets(at)
        p = np.hypot(ap, bp)
        nx, ny, dx, dy = bp / p, -ap / p, x - a, y - b
        phi, far = dx * nx + dy * ny, np.hypot(dx, dy)
        wrong = np.abs(dx * ap + dy * bp) / p > PERPENDICULAR * (far + self.size)
        phi = np.where(wrong, np.copysign(far, phi) - self.spacing, phi)
        return np.where(phi > FAR * self.sagitta, phi - self.sagitta, phi), nx, ny, at

    def _around(self, i: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The parameters of both neighbours of each sample."""
        n, params = len(self.params), self.params
        if not self.closed:
            return params[np.maximum(i - 1, 0)], params[np.minimum(i + 1, n - 1)]
        period = self.outline.period or 0.0
        return (
            np.where(i > 0, params[i - 1], params[-1] - period),
            np.where(i < n - 1, params[(i + 1) % n], params[0] + period),
        )
