"""The phase of contact that Coulomb's inequalities allow at an instant, and whether a plate leaves its track there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf
from typing import NamedTuple

import numpy as np

from .equations import ContactLaws, ContactPhase, ContactScene, rates

# A normal force of a rounding below zero is a release at N = 0, as in the start of `disc_in_circle`.
RELEASE = 1e-12

# A normal force of zero is evaluated this far ahead, in parts of the motion's time scale, to distinguish a release from
# a departure. A force that grows with the square of time is then 1e-8 of the scene's forces, far above rounding.
SOON = 1e-4

# A static force may exceed its bound by this part of the scene's forces: both are results of some tens of rounded
# operations. (On an incline with tan(slope) = mu the sign of their difference is rounding.)
AT_BOUND = 64 * float(np.finfo(float).eps)


class ContactForces(NamedTuple):
    """Normal force, friction and couple in a phase, as forces or as parts of an impulse."""

    normal: float
    friction: float
    couple: float


def admissible(
    laws: ContactLaws,
    v: float,
    w: float,
    forces_of: Callable[[ContactPhase], ContactForces],
    may_stick: bool = True,
    may_hold: bool = True,
    rounding: float = 0.0,
) -> Iterator[ContactPhase]:
    """Phases that Coulomb's inequalities allow at slip v and spin w, the most static ones first.

    A zero slip or spin stays zero while the force needed for that is within its bound; otherwise it begins against that
    force. `forces_of` gives the forces in a phase, which have an error of `rounding`; `may_stick`, `may_hold`: false if
    slip or rotation is known to begin, because the bound has just been reached from inside. The caller checks the sign
    of N.
    """
    slips, turns = _options(laws.slip, v, may_stick), _options(laws.arm, w, may_hold)

    def slip_is_right(slip, turn) -> bool:
        if v != 0.0 or slip is None:
            return True
        forces = forces_of(ContactPhase(0, turn))
        too_much = not may_stick or abs(forces.friction) > laws.stick * (abs(forces.normal) + rounding)
        return not too_much if slip == 0 else too_much and slip * forces.friction <= 0.0

    def turn_is_right(slip, turn) -> bool:
        if w != 0.0 or turn is None:
            return True
        forces = forces_of(ContactPhase(slip, 0))
        bound = laws.arm * (abs(forces.normal) + rounding)  # type: ignore[operator]
        too_much = not may_hold or abs(forces.couple) > bound
        return not too_much if turn == 0 else too_much and turn * forces.couple <= 0.0

    for slip in slips:
        for turn in turns:
            if slip_is_right(slip, turn) and turn_is_right(slip, turn):
                yield ContactPhase(slip, turn)


def _options(law: float | None, velocity: float, may_rest: bool) -> tuple[int | None, ...]:
    if law is None:
        return (None,)
    if law == inf:
        return (0,)
    if velocity != 0.0:
        return (1,) if velocity > 0 else (-1,)
    return (0, 1, -1) if may_rest else (1, -1)


def decide(
    scene: ContactScene, t: float, z, turns: int, may_stick: bool = True, may_hold: bool = True
) -> ContactPhase | None:
    """The phase at an instant; None if none is consistent with the sign of its normal force."""
    scale = scene.scale(t, z, turns)
    tolerance = RELEASE * scale

    def forces_of(phase: ContactPhase) -> ContactForces:
        f = scene.forces(t, z, with_side(phase), turns)
        # A unilateral contact cannot pull.
        return ContactForces(max(f.normal, 0.0) if scene.unilateral else f.normal, f.friction, f.couple)

    def with_side(phase: ContactPhase) -> ContactPhase:
        if scene.unilateral:
            return phase
        f = scene.forces(t, z, phase, turns)
        # If the force is zero to rounding, the side is the one that presses a moment later.
        toward = f.push if abs(f.normal) > tolerance else soon(scene, t, z, phase, turns)
        return phase if toward >= 0.0 else phase._replace(side=-1)

    allowed = admissible(scene.laws, z[3], z[2], forces_of, may_stick, may_hold, AT_BOUND * scale)
    for phase in map(with_side, allowed):
        f = scene.forces(t, z, phase, turns)
        if f.inverse_mass > 0.0 and (abs(f.normal) > tolerance or soon(scene, t, z, phase, turns) >= -tolerance):
            if phase.side * f.normal >= -tolerance:
                return phase
    return None


def soon(scene: ContactScene, t: float, z, phase: ContactPhase, turns: int) -> float:
    """The normal force on its side a moment after an instant at which it is zero (N), by a midpoint step."""
    pace = scene.pace(t, z, turns)
    if pace == 0.0:
        return phase.side * scene.forces(t, z, phase, turns).normal  # nothing changes
    moment = SOON / pace
    middle = np.array(z) + 0.5 * moment * rates(scene, t, z, phase, turns)
    after = np.array(z) + moment * rates(scene, t + 0.5 * moment, middle.tolist(), phase, turns)
    return phase.side * scene.forces(t + moment, after.tolist(), phase, turns).normal


def leaves(scene: ContactScene, t: float, z, turns: int) -> bool:
    """Whether the plate without contact forces would leave its track (and not move into it)."""
    free = ContactPhase(None, None)
    return scene.forces(t, z, free, turns).push <= RELEASE * scene.scale(t, z, turns) / scene.m


def comes_down(scene: ContactScene, t: float, z, turns: int) -> bool:
    """Whether a plate that leaves its track would come down at once, as effects of the user's own lift it and end with
    the contact. The push of a plate that leaves is not positive; what remains of it is the error of that instant."""
    push = min(scene.forces(t, z, ContactPhase(None, None), turns).push, 0.0)
    return push + scene.own_lift(t, z) > RELEASE * scene.scale(t, z, turns) / scene.m


def lets_go(scene: ContactScene, t: float, z, phase: ContactPhase, turns: int) -> bool:
    """Whether a plate leaves a perfectly rough contact whose normal force has just vanished.

    Friction T may act there, since nothing bounds it. With a, b the arm along tangent and normal, per mass (J = ρ² m):

        v̇ = … + (1 + b²/ρ²) T − (a b/ρ²) N,      γ̈ = … + (1 + a²/ρ²) N − (a b/ρ²) T,

    and while the contact lasted, both were zero. Without it N = T = 0 and γ̈ = (a b/ρ²) T: if that is positive the
    plate departs. If it is negative the plate would move into its track, and to stay on it would have to be pulled.
    Coulomb friction, whatever its μ, has an answer there: where N falls to |T|/μ a slip v with v T < 0 begins, whose
    Painlevé number 1 + a²/ρ² + μ |a b|/ρ² is positive, with N of the order of |T|/μ and T such that γ̈ = 0. Velocities
    do not jump, so there is no impulse, and the limit μ → ∞ is a slip with friction but without a normal force. A
    perfectly rough contact excludes every slip: rigid contact has no solution, a paradox, with or without Flight. (If
    a b T > 0 the same number, 1 + a²/ρ² − μ |a b|/ρ², is negative for large μ: slip is excluded, only departure is
    possible.)
    """
    q, friction = scene.place(z[0], z[1]), scene.forces(t, z, phase, turns).friction
    return q.arm_t * q.arm_n * scene.m / scene.J * friction >= -RELEASE * scene.scale(t, z, turns)
