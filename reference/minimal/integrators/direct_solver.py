"""SciPy's DOP853 without the functions that it puts around the rates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.integrate import DOP853


class DirectDOP853(DOP853):
    """DOP853 whose rates (t, state) -> list of floats are called without SciPy's two functions around them, which check
    and convert: they take half a microsecond of each evaluation, a fortieth of a disc's motion on a line."""

    def __init__(self, rates: Callable[[float, np.ndarray], Sequence[float]], t, y, end: float, **options: Any):
        super().__init__(rates, t, y, end, **options)

        def counted(time, state):
            self.nfev += 1
            return np.array(rates(time, state), dtype=float)

        self.fun = counted
