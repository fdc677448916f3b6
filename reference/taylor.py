"""One phase by heyoka's Taylor method with its own event detection (Biscani & Izzo 2021, MNRAS 504, 2614).

Optional: where heyoka is not installed, `AVAILABLE` is False and DOP853 does everything.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .arc import Arc, Stop
from .eliminated import System, T
from .modes import Phase

try:
    import heyoka as hy
except ImportError:
    AVAILABLE = False
else:
    AVAILABLE = True

# Step-size tolerances are rounded to whole powers of ten: one compiled integrator each.
FINEST = 1e-16


def _expressions(system: System) -> dict:
    """SymPy symbols of the system as heyoka's variables, parameters and time."""
    known = {v: hy.expression(v.name) for v in system.variables}
    return known | {p: hy.par[i] for i, p in enumerate(system.parameters)} | {T: hy.time}


@lru_cache(maxsize=128)
def compiled(system: System, tolerance: float, real: type = float):
    """The compiled integrator of a system, with one terminal event for each guard."""
    known = _expressions(system)
    equations = [(known[v], hy.from_sympy(rate, known)) for v, rate in zip(system.variables, system.rates, strict=True)]
    falling = hy.event_direction.negative
    events = [hy.t_event(hy.from_sympy(g, known), direction=falling, fp_type=real) for g in system.guards.values()]
    return hy.taylor_adaptive(
        equations, [real(0.0)] * len(equations), t_events=events, tol=real(tolerance), fp_type=real, compact_mode=False
    )


def prepare(phase: Phase, rtol: float = 1e-10) -> None:
    """Compile the phase's equations for that tolerance."""
    compiled(phase.system, _tolerance(rtol))


def _tolerance(rtol: float) -> float:
    return max(FINEST, 10.0 ** np.floor(np.log10(rtol) + 1e-9))


def integrate(phase: Phase, t: float, y, end: float, rtol: float) -> Arc:
    """Integrate from (t, y) until a guard reaches zero or `end`; raises FloatingPointError if it stops."""
    integrator = compiled(phase.system, _tolerance(rtol))
    integrator.time = t
    integrator.state[:] = y
    integrator.pars[:] = phase.parameters[: len(integrator.pars)]
    integrator.reset_cooldowns()
    names = list(phase.system.guards)
    outputs, steps = [], 0
    while True:
        outcome, _, _, taken, output, _ = integrator.propagate_until(end, c_output=True)
        steps += taken
        if output is not None:
            outputs.append(output)
        if outcome == hy.taylor_outcome.time_limit:
            guard = None
            break
        if int(outcome) >= 0 or int(outcome) < -len(names):
            raise FloatingPointError(f"the Taylor integrator stopped at t = {integrator.time:.9g} s: {outcome}")
        # A phase begins with a guard at zero that the decision found to grow; heyoka fires there at once, and its
        # own cool-down keeps the same root from firing twice.
        if integrator.time > t:
            guard = names[-int(outcome) - 1]
            break
    stop = Stop(guard, float(integrator.time), tuple(integrator.state.tolist()))
    return Arc(phase, _step_times(t, outputs), _dense(outputs, y), stop, steps)


def _step_times(t: float, outputs) -> np.ndarray:
    return np.array(outputs[-1].times) if outputs else np.array([t])


def _dense(outputs, y):
    def states(times: np.ndarray) -> np.ndarray:
        if not outputs:
            return np.repeat(np.array(y, dtype=float)[:, None], len(times), axis=1)
        return np.array(outputs[-1](times)).T

    return states
