"""Integration with the paper's matrix: (27) is assembled and solved at every evaluation of DOP853.

This is `simulate(case, method="augmented")`. By `reference.paper`, literally: the rates, the contact forces and the
couple, slip and spin, and so every guard's value and the contact quantities of a trajectory. Shared with the other
integrators: the variables of a mode (those that its constraints leave free), its guards, what follows an event
(`decision.decide`, impacts, landings), and the steps and the location of events (`dop853`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple, cast

import numpy as np

from cases import Case
from cases.contact import track_place

from .effect_laws import laws
from .effect_laws.own_forces import OWN_END, own_guard
from .minimal import modes
from .minimal.assembly import PAINLEVE_LEAST
from .minimal.integrators.segment import Segment
from .minimal.modes import SLIP_SIGN, Phase, full_state
from .minimal.system import System
from .paper.augmented import (
    AugmentedSystem,
    Solution,
    condition,
    fill,
    parameter_accelerations,
    solution,
    uniqueness,
)
from .paper.kinematics import at_each, belt_of, bend, slip_velocity

# From this condition number on, half of the digits of a double may be lost in the solve, and the reason says so.
NEARLY_SINGULAR = 1e8


_NO_SOLUTION = Solution(np.full(3, np.nan), np.full(2, np.nan), np.nan, np.nan, np.nan)


class ContactQuantities(NamedTuple):
    """The contact quantities of a trajectory; forces per mass, as in the eliminated equations."""

    slip: float
    omega: float
    normal: float
    friction: float


class LiteralSystem:
    """One mode's equations by the paper's matrix, with the interface that DOP853 and the trajectory use.

    The methods take (t, y, parameters) as those of `System` do; the parameters are ignored, as the case has them.
    """

    record = ContactQuantities  # the columns that `outputs_of_arrays` returns

    def __init__(self, case: Case, phase: Phase, original: Case | None = None):
        self.case, self.phase, self.regime, self.original = case, phase, phase.regime, original
        self.variables, self.positions = phase.system.variables, phase.system.positions
        self.guards = dict.fromkeys(phase.system.guards)  # their names
        self.check_layout = phase.system.check_layout

    def system_at(self, t: Any, y: Sequence[Any]) -> AugmentedSystem:
        """Assemble (27) at a state of the mode, or at n states of shape (variables, n)."""
        mode, side, turn, _ = self.regime
        if isinstance(t, np.ndarray):
            instants = zip(t.tolist(), np.transpose(y).tolist(), strict=True)
            state = [*np.array([full_state(self.case, self.phase, *instant) for instant in instants]).T]
        else:
            state = [*full_state(self.case, self.phase, t, y)]
        if self.original is None:
            return fill(self.case, mode, state, side, turn, t)
        # The state has θ relative to the track; the matrix is that of R(ξ₁, t) in the fixed frame.
        state[4:] = [angle + track_place(self.original, t).angle for angle in state[4:]]
        return fill(self.original, mode, state, side, turn, t)

    def rates_of_numbers(self, t: float, y: Sequence[float], _parameters=()) -> list[float]:
        """Rates of the mode's variables; NaN, which no step accepts, where the matrix is singular."""
        if len(y) == self.positions and not laws(self.case).belt.runs:
            return [0.0] * len(y)  # at rest all rates are zero, whatever the forces
        try:
            equations = self.system_at(t, y)
            accelerations = parameter_accelerations(equations)
        except np.linalg.LinAlgError:
            return [np.nan] * len(y)
        speeds = len(y) - self.positions
        angle = [equations.k.turning] if self.positions == 3 else []
        return [*equations.k.q_dot.tolist(), *angle, *accelerations[:speeds]]

    def guards_of_numbers(self, t: float, y: Sequence[float], _parameters=()) -> list[float]:
        """The guards' values; NaN for those that need forces if the matrix is singular."""
        return [float(value) for value in self._guards(t, y)]

    def guards_of_arrays(self, times: np.ndarray, states: np.ndarray, _parameters=()) -> list[np.ndarray]:
        """The guards' values at many instants, states of shape (variables, n)."""
        return _together(self._guards, times, states)

    def _guards(self, t: Any, y: Sequence[Any]) -> list[Any]:
        """The guards' values at one instant or at n, with the regime's slack (m/s²)."""
        if not self.guards:
            return []
        equations, slack = self.system_at(t, y), dict(self.regime.slack)
        forces = _forces(equations, t)
        return [_guard(self.phase, name, t, equations, forces) + slack.get(name, 0.0) for name in self.guards]

    def load_quantities_of_arrays(self, times: np.ndarray, states: np.ndarray, parameters) -> list[np.ndarray]:
        """The load's quantities, which do not depend on the matrix."""
        return self.phase.system.load_quantities_of_arrays(times, states, parameters)

    def outputs_of_arrays(self, times: np.ndarray, states: np.ndarray, _parameters=()) -> list[np.ndarray]:
        """The contact quantities in the order of `ContactQuantities`, each of shape (n,)."""
        if not len(times):
            return [times] * len(ContactQuantities._fields)
        return [np.broadcast_to(column, times.shape) for column in _together(self.outputs_of_numbers, times, states)]

    def outputs_of_numbers(self, t: Any, y: Sequence[Any], _parameters=()) -> ContactQuantities:
        """The same at one instant; forces are NaN if the matrix is singular."""
        equations, mass = self.system_at(t, y), self.case.plate.mass
        slip = 0.0 if equations.rolls else slip_velocity(equations.k, belt_of(self.case, t)[0])
        omega = 0.0 if equations.rotation_fixed else equations.k.turning
        forces = _forces(equations, t)
        return ContactQuantities(slip, omega, forces.normal_force / mass, forces.friction_force / mass)


def _forces(equations: AugmentedSystem, t: Any) -> Solution:
    """(27) solved; NaN at one instant where it is singular, which raises numpy.linalg.LinAlgError among n."""
    try:
        return solution(equations)
    except np.linalg.LinAlgError:
        if isinstance(t, np.ndarray):
            raise
        return _NO_SOLUTION


def _together(function: Callable[[Any, Any], Sequence[Any]], times: np.ndarray, states: np.ndarray) -> list[Any]:
    """The columns of a function's values at many instants; computed one by one if (27) is singular in one of them."""
    try:
        return [*function(times, states)]
    except np.linalg.LinAlgError:
        rows = [function(t, y) for t, y in zip(times.tolist(), states.T.tolist(), strict=True)]
        return list(np.array(rows).T)


def _guard(phase: Phase, name: str, t: Any, equations: AugmentedSystem, forces: Solution) -> Any:
    """The value of one guard, positive while the mode lasts, at one instant or at n. Forces per mass, couples over mass
    and radius of gyration."""
    case, regime, parts, k = phase.case, phase.regime, phase.parts, equations.k
    mass, size = case.plate.mass, case.plate.gyration
    curve, _, end = name.partition("_")
    if curve in ("track", "outline"):
        track, outline = (case.track.part(parts[0]), case.plate.outline.part(parts[1]))
        xi, domain = (k.q[0], track.domain) if curve == "track" else (k.q[1], outline.domain)
        assert domain is not None  # a curve without ends has no such guard
        return xi - domain[0] if end == "start" else domain[1] - xi
    if name == "fit":
        return bend(k.rp, k.rs) - bend(k.Rp, k.Rs)
    if name == "painleve":
        return uniqueness(equations) - PAINLEVE_LEAST
    if name in ("turn", "slip") or name.startswith(OWN_END):
        spin = 0.0 if equations.rotation_fixed else k.turning
        if name == "turn":
            return (regime.turn or 0) * spin * size
        slip = 0.0 if equations.rolls else slip_velocity(k, belt_of(case, t)[0])
        return (
            SLIP_SIGN[regime.mode] * slip if name == "slip" else at_each(partial(own_guard, case, name), t, slip, spin)
        )
    pressing = regime.side * forces.normal_force
    if name == "normal_force":
        return pressing / mass
    sense = 1.0 if end == "forward" else -1.0
    if curve == "cone":
        return (laws(case).friction.coefficients(case)[1] * pressing + sense * forces.friction_force) / mass
    assert curve == "couple"
    return (laws(case).resistance.arm(case) * pressing + sense * forces.couple) / (mass * size)


def prepare(phase: Phase, rtol: float = 1e-10) -> None:
    """Compile the curves' derivatives, from which the matrix is assembled."""
    phase.case.track.jet(phase.case.start.xi1)
    phase.case.plate.outline.jet(0.0)


def integrate(phase: Phase, t: float, y, end: float, rtol: float, original: Case | None = None) -> Segment:
    """Integrate as `dop853.integrate`, with the paper's matrix in place of the phase's own equations: that of
    `original` in the fixed frame, if the phase is one of `relative_case(original)`."""
    from .minimal.integrators import dop853  # SciPy's integrators take a tenth of a second to import

    # In flight there is no contact, and (16) and (19) alone are no matrix.
    return dop853.integrate(phase if phase.flies else _with_matrix(phase, original), t, y, end, rtol)


class _LiteralPhase(Phase):
    """A phase whose equations are the paper's matrix."""

    def __reduce__(self):
        """Pickle as the ordinary phase from which it was made."""
        original = cast(LiteralSystem, self.system).original
        return _with_matrix, (modes.phase(self.case, self.regime, self.parts), original)


def _with_matrix(now: Phase, original: Case | None = None) -> _LiteralPhase:
    """The phase with the paper's matrix in place of its own equations."""
    # LiteralSystem has everything that the loop and the record use; nothing in it is symbolic.
    return _LiteralPhase(*now._replace(system=cast(System, LiteralSystem(now.case, now, original))))


def warning(segments: Sequence[Segment]) -> str:
    """A sentence if (27) was nearly singular at a step of a motion by the paper's matrix, else ""."""
    worst, when = 0.0, 0.0
    for segment in segments:
        system: object = segment.phase.system
        if not isinstance(system, LiteralSystem):
            continue
        for t, y in zip(segment.times.tolist(), segment.states(segment.times).T.tolist(), strict=True):
            now = condition(system.case, system.system_at(t, y))
            if now > worst:
                worst, when = now, t
    if worst < NEARLY_SINGULAR:
        return ""
    return f"The matrix (27) was nearly singular: its condition reached {worst:.1e} at t = {when:.9g} s."
