"""Work-precision plots: error against CPU time for each case, and a summary of all cases."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..analysis import time_to_accuracy, work_precision
from ..analysis.quantities import UNITS
from ..analysis.work_precision import CostMeasurements
from ..judging.grades import LEVELS, percent
from ..running.names import REFERENCE
from ..running.records import Experiment
from .figure_files import FigureEntry, file_name, save
from .style import STYLE, LineStyles, logarithmic, looks_of

_WORDS = (
    "Work and precision",
    "Each point is one setting, timed alone: median CPU time of the whole call (setting up, running and reading the "
    "motion) in a process that has made such calls before. Hollow: the engine's default settings. Pale: timing "
    "disturbed by other load. Left is faster, down is more accurate. The grey band ends at ten times the truth's "
    "error bar; errors inside it are not drawn, and a triangle on its edge marks the fastest setting that reaches it. "
    "Quantities with errors inside the band only have no panel. Dotted: the error of a motion that does not use the "
    "law of friction.",
)
_SUMMARY_WORDS = (
    "What accuracy costs, over all timed cases",
    "Performance profiles (Dolan and Moré 2002): the fraction of the cases in which a route reaches the level of off "
    "within the given multiple of the fastest route's CPU time for a whole call. Within a level: off and its doubt "
    "stay within it at the setting and at all finer ones. A route whose line ends below 1 does not reach the level in "
    "the other cases.",
)
# Factor between the error of a null motion and the top of the axis: room for its name.
_NULL_ROOM = 30.0
# Title of a quantity's panel, and the label of its axis.
_TITLES = {
    "off": ("error of the motion, off", "share of ignoring friction"),
    "first_transition_time": ("first transition's time", "error / s"),
    "all_transitions": ("worst transition's time", "error / s"),
    "final_pose": ("final pose", "error / m"),
    "centre_rms": ("centre, root mean square", "error / m"),
    "normal_force_mean": ("normal force, mean", "error / true mean"),
    "energy_mean": ("energy, mean", "error / true kinetic energy"),
}


def draw(experiment: Experiment, measurements: CostMeasurements, folder: Path) -> Iterator[FigureEntry]:
    """Write a figure for each timed case and one for all; yields the entries of the figures."""
    looks, points = looks_of(experiment), work_precision.work_precision_rows(experiment, measurements)
    rows = time_to_accuracy.rows(experiment, measurements)
    with matplotlib.rc_context(STYLE):
        if any(row["solver"] != REFERENCE and isfinite(row["call_s"]) for row in rows):
            yield save(summary(rows, looks), folder, "work_precision", "", *_SUMMARY_WORDS)
        for label in measurements.cases:
            case_points = [p for p in points if p["case"] == label and isfinite(p["call_s"])]
            if not all(p["below_floor"] for p in case_points):
                figure = case_figure(experiment, label, case_points, looks)
                yield save(figure, folder, f"work_precision_{file_name(label)}", label, *_WORDS)


def case_figure(experiment: Experiment, label: str, points: Sequence[dict[str, Any]], looks: LineStyles) -> Figure:
    """A figure with a panel for each quantity that has an error above the band; "all transitions" only if there is more
    than one."""
    several = len(experiment.truths[label].transitions) > 1
    of_quantity = work_precision.groups(points, "quantity")
    visible = {quantity for (quantity,), group in of_quantity.items() if not all(p["below_floor"] for p in group)}
    quantities = [q for q in UNITS if q in visible and (several or q != "all_transitions")]
    columns = 3 if len(quantities) > 4 else 2
    lines = -(-len(quantities) // columns)
    figure, axes = plt.subplots(
        lines, columns, figsize=(3.1 * columns, 2.6 * lines), sharex=True, layout="constrained", squeeze=False
    )
    for ax, quantity in zip(axes.flat, quantities, strict=False):
        _panel(ax, of_quantity[quantity,], looks)
        title, axis_label = _TITLES[quantity]
        ax.set_title(title, loc="left")
        ax.set_ylabel(axis_label)
    for ax in axes.flat[len(quantities) :]:
        ax.set_axis_off()
    for column in range(columns):
        last = max((place for place in range(len(quantities)) if place % columns == column), default=None)
        if last is not None:
            axes.flat[last].set_xlabel("CPU time of a whole call / s")
            axes.flat[last].tick_params(labelbottom=True)
    # A route may have errors in some panels only.
    by_name = {name: handle for ax in axes.flat for handle, name in zip(*ax.get_legend_handles_labels(), strict=True)}
    names, handles = list(by_name), list(by_name.values())
    figure.legend(
        handles, names, loc="outside upper center", ncols=3, title=label, title_fontproperties={"weight": "bold"}
    )
    return figure


def _panel(ax: Axes, points: Sequence[dict[str, Any]], looks: LineStyles) -> None:
    logarithmic(ax, "xy")
    band, null = points[0]["floor_error"], points[0]["null_error"]
    for (solver, route), group in work_precision.groups(points, "solver", "route").items():
        ladder = [p for p in group if not p["setting"].is_default]
        look = looks.line(solver, route)
        # A setting inside the band interrupts the line, because its error is uncertain.
        sizes = [nan if p["below_floor"] else p["absolute_error"] for p in ladder]
        ax.plot([p["call_s"] for p in ladder], sizes, **look)
        ax.plot([], [], **look, marker=looks.marker(solver, route), markersize=5, label=f"{solver}, {route}")
        _points(ax, [p for p in group if not p["below_floor"]], look["color"], looks.marker(solver, route))
        times_in_band = [p["call_s"] for p in group if p["below_floor"]]
        if times_in_band:
            ax.plot(min(times_in_band), band, marker="v", color=look["color"], markersize=7, clip_on=False, zorder=5)
    ax.axhspan(band / 10, band, color="#eeeeee", zorder=0)
    ax.set_ylim(bottom=band / 10)
    if isfinite(null) and null > band:
        ax.set_ylim(top=max(_NULL_ROOM * null, ax.get_ylim()[1]))
        ax.axhline(null, color="#555555", linewidth=0.9, linestyle=":", zorder=1)
        ax.annotate(
            points[0]["null_motion"], (1.0, null), (0, 2), xycoords=("axes fraction", "data"),
            textcoords="offset points", ha="right", va="bottom", fontsize=7.5, color="#555555",
        )  # fmt: skip


def _points(ax: Axes, points: Sequence[dict[str, Any]], colour: str, marker: str) -> None:
    """Draw the points of a route, those of one look as one artist."""
    for (is_default, is_disturbed), group in work_precision.groups(
        [p | {"is_default": p["setting"].is_default} for p in points], "is_default", "disturbed"
    ).items():
        ax.plot(
            [p["call_s"] for p in group], [p["absolute_error"] for p in group], linestyle="", marker=marker,
            markersize=5, color=colour, markerfacecolor="white" if is_default else colour,
            alpha=0.35 if is_disturbed else 1.0,
        )  # fmt: skip


def summary(rows: Sequence[dict[str, Any]], looks: LineStyles) -> Figure:
    """Performance profiles at several levels, from rows of `time_to_accuracy`; times are of whole calls."""
    count = len({row["case"] for row in rows})
    ratios_by_route = _ratios(rows)
    accuracies = [a for a in LEVELS if any(level == a for level, _, _ in ratios_by_route)]
    solver_routes = list(dict.fromkeys((row["solver"], row["route"]) for row in rows))
    figure, axes = plt.subplots(
        1, len(accuracies), figsize=(2.5 * len(accuracies) + 0.6, 3.4), sharey=True, sharex=True, layout="constrained",
        squeeze=False,
    )  # fmt: skip
    widest = max(map(max, ratios_by_route.values())) * 2
    for ax, accuracy in zip(axes[0], accuracies, strict=True):
        for solver, route in solver_routes:
            ratios = sorted(ratios_by_route.get((accuracy, solver, route), ()))
            shares = [i / count for i in range(len(ratios) + 1)]
            # Also drawn if it stays at zero, so that the legend is the same in all panels.
            ax.step([1.0, *ratios, widest], [0.0, *shares[1:], shares[-1]], where="post", **looks.line(solver, route),
                    label=f"{solver}, {route}")  # fmt: skip
        logarithmic(ax, "x")
        ax.set_title(f"within {percent(accuracy)}", loc="left")
        ax.set_xlabel("CPU time / fastest")
    axes[0][0].set_ylabel(f"share of the timed cases (n = {count})")
    axes[0][0].set_ylim(-0.03, 1.03)
    handles, names = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=3)
    return figure


def _ratios(rows: Sequence[dict[str, Any]]) -> dict[tuple[float, str, str], list[float]]:
    """By level, solver and route: the times of whole calls over the fastest route's, one for each timed case."""
    ratios: dict[tuple[float, str, str], list[float]] = {}
    timed = [row for row in rows if isfinite(row["call_s"])]
    for (_, level), group in work_precision.groups(timed, "case", "level").items():
        fastest = min(row["call_s"] for row in group)
        for row in group:
            ratios.setdefault((level, row["solver"], row["route"]), []).append(row["call_s"] / fastest)
    return ratios
