"""One scene, its effects added one at a time: what each solver makes of each stage, and what it costs.

Every solver runs each stage it can; a stage that it refuses is a row that says why. Results come first, in workers;
then all stages of all solvers take turns at the clock, in one process, with nothing beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from math import hypot, nan
from typing import Any, NamedTuple

import numpy as np

from adapters import Setting
from cases import (
    Case,
    CoulombFriction,
    Curve,
    Effect,
    Flight,
    Gravity,
    Impact,
    Load,
    NotSupported,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases import curves as c
from cases.library import circle

from ...running.calls import Calls, Keep
from ...running.clock import UNTIMED, Contestant, Timing
from ...running.experiment import offers
from ...running.records import REFERENCE
from ...running.solvers import solver
from ...running.tasks import timed
from ...running.timings import time_together

# Wall seconds for the timings of a scene: the stages of the reference take milliseconds, of an engine up to a second.
BUDGET, FULL_BUDGET = 5.0, 60.0
# A stage that takes longer than this has lost its way; the slowest engine needs two seconds.
LIMIT = 30.0
# The reference at a tolerance that engines do not reach, engines in the middle of their ladders: one price for each.
_RTOL = Setting.of(rtol=1e-9)


class Stage(NamedTuple):
    """A scene with one effect more than the stage before: the effect's name, and the case."""

    added: str
    case: Case


class Probe(NamedTuple):
    """What a solver made of a stage: outcome and reason, setting, where it ended, its path, what it took."""

    outcome: str
    reason: str = ""
    setting: Setting = Setting.of()
    end: tuple[float, float, float] = (nan, nan, nan)  # t, x, y
    path: tuple[np.ndarray, ...] = ()  # t, x, y
    status: str = ""
    transitions: int = 0
    evaluations: int = 0
    seconds: float = nan


@lru_cache
def stages(scene: str) -> tuple[Stage, ...]:
    """The stages of a scene of `SCENES`, from gravity alone to all its effects."""
    make, effects = SCENES[scene]
    cases = [replace(make(_merged(effects[: i + 1])), name=f"{scene}, stage {i}") for i in range(len(effects))]
    return tuple(Stage(_name(e, effects[:i]), case) for i, (e, case) in enumerate(zip(effects, cases, strict=True)))


def _name(effect: Effect, before: Sequence[Effect]) -> str:
    again = any(type(effect) is type(e) for e in before)
    return "static friction" if again else type(effect).__name__


def _merged(effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """The effects, a later one of a kind in the place of an earlier."""
    return tuple({type(effect): effect for effect in effects}.values())


def _in_circle(effects: tuple[Effect, ...]) -> Case:
    return Case(circle(1.0), disc(0.1, 1.0), effects, Start(xi1=-0.1), 2.5)


def _over_crest(effects: tuple[Effect, ...]) -> Case:
    track = Curve(lambda s: (s, c.exp(-4.0 * s**2)), domain=(-8, 12))
    return Case(track, disc(0.05, 1.0), effects, Start(xi1=0.0, slip=1.4), 1.0)


# Each scene: how it is made of effects, and the effects in the order in which they are added.
SCENES: dict[str, tuple[Callable[[tuple[Effect, ...]], Case], tuple[Effect, ...]]] = {
    "in_circle": (
        _in_circle,
        (
            Gravity(9.81),
            Unilateral(),
            CoulombFriction(0.15),
            CoulombFriction(0.15, 0.2),
            RollingResistance(0.002),
            Load(fx="-0.1*vx", fy="-0.1*vy"),
        ),
    ),
    "over_crest": (
        _over_crest,
        (Gravity(9.81), Unilateral(), Flight(), Impact(0.3), CoulombFriction(0.2), RollingResistance(0.002)),
    ),
}


# --- results ----------------------------------------------------------------------------------------------------------


def probe(case: Case, name: str, route: str, setting: Setting) -> Probe:
    """Run one stage by one route of a solver."""
    try:
        motion = timed(solver(name), case, route, setting)
    except NotSupported as refusal:
        return Probe("refused", str(refusal), setting)
    path = np.linspace(motion.t[0], motion.t[-1], 201)
    state = motion(path)
    x, y = np.asarray(state.x), np.asarray(state.y)
    if not np.all(np.isfinite([x, y])):
        return Probe("wrong", "its motion is not finite", setting)
    return Probe(
        "done", "", setting, (float(motion.t[-1]), float(motion.x[-1]), float(motion.y[-1])),
        (path, x, y), motion.status, len(motion.transitions), motion.cost.evaluations,
        motion.cost.wall_s + motion.cost.setup_s,
    )  # fmt: skip


def _middle(ladder: Sequence[Setting]) -> Setting:
    return _RTOL if _RTOL in ladder else ladder[len(ladder) // 2]


@lru_cache
def compiled(case: Case) -> tuple[int, int]:
    """Operations of the largest of the case's compiled modes of contact (rates and events, after common
    subexpressions), and how many events are watched in the mode that watches most."""
    import sympy as sp

    from reference.minimal.modes import candidates, phase

    systems = [phase(case, regime).system for regime in candidates(case)]

    def operations(system) -> int:
        shared, rest = sp.cse([*system.rates, *system.guards.values()])
        return int(sp.count_ops([e for _, e in shared]) + sp.count_ops(rest))

    return max(map(operations, systems)), max(len(system.guards) for system in systems)


# --- prices -----------------------------------------------------------------------------------------------------------

Who = tuple[int, str, str]  # stage, solver, route


def measure(solvers: Sequence[str], budget: float, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all scenes: one for each stage and route, timed within `budget` wall seconds a scene."""
    with calls.alone() as alone:
        return [row for scene in SCENES for row in _priced(scene, solvers, budget, calls, alone)]


def _priced(scene: str, solvers: Sequence[str], budget: float, calls: Calls, alone: Calls) -> Iterator[dict[str, Any]]:
    """The rows of a scene; timed in the worker that is `alone`, which has imported everything at the second one."""
    probes = dict(_probes(scene, solvers, calls))
    cases = [stage.case for stage in stages(scene)]
    able = {who: p for who, p in probes.items() if p.outcome == "done"}
    contestants = [Contestant(cases[i], name, route, p.setting, p.seconds) for (i, name, route), p in able.items()]
    pairs, _ = time_together(contestants, budget, budget, alone) if able else ([], [])
    timings = {(cases.index(one.case), one.solver, one.route): timing for one, timing in pairs}
    routes = list(dict.fromkeys(who[1:] for who in probes))
    for who in sorted(probes, key=lambda who: (solvers.index(who[1]), routes.index(who[1:]), who[0])):
        yield _row(scene, who, probes, timings)


def _probes(scene: str, solvers: Sequence[str], calls: Calls) -> Iterator[tuple[Who, Probe]]:
    """What every route made of every stage."""
    cases = [stage.case for stage in stages(scene)]
    labels = [case.label for case in cases]
    todo: list[tuple[Who, tuple]] = []
    for (label, name), of_routes in offers(cases, solvers, calls).items():
        for offer in of_routes:
            who = (labels.index(label), name, offer.route)
            if offer.outcome or not offer.settings:
                yield who, Probe(offer.outcome or "refused", offer.reason or "it offers no setting for this case")
            else:
                todo.append((who, (cases[who[0]], name, offer.route, _middle(offer.settings))))
    answers = calls.all(f"effects {scene}", probe, [call for _, call in todo], limit=LIMIT, keep=Keep())
    for (who, call), answer in zip(todo, answers, strict=True):
        yield who, answer.value if answer.outcome == "done" else Probe(*answer.failure, call[3])


def _row(scene: str, who: Who, probes: dict[Who, Probe], timings: dict[Who, Timing]) -> dict[str, Any]:
    stage, name, route = who
    here, case = probes[who], stages(scene)[stage].case
    before = probes.get((stage - 1, name, route))
    timing, first = timings.get(who, UNTIMED), timings.get((0, name, route), UNTIMED)
    operations, events = compiled(case) if name == REFERENCE else (nan, nan)
    return {
        "scene": scene,
        "effect": stages(scene)[stage].added,
        "effects": " + ".join(type(e).__name__ for e in case.effects),
        "solver": name,
        "route": route,
        "setting": here.setting,
        "outcome": here.outcome,
        "reason": here.reason,
        "cpu_s": timing.cpu_s,
        "cpu_low_s": timing.cpu_low_s,
        "cpu_high_s": timing.cpu_high_s,
        "cpu_to_first": timing.cpu_s / first.cpu_s,
        "repeats": timing.repeats,
        "disturbed": timing.disturbed,
        "evaluations": here.evaluations,
        "operations": operations,
        "events": events,
        "transitions": here.transitions,
        "status": here.status,
        "end_s": here.end[0],
        "change_m": change(before, here) if before else nan,
    }


def change(before: Probe, now: Probe) -> float:
    """How far the centre is from where it was without the effect, m, at most; a motion that has ended stays there."""
    if not (before.path and now.path):
        return nan
    t = np.linspace(0.0, max(before.end[0], now.end[0]), 401)
    x, y = (np.interp(t, now.path[0], now.path[i]) - np.interp(t, before.path[0], before.path[i]) for i in (1, 2))
    return float(max(hypot(a, b) for a, b in zip(x, y, strict=True)))
