"""Figures of the study: CPU time and change of the motion, effect by effect, for each scene."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from reports.drawing.figure_files import FigureEntry, save
from reports.drawing.style import FAINT, STYLE, LineStyles, logarithmic
from reports.running.names import REFERENCE

from .measure import SCENES, stages

# Part of an effect's column that the solvers' points fill.
_WIDTH = 0.7
_WORDS = (
    "What each effect costs",
    "One scene with its effects added one at a time from left to right. Above: CPU time of the run with all effects up "
    "to this one (median, each solver at one setting; hollow: timing disturbed by other load; cross: the motion ended "
    "early, at a lift-off or a landing that the effects so far do not cover, so its time is of a shorter motion). "
    "Below: change of the motion when the effect is added, which is the error without it (after its end, a motion "
    "stays at its last position). A solver that does not support an effect has no point there.",
)


def draw(rows: Sequence[dict[str, Any]], folder: Path) -> Iterator[FigureEntry]:
    """Write one figure for each scene; yields the entries of the figures."""
    with matplotlib.rc_context(STYLE):
        for scene in SCENES:
            scene_rows = [row for row in rows if row["scene"] == scene]
            if scene_rows:
                yield save(_figure(scene, scene_rows), folder, f"effect_costs_{scene}", "", *_WORDS)


def _figure(scene: str, rows: Sequence[dict[str, Any]]) -> Figure:
    names = [stage.effect for stage in stages(scene)]
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(8.0, 6.4), sharex=True, height_ratios=(3, 2), layout="constrained"
    )
    looks = LineStyles((row["solver"], row["route"]) for row in rows)
    solver_routes = sorted(
        {(row["solver"], row["route"]) for row in rows if row["outcome"] == "done"},
        key=lambda w: (w[0] != REFERENCE, w),
    )
    shifts = np.linspace(-_WIDTH / 2, _WIDTH / 2, max(len(solver_routes), 2))
    for (name, route), shift in zip(solver_routes, shifts, strict=False):
        colour, marker = looks.colour(name), looks.marker(name, route)
        above.plot([], [], linestyle="", marker=marker, color=colour, label=f"{name}, {route}")
        for row in rows:
            if (row["solver"], row["route"]) != (name, route) or not row["cpu_s"] > 0.0:
                continue
            place, face = names.index(row["effect"]) + shift, "white" if row["disturbed"] else colour
            above.plot(place, row["cpu_s"], marker=marker, color=colour, markerfacecolor=face)
            if row["status"] != "completed":
                above.plot(place, row["cpu_s"], marker="x", markersize=9, color="black", markeredgewidth=0.9)
    if any(row["status"] not in ("", "completed") for row in rows):
        above.plot([], [], linestyle="", marker="x", color="black", label="motion ended early")
    for boundary in range(1, len(names)):
        above.axvline(boundary - 0.5, color=FAINT, linewidth=0.5)
    above.grid(axis="x", visible=False)
    changes = [row for row in rows if (row["solver"], row["route"]) == solver_routes[0]] if solver_routes else []
    below.bar([names.index(row["effect"]) for row in changes], [row["change_m"] for row in changes], 0.5, color=FAINT)
    above.set(ylabel="CPU time of the run / s")
    below.set(
        yscale="symlog",
        ylabel="change of the motion / m",
        xticks=range(len(names)),
        xticklabels=[f"{'+ ' if place else ''}{_in_words(name)}" for place, name in enumerate(names)],
    )
    below.set_yscale("symlog", linthresh=1e-6)
    logarithmic(above, "y")
    figure.legend(*above.get_legend_handles_labels(), loc="outside upper center", ncols=4, title=_in_words(scene, " "),
                  title_fontproperties={"weight": "bold"})  # fmt: skip
    return figure


def _in_words(name: str, between: str = "\n") -> str:
    """The name of a class or a scene in words: "CoulombFriction" is "coulomb friction" in two lines."""
    return between.join(re.findall(r"[A-Z]?[a-z]+", name)).lower().replace("coulomb", "Coulomb")
