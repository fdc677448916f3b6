"""Programs that are timed warm and in turns: first slip phases at an equal error, whole motions, and whole calls."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from math import nan
from typing import Any, NamedTuple

import numpy as np

import cases
import reference
from cases.library import cosine
from reference import solve
from reference.minimal.integrators import taylor
from reference.minimal.modes import Regime, phase, start_state
from reference.paper.closed_form import sliding_disc_in_circle

# First slip phases are timed at the coarsest tolerance that reaches this error, s; whole motions at this tolerance.
FIRST_SLIP_ERROR, RTOL = 1e-9, 1e-9
COEFFICIENTS = (0.01, 0.1, 0.2)


class Program(NamedTuple):
    """A program to time, and its error at the first transition (s, NaN for whole motions)."""

    run: Callable[[], Any]
    error: float = nan


# The methods of `simulate`, and the Taylor method compiled for many runs.
METHODS = (*reference.METHODS, *(("taylor_optimised",) if taylor.AVAILABLE else ()))


def contestants() -> dict[str, Program]:
    """All contestants by name. All are warm: compiled, and run repeatedly."""
    programs: dict[str, Program] = {}
    for mu in COEFFICIENTS:
        if taylor.AVAILABLE:
            programs[f"heyoka on (35), first slip, mu={mu}"] = _coarsest_program(mu, closed_form_by_heyoka)
        for method in METHODS:
            programs[f"{method}, first slip, mu={mu}"] = _coarsest_program(mu, partial(first_slip, method=method))
            programs[f"simulate by {method}, first slip, new mu={mu}"] = _coarsest_program(
                mu, partial(whole_call, method=method)
            )
    valley = scenes()["cosine valley, 2 s"]
    exact = slip_on(valley, 1e-14, reference.METHODS[0])()
    for method in METHODS:
        programs[f"{method}, first slip, cosine valley"] = _reaching(exact, partial(slip_on, valley, method=method))
    for method in METHODS:
        for name, case in scenes().items():
            if method != reference.METHODS[0] and name == "superellipse on hill":
                continue  # this scene tests the search, which is the same for all methods
            programs[f"{method}, {name}"] = Program(integration(case, method))
            programs[f"simulate by {method}, {name}"] = Program(partial(simulate_new_case, case, method))
            programs[f"{method} with decisions and second contacts, {name}"] = Program(decision_program(case, method))
    return programs


def scenes() -> dict[str, cases.Case]:
    """The timed whole motions: the paper's disc with eight transitions, a general curve on which a theorem excludes
    second contacts, and one that requires a search for them."""
    valley = cases.Case(
        track=cosine(0.3, 2.0),
        plate=cases.disc(0.1, 1.0),
        effects=(cases.Gravity(9.81), cases.CoulombFriction(0.1), cases.Unilateral()),
        start=cases.Start(-1.0),
        duration=2.0,
    )
    return {
        "disc in circle, 5 s": cases.load("disc_in_circle", mu=0.2, duration=5.0),
        "cosine valley, 2 s": valley,
        "superellipse on hill": cases.load("superellipse_on_hill"),
    }


def _exact(mu: float) -> float:
    """The time (s) at which the slip of the paper's disc vanishes, by a quadrature with 20 digits."""
    return float(sliding_disc_in_circle("1", "0.1", str(mu), "9.81").time)


def _coarsest_program(mu: float, make: Callable[[float, float], Callable[[], float]]) -> Program:
    """`make(mu, tolerance)` at the coarsest power of ten that reaches the error."""
    return _reaching(_exact(mu), partial(make, mu))


def _reaching(exact: float, make: Callable[[float], Callable[[], float]]) -> Program:
    """`make(tolerance)` at the coarsest power of ten that reaches the error; at the finest if none does."""
    for digits in range(5, 15):
        run = make(10.0**-digits)
        error = run() - exact
        if abs(error) <= FIRST_SLIP_ERROR:
            break
    return Program(run, error)


def closed_form_by_heyoka(mu: float, tolerance: float) -> Callable[[], float]:
    """heyoka on (35) until v = 0, hand-written with compiled-in constants; returns the time."""
    import heyoka as hy

    R, r, g = 1.0, 0.1, 9.81
    L = R - r
    xi, u, theta, w = hy.make_vars("xi", "u", "theta", "w")
    normal = g * hy.sin(xi) + L * u * u
    equations = [
        (xi, u),
        (u, g / L * (hy.cos(xi) - mu * hy.sin(xi)) - mu * u * u),
        (theta, w),
        (w, -2 * mu / r * normal),
    ]
    event = hy.t_event(L * u + r * w, direction=hy.event_direction.negative)
    integrator = hy.taylor_adaptive(equations, [0.0] * 4, t_events=[event], tol=tolerance)

    def solve_once() -> float:
        integrator.time = 0.0
        integrator.state[:] = 0.0
        integrator.reset_cooldowns()
        integrator.propagate_until(2.5)
        return integrator.time

    return solve_once


def first_slip(mu: float, rtol: float, method: str) -> Callable[[], float]:
    """The general formulation until v = 0; returns the time."""
    return slip_on(cases.load("disc_in_circle", mu=mu), rtol, method)


def slip_on(case: cases.Case, rtol: float, method: str) -> Callable[[], float]:
    """A case's first phase, in which it slips forward; the program returns the time of its end."""
    _, integrate = solve.INTEGRATORS[method]
    now, start = phase(case, Regime(cases.Mode.SLIP_FORWARD)), start_state(case)
    return lambda: integrate(now, 0.0, start, case.duration, rtol).event.time


def whole_call(mu: float, rtol: float, method: str) -> Callable[[], float]:
    """The call of a user's loop over μ, with a duration just beyond the first transition; returns its time."""
    end = 1.01 * _exact(mu)
    number = count()

    def solve_once() -> float:
        # Each call has a different friction, so that only results independent of μ are cached between calls.
        other = mu * (1.0 + 1e-14 * next(number))
        case = cases.load("disc_in_circle", mu=other, duration=end)
        return reference.simulate(case, rtol=rtol, method=method).transitions[0].time

    return solve_once


def simulate_new_case(case: cases.Case, method: str) -> int:
    """The whole call for a newly made case; returns the number of transitions."""
    again = cases.Case(case.track, case.plate, case.effects, case.start, case.duration)
    return len(reference.simulate(again, rtol=RTOL, method=method).transitions)


def decision_program(case: cases.Case, method: str) -> Callable[[], int]:
    """All phases, decisions and the search for second contacts; returns the number of transitions."""
    regime = solve.first_regime(case, start_state(case))
    _, integrate = solve.INTEGRATORS[method]
    return lambda: len(solve.solve_motion(case, RTOL, integrate, regime)[1])


def integration(case: cases.Case, method: str) -> Callable[[], int]:
    """Only the integration of the same phases, each from its start; returns their number."""
    _, integrate = solve.INTEGRATORS[method]
    segments, _, _ = solve.solve_motion(case, RTOL, integrate)
    phase_starts = [(s.phase, s.start, s.states(np.array([s.start]))[:, 0].tolist()) for s in segments]
    return lambda: len([integrate(now, t, y, case.duration, RTOL) for now, t, y in phase_starts])
