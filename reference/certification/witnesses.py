"""The witnesses: independent solutions of a case that certify each other, and their sensitivity to rounding.

All witnesses start from the same rounded state, so their differences do not show the effect of that rounding.
`perturb` shows it: it repeats the motion with one component of the state moved by some roundings at the beginning of
each phase, where the state is stored in doubles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cases import Case, Flight, Mode, NotSupported, Trajectory, Transition
from cases.contact import start_motion
from cases.motion.trajectory import CONTACT
from cases.moving_frame import in_fixed_frame, relative_case
from cases.scene.contact_limits import limitation, touches_by_features
from cases.scene.free_plates import names_of
from cases.scene.limits import Scope, limit

from .. import solve
from ..minimal.integrators import taylor
from ..minimal.modes import FLIGHT, Phase, candidates, phase_at, start_pieces, start_state
from ..time_limit import OutOfTime, cpu_limit

QUANTITIES = ("x", "y", "theta", "slip", "omega")
FREE = ("x", "y", "theta", "omega")
EPS = float(np.finfo(float).eps)

# Least number of steps of the second formulation: with 300 its errors are 1e-14, with the default 60 up to 1e-11.
STEPS_PER_TURN = 300
SECOND = "contact frame"
# The witness with the fewest steps is the first of these that is available.
QUICKEST = ("taylor 1e-10", "dop853 1e-13")
# The status of a motion that reached the limit on work.
IN_PROGRESS = "unfinished"
# The tolerance at which each method's error reaches rounding: steps of the Taylor method have a hundredth of it.
FINEST = {"taylor": 1e-12, "dop853": 1e-13}


# CPU seconds of one witness.
MOST_S = 100


class Witness(NamedTuple):
    """One solution: its transitions, status, end of the motion, and states at any times, by quantity (those of the
    first formulation include the contact's parameters); `motion`: that of the first formulation."""

    name: str
    transitions: Sequence[Transition]
    status: str
    end: float
    states: Callable[[np.ndarray], dict[str, np.ndarray]]
    motion: Trajectory | None = None

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
        "contact frame 1e-13": (SECOND, 1e-13),
    }


def _by_first(case: Case, name: str, method: str, rtol: float) -> Witness:
    return _witness(name, solve.simulate(case, rtol=rtol, method=method))


def _witness(name: str, motion: Trajectory) -> Witness:
    def states(times):
        return states_of(motion, np.minimum(times, motion.t[-1]))

    return Witness(name, motion.transitions, motion.status, float(motion.t[-1]), states, motion)


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
    from .. import (
        contact_frame,
        delassus,
    )  # SciPy's integrators and trees are slow to import, and stored truth needs no witness

    if case.others:
        return _plates_witness(case, name, rtol)
    if touches_by_features(case):
        return _supports_witness(case, name, rtol)
    if not limitation(case) and delassus.touches_at_start(case):
        return _from_touches(case, name, rtol)
    answer = contact_frame.solve(case, rtol=rtol, steps_per_turn=STEPS_PER_TURN, overlaps=True)
    if answer.status == contact_frame.STOPS["elsewhere"] and not limitation(case):
        return _by_delassus(case, name, rtol, answer)

    def states(times):
        # Beyond a second contact the equations may be singular; if there was none, the search is not repeated.
        again = answer.status == contact_frame.STOPS["elsewhere"]
        motions = contact_frame.solve(
            case, rtol=rtol, times=times, steps_per_turn=STEPS_PER_TURN, overlaps=again
        ).motions
        return {q: motions[contact_frame.MOTION.index(q)] for q in QUANTITIES}

    return Witness(name, answer.transitions, answer.status, answer.end, states)


def _from_touches(case: Case, name: str, rtol: float) -> Witness:
    """The second formulation of a plate that touches its track in several places in its start."""
    from .. import delassus

    begin = start_motion(case)
    body = np.array([begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega])
    mode = delassus.mode_of(case, begin.slip, begin.omega)
    witness = _several_witness(case, name, rtol, (), (0.0, body, (begin.xi1, begin.xi2), mode))
    if _has_several_contacts(case):
        return witness
    # The other contacts open at once, and a contact that is the only one has no name.
    unnamed = (replace(event, contact="") if event.contact == CONTACT else event for event in witness.transitions)
    return witness._replace(transitions=tuple(unnamed))


def _by_delassus(case: Case, name: str, rtol: float, first) -> Witness:
    """The second formulation with the motion after a second contact."""
    from .. import contact_frame, delassus

    end = first.end
    # Where impacts come to rest at the end, a run that is asked for states before it simulates more of them, and may
    # end by roundings earlier.
    ends = [end, _just_before(end)]
    last = contact_frame.solve(case, rtol=rtol, times=ends, steps_per_turn=STEPS_PER_TURN, until=end)
    column = int(np.isnan(last.motions[0, 0]))
    states, motions = last.states[:, column], last.motions[:6, column]
    before = tuple(replace(event, contact=CONTACT) for event in first.transitions)
    slip, omega = float(states[3]), float(states[2])
    mode = before[-1].after if before else delassus.mode_of(case, slip, omega)
    place = float(states[0]), float(states[1])
    own = None if np.isnan(place[0]) else place  # in flight
    mode = Mode.FLIGHT if own is None else mode
    return _several_witness(case, name, rtol, before, (end, motions, own, mode))


def _supports_witness(case: Case, name: str, rtol: float) -> Witness:
    """The second formulation of a case whose contacts are pairs of a support and a feature. Raises NotSupported for
    effects that it does not have."""
    if reason := limit(case, Scope.EFFECTS):
        raise NotSupported(reason)
    from .. import contact_frame, delassus

    answer = delassus.from_start(case, rtol)

    def states(times):
        motions = delassus.from_start(case, rtol, np.asarray(times, dtype=float)).motions
        return {q: motions[contact_frame.MOTION.index(q)] for q in QUANTITIES}

    return Witness(name, answer.transitions, answer.status, answer.end, states)


def _plates_witness(case: Case, name: str, rtol: float) -> Witness:
    """The second formulation of several plates."""
    from .. import delassus

    answer = delassus.bodies_motion(case, rtol)

    def states(times):
        *rows, slip = delassus.bodies_motion(case, rtol, np.asarray(times, dtype=float)).motions
        half, values = len(rows) // 2, {"slip": slip}
        for b, name in enumerate(names_of(case)):
            own = (*rows[3 * b : 3 * b + 3], rows[half + 3 * b + 2])
            values |= {q if b == 0 else f"{q} of {name}": row for q, row in zip(FREE, own, strict=True)}
        return values

    return Witness(name, answer.transitions, answer.status, answer.end, states)


def _several_witness(case: Case, name: str, rtol: float, before: tuple[Transition, ...], state) -> Witness:
    """The second formulation from `state` on: time, (x, y, θ, vx, vy, ω), pair of points and mode of the contact."""
    from .. import contact_frame, delassus

    end, body, own, mode = state

    def go_on(times: Sequence[float]) -> delassus.SeveralMotion:
        return delassus.continue_motion(case, end, body, own, mode, rtol, times)

    answer = go_on(())

    def states(times):
        times = np.asarray(times, dtype=float)
        if answer.end <= end:  # an impact whose outcome is not unique: there are states before it only
            times = np.minimum(times, _just_before(end))
        motions, is_before = go_on(times).motions, times < end
        if is_before.any():
            early = contact_frame.solve(
                case, rtol=rtol, times=times[is_before], steps_per_turn=STEPS_PER_TURN, until=end
            )
            motions[:, is_before] = early.motions
        return {q: motions[contact_frame.MOTION.index(q)] for q in QUANTITIES}

    return Witness(name, (*before, *answer.transitions), answer.status, answer.end, states)


def _just_before(end: float) -> float:
    """A time (s) that a motion reaches which ends at `end` in another run: runs differ by roundings."""
    return end - 64 * EPS * max(end, 1.0)


# --- the same motion from a perturbed state ---------------------------------------------------------------------------


def components(case: Case) -> int:
    """The largest number of state components in any phase of the case."""
    if case.others or touches_by_features(case):
        segments, *_ = solve.solve_motion(relative_case(case), 1e-10, solve.INTEGRATORS["dop853"][1])
        return max(len(segment.event.state) for segment in segments)
    case = relative_case(case)
    regimes = (*candidates(case), *((FLIGHT,) if case.effect(Flight) is not None else ()))
    here, start = start_pieces(case), start_state(case)
    return max(len(phase_at(here, regime, start).system.variables) for regime in regimes)


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


@lru_cache(maxsize=64)
def _has_several_contacts(case: Case) -> bool:
    """Whether a motion goes on after a second contact."""
    try:
        motion = solve.simulate(case)
    except NotSupported:  # by the default method of this machine
        motion = solve.simulate(case, method="dop853")
    return len(motion.contact_names) > 1


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
