"""Figures of the maps."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from ...drawing.figure_files import FigureEntry, save
from ...running.records import REFERENCE
from ...sweeping import maps
from ...sweeping.folder import Folder
from ...sweeping.run import ROWS
from .measure import MARKS, Map


def draw(findings: list[Map], folder: Path) -> Iterator[FigureEntry]:
    """Write the figures to the folder; yields their entries."""
    for each in findings:
        kind = ROWS if each.solver == REFERENCE else f"{each.solver}.{each.route}"
        with tempfile.TemporaryDirectory() as place:
            rows = Folder(Path(place))
            for start, content in each.parts.items():
                rows.add_part(kind, start, content)
            if each.solver == REFERENCE:
                figure = maps.of_reference(each.plan, rows, marks=MARKS)
                title = "Motion of the disc after its release, over friction and start"
                caption = (
                    f"{len(each.plan):,} motions. Thin lines: time at which the slip first ends, s, with R = 1 m, "
                    "r = 0.1 m; thick lines: boundaries between kinds of motion by (35). Dots: the paper's three "
                    "coefficients, with release at ξ₁ = 0."
                )
            else:
                title = f"{each.solver}, {each.route}: wrong verdicts with default settings, over friction and start"
                caption = f"{len(each.plan):,} runs with default settings. Left: verdicts. Right: errors of the time."
                figure = maps.of_engine(each.plan, rows, kind, f"{each.solver}, {each.route}")
            yield save(figure, folder, f"map_{kind.replace('.', '_')}", "", title, caption)
