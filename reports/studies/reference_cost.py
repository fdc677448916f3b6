"""What the reference costs, against heyoka on the paper's closed form in the same run, and from a cold start.

All contestants take turns at the one clock: ratios hold on a noisy machine, absolute times do not.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cases
import reference
from adapters import Setting
from cases import kept
from reference import solve
from reference.minimal.integrators import taylor
from reference.minimal.modes import Regime, phase, start_state
from reference.paper.closed_form import sliding_disc_in_circle

from ..analysis.tables import Table
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
    )
}
MU, RTOL = 0.2, 1e-9
# Wall seconds for all turns; a full study waits for better known medians.
BUDGET, FULL_BUDGET = 5.0, 30.0
CURVES = ("(s, -0.3 * cos(2 * s))", "(s + 0.1 * sin(s), -0.3 * cos(2 * s) + 0.05 * sin(3 * s))")
# Beyond its budget: derivations and compilations of all contestants.
_PATIENCE = 60.0


def contestants() -> dict[str, Callable[[], float | int]]:
    """What takes turns, by name; those named "first slip" return the time of the first transition, s."""
    found: dict[str, Callable[[], float | int]] = {"dop853, first slip": first_slip(MU, "dop853", RTOL)}
    if taylor.AVAILABLE:
        found["heyoka on (35), first slip"] = closed_form_by_heyoka(MU, RTOL)
        found["taylor, first slip"] = first_slip(MU, "taylor", RTOL)
    return found | {f"{method}, 5 s with all transitions": whole_motion(method, RTOL) for method in reference.METHODS}


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


def first_slip(mu: float, method: str, rtol: float) -> Callable[[], float]:
    """The general formulation until v = 0; returns the time."""
    case = cases.load("disc_in_circle", mu=mu)
    _, integrate = solve.INTEGRATORS[method]
    now, start = phase(case, Regime(cases.Mode.SLIP_FORWARD)), start_state(case)
    return lambda: integrate(now, 0.0, start, case.duration, rtol).event.time


def whole_motion(method: str, rtol: float) -> Callable[[], int]:
    """5 s of the disc with μ₀ = 0.2: all phases and decisions, without sampling; returns the number of transitions."""
    case = cases.load("disc_in_circle", mu=0.2, duration=5.0)
    start = start_state(case)
    regime = solve.first_regime(case, start)
    _, integrate = solve.INTEGRATORS[method]
    return lambda: len(solve.solved(case, regime, start, rtol, integrate)[1])


def timings(budget: float) -> dict[str, tuple[Timing, float]]:
    """Timing and error (s, NaN for whole motions) of every contestant, within about `budget` wall seconds."""
    exact = float(sliding_disc_in_circle("1", "0.1", str(MU), "9.81").time)
    case, programs = cases.load("disc_in_circle", mu=MU), contestants()
    entries = []
    for name, program in programs.items():
        who = Contestant(case, REFERENCE, name, Setting.of(rtol=RTOL), 1e-3)
        entries.append(Entry(who, lambda: None, lambda model, program=program: program()))  # type: ignore[misc]
    errors = {name: program() - exact if "first slip" in name else nan for name, program in programs.items()}
    loop = take_turns(entries, time.perf_counter() + budget)
    return {e.contestant.route: (timing(e, loop), errors[e.contestant.route]) for e in entries if e.repeats}


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
    """The one table."""
    return {"reference_cost": found}


def draw(found: list[dict[str, Any]], folder: Path) -> Iterator[Drawn]:
    """No picture: five numbers need none."""
    return iter(())
