"""The atlas of hard scenes, solver by solver: right or wrong and by how much, refused, crashed, timed out, chaotic.

Beside each verdict stand what needs no truth (energy, gap, tangency, their drifts), the condition of the paper's matrix
(27) along the motion, and what one unit in the last place of the inputs changes: where that alone decides the outcome
nobody is ranked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np

import cases
import reference
from adapters import Setting
from cases import Case, Mode, Trajectory
from reference import certification

from ...judging import residuals
from ...judging.residuals import Residuals
from ...running.calls import Calls, Keep
from ...running.experiment import hopeless, offers
from ...running.records import REFERENCE, TRUTH_RTOL, Offer, Run, Truth, first_error
from ...running.serving import Answer
from ...running.tasks import attempt, find_truth, in_catalogue, judge, true_motion
from . import sensitivity, step_limit
from .sensitivity import Conditioning, Spread

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


class Scene(NamedTuple):
    """What is known of a case before any engine runs; `motion` is the true one, sampled, None if there is none.

    `visible` is the truth without slips below what a reading of samples tells from rounding: engines are judged by it.
    """

    truth: Truth
    visible: Truth
    motion: Trajectory | None
    conditioning: Conditioning
    spread: Spread

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
    runs: tuple[tuple[Run, Residuals], ...]
    unstable: tuple[step_limit.Bracket, ...]


# --- running ----------------------------------------------------------------------------------------------------------


def atlas(full: bool) -> tuple[Case, ...]:
    """The hard cases of the catalogue: the last variant of each family; if `full` all, and those that take minutes."""
    families = [cases.select(name, long=full) for name in cases.names(hard=True)]
    return tuple(case for family in families for case in (family if full else family[-1:]))


def measure(chosen: Sequence[Case], solvers: Sequence[str], full: bool, calls: Calls) -> Stability:
    """Run the cases through the solvers; every failure is a row."""
    limit = _FULL_LIMIT if full else _LIMIT
    answers = calls.all("scenes", scene_of, [(case,) for case in chosen], limit=limit + _DERIVING, keep=Keep())
    scenes = {case.label: _scene(answer) for case, answer in zip(chosen, answers, strict=True)}
    runs = [_unknown(case, answer) for case, answer in zip(chosen, answers, strict=True) if answer.outcome != "done"]
    failed = {run.case for run, _ in runs}
    # The longest at the end would have the others wait.
    offered = offers(sorted(chosen, key=lambda case: -case.duration), solvers, calls)
    by_label = {case.label: case for case in chosen}
    own: list[tuple] = []
    todo: list[tuple] = []
    for (label, name), of_routes in offered.items():
        for offer in of_routes if name != REFERENCE or label not in failed else ():
            excused, more = _plan(by_label[label], name, offer, scenes[label], full)
            runs += excused
            (own if name == REFERENCE else todo).extend(more)
    own.reverse()  # the paper's matrix at fine tolerances takes longest
    runs += _assessed(calls.all("reference", assess_own, own, limit=limit + _DERIVING, keep=Keep()), own)
    # Rung by rung: where the coarse one of a route runs out of time the next has not begun, and is not tried.
    todo.sort(key=lambda call: (-call[0].duration, call[0].label, call[4]))
    runs += _assessed(calls.all("engines", assess, todo, limit=limit, keep=Keep(), skip=hopeless), todo)
    engines = [name for name in solvers if name != REFERENCE]
    wanted = [
        (case, name, offer.route, middle)
        for case in chosen
        if full or case.label in step_limit.LOOKED_AT
        for name in engines
        for offer in offered[case.label, name]
        if (middle := _middle(offer.settings))
    ]
    brackets = _brackets(wanted, calls)
    place = {case.label: i for i, case in enumerate(chosen)}
    runs.sort(
        key=lambda pair: (place[pair[0].case], pair[0].solver != REFERENCE, pair[0].solver, pair[0].route, pair[0].rung)
    )
    return Stability(tuple(chosen), scenes, tuple(runs), brackets)


def scene_of(case: Case) -> Scene:
    """A case's truth, how it is conditioned and what its last bits decide."""
    spread = sensitivity.spread(case)
    # A hard case of the catalogue whose certificate is not kept has none: its witnesses' sequences differ, or one of
    # them stops, sometimes after minutes.
    kept = not in_catalogue(case) or case.label in certification.read()
    truth = find_truth(case) if kept else Truth(failure="no certificate of it is kept: its witnesses disagree")
    if truth.failure and not spread.sequence:
        truth = _by_one_formulation(case, truth)
    motion = None if truth.failure else true_motion(case, truth.method)
    conditioning = sensitivity.conditioning(case, motion) if motion else Conditioning(nan, nan, nan)
    visible = _visible(truth, motion) if motion else truth
    return Scene(truth, visible, _sampled(motion) if motion else None, conditioning, spread)


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


def _without_truth(call: tuple, why: str) -> tuple[Run, Residuals]:
    """The row of a run that is not made because nothing is there to judge it by."""
    case, name, route, setting, rung = call
    reason = f"there is no truth to judge it by: {why}"
    return Run(case.label, name, route, setting, rung, "refused", reason), Residuals()


def _sampled(motion: Trajectory) -> Trajectory:
    """A motion at even times and at its transitions: all that runs are judged by, and small to send to each."""
    events = [event.time for event in motion.transitions]
    times = np.union1d(np.linspace(motion.t[0], motion.t[-1], _SAMPLES), events)
    return Trajectory(t=times, **motion(times)._asdict(), first_mode=motion.first_mode)


def _scene(answer: Answer) -> Scene:
    if answer.outcome == "done":
        return answer.value
    nothing = Truth(failure=answer.failure[1])
    return Scene(nothing, nothing, None, Conditioning(nan, nan, nan), Spread("", nan, nan))


def _unknown(case: Case, answer: Answer) -> tuple[Run, Residuals]:
    """The row of a case of which nothing could be found out."""
    return Run(case.label, REFERENCE, "", Setting.of(), 0, *answer.failure), Residuals()


def _plan(case: Case, name: str, offer: Offer, scene: Scene, full: bool):
    """Rows of what cannot be run, and the calls of what can."""
    if not offer.settings:
        outcome, reason = offer.outcome or "refused", offer.reason or "it offers no setting for this case"
        return [(Run(case.label, name, offer.route, Setting.of(), 0, outcome, reason), Residuals())], []
    chosen = offer.settings if full else offer.settings[1::2] if name == REFERENCE else _few(offer.settings)
    calls = [(case, name, offer.route, setting, rung) for rung, setting in enumerate(chosen, 1)]
    if scene.motion is None:
        return [_without_truth(call, scene.truth.failure) for call in calls], []
    # The reference is judged by all of the truth and by the true motion itself, which each worker has.
    known = (scene.truth,) if name == REFERENCE else (scene.visible, scene.motion)
    return [], [(*call, *known) for call in calls]


def _few(settings: Sequence[Setting]) -> list[Setting]:
    ladder = [s for s in settings if not s.is_default]
    return [*(s for s in settings if s.is_default), *(ladder[min(i, len(ladder) - 1)] for i in _RUNGS if ladder)]


def _middle(settings: Sequence[Setting]) -> Setting | None:
    ladder = [s for s in settings if not s.is_default]
    return ladder[len(ladder) // 2] if ladder else None


def assess(
    case: Case, name: str, route: str, setting: Setting, rung: int, truth: Truth, motion: Trajectory
) -> tuple[Run, Residuals]:
    """Run one setting, judge it by the true motion and examine it by itself."""
    own = Residuals()

    def verdict(row: Run, trajectory: Trajectory) -> Run:
        nonlocal own
        own = residuals.examine(case, trajectory)
        run = replace(judge(row, case, trajectory, motion, truth), samples={}, off={})
        off = run.distance.centre_max / residuals.motion_extent(case, motion)
        if run.outcome == "right" and off > RIGHT:
            run = replace(run, outcome="wrong", reason=f"its centre is off by {off:.2g} of the path")
        if run.outcome == "right" and truth.status == "paradox" and trajectory.status != "paradox":
            run = replace(run, reason="it goes on where rigid contact has no answer")
        return run

    return attempt(Run(case.label, name, route, setting, rung, outcome=""), case, verdict), own


def assess_own(case: Case, name: str, route: str, setting: Setting, rung: int, truth: Truth) -> tuple[Run, Residuals]:
    """The same of the reference."""
    return assess(case, name, route, setting, rung, truth, true_motion(case, truth.method))


def _assessed(answers: Sequence[Answer], calls: Sequence[tuple]) -> list[tuple[Run, Residuals]]:
    """The rows of the calls, those of what did not return among them."""
    pairs = zip(answers, calls, strict=True)
    return [a.value if a.outcome == "done" else (_failed(call, a), Residuals()) for a, call in pairs]


def _failed(call: tuple, answer: Answer) -> Run:
    case, name, route, setting, rung, *_ = call
    return Run(case.label, name, route, setting, rung, *answer.failure)


def _brackets(asked: Sequence[tuple], calls: Calls) -> tuple[step_limit.Bracket, ...]:
    """The step that blows up, of each route on some cases."""
    answers = calls.all("unstable steps", step_limit.bracket, asked, limit=step_limit.PATIENCE, keep=Keep())
    return tuple(
        answer.value if answer.outcome == "done" else step_limit.Bracket.unknown(case, name, route, answer.failure[1])
        for (case, name, route, _), answer in zip(asked, answers, strict=True)
    )


# --- rows -------------------------------------------------------------------------------------------------------------


def rows(found: Stability) -> list[dict[str, Any]]:
    """One row per run. `centre_error` is the largest distance from the truth over the path; `spread` what one unit in
    the last place of the inputs does to it; `condition` of (27) in the plate's own units, `condition_si` as it
    stands; `witnesses` how many ways of solving the truth rests on."""
    extents = {c.label: residuals.motion_extent(c, m) for c in found.cases if (m := found.scenes[c.label].motion)}
    told = []
    for run, own in found.runs:
        scene = found.scenes[run.case]
        outcome, reason = run.outcome, run.reason
        if scene.chaotic and (
            outcome in ("right", "wrong") or (outcome == "refused" and scene.motion is None and run.setting.keys())
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
                "first_transition_error": first_error(run),
                "centre_error": run.distance.centre_max / extents.get(run.case, nan),
                "energy": own.energy,
                "energy_drift": own.energy_drift,
                "gap": own.gap,
                "gap_drift": own.gap_drift,
                "tangency": own.tangency,
                "condition": _number(scene.conditioning.scaled),
                "condition_si": _number(scene.conditioning.largest),
                "condition_time": scene.conditioning.when,
                "spread": _number(scene.spread.centre),
                "spread_time": _number(scene.spread.time),
                "last_bit": scene.spread.sequence,
                "witnesses": len(scene.truth.witnesses),
            }
        )
    return told


def _number(value: float) -> float:
    """What is beyond all numbers has a word in another column, and none here."""
    return value if isfinite(value) else nan
