"""The impulse of an impact at one contact, in numbers: by Routh's construction, or by a law for whole impulses.

Impulses along tangent and normal (N s) change the velocities (slip, closing) by a matrix (1/kg) times them.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import copysign, inf, isinf, nan
from typing import Any

from cases import Case, Impact

from .samples import ContactLaw

# Slip stops and compression ends a few times in an impact.
MOST_PHASES = 20
# Friction is at the edge of its cone up to roundings.
AT_CONE = 1.0 + 1e-12

Pair = tuple[float, float]
NONE = (nan, nan)


def landing_defect(
    case: Case, law: ContactLaw, t: float, arm: complex, tangent: complex, before: Any, after: Any
) -> float:
    """How far an impact of a plate with what is fixed differs from its law, m/s: from the velocity and spin before it,
    with the contact's `arm` from the centre of mass and the unit tangent there, complex.

    With rolling resistance, whose couple is open, the impulse presses and lies in the cone, and where there is no
    restitution the contact stays closed."""
    plate, along = case.plate, tangent.conjugate()
    spin = 1.0 / plate.inertia if plate.turns else 0.0
    lever, velocity = arm * along, (before[0] + 1j * before[1] * arm) * along
    slip = velocity.real - (law.belt.at(t)[0] if law.belt else 0.0)
    moving, stick = map(float, law.in_impact(slip))
    if law.arm:
        change, lift = (after[0] - before[0]) * along, ((after[0] + 1j * after[1] * arm) * along).imag
        outside = abs(change.real) - stick * change.imag if change.imag else 0.0
        return max(-change.imag, outside, 0.0 if law.impact.restitution else abs(lift))
    side = -spin * lever.real * lever.imag
    matrix = (1.0 / plate.mass + spin * lever.imag**2, side), (side, 1.0 / plate.mass + spin * lever.real**2)
    friction, normal = impulse_of_one(matrix, (slip, velocity.imag), moving, stick, law.impact)
    off = abs(after[0] - before[0] - complex(friction, normal) * tangent / plate.mass)
    off += plate.reach * abs(after[1] - before[1] - spin * (lever.real * normal - lever.imag * friction))
    return off if off < inf else inf  # without an impulse it is NaN


def impulse_of_one(matrix: Any, velocity: Any, mu: float, stick: float, impact: Impact) -> Pair:
    """The impulse of an impact that begins with these velocities; `mu` and `stick`: coefficients of friction with slip
    and without. NaN where it has none."""
    if impact.law == "moreau":
        return next(impulses_at_once(matrix, velocity, mu, stick, impact), NONE)
    return _routh(matrix, velocity, mu, stick, impact)


def impulses_at_once(matrix: Any, velocity: Any, mu: float, stick: float, impact: Impact) -> Iterator[Pair]:
    """The impulses of an impact whose law holds for whole impulses: with Poisson's restitution those of compression and
    those of restitution, each with Coulomb's law and the slip at its end."""
    e = impact.restitution
    if impact.law != "poisson" or e == 0.0:
        yield from _whole_impulses(matrix, velocity, mu, stick, -e * velocity[1])
        return
    (a, b), (_, c) = matrix
    for first in _whole_impulses(matrix, velocity, mu, stick, 0.0):
        slip, closing, normal = *_after(matrix, velocity, *first), e * first[1]
        tangential = [] if isinf(mu) else [-sense * mu * normal for sense in (1.0, -1.0)]
        tangential = [t for t in tangential if t * (slip + a * t + b * normal) <= 0.0]
        hold = -(slip + b * normal) / a
        tangential += [hold] if abs(hold) <= stick * normal * AT_CONE else []
        for t in tangential:
            if closing + b * t + c * normal >= 0.0:
                yield first[0] + t, first[1] + normal


def _after(matrix: Any, velocity: Any, friction: float, normal: float) -> Pair:
    """The velocities after an impulse."""
    (a, b), (_, c) = matrix
    return velocity[0] + a * friction + b * normal, velocity[1] + b * friction + c * normal


def _whole_impulses(matrix: Any, velocity: Any, mu: float, stick: float, goal: float) -> Iterator[Pair]:
    """Newton's restitution with Coulomb's law between the whole impulses and the velocities after the impact: the
    impulses without slip, if that is consistent, and with it. Unbounded friction may lift the contact by itself."""
    (a, b), (_, c) = matrix
    slip, closing = velocity
    stop = -slip / a
    if isinf(stick) and closing + b * stop >= goal:
        yield stop, 0.0
    normal = (a * (goal - closing) + b * slip) / (a * c - b * b)
    friction = -(slip + b * normal) / a
    if normal >= 0.0 and abs(friction) <= stick * normal * AT_CONE:
        yield friction, normal
    for sense in (1.0, -1.0) if not isinf(mu) else ():
        normal = (goal - closing) / (c - sense * mu * b)
        if normal >= 0.0 and sense * (slip + (b - sense * mu * a) * normal) > 0.0:
            yield -sense * mu * normal, normal


def _routh(matrix: Any, velocity: Any, mu: float, stick: float, impact: Impact) -> Pair:
    """Routh's construction: friction follows the slip along the normal impulse, until compression and restitution
    end."""
    (a, b), (_, c) = matrix
    slip, closing = map(float, velocity)
    friction = normal = 0.0
    compression, goal = None, -impact.restitution * closing
    for _ in range(MOST_PHASES):
        ratio = -copysign(mu, slip)
        if slip == 0.0:
            ratio = -b / a
            if abs(ratio) > stick:  # friction cannot hold it
                ratio = -copysign(mu, b)
        if isinf(ratio):  # a perfectly rough contact stops its slip first
            stop = -slip / a
            friction, slip, closing = friction + stop, 0.0, closing + b * stop
            continue
        slips, lifts = a * ratio + b, b * ratio + c
        if slip == 0.0 and abs(b) <= stick * a:  # it sticks: a rounding of its slip is none
            slips = 0.0
        if compression is not None and impact.law == "poisson":
            rest = impact.restitution * compression - (normal - compression)
        else:
            rest = ((0.0 if compression is None else goal) - closing) / lifts if lifts > 0.0 else inf
        stop = -slip / slips if slip * slips < 0.0 else inf
        part = max(min(rest, stop), 0.0)
        if isinf(part):
            break
        friction, normal = friction + part * ratio, normal + part
        slip, closing = slip + part * slips, closing + part * lifts
        if stop <= rest:
            slip = 0.0
        if rest <= stop:
            if compression is not None or impact.restitution == 0.0:
                return friction, normal
            compression = normal
    return NONE
