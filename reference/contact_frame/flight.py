"""Free flight of the second formulation, and its search for the landing, wherever on outline and track that is.

The outline is looked at as several hundred points whose signed distances from a densely sampled track are found with a
tree of nearest neighbours; the closest pairs are refined by Newton's method in the frame of the track. Looks follow
each other no faster than the plate could close its gap, down to a hundredth of its size.
"""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, inf, isfinite, sin, sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar
from scipy.spatial import cKDTree

from cases import Curve

from .equations import Scene
from .steps import Lost, Paced, UsedUp, Work

# Points of the outline looked at, and track samples to the size of a plate: the sagitta between neighbours is some
# 1e-5 of the size, so that every valley between the two curves wider than a hundredth of the plate is seen, and
# Newton's method starts well inside its basin.
OUTLINE_POINTS = 512
TRACK_POINTS_TO_A_SIZE = 128
MOST_TRACK_POINTS = 400_000

# A track this many plates long is not searched for landings: its samples would be dozens of plates apart.
LONGEST_TRACK = 1e7

# Between two looks no point of the plate moves by more than this part of its size, unless the gap is wider anyway.
STRIDE = 0.02

# Valleys whose sampled depth is within this part of the size of the lowest are refined; sampling errs by far less.
NEAR = 0.02

# A gap below this part of the size is none: rounding of a contact's pose is a millionth of it, the gap of the shortest
# flight that is followed a thousand times as wide.
TOUCH = 1e-10

# More valleys than this in one look are one long flat one, as of a disc in the middle of a circle.
MOST_VALLEYS = 12


class Pair(NamedTuple):
    """A pair of points where outline and track come close: signed gap (m) and parameters."""

    gap: float
    xi1: float
    xi2: float


class Frame(NamedTuple):
    """Outline's point seen from the track's, in the track's frame: offsets, angle, speeds, curvatures, velocities."""

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
    """An instant at which the outline meets the track: time, (x, y, θ, vx, vy, ω) and contact parameters."""

    time: float
    body: list[float]
    xi1: float
    xi2: float


class Flown(NamedTuple):
    """A flight: pieces (start, end, interpolant), its end, and the touch that ended it, if one did. One whose work is
    used up ends at its last look."""

    pieces: list[tuple[float, float, Callable]]
    end: float
    touch: Touch | None


def frame(scene: Scene, body, xi1: float, xi2: float) -> Frame:
    """Where the outline's point xi2 is and how it moves, seen from the track's point xi1."""
    x, y, theta, vx, vy, w = body
    X, Y, Xp, Yp, Xs, Ys, _, _ = scene.track.jet(xi1)
    a, b, ap, bp, as_, bs, _, _ = scene.outline.jet(xi2)
    P, p, c, s = hypot(Xp, Yp), hypot(ap, bp), cos(theta), sin(theta)
    tx, ty = Xp / P, Yp / P
    rx, ry = c * a - s * b, s * a + c * b
    ox, oy = (c * ap - s * bp) / p, (s * ap + c * bp) / p
    dx, dy, ux, uy = x + rx - X, y + ry - Y, vx - w * ry, vy + w * rx
    return Frame(
        dx * tx + dy * ty, dy * tx - dx * ty, atan2(tx * oy - ty * ox, tx * ox + ty * oy), P, p,
        (Xp * Ys - Yp * Xs) / P**3, (ap * bs - bp * as_) / p**3, ux * tx + uy * ty, uy * tx - ux * ty,
    )  # fmt: skip


class Surroundings:
    """Outline and track of a scene as samples, for global looks at where they come close."""

    def __init__(self, scene: Scene, xi1: float):
        self.scene = scene
        self.fine = np.zeros(0, dtype=int)
        self.params2, _ = _even(scene.outline, *scene.outline.span, OUTLINE_POINTS)
        if scene.outline.features:
            self.params2 = np.union1d(self.params2, scene.outline.features.places(*scene.outline.span))
        self.points = scene.outline.point(self.params2)
        self.closed = bool(scene.outline.period)
        if self.closed:
            self.params2, self.points = self.params2[:-1], self.points[:, :-1]
        self.outline_tangents = scene.outline.tangent(self.params2)
        self.outline_tree = cKDTree(self.points.T)
        self.reach = float(np.hypot(*self.points).max())
        self.size = float(np.ptp(self.points, axis=1).max())
        track = scene.track
        self.ends = track.domain is not None and not track.period
        self.endless = track.domain is None and not track.period
        if self.endless:
            # A window of an endless track, some sizes to either side; it grows where the plate comes near its ends.
            margin = 8.0 * self.size / float(track.speed(xi1))
            self._sample(xi1 - margin, xi1 + margin)
        else:
            self._sample(*track.span)

    def _sample(self, low: float, high: float) -> None:
        track = self.scene.track
        _, length = _even(track, low, high, 257)
        if not length <= LONGEST_TRACK * self.size:
            raise Lost(
                f"landings are searched on {length:.3g} m of track by a plate of {self.size:.3g} m; "
                "give a larger plate or a shorter track"
            )
        count = int(min(MOST_TRACK_POINTS, max(512, TRACK_POINTS_TO_A_SIZE * length / self.size)))
        self.params1, _ = _even(track, low, high, count)
        if track.features:
            # Beside what the plate's size asks for, all that shows the track's own features.
            fine = track.features.places(low, high)[1:-1]
            self.params1 = np.union1d(self.params1, fine)
            self.fine = np.searchsorted(self.params1, fine)
        jets = track.jets(self.params1)
        self.track_points = jets[:2]
        self.tangents = jets[2:4] / np.hypot(jets[2], jets[3])
        self.tree = cKDTree(self.track_points.T)

    def closest(self, body) -> Pair:
        """The smallest signed gap in a pose; infinite where no point of the outline lies beside the track."""
        return min(self._refined(body, *self.gaps(body)), self._tips(body))

    def gaps(self, body) -> tuple[np.ndarray, np.ndarray]:
        """Signed gaps of the outline's samples in a pose, and which sample of the track each is nearest to."""
        x, y, theta = body[0], body[1], body[2]
        c, s = cos(theta), sin(theta)
        px, py = x + c * self.points[0] - s * self.points[1], y + s * self.points[0] + c * self.points[1]
        _, nearest = self.tree.query(np.column_stack([px, py]))
        if self.endless and self._widened(nearest):
            return self.gaps(body)
        dx, dy = px - self.track_points[0, nearest], py - self.track_points[1, nearest]
        tx, ty = self.tangents[:, nearest]
        gaps = dy * tx - dx * ty
        if self.ends:
            # Points beside the end of an open track have nothing below them to land on.
            gaps[(nearest == 0) | (nearest == len(self.params1) - 1)] = inf
        return gaps, nearest

    def _tips(self, body) -> Pair:
        """The closest of the track's features, which may come up between two points of the outline; refined."""
        x, y, theta = body[0], body[1], body[2]
        c, s = cos(theta), sin(theta)
        u, v = self.track_points[0, self.fine] - x, self.track_points[1, self.fine] - y
        near = np.flatnonzero(np.hypot(u, v) < self.reach + NEAR * self.size)
        if not near.size or not self.closed:
            return Pair(inf, np.nan, np.nan)
        u, v = (c * u + s * v)[near], (c * v - s * u)[near]
        _, places = self.outline_tree.query(np.column_stack([u, v]))
        tx, ty = self.outline_tangents[:, places]
        # The plate is on the left of its outline, what is outside on the right.
        gaps = (u - self.points[0, places]) * ty - (v - self.points[1, places]) * tx
        lowest = int(np.argmin(gaps))
        return self.refined(
            body,
            Pair(
                float(gaps[lowest]), float(self.params1[self.fine[near[lowest]]]), float(self.params2[places[lowest]])
            ),
        )

    def _widened(self, nearest) -> bool:
        """Whether the window of an endless track had to grow, because the plate is near one of its ends."""
        count, margin = len(self.params1), len(self.params1) // 16
        low, high = self.params1[0], self.params1[-1]
        before = low, high
        if nearest.min() < margin:
            low -= high - low
        if nearest.max() >= count - margin:
            high += high - low
        if (low, high) == before:
            return False
        self._sample(low, high)
        return True

    def _refined(self, body, gaps, nearest) -> Pair:
        """The lowest valley of the sampled gaps, refined."""
        rough = self.valleys(gaps, nearest)
        if not rough:
            return Pair(inf, np.nan, np.nan)
        if rough[0].gap > 0.5 * self.size:
            return rough[0]  # far away; a look only asks how long nothing can happen
        return min(self.refined(body, pair) for pair in rough if pair.gap <= rough[0].gap + NEAR * self.size)

    def valleys(self, gaps, nearest) -> list[Pair]:
        """The lowest places of the sampled gaps, the lowest first."""
        left, right = np.roll(gaps, 1), np.roll(gaps, -1)
        if not self.closed:
            left[0] = right[-1] = -inf  # the end of an open outline is no point of contact
        valleys = np.nonzero((gaps <= left) & (gaps <= right) & np.isfinite(gaps))[0]
        lowest = sorted(valleys, key=gaps.__getitem__)[:MOST_VALLEYS]
        return [Pair(float(gaps[i]), float(self.params1[nearest[i]]), float(self.params2[i])) for i in lowest]

    def refined(self, body, pair: Pair) -> Pair:
        """Newton's method in arc lengths: the outline's point straight above the track's, their tangents parallel."""
        xi1, xi2, features = pair.xi1, pair.xi2, self.scene.track.features
        for _ in range(30):
            f = frame(self.scene, body, xi1, xi2)
            # d(along) = (κ_track gap − 1) ds_track + cos(angle) ds_outline; d(angle) = −κ_track, κ_outline.
            a, b = f.bend_track * f.gap - 1.0, cos(f.angle)
            det = a * f.bend_outline + b * f.bend_track
            if det == 0.0 or not isfinite(det):
                return pair
            step1 = (b * f.angle - f.bend_outline * f.along) / det
            step2 = -(a * f.angle + f.bend_track * f.along) / det
            longest = max(abs(step1), abs(step2))
            furthest = 0.1 * self.size
            if features:  # the tangents that Newton's method follows are not true beyond the next feature
                furthest = min(furthest, f.P * abs(features.clear(xi1, xi1 + self.size / f.P) - xi1))
            shorten = min(1.0, furthest / max(longest, 1e-300))
            xi1, xi2 = xi1 + shorten * step1 / f.P, xi2 + shorten * step2 / f.p
            if longest <= 1e-13 * self.size:
                found = frame(self.scene, body, xi1, xi2).gap
                # Newton's method may have left for another valley; the sampled one is then the better witness.
                return Pair(found, xi1, xi2) if abs(found - pair.gap) <= NEAR * self.size else pair
        return pair


def _even(curve: Curve, low: float, high: float, count: int) -> tuple[np.ndarray, float]:
    """Parameters at nearly even distances along a curve, and its length."""
    grid = np.linspace(low, high, 2049)
    speed = np.asarray(curve.speed(grid)) * np.ones_like(grid)
    length = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(grid))])
    return np.interp(np.linspace(0.0, length[-1], count), length, grid), float(length[-1])


class _Course:
    """A flight as it is integrated, step by step, and looked at."""

    def __init__(
        self, scene: Scene, around: Surroundings, t: float, body, end: float, rtol: float, looks: int, work: Work
    ):
        self.scene, self.around = scene, around
        self.rtol = max(rtol, 1e-13)
        # Without a load a flight is a parabola, which no step is too long for.
        pace = scene.free_pace if scene.load else lambda t, body: 0.0
        self.solver = Paced(
            self.rates, t, np.array(body), end, pace=pace, looks=looks, work=work, features=scene.in_time,
            load_allows=scene.load_scales.allows if scene.load_scales else None, rtol=self.rtol, atol=1e-2 * self.rtol,
        )  # fmt: skip
        self.pieces: list[tuple[float, float, Callable]] = []
        self.nodes = [(t, np.array(body))]

    def rates(self, t: float, body) -> np.ndarray:
        ax, ay, spin = self.scene.pull(t, body)
        return np.array([body[3], body[4], body[5], ax, ay, spin * self.scene.m / self.scene.J])

    def until(self, t: float) -> None:
        """Integrate at least up to t."""
        solver = self.solver
        while solver.t < t:
            problem = solver.step()
            if solver.status == "failed" and solver.work.used_up:
                raise UsedUp
            if solver.status == "failed":
                raise Lost(f"the second formulation's flight stopped at t = {solver.t:.9g} s: {problem}")
            self.pieces.append((solver.t_old, solver.t, solver.dense_output()))
            self.nodes.append((solver.t, solver.y.copy()))

    def __call__(self, t: float) -> list[float]:
        self.until(t)
        if t == self.nodes[0][0]:
            return self.nodes[0][1].tolist()
        piece = next(piece for piece in reversed(self.pieces) if piece[0] < t or piece is self.pieces[0])
        return piece[2](t).tolist()

    def exactly(self, t: float) -> list[float]:
        """The state by an integration that ends there: dense output is one order less accurate than a step."""
        start, body = next(node for node in reversed(self.nodes) if node[0] <= t)
        if t == start:
            return body.tolist()
        found = solve_ivp(
            self.rates, (start, t), body, method="DOP853", rtol=self.rtol, atol=1e-2 * self.rtol, max_step=t - start
        )
        return found.y[:, -1].tolist()


def fly(
    scene: Scene, around: Surroundings, t: float, body, end: float, rtol: float, looks: int, hop: float, work: Work
) -> Flown:
    """Free flight from a pose until the outline meets the track, at most until `end`.

    `looks`: steps to a turn under a load, at least; `hop`: roughly when a flight that begins on the track comes down
    again, s (inf: nothing known). A start overlapping its track by rounding is taken as touching it.
    """
    course = _Course(scene, around, t, body, end, rtol, looks, work)
    before, near = t, around.closest(body)
    # A flight that begins on the track is first looked at well before its hop is over, then at growing intervals.
    touching = near.gap <= TOUCH * around.size
    try:
        while before < end and not work.used_up:
            work.done += 1
            stride = _stride(scene, around, before, course(before), near.gap)
            if touching:
                growing = 0.4 * hop if before == t else 0.4 * (before - t)
                stride = min(stride, growing if isfinite(growing) else 1e-3 * sqrt(around.size) / _rush(scene, t, body))
            now = min(max(before + stride, float(np.nextafter(before, end))), end)
            body_now = course(now)
            found = around.closest(body_now)
            low, high = _bracket(scene, course, before, near, now, found)
            if low is not None:
                return _landed(course, low, high)
            before, near = now, found
    except UsedUp:
        pass
    return Flown(_until(course.pieces, before), before, None)


def _until(pieces: list[tuple[float, float, Callable]], end: float) -> list[tuple[float, float, Callable]]:
    return [(start, min(stop, end), course) for start, stop, course in pieces if start < end]


def _rush(scene: Scene, t: float, body) -> float:
    """Square root of the acceleration, m^½/s: with a length it makes the time of a fall."""
    ax, ay, spin = scene.pull(t, body)
    return max(sqrt(hypot(ax, ay)), 1e-6)


def _stride(scene: Scene, around: Surroundings, t: float, body, gap: float) -> float:
    """How long to the next look: as long as the gap lasts at the plate's speed, at least a small part of its size."""
    ax, ay, spin = scene.pull(t, body)
    speed = hypot(body[3], body[4]) + abs(body[5]) * around.reach
    pull = hypot(ax, ay) + abs(spin) * scene.m / scene.J * around.reach
    # A load may change on the way, so only half of the gap is used up.
    way = max(0.5 * gap, STRIDE * around.size) if isfinite(gap) else around.size
    root = sqrt(speed**2 + 2 * pull * way)
    return 2 * way / (speed + root) if root > 0.0 else inf


def _bracket(scene, course: _Course, low: float, near: Pair, high: float, found: Pair):
    """Two times between which the gap vanishes, or (None, None): by its sign, or by a dip between two looks."""
    if not (isfinite(near.gap) and isfinite(found.gap)):
        return None, None  # past the end of an open track, and not through it
    if found.gap <= 0.0:
        return (low, high) if near.gap > 0.0 or low == course.nodes[0][0] else (None, None)
    if near.gap <= TOUCH * course.around.size:
        return None, None  # just leaving
    sinking = frame(scene, course(low), near.xi1, near.xi2).lift
    rising = frame(scene, course(high), found.xi1, found.xi2).lift
    # Between the looks the gap can fall no deeper than the two tangents' crossing, were they straight.
    if not (sinking < 0.0 < rising) or min(near.gap, found.gap) > (high - low) * max(-sinking, rising):
        return None, None

    def gap(t: float) -> float:
        return course.around.closest(course(t)).gap

    lowest = minimize_scalar(gap, bounds=(low, high), method="bounded", options={"xatol": 1e-6 * (high - low)})
    return (low, float(lowest.x)) if lowest.fun <= 0.0 else (None, None)


def _landed(course: _Course, low: float, high: float) -> Flown:
    """The landing between two looks: bisected on the smallest gap of all, then by Newton's method on all unknowns."""
    around = course.around

    def gap(t: float) -> float:
        return around.closest(course(t)).gap

    # The start of a flight touches; the gap opens, and its first sign is looked for by halves.
    while gap(low) <= 0.0:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gap(middle) > 0.0 else (low, middle)
        if high - low <= 1e-15 * max(1.0, abs(high)):
            break
    time = brentq(gap, low, high, xtol=1e-9 * (high - low)) if gap(low) > 0.0 else high
    pair = around.closest(course(time))
    landing = _polished(course, time, pair, 0.5 * (high - low))
    return Flown(_until(course.pieces, landing.time), landing.time, landing)


def _polished(course: _Course, time: float, pair: Pair, furthest: float) -> Touch:
    """Newton's method for time and both contact parameters together: the points coincide, the tangents are parallel."""
    scene, size, xi1, xi2 = course.scene, course.around.size, pair.xi1, pair.xi2
    first, smallest = time, inf
    best = Touch(time, course.exactly(time), xi1, xi2)
    for _ in range(8):
        body = course.exactly(time)
        f = frame(scene, body, xi1, xi2)
        miss = hypot(f.along, f.gap, size * f.angle)
        if miss >= smallest:
            break  # no better than before: rounding
        best, smallest = Touch(time, body, xi1, xi2), miss
        matrix = [
            [f.slip, f.bend_track * f.gap - 1.0, cos(f.angle)],
            [f.lift, -f.bend_track * f.along, sin(f.angle)],
            [body[5], -f.bend_track, f.bend_outline],
        ]
        try:
            step = np.linalg.solve(matrix, [-f.along, -f.gap, -f.angle])
        except np.linalg.LinAlgError:
            break  # a grazing touch: the bisected instant is as good as it gets
        if abs(time + step[0] - first) > furthest:
            break
        time, xi1, xi2 = time + float(step[0]), xi1 + float(step[1]) / f.P, xi2 + float(step[2]) / f.p
    return best
