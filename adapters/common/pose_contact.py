"""One contact along a motion of poses; which of several contacts push, and with which forces, from momentum alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import nnls

from cases import CoulombFriction, PerfectlyRough, Trajectory
from cases.motion.sampled_contacts import SampledContacts
from cases.motion.trajectory import ContactColumns

# A contact force below this part of the whole is none: noise of a step's momentum in engines of single precision.
UNNEEDED = 1e-3
# The error of a closed contact's gap, for coordinates of size 1, in a motion whose solver keeps it closed: that of an
# integrator between its steps at a tolerance of 1e-10 (DOP853: 1.2e-12 m in a groove), and of files with ten digits.
ROUNDING = 1e-10
# The angle of a cone that no force leaves.
ROUGH = 1e6
# Singular values of the contacts' directions below this part of the largest are roundings of 0: such forces cancel.
_UNIQUE = 1e-9
# A force is unique if a unit of it is in forces that cancel by less than this: far above what _UNIQUE leaves of a 0,
# and far below the share 1/n of one among n that do.
_OPEN = 1e-4


@dataclass(frozen=True)
class PoseContact:
    """One contact along a motion, arrays of n samples: gap (m), slip velocity (m/s), unit tangent and normal (2, n),
    both contact parameters, and the contact point from the origins of its plate `body` and of the plate `base` on which
    it lies (2, n), m; None for a fixed curve. `mu`: the slope of its friction cone."""

    name: str
    body: int
    base: int | None
    mu: float
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
        result = np.zeros((len(samples), len(turning), 3, 2))
        for axis, every in enumerate((self.normal, self.tangent)):
            direction = every[:, samples]
            for plate, arm, sign in ((self.body, self.arm, 1.0), (self.base, self.base_arm, -1.0)):
                if plate is not None:
                    moment = arm[0, samples] * direction[1] - arm[1, samples] * direction[0]
                    result[:, plate, :2, axis] = sign * direction.T
                    result[:, plate, 2, axis] = sign * turning[plate] / lengths[plate] * moment
        return result.reshape(len(samples), -1, 2)

    @property
    def cone(self) -> np.ndarray:
        """The two edges of the friction cone by their parts along normal and tangent, columns of shape (2, 2)."""
        return np.array([[1.0, 1.0], [self.mu, -self.mu]]) / np.hypot(1.0, self.mu)

    def columns(self, closed: np.ndarray, forces: np.ndarray) -> ContactColumns:
        """Its columns with normal and friction forces (2, n), N, that are known where it is closed."""
        normal, friction = np.where(closed, forces, 0.0)
        return ContactColumns(
            gap=self.gap,
            slip=np.where(closed, self.slip, np.nan),
            normal_force=normal,
            friction_force=friction,
            xi1=self.xi1,
            xi2=self.xi2,
            normal_range=np.array([normal, normal]),
            friction_range=np.array([friction, friction]),
        )


def cone_slope(effect: Callable[[type], Any]) -> float:
    """The slope of the friction cone of a contact, from the function that gives its effect of a kind."""
    friction = effect(CoulombFriction)
    return ROUGH if effect(PerfectlyRough) else float(friction.at_rest) if friction else 0.0


def with_columns(
    motion: Trajectory, contacts: Sequence[PoseContact], closed: Sequence[np.ndarray], forces: Iterable[np.ndarray]
) -> Trajectory:
    """The motion with the columns of these contacts, each with its closed samples (n,) and its forces (2, n), N.

    Slip, forces and parameters of the trajectory itself are those of the first closed contact of the case's plate; NaN
    and forces of 0 in flight.
    """
    columns = {one.name: one.columns(*each) for one, *each in zip(contacts, closed, forces, strict=True)}
    empty = {name: np.nan for name in ("slip", "xi1", "xi2")} | {"normal_force": 0.0, "friction_force": 0.0}
    first: dict[str, Any] = {name: np.full(len(motion.t), value) for name, value in empty.items()}
    for one, shut in reversed([*zip(contacts, closed, strict=True)]):
        if one.body == 0:
            for field, values in first.items():
                values[shut] = getattr(columns[one.name], field)[shut]
    sampled = SampledContacts(motion.t, columns) if columns else None
    return replace(motion, **first, contact_names=tuple(columns), contact_columns=sampled)


def pushing(
    some: Sequence[PoseContact],
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


def forces_of(
    some: Sequence[PoseContact],
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
        # The lever of an only contact changes within a step, and its force is known without the moment.
        rows = slice(2 if len(here) == len(turning) == 1 else None)
        inverse = np.linalg.pinv(matrix[:, rows], rcond=_UNIQUE)
        values = (inverse @ torsors[samples][:, rows, None])[:, :, 0]
        # What forces without any effect on the plates may add to each.
        open_part = 1.0 - np.einsum("nij,nji->ni", inverse, matrix[:, rows])
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
