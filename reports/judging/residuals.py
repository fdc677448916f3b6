"""How sound a motion is, whatever its truth: energy closed, contact kept, matrix regular, answer independent of a bit.

Pure functions of cases and trajectories; SI units, residuals relative to the scene's own sizes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from math import inf, nan, sqrt
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

import reference
from cases import Case, CaseError, CoulombFriction, Curve, Gravity, Mode, Trajectory, Unilateral
from cases.contact import start_motion, velocity
from cases.trajectory import State
from reference.augmented import augmented_system

from . import distances

# Effects whose energy is known here: a conservative force, what friction takes, and a bound that does no work.
_BALANCED = (Gravity, CoulombFriction, Unilateral)
# Instants at which residuals and condition numbers are looked at: enough to meet the worst to within a few per cent.
_LOOKS = 200
# Gauss points between two samples of a dense motion: its steps carry polynomials of up to degree 25, their product with
# the slip's is integrated to rounding by 26, and between two of a DOP853's steps by far less.
_GAUSS = np.polynomial.legendre.leggauss(26)
# Neighbours by one unit in the last place that are asked: each takes a run of the reference.
NEIGHBOURS = 4
# A run tells where its inputs' last bits matter if it resolves about as little as they move. DOP853, which joins in to
# ask whether the sequence of modes is sure, takes thousands of steps at the limits of its rounding below 1e-11.
SPREAD_RTOL, OTHERS_RTOL = 1e-13, 1e-11


class Health(NamedTuple):
    """Residuals of a motion, NaN where it does not tell enough.

    `energy`: largest of |E(t) − E(0) − work of friction|, over the energy that moves; `energy_drift`: its slope, 1/s;
    `gap`: largest distance of the two contact points told (5) over the plate's size, `gap_drift` its slope, m/s;
    `tangency`: largest sine between the tangents at the contact parameters told (6).
    """

    energy: float = nan
    energy_drift: float = nan
    gap: float = nan
    gap_drift: float = nan
    tangency: float = nan


def examine(case: Case, motion: Trajectory) -> Health:
    """All residuals of a motion in contact."""
    energy, energy_drift = _energy(case, motion)
    gap, gap_drift = _gap(case, motion)
    return Health(energy, energy_drift, gap, gap_drift, _tangency(case, motion))


# --- energy -----------------------------------------------------------------------------------------------------------


def energy_residual(case: Case, motion: Trajectory) -> np.ndarray:
    """E(t) − E(0) − ∫ T v dt at the motion's samples, in parts of the energy that moves; NaN if it cannot be told."""
    if any(not isinstance(effect, _BALANCED) for effect in case.effects):
        return np.full(len(motion.t), nan)
    total = distances.energy(case, motion)
    off = total - total[0] - (work_of_friction(motion) if case.effect(CoulombFriction) else 0.0)
    kinetic = 0.5 * case.plate.mass * (motion.vx**2 + motion.vy**2) + 0.5 * case.plate.inertia * motion.omega**2
    scale = float(max(kinetic.max(), np.ptp(total - kinetic)))
    return off / scale if scale > 0.0 else off


def work_of_friction(motion: Trajectory) -> np.ndarray:
    """∫ T v dt from the start to each sample, J: Gauss's rule on a dense motion, trapezoids on samples."""
    steps = np.diff(motion.t)
    if motion.dense is None:
        power = motion.friction_force * motion.slip
        return np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * steps)])
    nodes, weights = _GAUSS
    # At a transition two samples share one time, and what lies between neighbours is smooth.
    times = motion.t[:-1, None] + 0.5 * steps[:, None] * (nodes + 1.0)
    state = motion(np.clip(times.ravel(), motion.t[0], motion.t[-1]))
    power = np.asarray(state.friction_force * state.slip).reshape(times.shape)
    return np.concatenate([[0.0], np.cumsum(0.5 * steps * (power @ weights))])


def _energy(case: Case, motion: Trajectory) -> tuple[float, float]:
    off = energy_residual(case, motion)
    return float(np.abs(off).max()), _slope(motion.t, off)


def _slope(t: np.ndarray, y: np.ndarray) -> float:
    """Least-squares rate of change of y; NaN where there is none."""
    if len(t) < 2 or t[-1] <= t[0] or not np.all(np.isfinite(y)):
        return nan
    along = t - t.mean()
    return float(along @ y / (along @ along))


# --- contact ----------------------------------------------------------------------------------------------------------


def _looks(motion: Trajectory) -> tuple[np.ndarray, State]:
    """Times spread over the motion's own samples, and its states there."""
    pick = np.unique(np.linspace(0, len(motion.t) - 1, min(_LOOKS, len(motion.t))).round().astype(int))
    return motion.t[pick], State(*(np.asarray(getattr(motion, name))[pick] for name in State._fields))


def _gap(case: Case, motion: Trajectory) -> tuple[float, float]:
    """(5): how far the outline's point at ξ₂ lies from the track's at ξ₁, over the plate's size, and its slope."""
    times, state = _looks(motion)
    if not np.all(np.isfinite(state.xi1)) or not np.all(np.isfinite(state.xi2)):
        return nan, nan
    (X, Y), (u, v) = case.track.point(np.asarray(state.xi1)), case.plate.outline.point(np.asarray(state.xi2))
    c, s = np.cos(state.theta), np.sin(state.theta)
    apart = np.hypot(state.x + c * u - s * v - X, state.y + s * u + c * v - Y)
    return float(apart.max()) / size(case), _slope(times, apart)


def size(case: Case) -> float:
    """The plate's reach from its centre of mass, m."""
    return float(np.hypot(*case.plate.outline.point(np.linspace(*case.plate.outline.look, 65))).max())


def _tangency(case: Case, motion: Trajectory) -> float:
    _, state = _looks(motion)
    if not np.all(np.isfinite(state.xi1)) or not np.all(np.isfinite(state.xi2)):
        return nan
    tx, ty = case.track.tangent(np.asarray(state.xi1))
    ox, oy = case.plate.outline.tangent(np.asarray(state.xi2))
    c, s = np.cos(state.theta), np.sin(state.theta)
    return float(np.abs(tx * (s * ox + c * oy) - ty * (c * ox - s * oy)).max())


# --- the augmented matrix ---------------------------------------------------------------------------------------------


class Conditioning(NamedTuple):
    """Condition numbers of the matrix of (27) along a motion: the largest as it stands in SI units, the largest in the
    plate's own units (its mass, its radius of gyration, arc lengths), and when (s) the latter is met."""

    largest: float
    scaled: float
    when: float


def conditioning(case: Case, motion: Trajectory) -> Conditioning:
    """How near to singular the augmented matrix comes along a motion that tells its modes."""
    times, state = _looks(motion)
    found = Conditioning(0.0, 0.0, nan)
    for i, t in enumerate(times):
        mode = _mode_at(motion, float(t))
        if mode is None or mode is Mode.FLIGHT:
            continue
        at = velocity(case, *(float(np.asarray(v)[i]) for v in (state.xi1, state.xi2, state.slip, state.omega)))
        matrix, _ = augmented_system(case, mode, (at.xi1, at.xi2, at.xi1_dot, at.xi2_dot))
        if not np.all(np.isfinite(matrix)):
            continue
        scaled = float(np.linalg.cond(_without_units(case, matrix, at.xi1, at.xi2)))
        found = Conditioning(
            max(found.largest, float(np.linalg.cond(matrix))),
            max(found.scaled, scaled),
            float(t) if scaled > found.scaled else found.when,
        )
    return found


def _mode_at(motion: Trajectory, t: float) -> Mode | None:
    mode = motion.first_mode
    for transition in motion.transitions:
        if transition.time > t:
            break
        mode = transition.after
    return mode


def _without_units(case: Case, matrix: np.ndarray, xi1: float, xi2: float) -> np.ndarray:
    """The matrix in the plate's own units: mass, radius of gyration and arc lengths are one."""
    m, rho = case.plate.mass, sqrt(case.plate.inertia / case.plate.mass)
    P, p = float(case.track.speed(xi1)), float(case.plate.outline.speed(xi2))
    # Units of the unknowns Ẍ₀, Ÿ₀, θ̈, ξ̈₁, ξ̈₂ and of one or two multipliers λ = N/P; then of the rows: two forces, a
    # moment, (8) twice, (9), and in roll R_pᵀ v.
    unknowns = np.array([rho, rho, 1.0, rho / P, rho / p, m * rho / P, m * rho / P])
    rows = np.array([m * rho, m * rho, m * rho**2, rho, rho, P * p, P * rho])
    n = len(matrix)
    return matrix * unknowns[:n] / rows[:n, None]


# --- the last bit -----------------------------------------------------------------------------------------------------


class Spread(NamedTuple):
    """What one unit in the last place of the inputs changes: `sequence` (a sentence if the modes change, else ""),
    the time of a transition (s), and the centre over the motion's extent."""

    sequence: str
    time: float
    centre: float


def neighbours(case: Case, count: int = NEIGHBOURS) -> Iterator[Case]:
    """The case with every input moved by one unit in the last place, up or down by chance (the same each time).

    Inputs are the curves' sizes, mass, inertia, the effects' numbers and the start; what is exactly zero stays.
    Raises CaseError where a neighbour is no case.
    """
    rng = np.random.default_rng(20010)

    def move(value: float) -> float:
        up = rng.random() < 0.5
        return float(np.nextafter(value, inf if up else -inf)) if value else value

    def curve(known: Curve) -> Curve:
        floats = sorted({abs(float(f)) for e in known.expression for f in e.atoms(sp.Float)})
        moved = {size: move(size) for size in floats}
        swap = {
            f: sp.Float(moved[abs(float(f))] * (1 if f > 0 else -1), 17) for e in known.expression
            for f in e.atoms(sp.Float)
        }  # fmt: skip
        return Curve(lambda s: tuple(e.xreplace(swap) for e in known.expression), known.domain)

    def numbers(known: Any) -> Any:
        floats = {f.name: getattr(known, f.name) for f in fields(known) if isinstance(getattr(known, f.name), float)}
        return replace(known, **{name: move(value) for name, value in floats.items()})

    for _ in range(count):
        plate = case.plate
        yield replace(
            case,
            track=curve(case.track),
            plate=replace(plate, outline=curve(plate.outline), mass=move(plate.mass), inertia=move(plate.inertia)),
            effects=tuple(numbers(effect) for effect in case.effects),
            start=numbers(case.start),
        )


def spread(case: Case, methods: tuple[str, ...] = reference.METHODS) -> Spread:
    """How far the reference's answers to a case and to its neighbours, by all methods in turn, lie apart."""
    centre = reference.simulate(case, rtol=SPREAD_RTOL, method=methods[0])
    kinds = [(t.before, t.after) for t in centre.transitions]
    times, found = np.linspace(0.0, 1.0, 101), Spread("", 0.0, 0.0)
    extent = max(float(np.hypot(np.ptp(centre.x), np.ptp(centre.y))), 1e-3 * size(case))
    try:
        for i, other in enumerate(neighbours(case)):
            method = methods[(i + 1) % len(methods)]
            rtol = SPREAD_RTOL if method == methods[0] else OTHERS_RTOL
            motion = reference.simulate(other, rtol=rtol, method=method)
            if motion.status != centre.status or [(t.before, t.after) for t in motion.transitions] != kinds:
                told = f"{len(motion.transitions)} transitions ({motion.status})"
                return Spread(f"{len(kinds)} transitions ({centre.status}) become {told}", inf, inf)
            last = min(centre.t[-1], motion.t[-1])
            here, there = centre(times * last), motion(times * last)
            apart = float(np.hypot(here.x - there.x, here.y - there.y).max()) / extent
            late = [abs(a.time - b.time) for a, b in zip(centre.transitions, motion.transitions, strict=True)]
            found = Spread("", max(found.time, *late, 0.0), max(found.centre, apart))
    except CaseError as problem:
        return Spread(f"a neighbour is refused: {problem}", inf, inf)
    return found


def motion_extent(case: Case, motion: Trajectory) -> float:
    """How far the centre of mass travels, m, at least a thousandth of the plate's size: what errors are parts of."""
    start = start_motion(case)
    return max(float(np.hypot(motion.x - start.x, motion.y - start.y).max()), 1e-3 * size(case))
