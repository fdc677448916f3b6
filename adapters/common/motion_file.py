"""The motion of a file: a table of poses (`motion_table`) becomes a trajectory.

Columns that the table lacks are computed from the others:

- velocities by central differences, good to h² v''/6 where the motion is smooth and to h times the jump of the
  acceleration at a transition; with poses 1 ms apart that is about 1e-5 m/s and 3e-3 m/s for the disc in a circle;
- slip from (11) at the contact point that `cases.contact.follow` finds. Where velocities are differences, its
  resolution is estimated from its change if every second sample is left out. Solvers should write velocities and slip
  if they have better ones.

Slips and forces of several contacts are not read: they follow from the poses. A solver whose contacts creep while they
stick reports the speed, as the built-in adapters do. Coarse samples are judged like those of the built-in engines: a
transition that they miss is a row. A bounce lower than a hundredth of the plate differs from contact only by its
forces, which are 0 in flight; without forces, by the change of momentum between samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from math import ceil, inf, isfinite, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from cases import BadValue, Case, DoesNotFit, Flight, Impact, StartPose, Trajectory, Unilateral
from cases.contact import MotionPoint, in_track_frame, slip_velocity, start_motion
from cases.motion.mechanics import gravity
from cases.scene.contact_limits import touches_by_features
from cases.scene.free_plates import POSE, names_of, plates_of

from . import contacts_from_poses, momentum, several_contacts
from .driven_tracks import by_track
from .flights import flights
from .motion_table import CREEP, LEAST_SAMPLES, LEVER, OPTIONAL_COLUMNS, REQUIRED_COLUMNS, columns_of, of_plate
from .one_contact import columns_of as contact_columns
from .one_contact import follow

if TYPE_CHECKING:
    import pandas as pd

# Relative to the plate's size: the largest distance from the track that a solver's penalty or facets may leave; and the
# largest difference of its first angle (rad).
LOOSE = 1e-2
# Relative to the plate's size: the gap below which one of several contacts is closed, besides what gravity closes or
# opens within two samples. At the speeds of an impact it is a matter of a millisecond.
CLOSED = 1e-3
# The same of one contact that does not push: a lower hop lasts a few milliseconds for plates of some centimetres.
HOP = 1e-4
# The shortest hop that the transitions' reader takes for one, in gaps between samples.
SHORTEST = 2.5

RATES = (("vx", "x"), ("vy", "y"), ("omega", "theta"))
# Largest turn (rad) of the plate or the track between samples. From a quarter of a turn on, the contact cannot be found
# from the previous one, and degrees, or an angle that jumps by whole turns, look like a motion.
MOST_TURN = 0.5 * pi
# Another unit of a rate leaves at most this part of it.
FITS = 0.1
# Relative to the plate's size: the largest distance that an engine keeps between the surfaces, as a skin or by its
# correction of poses (the default of a game engine at a tenth of its usual sizes has 5 %), also at the start. A start
# that is farther off is of another scene.
SKIN = 0.1
# A plate that is off its track keeps its distance while that is within this factor of its usual one, and leaves above.
STEADY = 1.5
# Fewest samples of a motion that lasts as long as its case; of a shorter one in proportion.
SAMPLES_IN_DURATION = 50
# Largest relative difference of half of a column from the value that follows from the others: of the largest value for
# rates, of the value itself for slip. A solver's facets or half a step are less; another unit, sign or frame is more.
OFF = 0.05


def _creep(columns, declaration: float) -> float:
    """The largest creep that is declared, m/s; raises BadValue for a value that is no speed."""
    for value in (declaration, *columns.get(CREEP, ())):
        if not (isfinite(value) and value >= 0.0):
            raise BadValue(f"the creep is {value:g}; give a speed in m/s, zero or more")
    return float(max([declaration, *columns.get(CREEP, ())]))


def _lever(columns) -> float:
    """The share of the gap at which friction acts; raises BadValue for one outside of it."""
    lever = float(columns.get(LEVER, (0.0,))[0])
    if not 0.0 <= lever <= 1.0:
        raise BadValue(f"the lever is {lever:g}; give 0 to 1, the share of the gap at which the engine's friction acts")
    return lever


def check_start(case: Case, table: pd.DataFrame) -> None:
    """Raise DoesNotFit if the first row is not the case's start."""
    first = table.iloc[0]
    if abs(first["t"]) > 1e-9 * case.duration:
        raise DoesNotFit(f"the first time is {first['t']:g} s; the case's motion begins at 0")
    _check_pose(start_motion(case), first, case.plate.reach)
    for other in case.others:
        names = {of_plate(name, other.name): name for name in REQUIRED_COLUMNS[1:]}
        missing = [name for name in names if name not in table]
        if missing:
            raise BadValue(f"there is no column {missing[0]!r}; give x, y and theta of every plate of the case")
        try:
            _check_pose(other.start, {own: first[name] for name, own in names.items()}, other.plate.reach)
        except DoesNotFit as problem:
            raise DoesNotFit(f"of {other.name}, {problem}") from problem


def _check_pose(start: MotionPoint | StartPose, first: Mapping | pd.Series, reach: float) -> None:
    """Raise DoesNotFit if the first pose is not the start of a plate of that size (m)."""
    if np.hypot(first["x"] - start.x, first["y"] - start.y) > SKIN * reach:
        raise DoesNotFit(
            f"the centre of mass starts at ({first['x']:.6g}, {first['y']:.6g}), the case's at "
            f"({start.x:.6g}, {start.y:.6g}) m; {_frame(first, start, reach)}"
        )
    turn = (first["theta"] - start.theta + pi) % (2 * pi) - pi
    if abs(turn) > LOOSE:
        in_degrees = abs(np.radians(first["theta"]) - start.theta) <= LOOSE * abs(start.theta)
        advice = "give radians" if in_degrees else f"subtract {turn:.6g} rad, so that it begins as the case does"
        raise DoesNotFit(f"theta starts at {first['theta']:.6g}, the case's at {start.theta:.6g} rad; {advice}")


def _frame(first: Mapping | pd.Series, start: MotionPoint | StartPose, reach: float) -> str:
    """What to change if the first centre differs from the case's."""
    for x, y, words in ((-1, 1, "x is mirrored"), (1, -1, "y is mirrored"), (-1, -1, "both axes are mirrored")):
        if np.hypot(x * first["x"] - start.x, y * first["y"] - start.y) <= LOOSE * reach:
            return f"{words}: give x to the right, y upwards, and theta counter-clockwise"
    return "give metres, in the case's frame, of the same plate"


def trajectory_of(case: Case, table: pd.DataFrame, creep: float = 0.0) -> Trajectory:
    """The table up to the case's duration as a trajectory, cut where the plate finally leaves its track.

    `creep` (m/s) is the solver's creep while it sticks, in addition to the creep that the table declares. Raises
    CaseError, in one sentence, if the table is no motion of the case.
    """
    check_start(case, table)
    # A printed last time may be rounded up.
    table = table[table["t"] <= case.duration * (1 + 1e-9)]
    last = float(table["t"].iloc[-1])
    least = max(LEAST_SAMPLES, ceil(SAMPLES_IN_DURATION * last / case.duration * (1 - 1e-9)))
    if len(table) < least:
        raise DoesNotFit(
            f"the case lasts {case.duration:g} s, and within its first {last:g} s there are {len(table)} samples; "
            f"give at least {least}, and t in seconds"
        )
    columns = columns_of(table)
    t = columns["t"]
    from_differences = any(rate not in columns for rate, _ in RATES)
    for name, plate in zip(names_of(case), plates_of(case), strict=True):
        _complete_rates(columns, t, name, slowest(case, float(t[-1] - t[0])), plate.reach)
    if case.others or touches_by_features(case):
        return _by_features(case, columns, creep)
    touches_twice = several_contacts.may_touch_twice(case)
    if touches_twice:  # which contact's slip a file has is not known; that of each contact follows from the poses
        columns.pop("slip", None)
    xi1, xi2, gap = follow_contact(case, columns, from_differences)
    count, status, reason = _ending(case, columns, xi1, gap)
    slip, resolution = _slip(case, columns, xi1), _creep(columns, creep)
    if "slip" not in columns:
        columns["slip"] = slip
        resolution = max(resolution, _resolution(case, columns, xi1) if from_differences else 0.0)
    else:
        doubt = _slip_doubt(case, columns, slip, xi1, gap)
        if from_differences:
            doubt += _resolution(case, {**columns, "slip": slip}, xi1)
        _check_slip(case, columns["slip"][:count], slip[:count], doubt[:count] + slowest(case, float(t[-1] - t[0])))
    missing_slip = np.isnan(xi1) | np.isnan(columns["slip"])
    columns["slip"] = np.where(missing_slip, slip, columns["slip"])
    if case.effect(Flight):  # in flight there is no force, even if the file has none
        for name in ("normal_force", "friction_force"):
            file_values = columns.get(name, np.full(len(t), np.nan))
            columns[name] = np.where(np.isnan(xi1) & np.isnan(file_values), 0.0, file_values)
    nothing = np.full(len(t), np.nan)
    whole: dict[str, Any] = {
        name: columns.get(name, nothing)[:count] for name in (*REQUIRED_COLUMNS, *OPTIONAL_COLUMNS)
    }
    motion = Trajectory(
        **whole, xi1=xi1[:count], xi2=xi2[:count], status=status, reason=reason, slip_resolution=resolution
    )
    if not touches_twice:
        return motion
    clear = _clear(case, t)
    rounding = contacts_from_poses.rounding_of(case, motion)
    complete = partial(several_contacts.with_contacts, clear=lambda xi1: np.full(len(xi1), clear), rounding=rounding)
    return by_track(case, motion, complete)


def _complete_rates(columns: dict[str, np.ndarray], t: np.ndarray, plate: str, slow: float, reach: float) -> None:
    """Add the velocities of a plate of size `reach` (m) that its columns lack, from differences. Raises DoesNotFit for
    too few samples, and for rates that are not those of its poses; `slow` (m/s) counts as zero."""
    angle = of_plate("theta", plate)
    turns = np.abs(np.diff(columns[angle]))
    if turns.max() > MOST_TURN:
        raise DoesNotFit(
            f"{angle} changes by {turns.max():.3g} between two samples, too coarse above {MOST_TURN:.3g} rad; "
            "give more samples, and theta in radians without jumps"
        )
    none = {"vx": slow, "vy": slow, "omega": slow / reach}
    for rate, name in RATES:
        slope = np.gradient(columns[of_plate(name, plate)], t, edge_order=2)
        velocity = columns.setdefault(of_plate(rate, plate), slope)
        # A kink makes few samples differ; a wrong unit or sign makes most samples differ. An engine that corrects poses
        # or jitters has other velocities than the rates of its poses too, but no multiple of them.
        is_another = np.median(np.abs(velocity - slope)) > OFF * np.abs(slope).max() + _coarse(slope) + none[rate]
        if is_another and _is_multiple(velocity, slope):
            raise DoesNotFit(
                f"{of_plate(rate, plate)} is not the rate of {of_plate(name, plate)}; give both in metres, radians and "
                "seconds, and in one frame"
            )


def _is_multiple(values: np.ndarray, slope: np.ndarray) -> bool:
    """Whether values are a constant times the slope, to a tenth, and the constant is not one."""
    size = float(slope @ slope)
    factor = float(values @ slope) / size if size > 0.0 else 1.0
    rest = values - factor * slope
    return abs(factor - 1.0) > OFF and float(rest @ rest) <= FITS**2 * float(values @ values)


def _by_features(case: Case, columns: dict[str, np.ndarray], creep: float) -> Trajectory:
    """The motion of several plates, or of one on supports or with flat sides, whose contacts follow from poses and
    velocities."""
    poses, rates = (
        np.array([[columns[of_plate(name, plate)] for name in names] for plate in names_of(case)]).transpose(2, 0, 1)
        for names in (POSE[:3], POSE[3:])
    )
    t = columns["t"]
    motion = replace(contacts_from_poses.motion_of(case, t, poses, rates), slip_resolution=_creep(columns, creep))
    complete = partial(contacts_from_poses.with_contacts, clear=_clear(case, t), slip_lever=_lever(columns))
    return by_track(case, motion, complete)


def _clear(case: Case, t: np.ndarray, share: float = CLOSED, gaps: float = 4.0) -> float:
    """The gap (m) below which a contact is closed: a share of the plate's size, and the height of a hop that lasts so
    many gaps between samples, by default what gravity closes or opens within two of them."""
    hop = float(np.hypot(*gravity(case))) * (gaps * float(np.max(np.diff(t)))) ** 2 / 8.0
    return share * min(plate.inner for plate in plates_of(case)) + hop


def slowest(case: Case, seconds: float) -> float:
    """A speed that counts as zero, m/s: a millionth of the plate's size in the time of a motion."""
    return 1e-6 * case.plate.reach / seconds


def _coarse(slope: np.ndarray) -> float:
    """The mean change of a rate from one sample to the next: the resolution of differences."""
    return float(np.mean(np.abs(np.diff(slope))))


def least_gap(case: Case, motion: Trajectory) -> np.ndarray:
    """The gap (m) of the nearest contact at the samples of such a motion; NaN where there is none."""
    if not touches_by_features(case):
        return follow_contact(case, {name: getattr(motion, name) for name in REQUIRED_COLUMNS})[2]
    gaps = [columns.gap for columns in motion.contacts.values()]
    return np.min(gaps, axis=0) if gaps else np.full(len(motion.t), np.nan)


# --- the contact ------------------------------------------------------------------------------------------------------


def follow_contact(case: Case, columns, from_differences: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Contact parameters and gap (m) of every pose; NaN where the plate has none.

    With Flight the plate has none wherever it is off its track, else from the first pose far from its track. Where
    `columns` have forces, or velocities (central differences, if `from_differences`) and so the momentum, these decide
    near it.
    """
    flies, off = case.effect(Flight) is not None, LOOSE * case.plate.reach
    poses = in_track_frame(case, columns["t"], *(columns[name] for name in ("x", "y", "theta")))
    contacts = np.full((3, len(columns["t"])), np.nan)
    some = contact_columns(follow(case, np.column_stack(poses), LOOSE)[0])
    contacts[:, : some.shape[1]] = some
    xi1, xi2, gap = contacts
    if flies:
        off = max(off, STEADY * _skin(case, columns, gap, from_differences))
        force = columns.get("normal_force")
        aloft = _aloft(gap <= off, force)
        if force is not None or "vx" in columns:
            pushing = momentum.push(case, columns, aloft, from_differences) if force is None else force != 0.0
            aloft |= _without_force(case, columns["t"], gap, ~aloft & pushing)
        xi1[aloft] = xi2[aloft] = np.nan
    turns = np.abs(np.diff(case.track.tangent_angle(xi1)))
    turn = turns[np.isfinite(turns)].max(initial=0.0)
    if turn > MOST_TURN:
        raise DoesNotFit(f"the track turns by {turn:.3g} rad between two samples, too coarse; give more samples")
    return xi1, xi2, gap


def _skin(case: Case, columns, gap: np.ndarray, from_differences: bool) -> float:
    """The gap (m) that a plate usually keeps where its track pushes it, by its forces or else by its momentum; 0 for
    one that keeps none."""
    near = gap <= SKIN * case.plate.reach
    if not np.any(near & (gap > LOOSE * case.plate.reach)):
        return 0.0
    if "normal_force" in columns:
        pushing = near & (columns["normal_force"] > 0.0)
    elif "vx" in columns:
        pushing = near & momentum.push(case, columns, ~near, from_differences)
    else:
        return 0.0
    usual = float(np.median(gap[pushing])) if pushing.any() else 0.0
    return usual if usual > LOOSE * case.plate.reach else 0.0


def _aloft(near: np.ndarray, force: np.ndarray | None) -> np.ndarray:
    """Which samples are in flight: those not `near` the track, and samples next to them without a force.

    A bounce passes near the track before and after it touches. If the file has forces, the samples between a flight
    and the first force, or between the last force and a flight, belong to the flight.
    """
    aloft = ~near
    if force is None:
        return aloft
    edges = [0, *(np.flatnonzero(np.diff(near)) + 1).tolist(), len(near)]
    for start, stop in zip(edges[:-1], edges[1:], strict=True):
        if near[start]:
            pushing = start + np.flatnonzero(force[start:stop])
            first, last = (int(pushing[0]), int(pushing[-1]) + 1) if len(pushing) else (stop, start)
            if start > 0:
                aloft[start:first] = True
            if stop < len(near):
                aloft[last:stop] = True
    return aloft


def _without_force(case: Case, t: np.ndarray, gap: np.ndarray, lasting: np.ndarray) -> np.ndarray:
    """Which samples are in flight although near the track: without a contact that lasts, and above its usual gap."""
    usual = float(np.median(gap[lasting])) if lasting.any() else 0.0
    result = np.zeros(len(gap), dtype=bool)
    for start, stop in flights(np.nan_to_num(gap, nan=inf) - usual, lasting, _clear(case, t, HOP, SHORTEST)):
        result[start:stop] = True
    return result


def _ending(case: Case, columns, xi1: np.ndarray, gap: np.ndarray) -> tuple[int, str, str]:
    """How many samples belong to the motion, its status and reason."""
    touching = np.flatnonzero(gap <= _highest(gap, case.plate.reach))
    if case.effect(Flight):
        landings = np.flatnonzero(np.isnan(xi1[:-1]) & np.isfinite(xi1[1:]))
        if landings.size and not case.effect(Impact):
            return int(landings[0]) + 2, "landing", "The plate meets its track again, and the case names no Impact."
        return len(gap), Trajectory.status, Trajectory.reason
    count, force = int(touching[-1]) + 1, columns.get("normal_force", np.full(len(gap), np.nan))
    if count == len(gap):
        # A file that ends where the force would vanish within one more step ends because the force vanishes.
        if case.effect(Unilateral) and columns["t"][-1] < case.duration * (1 - 1e-9) and 2 * force[-1] <= force[-2]:
            return count, "lift_off", "The file ends where the normal force vanishes."
        return count, Trajectory.status, Trajectory.reason
    pushing = np.flatnonzero(force[:count] > 0.0)
    pushing = pushing if len(pushing) else touching
    # Without forces the flight is detected by its gap, and therefore later than it begins.
    return max(int(pushing[-1]) + 1, 2), "lift_off", "The plate left its track."


def _highest(gap: np.ndarray, reach: float) -> float:
    """The gap (m) up to which a plate of this reach touches its track: that of a skin where the plate keeps one, else
    what penalties and facets leave."""
    off = gap[gap > LOOSE * reach]
    keeps = len(off) > 0 and off.max() <= SKIN * reach and gap[-1] <= STEADY * np.median(off)
    return float(off.max()) if keeps else LOOSE * reach


def _slip(case: Case, columns, xi1: np.ndarray) -> np.ndarray:
    """The slip velocity by (11), m/s: NaN in flight; zero off the track for a plate that may not fly."""
    touches = np.isfinite(xi1)
    slip = np.full(len(xi1), np.nan if case.effect(Flight) else 0.0)
    x, y, vx, vy, omega = (columns[name][touches] for name in ("x", "y", "vx", "vy", "omega"))
    slip[touches] = slip_velocity(case, x, y, vx, vy, omega, xi1[touches], columns["t"][touches])
    return slip


def _slip_doubt(case: Case, columns, slip: np.ndarray, xi1: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """The largest difference (m/s) of a correct slip from the `slip` of its pose, at each sample.

    A solver's contact point lies in the overlap of its own shapes, including their skins. The file does not contain its
    distance from the track, but the distance is at most that of an accepted pose; a point that much higher on the plate
    is faster by the distance times ω. (A displacement along the track changes only the normal velocity.) The slip may
    be that of the step that ends at the sample, or half a step off: a velocity v whose direction turns by a in the step
    has an error v a²/2 along the tangent of the step's beginning, the change of the lever adds ω times that change, and
    the slip itself changes in the step.
    """
    x, y, vx, vy, omega = (columns[name] for name in ("x", "y", "vx", "vy", "omega"))
    turn = np.gradient(case.track.tangent_angle(xi1))
    lever = np.sum((case.track.point(xi1) - np.array([x, y])) * case.track.normal(xi1), axis=0)
    bound = np.abs(omega) * (np.maximum(LOOSE * case.plate.reach, np.abs(gap)) + np.abs(np.gradient(lever)))
    bound += np.hypot(vx, vy) * turn**2 / 2 + np.abs(np.gradient(slip)) / 2
    return np.where(np.isfinite(bound), bound, 0.0)


def _check_slip(case: Case, file_values: np.ndarray, slip: np.ndarray, doubt: np.ndarray) -> None:
    """Raise DoesNotFit if the file's slip is another quantity than the slip of the poses, m/s. A plate that rebounds
    may touch its track between two samples only.

    Half of the samples that slip by either of the two, and more than two, must differ: at a kink or an impact few
    differ, and a sticking contact has no slip whose unit or sign could be wrong.
    """
    is_empty = np.isfinite(slip).any() and not np.isfinite(file_values - slip).any()
    if is_empty and case.effect(Impact) is None:
        raise DoesNotFit("slip is empty wherever the plate touches its track; give it there, or leave it out")
    tolerance = OFF * np.abs(slip) + doubt
    slips = (np.fmax(np.abs(file_values), np.abs(slip)) > tolerance) & np.isfinite(file_values - slip)
    count = int(np.sum(np.abs(file_values - slip)[slips] > tolerance[slips]))
    if count >= LEAST_SAMPLES and 2 * count > np.sum(slips):
        raise DoesNotFit(
            "slip is not the velocity of the plate's point of contact along the track's increasing parameter; "
            "give it so, in m/s, or leave it out"
        )


def _resolution(case: Case, columns, xi1: np.ndarray) -> float:
    """A third of slip's change if every second sample is left out (the error falls with h²); 95th percentile, m/s."""
    half = {name: columns[name][::2] for name in ("t", "x", "y", "theta")}
    if len(half["x"]) < LEAST_SAMPLES:
        return 0.0
    for rate, name in RATES:
        half[rate] = np.gradient(half[name], half["t"], edge_order=2)
    change = np.abs(_slip(case, half, xi1[::2]) - columns["slip"][::2])
    return float(np.quantile(change[np.isfinite(change)], 0.95) / 3) if np.isfinite(change).any() else 0.0
