"""The dictionary of columns: what each name means in every table of the comparison, and in which unit. One name, one
meaning; a test holds the files to it. (A study says what its own columns mean.)"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isinf
from typing import TYPE_CHECKING, NamedTuple

from ..running.solvers import is_missing

if TYPE_CHECKING:
    import pandas as pd


class Table(NamedTuple):
    """What is said of a table: what it holds, and what its columns mean."""

    holds: str
    columns: Mapping[str, str] = {}


# The quantities a motion is asked for stand in columns of their own in one table, and as words in others.
_QUANTITIES = {
    "first_transition_time": ("the time of the first transition", "s"),
    "all_transitions": ("the worst of the times of all transitions", "s"),
    "final_pose": ("root-mean-square distance of the plate's points at the last sample", "m"),
    "centre_rms": ("root-mean-square distance of the centre of mass", "m"),
    "normal_force_mean": ("mean difference of the normal force over the true force's mean; empty: none is told", "1"),
    "energy_mean": ("mean difference of the mechanical energy over the largest true kinetic energy", "1"),
}
_OF_QUANTITY = "in the unit of the quantity"

# Name: meaning and unit ("" for words, counts and truth values).
COLUMNS: dict[str, tuple[str, str]] = {
    # who and what
    "case": ("the case, with its parameters", ""),
    "solver": ("the reference, an engine, or who a trajectory came from", ""),
    "version": ("what the solver says of its version; empty: nothing", ""),
    "route": ("how the solver is used: native, assisted, a method of the reference, a file, a submission", ""),
    "setting": ("the knobs of one rung of the ladder; rung=defaults is the engine as it comes", ""),
    "motion": ("a motion that knows nothing of friction's law", ""),
    "quantity": ("what an error is of: " + ", ".join(_QUANTITIES), ""),
    "unit": ("the unit of the quantity's errors and accuracies", ""),
    "lead": ("whether the case is led by this quantity, which chance cannot meet: all transitions where there are "
             "several, else the final pose", ""),
    "item": ("the table or figure that was made without the solver's results", ""),
    # what came of it
    "outcome": ("right, wrong, refused, crashed or timed_out", ""),
    "reason": ("why it is not right, or why there is no answer", ""),
    "status": ("completed, or what ended the motion early", ""),
    "first_mode": ("the mode the motion begins in", ""),
    "transitions_true": ("how many transitions the truth has", ""),
    "matched": ("how many of them the run has", ""),
    "missed": ("how many it does not have", ""),
    "spurious": ("how many it has that the truth has not", ""),
    "event": ("number of the transition in the truth, from 1; of a spurious one where it would stand; 0: none", ""),
    "before": ("mode before the transition", ""),
    "after": ("mode after it", ""),
    "time": ("when it happens", "s"),
    "reference_time": ("when it truly happens", "s"),
    "error": ("solver minus truth, with its sign", "s"),
    "truth_error_bar": ("how sure the truth is of the transition's time (in a row of a route: of the first)", "s"),
    "reading_doubt": ("how far the time moves when it is read from other samples; empty: the solver located it", "s"),
    "verdict": ("matched, missed, unresolved or spurious", ""),
    "method": ("the reference's method behind the truth", ""),
    "notes": ("its witnesses, or why there is no truth", ""),
    "run_at": ("when it was run, UTC", ""),
    "steps": ("steps the solver took", ""),
    # scores: shares of the error of ignoring friction's law
    "off": ("error as a share of the error of ignoring friction's law: the largest of the three scores", "1"),
    "off_doubt": ("how much of off may be due to the samples of the motion", "1"),
    "pose_score": ("root-mean-square pose error over that of the nearest null motion", "1"),
    "mode_score": ("time in another mode than the truth, over the time outside the truth's longest mode", "1"),
    "slip_score": ("mean error of the slip velocity over that of the nearest null motion", "1"),
    "creep": ("slip velocity where the truth rolls; empty: it does not roll", "m/s"),
    "friction_factor": ("friction and other losses over those of the law; empty: not known", "1"),
    "grade": ("the score in words: excellent, very good, good, rough, poor, unusable", ""),
    "grade_reason": ("why the motion has its grade", ""),
    "sequence": ("how the sequence of modes agrees with the truth's", ""),
    "friction_sensitivity": ("off that 1 % more or less friction makes, the larger one", "1"),
    # the verdict: of each route, over the cases where 1 % of friction makes an off of 1e-5 at least
    "digits_rank": ("1 + the routes with more digits by more than a tie; empty: partly this project's, or no case", ""),
    "our_part": ("what of the route is this project's code; empty: the engine by itself", ""),
    "friction_cases": ("how many cases depend on friction's law: 1 % of friction makes an off of 1e-5 at least", ""),
    "answered": ("in how many of them the route gave a motion", ""),
    "unsupported": ("how many of them it does not support", ""),
    "crashed": ("in how many of them it crashed", ""),
    "timed_out": ("in how many of them it ran out of time", ""),
    "default_off": ("off with default settings, median of the cases answered; empty: no such setting", "1"),
    "default_off_worst": ("the largest off with default settings", "1"),
    "finest_off": ("off at the finest setting run, median of the cases answered", "1"),
    "finest_off_worst": ("the largest off at the finest setting run", "1"),
    "median_grade": ("the grade of that median", ""),
    "good_cases": ("in how many cases off is at most 0.01 at the finest setting run", ""),
    "worst_friction_factor": ("the friction × farthest from 1, with default settings or at the finest", "1"),
    "digits": ("-log10 of off within -1 and 4 at the finest setting run, mean of all cases; not answered: 0", "1"),
    "digits_doubt": ("how much of the digits may be due to the samples", "1"),
    # distances from the truth
    "centre_max": ("largest distance of the centre of mass", "m"),
    "angle_max": ("largest difference of the angle", "rad"),
    "angle_rms": ("root-mean-square difference of the angle", "rad"),
    "slip_max": ("largest difference of the slip velocity", "m/s"),
    "slip_rms": ("root-mean-square difference of the slip velocity", "m/s"),
    **_QUANTITIES,
    # the headline
    "lead_quantity": ("the quantity that leads the case (`lead`)", ""),
    "reached": ("the finest of 0.01, 1e-4, …, 1e-12 that the ladder reached in it: its finest rung, doubt included, "
                "stays within; empty: none, or the finest motion is wrong", _OF_QUANTITY),
    "lead_error_bar": ("how sure the truth is of it", _OF_QUANTITY),
    "default_lead_error": ("size of its error, the engine as it comes", _OF_QUANTITY),
    "finest_lead_error": ("size of its error at the finest setting", _OF_QUANTITY),
    "default_first_error": ("error of the first transition's time, signed, the engine as it comes", "s"),
    "finest_first_error": ("error of the first transition's time, signed, at the finest setting", "s"),
    "default_centre_max": ("largest distance of the centre, the engine as it comes", "m"),
    "finest_centre_max": ("largest distance of the centre at the finest setting", "m"),
    "default_outcome": ("outcome of the engine as it comes; empty: the route has no such setting", ""),
    "finest_outcome": ("outcome at the finest setting that gave a motion", ""),
    "finest_setting": ("that setting", ""),
    "is_truth": ("whether that run is the truth itself, so that it has no error", ""),
    # orders
    "order": ("p of error ~ steps^-p", "1"),
    "order_low": ("where its 95 % interval begins", "1"),
    "order_high": ("where it ends", "1"),
    "order_in_time": ("p of error ~ (CPU time)^-p", "1"),
    "order_in_time_low": ("where its 95 % interval begins", "1"),
    "order_in_time_high": ("where it ends", "1"),
    "finest_error": ("error at the finest setting; of times with its sign", _OF_QUANTITY),
    "settings": ("how many right settings there are", ""),
    "settings_used": ("those the order is fitted to", ""),
    "note": ("why there is no number, or what it holds for", ""),
    "saturation": ("why the finest rungs no longer improve: truth, reading, rounding, model; empty: they do", ""),
    "saturated_from": ("the setting from which on they do not", ""),
    "saturated_error": ("the error there", _OF_QUANTITY),
    # work and precision
    "cpu_s": ("CPU time of the run; in trajectories beside other runs, else the median of quiet repeats", "s"),
    "cpu_low_s": ("where the median of another process is expected to begin", "s"),
    "cpu_high_s": ("where it is expected to end", "s"),
    "wall_s": ("wall time of the run, median", "s"),
    "setup_s": ("building, warm (in trajectories: wall time of building and reading)", "s"),
    "compile_s": ("what the first building of the process took more; what settings share is the first one's", "s"),
    "read_s": ("CPU time of reading the motion back, with its samples, warm", "s"),
    "call_s": ("CPU time of a whole warm call: building, running, reading", "s"),
    "first_call_s": ("CPU time of a whole call from cold: first building (nothing compiled), running and reading in a "
                     "process, beyond imports; empty: not measured", "s"),
    "engine_s": ("of cpu_s the engine's compiled code; with its binding where binding_s is empty", "s"),
    "binding_s": ("of cpu_s the engine's Python package and conversions", "s"),
    "callback_s": ("of cpu_s our code that the engine calls back (of the reference: its Python)", "s"),
    "notes_s": ("of cpu_s our loop and its notes; empty: counted with the callback", "s"),
    "repeats": ("how many repeats the medians are of", ""),
    "disturbed_repeats": ("how many repeats were thrown away because the machine was busy", ""),
    "disturbed": ("whether too few were left, so that the row ranks nothing", ""),
    "absolute_error": ("size of the error", _OF_QUANTITY),
    "doubt": ("how sure the reading of the transitions from samples is", _OF_QUANTITY),
    "standing_error": ("largest error, doubt included, of this setting and all finer ones: what it may be trusted "
                       "with; empty: a finer motion is wrong", _OF_QUANTITY),
    "finer_rungs": ("how many finer settings there are to confirm it; 0: it is the finest, and nothing does", ""),
    "floor_error": ("ten times the truth's error bar: below it no error is told", _OF_QUANTITY),
    "below_floor": ("whether the error is below that", ""),
    "null_error": ("the best that a motion scores which knows nothing of friction's law", _OF_QUANTITY),
    "null_motion": ("which motion that is", ""),
    "accuracy": ("what is asked for", _OF_QUANTITY),
    "award": ("reached; or by chance (a setting is as accurate, and a finer one or the doubt contradicts it), never "
              "(no setting is), not timed, not known (the truth is not that sure), disturbed", ""),
    "ratio": ("CPU time over the fastest route's", "1"),
    "ratio_low": ("the least ratio that both intervals allow", "1"),
    "ratio_high": ("the greatest", "1"),
    "rank": ("how many routes are faster for sure, and one; equal ranks cannot be told apart", ""),
    "null_reaches": ("whether a motion that knows nothing of friction's law is as accurate", ""),
    "break_even_runs": ("from how many whole calls on the reference is cheaper; empty: never, or not known", ""),
    # answers
    "runs": ("how many whole calls one after the other, the first from cold", ""),
    "engine": ("the engine and route that takes least time for them", ""),
    "engine_setting": ("its setting", ""),
    "engine_total_s": ("what they take", "s"),
    "reference": ("the reference's method that takes least time", ""),
    "reference_setting": ("its setting", ""),
    "reference_total_s": ("what it takes", "s"),
    "engine_alone_s": ("the engine's compiled code alone, without cold start, binding, callback and notes", "s"),
    "cheaper": ("who is; alike: by less than a tenth; empty: one of the two has no time (`reason`)", ""),
    "factor": ("the dearer one's time over the cheaper one's", "1"),
    # the answer table
    "cases": ("how many cases it was asked", ""),
    "right": ("in how many its finest setting is right", ""),
    "wrong": ("in how many it is wrong", ""),
    "refused": ("in how many it refuses the case", ""),
    "failed": ("in how many it crashes or runs out of time", ""),
    "middle_default_error": ("size of the first transition's error, the engine as it comes, median of the cases", "s"),
    "middle_finest_error": ("the same at the finest setting, without motions that are the truth itself", "s"),
    **{f"hard_{word}": (f"of the hard scenes: how many {said}", "") for word, said in (
        ("right", "it gets right"), ("wrong", "it gets wrong"), ("refused", "it refuses"), ("failed", "it fails in"))},
    "rolling_cases": ("how many of its cases roll", ""),
    **{f"reached_1e_{n}": (f"in how many of these it reaches 1e-{n} in the quantity that leads the case", "")
       for n in (2, 4)},
    "cost_case": ("the case of the costs beside it: the first of the timed ones that rolls", ""),
    **{f"award_1e_{n}": (f"`award` of 1e-{n} there", "") for n in (2, 4)},
    **{f"once_1e_{n}_s": (f"one whole call from cold to 1e-{n} there; empty: not reached or not timed", "s")
       for n in (2, 4)},
    **{f"thousand_1e_{n}_s": (f"a thousand calls, the first from cold, to 1e-{n} there; the same", "s")
       for n in (2, 4)},
    # errata
    "where": ("where in the paper", ""),
    "printed": ("as printed", ""),
    "corrected": ("as it must be", ""),
    "printed_residual": ("residual of the formula as printed, relative", "1"),
    "corrected_residual": ("residual of the corrected formula, relative", "1"),
    "finding": ("what is wrong with it", ""),
    "claim": ("what the paper says of it", ""),
}  # fmt: skip


def with_version(frame: pd.DataFrame, versions: Mapping[str, str]) -> pd.DataFrame:
    """A table with a column `version` beside that of the solver, if it has one; empty for what told none."""
    if "solver" not in frame.columns or "version" in frame.columns:
        return frame
    description = frame.copy()
    column = ["" if is_missing(said := versions.get(name, "")) else said for name in frame["solver"]]
    description.insert(list(frame.columns).index("solver") + 1, "version", column)
    return description


def with_version_words(table: Table, frame: pd.DataFrame) -> Table:
    """What is said of a table, and of the column that `with_version` gave it."""
    if "version" not in frame.columns or "version" in table.columns:
        return table
    return table._replace(columns={**table.columns, "version": description("version")})


def describe_column(holds: str, names: Iterable[str]) -> Table:
    """A table with the dictionary's words for its columns; raises KeyError for a column that has none."""
    return Table(holds, {name: description(name) for name in names})


def description(name: str) -> str:
    """Meaning and unit of a column in one phrase."""
    meaning, unit = COLUMNS[name]
    if not unit or unit == "1":
        return meaning
    return f"{meaning} ({unit})"


def unit_of(name: str) -> str:
    """The unit of a column, "" where it has none of its own."""
    return COLUMNS[name][1] if name in COLUMNS else ""


def infinite(frame: pd.DataFrame) -> list[str]:
    """The columns of a table with a number that is infinite: no result is; a word says what is meant."""
    return [str(c) for c in frame.columns if any(isinstance(v, float) and isinf(v) for v in frame[c])]
