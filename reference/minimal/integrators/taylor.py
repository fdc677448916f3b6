"""Integration of one phase by heyoka's Taylor method with its event detection (Biscani & Izzo 2021, MNRAS 504, 2614).

Optional: without heyoka, `AVAILABLE` is False and DOP853 is used.
"""

from __future__ import annotations

from bisect import bisect_right
from functools import lru_cache, partial
from math import inf, ulp

import numpy as np

from ..defect_check import Expansion, good_part
from ..modes import Phase
from ..system import System
from .pool import IntegratorPool
from .segment import BREAKDOWN, MOST_LOOKED_AT, MOST_STEPS, MOST_TRIES, OUT_OF_STEPS, Event, Segment

try:
    import heyoka as hy
except ImportError:
    AVAILABLE = False
else:
    from .conversion import convert, nothing_on_disk, small, variables
    from .first_step import FirstStep, leave

    AVAILABLE = True
    # heyoka caches compiled code for equal source texts, up to 2 GB; here equal systems are already shared.
    if hasattr(hy.llvm_state, "set_memcache_limit"):  # versions before it had that cache
        hy.llvm_state.set_memcache_limit(64 * 2**20)
    hy.set_logger_level_error()  # a non-finite step ends the phase, with our own message
    # As integers: comparing heyoka's own outcomes, by name, costs as much as a step.
    SUCCESS, TIME_LIMIT, STEP_LIMIT = (
        int(outcome)
        for outcome in (hy.taylor_outcome.success, hy.taylor_outcome.time_limit, hy.taylor_outcome.step_limit)
    )

# heyoka's tolerance bounds the error of one step, in parts of the largest component of the state or of 1, whatever
# its unit. In parts of the plate's size the error of a motion was up to 54 times that tolerance (75 random scenes,
# the worst with a plate of 3 mm at 25 rad/s). So heyoka's is a hundredth of the motion's. That takes ln(100)/2, two
# or three, more terms of each series; steps, which follow from its radius of convergence, stay as long.
MARGIN = 100.0
# Step-size tolerances are whole powers of ten: one compiled integrator each.
FINEST = 1e-16
# Far below double precision's rounding, far above quadruple's.
QUADRUPLE_TOLERANCE = 1e-24
# A step of at most this many units in the last place of time makes no progress: towards a singularity steps shrink
# without limit.
SHORTEST = 16
# Limit on the defect of a step's polynomial, in tolerances of a step: its error is about a tenth of its defect, and
# those of a hundred steps that a motion amplifies tenfold are then the tolerance. (On a sliver, with 1 in place of 0.1,
# they were ten tolerances.) Forces have the error ROUNDING, as differences of terms up to 1000 times as large.
DEFECT, ROUNDING = 0.1, 1e-12
# The compiled loop returns after this many steps, so that it does not run forever towards a singularity.
CHUNK = 1000


@lru_cache(maxsize=128)
def integrators_of(system: System, tolerance: float, real: type = float, optimised: bool = False) -> IntegratorPool:
    """The compiled integrators of a system, with one terminal event for each guard; `optimised`: fully optimised,
    however long that takes, for thousands of runs."""
    return IntegratorPool(lambda: _compile(system, tolerance, real, optimised))


def _compile(system: System, tolerance: float, real: type, optimised: bool):
    # Constants are doubles: quadruple precision computes them as part of the equations.
    known = variables(system, constants=real is float)
    rates, guards = (convert(some, known) for some in (system.rates, system.guards.values()))
    equations = [(known[v], rate) for v, rate in zip(system.variables, rates, strict=True)]
    falling = hy.event_direction.negative
    events = [hy.t_event(guard, direction=falling, fp_type=real) for guard in guards]
    # A product in quadruple precision is a library call: unrolled steps take thirty times as long to compile, and run
    # no faster, to the same last bit.
    written_out = real is float
    with nothing_on_disk():
        return hy.taylor_adaptive(
            equations,
            [real(0.0)] * len(equations),
            t_events=events,
            tol=real(tolerance),
            fp_type=real,
            compact_mode=not written_out,
            opt_level=3 if written_out and (optimised or small(system)) else 0,
        )


def prepare(phase: Phase, rtol: float = 1e-10, optimised: bool = False) -> None:
    """Compile the phase's equations for that tolerance."""
    integrators_of(phase.system, tolerance_of(rtol), float, optimised)


def prepare_quadruple(phase: Phase, rtol: float = 1e-10) -> None:
    """Compile the phase's equations in quadruple precision."""
    integrators_of(phase.system, QUADRUPLE_TOLERANCE, hy.real128)


@lru_cache(maxsize=256)
def tolerance_of(rtol: float) -> float:
    """The tolerance of the integrator's steps for a motion's relative tolerance."""
    return float(max(FINEST, 10.0 ** np.floor(np.log10(rtol / MARGIN) + 1e-9)))


def integrate(phase: Phase, t: float, y, end: float, rtol: float, optimised: bool = False) -> Segment:
    """Integrate from (t, y) until a guard reaches zero, `end`, or a singularity (guard BREAKDOWN).

    The compiled loop integrates a phase to its event in one call; its steps are repeated, one by one, when they are
    requested. If a step could pass over a feature, or the loop ends without an event, the steps are taken one by one.
    """
    tolerance = tolerance_of(rtol)
    integrators = integrators_of(phase.system, tolerance, float, optimised)
    outcome = None if phase.checks_steps else integrators.call(_at_once, phase, t, y, end, tolerance)
    if outcome is None:
        return integrators.call(_one_by_one, phase, t, y, end, float, tolerance)
    event, steps = outcome
    # No closure, to spare the garbage collector.
    return Segment(
        phase, t, event, steps, steps, partial(_again, phase, t, y, end, tolerance, event.time, steps, optimised)
    )


def _again(phase: Phase, t: float, y, end: float, tolerance: float, end_time: float, steps: int, optimised: bool):
    """Times and dense output of a phase that the compiled loop integrated to its end in `steps` steps."""
    integrators = integrators_of(phase.system, tolerance, float, optimised)
    again = integrators.call(_one_by_one, phase, t, y, end, float, tolerance, most_steps=steps)
    return np.append(again.times[:-1], end_time), again.states


def integrate_quadruple(phase: Phase, t: float, y, end: float, rtol: float) -> Segment:
    """Integrate in quadruple precision, start and end of the phase rounded to double; `rtol` is ignored."""
    integrators = integrators_of(phase.system, QUADRUPLE_TOLERANCE, hy.real128)
    return integrators.call(_one_by_one, phase, t, y, end, hy.real128, QUADRUPLE_TOLERANCE)


def _at_once(integrator, phase: Phase, t: float, y, end: float, tolerance: float) -> tuple[Event, int] | None:
    """The event that ends the phase and the number of steps, by heyoka's own loop; None if its outcome is unclear."""
    _parametrise(integrator, phase, float)
    first = _leave(integrator, phase, t, y, end, float, tolerance)
    if first.guard:
        return None
    outcome = int(integrator.step(min(end - first.time, first.longest))[0])
    steps, guard = first.steps + 1, _guard(outcome, phase)
    if guard is None and outcome not in (SUCCESS, TIME_LIMIT):
        return None
    while guard is None and integrator.time < end:
        result, shortest, _, count, _, _ = integrator.propagate_until(end, max_steps=CHUNK)
        outcome = int(result)
        steps, guard = steps + count, _guard(outcome, phase)
        if guard is None and steps >= MOST_STEPS:
            guard = OUT_OF_STEPS
        is_known = guard is not None or outcome in (TIME_LIMIT, STEP_LIMIT)
        if shortest <= SHORTEST * ulp(integrator.time) or not is_known:
            return None
    return Event(guard, integrator.time, tuple(integrator.state.tolist())), steps


def _guard(outcome: int, phase: Phase) -> str | None:
    """The guard of the event that ended a step: heyoka numbers terminal events down from -1, other outcomes lower."""
    guards = tuple(phase.system.guards)
    return guards[-outcome - 1] if -len(guards) <= outcome < 0 else None


def _one_by_one(
    integrator, phase: Phase, t: float, y, end: float, real: type, tolerance: float, most_steps: int = MOST_LOOKED_AT
) -> Segment:
    """Integrate the phase step by step; returns the segment with all its steps."""
    _parametrise(integrator, phase, real)
    first = _leave(integrator, phase, t, y, end, real, tolerance)
    guard = first.guard
    times, coefficients = ([t, first.time], [integrator.tc.astype(float)]) if first.steps else ([t], [])
    last, longest, tries = real(end), real(first.longest), 0
    with np.errstate(over="ignore"):  # quadruple-precision coefficients may overflow doubles near a singularity
        while integrator.time < end and guard is None:
            if len(coefficients) >= most_steps or tries >= MOST_TRIES:
                guard = OUT_OF_STEPS
                break
            outcome, count = _step(integrator, phase, min(last - integrator.time, longest), real, tolerance)
            tries += count
            longest = real(inf)
            coefficients.append(_doubles(integrator.tc))
            times.append(float(integrator.time))
            if int(outcome) not in (SUCCESS, TIME_LIMIT):
                guard = _guard(int(outcome), phase)
                if guard is None:
                    return _breakdown(phase, times, coefficients, y)
            elif times[-1] < end and times[-1] - times[-2] <= SHORTEST * ulp(times[-1]):
                return _breakdown(phase, times, coefficients, y)
    event = Event(guard, float(integrator.time), tuple(float(v) for v in integrator.state))
    return Segment.of(phase, np.array(times), _TaylorOutput(times, coefficients, y), event, len(coefficients))


def _step(integrator, phase: Phase, longest, real: type, tolerance: float):
    """Take one step of at most `longest`; repeat it shorter if it passes a feature or does not satisfy the equations.
    Returns its outcome and the number of tries."""
    if not phase.checks_steps:
        return integrator.step(longest, True)[0], 1
    start, before, tries = integrator.time, integrator.state.copy(), 1
    outcome, _ = integrator.step(longest, True)
    while np.all(np.isfinite(integrator.tc.astype(float))):
        length = float(integrator.time - start)
        course = Expansion(float(start), length, integrator.tc.astype(float))
        part = good_part(phase, course, tolerance, max(DEFECT * tolerance, ROUNDING))
        if part == 1.0 or part * length <= SHORTEST * np.spacing(float(start)):
            break
        integrator.time = start
        integrator.state[:] = before
        if integrator.with_events:
            integrator.reset_cooldowns()
        outcome, _ = integrator.step(real(part * length), True)
        tries += 1
    return outcome, tries


def _doubles(series: np.ndarray) -> np.ndarray:
    """Coefficients as doubles, 0 for those of quadruple precision that are too large for one.

    Towards a singularity steps are so short that c_k h^k of these is below rounding: heyoka's step is e^-2 of
    the radius of convergence ρ, and where h is 1e-17 the first such k is 18.
    """
    doubles = series.astype(float)
    doubles[np.isinf(doubles) & (series - series == 0)] = 0.0
    return doubles


def _breakdown(phase: Phase, times, coefficients, y) -> Segment:
    """The segment up to the last finite state, if numbers stopped being finite."""
    steps = len(coefficients) - 1
    # Towards a singularity the coefficients of quadruple precision outgrow doubles while the state is still finite.
    while steps > 1 and not np.all(np.isfinite(coefficients[steps - 1])):
        steps -= 1
    states = _TaylorOutput(times[: steps + 1], coefficients[:steps], y)
    last = times[steps]
    event = Event(BREAKDOWN, last, tuple(float(v) for v in states(np.array([last]))[:, 0]))
    return Segment.of(phase, np.array(times[: steps + 1]), states, event, len(coefficients))


def _leave(integrator, phase: Phase, t: float, y, end: float, real: type, tolerance: float) -> FirstStep:
    """Take the phase's first step by its Taylor polynomial, and set the integrator to its end."""
    _set(integrator, t, y, real)
    integrator.step(real(0.0), True)
    first = leave(phase, integrator.tc if real is float else integrator.tc.astype(float), t, y, end, tolerance)
    _set(integrator, first.time, first.state, real)
    return first


def _parametrise(integrator, phase: Phase, real: type) -> None:
    pars = integrator.pars  # only as many as the equations use
    used = phase.parameters[: len(pars)]
    pars[:] = used if real is float else [real(value) for value in used]


def _set(integrator, t: float, y, real: type) -> None:
    integrator.time = real(t)
    integrator.state[:] = y if real is float else [real(float(value)) for value in y]
    if integrator.with_events:
        integrator.reset_cooldowns()


class _TaylorOutput:
    """Dense output from the steps' Taylor polynomials, t ↦ states (variables, n).

    Two arrays and no closures: with 10⁵ phases each object adds to the garbage collector's work.
    """

    __slots__ = ("starts", "by_power")

    def __init__(self, times: list[float], coefficients: list[np.ndarray], y):
        # By power, variable and step; a phase without a step has a constant state.
        powers = np.array(coefficients).transpose(2, 1, 0) if coefficients else np.array(y, dtype=float)[None, :, None]
        self.starts, self.by_power = np.array(times[: powers.shape[2]]), np.ascontiguousarray(powers)

    def __call__(self, when: np.ndarray) -> np.ndarray:
        if len(when) == 1:  # searches evaluate single instants: a tenth of the time of the general code below
            i = max(bisect_right(self.starts, float(when[0])) - 1, 0)
            start, rows = _rows(self, i)
            return np.array([[_horner(row, float(when[0]) - start)] for row in rows])
        # All at once, each instant with its own step's coefficients: linear in steps and in instants.
        which = np.clip(np.searchsorted(self.starts, when, side="right") - 1, 0, len(self.starts) - 1)
        parts = when - self.starts[which]
        values = self.by_power[-1][:, which]
        for row in self.by_power[-2::-1]:
            values = row[:, which] + values * parts
        return values


@lru_cache(maxsize=16)
def _rows(dense: _TaylorOutput, i: int) -> tuple[float, list[list[float]]]:
    """The start of one step, and its polynomials from the highest power down, without vanishing powers."""
    own = dense.by_power[:, :, i]
    used = max(np.flatnonzero(own.any(axis=1)), default=0) + 1
    return float(dense.starts[i]), own[:used][::-1].T.tolist()


def _horner(row: list[float], x: float) -> float:
    """A polynomial's value, its coefficients from the highest down."""
    value = 0.0
    for coefficient in row:
        value = coefficient + value * x
    return value
