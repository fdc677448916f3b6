"""The check of the laws that every motion gets before it is returned.

A motion of one contact is looked at by the coefficients of its steps, all laws at once, with the largest scale of the
motion; only one that fails is checked law by law. Other motions are checked law by law, at a few steps of each phase.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cases import Case, Curve, Gravity, Impact, Load, Trajectory, Transition, Unilateral
from cases.contact_limits import touches_by_features
from cases.effects import MOTION
from cases.own_effects import own_effects
from cases.trajectory import CONTACT

from ..minimal.curvature_proof import fits, fits_everywhere
from ..minimal.integrators.segment import Segment
from ..minimal.modes import Regime
from ..minimal.phase_end import Ending
from . import broken_laws
from .laws import SENSE, STICKING, landing_defects, load_on_arrays
from .penetration import in_curve
from .phase_instants import obeys_at_instants
from .phase_samples import FRICTION, NORMAL, PLACE, SPIN, TURN, VELOCITY, PhaseSamples, of_phases
from .samples import WEIGHTS, ContactLaw, PlateSamples, law_at
from .tolerances import part_of

# The status of a motion that breaks a law.
BROKEN_LAW = "broken_law"
# The plate's angle in a load: the samples of phases have its direction only.
ANGLE = MOTION[3]
# Steps of a motion that are checked law by law: the first, middle and last of each phase; of more, the longest and
# others evenly distributed.
MOST = 90

Solution = tuple[Sequence[Segment], Sequence[Transition], Ending]


def ending_by_laws(case: Case, solution: Solution, rtol: float, motion: Callable[..., Trajectory]) -> Ending:
    """The ending of a solution (segments, transitions, ending) that obeys the laws, or the status BROKEN_LAW with the
    law in a sentence. `motion` makes columns of the case, whose track is at rest, and the solution."""
    segments, transitions, ending = solution
    if not segments:
        return ending
    part = part_of(rtol)
    if _has_one_contact(case, segments):
        if _is_proven_apart(case) and obeys_at_instants(case, segments, part):
            return ending
        samples = of_phases(case, segments)
        if samples is not None and _is_lawful(case, samples, transitions, part):
            return ending
    start, length = _steps(segments)
    laws = broken_laws.broken_by(case, motion(case, *solution), start, length, part)
    if not laws:
        return ending
    status, reason = ending
    return BROKEN_LAW, f"The motion breaks a law, so a solver is wrong: {laws[0]}. It ended as {status}: {reason}"


def _has_one_contact(case: Case, segments: Sequence[Segment]) -> bool:
    """Whether all phases have at most one contact, of smooth curves, and forces that are written on arrays."""
    if type(case.track) is not Curve or type(case.plate.outline) is not Curve:
        return False
    if case.others or own_effects(case.effects) or touches_by_features(case):
        return False
    load = case.effect(Load)
    if load is not None and any(formula.has(ANGLE) for formula in load.expression):
        return False
    return all(segment.phase.parts == (0, 0) and isinstance(segment.phase.regime, Regime) for segment in segments)


def _steps(segments: Sequence[Segment]) -> tuple[np.ndarray, np.ndarray]:
    """Starts and lengths of the steps of a motion, about MOST of them."""
    knots = [np.unique(segment.times) for segment in segments]
    few = [np.unique([0, len(k) // 2 - 1, len(k) - 2]) for k in knots if len(k) > 1]
    pairs = [(k[i], k[i + 1]) for k, i in zip((k for k in knots if len(k) > 1), few, strict=True)]
    start, end = (np.concatenate(column) for column in zip(*pairs, strict=True))
    length = end - start
    some = np.arange(len(start))
    if len(some) > MOST:
        even, longest = some[np.linspace(0, len(some) - 1, MOST // 2).astype(int)], some[np.argsort(-length[some])]
        some = np.union1d(even, longest[: MOST // 2])
    return start[some], length[some]


def _is_lawful(case: Case, samples: PhaseSamples, transitions: Sequence[Transition], part: float) -> bool:
    """Whether a plate with at most one contact obeys all laws."""
    plate, gravity, length = case.plate, case.effect(Gravity), samples.length
    pull = complex(*gravity.vector) if gravity is not None else 0j
    motion, law = samples.motion, law_at(case, CONTACT)
    contact, spin = samples.contact, motion[SPIN].real
    force = (contact[FRICTION] + 1j * contact[NORMAL]) * samples.tangent
    largest, moment = max(float(np.abs(force).max()), plate.mass * abs(pull)), 0.0
    load, place, velocity = case.effect(Load), motion[PLACE], motion[VELOCITY]
    if load is not None:
        fx, fy, moment = load_on_arrays(load)(
            samples.times, place.real, place.imag, 0.0, velocity.real, velocity.imag, spin
        )
        pull = pull + (fx + 1j * np.asarray(fy)) / plate.mass
        largest = max(largest, plate.mass * float(np.abs(pull).max()))
    speed = float(np.abs(motion[VELOCITY]).max() + plate.reach * np.abs(spin).max())
    size = float(np.abs(motion[PLACE]).max()) + plate.reach
    if samples.is_closed.any() and not _contact_is_lawful(case, law, samples, part * largest, part * speed):
        return False
    rates = np.empty_like(motion)
    rates[PLACE], rates[TURN], rates[VELOCITY], rates[SPIN] = (
        motion[VELOCITY],
        motion[SPIN],
        force / plate.mass + pull,
        0.0,
    )
    if plate.turns:
        couple = (force * (place - samples.base).conj()).imag - moment
        if law.arm:
            held = np.array([segment.phase.regime.turn == 0 for segment in samples.segments])[:, None]
            couple = np.where(held, 0.0, -couple - np.sign(spin[:, 2:3]) * law.arm * np.abs(contact[NORMAL]))
        else:
            couple = -couple
        rates[SPIN] = couple / plate.inertia
    gains = (rates @ WEIGHTS) * length
    changes = motion[:, :, -1] - motion[:, :, 0]
    changes[TURN] = np.angle(motion[TURN, :, -1] * motion[TURN, :, 0].conj() * np.exp(-1j * gains[TURN].real))
    gains[TURN] = 0.0
    longest = float(length.max())
    swing, turning = speed + longest * largest / plate.mass, speed / plate.reach
    if plate.turns:
        turning += longest * largest * plate.reach / plate.inertia
    limits = part * np.array([size + speed * longest, 1.0 + longest * turning, swing, turning])
    if not (np.abs(changes - gains) <= limits[:, None]).all():
        return False
    limits = part * np.array([size, 1.0, speed, speed / plate.reach])
    jumps = np.abs(motion[:, 1:, 0] - motion[:, :-1, -1]) * samples.is_next > limits[:, None]
    k = np.flatnonzero(jumps.any(axis=0))
    if len(k):
        if jumps[:VELOCITY].any() or samples.is_closed[k].any() or case.effect(Impact) is None:
            return False
        states = samples.start[k + 1], place[k, -1], motion[VELOCITY:, k, -1], motion[VELOCITY:, k + 1, 0]
        for defects in landing_defects(case, law, transitions, *states, speed):
            if not (defects.sizes <= part * defects.scale).all():
                return False
    return _is_apart(case, samples, part * size)


def _contact_is_lawful(case: Case, law: ContactLaw, samples: PhaseSamples, force: float, speed: float) -> bool:
    """Signorini's and Coulomb's laws at one contact, to errors of forces (N) and speeds (m/s)."""
    slip, normal, friction = samples.contact
    modes = [segment.phase.regime.mode for segment in samples.segments]
    sense = np.array([SENSE.get(mode, 0.0) for mode in modes])[:, None]
    sticks = np.array([mode in STICKING for mode in modes])[:, None]
    if case.effect(Unilateral) is None:
        normal = np.abs(normal)
    if not normal.min() >= -force or not (np.abs(slip) * sticks - sense * slip).max() <= speed:
        return False
    if law.is_rough:
        return True
    excess = np.abs(friction + sense * law.coefficient(slip) * normal) - law.stick * sticks * normal
    return bool(excess.max() <= force)


def _is_proven_apart(case: Case) -> bool:
    """Whether curvatures exclude that the plate touches its track elsewhere than in its contact."""
    track = case.track
    if track.features is None:  # a straight line is the same wherever the plate goes
        return fits(track, case.plate.outline, *track.span)
    return (track.domain is not None or bool(track.period)) and fits_everywhere(case, ())


def _is_apart(case: Case, samples: PhaseSamples, length: float) -> bool:
    """Whether the plate overlaps its track nowhere by more than an error of places."""
    track, is_proven = case.track, _is_proven_apart(case)
    if is_proven and samples.is_closed.all():
        return True
    steps = np.flatnonzero(~samples.is_closed) if is_proven else slice(None)
    place, turn, velocity, spin = samples.motion[:, steps]
    one = PlateSamples(place, turn, velocity, spin.real, np.angle(turn))
    near = np.array([case.start.xi1, *(v for v in samples.near if np.isfinite(v))])
    return all(
        not (depth.depths > length).any()
        for depth in in_curve(CONTACT, track, case.plate, one, samples.times[steps], near)
    )
