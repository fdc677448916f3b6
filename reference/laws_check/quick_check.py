"""The check of the laws that every motion gets before it is returned.

A motion of one contact is looked at by the coefficients of its steps, all laws at once and with the largest scale of the
motion; only one that fails, or has an impact, is checked law by law. Other motions are checked law by law.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cases import Case, Gravity, Load, Mode, Trajectory, Unilateral
from cases.contact_limits import touches_by_features
from cases.own_effects import own_effects

from ..minimal.curvature_proof import fits, fits_everywhere
from ..minimal.integrators.segment import Segment
from ..minimal.modes import FLIGHT
from ..minimal.phase_end import Ending
from . import broken_laws
from .laws import SENSE, STICKING
from .penetration import depths
from .phase_samples import of_phases
from .samples import WEIGHTS, MotionSamples
from .tolerances import part_of

# The status of a motion that breaks a law.
BROKEN_LAW = "broken_law"
# Steps of a motion with several contacts that are checked: those of longer ones are evenly distributed.
MOST = 400


def ending_by_laws(
    case: Case, segments: Sequence[Segment], ending: Ending, rtol: float, motion: Callable[[], Trajectory]
) -> Ending:
    """The ending of a motion that obeys the laws, or the status BROKEN_LAW with the law in a sentence. `motion` gives
    its columns; the case's track is at rest."""
    if not segments:
        return ending
    part = part_of(rtol)
    if _has_one_contact(case, segments) and (samples := of_phases(case, segments)) and _is_lawful(samples, part):
        return ending
    start, length = _steps(segments)
    laws = broken_laws.broken_by(case, motion(), start, length, part)
    if not laws:
        return ending
    status, reason = ending
    return BROKEN_LAW, f"The motion breaks a law, so a solver is wrong: {laws[0]}. It ended as {status}: {reason}"


def _has_one_contact(case: Case, segments: Sequence[Segment]) -> bool:
    """Whether all phases have at most one contact, of smooth curves, and forces that are written on arrays."""
    if case.others or case.effect(Load) is not None or own_effects(case.effects) or touches_by_features(case):
        return False
    return all(segment.phase.parts == (0, 0) and len(segment.phase.regime) == 3 for segment in segments)


def _steps(segments: Sequence[Segment]) -> tuple[np.ndarray, np.ndarray]:
    """Starts and lengths of the steps of a motion, about MOST of them."""
    knots = [np.unique(segment.times) for segment in segments]
    start, length = np.concatenate([k[:-1] for k in knots]), np.concatenate([np.diff(k) for k in knots])
    some = np.flatnonzero(length > 0.0)
    if len(some) > MOST:
        some = np.unique(some[np.linspace(0, len(some) - 1, MOST).astype(int)])
    return start[some], length[some]


def _is_lawful(samples: MotionSamples, part: float) -> bool:
    """Whether a plate with at most one contact obeys all laws and its velocities never jump."""
    case, (one,), length = samples.case, samples.plates, samples.length
    plate, gravity = case.plate, case.effect(Gravity)
    pull = complex(*gravity.vector) if gravity is not None else 0j
    rates = np.empty((3, *samples.times.shape), dtype=complex)
    rates[0], rates[1], rates[2] = pull, one.velocity, 1j * one.spin
    speed, force = float(np.abs(one.velocity).max() + plate.reach * np.abs(one.spin).max()), plate.mass * abs(pull)
    for contact in samples.contacts:
        here = slice(None) if len(contact.steps) == len(length) else contact.steps
        acting = (contact.friction + 1j * contact.normal) * contact.tangent
        force = max(force, float(np.abs(acting).max()))
        rates[0, here] += acting / plate.mass
        if plate.turns:
            arm = one.place[here] - contact.base
            couple = (acting.conj() * arm).imag
            if contact.law.arm:
                couple -= np.sign(one.spin[here, 2:3]) * contact.law.arm * np.abs(contact.normal)
                couple[contact.modes == Mode.REST] = 0.0
            rates[2, here] += couple / plate.inertia
        if not _contact_is_lawful(contact, case.effect(Unilateral) is not None, part * force, part * speed):
            return False
    gains = (rates @ WEIGHTS) * length
    reach, longest = plate.reach, float(length.max())
    swing = speed + longest * force / plate.mass
    off = np.abs(one.velocity[:, -1] - one.velocity[:, 0] - gains[0])
    far = np.abs(one.place[:, -1] - one.place[:, 0] - gains[1])
    turned = np.abs(one.turn[:, -1] - one.turn[:, 0] * np.exp(1j * gains[2].imag))
    spun = np.abs(one.spin[:, -1] - one.spin[:, 0] - gains[2].real)
    size = float(np.abs(one.place).max()) + reach
    turning = speed / reach + (longest * force * reach / plate.inertia if plate.turns else 0.0)
    largest = np.array([off.max() / swing if swing else off.max(), far.max() / (size + speed * longest), turned.max(), spun.max() / turning if turning else spun.max()])
    if not (largest <= part).all() or not _is_continuous(samples, part * size, part, part * speed, part * speed / reach):
        return False
    return _is_apart(samples, part * size)


def _contact_is_lawful(contact, presses: bool, force: float, speed: float) -> bool:
    """Signorini's and Coulomb's laws at one contact, to errors of forces (N) and speeds (m/s)."""
    law, normal, slip = contact.law, contact.normal, contact.slip
    modes = contact.modes.tolist()
    sense = np.array([SENSE.get(mode, 0.0) for mode in modes])[:, None]
    sticks = np.array([mode in STICKING for mode in modes])[:, None]
    pressure = normal if presses else np.abs(normal)
    if not (normal.min() >= -force or not presses) or not (np.abs(slip) * sticks - sense * slip).max() <= speed:
        return False
    if law.is_rough:
        return True
    bound = law.stick * pressure * sticks
    if law.friction is None:
        return bool(np.abs(contact.friction).max() <= force)
    return bool((np.abs(contact.friction + sense * (law.coefficient(slip) * pressure)) - bound).max() <= force)


def _is_continuous(samples: MotionSamples, length: float, angle: float, speed: float, spin: float) -> bool:
    """Whether pose and velocities continue from step to step, to errors of them."""
    (one,), following = samples.plates, samples.is_next[1:]
    return all(
        (np.abs(row[1:, 0] - row[:-1, -1]) * following).max(initial=0.0) <= limit
        for row, limit in zip(one, (length, angle, speed, spin), strict=True)
    )


def _is_apart(samples: MotionSamples, length: float) -> bool:
    """Whether the plate overlaps its track nowhere by more than an error of places."""
    case, track, outline = samples.case, samples.case.track, samples.case.plate.outline
    if track.features is None:
        is_proven = fits(track, outline, *track.span)
    else:
        is_proven = (track.domain is not None or bool(track.period)) and fits_everywhere(case, ())
    if is_proven and samples.contacts and len(samples.contacts[0].steps) == len(samples.start):
        return True
    return not any((depth.depths > length).any() for depth in depths(samples, is_proven))
