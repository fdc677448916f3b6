"""`python -m reports.compare CASE FILE.csv`: judge a trajectory from a file, by the criteria of the report.

Columns of the file: `adapters.common.motion_table`. A folder with `submission.toml` has motions of several cases, a
line for each. Exit status: 0 if all could be judged, whatever their grades; 2, with one sentence, for the first that
could not. Of two folders it compares the reports: `compare_builds`, with --worse-than `gate`.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING

from cases import BadValue, DoesNotFit, lookup
from cases.files.user_files import existing, place

from . import compare_builds, gate, options

if TYPE_CHECKING:
    from cases import Case, Trajectory

    from .judging.law_error import LawError
    from .running.records import Run

COMMAND = "reports.compare"
# Note on the times of transitions.
SHOWN_DIGITS = (
    "Transitions are extrapolated between the samples (seen_at: the first sample after each, where it becomes visible "
    "at the end of a step)."
)


def compare(case: Case, path: str | Path, creep: float = 0.0) -> str:
    """Judge a file's motion; returns the result as text. `creep`: creep velocity of the solver while it sticks, m/s.

    Raises CaseError if the file cannot be judged or the reference has no truth.
    """
    from .running import external_motions
    from .running.tasks import find_truth

    try:
        external = external_motions.read(Path(path).name, case, Path(path), creep=creep)
    except DoesNotFit as problem:
        raise DoesNotFit("; ".join([str(problem), *_probable_mistakes(case, path)])) from problem
    run = external_motions.judge_motion(external, 1, find_truth(case))
    if run.score is None:
        raise DoesNotFit(run.reason)
    return _text(case, external.motion, run)


def _probable_mistakes(case: Case, path: str | Path) -> list[str]:
    """What is probably wrong with a file that is no motion of the case; empty if there is no truth to compare with."""
    from adapters.common import motion_table

    from .judging.diagnosis import mistakes
    from .running.tasks import find_truth
    from .running.true_motions import true_motion

    columns, truth = motion_table.columns_of(motion_table.read(path)), find_truth(case)
    return [] if truth.failure else mistakes(case, columns, true_motion(case, truth.method))


def _text(case: Case, motion: Trajectory, run: Run) -> str:
    from tabulate import tabulate

    from adapters.common.motion_file import least_gap
    from cases.motion.mechanics import energy

    from .judging import grades
    from .judging.residuals import broken_laws, energy_growth

    ledger = [
        (r.event, str(r.before), str(r.after), r.time, r.reference_time, r.error, _time_text(motion, r.time), r.pairing)
        for r in run.ledger
    ]
    head = ("event", "before", "after", "time", "reference_time", "error", "seen_at", "pairing")
    # Of a difference of two times fewer digits are certain than of the times.
    digits = (".9g", ".9g", ".9g", ".9g", ".9g", ".7g", ".9g", ".9g")
    distance = [(name, value) for name, value in run.distance._asdict().items()]
    total = energy(case, motion)
    energies = [
        ("energy at the start (J)", total[0]),
        ("energy at the end (J)", total[-1]),
        ("largest growth (J)", energy_growth(case, motion)),
    ]
    violations = broken_laws(case, motion, least_gap(case, motion))
    assert run.score is not None, "a motion that is judged has a score"
    return "\n\n".join(
        (
            f"{run.solver} on {case.label}: {grades.summary(run.score, run.friction_factor, run.reason)}",
            "Transitions (s)\n" + (tabulate(ledger, head, floatfmt=digits) if ledger else "none, as in the truth"),
            "Distance from the reference (m, rad, m/s)\n" + tabulate(distance, floatfmt=".3g"),
            "Energy\n" + tabulate(energies, floatfmt=".6g"),
            _law_text(run.law),
            "Laws broken\n" + ("\n".join(violations) if violations else "none"),
            _creep_text(run.score.creep, motion.slip_resolution),
            SHOWN_DIGITS,
        )
    )


def submission(folder: Path) -> str:
    """The judgement of the motions in a folder as text; raises CaseError for the first that cannot be judged."""
    from tabulate import tabulate

    from .running import submissions

    motions, runs = submissions.judge_all(folder)
    rows, pairings = [], ("paired", "missed", "spurious")
    for run in runs:
        counts = [sum(r.pairing == word for r in run.ledger) for word in pairings]
        off, doubt = (run.score.off, run.score.doubt) if run.score else (nan, nan)
        error = next((r.error for r in run.ledger if r.event == 1), nan)
        rows.append((run.case, run.outcome, run.grade, off, doubt, run.friction_factor, *counts, error))
    head = ("case", "outcome", "grade", "off", "± doubt", "friction ×", *pairings, "first transition's error / s")
    why = "".join(f"\n\n{run.case}: {run.reason}" for run in runs if run.reason)
    return f"{motions.name}, by {motions.words['who']}\n\n{tabulate(rows, head, floatfmt='.3g')}{why}"


def _law_text(error: LawError) -> str:
    """The error of the law of friction in slip, from the file's samples alone."""
    if not isfinite(error.median):
        return "Friction force in slip: not known (no slip, several contacts, or a moving track)."
    most = f"90 % of the steps within {error.upper:.2g}, most at t = {error.time:.3g} s"
    return f"Friction force in slip: off by {error.median:.2g} of μN (median; {most})."


def _creep_text(creep: float, declared: float) -> str:
    """The creep of a motion, as measured and as declared."""
    measured = f"{creep:.2g} m/s" if isfinite(creep) else "not known, since the truth does not roll"
    return f"Creep where the truth rolls: {measured} (declared: {declared:.2g} m/s)."


def _time_text(motion: Trajectory, time: float) -> float:
    """The time of the first sample at or after `time`; NaN if there is none."""
    place = int(motion.t.searchsorted(time))
    return float(motion.t[place]) if place < len(motion.t) else float("nan")


@options.runs(
    COMMAND, "Judge an exported trajectory, or compare two reports: all differences, or with --worse-than whether the "
    "second is worse (exit status 1; 3 if that is not decided).",
    "case_file", "creep", "solver", "worse_than", "format",
    words={
        "CASE": f"{options.A_CASE}; or the folder of a report, or, alone, of motions with their submission.toml",
        "FILE*": "comma-separated values with the columns t, x, y, theta; or the folder of another report",
    },
    example=f"python -m {COMMAND} old report --worse-than 10% --solver exudyn --format junit > worse.xml",
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> int:
    """Print the judgement of a file or a folder of motions, or the comparison of two reports; returns the exit
    status."""
    if not arguments.FILE:
        if not Path(arguments.CASE).is_dir():
            raise BadValue(f"{arguments.CASE!r} is no folder of motions; give a case and a FILE, or such a folder")
        print(submission(place("folder", arguments.CASE)))
        return 0
    if len(arguments.FILE) > 1:
        raise BadValue(f"give one file, not {len(arguments.FILE)}")
    (file,) = arguments.FILE
    if Path(arguments.CASE).is_dir() and Path(file).is_dir():
        one, other = place("report", arguments.CASE), place("report", file)
        if arguments.worse_than is not None:
            return gate.show(one, other, arguments)
        return compare_builds.show(one, other, arguments.solver or ())
    if arguments.solver or arguments.worse_than is not None:
        raise BadValue("--solver and --worse-than are for the folders of two reports; leave them out")
    options.load_files(arguments.case_file)
    case = lookup.case_name(arguments.CASE).one()
    print(compare(case, existing("file", file), options.creep_of(arguments.creep)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
