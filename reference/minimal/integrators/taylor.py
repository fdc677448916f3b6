"""One phase by heyoka's Taylor method with its own event detection (Biscani & Izzo 2021, MNRAS 504, 2614).

Optional: where heyoka is not installed, `AVAILABLE` is False and DOP853 does everything.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from itertools import chain, islice
from pathlib import Path

import numpy as np
import sympy as sp
from numpy.polynomial.polynomial import polyder, polyval

from cases import NotSupported

from ..ahead import INSIDE, PARTS, clear_part, defect
from ..eliminated import Motion, T
from ..modes import Phase
from ..system import System
from .segment import BREAKDOWN, Event, Segment

try:
    import heyoka as hy
except ImportError:
    AVAILABLE = False
else:
    AVAILABLE = True

# Step-size tolerances are rounded to whole powers of ten: one compiled integrator each.
FINEST = 1e-16
# Far below double precision's rounding, far above quadruple's.
QUADRUPLE_TOLERANCE = 1e-24
# A step of so few units in the last place of time no longer moves it: towards a singularity steps shrink without end.
SHORTEST = 16
# The defect of a step's polynomial, in tolerances: steps that saw what lay in them stayed below 1.1 (bumps, steps and
# notches at 1e-4 … 1e-12). Forces are known to ROUNDING, as differences of terms up to a thousand times as large.
DEFECT, ROUNDING = 10.0, 1e-12
# The part of its first polynomial's reach that a phase covers by it alone: it is exact there to rounding, and what
# leaves zero with the fourth power of time is still well above its own rounding.
PART = 1e-3
# Optimising a system whose expressions have so many nodes takes 0.3 s. For larger ones (curvatures change) it takes
# 0.5 to 2.7 s, ten times the rest of their compilation, to save a fifth to a half of runs of a millisecond.
SMALL = 500


def _expressions(system: System) -> dict:
    """SymPy symbols of the system as heyoka's variables, parameters and time."""
    known = {v: hy.expression(v.name) for v in system.variables}
    return known | {p: hy.par[i] for i, p in enumerate(system.parameters)} | {T: hy.time}


def _converted(expression: sp.Expr, known: dict):
    """The expression as heyoka's, whole powers as products: heyoka's own power has no Taylor series at zero."""
    known = known | {number: _number(number) for number in _numbers(expression)}
    products: dict[sp.Expr, sp.Symbol] = {}
    powers = [p for p in expression.atoms(sp.Pow) if p.exp.is_Integer and p.exp > 2]
    # What a power contains comes before it. SymPy sorts sums by names: those given here do not depend on what was
    # compiled before, so that a motion is the same to its last bit whatever ran earlier.
    for i, power in enumerate(sorted(powers, key=lambda p: (p.count_ops(), sp.default_sort_key(p)))):
        base = _from_sympy(power.base.xreplace(products), known)
        products[power] = sp.Symbol(f"power_{i:04d}")
        known[products[power]] = _power(base, int(power.exp))
    return _from_sympy(expression.xreplace(products), known)


def _from_sympy(expression: sp.Expr, known: dict):
    """heyoka's own conversion; raises NotSupported for a function that it has no series of."""
    try:
        return hy.from_sympy(expression, known)
    except (TypeError, ValueError) as problem:
        raise NotSupported(f"the Taylor method cannot do this case ({problem}); give method='dop853'") from problem


def _numbers(expression: sp.Expr) -> Iterator[sp.Expr]:
    """Numbers inside the expression that heyoka refuses or rounds to double precision: 1/3, sqrt(2), exp(1)."""
    nodes = sp.preorder_traversal(expression)
    for node in nodes:
        # π is heyoka's own; halves, quarters, … are exact, and as exponents they are square roots.
        plain = isinstance(node, sp.Integer | sp.Float) or node is sp.pi or (node.is_Rational and _is_binary(node.q))
        if isinstance(node, sp.Expr) and node.is_number and not plain:
            yield node
            nodes.skip()


def _is_binary(denominator: int) -> bool:
    """Whether the denominator is a power of two."""
    return denominator & (denominator - 1) == 0


def _number(number: sp.Expr):
    """The number in quadruple precision, where heyoka has it; a compilation in double precision rounds it once more."""
    digits = str(sp.N(number, 40))  # quadruple precision has 34
    return hy.expression(hy.real128(digits) if hasattr(hy, "real128") else float(digits))


def _power(base, exponent: int):
    """Repeated squaring."""
    half = base if exponent < 4 else _power(base, exponent // 2)
    if exponent in (2, 3):
        return base * base if exponent == 2 else base * (base * base)
    return half * half if exponent % 2 == 0 else base * (half * half)


@lru_cache(maxsize=128)
def compiled(system: System, tolerance: float, real: type = float):
    """The compiled integrator of a system, with one terminal event for each guard."""
    decided = (tolerance, real.__name__, hy.__version__, _build())
    return system.kept("integrator", decided, lambda: _compiled(system, tolerance, real))


@lru_cache(maxsize=1)
def _build() -> tuple[int, int]:
    """Which build of heyoka this is: the same version may come with another LLVM."""
    found = Path(hy._core.__file__).stat()
    return found.st_size, found.st_mtime_ns


def _compiled(system: System, tolerance: float, real: type):
    known = _expressions(system)
    equations = [(known[v], _converted(rate, known)) for v, rate in zip(system.variables, system.rates, strict=True)]
    falling = hy.event_direction.negative
    events = [hy.t_event(_converted(g, known), direction=falling, fp_type=real) for g in system.guards.values()]
    with _nothing_on_disk():
        return hy.taylor_adaptive(
            equations,
            [real(0.0)] * len(equations),
            t_events=events,
            tol=real(tolerance),
            fp_type=real,
            compact_mode=False,
            opt_level=3 if _small(system) else 0,
        )


def _small(system: System) -> bool:
    """Whether optimising the system's code is worth its time."""
    nodes = chain.from_iterable(sp.preorder_traversal(e) for e in (*system.rates, *system.guards.values()))
    return next(islice(nodes, SMALL, None), None) is None


@contextmanager
def _nothing_on_disk() -> Iterator[None]:
    """heyoka would keep all it compiles in the user's home, gigabytes of it, and compile at another speed each time."""
    state = hy.llvm_state
    if not hasattr(state, "set_diskcache_enabled"):  # versions before it had that cache
        yield
        return
    enabled = state.get_diskcache_enabled()
    state.set_diskcache_enabled(False)
    try:
        yield
    finally:
        state.set_diskcache_enabled(enabled)


def prepare(phase: Phase, rtol: float = 1e-10) -> None:
    """Compile the phase's equations for that tolerance."""
    compiled(phase.system, _tolerance(rtol))


def prepare_quadruple(phase: Phase, rtol: float = 1e-10) -> None:
    """Compile the phase's equations in quadruple precision."""
    compiled(phase.system, QUADRUPLE_TOLERANCE, hy.real128)


def _tolerance(rtol: float) -> float:
    return max(FINEST, 10.0 ** np.floor(np.log10(rtol) + 1e-9))


def integrate(phase: Phase, t: float, y, end: float, rtol: float) -> Segment:
    """Integrate from (t, y) until a guard reaches zero, `end`, or a singularity (guard BREAKDOWN)."""
    tolerance = _tolerance(rtol)
    return _integrate(compiled(phase.system, tolerance), phase, t, y, end, float, tolerance)


def integrate_quadruple(phase: Phase, t: float, y, end: float, rtol: float) -> Segment:
    """The same in quadruple precision, start and end of the phase rounded to double; `rtol` is not looked at."""
    integrator = compiled(phase.system, QUADRUPLE_TOLERANCE, hy.real128)
    return _integrate(integrator, phase, t, y, end, hy.real128, QUADRUPLE_TOLERANCE)


def _integrate(integrator, phase: Phase, t: float, y, end: float, real: type, tolerance: float) -> Segment:
    integrator.pars[:] = [real(value) for value in phase.parameters[: len(integrator.pars)]]
    times: list[float] = [t]
    coefficients: list[np.ndarray] = []
    _set(integrator, t, y, real)
    integrator.step(real(0.0), True)
    series = integrator.tc.astype(float)
    _set(integrator, t, y, real)
    guard = _leave_start(integrator, phase, series, t, y, end, real, times, coefficients)
    most = _most(series)
    while integrator.time < end and guard is None:
        outcome = _step(integrator, phase, min(real(end) - integrator.time, real(most)), real, tolerance)
        most = np.inf
        with np.errstate(over="ignore"):
            coefficients.append(integrator.tc.astype(float))
        times.append(float(integrator.time))
        if outcome not in (hy.taylor_outcome.success, hy.taylor_outcome.time_limit):
            number = -int(outcome) - 1
            if not 0 <= number < len(phase.system.guards):
                return _broken(phase, times, coefficients, y)
            guard = list(phase.system.guards)[number]
        elif times[-1] < end and times[-1] - times[-2] <= SHORTEST * np.spacing(times[-1]):
            return _broken(phase, times, coefficients, y)
    event = Event(guard, float(integrator.time), tuple(float(v) for v in integrator.state))
    return Segment(phase, np.array(times), _dense(times, coefficients, y), event, len(coefficients))


def _step(integrator, phase: Phase, longest, real: type, tolerance: float):
    """One step of at most `longest`; again from its start, shorter, where it passes a feature or the equations."""
    start, before = integrator.time, integrator.state.copy()
    outcome, _ = integrator.step(longest, True)
    while phase.features and np.all(np.isfinite(integrator.tc.astype(float))):
        length = float(integrator.time - start)
        part = _good_part(phase, float(start), length, integrator.tc.astype(float), tolerance)
        if part == 1.0 or part * length <= SHORTEST * np.spacing(float(start)):
            break
        integrator.time = start
        integrator.state[:] = before
        if integrator.with_events:
            integrator.reset_cooldowns()
        outcome, _ = integrator.step(real(part * length), True)
    return outcome


def _good_part(phase: Phase, start: float, length: float, series: np.ndarray, tolerance: float) -> float:
    """The part of a step that may stand, 1 if all of it."""
    part = clear_part(phase, start, length, polyval(length * PARTS, series.T))
    if part < 1.0:
        return part
    inside = length * INSIDE
    slopes = polyval(inside, polyder(series.T))
    missed = defect(phase, start + inside, polyval(inside, series.T), slopes, length)
    return 1.0 if missed <= max(DEFECT * tolerance, ROUNDING) else 0.5


def _broken(phase: Phase, times, coefficients, y) -> Segment:
    """The segment up to the last finite state, where numbers stopped being finite."""
    steps = len(coefficients) - 1
    # Towards a singularity the coefficients of quadruple precision outgrow doubles while the state is still finite.
    while steps > 1 and not np.all(np.isfinite(coefficients[steps - 1])):
        steps -= 1
    states = _dense(times[: steps + 1], coefficients[:steps], y)
    last = times[steps]
    event = Event(BREAKDOWN, last, tuple(float(v) for v in states(np.array([last]))[:, 0]))
    return Segment(phase, np.array(times[: steps + 1]), states, event, len(coefficients))


def _most(series: np.ndarray) -> float:
    """The longest step that the upper half of a series' terms allows.

    heyoka's rule (Jorba & Zou 2005, Experimental Mathematics 14, 99) looks at the last two terms, relative to the
    state or to 1. From a symmetric place at rest a motion has every fourth power only, and both may vanish.
    """
    powers = np.arange(series.shape[1])[series.shape[1] // 2 :]
    terms = np.max(np.abs(series[:, powers]), axis=0) / max(1.0, float(np.max(np.abs(series[:, 0]))))
    fastest = float(np.max(terms ** (1.0 / powers), initial=0.0))
    return np.exp(-2.0) / fastest if fastest else np.inf


def _leave_start(integrator, phase: Phase, series, t, y, end, real, times: list, coefficients: list) -> str | None:
    """The first, tiny part of a phase, by its Taylor polynomial alone; a guard if one reaches zero within it.

    A phase begins with a guard at zero that the decision found to grow, often with the square of time; event
    detection would find that root again, and a cool-down after it would hide the next.
    """
    if not np.all(np.isfinite(series)):
        return BREAKDOWN
    if not phase.system.guards:
        return None
    reach = _reach(phase, series, t, y)
    if not np.isfinite(reach):
        return None  # nothing moves and nothing presses: no guard leaves zero
    values: list[float] = []
    for shorter in range(9):
        h = min(PART * reach * 10.0**-shorter, end - t)
        if phase.features:
            h *= clear_part(phase, t, h, polyval(h * PARTS, series.T))
        # What is positive at the end and half-way there has left zero and not come back; else the step is shortened
        # until the event lies behind it.
        for part in (0.5, 1.0):
            state = polyval(part * h, series.T)
            values = phase.system.guards_of_numbers(t + part * h, state.tolist(), phase.parameters)
            if not all(value > 0.0 for value in values):
                break
        else:
            _set(integrator, t + h, state, real)
            coefficients.append(series)
            times.append(t + h)
            return None
    return next(name for name, value in zip(phase.system.guards, values, strict=True) if not value > 0.0)


def _reach(phase: Phase, series: np.ndarray, t: float, y) -> float:
    """The time in which some term of the positions' series grows to the plate's size, or the contact's forces would
    move the plate by it.

    All terms count: those of even or of odd order vanish in a motion from rest. Where none is left the forces balance,
    and a load may change them; infinite where there are no forces either.
    """
    powers = np.arange(1, series.shape[1])
    terms = np.abs(series[: phase.system.positions, 1:]) / np.array(phase.lengths)[:, None]
    forces = Motion(*phase.system.observed_of_numbers(t, tuple(y), phase.parameters))
    falls = (max(abs(forces.normal), abs(forces.friction)) / phase.size) ** 0.5
    fastest = max(falls, float(np.max(terms ** (1.0 / powers), initial=0.0)))
    return 1.0 / fastest if fastest else np.inf


def _set(integrator, t: float, y, real: type) -> None:
    integrator.time = real(t)
    integrator.state[:] = [real(float(value)) for value in y]
    if integrator.with_events:
        integrator.reset_cooldowns()


def _dense(times, coefficients, y):
    """The steps' own Taylor polynomials."""
    starts = np.array(times[:-1])

    @lru_cache(maxsize=4)
    def rows(i: int) -> list[list[float]]:
        """One step's polynomials from the highest power down, without what vanishes there."""
        used = max(np.flatnonzero(coefficients[i].any(axis=0)), default=0) + 1
        return coefficients[i][:, used - 1 :: -1].tolist() if used > 1 else coefficients[i][:, :1].tolist()

    def states(when: np.ndarray) -> np.ndarray:
        if not coefficients:
            return np.repeat(np.array(y, dtype=float)[:, None], len(when), axis=1)
        if len(when) == 1:  # a search looks at one instant after the other: a tenth of the time below
            i = max(bisect_right(times, float(when[0]), hi=len(coefficients)) - 1, 0)
            return np.array([[_horner(row, float(when[0]) - times[i])] for row in rows(i)])
        which = np.clip(np.searchsorted(starts, when, side="right") - 1, 0, len(coefficients) - 1)
        values = np.empty((len(y), len(when)))
        for i in np.unique(which):
            chosen = which == i
            values[:, chosen] = polyval(when[chosen] - starts[i], coefficients[i].T)
        return values

    return states


def _horner(row: list[float], x: float) -> float:
    """A polynomial's value, its coefficients from the highest down."""
    value = 0.0
    for coefficient in row:
        value = coefficient + value * x
    return value
