"""Figures of the study: CPU time and change of the motion, effect by effect, for each scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from ...drawing.figure_files import FigureEntry, save
from ...drawing.style import FAINT, STYLE, LineStyles
from ...running.records import REFERENCE
from .measure import SCENES, stages

_WORDS = (
    "What each effect costs",
    "One scene with its effects added one at a time from left to right. Above: CPU time of the run with all effects up "
    "to this one (median, each solver at one setting; hollow: timing disturbed by other load). Below: change of the "
    "motion when the effect is added, which is the error without it (after its end, a motion stays at its last "
    "position). A solver that does not support an effect has no point there.",
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
    figure, (above, below) = plt.subplots(2, 1, figsize=(8.0, 6.0), sharex=True, height_ratios=(3, 2))
    looks = LineStyles((row["solver"], row["route"]) for row in rows)
    solver_routes = sorted(
        {(row["solver"], row["route"]) for row in rows if row["outcome"] == "done"},
        key=lambda w: (w[0] != REFERENCE, w),
    )
    for name, route in solver_routes:
        look = looks.line(name, route)
        route_rows = [row for row in rows if (row["solver"], row["route"]) == (name, route) and row["cpu_s"] > 0.0]
        places = [names.index(row["effect"]) for row in route_rows]
        above.plot(places, [row["cpu_s"] for row in route_rows], marker=looks.marker(name, route), **look,
                   label=f"{name}, {route}")  # fmt: skip
        hollow = [row for row in route_rows if row["disturbed"]]
        places = [names.index(row["effect"]) for row in hollow]
        above.plot(places, [row["cpu_s"] for row in hollow], linestyle="", marker=looks.marker(name, route),
                   color=look["color"], markerfacecolor="white")  # fmt: skip
    changes = [row for row in rows if (row["solver"], row["route"]) == solver_routes[0]] if solver_routes else []
    below.bar([names.index(row["effect"]) for row in changes], [row["change_m"] for row in changes], 0.5, color=FAINT)
    above.set(yscale="log", ylabel="CPU time of the run / s")
    below.set(
        yscale="symlog",
        ylabel="change of the motion / m",
        xticks=range(len(names)),
        xticklabels=[f"+ {n}" for n in names],
    )
    below.set_yscale("symlog", linthresh=1e-6)
    below.tick_params(axis="x", labelrotation=18)
    above.legend(fontsize="small", ncols=2)
    figure.tight_layout()
    return figure
