"""The figure of the study: drift, error and cost of each formulation."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import pyplot as plt

from ...drawing.figure_files import FigureEntry, save
from ...drawing.style import STYLE, logarithmic, ordinal
from .measure import FORMULATIONS

_WORDS = (
    "Which coordinates to integrate",
    "The paper's ten coordinates without stabilisation, with Baumgarte's terms and with projection after each step, "
    "and the two independent ones with their rates; all with the same integrator and matrix. Left: gap. Middle: error "
    "of the centre, its largest. Right: the same against evaluations of the paper's equations (27). An unbalanced "
    "ellipse in an ellipse; above, it slips "
    "with friction until its first transition; below, it slides without friction for five seconds.",
)


def draw(rows: list[dict[str, Any]], folder: Path) -> Iterator[FigureEntry]:
    """Write the figure to the folder; yields its entry."""
    names = list(dict.fromkeys(row["scene"] for row in rows))
    with matplotlib.rc_context(STYLE):
        figure, axes = plt.subplots(len(names), 3, figsize=(9.6, 3.1 * len(names)), layout="constrained", squeeze=False)
        for line, name in zip(axes, names, strict=True):
            for i, (formulation, shade) in enumerate(zip(FORMULATIONS, ordinal(len(FORMULATIONS)), strict=True)):
                formulation_rows = [row for row in rows if (row["scene"], row["formulation"]) == (name, formulation)]
                # The last two coincide: the last one is drawn as rings around the points of the other.
                is_last = i == len(FORMULATIONS) - 1
                look: dict[str, Any] = dict(color=shade, marker="os^Do"[i], markersize=8 if is_last else 4)
                look |= {"markerfacecolor": "none", "linestyle": ":"} if is_last else {}
                for ax, (x, y) in zip(line, _AXES, strict=True):
                    # 1e-16 is the rounding of doubles of order one, here lengths in m.
                    ax.plot(
                        [r[x] for r in formulation_rows],
                        [max(r[y], 1e-16) for r in formulation_rows],
                        **look,
                        label=formulation,
                    )
            for ax, (x, y) in zip(line, _AXES, strict=True):
                logarithmic(ax, "xy")
                ax.set_xlabel(_LABELS[x])
                ax.set_ylabel(_LABELS[y])
            line[0].set_title(name, loc="left", fontweight="bold")
            line[2].set_ylabel("")  # that of its neighbour
            line[2].sharey(line[1])
        handles, labels = axes[0][0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=5)
        figure.align_ylabels(axes[:, :2])
        yield save(figure, folder, "formulation_study", "", *_WORDS)


_AXES = (("rtol", "gap"), ("rtol", "centre_error"), ("evaluations", "centre_error"))
_LABELS = {
    "rtol": "relative tolerance",
    "gap": "largest gap / m",
    "centre_error": "error of the centre / m",
    "evaluations": "evaluations of the equations (27)",
}
