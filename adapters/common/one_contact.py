"""The contact of a plate with its track along a motion of poses, and where such a motion ends: for every engine.

Arrays of n samples; times in s, gaps in m, forces in N.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from cases import Case, Cost, State, Trajectory
from cases.contact import Contact, slip_velocity

from .flights import BEYOND, LANDING_REASON, NEAR, Follower, lands_for_good

# Columns of a row of a trajectory: the forces, and all that only a contact has.
FORCES, TOUCH = slice(8, 10), slice(7, 12)


class ContactAlong(NamedTuple):
    """The contact at the samples: parameters, gap (m), slip (m/s), and forces on the plate (N). Shorter than the motion
    if the plate lost its track, for the reason `failure`."""

    xi1: np.ndarray
    xi2: np.ndarray
    gap: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    failure: str | None = None


def follow(case: Case, poses: np.ndarray, near: float = NEAR) -> tuple[list[Contact], str | None]:
    """The contacts of the poses (n, 3), up to the first pose without one, and why it has none; `near` as `Follower`."""
    follower, contacts = Follower(case, near), list[Contact]()
    try:
        for row in poses.tolist():
            contacts.append(follower(*row))
    except BEYOND as problem:
        return contacts, str(problem)
    return contacts, None


def columns_of(contacts: list[Contact]) -> np.ndarray:
    """Both parameters and the gaps, shape (3, n)."""
    # As one flat sequence: NumPy takes nine times as long to convert named tuples.
    return np.fromiter(chain.from_iterable(contacts), dtype=float).reshape(-1, 3).T


def with_forces(
    case: Case, t: np.ndarray, pose: np.ndarray, rates: np.ndarray, force: np.ndarray, lever: float
) -> ContactAlong:
    """The contact of the poses and velocities (n, 3), and the parts of a force (n, 2) there.

    `lever`: the fraction of the gap between the plate and the point where the engine's friction acts; with the nominal
    radius the slip would be biased.
    """
    contacts, failure = follow(case, pose)
    xi1, xi2, gap = columns_of(contacts)
    some = slice(len(gap))
    at = slip_and_forces(case, t[some], pose[some], rates[some], force[some], xi1, gap, lever)
    return ContactAlong(xi1, xi2, gap, *at, failure)


def slip_and_forces(
    case: Case, t: np.ndarray, pose: np.ndarray, rates: np.ndarray, force: np.ndarray, xi1: np.ndarray,
    gap: np.ndarray, lever: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Slip (m/s), normal and friction force (N) at contacts that are known (`with_forces`)."""
    nx, ny = case.track.normal(xi1)
    # Moving the centre by the engine's distance between plate and contact gives the engine's lever.
    (x, y, _), (vx, vy, omega), away = pose.T, rates.T, (1.0 - lever) * gap
    slip = slip_velocity(case, x - away * nx, y - away * ny, vx, vy, omega, xi1, t)
    return slip, force[:, 0] * nx + force[:, 1] * ny, np.sum(force[:, :2].T * case.track.tangent(xi1), axis=0)


# --- how a motion ends ------------------------------------------------------------------------------------------------


class MotionEnd(NamedTuple):
    """The end of a motion: after the fraction `share` of the step from sample `sample` − 1 to `sample`, and why."""

    sample: int
    share: float
    status: str
    reason: str

    @property
    def samples(self) -> int:
        """The number of samples up to the end; the last of them is moved to it by `moved_to_end`."""
        return max(self.sample + (self.share > 0.0), 1)


def first_of(ends: Iterable[MotionEnd | None]) -> MotionEnd | None:
    """The earliest of some ends, or None."""
    return min((end for end in ends if end), key=lambda end: end[:2], default=None)


def domain_ends(case: Case, xi1: np.ndarray, xi2: np.ndarray) -> Iterable[MotionEnd]:
    """The ends of track and outline that the contact's parameters (NaN in flight) reach."""
    for name, curve, xi in (("track", case.track, xi1), ("outline", case.plate.outline, xi2)):
        if curve.domain is None or curve.period:
            continue
        low, high = curve.domain
        outside = np.flatnonzero((xi < low) | (xi > high))
        # Rounding may put the start itself outside; it is on the curve.
        if outside.size and outside[0]:
            before, after = xi[outside[0] - 1 : outside[0] + 1]
            share = ((high if after > high else low) - before) / (after - before) if np.isfinite(before) else 0.0
            reason = f"The contact reached the end of the {name}'s domain."
            yield MotionEnd(int(outside[0]), float(share), f"{name}_end", reason)


def landing(
    case: Case, t: np.ndarray, gap: np.ndarray, flown: list[tuple[int, int]], late: int = 0
) -> MotionEnd | None:
    """The landing of a plate without Impact after the first of its flights: the gap's zero by two samples of flight.

    In the step that lands, the contact of some engines already brakes the plate. That of others acts at the beginning
    of the step in which the plate would land, so that the sample is one of flight, too (`late` = 1).
    """
    landings = [(start, lands) for start, lands in flown if lands < len(gap)]
    if not landings or not lands_for_good(case):
        return None
    start, lands = landings[0]
    share, last = 1.0, lands - 1 + late
    if last > start:
        before, after = gap[last - 1 : last + 1]
        if before > after:
            time = t[last - 1] + before / (before - after) * (t[last] - t[last - 1])
            share = min((time - t[lands - 1]) / (t[lands] - t[lands - 1]), 1.0 + late)
    return MotionEnd(lands, float(share), "landing", LANDING_REASON)


def moved_to_end(rows: np.ndarray, end: MotionEnd | None) -> np.ndarray:
    """The first `end.samples` rows, with the last one moved to the end."""
    if end is None or end.share <= 0.0:
        return rows
    last = rows[-2] + end.share * (rows[-1] - rows[-2])
    # The force is zero where contact ends or begins.
    if end.status in ("lift_off", "landing"):
        last[FORCES] = 0.0
    return np.vstack([rows[:-1], last])


def trajectory(rows: np.ndarray, end: MotionEnd | None, slip_resolution: float, cost: Cost) -> Trajectory:
    """The motion of rows (n, 12) in the order of a trajectory's columns, with its end."""
    columns: dict[str, Any] = dict(zip(("t", *State._fields), rows.T, strict=True))
    motion = Trajectory(**columns, slip_resolution=slip_resolution, cost=cost)
    return motion if end is None else replace(motion, status=end.status, reason=end.reason)
