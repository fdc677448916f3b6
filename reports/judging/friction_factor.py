"""Friction ×: how many times the friction of its law a motion had, from its own loss of energy."""

from __future__ import annotations

import numpy as np

from cases import Case, CoulombFriction, Load, RollingResistance, Trajectory, Unilateral
from cases.mechanics import energy, gravity, kinetic_energy

# Where the law would take less than this part of the energy, the motion says nothing about friction: rounding and creep
# are as large.
_LEAST_LOSS = 1e-3


def friction_factor(case: Case, motion: Trajectory, end: float = np.inf) -> float:
    """Energy lost up to the time `end` over the energy that the case's law of friction takes from this very motion,
    Σ (μ|slip| + arm|ω|) N h: 1 for the law, 60 for an engine whose friction (and other losses) is 60 times as large.

    The normal force N is that of the motion's own momentum, m (Δv/h − g) − load, along the track's normal. The work of
    a load counts as energy given. NaN where the case has no Coulomb friction, where the plate flies (an impact loses
    energy without duration), and where the law would take next to nothing.
    """
    friction, resistance = case.effect(CoulombFriction), case.effect(RollingResistance)
    inside = motion.t <= end
    if friction is None or inside.sum() < 2 or not np.isfinite(motion.xi1[inside]).all():
        return np.nan
    h = np.diff(motion.t[inside])
    x, y, vx, vy, omega, slip, xi1 = (
        getattr(motion, name)[inside] for name in ("x", "y", "vx", "vy", "omega", "slip", "xi1")
    )
    load = _loads(case, motion, inside)
    weight = case.plate.mass * gravity(case)
    # Impulses of the contact in each step, N s.
    push_x = case.plate.mass * np.diff(vx) - h * (weight[0] + _middle(load[:, 0]))
    push_y = case.plate.mass * np.diff(vy) - h * (weight[1] + _middle(load[:, 1]))
    normal = np.asarray(case.track.normal(_middle(xi1)))
    pressed = push_x * normal[0] + push_y * normal[1]
    if case.effect(Unilateral) is None:
        pressed = np.abs(pressed)
    rates = friction.mu * np.abs(slip) + (resistance.arm * np.abs(omega) if resistance else 0.0)
    by_law = float(np.sum(_middle(rates) * pressed))
    given = float(np.sum(h * _middle(load[:, 0] * vx + load[:, 1] * vy + load[:, 2] * omega)))
    total = energy(case, motion)[inside]
    if not by_law > _LEAST_LOSS * float(np.max(kinetic_energy(case, motion)[inside])):
        return np.nan
    return float((total[0] - total[-1] + given) / by_law)


def _middle(values: np.ndarray) -> np.ndarray:
    """The mean of each two neighbours."""
    return 0.5 * (values[1:] + values[:-1])


def _loads(case: Case, motion: Trajectory, inside: np.ndarray) -> np.ndarray:
    """Force and moment of the case's load at the samples (n, 3); zero without one."""
    load = case.effect(Load)
    if load is None:
        return np.zeros((int(inside.sum()), 3))
    names = ("t", "x", "y", "theta", "vx", "vy", "omega")
    moves = np.column_stack([getattr(motion, name)[inside] for name in names])
    return np.array([load.at(*row) for row in moves.tolist()])
