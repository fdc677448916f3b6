"""Error against CPU time, case by case and in one picture. Looks as in `figures`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import precision
from .figures import _STYLE, Drawn, _Looks, _save, file_name
from .precision import Measured
from .records import Experiment, is_default_setting

_WORDS = (
    "Work and precision",
    "Each point is one setting, timed alone: median CPU time of the run, bar from quartile to quartile; hollow: the "
    "engine's own defaults. Left is cheaper, down is more accurate. The grey band ends at ten times the truth's error "
    "bar; nothing is drawn inside it, a triangle on its edge marks what a setting that reaches it costs.",
)
_SUMMARY_WORDS = (
    "What accuracy costs, over all timed cases",
    "Share of the cases in which a route reaches the accuracy within so many times the CPU time of the fastest route "
    "(first transition, or the final centre where there is none). A line that ends low never gets there in the other "
    "cases.",
)
# The accuracies of the summary: what a game, a robot and a numerical analyst would ask for.
_PANELS = (1e-2, 1e-4, 1e-6, 1e-8)


def draw(experiment: Experiment, measured: Measured, folder: Path) -> Iterator[Drawn]:
    """Write a figure for each timed case and one for all; yields what was written."""
    looks, points = _Looks(experiment), precision.work_precision_rows(experiment, measured)
    rows = precision.time_to_accuracy_rows(points)
    with matplotlib.rc_context(_STYLE):
        if precision.verdicts(rows):
            yield _save(summary(experiment, rows, looks), folder, "work_precision", "", *_SUMMARY_WORDS)
        for label in measured.cases:
            own = [p for p in points if p["case"] == label and isfinite(p["cpu_s"]) and isfinite(p["error"])]
            if own:
                figure = work_precision(experiment, label, own, looks)
                yield _save(figure, folder, f"work_precision_{file_name(label)}", label, *_WORDS)


def work_precision(experiment: Experiment, label: str, points: Sequence[dict[str, Any]], looks: _Looks) -> Figure:
    """The first transition (where there is one) and the final centre."""
    asked = [q for q in ("first_transition_time", "final_centre") if any(p["quantity"] == q for p in points)]
    figure, axes = plt.subplots(1, len(asked), figsize=(4.6 * len(asked), 4.4), layout="constrained", squeeze=False)
    for ax, quantity in zip(axes[0], asked, strict=True):
        _panel(ax, experiment, label, [p for p in points if p["quantity"] == quantity], looks)
        ax.set_xlabel("CPU time of the run / s")
        ax.set_ylabel(f"{quantity.replace('_', ' ')}: error / {precision.QUANTITIES[quantity]}")
    handles, names = axes[0][0].get_legend_handles_labels()
    figure.legend(
        handles, names, loc="outside upper center", ncols=3, title=label, title_fontproperties={"weight": "bold"}
    )
    return figure


def _panel(ax: Axes, experiment: Experiment, label: str, points: Sequence[dict[str, Any]], looks: _Looks) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    band = points[0]["floor_error"]
    for (solver, route), group in precision._groups(points, "solver", "route").items():
        run = next(r for r in experiment.runs if (r.case, r.solver, r.route) == (label, solver, route))
        above = [p for p in group if not p["below_floor"]]
        ladder = [p for p in group if not is_default_setting(p["setting"])]
        look = looks.line(run)
        # A setting inside the band interrupts the line: where it lies is not known.
        sizes = [nan if p["below_floor"] else p["error"] for p in ladder]
        ax.plot([p["cpu_s"] for p in ladder], sizes, **look, label=f"{solver}, {route}")
        for p in above:
            face = "white" if is_default_setting(p["setting"]) else look["color"]
            bar = p["cpu_spread_s"] / 2 if isfinite(p["cpu_spread_s"]) else 0.0
            ax.errorbar(
                p["cpu_s"], p["error"], xerr=bar, fmt=looks.marker(run), markersize=5, color=look["color"],
                markerfacecolor=face, elinewidth=0.8,
            )  # fmt: skip
        reached = [p["cpu_s"] for p in group if p["below_floor"]]
        if reached:
            ax.plot(min(reached), band, marker="v", color=look["color"], markersize=7, clip_on=False, zorder=5)
    ax.axhspan(band / 10, band, color="#eeeeee", zorder=0)
    ax.set_ylim(bottom=band / 10)


def summary(experiment: Experiment, rows: Sequence[dict[str, Any]], looks: _Looks) -> Figure:
    """Performance profiles (Dolan & Moré 2002) at several accuracies."""
    quantity = {v.case: v.quantity for v in precision.verdicts(rows)}
    rows = [row for row in rows if quantity.get(row["case"]) == row["quantity"]]
    known = [a for a in _PANELS if any(isfinite(row["ratio"]) for row in rows if row["accuracy"] == a)]
    figure, axes = plt.subplots(
        1,
        len(known),
        figsize=(2.9 * len(known) + 0.6, 3.6),
        sharey=True,
        sharex=True,
        layout="constrained",
        squeeze=False,
    )
    widest = max(row["ratio"] for row in rows if isfinite(row["ratio"])) * 2
    for ax, accuracy in zip(axes[0], known, strict=True):
        for (solver, route), group in precision._groups(rows, "solver", "route").items():
            ratios = sorted(r["ratio"] for r in group if r["accuracy"] == accuracy and isfinite(r["ratio"]))
            run = next(r for r in experiment.runs if (r.solver, r.route) == (solver, route))
            shares = [i / len(quantity) for i in range(len(ratios) + 1)]
            # Drawn also where it never leaves zero, so that the legend is the same everywhere.
            ax.step([1.0, *ratios, widest], [0.0, *shares[1:], shares[-1]], where="post", **looks.line(run),
                    label=f"{solver}, {route}")  # fmt: skip
        ax.set_xscale("log")
        ax.set_title(f"accuracy {accuracy:g}")
        ax.set_xlabel("CPU time / fastest")
    axes[0][0].set_ylabel("share of cases")
    axes[0][0].set_ylim(-0.03, 1.03)
    handles, names = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=3)
    return figure
