"""Contacts at one instant of a motion: where plates touch, and how velocities and forces there go with those of the
plates. Generalised coordinates are (x, y, θ) of each plate, one after the other; plane vectors are complex numbers."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cases import Case, Chain, Curve, Mode
from cases.curves.corner import Corner
from cases.scene.free_plates import plates_of

from .samples import ContactInstants, ContactLaw, MotionSamples, PlateSamples, place_at

# Within this part of a radian or of a metre of the parameter two places of a chain are one.
JOINT = 1e-9


class TouchNow(NamedTuple):
    """A place at which a plate touches a curve or another plate: the laws there, the mode, the point (complex, m), the
    unit tangent, the gap of both curves (m), the rows (3 plates,) of the velocities along the tangent and the normal,
    slip velocity (m/s), and the contact parameters."""

    law: ContactLaw
    mode: Mode
    point: complex
    tangent: complex
    gap: complex
    along: np.ndarray
    across: np.ndarray
    slip: float
    xi1: float
    xi2: float


def plates_at(samples: MotionSamples, step: int, node: int) -> PlateSamples:
    """The plates at a node of a step."""
    rows = [[row[step, node] for row in one] for one in samples.plates]
    return PlateSamples(*(np.array(column) for column in zip(*rows, strict=True)))


def row_of(contact: ContactInstants, step: int) -> int | None:
    """The row of a contact's arrays in which a step is, or None where it is open."""
    i = int(np.searchsorted(contact.steps, step))
    return i if i < len(contact.steps) and contact.steps[i] == step else None


def touches_at(samples: MotionSamples, step: int, node: int) -> list[TouchNow]:
    """The closed contacts at a node of a step."""
    plates, result = plates_at(samples, step, node), list[TouchNow]()
    t = float(samples.times[step, node])
    for contact in samples.contacts:
        i = row_of(contact, step)
        if i is not None:
            xi1, xi2 = float(contact.xi1[i, node]), float(contact.xi2[i, node])
            result.append(touch(samples.case, contact.law, contact.modes[i], plates, xi1, xi2, t))
    return result


def touch(case: Case, law: ContactLaw, mode: Mode, plates: PlateSamples, xi1: float, xi2: float, t: float) -> TouchNow:
    """The contact of a pair at given parameters."""
    own, _ = place_at(law.outline, xi2)
    point, tangent = place_at(law.track, xi1)
    if law.base is not None:  # an outline runs with the other plate on its right
        point = complex(plates.place[law.base] + plates.turn[law.base] * point)
        tangent = complex(-plates.turn[law.base] * tangent)
    outer = complex(plates.place[law.body] + plates.turn[law.body] * own)
    along, across = (direction_row(case, law, plates, point, d) for d in (tangent, 1j * tangent))
    belt = float(law.belt.at(t)[0]) if law.belt else 0.0
    slip = float(along @ plates.rates) - belt
    return TouchNow(law, mode, point, tangent, outer - point, along, across, slip, xi1, xi2)


def direction_row(case: Case, law: ContactLaw, plates: PlateSamples, point: complex, direction: complex) -> np.ndarray:
    """The row (3 plates,) of the velocity of a plate's point along a direction, against that of its base: also the
    generalised force of a unit force there."""
    row = np.zeros(3 * len(plates.place))
    for body, sign in ((law.body, 1.0), (law.base, -1.0)):
        if body is not None:
            own = plates_of(case)[body]
            turns = own.turns or own.spins_by_load
            lever = ((point - plates.place[body]).conjugate() * direction).imag if turns else 0.0
            row[3 * body : 3 * body + 3] += sign * np.array([direction.real, direction.imag, lever])
    return row


def couple_row(law: ContactLaw, count: int) -> np.ndarray:
    """The row (3 plates,) of the rotation of a plate against its base."""
    row = np.zeros(3 * count)
    row[3 * law.body + 2] = 1.0
    if law.base is not None:
        row[3 * law.base + 2] = -1.0
    return row


@lru_cache(maxsize=256)
def masses(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Masses and moments of inertia of all plates (finite: 0 where a plate does not turn), and their inverses."""
    rows = [(p.mass, p.mass, p.inertia if p.turns else 0.0) for p in plates_of(case)]
    own = np.array(rows).ravel()
    return own, np.divide(1.0, own, out=np.zeros_like(own), where=own > 0.0)


def largest_rate(rates: np.ndarray, size: float) -> float:
    """The largest of generalised velocities or accelerations of plates of that size (m); infinite for NaN."""
    parts = rates.reshape(-1, 3)
    largest = float((np.hypot(parts[:, 0], parts[:, 1]) + size * np.abs(parts[:, 2])).max())
    return largest if np.isfinite(largest) else np.inf


def is_at_joint(curve: Curve, s: float) -> bool:
    """Whether a place of a curve is the end of one of its pieces."""
    return to_joint(curve, s) < JOINT


def to_joint(curve: Curve, s: float) -> float:
    """How far a place of a curve is from the nearest end of one of its pieces, in its parameter."""
    off = s - _joints(curve)
    if curve.period:
        off = (off + 0.5 * curve.period) % curve.period - 0.5 * curve.period
    return float(np.abs(off).min(initial=np.inf))


@lru_cache(maxsize=256)
def _joints(curve: Curve) -> np.ndarray:
    if isinstance(curve, Chain):
        return np.array([element.start for element in curve.elements] + [curve.span[1]])
    return np.array(getattr(curve, "knots", ()))


def bend_at(curve: Curve, s: float) -> float:
    """The curvature at a place, 1/m; infinite at a corner."""
    return float(curve.curvature(np.array([s]))[0]) if not isinstance(curve, Corner) else np.inf
