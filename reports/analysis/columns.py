"""The dictionary of columns: meaning and unit of each name in the tables of a report. One name has one meaning, which a
test checks. (A study describes its own columns.)"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isinf
from typing import TYPE_CHECKING, NamedTuple

from ..running.solvers import is_missing

if TYPE_CHECKING:
    import pandas as pd


class Table(NamedTuple):
    """The description of a table: its content, and the meaning of each column."""

    holds: str
    columns: Mapping[str, str] = {}


# The quantities of a motion; they are columns of one table, and words in others.
_QUANTITIES = {
    "first_transition_time": ("time of the first transition", "s"),
    "all_transitions": ("largest error of the times of all transitions", "s"),
    "final_pose": ("root-mean-square distance of the plate's points at the last sample", "m"),
    "centre_rms": ("root-mean-square distance of the centre of mass", "m"),
    "normal_force_mean": ("mean error of the normal force over the true force's mean; empty: not reported", "1"),
    "energy_mean": ("mean error of the mechanical energy over the largest true kinetic energy", "1"),
}
_OF_QUANTITY = "in the unit of the quantity"

# Name: meaning and unit ("" for words, counts and truth values).
COLUMNS: dict[str, tuple[str, str]] = {
    # keys
    "case": ("the case, with its parameters", ""),
    "solver": ("the reference, an engine, or the name of an external trajectory", ""),
    "version": ("version of the solver; empty: unknown", ""),
    "route": ("how the solver is used: native, assisted, a method of the reference, a file, a submission", ""),
    "setting": ("parameters of one rung of the ladder; rung=defaults: the engine's default settings", ""),
    "motion": ("a motion that ignores friction's law", ""),
    "quantity": ("the quantity of an error: off, " + ", ".join(_QUANTITIES), ""),
    "unit": ("unit of the quantity's errors", ""),
    # outcomes
    "outcome": ("answered, unsupported, crashed or timed_out", ""),
    "reason": ("why an answered run has its grade, or why there is no answer", ""),
    "refusal": ("of an unsupported case: the engine's documented limit, or that its adapter does not do it yet", ""),
    "status": ("completed, or why the motion ended early", ""),
    "first_mode": ("the mode in which the motion begins", ""),
    "transitions_true": ("number of transitions of the truth", ""),
    "paired": ("number of transitions of the truth that the run has", ""),
    "missed": ("number of transitions of the truth that the run does not have", ""),
    "spurious": ("number of transitions of the run that the truth does not have", ""),
    "event": ("number of the transition in the truth, from 1; of a spurious one in the run; 0: none", ""),
    "before": ("mode before the transition", ""),
    "after": ("mode after it", ""),
    "time": ("its time", "s"),
    "reference_time": ("its true time", "s"),
    "error": ("solver minus truth, with its sign", "s"),
    "truth_error_bar": ("error bar of the transition's true time (in a row of a route: of the first transition)", "s"),
    "reading_doubt": ("change of the time if it is read from other samples; empty: the solver located it", "s"),
    "pairing": ("paired (in truth and run), missed, spurious, or unresolved (the samples are too coarse)", ""),
    "contact": ("name of the contact in a motion with several contacts; empty: the only one", ""),
    "swing": ("largest turn of the plate after the impact and before the next one; empty: no such impact", "rad"),
    "reference_swing": ("that of the truth", "rad"),
    "closing_speed": ("speed along the track's normal before the impact; empty: no such impact", "m/s"),
    "reference_closing_speed": ("that of the truth", "m/s"),
    "restitution": ("speed with which the plate leaves over the closing speed; 0: it stays", "1"),
    "reference_restitution": ("that of the truth", "1"),
    "normal": ("impulse along the track's normal; empty: no such impact, or not known", "N s"),
    "reference_normal": ("that of the truth", "N s"),
    "friction": ("impulse along the track's tangent; empty: not known, or not unique", "N s"),
    "reference_friction": ("that of the truth; empty: not unique", "N s"),
    "work": ("work of both impulses", "J"),
    "reference_work": ("that of the truth", "J"),
    "certificate": ("proved: a theorem encloses the transition inside its error bar; else witnessed", ""),
    "method": ("the reference's method behind the truth", ""),
    "notes": ("its witnesses, or why there is no truth", ""),
    "run_at": ("time of the run, UTC", ""),
    "steps": ("number of steps of the solver", ""),
    # scores: shares of the error of ignoring friction's law
    "off": ("error as a share of the error of ignoring friction's law: the largest of the three scores", "1"),
    "off_doubt": ("how much of off may be due to the samples of the motion", "1"),
    "pose_score": ("root-mean-square pose error over that of the nearest null motion", "1"),
    "mode_score": ("time in another mode than the truth, over the time outside the truth's longest mode", "1"),
    "slip_score": ("mean error of the slip velocity over that of the nearest null motion", "1"),
    "creep": ("slip velocity where the truth rolls; empty: it does not roll", "m/s"),
    "mu_equivalent": ("error of friction that makes as large an off; empty: hardly any does", "1"),
    "friction_factor": ("friction and other losses over those of the law; empty: not known", "1"),
    "law_error": ("median error of the friction force in slip over μN, of the motion's samples alone; empty: not known",
                  "1"),
    "law_error_at": ("time at which it is largest", "s"),
    "grade": ("the score in words: excellent to unusable, or not decided by its samples; empty: no answer", ""),
    "sequence": ("how the sequence of modes agrees with the truth's", ""),
    "friction_sensitivity": ("off that 1 % more or less friction makes, the larger one", "1"),
    "friction_share": ("pose error of the nearest null motion over the path of the truth; empty: no motion", "1"),
    "not_ranked": ("why the case does not rank engines; empty: it does", ""),
    # the verdict: of each route, over the cases that measure friction
    "our_part": ("what of the route is this project's code; empty: the engine by itself", ""),
    "friction_cases": ("number of cases that measure friction: those whose not_ranked is empty", ""),
    "answered": ("number of them in which the route gave a motion", ""),
    "unsupported": ("number of them that the route does not support", ""),
    "crashed": ("number of them in which it crashed", ""),
    "timed_out": ("number of them in which it exceeded the time limit", ""),
    "default_off_best": ("the smallest off with default settings: usual values of step, facets, stiffness", "1"),
    "default_off_worst": ("the largest off with default settings", "1"),
    "default_settings": ("number of default settings run: combinations of usual values", ""),
    "finest_off_worst": ("the largest off at the finest setting run", "1"),
    "median_grade": ("the grade of the median off at the finest setting run", ""),
    **{f"{name}_cases": (f"number of them in which the ladder stays within {share} off from a setting on", "")
       for name, share in (("good", "1 %"), ("excellent", "0.01 %"))},
    **{f"{name}_one_setting": (f"number of `{name}_cases` that only the finest setting reaches, unconfirmed", "")
       for name in ("good", "excellent")},
    "worst_friction_factor": ("the friction × farthest from 1, with default settings or at the finest", "1"),
    "common_cases": ("number of them that all engines by themselves answer (of two: that both do)", ""),
    "common_default_off": ("median off over the common cases with default settings; empty: not all answered", "1"),
    "common_finest_off": ("median off over the common cases at the finest setting run; empty: not all answered", "1"),
    "other_solver": ("the other engine of two", ""),
    "other_route": ("its route", ""),
    "other_default_off": ("its default_off", "1"),
    "other_finest_off": ("its finest_off", "1"),
    "nearer": ("number of common cases in which the engine is nearer at the finest, by more than the doubts", ""),
    "other_nearer": ("number of them in which the other one is nearer", ""),
    "undecided": ("number of them in which the doubts leave it open", ""),
    "cost_case": ("the case of the two costs: the first timed one that depends on friction; empty: none was timed", ""),
    "good_first_s": ("CPU time of the first run within 1 % off in that case, with a cold start; empty: not timed", "s"),
    "good_thousand_s": ("CPU time of 1,000 runs within 1 % off in that case, the first with a cold start", "s"),
    # distances from the truth
    "centre_max": ("largest distance of the centre of mass", "m"),
    "angle_max": ("largest difference of the angle", "rad"),
    "angle_rms": ("root-mean-square difference of the angle", "rad"),
    "slip_max": ("largest difference of the slip velocity", "m/s"),
    "slip_rms": ("root-mean-square difference of the slip velocity", "m/s"),
    **_QUANTITIES,
    # the headline
    # With default settings all but off and its doubt are those of the first setting of the grid.
    **{f"{name}_{column}": (f"{meaning} {where}", unit)
       for name, where in (("default", "with default settings"), ("finest", "at the finest setting run"))
       for column, meaning, unit in (
           ("off", "median off", "1"), ("off_doubt", "largest doubt of off", "1"), ("grade", "grade of off", ""),
           ("friction_factor", "friction and other losses over those of the law", "1"),
           ("first_error", "error of the first transition's time, signed,", "s"),
           ("centre_max", "largest distance of the centre", "m"))},
    "default_outcome": ("outcome with default settings; empty: the route has no such setting", ""),
    "finest_outcome": ("outcome at the finest setting that gave a motion", ""),
    "finest_setting": ("that setting", ""),
    "is_truth": ("whether that run is the truth itself, so that it has no error", ""),
    # levels
    "level": ("a level of off: 0.1, 0.01, 0.001 or 1e-4; in the headline the smallest that the ladder reaches", "1"),
    "reached": ("reached; one setting (only the finest, unconfirmed); not reached; not known (by the doubt); "
                "of timings also not timed (the budget did not suffice) and disturbed (not ranked)", ""),
    "settings_within": ("number of settings, from this one to the finest, that stay within the level", ""),
    # orders
    "order": ("p of error ~ steps^-p", "1"),
    "order_low": ("lower end of its 95 % interval", "1"),
    "order_high": ("upper end", "1"),
    "order_in_time": ("p of error ~ (CPU time)^-p", "1"),
    "order_in_time_low": ("lower end of its 95 % interval", "1"),
    "order_in_time_high": ("upper end", "1"),
    "finest_error": ("size of the error at the finest setting run", _OF_QUANTITY),
    "settings": ("number of settings of the ladder with a motion (of the orders: with a usable one)", ""),
    "settings_used": ("the settings of the fit", ""),
    "note": ("why there is no number, or its range", ""),
    "saturation": ("why the finest rungs do not improve: truth, reading, rounding, model; empty: they do", ""),
    "saturated_from": ("the setting from which on they do not", ""),
    "saturated_error": ("the error there", _OF_QUANTITY),
    # work and precision
    "cpu_s": ("CPU time of the run; in trajectories next to other runs, else the median of quiet repeats", "s"),
    "cpu_low_s": ("lower end of the interval of the median in another process", "s"),
    "cpu_high_s": ("upper end", "s"),
    "wall_s": ("wall time of the run, median", "s"),
    "setup_s": ("building, warm (in trajectories: wall time of building and reading)", "s"),
    "compile_s": ("additional time of the first building in the process; what settings share is the first one's", "s"),
    "read_s": ("CPU time of reading the motion back, with its samples, warm", "s"),
    "call_s": ("CPU time of a whole warm call: building, running, reading", "s"),
    "first_call_s": ("CPU time of a whole call with a cold start: first building (nothing compiled), running and "
                     "reading in a process, without imports; empty: not measured", "s"),
    "engine_s": ("part of cpu_s of the engine's compiled code; with its binding if binding_s is empty", "s"),
    "binding_s": ("part of cpu_s of the engine's Python package and conversions", "s"),
    "callback_s": ("part of cpu_s of our code that the engine calls (of the reference: its Python)", "s"),
    "notes_s": ("part of cpu_s of our loop and its recording; empty: counted with the callback", "s"),
    "repeats": ("number of repeats of the medians", ""),
    "disturbed_repeats": ("number of repeats left out because of other load", ""),
    "disturbed": ("whether too few repeats were left, so that the row is not ranked", ""),
    "absolute_error": ("size of the error", _OF_QUANTITY),
    "doubt": ("how much of it may be due to the samples", _OF_QUANTITY),
    "floor_error": ("ten times the truth's error bar: smaller errors are not known", _OF_QUANTITY),
    "below_floor": ("whether the error is smaller", ""),
    "null_error": ("the smallest error of a motion that ignores friction's law", _OF_QUANTITY),
    "null_motion": ("that motion", ""),
    "ratio": ("CPU time over the fastest route's", "1"),
    "ratio_low": ("the smallest ratio that both intervals allow", "1"),
    "ratio_high": ("the largest", "1"),
    "rank": ("1 + the number of routes that are significantly faster; equal ranks cannot be distinguished", ""),
    "break_even_runs": ("number of whole calls from which on the reference is cheaper; empty: never, or not known", ""),
    # the fastest engine
    "runs": ("number of whole calls in sequence, the first with a cold start", ""),
    "engine": ("the engine and route that takes least time for them", ""),
    "engine_setting": ("its setting", ""),
    "engine_total_s": ("its time", "s"),
    "reference": ("the reference's method that takes least time", ""),
    "reference_setting": ("its setting", ""),
    "reference_total_s": ("its time", "s"),
    "engine_alone_s": ("time of the engine's compiled code, without cold start, binding, callback and recording", "s"),
    "cheaper": ("the faster of the two; tie: by less than a tenth; empty: one of the two has no time (`reason`)", ""),
    "factor": ("the slower one's time over the faster one's", "1"),
}  # fmt: skip


def with_version(frame: pd.DataFrame, versions: Mapping[str, str]) -> pd.DataFrame:
    """A table with a column `version` after that of the solver, if it has one; empty for an unknown version."""
    if "solver" not in frame.columns or "version" in frame.columns:
        return frame
    description = frame.copy()
    column = ["" if is_missing(said := versions.get(name, "")) else said for name in frame["solver"]]
    description.insert(list(frame.columns).index("solver") + 1, "version", column)
    return description


def with_version_words(table: Table, frame: pd.DataFrame) -> Table:
    """The description of a table with that of the column added by `with_version`."""
    if "version" not in frame.columns or "version" in table.columns:
        return table
    return table._replace(columns={**table.columns, "version": description("version")})


def words(*names: str, **own: str) -> dict[str, str]:
    """The dictionary's words for columns of a study, then its own; raises KeyError for a column that has none."""
    return {name: description(name) for name in names} | own


def describe_column(holds: str, names: Iterable[str]) -> Table:
    """A table with the dictionary's words for its columns; raises KeyError for a column that has none."""
    return Table(holds, words(*names))


def description(name: str) -> str:
    """Meaning and unit of a column in one phrase."""
    meaning, unit = COLUMNS[name]
    if not unit or unit == "1":
        return meaning
    return f"{meaning} ({unit})"


# Shares that are read in percent; the files have them as they are.
_IN_PERCENT = ("level", "pose_score", "mode_score", "slip_score", "law_error", "friction_sensitivity", "friction_share")


def is_in_percent(name: str) -> bool:
    """Whether a column is a share that readers get in percent: off and its doubts, levels and scores."""
    return name in COLUMNS and unit_of(name) == "1" and (name in _IN_PERCENT or "off" in name.split("_"))


def unit_of(name: str) -> str:
    """The unit of a column, "" where it has none of its own."""
    return COLUMNS[name][1] if name in COLUMNS else ""


def infinite(frame: pd.DataFrame) -> list[str]:
    """The columns of a table with an infinite number, which no result may be: a word is needed instead."""
    return [str(c) for c in frame.columns if any(isinstance(v, float) and isinf(v) for v in frame[c])]
