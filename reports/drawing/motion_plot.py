"""Plot of some motions and their truth: a quantity against time, and the differences from the truth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases.errors import unknown_name
from cases.pictures.plots import LABELS, mark_transitions
from cases.pictures.style import Picture, apply_style

from ..running.records import Run, Truth
from .colours import TRUTH
from .palette import LineStyles, logarithmic

# Names of quantities in the samples, and names of their differences.
_OFF = {
    "x": "x",
    "y": "y",
    "theta": "angle",
    "slip": "slip",
    "xi1": "xi1",
    "xi2": "xi2",
    "normal_force": "normal_force",
}


def plot(label: str, truth: Truth, runs: Sequence[Run], quantity: str) -> Picture:
    """Plot one quantity of the runs and the truth; raises UnknownName for a quantity that is not compared."""
    if quantity not in _OFF:
        raise unknown_name("quantity that is compared", quantity, _OFF)
    looks = LineStyles((run.solver, run.route) for run in runs)
    times = truth.samples["t"]
    with apply_style():
        figure = Picture(figsize=(7.2, 4.8), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        above.plot(times, truth.samples[quantity], color=TRUTH.light, linewidth=2.6, alpha=0.25, label="truth")
        for run in runs:
            look = looks.line(run.solver, run.route) if run.route else {"color": looks.colour(run.solver)}
            name = f"{run.solver}{run.route and f', {run.route}'}"
            above.plot(run.samples["t"], run.samples[quantity], **look, label=name)
            size = np.abs(run.off[_OFF[quantity]])
            below.plot(run.off["t"], np.where(size > 0.0, size, np.nan), **look, linewidth=1.0)
        for ax, width in ((above, 410.0), (below, 0.0)):
            mark_transitions(ax, truth.transitions, truth.first_mode, times[[0, -1]], width)
            ax.margins(x=0)
        above.set_ylabel(LABELS[quantity])
        above.set_title(label, loc="left", pad=18, fontweight="bold")
        above.legend(loc="best")
        logarithmic(below, "y")
        below.set(xlabel="time / s", ylabel="distance from truth")
    return figure
