"""The figure of a report that is a file: the slip velocity of all engines in one scene."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from adapters.processes.worker import settle
from cases import Case

from ..drawing.figure_files import FigureEntry
from ..running.calls import Calls
from ..running.ladder_selection import PAPER_CASE
from ..running.records import Experiment, usable

# Wall-clock limit in seconds; drawing takes about 2 s, longer on a busy machine.
_PATIENCE = 300.0
HEADLINE = "headline"


def draw(experiment: Experiment, folder: Path, calls: Calls, paper: bool) -> list[FigureEntry]:
    """Write the headline to the folder, in a worker; `paper`: also as PDF. If it fails its entry has the reason: a
    failed picture must not discard hours of runs. No entry without a case that has a transition."""
    folder.mkdir(parents=True, exist_ok=True)
    case = headline_case(experiment)
    if case is None:
        return []
    runs = tuple(run for run in experiment.runs if run.case == case.label)
    sample = replace(experiment, cases=(case,), truths={case.label: experiment.truths[case.label]}, runs=runs)
    (answer,) = calls.all("figures", draw_headline, [(sample, folder, paper)], limit=_PATIENCE, group="")
    if answer.outcome == "done":
        return [answer.value]
    return [FigureEntry("", case.label, "Picture", f"It could not be drawn: {answer.failure[1]}")]


def headline_case(experiment: Experiment) -> Case | None:
    """The paper's application; without it, the case with transitions in which most routes have a usable motion (of
    these, the one with the most transitions); None if no case has a transition."""
    having = [case for case in experiment.cases if experiment.truths[case.label].transitions]
    if paper := [case for case in having if case.label == PAPER_CASE]:
        return paper[0]
    answering: dict[str, set[tuple[str, str]]] = {}
    for run in experiment.runs:
        if usable(run):
            answering.setdefault(run.case, set()).add((run.solver, run.route))

    def worth(case: Case) -> tuple[int, int]:
        return len(answering.get(case.label, ())), len(experiment.truths[case.label].transitions)

    return max(having, key=worth, default=None)


def draw_headline(experiment: Experiment, folder: Path, paper: bool) -> FigureEntry:
    """Write the headline of an experiment of one case, also as PNG; `paper`: also as PDF."""
    settle(HEADLINE)
    from cases.pictures.style import apply_style

    from ..drawing import figures, matplotlib_writer
    from ..drawing.figure_files import file_kinds, save

    (case,) = experiment.cases
    diagram = figures.headline(experiment, case)
    with apply_style():
        picture = matplotlib_writer.draw(diagram, figures.looks_of(experiment))
        return save(picture, folder, HEADLINE, case.label, diagram.title, diagram.caption, file_kinds(paper))
