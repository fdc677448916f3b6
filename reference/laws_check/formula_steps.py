"""Steps of a motion in which formulas of the scene do more than the nodes show: a narrow bump of a load, of a belt's
speed, of friction by the slip speed or of a track's bend. They are divided until the nodes show it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cases import Case, Chain, Curve, Trajectory
from cases.formulas import formula_symbols
from cases.formulas.expression_code import ON_ARRAYS, python_function
from cases.formulas.expression_graph import Node, derivatives, from_sympy, symbol
from cases.formulas.features import degree
from cases.motion.trajectory import CONTACT
from cases.scene.free_plates import loads_of, names_of, plates_of

from .formula_intervals import enclosure
from .laws import MotionScales
from .samples import MotionSamples, contact_of, state_of

# Instants in each part of a step at which formulas are looked at, and how much wider than these values their arguments
# may be.
LOOKS, WIDER = 7, 0.15
# An enclosure this much wider than the values is no sign of more: interval arithmetic overestimates.
OVERESTIMATE, PART = 6.0, 1e-3
# Parts at a time, and halvings.
MOST_PARTS, MOST_HALVINGS = 4000, 40


class PathFormula(NamedTuple):
    """A formula along a motion: as a node, as a function on arrays, the names of its arguments, their values at times
    (n,) -> rows (arguments, n), the size of values that matters, and the steps in which it acts."""

    formula: Node
    values: Callable[..., np.ndarray]
    names: tuple[str, ...]
    path: Callable[[np.ndarray], np.ndarray]
    size: float
    steps: np.ndarray


def finer_steps(
    case: Case, motion: Trajectory, samples: MotionSamples, scales: MotionScales
) -> tuple[np.ndarray, np.ndarray]:
    """Starts and ends (s) of the parts of those steps that have to be divided."""
    cuts = [_cuts(samples, one) for one in _path_formulas(case, motion, samples, scales)]
    steps = np.concatenate([c[0] for c in cuts]) if cuts else np.array([], dtype=int)
    if not len(steps):
        return np.array([]), np.array([])
    places = np.concatenate([c[1] for c in cuts])
    start, end = list[float](), list[float]()
    for step in np.unique(steps):
        knots = np.unique([samples.start[step], *places[steps == step], samples.end[step]])
        start += knots[:-1].tolist()
        end += knots[1:].tolist()
    return np.array(start), np.array(end)


def _cuts(samples: MotionSamples, one: PathFormula) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of steps and times (s) at which they are divided."""
    step = one.steps
    low, high = samples.start[step], samples.end[step]
    steps, places = list[np.ndarray](), list[np.ndarray]()
    fractions = np.linspace(0.0, 1.0, LOOKS)
    for _ in range(MOST_HALVINGS):
        if not len(step):
            break
        times = low[:, None] + (high - low)[:, None] * fractions
        times[:, -1] = np.nextafter(high, -np.inf)
        rows = np.array(one.path(times.ravel())).reshape(len(one.names), *times.shape)
        values = np.broadcast_to(one.values(*rows), times.shape)
        spread = WIDER * np.ptp(rows, axis=-1) + 1e-15 * np.abs(rows).max(axis=-1)
        box = {n: (r.min(axis=-1) - s, r.max(axis=-1) + s) for n, r, s in zip(one.names, rows, spread, strict=True)}
        found = enclosure(one.formula, box)
        if found is None:
            break
        width = np.broadcast_to(found[1] - found[0], low.shape)
        largest = np.abs(values).max(axis=-1)
        is_wide = ~(width <= OVERESTIMATE * np.ptp(values, axis=-1) + PART * np.maximum(largest, one.size))
        is_wide &= np.isfinite(rows).all(axis=(0, 2)) & (high - low > 1e-13 * np.abs(high))
        if not is_wide.any() or is_wide.sum() > MOST_PARTS:
            break
        step, low, high = step[is_wide], low[is_wide], high[is_wide]
        middle = 0.5 * (low + high)
        steps.append(step)
        places.append(middle)
        step, low, high = np.tile(step, 2), np.concatenate([low, middle]), np.concatenate([middle, high])
    if not steps:
        return np.array([], dtype=int), np.array([])
    return np.concatenate(steps), np.concatenate(places)


def _path_formulas(
    case: Case, motion: Trajectory, samples: MotionSamples, scales: MotionScales
) -> Iterator[PathFormula]:
    every = np.flatnonzero(~samples.is_straight)
    for name, plate, load in zip(names_of(case), plates_of(case), loads_of(case), strict=True):
        if load is not None:
            state = lambda t, n=name: np.array([t, *np.broadcast_arrays(t, *state_of(motion, n, t)[:6])[1:]])  # noqa: E731
            for part in load.expression:
                yield from _one(formula_symbols.MOTION, part, state, plate.mass * scales.acceleration, every)
    for contact in samples.contacts:
        law, steps = contact.law, contact.steps[~samples.is_straight[contact.steps]]
        own = motion.contact_names[[n or CONTACT for n in motion.contact_names].index(law.name)]
        column = lambda which, t, n=own: np.broadcast_to(getattr(contact_of(motion, n, t), which), t.shape)[None]  # noqa: E731
        if law.belt is not None:
            yield from _one((formula_symbols.TIME,), law.belt.expression, lambda t: t[None], scales.speed, steps)
        if law.friction is not None and law.friction.by_speed:
            slip = lambda t, c=column: np.abs(c("slip", t))  # noqa: E731
            yield from _one((formula_symbols.SLIP_SPEED,), law.friction.mu, slip, 0.0, steps)
        for bend in _bends(law.track) if law.base is None else ():
            xi1 = lambda t, c=column: c("xi1", t)  # noqa: E731
            if degree(bend, bend.symbols) > 2:
                yield PathFormula(bend, _function(("s",), bend), ("s",), xi1, 100.0 / scales.size, steps)


def _one(symbols, expression, path, size: float, steps: np.ndarray) -> Iterator[PathFormula]:
    """A formula, unless its values at the nodes determine it."""
    formula = from_sympy(expression)
    if degree(formula, formula.symbols) > 2:
        names = tuple(s.name for s in symbols)
        yield PathFormula(formula, _function(names, formula), names, path, size, steps)


@lru_cache(maxsize=256)
def _function(names: tuple[str, ...], formula: Node) -> Callable[..., np.ndarray]:
    """The values of a formula on arrays of its arguments."""
    values = python_function([symbol(name) for name in names], [formula], ON_ARRAYS)
    return lambda *rows: np.asarray(values(*rows)[0], dtype=float)


@lru_cache(maxsize=256)
def _bends(track: Curve) -> tuple[Node, ...]:
    """The second derivatives of a track's formulas."""
    if isinstance(track, Chain) or track.parts is not None or track.integrals:
        return ()
    rows = track.rows
    parameter = next((s for row in rows for s in row.symbols), None)
    if parameter is None:
        return ()
    return tuple(bend for bend in derivatives(derivatives(rows, parameter), parameter) if bend.symbols)
