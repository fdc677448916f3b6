"""Figures of runs: the headline of a report; of one case the motion as in the paper, and the error against the steps.

Every figure depends only on an `Experiment`. Times in s, lengths in m, angles in rad.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import isfinite, nan
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases import Case
from cases.pictures import plots

from ..running.names import REFERENCE
from ..running.records import (
    Experiment,
    Run,
    Truth,
    finest,
    first_error,
    is_default,
    is_truth,
    routes,
    usable,
)
from .figure_files import FigureEntry, save
from .style import FAINT, POINTS, STYLE, TRUTH, LineStyles, logarithmic, looks_of

# Smallest error on a logarithmic axis: below the rounding of doubles of order one.
_SMALLEST = 1e-17
# A truth that varies by less, in SI units, counts as constant: the variation is rounding.
_LEVEL = 1e-9
# A motion with fewer samples than _FEW is drawn as dots of _DOT points.
_FEW, _DOT = 100, 3.0
# The headline shows this many times the largest error of the first transition on both sides of it, but at least and at
# most these parts of the duration.
_ERRORS_SHOWN, _WINDOW = 3.0, (0.02, 0.1)
# Height of a line of text, as a fraction of the axis next to it.
_LINE = 0.075


def _quantities(case: Case) -> list[tuple[str, str, str, str]]:
    """Quantities plotted against time, the paper's first: name, unit, name in the samples, and name of the difference
    from the truth. λ is the normal force over the length of track per unit of its parameter."""
    track, outline = plots.parameter_unit(case.track), plots.parameter_unit(case.plate.outline)
    return [
        ("slip velocity", "m/s", "slip", "slip"),
        ("track parameter ξ₁", track, "xi1", "xi1"),
        ("outline parameter ξ₂", outline, "xi2", "xi2"),
        ("rotation θ", "rad", "theta", "angle"),
        ("multiplier λ", "N" if track == "m" else "N/m", "lambda", "lambda"),
        ("X", "m", "x", "x"),
        ("Y", "m", "y", "y"),
    ]


def draw_headline(case: Case, experiment: Experiment, folder: Path) -> Iterator[FigureEntry]:
    """Write the headline, also as PNG; yields its entry."""
    with matplotlib.rc_context(STYLE):
        figure = headline(experiment, case, looks_of(experiment))
        yield save(figure, folder, "headline", case.label, *_HEADLINE_WORDS, png=True)


_HEADLINE_WORDS = (
    "Slip velocity, and how far each solver is from the truth",
    "Every engine with its default settings. Above: the whole motion. Below left: the first transition, where engines "
    "are early or late. Below right: absolute difference from the reference's slip velocity, on a logarithmic axis. "
    "Vertical lines: the truth's transitions, whose error bars are far smaller than the lines' width.",
)


def _name(run: Run) -> str:
    return f"{run.solver}, {run.route}"


def _finest(experiment: Experiment, label: str) -> list[Run]:
    groups = routes(run for run in experiment.runs if run.case == label).values()
    runs = [finest(group) for group in groups]
    return [run for run in runs if run and not is_truth(run, experiment.truths[label])]


def _mark_transitions(ax: Axes, truth: Truth, width: float = 0.0) -> None:
    """Draw lines at the truth's transitions and, if `width` (of the axis, in points) is positive, mode names."""
    plots.mark_transitions(ax, truth.transitions, truth.first_mode, truth.samples["t"][[0, -1]], width)


def _envelope(t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Largest |y| in each of at most POINTS equal groups of samples, and the times of these samples."""
    size = np.where(np.isfinite(y), np.abs(y), 0.0)
    pieces = np.array_split(np.arange(len(size)), min(POINTS, len(size)))
    top = np.array([piece[np.argmax(size[piece])] for piece in pieces if len(piece)], dtype=int)
    # A difference of zero cannot be drawn on a logarithmic axis.
    return t[top], np.where(size[top] > _SMALLEST, size[top], np.nan)


def _log_error(ax: Axes, runs: list[Run], name: str, looks: LineStyles) -> list[tuple[float, Run]]:
    """Draw |difference| of each run on a logarithmic axis; returns the last value of each line, for labels."""
    ends = []
    for run in runs:
        off = run.off[name]
        if not np.any(np.isfinite(off)):
            continue
        t, size = _envelope(run.off["t"], off)
        ax.plot(t, size, **looks.line(run.solver, run.route), linewidth=1.0)
        if np.any(np.isfinite(size)):
            ends.append((float(size[np.isfinite(size)][-1]), run))
    return ends


def _label_ends(ax: Axes, ends: list[tuple[float, Run]], looks: LineStyles) -> None:
    """Write names at the right ends of the lines, moved apart if they would overlap."""
    low, high = np.log10(ax.get_ylim())
    places: list[float] = []
    ends = sorted(ends, key=lambda end: end[0])
    for value, _ in ends:
        height = float((np.log10(value) - low) / (high - low))
        places.append(max(height, places[-1] + _LINE if places else 0.0))
    # A label above the top moves down and pushes the others down.
    for i, ceiling in enumerate(1.0 - _LINE * np.arange(len(places))):
        places[-1 - i] = min(places[-1 - i], float(ceiling))
    for (_, run), place in zip(ends, places, strict=True):
        ax.annotate(
            _name(run),
            (1.0, place),
            (5, 0),
            xycoords="axes fraction",
            textcoords="offset points",
            color=looks.colour(run.solver),
            va="center",
            fontsize=8.5,
            annotation_clip=False,
        )


# --- the figures ------------------------------------------------------------------------------------------------------


def headline(experiment: Experiment, case: Case, looks: LineStyles) -> Figure:
    """Slip velocity of every engine with default settings: the whole motion, the first transition, and the errors."""
    truth, runs = experiment.truths[case.label], _with_defaults(experiment, case.label)
    figure = plt.figure(figsize=(7.6, 5.8), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.15))
    above, near, below = figure.add_subplot(grid[0, :]), figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    slips = [(run, run.off["t"], _slip(run, truth)) for run in runs]
    window = _window(truth, runs)
    for ax in (above, near):
        ax.plot(truth.samples["t"], truth.samples["slip"], color=TRUTH, linewidth=2.6, alpha=0.25, label="truth")
        for run, times, slip in slips:
            ax.plot(times, slip, **looks.line(run.solver, run.route), linewidth=1.1)
        ax.axhline(0.0, color=FAINT, linewidth=0.7)
        ax.set_ylabel(plots.LABELS["slip"])
        ax.set_xlabel("time / s")
    above.margins(x=0)
    above.set_title(f"{case.label}, default settings", loc="left", pad=18, fontweight="bold")
    _mark_transitions(above, truth, width=480.0)
    above.axvspan(*window, color="#eeeeee", zorder=0)
    near.set_xlim(*window)
    near.set_ylim(*_range_inside(window, [(truth.samples["t"], truth.samples["slip"]), *(pair[1:] for pair in slips)]))
    near.set_title("the first transition (grey above)", loc="left")
    _mark_transitions(near, truth)
    logarithmic(below, "y")
    ends = _log_error(below, runs, "slip", looks)
    _mark_transitions(below, truth)
    below.set_ylabel("error / (m/s)")
    below.set_xlabel("time / s")
    below.margins(x=0)
    _label_ends(below, ends, looks)
    return figure


def _with_defaults(experiment: Experiment, label: str) -> list[Run]:
    """The run of every engine's route with default settings; the finest for a motion that has none, as from a file."""
    groups = routes(run for run in experiment.runs if run.case == label and run.solver != REFERENCE).values()
    runs = [next((run for run in group if is_default(run)), None) or finest(group) for group in groups]
    return [run for run in runs if run is not None and len(run.off.get("t", ()))]


def _slip(run: Run, truth: Truth) -> np.ndarray:
    """The slip velocity of a run at the times of its differences, m/s."""
    return np.interp(run.off["t"], truth.samples["t"], truth.samples["slip"]) + run.off["slip"]


def _window(truth: Truth, runs: list[Run]) -> tuple[float, float]:
    """The times around the truth's first transition in which the runs differ visibly, s."""
    begin, end = (float(time) for time in truth.samples["t"][[0, -1]])
    errors = [abs(error) for run in runs if isfinite(error := first_error(run))]
    least, most = (part * (end - begin) for part in _WINDOW)
    half = min(max(_ERRORS_SHOWN * max(errors, default=0.0), least), most)
    return truth.transitions[0].time - half, truth.transitions[0].time + half


def _range_inside(window: tuple[float, float], lines: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[float, float]:
    """The range of the lines' values inside a window of times, with a margin."""
    inside = np.concatenate([np.interp(np.linspace(*window, POINTS), t, values) for t, values in lines])
    low, high = float(np.nanmin(inside)), float(np.nanmax(inside))
    margin = 0.08 * (high - low) or 1.0
    return low - margin, high + margin


def _curves(ax: Axes, truth: Truth, runs: list[Run], name: str, looks: LineStyles) -> None:
    ax.plot(truth.samples["t"], truth.samples[name], color=TRUTH, linewidth=2.6, alpha=0.25, label="truth")
    top, bottom = np.nanmax(truth.samples[name]), np.nanmin(truth.samples[name])
    # The truth sets the axis range: a noisy force of one engine must not flatten or hide the other curves.
    room = 0.08 * (top - bottom if top - bottom > max(1e-6 * abs(top), _LEVEL) else max(abs(top), 1.0))
    ax.set_ylim(bottom - room, top + room)
    for run in runs:
        values = run.samples[name]
        if run.solver == REFERENCE:  # it coincides with the truth: only its difference is visible
            ax.plot([], [], **looks.line(run.solver, run.route), label=_name(run))
            continue
        if not np.any(np.isfinite(values)):
            continue
        every = max(1, len(values) // (2 * POINTS))
        exact = np.interp(run.samples["t"], truth.samples["t"], truth.samples[name])
        noisy = np.nanquantile(np.abs(values - exact), 0.9) > room
        look = looks.line(run.solver, run.route) | ({"linewidth": 0.4, "alpha": 0.5, "zorder": 1.5} if noisy else {})
        if len(values) < _FEW:
            _dots(ax, run.samples["t"], values, look["color"], _name(run))
        else:
            ax.plot(run.samples["t"][::every], values[::every], **look, label=_name(run))


def _dots(ax: Axes, t: np.ndarray, y: np.ndarray, colour: str, label: str) -> None:
    """Draw the samples of a solver with few long steps as dots; straight lines between them would add errors.

    The dots are one path of very short segments with round ends: markers would take a quarter of the file.
    """
    short = 1e-5 * float(np.ptp(t))
    times, values = np.column_stack([t, t + short, np.full(len(t), nan)]), np.column_stack([y, y, np.full(len(t), nan)])
    ax.plot(times.ravel(), values.ravel(), color=colour, linewidth=_DOT, solid_capstyle="round")
    ax.plot([], [], linestyle="", marker=".", markersize=2 * _DOT, color=colour, label=label)


def motion(experiment: Experiment, case: Case, looks: LineStyles) -> Figure:
    """The paper's diagrams from the finest setting of every route, each with the difference from the truth: the largest
    in each of POINTS time intervals. λ is missing without a usable normal force; in flight there is no contact."""
    truth, runs = experiment.truths[case.label], _finest(experiment, case.label)
    quantities = _quantities(case)
    figure, axes = plt.subplots(len(quantities), 2, figsize=(9.5, 13.6), sharex=True, layout="constrained")
    for place, (quantity, unit, name, off) in enumerate(quantities):
        row = axes[place]
        _curves(row[0], truth, runs, name, looks)
        row[0].set_ylabel(plots.with_unit(quantity, unit))
        logarithmic(row[1], "y")
        _log_error(row[1], runs, off, looks)
        row[1].set_ylabel(plots.with_unit("error", unit))
        for side, ax in enumerate(row):
            _mark_transitions(ax, truth, width=270.0 if place == side == 0 else 0.0)
            ax.margins(x=0)
    for ax in axes[-1]:
        ax.set_xlabel("time / s")
    handles, names = axes[0][0].get_legend_handles_labels()
    figure.legend(
        handles, names, loc="outside upper center", ncols=3, title=case.label, title_fontproperties={"weight": "bold"},
    )  # fmt: skip
    return figure


class _Point(NamedTuple):
    """A setting in the figure of errors."""

    steps: int
    error: float
    run: Run


def errors(experiment: Experiment, case: Case, looks: LineStyles) -> Figure | None:
    """Error of the first transition (without transitions, of the centre) of every rung against its steps; None if no
    error is larger than the truth's error bar. A cross marks an unusable motion (its first transition may still be
    accurate), a hollow marker the engine's default settings; grey is within the error bar of the truth."""
    truth = experiment.truths[case.label]
    has_transitions = bool(truth.transitions)
    bar = truth.error_bars[0] if has_transitions else truth.centre_bar if isfinite(truth.centre_bar) else 0.0
    points_by_route = _error_points(experiment, case.label)
    if not any(point.error > bar for points in points_by_route.values() for point in points):
        return None
    figure, ax = plt.subplots(figsize=(7.2, 4.3), layout="constrained")
    for (solver, route), points in points_by_route.items():
        ladder = [p for p in points if not is_default(p.run)]
        look, marker = looks.line(solver, route), looks.marker(solver, route)
        ax.plot([p.steps for p in ladder], [p.error for p in ladder], **look)
        ax.plot([], [], **look, marker=marker, markersize=6, label=f"{solver}, {route}")
        for is_usable, hollow in product((True, False), (False, True)):  # one artist for marks of one look
            marks = [(p.steps, p.error) for p in points if (usable(p.run), is_default(p.run)) == (is_usable, hollow)]
            shape, face = marker if is_usable else "x", "white" if hollow else look["color"]
            if marks:
                ax.plot(
                    *zip(*marks, strict=True), linestyle="", marker=shape, markersize=6, color=look["color"],
                    markerfacecolor=face,
                )  # fmt: skip
    logarithmic(ax, "xy")
    if bar > 0.0:
        ax.axhspan(_SMALLEST / 10, bar, color="#eeeeee", zorder=0)
        ax.axhline(bar, color=FAINT, linewidth=0.8)
    low, high = ax.get_ylim()
    ax.set_ylim(max(low, _SMALLEST / 3), high)
    ax.set_xlabel("steps")
    ax.set_ylabel("error of the first transition's time / s" if has_transitions else "largest error of the centre / m")
    ax.set_title(case.label, loc="left", fontweight="bold")
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _error_points(experiment: Experiment, label: str) -> dict[tuple[str, str], list[_Point]]:
    """The settings of each route that have an error, except the truth itself."""
    truth = experiment.truths[label]
    points: dict[tuple[str, str], list[_Point]] = {}
    for run in experiment.runs:
        if run.case != label or run.outcome != "answered" or is_truth(run, truth):
            continue
        size = abs(first_error(run) if truth.transitions else run.distance.centre_max)
        if isfinite(size):
            points.setdefault((run.solver, run.route), []).append(_Point(run.cost.steps, max(size, _SMALLEST), run))
    return points
