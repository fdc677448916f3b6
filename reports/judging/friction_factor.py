"""Friction ×: how many times the friction of its law a motion had, from its own loss of energy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import Case, CoulombFriction, Load, RollingResistance, Trajectory, Unilateral
from cases.mechanics import energy, gravity, kinetic_energy

# A case whose friction takes less than this part of its largest kinetic energy says nothing about friction: the errors
# of an engine's energy are as large.
_LEAST_LOSS = 1e-3
# A motion that slips so little that its law would take less than this part of the truth's loss has no friction ×: an
# engine with 10,000 times the friction is the last that has one.
_LEAST_SLIP = 1e-4


class Losses(NamedTuple):
    """Energy that a motion lost, J, and what the case's law of friction takes from that very motion, J."""

    lost: float
    by_law: float


def friction_factor(case: Case, motion: Trajectory, truth: Losses, end: float) -> float:
    """Energy lost up to the time `end` over what the law of friction takes from this very motion: 1 for the law, 60 for
    an engine whose friction (and other losses) is 60 times as large. `truth`: the losses of the true motion.

    NaN where the losses are not known, and where friction takes next to nothing from the truth or from the motion.
    """
    own = losses(case, motion if motion.dense is None else _sampled(motion), end)
    known = np.isfinite(own.by_law) and np.isfinite(truth.by_law)
    if not known or own.by_law <= _LEAST_SLIP * truth.by_law or truth.by_law <= 0.0:
        return np.nan
    return own.lost / own.by_law


def losses_of_truth(case: Case, truth: Trajectory) -> Losses:
    """The losses of the true motion; none where friction takes next to nothing."""
    found = losses(case, _sampled(truth), float(truth.t[-1]))
    largest = float(np.max(kinetic_energy(case, truth)))
    return found if found.by_law > _LEAST_LOSS * largest else Losses(found.lost, np.nan)


def _sampled(motion: Trajectory) -> Trajectory:
    """A motion that is known at every time, at times so near to each other that trapezoids are good to 1e-4."""
    times = np.linspace(motion.t[0], motion.t[-1], 4001)
    return Trajectory(t=times, **motion(times)._asdict())


def losses(case: Case, motion: Trajectory, end: float) -> Losses:
    """The losses of a motion up to the time `end`: the law takes Σ (μ|slip| + arm|ω|) N h.

    The normal force N is that of the motion's own momentum, m (Δv/h − g) − load, along the track's normal. The work of
    a load counts as energy given. NaN where the case has no Coulomb friction, and where the plate flies: an impact
    loses energy without duration.
    """
    friction, resistance = case.effect(CoulombFriction), case.effect(RollingResistance)
    inside = motion.t <= end
    if friction is None or inside.sum() < 2 or not np.isfinite(motion.xi1[inside]).all():
        return Losses(np.nan, np.nan)
    h = np.diff(motion.t[inside])
    vx, vy, omega, slip, xi1 = (getattr(motion, name)[inside] for name in ("vx", "vy", "omega", "slip", "xi1"))
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
    given = np.sum(h * _middle(load[:, 0] * vx + load[:, 1] * vy + load[:, 2] * omega))
    total = energy(case, motion)[inside]
    return Losses(float(total[0] - total[-1] + given), float(np.sum(_middle(rates) * pressed)))


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
