"""The step at which an engine blows up: bracketed by doubling, closed in on by bisection, never guessed.

Everything but the step stays as a middle rung of the route's ladder has it, so that stiffness and regularisation do not
move with it.
"""

from __future__ import annotations

from math import nan, sqrt
from typing import NamedTuple

import numpy as np

from adapters import EngineFailure, Setting
from cases import Case, Load, Trajectory

from . import health, metrics, trial
from .records import CaseKey, is_default_setting

# A scene without load cannot gain energy; a tenth of all that moves is no inaccuracy any more.
BLOWN_UP = 0.1
# Six halvings of a factor of two leave the bracket a per cent wide.
HALVINGS = 6
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
    def unknown(cls, key: CaseKey, name: str, route: str, why: str) -> Bracket:
        """No bracket, because the search itself failed."""
        return cls(trial.load(key).label, name, route, "", nan, nan, nan, why)


def bracket(key: CaseKey, name: str, route: str) -> Bracket:
    """Search the unstable step of a route on a case."""
    case, module = trial.load(key), trial.solver(name)
    ladder = [s for s in module.ladder(case, route) if not is_default_setting(s)]
    middle = ladder[len(ladder) // 2]
    rest = " ".join(part for part in str(middle).split() if not part.startswith(("h=", "rung=")))
    if "h" not in dict(middle.values):
        return Bracket(case.label, name, route, rest, nan, nan, nan, "its settings name no step h")

    def failure(h: float) -> str:
        return blow_up(module, case, route, _with_step(middle, h))

    # A step needs room for at least four of it; the coarsest one is a quarter of the duration.
    works, fails = nan, nan
    h, how = min(float(middle["h"]), case.duration / 8), ""
    most = case.duration / 4
    how = failure(h)
    while how and h > 1e-6 * case.duration:
        fails, h = h, h / 2
        how, last = failure(h), how
    if how:
        return Bracket(case.label, name, route, rest, nan, h, case.duration / h, f"blows up at every step tried: {how}")
    works = h
    last = "" if np.isnan(fails) else last
    while np.isnan(fails) and 2 * h <= most:
        h *= 2
        last = failure(h)
        works, fails = (works, h) if last else (h, nan)
    if np.isnan(fails):
        return Bracket(case.label, name, route, rest, works, nan, nan, "no step up to a quarter of the duration blows up")
    for _ in range(HALVINGS):
        h = sqrt(works * fails)
        how = failure(h)
        works, fails, last = (works, h, how) if how else (h, fails, last)
    return Bracket(case.label, name, route, rest, works, fails, case.duration / fails, last)


def _with_step(setting: Setting, h: float) -> Setting:
    return Setting(tuple((name, h if name == "h" else value) for name, value in setting.values))


def blow_up(module, case: Case, route: str, setting: Setting) -> str:
    """How a run blows up, in a few words, or ""."""
    try:
        motion = trial.timed(module, case, route, setting)
    except EngineFailure as problem:
        return str(problem)
    except Exception as problem:
        return trial._sentence(problem)
    if not trial._sound(motion):
        return "numbers that are not finite"
    growth = energy_growth(case, motion)
    return f"the energy grows by {growth:.2g} of what moves" if growth > BLOWN_UP else ""


def energy_growth(case: Case, motion: Trajectory) -> float:
    """The most the energy rises above its least so far, over the energy a fall through the truth's whole motion frees."""
    if case.effect(Load) is not None:
        return 0.0
    total = metrics.energy(case, motion)
    kinetic = 0.5 * case.plate.mass * (motion.vx**2 + motion.vy**2) + 0.5 * case.plate.inertia * motion.omega**2
    # The scale is the energy at the start that can move: what the run itself makes of it must not hide its own growth.
    scale = float(kinetic[0]) + case.plate.mass * 9.81 * 1e-3 * health.size(case)
    potential = total - kinetic
    scale = max(scale, float(potential[0] - potential.min()))
    return float((total - np.minimum.accumulate(total)).max()) / scale
