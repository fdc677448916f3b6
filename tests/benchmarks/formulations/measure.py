"""Integration of the paper's ten coordinates (plain, with Baumgarte's terms, projected) and of the independent ones.

The formulations solve the same matrix (27) with the same integrator (SciPy's DOP853), so they differ only in the
integrated coordinates: X₀, Y₀, θ, ξ₁, ξ₂ and their rates, of which (5), (6), (8), (9) leave only (ξ₁, ξ₂, ξ̇₁, ξ̇₂) free.
The last formulation has (27) eliminated by hand, as in the reference. Cost is the number of evaluations of (27); CPU
seconds are of one run on this machine, possibly with other load.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import lru_cache
from math import nan, pi
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import DOP853

import reference
from cases import Case, CoulombFriction, Curve, Gravity, Mode, Plate, Start, Trajectory, Unilateral
from cases.contact import pose, start_motion
from cases.curves import cos, sin
from cases.library import ellipse
from reference.minimal.integrators.dop853 import prepare
from reference.minimal.modes import Regime, phase
from reference.paper.augmented import assemble, constraints, solve_full_system
from reference.paper.kinematics import Kinematics, U, kinematics
from reports.running.calls import Calls, StorePolicy

FORMULATIONS = (
    "ten coordinates",
    "ten with Baumgarte",
    "ten with projection",
    "independent coordinates",
    "independent, eliminated",
)
TOLERANCES = (1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
# Baumgarte's α = β in 1/s: gaps then decay within a few hundredths of a second, ten times faster than these scenes
# move. (Baumgarte 1972, Comput. Methods Appl. Mech. Eng. 1, 1, reference looked up; there is no general rule for
# choosing them.)
BAUMGARTE = 50.0
# Newton corrections of a position whose error is less than that of one step: after two only rounding remains.
_CORRECTIONS = 2


class Integration(NamedTuple):
    """A run: times, the ten coordinates at the steps' ends (10, n), evaluations of (27), CPU seconds."""

    t: np.ndarray
    ten: np.ndarray
    evaluations: int
    cpu_s: float


# --- the scenes -------------------------------------------------------------------------------------------------------


# An unbalanced ellipse in an ellipse: slipping with friction until its first transition, and sliding for 5 s.
SCENES = ("slipping, to the first transition", "sliding, 5 s")


@lru_cache
def scene(name: str) -> tuple[Case, Mode, Trajectory]:
    """A scene of `SCENES`, the one mode it stays in, and its true motion."""
    if name == SCENES[0]:
        rough = _ellipse_in_ellipse(CoulombFriction(0.03), slip=3.0, duration=2.0)
        first = reference.simulate(rough, rtol=1e-12).transitions[0].time
        case, mode = _ellipse_in_ellipse(CoulombFriction(0.03), slip=3.0, duration=first), Mode.SLIP_FORWARD
    else:
        case, mode = _ellipse_in_ellipse(None, slip=0.0, duration=5.0), Mode.SLIDE
    return case, mode, reference.simulate(case, rtol=1e-13)


def _ellipse_in_ellipse(friction: CoulombFriction | None, slip: float, duration: float) -> Case:
    outline = Curve(lambda s: (0.25 * cos(s) + 0.03, 0.2 * sin(s)))
    plate = Plate(outline, 1.0, (0.25**2 + 0.2**2) / 4)
    effects = (Gravity(9.81), *((friction,) if friction else ()), Unilateral())
    return Case(ellipse(1.2, 1.0), plate, effects, Start(-pi / 2 + 0.5, 0.3, slip=slip, omega=-1.0), duration)


# --- the formulations -------------------------------------------------------------------------------------------------


def solve(case: Case, mode: Mode, formulation: str, rtol: float) -> Integration:
    """The case in one mode from start to end by one of `FORMULATIONS`; raises FloatingPointError if it breaks down."""
    if formulation.endswith("eliminated"):
        prepare(phase(case, Regime(mode)))  # derivations count as set-up, like the building of an engine's model
    began = time.process_time()
    if formulation.startswith("independent"):
        t, states, evaluations = _independent(case, mode, rtol, formulation.endswith("eliminated"))
        return Integration(t, _complete(case, states), evaluations, time.process_time() - began)
    stabilise = BAUMGARTE if formulation == "ten with Baumgarte" else 0.0

    def rates(t, y):
        return np.concatenate([y[5:], _accelerations(case, mode, t, y, stabilise)])

    correct = _project if formulation == "ten with projection" else None
    t, states, evaluations = _march(rates, _start(case), case, rtol, correct)
    return Integration(t, states, evaluations, time.process_time() - began)


def _independent(case: Case, mode: Mode, rtol: float, with_elimination: bool):
    start, now = start_motion(case), phase(case, Regime(mode))

    def literal(t, y):
        return np.concatenate([y[2:], solve_full_system(case, mode, y.tolist(), time=t).q2_ddot])

    def short(t, y):
        return now.system.rates_of_numbers(t, y.tolist(), now.parameters)

    return _march(
        short if with_elimination else literal,
        np.array([start.xi1, start.xi2, start.xi1_dot, start.xi2_dot]),
        case,
        rtol,
        None,
    )


def _march(rates: Callable, y: np.ndarray, case: Case, rtol: float, correct: Callable | None):
    """Integrate with DOP853 to the end of the case; `correct`, if not None, is applied after each step."""
    # All lengths and angles are of order one here, so one absolute tolerance suffices.
    solver = DOP853(rates, 0.0, y, case.duration, rtol=rtol, atol=rtol)
    t, states = [0.0], [y]
    while solver.status == "running":
        solver.step()
        if solver.status == "failed":
            raise FloatingPointError(f"no step is small enough at t = {solver.t:.6g} s")
        if correct:
            solver.y = correct(case, solver.y)
            solver.f = solver.fun(solver.t, solver.y)
        t.append(solver.t)
        states.append(solver.y)
    return np.array(t), np.array(states).T, solver.nfev


def _start(case: Case) -> np.ndarray:
    s = start_motion(case)
    return np.array([s.x, s.y, s.theta, s.xi1, s.xi2, s.vx, s.vy, s.omega, s.xi1_dot, s.xi2_dot])


def _complete(case: Case, states: np.ndarray) -> np.ndarray:
    """The ten coordinates computed from the independent ones by (5), (6), (8), (9)."""
    x, y, theta = pose(case, states[0], states[1])
    rest = [plate_rates(case, state) for state in states.T]
    return np.vstack([x, y, theta, states[:2], np.array(rest).T, states[2:]])


def plate_rates(case: Case, state: np.ndarray) -> np.ndarray:
    """(Ẋ₀, Ẏ₀, θ̇) of a state (ξ₁, ξ₂, ξ̇₁, ξ̇₂)."""
    k = kinematics(case, *state)
    return np.array([*k.R0_dot, k.theta_dot])


def kinematics_of_ten(case: Case, y: np.ndarray) -> Kinematics:
    """(1)–(4) with the integrated pose and rates, even if they violate the contact constraints."""
    R, Rp, Rs, Rt = np.array(case.track.jet(y[3])).reshape(4, 2)
    r, rp, rs, rt = np.array(case.plate.outline.jet(y[4])).reshape(4, 2)
    c, s = np.cos(y[2]), np.sin(y[2])
    turn = np.array([[c, -s], [s, c]])
    return Kinematics(y[3:5], y[8:], R, Rp, Rs, Rt, r, rp, rs, rt, y[2], turn, y[:2], y[7], y[5:7])


def contact_residual(k: Kinematics) -> np.ndarray:
    """(5) and (6): the gap vector (m) and R_pᵀ U θ r_p, which both vanish in contact."""
    return np.array([*(k.R0 + k.turn @ k.r - k.R), k.Rp @ U @ k.turn @ k.rp])


def _accelerations(case: Case, mode: Mode, t: float, y: np.ndarray, stabilise: float) -> np.ndarray:
    """(27) with the ten coordinates; Baumgarte's terms −2α φ̇ − α² φ are added to C if `stabilise` (α) is not 0."""
    system = assemble(case, mode, kinematics_of_ten(case, y), (t, *y[:3], *y[5:8]))
    matrix, right = system.matrix, system.right
    if stabilise:
        drift = matrix[3:6, :3] @ y[5:8] + matrix[3:6, 3:5] @ y[8:]
        right[3:6] -= 2 * stabilise * drift + stabilise**2 * contact_residual(system.k)
    return np.linalg.solve(matrix, right)[:5]


def _project(case: Case, y: np.ndarray) -> np.ndarray:
    """The nearest state in contact: positions by Newton's method with least change, then velocities by one solve."""
    y = y.copy()
    for _ in range(_CORRECTIONS):
        k = kinematics_of_ten(case, y)
        J = np.hstack(constraints(k)[:2])
        y[:5] -= J.T @ np.linalg.solve(J @ J.T, contact_residual(k))
    J = np.hstack(constraints(kinematics_of_ten(case, y))[:2])
    y[5:] -= J.T @ np.linalg.solve(J @ J.T, J @ y[5:])
    return y


# --- rows -------------------------------------------------------------------------------------------------------------


def measure(tolerances: Sequence[float], calls: Calls) -> list[dict[str, Any]]:
    """One row per scene, formulation and tolerance."""
    requests = [(name, formulation, rtol) for name in SCENES for formulation in FORMULATIONS for rtol in tolerances]
    answers = calls.all("formulations", drift, requests, keep=StorePolicy())
    return [
        dict(zip(("scene", "formulation", "rtol"), call, strict=True))
        | (answer.value | {"outcome": "done", "reason": ""} if answer.outcome == "done" else _nothing(*answer.failure))
        for call, answer in zip(requests, answers, strict=True)
    ]


def _nothing(outcome: str, reason: str) -> dict[str, Any]:
    return dict.fromkeys(NUMBERS, nan) | {"outcome": outcome, "reason": reason}


def drift(name: str, formulation: str, rtol: float) -> dict[str, float | int]:
    """The drift of a formulation from its constraints and from the truth on a scene, and its cost."""
    case, mode, truth = scene(name)
    answer = solve(case, mode, formulation, rtol)
    ks = [kinematics_of_ten(case, y) for y in answer.ten.T]
    residuals = np.array([contact_residual(k) for k in ks])
    speeds = [np.hstack(constraints(k)[:2]) @ y[5:] for k, y in zip(ks, answer.ten.T, strict=True)]
    gaps = np.hypot(residuals[:, 0], residuals[:, 1])
    exact = truth(np.minimum(answer.t, truth.t[-1]))
    off = np.hypot(answer.ten[0] - exact.x, answer.ten[1] - exact.y)
    return {
        "gap": float(gaps.max()),
        "gap_drift": float(gaps[-1] / answer.t[-1]),
        "tangency": float(np.abs(residuals[:, 2]).max()),
        "velocity_residual": float(np.hypot(*np.array(speeds)[:, :2].T).max()),
        "centre_error": float(off.max()),
        "steps": len(answer.t) - 1,
        "evaluations": answer.evaluations,
        "cpu_s": answer.cpu_s,
    }


NUMBERS = ("gap", "gap_drift", "tangency", "velocity_residual", "centre_error", "steps", "evaluations", "cpu_s")
