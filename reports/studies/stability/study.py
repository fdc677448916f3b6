"""The atlas of hard scenes: outcome and grade of each solver.

Each run also has the residuals that need no truth (energy, gap, tangency, their drifts). A scene of the catalogue has
constants, which no engine changes and which `constants.csv` holds: the condition number of the paper's matrix (27)
along the motion, and the effect of one unit in the last place of the inputs: if that unit decides the outcome, solvers
are not ranked on the scene.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from math import inf, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import cases
import reference
from adapters import Setting
from adapters.processes.worker import CallResult
from cases import Case, Mode, Trajectory
from reference import certification

from ...analysis.columns import Table, words
from ...judging import residuals
from ...judging.grades import LIMITS, Grade, percent
from ...running.calls import Calls, StorePolicy
from ...running.experiment import run_cases
from ...running.ladder_selection import default_and
from ...running.names import REFERENCE
from ...running.records import TRUTH_RTOL, Run, Truth, first_error, one_default
from ...running.tasks import find_truth, in_catalogue, truth_of
from ...running.true_motions import true_motion
from .. import Request

TITLE = "Hard scenes"
QUESTION = (
    "Scenes that are hard for solvers, and the outcome of each. One variant of each family; a full report has all. "
    "Chaotic: one unit in the last place of the inputs decides the outcome, so solvers are not ranked."
)
TAKES = ("case", "solver")
TAB = "errors"
IN_REPORT = True
TABLES = {
    "stability": Table(
        "Hard scenes, solver by solver: outcome, residuals, conditioning",
        words("case", "solver", "route", "setting")
        | words(outcome="answered, unsupported, crashed, timed_out, or chaotic: the last bit of the inputs decides")
        | words("grade", "off", "off_doubt", "reason")
        | words(
            first_transition_error="error of the first transition's time, s",
            centre_error="largest distance of the centre from the truth over its path",
            energy="largest residual of the energy balance over the energy of the motion",
            energy_drift="its slope, 1/s",
            gap="largest distance of the two contact points (5) over the plate's size",
            gap_drift="its slope, m/s",
            tangency="largest sine between the tangents at the contact point (6)",
            condition="largest condition number of the matrix of (27), in the plate's own units; empty: singular",
            condition_si="the same in SI units",
            condition_time="time of `condition`, s",
            spread="change of the centre over its path by one unit in the last place of the inputs; or `last_bit`",
            spread_time="change of the time of a transition by that unit, s",
            last_bit="change of the sequence of modes by that unit; empty: none",
            witnesses="number of independent solutions behind the truth",
        ),
    ),
}
# The constants of the catalogue's hard scenes (`python -m tests.benchmarks.hard_scenes` writes it, in a clone).
CONSTANTS = Path(__file__).with_name("constants.csv")
# A slip below this fraction of the motion's speed is rounding for a reading of samples (`slip_phases.ROUNDING`).
NEGLIGIBLE_SLIP = 1e-9
# One unit in the last place may move the centre by at most this fraction of its path: beyond it, engines closer to the
# truth than that displacement would be ranked by noise.
CHAOTIC = 1e-6
# Wall-clock limits of a run in seconds; deriving the equations of the hardest outlines alone takes a fraction of a
# minute. On the machine used to choose the limit, no run of a default report takes between 4 and 30 s, so outcomes are
# the same on other machines.
_LIMIT, _FULL_LIMIT, _DERIVING = 6.0, 600.0, 120.0
# Rungs of a route's ladder that a default report runs in addition to the default settings: the third, the finest with
# which two workers complete all scenes in half a minute.
_RUNGS = (2,)

_NUMBERS = ("condition", "condition_si", "condition_time", "spread", "spread_time")
SLIPS = (Mode.SLIP_FORWARD, Mode.SLIP_BACKWARD)


class HardScene(NamedTuple):
    """The data of a case before any engine runs.

    `visible`: the truth without slips that a reading of samples cannot distinguish from rounding; engines are compared
    with it.
    """

    truth: Truth
    visible: Truth


@cache
def _stored_constants() -> dict[str, dict[str, str]]:
    with open(CONSTANTS, newline="", encoding="utf-8") as file:
        return {row["case"]: row for row in csv.DictReader(file)}


def constants(case: Case) -> dict[str, Any]:
    """The constants of a scene of the catalogue: `last_bit`, "" if that unit does not change the sequence of modes, and
    numbers; NaN where they are not known, as of all other scenes."""
    own: Mapping[str, str] = _stored_constants().get(case.label, {}) if in_catalogue(case) else {}
    numbers = {name: float(own.get(name) or nan) for name in _NUMBERS}
    return numbers | {"last_bit": own.get("last_bit", "")}


def chaotic(case: Case) -> str:
    """The reason why solvers are not ranked on a scene, or ""."""
    own = constants(case)
    if own["last_bit"]:
        return f"one unit in the last place decides: {own['last_bit']}"
    if own["spread"] > CHAOTIC:
        return f"one unit in the last place moves the centre by {own['spread']:.1e} of its path"
    return ""


@dataclass(frozen=True)
class Stability:
    """The findings of the study: scenes by case label, and the runs."""

    cases: tuple[Case, ...]
    scenes: dict[str, HardScene]
    runs: tuple[Run, ...]


# --- running ----------------------------------------------------------------------------------------------------------


def atlas(full: bool) -> tuple[Case, ...]:
    """The hard cases of the catalogue: the last variant of each family; if `full`, all, including those of minutes."""
    families = [cases.select(name, long=full) for name in cases.names(hard=True)]
    return tuple(case for family in families for case in (family if full else family[-1:]))


def run(request: Request, calls: Calls) -> Stability:
    """Run the requested cases, or the atlas, through the solvers; every failure is a row."""
    full, solvers = request.full, request.solvers
    case_list = request.cases or atlas(full)
    limit = _FULL_LIMIT if full else _LIMIT
    # In reverse, because the tightest fit, which is near the end of the atlas, takes longest.
    requests = [(case,) for case in case_list[::-1]]
    answers = calls.all("scenes", scene_of, requests, limit=limit + _DERIVING, keep=StorePolicy())[::-1]
    scenes = {case.label: _scene(answer) for case, answer in zip(case_list, answers, strict=True)}
    failures = {c.label: a.failure for c, a in zip(case_list, answers, strict=True) if a.outcome != "done"}
    runs = [Run(label, REFERENCE, "", Setting.of(), 0, *failure) for label, failure in failures.items()]
    own = [case for case in case_list if case.label not in failures]
    # Engines: the longest first, because a long one at the end would run alone.
    in_turn = sorted(case_list, key=lambda case: -case.duration)
    engines = [name for name in solvers if name != REFERENCE]
    # The reference is compared with the complete truth.
    for step, its_cases, names, seconds in (
        ("reference", own, [name for name in solvers if name == REFERENCE], limit + _DERIVING),
        ("engines", in_turn, engines, limit),
    ):
        is_own = step == "reference"
        truths = {label: scene.truth if is_own else scene.visible for label, scene in scenes.items()}
        runs += run_cases(
            its_cases, names, calls, partial(_rungs, full), truths=truths, is_hard=True, limit=seconds, step=step
        ).runs
    place = {case.label: i for i, case in enumerate(case_list)}
    runs.sort(key=lambda run: (place[run.case], run.solver != REFERENCE, run.solver, run.route, run.rung))
    return Stability(tuple(case_list), scenes, tuple(runs))


def _rungs(full: bool, case: str, solver: str, route: str, settings: tuple[Setting, ...]) -> tuple[Setting, ...]:
    """The settings to run: of the reference every second one, of an engine its default settings and one."""
    if full:
        return tuple(one_default(settings))
    if solver == REFERENCE:
        return settings[1::2]
    return default_and(settings, *_RUNGS)


def scene_of(case: Case) -> HardScene:
    """A case's truth, and what of it a reading of samples can distinguish."""
    # A hard case of the catalogue without a stored certificate cannot be certified: its witnesses' sequences differ, or
    # one of them stops, sometimes after minutes.
    has_truth = not in_catalogue(case) or case.label in certification.read()
    truth = find_truth(case) if has_truth else Truth(failure="it has no certificate: its witnesses disagree")
    if truth.failure and not constants(case)["last_bit"]:
        truth = _by_one_formulation(case, truth)
    return HardScene(truth, truth if truth.failure else _visible(truth, true_motion(case, truth.method)))


def _visible(truth: Truth, motion: Trajectory) -> Truth:
    """The truth without phases of slip that never exceed a billionth of the motion's speed."""
    edges = [float(motion.t[0]), *(t.time for t in truth.transitions), float(motion.t[-1])]
    negligible = NEGLIGIBLE_SLIP * float(np.max(np.hypot(motion.vx, motion.vy)))
    assert truth.first_mode is not None, "a motion has a first mode"
    modes = [truth.first_mode, *(t.after for t in truth.transitions)]
    for i, mode in enumerate(modes):
        # A truth computed from several motions may end later than this one by a rounding error.
        sample_times = np.clip(np.linspace(edges[i], edges[i + 1], 21), motion.t[0], motion.t[-1])
        slips = np.abs(np.asarray(motion(sample_times).slip))
        if mode in SLIPS and slips.max() <= negligible:
            modes[i] = Mode.ROLL
    visible_indices = [i for i in range(1, len(modes)) if modes[i] != modes[i - 1]]
    return replace(
        truth,
        first_mode=modes[0],
        transitions=tuple(
            replace(truth.transitions[i - 1], before=modes[i - 1], after=modes[i]) for i in visible_indices
        ),
        error_bars=tuple(truth.error_bars[i - 1] for i in visible_indices),
    )


def _by_one_formulation(case: Case, failed_truth: Truth) -> Truth:
    """The truth by the first formulation alone, if its methods agree; otherwise `failed_truth`."""
    methods = (*reference.METHODS, *(("taylor_quadruple",) if "taylor" in reference.METHODS else ()))
    motions = [reference.simulate(case, rtol=TRUTH_RTOL, method=method) for method in methods]
    centre = motions[0]
    kinds = [(t.before, t.after) for t in centre.transitions]
    if any(m.status != centre.status or [(t.before, t.after) for t in m.transitions] != kinds for m in motions):
        return failed_truth
    bars = tuple(
        max(abs(t.time - same[0].time) for t in same) + float(np.spacing(same[0].time))
        for same in zip(*(m.transitions for m in motions), strict=True)
    )
    truth = truth_of(case, centre, centre.transitions, methods[0])
    return replace(truth, error_bars=bars, witnesses=tuple(f"{method} {TRUTH_RTOL:g}" for method in methods))


def _scene(answer: CallResult) -> HardScene:
    if answer.outcome == "done":
        return answer.value
    nothing = Truth(failure=answer.failure[1])
    return HardScene(nothing, nothing)


# --- rows -------------------------------------------------------------------------------------------------------------


def rows(stability: Stability) -> dict[str, list[dict[str, Any]]]:
    """The table: one row per run; no table if nothing was run.

    `centre_error`: largest distance from the truth over the path; `witnesses`: number of independent solutions behind
    the truth.
    """
    if not stability.cases:
        return {}
    extents = {
        c.label: residuals.motion_extent(c, truth.samples["x"], truth.samples["y"])
        for c in stability.cases
        if (truth := stability.scenes[c.label].truth).samples
    }
    table_rows, by_label = [], {case.label: case for case in stability.cases}
    for run in stability.runs:
        scene, case = stability.scenes[run.case], by_label[run.case]
        outcome, reason = run.outcome, run.reason
        lacks_truth = outcome == "unsupported" and scene.truth.failure and not run.refusal
        if (why := chaotic(case)) and (outcome == "answered" or lacks_truth):
            outcome, reason = "chaotic", why
        elif outcome == "answered" and scene.truth.status == "paradox" != run.status:
            reason = f"{reason}; it continues although rigid contact has no solution there"
        table_rows.append(
            {
                "case": run.case,
                "solver": run.solver,
                "route": run.route,
                "setting": run.setting,
                "outcome": outcome,
                "grade": "" if outcome == "chaotic" else str(run.grade),
                "off": run.score.off if run.score else nan,
                "off_doubt": run.score.doubt if run.score else nan,
                "reason": reason,
                "first_transition_error": first_error(run),
                "centre_error": run.distance.centre_max / extents.get(run.case, nan),
                **run.residuals._asdict(),
                **constants(case),
                "witnesses": len(scene.truth.witnesses),
            }
        )
    return {"stability": table_rows}


def in_words(stability: Stability) -> dict[str, str]:
    """Three sentences for each scene, the hardest for engines first: what it is, what makes it hard, and what the
    solvers did at their finest setting."""
    last = {(run.case, run.solver, run.route): run for run in stability.runs}
    texts: dict[str, tuple[float, str]] = {}
    for case in stability.cases:
        entry = cases.entry(case.name) if case.name in cases.names() else None
        runs = [run for (label, solver, _), run in last.items() if label == case.label and solver != REFERENCE]
        about = f"{entry.summary} Hard: {entry.hard}; known: {entry.outcome}. " if entry and entry.hard else ""
        seen = chaotic(case) or "; ".join(map(_seen, runs)) or "no engine ran"
        worst = max((run.score.off for run in runs if run.score), default=inf)
        texts[case.label] = -worst, f"{about.replace('`', '')}Seen: {seen}."
    return {label: text for label, (_, text) in sorted(texts.items(), key=lambda item: item[1][0])}


def _seen(run: Run) -> str:
    """What an engine did with a scene, and why."""
    name = f"{run.solver} {run.route}".strip()
    if run.score is None:
        return f"{name}: {run.outcome.replace('_', ' ')}"
    why = f" ({run.reason})" if run.reason and run.score.off > LIMITS[Grade.GOOD] else ""
    return f"{name} {percent(run.score.off)} off{why}"


def summary(stability: Stability) -> str:
    """The scenes in words, for the terminal."""
    return "\n".join(f"{label}: {text}" for label, text in in_words(stability).items())
