"""`python -m reports.submit FOLDER`: check motions before submission, and judge them by the report's criteria.

Exit status: 0 if all of them could be judged, whatever their grades; 2, with one sentence, for the first that could
not.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Sequence
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING

from cases.files.user_files import place

from . import options

if TYPE_CHECKING:
    from .running.records import Run
    from .running.submissions import Submission


def judge_submission(folder: str | Path) -> tuple[Submission, list[Run]]:
    """Read a submission and judge its motions; returns both. Raises CaseError for a wrong format."""
    from .running import external_motions, submissions
    from .running.tasks import find_truth

    submission = submissions.read(place("folder", folder))
    motions = [submissions.motion(submission, label) for label in submission.files]
    return submission, [external_motions.judge_motion(external, 1, find_truth(external.case)) for external in motions]


def _text(submission: Submission, runs: Sequence[Run]) -> str:
    from tabulate import tabulate

    rows, pairings = [], ("paired", "missed", "spurious")
    for run in runs:
        counts = [sum(r.pairing == word for r in run.ledger) for word in pairings]
        off, doubt = (run.score.off, run.score.doubt) if run.score else (nan, nan)
        error = next((r.error for r in run.ledger if r.event == 1), nan)
        rows.append((run.case, run.outcome, run.grade, off, doubt, run.friction_factor, *counts, error))
    head = ("case", "outcome", "grade", "off", "± doubt", "friction ×", *pairings, "first transition's error / s")
    why = "".join(f"\n\n{run.case}: {run.reason}" for run in runs if run.reason)
    return f"{submission.name}, by {submission.words['who']}\n\n{tabulate(rows, head, floatfmt='.3g')}{why}"


@options.runs(
    "reports.submit", "Check and judge motions before you submit them.",
    words={"FOLDER": "submissions/ENGINE/VERSION, with submission.toml and a CASE.csv for each case"},
)  # fmt: skip
def main(arguments: Namespace, words: list[str]) -> None:
    """Judge the motions and print the result."""
    print(_text(*judge_submission(arguments.FOLDER)))


if __name__ == "__main__":
    sys.exit(main())
