"""`slip-to-roll compare CASE FILE.csv`: judge a trajectory from a file, by the criteria of the report.

Columns of the file: `adapters.common.motion_table`. A folder with `submission.toml` has motions of several cases, a
line for each. Exit status: 0 if all could be judged, whatever their grades; 2, with one sentence, for the first that
could not. Of two folders it compares the reports: `compare_builds`, with --worse-than `gate`.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases import BadValue, DoesNotFit, lookup
from cases.files.user_files import existing, place

from . import compare_builds, gate, options

if TYPE_CHECKING:
    from cases import Case, Trajectory

    from .running.records import Run

COMMAND = "reports.compare"
# Note on the times of transitions.
SHOWN_DIGITS = (
    "Transitions are extrapolated between the samples (seen_at: the first sample after each, where it becomes visible "
    "at the end of a step)."
)


# The impulses of the impacts: those of the truth, and of the file from its velocities before and after them.
IMPACTS = "Impacts (s, N s, J; the file's next to them, from its samples; nan without velocities)"
IMPACT_COLUMNS = (
    "contact", "reference_time", "reference_normal", "normal", "reference_friction", "friction", "reference_work",
    "work",
)  # fmt: skip
# Impacts that are listed; the text gives the number of the others.
MOST_IMPACTS = 12


def compare(case: Case, path: str | Path, creep: float = 0.0) -> str:
    """Judge a file's motion; returns the result as text. `creep`: creep velocity of the solver while it sticks, m/s.

    Raises CaseError if the file cannot be judged or the reference has no truth.
    """
    return _text(judgement(case, path, creep))


def judgement(case: Case, path: str | Path, creep: float = 0.0) -> dict[str, Any]:
    """The judgement of a file's motion as numbers and texts in SI units, of which `compare` makes its text."""
    from .running import external_motions
    from .running.tasks import find_truth

    try:
        external = external_motions.read(Path(path).name, case, Path(path), creep=creep)
    except DoesNotFit as problem:
        raise DoesNotFit("; ".join([str(problem), *_probable_mistakes(case, path)])) from problem
    run = external_motions.judge_motion(external, 1, find_truth(case))
    if run.score is None:
        raise DoesNotFit(run.reason)
    return _facts(case, external.motion, run)


def _probable_mistakes(case: Case, path: str | Path) -> list[str]:
    """What is probably wrong with a file that is no motion of the case; empty if there is no truth to compare with."""
    from adapters.common import motion_table

    from .judging.diagnosis import mistakes
    from .running.tasks import find_truth
    from .running.true_motions import true_motion

    columns, truth = motion_table.columns_of(motion_table.read(path)), find_truth(case)
    return [] if truth.failure else mistakes(case, columns, true_motion(case, truth.method))


def _facts(case: Case, motion: Trajectory, run: Run) -> dict[str, Any]:
    from adapters.common.motion_file import least_gap
    from cases.motion.mechanics import energy

    from .judging import grades
    from .judging.residuals import broken_laws, energy_growth

    assert run.score is not None, "a motion that is judged has a score"
    total = energy(case, motion)
    return {
        "case": case.label,
        "file": run.solver,
        "summary": grades.summary(run.score, run.friction_factor, run.reason),
        "grade": run.grade,
        "off": run.score.off,
        "off_doubt": run.score.doubt,
        "friction_factor": run.friction_factor,
        "reason": run.reason,
        "transitions": [
            {
                "event": r.event,
                "before": str(r.before),
                "after": str(r.after),
                "contact": r.contact,
                "time": r.time,
                "reference_time": r.reference_time,
                "error": r.error,
                "seen_at": _time_of_sample(motion, r.time),
                "pairing": r.pairing,
            }
            for r in run.ledger
        ],
        "impacts": [row._asdict() for row in run.impulses],
        "distance": run.distance._asdict(),
        "energy": {
            "at the start (J)": float(total[0]),
            "at the end (J)": float(total[-1]),
            "largest growth (J)": float(energy_growth(case, motion)),
        },
        "law_error": run.law._asdict(),
        "laws_broken": [*broken_laws(case, motion, least_gap(case, motion))],
        "creep": run.score.creep,
        "creep_declared": motion.slip_resolution,
    }


def _text(facts: dict[str, Any]) -> str:
    from tabulate import tabulate

    # Of a difference of two times fewer digits are certain than of the times.
    digits = (".9g", ".9g", ".9g", ".9g", ".9g", ".7g", ".9g", ".9g")
    head = ("event", "before", "after", "time", "reference_time", "error", "seen_at", "pairing")
    ledger = [[row[name] for name in head] for row in facts["transitions"]]
    few = [[row[name] for name in IMPACT_COLUMNS] for row in facts["impacts"][:MOST_IMPACTS]]
    impacts = tabulate(few, IMPACT_COLUMNS, floatfmt=("", ".9g", *6 * (".4g",)), missingval="nan")
    more = len(facts["impacts"]) - len(few)
    energies = [(f"energy {name}", value) for name, value in facts["energy"].items()]
    return "\n\n".join(
        (
            f"{facts['file']} on {facts['case']}: {facts['summary']}",
            "Transitions (s)\n" + (tabulate(ledger, head, floatfmt=digits) if ledger else "none, as in the truth"),
            *([f"{IMPACTS}\n{impacts}" + (f"\n… and {more} more; --json has all" if more else "")] if few else []),
            "Distance from the reference (m, rad, m/s)\n" + tabulate([*facts["distance"].items()], floatfmt=".3g"),
            "Energy\n" + tabulate(energies, floatfmt=".6g"),
            _law_text(**facts["law_error"]),
            "Laws broken\n" + ("\n".join(facts["laws_broken"]) or "none"),
            _creep_text(facts["creep"], facts["creep_declared"]),
            SHOWN_DIGITS,
        )
    )


def submission(folder: Path) -> dict[str, Any]:
    """The judgement of the motions in a folder; raises CaseError for the first that cannot be judged."""
    from .running import submissions

    motions, runs = submissions.judge_all(folder)
    rows = []
    for run in runs:
        off, doubt = (run.score.off, run.score.doubt) if run.score else (nan, nan)
        rows.append(
            {
                "case": run.case,
                "outcome": run.outcome,
                "grade": run.grade,
                "off": off,
                "± doubt": doubt,
                "friction ×": run.friction_factor,
                **{word: sum(r.pairing == word for r in run.ledger) for word in ("paired", "missed", "spurious")},
                "first transition's error / s": next((r.error for r in run.ledger if r.event == 1), nan),
                "reason": run.reason,
            }
        )
    return {"name": motions.name, "who": motions.words["who"], "motions": rows}


def _submission_text(facts: dict[str, Any]) -> str:
    from tabulate import tabulate

    rows = [{name: value for name, value in row.items() if name != "reason"} for row in facts["motions"]]
    why = "".join(f"\n\n{row['case']}: {row['reason']}" for row in facts["motions"] if row["reason"])
    return f"{facts['name']}, by {facts['who']}\n\n{tabulate(rows, headers='keys', floatfmt='.3g')}{why}"


def _law_text(median: float, upper: float, time: float) -> str:
    """The error of the law of friction in slip, from the file's samples alone."""
    if not isfinite(median):
        return "Friction force in slip: not known (no slip, several contacts, or a moving track)."
    most = f"90 % of the steps within {upper:.2g}, most at t = {time:.3g} s"
    return f"Friction force in slip: off by {median:.2g} of μN (median; {most})."


def _creep_text(creep: float, declared: float) -> str:
    """The creep of a motion, as measured and as declared."""
    measured = f"{creep:.2g} m/s" if isfinite(creep) else "not known, since the truth does not roll"
    return f"Creep where the truth rolls: {measured} (declared: {declared:.2g} m/s)."


def _time_of_sample(motion: Trajectory, time: float) -> float:
    """The time of the first sample at or after `time`; NaN if there is none."""
    place = int(motion.t.searchsorted(time))
    return float(motion.t[place]) if place < len(motion.t) else float("nan")


@options.runs(
    COMMAND, "Judge an exported trajectory, or compare two reports: all differences, or with --worse-than whether the "
    "second is worse (exit status 1; 3 if that is not decided).",
    "case_file", "creep", "solver", "worse_than", "format", "json",
    words={
        "CASE": f"{options.A_CASE}; or the folder of a report, or, alone, of motions with their submission.toml",
        "FILE*": "comma-separated values with the columns t, x, y, theta; or the folder of another report",
    },
    example=f"python -m {COMMAND} old report --worse-than 10% --solver exudyn --format junit > worse.xml",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> int:
    """Print the judgement of a file or a folder of motions, or the comparison of two reports; returns the exit
    status."""
    if arguments.json:
        arguments.format = "json"
    if not arguments.FILE:
        if not Path(arguments.CASE).is_dir():
            raise BadValue(f"{arguments.CASE!r} is no folder of motions; give a case and a FILE, or such a folder")
        return _print(arguments, submission(place("folder", arguments.CASE)), _submission_text)
    if len(arguments.FILE) > 1:
        raise BadValue(f"give one file, not {len(arguments.FILE)}")
    (file,) = arguments.FILE
    if Path(arguments.CASE).is_dir() and Path(file).is_dir():
        one, other = place("report", arguments.CASE), place("report", file)
        if arguments.worse_than is not None:
            return gate.show(one, other, arguments)
        return compare_builds.show(one, other, arguments)
    if arguments.solver or arguments.worse_than is not None:
        raise BadValue("--solver and --worse-than are for the folders of two reports; leave them out")
    options.load_files(arguments.case_file)
    case = lookup.case_name(arguments.CASE).one()
    return _print(arguments, judgement(case, existing("file", file), options.creep_of(arguments.creep)), _text)


def _print(arguments: Namespace, facts: dict[str, Any], as_text: Callable[[dict[str, Any]], str]) -> int:
    """Print facts as JSON, or as text."""
    print(options.json_of(facts) if options.is_json(arguments) else as_text(facts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
