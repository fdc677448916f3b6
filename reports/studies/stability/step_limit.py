"""The step at which an engine becomes unstable: bracketed by doubling or halving, then refined by bisection.

All other parameters are those of a middle rung of the route's ladder, so that stiffness and regularisation do not
change with the step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isnan, nan, sqrt
from typing import NamedTuple

from adapters import Setting
from cases import Belt, Case, Gravity, Load, Trajectory
from cases.motion import mechanics

from ...judging import residuals
from ...running.records import Run
from ...running.tasks import attempt

# A scene without load cannot gain energy; a gain of a tenth of its energy scale is instability, not inaccuracy.
BLOWN_UP = 0.1
# Six bisections reduce a factor of two to a bracket about 1 % wide.
HALVINGS = 6
# Range of the search, in steps per duration: fewer than FEW do not represent a motion, and an engine that needs more
# than MANY to be stable is of no practical use.
FEW, MANY = 4, 200_000
# Wall-clock limit of one search, in seconds.
PATIENCE = 60.0
# The hard scenes for which a default report searches the step: one with nearly conforming contact, one in which the
# disc slips, rolls and slips again, one whose plate is not a disc.
DEFAULT_CASES = ("at_any_size[length=0.001]", "nearly_conforming[gap=0.01]", "degenerate_release[mu=0.3,tilt=0.5]")


class Bracket(NamedTuple):
    """The largest step (s) that works and the smallest that is unstable, the duration over the latter, and how it
    fails; NaN if there is none."""

    case: str
    solver: str
    route: str
    setting: str
    works: float
    fails: float
    steps_at_failure: float
    how: str

    @classmethod
    def failure(cls, case: Case, name: str, route: str, why: str) -> Bracket:
        """No bracket, because the search itself failed."""
        return cls(case.label, name, route, "", nan, nan, nan, why)


def bracket(case: Case, name: str, route: str, middle: Setting) -> Bracket:
    """Search the unstable step of a route on a case, with all other parameters from the `middle` rung of its ladder."""
    rest = str(middle.but(h=None, rung=None))
    if "h" not in middle:
        return Bracket(case.label, name, route, rest, nan, nan, nan, "its settings have no step h")

    def failure(h: float) -> str:
        return blow_up(case, name, route, middle.but(h=h))

    limit = search(failure, min(float(middle["h"]), case.duration / 8), case.duration / MANY, case.duration / FEW)
    return Bracket(case.label, name, route, rest, limit.works, limit.fails, case.duration / limit.fails, limit.how)


class StepLimit(NamedTuple):
    """The largest step that works, the smallest that fails (NaN if there is none), and how it fails."""

    works: float
    fails: float
    how: str


def search(failure: Callable[[float], str], h: float, least: float, most: float) -> StepLimit:
    """Double or halve from `h` until one step works and another fails, within [least, most]; then bisect."""
    how = failure(h)
    works, fails = (nan, h) if how else (h, nan)
    while isnan(works) and h / 2 >= least:
        h /= 2
        now = failure(h)
        works, fails, how = (nan, h, now) if now else (h, fails, how)
    while isnan(fails) and 2 * h <= most:
        h *= 2
        how = failure(h)
        works, fails = (works, h) if how else (h, nan)
    if isnan(works):
        return StepLimit(nan, fails, f"at every step tried: {how}")
    if isnan(fails):
        return StepLimit(works, nan, f"no step up to {h:.2g} s is unstable")
    for _ in range(HALVINGS):
        h = sqrt(works * fails)
        now = failure(h)
        works, fails, how = (works, h, now) if now else (h, fails, how)
    return StepLimit(works, fails, how)


def blow_up(case: Case, name: str, route: str, setting: Setting) -> str:
    """How a run becomes unstable, in a few words; "" if it does not."""

    def gain(row: Run, motion: Trajectory) -> Run:
        growth = energy_growth(case, motion)
        words = f"the energy grows by {growth:.2g} of its scale" if growth > BLOWN_UP else ""
        return replace(row, outcome="answered", reason=words)

    return attempt(Run(case.label, name, route, setting, 0, outcome=""), case, gain).reason


def energy_growth(case: Case, motion: Trajectory) -> float:
    """The largest rise of the energy above its minimum so far, divided by an energy scale; 0 under a load or on a belt,
    which may do any work. The scale is the start's kinetic energy plus the energy that lifts the plate by its own
    size."""
    if case.effect(Load) is not None or case.effect(Belt) is not None:
        return 0.0
    gravity = case.effect(Gravity)
    scale = float(mechanics.kinetic_energy(case, motion)[0])
    scale += case.plate.mass * (gravity.g if gravity else 0.0) * case.plate.reach
    return residuals.energy_growth(case, motion) / scale if scale > 0.0 else 0.0
