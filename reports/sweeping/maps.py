"""Maps of a sweep: what follows over two parameters, when, and where engines get it wrong.

Rows are read part by part, and of a grid only those that a picture can show: memory does not grow with the sweep.
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
from reference.sweeping.table import ARROW, BAD, FAILED

from ..drawing.files import Drawn, save
from ..drawing.style import AREAS, STYLE, logarithmic
from . import boundaries
from .folder import Folder
from .run import ROWS

# Cells to a side of a picture, and points of a sampled one.
CELLS, POINTS = 500, 20_000
# More kinds of motion than this are drawn as one.
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
# What is met most has its colour, the same in every map; the rest takes what is left.
_USUAL = ("slips forward, then rolls", "rolls throughout", "slips forward, then slips backward")
_SIGNS = {"mu": "μ", "xi1": "ξ₁ / rad"}


class Mark(NamedTuple):
    """A point of its own on a map, and what is said of it."""

    x: float
    y: float
    label: str


class _Shown(NamedTuple):
    """What a picture shows: the parameters (n,) of its points, or the edges of its grid's axes, and columns of each."""

    x: np.ndarray
    y: np.ndarray
    columns: dict[str, np.ndarray]
    on_grid: bool


def kind(sequence: str, outcome: str) -> str:
    """A motion in a few words: what it begins with, and what follows."""
    if outcome in (BAD, FAILED, "crashed", "timed_out") or not sequence:
        return {BAD: "no such scene"}.get(outcome, outcome.replace("_", " "))
    verbs = [_VERBS[Mode(mode)] for mode in sequence.split(ARROW)[:2]]
    return f"{verbs[0]}, then {verbs[1]}" if len(verbs) > 1 else f"{verbs[0]} throughout"


def counts(folder: Folder) -> Counter[str]:
    """How many scenarios of each kind."""
    found: Counter[str] = Counter()
    for rows in folder.rows(ROWS, ["sequence", "outcome"]):
        pairs = rows.group_by(["sequence", "outcome"]).aggregate([([], "count_all")]).to_pylist()
        for row in pairs:
            found[kind(row["sequence"] or "", row["outcome"])] += row["count_all"]
    return found


def draw(plan: Plan, folder: Folder, place: Path, engines: Mapping[str, str], edges: Any = None) -> Iterator[Drawn]:
    """Write the pictures of a sweep into the folder `place`; `engines`: kinds of rows and their titles."""
    if len(plan.axes) == 1:
        yield save(_curve(plan, folder), place, "map", "", f"{plan.name} over {plan.axes[0].name}", "", png=True)
        return
    how = _caption(plan)
    figure = of_reference(plan, folder, edges)
    yield save(figure, place, "map", "", f"What follows: {plan.name}", f"Lines: when, s. {how}", png=True)
    for rows, title in engines.items():
        figure = of_engine(plan, folder, rows, title)
        yield save(figure, place, f"map_{rows}", "", f"{title}: wrong verdicts and errors", how, png=True)


def of_reference(plan: Plan, folder: Folder, edges: Any = None, marks: Sequence[Mark] = ()) -> Figure:
    """What follows the first phase, and when."""
    with plt.rc_context(STYLE):
        figure, ax = plt.subplots(figsize=(7.4, 4.6), layout="constrained")
        motions(ax, plan, folder, edges, marks)
    return figure


def motions(ax: Axes, plan: Plan, folder: Folder, edges: Any = None, marks: Sequence[Mark] = ()) -> None:
    """The map of the reference's motions on these axes."""
    shown = _shown(plan, folder, ROWS, ["sequence", "outcome", "first_time"])
    pairs = zip(shown.columns["sequence"].ravel(), shown.columns["outcome"].ravel(), strict=True)
    words: dict = {}
    kinds = np.array([words.setdefault(pair, kind(*(word or "" for word in pair))) for pair in pairs], dtype=object)
    order = [name for name, _ in Counter(kinds.tolist()).most_common()]
    order = order if len(order) <= MOST else [*order[: MOST - 1], _OTHER]
    number = {name: i for i, name in enumerate(order)}
    numbers = np.array([number.get(name, len(order) - 1) for name in kinds.tolist()]).reshape(
        shown.columns["sequence"].shape
    )
    colours = _colours(order)
    _fill(ax, shown, numbers, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(order) - 0.5, alpha=0.55)
    handles: list[Any] = [Patch(color=c, alpha=0.55, label=name) for c, name in zip(colours, order, strict=True)]
    if shown.on_grid:
        _contours(ax, shown, numbers)
        handles.append(Line2D([], [], color="#404040", linewidth=0.7, label="time of the first transition / s"))
    x, y = plan.axes[0].name, plan.axes[1].name
    for line, dashes in zip(boundaries.known(plan, x, y), ("-", "--"), strict=False):
        handles += ax.plot(line.x, line.y, color="black", linewidth=1.3, linestyle=dashes, label=line.label)
    if edges is not None and len(edges.x):
        handles += ax.plot(edges.x, edges.y, ".", color="black", markersize=1.5, label="boundary found by --refine")
    for mark in marks:
        ax.plot(mark.x, mark.y, "o", color="white", markeredgecolor="black", markersize=6, clip_on=False, zorder=5)
        ax.annotate(
            mark.label, (mark.x, mark.y), xytext=(7, 8), textcoords="offset points", fontsize=8.5, zorder=5,
            bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 1.0},
        )  # fmt: skip
    _frame(ax, plan, shown)
    ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)


def of_engine(plan: Plan, folder: Folder, rows: str, title: str) -> Figure:
    """Where an engine as it comes is wrong, and by how much it misses the first transition."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(10.4, 4.2), layout="constrained", sharey=True)
        verdicts(axes[0], plan, folder, rows)
        axes[0].set_title(f"{title}: verdicts")
        shown = _shown(plan, folder, rows, ["error"])
        errors = np.abs(shown.columns["error"].astype(float))
        known = errors[np.isfinite(errors) & (errors > 0.0)]
        if known.size:
            norm = LogNorm(known.min(), known.max() if known.max() > known.min() else 2.0 * known.min())
            drawn = _fill(axes[1], shown, np.where(errors > 0.0, errors, np.nan), cmap="viridis", norm=norm)
            figure.colorbar(drawn, ax=axes[1], label="|error| of the first transition / s")
        axes[1].set_title("error of the first transition; white: it or the reference has none")
        _frame(axes[1], plan, shown)
        axes[1].set_ylabel("")
    return figure


def verdicts(ax: Axes, plan: Plan, folder: Folder, rows: str) -> None:
    """The map of an engine's verdicts on these axes."""
    shown = _shown(plan, folder, rows, ["verdict", "outcome"])
    verdict, outcome = shown.columns["verdict"], shown.columns["outcome"]
    names = ("right", "wrong", "no motion")
    number = np.where(verdict == "right", 0, np.where(verdict == "wrong", 1, 2))
    number = np.where(outcome == BAD, -1, number)
    colours = ("#d9d9d9", AREAS[1], "#404040")
    _fill(ax, shown, np.where(number < 0, np.nan, number), cmap=ListedColormap(colours), vmin=-0.5, vmax=2.5)
    parts = [np.sum(number == i) / max(np.sum(number >= 0), 1) for i in range(3)]
    handles = [Patch(color=c, label=f"{n}, {p:.0%}") for c, n, p in zip(colours, names, parts, strict=True) if p > 0.0]
    for line in boundaries.known(plan, plan.axes[0].name, plan.axes[1].name):
        ax.plot(line.x, line.y, color="black", linewidth=0.8)
    ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
    _frame(ax, plan, shown)


def _colours(kinds: Sequence[str]) -> list[str]:
    """A colour for each kind."""
    usual = dict(zip(_USUAL, _COLOURS, strict=False))
    free = (colour for colour in _COLOURS if colour not in {usual.get(name) for name in kinds})
    return [usual[name] if name in usual else next(free) for name in kinds]


# --- reading ----------------------------------------------------------------------------------------------------------


def _shown(plan: Plan, folder: Folder, rows: str, names: list[str]) -> _Shown:
    """Columns of what a picture shows."""
    x, y = plan.axes[0].name, plan.axes[1].name
    if plan.sample == "grid":
        wanted, places = _cells(plan)
        columns = _read(folder, rows, names, wanted)
        return _Shown(plan.axes[0].all[places[0]], plan.axes[1].all[places[1]], columns, True)
    columns = _read(folder, rows, [x, y, *names], np.arange(min(len(plan), POINTS)))
    return _Shown(columns[x].astype(float), columns[y].astype(float), columns, False)


def _cells(plan: Plan) -> tuple[np.ndarray, list[np.ndarray]]:
    """The scenarios of a grid's cells (x, y), and their places on the two axes; others take a middle value."""
    places = [np.unique(np.linspace(0, m - 1, min(m, CELLS)).round().astype(int)) for m in plan.shape[:2]]
    rest = [m // 2 for m in plan.shape[2:]]
    i, j = np.meshgrid(*places, indexing="ij")
    return np.ravel_multi_index((i, j, *(np.full(i.shape, k) for k in rest)), plan.shape), places


def _read(folder: Folder, rows: str, names: list[str], wanted: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of those scenarios, in their shape."""
    flat = wanted.ravel()
    order = np.argsort(flat)
    found = {name: np.full(len(flat), None, dtype=object) for name in names}
    for part in folder.rows(rows, ["scenario", *names]):
        numbers = part.column("scenario").to_numpy()
        first, last = np.searchsorted(flat[order], [numbers[0], numbers[-1] + 1])
        some = order[first:last]
        if some.size:
            taken = part.take(np.searchsorted(numbers, flat[some]))
            for name in names:
                found[name][some] = taken.column(name).to_numpy(zero_copy_only=False)
    return {name: column.reshape(wanted.shape) for name, column in found.items()}


# --- drawing ----------------------------------------------------------------------------------------------------------


def _fill(ax: Axes, shown: _Shown, values: np.ndarray, **how: Any):
    if shown.on_grid:
        return ax.pcolormesh(shown.x, shown.y, values.T, shading="nearest", rasterized=True, linewidth=0, **how)
    return ax.scatter(shown.x, shown.y, c=values, s=4.0, linewidths=0, rasterized=True, **how)


def _contours(ax: Axes, shown: _Shown, numbers: np.ndarray) -> None:
    """When the first transition is; over each kind of motion by itself, for it may jump between them."""
    times = shown.columns["first_time"].astype(float)
    known = times[np.isfinite(times)]
    if min(times.shape) < 3 or not known.size or np.ptp(known) == 0.0:
        return
    levels = plt.MaxNLocator(8).tick_values(*np.quantile(known, [0.02, 0.98]))
    for number in np.unique(numbers):
        of_kind = np.where(numbers == number, times, np.nan)
        if np.isfinite(of_kind).sum() > 0.02 * of_kind.size:
            lines = ax.contour(shown.x, shown.y, of_kind.T, levels=levels, colors="#404040", linewidths=0.7)
            ax.clabel(lines, fontsize=7, fmt="%g")


def _frame(ax: Axes, plan: Plan, shown: _Shown) -> None:
    ax.grid(False)
    for axis, which in zip(plan.axes[:2], "xy", strict=True):
        if axis.log:
            logarithmic(ax, which)
        ax.set(**{f"{which}label": _SIGNS.get(axis.name, axis.name)})
    ax.set_xlim(float(np.nanmin(shown.x)), float(np.nanmax(shown.x)))
    ax.set_ylim(float(np.nanmin(shown.y)), float(np.nanmax(shown.y)))


def _caption(plan: Plan) -> str:
    if plan.sample == "grid" and len(plan.axes) > 2:
        rest = [(axis, axis.all[len(axis) // 2]) for axis in plan.axes[2:]]
        return "Shown for " + ", ".join(f"{axis.name} = {value:g}" for axis, value in rest) + "."
    if plan.sample != "grid" and len(plan) > POINTS:
        return f"The first {POINTS} of {len(plan)} scenarios."
    return ""


def _curve(plan: Plan, folder: Folder) -> Figure:
    """The times of all transitions over one parameter."""
    name = plan.axes[0].name
    step = max(1, len(plan) // POINTS)
    xs, ys, modes = [], [], []
    for part in folder.rows(ROWS, ["scenario", name, "times", "sequence"]):
        for row in part.filter(np.asarray(part.column("scenario")) % step == 0).to_pylist():
            for time, mode in zip(row["times"] or (), row["sequence"].split(ARROW)[1:], strict=True):
                xs.append(row[name])
                ys.append(time)
                modes.append(mode)
    with plt.rc_context(STYLE):
        figure, ax = plt.subplots(figsize=(7.4, 4.2), layout="constrained")
        for colour, mode in zip(_COLOURS, sorted(set(modes)), strict=False):
            some = [i for i, m in enumerate(modes) if m == mode]
            ax.plot(
                [xs[i] for i in some],
                [ys[i] for i in some],
                ".",
                markersize=2,
                color=colour,
                label=f"then it {_VERBS[Mode(mode)]}",
            )
        if plan.axes[0].log:
            logarithmic(ax, "x")
        ax.set_xlabel(_SIGNS.get(name, name))
        ax.set_ylabel("transitions / s")
        if modes:
            ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return figure
