"""Contacts of several free plates, from the poses and velocities of a motion alone.

Each pair of a disc or a corner and a line, and of a disc and another plate, has one gap in every pose. It is closed
while the gap is below what the engine's step leaves, as long as the plates' change of momentum needs it or the gap does
not grow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from cases import Case, CoulombFriction, PerfectlyRough, Trajectory
from cases.contact.polygon_features import local_centre, places_in_regions
from cases.motion.sampled_contacts import SampledContacts, SampledPlates
from cases.motion.trajectory import ContactColumns
from cases.scene.free_plates import PlateContact, names_of, parameter, plate_contacts, plates_of

from . import several_contacts
from .closed_samples import by_gap, from_first_to_last, ranges, touching
from .support_contacts import ROUGH, ROUNDING, UNNEEDED

# Singular values of the contacts' directions below this part of the largest are roundings of 0: such forces cancel.
_UNIQUE = 1e-9
# A force is unique if a unit of it is in forces that cancel by less than this: far above what _UNIQUE leaves of a 0,
# and far below the share 1/n of one among n that do.
_OPEN = 1e-4


@dataclass(frozen=True)
class _PairContact:
    """One contact along a motion, arrays of n samples: gap (m), slip velocity (m/s), unit tangent and normal (2, n),
    both contact parameters, and the contact point from the origins of its plate and of the plate on which it lies
    (2, n), m."""

    contact: PlateContact
    gap: np.ndarray
    slip: np.ndarray
    tangent: np.ndarray
    normal: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    arm: np.ndarray
    base_arm: np.ndarray

    def torsors(self, lengths: np.ndarray, turning: np.ndarray, samples: np.ndarray) -> np.ndarray:
        """The forces and moments over `lengths` (m, of each plate) that a unit force along normal and tangent gives all
        plates at these samples, shape (samples, 3 plates, 2). `turning`: 1 for a plate that turns; the momentum of
        others does not contain their moment, and 0 stands for it."""
        body, base = self.contact.body, self.contact.base
        result = np.zeros((len(samples), len(turning), 3, 2))
        for axis, every in enumerate((self.normal, self.tangent)):
            direction = every[:, samples]
            for plate, arm, sign in ((body, self.arm, 1.0), (base, self.base_arm, -1.0)):
                if plate is None:
                    continue
                result[:, plate, :2, axis] = sign * direction.T
                result[:, plate, 2, axis] = sign * turning[plate] / lengths[plate] * _cross(arm[:, samples], direction)
        return result.reshape(len(samples), -1, 2)

    @property
    def cone(self) -> np.ndarray:
        """The two edges of the friction cone by their parts along normal and tangent, columns of shape (2, 2)."""
        friction = self.contact.effect(CoulombFriction)
        mu = ROUGH if self.contact.effect(PerfectlyRough) else friction.at_rest if friction else 0.0
        return np.array([[1.0, 1.0], [mu, -mu]]) / np.hypot(1.0, mu)


def with_plates(
    case: Case,
    t: np.ndarray,
    poses: np.ndarray,
    rates: np.ndarray,
    clear: float,
    torsor: np.ndarray | None = None,
    slip_lever: float = 0.0,
    impact: float = 0.0,
) -> Trajectory:
    """The motion of several plates with the columns of each contact that closes at some time.

    `poses`, `rates`: (x, y, θ) and (vx, vy, ω) of all plates at the times `t`, shape (n, plates, 3). `clear`: the gap
    (m) below which a contact is closed. `torsor`: force (N) and moment (N m) of all contacts on each plate, like
    `poses`; without it a contact is open as soon as its gap grows, and forces are not known. The engine's friction acts
    at the share `slip_lever` of the gap from the plate that is named first. A contact between two flights that does not
    last longer than `impact` (s) is an impact, closed at its first sample only.
    """
    size = float(np.abs(poses[..., :2]).max()) + max(plate.reach for plate in plates_of(case))
    every = [_along(case, contact, poses, rates, slip_lever) for contact in plate_contacts(case)]
    some = [one for one in every if (one.gap <= clear).any()]
    closed = [one.gap <= clear for one in some]
    rounding = ROUNDING * size
    if torsor is not None:
        turning = np.array([float(plate.turns) for plate in plates_of(case)])
        lengths = np.array([plate.reach for plate in plates_of(case)])
        momenta = (torsor / [(1.0, 1.0, length) for length in lengths]).reshape(len(t), -1)
        steady = [touching(one.gap, shut, rounding) for one, shut in zip(some, closed, strict=True)]
        steady = _pushing(some, closed, steady, momenta, lengths, turning)
        closed = [from_first_to_last(shut, holds) for shut, holds in zip(closed, steady, strict=True)]
    else:
        closed = [by_gap(one.gap, shut, rounding) for one, shut in zip(some, closed, strict=True)]
    closed = [_with_instants(t, shut, impact) for shut in closed]
    forces = np.full((len(some), 2, len(t)), np.nan)
    if torsor is not None:
        forces = _forces(some, closed, momenta, lengths, turning)
    columns = {
        one.contact.name: _columns(one, shut, force) for one, shut, force in zip(some, closed, forces, strict=True)
    }
    plates = {name: np.vstack([poses[:, i].T, rates[:, i].T]) for i, name in enumerate(names_of(case))}
    nothing = np.full(len(t), np.nan)
    x, y, theta, vx, vy, omega = plates[names_of(case)[0]]
    motion = Trajectory(t, x, y, theta, vx, vy, omega, nothing, nothing, nothing, nothing, nothing, case=case)
    own = {one.contact.name: shut for one, shut in zip(some, closed, strict=True) if one.contact.body == 0}
    return replace(
        motion,
        **several_contacts.first_closed(motion, {name: columns[name] for name in own}, own),
        contact_names=tuple(columns),
        contact_columns=SampledContacts(t, columns) if columns else None,
        plate_names=names_of(case),
        plate_columns=SampledPlates(t, plates),
    )


def _with_instants(t: np.ndarray, closed: np.ndarray, impact: float) -> np.ndarray:
    """The closed samples, of contacts between two flights that last at most `impact` (s) only the first one."""
    result = closed.copy()
    for start, stop in ranges(closed):
        if 0 < start and stop < len(t) and t[stop - 1] - t[start] <= impact:
            result[start + 1 : stop] = False
    return result


def _along(case: Case, contact: PlateContact, poses: np.ndarray, rates: np.ndarray, slip_lever: float) -> _PairContact:
    body, base, circle = contact.body, contact.base, contact.circle
    x, y, theta = poses[:, body].T
    c, s = np.cos(theta), np.sin(theta)
    centre = np.array([x + c * circle.x - s * circle.y, y + s * circle.x + c * circle.y])
    gap, normal, xi1 = _on_line(contact, centre) if base is None else _on_plate(case, contact, centre, poses[:, base])
    tangent = np.array([normal[1], -normal[0]])
    place = centre - (circle.radius + slip_lever * gap) * normal
    arm, velocity = place - poses[:, body, :2].T, _velocity(rates[:, body], place - poses[:, body, :2].T)
    base_arm = np.zeros_like(arm)
    if base is not None:
        base_arm = place - poses[:, base, :2].T
        velocity = velocity - _velocity(rates[:, base], base_arm)
    if circle.radius == 0.0:
        xi2 = circle.outline_parameter(np.arctan2(tangent[1], tangent[0]) - theta)
    else:
        inwards = np.unwrap(np.arctan2(-normal[1], -normal[0]))
        xi2 = np.asarray(parameter(plates_of(case)[body].outline, inwards - theta))
    slip = np.sum(velocity * tangent, axis=0)
    return _PairContact(contact, gap, slip, tangent, normal, xi1, xi2, arm, base_arm)


def _on_line(contact: PlateContact, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gap (m), normal and parameter of a contact with a line; `centre` (2, n): of its circle, m."""
    line, curve = contact.line, contact.curve
    assert line is not None and curve is not None, "checked by the case"
    tangent = np.repeat(line.direction[:, None], centre.shape[1], axis=1)
    normal, off, low = np.array([-tangent[1], tangent[0]]), centre - line.point[:, None], float(curve.span[0])
    begin = np.asarray(curve.point(low)) - line.point
    xi1 = low + np.sum((off - begin[:, None]) * tangent, axis=0) / float(curve.speed(low))
    return np.sum(off * normal, axis=0) - contact.circle.radius, normal, xi1


def _on_plate(
    case: Case, contact: PlateContact, centre: np.ndarray, pose: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gap (m), normal and parameter of a contact with another plate, of poses (n, 3)."""
    if contact.around:
        u, v = local_centre(pose.T, *centre)
        gap, a, b, xi1 = places_in_regions(contact.around, u, v, contact.circle.radius)
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        return gap, np.array([c * a - s * b, s * a + c * b]), xi1
    off = centre - pose[:, :2].T
    far = np.hypot(*off)
    assert contact.base is not None
    polar = np.unwrap(np.arctan2(off[1], off[0]))
    xi1 = np.asarray(parameter(plates_of(case)[contact.base].outline, polar - pose[:, 2]))
    return far - contact.circle.radius - contact.base_radius, off / far, xi1


def _velocity(rates: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """The velocity (2, n) of a plate's point at `arm` (2, n) from its origin, of rates (n, 3)."""
    vx, vy, omega = rates.T
    return np.array([vx - omega * arm[1], vy + omega * arm[0]])


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[0] * b[1] - a[1] * b[0]


def _columns(one: _PairContact, closed: np.ndarray, force: np.ndarray) -> ContactColumns:
    normal, friction = np.where(closed, force, 0.0)
    return ContactColumns(
        gap=one.gap,
        slip=np.where(closed, one.slip, np.nan),
        normal_force=normal,
        friction_force=friction,
        xi1=one.xi1,
        xi2=one.xi2,
        normal_range=np.array([normal, normal]),
        friction_range=np.array([friction, friction]),
    )


def _pushing(
    some: Sequence[_PairContact],
    closed: Sequence[np.ndarray],
    steady: Sequence[np.ndarray],
    torsors: np.ndarray,
    lengths: np.ndarray,
    turning: np.ndarray,
) -> list[np.ndarray]:
    """Which of the contacts with small gaps are `steady` or push: those without which the others, with forces in their
    cones, do not give the torsors of all plates, (n, 3 plates) with moments over radius."""
    sizes = np.linalg.norm(torsors, axis=1)
    least = UNNEEDED * np.maximum(sizes, float(np.median(sizes)))
    holds = [mask.copy() for mask in steady]
    for samples, here in _by_closed(closed):
        edges = {k: some[k].torsors(lengths, turning, samples) @ some[k].cone for k in here}
        for k in here:
            others = [edges[other] for other in here if other != k]
            for place in np.flatnonzero(~steady[k][samples]):
                i = samples[place]
                rest = float(sizes[i])
                if others:
                    rest = nnls(np.hstack([edge[place] for edge in others]), torsors[i])[1]
                holds[k][i] = rest > least[i]
    return holds


def _forces(
    some: Sequence[_PairContact],
    closed: Sequence[np.ndarray],
    torsors: np.ndarray,
    lengths: np.ndarray,
    turning: np.ndarray,
) -> np.ndarray:
    """Normal and friction force (N) of each contact, shape (contacts, 2, n): those that give the torsors of all plates
    best; NaN where they are not unique."""
    forces = np.full((len(some), 2, len(torsors)), np.nan)
    for samples, here in _by_closed(closed):
        matrix = np.concatenate([some[k].torsors(lengths, turning, samples) for k in here], axis=2)
        inverse = np.linalg.pinv(matrix, rcond=_UNIQUE)
        values = (inverse @ torsors[samples][:, :, None])[:, :, 0]
        # What forces without any effect on the plates may add to each.
        open_part = 1.0 - np.einsum("nij,nji->ni", inverse, matrix)
        values[open_part > _OPEN] = np.nan
        for place, k in enumerate(here):
            forces[k][:, samples] = values[:, 2 * place : 2 * place + 2].T
    return forces


def _by_closed(closed: Sequence[np.ndarray]) -> list[tuple[np.ndarray, list[int]]]:
    """The samples of each set of closed contacts that is not empty, and the contacts' numbers."""
    patterns, which = np.unique(np.array(closed).T, axis=0, return_inverse=True)
    result = []
    for number, pattern in enumerate(patterns):
        if pattern.any():
            result.append((np.flatnonzero(which.ravel() == number), np.flatnonzero(pattern).tolist()))
    return result
