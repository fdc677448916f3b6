"""Results and costs of each solver for a scene whose effects are added one at a time.

Every solver runs each stage that it supports; an unsupported stage is a row with the reason. The results are computed
first, in workers; then all stages of all solvers are timed in turns, in one process without other load.
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
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Drive,
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
from reports.analysis.columns import Table
from reports.running.calls import Calls, StorePolicy
from reports.running.clocked_run import run_on_clock
from reports.running.experiment import offers
from reports.running.names import REFERENCE
from reports.running.records import one_default
from reports.running.solvers import solver
from reports.running.timing import clock
from reports.running.timing.clock import NO_TIMING, Contestant, Timing
from reports.running.timing.timed_pass import together
from reports.studies import Request

TABLES = {
    "effect_costs": Table(
        "The cost of each effect, and the error of the motion without it",
        {
            "scene": "the scene, which also determines the order of its effects",
            "effect": "the effect that this stage adds to the stage before",
            "effects": "all effects of the stage",
            "solver": "the solver",
            "route": "its route, or method of the reference",
            "setting": "one rung: the reference at 1e-9, engines in the middle of their ladders",
            "outcome": "done, unsupported, crashed (also a motion that is not finite) or timed_out",
            "reason": "the reason of any other outcome than done",
            "cpu_s": "CPU time of the run alone, s: the median of the undisturbed repeats",
            "cpu_low_s": "lower end of the interval expected for the median of another process, s",
            "cpu_high_s": "its upper end, s",
            "cpu_to_first": "CPU time over that of the first stage",
            "repeats": "number of repeats behind the median",
            "disturbed": "whether the timing was disturbed by other load",
            "evaluations": "evaluations of the right-hand side, if the solver counts them",
            "operations": "operations of the largest compiled mode of contact (the reference)",
            "events": "largest number of events monitored in a mode (the reference)",
            "transitions": "transitions that the solver located itself",
            "status": "how the motion ended",
            "end_s": "when it ended, s",
            "change_m": "largest distance of the centre from the motion without the effect, m",
        },
    )
}

# Wall-clock budget in seconds for the timings of a scene: a stage takes milliseconds in the reference, and up to a
# second in an engine.
BUDGET, FULL_BUDGET = 5.0, 60.0
# Time limit of a stage in seconds: the slowest engine needs two.
LIMIT = 30.0
# One setting for each solver: for the reference a tolerance that engines do not reach, for engines the middle rung.
_RTOL = Setting.of(rtol=1e-9)


class Stage(NamedTuple):
    """A scene with one more effect than the stage before: the effect's name, and the case."""

    effect: str
    case: Case


class StageResult(NamedTuple):
    """A solver's result for a stage: outcome and reason, setting, end (s, m), path (s, m), and work done."""

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
    cases = [replace(make(_merge(effects[: i + 1])), name=f"{scene}, stage {i}") for i in range(len(effects))]
    return tuple(Stage(_name(e, effects[:i]), case) for i, (e, case) in enumerate(zip(effects, cases, strict=True)))


# The name of a stage that replaces an effect by another of its class.
AGAIN = {CoulombFriction: "static friction", Belt: "belt of varying speed"}


def _name(effect: Effect, before: Sequence[Effect]) -> str:
    if isinstance(effect, CoulombFriction) and effect.by_speed:
        return "friction by slip speed"
    again = any(type(effect) is type(e) for e in before)
    return AGAIN[type(effect)] if again else type(effect).__name__


def _merge(effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """The effects, with each later effect of the same class replacing the earlier one."""
    return tuple({type(effect): effect for effect in effects}.values())


def _in_circle(effects: tuple[Effect, ...]) -> Case:
    return Case(circle(1.0), disc(0.1, 1.0), effects, Start(xi1=-0.1), 2.5)


def _on_belt(effects: tuple[Effect, ...]) -> Case:
    return Case(circle(1.0), disc(0.1, 1.0), effects, Start(xi1=-1.5), 2.5)


def _over_crest(effects: tuple[Effect, ...]) -> Case:
    track = Curve(lambda s: (s, c.exp(-4.0 * s**2)), domain=(-8, 12))
    return Case(track, disc(0.05, 1.0), effects, Start(xi1=0.0, slip=1.4), 1.0)


# Each scene: the function that makes its case from effects, and the effects in the order in which they are added.
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
            CoulombFriction("0.12 + 0.03*exp(-v/0.1) + 0.01*v", 0.2),
        ),
    ),
    "on_belt": (
        _on_belt,
        (
            Gravity(9.81),
            Unilateral(),
            CoulombFriction(0.15),
            Belt(0.5),
            Belt("0.5 + 0.2*sin(3*t)"),
            Drive(x="0.05*sin(6*t)"),
        ),
    ),
    "over_crest": (
        _over_crest,
        (Gravity(9.81), Unilateral(), Flight(), Impact(0.3), CoulombFriction(0.2), RollingResistance(0.002)),
    ),
}


# --- results ----------------------------------------------------------------------------------------------------------


def probe(case: Case, name: str, route: str, setting: Setting) -> StageResult:
    """Run one stage by one route of a solver."""
    try:
        motion = run_on_clock(solver(name), case, route, setting)
    except NotSupported as refusal:
        return StageResult("unsupported", str(refusal), setting)
    path = np.linspace(motion.t[0], motion.t[-1], 201)
    state = motion(path)
    x, y = np.asarray(state.x), np.asarray(state.y)
    if not np.all(np.isfinite([x, y])):
        return StageResult("crashed", "its motion is not finite", setting)
    return StageResult(
        "done", "", setting, (float(motion.t[-1]), float(motion.x[-1]), float(motion.y[-1])),
        (path, x, y), motion.status, len(motion.transitions), motion.cost.evaluations,
        motion.cost.wall_s + motion.cost.setup_s,
    )  # fmt: skip


def _middle(ladder: Sequence[Setting]) -> Setting:
    return _RTOL if _RTOL in ladder else ladder[len(ladder) // 2]


@lru_cache
def compiled_size(case: Case) -> tuple[int, int]:
    """Operation count of the case's largest compiled mode of contact (rates and events, each common part counted once),
    and the largest number of events monitored in a mode."""
    from cases.formulas.expression_graph import in_order
    from reference.minimal.modes import candidates, phase

    systems = [phase(case, regime).system for regime in candidates(case)]

    def operations(system) -> int:
        nodes = in_order([*system.rates, *system.guards.values()])
        return sum(node.op not in ("number", "symbol") for node in nodes)

    return max(map(operations, systems)), max(len(system.guards) for system in systems)


# --- costs ------------------------------------------------------------------------------------------------------------

RouteKey = tuple[int, str, str]  # stage, solver, route


def measure(solvers: Sequence[str], budget: float, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all scenes: one for each stage and route, timed within `budget` wall-clock seconds per scene."""
    with calls.alone() as alone:
        return [row for scene in SCENES for row in _price(scene, solvers, budget, calls, alone)]


def _price(scene: str, solvers: Sequence[str], budget: float, calls: Calls, alone: Calls) -> Iterator[dict[str, Any]]:
    """The rows of a scene, timed in the only running worker `alone`; for the second scene its imports are done."""
    probes = dict(_probes(scene, solvers, calls))
    cases = [stage.case for stage in stages(scene)]
    able = {key: p for key, p in probes.items() if p.outcome == "done"}
    contestants = [Contestant(cases[i], name, route, p.setting, p.seconds) for (i, name, route), p in able.items()]
    found, _ = together(clock.time_all, contestants, budget, budget, alone, "timings") if able else ({}, {})
    stage_of = {one.key: (cases.index(one.case), one.solver, one.route) for one in contestants}
    timings = {stage_of[key]: timing for key, timing in found.items()}
    routes = list(dict.fromkeys(key[1:] for key in probes))
    for key in sorted(probes, key=lambda key: (solvers.index(key[1]), routes.index(key[1:]), key[0])):
        yield _row(scene, key, probes, timings)


def _probes(scene: str, solvers: Sequence[str], calls: Calls) -> Iterator[tuple[RouteKey, StageResult]]:
    """The result of every route for every stage."""
    cases = [stage.case for stage in stages(scene)]
    labels = [case.label for case in cases]
    todo: list[tuple[RouteKey, tuple]] = []
    for (label, name), of_routes in offers(cases, solvers, calls).items():
        for offer in of_routes:
            key = (labels.index(label), name, offer.route)
            if offer.outcome or not offer.settings:
                yield (
                    key,
                    StageResult(offer.outcome or "unsupported", offer.reason or "it offers no setting for this case"),
                )
            else:
                todo.append((key, (cases[key[0]], name, offer.route, _middle(one_default(offer.settings)))))
    answers = calls.all(f"effects {scene}", probe, [call for _, call in todo], limit=LIMIT, keep=StorePolicy())
    for (key, call), answer in zip(todo, answers, strict=True):
        yield key, answer.value if answer.outcome == "done" else StageResult(*answer.failure, call[3])


def _row(
    scene: str, key: RouteKey, probes: dict[RouteKey, StageResult], timings: dict[RouteKey, Timing]
) -> dict[str, Any]:
    stage, name, route = key
    current, case = probes[key], stages(scene)[stage].case
    before = probes.get((stage - 1, name, route))
    timing, first = timings.get(key, NO_TIMING), timings.get((0, name, route), NO_TIMING)
    operations, events = compiled_size(case) if name == REFERENCE else (nan, nan)
    return {
        "scene": scene,
        "effect": stages(scene)[stage].effect,
        "effects": " + ".join(type(e).__name__ for e in case.effects),
        "solver": name,
        "route": route,
        "setting": current.setting,
        "outcome": current.outcome,
        "reason": current.reason,
        "cpu_s": timing.cpu_s,
        "cpu_low_s": timing.cpu_low_s,
        "cpu_high_s": timing.cpu_high_s,
        "cpu_to_first": timing.cpu_s / first.cpu_s,
        "repeats": timing.repeats,
        "disturbed": timing.disturbed,
        "evaluations": current.evaluations,
        "operations": operations,
        "events": events,
        "transitions": current.transitions,
        "status": current.status,
        "end_s": current.end[0],
        "change_m": change(before, current) if before else nan,
    }


def change(before: StageResult, now: StageResult) -> float:
    """The largest distance (m) of the centre from the motion without the effect; after its end, a motion stays put."""
    if not (before.path and now.path):
        return nan
    t = np.linspace(0.0, max(before.end[0], now.end[0]), 401)
    x, y = (np.interp(t, now.path[0], now.path[i]) - np.interp(t, before.path[0], before.path[i]) for i in (1, 2))
    return float(max(hypot(a, b) for a, b in zip(x, y, strict=True)))


def run(request: Request, calls: Calls) -> list[dict[str, Any]]:
    """The rows of all scenes."""
    return measure(request.solvers, FULL_BUDGET if request.full else BUDGET, calls)


def rows(findings: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The table of costs."""
    return {"effect_costs": findings}
