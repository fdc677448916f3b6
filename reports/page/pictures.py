"""All pictures of a report, drawn in workers beside each other: of cases, of what accuracy costs, of studies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..analysis.work_precision import Measured
from ..drawing import of_cases
from ..drawing.files import Drawn, Picture, for_print, printed
from ..running.calls import Calls
from ..running.records import Experiment
from ..running.serving import settle
from ..studies import Result, study
from ..studies import draw as written

# Wall seconds for the pictures of one study or of all timings: the latter take some six, and longer on a busy machine.
_PATIENCE = 300.0
_TIMINGS = ""


def draw(
    shown: Experiment, ran: Experiment, measured: Measured, studied: Sequence[Result], folder: Path, calls: Calls
) -> tuple[list[Drawn], dict[str, list[Drawn]]]:
    """Write every picture into the folder: what was written of cases and timings, and of each study by its name."""
    drawn = list(of_cases.draw(shown, folder, calls))
    # The longest first. Samples of motions are not drawn there, and need not travel.
    bare = replace(ran, runs=tuple(replace(run, samples={}, off={}) for run in ran.runs))
    asked: list[tuple] = [(_TIMINGS, printed(), bare, measured)] if measured.cases else []
    asked += [(result.name, printed(), result.found) for result in studied if not result.failure]
    written: dict[str, list[Drawn]] = {result.name: [] for result in studied}
    for (name, *_), answer in zip(asked, calls.all("other figures", drawn_of, asked, limit=_PATIENCE), strict=True):
        if answer.outcome == "done":
            written[name] = [picture.write(folder) for picture in answer.value]
        else:
            written[name] = [Drawn("", "", "Pictures", f"They could not be drawn: {answer.failure[1]}")]
    return drawn + written.pop(_TIMINGS, []), written


def drawn_of(name: str, paper: bool, *made_from: Any) -> list[Picture]:
    """In a worker, whose folder is empty: the pictures of a study from what it found, or of the timings;
    `paper`: also as PDF. Where they fail with the results of a solver, they are drawn without them."""
    folder = Path.cwd()
    if name == _TIMINGS:
        from ..drawing import work_precision

        settle(__name__)
        draw: Callable[..., Iterable[Drawn]] = work_precision.draw
    else:
        draw = study(name).draw
        settle(name)
    with for_print(paper):
        return [Picture.read(one, folder) for one in written(name or "timings", draw, made_from, folder)]
