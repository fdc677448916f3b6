"""Integration with the paper's matrix: (27) is assembled and solved at every evaluation of DOP853.

This is `simulate(case, method="augmented")`. By `reference.paper`, literally: the rates, the contact forces and the
couple, slip and spin, and so every guard's value and the contact quantities of a trajectory. Shared with the other
integrators: the variables of a mode (those that its constraints leave free), its guards, what follows an event
(`decision.decide`, impacts, landings), and the steps and the location of events (`dop853`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, cast

import numpy as np

from cases import Belt, Case, CoulombFriction, RollingResistance
from cases.contact import track_place
from cases.own_effects import own_effects

from .minimal import modes
from .minimal.assembly import PAINLEVE_LEAST
from .minimal.effects import OWN_END
from .minimal.integrators.segment import Segment
from .minimal.modes import FLIGHT, SLIP_SIGN, Phase, full_state
from .minimal.system import System
from .paper import contact_forces
from .paper.augmented import (
    WITHOUT_SLIP,
    AugmentedSystem,
    Solution,
    condition,
    fill,
    flight_acceleration,
    solution,
    uniqueness,
)
from .paper.kinematics import belt_of, slip_velocity

# From this condition number on, half of the digits of a double may be lost in the solve, and the reason says so.
NEARLY_SINGULAR = 1e8


_NO_SOLUTION = Solution(np.full(3, np.nan), np.full(2, np.nan), np.full(1, np.nan), np.nan, np.nan, np.nan)


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

    def system_at(self, t: float, y: Sequence[float]) -> AugmentedSystem:
        """Assemble (27) at a state of the mode."""
        mode, side, turn = self.regime
        state = full_state(self.case, self.phase, t, y)
        if self.original is None:
            return fill(self.case, mode, state, side, turn, t)
        # The state has θ relative to the track; the matrix is that of R(ξ₁, t) in the fixed frame.
        angle = [value + track_place(self.original, t).angle for value in state[4:]]
        return fill(self.original, mode, (*state[:4], *angle), side, turn, t)

    def rates_of_numbers(self, t: float, y: Sequence[float], _parameters=()) -> list[float]:
        """Rates of the mode's variables; NaN, which no step accepts, where the matrix is singular."""
        if self.regime == FLIGHT:
            return [*y[3:], *flight_acceleration(self.case, t, y)]
        if len(y) == self.positions and self.case.effect(Belt) is None:
            return [0.0] * len(y)  # at rest all rates are zero, whatever the forces
        try:
            equations = self.system_at(t, y)
            accelerations = solution(equations).q2_ddot
        except np.linalg.LinAlgError:
            return [np.nan] * len(y)
        speeds = len(y) - self.positions
        angle = [equations.k.turning] if self.positions == 3 else []
        return [*equations.k.q_dot, *angle, *accelerations[:speeds]]

    def guards_of_numbers(self, t: float, y: Sequence[float], _parameters=()) -> list[float]:
        """The guards' values; NaN for those that need forces if the matrix is singular."""
        if not self.guards:
            return []
        equations = self.system_at(t, y)
        try:
            forces = solution(equations)
        except np.linalg.LinAlgError:
            forces = _NO_SOLUTION
        return [_guard(self.phase, name, equations, forces, t) for name in self.guards]

    def guards_of_arrays(self, times: np.ndarray, states: np.ndarray, _parameters=()) -> list[np.ndarray]:
        """The guards' values at many instants, states of shape (variables, n)."""
        columns = [self.guards_of_numbers(t, y) for t, y in zip(times.tolist(), states.T.tolist(), strict=True)]
        return list(np.array(columns).T)

    def load_quantities_of_arrays(self, times: np.ndarray, states: np.ndarray, parameters) -> list[np.ndarray]:
        """The load's quantities, which do not depend on the matrix."""
        return self.phase.system.load_quantities_of_arrays(times, states, parameters)

    def outputs_of_arrays(self, times: np.ndarray, states: np.ndarray, _parameters=()) -> list[np.ndarray]:
        """The contact quantities in the order of `ContactQuantities`, each of shape (n,)."""
        columns = states.T.tolist()
        in_contact = self.original is None and self.regime != FLIGHT
        if columns and in_contact and contact_forces.fits(self.case, self.regime.turn):
            full = [full_state(self.case, self.phase, t, y) for t, y in zip(times.tolist(), columns, strict=True)]
            try:
                return list(self._observed_at_once(times.tolist(), full))
            except np.linalg.LinAlgError:
                pass  # solved one by one below: those that are not singular have forces
        rows = [self._observe(t, y) for t, y in zip(times.tolist(), columns, strict=True)]
        return list(np.array(rows).reshape(-1, len(ContactQuantities._fields)).T)

    def _observed_at_once(self, times: Sequence[float], states: Sequence[Sequence[float]]) -> Iterator[np.ndarray]:
        mode, side, turn = self.regime
        contact, mass = contact_forces.contacts(self.case, mode, states, side, turn, times), self.case.plate.mass
        yield np.zeros(len(states)) if self.regime.mode in WITHOUT_SLIP else contact.slip
        yield from (contact.theta_dot, contact.normal_force / mass, contact.friction_force / mass)

    def _observe(self, t: float, y: Sequence[float]) -> ContactQuantities:
        equations = self.system_at(t, y)
        slip = 0.0 if equations.rolls else slip_velocity(equations.k, belt_of(self.case, t)[0])
        omega = 0.0 if equations.rotation_fixed else equations.k.turning
        try:
            forces, mass = solution(equations), self.case.plate.mass
        except np.linalg.LinAlgError:
            return ContactQuantities(slip, omega, np.nan, np.nan)
        return ContactQuantities(slip, omega, forces.normal_force / mass, forces.friction_force / mass)


def _guard(phase: Phase, name: str, equations: AugmentedSystem, forces: Solution, t: float) -> float:
    """The value of one guard, positive while the mode lasts. Forces per mass, couples over mass and radius of
    gyration."""
    case, regime, parts = phase.case, phase.regime, phase.parts
    k, mass, size = equations.k, case.plate.mass, case.plate.gyration
    curve, _, end = name.partition("_")
    if curve in ("track", "outline"):
        track, outline = (case.track.part(parts[0]), case.plate.outline.part(parts[1]))
        xi, domain = (k.q[0], track.domain) if curve == "track" else (k.q[1], outline.domain)
        assert domain is not None  # a curve without ends has no such guard
        return float(xi - domain[0] if end == "start" else domain[1] - xi)
    if name.startswith(OWN_END):
        slip = 0.0 if equations.rolls else slip_velocity(k, belt_of(case, t)[0])
        return _own_end(case, name.removeprefix(OWN_END), (t, slip, k.turning))
    pressing = regime.side * forces.normal_force
    if name == "normal_force":
        return pressing / mass
    if name == "slip":
        return SLIP_SIGN[regime.mode] * slip_velocity(k, belt_of(case, t)[0])
    if name == "turn":
        return (regime.turn or 0) * k.turning * size
    if name == "fit":
        return _bend(k.rp, k.rs) - _bend(k.Rp, k.Rs)
    if name == "painleve":
        return uniqueness(equations) - PAINLEVE_LEAST
    sense = 1.0 if end == "forward" else -1.0
    if curve == "cone":
        friction = case.effect(CoulombFriction)
        assert friction is not None
        return (friction.stick * pressing + sense * forces.friction_force) / mass
    resistance = case.effect(RollingResistance)
    assert curve == "couple" and resistance is not None
    return (resistance.arm * pressing + sense * forces.couple) / (mass * size)


def _own_end(case: Case, status: str, state: tuple[float, float, float]) -> float:
    """The value of a condition of an effect of the user's own."""
    effects = own_effects(case.effects)
    values = [(end.status, value) for e in effects for end, value in zip(e.ends(), e.at(*state)[3:], strict=True)]
    return next(value for name, value in values if name == status)


def _bend(p: np.ndarray, s: np.ndarray) -> float:
    """A curve's curvature from its first and second derivative, 1/m."""
    return float((p[0] * s[1] - p[1] * s[0]) / np.hypot(*p) ** 3)


def prepare(phase: Phase, rtol: float = 1e-10) -> None:
    """Compile the curves' derivatives, from which the matrix is assembled."""
    phase.case.track.jet(phase.case.start.xi1)
    phase.case.plate.outline.jet(0.0)


def integrate(phase: Phase, t: float, y, end: float, rtol: float, original: Case | None = None) -> Segment:
    """Integrate as `dop853.integrate`, with the paper's matrix in place of the phase's own equations: that of
    `original` in the fixed frame, if the phase is one of `relative_case(original)`."""
    from .minimal.integrators import dop853  # SciPy's integrators take a tenth of a second to import

    return dop853.integrate(_with_matrix(phase, original), t, y, end, rtol)


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
        if not isinstance(system, LiteralSystem) or segment.phase.regime == FLIGHT:
            continue
        for t, y in zip(segment.times.tolist(), segment.states(segment.times).T.tolist(), strict=True):
            now = condition(system.case, system.system_at(t, y))
            if now > worst:
                worst, when = now, t
    if worst < NEARLY_SINGULAR:
        return ""
    return f"The matrix (27) was nearly singular: its condition reached {worst:.1e} at t = {when:.9g} s."
