"""All figures of a report, drawn in parallel workers: of cases, of timings, of studies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..analysis.work_precision import CostMeasurements
from ..drawing import case_figures
from ..drawing.figure_files import FigureContent, FigureEntry, for_print, writes_pdf
from ..running.calls import Calls
from ..running.processes.worker_process import settle
from ..running.records import Experiment
from ..studies import Result, study
from ..studies import draw as draw_study

# Wall-clock limit in seconds for the figures of one study or of all timings. The latter take about 6 s, longer on a
# busy machine.
_PATIENCE = 300.0
_TIMINGS = ""


def draw(
    experiment: Experiment,
    ran: Experiment,
    measurements: CostMeasurements,
    results: Sequence[Result],
    folder: Path,
    calls: Calls,
) -> tuple[list[FigureEntry], dict[str, list[FigureEntry]]]:
    """Write every figure to the folder; returns those of cases and timings, and those of each study by name."""
    figures = list(case_figures.draw(experiment, folder, calls))
    # The longest first. These figures do not show samples of motions, so the samples are not sent to the workers.
    bare = replace(ran, runs=tuple(replace(run, samples={}, off={}) for run in ran.runs))
    requests: list[tuple] = [(_TIMINGS, writes_pdf(), bare, measurements)] if measurements.cases else []
    requests += [(result.name, writes_pdf(), result.findings) for result in results if not result.failure]
    by_study: dict[str, list[FigureEntry]] = {result.name: [] for result in results}
    answers = calls.all("other figures", draw_figures, requests, limit=_PATIENCE, group="")
    for (name, *_), answer in zip(requests, answers, strict=True):
        if answer.outcome == "done":
            by_study[name] = [picture.write(folder) for picture in answer.value]
        else:
            by_study[name] = [FigureEntry("", "", "Pictures", f"They could not be drawn: {answer.failure[1]}")]
    return figures + by_study.pop(_TIMINGS, []), by_study


def draw_figures(name: str, paper: bool, *inputs: Any) -> list[FigureContent]:
    """Draw the figures of a study from its result, or of the timings, in a worker with an empty folder.

    `paper`: also as PDF. If the results of a solver make a figure fail, it is drawn without them.
    """
    folder = Path.cwd()
    if name == _TIMINGS:
        from ..drawing import work_precision_figure

        settle(__name__)
        draw: Callable[..., Iterable[FigureEntry]] = work_precision_figure.draw
    else:
        draw = study(name).draw
        settle(name)
    with for_print(paper):
        return [FigureContent.read(figure, folder) for figure in draw_study(name or "timings", draw, inputs, folder)]
