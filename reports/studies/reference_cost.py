"""What the reference costs, against heyoka on the paper's closed form in the same run, and from a cold start.

All contestants take turns at the one clock: ratios hold on a noisy machine, absolute times do not.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from itertools import count
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import cases
import reference
from adapters import Setting
from cases import kept
from cases.library import cosine
from reference import solve
from reference.minimal.integrators import taylor
from reference.minimal.modes import Regime, phase, start_state
from reference.paper.closed_form import sliding_disc_in_circle

from ..analysis.columns import Table
from ..running.calls import Calls
from ..running.clock import UNTIMED, Contestant, Entry, Timing, take_turns, timing
from ..running.records import REFERENCE
from . import Request

if TYPE_CHECKING:
    from ..drawing.files import Drawn

TITLE = "What the reference costs"
QUESTION = (
    "The general formulation against a Taylor integrator on the paper's own closed form, and what a cold start takes."
)
TAKES = ()
IN_REPORT = False  # it says how the reference's own code fares, and nothing of engines
TABLES = {
    "reference_cost": Table(
        "CPU time of the reference and of heyoka on the paper's closed form, and cold starts",
        {
            "contestant": "what is solved by what, at which tolerance",
            "cpu_s": "CPU time, s: the median of the undisturbed repeats (of a cold start: wall time of one process)",
            "cpu_low_s": "where the median of another process is expected to begin, s",
            "cpu_high_s": "where it is expected to end, s",
            "ratio": "CPU time over the fastest contestant's",
            "repeats": "how many repeats the median is of",
            "disturbed": "whether the machine had other things to do",
            "error_s": "error of the first transition's time, s",
            "reason": "why there is no time",
        },
    ),
    "reference_cost_bars": Table(
        "What the reference may cost",
        {
            "contestant": "what is held to a bar",
            "beside": "what it is measured by",
            "limit": "the bar: at most so many times its CPU time",
            "ratio": "so many times it took",
            "outcome": "pass, fail, or not timed",
        },
    ),
}
# First slip phases are timed at the coarsest tolerance that reaches this error, s; whole motions at this tolerance.
ACHIEVED, RTOL = 1e-9, 1e-9
COEFFICIENTS = (0.01, 0.1, 0.2)
# Wall seconds for all turns; a full study waits for better known medians.
BUDGET, FULL_BUDGET = 5.0, 30.0


class Bar(NamedTuple):
    """A contestant may take at most `limit` times the CPU time of the one beside it."""

    contestant: str
    beside: str
    limit: float


BARS = (
    *(Bar(f"taylor, first slip, mu={mu}", f"heyoka on (35), first slip, mu={mu}", 2.5) for mu in COEFFICIENTS),
    *(
        Bar(f"simulate by taylor, first slip, new mu={mu}", f"heyoka on (35), first slip, mu={mu}", 60.0)
        for mu in COEFFICIENTS
    ),
    Bar("simulate by taylor, disc in circle, 5 s", "taylor, disc in circle, 5 s", 2.0),
    Bar("taylor with decisions and second contacts, cosine valley, 2 s", "taylor, cosine valley, 2 s", 4.0),
)
CURVES = ("(s, -0.3 * cos(2 * s))", "(s + 0.1 * sin(s), -0.3 * cos(2 * s) + 0.05 * sin(3 * s))")
# Beyond its budget: derivations and compilations of all contestants.
_PATIENCE = 60.0


class Program(NamedTuple):
    """What is timed, and its error at the first transition (s, NaN for whole motions)."""

    run: Callable[[], Any]
    error: float = nan


def contestants() -> dict[str, Program]:
    """All that take turns, by name. All are hot: compiled, and run again and again."""
    found: dict[str, Program] = {}
    for mu in COEFFICIENTS:
        if taylor.AVAILABLE:
            found[f"heyoka on (35), first slip, mu={mu}"] = _reached(mu, closed_form_by_heyoka)
        for method in reference.METHODS:
            found[f"{method}, first slip, mu={mu}"] = _reached(mu, partial(first_slip, method=method))
            found[f"simulate by {method}, first slip, new mu={mu}"] = _reached(mu, partial(whole_call, method=method))
    for method in reference.METHODS:
        for name, case in scenes().items():
            found[f"{method}, {name}"] = Program(integration(case, method))
            found[f"simulate by {method}, {name}"] = Program(partial(simulate_anew, case, method))
            found[f"{method} with decisions and second contacts, {name}"] = Program(decided(case, method))
    return found


def scenes() -> dict[str, cases.Case]:
    """The whole motions that are timed: the paper's disc with eight transitions, and a general curve."""
    valley = cases.Case(
        track=cosine(0.3, 2.0),
        plate=cases.disc(0.1, 1.0),
        effects=(cases.Gravity(9.81), cases.CoulombFriction(0.1), cases.Unilateral()),
        start=cases.Start(-1.0),
        duration=2.0,
    )
    return {"disc in circle, 5 s": cases.load("disc_in_circle", mu=0.2, duration=5.0), "cosine valley, 2 s": valley}


def _reached(mu: float, make: Callable[[float, float], Callable[[], float]]) -> Program:
    """`make(mu, tolerance)` at the coarsest power of ten that reaches the error; at the finest where none does."""
    exact = float(sliding_disc_in_circle("1", "0.1", str(mu), "9.81").time)
    for digits in range(5, 15):
        run = make(mu, 10.0**-digits)
        error = run() - exact
        if abs(error) <= ACHIEVED:
            break
    return Program(run, error)


def closed_form_by_heyoka(mu: float, tolerance: float) -> Callable[[], float]:
    """heyoka on (35) until v = 0, written by hand with its numbers compiled in; returns the time."""
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

    def run() -> float:
        integrator.time = 0.0
        integrator.state[:] = 0.0
        integrator.reset_cooldowns()
        integrator.propagate_until(2.5)
        return integrator.time

    return run


def first_slip(mu: float, rtol: float, method: str) -> Callable[[], float]:
    """The general formulation until v = 0; returns the time."""
    case = cases.load("disc_in_circle", mu=mu)
    _, integrate = solve.INTEGRATORS[method]
    now, start = phase(case, Regime(cases.Mode.SLIP_FORWARD)), start_state(case)
    return lambda: integrate(now, 0.0, start, case.duration, rtol).event.time


def whole_call(mu: float, rtol: float, method: str) -> Callable[[], float]:
    """What a user calls in a loop over μ, ended just after the first transition; returns its time."""
    end = 1.01 * float(sliding_disc_in_circle("1", "0.1", str(mu), "9.81").time)
    number = count()

    def run() -> float:
        # Each call has a friction of its own, so that nothing is kept of the call before but what μ does not change.
        other = mu * (1.0 + 1e-14 * next(number))
        case = cases.load("disc_in_circle", mu=other, duration=end)
        return reference.simulate(case, rtol=rtol, method=method).transitions[0].time

    return run


def simulate_anew(case: cases.Case, method: str) -> int:
    """The whole call for a case that is made anew; returns the number of transitions."""
    again = cases.Case(case.track, case.plate, case.effects, case.start, case.duration)
    return len(reference.simulate(again, rtol=RTOL, method=method).transitions)


def decided(case: cases.Case, method: str) -> Callable[[], int]:
    """All phases, decisions and the search for second contacts; returns the number of transitions."""
    start = start_state(case)
    regime = solve.first_regime(case, start)
    _, integrate = solve.INTEGRATORS[method]
    return lambda: len(solve.solved(case, regime, start, RTOL, integrate)[1])


def integration(case: cases.Case, method: str) -> Callable[[], int]:
    """The same phases, each integrated from its start, and nothing else; returns their number."""
    start = start_state(case)
    _, integrate = solve.INTEGRATORS[method]
    segments, _, _ = solve.solved(case, solve.first_regime(case, start), start, RTOL, integrate)
    begun = [(s.phase, s.start, s.states(np.array([s.start]))[:, 0].tolist()) for s in segments]
    return lambda: len([integrate(now, t, y, case.duration, RTOL) for now, t, y in begun])


def timings(budget: float) -> dict[str, tuple[Timing, float]]:
    """Timing and error (s, NaN for whole motions) of every contestant, within about `budget` wall seconds."""
    entries, programs = [], contestants()
    for name, program in programs.items():
        # The case only labels the turn.
        who = Contestant(cases.load("disc_in_circle"), REFERENCE, name, Setting.of(rtol=RTOL), 1e-3)
        entries.append(Entry(who, lambda: None, lambda model, run=program.run: run()))  # type: ignore[misc]
    loop = take_turns(entries, time.perf_counter() + budget)
    return {e.contestant.route: (timing(e, loop), programs[e.contestant.route].error) for e in entries if e.repeats}


def cold_start(curve: str) -> float:
    """Wall seconds of a new process that imports, derives, compiles and solves a case with that track."""
    program = (
        "import cases, reference\n"
        "from cases import *\n"
        "from cases.curves import cos, sin\n"
        f"track = Curve(lambda s: {curve}, domain=(-3, 3))\n"
        "effects = (Gravity(9.81), CoulombFriction(0.1), Unilateral())\n"
        "reference.simulate(Case(track, disc(0.1, 1.0), effects, Start(-1.0), 1.0))\n"
    )
    began = time.perf_counter()
    with kept.off():
        subprocess.run([sys.executable, "-c", program], check=True)
    return time.perf_counter() - began


def run(request: Request, calls: Calls) -> list[dict[str, Any]]:
    """The rows, the fastest contestant's ratio being one."""
    budget = FULL_BUDGET if request.full else BUDGET
    with calls.alone() as alone:
        (answer,) = alone.all("timings", timings, [(budget,)], limit=budget + _PATIENCE)
        cold = alone.all("cold starts", cold_start, [(curve,) for curve in CURVES])
    if answer.outcome == "done":
        fastest = min(t.cpu_s for t, _ in answer.value.values())
        found = [_row(name, t, t.cpu_s / fastest, error) for name, (t, error) in answer.value.items()]
    else:
        found = [_row("all", UNTIMED, reason=answer.failure[1])]
    for curve, start in zip(CURVES, cold, strict=True):
        done = start.outcome == "done"
        row = _row(f"cold start of {curve}", UNTIMED, reason="" if done else start.failure[1])
        found.append(row | {"cpu_s": start.value if done else nan})
    return found


def _row(name: str, t: Timing, ratio: float = nan, error: float = nan, reason: str = "") -> dict[str, Any]:
    times = {"cpu_s": t.cpu_s, "cpu_low_s": t.cpu_low_s, "cpu_high_s": t.cpu_high_s}
    counts = {"repeats": t.repeats, "disturbed": t.disturbed}
    return {"contestant": name, **times, "ratio": ratio, **counts, "error_s": error, "reason": reason}


def rows(found: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """What everything took, and the bars."""
    return {"reference_cost": found, "reference_cost_bars": bars(found)}


def bars(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Each bar with its ratio; "not timed" where one of the two has no time."""
    took = {row["contestant"]: row["cpu_s"] for row in found}
    told = []
    for bar in BARS:
        ratio = took.get(bar.contestant, nan) / took.get(bar.beside, nan)
        outcome = "not timed" if isnan(ratio) else "pass" if ratio <= bar.limit else "fail"
        told.append({**bar._asdict(), "ratio": ratio, "outcome": outcome})
    return told


def draw(found: list[dict[str, Any]], folder: Path) -> Iterator[Drawn]:
    """No picture: five numbers need none."""
    return iter(())
