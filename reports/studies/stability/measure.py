"""The atlas of hard scenes, solver by solver: right or wrong and by how much, refused, crashed, timed out, chaotic.

    python -m reports.stability [--case NAME …] [--solver NAME …] [--out DIR] [--full] [--jobs N]

writes DIR/stability.csv, DIR/unstable_steps.csv and their pictures. Beside each verdict stand what needs no truth
(energy, gap, tangency, their drifts), the condition of the paper's matrix (27) along the motion, and what one unit in
the last place of the inputs changes: where that alone decides the outcome nobody is ranked.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import adapters
import cases
import reference
from adapters import EngineFailure, Setting
from cases import BadValue, Case, CaseError, Mode, NotSupported, Trajectory
from cases.errors import unknown
from reference import certification

from ...judging import residuals as health
from ...judging.residuals import Conditioning, Health, Spread
from ...running import tasks as trial
from ...running import workers
from ...running.experiment import hopeless
from ...running.records import REFERENCE, TRUTH_RTOL, CaseKey, Offer, Run, Truth, is_default_setting
from . import step_limit as unstable

if TYPE_CHECKING:
    import pandas as pd

# A right motion's centre stays within a hundredth of its path from the truth's: what the eye would call the same.
RIGHT = 1e-2
# A slip below this part of the motion's speed is rounding to whoever reads samples (`metrics` reads them so).
UNSEEN = 1e-9
# One unit in the last place may move the centre by a millionth of its path: engines that come nearer than that to the
# truth would be ranked by noise.
CHAOTIC = 1e-6
# Wall seconds a run may take; deriving the equations of the hardest outlines takes a fraction of a minute by itself. No
# run of a default report takes between 4 and 30 s on the machine it was chosen on: its outcome is the same on others.
_LIMIT, _FULL_LIMIT, _DERIVING = 6.0, 600.0, 120.0
# Samples of the true motion that travel to the engines' judge. Between them it is interpolated by cubics: for the
# longest of the short scenes that is good to 1e-9 of the plate's size.
_SAMPLES = 4000
# Places on a route's ladder that stand in a default report beside the engine as it comes: the third, as fine as two
# workers can take every scene in half a minute.
_RUNGS = (2,)

SLIPS = (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD)

Tell = Callable[[str, int, Iterator], Iterator]


class Scene(NamedTuple):
    """What is known of a case before any engine runs; `motion` is the true one, sampled, None if there is none.

    `visible` is the truth without slips below what a reading of samples tells from rounding: engines are judged by it.
    """

    truth: Truth
    visible: Truth
    motion: Trajectory | None
    conditioning: Conditioning
    spread: Spread
    runs: tuple[tuple[Run, Health], ...]

    @property
    def chaotic(self) -> str:
        """Why nobody is ranked here, or ""."""
        if self.spread.sequence:
            return f"one unit in the last place decides: {self.spread.sequence}"
        if self.spread.centre > CHAOTIC:
            return f"one unit in the last place moves the centre by {self.spread.centre:.1e} of its path"
        return ""


@dataclass(frozen=True)
class Stability:
    """Everything that was found out: scenes by case label, runs with their residuals, and the steps that blow up."""

    cases: tuple[Case, ...]
    scenes: dict[str, Scene]
    runs: tuple[tuple[Run, Health], ...]
    unstable: tuple[unstable.Bracket, ...]


# --- running ----------------------------------------------------------------------------------------------------------


def atlas(full: bool) -> tuple[Case, ...]:
    """The hard cases of the catalogue: the last variant of each family; if `full` all, and those that take minutes."""
    families = [cases.select(name, long=full) for name in cases.names(hard=True)]
    return tuple(case for family in families for case in (family if full else family[-1:]))


def measure(
    chosen: Sequence[Case],
    solvers: Sequence[str],
    full: bool = False,
    jobs: int = 2,
    files: tuple[str, ...] = (),
    tell: Tell = lambda step, total, answers: answers,
    calls: Callable = workers.run,
) -> Stability:
    """Run the cases through the solvers; every call in a process of its own, every failure a row.

    `calls` makes them: `workers.run`, or what stands in for it."""
    keys = {case.label: CaseKey.of(case, files) for case in chosen}
    limit = _FULL_LIMIT if full else _LIMIT

    def step(name: str, function: Callable, asked: list[tuple], seconds: float, instead=lambda call, slow: None):
        answers: dict[int, workers.Answer] = {}
        slow: list[tuple] = []
        coming = calls(function, asked, jobs, seconds, lambda i: instead(asked[i], slow))
        for i, answer in tell(name, len(asked), coming):
            answers[i] = answer
            if answer.outcome == "timed_out":
                slow.append(asked[i])
        return [answers[i] for i in range(len(asked))]

    looks = step("scenes", look, [(key, REFERENCE in solvers, full) for key in keys.values()], limit + _DERIVING)
    scenes = {label: _scene(label, answer) for label, answer in zip(keys, looks, strict=True)}
    runs = [run for scene in scenes.values() for run in scene.runs]
    engines = [name for name in solvers if name != REFERENCE]
    todo: list[tuple] = []
    for case in sorted(chosen, key=lambda case: -case.duration):  # the longest at the end would have the others wait
        for name in engines:
            for offer in trial.survey(keys[case.label], name):
                runs_of, more = _plan(keys[case.label], name, offer, scenes[case.label], full)
                runs += runs_of
                todo += more
    for call, answer in zip(todo, step("engines", assess, todo, limit, hopeless), strict=True):
        runs.append(answer.value if answer.outcome == "done" else (_failed(call, answer), Health()))
    brackets = _brackets(chosen, keys, engines, full, step)
    place = {case.label: i for i, case in enumerate(chosen)}
    runs.sort(key=lambda pair: (place[pair[0].case], pair[0].solver != REFERENCE, pair[0].solver, pair[0].route))
    return Stability(tuple(chosen), scenes, tuple(runs), brackets)


def look(key: CaseKey, with_reference: bool, full: bool) -> Scene:
    """A case's truth, how it is conditioned, what its last bits decide, and the reference's own runs."""
    case = trial.load(key)
    spread = health.spread(case)
    # A hard case of the catalogue whose certificate is not kept has none: its witnesses' sequences differ, or one of
    # them stops, sometimes after minutes.
    kept = bool(key.files) or case.label in certification.read()
    truth = trial.find_truth(key) if kept else Truth(failure="no certificate of it is kept: its witnesses disagree")
    if truth.failure and not spread.sequence:
        truth = _by_one_formulation(case, truth)
    motion = None if truth.failure else reference.simulate(case, rtol=TRUTH_RTOL, method=truth.method)
    conditioning = health.conditioning(case, motion) if motion else Conditioning(nan, nan, nan)
    runs = []
    for offer in trial.survey(key, REFERENCE) if with_reference else ():
        for rung, setting in enumerate(offer.settings if full else offer.settings[1::2], start=1):
            call = (key, REFERENCE, offer.route, setting, rung)
            runs.append(assess(*call, truth, motion) if motion else _untold(call, truth.failure))
    visible = _visible(truth, motion) if motion else truth
    return Scene(truth, visible, _sampled(motion) if motion else None, conditioning, spread, tuple(runs))


def _visible(truth: Truth, motion: Trajectory) -> Truth:
    """The truth without phases of slip that never exceed a billionth of the motion's speed."""
    edges = [float(motion.t[0]), *(t.time for t in truth.transitions), float(motion.t[-1])]
    unseen = UNSEEN * float(np.max(np.hypot(motion.vx, motion.vy)))
    assert truth.first_mode is not None, "a motion has a first mode"
    modes = [truth.first_mode, *(t.after for t in truth.transitions)]
    for i, mode in enumerate(modes):
        # A truth found from several motions may end a rounding later than this one.
        looks = np.clip(np.linspace(edges[i], edges[i + 1], 21), motion.t[0], motion.t[-1])
        slips = np.abs(np.asarray(motion(looks).slip))
        if mode in SLIPS and slips.max() <= unseen:
            modes[i] = Mode.ROLL
    kept = [i for i in range(1, len(modes)) if modes[i] != modes[i - 1]]
    return replace(
        truth,
        first_mode=modes[0],
        transitions=tuple(replace(truth.transitions[i - 1], before=modes[i - 1], after=modes[i]) for i in kept),
        error_bars=tuple(truth.error_bars[i - 1] for i in kept),
    )


def _by_one_formulation(case: Case, failed: Truth) -> Truth:
    """The truth where the second formulation is no witness, if the first one's methods agree; else the failed one."""
    methods = (*reference.METHODS, *(("taylor_quadruple",) if "taylor" in reference.METHODS else ()))
    motions = [reference.simulate(case, rtol=TRUTH_RTOL, method=method) for method in methods]
    centre = motions[0]
    kinds = [(t.before, t.after) for t in centre.transitions]
    if any(m.status != centre.status or [(t.before, t.after) for t in m.transitions] != kinds for m in motions):
        return failed
    bars = tuple(
        max(abs(t.time - same[0].time) for t in same) + float(np.spacing(same[0].time))
        for same in zip(*(m.transitions for m in motions), strict=True)
    )
    return Truth(
        method=methods[0],
        transitions=tuple(centre.transitions),
        error_bars=bars,
        first_mode=centre.first_mode,
        status=centre.status,
        reason=centre.reason,
        samples={"t": centre.t},
        witnesses=tuple(f"{method} {TRUTH_RTOL:g}" for method in methods),
    )


def _untold(call: tuple, why: str) -> tuple[Run, Health]:
    """The row of a run that is not made because nothing is there to judge it by."""
    key, name, route, setting, rung = call
    reason = f"there is no truth to judge it by: {why}"
    return Run(trial.load(key).label, name, route, str(setting), rung, "refused", reason), Health()


def _sampled(motion: Trajectory) -> Trajectory:
    """A motion without its dense output, which does not travel between processes."""
    events = [event.time for event in motion.transitions]
    times = np.union1d(np.linspace(motion.t[0], motion.t[-1], _SAMPLES), events)
    return Trajectory(t=times, **motion(times)._asdict(), first_mode=motion.first_mode)


def _scene(label: str, answer: workers.Answer) -> Scene:
    if answer.outcome == "done":
        return answer.value
    outcome = "timed_out" if answer.outcome == "timed_out" else "crashed"
    failed = Run(label, REFERENCE, "", "", 0, outcome, answer.reason)
    nothing = Truth(failure=answer.reason)
    return Scene(nothing, nothing, None, Conditioning(nan, nan, nan), Spread("", nan, nan), ((failed, Health()),))


def _plan(key: CaseKey, name: str, offer: Offer, scene: Scene, full: bool):
    """Rows of what cannot be run, and the calls of what can."""
    if offer.outcome:
        return [(Run(trial.load(key).label, name, offer.route, "", 0, offer.outcome, offer.reason), Health())], []
    chosen = offer.settings if full else _few(offer.settings)
    calls = [(key, name, offer.route, setting, rung) for rung, setting in enumerate(chosen, 1)]
    if scene.motion is None:
        return [_untold(call, scene.truth.failure) for call in calls], []
    return [], [(*call, scene.visible, scene.motion) for call in calls]


def _few(settings: Sequence[Setting]) -> list[Setting]:
    ladder = [s for s in settings if not is_default_setting(s)]
    return [*(s for s in settings if is_default_setting(s)), *(ladder[i] for i in _RUNGS if i < len(ladder))]


def assess(
    key: CaseKey, name: str, route: str, setting: Setting, rung: int, truth: Truth, motion: Trajectory
) -> tuple[Run, Health]:
    """Run one setting, judge it by the true motion and examine it by itself."""
    case = trial.load(key)
    row = Run(case.label, name, route, str(setting), rung, outcome="")
    try:
        trajectory = trial.timed(trial.solver(name), case, route, setting)
    except NotSupported as refusal:
        return replace(row, outcome="refused", reason=str(refusal)), Health()
    except EngineFailure as failure:
        return replace(row, outcome="crashed", reason=str(failure)), Health()
    except Exception as problem:
        return replace(row, outcome="crashed", reason=trial._sentence(problem)), Health()
    if not trial._sound(trajectory):
        return replace(row, outcome="crashed", reason="it gave numbers that are not finite, or no motion"), Health()
    run = trial.judge(replace(row, status=trajectory.status), case, trajectory, motion, truth)
    run = replace(run, samples={}, off={})
    off = run.distance.centre_max / health.motion_extent(case, motion)
    if run.outcome == "right" and off > RIGHT:
        run = replace(run, outcome="wrong", reason=f"its centre is off by {off:.2g} of the path")
    if run.outcome == "right" and truth.status == "paradox" and trajectory.status != "paradox":
        run = replace(run, reason="it goes on where rigid contact has no answer")
    return run, health.examine(case, trajectory)


def _failed(call: tuple, answer: workers.Answer) -> Run:
    key, name, route, setting, rung, *_ = call
    outcome = "timed_out" if answer.outcome == "timed_out" else "crashed"
    return Run(trial.load(key).label, name, route, str(setting), rung, outcome, answer.reason)


def _brackets(chosen, keys, engines, full: bool, step) -> tuple[unstable.Bracket, ...]:
    """The step that blows up, of each route on a few cases (on all, if `full`)."""
    wanted = [case for case in chosen if full or case.label in unstable.LOOKED_AT]
    calls = [
        (keys[case.label], name, offer.route)
        for case in wanted
        for name in engines
        for offer in trial.survey(keys[case.label], name)
        if not offer.outcome
    ]
    answers = step("unstable steps", unstable.bracket, calls, unstable.PATIENCE)
    return tuple(
        answer.value if answer.outcome == "done" else unstable.Bracket.unknown(*call, answer.reason)
        for call, answer in zip(calls, answers, strict=True)
    )


# --- rows -------------------------------------------------------------------------------------------------------------


def rows(found: Stability) -> list[dict[str, Any]]:
    """One row per run. `centre_error` is the largest distance from the truth over the path; `spread` what one unit in
    the last place of the inputs does to it; `condition` of (27) in the plate's own units, `condition_si` as it
    stands; `witnesses` how many ways of solving the truth rests on."""
    from ...analysis import tables

    extents = {c.label: health.motion_extent(c, m) for c in found.cases if (m := found.scenes[c.label].motion)}
    told = []
    for run, residuals in found.runs:
        scene = found.scenes[run.case]
        outcome, reason = run.outcome, run.reason
        if scene.chaotic and (
            outcome in ("right", "wrong") or (outcome == "refused" and scene.motion is None and run.setting)
        ):
            outcome, reason = "chaotic", scene.chaotic
        told.append(
            {
                "case": run.case,
                "solver": run.solver,
                "route": run.route,
                "setting": run.setting,
                "outcome": outcome,
                "reason": reason,
                "first_transition_error": tables.first_error(run),
                "centre_error": run.distance.centre_max / extents.get(run.case, nan),
                "energy": residuals.energy,
                "energy_drift": residuals.energy_drift,
                "gap": residuals.gap,
                "gap_drift": residuals.gap_drift,
                "tangency": residuals.tangency,
                "condition": scene.conditioning.scaled,
                "condition_si": scene.conditioning.largest,
                "condition_time": scene.conditioning.when,
                "spread": scene.spread.centre,
                "spread_time": scene.spread.time,
                "witnesses": len(scene.truth.witnesses),
            }
        )
    return told


def frame(found: Stability) -> pd.DataFrame:
    """The table `stability`."""
    import pandas as pd

    return pd.DataFrame(rows(found))


def frames(found: Stability) -> dict[str, pd.DataFrame]:
    """The tables `stability` and `unstable_steps`; none if nothing was run."""
    import pandas as pd

    if not found.cases:
        return {}
    return {"stability": frame(found), "unstable_steps": pd.DataFrame([b._asdict() for b in found.unstable])}


def draw(found: Stability, folder: Path):
    """Write the pictures; yields what was written."""
    from . import figure as stability_figures

    yield from stability_figures.draw(found, folder)


# --- the command ------------------------------------------------------------------------------------------------------


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status: 0, or 2 with one line if what was asked for makes no sense."""
    from ... import build
    from ... import options as plan
    from ...analysis import tables

    parser = plan.Parser(prog="python -m reports.stability", description="Hard scenes, solver by solver.")
    parser.add_argument(
        "--case", nargs="+", action="extend", metavar="NAME", help="cases (default: one variant of each hard family)"
    )
    parser.add_argument("--solver", nargs="+", action="extend", metavar="NAME", help="solvers (default: all)")
    parser.add_argument("--out", default="stability", metavar="DIR", help="folder to write (default: stability)")
    parser.add_argument(
        "--full", action="store_true", help="every variant and setting, every unstable step, long scenes"
    )
    parser.add_argument("--jobs", default="2", metavar="N", help="runs beside each other (default: 2)")
    try:
        asked = parser.parse_args(list(sys.argv[1:] if argv is None else argv))
        chosen, solvers = _chosen(asked)
        jobs = plan.whole_jobs(asked.jobs)
        found = measure(chosen, solvers, asked.full, jobs, tell=build.progress)
        folder = Path(asked.out)
        folder.mkdir(parents=True, exist_ok=True)
        tables.write(frames(found), folder)
        for drawn in draw(found, folder):
            print(f"written: {folder / drawn.name}.svg")
    except (CaseError, OSError) as problem:
        print(f"reports.stability: {problem}", file=sys.stderr)
        return 2
    print(f"written: {folder / 'stability.csv'}, {folder / 'unstable_steps.csv'}\n\n{summary(found)}")
    return 0


def _chosen(asked: argparse.Namespace) -> tuple[tuple[Case, ...], tuple[str, ...]]:
    known = (REFERENCE, *adapters.engines())
    solvers = tuple(dict.fromkeys(asked.solver or known))
    for name in solvers:
        if name not in known:
            raise unknown("solver", name, known)
    if not asked.case:
        return atlas(asked.full), solvers
    chosen = {case.label: case for text in asked.case for case in cases.select(text, long=asked.full)}
    if Path(asked.out).is_file():
        raise BadValue(f"--out is {asked.out}, which is a file; give a folder")
    return tuple(chosen.values()), solvers


def summary(found: Stability) -> str:
    """Outcomes by route, and the reference's worst residuals at its finest, for the terminal."""
    from collections import Counter

    from tabulate import tabulate

    counts: dict[tuple[str, str], Counter] = {}
    told = rows(found)
    for row in told:
        counts.setdefault((row["solver"], row["route"]), Counter())[row["outcome"]] += 1
    words = ("right", "wrong", "chaotic", "refused", "crashed", "timed_out")
    lines = [tabulate([[*who, *(c[w] for w in words)] for who, c in counts.items()], ["solver", "route", *words])]
    finest = [r for r in told if r["solver"] == REFERENCE and r["setting"] == f"rtol={TRUTH_RTOL:g}"]
    for name in ("energy", "gap", "tangency", "condition"):
        known = [row for row in finest if isfinite(row[name])]
        if known:
            worst = max(known, key=lambda row: row[name])
            lines.append(f"reference at rtol={TRUTH_RTOL:g}, largest {name}: {worst[name]:.1e} ({worst['case']})")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
