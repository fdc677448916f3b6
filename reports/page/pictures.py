"""All figures of a report, drawn in parallel workers: the headline, timings, studies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cases import Case

from ..analysis.work_precision import CostMeasurements
from ..drawing.figure_files import FigureEntry, for_print, writes_pdf
from ..running.calls import Calls
from ..running.ladder_selection import PAPER_CASE
from ..running.processes.worker_process import settle
from ..running.records import Experiment, usable
from ..studies import Result, study

# Wall-clock limit in seconds for the figures of one study or of all timings. The latter take about 6 s, longer on a
# busy machine.
_PATIENCE = 300.0
_HEADLINE, _TIMINGS = "headline", "timings"


def draw(
    experiment: Experiment,
    ran: Experiment,
    measurements: CostMeasurements,
    results: Sequence[Result],
    folder: Path,
    calls: Calls,
) -> tuple[list[FigureEntry], dict[str, list[FigureEntry]]]:
    """Write every figure to the folder; returns the headline and those of timings, and those of each study by name.

    Figures that fail have one entry with the reason, so that a failed picture does not discard hours of runs."""
    folder.mkdir(parents=True, exist_ok=True)
    inputs: dict[str, tuple] = {}
    if main := headline_case(experiment):
        inputs[_HEADLINE] = main, _without_samples(experiment, but=main.label)
    inputs |= {_TIMINGS: (_without_samples(ran), measurements)} if measurements.cases else {}
    inputs |= {result.name: (result.findings,) for result in results if not result.failure}
    requests = [(name, folder, writes_pdf(), *records) for name, records in inputs.items()]
    answers = calls.all("figures", draw_figures, requests, limit=_PATIENCE, group="")
    entries = {
        name: answer.value
        if answer.outcome == "done"
        else [FigureEntry("", "", "Pictures", f"They could not be drawn: {answer.failure[1]}")]
        for name, answer in zip(inputs, answers, strict=True)
    }
    by_study = {result.name: entries.get(result.name, []) for result in results}
    return [*entries.get(_HEADLINE, []), *entries.get(_TIMINGS, [])], by_study


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


def _without_samples(experiment: Experiment, but: str = "") -> Experiment:
    """The experiment without the samples that a figure does not show, so that they are not sent to the worker; `but`:
    the case whose samples stay."""
    runs = (run if run.case == but else replace(run, samples={}, off={}) for run in experiment.runs)
    return replace(experiment, runs=tuple(runs))


def draw_figures(name: str, folder: Path, paper: bool, *inputs: Any) -> list[FigureEntry]:
    """Write the headline, figures of timings, or those of a study, in a worker; `paper`: also as PDF."""
    settle(name)
    function: Callable[..., Iterable[FigureEntry]]
    if name == _HEADLINE:
        from ..drawing.figures import draw_headline as function
    elif name == _TIMINGS:
        from ..drawing.work_precision_figure import draw as function
    else:
        function = study(name).draw
    with for_print(paper):
        return list(function(*inputs, folder))
