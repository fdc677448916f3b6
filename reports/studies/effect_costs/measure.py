"""What each effect costs, and what would be wrong without it: one scene, its effects added one at a time.

    python -m reports.effect_costs [--out DIR] [--solver NAME …] [--seconds S]

Every solver runs each stage it can; a stage that it refuses is a row that says why. Results come first, in isolated
workers; then all stages of all solvers take turns at the clock, in one process, with nothing beside it.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial
from itertools import cycle
from math import hypot, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cases import (
    Case,
    CoulombFriction,
    Curve,
    Effect,
    Flight,
    Gravity,
    Impact,
    Load,
    RollingResistance,
    Start,
    Unilateral,
    disc,
)
from cases import curves as c
from cases.library import circle

from ...running import workers
from ...running.clock import Contestant, Entry, take_turns, timing
from ...running.tasks import solver

if TYPE_CHECKING:
    import pandas as pd

    from ...drawing.style import Drawn

# Wall seconds for the timings of a scene: the stages of the reference take milliseconds, of an engine up to a second.
BUDGET = 5.0
# A stage that takes longer than this has lost its way; the slowest engine needs two seconds.
LIMIT = 30.0
# The reference at a tolerance that engines do not reach, engines in the middle of their ladders: one price for each.
_RTOL = "rtol=1e-09"


class Stage(NamedTuple):
    """A scene with one effect more than the stage before: the effect's name, and the case."""

    added: str
    case: Case


class Probe(NamedTuple):
    """What a solver made of a stage: outcome and reason, setting, where it ended, its path, what it took."""

    outcome: str
    reason: str = ""
    setting: str = ""
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
    return tuple(Stage(_name(effect, effects[:i]), make(_merged(effects[: i + 1]))) for i, effect in enumerate(effects))


def _name(effect: Effect, before: Sequence[Effect]) -> str:
    again = any(type(effect) is type(e) for e in before)
    return "static friction" if again else type(effect).__name__


def _merged(effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """The effects, a later one of a kind in the place of an earlier."""
    return tuple({type(effect): effect for effect in effects}.values())


def _in_circle(effects: tuple[Effect, ...]) -> Case:
    return Case(circle(1.0), disc(0.1, 1.0), effects, Start(xi1=-0.1), 2.5, name="in_circle")


def _over_crest(effects: tuple[Effect, ...]) -> Case:
    track = Curve(lambda s: (s, c.exp(-4.0 * s**2)), domain=(-8, 12))
    return Case(track, disc(0.05, 1.0), effects, Start(xi1=0.0, slip=1.4), 1.0, name="over_crest")


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


def probe(scene: str, stage: int, name: str, route: str) -> Probe:
    """Run one stage by one route of a solver."""
    case = stages(scene)[stage].case
    try:
        module = solver(name)
    except ImportError as problem:
        return Probe("refused", f"{name} is not installed here ({problem})")
    refusal = module.refuses(case, route)
    if refusal:
        return Probe("refused", refusal)
    setting = _setting(module, case, route)
    began = time.perf_counter()
    model = module.build(case, route, setting)
    module.run(model)
    seconds = time.perf_counter() - began
    motion = module.read(model)
    path = np.linspace(motion.t[0], motion.t[-1], 201)
    state = motion(path)
    if not np.all(np.isfinite([state.x, state.y])):
        return Probe("wrong", "its motion is not finite", str(setting))
    return Probe(
        "done", "", str(setting), (float(motion.t[-1]), float(motion.x[-1]), float(motion.y[-1])),
        (path, state.x, state.y), motion.status, len(motion.transitions), motion.cost.evaluations, seconds,
    )  # fmt: skip


def _setting(module, case: Case, route: str):
    ladder = module.ladder(case, route)
    return next((s for s in ladder if str(s) == _RTOL), ladder[len(ladder) // 2])


@lru_cache
def compiled(case: Case) -> tuple[int, int]:
    """Operations of the largest of the case's compiled modes of contact (rates and events, after common
    subexpressions), and how many events are watched in the mode that watches most."""
    import sympy as sp

    from reference.modes import candidates, phase

    systems = [phase(case, regime).system for regime in candidates(case)]

    def operations(system) -> int:
        shared, rest = sp.cse([*system.rates, *system.guards.values()])
        return int(sp.count_ops([e for _, e in shared]) + sp.count_ops(rest))

    return max(map(operations, systems)), max(len(system.guards) for system in systems)


# --- prices -----------------------------------------------------------------------------------------------------------


def prices(scene: str, contestants: Sequence[tuple[int, str, str, float]], budget: float) -> dict[tuple, tuple]:
    """Timings of (stage, solver, route, expected seconds), all in turn: (median, low, high, repeats, disturbed)."""
    entries = []
    for stage, name, route, expected in contestants:
        case, module = stages(scene)[stage].case, solver(name)
        setting = _setting(module, case, route)
        who = Contestant(name, route, str(setting), expected)
        entries.append(Entry(who, partial(module.build, case, route, setting), module.run))
    loop = take_turns(entries, time.perf_counter() + budget)
    told = {}
    for (stage, name, route, _), entry in zip(contestants, entries, strict=True):
        if entry.repeats:
            t = timing(entry, loop)
            told[stage, name, route] = (t.cpu_s, t.cpu_low_s, t.cpu_high_s, t.repeats, t.disturbed)
    return told


def measure(
    solvers: Sequence[str],
    jobs: int = 2,
    budget: float = BUDGET,
    tell: Callable[[str, int, Iterator], Iterator] = lambda step, total, answers: answers,
    calls: Callable = workers.run,
) -> list[dict[str, Any]]:
    """The rows of all scenes: one for each stage and route. `calls` makes what is not timed, as `workers.run` does."""
    rows = []
    with workers.Pool(1) as alone:
        for scene in SCENES:
            rows += _priced(scene, solvers, jobs, budget, tell, calls, alone)
    return rows


def _priced(scene: str, solvers: Sequence[str], jobs: int, budget: float, tell, calls, alone: workers.Pool):
    """The rows of a scene; timed in the worker that is `alone`, which has imported everything at the second one."""
    count = len(stages(scene))
    asked = [(scene, i, name, route) for name in solvers for route in _routes(name) for i in range(count)]
    answers = tell(f"effects {scene}", len(asked), calls(probe, asked, jobs, LIMIT))
    probes = {asked[k][1:]: _probe(answer) for k, answer in answers}
    timed = [(*who, p.seconds) for who, p in probes.items() if p.outcome == "done"]
    (_, answer), *_ = alone.run(prices, [(scene, timed, budget)], budget + 2 * LIMIT)
    told = answer.value if answer.outcome == "done" else {}
    order = sorted(probes, key=lambda who: (solvers.index(who[1]), _routes(who[1]).index(who[2]), who[0]))
    return [_row(scene, who, probes, told) for who in order]


def _routes(name: str) -> tuple[str, ...]:
    try:
        return tuple(solver(name).routes)
    except ImportError:
        return ("",)


def _probe(answer: workers.Answer) -> Probe:
    if answer.outcome == "done":
        return answer.value
    return Probe("timed_out" if answer.outcome == "timed_out" else "crashed", answer.reason)


def _row(scene: str, who: tuple[int, str, str], probes: dict, told: dict) -> dict[str, Any]:
    stage, name, route = who
    here, case = probes[who], stages(scene)[stage].case
    before = probes.get((stage - 1, name, route))
    cpu, low, high, repeats, disturbed = told.get(who, (nan, nan, nan, 0, False))
    first = told.get((0, name, route), (nan,))[0]
    operations, events = compiled(case) if name == "reference" else (nan, nan)
    return {
        "scene": scene,
        "effect": stages(scene)[stage].added,
        "effects": " + ".join(type(e).__name__ for e in case.effects),
        "solver": name,
        "route": route,
        "setting": here.setting,
        "outcome": here.outcome,
        "reason": here.reason,
        "cpu_s": cpu,
        "cpu_low_s": low,
        "cpu_high_s": high,
        "cpu_to_first": cpu / first,
        "repeats": repeats,
        "disturbed": disturbed,
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


def frame(rows: Sequence[dict[str, Any]]) -> pd.DataFrame:
    """The price list as a table."""
    import pandas as pd

    return pd.DataFrame(rows)


# --- figure and command -----------------------------------------------------------------------------------------------

_WORDS = (
    "What each effect costs",
    "One scene, its effects added one at a time from left to right. Above: CPU time of the run with all effects up to "
    "this one (median, each solver at one setting; hollow: the machine was disturbed). Below: how far the motion moves "
    "when the effect is added, which is what would be wrong without it (a motion that has ended stays where it is). A "
    "solver that lacks an effect has no point there.",
)


def draw(rows: Sequence[dict[str, Any]], folder: Path) -> Iterator[Drawn]:
    """One figure for each scene; yields what was written."""
    import matplotlib

    from ...drawing.style import STYLE, save

    with matplotlib.rc_context(STYLE):
        for scene in SCENES:
            own = [row for row in rows if row["scene"] == scene]
            if own:
                yield save(_figure(scene, own), folder, f"effect_costs_{scene}", "", *_WORDS)


def _figure(scene: str, rows: Sequence[dict[str, Any]]):
    from matplotlib import pyplot as plt

    from ...drawing.style import PALETTE

    names = [stage.added for stage in stages(scene)]
    figure, (above, below) = plt.subplots(2, 1, figsize=(8.0, 6.0), sharex=True, height_ratios=(3, 2))
    who = sorted(
        {(row["solver"], row["route"]) for row in rows if row["outcome"] == "done"},
        key=lambda w: (w[0] != "reference", w),
    )
    for (name, route), colour in zip(who, cycle(PALETTE), strict=False):
        own = [row for row in rows if (row["solver"], row["route"]) == (name, route) and row["cpu_s"] > 0.0]
        places = [names.index(row["effect"]) for row in own]
        above.plot(places, [row["cpu_s"] for row in own], marker="o", color=colour, label=f"{name} {route}")
        hollow = [row for row in own if row["disturbed"]]
        places = [names.index(row["effect"]) for row in hollow]
        above.plot(places, [row["cpu_s"] for row in hollow], "o", color=colour, markerfacecolor="white")
    changes = [row for row in rows if (row["solver"], row["route"]) == who[0]] if who else []
    below.bar(
        [names.index(row["effect"]) for row in changes], [row["change_m"] for row in changes], 0.5, color=PALETTE[0]
    )
    above.set(yscale="log", ylabel="CPU time of the run / s")
    below.set(
        yscale="symlog",
        ylabel="change of the motion / m",
        xticks=range(len(names)),
        xticklabels=[f"+ {n}" for n in names],
    )
    below.set_yscale("symlog", linthresh=1e-6)
    below.tick_params(axis="x", labelrotation=18)
    above.legend(fontsize="small", ncols=2)
    figure.tight_layout()
    return figure


def main(argv: Sequence[str] | None = None) -> int:
    """The command: writes effect_costs.csv and its figures into a folder and prints the table."""
    import argparse

    import adapters
    from cases.errors import unknown

    known = ("reference", *adapters.engines())
    parser = argparse.ArgumentParser(prog="python -m reports.effect_costs", description=__doc__.split("\n")[0])
    parser.add_argument("--out", default="effect_costs", metavar="DIR", help="folder for the table and its figures")
    parser.add_argument("--solver", nargs="+", default=list(known), metavar="NAME", help=", ".join(known))
    parser.add_argument("--seconds", type=float, default=BUDGET, metavar="S", help="wall seconds of timing a scene")
    options = parser.parse_args(argv)
    for name in options.solver:
        if name not in known:
            print(f"reports.effect_costs: {unknown('solver', name, known)}", file=sys.stderr)
            return 2
    table = frame(rows := measure(options.solver, budget=options.seconds))
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    table.to_csv(folder / "effect_costs.csv", index=False)
    drawn = list(draw(rows, folder))
    shown = [
        "scene",
        "effect",
        "solver",
        "route",
        "outcome",
        "cpu_s",
        "cpu_to_first",
        "operations",
        "events",
        "change_m",
    ]
    print(table[shown].to_string(index=False))
    print(f"written: {folder}/effect_costs.csv and {len(drawn)} figures")
    return 0


if __name__ == "__main__":
    sys.exit(main())
