"""Motions for the page's player: the true motion, and the difference of engines from it with default settings and at
finer ones.

Numbers are 32-bit floats with rounded mantissas, which keeps the page small: poses of the truth have 16 bits (five
digits), its slip and forces 13 (four digits are shown), differences 8 (0.2 %, less than a pixel of a plot).
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

import cases
from cases import Case, Curve, Mode
from cases.pictures.layout import Instant, along_line, drawn_angle, support_parameters, visible
from cases.scene.supports import TRACK, base_of

from ..drawing.figures import is_stuck
from ..judging.grades import percent
from ..running.names import REFERENCE
from ..running.records import Experiment, Run, Truth, default, routes
from .fragments import compress

# Samples of a motion, including its transitions: a player 800 pixels wide cannot show more.
SAMPLES = 301
# The samples include the exact times of at most this many transitions, spread over all of them.
_EXACT = 120
TRUE = ("x", "y", "theta", "xi1", "slip", "normal_force", "friction_force")
# Of each contact, where there are several.
OF_CONTACT = ("xi1", "normal_force", "friction_force", "normal_low", "normal_high")
# Solver minus truth, with the names of `distances.differences`.
OFF = ("x", "y", "angle", "slip")
# Of the columns of the truth so many are a pose.
POSE = 4
# Bits of a mantissa: of times, since users zoom in on transitions; of poses; of slip and forces; of differences.
_BITS_OF_TIMES, _BITS, _BITS_OF_FORCES, _BITS_OF_DIFFERENCES = 23, 16, 13, 8


class Numbers(NamedTuple):
    """Numbers of a motion, and the bits of their mantissas that the page has."""

    values: np.ndarray
    bits: int = _BITS


def motions(experiment: Experiment) -> list[dict[str, Any]]:
    """Data for the player of each case that has a truth."""
    return [data for case in experiment.cases if (data := motion(experiment, case))]


def motion(experiment: Experiment, case: Case) -> dict[str, Any] | None:
    """Data for the player of a case, with all arrays as `Numbers`; None for a case without a truth."""
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
    true = np.array([*columns.values()])
    return {
        "label": case.label,
        "down": case.scene.down,
        "t": Numbers(times, _BITS_OF_TIMES),
        "start": float(times[0]),
        "end": float(times[-1]),
        "lanes": _lanes(truth),
        "track": _curve(case.track, visible(case.scene, path, xi1)),
        "supports": [{"name": s.name} | _curve(s.curve, supports[s.name]) for s in case.supports],
        "outline": Numbers(case.scene.corners()),
        "truth": [Numbers(true[:POSE]), Numbers(true[POSE:], _BITS_OF_FORCES)],
        "contacts": [
            {
                "name": name,
                "curve": base_of(name),
                "data": Numbers(np.array([at_contact(times, samples, column) for column in OF_CONTACT])),
            }
            for name, samples in truth.contact_samples.items()
            if base_of(name) in (TRACK, *supports)  # a place on a curve that is drawn
        ],
        "plates": [
            {
                "outline": Numbers(case.scene.of(other.plate).corners()),
                "data": Numbers(np.array([_at(times, truth.plate_samples[other.name], q) for q in TRUE[:3]])),
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
    return {"low": low, "high": high, "period": bool(curve.period), "points": Numbers(curve.point(parameters))}


def _run(run: Run, times: np.ndarray, case: Case) -> dict[str, Any]:
    """Facts of a run, and its differences from the truth: four of the case's plate, then three of each other plate."""
    names = [*OFF, *(f"{name} of {other.name}" for other in case.others for name in OFF[:3])]
    columns = np.array([_at(coarse(times), run.off, name) for name in names])
    events = [float(f"{row.time:.6g}") for row in run.ledger if isfinite(row.time)]
    facts = {"solver": run.solver, "route": run.route, "setting": str(run.setting), "events": events[:_EXACT]}
    facts |= {"score": percent(run.score.off) if run.score else "", "grade": run.grade}
    return facts | {"off": Numbers(columns, _BITS_OF_DIFFERENCES)}


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


def script(facts: Mapping[str, Any]) -> str:
    """The text of a motion in the page: facts as JSON, in which numbers are places in a list of arrays; the length and
    the rounded bits of each array; and the arrays' bytes, all compressed."""
    heads, planes = list[tuple[int, int]](), list[bytes]()

    def collect(value: Any) -> Any:
        if isinstance(value, Numbers):
            heads.append((value.values.size, 23 - value.bits))
            planes.append(encode(*value))
            return len(heads) - 1
        if isinstance(value, Mapping):
            return {key: collect(one) for key, one in value.items()}
        return [collect(one) for one in value] if isinstance(value, list | tuple) else value

    texts = [json.dumps(one, separators=(",", ":")) for one in (collect(facts), heads)]
    return compress(b"".join([*(text.encode() + b"\0" for text in texts), *planes]))


def encode(values: np.ndarray, bits: int) -> bytes:
    """Numbers as 32-bit floats whose mantissas are rounded to so many bits.

    The bits of a positive float, read as an integer, grow with it. Motions are smooth, so the second differences of
    these integers (modulo 2³²; the sign in the last bit; grouped by byte position) are small and take half the space.
    """
    words = np.ascontiguousarray(values, dtype="<f4").view("<u4").ravel().astype(np.int64)
    rest = 23 - bits
    size = ((words & 0x7FFFFFFF) + (1 << rest >> 1)) >> rest
    size = np.where(np.isfinite(np.ravel(values)), size, 0x7FC00000 >> rest)
    codes = np.where((words >> 31 == 1) & np.isfinite(np.ravel(values)), -size, size)
    changes = np.diff(codes, n=2, prepend=[0, 0]).astype("<u4").view("<i4")
    zigzag = ((changes << 1) ^ (changes >> 31)).astype("<i4")
    return zigzag.view(np.uint8).reshape(-1, 4).T.tobytes()
