"""How much hangs on the last bit: condition of the paper's matrix along a motion, and what neighbours of a case do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

import reference
from cases import Case, CaseError, Curve, Mode, Trajectory
from cases.contact import velocity
from reference.paper.augmented import condition, fill

from ...judging.residuals import looks

# Neighbours by one unit in the last place that are asked: each takes a run of the reference.
NEIGHBOURS = 4
# A run tells where its inputs' last bits matter if it resolves about as little as they move. DOP853, which joins in to
# ask whether the sequence of modes is sure, takes thousands of steps at the limits of its rounding below 1e-11.
SPREAD_RTOL, OTHERS_RTOL = 1e-13, 1e-11


# --- the augmented matrix ---------------------------------------------------------------------------------------------


class Conditioning(NamedTuple):
    """Condition numbers of the matrix of (27) along a motion: the largest as it stands in SI units, the largest in the
    plate's own units (its mass, its radius of gyration, arc lengths), and when (s) the latter is met."""

    largest: float
    scaled: float
    when: float


def conditioning(case: Case, motion: Trajectory) -> Conditioning:
    """How near to singular the augmented matrix comes along a motion that tells its modes."""
    times, state = looks(motion)
    found = Conditioning(0.0, 0.0, nan)
    for i, t in enumerate(times):
        mode = _mode_at(motion, float(t))
        if mode is None or mode is Mode.FLIGHT:
            continue
        at = velocity(case, *(float(np.asarray(v)[i]) for v in (state.xi1, state.xi2, state.slip, state.omega)))
        filled = fill(case, mode, (at.xi1, at.xi2, at.xi1_dot, at.xi2_dot), time=float(t))
        if not np.all(np.isfinite(filled.matrix)):
            continue
        scaled = condition(case, filled)
        found = Conditioning(
            max(found.largest, float(np.linalg.cond(filled.matrix))),
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
    """How far the reference's answers to a case and to its neighbours, by all methods in turn, lie apart.

    What is smaller than the methods' own errors is not seen: some 30 units in the last place where DOP853 is alone.
    """
    centre = reference.simulate(case, rtol=SPREAD_RTOL, method=methods[0])
    kinds = [(t.before, t.after) for t in centre.transitions]
    times, found = np.linspace(0.0, 1.0, 101), Spread("", 0.0, 0.0)
    extent = max(float(np.hypot(np.ptp(centre.x), np.ptp(centre.y))), 1e-3 * case.plate.reach)
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
