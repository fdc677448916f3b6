"""Transitions of a motion that flies in between: lift-off, landing and rebound, read from samples.

In flight there is no slip velocity (NaN). What lies between is read by the code for contact, stretch by stretch.
"""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from typing import Any, NamedTuple

import numpy as np

from cases import Mode, State, Trajectory, Transition

# A contact between two flights that lasts no longer than this many samples' gaps is an impact: too short to be read,
# and in an engine without impacts of no duration its own.
_IMPACT_GAPS = 2.5
# A contact of fewer samples is told by its slip alone; no branch of it can be extrapolated.
_READABLE = 8
# A rebound whose flight lasts less than this part of the motion belongs to bouncing that comes to rest, as in truth.
_LISTED = 1e-3
# What a velocity may change by for no reason, as a part of the speed: a thousand steps' rounding, in single precision.
_ROUNDING = 1e-4

Contact = tuple[Mode, tuple[Transition, ...], tuple[float, ...]]
Zero = Callable[[np.ndarray, np.ndarray, float], "tuple[float, float] | None"]


class _Stretch(NamedTuple):
    """Samples [start, stop) in flight or in contact."""

    flies: bool
    start: int
    stop: int


def flies(trajectory: Trajectory) -> bool:
    """Whether some of its samples are in flight."""
    return bool(np.isnan(trajectory.slip).any())


def read(trajectory: Trajectory, contact: Callable[[Trajectory], Contact], zero: Zero) -> Contact:
    """First mode, transitions and spreads (s) of a motion with flights.

    `contact` reads a stretch without one; `zero(t, y, end)` is where a branch y ≥ 0 vanishes after its last sample, and
    how sure that is. A lift-off is where the normal force vanishes. A landing is where the two straight lines of the
    velocities before and after it meet: exact but for what gravity does to the path within one gap.
    """
    stretches = _stretches(trajectory)
    readings = [None if s.flies else _in_contact(trajectory, s, contact) for s in stretches]
    first = readings[0][0] if readings[0] else Mode.FLIGHT
    transitions: list[Transition] = []
    spreads: list[float] = []
    ahead = zip(stretches, [*stretches[1:], None], readings, [*readings[1:], None], strict=True)
    for before, after, reading, following in ahead:
        if reading:
            transitions += reading[1]
            spreads += reading[2]
        if after is None:
            break
        last = (reading[1][-1].after if reading[1] else reading[0]) if reading else Mode.FLIGHT
        time, spread = _leaves(trajectory, before, zero) if reading else (_lands(trajectory, after.start), nan)
        cause = "the normal force vanishes" if reading else "impact"
        transitions.append(Transition(time, last, following[0] if following else Mode.FLIGHT, cause=cause))
        spreads.append(spread)
    return (first, *_listed(transitions, spreads, float(trajectory.t[0]), float(trajectory.t[-1])))


def _stretches(trajectory: Trajectory) -> list[_Stretch]:
    """Flights and contacts in turn; two flights that follow each other are parted by an impact."""
    flying = np.isnan(trajectory.slip)
    edges = [0, *(np.flatnonzero(np.diff(flying)) + 1).tolist(), len(flying)]
    runs = [_Stretch(bool(flying[a]), a, b) for a, b in zip(edges[:-1], edges[1:], strict=True)]
    found: list[_Stretch] = []
    for place, run in enumerate(runs):
        inside = 0 < place < len(runs) - 1
        if not run.flies and inside and _brief(trajectory.t, run):
            continue
        found += _apart(trajectory, run) if run.flies else [run]
    return found


def _brief(t: np.ndarray, run: _Stretch) -> bool:
    around = t[run.start - 1 : run.stop + 1]
    return bool(around[-1] - around[0] <= _IMPACT_GAPS * np.max(np.diff(t[max(run.start - 20, 0) : run.stop + 20])))


def _apart(trajectory: Trajectory, run: _Stretch) -> list[_Stretch]:
    """A flight in pieces, parted by impacts: by some samples whose force is not known, or between two samples."""
    hit = np.isnan(trajectory.normal_force[run.start : run.stop])
    struck = _struck(trajectory, run, ~hit[:-1] & ~hit[1:])
    edges = [0, *(np.flatnonzero(np.diff(hit) | struck) + 1).tolist(), len(hit)]
    pieces = zip(edges[:-1], edges[1:], strict=True)
    return [_Stretch(True, run.start + a, run.start + b) for a, b in pieces if not hit[a]]


def _struck(trajectory: Trajectory, run: _Stretch, free: np.ndarray) -> np.ndarray:
    """For each gap between the samples of a flight, if it is `free` of any force, whether something struck there.

    Either its two samples have one time, or the velocity changes as no free fall would: by what differs from the
    median of all gaps by as much as that is itself.
    """
    part = slice(run.start, run.stop)
    gaps = np.diff(trajectory.t[part])
    change = np.diff(np.column_stack([trajectory.vx[part], trajectory.vy[part]]), axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = change / gaps[:, None]
    steady = (gaps > 0.0) & free
    if not steady.any():
        return free
    usual = np.median(rate[steady], axis=0)
    # Without any force beside, the rounding of the velocities is all that changes them.
    speed = float(np.max(np.hypot(trajectory.vx[part], trajectory.vy[part])))
    allowed = np.hypot(*usual) * gaps + _ROUNDING * speed
    jumps = np.linalg.norm(change - usual * gaps[:, None], axis=1) > allowed
    return free & ((gaps == 0.0) | jumps)


def _in_contact(trajectory: Trajectory, stretch: _Stretch, contact: Callable[[Trajectory], Contact]) -> Contact:
    part = slice(stretch.start, stretch.stop)
    values = {name: getattr(trajectory, name)[part] for name in ("t", *State._fields)}
    status = trajectory.status if stretch.stop == len(trajectory.t) else Trajectory.status
    readable = stretch.stop - stretch.start >= _READABLE
    if not readable:
        # Twice its first sample: a mode and nothing else.
        values = {name: np.repeat(of_name[:1], 2) for name, of_name in values.items()}
    told: dict[str, Any] = {**values, "status": status, "slip_resolution": trajectory.slip_resolution}
    reading = contact(Trajectory(**told))
    return reading if readable else (reading[0], (), ())


def _leaves(trajectory: Trajectory, before: _Stretch, zero: Zero) -> tuple[float, float]:
    """Where the normal force of a contact that ends in flight vanishes; the middle of the gap if it does not fall."""
    t, force = (values[before.start : before.stop] for values in (trajectory.t, trajectory.normal_force))
    known = np.isfinite(force) & np.append(np.diff(t) > 0, True)
    end = float(trajectory.t[before.stop])
    found = zero(t[known], force[known], end) if known.sum() > 3 else None
    last = float(trajectory.t[before.stop - 1])
    return found if found and last <= found[0] <= end else (0.5 * (last + end), 0.5 * (end - last))


def _lands(trajectory: Trajectory, after: int) -> float:
    """The instant of the impact between the last sample that surely flew before and the sample `after`."""
    before = after - 1
    while before > 0 and not np.isfinite(trajectory.normal_force[before]):
        before -= 1
    t = trajectory.t
    duration = float(t[after] - t[before])
    if duration <= 0.0:
        return float(t[after])
    moved = np.array([trajectory.x[after] - trajectory.x[before], trajectory.y[after] - trajectory.y[before]])
    here, there = (np.array([trajectory.vx[i], trajectory.vy[i]]) for i in (before, after))
    jump = there - here
    # On the line of the jump: v before for the time asked for, v after for the rest.
    share = float(np.dot(there * duration - moved, jump) / np.dot(jump, jump)) if jump.any() else 0.5 * duration
    return float(t[before]) + min(max(share, 0.0), duration)


def _listed(
    transitions: list[Transition], spreads: list[float], begin: float, end: float
) -> tuple[tuple[Transition, ...], tuple[float, ...]]:
    """Without the rebounds of bouncing that comes to rest."""
    ends = [*(event.time for event in transitions[1:]), end]
    kept = [
        (event, spread)
        for event, spread, until in zip(transitions, spreads, ends, strict=False)
        if not event.before is event.after is Mode.FLIGHT or until - event.time >= _LISTED * (end - begin)
    ]
    return tuple(event for event, _ in kept), tuple(spread for _, spread in kept)
