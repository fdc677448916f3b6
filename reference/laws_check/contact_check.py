"""Signorini's and Coulomb's laws at the contacts of a motion, at the nodes of its steps and, for what must not change
its sign, between them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cases import Mode, Unilateral
from cases.scene.free_plates import plates_of

from . import chebyshev
from .laws import (
    SENSE,
    STICKING,
    Defects,
    MotionScales,
    contact_laws,
    force_scale_at,
    material_velocity,
    relative_spin,
    turns_of,
)  # fmt: skip
from .samples import ContactInstants, MotionSamples
from .tolerances import AMPLIFICATION, CLOSED, EPS, FORCE, FRICTION, SLIP, TANGENT

# A polynomial whose last coefficients are below this part of the scale is what it approximates.
RESOLVED = 1e-9
# Steps that are not resolved are divided where a quantity comes nearer to zero than this part of its scale.
NEAR_ZERO = 1e-3
# The names of laws that say that a quantity does not change its sign, with the sign of contact_laws' sizes.
_SIGNS = ("normal force presses", "sense of slip", "Coulomb's cone")


def contact_defects(
    samples: MotionSamples, contact: ContactInstants, scales: MotionScales, is_listed: np.ndarray
) -> Iterator[Defects]:
    """Signorini's and Coulomb's laws at a contact, and that it stays closed with the slip that the motion has. In
    steps that are not listed the modes are not known, and friction lies in its cone."""
    law, times = contact.law, samples.times[contact.steps]
    force = force_scale_at(samples, law, scales)
    condition = scales.condition[contact.steps, None]
    still = SLIP + 20 * EPS * scales.acceleration * scales.last / scales.speed + AMPLIFICATION * condition
    modes = [mode if listed else None for mode, listed in zip(contact.modes, is_listed.tolist(), strict=True)]
    floors: dict[str, np.ndarray | float] = {
        "Coulomb's law in slip": FRICTION,
        "no friction": FRICTION,
        "no slip": still,
    }
    is_unilateral = samples.case.effect(Unilateral) is not None
    for mode in set(modes):
        here = np.array([other is mode for other in modes])
        rows = contact.slip[here], contact.normal[here], contact.friction[here]
        if mode in SENSE and law.is_rough:
            continue
        for name, sizes, unit in contact_laws(law, mode, is_unilateral, *rows):
            scale = scales.speed if unit == "m/s" else force
            floor = floors.get(name, FORCE if unit == "N" else SLIP + AMPLIFICATION * condition)
            floor = np.broadcast_to(floor, (len(here), sizes.shape[1]))[here]
            if name in _SIGNS:
                yield _between_nodes(name, law.name, times[here], sizes, scale, floor[:, 0], unit)
                continue
            bound = law.coefficient(rows[0]) * np.abs(rows[1]) if name == "Coulomb's law in slip" else None
            yield Defects(name, law.name, times[here], sizes, scale, unit, floor, bound)
        if mode is Mode.REST and plates_of(samples.case)[law.body].turns:
            spin = np.abs(relative_spin(samples, law, contact.steps[here]))
            yield Defects("no rotation", law.name, times[here], spin, scales.speed / scales.size, "rad/s", still[here])
    yield from _kinematics(samples, contact, scales, is_listed, still)


def _between_nodes(name, place, times, sizes, scale, floor, unit) -> Defects:
    """The largest sizes of each step, of the polynomial through its nodes where it is resolved."""
    low, at = chebyshev.least(-sizes)
    is_resolved = chebyshev.tail(sizes) < RESOLVED * scale
    largest = np.where(is_resolved, -low, sizes.max(axis=1))
    when = np.where(
        is_resolved, times[:, 0] + at * (times[:, -1] - times[:, 0]), times[np.arange(len(times)), sizes.argmax(axis=1)]
    )
    return Defects(name, place, when, largest, scale, unit, floor)


def _kinematics(samples, contact, scales, is_listed, still) -> Iterator[Defects]:
    """(5), (6) and (11): one point, one tangent, and the velocity of the plate there."""
    law, name, times = contact.law, contact.law.name, samples.times[contact.steps]
    turns = turns_of(samples.plates[law.body], scales.last)
    scale = scales.extent + scales.size * turns
    yield Defects("contact is closed", name, times, np.abs(contact.point - contact.base), scale, "m", CLOSED)
    across = np.abs((contact.direction * contact.tangent.conj()).imag)
    yield Defects("tangents agree", name, times, across, turns, "rad", TANGENT)
    moving = (
        material_velocity(samples, contact, law.body) - material_velocity(samples, contact, law.base)
    ) * contact.tangent.conj()
    slip = moving.real - (law.belt.at_arrays(times.ravel()).reshape(times.shape) if law.belt else 0.0)
    yield Defects("contact stays closed", name, times, np.abs(moving.imag), scales.speed, "m/s", still)
    other = np.where(is_listed[:, None], np.abs(slip - contact.slip), 0.0)
    floor = SLIP + AMPLIFICATION * scales.condition[contact.steps, None]
    yield Defects("slip velocity", name, times, other, scales.speed, "m/s", floor)


def unresolved_steps(samples: MotionSamples, scales: MotionScales) -> np.ndarray:
    """Numbers of the steps in which a quantity that must not change its sign comes near to zero and is not resolved."""
    every: list[np.ndarray] = []
    for contact in samples.contacts:
        force = force_scale_at(samples, contact.law, scales)
        stick = contact.law.stick if np.isfinite(contact.law.stick) else 0.0
        cone = stick * np.abs(contact.normal) - np.abs(contact.friction)
        sticks = np.array([mode in STICKING for mode in contact.modes])
        slips = np.array([mode in SENSE for mode in contact.modes])
        rows = ((contact.normal, force, True), (cone, force, sticks), (np.abs(contact.slip), scales.speed, slips))
        for values, scale, matters in rows:
            bad = (chebyshev.tail(values) >= RESOLVED * scale) & (values.min(axis=1) < NEAR_ZERO * scale) & matters
            every.append(contact.steps[bad])
    return np.unique(np.concatenate(every)) if every else np.array([], dtype=int)
