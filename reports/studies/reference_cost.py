"""`python -m reports.bench`: what the reference costs, against heyoka on the paper's closed form in the same run.

CPU time of the run alone, contestants interleaved, medians of many repeats: ratios hold on a noisy machine, absolute
times do not.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import cases
import reference
from reference import solve, taylor
from reference.closed_form import sliding_disc_in_circle
from reference.modes import Regime, phase, start_state

REPEATS = 60


def interleaved(contestants: dict[str, Callable[[], object]], repeats: int = REPEATS) -> dict[str, list[float]]:
    """CPU seconds of each contestant, run in turn so that the machine's drift hits all alike."""
    seconds: dict[str, list[float]] = {name: [] for name in contestants}
    for run in contestants.values():
        run()
    for _ in range(repeats):
        for name, run in contestants.items():
            began = time.process_time()
            run()
            seconds[name].append(time.process_time() - began)
    return seconds


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
    return lambda: integrate(now, 0.0, start, case.duration, rtol).stop.time


def whole_motion(method: str, rtol: float) -> Callable[[], int]:
    """5 s of the disc with μ₀ = 0.2: all phases and decisions, without sampling; returns the number of transitions."""
    case = cases.load("disc_in_circle", mu=0.2, duration=5.0)
    start = start_state(case)
    regime = solve.first_regime(case, start)
    _, integrate = solve.INTEGRATORS[method]
    return lambda: len(solve.run(case, regime, start, rtol, integrate)[1])


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
    subprocess.run([sys.executable, "-c", program], check=True)
    return time.perf_counter() - began


def main() -> None:
    """Print the table."""
    mu = 0.2
    exact = float(sliding_disc_in_circle("1", "0.1", str(mu), "9.81").time)
    contestants: dict[str, Callable[[], object]] = {"scipy, first slip, 1e-9": first_slip(mu, "dop853", 1e-9)}
    errors = {"scipy, first slip, 1e-9": first_slip(mu, "dop853", 1e-9)() - exact}
    if taylor.AVAILABLE:
        for name, run in {
            "heyoka on (35), first slip, 1e-9": closed_form_by_heyoka(mu, 1e-9),
            "taylor, first slip, 1e-9": first_slip(mu, "taylor", 1e-9),
        }.items():
            contestants[name], errors[name] = run, run() - exact
    for method in reference.METHODS:
        contestants[f"{method}, 5 s with all transitions, 1e-9"] = whole_motion(method, 1e-9)
    seconds = interleaved(contestants)
    fastest = min(statistics.median(times) for times in seconds.values())
    print(f"{'contestant':44s} {'median':>10s} {'spread':>10s} {'ratio':>8s} {'error of t':>11s}")
    for name, times in seconds.items():
        low, middle, high = statistics.quantiles(times, n=4)
        error = f"{errors[name]:+.1e}" if name in errors else ""
        print(f"{name:44s} {middle * 1e6:7.1f} µs {(high - low) * 1e6:7.1f} µs {middle / fastest:8.1f} {error:>11s}")
    for curve in ("(s, -0.3 * cos(2 * s))", "(s + 0.1 * sin(s), -0.3 * cos(2 * s) + 0.05 * sin(3 * s))"):
        print(f"cold start of y(s) = {curve}: {cold_start(curve):.2f} s")


if __name__ == "__main__":
    main()
