"""Steps of DOP853 that resolve friction by a formula of the slip speed (`contact_frame.loads` has the bound)."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.integrate import DOP853
from scipy.interpolate import CubicHermiteSpline

from cases import Case, CoulombFriction

from ..contact_frame.loads import FormulaScales, slip_scales
from .phase import SIGN, SeveralContactPhase

# Parts of a step at which the slip speeds are looked at: steps are so short that these are nearly straight between.
PLACES = np.linspace(0.0, 1.0, 3)
# A step is not made shorter than this many spacings of its time.
SHORTEST = 100.0

Allows = Callable[[np.ndarray, np.ndarray], bool]


@lru_cache(maxsize=256)
def _scales(pair: Case) -> FormulaScales | None:
    return slip_scales(pair.effect(CoulombFriction))


def slips_allow(phase: SeveralContactPhase) -> Allows | None:
    """Whether the laws of friction of a phase's slipping contacts allow a step, as a function of times (n,) and states
    (variables, n) along it; None if they always do."""
    limits = [(k, scales, SIGN[c.mode]) for k, c in enumerate(phase.contacts)
              if c.mode in SIGN and (scales := _scales(c.case)) is not None]  # fmt: skip
    if not limits:
        return None

    def allows(times: np.ndarray, states: np.ndarray) -> bool:
        every = [phase.closed_pairs(t, state) for t, state in zip(times.tolist(), states.T, strict=True)]
        speeds = [np.array([sign * now[k].slip for now in every]) for k, _, sign in limits]  # type: ignore[union-attr]
        return all(scales.allows(speed) for (_, scales, _), speed in zip(limits, speeds, strict=True))

    return allows


class ResolvingDOP853(DOP853):
    """DOP853 whose steps are halved until `allows`, a function of times and states along a step, admits them."""

    t: float
    y: np.ndarray
    f: np.ndarray
    max_step: float

    def __init__(self, *arguments, allows: Allows | None = None, **options):
        super().__init__(*arguments, **options)
        self.allows, self.longest = allows, self.max_step

    def _step_impl(self):
        t, y, f, self.max_step = self.t, self.y, self.f, self.longest
        while True:
            success, message = super()._step_impl()
            length = self.t - t
            if not success or self.allows is None or length <= SHORTEST * np.spacing(abs(t)):
                return success, message
            times = t + length * PLACES
            states = CubicHermiteSpline([t, self.t], [y, self.y], [f, self.f])(times).T
            if self.allows(times, states):
                return success, message
            self.t, self.y, self.f, self.max_step = t, y, f, 0.5 * length
