"""Steps of the second formulation that pass no feature of track, outline or load (`cases.features`).

A step that does is taken again with half its length, as often as it takes: slow and simple on purpose.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.integrate import DOP853

from cases.features import Features

# Between its ends a step's course is looked at by Hermite's cubic, which turns round where the motion does.
INSIDE = np.linspace(0.0, 1.0, 9)[1:]


class Watchful(DOP853):
    """SciPy's DOP853 with steps that stop at features: pairs of a row of the state (None: time) and what it meets."""

    t: float
    y: np.ndarray
    f: np.ndarray
    max_step: float

    def __init__(self, *arguments, features: Sequence[tuple[int | None, Features]] = (), **options):
        super().__init__(*arguments, **options)
        self.features = [(row, found) for row, found in features if not found.plain]

    def _step_impl(self):
        t, y, f, longest = self.t, self.y, self.f, self.max_step
        while True:
            success, message = super()._step_impl()
            h = self.t - t
            # A step as short as ten roundings of the time is SciPy's shortest.
            if not success or h <= 20 * np.spacing(abs(t)) or not self._passes(t, y, f, h):
                self.max_step = longest
                return success, message
            self.t, self.y, self.f, self.max_step = t, y, f, 0.5 * h

    def _passes(self, t, y, f, h) -> bool:
        """Whether the step from there goes farther than a feature allows."""
        for row, features in self.features:
            if row is None:
                start, way = t, np.array([t + h])
            else:
                start, end, s = y[row], self.y[row], INSIDE
                out, back = h * f[row] * s * (1 - s) ** 2, h * self.f[row] * s**2 * (1 - s)
                way = start + (end - start) * s**2 * (3 - 2 * s) + out - back
            if features.clear(start, way.min()) > way.min() or features.clear(start, way.max()) < way.max():
                return True
        return False
