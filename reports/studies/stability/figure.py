"""Figures of the hard scenes: a chart of the outcomes, and the steps at which engines become unstable."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite, isnan
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from ...drawing.colours import GRADES
from ...drawing.figure_files import FigureEntry, save
from ...drawing.style import STYLE, LineStyles, logarithmic
from ...running.names import REFERENCE
from . import measure
from .measure import Stability

# Other outcomes than answers are greys, some of them hatched to be distinguishable: with lines, as dots are circles
# that would be four fifths of the file.
_FACES: dict[str, dict[str, Any]] = {
    **{grade: {"facecolor": colour} for grade, colour in GRADES.items()},
    "chaotic": {"facecolor": "#efefef", "hatch": "\\\\\\\\", "edgecolor": "#9a9a9a"},
    "unsupported": {"facecolor": "white"},
    "crashed": {"facecolor": "#555555"},
    "timed_out": {"facecolor": "#b5b5b5", "hatch": "////", "edgecolor": "#777777"},
}
_WORDS = (
    "Hard scenes, solver by solver",
    "Each cell is one route at its finest setting run; the narrow strip at its left is the engine with default "
    "settings. The colour is the grade; the number is off, the error as a share of that of ignoring friction. Next "
    "to the case: the condition number of the paper's matrix in the plate's own units, and the displacement of the "
    "centre, as a fraction of its path, by one unit in the last place of the inputs. Chaotic scenes, in which that "
    "unit decides the outcome, are not ranked.",
)
_STEP_WORDS = (
    "The step at which an engine becomes unstable",
    "Largest step that works (right end of the bar) and smallest that fails (cross), by bisection with all other "
    "parameters from a middle rung, as a fraction of the duration. Arrow: no step up to a quarter of the duration is "
    "unstable.",
)


def draw(stability: Stability, folder: Path) -> Iterator[FigureEntry]:
    """Write both figures to the folder; yields their entries."""
    if not stability.cases:
        return
    with matplotlib.rc_context(STYLE):
        yield save(outcomes(stability), folder, "stability", "", *_WORDS)
        if stability.unstable:
            yield save(steps(stability), folder, "unstable_steps", "", *_STEP_WORDS)


def outcomes(stability: Stability) -> Figure:
    """The chart: a row for each case, a column for each route."""
    rows = measure.rows(stability)
    labels = [case.label for case in stability.cases]
    routes = list(dict.fromkeys((r["solver"], r["route"]) for r in rows if r["route"]))
    routes.sort(key=lambda route_key: (route_key[0] != REFERENCE, route_key))
    cells = {
        route_key: {
            label: [r for r in rows if r["case"] == label and (r["solver"], r["route"]) == route_key]
            for label in labels
        }
        for route_key in routes
    }
    figure, ax = plt.subplots(figsize=(2.6 + 0.95 * (len(routes) + 2), 0.9 + 0.21 * len(labels)), layout="constrained")
    for y, label in enumerate(labels):
        scene = stability.scenes[label]
        for x, value in enumerate((scene.conditioning.dimensionless, scene.spread.centre)):
            ax.text(x + 0.5, y + 0.5, _small(value), ha="center", va="center", fontsize=7, color="#555555")
        for x, route_key in enumerate(routes, start=2):
            _cell(ax, x, y, cells[route_key][label])
    ax.set_xlim(0, len(routes) + 2)
    ax.set_ylim(len(labels), 0)
    ax.set_yticks([y + 0.5 for y in range(len(labels))], labels, fontsize=7)
    ax.set_xticks(
        [x + 0.5 for x in range(len(routes) + 2)],
        ["condition", "last bit", *(f"{solver}\n{route}" for solver, route in routes)],
        fontsize=8,
    )
    ax.xaxis.tick_top()
    ax.tick_params(length=0)
    ax.grid(False)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)
    faces = [Patch(label=word.replace("_", " "), **{"edgecolor": "#777777", **face}) for word, face in _FACES.items()]
    figure.legend(handles=faces, loc="outside lower center", ncols=len(faces))
    return figure


def _cell(ax, x: int, y: int, rows: list[dict[str, Any]]) -> None:
    """Draw the finest setting's outcome, and a strip for the engine's default settings."""
    if not rows:
        return
    defaults = [row for row in rows if row["setting"].is_default]
    ladder = [row for row in rows if not row["setting"].is_default] or rows
    strip = 0.12 if defaults else 0.0
    if defaults:
        ax.add_patch(Rectangle((x + 0.03, y + 0.06), strip, 0.88, **_face(defaults[0])))
    ax.add_patch(Rectangle((x + 0.03 + strip, y + 0.06), 0.94 - strip, 0.88, **_face(ladder[-1])))
    if ladder[-1]["outcome"] in ("answered", "chaotic"):
        ax.text(x + 0.5 + strip / 2, y + 0.5, _small(ladder[-1]["off"]), ha="center", va="center", fontsize=7)


def _face(row: dict[str, Any]) -> dict[str, Any]:
    return {"edgecolor": "#d0d0d0", "linewidth": 0.4, **_FACES[row["grade"] or row["outcome"]]}


def _small(value: float) -> str:
    if isnan(value):
        return ""
    if not isfinite(value):
        return "decides"
    if 0.5 <= abs(value) < 995.0:
        return f"{float(f'{value:.0e}'):g}"
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e") if value else "0"


def steps(stability: Stability) -> Figure:
    """The figure of the brackets of the unstable step, case by case."""
    brackets = [b for b in stability.unstable if isfinite(b.works) or isfinite(b.fails)]
    durations = {case.label: case.duration for case in stability.cases}
    figure, ax = plt.subplots(figsize=(7.4, 0.9 + 0.26 * max(len(brackets), 1)), layout="constrained")
    looks = LineStyles((b.solver, b.route) for b in brackets)
    for y, b in enumerate(brackets):
        colour, whole = looks.colour(b.solver), durations[b.case]
        if isfinite(b.works):
            ax.plot([1e-6, b.works / whole], [y, y], color=colour, linewidth=4, solid_capstyle="butt")
        if isfinite(b.fails):
            ax.plot(b.fails / whole, y, marker="x", color=colour, markersize=7)
        else:
            ax.plot(b.works / whole, y, marker=">", color=colour, markersize=7)
    ax.set_yticks(range(len(brackets)), [f"{b.case}: {b.solver}, {b.route}" for b in brackets], fontsize=7.5)
    logarithmic(ax, "x")
    lowest = min((b.fails if not isfinite(b.works) else b.works) / durations[b.case] for b in brackets)
    ax.set_xlim(0.3 * lowest, 1.0)
    ax.set_xlabel("step / duration")
    ax.set_ylim(len(brackets) - 0.5, -0.5)
    return figure
