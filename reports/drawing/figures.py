"""Figures of runs: the scene, the motion as in the paper, the error against the steps, and the headline figure.

Every figure depends only on an `Experiment`. Times in s, lengths in m, angles in rad.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isfinite, nan

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases import Case
from cases.pictures import drawn_scene, plots
from cases.pictures.layout import Instant, instants

from ..running import per_solver
from ..running.records import (
    REFERENCE,
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
from .figure_files import FigureContent, file_name, picture
from .style import FAINT, POINTS, STYLE, TRUTH, LineStyles, logarithmic

# Smallest error on a logarithmic axis: below the rounding of doubles of order one.
_SMALLEST = 1e-17
# A truth that varies by less, in SI units, counts as constant: the variation is rounding.
_LEVEL = 1e-9
# A motion with fewer samples than _FEW is drawn as dots of _DOT points.
_FEW, _DOT = 100, 3.0
# Height of a line of text, as a fraction of the axis next to it.
_LINE = 0.075
# Quantities plotted against time, the paper's first: label, name in the samples, and name of the difference from the
# truth.
_QUANTITIES = (
    (plots.LABELS["slip"], "slip", "slip"),
    (plots.LABELS["xi1"], "xi1", "xi1"),
    (plots.LABELS["xi2"], "xi2", "xi2"),
    (plots.LABELS["theta"], "theta", "angle"),
    ("multiplier λ", "lambda", "lambda"),
    (plots.LABELS["x"], "x", "x"),
    (plots.LABELS["y"], "y", "y"),
)


def draw_case(case: Case, part: Experiment, looks: LineStyles, main: bool) -> list[FigureContent]:
    """Draw the figures of one case: scene, motion, error, and the headline if it is the `main` case.

    A figure that fails with the results of a solver is drawn without them.
    """
    name = file_name(case.label)
    figures: list[tuple[Callable[[Experiment], Figure], str, tuple[str, str]]] = [
        (lambda part: scene(part, case), f"scene_{name}", _SCENE_WORDS),
        (lambda part: motion(part, case, looks), f"motion_{name}", _MOTION_WORDS),
        (lambda part: errors(part, case, looks), f"errors_{name}", _ERRORS_WORDS),
    ]
    if main:
        figures.insert(0, (lambda part: headline(part, case, looks), "headline", _HEADLINE_WORDS))
    solvers = [run.solver for run in part.runs]
    pictures = []
    with matplotlib.rc_context(STYLE):
        for figure, file, words in figures:

            def draw(part: Experiment, figure=figure, file=file, words=words) -> FigureContent:
                try:
                    title, caption = words
                    return picture(figure(part), file, case.label, title, caption, png=file == "headline")
                finally:
                    plt.close("all")  # also after a failure

            picture_, omissions = per_solver.make_per_solver(draw, (part,), solvers, f"figure {file}")
            pictures.append(replace(picture_, entry=replace(picture_.entry, left_out=tuple(omissions))))
    return pictures


_HEADLINE_WORDS = (
    "Slip velocity, and how far each solver is from the truth",
    "Finest setting of every route. Above: the curves coincide. Below: absolute difference from the reference's slip "
    "velocity, on a logarithmic axis; it jumps where a solver's transition is early or late, because the slopes "
    "differ there. Vertical lines: the truth's transitions.",
)
_SCENE_WORDS = (
    "The scene",
    "The plate at its start (darkest), at each transition and at evenly spaced times between; the spoke turns with the "
    "plate, and the dot is the contact point. Gravity points down the page.",
)
_MOTION_WORDS = (
    "The motion, as in the paper",
    "Left: slip velocity, contact parameters, rotation, multiplier λ = N/‖R_p‖ and the centre's position against time, "
    f"from the finest setting of every route. Right: absolute difference from the truth, the largest value in each of "
    f"{POINTS} time intervals. λ is missing for a solver without a usable normal force; in flight there is no contact.",
)
_ERRORS_WORDS = (
    "Error against steps",
    "Each point is one setting; steps are the solver's own. A cross marks an unusable motion (its first "
    "transition may still be accurate), a hollow marker the engine's default settings. Grey: within the error "
    "bar of the truth.",
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
    """Draw |difference| of each run; returns the last value of each line, for labels."""
    ends = []
    for run in runs:
        off = run.off[name]
        if not np.any(np.isfinite(off)):
            continue
        t, size = _envelope(run.off["t"], off)
        ax.plot(t, size, **looks.line(run.solver, run.route), linewidth=1.0)
        if np.any(np.isfinite(size)):
            ends.append((float(size[np.isfinite(size)][-1]), run))
    logarithmic(ax, "y")
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
    """Slip velocity of every route, and its distance from the truth."""
    truth, runs = experiment.truths[case.label], _finest(experiment, case.label)
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(7.6, 5.6), sharex=True, height_ratios=(1, 1.25), layout="constrained"
    )
    _curves(above, truth, runs, "slip", looks)
    _mark_transitions(above, truth, width=410.0)
    above.axhline(0.0, color=FAINT, linewidth=0.7)
    above.set_ylabel("slip velocity / (m/s)")
    above.set_title(case.label, loc="left", pad=18, fontweight="bold")
    ends = _log_error(below, runs, "slip", looks)
    _mark_transitions(below, truth)
    below.set_ylabel("distance from truth / (m/s)")
    below.set_xlabel("time / s")
    below.margins(x=0)
    _label_ends(below, ends, looks)
    return figure


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
        every = max(1, len(values) // POINTS)
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
    """The paper's diagrams with every route, each with the difference from the truth."""
    truth, runs = experiment.truths[case.label], _finest(experiment, case.label)
    # Fixed margins with room for all labels except the outer left ones, for which the file's bounding box has room.
    # Automatic layout would take a third of the figure's time.
    places = {"left": 0.08, "right": 0.99, "bottom": 0.04, "top": 0.93, "wspace": 0.24, "hspace": 0.12}
    figure, axes = plt.subplots(len(_QUANTITIES), 2, figsize=(9.2, 13.6), sharex=True, gridspec_kw=places)
    for place, (label, name, off) in enumerate(_QUANTITIES):
        row = axes[place]
        _curves(row[0], truth, runs, name, looks)
        row[0].set_ylabel(label)
        _log_error(row[1], runs, off, looks)
        row[1].set_ylabel("distance from truth")
        for side, ax in enumerate(row):
            _mark_transitions(ax, truth, width=270.0 if place == side == 0 else 0.0)
            ax.margins(x=0)
    for ax in axes[-1]:
        ax.set_xlabel("time / s")
    handles, names = axes[0][0].get_legend_handles_labels()
    figure.legend(
        handles, names, loc="lower center", bbox_to_anchor=(0.535, 0.945), ncols=3, title=case.label,
        title_fontproperties={"weight": "bold"},
    )  # fmt: skip
    return figure


def errors(experiment: Experiment, case: Case, looks: LineStyles) -> Figure:
    """Error of the first transition (without transitions, of the centre) of every rung against its steps."""
    truth = experiment.truths[case.label]
    has_transitions = bool(truth.transitions)
    figure, ax = plt.subplots(figsize=(7.2, 4.3), layout="constrained")
    for (_, _, route), group in routes(run for run in experiment.runs if run.case == case.label).items():
        if not route:
            continue
        points = [
            (run.cost.steps, max(size, _SMALLEST), run)
            for run in group
            if run.outcome == "answered"
            and not is_truth(run, truth)
            and isfinite(size := abs(first_error(run) if has_transitions else run.distance.centre_max))
        ]
        ladder = [p for p in points if not is_default(p[2])]
        if not points:
            continue
        look = looks.line(points[0][2].solver, route)
        ax.plot([p[0] for p in ladder], [p[1] for p in ladder], **look, label=_name(points[0][2]))
        for steps, size, run in points:
            hollow = "white" if is_default(run) else look["color"]
            marker = "x" if not usable(run) else looks.marker(run.solver, run.route)
            ax.plot(steps, size, marker=marker, markersize=6, color=look["color"], markerfacecolor=hollow)
    logarithmic(ax, "xy")
    if has_transitions:
        ax.axhspan(_SMALLEST / 10, truth.error_bars[0], color="#eeeeee", zorder=0)
        ax.axhline(truth.error_bars[0], color=FAINT, linewidth=0.8)
    low, high = ax.get_ylim()
    ax.set_ylim(max(low, _SMALLEST / 3), high)
    ax.set_xlabel("steps")
    ax.set_ylabel("error of the first transition's time / s" if has_transitions else "largest error of the centre / m")
    ax.set_title(case.label, loc="left", fontweight="bold")
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def scene(experiment: Experiment, case: Case) -> Figure:
    """Track and plate at several instants, gravity down the page; in flight, the path of the centre."""
    truth = experiment.truths[case.label]
    samples = truth.samples
    x, y, theta, xi1 = (samples[name] for name in ("x", "y", "theta", "xi1"))
    figure, ax = plt.subplots(figsize=(4.6, 3.8), layout="constrained")
    shades = instants(samples["t"], [t.time for t in truth.transitions])
    poses = [Instant(x[i], y[i], theta[i], xi1[i], shade) for i, shade in shades]
    drawn_scene.draw(ax, case.scene, np.array([x, y]), xi1, poses)
    ax.set_title(case.label, loc="left", fontweight="bold")
    return figure
