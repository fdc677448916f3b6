"""The zeros of guards inside a step of DOP853, on its dense output."""

from __future__ import annotations

from collections.abc import Set

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ...scales import TOUCHES
from ..modes import Phase
from ..series import Series
from .first_step import gap_rounding, open_gaps, opening_gaps

# Places in a step at which guards are evaluated: Chebyshev–Lobatto points, which resolve a polynomial of DOP853's
# order.
NODES = 0.5 * (1 - np.cos(np.pi * np.arange(9) / 8))
# The same guards on a fine grid, by interpolation through the nodes (barycentric; Berrut & Trefethen, SIAM Review 46,
# 2004, 501: looked up).
FINE = np.linspace(0.0, 1.0, 129)


def _interpolation() -> np.ndarray:
    weights = (-1.0) ** np.arange(9) * np.where((np.arange(9) == 0) | (np.arange(9) == 8), 0.5, 1.0)
    difference = FINE[:, None] - NODES[None, :]
    exact = np.isclose(difference, 0.0, atol=1e-15)
    terms = weights / np.where(exact, 1.0, difference)
    rows = terms / terms.sum(axis=1, keepdims=True)
    hit = exact.any(axis=1)
    rows[hit] = exact[hit].astype(float)
    return rows


_TO_FINE = _interpolation()


# Next to an end of a step a guard is evaluated at this part of it, to see whether it falls from there.
INWARD = 1e-6


def weights(x):
    """The weights of the seven vectors F of a step's dense output at part x of the step: x, x (1−x), x² (1−x), …
    (Hairer, Nørsett & Wanner, II.6). One part as a float, or an array of them."""
    values = [x]
    for k in range(1, 7):
        values.append(values[-1] * (1.0 - x if k % 2 else x))
    return values


_AT_NODES = np.array(weights(NODES)).T


def guards_at_nodes(phase: Phase, piece) -> np.ndarray:
    """All guards at NODES of a step, shape (guards, nodes)."""
    # One product instead of SciPy's evaluation, which costs as much as a third of the step itself.
    states = (piece.y_old + _AT_NODES @ piece.F).T
    values = np.empty((len(phase.system.guards), len(NODES)))
    times = piece.t_old + piece.h * NODES
    with np.errstate(all="ignore"):
        for row, guard in zip(values, phase.system.guards_of_arrays(times, states, phase.parameters), strict=True):
            row[:] = guard  # a constant one is a number
    return values


def guard_at(phase: Phase, piece, index: int, x: float) -> float:
    """One guard at the part x of a step."""
    state, time = piece.y_old + weights(x) @ piece.F, piece.t_old + piece.h * x
    value = phase.system.guards_of_numbers(time, state.tolist(), phase.parameters)[index]
    if value == value:
        return value
    # Numbers have no value where any guard has none: where a divisor vanishes, it is itself a guard that is exactly 0.
    with np.errstate(all="ignore"):
        alone = phase.system.guards_of_arrays(np.array([time]), state[:, None], phase.parameters)[index]
    value = float(np.ravel(alone)[0])
    return value if value == value else 0.0  # the guard ends where its formula does


def first_zero(
    phase: Phase, piece, at_nodes: np.ndarray, first: bool, growing: Set[str] = frozenset()
) -> tuple[str, float] | None:
    """The first guard to reach zero inside the step, and its time; None if all stay positive. `first`: of a phase;
    `growing`: gaps that grow from zero, so that a rounding of either sign is none."""
    if piece.t <= piece.t_old:
        return None
    if first:
        # By the decision that began the phase all guards are positive just after its start; at the start itself one is
        # zero, up to a rounding of either sign.
        at_nodes[:, 0] = np.maximum(at_nodes[:, 0], 0.0)
    names = list(phase.system.guards)
    rounding = gap_rounding(phase, piece.y_old) if growing else 0.0
    for index in map(names.index, growing):
        at_nodes[index, np.abs(at_nodes[index]) <= rounding] = rounding
    fine = at_nodes @ _TO_FINE.T
    # Most guards of most steps are far from zero compared with how much they change.
    lowest = np.minimum.reduce(fine, axis=1).tolist()
    near = [i for i, row in enumerate(at_nodes.tolist()) if not lowest[i] > 0.1 * (max(row) - min(row))]
    earliest = None
    # A gap that is open at the start may close and open again before the first place of the grid.
    open_at_start = {index for index, _ in open_gaps(phase, piece.t_old, piece.y_old.tolist())} if first else ()
    for index in near:
        least = rounding if names[index] in growing else 0.0
        when = _zero_of_one(phase, piece, index, fine[index], first and index not in open_at_start, least)
        if when is not None and (earliest is None or when < earliest[1]):
            earliest = (names[index], when)
    return earliest


def _zero_of_one(phase: Phase, piece, index: int, fine: np.ndarray, first: bool, rounding: float = 0.0) -> float | None:
    """The time of the guard's first zero; values up to `rounding` of either sign count as positive."""
    h = piece.t - piece.t_old

    def value(s: float) -> float:
        now = guard_at(phase, piece, index, s)
        return now if abs(now) > rounding else rounding

    below = np.flatnonzero(fine[1:] <= 0.0) + 1
    if below.size:
        # The bracket may be wrong by the interpolation's error, so the guard itself is evaluated.
        low, high = float(FINE[below[0] - 1]), float(FINE[below[0]])
        while high < 1.0 and value(high) > 0.0:
            high = min(1.0, high + FINE[1])
        while low > 0.0 and value(low) <= 0.0:
            low, high = max(0.0, low - FINE[1]), low
        if value(high) <= 0.0:
            if low == 0.0 and first:
                low = FINE[1] * 1e-3
                while low > 1e-12 and value(low) <= 0.0:
                    low *= 0.1
                if value(low) <= 0.0:
                    # The phase ends before it is resolved: its start is nearer to the zero than any later state. (A
                    # spin of 1e-306 rad/s would end as one of -1e-31 rad/s.)
                    return piece.t_old
            if value(low) <= 0.0:
                return piece.t_old + h * low
            return piece.t_old + h * brentq(value, low, high, xtol=1e-15, rtol=8.9e-16)
    # No change of sign on the fine grid: the lowest place inside the step may still dip below zero between its points.
    lowest = int(np.argmin(fine))
    low, high = float(FINE[max(lowest - 1, 0)]), float(FINE[min(lowest + 1, len(FINE) - 1)])
    # At an end of the step it may, if the guard falls from there.
    if 0 < lowest < len(FINE) - 1 or value(abs(float(FINE[lowest]) - INWARD)) < fine[lowest]:
        dip = minimize_scalar(value, bounds=(low, high), method="bounded", options={"xatol": 1e-9})
        if dip.fun < 0.0 and not (first and low == 0.0):
            if value(low) <= 0.0:  # the interpolation is positive there, by a rounding
                return piece.t_old + h * low
            return piece.t_old + h * brentq(value, low, float(dip.x), xtol=1e-15, rtol=8.9e-16)
    return None


def never_opens(phase: Phase, piece, guard: str, when: float, first: bool) -> bool:
    """Whether a zero is that of a gap which is one at the step's start and has not opened before: it may grow more
    slowly at first, with the third power of time, than the dense output is wrong. In a shorter step that error is less
    by the eighth power. A gap that grows at the start by more than its rounding is a hop, however low."""
    if not guard.startswith("gap"):
        return False
    index = list(phase.system.guards).index(guard)
    half = 0.5 * (when - piece.t_old) / piece.h
    closed = first or abs(guard_at(phase, piece, index, 0.0)) <= gap_rounding(phase, piece.y_old)
    least = TOUCHES * (phase.size + abs(piece.y_old[0]) + abs(piece.y_old[1]))
    if not closed or guard_at(phase, piece, index, half) > least:
        return False
    rate, rounding = _rate(phase, piece, guard), gap_rounding(phase, piece.y_old)
    if not first and rate * piece.h < -rounding:  # it has opened by a rounding and closes
        return False
    # A hop of the least height that is no rounding, `bouncing.REBOUND_ROUNDINGS`, rises to a quarter of this.
    return rate * (when - piece.t_old) <= rounding


def _rate(phase: Phase, piece, guard: str) -> float:
    """The rate of a guard at a step's start; its guard is a condition of the phase."""
    state = piece.y_old.tolist()
    bounds = [np.finfo(float).eps * abs(value) for value in state]
    series = phase.system.expand(piece.t_old, state, bounds, phase.parameters, 1)[1]
    value = series[list(phase.system.conditions).index(guard)]
    return float(value.c[1]) if isinstance(value, Series) else 0.0


def growing_gaps(phase: Phase, piece) -> frozenset[str]:
    """The gaps that are roundings at a short step's start, and grow half-way and at its end."""
    starts = phase.system.guards_of_numbers(piece.t_old, piece.y_old.tolist(), phase.parameters)
    states = [(piece.t_old + x * piece.h, (piece.y_old + weights(x) @ piece.F).tolist()) for x in (0.5, 1.0)]
    names = list(phase.system.guards)
    return frozenset(names[index] for index in opening_gaps(phase, piece.y_old, starts, states))
