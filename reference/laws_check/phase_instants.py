"""The laws at one instant of each phase of a contact, in numbers: a motion by the Taylor method takes 0.3 ms, of which
arrays would take twice as much.

In a step that begins at t the contact's parameters are ξ + ξ̇ τ + ½ ξ̈ τ² + …, and with R₀ = R(ξ₁) − Q p(ξ₂) and the
turn Q of the angle θ = φ₁ − φ₂ of both tangents

    R̈₀ = R'' ξ̇₁² + R' ξ̈₁ − Q (p'' ξ̇₂² + p' ξ̈₂ + 2 i ω p' ξ̇₂ + (i ω̇ − ω²) p),    ω = φ₁' ξ̇₁ − φ₂' ξ̇₂

(derived here; plane vectors are complex numbers). It has to be the acceleration of gravity and of the contact's forces.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cases import Case, Curve, Gravity, Load, Unilateral
from cases.contact import belt_speed
from cases.trajectory import CONTACT

from ..minimal.integrators.segment import Segment
from ..minimal.integrators.taylor import start_and_step
from .laws import SENSE, STICKING
from .samples import ContactLaw, law_at

# Phases that are looked at: all of so few, of more a part.
FEW, EVERY = 6, 8


def obeys_at_instants(case: Case, segments: Sequence[Segment], part: float) -> bool | None:
    """Whether a motion in contact, of smooth curves, obeys the laws in its phases, to a `part` of their scales; None if
    it was not integrated by the Taylor method, or flies."""
    law, gravity = law_at(case, CONTACT), case.effect(Gravity)
    pull = complex(*gravity.vector) if gravity is not None else 0j
    every = 1 + (len(segments) > FEW) * len(segments) // (FEW + len(segments) // EVERY)
    for segment in segments[::every]:
        step = start_and_step(segment) if segment.phase.places[:2] == (0, 1) else None
        if step is None:
            return None
        if not _obeys(case, law, pull, segment, step[1:], part):
            return False
    return all(_continues(one, other, part) for one, other in zip(segments, segments[1:], strict=False))


def _obeys(
    case: Case, law: ContactLaw, pull: complex, segment: Segment, step: tuple[float, np.ndarray], part: float
) -> bool:
    """The laws where a step of a phase begins."""
    phase, (t, coefficients) = segment.phase, step
    if coefficients.shape[1] < 3:  # a constant state
        return True
    y = coefficients[:, 0].tolist()
    (xi1, u1, half1), (xi2, u2, half2) = coefficients[:2, :3].tolist()
    outputs = phase.system.record(*phase.system.outputs_of_numbers(t, y, phase.parameters))
    normal, friction, slip, omega = outputs.normal, outputs.friction, outputs.slip, outputs.omega
    point, rate, bend, turn1, turning1 = _terms(case.track, xi1)
    own, own_rate, own_bend, turn2, turning2 = _terms(case.plate.outline, xi2)
    spin = turn1 * u1 - turn2 * u2
    spin_rate = turning1 * u1**2 + 2.0 * turn1 * half1 - turning2 * u2**2 - 2.0 * turn2 * half2
    tangent, along = rate / abs(rate), own_rate / abs(own_rate)
    Q = tangent * along.conjugate()
    first = bend * u1**2 + 2.0 * rate * half1
    second = own_bend * u2**2 + 2.0 * own_rate * half2 + 2j * spin * own_rate * u2 + (1j * spin_rate - spin**2) * own
    # The terms are larger than their sum where curvatures nearly agree.
    pace = abs(turn1 * u1) + abs(turn2 * u2)
    load, moment = case.effect(Load), 0.0
    if load is not None:
        place, velocity = point - Q * own, rate * u1 - Q * (own_rate * u2 + 1j * spin * own)
        fx, fy, moment = load.at(t, place.real, place.imag, 0.0, velocity.real, velocity.imag, omega)
        pull, moment = pull + complex(fx, fy) / case.plate.mass, moment / case.plate.mass
    size = abs(first) + abs(second) + abs(own) * (pace**2 + abs(spin_rate)) + abs(pull)
    size += abs(normal) + abs(friction)
    speed = abs(rate * u1) + abs(own_rate * u2) + case.plate.gyration * pace
    force = (friction + 1j * normal) * tangent
    if not abs(first - Q * second - pull - force) <= part * size:
        return False
    if not abs(abs(rate) * u1 - abs(own_rate) * u2 - belt_speed(case, t) - slip) <= part * (speed + abs(slip)):
        return False
    if not abs(spin - omega) <= part * (pace + abs(omega) + speed / case.plate.reach):
        return False
    if case.plate.turns and phase.regime.turn != 0:
        couple = moment - (force.conjugate() * Q * own).imag - (phase.regime.turn or 0) * law.arm * abs(normal)
        scale = case.plate.gyration**2 * (abs(spin_rate) + pace**2) + abs(own) * size + abs(moment)
        if not abs(couple - case.plate.gyration**2 * spin_rate) <= part * scale:
            return False
    return _is_coulomb(case, law, segment, normal, friction, slip, part * size, part * speed)


def _is_coulomb(
    case: Case,
    law: ContactLaw,
    segment: Segment,
    normal: float,
    friction: float,
    slip: float,
    force: float,
    speed: float,
) -> bool:
    """Signorini's and Coulomb's laws, with forces per mass and their errors."""
    mode = segment.phase.regime.mode
    sense = SENSE.get(mode, 0.0)
    if case.effect(Unilateral) is not None and normal < -force:
        return False
    if mode in STICKING:
        return abs(slip) <= speed and (law.is_rough or abs(friction) <= law.stick * abs(normal) + force)
    return sense * slip >= -speed and abs(friction + sense * law.coefficient(slip) * abs(normal)) <= force


def _terms(curve: Curve, s: float) -> tuple[complex, complex, complex, float, float]:
    """Point, first and second derivative (complex), and the first two derivatives of the tangent's angle."""
    x, y, dx, dy, d2x, d2y, d3x, d3y = curve.jet(s)
    square, cross = dx * dx + dy * dy, dx * d2y - dy * d2x
    turn = cross / square
    return complex(x, y), complex(dx, dy), complex(d2x, d2y), turn, (
        (dx * d3y - dy * d3x) / square - 2.0 * turn * (dx * d2x + dy * d2y) / square
    )  # fmt: skip


def _continues(one: Segment, other: Segment, part: float) -> bool:
    """Whether a phase begins at the place, and with the speed, at which the one before ends."""
    start = start_and_step(other)
    if not one.event.time == other.start or start is None:
        return False
    before, after = one.event.state, start[0]
    # The rows that both have are ξ₁, ξ₂ and, if both have a speed of the contact along the track, that.
    rows = 3 if 2 in one.phase.places and 2 in other.phase.places else 2
    return all(abs(a - b) <= part * (1.0 + abs(a)) for a, b in zip(before[:rows], after[:rows], strict=False))
