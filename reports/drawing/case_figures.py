"""The figures of all cases: drawn in workers and cached like runs, so that none is drawn twice."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from cases import Case

from ..running.calls import Calls, StorePolicy
from ..running.processes.worker_process import settle
from ..running.records import Experiment, usable
from ..running.storage.fingerprint import installed_packages
from .figure_files import FigureContent, FigureEntry, for_print, writes_pdf

# Wall-clock limit in seconds for one case's figures: they take about 1 s, and much longer only on a busy machine.
_PATIENCE = 120.0
# Failures are not cached, so a figure that failed is drawn again.
_KEEP = StorePolicy("figure", of=lambda *call: (*call, installed_packages("matplotlib")), failures=False)
# The paper's application.
PAPER = "disc_in_circle[mu=0.2]"


def draw(experiment: Experiment, folder: Path, calls: Calls) -> Iterator[FigureEntry]:
    """Write every figure to the folder; yields the entries of the figures, case by case.

    A case whose figures fail has one `FigureEntry` with the reason, so that a failed picture does not discard hours of
    runs.
    """
    folder.mkdir(parents=True, exist_ok=True)
    routes, main = tuple(dict.fromkeys((r.solver, r.route) for r in experiment.runs)), headline_case(experiment)
    drawable = [case for case in experiment.cases if not experiment.truths[case.label].failure]
    requests = [(case, _part(experiment, case.label), routes, case is main, writes_pdf()) for case in drawable]
    answers = calls.all("figures", draw_case, requests, limit=_PATIENCE, keep=_KEEP, group="")
    for case, answer in zip(drawable, answers, strict=True):
        if answer.outcome == "done":
            yield from (picture.write(folder) for picture in answer.value)
        else:
            yield FigureEntry("", case.label, "Figures", f"They could not be drawn: {answer.failure[1]}")


def draw_case(
    case: Case, part: Experiment, routes: tuple[tuple[str, str], ...], main: bool, paper: bool
) -> list[FigureContent]:
    """Draw the figures of one case in a worker; `routes` of all cases, which determine the line styles; `paper`: also
    as PDF."""
    from . import figures
    from .palette import LineStyles

    settle(__name__)
    with for_print(paper):
        return figures.draw_case(case, part, LineStyles(routes), main)


def _part(experiment: Experiment, label: str) -> Experiment:
    """The data for one case's figures, without anything that differs from build to build."""
    runs = tuple(run for run in experiment.runs if run.case == label)
    return Experiment((), {label: experiment.truths[label]}, runs, 0.0)


def headline_case(experiment: Experiment) -> Case | None:
    """The paper's application; without it, the case with transitions in which most routes have a usable motion (of
    these, the one with the most transitions); None if no case has a transition."""
    having = [case for case in experiment.cases if experiment.truths[case.label].transitions]
    if paper := [case for case in having if case.label == PAPER]:
        return paper[0]
    answering: dict[str, set[tuple[str, str]]] = {}
    for run in experiment.runs:
        if usable(run):
            answering.setdefault(run.case, set()).add((run.solver, run.route))

    def worth(case: Case) -> tuple[int, int]:
        return len(answering.get(case.label, ())), len(experiment.truths[case.label].transitions)

    return max(having, key=worth, default=None)
