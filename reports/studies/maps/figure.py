"""The maps as pictures."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from ...drawing.files import Drawn, save
from ...running.records import REFERENCE
from ...sweeping import maps
from ...sweeping.folder import Folder
from ...sweeping.run import ROWS
from .measure import MARKS, Map


def draw(found: list[Map], folder: Path) -> Iterator[Drawn]:
    """Write the pictures into the folder; yields what was written."""
    for each in found:
        kind = ROWS if each.solver == REFERENCE else f"{each.solver}.{each.route}"
        with tempfile.TemporaryDirectory() as place:
            rows = Folder(Path(place))
            for start, content in each.parts.items():
                rows.put(kind, start, content)
            if each.solver == REFERENCE:
                figure = maps.of_reference(each.plan, rows, marks=MARKS)
                title = "What follows when the disc is let go, over friction and start"
                caption = (
                    f"{len(each.plan):,} motions. Thin lines: when the slip first ends, s, with R = 1 m, r = 0.1 m; "
                    "thick ones: where (35) says that what follows changes. Dots: the paper's three coefficients, let "
                    "go at ξ₁ = 0."
                )
            else:
                title = f"{each.solver}, {each.route}: wrong verdicts as it comes, over friction and start"
                caption = f"{len(each.plan):,} runs at its default setting: left what follows, right when."
                figure = maps.of_engine(each.plan, rows, kind, f"{each.solver}, {each.route}")
            yield save(figure, folder, f"map_{kind.replace('.', '_')}", "", title, caption)
