"""Columns of a motion with several contacts: of the plate, and of each contact."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import Case, State

from ..minimal.integrators.segment import Segment
from .decision import load_at
from .equations import COLUMNS
from .forces import Ranges, ranges
from .geometry import places
from .regimes import SeveralPhase, body_of, coefficients, pairs_of


class ContactStates(NamedTuple):
    """One contact at n instants, arrays (n,): gap (m), slip velocity (m/s), normal and friction force (N, NaN where they
    are not unique), contact parameters; slip and parameters are NaN where it is not watched."""

    gap: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray


def contact_states(case: Case, now: SeveralPhase, times: np.ndarray, y: np.ndarray, name: str) -> ContactStates:
    """One contact of a phase at some instants; `y` (variables, n)."""
    none = np.full(times.shape, np.nan)
    if name not in now.regime.names:
        return ContactStates(none, none, 0.0 * times, 0.0 * times, none, none)
    k = now.regime.names.index(name)
    xi1, xi2 = y[3 + 2 * k], y[4 + 2 * k]
    if now.regime.rests:
        normal, friction = _rest_forces(case, now, times, y, k)
        is_closed = k in now.regime.closed
        return ContactStates(_gap(case, y, k, is_closed), 0.0 * times if is_closed else none, normal, friction, xi1, xi2)
    values = now.system.outputs_of_arrays(times, y, now.parameters)
    columns = values[5 + len(COLUMNS) * k : 5 + len(COLUMNS) * (k + 1)]
    normal, friction, slip, _, _ = (np.broadcast_to(np.asarray(row, dtype=float), times.shape) for row in columns)
    is_closed, mass = k in now.regime.closed, case.plate.mass
    return ContactStates(
        _gap(case, y, k, is_closed), slip if is_closed else none, mass * normal, mass * friction, xi1, xi2
    )


def _gap(case: Case, y: np.ndarray, k: int, is_closed: bool) -> np.ndarray:
    """The distance of contact k's points, 0 while it is closed."""
    from .meetings import _gaps

    return np.zeros(y.shape[1]) if is_closed else _gaps(case, y, k)


def _rest_forces(case: Case, now: SeveralPhase, times: np.ndarray, y: np.ndarray, k: int):
    """Normal and friction force of contact k of a plate at rest, NaN where they are not unique."""
    closed, stick = now.regime.closed, coefficients(case)[1]
    if k not in closed:
        return 0.0 * times, 0.0 * times
    state = y[:, 0]
    at = places(case, body_of(state), pairs_of(state))
    rows = [at[i].lift_row for i in closed] + [at[i].slip_row for i in closed if stick > 0.0]
    matrix = np.array(rows).T
    if np.linalg.matrix_rank(matrix, tol=1e-9) < matrix.shape[1]:
        return np.full(times.shape, np.nan), np.full(times.shape, np.nan)
    load = np.array([load_at(case, float(t), body_of(state)) for t in times]).T
    values, *_ = np.linalg.lstsq(matrix, -load, rcond=None)
    i = closed.index(k)
    return values[i], values[len(closed) + i] if stick > 0.0 else 0.0 * times


def observe(case: Case, now: SeveralPhase, times: np.ndarray, y: np.ndarray) -> State:
    """The plate's pose and velocities, and slip, forces and parameters of the first closed contact; as in flight if
    none is closed."""
    closed = now.regime.closed
    x, y0, theta, vx, vy, omega = *y[:3], *y[-3:]
    if not closed:
        none, nothing = np.full(times.shape, np.nan), np.zeros(times.shape)
        return State(x, y0, theta, vx, vy, omega, none, nothing, nothing, none, none)
    one = contact_states(case, now, times, y, now.regime.names[closed[0]])
    return State(x, y0, theta, vx, vy, omega, one.slip, one.normal_force, one.friction_force, one.xi1, one.xi2)


def force_ranges(case: Case, segment: Segment, t: float) -> dict[str, np.ndarray]:
    """For each closed contact at an instant: least and greatest normal force and friction force, shape (2, 2)."""
    now, state = segment.phase, segment.states(np.array([t]))[:, 0]
    regime = now.regime
    names = [regime.names[k] for k in regime.closed]
    if not regime.rests:
        values = [contact_states(case, now, np.array([t]), state[:, None], name) for name in names]
        pairs = [(float(one.normal_force[0]), float(one.friction_force[0])) for one in values]
        return {name: np.array([[n, n], [f, f]]) for name, (n, f) in zip(names, pairs, strict=True)}
    at = places(case, body_of(state), pairs_of(state))
    limits: Ranges = ranges(
        [at[k] for k in regime.closed], load_at(case, t, body_of(state)), case.plate.gyration, coefficients(case)[1]
    )
    return {name: np.array([limits.normal[i], limits.friction[i]]) for i, name in enumerate(names)}
