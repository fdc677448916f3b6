"""Contacts of several free plates, from the poses and velocities of a motion alone.

Each pair of a disc and a line, or of two discs, has one gap in every pose. It is closed while the gap is below what the
engine's step leaves, as long as the plates' change of momentum needs it or the gap does not grow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from cases import Case, CoulombFriction, PerfectlyRough, Trajectory
from cases.free_plates import PlateContact, names_of, parameter, plate_contacts, plates_of
from cases.sampled_contacts import SampledContacts, SampledPlates
from cases.trajectory import ContactColumns

from . import several_contacts
from .support_contacts import ROUGH, ROUNDING, UNNEEDED, from_first_to_last, ranges, touching

# Forces are unique if the smallest singular value of the contacts' directions is above this part of the largest.
_UNIQUE = 1e-9


@dataclass(frozen=True)
class _PairContact:
    """One contact along a motion, arrays of n samples: gap (m), slip velocity (m/s), unit tangent and normal (2, n),
    both contact parameters."""

    contact: PlateContact
    gap: np.ndarray
    slip: np.ndarray
    tangent: np.ndarray
    normal: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray

    def torsors(self, turning: np.ndarray, samples: np.ndarray) -> np.ndarray:
        """The forces and moments over radius that a unit force along normal and tangent gives all plates at these
        samples, shape (samples, 3 plates, 2). `turning`: 1 for a plate that turns; the momentum of others does not
        contain their moment, and 0 stands for it."""
        body, base = self.contact.body, self.contact.base
        result = np.zeros((len(samples), len(turning), 3, 2))
        for axis, direction in enumerate((self.normal, self.tangent)):
            result[:, body, :2, axis] = direction[:, samples].T
            if base is not None:
                result[:, base, :2, axis] = -direction[:, samples].T
        # Both moments are r T: the normal points from the base to the body, and the forces are opposite.
        result[:, body, 2, 1] = turning[body]
        if base is not None:
            result[:, base, 2, 1] = turning[base]
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
    # Each step rounds the poses.
    size = float(np.abs(poses[..., :2]).max()) + max(plate.reach for plate in plates_of(case))
    every = [_along(case, contact, poses, rates, slip_lever) for contact in plate_contacts(case)]
    some = [one for one in every if (one.gap <= clear).any()]
    closed = [one.gap <= clear for one in some]
    steady = [touching(one.gap, shut, ROUNDING * size * len(t)) for one, shut in zip(some, closed, strict=True)]
    if torsor is not None:
        turning = np.array([float(plate.turns) for plate in plates_of(case)])
        momenta = (torsor / [(1.0, 1.0, plate.reach) for plate in plates_of(case)]).reshape(len(t), -1)
        steady = _pushing(some, closed, steady, momenta, turning)
    closed = [from_first_to_last(shut, holds) for shut, holds in zip(closed, steady, strict=True)]
    closed = [_with_instants(t, shut, impact) for shut in closed]
    forces = np.full((len(some), 2, len(t)), np.nan)
    if torsor is not None:
        forces = _forces(some, closed, momenta, turning)
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
    plates, body, base = plates_of(case), contact.body, contact.base
    (x, y, theta), (vx, vy, omega) = poses[:, body].T, rates[:, body].T
    radius = plates[body].reach
    if base is None:
        line, curve = contact.line, contact.curve
        assert line is not None and curve is not None, "checked by the case"
        tangent = np.repeat(line.direction[:, None], len(poses), axis=1)
        normal = np.array([-tangent[1], tangent[0]])
        off, low = np.array([x - line.point[0], y - line.point[1]]), float(curve.span[0])
        gap = np.sum(off * normal, axis=0) - radius
        begin = np.asarray(curve.point(low)) - line.point
        xi1 = low + np.sum((off - begin[:, None]) * tangent, axis=0) / float(curve.speed(low))
        slip = vx * tangent[0] + vy * tangent[1] + (radius + slip_lever * gap) * omega
    else:
        own = plates[base].reach
        off = poses[:, body, :2].T - poses[:, base, :2].T
        normal = off / np.hypot(*off)
        tangent = np.array([normal[1], -normal[0]])
        gap = np.hypot(*off) - radius - own
        polar = np.unwrap(np.arctan2(normal[1], normal[0]))
        xi1 = np.asarray(parameter(plates[base].outline, polar - poses[:, base, 2]))
        relative = rates[:, body, :2].T - rates[:, base, :2].T
        arms = radius + slip_lever * gap, own + (1.0 - slip_lever) * gap
        slip = np.sum(relative * tangent, axis=0) + arms[0] * omega + arms[1] * rates[:, base, 2]
    inwards = np.unwrap(np.arctan2(-normal[1], -normal[0]))
    xi2 = np.asarray(parameter(plates[body].outline, inwards - theta))
    return _PairContact(contact, gap, slip, tangent, normal, xi1, xi2)


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
    turning: np.ndarray,
) -> list[np.ndarray]:
    """Which of the contacts with small gaps are `steady` or push: those without which the others, with forces in their
    cones, do not give the torsors of all plates, (n, 3 plates) with moments over radius."""
    sizes = np.linalg.norm(torsors, axis=1)
    least = UNNEEDED * np.maximum(sizes, float(np.median(sizes)))
    holds = [mask.copy() for mask in steady]
    for samples, here in _by_closed(closed):
        edges = {k: some[k].torsors(turning, samples) @ some[k].cone for k in here}
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
    some: Sequence[_PairContact], closed: Sequence[np.ndarray], torsors: np.ndarray, turning: np.ndarray
) -> np.ndarray:
    """Normal and friction force (N) of each contact, shape (contacts, 2, n): those that give the torsors of all plates
    best, where they are unique; NaN elsewhere."""
    forces = np.full((len(some), 2, len(torsors)), np.nan)
    for samples, here in _by_closed(closed):
        matrix = np.concatenate([some[k].torsors(turning, samples) for k in here], axis=2)
        singular = np.linalg.svd(matrix, compute_uv=False)
        is_unique = (matrix.shape[1] >= matrix.shape[2]) & (singular[:, -1] > _UNIQUE * singular[:, 0])
        values = (np.linalg.pinv(matrix) @ torsors[samples][:, :, None])[:, :, 0]
        values[~is_unique] = np.nan
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
