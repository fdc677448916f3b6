"""Integration of one phase by heyoka's Taylor method with its event detection (Biscani & Izzo 2021, MNRAS 504, 2614).

Optional: without heyoka, `AVAILABLE` is False and DOP853 is used.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from copy import deepcopy
from functools import lru_cache, partial
from math import inf, ulp
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np

from cases.derivation import in_one_thread

from ...endings import BREAKDOWN
from ..defect_check import Expansion, good_part
from ..modes import Phase
from ..system import System
from .segment import MOST_LOOKED_AT, MOST_STEPS, MOST_TRIES, OUT_OF_STEPS, Event, Instant, Segment

try:
    import heyoka as hy
except ImportError:
    AVAILABLE = False
else:
    from .conversion import LARGE, SMALL, convert, nothing_on_disk, operations_of, variables
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
# The compiled loop returns after this many steps, so that it does not run forever towards a singularity. First after
# fewer, twice as many each time: the laws are checked at a state where it returned. A return takes 3 µs.
CHUNK, FIRST_CHUNK = 1000, 4


P = ParamSpec("P")
T = TypeVar("T")


@lru_cache(maxsize=128)
def integrators_of(system: System, tolerance: float, real: type = float, optimised: bool = False) -> IntegratorPool:
    """The compiled integrators of a system, with one terminal event for each guard; `optimised`: fully optimised,
    however long that takes, for thousands of runs."""
    return IntegratorPool(lambda: Workspace(_compile(system, tolerance, real, optimised), real))


class Workspace:
    """A compiled integrator with the arrays of its memory: heyoka makes a new array each time that `state`, `pars` or
    `tc` is read, which takes as long as a step.

    `parameters` are those of the phase that are set, to be emptied by code that sets `pars` itself.
    """

    __slots__ = ("integrator", "real", "state", "pars", "coefficients", "parameters", "with_events")

    def __init__(self, integrator, real: type = float):
        self.integrator, self.real, self.with_events = integrator, real, integrator.with_events
        self.state, self.pars, self.coefficients = integrator.state, integrator.pars, integrator.tc
        self.parameters: tuple[float, ...] = ()

    def __deepcopy__(self, memo) -> Workspace:
        return Workspace(deepcopy(self.integrator, memo), self.real)

    def use(self, phase: Phase) -> None:
        """Set the phase's parameters."""
        if self.parameters is phase.parameters:
            return
        self.parameters = ()  # an interrupt may come before all are set
        used = phase.parameters[: len(self.pars)]  # only as many as the equations use
        self.pars[:] = used if self.real is float else [self.real(value) for value in used]
        self.parameters = phase.parameters

    def set(self, t: float, y) -> None:
        """Set time and state."""
        real = self.real
        self.integrator.time = t if real is float else real(t)
        self.state[:] = y if real is float else [real(float(value)) for value in y]
        if self.with_events:
            self.integrator.reset_cooldowns()


def _compile(system: System, tolerance: float, real: type, optimised: bool):
    # Constants are doubles: quadruple precision computes them as part of the equations.
    known = variables(system, constants=real is float)
    rates, guards = (convert(some, known) for some in (system.rates, system.guards.values()))
    equations = [(known[v], rate) for v, rate in zip(system.variables, rates, strict=True)]
    falling = hy.event_direction.negative
    events = [hy.t_event(guard, direction=falling, fp_type=real) for guard in guards]
    # A product in quadruple precision is a library call: unrolled steps take thirty times as long to compile, and run
    # no faster, to the same last bit.
    count = operations_of(system)
    written_out = real is float and (optimised or count <= LARGE)
    with nothing_on_disk():
        return hy.taylor_adaptive(
            equations,
            [real(0.0)] * len(equations),
            t_events=events,
            tol=real(tolerance),
            fp_type=real,
            compact_mode=not written_out,
            opt_level=3 if written_out and (optimised or count < SMALL) else 0,
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
        return integrators.call(_one_by_one, phase, t, y, end, tolerance)
    event, steps, inside = outcome
    # No closure, to spare the garbage collector.
    again = partial(_again, phase, t, y, end, tolerance, event.time, steps, optimised)
    return Segment(phase, t, event, steps, steps, again, ((t, y), *inside))


def _again(phase: Phase, t: float, y, end: float, tolerance: float, end_time: float, steps: int, optimised: bool):
    """Times and dense output of a phase that the compiled loop integrated to its end in `steps` steps."""
    integrators = integrators_of(phase.system, tolerance, float, optimised)
    again = integrators.call(_one_by_one, phase, t, y, end, tolerance, most_steps=steps)
    return np.append(again.times[:-1], end_time), again.states


def integrate_quadruple(phase: Phase, t: float, y, end: float, rtol: float) -> Segment:
    """Integrate in quadruple precision, start and end of the phase rounded to double; `rtol` is ignored."""
    integrators = integrators_of(phase.system, QUADRUPLE_TOLERANCE, hy.real128)
    return integrators.call(_one_by_one, phase, t, y, end, QUADRUPLE_TOLERANCE)


def _at_once(
    workspace: Workspace, phase: Phase, t: float, y, end: float, tolerance: float
) -> tuple[Event, int, tuple[Instant, ...]] | None:
    """The event that ends the phase, the number of steps, and, of several, the state after one, by heyoka's own loop;
    None if its outcome is unclear."""
    integrator = workspace.integrator
    first = _leave(workspace, phase, t, y, end, tolerance)
    if first.guard:
        return None
    outcome = int(integrator.step(min(end - first.time, first.longest))[0])
    steps, guard, time = first.steps + 1, _guard(outcome, phase), integrator.time
    if guard is None and outcome not in (SUCCESS, TIME_LIMIT):
        return None
    inside, chunk = list[Instant](), FIRST_CHUNK
    while guard is None and time < end:
        inside.append((time, workspace.state.tolist()))
        result, shortest, _, count, _, _ = integrator.propagate_until(end, max_steps=chunk)
        chunk = min(2 * chunk, CHUNK)
        outcome, time = int(result), integrator.time
        steps, guard = steps + count, _guard(outcome, phase)
        if guard is None and steps >= MOST_STEPS:
            guard = OUT_OF_STEPS
        is_known = guard is not None or outcome in (TIME_LIMIT, STEP_LIMIT)
        if shortest <= SHORTEST * ulp(time) or not is_known:
            return None
    half = len(inside) // 2
    return Event(guard, time, tuple(workspace.state.tolist())), steps, tuple(inside[half : half + 1])


def _guard(outcome: int, phase: Phase) -> str | None:
    """The guard of the event that ended a step: heyoka numbers terminal events down from -1, other outcomes lower."""
    guards = phase.system.guards
    return tuple(guards)[-outcome - 1] if -len(guards) <= outcome < 0 else None


def _one_by_one(
    workspace: Workspace, phase: Phase, t: float, y, end: float, tolerance: float, most_steps: int = MOST_LOOKED_AT
) -> Segment:
    """Integrate the phase step by step; returns the segment with all its steps."""
    integrator, real = workspace.integrator, workspace.real
    first = _leave(workspace, phase, t, y, end, tolerance)
    guard = first.guard
    times, coefficients = ([t, first.time], [workspace.coefficients.astype(float)]) if first.steps else ([t], [])
    last, longest, tries = real(end), real(first.longest), 0
    with np.errstate(over="ignore"):  # quadruple-precision coefficients may overflow doubles near a singularity
        while integrator.time < end and guard is None:
            if len(coefficients) >= most_steps or tries >= MOST_TRIES:
                guard = OUT_OF_STEPS
                break
            outcome, count = _step(workspace, phase, min(last - integrator.time, longest), tolerance)
            tries += count
            longest = real(inf)
            coefficients.append(_doubles(workspace.coefficients))
            times.append(float(integrator.time))
            if int(outcome) not in (SUCCESS, TIME_LIMIT):
                guard = _guard(int(outcome), phase)
                if guard is None:
                    return _breakdown(phase, times, coefficients, y)
            elif times[-1] < end and times[-1] - times[-2] <= SHORTEST * ulp(times[-1]):
                return _breakdown(phase, times, coefficients, y)
    event = Event(guard, float(integrator.time), tuple(float(v) for v in workspace.state))
    return Segment.of(phase, np.array(times), _TaylorOutput(times, coefficients, y), event, len(coefficients))


def _step(workspace: Workspace, phase: Phase, longest, tolerance: float):
    """Take one step of at most `longest`; repeat it shorter if it passes a feature or does not satisfy the equations.
    Returns its outcome and the number of tries."""
    integrator, real = workspace.integrator, workspace.real
    if not phase.checks_steps:
        return integrator.step(longest, True)[0], 1
    start, before, tries = integrator.time, workspace.state.copy(), 1
    outcome, _ = integrator.step(longest, True)
    while np.isfinite(coefficients := workspace.coefficients.astype(float)).all():
        length = float(integrator.time - start)
        if length == 0.0:  # shorter than the clock resolves: the motion breaks down, as the caller finds
            break
        course = Expansion(float(start), length, coefficients)
        part = good_part(phase, course, tolerance, max(DEFECT * tolerance, ROUNDING))
        if part == 1.0 or part * length <= SHORTEST * np.spacing(float(start)):
            break
        integrator.time = start
        workspace.state[:] = before
        if workspace.with_events:
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


def _leave(workspace: Workspace, phase: Phase, t: float, y, end: float, tolerance: float) -> FirstStep:
    """Take the phase's first step by its Taylor polynomial, and set the integrator to its end."""
    workspace.use(phase)
    workspace.set(t, y)
    workspace.integrator.step(workspace.real(0.0), True)
    coefficients = workspace.coefficients
    first = leave(phase, coefficients if workspace.real is float else coefficients.astype(float), t, y, end, tolerance)
    workspace.set(first.time, first.state)
    return first


class _TaylorOutput:
    """Dense output from the steps' Taylor polynomials, t ↦ states (variables, n).

    Two arrays and no closures: with 10⁵ phases each object adds to the garbage collector's work.
    """

    __slots__ = ("starts", "by_power")

    def __init__(self, times: list[float], coefficients: list[np.ndarray], y):
        # By power, variable and step; a phase without a step has a constant state.
        powers = np.array(coefficients).transpose(2, 1, 0) if coefficients else np.array(y, dtype=float)[None, :, None]
        self.starts, self.by_power = np.array(times[: powers.shape[2]]), np.ascontiguousarray(powers)

    def at_step(self, i: int) -> Instant:
        """The time and the state at which a step begins."""
        return float(self.starts[i]), self.by_power[0, :, i].tolist()

    def inside(self, i: int, part: float) -> Instant:
        """The time and the state `part` seconds after a step's beginning."""
        powers = part ** np.arange(len(self.by_power))
        return float(self.starts[i]) + part, (powers @ self.by_power[:, :, i]).tolist()

    def __call__(self, when: np.ndarray) -> np.ndarray:
        if len(when) == 1:  # searches evaluate single instants: a tenth of the time of the general code below
            i = max(bisect_right(self.starts, float(when[0])) - 1, 0)
            start, rows = _rows(self, i)
            return np.array([[_horner(row, float(when[0]) - start)] for row in rows])
        # All at once, each instant with its own step's coefficients: linear in steps and in instants.
        which = np.clip(np.searchsorted(self.starts, when, side="right") - 1, 0, len(self.starts) - 1)
        parts = when - self.starts[which]
        values = self.by_power[-1].take(which, axis=1)
        for row in self.by_power[-2::-1]:
            values *= parts
            values += row.take(which, axis=1)
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


class IntegratorPool:
    """Identical integrators, as many as were ever in use at the same time.

    An integrator stores the time, state and parameters of its present phase, so that no other phase may use it until
    the results are read. `make` makes one; a single thread never needs a second.
    """

    def __init__(self, make: Callable[[], Any]):
        self._make, self._free = make, [make()]
        self._original: Any = None  # the source of copies, never in use itself

    def call(self, function: Callable[Concatenate[Any, P], T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call `function(integrator, …)` with an integrator that is not used elsewhere until it returns."""
        try:
            integrator = self._free.pop()
        except IndexError:
            integrator = self._another()
        try:
            return function(integrator, *args, **kwargs)
        finally:
            self._free.append(integrator)

    @in_one_thread
    def _another(self) -> Any:
        """One more integrator. A copy takes 2 ms and shares the machine code; making one takes at least ten times as
        long."""
        if self._original is None:
            self._original = self._make()
        return deepcopy(self._original)
