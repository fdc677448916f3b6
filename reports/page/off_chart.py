"""The chart of the first screen: off against cost of every setting of one case, as numbers for its SVG template."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from math import ceil, floor, isfinite, log10
from typing import Any

from ..analysis.number_format import number, seconds
from ..judging.grades import LIMITS, percent
from ..running.names import REFERENCE
from .fragments import identifier, switch

WIDTH, HEIGHT = 520, 290
_LEFT, _RIGHT, _TOP, _BOTTOM = 58, 494, 8, 246
# Smaller values of off are drawn at the lower edge: they depend on the samples.
_LEAST = 1e-6
# Paths of the markers, 8 pixels wide, by the place of a route among all.
_MARKERS = (
    "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z",
    "M-3.6-3.6h7.2v7.2h-7.2z",
    "M0-4.6L4.4 3.4H-4.4z",
    "M0-5L5 0L0 5L-5 0z",
)
CALL, STEPS = "call_s", "steps"
NATIVE = "native"


def off_chart(
    case: str, trajectories: Sequence[Mapping[str, Any]], timings: Sequence[Mapping[str, Any]]
) -> dict[str, Any] | None:
    """Data of the chart of a case from rows of the tables `trajectories` and `work_precision`; None without a point.

    The cost is the whole call's CPU time, or where nothing was timed the number of steps.
    """
    times = {_key(row): row[CALL] for row in timings if row["case"] == case and row["quantity"] == "off"}
    cost = CALL if any(isfinite(time) for time in times.values()) else STEPS
    points, without_time = dict[tuple[str, str], list[dict[str, Any]]](), 0
    for row in trajectories:
        work = times.get(_key(row), float("nan")) if cost == CALL else row["steps"]
        if cost == STEPS and row["solver"] == REFERENCE:
            continue  # its steps are of another kind
        if row["case"] != case or not isfinite(row["off"]):
            continue
        without_time += not isfinite(work)
        if work > 0.0:
            point = {"work": float(work), "off": row["off"], "doubt": row["off_doubt"], "setting": str(row["setting"])}
            point["default"] = point["setting"].startswith("rung=defaults")
            points.setdefault((row["solver"], row["route"]), []).append(point)
    if not points:
        return None
    every = [point for line in points.values() for point in line]
    x = LogAxis([point["work"] for point in every], _LEFT, _RIGHT)
    y = LogAxis([max(point["off"], _LEAST) for point in every], _BOTTOM, _TOP)
    # Routes of engines have the first markers, native the very first.
    names = sorted(
        dict.fromkeys(key for key in points), key=lambda key: (key[0] == REFERENCE, key[1] != NATIVE, key[1])
    )
    markers = dict(zip(dict.fromkeys(route for _, route in names), cycle(_MARKERS), strict=False))
    return {
        "case": case,
        "cost": cost,
        "without_time": without_time,
        "box": {"left": _LEFT, "right": _RIGHT, "top": _TOP, "bottom": _BOTTOM, "width": WIDTH, "height": HEIGHT},
        "ticks_x": [{"at": x(value), "text": _cost_text(value, cost)} for value in x.ticks()],
        "ticks_y": [{"at": y(value), "text": percent(value).replace(" ", "\u202f")} for value in y.ticks()],
        "bands": _bands(y),
        "lines": [_line(key, line, x, y, markers[key[1]], cost) for key, line in points.items()],
    }


def _key(row: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(str(row[name]) for name in ("case", "solver", "route", "setting"))


class LogAxis:
    """A logarithmic axis over whole decades: from a value to pixels."""

    def __init__(self, values: Iterable[float], begin: float, end: float):
        powers = [log10(value) for value in values]
        self.low, self.high = floor(min(powers)), max(ceil(max(powers)), floor(min(powers)) + 1)
        self.begin, self.end = begin, end

    def __call__(self, value: float) -> float:
        share = (log10(value) - self.low) / (self.high - self.low)
        return round(self.begin + min(max(share, 0.0), 1.0) * (self.end - self.begin), 1)

    def ticks(self) -> list[float]:
        """Powers of ten, at most nine."""
        step = ceil((self.high - self.low) / 8)
        return [10.0**power for power in range(self.low, self.high + 1, step)]


def _bands(y: LogAxis) -> list[dict[str, Any]]:
    """The grades, from the best at the lower edge."""
    bands, below = [], y(10.0**y.low)
    for name, limit in [*LIMITS.items(), ("unusable", 10.0**y.high)]:
        above = y(limit)
        if below > above:
            bands.append({"name": str(name), "y": above, "height": round(below - above, 1)})
        below = min(below, above)
    return bands


def _line(
    key: tuple[str, str], points: Sequence[Mapping[str, Any]], x: LogAxis, y: LogAxis, marker: str, cost: str
) -> dict[str, Any]:
    solver, route = key
    marks = [
        {
            "x": x(point["work"]),
            "y": y(max(point["off"], _LEAST)),
            "bar": [y(max(point["off"] + sign * point["doubt"], _LEAST)) for sign in (-1.0, 1.0)],
            "default": point["default"],
            "tip": f"{solver} {route}, {point['setting']}: {percent(point['off'])} ± "
            f"{percent(point['doubt'])} off, "
            + (f"{seconds(point['work'])}" if cost == CALL else f"{number(point['work'])} steps"),
        }
        for point in points
    ]
    ladder = [mark for mark in marks if not mark["default"]]
    return {
        "solver": solver,
        "route": route,
        "switch": switch(solver, route),
        "id": identifier(solver),
        "marker": marker,
        "is_dashed": route != NATIVE and bool(switch(solver, route)),
        "path": "".join(f"{'L' if i else 'M'}{mark['x']} {mark['y']}" for i, mark in enumerate(ladder)),
        "marks": marks,
    }


def _cost_text(value: float, cost: str) -> str:
    return seconds(value).replace(" ", "\u202f") if cost == CALL else number(value)
