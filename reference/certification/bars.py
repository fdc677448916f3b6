"""Error bars: the differences between the witnesses, and the effect of rounding on values that all of them share.

A bar is the largest distance of any witness from the centre, and at least the sum of
- the rounding of the value itself, as a sum of terms that are larger than it (an angle is a difference of two tangents'
  angles, a slip of two speeds),
- its change during a rounding of its time,
- its change when each component of the state is moved by its rounding, summed over the components.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, Chain, Curve
from cases.contact import velocity
from cases.contact.geometry import piece_at
from cases.curves.corner import turning
from cases.scene.contact_limits import touches_by_features

from .witnesses import EPS, FINEST, FREE, Witness, components, perturb, quantities

# A state is computed in a few operations, each of which rounds by half a unit in the last place.
ULPS = 4
# The error of each method at its finest tolerance, in roundings of the largest value of a kind. The Taylor method sums
# its steps with compensation, so its error is that of a state. DOP853 rounds each of the twelve stages of a step: its
# times of the catalogue's transitions differ from those in quadruple precision by 8e-15 s and 32 roundings (medians),
# and by as much again on machines with other elementary functions. The README and docs/truth.md give the errors of a
# time of one second: 1e-15 and 1e-14 s.
METHOD_ULPS = {"taylor": ULPS, "dop853": 64}
# The state is moved by this many roundings, and the difference is divided by the number: the integrator's own rounding
# is then far below the difference. If the larger move changes the events, the smaller one is used.
STEPS = (64.0, float(ULPS))


class Bar(NamedTuple):
    """A value and the half-width of its error bar."""

    value: float
    bar: float


def bar(values: Sequence[float], least: float, period: float | None = None) -> Bar:
    """The first value and the others' largest distance from it, at least `least`; for a parameter with a period, modulo
    that period.

    If no witness has a value (slip in flight), the bar is 0; if only some have one, it is infinite.
    """
    centre = float(values[0])
    if np.all(np.isnan(values)):
        return Bar(centre, 0.0)
    if np.any(np.isnan(values)):
        return Bar(centre, np.inf)
    apart = [float(value) - centre for value in values]
    if period:
        # After a flight each witness counts the turns around a closed track in its own way.
        apart = [distance - period * round(distance / period) for distance in apart]
    return Bar(centre, max(*map(abs, apart), least))


class Shares(NamedTuple):
    """The changes when the state is moved by its rounding: times of transitions (s), their ξ₁, the end (s), and the
    samples by quantity; `ill` names the move that changes the events, "" if none does."""

    times: np.ndarray
    places: np.ndarray
    end: float
    samples: dict[str, np.ndarray]
    ill: str = ""


def shares(case: Case, times: np.ndarray, method: str) -> Shares:
    """The changes of all values by the roundings of the state, summed over its components."""
    plain = perturb(case, 0, 0.0, method)
    sums = _differences(plain, plain, times, case.track.period)
    ill = ""
    for component in range(components(case)):
        for steps in STEPS:
            other = perturb(case, component, steps, method)
            if other.events == plain.events:
                changes = _differences(plain, other, times, case.track.period)
                sums = [a + ULPS / steps * b for a, b in zip(sums, changes, strict=True)]
                break
        else:
            ill = _changes(steps, other)
    at, places, end, *samples = sums
    return Shares(at, places, float(end), dict(zip(plain.states(times), samples, strict=True)), ill)


def ambiguity(case: Case, method: str) -> str:
    """The move of a component of the state by the method's own tolerance that changes the events, "" if none does.

    A method whose tolerance is far above rounding (DOP853) gives the same wrong answer for all states that differ by
    roundings only.
    """
    plain, most = perturb(case, 0, 0.0, method), FINEST[method] / EPS
    for component in range(components(case)):
        for by in (most, -most):
            other = perturb(case, component, by, method)
            if other.events != plain.events:
                return _changes(by, other)
    return ""


def _changes(by: float, other: Witness) -> str:
    return f"moving a component of its state by {by:.3g} roundings gives {other.answer}"


def _differences(plain: Witness, other: Witness, times: np.ndarray, period: float | None) -> list[np.ndarray]:
    """Absolute differences of times, places, end and samples."""
    pairs = list(zip(plain.transitions, other.transitions, strict=True))
    places = np.array([b.xi1 - a.xi1 for a, b in pairs])
    if period:
        places = places - period * np.round(places / period)
    here, there = plain.states(times), other.states(times)
    return [
        np.abs(np.array([b.time - a.time for a, b in pairs])),
        np.abs(np.nan_to_num(places)),
        np.abs(np.array(other.end - plain.end)),
        *(np.abs(np.nan_to_num(there[q] - here[q])) for q in here),
    ]


def roundings(case: Case, witness: Witness, times: np.ndarray, rounding: float) -> dict[str, np.ndarray]:
    """The rounding of each sample's value and of its time, by quantity: the part `rounding` of the largest terms of the
    quantity anywhere in the motion, plus its change during a rounding of the time."""
    terms = _terms(case, witness, times)
    last = max(float(times[-1]), np.finfo(float).tiny)
    h = (
        1e-6 * last
    )  # short compared with any motion of eleven samples, long compared with the roundings of values and times
    before, after = np.clip(times - h, 0.0, last), np.clip(times + h, 0.0, last)
    early, late = witness.states(before), witness.states(after)
    every = quantities(case)
    rate = {q: np.nan_to_num(np.abs(late[q] - early[q])) / (after - before) for q in every}
    return {q: rounding * (terms[q] + rate[q] * times) for q in every}


def _turning(curve: Curve, s: float, speed: float, rate: float) -> float:
    """How fast the tangent turns along a curve, rad/s, without its sign."""
    if isinstance(curve, Chain):
        return abs(turning(*piece_at(curve, s)) * rate)
    return abs(float(curve.curvature(s))) * speed


def _terms_of_others(case: Case, state: dict[str, np.ndarray]) -> dict[str, float]:
    """As `_terms`, of free plates."""
    sizes = {}
    for other in case.others:
        for q in FREE:
            own = 2 * other.plate.reach if q in ("x", "y") else 0.0
            sizes[f"{q} of {other.name}"] = float(np.abs(state[f"{q} of {other.name}"]).max()) + own
    return sizes


def _terms(case: Case, witness: Witness, times: np.ndarray) -> dict[str, float]:
    """The size of the terms that each quantity is computed from, the largest of the motion."""
    outline, track = case.plate.outline, case.track
    reach = float(np.hypot(*outline.point(np.linspace(*outline.span, 721))).max())
    state = witness.states(times)
    place = float(np.max(np.hypot(state["x"], state["y"])))
    angle, slip, omega = (float(np.nanmax(np.abs(np.append(state[q], 0.0)))) for q in ("theta", "slip", "omega"))
    assert witness.motion is not None
    if case.others or touches_by_features(case) or len(witness.motion.contact_names) > 1:  # parameters of any contact
        sizes = {"slip": slip + reach * omega, "omega": omega}
        return {"x": place + 2 * reach, "y": place + 2 * reach, "theta": angle} | sizes | _terms_of_others(case, state)
    for xi1, xi2, v, w in zip(*(state[q] for q in ("xi1", "xi2", "slip", "omega")), strict=True):
        if not np.isfinite(xi2) or not np.isfinite(v):
            continue
        angle = max(angle, abs(float(track.tangent_angle(xi1))) + abs(float(outline.tangent_angle(xi2))))
        now = velocity(case, xi1, xi2, v, w)
        speeds = abs(now.xi1_dot) * float(track.speed(xi1)), abs(now.xi2_dot) * float(outline.speed(xi2))
        slip = max(slip, sum(speeds))
        omega = max(
            omega,
            _turning(track, xi1, speeds[0], now.xi1_dot) + _turning(outline, xi2, speeds[1], now.xi2_dot),
        )
    # The plate's position is a sum of the contact's place and the outline's point.
    return {"x": place + 2 * reach, "y": place + 2 * reach, "theta": angle, "slip": slip, "omega": omega}
