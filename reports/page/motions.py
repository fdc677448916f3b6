"""Motions for the page's player: the true motion, and the difference of engines from it with default settings and at
finer ones.

Numbers are compressed 32-bit floats. The mantissas of the truth are rounded to 16 bits (five digits), those of
differences to 10 bits (three digits), which keeps the page small.
"""

from __future__ import annotations

import inspect
import zlib
from base64 import b64encode
from collections.abc import Mapping
from itertools import groupby
from math import isfinite
from typing import Any

import numpy as np

import cases
from cases import Case, Curve, Mode
from cases.pictures.layout import Instant, along_line, drawn_angle, support_parameters, visible
from cases.scene.supports import TRACK, base_of

from ..drawing.figures import is_stuck
from ..judging.grades import percent
from ..running.names import REFERENCE
from ..running.records import Experiment, Run, Truth, default, routes

# Samples of a motion, including its transitions: a player 800 pixels wide cannot show more.
SAMPLES = 301
# The samples include the exact times of at most this many transitions, spread over all of them.
_EXACT = 120
TRUE = ("x", "y", "theta", "slip", "xi1", "normal_force", "friction_force")
# Of each contact, where there are several.
OF_CONTACT = ("xi1", "normal_force", "friction_force", "normal_low", "normal_high")
# Solver minus truth, with the names of `distances.differences`.
OFF = ("x", "y", "angle", "slip")
# Bits of a mantissa: of the truth, and of differences.
_BITS, _BITS_OF_DIFFERENCES = 16, 10


def motions(experiment: Experiment) -> list[dict[str, Any]]:
    """Data for the player of each case that has a truth."""
    return [data for case in experiment.cases if (data := motion(experiment, case))]


def motion(experiment: Experiment, case: Case) -> dict[str, Any] | None:
    """Data for the player of a case, ready for JSON; None for a case without a truth."""
    truth = experiment.truths[case.label]
    if truth.failure or not truth.samples:
        return None
    times = _times(truth)
    x, y, xi1 = (truth.samples[name] for name in ("x", "y", "xi1"))
    path = np.array([x, y])
    for samples in truth.plate_samples.values():
        further = np.array([samples["x"], samples["y"]])
        path, xi1 = np.hstack([path, further]), np.concatenate([xi1, along_line(case.track, further)])
    supports = support_parameters(case.scene, path)
    columns = {name: _at(times, truth.samples, name) for name in TRUE}
    if case.scene.block:
        poses = np.array([columns[name] for name in ("x", "y", "theta", "xi1")]).T.tolist()
        instants = (Instant(x, y, theta, xi1, 1.0) for x, y, theta, xi1 in poses)
        columns["theta"] = np.array([drawn_angle(case.scene, one) for one in instants])
    return {
        "label": case.label,
        "down": case.scene.down,
        "t": pack(times, bits=23),
        "start": float(times[0]),
        "end": float(times[-1]),
        "modes": _modes(truth),
        "lanes": _lanes(truth),
        "track": _curve(case.track, visible(case.scene, path, xi1)),
        "supports": [{"name": s.name} | _curve(s.curve, supports[s.name]) for s in case.supports],
        "outline": pack(case.scene.corners()),
        "truth": pack(np.array([*columns.values()])),
        "contacts": [
            {
                "name": name,
                "curve": base_of(name),
                "data": pack(np.array([at_contact(times, samples, column) for column in OF_CONTACT])),
            }
            for name, samples in truth.contact_samples.items()
            if base_of(name) in (TRACK, *supports)  # a place on a curve that is drawn
        ],
        "plates": [
            {
                "outline": pack(case.scene.of(other.plate).corners()),
                "data": pack(np.array([_at(times, truth.plate_samples[other.name], q) for q in ("x", "y", "theta")])),
            }
            for other in case.others
        ],
        "runs": [_run(run, times, case) for run in moving_runs(experiment, case.label)],
    }


def moving_runs(experiment: Experiment, label: str) -> list[Run]:
    """The runs of a case that have a motion to show, route by route from coarse to fine: with the median default
    setting, and at the finest or all others. Not the reference's, which coincide with the truth."""
    runs = [run for run in experiment.runs if run.case == label and run.solver != REFERENCE and run.score]
    groups = routes(runs).values()
    visible = [run for group in groups for run in group if not run.setting.is_default or run is default(group)]
    return [run for run in visible if len(run.off.get("t", ())) > 1]


def family(case: Case) -> str:
    """The family of a case: the name of its catalogue file in words; "Your own" for a case outside the catalogue."""
    if case.name not in cases.names():
        return "Your own"
    module = inspect.getmodule(cases.entry(case.name).function)
    name = module.__name__ if module else ""
    return name.rpartition(".")[2].replace("_", " ").capitalize() if ".catalogue." in f".{name}" else "Your own"


def _curve(curve: Curve, parameters: np.ndarray) -> dict[str, Any]:
    """A curve as the player draws it and finds its contacts."""
    low, high = float(parameters[0]), float(parameters[-1])
    return {"low": low, "high": high, "period": bool(curve.period), "points": pack(curve.point(parameters))}


def _run(run: Run, times: np.ndarray, case: Case) -> dict[str, Any]:
    columns = [_at(coarse(times), run.off, name) for name in OFF]
    plates = [
        [_at(coarse(times), run.off, f"{name} of {other.name}") for name in ("x", "y", "angle")]
        for other in case.others
    ]
    events = [row.time for row in run.ledger if isfinite(row.time)]
    facts = {"solver": run.solver, "route": run.route, "setting": str(run.setting), "default": run.setting.is_default}
    facts |= {"score": percent(run.score.off) if run.score else "", "grade": run.grade}
    facts |= {"plates": [pack(np.array(one), bits=_BITS_OF_DIFFERENCES) for one in plates]}
    return facts | {"events": events[:_EXACT], "data": pack(np.array(columns), bits=_BITS_OF_DIFFERENCES)}


def _times(truth: Truth) -> np.ndarray:
    """Evenly spaced times, and the times of the transitions."""
    t, events = truth.samples["t"], np.array([event.time for event in truth.transitions])
    if len(events) > _EXACT:
        events = events[np.linspace(0, len(events) - 1, _EXACT).astype(int)]
    return np.union1d(np.linspace(t[0], t[-1], SAMPLES - len(events)), events)


def coarse(times: np.ndarray) -> np.ndarray:
    """Every second time, and the last: differences have half as many samples as the truth."""
    return np.union1d(times[::2], times[-1:])


def _at(times: np.ndarray, samples: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """A quantity interpolated at these times; NaN outside the motion."""
    t, values = samples["t"], samples[name]
    if not len(t):
        return np.full(len(times), np.nan)
    return np.interp(times, t, values, left=np.nan, right=np.nan)


def at_contact(times: np.ndarray, samples: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """A quantity of one contact, interpolated at these times; next to where it opens or closes that of the nearest
    sample, which at the time of a transition is the value after it."""
    values, t = _at(times, samples, name), samples["t"]
    later = np.clip(np.searchsorted(t, times), 1, len(t) - 1)
    nearest = np.where(times - t[later - 1] < t[later] - times, later - 1, later)
    return np.where(np.isnan(values), samples[name][nearest], values)


def _modes(truth: Truth) -> list[tuple[float, str, str]]:
    """Start time, name and cause of each mode; with several contacts the modes of all closed ones."""
    begin, first = float(truth.samples["t"][0]), truth.first_mode
    if not truth.has_several_contacts:
        return [(begin, str(first), ""), *((event.time, str(event.after), event.cause) for event in truth.transitions)]
    modes = {name: scale.phases[0].mode for name, scale in truth.scales.items()}
    result = [(begin, _closed(modes), "")]
    for time, events in groupby(truth.transitions, key=lambda event: event.time):
        changes = list(events)
        modes |= {event.contact: event.after for event in changes}
        result.append((time, _closed(modes), changes[-1].cause))
    return result


def _lanes(truth: Truth) -> list[tuple[str, list[tuple[float, str, str]]]]:
    """Name, and start time, mode and cause of each mode, of every contact ("" for the only one); a plate that does not
    turn without slip sticks."""
    begin, end = (float(time) for time in truth.samples["t"][[0, -1]])
    lanes = []
    for name in truth.scales if truth.has_several_contacts else ("",):
        events = [event for event in truth.transitions if event.contact == name or not name]
        first = truth.scales[name].phases[0].mode if name else truth.first_mode
        modes = [(begin, str(first), ""), *((event.time, str(event.after), event.cause) for event in events)]
        ends = [time for time, _, _ in modes[1:]] + [end]
        stuck = [
            mode == Mode.ROLL and is_stuck(truth, name, t, to) for (t, mode, _), to in zip(modes, ends, strict=True)
        ]
        lanes.append(
            (
                name,
                [(t, "stick" if still else mode, cause) for (t, mode, cause), still in zip(modes, stuck, strict=True)],
            )
        )
    return lanes


def _closed(modes: Mapping[str, Mode]) -> str:
    """The modes of the closed contacts in words; "flight" if none is closed."""
    words = [f"{mode} at {name}" for name, mode in modes.items() if mode is not Mode.FLIGHT]
    return ", ".join(words) or str(Mode.FLIGHT)


def pack(values: np.ndarray, bits: int = _BITS) -> str:
    """Numbers as base64 text of compressed 32-bit floats whose mantissas are rounded to so many `bits`; all 23 are for
    times, since users zoom in on transitions.

    The bits of a positive float, read as an integer, grow with it. Motions are smooth, so the second differences of
    these integers (modulo 2³²; the sign in the last bit; grouped by byte position) are small and take half the space.
    The first byte is the number of bits that were rounded away.
    """
    words = np.ascontiguousarray(values, dtype="<f4").view("<u4").ravel().astype(np.int64)
    rest = 23 - bits
    size = ((words & 0x7FFFFFFF) + (1 << rest >> 1)) >> rest
    size = np.where(np.isfinite(np.ravel(values)), size, 0x7FC00000 >> rest)
    codes = np.where((words >> 31 == 1) & np.isfinite(np.ravel(values)), -size, size)
    changes = np.diff(codes, n=2, prepend=[0, 0]).astype("<u4").view("<i4")
    zigzag = ((changes << 1) ^ (changes >> 31)).astype("<i4")
    planes = zigzag.view(np.uint8).reshape(-1, 4).T.tobytes()
    return b64encode(zlib.compress(bytes([rest]) + planes, 9)).decode()
