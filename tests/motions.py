"""The same scene seen otherwise: in a mirror, turned, in other units. And a case's reference motion, solved once."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import pi

import numpy as np

import reference
from cases import Case, Curve, Gravity, Start, Trajectory
from cases import curves as c
from cases.contact import start_motion
from cases.curves import PARAMETER


@lru_cache(maxsize=256)
def motion_of(case: Case) -> Trajectory:
    """The reference's motion at 1e-12."""
    return reference.simulate(case, rtol=1e-12)


def _gravity(case: Case, strength: float, turned):
    return tuple(
        Gravity(strength * e.g, turned(e.direction)) if isinstance(e, Gravity) else e  # friction has no direction
        for e in case.effects
    )


def _mirrored_curve(curve: Curve) -> Curve:
    x, y = curve.expression
    domain = curve.domain and (-curve.domain[1], -curve.domain[0])
    return Curve(lambda s: (-x.subs(PARAMETER, -s), y.subs(PARAMETER, -s)), domain)


def mirrored(case: Case) -> Case:
    """In a mirror along Y; parameters run backwards, so that the plate is still on the left."""
    start = start_motion(case)
    return replace(
        case,
        track=_mirrored_curve(case.track),
        plate=replace(case.plate, outline=_mirrored_curve(case.plate.outline)),
        effects=_gravity(case, 1.0, lambda direction: pi - direction),
        start=Start(-start.xi1, -start.xi2, -start.slip, -start.omega),
    )


def in_other_units(case: Case, length: float, time: float, mass: float, turn: float) -> Case:
    """Turned by an angle, and with all lengths, times and masses multiplied."""

    def moved(curve: Curve, angle: float) -> Curve:
        x, y = (length * part for part in curve.expression)
        a, b = c.cos(angle), c.sin(angle)
        return Curve(lambda s: (a * x - b * y, b * x + a * y), curve.domain)

    start = start_motion(case)
    plate = case.plate
    return replace(
        case,
        track=moved(case.track, turn),
        plate=replace(
            plate, outline=moved(plate.outline, 0), mass=mass * plate.mass, inertia=mass * length**2 * plate.inertia
        ),
        effects=_gravity(case, length / time**2, lambda direction: direction + turn),
        start=Start(start.xi1, start.xi2, start.slip * length / time, start.omega / time),
        duration=case.duration * time,
    )


def energy(case: Case, state) -> np.ndarray:
    """Kinetic and potential energy, J."""
    gravity = case.effect(Gravity) or Gravity(0.0)
    height = -(state.x * np.cos(gravity.direction) + state.y * np.sin(gravity.direction))
    kinetic = 0.5 * case.plate.mass * (state.vx**2 + state.vy**2) + 0.5 * case.plate.inertia * state.omega**2
    return kinetic + case.plate.mass * gravity.g * height


def work_of_friction(motion: Trajectory) -> float:
    """∫ T v dt, J, by Gauss's rule between transitions."""
    nodes, weights = np.polynomial.legendre.leggauss(10)
    ends = [0.0, *(t.time for t in motion.transitions), float(motion.t[-1])]
    total = 0.0
    for low, high in zip(ends[:-1], ends[1:], strict=True):
        edges = np.linspace(low, high, 41)
        half = np.diff(edges)[:, None] / 2
        times = (edges[:-1, None] + half + half * nodes).ravel()
        state = motion(times)
        total += float(np.sum((half * weights).ravel() * state.friction_force * state.slip))
    return total
