"""Steps of the second formulation: limited by the motion's time scale, and never past a feature.

A step that passes a feature of track, outline or load (`cases.formulas.features`) is repeated with half its length, as
often as necessary: slow and simple on purpose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, pi

import numpy as np
from scipy.integrate import DOP853

from cases.formulas.features import Features

from .dips import PhaseDips

# Steps per time scale of the motion: ten times the number at the largest `steps_per_turn` in use. Towards Painlevé's
# singularity steps shrink without limit.
MOST_STEPS = 20_000

# Limit on the work of one motion, whatever its duration: minutes.
MOST_WORK = 400_000

# SciPy's shortest step is ten roundings of the time; one of this many is not divided.
SHORTEST_STEPS = 20

# A step in which a guard falls below zero and rises again is repeated up to there, at most so many times.
MOST_CUTS = 20

# Inside a step the state is sampled by Hermite's cubic, which has its extrema where the motion does.
INSIDE = np.linspace(0.0, 1.0, 9)[1:]

# A step covers at most a quarter of the length that a feature allows: a force may leave its bound and come back within
# one piece (a slip of a sixth of a pulse's width), and the bound of `dips` supposes steps in which that is resolved.
QUARTER = 4.0

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


class WorkLimit(Exception):
    """The motion reached its limit on work."""


Allows = Callable[[np.ndarray, np.ndarray], bool]


class FrequencyLimitedDOP853(DOP853):
    """DOP853 with at least `steps_per_turn` steps per turn of the motion's frequency by 2π.

    `pace` maps (t, y) to that frequency (rad/s, zero if there is none); no step passes one of the `features`, each
    given with its row of the state (None: time); `load_allows` maps times (n,) and states (variables, n) along a step
    to whether the load allows a step of that length; a step ends where one of the `dips` shows a short event;
    `after_step` is called with the interpolant and both ends of each step. Fails when the `work` of the motion reaches
    its limit. Raises StepFailure if steps vanish.
    """

    t: float
    status: str
    y: np.ndarray
    f: np.ndarray
    max_step: float

    def __init__(
        self, fun, t0, y0, t_bound, *, pace: Callable[[float, np.ndarray], float], steps_per_turn: int,
        work: WorkBudget,
        features: Sequence[tuple[int | None, Features]] = (), load_allows: Allows | None = None,
        dips: PhaseDips | None = None, after_step: Callable | None = None, **options,
    ):  # fmt: skip
        self.pace, self.steps_per_turn, self.work, self.load_allows = pace, steps_per_turn, work, load_allows
        self.dips, self.after_step, self.longest = dips, after_step, inf
        self.features = [(row, feature) for row, feature in features if not feature.plain]
        self.steps, self.counted_until = 0, -inf
        super().__init__(fun, t0, y0, t_bound, **options)

    def step(self):
        before = self.t, self.y, self.f
        message = super().step()
        for _ in range(MOST_CUTS):
            dip = None if self.dips is None or self.status == "failed" else self._dip(before[0])
            if dip is None:
                break
            (self.t, self.y, self.f), self.status, self.longest = before, "running", dip - before[0]
            message = super().step()
        self.longest = inf
        if self.after_step is not None and self.status != "failed" and self.t_old is not None and self.t > self.t_old:
            self.after_step(self.dense_output(), self.t_old, self.t)
        return message

    def _dip(self, start: float) -> float | None:
        """The time in the last step, from `start`, of a short event, if there is one."""
        time = self.dips.in_step(self.dense_output, start, self.t, self.y)  # type: ignore[union-attr]
        return None if time is None or time - start <= SHORTEST_STEPS * np.spacing(abs(start)) else time

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
        if self.steps > MOST_STEPS:
            raise StepFailure(
                f"the second formulation needs more than {MOST_STEPS} steps for one turn of the motion at "
                f"t = {self.t:.9g} s: a singularity, or features that are too fine"
            )
        self.max_step = min(turn / self.steps_per_turn, self.longest)
        t, y, f = self.t, self.y, self.f
        while True:
            self.work.count += 1
            success, message = super()._step_impl()
            h = self.t - t
            if not success or h <= SHORTEST_STEPS * np.spacing(abs(t)) or not self._passes(t, y, f, h):
                return success, message
            self.t, self.y, self.f, self.max_step = t, y, f, 0.5 * h

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

    def _way(self, row: int, y, f, h) -> np.ndarray:
        """One component of the state at the parts INSIDE of the step from y."""
        start, end, s = y[row], self.y[row], INSIDE
        out, back = h * f[row] * s * (1 - s) ** 2, h * self.f[row] * s**2 * (1 - s)
        return start + (end - start) * s**2 * (3 - 2 * s) + out - back
