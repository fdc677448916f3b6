"""Gravity and energy of a plate's motion, which follow from the case alone, for any solver.

A motion is anything with x, y, vx, vy, omega in SI units, numbers or arrays: a Trajectory, a State, a start.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from ..contact import belt_speed, track_place
from ..effects import Drive, Gravity, Load
from ..own_effects import ContactEffect, own_effects
from ..scene.case_class import Case
from ..scene.plate import Plate
from .trajectory import Trajectory


def gravity(case: Case) -> np.ndarray:
    """Gravity as a vector (2,) in m/s², zero without Gravity."""
    effect = case.effect(Gravity)
    return np.array(effect.vector) if effect else np.zeros(2)


def kinetic_energy(case: Case, motion):
    """½ m (vx² + vy²) + ½ J ω², J; a number, or an array of the motion's length. Of a Trajectory that of all its
    plates."""
    first, *further = (_kinetic_energy(plate, own) for plate, own in _each_plate(case, motion))
    return sum(further, first)


def energy(case: Case, motion, times: np.ndarray | None = None):
    """Kinetic energy plus the potential of the case's gravity, J, zero potential at the frame's origin. Of a Trajectory
    that of all its plates; of one with a dense output also at other `times` (n,) than its samples'."""
    (gx, gy), plates = gravity(case), _each_plate(case, motion, times)
    first, *further = (
        _kinetic_energy(plate, own) - plate.mass * (gx * np.asarray(own.x) + gy * np.asarray(own.y))
        for plate, own in plates
    )
    return sum(further, first)


def _each_plate(case: Case, motion, times: np.ndarray | None = None) -> list[tuple[Plate, Any]]:
    """All plates that a motion has, with their motions, or with their states at some times."""
    names = motion.plate_names if isinstance(motion, Trajectory) else ()
    others = [other for other in case.others if other.name in names]
    if times is None:
        return [(case.plate, motion), *((other.plate, motion.plate(other.name)) for other in others)]
    return [(case.plate, motion.dense(times)), *((one.plate, motion.plate_columns(one.name, times)) for one in others)]


def _kinetic_energy(plate: Plate, motion):
    vx, vy, omega = (np.asarray(v) for v in (motion.vx, motion.vy, motion.omega))
    moving = 0.5 * plate.mass * (vx**2 + vy**2)
    return moving + 0.5 * plate.inertia * omega**2 if plate.turns else moving


def contact_power(case: Case, t, motion):
    """The power of the contact's forces on a plate, W: those along the track, which are friction and those of the
    user's own effects, by the velocity of the plate's point, which is slip plus speed of a belt; and all forces by the
    velocity of a driven track's point. 0 in flight; without the couple of a rolling resistance."""
    slip, tangential = np.asarray(motion.slip), np.asarray(motion.friction_force)
    normal, spin_power = np.asarray(motion.normal_force), 0.0
    for effect in own_effects(case.effects):
        along, across, couple = own_forces(case, effect, t, motion)
        tangential, normal = tangential + along, normal + across
        spin_power = spin_power + couple * np.asarray(motion.omega)
    power = tangential * (slip + belt_speed(case, t)) + spin_power
    if case.effect(Drive) is not None:
        place, xi1 = track_place(case, t), np.asarray(motion.xi1)
        c, s = np.cos(place.angle), np.sin(place.angle)
        (tx, ty), (X, Y) = case.track.tangent(xi1), case.track.point(xi1)
        fx, fy = tangential * tx - normal * ty, tangential * ty + normal * tx
        # In the axes of the track's frame: the velocity of its point is Qᵀ ċ + α̇ U Γ.
        ux, uy = c * place.vx + s * place.vy - place.spin * Y, c * place.vy - s * place.vx + place.spin * X
        power = power + fx * ux + fy * uy
    return np.where(np.isnan(slip), 0.0, power)


def own_forces(case: Case, effect: ContactEffect, t, motion):
    """The force of an effect of the user's own along tangent and normal (N), and its couple (N m), at each sample."""
    slip = np.nan_to_num(np.asarray(motion.slip))
    turning = np.asarray(motion.omega) - track_place(case, t).spin
    rows = [effect.at(*map(float, state))[:3] for state in np.broadcast(t, slip, turning)]
    return np.array(rows).T.reshape(3, *np.shape(slip))


def loads(case: Case, now: Any) -> np.ndarray:
    """Force (N) and moment about the centre of mass (N m) of the case's load, shape (3, n), in the fixed frame. `now`
    has the samples t, x, y, theta, vx, vy and omega, arrays (n,)."""
    load = case.effect(Load)
    if load is None:
        return np.zeros((3, len(now.t)))
    rows = zip(*(getattr(now, name).tolist() for name in ("t", "x", "y", "theta", "vx", "vy", "omega")), strict=True)
    return np.array([load.at(*row) for row in rows]).reshape(-1, 3).T


def applied_forces(case: Case, motion: Trajectory, inside: np.ndarray | slice = slice(None)) -> np.ndarray:
    """Force (N) and moment about the centre of mass (N m), shape (3, n), at the samples `inside`, in the fixed frame:
    of the case's load and, in contact with a track at rest, of the user's own effects."""
    names = ("t", "x", "y", "theta", "vx", "vy", "omega", "xi1", "slip")
    now = SimpleNamespace(**{name: getattr(motion, name)[inside] for name in names})
    forces = loads(case, now)
    touches = np.isfinite(now.xi1)
    place = np.where(touches, now.xi1, case.start.xi1)
    for effect in own_effects(case.effects):
        along, across, couple = own_forces(case, effect, now.t, now)
        fx, fy = along * case.track.tangent(place) + across * case.track.normal(place)
        arm_x, arm_y = case.track.point(place) - np.array([now.x, now.y])
        forces += np.where(touches, [fx, fy, arm_x * fy - arm_y * fx + couple], 0.0)
    return forces


def energy_growth(total: np.ndarray) -> np.ndarray:
    """The excess of each energy of a series over the least one before it: zero where only friction acts."""
    return total - np.minimum.accumulate(total)
