"""Checks of a motion without the truth: balance of energy, gap at the contact, violated laws of mechanics.

Pure functions of cases and trajectories; SI units, residuals relative to the scene's sizes.
"""

from __future__ import annotations

from math import nan

import numpy as np
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.ndimage import median_filter

from adapters.common.motion_file import LOOSE, slowest
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    PerfectlyRough,
    Trajectory,
    Unilateral,
)
from cases.contact import start_motion
from cases.motion import mechanics
from cases.motion.trajectory import State
from cases.own_effects import ContactEffect, own_effects

from .distances import states_of
from .validation import Residuals

# Effects included in the balance of energy: a conservative force, friction, and a bound that does no work.
_ENERGY_EFFECTS = (Gravity, CoulombFriction, Unilateral, Belt, Drive, ContactEffect)
# Number of times at which residuals and condition numbers are computed: gives their maxima to within a few per cent.
_LOOKS = 200
# Gauss points between two samples of a dense motion: its steps carry polynomials of up to degree 25, their product with
# the slip's is integrated to rounding by 26, and between two of a DOP853's steps by far less.
_GAUSS = np.polynomial.legendre.leggauss(26)
# Velocities good to one percent give energies good to two.
ENERGY = 2e-2
# Relative; forces that a file holds with six digits, summed by their writer.
CONE = 1e-4
# A force that changes by so much of its largest between two samples jumps.
JUMP = 0.2
# Relative: what a hundred roundings leave of a difference.
ROUNDING = 1e-12


def examine(case: Case, motion: Trajectory) -> Residuals:
    """All residuals of a motion in contact."""
    off = energy_residual(case, motion)
    return Residuals(float(np.abs(off).max()), _slope(motion.t, off), *_contact(case, motion))


# --- energy -----------------------------------------------------------------------------------------------------------


def energy_residual(case: Case, motion: Trajectory) -> np.ndarray:
    """E(t) − E(0) − ∫ T (v + b) dt at the samples, with the speed b of a belt, relative to the energy that moves.

    NaN if the energy of an effect is unknown, and of one plate of several.
    """
    if case.others or any(not isinstance(effect, _ENERGY_EFFECTS) for effect in case.effects):
        return np.full(len(motion.t), nan)
    total = mechanics.energy(case, motion)
    works = case.effect(CoulombFriction) or case.effect(Drive) or own_effects(case.effects)
    off = total - total[0] - (work_of_contact(case, motion) if works else 0.0)
    kinetic = mechanics.kinetic_energy(case, motion)
    scale = float(max(kinetic.max(), np.ptp(total - kinetic)))
    return off / scale if scale > 0.0 else off


def work_of_contact(case: Case, motion: Trajectory) -> np.ndarray:
    """∫ T (v + b) dt, with the speed b of a belt, and the work of the user's own effects, from the start to each
    sample, J: Gauss's rule on a dense motion, trapezoids on samples."""
    steps = np.diff(motion.t)
    if motion.dense is None:
        power = mechanics.contact_power(case, motion.t, motion)
        return np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * steps)])
    nodes, weights = _GAUSS
    # At a transition two samples share one time, and what lies between neighbours is smooth.
    times = motion.t[:-1, None] + 0.5 * steps[:, None] * (nodes + 1.0)
    flat = np.clip(times.ravel(), motion.t[0], motion.t[-1])
    power = np.asarray(mechanics.contact_power(case, flat, motion(flat))).reshape(times.shape)
    return np.concatenate([[0.0], np.cumsum(0.5 * steps * (power @ weights))])


def _slope(t: np.ndarray, y: np.ndarray) -> float:
    """Least-squares rate of change of y; NaN where there is none."""
    if len(t) < 2 or t[-1] <= t[0] or not np.all(np.isfinite(y)):
        return nan
    along = t - t.mean()
    return float(along @ y / (along @ along))


# --- contact ----------------------------------------------------------------------------------------------------------


def looks(motion: Trajectory) -> tuple[np.ndarray, State]:
    """Times spread over the motion's own samples, and its states there."""
    pick = np.unique(np.linspace(0, len(motion.t) - 1, min(_LOOKS, len(motion.t))).round().astype(int))
    return motion.t[pick], states_of(motion, pick)


def _contact(case: Case, motion: Trajectory) -> tuple[float, float, float]:
    """(5): how far the outline's point at ξ₂ lies from the track's at ξ₁, over the plate's size, and its
    slope, m/s; (6): the largest sine between both tangents. NaN without a contact, and on a driven track."""
    times, state = looks(motion)
    xi1, xi2 = np.asarray(state.xi1), np.asarray(state.xi2)
    if case.effect(Drive) is not None or not np.all(np.isfinite(xi1 + xi2)):
        return nan, nan, nan
    c, s = np.cos(state.theta), np.sin(state.theta)
    (X, Y), (u, v) = case.track.point(xi1), case.plate.outline.point(xi2)
    apart = np.hypot(state.x + c * u - s * v - X, state.y + s * u + c * v - Y)
    (tx, ty), (ox, oy) = case.track.tangent(xi1), case.plate.outline.tangent(xi2)
    sine = np.abs(tx * (s * ox + c * oy) - ty * (c * ox - s * oy))
    return float(apart.max()) / case.plate.reach, _slope(times, apart), float(sine.max())


def motion_extent(case: Case, x: np.ndarray, y: np.ndarray) -> float:
    """The largest displacement of the centre, m, at least a thousandth of the plate's size; a scale of errors."""
    start = start_motion(case)
    return max(float(np.hypot(x - start.x, y - start.y).max()), 1e-3 * case.plate.reach)


# --- laws -------------------------------------------------------------------------------------------------------------


def broken_laws(case: Case, motion: Trajectory, gap: np.ndarray) -> list[str]:
    """The laws of mechanics that a motion violates, one sentence each."""
    violations, far = [], LOOSE * case.plate.reach
    if np.nanmin(gap) < -far:
        at = motion.t[np.nanargmin(gap)]
        violations.append(f"the plate overlaps its track by {-np.nanmin(gap):.3g} m at t = {at:.6g} s")
    if not case.effect(Flight) and gap.max() > far:
        violations.append(f"the plate leaves its track by {gap.max():.3g} m and comes back")
    growth, kinetic = energy_growth(case, motion), mechanics.kinetic_energy(case, motion).max()
    rounding = ROUNDING * float(np.abs(mechanics.energy(case, motion)).max())
    has_power = case.effect(Load) or case.effect(Belt) or case.effect(Drive) or own_effects(case.effects)
    if not has_power and growth > ENERGY * max(kinetic, case.plate.mass * _slow(case, motion) ** 2) + rounding:
        violations.append(f"the energy grows by {growth:.3g} J without a load or a belt")
    if np.isfinite(motion.normal_force).all() and np.isfinite(motion.friction_force).all():
        violations += _broken_force_laws(case, motion)
    return violations


def _broken_force_laws(case: Case, motion: Trajectory) -> list[str]:
    """Violations by the forces: outside the cone, driving the slip, or not the cause of the motion."""
    violations, friction = [], case.effect(CoulombFriction)
    t, normal, tangential = motion.t, motion.normal_force, motion.friction_force
    slow = _slow(case, motion)
    # Forces too small to affect a motion of the scene are ignored: those of a weightless plate at rest are rounding.
    scale = CONE * max(float(np.abs(normal).max()), case.plate.mass * slow**2 / case.plate.reach)
    beyond = np.abs(tangential) - _cone(friction, motion.slip) * np.abs(normal)
    if not case.effect(PerfectlyRough) and np.max(beyond) > scale:
        violations.append(f"friction exceeds its cone by {np.max(beyond):.3g} N at t = {t[np.argmax(beyond)]:.6g} s")
    if case.effect(Unilateral) and normal.min() < -scale:
        violations.append(f"the track pulls with {-normal.min():.3g} N at t = {t[np.argmin(normal)]:.6g} s")
    power = np.where(np.isnan(motion.slip), 0.0, tangential * motion.slip)
    # Creep in stick has either sign; it is a small part of the speed.
    fastest = max(float(np.hypot(motion.vx, motion.vy).max()), slow)
    if power.max() > LOOSE * max(float(np.abs(tangential).max()), scale) * fastest:
        violations.append(f"friction drives the slip with {power.max():.3g} W at t = {t[np.argmax(power)]:.6g} s")
    # No column contains the impulse of an impact.
    # A driven track may turn, with the directions of the forces.
    unknown = case.effect(Impact) or case.effect(Drive)
    for what, error, tolerance in () if unknown else _momentum(case, motion):
        if error > tolerance:
            violations.append(f"the forces do not make the motion: {what} is off by {error:.3g} kg m/s")
    return violations


def _cone(friction: CoulombFriction | None, slip: np.ndarray) -> float | np.ndarray:
    """The largest friction per normal force at each slip velocity."""
    if friction is None or not friction.by_speed:
        return friction.stick if friction else 0.0
    return np.maximum(friction.stick, friction.at(np.abs(np.nan_to_num(slip))))


def _slow(case: Case, motion: Trajectory) -> float:
    """The speed, m/s, below which the plate counts as at rest."""
    return slowest(case, float(motion.t[-1] - motion.t[0]))


def _momentum(case: Case, motion: Trajectory) -> list[tuple[str, float, float]]:
    """For m vx and m vy: name, difference from the integral of the forces, and its tolerance (kg m/s)."""
    gravity, mass, applied = mechanics.gravity(case), case.plate.mass, mechanics.applied_forces(case, motion)
    place = np.where(np.isnan(motion.xi1), case.start.xi1, motion.xi1)  # in flight there are no forces
    normal, tangent = case.track.normal(place), case.track.tangent(place)
    rows = []
    for axis, rate in enumerate((motion.vx, motion.vy)):
        force = motion.normal_force * normal[axis] + motion.friction_force * tangent[axis] + applied[axis]
        force = force + mass * gravity[axis]
        off = mass * (rate - rate[0]) - cumulative_trapezoid(force, motion.t, initial=0.0)
        # The sum of forces that balance is uncertain by the rounding of the larger ones.
        uncertainty = mass * _slow(case, motion) + ROUNDING * float(trapezoid(np.abs(motion.normal_force), motion.t))
        # Where a force jumps between two samples, its integral is uncertain by half the jump times the gap.
        leaps = np.abs(np.diff(force))
        uncertainty += 0.5 * float(np.sum((leaps * np.diff(motion.t))[leaps > JUMP * np.abs(force).max()]))
        tolerance = ENERGY * float(trapezoid(np.abs(force), motion.t)) + uncertainty
        rows.append((f"m v{'xy'[axis]}", float(np.abs(off).max()), tolerance))
    return rows


def energy_growth(case: Case, motion: Trajectory) -> float:
    """The largest rise of the energy (J) above its previous minimum, without single samples at impacts."""
    total = mechanics.energy(case, motion)
    if case.effect(Impact):
        # Velocities computed from differences across an impact are wrong, at two samples of any nine.
        total = median_filter(total, size=9, mode="nearest")
    return float(mechanics.energy_growth(total).max())
