"""Motions that a solver without Python has written to a file: a table of poses as a trajectory.

Columns: t, x, y, theta of the plate (s, m, rad; the centre of mass), in any order and among others; optional vx, vy,
omega (m/s, rad/s), slip (m/s), normal_force and friction_force (N). What is missing follows from the rest:

- velocities by central differences, good to h² v''/6 where the motion is smooth and to h times the jump of the
  acceleration at a transition; with poses 1 ms apart that is about 1e-5 m/s
  and 3e-3 m/s for the disc in a circle;
- slip from (11) at the contact point that `cases.contact.follow` finds. Its resolution is measured by what it changes
  if every second sample is left out. Solvers that know their velocities or slip better should write them.
"""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from cases import BadValue, Case, DoesNotFit, Flight, Impact, Trajectory
from cases.contact import Contact, find, slip_velocity, start_motion
from cases.errors import UnknownName
from cases.nearest import nearest

if TYPE_CHECKING:
    import pandas as pd

# Relative to the plate's size: what a solver's penalty or facets may miss the track by, and what a printed start may
# be rounded to. Beyond, it is another scene.
LOOSE = 1e-2

NEEDED = ("t", "x", "y", "theta")
OPTIONAL = ("vx", "vy", "omega", "slip", "normal_force", "friction_force")

# Fewer samples than these leave no branch long enough to extrapolate a transition from.
LEAST_SAMPLES = 50
# The plate's or the track's direction may turn by so much (rad) between samples: differences are then good to
# 0.2²/6 < 1 %, and the contact point is found from the one before.
MOST_TURN = 0.2
# Relative to the largest: by how much half of a column may differ from what follows from the others. A solver's own
# lever or half a step is less; another unit, sign or frame is more.
OFF = 0.05


# --- the file --------------------------------------------------------------------------------------------------------


def read_table(path: str | Path) -> pd.DataFrame:
    """The known columns of the file as finite floats with growing times. Raises CaseError, in one sentence."""
    path = Path(path)
    if not path.is_file():
        raise UnknownName(f"there is no file {str(path)!r}")
    return parsed(path, path.name)


def parsed(source: Path | TextIO, called: str) -> pd.DataFrame:
    """The same of a file or of text; lines that begin with # are comments."""
    import pandas as pd  # it takes half a second, and most who are here read no file

    try:
        table = pd.read_csv(source, skipinitialspace=True, comment="#")
    except (ValueError, OSError) as problem:
        raise BadValue(f"{called} cannot be read as comma-separated values: {problem}") from problem
    table = table.rename(columns=lambda name: str(name).strip())
    missing = [name for name in NEEDED if name not in table]
    if missing:
        first = ",".join(str(name) for name in table.columns)
        raise BadValue(
            f"{called} has no column {', '.join(missing)}: its first line is {first[:60]!r}, and has to name "
            "t, x, y, theta, separated by commas"
        )
    table = table[[name for name in (*NEEDED, *OPTIONAL) if name in table]]
    for name in table:
        numbers = pd.to_numeric(table[name], errors="coerce")
        bad = np.flatnonzero(~np.isfinite(numbers))
        if len(bad):
            raise BadValue(f"{name} in line {bad[0] + 2} of {called} is not a finite number")
        table = table.assign(**{str(name): numbers.astype(float)})
    backwards = np.flatnonzero(np.diff(table["t"]) <= 0.0)
    if len(backwards):
        raise BadValue(f"the time in line {backwards[0] + 3} of {called} does not grow; sort the lines by t")
    if len(table) < LEAST_SAMPLES:
        raise BadValue(f"{called} has {len(table)} samples, too coarse to judge; give at least {LEAST_SAMPLES}")
    return table


def check_start(case: Case, table: pd.DataFrame) -> None:
    """Raises DoesNotFit if the first row is not the case's start."""
    start, first, reach = start_motion(case), table.iloc[0], case.plate.reach
    if abs(first["t"]) > 1e-9 * case.duration:
        raise DoesNotFit(f"the first time is {first['t']:g} s; the case's motion begins at 0")
    if np.hypot(first["x"] - start.x, first["y"] - start.y) > LOOSE * reach:
        raise DoesNotFit(
            f"the centre of mass starts at ({first['x']:.6g}, {first['y']:.6g}), the case's at "
            f"({start.x:.6g}, {start.y:.6g}) m; give metres, in the case's frame, of the same plate"
        )
    turn = (first["theta"] - start.theta + pi) % (2 * pi) - pi
    if abs(turn) > LOOSE:
        raise DoesNotFit(f"theta starts at {first['theta']:.6g}, the case's at {start.theta:.6g} rad; give radians")


def trajectory_of(case: Case, table: pd.DataFrame) -> Trajectory:
    """The table up to the case's duration as a trajectory, cut where the plate has left its track for good.

    Raises CaseError, in one sentence, if the table is no motion of the case.
    """
    check_start(case, table)
    # A printed last time may be rounded up.
    table = table[table["t"] <= case.duration * (1 + 1e-9)]
    if len(table) < LEAST_SAMPLES:
        raise DoesNotFit(
            f"the case lasts {case.duration:g} s, and within it there are {len(table)} samples, too coarse; "
            f"give at least {LEAST_SAMPLES}, and t in seconds"
        )
    columns = {str(name): table[name].to_numpy() for name in table}
    t = columns["t"]
    turns = np.abs(np.diff(columns["theta"]))
    if turns.max() > MOST_TURN:
        raise DoesNotFit(
            f"theta changes by {turns.max():.3g} between two samples, too coarse above {MOST_TURN} rad; "
            "give more samples, and theta in radians without jumps"
        )
    for rate, name in (("vx", "x"), ("vy", "y"), ("omega", "theta")):
        slope = np.gradient(columns[name], t, edge_order=2)
        given = columns.setdefault(rate, slope)
        # A kink leaves differences off at few samples; a unit, a sign or a frame leaves them off at most.
        if np.median(np.abs(given - slope)) > OFF * np.abs(slope).max() + 1e-9:
            raise DoesNotFit(f"{rate} is not the rate of {name}; give it in the same units and the same frame")
    xi1, xi2, gap = followed(case, columns)
    kept, status, reason = _ending(case, columns, xi1, gap)
    slip, resolution = _slip(case, columns, xi1), 0.0
    # What the pose may miss the track by, its point of contact may, too: in rolling that is all there is of the slip.
    lever = LOOSE * case.plate.reach * float(np.abs(columns["omega"]).max())
    if "slip" not in columns:
        columns["slip"] = slip
        resolution = _resolution(case, columns, xi1)
    elif np.nanquantile(np.abs(columns["slip"] - slip)[:kept], 0.5) > OFF * np.nanmax(np.abs(slip)) + lever + 1e-9:
        raise DoesNotFit(
            "slip is not the velocity of the plate's point of contact along the track's increasing parameter; "
            "give it so, in m/s, or leave it out"
        )
    columns["slip"] = np.where(np.isnan(xi1), slip, columns["slip"])
    nothing = np.full(len(t), np.nan)
    whole: dict[str, Any] = {name: columns.get(name, nothing)[:kept] for name in (*NEEDED, *OPTIONAL)}
    return Trajectory(**whole, xi1=xi1[:kept], xi2=xi2[:kept], status=status, reason=reason, slip_resolution=resolution)


def followed(case: Case, columns) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
        aloft = ~(gap <= off)
        xi1[aloft] = xi2[aloft] = np.nan
    turns = np.abs(np.diff(case.track.tangent_angle(xi1)))
    turn = turns[np.isfinite(turns)].max(initial=0.0)
    if turn > MOST_TURN:
        raise DoesNotFit(f"the track turns by {turn:.3g} rad between two samples, too coarse; give more samples")
    return xi1, xi2, gap


def _ending(case: Case, columns, xi1: np.ndarray, gap: np.ndarray) -> tuple[int, str, str]:
    """How many samples belong to the motion, its status and reason."""
    touching = np.flatnonzero(gap <= LOOSE * case.plate.reach)
    if case.effect(Flight):
        landed = np.flatnonzero(np.isnan(xi1[:-1]) & np.isfinite(xi1[1:]))
        if landed.size and not case.effect(Impact):
            return int(landed[0]) + 2, "landing", "The plate meets its track again, and the case names no Impact."
        return len(gap), Trajectory.status, Trajectory.reason
    count = int(touching[-1]) + 1
    if count == len(gap):
        return count, Trajectory.status, Trajectory.reason
    pressed = np.flatnonzero(columns["normal_force"][:count] > 0.0) if "normal_force" in columns else touching
    # Without forces the flight is seen once the gap is there, and told so much later than it began.
    return max(int(pressed[-1]) + 1, 2), "lift_off", "The plate left its track."


def _slip(case: Case, columns, xi1: np.ndarray) -> np.ndarray:
    """By (11), NaN in flight; zero where a plate that may not fly has lost its track."""
    known = np.isfinite(xi1)
    slip = np.full(len(xi1), np.nan if case.effect(Flight) else 0.0)
    x, y, vx, vy, omega = (columns[name][known] for name in ("x", "y", "vx", "vy", "omega"))
    slip[known] = slip_velocity(case, x, y, vx, vy, omega, xi1[known])
    return slip


def _resolution(case: Case, columns, xi1: np.ndarray) -> float:
    """What slip changes if every second sample is left out, over three (the error falls with h²): 95 % stay below."""
    half = {name: columns[name][::2] for name in ("x", "y", "theta")}
    for rate, name in (("vx", "x"), ("vy", "y"), ("omega", "theta")):
        half[rate] = np.gradient(half[name], columns["t"][::2], edge_order=2)
    change = np.abs(_slip(case, half, xi1[::2]) - columns["slip"][::2])
    return float(np.quantile(change[np.isfinite(change)], 0.95) / 3) if np.isfinite(change).any() else 0.0
