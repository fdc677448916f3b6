"""`python -m tests.benchmarks.hard_scenes`: the constants of the hard scenes, which no engine changes.

How ill-conditioned the paper's matrix (27) becomes along each motion, and what one unit in the last place of the inputs
does to it. Writes the file that the study `stability` reads; takes minutes.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import fields, replace
from math import inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

import cases
import reference
from cases import Case, CaseError, Curve, Mode, Trajectory
from cases.contact import velocity
from reference.paper.augmented import condition, fill
from reports.judging.residuals import looks
from reports.running.true_motions import true_motion
from reports.studies.stability.study import CONSTANTS, scene_of

# Number of neighbouring cases (by one unit in the last place): each takes a run of the reference.
NEIGHBOURS = 4
# A run shows the effect of the inputs' last bits if its own error is about as small as that effect. DOP853, which only
# checks the sequence of modes, takes thousands of steps at its rounding limit below 1e-11.
SPREAD_RTOL, OTHERS_RTOL = 1e-13, 1e-11


# --- the augmented matrix ---------------------------------------------------------------------------------------------


class Conditioning(NamedTuple):
    """Condition numbers of the matrix of (27) along a motion: the largest in SI units, the largest in the plate's own
    units (its mass, its radius of gyration, arc lengths), and the time (s) of the latter."""

    largest: float
    dimensionless: float
    when: float


def conditioning(case: Case, motion: Trajectory) -> Conditioning:
    """The largest condition numbers of the augmented matrix along a motion with modes."""
    times, state = looks(motion)
    largest_so_far = Conditioning(0.0, 0.0, nan)
    for i, t in enumerate(times):
        mode = _mode_at(motion, float(t))
        if mode is None or mode is Mode.FLIGHT:
            continue
        at = velocity(case, *(float(np.asarray(v)[i]) for v in (state.xi1, state.xi2, state.slip, state.omega)))
        system = fill(case, mode, (at.xi1, at.xi2, at.xi1_dot, at.xi2_dot), time=float(t))
        if not np.all(np.isfinite(system.matrix)):
            continue
        dimensionless = condition(case, system)
        largest_so_far = Conditioning(
            max(largest_so_far.largest, float(np.linalg.cond(system.matrix))),
            max(largest_so_far.dimensionless, dimensionless),
            float(t) if dimensionless > largest_so_far.dimensionless else largest_so_far.when,
        )
    return largest_so_far


def _mode_at(motion: Trajectory, t: float) -> Mode | None:
    mode = motion.first_mode
    for transition in motion.transitions:
        if transition.time > t:
            break
        mode = transition.after
    return mode


# --- the last bit -----------------------------------------------------------------------------------------------------


class Sensitivity(NamedTuple):
    """Changes by one unit in the last place of the inputs: `sequence` (a sentence if the modes change, otherwise ""),
    the time of a transition (s), and the centre over the motion's extent."""

    sequence: str
    time: float
    centre: float


def neighbours(case: Case, count: int = NEIGHBOURS) -> Iterator[Case]:
    """Neighbours of a case: every input is changed by one unit in the last place, up or down at random (fixed seed).

    Inputs are the curves' sizes, mass, inertia, the effects' numbers and the start; exact zeros do not change. Raises
    CaseError if a neighbour is not a valid case.
    """
    rng = np.random.default_rng(20010)

    def move(value: float) -> float:
        up = rng.random() < 0.5
        return float(np.nextafter(value, inf if up else -inf)) if value else value

    def curve(original: Curve) -> Curve:
        if original.parts is not None:
            return original  # its pieces would no longer meet
        floats = sorted({abs(float(f)) for e in original.expression for f in e.atoms(sp.Float)})
        new_values = {size: move(size) for size in floats}
        swap = {
            f: sp.Float(new_values[abs(float(f))] * (1 if f > 0 else -1), 17) for e in original.expression
            for f in e.atoms(sp.Float)
        }  # fmt: skip
        return Curve(lambda s: tuple(e.xreplace(swap) for e in original.expression), original.domain)

    def numbers(original: Any) -> Any:
        floats = {
            f.name: getattr(original, f.name) for f in fields(original) if isinstance(getattr(original, f.name), float)
        }
        return replace(original, **{name: move(value) for name, value in floats.items()})

    for _ in range(count):
        plate = case.plate
        yield replace(
            case,
            track=curve(case.track),
            plate=replace(plate, outline=curve(plate.outline), mass=move(plate.mass), inertia=move(plate.inertia)),
            effects=tuple(numbers(effect) for effect in case.effects),
            start=numbers(case.start),
        )


def spread(case: Case, methods: tuple[str, ...] = reference.METHODS) -> Sensitivity:
    """The largest differences between the reference's motions of a case and of its neighbours, by all methods in turn.

    Differences below the methods' own errors are invisible: about 30 units in the last place if DOP853 is alone.
    """
    centre = reference.simulate(case, rtol=SPREAD_RTOL, method=methods[0])
    kinds = [(t.before, t.after) for t in centre.transitions]
    times, largest = np.linspace(0.0, 1.0, 101), Sensitivity("", 0.0, 0.0)
    extent = max(float(np.hypot(np.ptp(centre.x), np.ptp(centre.y))), 1e-3 * case.plate.reach)
    try:
        for i, other in enumerate(neighbours(case)):
            method = methods[(i + 1) % len(methods)]
            rtol = SPREAD_RTOL if method == methods[0] else OTHERS_RTOL
            motion = reference.simulate(other, rtol=rtol, method=method)
            if motion.status != centre.status or [(t.before, t.after) for t in motion.transitions] != kinds:
                outcome = f"{len(motion.transitions)} transitions ({motion.status})"
                return Sensitivity(f"{len(kinds)} transitions ({centre.status}) become {outcome}", inf, inf)
            last = min(centre.t[-1], motion.t[-1])
            here, there = centre(times * last), motion(times * last)
            distance = float(np.hypot(here.x - there.x, here.y - there.y).max()) / extent
            late = [abs(a.time - b.time) for a, b in zip(centre.transitions, motion.transitions, strict=True)]
            largest = Sensitivity("", max(largest.time, *late, 0.0), max(largest.centre, distance))
    except CaseError as problem:
        return Sensitivity(f"a neighbouring case is rejected: {problem}", inf, inf)
    return largest


# --- the file ---------------------------------------------------------------------------------------------------------


def row(case: Case) -> dict[str, Any]:
    """The constants of a scene, in the columns of the file; empty where a number is not known or infinite."""
    change, scene = spread(case), scene_of(case)
    values: dict[str, float] = {"spread": change.centre, "spread_time": change.time}
    motion = None if scene.truth.failure else true_motion(case, scene.truth.method)
    if motion is not None:
        worst = conditioning(case, motion)
        values |= {"condition": worst.dimensionless, "condition_si": worst.largest, "condition_time": worst.when}
    numbers = {name: f"{value:.4g}" if isfinite(value) else "" for name, value in values.items()}
    return {"case": case.label, "last_bit": change.sequence} | numbers


def scenes() -> list[Case]:
    """All hard cases of the catalogue but those that take minutes: five motions of each are compared."""
    return [case for name in cases.names(hard=True) for case in cases.select(name)]


def main() -> None:
    """Write the file."""
    columns = ("case", "last_bit", "condition", "condition_si", "condition_time", "spread", "spread_time")
    with open(CONSTANTS, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n", restval="")
        writer.writeheader()
        for case in scenes():
            writer.writerow(row(case))
            file.flush()


if __name__ == "__main__":
    main()
