"""Probable mistakes of an exported motion: a mirrored axis, another unit, a lag, a moved frame, rounding.

Pure functions. Each mistake is a transformation of the file's columns. A transformation that brings the motion much
closer to the truth, or a rate to the slope of its pose, is named with its size. Nothing is corrected: the motion is
judged unchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import pi
from typing import NamedTuple

import numpy as np

from cases import Case, Trajectory
from cases.contact import slip_velocity

Columns = Mapping[str, np.ndarray]

# Velocities count as half a step away from the poses if their offset is within these bounds, in steps, and if removing
# the offset leaves at most this fraction of their error.
HALF, LARGEST_REST = (0.25, 0.75), 0.3
# A transformation is named if it leaves at most this fraction of the error.
NEARER = 0.1
# Of two that do, the one with a fitted number more has to be better by this factor: a number fits by itself.
SIMPLER = 2.0
# Poses that are nearer to the truth than this part of its path have no mistake.
LEAST_MISTAKE = 1e-4
# Fewest samples within the truth's duration for a diagnosis, and most that are compared.
LEAST, MOST = 3, 500
# A plate that turns by less (rad) does not turn: an angle of this size counts as much as all of its way. (By a smaller
# one the rounding of angles would outweigh every error of places.)
STILL = 1e-3
# Columns with at most so many decimals are checked for rounding.
FEW_DECIMALS = 5
# A factor of a rate counts as a unit or a sign if it is met to this accuracy; exports have errors of a step.
CLOSE = 0.02

# Columns in units that are common elsewhere: name, unit, and the unit in seconds, metres or radians.
_UNITS = (
    *((name, unit, size) for name in ("x", "y") for unit, size in
      (("millimetres", 1e-3), ("centimetres", 1e-2), ("kilometres", 1e3), ("inches", 0.0254), ("feet", 0.3048))),
    *(("x and y", unit, size) for unit, size in (("millimetres", 1e-3), ("centimetres", 1e-2), ("feet", 0.3048))),
    *(("t", unit, size) for unit, size in
      (("minutes", 60.0), ("hours", 3600.0), ("milliseconds", 1e-3), ("microseconds", 1e-6))),
    ("theta", "degrees", pi / 180.0),
    ("theta", "turns", 2.0 * pi),
)  # fmt: skip
_SIGNS = ("x", "y", "theta", "x and theta", "y and theta", "x and y", "x and y and theta")
# Factors of a rate, and what they mean.
_RATE_FACTORS = {
    "vx": {-1.0: "the sign", 1e3: "millimetres", 1e2: "centimetres", 1e-3: "metres per millisecond", 3.6: "km/h"},
    "omega": {
        -1.0: "the sign",
        180 / pi: "degrees per second",
        1 / (2 * pi): "turns per second",
        30 / pi: "turns per minute",
        1e-3: "radians per millisecond",
    },
}
_RATE_FACTORS["vy"] = _RATE_FACTORS["vx"]
_POSES = (("vx", "x"), ("vy", "y"), ("omega", "theta"))


class Change(NamedTuple):
    """A transformation of the columns: what it says of the file, the changed columns, and how many numbers it fits."""

    words: str
    columns: Columns
    fitted: int = 0


def mistakes(case: Case, columns: Columns, truth: Trajectory) -> list[str]:
    """Sentences about the probable mistakes of a table: of its poses, its rates, its slip and its digits."""
    found = [pose_mistake(case, columns, truth), *rate_mistakes(columns), slip_mistake(case, columns, truth)]
    return [sentence for sentence in (*found, rounding(columns, truth)) if sentence]


# --- poses ------------------------------------------------------------------------------------------------------------


def pose_mistake(case: Case, columns: Columns, truth: Trajectory) -> str:
    """A sentence about the transformation that brings a table's poses much closer to the truth; "" if none does."""
    some = np.unique(np.linspace(0, len(columns["t"]) - 1, min(len(columns["t"]), MOST)).astype(int))
    table = {name: np.asarray(columns[name], dtype=float)[some] for name in ("t", "x", "y", "theta")}
    whole = truth(np.linspace(truth.t[0], truth.t[-1], len(columns["t"])))
    # Angles are converted to lengths by the whole motion's ratio of both.
    size = float(np.hypot(np.ptp(whole.x), np.ptp(whole.y))) / max(float(np.ptp(whole.theta)), STILL)
    size = max(size, STILL * case.plate.reach)  # of a plate that turns on the spot the ratio is that of roundings
    own = _off(table, truth, size)
    if own <= LEAST_MISTAKE * np.hypot(np.hypot(np.ptp(whole.x), np.ptp(whole.y)), size * np.ptp(whole.theta)):
        return ""
    turns, best, least = float(np.ptp(whole.theta)) > STILL, "", NEARER * own
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # the values may be of any size
        for change in (*_conventions(table, turns), *_fits(case, table, truth, size)):
            off = _off(change.columns, truth, size) * SIMPLER**change.fitted
            if off < least:
                best, least = change.words, off
    return best and f"{best}: so read, the motion comes much nearer to the truth"


def _off(table: Columns, truth: Trajectory, size: float) -> float:
    """The distance of a table's poses from the truth, m; infinite if it has hardly any samples in the truth's time."""
    true = _true(table, truth)
    if true is None:
        return np.inf
    inside, state = true
    with np.errstate(over="ignore", invalid="ignore"):
        turn = size * _turn(table["theta"][inside], state.theta)
        off = float(
            np.sqrt(np.mean((table["x"][inside] - state.x) ** 2 + (table["y"][inside] - state.y) ** 2 + turn**2))
        )
    return off if np.isfinite(off) else np.inf


def _turn(values: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """The difference of two angles (rad), without the whole turns of its first sample."""
    off = values - exact
    return off - 2 * pi * np.round(off[0] / (2 * pi))


def _true(table: Columns, truth: Trajectory):
    """Which samples lie in the truth's time, and its states there; None if there are too few."""
    inside = (table["t"] <= truth.t[-1]) & (table["t"] >= truth.t[0])
    return (inside, truth(table["t"][inside])) if inside.sum() >= LEAST else None


def _conventions(table: Columns, turns: bool) -> Iterator[Change]:
    """Other signs, units and names of columns; of angles only where the truth turns."""
    for names in _SIGNS:
        verb = "seem" if " and " in names else "seems"
        factors = dict.fromkeys(names.split(" and "), -1.0)
        words = f"{names} {verb} to be mirrored; give x to the right, y upwards, and theta counter-clockwise"
        yield Change(words, _scaled(table, factors))
    for names, unit, unit_size in _UNITS:
        if names == "theta" and not turns:
            continue
        verb = "seem" if " and " in names else "seems"
        words = f"{names} {verb} to be in {unit}; give seconds, metres and radians"
        yield Change(words, _scaled(table, dict.fromkeys(names.split(" and "), unit_size)))
    yield Change("x and y seem to be exchanged", {**table, "x": table["y"], "y": table["x"]})
    turn = np.unwrap(table["theta"])
    if np.abs(turn - table["theta"]).max() > pi:
        yield Change("theta seems to jump by whole turns; write it without jumps", {**table, "theta": turn})


def _scaled(table: Columns, factors: Mapping[str, float]) -> Columns:
    return {name: factors.get(name, 1.0) * values for name, values in table.items()}


def _fits(case: Case, table: Columns, truth: Trajectory, size: float) -> Iterator[Change]:
    """Transformations with a number that is fitted: another time, frame, angle or point of the plate."""
    true = _true(table, truth)
    if true is None:
        return
    inside, state = true
    t = table["t"][inside]
    off_x, off_y = (table[name][inside] - getattr(state, name) for name in ("x", "y"))
    off_turn = _turn(table["theta"][inside], state.theta)
    rates = (state.vx, state.vy, size * np.asarray(state.omega))

    def lag(weight: np.ndarray) -> float:
        """The least-squares factor of the rates times the weight that explains the errors, with its sign turned."""
        along = sum(float(np.sum(weight * r * o)) for r, o in zip(rates, (off_x, off_y, size * off_turn), strict=True))
        steepness = sum(float(np.sum((weight * r) ** 2)) for r in rates)
        return -along / steepness if steepness else 0.0

    late = _refined(lag(np.ones(len(t))), lambda value: {**table, "t": table["t"] - value}, truth, size)
    when = "late" if late > 0.0 else "early"
    words = f"the poses seem to be {abs(late):.4g} s {when}; write the time of each pose"
    yield Change(words, {**table, "t": table["t"] - late}, 1)
    pace = _refined(lag(t), lambda value: {**table, "t": table["t"] * (1 - value)}, truth, size)
    words = f"the time seems to run {abs(100 * pace):.3g} % {'slow' if pace > 0 else 'fast'} (or gravity is another)"
    yield Change(words, {**table, "t": table["t"] * (1 - pace)}, 1)
    dx, dy, turn = float(np.mean(off_x)), float(np.mean(off_y)), float(np.mean(off_turn))
    words = f"the frame seems to be moved by ({dx:.4g}, {dy:.4g}) m"
    yield Change(words, {**table, "x": table["x"] - dx, "y": table["y"] - dy}, 1)
    words = f"theta seems to have the constant offset {turn:.4g} rad; count it from the angle of the case's start"
    yield Change(words, {**table, "theta": table["theta"] - turn}, 1)
    yield from _turned(table, inside, state)
    yield from _other_points(case, table, inside, state, (off_x, off_y))


def _refined(value: float, change: Callable[[float], Columns], truth: Trajectory, size: float) -> float:
    """The value near the first estimate with the smallest distance: a golden-section search around it."""
    if not np.isfinite(value) or value == 0.0:
        return 0.0
    low, high = sorted((0.0, 2 * value))
    share = (5**0.5 - 1) / 2
    for _ in range(30):  # 30 sections leave a millionth of the interval
        one, two = high - share * (high - low), low + share * (high - low)
        if _off(change(one), truth, size) < _off(change(two), truth, size):
            high = two
        else:
            low = one
    return 0.5 * (low + high)


def _turned(table: Columns, inside: np.ndarray, state) -> Iterator[Change]:
    """A frame that is turned about its origin."""
    x, y = table["x"][inside], table["y"][inside]
    angle = float(np.arctan2(np.sum(state.x * y - state.y * x), np.sum(state.x * x + state.y * y)))
    c, s = np.cos(angle), np.sin(angle)
    back = {"x": c * table["x"] + s * table["y"], "y": c * table["y"] - s * table["x"]}
    words = f"the frame seems to be turned by {np.degrees(angle):.4g} degrees about its origin"
    yield Change(words, {**table, **back}, 1)
    yield Change(f"{words}, with theta", {**table, **back, "theta": table["theta"] - angle}, 1)


def _other_points(case: Case, table: Columns, inside: np.ndarray, state, off) -> Iterator[Change]:
    """A pose of another point than the centre of mass: a point fixed in the plate, or the contact."""
    c, s = np.cos(state.theta), np.sin(state.theta)
    px, py = float(np.mean(c * off[0] + s * off[1])), float(np.mean(c * off[1] - s * off[0]))
    cos, sin = np.cos(table["theta"]), np.sin(table["theta"])
    pose = {"x": table["x"] - cos * px + sin * py, "y": table["y"] - sin * px - cos * py}
    words = f"the pose seems to be that of the plate's point ({px:.4g}, {py:.4g}) m; give that of the centre of mass"
    yield Change(words, {**table, **pose}, 1)
    if np.isfinite(state.xi1).all() and inside.all():
        contact = case.track.point(np.asarray(state.xi1)) - np.array([state.x, state.y])
        pose = {"x": table["x"] - contact[0], "y": table["y"] - contact[1]}
        yield Change(
            "the pose seems to be that of the contact point; give that of the centre of mass", {**table, **pose}
        )


# --- rates ------------------------------------------------------------------------------------------------------------


def rate_mistakes(columns: Columns) -> list[str]:
    """Sentences about rates that are not those of the table's own poses: sign, unit, frame of the plate, time."""
    rates = {rate: name for rate, name in _POSES if rate in columns}
    if not rates:
        return []
    t = columns["t"]
    slopes = {rate: np.gradient(columns[name], t, edge_order=2) for rate, name in rates.items()}
    if "vx" in rates and "vy" in rates and _in_plates_frame(columns, slopes):
        return ["vx and vy seem to be components in the plate's frame; give those in the case's frame"]
    sentences = []
    for rate, slope in slopes.items():
        size = float(slope @ slope)
        factor = float(columns[rate] @ slope) / size if size else 1.0
        if np.sum((columns[rate] - factor * slope) ** 2) > NEARER**2 * np.sum(columns[rate] ** 2):
            continue  # no multiple fits
        for value, words in _RATE_FACTORS[rate].items():
            if abs(factor - value) < CLOSE * abs(value):
                sentences.append(f"{rate} seems to be {_in(words)}; it is {factor:.4g} times the rate of {rates[rate]}")
    return sentences or [sentence for sentence in (_late_rates(columns, slopes),) if sentence]


def _in(words: str) -> str:
    return "of the other sign" if words == "the sign" else f"in {words}"


def _in_plates_frame(columns: Columns, slopes: Mapping[str, np.ndarray]) -> bool:
    """Whether vx and vy are much nearer to the slopes of the poses if they are turned by theta."""
    c, s = np.cos(columns["theta"]), np.sin(columns["theta"])
    vx, vy, x, y = columns["vx"], columns["vy"], slopes["vx"], slopes["vy"]
    own, other = np.hypot(vx - x, vy - y), np.hypot(c * vx - s * vy - x, s * vx + c * vy - y)
    return bool(np.median(other) < NEARER * np.median(own))


def _late_rates(columns: Columns, slopes: Mapping[str, np.ndarray]) -> str:
    """A sentence if the rates are those of another time than the poses, as after a semi-implicit step.

    To first order v(t + s h) = v + s h v̇: the offset s is fitted to the difference between the rates and the slopes of
    the poses.
    """
    t = columns["t"]
    shifts = {}
    for rate, slope in slopes.items():
        shift = _shift(columns[rate], slope, np.gradient(slope, t) * np.gradient(t))
        if abs(shift) >= HALF[0]:
            shifts[rate] = shift
    if not shifts:
        return ""
    mean = float(np.mean(list(shifts.values())))
    when, names = "before" if mean < 0.0 else "after", ", ".join(shifts)
    if max(abs(shift) for shift in shifts.values()) <= HALF[1]:
        return (
            f"{names} seem to belong to times half a step {when} the poses, as with semi-implicit steps: slip and "
            "everything read from it have an error of half a step; write velocities of the poses' times"
        )
    seconds = abs(mean) * float(np.median(np.diff(t)))
    return (
        f"{names} seem to belong to times {abs(mean):.2g} steps ({seconds:.2g} s) {when} the poses; "
        "write velocities of the poses' times"
    )


def _shift(column: np.ndarray, own: np.ndarray, growth: np.ndarray) -> float:
    """The offset of a column in time, in steps, if it explains the column's error; else 0.

    `own`: the values that follow from the other columns; `growth`: their change from one sample to the next.
    """
    off = column - own
    # Kinks of the motion are few and large: the middle nine tenths decide.
    usual = np.abs(off) <= np.quantile(np.abs(off), 0.9)
    off, growth = off[usual], growth[usual]
    size = float(growth @ growth)
    if size == 0.0:
        return 0.0
    shift = float(off @ growth) / size
    rest = off - shift * growth
    return shift if rest @ rest <= LARGEST_REST**2 * (off @ off) else 0.0


# --- slip and digits --------------------------------------------------------------------------------------------------


def slip_mistake(case: Case, columns: Columns, truth: Trajectory) -> str:
    """A sentence about a slip column of the other sign, or of the speed of the centre."""
    if "slip" not in columns:
        return ""
    table = {name: columns[name] for name in ("t",)}
    true = _true(table, truth)
    if true is None:
        return ""
    inside, state = true
    slip, exact = columns["slip"][inside], np.asarray(state.slip)
    good = np.isfinite(slip) & np.isfinite(exact)
    slip, exact, speed = slip[good], exact[good], np.hypot(state.vx, state.vy)[good]
    own, size = float(np.sum((slip - exact) ** 2)), float(np.sum(exact**2))
    if not size or own <= NEARER * size:
        return ""
    factor = float(slip @ exact) / size
    for value, words in _RATE_FACTORS["vx"].items():
        if abs(factor - value) < CLOSE * abs(value) and np.sum((slip / value - exact) ** 2) < NEARER**2 * size:
            return f"slip seems to be {_in(words)}"
    if min(float(np.sum((slip - way * speed) ** 2)) for way in (-1.0, 1.0)) < NEARER**2 * own:
        return "slip seems to be the speed of the centre; give that of the plate's point of contact"
    return ""


def slip_half_a_step_beside(case: Case, motion: Trajectory) -> str:
    """A sentence if the slip of a motion is half a step before or after its poses, though its velocities are not."""
    touches = np.isfinite(motion.xi1) & np.isfinite(motion.slip)
    t, column = motion.t[touches], motion.slip[touches]
    if len(t) < 3:
        return ""
    x, y, vx, vy, omega, xi1 = (getattr(motion, name)[touches] for name in ("x", "y", "vx", "vy", "omega", "xi1"))
    own = slip_velocity(case, x, y, vx, vy, omega, xi1, t)
    shift = _shift(column, own, np.gradient(own, t) * np.gradient(t))
    if not HALF[0] <= abs(shift) <= HALF[1]:
        return ""
    when = "before" if shift < 0.0 else "after"
    return (
        f"slip seems to belong to times half a step {when} the poses, so every transition has that error; "
        "write the slip of the poses' times"
    )


def rounding(columns: Columns, truth: Trajectory) -> str:
    """A sentence if columns have few decimals, and their error is no more than that."""
    true = _true(columns, truth)
    if true is None:
        return ""
    inside, state = true
    coarse = {}
    for name in ("x", "y", "theta"):
        values, exact = columns[name][inside], np.asarray(getattr(state, name))
        decimals = _decimals(values)
        if decimals is None:
            continue
        off = _turn(values, exact) if name == "theta" else values - exact
        # Values that are rounded and change do so by a unit of the last decimal; less is noise of a constant.
        quantum = 10.0**-decimals
        if np.ptp(values) > 0.5 * quantum and np.sqrt(np.mean(off**2)) <= quantum:
            coarse[name] = decimals
    if not coarse:
        return ""
    fewest, names = min(coarse.values()), ", ".join(coarse)
    step = float(np.median(np.diff(columns["t"])))
    quantum = 10.0**-fewest
    return (
        f"{names} seem to be rounded to {fewest} decimals: between two samples that is {quantum / step:.2g} per second "
        "in a rate; write all digits"
    )


def _decimals(values: np.ndarray) -> int | None:
    """The fewest decimals that write all values, if that is at most FEW_DECIMALS; else None."""
    for decimals in range(1, FEW_DECIMALS + 1):
        if np.all(np.abs(values * 10.0**decimals - np.round(values * 10.0**decimals)) <= 1e-6):
            return decimals
    return None
