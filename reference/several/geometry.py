"""Numbers of several contacts in one pose: frames, gaps, velocities, and the rows of their velocities."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, sin
from typing import NamedTuple

import numpy as np

from cases import Case
from cases.contact import belt_speed, find
from cases.contact_pairs import PairCase
from cases.corner import Corner

from .contact_law import coefficients, compliance, freedoms, kinetic, resisting_arm, restitution

# A contact touches if its gap is below this part of the plate's size and place: the rounding of an event's pose.
TOUCHES = 1e-12
# Newton's steps that move a plate onto its contacts: each squares the error, which begins at an integrator's tolerance.
STEPS = 8
# Belts that turn back stand still but for roundings, and no motion of the plate follows all of these: if it misses them
# by this part, no contact opens or closes with what remains.
CONTRADICTS = 1e-9
# The row of the plate's rotation in (vx, vy, ω).
TURNING_ROW = np.array([0.0, 0.0, 1.0])


class ContactPlace(NamedTuple):
    """One contact: its pair, parameters, gap (m), unit tangent of the support, the arm from the centre of mass to the
    outline's point (m), the rows of slip and lift velocity in (vx, vy, ω), and the clearance of the curvatures (1/m; of
    a corner a number)."""

    contact: PairCase
    xi1: float
    xi2: float
    gap: float
    tangent: tuple[float, float]
    arm: tuple[float, float]
    slip_row: np.ndarray
    lift_row: np.ndarray
    clearance: float

    def slip(self, velocity: np.ndarray, t: float) -> float:
        """The slip velocity (m/s) of a plate with that velocity (vx, vy, ω), relative to its support's surface."""
        return float(self.slip_row @ velocity) - belt_speed(self.contact, t)

    @property
    def mu(self) -> float:
        """The coefficient of friction of a slip that begins."""
        return coefficients(self.contact)[0]

    def mu_of(self, velocity: np.ndarray, t: float) -> float:
        """The coefficient of friction of a plate that slips with that velocity (vx, vy, ω)."""
        return float(kinetic(self.contact, self.slip(velocity, t)))

    @property
    def stick(self) -> float:
        """The coefficient of friction without slip."""
        return coefficients(self.contact)[1]

    @property
    def resisting_arm(self) -> float:
        """The largest couple of rolling resistance per normal force, m."""
        return resisting_arm(self.contact)

    @property
    def restitution(self) -> float:
        """The coefficient of restitution."""
        return restitution(self.contact)


def place(contact: PairCase, body: Sequence[float] | np.ndarray, near: tuple[float, float]) -> ContactPlace:
    """The pair of nearest points next to `near` of a plate in that pose. Raises DoesNotFit."""
    x, y, theta = (float(v) for v in body[:3])
    points = find(contact, x, y, theta, near)
    track, outline = contact.track, contact.plate.outline
    _, _, xp, yp, *_ = track.jet(points.xi1)
    speed = hypot(xp, yp)
    tx, ty = xp / speed, yp / speed
    u, v, *_ = outline.jet(points.xi2)
    c, s = cos(theta), sin(theta)
    rx, ry = c * u - s * v, s * u + c * v
    slip = np.array([tx, ty, tx * -ry + ty * rx])
    lift = np.array([-ty, tx, ty * ry + tx * rx])
    bend = float(track.curvature(points.xi1))
    own = 1.0 if isinstance(outline, Corner) else float(outline.curvature(points.xi2))
    clearance = own * (1.0 - points.gap * bend) - (0.0 if isinstance(outline, Corner) else bend)
    return ContactPlace(contact, points.xi1, points.xi2, points.gap, (tx, ty), (rx, ry), slip, lift, clearance)


def places(
    contacts: Sequence[PairCase], body: Sequence[float] | np.ndarray, points: Sequence[tuple[float, float]]
) -> list[ContactPlace]:
    """`place` for every contact, with its pair of points."""
    return [place(contact, body, near) for contact, near in zip(contacts, points, strict=True)]


def project(
    case: Case,
    contacts: Sequence[PairCase],
    body: Sequence[float] | np.ndarray,
    pairs: Sequence[tuple[float, float]],
    closed: Sequence[int],
) -> tuple[list[float], list[ContactPlace]]:
    """The plate moved by rounding so that the closed contacts have no gap, with all pairs in that pose."""
    body = list(body)
    inverse = compliance(case.plate)
    for _ in range(STEPS):
        now = places(contacts, body, pairs)
        gaps = np.array([now[k].gap for k in closed])
        if not len(closed) or np.abs(gaps).max() <= 2e-16 * (abs(body[0]) + abs(body[1]) + case.plate.reach):
            break
        rows = np.array([now[k].lift_row for k in closed])
        step = inverse * (rows.T @ np.linalg.lstsq(rows * inverse @ rows.T, gaps, rcond=1e-10)[0])
        body[:3] = [value - change for value, change in zip(body[:3], step.tolist(), strict=True)]
        pairs = [(one.xi1, one.xi2) for one in now]
    return body, places(contacts, body, pairs)


def without_velocity(
    case: Case,
    t: float,
    body: Sequence[float] | np.ndarray,
    now: Sequence[ContactPlace],
    closed: Sequence[int],
    stuck: Sequence[int],
    is_turning: bool = True,
) -> list[float]:
    """The plate's state at time t (s) with lift velocity 0 at the closed contacts and slip velocity 0 at the stuck
    ones, and without rotation unless it is turning: the nearest such velocities in kinetic energy."""
    rows = [now[k].lift_row for k in closed] + [now[k].slip_row for k in stuck]
    rows += [] if is_turning else [TURNING_ROW]
    velocity = np.array(body[3:], dtype=float)
    if rows:
        inverse = compliance(case.plate)
        matrix = np.array(rows)
        goals = np.array([0.0] * len(closed) + [belt_speed(now[k].contact, t) for k in stuck])
        goals = goals if is_turning else np.append(goals, 0.0)
        is_held = np.linalg.matrix_rank(matrix * np.sqrt(inverse), tol=1e-9) == freedoms(case.plate)
        if is_held and not goals.any():
            return [*body[:3], 0.0, 0.0, 0.0]
        for _ in range(2):  # the second step removes the rounding of the first
            off = np.linalg.lstsq(matrix * inverse @ matrix.T, matrix @ velocity - goals, rcond=1e-10)[0]
            velocity = velocity - inverse * (matrix.T @ off)
        miss = float(np.abs(matrix @ velocity - goals).max())
        if is_held and closed and miss > CONTRADICTS * np.abs(goals).max():
            lifts = matrix[: len(closed)]
            off = np.linalg.lstsq(lifts * inverse @ lifts.T, lifts @ velocity, rcond=1e-10)[0]
            velocity = velocity - inverse * (lifts.T @ off)
    return [*body[:3], *velocity.tolist()]
