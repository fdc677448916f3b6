"""The drift of each formulation, its error, and what it costs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import pyplot as plt

from ...drawing.files import Drawn, save
from ...drawing.style import STYLE, logarithmic, ordinal
from .measure import FORMULATIONS

_WORDS = (
    "Which coordinates to integrate",
    "The paper's ten coordinates without stabilisation, with Baumgarte's terms and with projection after each step, "
    "and the two independent ones with their rates; one integrator, one matrix. Left: the gap that opens. Middle: the "
    "error of the centre. Right: error against evaluations of (27). An unbalanced ellipse in an ellipse; above it "
    "slips with friction until its first transition, below it slides without friction for five seconds.",
)


def draw(told: list[dict[str, Any]], folder: Path) -> Iterator[Drawn]:
    """Write the picture into the folder; yields what was written."""
    names = list(dict.fromkeys(row["scene"] for row in told))
    with matplotlib.rc_context(STYLE):
        figure, axes = plt.subplots(len(names), 3, figsize=(9.6, 3.1 * len(names)), layout="constrained", squeeze=False)
        for line, name in zip(axes, names, strict=True):
            for i, (formulation, shade) in enumerate(zip(FORMULATIONS, ordinal(len(FORMULATIONS)), strict=True)):
                own = [row for row in told if (row["scene"], row["formulation"]) == (name, formulation)]
                look: dict[str, Any] = dict(color=shade, marker="os^Dv"[i], markersize=4)
                for ax, (x, y) in zip(line, _AXES, strict=True):
                    # Nothing is smaller than a double's rounding of lengths of a metre.
                    ax.plot([r[x] for r in own], [max(r[y], 1e-16) for r in own], **look, label=formulation)
            for ax, (x, y) in zip(line, _AXES, strict=True):
                logarithmic(ax, "xy")
                ax.set_xlabel(_LABELS[x])
                ax.set_ylabel(_LABELS[y])
            line[1].set_title(name)
        handles, labels = axes[0][0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=5)
        yield save(figure, folder, "formulation_study", "", *_WORDS)


_AXES = (("rtol", "gap"), ("rtol", "centre_error"), ("evaluations", "centre_error"))
_LABELS = {
    "rtol": "relative tolerance",
    "gap": "largest gap / m",
    "centre_error": "largest error of the centre / m",
    "evaluations": "evaluations of (27)",
}
