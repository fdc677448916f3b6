"""Mode decisions: one rule determines the regime that follows every event.

A regime follows if its conditions hold just after the event along its own motion. "Just after" is the sign of the first
derivative that does not vanish, from Taylor series whose coefficients carry bounds on their rounding. The same rule
applies to the start, to a slip that vanishes and to a normal force that vanishes in a bilateral guide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite

from cases import Case

from ..scales import power_of_two, slip_error
from . import series
from .modes import Phase, Regime, candidates, phase_at, state_in
from .series import Series
from .system import QUICK

# Derivatives evaluated before a condition counts as identically zero. The start of `disc_in_circle` needs the second of
# the normal force; a start at rest on a symmetric place needs the fourth. QUICK of them decide most cases, MIDDLE
# nearly all others but those of a condition that stays at zero: a series to ORDER takes five times as long.
MIDDLE, ORDER = 4, 8

# A force that is at most this part of the largest condition away from its bound is at it: a coefficient, an angle and
# the constants made of them are rounded, and a series has only the rounding that follows. (On an incline with
# tan(slope) = mu a plate would neither stick nor slip.)
AT_BOUND = 32 * series.EPS

# Forces that stay at zero may have this many times the rounding that decides about them, before they count as changes.
SLACK = 4.0

# An event's time is known to this part of it: two roundings of where a root was found, and as many in what has it.
TIME_ROUNDING = 8 * series.EPS


class Undecidable(ArithmeticError):
    """The numbers of a state or of its series in time are too large, too small or not finite."""


def decide(
    case: Case, t: float, y: Sequence[float], error: float, among: Sequence[Regime] | None = None, weak: float = 0.0
) -> Regime | None:
    """The regime that follows from the state (ξ₁, ξ₂, ξ̇₁, ξ̇₂) at time t, or None if none is consistent.

    `error` is the relative error of the state (rounding at a start, the location's at an event): smaller values count
    as zero and the next derivative decides; `weak` as of `follows`. Raises Undecidable if numbers are not finite.
    """
    for regime in candidates(case) if among is None else among:
        if follows(case, phase_at(case, regime, y), t, y, error, weak=weak):
            return regime
    return None


def follows(
    case: Case, candidate: Phase, t: float, y: Sequence[float], error: float, still: float = 0.0, weak: float = 0.0
) -> bool:
    """Whether the candidate's conditions hold just after t along its own motion. A slip of less than `still` (m/s) has
    vanished: the state does not show its error if surfaces move that it is a difference to. So has a force per mass of
    less than `weak` (m/s²): where all forces of the contacts vanish, they do not show it either."""
    quick = _by_value(candidate, t, y, error, still, weak)
    return _by_series(candidate, t, y, error, still, weak) if quick is None else quick


def _by_value(candidate: Phase, t, y, error, still: float, weak: float) -> bool | None:
    """The decision from values alone if they are far from zero; None if a derivative must decide."""
    system, parameters = candidate.system, candidate.parameters
    y = state_in(candidate, y)
    values = system.conditions_of_numbers(t, y, parameters)
    if system.rated:
        # For a velocity that has just vanished, the sign of its rate decides. (All other conditions are forces per
        # mass, and so is this rate.)
        fastest = max([abs(u) / unit for u, unit in zip(y[system.positions :], candidate.lengths, strict=False)])
        bound = max(slip_error(error) * candidate.size * fastest, still)
        if any([abs(values[place]) <= bound for place in system.rated]):
            rates = system.condition_rates_of_numbers(t, y, parameters)
            for place, rate in zip(system.rated, rates, strict=True):
                values[place] = rate if abs(values[place]) <= bound else values[place]
    if not all(map(isfinite, values)):
        raise Undecidable
    sizes = [abs(value) for value in values]
    if sizes and min(sizes) <= max(close(error) * max(sizes), weak):
        return None
    return not values or min(values) > 0.0


def close(error: float) -> float:
    """The part of the largest condition below which a value does not decide: a million times the state's error. Values
    closer to zero are decided by series, which carry their own error bounds."""
    return 1e6 * max(error, series.EPS)


def _by_series(candidate: Phase, t, y, error, still: float, weak: float) -> bool:
    """Whether the conditions hold, by the signs of their series."""
    for signs in _signs_by_order(candidate, t, y, error, still, weak):
        if all(signs.values()) or min(signs.values()) < 0:
            break
    # A velocity must become positive; any other condition may stay at its bound (weightless, level, at rest).
    velocities = candidate.system.condition_rates
    return all(sign > 0 if name in velocities else sign >= 0 for name, sign in signs.items())


def slack_of(
    candidate: Phase, t: float, y: Sequence[float], error: float, weak: float
) -> tuple[tuple[str, float], ...]:
    """The conditions on forces and gaps of a phase that vanish and stay at zero along its motion, each with how far
    below zero its roundings may be (m/s², m): they are no events. Plates that float next to each other neither close
    nor open a contact.

    An integrator would find their roundings below zero; arguments as of `follows`."""
    y = state_in(candidate, y)
    numbers = candidate.system.conditions_of_numbers(t, y, candidate.parameters)
    values = dict(zip(candidate.system.conditions, numbers, strict=True))
    bounds = {name: weak for name in values if name not in candidate.system.condition_rates and name[:4] != "row_"}
    bounds |= {name: _gap_rounding(candidate, y, values[name]) for name in bounds if name.startswith("gap:")}
    names = [name for name, bound in bounds.items() if abs(values[name]) <= bound]
    signs = dict.fromkeys(names, 1)
    for signs in _signs_by_order(candidate, t, y, error, 0.0, weak) if names else ():
        if all(signs[name] for name in names):
            break
    return tuple((name, power_of_two(SLACK * bounds[name])) for name in names if signs[name] == 0)


def _gap_rounding(candidate: Phase, y: Sequence[float], gap: float) -> float:
    """The rounding of a gap, m: not in the units of forces."""
    return AT_BOUND * (candidate.size + abs(y[0]) + abs(y[1]) + abs(gap))


def _signs_by_order(candidate: Phase, t, y, error, still: float, weak: float) -> Iterator[dict[str, int]]:
    """The signs of the conditions by series of rising order: one that is not zero stays."""
    for order in (QUICK, MIDDLE, ORDER):
        yield _leading_signs(candidate, t, y, error, order, still, weak)


def _leading_signs(candidate: Phase, t, y, error, order: int, still: float, weak: float) -> dict[str, int]:
    y = state_in(candidate, y)
    # Velocities have an error of `error` times the largest of them, so that a small one does not count as exact.
    positions = candidate.system.positions
    fastest = max((abs(v) for v in y[positions:]), default=0.0)
    bounds = [error * abs(v) for v in y[:positions]] + [error * fastest for _ in y[positions:]]
    values = dict(zip(candidate.system.conditions, _values(candidate, t, y, bounds, order), strict=True))
    if still:  # a gap may open or close with a velocity of roundings
        values = {
            name: _at_event(value, 1, still, 0.0) if name.startswith("gap:") else value
            for name, value in values.items()
        }
    if weak:
        rates = candidate.system.condition_rates
        orders = {name: 1 if name in rates else 2 if name.startswith("gap:") else 0 for name in values}
        values = {name: _at_event(value, orders[name], weak, TIME_ROUNDING * t) for name, value in values.items()}
    velocities = candidate.system.condition_rates
    gaps = {name: value for name, value in values.items() if name.startswith("gap:")}
    forces = {name: value for name, value in values.items() if name not in velocities and name not in gaps}
    largest = AT_BOUND * max((abs(_value(force)) for force in forces.values()), default=0.0)
    rounding = dict.fromkeys(forces, max(largest, weak))
    if gaps:
        rounding |= dict.fromkeys(gaps, _gap_rounding(candidate, y, max(abs(_value(gap)) for gap in gaps.values())))
    rounding |= dict.fromkeys(velocities, still)
    return {name: series.sign(v, rounding.get(name, 0.0)) for name, v in values.items()}


def _at_event(condition: Series | float, order: int, weak: float, late: float) -> Series | float:
    """A condition with the errors of an event's instant: the time may be off by `late` (s), and a force per mass that
    has vanished there by `weak` (m/s²), which is the coefficient `order` of its effect: of a force, a slip or a gap."""
    if not isinstance(condition, Series):
        return condition
    slopes = [abs(a) for a in condition.derivative().c] + [0.0]
    return Series(
        condition.c,
        [
            e + late * slope + (weak if k == order else 0.0)
            for k, (e, slope) in enumerate(zip(condition.e, slopes, strict=True))
        ],
    )


def _value(condition: Series | float) -> float:
    """A condition's present value."""
    return condition.c[0] if isinstance(condition, Series) else condition


def _values(candidate: Phase, t, y, bounds, order: int) -> Sequence[Series | float]:
    """The conditions' series in numbers; raises Undecidable if they are not finite."""
    try:
        values = candidate.system.condition_series(t, y, bounds, candidate.parameters, order)
    except (ArithmeticError, ValueError) as problem:
        raise Undecidable from problem
    if not all(isfinite(c) for value in values if isinstance(value, Series) for c in value.c):
        raise Undecidable
    return values
