"""Runs -> figures: the scene, the motion as the paper draws it, the error against the steps, and the headline.

Every figure is made from an `Experiment` alone. Times in s, lengths in m, angles in rad.
"""

from __future__ import annotations

from math import cos, isfinite, sin

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from cases import Case, Gravity, Mode

from ..running.records import Experiment, Run, Truth, finest, first_error, is_default, is_truth, routes
from .files import Picture, file_name, picture
from .style import FAINT, PALETTE, POINTS, STYLE, TRUTH, Looks, logarithmic

# An error drawn on a logarithmic axis needs a least value; below a double's rounding of quantities of order one there
# is nothing to see.
_SMALLEST = 1e-17
# Corners of a plate as drawn: a circle's chords then leave it by a thousandth of its radius.
_CORNERS = 73
# A truth that varies by less, in SI units, is level: what varies is rounding.
_LEVEL = 1e-9
# Fewer samples than this over a motion are drawn as points.
_FEW = 100
# Points that a letter of eight points takes, in the mean.
_LETTER = 5.0
# What the paper draws against time: the label, the samples' name, and the name of its difference from the truth.
_QUANTITIES = (
    ("slip velocity v / (m/s)", "slip", "slip"),
    ("track parameter ξ₁", "xi1", "xi1"),
    ("outline parameter ξ₂", "xi2", "xi2"),
    ("rotation θ / rad", "theta", "angle"),
    ("multiplier λ", "lambda", "lambda"),
)
_MODE_WORDS = {
    Mode.SLIDE: "slides",
    Mode.SLIP_FORWARD: "slip v > 0",
    Mode.SLIP_BACKWARD: "slip v < 0",
    Mode.ROLL: "rolls",
    Mode.REST: "rests",
    Mode.FLIGHT: "flies",
}


def draw_case(case: Case, part: Experiment, looks: Looks, main: bool) -> list[Picture]:
    """The figures of one case: scene, motion, error, and the headline if it is the main one."""
    name, made = file_name(case.label), []
    with matplotlib.rc_context(STYLE):
        if main:
            figure = headline(part, case, looks)
            made.append(picture(figure, "headline", case.label, *_HEADLINE_WORDS, png=True))
        made.append(picture(scene(part, case), f"scene_{name}", case.label, *_SCENE_WORDS))
        made.append(picture(motion(part, case, looks), f"motion_{name}", case.label, *_MOTION_WORDS))
        made.append(picture(errors(part, case, looks), f"errors_{name}", case.label, *_ERRORS_WORDS))
    return made


_HEADLINE_WORDS = (
    "Slip velocity, and how far each solver is from the truth",
    "Finest setting of every route. Above: the curves lie on each other. Below: the absolute difference from the "
    "reference's slip velocity, on a logarithmic axis; it jumps where a solver's transition comes early or late, "
    "because the slopes differ there. Vertical lines: the truth's transitions.",
)
_SCENE_WORDS = (
    "The scene",
    "The plate at its start (darkest), at each transition and at even times between; the spoke turns with it, the dot "
    "is the contact point. Gravity pulls down the page.",
)
_MOTION_WORDS = (
    "The motion, as the paper draws it",
    "Left: slip velocity, contact parameters, rotation and multiplier λ = N/‖R_p‖ against time, from the finest "
    f"setting of every route. Right: absolute difference from the truth, largest value in each of {POINTS} stretches "
    "of time. Where a solver gives no usable normal force its λ is missing.",
)
_ERRORS_WORDS = (
    "Error against steps",
    "Each point is one setting; steps are the solver's own. A cross marks a run with a wrong sequence of transitions "
    "(its first transition may still be right), a hollow marker the engine's own defaults. Below the grey line the "
    "truth itself is not sure.",
)


def _name(run: Run) -> str:
    return f"{run.solver}, {run.route}"


def _finest(experiment: Experiment, label: str) -> list[Run]:
    groups = routes(run for run in experiment.runs if run.case == label).values()
    runs = [finest(group) for group in groups]
    return [run for run in runs if run and not is_truth(run, experiment.truths[label])]


def _mark_transitions(ax: Axes, truth: Truth, width: float = 0.0) -> None:
    """Lines at the truth's transitions; over an axis about `width` points wide also the modes between, in words."""
    times = [t.time for t in truth.transitions]
    for time in times:
        ax.axvline(time, color=FAINT, linewidth=0.7, zorder=0.5)
    if not width:
        return
    edges = [float(truth.samples["t"][0]), *times, float(truth.samples["t"][-1])]
    modes = [truth.first_mode, *(t.after for t in truth.transitions)]
    for mode, left, right in zip(modes, edges[:-1], edges[1:], strict=False):
        word = _MODE_WORDS[mode] if mode is not None else ""
        # A stretch narrower than its word goes without.
        if word and (right - left) * width > _LETTER * len(word) * (edges[-1] - edges[0]):
            middle = 0.5 * (left + right)
            ax.annotate(
                word,
                (middle, 1.0),
                (0, 3),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                ha="center",
                color="#555555",
                fontsize=8,
            )


def _envelope(t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Largest |y| in each of at most POINTS equal stretches of the samples, at that sample's time."""
    size = np.where(np.isfinite(y), np.abs(y), 0.0)
    pieces = np.array_split(np.arange(len(size)), min(POINTS, len(size)))
    top = np.array([piece[np.argmax(size[piece])] for piece in pieces if len(piece)], dtype=int)
    # Where a solver agrees to the last digit there is nothing to draw on a logarithmic axis.
    return t[top], np.where(size[top] > _SMALLEST, size[top], np.nan)


def _log_error(ax: Axes, runs: list[Run], name: str, looks: Looks) -> list[tuple[float, Run]]:
    """Draw |difference| of each run; returns where each line ends, for labels."""
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


def _label_ends(ax: Axes, ends: list[tuple[float, Run]], looks: Looks) -> None:
    """Names beside the lines' right ends, moved apart where they would overlap."""
    low, high = np.log10(ax.get_ylim())
    places: list[float] = []
    for value, run in sorted(ends, key=lambda end: end[0]):
        wanted = (np.log10(value) - low) / (high - low)
        place = max(float(wanted), places[-1] + 0.075 if places else 0.0)
        places.append(place)
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


def headline(experiment: Experiment, case: Case, looks: Looks) -> Figure:
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


def _curves(ax: Axes, truth: Truth, runs: list[Run], name: str, looks: Looks) -> None:
    ax.plot(truth.samples["t"], truth.samples[name], color=TRUTH, linewidth=2.6, alpha=0.25, label="truth")
    top, bottom = np.nanmax(truth.samples[name]), np.nanmin(truth.samples[name])
    # The axis belongs to the truth: a noisy force of one engine must not flatten everyone's curve, nor hide it.
    room = 0.08 * (top - bottom if top - bottom > max(1e-6 * abs(top), _LEVEL) else max(abs(top), 1.0))
    ax.set_ylim(bottom - room, top + room)
    for run in runs:
        values = run.samples[name]
        if not np.any(np.isfinite(values)):
            continue
        every = max(1, len(values) // POINTS)
        exact = np.interp(run.samples["t"], truth.samples["t"], truth.samples[name])
        noisy = np.nanquantile(np.abs(values - exact), 0.9) > room
        look = looks.line(run.solver, run.route) | ({"linewidth": 0.4, "alpha": 0.5, "zorder": 1.5} if noisy else {})
        # A solver that takes a few long steps gives points; straight lines between them would be this picture's error.
        look |= {"linestyle": "", "marker": ".", "markersize": 4} if len(values) < _FEW else {}
        ax.plot(run.samples["t"][::every], values[::every], **look, label=_name(run))


def motion(experiment: Experiment, case: Case, looks: Looks) -> Figure:
    """The paper's diagrams with every route, and beside each the distance from the truth."""
    truth, runs = experiment.truths[case.label], _finest(experiment, case.label)
    figure, axes = plt.subplots(len(_QUANTITIES), 2, figsize=(9.2, 10.4), sharex=True, layout="constrained")
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
        handles, names, loc="outside upper center", ncols=3, title=case.label, title_fontproperties={"weight": "bold"}
    )
    return figure


def errors(experiment: Experiment, case: Case, looks: Looks) -> Figure:
    """First-transition error (or, without transitions, the centre's) of every rung against its steps."""
    truth = experiment.truths[case.label]
    timed = bool(truth.transitions)
    figure, ax = plt.subplots(figsize=(7.2, 4.3), layout="constrained")
    for (_, _, route), group in routes(run for run in experiment.runs if run.case == case.label).items():
        if not route:
            continue
        points = [
            (run.cost.steps, max(size, _SMALLEST), run)
            for run in group
            if run.outcome in ("right", "wrong")
            and not is_truth(run, truth)
            and isfinite(size := abs(first_error(run) if timed else run.distance.centre_max))
        ]
        ladder = [p for p in points if not is_default(p[2])]
        if not points:
            continue
        look = looks.line(points[0][2].solver, route)
        ax.plot([p[0] for p in ladder], [p[1] for p in ladder], **look, label=_name(points[0][2]))
        for steps, size, run in points:
            hollow = "white" if is_default(run) else look["color"]
            marker = "x" if run.outcome == "wrong" else looks.marker(run.solver, run.route)
            ax.plot(steps, size, marker=marker, markersize=6, color=look["color"], markerfacecolor=hollow)
    logarithmic(ax, "xy")
    if timed:
        ax.axhspan(_SMALLEST / 10, truth.error_bars[0], color="#eeeeee", zorder=0)
        ax.axhline(truth.error_bars[0], color=FAINT, linewidth=0.8)
    low, high = ax.get_ylim()
    ax.set_ylim(max(low, _SMALLEST / 3), high)
    ax.set_xlabel("steps")
    ax.set_ylabel("error of the first transition's time / s" if timed else "largest error of the centre / m")
    ax.set_title(case.label, loc="left", fontweight="bold")
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def scene(experiment: Experiment, case: Case) -> Figure:
    """Track and plate at several instants, gravity down the page."""
    shown = experiment.truths[case.label].samples
    figure, ax = plt.subplots(figsize=(4.6, 3.8), layout="constrained")
    track = case.track.point(_visible(case, shown))
    ax.plot(*track, color=TRUTH, linewidth=1.6)
    outline = case.plate.outline.point(np.linspace(*case.plate.outline.span, _CORNERS))
    for shade, i in _instants(experiment.truths[case.label]):
        x, y, theta = (float(shown[name][i]) for name in ("x", "y", "theta"))
        turn = np.array([[cos(theta), -sin(theta)], [sin(theta), cos(theta)]])
        place = turn @ outline + np.array([[x], [y]])
        spoke = turn @ outline[:, :1] + np.array([[x], [y]])
        edge, inside = (to_rgba(PALETTE[0], alpha) for alpha in (0.4 + 0.6 * shade, 0.10 + 0.3 * shade))
        ax.fill(*place, facecolor=inside, edgecolor=edge, linewidth=0.9)
        ax.plot([x, spoke[0, 0]], [y, spoke[1, 0]], color=PALETTE[0], linewidth=0.9, alpha=0.4 + 0.6 * shade)
        if np.isfinite(shown["xi1"][i]):  # no contact in flight
            ax.plot(*case.track.point(float(shown["xi1"][i])), marker="o", markersize=3, color=PALETTE[1])
    ax.set_aspect("equal")
    ax.locator_params(nbins=5)
    gravity = case.effect(Gravity)
    if gravity is not None and sin(gravity.direction) > 0:
        ax.invert_yaxis()
    ax.set_xlabel("X / m")
    ax.set_ylabel("Y / m" + (" (points down)" if ax.yaxis_inverted() else ""))
    ax.set_title(case.label, loc="left", fontweight="bold")
    return figure


def _visible(case: Case, shown: dict[str, np.ndarray]) -> np.ndarray:
    """Track parameters worth drawing: all of a closed track, else what the plate visits and a little more."""
    if case.track.period:
        return np.linspace(*case.track.span, 361)
    below = np.where(np.isfinite(shown["xi1"]), shown["xi1"], _below(case, shown))
    low, high = float(np.min(below)), float(np.max(below))
    size = float(np.ptp(case.plate.outline.point(np.linspace(*case.plate.outline.span, 181)), axis=1).max())
    more = 1.2 * size / float(case.track.speed(0.5 * (low + high)))
    domain = case.track.domain or (-np.inf, np.inf)
    return np.linspace(max(low - more, domain[0]), min(high + more, domain[1]), 361)


def _below(case: Case, shown: dict[str, np.ndarray]) -> np.ndarray:
    """Roughly the track parameter that is nearest to the centre, for each sample."""
    grid = np.linspace(*case.track.span, 1001)
    X, Y = case.track.point(grid)
    return np.array([grid[np.argmin(np.hypot(X - x, Y - y))] for x, y in zip(shown["x"], shown["y"], strict=True)])


def _instants(truth: Truth) -> list[tuple[float, int]]:
    """(shade from 1 to 0, sample) of the start, the transitions and even times, not closer than a tenth apart."""
    t = truth.samples["t"]
    wanted = [float(t[0]), *(e.time for e in truth.transitions), float(t[-1])]
    for time in np.linspace(t[0], t[-1], 7)[1:-1]:
        if all(abs(time - other) > 0.1 * (t[-1] - t[0]) for other in wanted):
            wanted.append(float(time))
    places = sorted({int(np.argmin(np.abs(t - time))) for time in wanted})
    return [(1.0 - i / max(len(places) - 1, 1), place) for i, place in enumerate(places)]
