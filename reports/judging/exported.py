"""`python -m reports.compare CASE FILE.csv`: judge a trajectory that a solver without Python has written to a file.

Columns: t, x, y, theta of the plate (s, m, rad; the centre of mass), in any order and among others; optional vx, vy,
omega (m/s, rad/s), slip (m/s), normal_force and friction_force (N). What is missing follows from the rest:

- velocities by central differences, good to h² v''/6 where the motion is smooth and to h times the jump of the
  acceleration at a transition; with poses 1 ms apart that is about 1e-5 m/s
  and 3e-3 m/s for the disc in a circle;
- slip from (11) at the contact point that `cases.contact.follow` finds. Its resolution is measured by what it changes
  if every second sample is left out. Solvers that know their velocities or slip better should write them.

The judgement is that of the report (`trial.judge`). Exit status: 0 if the file could be judged, whatever came
out; 2, with one sentence, if it could not.
"""

from __future__ import annotations

import sys
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.ndimage import median_filter
from tabulate import tabulate

import cases
import reference
from cases import (
    BadValue,
    Case,
    CaseError,
    CoulombFriction,
    DoesNotFit,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    Trajectory,
    Unilateral,
)
from cases.contact import Contact, find, slip_velocity, start_motion
from cases.errors import UnknownName
from cases.nearest import nearest

from ..running import tasks as trial
from ..running.records import TRUTH_RTOL, CaseKey, Run, Truth
from . import distances

NEEDED = ("t", "x", "y", "theta")
OPTIONAL = ("vx", "vy", "omega", "slip", "normal_force", "friction_force")

# Fewer samples than these leave no branch long enough to extrapolate a transition from.
LEAST_SAMPLES = 50
# The plate's or the track's direction may turn by so much (rad) between samples: differences are then good to
# 0.2²/6 < 1 %, and the contact point is found from the one before.
MOST_TURN = 0.2
# Relative to the plate's size: what a solver's penalty or facets may miss the track by, and what a printed start may
# be rounded to. Beyond, it is another scene.
LOOSE = 1e-2
# Relative to the largest: by how much half of a column may differ from what follows from the others. A solver's own
# lever or half a step is less; another unit, sign or frame is more.
OFF = 0.05
# Velocities good to one percent give energies good to two.
ENERGY = 2e-2
# Relative; forces that a file holds with six digits, summed by their writer.
CONE = 1e-4


# --- the file --------------------------------------------------------------------------------------------------------


def read_table(path: str | Path) -> pd.DataFrame:
    """The known columns of the file as finite floats with growing times. Raises CaseError, in one sentence."""
    path = Path(path)
    if not path.is_file():
        raise UnknownName(f"there is no file {str(path)!r}")
    try:
        table = pd.read_csv(path, skipinitialspace=True)
    except (ValueError, OSError) as problem:
        raise BadValue(f"{path} cannot be read as comma-separated values: {problem}") from problem
    table = table.rename(columns=lambda name: str(name).strip())
    missing = [name for name in NEEDED if name not in table]
    if missing:
        first = ",".join(str(name) for name in table.columns)
        raise BadValue(
            f"{path.name} has no column {', '.join(missing)}: its first line is {first[:60]!r}, and has to name "
            "t, x, y, theta, separated by commas"
        )
    table = table[[name for name in (*NEEDED, *OPTIONAL) if name in table]]
    for name in table:
        numbers = pd.to_numeric(table[name], errors="coerce")
        bad = np.flatnonzero(~np.isfinite(numbers))
        if len(bad):
            raise BadValue(f"{name} in line {bad[0] + 2} of {path.name} is not a finite number")
        table = table.assign(**{str(name): numbers.astype(float)})
    backwards = np.flatnonzero(np.diff(table["t"]) <= 0.0)
    if len(backwards):
        raise BadValue(f"the time in line {backwards[0] + 3} of {path.name} does not grow; sort the lines by t")
    if len(table) < LEAST_SAMPLES:
        raise BadValue(f"{path.name} has {len(table)} samples, too coarse to judge; give at least {LEAST_SAMPLES}")
    return table


def check_start(case: Case, table: pd.DataFrame) -> None:
    """Raises DoesNotFit if the first row is not the case's start."""
    start, first, size = start_motion(case), table.iloc[0], _size(case)
    if abs(first["t"]) > 1e-9 * case.duration:
        raise DoesNotFit(f"the first time is {first['t']:g} s; the case's motion begins at 0")
    if np.hypot(first["x"] - start.x, first["y"] - start.y) > LOOSE * size:
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
    xi1, xi2, gap = _followed(case, columns)
    kept, status, reason = _ending(case, columns, xi1, gap)
    slip, resolution = _slip(case, columns, xi1), 0.0
    if "slip" not in columns:
        columns["slip"] = slip
        resolution = _resolution(case, columns, xi1)
    elif np.nanquantile(np.abs(columns["slip"] - slip)[:kept], 0.5) > OFF * np.nanmax(np.abs(slip)) + 1e-9:
        raise DoesNotFit(
            "slip is not the velocity of the plate's point of contact along the track's increasing parameter; "
            "give it so, in m/s, or leave it out"
        )
    columns["slip"] = np.where(np.isnan(xi1), slip, columns["slip"])
    nothing = np.full(len(t), np.nan)
    whole: dict[str, Any] = {name: columns.get(name, nothing)[:kept] for name in (*NEEDED, *OPTIONAL)}
    return Trajectory(**whole, xi1=xi1[:kept], xi2=xi2[:kept], status=status, reason=reason, slip_resolution=resolution)


def _size(case: Case) -> float:
    return float(np.hypot(*case.plate.outline.point(np.linspace(*case.plate.outline.look, 65))).max())


def _followed(case: Case, columns) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Contact parameters and gap (m) of every pose; NaN where the plate has none.

    That is beyond the first pose far from its track; where the case has Flight, wherever the plate is off it.
    """
    start, flies, off = start_motion(case), case.effect(Flight) is not None, LOOSE * _size(case)
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
    touching = np.flatnonzero(gap <= LOOSE * _size(case))
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


# --- the judgement ---------------------------------------------------------------------------------------------------


def laws_broken(case: Case, motion: Trajectory, gap: np.ndarray) -> list[str]:
    """Facts of mechanics the motion contradicts, one sentence each."""
    broken, size = [], _size(case)
    if np.nanmin(gap) < -LOOSE * size:
        at = motion.t[np.nanargmin(gap)]
        broken.append(f"the plate overlaps its track by {-np.nanmin(gap):.3g} m at t = {at:.6g} s")
    if not case.effect(Flight) and gap.max() > LOOSE * size:
        broken.append(f"the plate leaves its track by {gap.max():.3g} m and comes back")
    growth = energy_growth(case, motion)
    if not case.effect(Load) and growth > ENERGY * kinetic(case, motion).max():
        broken.append(f"the energy grows by {growth:.3g} J without a load")
    if np.isfinite(motion.normal_force).all() and np.isfinite(motion.friction_force).all():
        broken += _forces_broken(case, motion)
    return broken


def _forces_broken(case: Case, motion: Trajectory) -> list[str]:
    """What the forces contradict: the cone, the slip they should oppose, and the motion they should cause."""
    broken, friction = [], case.effect(CoulombFriction)
    t, normal, tangential = motion.t, motion.normal_force, motion.friction_force
    scale = CONE * np.abs(normal).max()
    beyond = np.abs(tangential) - (friction.stick if friction else 0.0) * np.abs(normal)
    if not case.effect(PerfectlyRough) and beyond.max() > scale:
        broken.append(f"friction exceeds its cone by {beyond.max():.3g} N at t = {t[np.argmax(beyond)]:.6g} s")
    if case.effect(Unilateral) and normal.min() < -scale:
        broken.append(f"the track pulls with {-normal.min():.3g} N at t = {t[np.argmin(normal)]:.6g} s")
    power = np.where(np.isnan(motion.slip), 0.0, tangential * motion.slip)
    # Creep in stick has either sign; it is a small part of the speed.
    if power.max() > LOOSE * np.abs(tangential).max() * np.hypot(motion.vx, motion.vy).max():
        broken.append(f"friction drives the slip with {power.max():.3g} W at t = {t[np.argmax(power)]:.6g} s")
    # The impulse of an impact is in no column.
    for what, missing, allowed in () if case.effect(Impact) else _momentum(case, motion):
        if missing > allowed:
            broken.append(f"the forces do not make the motion: {what} is off by {missing:.3g} kg m/s")
    return broken


def _momentum(case: Case, motion: Trajectory) -> list[tuple[str, float, float]]:
    """Names of m vx and m vy, by how much they differ from what the forces sum up to, and what is allowed (kg m/s)."""
    gravity, load, mass = case.effect(Gravity) or Gravity(0.0), case.effect(Load), case.plate.mass
    place = np.where(np.isnan(motion.xi1), case.start.xi1, motion.xi1)  # in flight there are no forces
    normal, tangent = case.track.normal(place), case.track.tangent(place)
    applied = np.zeros((3, len(motion.t)))
    if load:
        state = (motion.t, motion.x, motion.y, motion.theta, motion.vx, motion.vy, motion.omega)
        applied = np.array([load.at(*now) for now in zip(*state, strict=True)]).T
    found = []
    for axis, rate, pull in ((0, motion.vx, cos(gravity.direction)), (1, motion.vy, sin(gravity.direction))):
        force = motion.normal_force * normal[axis] + motion.friction_force * tangent[axis] + applied[axis]
        force = force + mass * gravity.g * pull
        off = mass * (rate - rate[0]) - cumulative_trapezoid(force, motion.t, initial=0.0)
        found.append((f"m v{'xy'[axis]}", float(np.abs(off).max()), ENERGY * float(trapezoid(np.abs(force), motion.t))))
    return found


def kinetic(case: Case, motion: Trajectory) -> np.ndarray:
    """Kinetic energy in J, shape (n,)."""
    plate = case.plate
    return 0.5 * (plate.mass * (motion.vx**2 + motion.vy**2) + plate.inertia * motion.omega**2)


def energy_growth(case: Case, motion: Trajectory) -> float:
    """The most the energy (J) rises above its least value so far, but for single samples at impacts."""
    total = distances.energy(case, motion)
    if case.effect(Impact):
        # Differences across an impact are no velocities; it is two samples of any nine that they spoil.
        total = median_filter(total, size=9, mode="nearest")
    return float((total - np.minimum.accumulate(total)).max())


def compare(case: Case, path: str | Path, files: tuple[str, ...] = ()) -> str:
    """The judgement as text. Raises CaseError if the file cannot be judged, or the reference has no truth."""
    motion = trajectory_of(case, read_table(path))
    row = Run(case.label, Path(path).name, "", "", 0, outcome="")
    return _text(case, motion, judge(row, case, motion, trial.find_truth(CaseKey.of(case, files))))


def judge(row: Run, case: Case, motion: Trajectory, truth: Truth) -> Run:
    """The row with its verdict, ledger and errors; raises DoesNotFit if there is no truth to judge it by."""
    if truth.failure:
        raise DoesNotFit(f"there is no truth to judge it by: {truth.failure}")
    exact = reference.simulate(case, rtol=TRUTH_RTOL, method=truth.method)
    return trial.judge(row, case, motion, exact, truth)


def _text(case: Case, motion: Trajectory, run: Run) -> str:
    gap = _followed(case, {name: getattr(motion, name) for name in NEEDED})[2]
    ledger = [(r.event, str(r.before), str(r.after), r.time, r.reference_time, r.error, r.verdict) for r in run.ledger]
    head = ("event", "before", "after", "time", "reference_time", "error", "verdict")
    distance = [(name, value) for name, value in run.distance._asdict().items()]
    total = distances.energy(case, motion)
    energy = [
        ("energy at the start (J)", total[0]),
        ("energy at the end (J)", total[-1]),
        ("largest growth (J)", energy_growth(case, motion)),
    ]
    broken = laws_broken(case, motion, gap)
    return "\n\n".join(
        (
            f"{run.solver} on {case.label}: {run.outcome}{f' ({run.reason})' if run.reason else ''}",
            "Transitions (s)\n" + (tabulate(ledger, head, floatfmt=".9g") if ledger else "none, as in the truth"),
            "Distance from the reference (m, rad, m/s)\n" + tabulate(distance, floatfmt=".3g"),
            "Energy\n" + tabulate(energy, floatfmt=".6g"),
            "Laws broken\n" + ("\n".join(broken) if broken else "none"),
            f"Slip is told from stick above {motion.slip_resolution:.2g} m/s.",
        )
    )


def main(arguments: list[str] | None = None) -> int:
    """The command; returns its exit status."""
    from ..options import Parser

    parser = Parser(prog="python -m reports.compare", description="Judge an exported trajectory.", allow_abbrev=False)
    parser.add_argument("case", help='a case, such as "disc_in_circle[mu=0.1]"')
    parser.add_argument("file", help="comma-separated values with the columns t, x, y, theta")
    parser.add_argument("--case-file", action="append", default=[], metavar="FILE", help="a Python file with cases")
    try:
        asked = parser.parse_args(arguments)
        for file in asked.case_file:
            cases.load_file(file)
        print(compare(cases.load(asked.case), asked.file, tuple(asked.case_file)))
    except CaseError as problem:
        print(problem, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
