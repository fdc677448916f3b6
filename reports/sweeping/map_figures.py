"""Maps of a sweep over two parameters: kinds of motion, times of the first transition, and the grades of engines.

Rows are read part by part, and from a grid only those that a figure can show, so memory does not grow with the sweep.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from cases import Mode
from reference.sweeping import Plan
from reference.sweeping.table import ARROW, BAD, FAILED, mode_of

from ..drawing.colours import GRADES
from ..drawing.figure_files import FigureEntry, file_kinds, save
from ..drawing.style import AREAS, STYLE
from . import boundaries
from .computation import ROWS
from .parameter_units import parameter_label
from .sweep_folder import Folder

# Largest number of cells per side of a grid's map, and of points in the map of a sampled plan.
CELLS, POINTS = 500, 20_000
# Largest number of kinds of motion; the rarer ones are drawn as one.
MOST = 8
_VERBS = {
    Mode.SLIDE: "slides",
    Mode.SLIP_FORWARD: "slips forward",
    Mode.SLIP_BACKWARD: "slips backward",
    Mode.ROLL: "rolls",
    Mode.REST: "rests",
    Mode.FLIGHT: "flies",
}
_OTHER = "something else"
_COLOURS = (*AREAS, "#999999")
# The most frequent kinds have the same colour in every map; the others share the remaining colours.
_USUAL = ("slips forward, then rolls", "rolls throughout", "slips forward, then slips backward")


class _MapData(NamedTuple):
    """The data of a map: parameters (n,) of its points, or the values on its grid's axes, and columns of values."""

    x: np.ndarray
    y: np.ndarray
    columns: dict[str, np.ndarray]
    on_grid: bool


def kind(sequence: str, outcome: str) -> str:
    """The kind of a motion in words: its first two phases; of several contacts, with the one whose mode changes."""
    if outcome in (BAD, FAILED, "crashed", "timed_out") or not sequence:
        return {BAD: "no such scene"}.get(outcome, outcome.replace("_", " "))
    (first, _), *changes = map(mode_of, sequence.split(ARROW)[:2])
    if not changes:
        return f"{_VERBS[first]} throughout"
    ((second, contact),) = changes
    return f"{_VERBS[first]}, then {_VERBS[second]}{contact and f' ({contact})'}"


def draw(
    plan: Plan, folder: Folder, place: Path, engines: Mapping[str, str], edges: Any = None, paper: bool = False
) -> Iterator[FigureEntry]:
    """Write the figures of a sweep to the folder `place`; `engines`: kinds of rows and their titles; `paper`: also as
    PDF."""
    files = file_kinds(paper)
    if len(plan.axes) == 1:
        yield save(_curve(plan, folder), place, "map", "", f"{plan.name} over {plan.axes[0].name}", "", files)
        return
    how = _caption(plan)
    figure = of_reference(plan, folder, edges)
    caption = f"Lines: time of the first transition, s. {how}"
    yield save(figure, place, "map", "", f"Map of outcomes: {plan.name}", caption, files)
    for rows, title in engines.items():
        figure = of_engine(plan, folder, rows, title)
        yield save(figure, place, f"map_{rows}", "", f"{title}: grades and errors", how, files)


def of_reference(plan: Plan, folder: Folder, edges: Any = None) -> Figure:
    """The map of the reference's motions as a figure."""
    with plt.rc_context(STYLE):
        figure, ax = plt.subplots(figsize=(7.4, 4.6), layout="constrained")
        motions(ax, plan, folder, edges)
    return figure


def motions(ax: Axes, plan: Plan, folder: Folder, edges: Any = None) -> None:
    """Draw the map of the reference's motions on the axes: first two phases, and time of the first transition."""
    data = _map_data(plan, folder, ROWS, ["sequence", "outcome", "first_time"])
    pairs = zip(data.columns["sequence"].ravel(), data.columns["outcome"].ravel(), strict=True)
    words: dict = {}
    kinds = np.array([words.setdefault(pair, kind(*(word or "" for word in pair))) for pair in pairs], dtype=object)
    order = [name for name, _ in Counter(kinds.tolist()).most_common()]
    order = order if len(order) <= MOST else [*order[: MOST - 1], _OTHER]
    number = {name: i for i, name in enumerate(order)}
    numbers = np.array([number.get(name, len(order) - 1) for name in kinds.tolist()]).reshape(
        data.columns["sequence"].shape
    )
    colours = _colours(order)
    _fill(ax, data, numbers, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(order) - 0.5, alpha=0.55)
    handles: list[Any] = [Patch(color=c, alpha=0.55, label=name) for c, name in zip(colours, order, strict=True)]
    if data.on_grid:
        _contours(ax, data, numbers)
        handles.append(Line2D([], [], color="#404040", linewidth=0.7, label="time of the first transition / s"))
    x, y = plan.axes[0].name, plan.axes[1].name
    for line, dashes in zip(boundaries.exact_boundaries(plan, x, y), ("-", "--"), strict=False):
        handles += ax.plot(line.x, line.y, color="black", linewidth=1.3, linestyle=dashes, label=line.label)
    if edges is not None and len(edges.x):
        handles += ax.plot(edges.x, edges.y, ".", color="black", markersize=1.5, label="boundary by --refine")
    _frame(ax, plan, data)
    ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)


def of_engine(plan: Plan, folder: Folder, rows: str, title: str) -> Figure:
    """Maps of an engine with default settings: grades, and errors of the first transition."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(10.4, 4.2), layout="constrained", sharey=True)
        engine_grades(axes[0], plan, folder, rows)
        axes[0].set_title(f"{title}: grades")
        data = _map_data(plan, folder, rows, ["error"])
        errors = np.abs(data.columns["error"].astype(float))
        positive = errors[np.isfinite(errors) & (errors > 0.0)]
        if positive.size:
            norm = LogNorm(positive.min(), positive.max() if positive.max() > positive.min() else 2.0 * positive.min())
            image = _fill(axes[1], data, np.where(errors > 0.0, errors, np.nan), cmap="viridis", norm=norm)
            figure.colorbar(image, ax=axes[1], label="|error| of the first transition / s")
        axes[1].set_title("error of the first transition; white: no transition in the engine or the reference")
        _frame(axes[1], plan, data)
        axes[1].set_ylabel("")
    return figure


def engine_grades(ax: Axes, plan: Plan, folder: Folder, rows: str) -> None:
    """Draw the map of the grades of an engine's motions on the axes."""
    data = _map_data(plan, folder, rows, ["grade", "outcome"])
    grade, outcome = data.columns["grade"], data.columns["outcome"]
    names = [*GRADES, "no motion"]
    number = np.full(grade.shape, len(names) - 1.0)
    for place, name in enumerate(GRADES):
        number[grade == name] = place
    number[outcome == BAD] = np.nan
    colours = [*GRADES.values(), "#404040"]
    _fill(ax, data, number, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(names) - 0.5)
    parts = [np.sum(number == i) / max(np.sum(np.isfinite(number)), 1) for i in range(len(names))]
    handles = [Patch(color=c, label=f"{n}, {p:.0%}") for c, n, p in zip(colours, names, parts, strict=True) if p > 0.0]
    for line in boundaries.exact_boundaries(plan, plan.axes[0].name, plan.axes[1].name):
        ax.plot(line.x, line.y, color="black", linewidth=0.8)
    ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
    _frame(ax, plan, data)


def _colours(kinds: Sequence[str]) -> list[str]:
    """A colour for each kind."""
    usual = dict(zip(_USUAL, _COLOURS, strict=False))
    free = (colour for colour in _COLOURS if colour not in {usual.get(name) for name in kinds})
    return [usual[name] if name in usual else next(free) for name in kinds]


# --- reading ----------------------------------------------------------------------------------------------------------


def _map_data(plan: Plan, folder: Folder, rows: str, names: list[str]) -> _MapData:
    """Read the columns for a map."""
    x, y = plan.axes[0].name, plan.axes[1].name
    if plan.sample == "grid":
        scenarios, places = _cells(plan)
        columns = _read(folder, rows, names, scenarios)
        return _MapData(plan.axes[0].all[places[0]], plan.axes[1].all[places[1]], columns, True)
    columns = _read(folder, rows, [x, y, *names], np.arange(min(len(plan), POINTS)))
    return _MapData(columns[x].astype(float), columns[y].astype(float), columns, False)


def _cells(plan: Plan) -> tuple[np.ndarray, list[np.ndarray]]:
    """The scenarios of a grid's cells (x, y), and their indices on the two axes; other axes have a middle value."""
    places = [np.unique(np.linspace(0, m - 1, min(m, CELLS)).round().astype(int)) for m in plan.shape[:2]]
    rest = [m // 2 for m in plan.shape[2:]]
    i, j = np.meshgrid(*places, indexing="ij")
    return np.ravel_multi_index((i, j, *(np.full(i.shape, k) for k in rest)), plan.shape), places


def _read(folder: Folder, rows: str, names: list[str], scenarios: np.ndarray) -> dict[str, np.ndarray]:
    """Read columns of the given scenarios, in the same shape."""
    flat = scenarios.ravel()
    order = np.argsort(flat)
    columns = {name: np.full(len(flat), None, dtype=object) for name in names}
    for part in folder.rows(rows, ["scenario", *names]):
        numbers = part.column("scenario").to_numpy()
        first, last = np.searchsorted(flat[order], [numbers[0], numbers[-1] + 1])
        indices = order[first:last]
        if indices.size:
            rows_here = part.take(np.searchsorted(numbers, flat[indices]))
            for name in names:
                columns[name][indices] = rows_here.column(name).to_numpy(zero_copy_only=False)
    return {name: column.reshape(scenarios.shape) for name, column in columns.items()}


# --- drawing ----------------------------------------------------------------------------------------------------------


def _fill(ax: Axes, data: _MapData, values: np.ndarray, **how: Any):
    if data.on_grid:
        return ax.pcolormesh(data.x, data.y, values.T, shading="nearest", rasterized=True, linewidth=0, **how)
    return ax.scatter(data.x, data.y, c=values, s=4.0, linewidths=0, rasterized=True, **how)


def _contours(ax: Axes, data: _MapData, numbers: np.ndarray) -> None:
    """Draw contours of the first transition's time, separately for each kind: the time may jump between kinds."""
    times = data.columns["first_time"].astype(float)
    finite = times[np.isfinite(times)]
    if min(times.shape) < 3 or not finite.size or np.ptp(finite) == 0.0:
        return
    levels = plt.MaxNLocator(8).tick_values(*np.quantile(finite, [0.02, 0.98]))
    for number in np.unique(numbers):
        of_kind = np.where(numbers == number, times, np.nan)
        if np.isfinite(of_kind).sum() > 0.02 * of_kind.size:
            lines = ax.contour(data.x, data.y, of_kind.T, levels=levels, colors="#404040", linewidths=0.7)
            ax.clabel(lines, fontsize=7, fmt="%g")


def _frame(ax: Axes, plan: Plan, data: _MapData) -> None:
    ax.grid(False)
    for axis, which in zip(plan.axes[:2], "xy", strict=True):
        ax.set(**{f"{which}scale": "log" if axis.log else "linear", f"{which}label": parameter_label(plan, axis.name)})
    ax.set_xlim(float(np.nanmin(data.x)), float(np.nanmax(data.x)))
    ax.set_ylim(float(np.nanmin(data.y)), float(np.nanmax(data.y)))


def _caption(plan: Plan) -> str:
    if plan.sample == "grid" and len(plan.axes) > 2:
        rest = [(axis, axis.all[len(axis) // 2]) for axis in plan.axes[2:]]
        return "Shown for " + ", ".join(f"{axis.name} = {value:g}" for axis, value in rest) + "."
    if plan.sample != "grid" and len(plan) > POINTS:
        return f"The first {POINTS} of {len(plan)} scenarios."
    return ""


def _curve(plan: Plan, folder: Folder) -> Figure:
    """The figure of the times of all transitions over one parameter."""
    name = plan.axes[0].name
    step = max(1, len(plan) // POINTS)
    xs, ys, modes = [], [], []
    for part in folder.rows(ROWS, ["scenario", name, "times", "sequence"]):
        for row in part.filter(np.asarray(part.column("scenario")) % step == 0).to_pylist():
            for time, change in zip(row["times"] or (), row["sequence"].split(ARROW)[1:], strict=True):
                xs.append(row[name])
                ys.append(time)
                modes.append(mode_of(change)[0])
    with plt.rc_context(STYLE):
        figure, ax = plt.subplots(figsize=(7.4, 4.2), layout="constrained")
        for colour, mode in zip(_COLOURS, sorted(set(modes)), strict=False):
            indices = [i for i, m in enumerate(modes) if m == mode]
            ax.plot(
                [xs[i] for i in indices],
                [ys[i] for i in indices],
                ".",
                markersize=2,
                color=colour,
                label=f"then it {_VERBS[mode]}",
            )
        if plan.axes[0].log:
            ax.set_xscale("log")
        ax.set_xlabel(parameter_label(plan, name))
        ax.set_ylabel("times of the transitions / s")
        if modes:
            ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return figure
