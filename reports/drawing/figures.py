"""Every figure of runs as data: the slip of all engines, one case with its engines, error against cost, all scenes.

Times in s, lengths in m, angles in rad.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isfinite, nan
from statistics import median
from typing import Any

import numpy as np

from cases import Case, Mode
from cases.errors import unknown_name
from cases.pictures.plots import LABELS

from ..analysis.number_format import number, seconds
from ..analysis.verdict import Key, SceneOffs
from ..judging.grades import LEVELS, percent
from ..judging.phases import phases_of
from ..running.names import REFERENCE
from ..running.records import Experiment, Run, Truth, default, finest, first_error, is_truth, routes
from .colours import LineStyles
from .traces import Diagram, Panel, PlotAxis, Span, Trace

# Smallest error on a logarithmic axis in SI units, and smallest off: below are rounding, and the samples.
_SMALLEST, LEAST_OFF = 1e-17, 1e-6
# Off beyond this is drawn at the edge: a motion of its own.
MOST_OFF = 10.0
# Points along a line: enough for a panel, and few enough for a small page.
POINTS = 160
# The headline shows this many times the largest error of the first transition on both sides of it, but at least and at
# most these parts of the duration.
_ERRORS_SHOWN, _WINDOW = 3.0, (0.02, 0.1)
# A line is visibly apart from the truth by this part of the axis.
_VISIBLE = 0.03
# A plate that turns by less within a phase does not roll, rad; and the words of modes.
_STILL = 1e-9
_WORDS = {
    "slide": "slides",
    "slip_forward": "slip v > 0",
    "slip_backward": "slip v < 0",
    "roll": "rolls",
    "rest": "rests",
}
_TIME = PlotAxis("time / s")
# The differences by the names of the quantities that are compared, with the unit of each.
_OFF = {
    "slip": ("slip", "m/s"), "normal_force": ("normal_force", "N"), "theta": ("angle", "rad"), "x": ("x", "m"),
    "y": ("y", "m"), "xi1": ("xi1", ""), "xi2": ("xi2", ""),
}  # fmt: skip
# Heights of neighbouring dots of the strip in shares of a row: a fixed order, so that a page is made again as it was.
_HEIGHTS = (0, -8, 6, -4, 10, -11, 3, -7, 9, -2, 12)


def looks_of(experiment: Experiment) -> LineStyles:
    """The line styles of all solvers and routes of an experiment."""
    return LineStyles((run.solver, run.route) for run in experiment.runs)


# --- motions ----------------------------------------------------------------------------------------------------------


def headline(experiment: Experiment, case: Case) -> Diagram:
    """Slip velocity of every engine with default settings: the whole motion, the first transition, and the errors."""
    truth, runs = experiment.truths[case.label], with_defaults(experiment, case.label)
    whole = _curves(truth, runs, "slip")
    window = _window(truth, runs)
    near = [_inside(trace, *window) for trace in whole.traces]
    first = Panel(
        _TIME._replace(low=window[0], high=window[1]), _room(whole.y.label, near),
        tuple(trace._replace(label="") for trace in near), "the first transition", _spans(truth, window),
    )  # fmt: skip
    return Diagram(
        f"Slip velocity in {case.label}, default settings",
        "Above: the whole motion. Below: the first transition, where engines are early or late, and each engine's "
        "absolute difference from the true slip velocity. Vertical lines: the true transitions, whose error bars are "
        "far smaller than the lines' width.",
        ((whole,), (first, _errors(truth, runs, "slip"))),
    )


def motion(experiment: Experiment, case: Case) -> Diagram:
    """A case with the finest setting of every route: slip velocity and normal force, and the differences from the truth
    of slip, force, rotation and centre. In flight there is no contact."""
    truth = experiment.truths[case.label]
    groups = routes(run for run in experiment.runs if run.case == case.label).values()
    runs = [run for group in groups if (run := finest(group)) and not is_truth(run, truth)]
    rows = [
        (_curves(truth, runs, "slip"), _errors(truth, runs, "slip")),
        (_curves(truth, runs, "normal_force"), _errors(truth, runs, "normal_force")),
        (_errors(truth, runs, "theta"), _errors(truth, runs, "y")),
    ]
    words = "Every route at its finest setting run, and its absolute difference from the truth."
    return Diagram(f"{case.label}, finest settings", words, tuple(rows))


def comparison(label: str, truth: Truth, runs: Sequence[Run], quantity: str) -> Diagram:
    """One quantity of some motions against time, and its difference from the truth; raises UnknownName for a quantity
    that is not compared."""
    if quantity not in _OFF:
        raise unknown_name("quantity that is compared", quantity, _OFF)
    panels = (_curves(truth, runs, quantity),), (_errors(truth, runs, quantity),)
    return Diagram(label, "Above: the motions. Below: their absolute differences from the truth.", panels)


def with_defaults(experiment: Experiment, label: str) -> list[Run]:
    """The run of every engine's route with default settings; the finest for a motion that has none, as from a file."""
    groups = routes(run for run in experiment.runs if run.case == label and run.solver != REFERENCE).values()
    runs = [default(group) or finest(group) for group in groups]
    return [run for run in runs if run is not None and len(run.off.get("t", ()))]


def _name(run: Run) -> str:
    return f"{run.solver}, {run.route}" if run.route else run.solver


def _curves(truth: Truth, runs: Sequence[Run], quantity: str) -> Panel:
    """A quantity of the truth and of the runs against time; the truth sets the axis, so that a noisy force of one
    engine does not flatten the other curves. With several contacts, while the first one is closed."""
    t, values = truth.samples["t"], truth.samples[quantity]
    spans = _spans(truth, (float(t[0]), float(t[-1])))
    is_open = _flight(truth, t) if quantity in ("slip", "normal_force") else np.zeros(len(t), dtype=bool)
    traces = [_line("", "", t, np.where(is_open, nan, values))]
    for run in runs:
        times = run.off["t"]
        line = np.interp(times, t, values) + run.off[_OFF[quantity][0]]
        if np.any(np.isfinite(line)):
            line = np.where(np.interp(times, t, is_open) > 0.0, nan, line)
            traces.append(_line(run.solver, run.route, times, line, _name(run), run.off[_OFF[quantity][0]]))
    room = _room(LABELS[quantity], traces if quantity == "slip" else traces[:1])
    if len(traces) > 2:  # a line that the eye cannot tell from the truth has no name here
        least = _VISIBLE * ((room.high or 0.0) - (room.low or 0.0))
        large = {_name(run): np.nanmax(np.abs(run.off[_OFF[quantity][0]]), initial=0.0) > least for run in runs}
        traces = [trace._replace(label=trace.label if large.get(trace.label) else "") for trace in traces]
    return Panel(_TIME, room, tuple(traces), spans=spans)


def _errors(truth: Truth, runs: Sequence[Run], quantity: str) -> Panel:
    """The absolute differences from the truth on a logarithmic axis: the largest of each group of samples."""
    name, unit = _OFF[quantity]
    traces = []
    for run in runs:
        t, size = _envelope(run.off["t"], run.off[name])
        if np.any(np.isfinite(size)):
            traces.append(Trace(run.solver, run.route, t.tolist(), size.tolist(), label=_name(run)))
    what = LABELS[quantity].partition(" / ")[0].partition(" v")[0]
    unit = f" / ({unit})" if "/" in unit else unit and f" / {unit}"
    begin, end = (float(time) for time in truth.samples["t"][[0, -1]])
    spans = tuple(span._replace(name="") for span in _spans(truth, (begin, end)))
    return Panel(
        _TIME._replace(low=begin, high=end), PlotAxis(f"error, {what}{unit}", is_log=True), tuple(traces), spans=spans
    )


def _line(
    solver: str, route: str, t: np.ndarray, values: np.ndarray, label: str = "", off: np.ndarray | None = None
) -> Trace:
    """A line of at most 2 POINTS points, whose label stands where it is farthest from the truth."""
    places = np.unique(np.linspace(0, len(t) - 1, 2 * POINTS).astype(int))
    far = np.abs(off[places]) if off is not None else np.zeros(len(places))
    at = int(np.nanargmax(far)) if np.any(np.isfinite(far)) else -1
    return Trace(solver, route, t[places].tolist(), values[places].tolist(), label=label, label_at=at)


def _inside(trace: Trace, low: float, high: float) -> Trace:
    """The trace within a window of times, with points at its ends."""
    times = np.linspace(low, high, POINTS)
    return trace._replace(x=times.tolist(), y=np.interp(times, trace.x, trace.y).tolist())


def _room(label: str, traces: Sequence[Trace]) -> PlotAxis:
    """An axis with a margin around the values; a constant has one of its own size, as its variation is rounding."""
    values = [value for trace in traces for value in trace.y if isfinite(value)] or [0.0]
    low, high = min(values), max(values)
    is_level = high - low <= max(1e-6 * abs(high), 1e-9)
    margin = 0.1 * (max(abs(high), 1.0) if is_level else high - low)
    return PlotAxis(label, low=low - margin, high=high + margin)


def _envelope(t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Largest |y| in each of at most POINTS equal groups of samples, and the times of these samples."""
    size = np.where(np.isfinite(y), np.abs(y), 0.0)
    pieces = np.array_split(np.arange(len(size)), min(POINTS, len(size)))
    top = np.array([piece[np.argmax(size[piece])] for piece in pieces if len(piece)], dtype=int)
    # A difference of zero cannot be drawn on a logarithmic axis.
    return t[top], np.where(size[top] > _SMALLEST, size[top], nan)


def is_stuck(truth: Truth, contact: str, begin: float, end: float) -> bool:
    """Whether no plate at a contact ("" for the only one) turns from one time to another: without slip it sticks."""
    sides = {side.split(" ")[0] for side in contact.split("/")}
    own = [truth.plate_samples[name] for name in sides & truth.plate_samples.keys()]
    plates = own if own and "plate" not in sides else [truth.samples, *own]
    angles = [np.interp([begin, end], plate.get("t", truth.samples["t"]), plate["theta"]) for plate in plates]
    return all(np.ptp(turn) <= _STILL for turn in angles)


def _first_contact(truth: Truth, end: float) -> tuple[str, tuple]:
    """The name of the truth's first contact where there are several, and its phases."""
    name = next(iter(truth.scales), "") if truth.has_several_contacts else ""
    first = truth.scales[name].phases[0].mode if name else truth.first_mode
    return name, phases_of(first, [t for t in truth.transitions if t.contact == name or not name], end)


def _flight(truth: Truth, t: np.ndarray) -> np.ndarray:
    """At which times the first contact is open."""
    _, phases = _first_contact(truth, float(t[-1]))
    flights = [phase for phase in phases if phase.mode is Mode.FLIGHT]
    return np.any(
        [(t >= phase.begin) & (t <= phase.end) for phase in flights] or [np.zeros(len(t), dtype=bool)], axis=0
    )


def _spans(truth: Truth, window: tuple[float, float]) -> tuple[Span, ...]:
    """The modes of the truth's first contact within a window; without slip they are shaded."""
    name, phases = _first_contact(truth, float(truth.samples["t"][-1]))
    spans: list[Span] = []
    for phase in phases:
        low, high = max(phase.begin, window[0]), min(phase.end, window[1])
        if low >= high:
            continue
        word = _WORDS.get(str(phase.mode), "flies" if not name else "open")
        if phase.mode is Mode.ROLL and is_stuck(truth, name, phase.begin, phase.end):
            word = "sticks"
        text = f"{name}: {word}" if name and not spans else word
        spans.append(Span(low, high, text, phase.mode in (Mode.ROLL, Mode.REST)))
    return tuple(spans)


def _window(truth: Truth, runs: Sequence[Run]) -> tuple[float, float]:
    """The times around the truth's first transition in which the runs differ visibly, s."""
    begin, end = (float(time) for time in truth.samples["t"][[0, -1]])
    errors = [abs(error) for run in runs if isfinite(error := first_error(run))]
    least, most = (part * (end - begin) for part in _WINDOW)
    half = min(max(_ERRORS_SHOWN * max(errors, default=0.0), least), most)
    middle = truth.transitions[0].time
    return max(begin, middle - half), min(end, middle + half)


# --- settings and scenes ----------------------------------------------------------------------------------------------


def against_cost(
    case: str,
    points: Iterable[Mapping[str, Any]],
    work: str = "call_s",
    quantity: str = "off",
    floor: float = LEAST_OFF,
) -> Diagram | None:
    """Error against cost of every setting of a case, from coarse to fine; None without a point.

    `points`: rows with solver, route, setting, `absolute_error` and `doubt`, and `work`, seconds of a whole call or the
    number of steps. What is smaller than `floor` is an arrow at the edge.
    """
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for row in points:
        if row[work] > 0.0 and isfinite(row["absolute_error"]):
            groups.setdefault((row["solver"], row["route"]), []).append(row)
    if not groups:
        return None
    is_off, is_timed = quantity == "off", work == "call_s"
    text = (lambda value: f"{percent(value)} off") if is_off else (lambda value: f"{value:.1e} s")
    cost = seconds if is_timed else (lambda value: f"{number(value)} steps")
    traces = []
    for (solver, route), rows in groups.items():
        hollow = frozenset(i for i, row in enumerate(rows) if str(row["setting"]).startswith("rung=defaults"))
        ladder = [row for i, row in enumerate(rows) if i not in hollow]
        name = f"{solver} {route}"
        pairs = [(row["absolute_error"], row["doubt"]) for row in rows]
        low, high = ([max(error + sign * doubt, floor) for error, doubt in pairs] for sign in (-1.0, 1.0))
        tips = [
            f"{name}, {row['setting']}: {text(error)} ± {text(doubt)}, {cost(row[work])}"
            for row, (error, doubt) in zip(rows, pairs, strict=True)
        ]
        line = [row[work] for row in ladder], [max(row["absolute_error"], floor) for row in ladder]
        marks = [row[work] for row in rows], [error for error, _ in pairs]
        traces += [Trace(solver, route, *line, label=name)] if ladder else []
        label = "" if ladder else name
        traces.append(Trace(solver, route, *marks, False, True, low, high, hollow, tips=tips, label=label))
    least = max(floor, min(value for trace in traces for value in trace.y if isfinite(value)))
    y = PlotAxis("off" if is_off else "error of the first transition / s", True, least, is_percent=is_off)
    x = PlotAxis("CPU time of a whole call: build, run, read / s" if is_timed else "steps", is_log=True)
    levels = tuple(level for level in LEVELS if level > least) if is_off else ()
    words = (
        "Lines: from coarse to fine. Hollow: default settings. Bars: what the samples leave in doubt. Arrows: smaller "
        "than the axis." + (" Lines across: limits of the grades." if is_off else "")
    )
    return Diagram(
        f"Error against {'cost' if is_timed else 'steps'} in {case}",
        words,
        ((Panel(x, y, tuple(traces), levels=levels),),),
    )


def against_steps(experiment: Experiment, case: Case) -> Diagram | None:
    """Off against the number of steps of every setting of a case; not of the reference, whose steps are of another
    kind. None if no setting has a motion."""
    runs = [run for run in experiment.runs if run.case == case.label and run.score and run.solver != REFERENCE]
    rows = [
        {"solver": run.solver, "route": run.route, "setting": run.setting, "steps": run.cost.steps,
         "absolute_error": run.score.off, "doubt": run.score.doubt}
        for run in runs if run.score
    ]  # fmt: skip
    return against_cost(case.label, rows, "steps")


def strip(offs: Mapping[Key, Mapping[str, SceneOffs]], address: Callable[[str], str]) -> Diagram | None:
    """Every scene as a dot, for each engine with default settings and at the finest, and the medians; None without an
    engine. `offs`: errors by route and scene; `address` of a scene. Full dots are scenes that all engines run."""
    offs = {key: own for key, own in offs.items() if own}
    if not offs:
        return None
    common = set.intersection(*(set(own) for own in offs.values()))
    traces, medians = list[Trace](), list[tuple[str, str, float, float, str]]()
    names = list[tuple[float, str]]()
    for (solver, route), own in offs.items():
        for words in ("default", "finest"):
            values = {case: one.default if words == "default" else one.finest.off for case, one in own.items()}
            pairs = sorted((off, case) for case, off in values.items() if isfinite(off))
            if not pairs:
                continue
            row = -float(len(names))
            names.append((row, f"{solver}, {words}"))
            middle = median(off for off, _ in pairs)
            medians.append((solver, route, middle, row, percent(middle)))
            traces.append(
                Trace(
                    solver, route, [off for off, _ in pairs],
                    [row + 0.025 * _HEIGHTS[i % len(_HEIGHTS)] for i in range(len(pairs))], False, True,
                    pale=frozenset(i for i, (_, case) in enumerate(pairs) if case not in common),
                    tips=[f"{case}: {percent(off)} off, {solver}, {words} settings" for off, case in pairs],
                    links=[address(case) for _, case in pairs],
                )
            )  # fmt: skip
    x = PlotAxis("off; 100 %: as bad as ignoring friction", True, LEAST_OFF, MOST_OFF, True)
    y = PlotAxis(low=0.5 - len(names), high=0.5, names=tuple(names))
    spans = tuple(
        Span(low, high, "") for low, high in zip((LEAST_OFF, *LEVELS[::-1]), (*LEVELS[::-1], MOST_OFF), strict=True)
    )
    words = (
        f"Off of each scene, and the median. Full dots: the {len(common)} scenes that all engines run. Arrows: beyond "
        "the axis. A dot leads to its scene."
    )
    return Diagram("Every scene, one dot", words, ((Panel(x, y, tuple(traces), spans=spans, medians=tuple(medians)),),))
