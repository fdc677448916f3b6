"""Motions that a solver without Python has written to a file: a table of poses as a trajectory.

Columns: t, x, y, theta of the plate (s, m, rad; the centre of mass), in any order and among others; optional vx, vy,
omega (m/s, rad/s), slip (m/s), normal_force and friction_force (N). What is missing follows from the rest:

- velocities by central differences, good to h² v''/6 where the motion is smooth and to h times the jump of the
  acceleration at a transition; with poses 1 ms apart that is about 1e-5 m/s
  and 3e-3 m/s for the disc in a circle;
- slip from (11) at the contact point that `cases.contact.follow` finds. Where velocities are differences its resolution
  is measured by what it changes if every second sample is left out. Solvers that know better should write them.

A solver whose contacts creep while they stick says how fast, as our own adapters do: a column `creep` (m/s), or a line
`# creep = 5e-3` before the columns. Coarse samples are judged as our own ladders' are: what they miss is a row.
A bounce lower than a hundredth of the plate is told from lying on the track by the forces alone: 0 in flight.
"""

from __future__ import annotations

import re
from io import StringIO
from itertools import takewhile
from math import isfinite, pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cases import BadValue, Case, DoesNotFit, Flight, Impact, Trajectory, Unilateral, user_files
from cases.contact import Contact, MotionPoint, find, slip_velocity, start_motion
from cases.nearest import nearest

if TYPE_CHECKING:
    import pandas as pd

# Relative to the plate's size: what a solver's penalty or facets may miss the track by, and what a printed start may
# be rounded to. Beyond, it is another scene.
LOOSE = 1e-2

REQUIRED_COLUMNS = ("t", "x", "y", "theta")
OPTIONAL = ("vx", "vy", "omega", "slip", "normal_force", "friction_force")
RATES = (("vx", "x"), ("vy", "y"), ("omega", "theta"))
CREEP = "creep"

# A file's size in bytes, and its samples: each is looked at by itself, a tenth of a millisecond.
LARGEST_FILE, MOST_SAMPLES = 100 * 2**20, 200_000
# Squares of what is read, and of its slopes, have to be doubles.
LARGEST = 1e100
# A slope to second order takes so many samples. (Our own adapters ask for no more.)
LEAST_SAMPLES = 3
# By so much (rad) the plate or the track may turn between samples: from a quarter of a turn on, the contact is not
# found from the one before, and degrees, or an angle that jumps by whole turns, look like a motion.
MOST_TURN = 0.5 * pi
# By which part half of a column may differ from what follows from the others: rates of the largest, slip of itself.
# A solver's own facets or half a step is less; another unit, sign or frame is more.
OFF = 0.05


# --- the file --------------------------------------------------------------------------------------------------------


def read_table(path: str | Path) -> pd.DataFrame:
    """The known columns of the file as finite floats with growing times. Raises CaseError, in one sentence."""
    path = user_files.existing("file", path)
    return parse(user_files.text("file", path, LARGEST_FILE), path.name)


def parse(text: str, called: str) -> pd.DataFrame:
    """The same of text; lines that begin with # are comments, and may declare the creep."""
    import pandas as pd  # it takes half a second, and most who are here read no file

    head = list(takewhile(lambda line: line.startswith("#"), text.splitlines()))
    try:
        # Every cell as text: what pandas takes for a number, a date or an index is decided below.
        table = pd.read_csv(StringIO(text), skipinitialspace=True, comment="#", header=None, dtype=str, index_col=False)
    except (ValueError, OverflowError, RecursionError) as problem:
        raise BadValue(f"{called} cannot be read as comma-separated values: {problem}") from problem
    heading = ["" if pd.isna(cell) else str(cell).strip() for cell in table.iloc[0]]
    table = table.iloc[1:].reset_index(drop=True)
    table.columns = pd.Index(heading)
    _check_heading(called, heading)
    missing = [name for name in REQUIRED_COLUMNS if name not in table]
    if missing:
        first = ",".join(str(name) for name in table.columns)
        raise BadValue(
            f"{called} has no column {', '.join(missing)}: its first line is {first[:60]!r}, and has to name "
            "t, x, y, theta, separated by commas"
        )
    if len(table) > MOST_SAMPLES:
        raise BadValue(f"{called} has {len(table)} samples; give at most {MOST_SAMPLES}")
    again = table.duplicated().to_numpy()
    if again.any():
        line = int(np.argmax(again)) + 2
        raise BadValue(f"line {line} of {called} stands there before; leave duplicated lines out")
    table = table[[name for name in (*REQUIRED_COLUMNS, *OPTIONAL, CREEP) if name in table]]
    declared = _declaration(head)
    if declared is not None:
        table = table.assign(**{CREEP: declared})
    for name in table:
        numbers = pd.to_numeric(table[name], errors="coerce")
        # In flight there is no slip: an empty cell, as `Trajectory.to_csv` writes it.
        empty = table[name].isna() if name == "slip" else np.zeros(len(table), dtype=bool)
        bad = np.flatnonzero(~np.isfinite(numbers) & ~empty)
        if len(bad):
            raise BadValue(f"{name} in line {bad[0] + 2 + len(head)} of {called} is not a finite number")
        large = np.flatnonzero(np.abs(numbers) > LARGEST)
        if len(large):
            line = large[0] + 2 + len(head)
            raise BadValue(f"{name} in line {line} of {called} is beyond all sizes; give numbers up to {LARGEST:g}")
        # From the text: before version 3 `to_numeric` is off by a unit in the last place.
        table = table.assign(**{str(name): table[name].where(np.isfinite(numbers)).astype(float)})
    backwards = np.flatnonzero(np.diff(table["t"]) <= 0.0)
    if len(backwards):
        line = backwards[0] + 3 + len(head)
        raise BadValue(f"the time in line {line} of {called} does not grow; sort the lines by t")
    if len(table) < LEAST_SAMPLES:
        raise BadValue(f"{called} has {len(table)} samples, and no slope; give at least {LEAST_SAMPLES}")
    return table


_UNITS = "(ms|us|min|h|mm|cm|km|deg|in|ft)"


def _check_heading(file: str, heading: list[str]) -> None:
    """Raises BadValue for a first line that leaves open what a column holds."""
    # pandas calls a nameless column "Unnamed: 0" where it read it and writes it again.
    nameless = [not cell or cell.startswith("Unnamed:") for cell in heading]
    if any(nameless):
        number = nameless.index(True) + 1
        raise BadValue(f"column {number} of {file} has no name (an index?); name it or leave it out")
    for name in (*REQUIRED_COLUMNS, *OPTIONAL):
        if heading.count(name) > 1:
            raise BadValue(f"{file} has {heading.count(name)} columns {name}; leave one")
        # t_ms, x [mm], time (min): a unit beside a name that is known says that it is not metres or seconds.
        other = [given for given in heading if re.fullmatch(rf"{name}[\s_(\[/]+{_UNITS}.*", given)]
        if other and name not in heading:
            raise BadValue(f"{file} has a column {other[0]!r}; give {name} in SI units and radians, and call it {name}")


# A comment that declares it, such as `# creep = 5e-3` or `# creep: 0.005 m/s`.
_UNIT_LINE = re.compile(r"#\s*creep\s*[=:]\s*(\S+)(\s*m/s)?\s*", re.IGNORECASE)


def _declaration(head: list[str]) -> str | None:
    """The creep that the file's head declares, as it is written there."""
    found = [match[1] for line in head if (match := _UNIT_LINE.fullmatch(line))]
    return found[-1] if found else None


def _creep(columns, declared: float) -> float:
    """The largest creep that is declared, m/s; raises BadValue for one that is no speed."""
    for value in (declared, *columns.get(CREEP, ())):
        if not (isfinite(value) and value >= 0.0):
            raise BadValue(f"the creep is {value:g}; give a speed in m/s, zero or more")
    return float(max([declared, *columns.get(CREEP, ())]))


def columns_of(table: pd.DataFrame) -> dict[str, np.ndarray]:
    """The table's columns by name."""
    return {str(name): table[name].to_numpy() for name in table}


def check_start(case: Case, table: pd.DataFrame) -> None:
    """Raises DoesNotFit if the first row is not the case's start."""
    start, first, reach = start_motion(case), table.iloc[0], case.plate.reach
    if abs(first["t"]) > 1e-9 * case.duration:
        raise DoesNotFit(f"the first time is {first['t']:g} s; the case's motion begins at 0")
    if np.hypot(first["x"] - start.x, first["y"] - start.y) > LOOSE * reach:
        raise DoesNotFit(
            f"the centre of mass starts at ({first['x']:.6g}, {first['y']:.6g}), the case's at "
            f"({start.x:.6g}, {start.y:.6g}) m; {_frame(first, start, reach)}"
        )
    turn = (first["theta"] - start.theta + pi) % (2 * pi) - pi
    if abs(turn) > LOOSE:
        raise DoesNotFit(f"theta starts at {first['theta']:.6g}, the case's at {start.theta:.6g} rad; give radians")


def _frame(first: pd.Series, start: MotionPoint, reach: float) -> str:
    """What to change where the first centre is not the case's."""
    for x, y, words in ((-1, 1, "x is mirrored"), (1, -1, "y is mirrored"), (-1, -1, "both axes are mirrored")):
        if np.hypot(x * first["x"] - start.x, y * first["y"] - start.y) <= LOOSE * reach:
            return f"{words}: give x to the right, y upwards, and theta counter-clockwise"
    return "give metres, in the case's frame, of the same plate"


def trajectory_of(case: Case, table: pd.DataFrame, creep: float = 0.0) -> Trajectory:
    """The table up to the case's duration as a trajectory, cut where the plate has left its track for good.

    `creep` (m/s) is what the solver is said to creep while it sticks, beside what the table declares. Raises CaseError,
    in one sentence, if the table is no motion of the case.
    """
    check_start(case, table)
    # A printed last time may be rounded up.
    table = table[table["t"] <= case.duration * (1 + 1e-9)]
    if len(table) < LEAST_SAMPLES:
        raise DoesNotFit(
            f"the case lasts {case.duration:g} s, and within it there are {len(table)} samples; "
            f"give at least {LEAST_SAMPLES}, and t in seconds"
        )
    columns = columns_of(table)
    t = columns["t"]
    turns = np.abs(np.diff(columns["theta"]))
    if turns.max() > MOST_TURN:
        raise DoesNotFit(
            f"theta changes by {turns.max():.3g} between two samples, too coarse above {MOST_TURN:.3g} rad; "
            "give more samples, and theta in radians without jumps"
        )
    measured = any(rate not in columns for rate, _ in RATES)
    slow = slowest(case, float(t[-1] - t[0]))
    none = {"vx": slow, "vy": slow, "omega": slow / case.plate.reach}
    for rate, name in RATES:
        slope = np.gradient(columns[name], t, edge_order=2)
        given = columns.setdefault(rate, slope)
        # A kink leaves differences off at few samples; a unit, a sign or a frame leaves them off at most.
        if np.median(np.abs(given - slope)) > OFF * np.abs(slope).max() + _coarse(slope) + none[rate]:
            raise DoesNotFit(
                f"{rate} is not the rate of {name}; give both in metres, radians and seconds, and in one frame"
            )
    xi1, xi2, gap = follow_contact(case, columns)
    kept, status, reason = _ending(case, columns, xi1, gap)
    slip, resolution = _slip(case, columns, xi1), _creep(columns, creep)
    if "slip" not in columns:
        columns["slip"] = slip
        resolution = max(resolution, _resolution(case, columns, xi1) if measured else 0.0)
    else:
        vague = _vague(case, columns, slip, xi1)
        if measured:
            vague += _resolution(case, {**columns, "slip": slip}, xi1)
        _check_slip(columns["slip"][:kept], slip[:kept], vague[:kept] + slow)
    untold = np.isnan(xi1) | np.isnan(columns["slip"])
    columns["slip"] = np.where(untold, slip, columns["slip"])
    if case.effect(Flight):  # in flight there is none, even if nothing is told
        for name in ("normal_force", "friction_force"):
            told = columns.get(name, np.full(len(t), np.nan))
            columns[name] = np.where(np.isnan(xi1) & np.isnan(told), 0.0, told)
    nothing = np.full(len(t), np.nan)
    whole: dict[str, Any] = {name: columns.get(name, nothing)[:kept] for name in (*REQUIRED_COLUMNS, *OPTIONAL)}
    return Trajectory(**whole, xi1=xi1[:kept], xi2=xi2[:kept], status=status, reason=reason, slip_resolution=resolution)


def slowest(case: Case, seconds: float) -> float:
    """A speed below which nothing moves, m/s: a millionth of the plate's size in the time of a motion."""
    return 1e-6 * case.plate.reach / seconds


def _coarse(slope: np.ndarray) -> float:
    """How much a rate changes from one sample to the next, in the mean: what differences cannot tell."""
    return float(np.mean(np.abs(np.diff(slope))))


# --- the contact ------------------------------------------------------------------------------------------------------


def follow_contact(case: Case, columns) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Contact parameters and gap (m) of every pose; NaN where the plate has none.

    That is beyond the first pose far from its track; where the case has Flight, wherever the plate is off it.
    """
    start, flies, off = start_motion(case), case.effect(Flight) is not None, LOOSE * case.plate.reach
    near, found = (start.xi1, start.xi2), np.full((len(columns["t"]), 3), np.nan)
    for place, pose in enumerate(zip(*(columns[name].tolist() for name in ("x", "y", "theta")), strict=True)):
        try:
            contact: Contact | None = find(case, pose[0], pose[1], pose[2], near)
        except DoesNotFit:
            contact = None
        if flies and (contact is None or contact.gap > off):
            contact = nearest(case, *pose)
        if contact is not None:
            near, found[place] = contact[:2], contact
        elif not flies:
            break
    xi1, xi2, gap = found.T
    if flies:
        aloft = _aloft(gap <= off, columns.get("normal_force"))
        xi1[aloft] = xi2[aloft] = np.nan
    turns = np.abs(np.diff(case.track.tangent_angle(xi1)))
    turn = turns[np.isfinite(turns)].max(initial=0.0)
    if turn > MOST_TURN:
        raise DoesNotFit(f"the track turns by {turn:.3g} rad between two samples, too coarse; give more samples")
    return xi1, xi2, gap


def _aloft(near: np.ndarray, force: np.ndarray | None) -> np.ndarray:
    """Which samples fly, of those `near` the track and the others: a bounce passes near it before and after it touches.
    Where forces are told, the samples between a flight and the first force, or the last, belong to the flight."""
    aloft = ~near
    if force is None:
        return aloft
    edges = [0, *(np.flatnonzero(np.diff(near)) + 1).tolist(), len(near)]
    for start, stop in zip(edges[:-1], edges[1:], strict=True):
        if near[start]:
            pressed = start + np.flatnonzero(force[start:stop])
            first, last = (int(pressed[0]), int(pressed[-1]) + 1) if len(pressed) else (stop, start)
            if start > 0:
                aloft[start:first] = True
            if stop < len(near):
                aloft[last:stop] = True
    return aloft


def _ending(case: Case, columns, xi1: np.ndarray, gap: np.ndarray) -> tuple[int, str, str]:
    """How many samples belong to the motion, its status and reason."""
    touching = np.flatnonzero(gap <= LOOSE * case.plate.reach)
    if case.effect(Flight):
        landed = np.flatnonzero(np.isnan(xi1[:-1]) & np.isfinite(xi1[1:]))
        if landed.size and not case.effect(Impact):
            return int(landed[0]) + 2, "landing", "The plate meets its track again, and the case names no Impact."
        return len(gap), Trajectory.status, Trajectory.reason
    count, force = int(touching[-1]) + 1, columns.get("normal_force", np.full(len(gap), np.nan))
    if count == len(gap):
        # A file that ends where the force would vanish within another gap ends because it does.
        if case.effect(Unilateral) and columns["t"][-1] < case.duration * (1 - 1e-9) and 2 * force[-1] <= force[-2]:
            return count, "lift_off", "The file ends where the normal force does."
        return count, Trajectory.status, Trajectory.reason
    pressed = np.flatnonzero(force[:count] > 0.0)
    pressed = pressed if len(pressed) else touching
    # Without forces the flight is seen once the gap is there, and told so much later than it began.
    return max(int(pressed[-1]) + 1, 2), "lift_off", "The plate left its track."


def _slip(case: Case, columns, xi1: np.ndarray) -> np.ndarray:
    """By (11), NaN in flight; zero where a plate that may not fly has lost its track."""
    known = np.isfinite(xi1)
    slip = np.full(len(xi1), np.nan if case.effect(Flight) else 0.0)
    x, y, vx, vy, omega = (columns[name][known] for name in ("x", "y", "vx", "vy", "omega"))
    slip[known] = slip_velocity(case, x, y, vx, vy, omega, xi1[known])
    return slip


def _vague(case: Case, columns, slip: np.ndarray, xi1: np.ndarray) -> np.ndarray:
    """By how much (m/s) an honest slip may differ from the `slip` of its pose, at each sample.

    A solver's point of contact lies in the overlap of its own shapes, skins and all: how far from the track the file
    does not tell, but no farther than a pose may be, and a point that much higher on the plate is faster by that times
    ω. (Beside the track's point it only moves along the normal.) Its slip may be that of the step that ends at the
    sample, or half a step beside: along the tangent of the step's beginning a velocity v whose direction turns by a
    misses v a²/2, with the lever from there what ω makes of its change, and the slip itself changes in the step.
    """
    x, y, vx, vy, omega = (columns[name] for name in ("x", "y", "vx", "vy", "omega"))
    turn = np.gradient(case.track.tangent_angle(xi1))
    lever = np.sum((case.track.point(xi1) - np.array([x, y])) * case.track.normal(xi1), axis=0)
    bound = np.abs(omega) * (LOOSE * case.plate.reach + np.abs(np.gradient(lever)))
    bound += np.hypot(vx, vy) * turn**2 / 2 + np.abs(np.gradient(slip)) / 2
    return np.where(np.isfinite(bound), bound, 0.0)


def _check_slip(told: np.ndarray, slip: np.ndarray, vague: np.ndarray) -> None:
    """Raises DoesNotFit if the slip that is told is another quantity than the slip of the poses, m/s.

    Of the samples that slip by either of the two, half decide: at a kink or an impact few are off, and what sticks has
    no slip whose unit or sign could be wrong.
    """
    if np.isfinite(slip).any() and not np.isfinite(told - slip).any():
        raise DoesNotFit("slip is a number nowhere where the plate touches its track; give it there, or leave it out")
    allowed = OFF * np.abs(slip) + vague
    slips = (np.fmax(np.abs(told), np.abs(slip)) > allowed) & np.isfinite(told - slip)
    if 2 * np.sum(np.abs(told - slip)[slips] > allowed[slips]) > np.sum(slips):
        raise DoesNotFit(
            "slip is not the velocity of the plate's point of contact along the track's increasing parameter; "
            "give it so, in m/s, or leave it out"
        )


def _resolution(case: Case, columns, xi1: np.ndarray) -> float:
    """What slip changes if every second sample is left out, over three (the error falls with h²): 95 % stay below."""
    half = {name: columns[name][::2] for name in ("x", "y", "theta")}
    if len(half["x"]) < LEAST_SAMPLES:
        return 0.0
    for rate, name in RATES:
        half[rate] = np.gradient(half[name], columns["t"][::2], edge_order=2)
    change = np.abs(_slip(case, half, xi1[::2]) - columns["slip"][::2])
    return float(np.quantile(change[np.isfinite(change)], 0.95) / 3) if np.isfinite(change).any() else 0.0
