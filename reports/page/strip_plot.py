"""The strip plot of the first screen: one dot per scene for each engine, with usual settings and at the finest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from statistics import median
from typing import Any

from ..analysis import verdict
from ..analysis.verdict_text import off_text
from ..judging.grades import LIMITS, percent
from .chapters import anchor
from .fragments import identifier
from .off_chart import LogAxis

WIDTH, ROW, _LEFT, _RIGHT, _TOP = 640, 46, 118, 604, 26
# Off below and above is drawn at the edges: below it is the error of samples, above a motion of its own.
_LOW, _HIGH = 1e-6, 10.0
_AXIS = LogAxis((_LOW, _HIGH), _LEFT, _RIGHT)
# Heights of neighbouring dots, pixels from the middle of a row: a fixed order, so that a page is made again as it was.
_HEIGHTS = (0, -8, 6, -4, 10, -11, 3, -7, 9, -2, 12)


def strip_plot(
    verdicts: Sequence[Mapping[str, Any]], offs: Mapping[verdict.Key, Mapping[str, verdict.SceneOffs]]
) -> dict[str, Any] | None:
    """Data of the plot: rows of dots, medians, and the axis; None without an engine. `offs`: errors by route and
    scene."""
    keys = [(row["solver"], row["route"]) for row in verdicts if verdict.is_engine(row) and row["answered"]]
    if not keys:
        return None
    common = set.intersection(*(set(offs[key]) for key in keys))
    rows = list[dict[str, Any]]()
    for key in keys:
        for words in ("usual", "finest"):
            values = {case: own.default if words == "usual" else own.finest.off for case, own in offs[key].items()}
            values = {case: off for case, off in values.items() if isfinite(off)}
            if values:
                rows.append(_row(key, words, values, common, _TOP + ROW * (len(rows) + 0.5)))
    bottom = _TOP + ROW * len(rows)
    return {
        "width": WIDTH,
        "height": bottom + 34,
        "top": _TOP,
        "bottom": bottom,
        "left": _LEFT,
        "right": _RIGHT,
        "rows": rows,
        "ticks": [{"x": _place(off), "text": _tick(off)} for off in _AXIS.ticks()],
        "grades": _grades(),
        "many": len(common),
    }


def _row(key: tuple[str, str], words: str, values: Mapping[str, float], common: set[str], y: float) -> dict[str, Any]:
    solver, route = key
    dots = [
        {
            "x": _place(off),
            "y": y + _HEIGHTS[i % len(_HEIGHTS)],
            "href": f"#{anchor(case)}",
            "is_common": case in common,
            "tip": f"{case}: {percent(off)} off, {solver}, {words} settings",
        }
        for i, (case, off) in enumerate(sorted(values.items(), key=lambda item: item[1]))
    ]
    middle = median(values.values())
    x, is_far = _place(middle), _place(middle) > _RIGHT - 70
    of_median = {
        "x": x,
        "text": off_text(middle),
        "anchor": "end" if is_far else "start",
        "text_x": x - 5 if is_far else x + 5,
    }
    return {
        "solver": solver, "route": route, "id": identifier(solver), "words": f"{words} settings", "y": y, "dots": dots,
        "median": of_median,
    }  # fmt: skip


def _place(off: float) -> float:
    return _AXIS(max(off, _LOW))


def _tick(off: float) -> str:
    text = f"{100.0 * off:,g}\u202f%"
    return f"≤\u202f{text}" if off <= _LOW else text


def _grades() -> list[dict[str, Any]]:
    """The names of grades between their limits."""
    edges = [_LOW, *LIMITS.values(), _HIGH]
    names = [*map(str, LIMITS), "unusable"]
    return [
        {"text": name, "x": 0.5 * (_place(low) + _place(high)), "edge": _place(high)}
        for name, low, high in zip(names, edges[:-1], edges[1:], strict=True)
    ]
