"""The witnesses: independent solutions of a case that certify each other, and their sensitivity to rounding.

All witnesses start from the same rounded state, so their differences do not show the effect of that rounding.
`perturb` shows it: it repeats the motion with one component of the state moved by some roundings at the beginning of
each phase, where the state is stored in doubles.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, NotSupported, Trajectory, Transition
from cases.moving_frame import in_fixed_frame, relative_case

from .. import solve
from ..minimal.integrators import taylor
from ..minimal.modes import Phase
from ..time_limit import OutOfTime, cpu_limit

QUANTITIES = ("x", "y", "theta", "slip", "omega")
FREE = ("x", "y", "theta", "omega")
EPS = float(np.finfo(float).eps)

SECOND = "contact frame"
# The witness with the fewest steps is the first of these that is available.
QUICKEST = ("taylor 1e-10", "dop853 1e-13")
# The status of a motion that reached the limit on work.
IN_PROGRESS = "unfinished"
# The tolerance at which each method's error reaches rounding: steps of the Taylor method have a hundredth of it.
FINEST = {"taylor": 1e-12, "dop853": 1e-13}

# The second formulation, which predicts the sequence, the status and the times.
PREDICTION = f"{SECOND} 1e-13"
# CPU seconds of one witness.
MOST_S = 100


class Witness(NamedTuple):
    """One solution: its transitions, status and end of the motion; of the first formulation also the motion."""

    name: str
    transitions: Sequence[Transition]
    status: str
    end: float
    motion: Trajectory | None = None

    def states(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """States of the motion at any times, by quantity, with the contact's parameters."""
        assert self.motion is not None
        return states_of(self.motion, np.minimum(times, self.motion.t[-1]))

    @property
    def events(self):
        """Status and modes of all transitions, without times."""
        return self.status, [(t.contact, t.before, t.after) for t in self.transitions]

    @property
    def answer(self) -> str:
        """Transitions and status in words."""
        parts = [f"{t.after} at {t.time:.9g} s" for t in self.transitions]
        if len(parts) > 4:
            parts = [*parts[:4], f"… ({len(self.transitions)} transitions in all)"]
        return ", ".join([*parts, f"{self.status} at {self.end:.9g} s"])


def witnesses(case: Case) -> tuple[list[Witness], list[str]]:
    """All witnesses of a case, the most precise first, and a sentence for each that cannot run or does not reach the
    end of the motion. If the fastest one, with the fewest steps, does not reach it, no other witness is run.

    Raises FloatingPointError if the second formulation starts and cannot continue.
    """
    able: dict[str, Witness] = {}
    missing: dict[str, str] = {}
    ways = _ways()
    quickest = next(name for name in QUICKEST if name in ways)
    for name in sorted(ways, key=lambda name: name != quickest):
        method, rtol = ways[name]
        try:
            with cpu_limit(MOST_S):
                one = _by_second(case, name, rtol) if method == SECOND else _by_first(case, name, method, rtol)
        except OutOfTime:
            missing[name] = f"{name} takes more than {MOST_S} s of CPU time"
            continue
        except NotSupported as problem:
            missing[name] = f"{name} cannot run: {problem}"
            continue
        if one.status != IN_PROGRESS:
            able[name] = one
            continue
        missing[name] = f"{name} reached its limit on steps at {one.end:.9g} s"
        if name == quickest:
            break
    return [able[name] for name in ways if name in able], [missing[name] for name in ways if name in missing]


def _ways() -> dict[str, tuple[str, float]]:
    """Names of the witnesses, with method and relative tolerance."""
    best = {
        "taylor, quadruple precision": ("taylor_quadruple", 1e-14),
        "taylor 1e-12": ("taylor", 1e-12),
        "taylor 1e-10": ("taylor", 1e-10),
    }
    return (best if taylor.AVAILABLE else {}) | {
        "dop853 1e-13": ("dop853", 1e-13),
        PREDICTION: (SECOND, 1e-13),
    }


def _by_first(case: Case, name: str, method: str, rtol: float) -> Witness:
    return _witness(name, solve.simulate(case, rtol=rtol, method=method))


def _witness(name: str, motion: Trajectory) -> Witness:
    return Witness(name, motion.transitions, motion.status, float(motion.t[-1]), motion)


def quantities(case: Case) -> tuple[str, ...]:
    """The quantities that a certificate has: those of the case's plate, and poses and spins of free plates."""
    return (*QUANTITIES, *(f"{q} of {other.name}" for other in case.others for q in FREE))


def states_of(motion: Trajectory, times: np.ndarray) -> dict[str, np.ndarray]:
    """The states of a motion by quantity, with the contact's parameters."""
    state = motion(times)
    values = {q: np.asarray(getattr(state, q)) for q in (*QUANTITIES, "xi1", "xi2")}
    for name in motion.plate_names[1:]:
        free = motion.plate(name)(times)
        values |= {f"{q} of {name}": np.asarray(getattr(free, q)) for q in FREE}
    return values


def _by_second(case: Case, name: str, rtol: float) -> Witness:
    from ..witness import predict  # SciPy's integrators are slow to import, and stored truth needs no witness

    answer = predict(case, rtol)
    return Witness(name, answer.transitions, answer.status, answer.end)


# --- the same motion from a perturbed state ---------------------------------------------------------------------------


def components(case: Case) -> int:
    """The largest number of state components in any phase of the case's motion."""
    segments, *_ = solve.solve_motion(relative_case(case), 1e-10, solve.INTEGRATORS["dop853"][1])
    return max((len(segment.event.state) for segment in segments), default=0)


def perturb(case: Case, component: int, roundings: float, method: str) -> Witness:
    """The motion with one component of the state moved by some roundings at the beginning of each phase; with 0
    roundings, the motion to compare it with."""
    rtol = FINEST[method]
    _, integrate = solve.INTEGRATORS[method]

    def integrate_perturbation(now: Phase, t: float, y, end: float, tolerance: float):
        return integrate(now, t, _shift(now, y, component, roundings), end, tolerance)

    relative = relative_case(case)
    motion = solve.as_trajectory(relative, *solve.solve_motion(relative, rtol, integrate_perturbation, None, case))
    motion = motion if relative is case else in_fixed_frame(case, motion)
    return _witness(f"component {component} moved by {roundings:g} roundings", motion)


def _shift(now: Phase, y: Sequence[float], component: int, roundings: float) -> tuple[float, ...]:
    """The state with one component moved by some roundings of its own size.

    A position is a difference of places that are at least as large as the plate. A speed is a difference of speeds, so
    its rounding is that of the largest of them.
    """
    if component >= len(y):
        return tuple(y)
    positions = now.system.positions
    if component < positions:
        size = max(abs(y[component]), now.lengths[component])
    else:
        speeds, lengths = y[positions:], now.lengths
        fastest = max(abs(u) / length for u, length in zip(speeds, lengths, strict=False))
        size = fastest * lengths[component - positions]
    return (*y[:component], y[component] + roundings * EPS * size, *y[component + 1 :])
