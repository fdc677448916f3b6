"""Steps of the second formulation: as long as its motion's own time allows, however long the motion lasts."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, pi

import numpy as np
from scipy.integrate import DOP853

# Steps within one of the motion's own times: ten times what the closest look takes. Towards Painlevé's singularity
# steps shrink without end.
MOST_STEPS = 20_000

# A motion that turns more often than this before its end would take years to follow.
MOST_TURNS = 1e9


class Lost(FloatingPointError):
    """The second formulation cannot go on; one sentence says where and why."""


class Paced(DOP853):
    """DOP853 whose steps are at most a part of a turn: `looks` of them while the motion's frequency turns by 2π.

    `pace` maps (t, y) to that frequency (rad/s, zero where nothing sets one). Raises Lost where steps
    come to nothing.
    """

    def __init__(self, fun, t0, y0, t_bound, *, pace: Callable[[float, np.ndarray], float], looks: int, **options):
        self.pace, self.looks = pace, looks
        self.steps, self.counted_until = 0, -inf
        super().__init__(fun, t0, y0, t_bound, **options)

    def _step_impl(self):
        frequency = self.pace(self.t, self.y)
        turn = 2 * pi / frequency if frequency > 0.0 else inf
        if self.t >= self.counted_until:
            self.steps, self.counted_until = 0, self.t + turn
        if turn * MOST_TURNS < self.t_bound - self.t:
            raise Lost(
                f"the motion at t = {self.t:.9g} s turns once in {turn:.3g} s, too often to be followed to its end at "
                f"{self.t_bound:.3g} s; give a shorter duration"
            )
        self.steps += 1
        if self.steps > MOST_STEPS:
            raise Lost(f"the second formulation hardly moves on at t = {self.t:.9g} s")
        self.max_step = turn / self.looks
        return super()._step_impl()
