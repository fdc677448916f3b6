"""Steps of the second formulation: limited by the motion's time scale, and never past a feature.

A step that passes a feature of track, outline or load (`cases.formulas.features`) is repeated with half its length, as
often as necessary: slow and simple on purpose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, pi

import numpy as np
from scipy.integrate import DOP853

from cases import Curve
from cases.formulas.features import Features

# Steps per time scale of the motion: a hundred times as many as usual. Towards Painlevé's singularity steps shrink
# without limit.
MOST_STEPS = 3_000

# Limit on the work of one motion, whatever its duration: minutes.
MOST_WORK = 400_000

# SciPy's shortest step is ten roundings of the time; one of this many is not divided.
SHORTEST_STEPS = 20

# Inside a step the state is sampled by Hermite's cubic, which has its extrema where the motion does.
INSIDE = np.linspace(0.0, 1.0, 9)[1:]

# A step ends at a knot, where the curve's third derivative may jump: an error that the method does not see. Knots in a
# thousandth of it at both ends are left there; between them it is sampled at twice as many places.
BETWEEN_KNOTS = np.linspace(1e-3, 1.0 - 1e-3, 2000)

# A step covers at most a quarter of the length that a feature allows: a force may leave its bound and come back within
# one piece (a slip of a sixth of a pulse's width), and the bound of `dips` supposes steps in which that is resolved.
QUARTER = 4.0

# After a step that was repeated, steps grow by this factor again.
GROWTH = 1.25

# A motion that turns more often than this before its end would take years to follow.
MOST_TURNS = 1e9


class WorkBudget:
    """The number of steps, hops and landing searches of a motion so far."""

    def __init__(self) -> None:
        self.count = 0

    @property
    def used_up(self) -> bool:
        """Whether the limit is reached."""
        return self.count >= MOST_WORK


class StepFailure(FloatingPointError):
    """The second formulation cannot continue; the message says where and why."""


Allows = Callable[[np.ndarray, np.ndarray], bool]


class FrequencyLimitedDOP853(DOP853):
    """DOP853 with at least `steps_per_turn` steps per turn of the motion's frequency by 2π.

    `pace` maps (t, y) to that frequency (rad/s, zero if there is none); no step passes one of the `features`, each
    given with its row of the state (None: time), and none a knot of the `curves`; `load_allows` maps times (n,) and
    states (variables, n) along a step to whether the load allows a step of that length. Fails when the `work` of the
    motion reaches its limit. Raises StepFailure if steps vanish.
    """

    t: float
    status: str
    y: np.ndarray
    f: np.ndarray
    max_step: float

    def __init__(
        self, fun, t0, y0, t_bound, *, pace: Callable[[float, np.ndarray], float], steps_per_turn: int,
        work: WorkBudget,
        features: Sequence[tuple[int | None, Features]] = (), curves: Sequence[tuple[int, Curve]] = (),
        load_allows: Allows | None = None,
        **options,
    ):  # fmt: skip
        self.pace, self.steps_per_turn, self.work, self.load_allows = pace, steps_per_turn, work, load_allows
        self.features = [(row, feature) for row, feature in features if not feature.plain]
        self.curves = [(row, curve) for row, curve in curves if curve.knots]
        self.steps, self.counted_until, self.longest = 0, -inf, inf
        super().__init__(fun, t0, y0, t_bound, **options)

    def _step_impl(self):
        if self.work.used_up:
            return False, "the motion's work is used up"
        frequency = self.pace(self.t, self.y)
        turn = 2 * pi / frequency if frequency > 0.0 else inf
        if self.t >= self.counted_until:
            self.steps, self.counted_until = 0, self.t + turn
        if turn * MOST_TURNS < self.t_bound - self.t:
            raise StepFailure(
                f"the motion at t = {self.t:.9g} s turns once in {turn:.3g} s, too often to be followed to its end at "
                f"{self.t_bound:.3g} s; give a shorter duration"
            )
        self.steps += 1
        if self.steps > MOST_STEPS and frequency:
            raise StepFailure(
                f"the second formulation needs more than {MOST_STEPS} steps for one turn of the motion at "
                f"t = {self.t:.9g} s: a singularity, or features that are too fine"
            )
        self.max_step = min(turn / self.steps_per_turn, self.longest)
        self.longest = inf if self.longest > turn else GROWTH * self.longest
        t, y, f = self.t, self.y, self.f
        while True:
            self.work.count += 1
            success, message = super()._step_impl()
            h = self.t - t
            if not success or h <= SHORTEST_STEPS * np.spacing(abs(t)):
                return success, message
            if self._passes(t, y, f, h):
                part, self.longest = 0.5, 0.5 * h
            elif (part := self._to_knot(y, f, h)) == 1.0 or part * h <= SHORTEST_STEPS * np.spacing(abs(t)):
                return success, message
            self.t, self.y, self.f, self.max_step = t, y, f, part * h

    def exactly(self, t: float) -> np.ndarray:
        """The state at a time of the last step, by a step that ends there: dense output is one order less accurate."""
        h, slopes = t - self.t_old, [self.fun(self.t_old, self.y_old)]
        for row, part in zip(self.A[1:], self.C[1:], strict=True):
            slopes.append(self.fun(self.t_old + part * h, self.y_old + h * (row[: len(slopes)] @ slopes)))
        return self.y_old + h * (self.B @ slopes)

    def _passes(self, t, y, f, h) -> bool:
        """Whether the step from (t, y) is longer than a feature or the load allows."""
        if self.load_allows is not None:
            every = np.array([self._way(row, y, f, h) for row in range(len(y))])
            if not self.load_allows(np.append(t, t + h * INSIDE), np.column_stack([y, every])):
                return True
        for row, features in self.features:
            if row is None:
                start, way = t, np.array([t + h])
            else:
                start, way = y[row], self._way(row, y, f, h)
            lowest, highest = (start + QUARTER * (extreme - start) for extreme in (way.min(), way.max()))
            if features.clear(start, lowest) > lowest or features.clear(start, highest) < highest:
                return True
        return False

    def _to_knot(self, y, f, h) -> float:
        """The part of the step from y that ends at the first knot of a curve; 1 if it passes none."""
        first = 1.0
        for row, curve in self.curves:
            (low, _), period = curve.span, curve.period or inf
            pieces = np.searchsorted(curve.knots, (self._way(row, y, f, h, BETWEEN_KNOTS) - low) % period + low)
            passed = np.flatnonzero(np.diff(pieces))
            if passed.size:
                first = min(first, float(BETWEEN_KNOTS[passed[0] + 1]))
        return first

    def _way(self, row: int, y, f, h, s=INSIDE) -> np.ndarray:
        """One component of the state at some parts of the step from y."""
        start, end = y[row], self.y[row]
        out, back = h * f[row] * s * (1 - s) ** 2, h * self.f[row] * s**2 * (1 - s)
        return start + (end - start) * s**2 * (3 - 2 * s) + out - back
