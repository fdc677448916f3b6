"""The step at which an engine blows up: bracketed by doubling, closed in on by bisection, never guessed.

Everything but the step stays as a middle rung of the route's ladder has it, so that stiffness and regularisation do not
move with it.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isnan, nan, sqrt
from typing import NamedTuple

from adapters import EngineFailure, Setting
from cases import Case, Gravity, Load, Trajectory, mechanics

from ...judging import residuals
from ...judging.soundness import sound
from ...running.solvers import solver
from ...running.tasks import sentence, timed

# A scene without load cannot gain energy; a tenth of all that moves is no inaccuracy any more.
BLOWN_UP = 0.1
# Six halvings of a factor of two leave the bracket a per cent wide.
HALVINGS = 6
# The steps looked at, as parts of the duration: with fewer than four there is no motion to speak of, and more than so
# many nobody takes to be stable.
FEW, MANY = 4, 200_000
# Wall seconds for one search.
PATIENCE = 60.0
# The hard scenes on which a default report looks for the step: one where contact is all but conforming, one where the
# disc slips, rolls and slips again, one whose plate is no disc.
LOOKED_AT = ("at_any_size[length=0.001]", "nearly_conforming[gap=0.01]", "degenerate_release[mu=0.3,tilt=0.5]")


class Bracket(NamedTuple):
    """The largest step (s) known to work and the smallest known to blow up, the duration over the latter, and how it
    fails; NaN where there is none."""

    case: str
    solver: str
    route: str
    setting: str
    works: float
    fails: float
    steps_at_failure: float
    how: str

    @classmethod
    def unknown(cls, case: Case, name: str, route: str, why: str) -> Bracket:
        """No bracket, because the search itself failed."""
        return cls(case.label, name, route, "", nan, nan, nan, why)


def bracket(case: Case, name: str, route: str, middle: Setting) -> Bracket:
    """Search the unstable step of a route on a case, all but the step as in a middle rung of its ladder."""
    rest = str(middle.but(h=None, rung=None))
    if "h" not in middle:
        return Bracket(case.label, name, route, rest, nan, nan, nan, "its settings name no step h")
    module = solver(name)

    def failure(h: float) -> str:
        return blow_up(module, case, route, middle.but(h=h))

    found = search(failure, min(float(middle["h"]), case.duration / 8), case.duration / MANY, case.duration / FEW)
    return Bracket(case.label, name, route, rest, found.works, found.fails, case.duration / found.fails, found.how)


class Found(NamedTuple):
    """The largest step known to work, the smallest known to fail (NaN where there is none), and how it fails."""

    works: float
    fails: float
    how: str


def search(failure: Callable[[float], str], h: float, least: float, most: float) -> Found:
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
        return Found(nan, fails, f"at every step tried: {how}")
    if isnan(fails):
        return Found(works, nan, f"no step up to {h:.2g} s blows up")
    for _ in range(HALVINGS):
        h = sqrt(works * fails)
        now = failure(h)
        works, fails, how = (works, h, now) if now else (h, fails, how)
    return Found(works, fails, how)


def blow_up(module, case: Case, route: str, setting: Setting) -> str:
    """How a run blows up, in a few words, or ""."""
    try:
        motion = timed(module, case, route, setting)
    except EngineFailure as problem:
        return str(problem)
    except Exception as problem:
        return sentence(problem)
    if not sound(motion):
        return "numbers that are not finite"
    growth = energy_growth(case, motion)
    return f"the energy grows by {growth:.2g} of what moves" if growth > BLOWN_UP else ""


def energy_growth(case: Case, motion: Trajectory) -> float:
    """The most the energy rises above its least so far, over the start's kinetic energy and what lifts the plate by its
    own size; 0 under a load, which may do any work."""
    if case.effect(Load) is not None:
        return 0.0
    gravity = case.effect(Gravity)
    scale = float(mechanics.kinetic_energy(case, motion)[0])
    scale += case.plate.mass * (gravity.g if gravity else 0.0) * case.plate.reach
    return residuals.energy_growth(case, motion) / scale if scale > 0.0 else 0.0
