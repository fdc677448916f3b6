"""Which motions are consistent at an instant: for each choice of modes of the touching contacts a linear program for
the accelerations and contact forces that obey the laws just after it, with the margin by which they do."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from cases import Case, Gravity, Mode, Unilateral
from cases.motion.trajectory import CONTACT
from cases.own_effects import own_effects
from cases.scene.free_plates import loads_of, plates_of

from .chebyshev import AMPLIFICATION, RATES
from .laws import MotionScales, load_at, own_force
from .samples import MotionSamples, PlateSamples, law_at
from .tolerances import EPS, STILL, TOUCHES
from .touches import TouchNow, bend_at, couple_row, is_at_joint, largest_rate, masses, plates_at, touch, touches_at

# Laws hold strictly with this margin, in parts of the largest acceleration.
STRICT = 1e-7
# Two contacts of a pair that are nearer to each other, in parts of a plate's size, change their names next.
ALMOST_ONE = 1e-4
# Of more choices of modes than this nothing is said.
MOST_CHOICES = 200


class Consistent(NamedTuple):
    """A consistent motion: accelerations (3 plates,) in parts of the largest, whether all laws hold strictly, and the
    modes of the contacts: "open", "stick", "slide", or the sign of the slip."""

    rates: np.ndarray
    is_strict: bool
    modes: tuple


class NextMotions(NamedTuple):
    """The consistent motions just after an instant; the one of the samples, in the same unit, and how far it may be
    off."""

    every: list[Consistent]
    own: np.ndarray
    noise: float


class _Candidate(NamedTuple):
    """A touching contact, with what its relative accelerations are besides those of the plates' own: the rate of slip
    is `along`·a − `slip_rate`, that of the opening `across`·a − `opening_rate`; `own`: generalised forces of effects
    of packages; `spin`: the plate's rotation against its base, rad/s."""

    touch: TouchNow
    slip: float
    slip_rate: float
    opening_rate: float
    own: np.ndarray
    spin: float


def next_motions(samples: MotionSamples, scales: MotionScales, t: float, is_end: bool = False) -> NextMotions | None:
    """The motions that are consistent just after t, a start of a step, or the end of the motion (`is_end`: the samples
    have no accelerations there); None where this is not known: at joints of tracks, corners on corners, and for many
    contacts."""
    step = len(samples.start) - 1 if is_end else int(np.searchsorted(samples.start, t * (1.0 - 1e-15)))
    step, node = min(step, len(samples.start) - 1), -1 if is_end else 0
    case, plates = samples.case, plates_at(samples, step, node)
    places = _places(samples, scales, step, node, t)
    if places is None:
        return None
    own, inverse = masses(case)
    force = _weight_and_load(case, t, plates)
    claim = np.zeros(len(own)) if is_end else _rates(samples, step)
    largest = max(
        scales.acceleration, scales.speed**2 / scales.size * 1e-3, largest_rate(force * inverse, scales.size),
        largest_rate(claim, scales.size),
    )  # fmt: skip
    unit = np.tile([1.0, 1.0, scales.size], len(plates.place)) / largest
    small = (1e-13 + EPS * float(scales.condition[step])) * scales.speed
    small += 20 * EPS * scales.acceleration * scales.last
    choices = [_choices(place, small, case.effect(Unilateral) is not None) for place in places]
    if np.prod([len(c) for c in choices], dtype=float) > MOST_CHOICES:
        return None
    every = [_solve(case, places, modes, force, unit, largest, small) for modes in product(*choices)]
    noise = 1e-5 + 4 * EPS * AMPLIFICATION * float(scales.condition[step]) * scales.speed / (
        samples.length[step] * largest
    )
    return NextMotions([one for one in every if one is not None], claim * unit, noise)


def _weight_and_load(case: Case, t: float, plates: PlateSamples) -> np.ndarray:
    """Weight and load of all plates at one instant: forces (N) and moments (N m), (3 plates,)."""
    gravity, result = case.effect(Gravity), list[float]()
    pull = complex(*gravity.vector) if gravity is not None else 0j
    for plate, load, *one in zip(plates_of(case), loads_of(case), *plates, strict=True):
        force, moment = load_at(load, t, PlateSamples(*one))
        result += (plate.mass * pull + force).real, (plate.mass * pull + force).imag, moment
    return np.array(result)


def _rates(samples: MotionSamples, step: int) -> np.ndarray:
    """The accelerations at the start of a step, (3 plates,)."""
    rows = [(one.velocity[step].real, one.velocity[step].imag, one.spin[step]) for one in samples.plates]
    return np.array([[RATES[0] @ row for row in three] for three in rows]).ravel() / samples.length[step]


def _places(samples: MotionSamples, scales: MotionScales, step: int, node: int, t: float) -> list[_Candidate] | None:
    """The contacts that touch at a node, each place once; None where what follows is not known."""
    case, plates = samples.case, plates_at(samples, step, node)
    every = touches_at(samples, step, node)
    names = {one.law.name for one in every}
    # A contact that has just opened touches still.
    if node == 0 and step > 0:
        for one in touches_at(samples, step - 1, -1):
            again = touch(case, one.law, Mode.FLIGHT, plates, one.xi1, one.xi2, t)
            if one.law.name not in names and abs(float(again.across @ plates.rates)) <= STILL * scales.speed:
                every.append(again)
    start = case.start
    if t == 0.0 and start.in_contact and start.xi2 is not None and CONTACT not in names:
        first = touch(case, law_at(case, CONTACT), Mode.FLIGHT, plates, start.xi1, start.xi2, t)
        if abs(float(first.across @ plates.rates)) <= STILL * scales.speed:
            every.append(first)
    result, points = list[_Candidate](), list[tuple]()
    for one in every:
        curves = one.law.body, one.law.base, one.law.track
        apart = min((abs(one.point - point) for other, point in points if curves == other), default=np.inf)
        if apart < TOUCHES * scales.extent:
            continue  # one place with two names
        if apart < ALMOST_ONE * scales.size:
            return None
        points.append((curves, one.point))
        place = _candidate(one, plates, t, scales.speed)
        if place is None:
            return None
        result.append(place)
    return result


def _candidate(one: TouchNow, plates: PlateSamples, t: float, scale: float) -> _Candidate | None:
    """The second-order terms at a contact: its point moves along both curves, whose tangents turn."""
    law = one.law
    if is_at_joint(law.track, one.xi1):
        return None
    below = bend_at(law.track, one.xi1) * (-1.0 if law.base is not None else 1.0)
    spin = float(plates.spin[law.body])
    base_spin = float(plates.spin[law.base]) if law.base is not None else 0.0
    speed, opening = float(one.along @ plates.rates), float(one.across @ plates.rates)
    above = bend_at(law.outline, one.xi2)
    if is_at_joint(law.outline, one.xi2):
        sides = [bend_at(law.outline, one.xi2 + step) for step in (-1e-7, 1e-7)]
        if np.inf not in sides and sides[0] != sides[1]:
            return None
        # A corner goes on to the side that the tangent turns to.
        turning = base_spin + below * speed - spin
        ahead = sides[int(turning > 0.0)] if abs(turning) * law.outline.sizes[0] > STILL * scale else np.inf
        above = ahead if np.inf in sides else above
    if np.isinf(below) and np.isinf(above) or not (above > below or np.isinf(below)):
        return None
    # The rate of the contact point along its base, and of the tangent's angle.
    if np.isinf(above):
        along, turning = speed, base_spin + below * speed
    elif np.isinf(below):
        along, turning = 0.0, spin - above * speed
    else:
        along = (spin - base_spin - above * speed) / (below - above)
        turning = base_spin + below * along
    base_velocity = 0j
    if law.base is not None:
        base_velocity = plates.velocity[law.base] + 1j * base_spin * (one.point - plates.place[law.base])
    moving = base_velocity + along * one.tangent
    extra = 1j * spin * (moving - plates.velocity[law.body])
    if law.base is not None:
        extra -= 1j * base_spin * (moving - plates.velocity[law.base])
    extra *= one.tangent.conjugate()
    belt_rate = float(law.belt.at(t)[1]) if law.belt else 0.0
    forces = np.zeros(3 * len(plates.place))
    for effect in own_effects(law.effects):
        tangential, normal, couple = (float(np.asarray(v)) for v in own_force(effect)(t, one.slip, spin - base_spin))
        forces += tangential * one.along + normal * one.across + couple * couple_row(law, len(plates.place))
    rates = belt_rate - extra.real - turning * opening, turning * speed - extra.imag
    return _Candidate(one, one.slip, *rates, forces, spin - base_spin)


def _choices(place: _Candidate, small: float, is_unilateral: bool) -> list[tuple]:
    """The modes that a contact may have, each with the sense of its rotation (0: none, None: it does not matter)."""
    law, slip = place.touch.law, place.slip
    if law.friction is None and not law.is_rough:
        modes: list = ["slide"]
    elif law.is_rough:
        modes = ["stick"]
    else:
        modes = [float(np.sign(slip))] if abs(slip) > small else [1.0, -1.0, "stick"]
    turns: list = [None]
    if law.arm:
        reach = place.touch.law.outline.sizes[0]
        turns = [float(np.sign(place.spin))] if abs(place.spin) * reach > small else [1.0, -1.0, 0.0]
    # What an effect of a package does ends with the contact, which it holds.
    holds = place.touch.mode is not Mode.FLIGHT and bool(own_effects(law.effects))
    open_one = [("open", None)] if is_unilateral and not holds else []
    signs = [1.0] if is_unilateral else [1.0, -1.0]
    return open_one + [(mode, turn, sign) for mode in modes for turn in turns for sign in signs]


def _solve(case, places, modes, force, unit, largest, small) -> Consistent | None:
    """The accelerations with these modes, with the largest margin of all inequalities, or None if there are none."""
    own, inverse = masses(case)
    total, columns, equal, above = force.copy(), [], [], []
    for place, mode in zip(places, modes, strict=True):
        one, law = place.touch, place.touch.law
        opening = (one.across, place.opening_rate)
        if mode[0] == "open":
            above.append(opening)
            continue
        total = total + place.own
        equal.append(opening)
        kind, turn, sign = mode
        if kind == "stick":
            equal.append((one.along, place.slip_rate))
            if law.is_rough:
                own_columns = [sign * one.across]
                columns += [one.along, -one.along]
            else:
                own_columns = [sign * one.across + s * law.stick * one.along for s in (1.0, -1.0)]
        elif kind == "slide":
            own_columns = [sign * one.across]
        else:
            own_columns = [sign * one.across - kind * float(law.coefficient(place.slip)) * one.along]
            if abs(place.slip) <= small:
                above.append((kind * one.along, kind * place.slip_rate))
        if law.arm:
            row = couple_row(law, len(own) // 3)
            if turn == 0.0:
                equal.append((row, 0.0))
                own_columns = [c + s * law.arm * row for c in own_columns for s in (1.0, -1.0)]
            else:
                own_columns = [c - turn * law.arm * row for c in own_columns]
                if abs(place.spin) * law.outline.sizes[0] <= small:
                    above.append((turn * row, 0.0))
        columns += own_columns
    pull = np.array(columns).reshape(-1, len(own)).T
    by_load = np.array([i == 2 and plate.spins_by_load for plate in plates_of(case) for i in range(3)])
    result = _program(total, pull, equal, above, inverse, by_load, unit, largest, own)
    return result and result._replace(modes=modes)


def _program(total, pull, equal, above, inverse, by_load, unit, largest, own) -> Consistent | None:
    """Unknowns: accelerations and forces, in units of the scene, and the margin; `by_load`: rates of spin that are
    given."""
    from scipy.optimize import linprog  # takes a tenth of a second to import

    n, m = len(own), pull.shape[1]
    newton = largest * float(own.max())
    matrix, rest = np.zeros((n + len(equal), n + m + 1)), np.zeros(n + len(equal))
    matrix[:n, :n] = np.eye(n)
    matrix[:n, n : n + m] = -(pull * inverse[:, None]) * newton * unit[:, None]
    rest[:n] = total * np.where(by_load, 1.0, inverse) * unit
    for i, (row, value) in enumerate(equal):
        matrix[n + i, :n], rest[n + i] = row / unit / largest, value / largest
    sides, limits = np.zeros((len(above) + m, n + m + 1)), np.zeros(len(above) + m)
    for i, (row, value) in enumerate(above):
        sides[i, :n], sides[i, -1], limits[i] = -row / unit / largest, 1.0, -value / largest
    for i in range(m):
        sides[len(above) + i, n + i], sides[len(above) + i, -1] = -1.0, 1.0
    cost = np.zeros(n + m + 1)
    cost[-1] = -1.0
    bounds = [(None, None)] * (n + m) + [(-STRICT, 1e-3)]
    some = len(sides) > 0
    result = linprog(cost, sides if some else None, limits if some else None, matrix, rest, bounds)
    if result.status != 0:
        return None
    return Consistent(result.x[:n], bool(result.x[-1] > STRICT), ())
