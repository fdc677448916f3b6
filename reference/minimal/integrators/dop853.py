"""Integration of one phase by SciPy's DOP853 (Hairer, Nørsett & Wanner, Solving ODE I, section II.5), with exact
events.

After each step the guards are evaluated inside the step, not only at its ends: two zeros in one step (a slip that
reverses and comes back) would leave no change of sign at the ends.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import sqrt

import numpy as np
from scipy.integrate import DOP853, DenseOutput

from cases.scene.supports import has_belt

from ...effect_laws import laws
from ...endings import BREAKDOWN
from ...scales import EPS, frequency
from ..defect_check import good_part
from ..modes import Phase
from .first_step import SHORTER, runge_kutta
from .segment import MOST_LOOKED_AT, MOST_TRIES, OUT_OF_STEPS, Event, Segment, blocks
from .step_zeros import FINE, NODES, first_zero, growing_gaps, guard_at, guards_at_nodes, never_opens, weights

# Limit on the defect of a step's dense output, which is of order seven while the step is of order eight, in tolerances
# to the power 7/8: steps that resolved their features stayed below 40 (bumps, steps and notches at 1e-4 … 1e-13).
DEFECT = 300.0

# If a guard's formula is undefined inside a step, the phase is cut and integrated again up to there; after this many
# nested cuts the phase ends at the step's start.
MOST_CUTS = 4

# Roundings of the stages in the dense output of a step of constant acceleration: the largest observed is 3.7.
ROUNDINGS = 16
_STAGE_WEIGHTS = np.abs(DOP853.D)

# A step in which a gap closes that has not opened is repeated with this part of its length.
SHORTENED = 0.1

# Before a first step the rates are evaluated this far ahead, in parts of the motion's time scale.
PROBE = 1e-2

# A motion that changes this much more slowly than gravity would make it is at rest when its phase begins.
STILL = 1e-6
# Variables of a phase with one contact, or of flight, at most.
MOST_OF_ONE = 6

# The phase stops if MOST_TINY_STEPS steps together cover at most the fraction TINY of it so far: near a singularity
# the tolerance needs digits that are lost to rounding, long before a step is as short as a rounding of the time.
MOST_TINY_STEPS, TINY = 500, 1e-9
# A zero inside an accepted step is a few steps away. Where many lead there, the equations are singular before it, which
# the accepted step has passed over: two contacts of a side that slides off a corner come together.
MOST_TO_ZERO = 200


def _weight_slopes(x):
    """The derivatives of `weights`."""
    slopes, values = [np.ones_like(x)], weights(x)
    for k in range(1, 7):
        slopes.append(slopes[-1] * (1.0 - x if k % 2 else x) + values[k - 1] * (-1.0 if k % 2 else 1.0))
    return slopes


# Cached, as most steps are evaluated at the same places.
@lru_cache(maxsize=128)
def _at(parts: bytes) -> np.ndarray:
    return np.array(weights(np.frombuffer(parts))).T


@lru_cache(maxsize=8)
def _slopes_at(parts: bytes) -> np.ndarray:
    return np.array(_weight_slopes(np.frombuffer(parts))).T


class _StepOutput:
    """A step by its dense output."""

    # The dense output's last four vectors are sums of the stages, with large weights of either sign.
    amplification = float(np.max(np.abs(_weight_slopes(FINE)[3:]).T @ np.sum(_STAGE_WEIGHTS, axis=1)))

    def __init__(self, piece: DenseOutput):
        self._piece, self.start, self.length = piece, float(piece.t_old), float(piece.h)

    def states(self, parts: np.ndarray) -> np.ndarray:
        """States (variables, n) at these parts of the step, 0 to 1."""
        return (self._piece.y_old + _at(parts.tobytes()) @ self._piece.F).T

    def slopes(self, parts: np.ndarray) -> np.ndarray:
        """Their derivatives by time."""
        return (_slopes_at(parts.tobytes()) @ self._piece.F).T / self.length


def prepare(phase: Phase, rtol: float = 1e-10) -> None:
    """Compile the phase's equations, which are the same for every tolerance."""
    phase.system.rates_of_numbers, phase.system.guards_of_arrays, phase.system.guards_of_numbers  # noqa: B018


def integrate(phase: Phase, t: float, y, end: float, rtol: float) -> Segment:
    """Integrate from (t, y) until a guard reaches zero, `end`, or a singularity where no step is small enough.

    The absolute tolerance is rtol times the state's natural sizes in the phase; rtol below 1e-13 counts as 1e-13, where
    DOP853's error reaches rounding.
    """
    return _integrate(phase, t, y, end, rtol, MOST_CUTS)


def _integrate(phase: Phase, t: float, y, end: float, rtol: float, cuts: int) -> Segment:
    """Same as `integrate`; `cuts`: how often the phase may still be cut where a guard is undefined."""
    rates, parameters = phase.system.rates_of_numbers, phase.parameters

    def rhs(time, state):
        return rates(time, state.tolist(), parameters)

    rtol, often = max(rtol, 1e-13), frequency(phase, t, y)
    atol = rtol * _scales(phase, often, len(y))
    if end <= t or not np.isfinite(atol).all():
        return _end_event(phase, [t], [], Event(None if end <= t else BREAKDOWN, t, tuple(y)), 1)
    # A flight over its estimated duration takes one step, often: a constant force needs no more. Where a contact is
    # followed a step is as long as the gap is resolved.
    first = end - t if phase.flies and not phase.system.guards else _first_step(often, rhs, t, y, end, rtol, atol)
    solver = DOP853(rhs, t, np.array(y, dtype=float), end, rtol=rtol, atol=atol, first_step=first)
    times: list[float] = [t]
    pieces: list[DenseOutput] = []
    tries = shorter = 0
    while True:
        tries += _step(solver, phase, rtol)
        if solver.status == "failed":
            event = Event(BREAKDOWN, float(solver.t), tuple(solver.y.tolist()))
            return _end_event(phase, times, pieces, event, solver.nfev)
        piece = _dense_output(solver)
        zero = None
        if phase.system.guards:
            at_nodes = guards_at_nodes(phase, piece)
            if not np.isfinite(at_nodes).all():
                return _without_value(phase, times, pieces, piece, at_nodes, rtol, solver.nfev, cuts)
            zero = first_zero(phase, piece, at_nodes, not pieces)
            if zero and never_opens(phase, piece, zero[0], zero[1], not pieces):
                growing = growing_gaps(phase, piece) if shorter else frozenset()
                if zero[0] not in growing and shorter < SHORTER:
                    shorter += 1
                    solver = _restart(solver, piece, rhs, end, rtol, atol)
                    continue
                zero = first_zero(phase, piece, at_nodes, not pieces, growing)
        shorter = 0
        if zero:
            guard, when = zero
            piece, event = _land(phase, rhs, piece, guard, when, rtol, atol)
            output = _PiecewiseOutput.of(times, pieces, piece)
            return Segment.of(phase, np.array([*times, event.time]), output, event, solver.nfev)
        times.append(solver.t)
        pieces.append(piece)
        if len(times) > MOST_TINY_STEPS and solver.t - times[-MOST_TINY_STEPS] <= TINY * (solver.t - t):
            event = Event(BREAKDOWN, float(solver.t), tuple(solver.y.tolist()))
            return _end_event(phase, times, pieces, event, solver.nfev)
        if (len(pieces) >= MOST_LOOKED_AT or tries >= MOST_TRIES) and solver.status != "finished":
            event = Event(OUT_OF_STEPS, float(solver.t), tuple(solver.y.tolist()))
            return _end_event(phase, times, pieces, event, solver.nfev)
        if solver.status == "finished" or (phase.is_past is not None and phase.is_past(solver.y)):
            return _end_event(phase, times, pieces, Event(None, float(solver.t), tuple(solver.y.tolist())), solver.nfev)


def _first_step(often: float, rhs, t: float, y, end: float, rtol: float, atol: np.ndarray) -> float:
    """The first step to try, s: SciPy's rule (Hairer, Nørsett & Wanner, II.4), but in the motion's time scale, of
    frequency `often` (1/s).

    The rule takes the eighth root of a rate, and so depends on the unit of time: in microseconds the step was so short
    that a slip that grows with the square of time was still rounding at its end.
    """
    if not often > 0.0:
        return end - t
    state = np.array(y, dtype=float)
    rates, scale = np.array(rhs(t, state)), atol + rtol * np.abs(state)
    probe = min(PROBE / often, end - t)
    change = (np.array(rhs(t + probe, state + probe * rates)) - rates) / (often * probe)
    # NumPy's mean without its preparation, which takes longer than the sum.
    fastest = max(sqrt(np.add.reduce((row / (often * scale)) ** 2) / len(row)) for row in (rates, change))
    # Their hundredth of the tolerance, for a motion of any scale, would be a step more in each phase.
    step = fastest**-0.125 if 0.0 < fastest < np.inf else PROBE
    return min(step / often, end - t)


def _end_event(phase: Phase, times: list[float], pieces, event: Event, evaluations: int) -> Segment:
    """The segment of complete steps; without any, the state at which it stopped."""
    states = _PiecewiseOutput(times[:-1], pieces) if pieces else _ConstantOutput(event.state)
    return Segment.of(phase, np.array(times), states, event, evaluations)


def _step(solver: DOP853, phase: Phase, rtol: float) -> int:
    """Take one step; repeat it with a shorter length if it passes a feature or does not satisfy the equations. Returns
    the number of tries."""
    start, before, slope, tries = solver.t, solver.y, solver.f, 1
    solver.step()
    while phase.checks_steps and solver.status != "failed":
        part = good_part(phase, _StepOutput(solver.dense_output()), rtol, DEFECT * rtol**0.875)
        length = part * (solver.t - start)
        if part == 1.0 or length <= 10 * np.spacing(abs(start)):  # the shortest step of SciPy's method
            break
        solver.t, solver.y, solver.f, solver.status = start, before, slope, "running"
        solver.max_step = length
        solver.step()
        solver.max_step = np.inf
        tries += 1
    return tries


def _restart(solver: DOP853, piece: DenseOutput, rhs, end: float, rtol: float, atol: np.ndarray) -> DOP853:
    """The solver at the start of its last step, which is to be shorter."""
    again = DOP853(rhs, piece.t_old, piece.y_old, end, rtol=rtol, atol=atol, first_step=SHORTENED * piece.h)
    again.nfev += solver.nfev
    return again


def _dense_output(solver: DOP853) -> DenseOutput:
    """The dense output of the last step, without terms that are only rounding of its stages.

    Its last four vectors F weight the stages by up to a thousand; if the motion is a polynomial of low degree, as in
    free flight, they should vanish but are a hundred roundings.
    """
    piece = solver.dense_output()
    last = piece.F[3:]
    last[np.abs(last) <= ROUNDINGS * EPS * abs(piece.h) * (_STAGE_WEIGHTS @ np.abs(solver.K_extended))] = 0.0
    return piece


def _scales(phase: Phase, often: float, count: int) -> np.ndarray:
    """Sizes of the `count` components: the plate's own size for the parameters, and the speed at which it is covered,
    as often as that (1/s)."""
    # One contact and flights have at most as many variables; the phases of several contacts have more.
    is_carried = count > MOST_OF_ONE and (has_belt(phase.case) or often > 0.0)
    if laws(phase.case).friction.by_speed or is_carried:
        # A belt may begin without speed and acceleration, and a slip under friction by a formula begins so at its cone;
        # of a plate that several contacts carry, a frequency may be all rounding: gravity gives the speed that it may
        # reach. (Other motions keep their last bits.)
        pull = sqrt(phase.case.weight / (phase.case.plate.mass * phase.size))
        often = pull if often < STILL * pull else often
    often = often or 1.0  # without force and motion any speed would do
    return np.array([*phase.lengths, *(size * often for size in phase.lengths)][:count])


def _without_value(phase: Phase, times, pieces, piece, at_nodes, rtol: float, evaluations: int, cuts: int) -> Segment:
    """The segment up to the point in the last step where a guard's formula becomes undefined, or an earlier zero."""
    after = int(np.argmin(np.isfinite(at_nodes).all(axis=0)))
    low, high = float(NODES[max(after - 1, 0)]), float(NODES[after])
    for _ in range(60):
        middle = 0.5 * (low + high)
        state = piece.y_old + weights(middle) @ piece.F
        values = phase.system.guards_of_numbers(piece.t_old + piece.h * middle, state.tolist(), phase.parameters)
        low, high = (middle, high) if np.isfinite(values).all() else (low, middle)
    until = piece.t_old + piece.h * low
    if until <= piece.t_old or not cuts:
        return _end_event(phase, times, pieces, Event(BREAKDOWN, piece.t_old, tuple(piece.y_old.tolist())), evaluations)
    rest = _integrate(phase, piece.t_old, piece.y_old, until, rtol, cuts - 1)
    event = rest.event if rest.event.guard else rest.event._replace(guard=BREAKDOWN)
    states = _PiecewiseOutput.of(times, pieces, rest.states)
    return Segment.of(phase, np.array([*times, *rest.times[1:]]), states, event, evaluations + rest.evaluations)


def _land(phase: Phase, rhs, piece, guard: str, when: float, rtol: float, atol):
    """Step again from the step's start to the guard's zero: a step's end is more accurate than its inside.

    The correction by Newton's method is then as short as the error of the dense output, and one step of the classical
    Runge–Kutta method covers it without error.
    """
    whole, start = piece.t - piece.t_old, piece.t_old
    if whole <= 0.0 or when <= start:
        return piece, Event(guard, start, tuple(piece.y_old.tolist()))
    again = DOP853(rhs, start, piece.y_old, when, rtol=rtol, atol=atol, first_step=when - start)
    pieces: list[DenseOutput] = []
    while again.status == "running" and len(pieces) < MOST_TO_ZERO:
        again.step()
        if again.status != "failed":
            pieces.append(_dense_output(again))
    if again.status != "finished":
        stop = Event(BREAKDOWN, float(again.t), tuple(again.y.tolist()))
        return _PiecewiseOutput([p.t_old for p in pieces], pieces) if pieces else piece, stop
    index = list(phase.system.guards).index(guard)
    part = (when - start) / whole
    inner = part - min(1e-4, 0.5 * part)  # not the start, where a gap is zero as well
    fall = guard_at(phase, piece, index, part) - guard_at(phase, piece, index, inner)
    slope = fall / ((part - inner) * whole)
    t, y = float(again.t), again.y
    for _ in range(2 if slope < 0.0 else 0):
        correction = -phase.system.guards_of_numbers(t, y.tolist(), phase.parameters)[index] / slope
        # A correction larger than the dense output's error means that the slope is unreliable (a touching zero).
        if abs(correction) > 1e-3 * whole or abs(correction) <= 2e-16 * abs(t) or t + correction <= start:
            break
        t, y = float(t + correction), runge_kutta(rhs, t, y, correction)
    return _PiecewiseOutput([p.t_old for p in pieces], pieces), Event(guard, t, tuple(y.tolist()))


@dataclass(frozen=True, eq=False, slots=True)
class _ConstantOutput:
    """Dense output of a phase without a step: a constant state."""

    state: tuple[float, ...]

    def __call__(self, times: np.ndarray) -> np.ndarray:
        return np.outer(self.state, np.ones(len(times)))


@dataclass(frozen=True, eq=False, slots=True)
class _PiecewiseOutput:
    """Dense output over several steps that begin at `starts`: times (n,) ↦ states (variables, n)."""

    starts: Sequence[float]
    pieces: Sequence[Callable[[np.ndarray], np.ndarray]]

    @classmethod
    def of(cls, starts: Sequence[float], pieces: Sequence[Callable], last: Callable) -> _PiecewiseOutput:
        """Pieces and a last one, which may have several steps itself."""
        if isinstance(last, _PiecewiseOutput):
            return cls([*starts[:-1], *last.starts], [*pieces, *last.pieces])
        return cls(starts, [*pieces, last])

    def __call__(self, times: np.ndarray) -> np.ndarray:
        pieces = self.pieces
        if len(times) == 1:  # searches evaluate single instants: a fifth of the time of the general code below
            piece = pieces[min(max(bisect_right(self.starts, float(times[0])) - 1, 0), len(pieces) - 1)]
            if not isinstance(piece, DenseOutput):
                return piece(times)
            return _at_instant(piece, float(times[0]))
        numbers, parts = zip(*blocks(np.array(self.starts), times), strict=True)
        some, order = [pieces[i] for i in numbers], np.concatenate(parts)
        if len(some) > 1 and all(isinstance(piece, DenseOutput) for piece in some):
            values = _at_instants(some, np.repeat(np.arange(len(some)), [len(part) for part in parts]), times[order])
        else:
            values = np.concatenate([piece(times[part]) for piece, part in zip(some, parts, strict=True)], axis=1)
        result = np.empty_like(values)
        result[:, order] = values
        return result


def _at_instants(pieces: Sequence[DenseOutput], which: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The states (variables, n) of the steps `which` at n times, by the same operations for all steps at once."""
    start, length = (np.array([getattr(piece, name) for piece in pieces])[which] for name in ("t_old", "h"))
    x = ((times - start) / length)[:, None]
    rows, y = np.array([piece.F for piece in pieces]), np.zeros((len(times), len(pieces[0].y_old)))
    for i in range(rows.shape[1]):
        y += rows[which, -1 - i]
        y *= 1.0 - x if i % 2 else x
    y += np.array([piece.y_old for piece in pieces])[which]
    return y.T


def _at_instant(piece: DenseOutput, time: float) -> np.ndarray:
    """The state (variables, 1) of a step at one time, by the operations of SciPy's dense output, so that it is the same
    to its last bit alone and among others."""
    x = (time - float(piece.t_old)) / float(piece.h)
    y = [0.0] * len(piece.y_old)
    for i, row in enumerate(reversed(piece.F.tolist())):
        factor = 1.0 - x if i % 2 else x
        y = [(value + own) * factor for value, own in zip(y, row, strict=True)]
    return np.array([[value + own] for value, own in zip(y, piece.y_old.tolist(), strict=True)])
