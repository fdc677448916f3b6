"""Simulation of one case: `simulate` returns its trajectory."""

from __future__ import annotations

import logging
import pickle
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from inspect import isfunction
from math import isfinite
from typing import Any

import numpy as np

from cases import BadValue, Case, Chain, ContactImpulse, Cost, Load, Mode, NotSupported, Passage, State, Trajectory
from cases.curves.corner import Corner
from cases.curves.element import Element
from cases.errors import between, unknown_name
from cases.motion.sampled_contacts import SampledPlates
from cases.motion.trajectory import CONTACT
from cases.moving_frame import in_fixed_frame, relative_case
from cases.scene.contact_limits import touches_by_features
from cases.scene.free_plates import names_of, start_poses
from cases.scene.limits import Scope, as_sentence, has_spinning_plate, limit
from cases.scene.piece_case import PieceCase, has_pieces

from . import augmented_integrator, solver
from .endings import BREAKDOWN, LIFT_OFF, undecidable
from .minimal.contact_end import SMOOTH
from .minimal.decision import Undecidable
from .minimal.integrators import taylor
from .minimal.integrators.segment import Segment
from .minimal.modes import (
    Phase,
    Regime,
    candidates,
    phase_at,
    start_pieces,
    start_state,
    state_in,
)
from .solution_check import ending_by_laws
from .solver import first_regime


def _prepare_dop853(phase: Phase, rtol: float) -> None:
    from .minimal.integrators import dop853  # SciPy's integrators take a tenth of a second to import

    dop853.prepare(phase, rtol)


def _integrate_dop853(phase: Phase, t: float, y, end: float, rtol: float) -> Segment:
    from .minimal.integrators import dop853

    return dop853.integrate(phase, t, y, end, rtol)


# The installed integrators, the best first.
METHODS = ("taylor", "dop853") if taylor.AVAILABLE else ("dop853",)
# All methods that `simulate` accepts: also the paper's matrix, assembled and solved at every evaluation.
ROUTES = (*METHODS, "augmented")


# Forces that are negative by less than this part of the weight are zero.
FORCE_ROUNDING = 1e-12


def _integrate_taylor(phase: Phase, t: float, y, end: float, rtol: float) -> Segment:
    """By Taylor's method; by DOP853 a phase that begins where its forces have no second derivative, as drag of √(v²) at
    rest, which it does not need, and one with a force that is zero at first, with all derivatives."""
    segment = taylor.integrate(phase, t, y, end, rtol)
    if (segment.event.guard == BREAKDOWN and segment.event.time == t) or (
        phase.checks_steps and _passes_zero(segment, t, y)
    ):
        return _integrate_dop853(phase, t, y, end, rtol)
    return segment


def _passes_zero(segment: Segment, t: float, y) -> bool:
    """Whether a force that is zero at a phase's start becomes negative without an event: the loop looks for roots after
    the start of a step."""
    phase = segment.phase
    starts = phase.system.guards_of_numbers(t, tuple(y), phase.parameters)
    names = list(phase.system.guards)
    zero = [i for i, name in enumerate(names) if name.startswith(("normal", "cone")) and not starts[i] > 0.0]
    if not zero:
        return False
    values = phase.system.guards_of_arrays(segment.times, segment.states(segment.times), phase.parameters)
    rounding = FORCE_ROUNDING * phase.case.weight / phase.case.plate.mass
    return any(float(np.min(values[i])) < -rounding for i in zero)


# By name: the functions that prepare and integrate a phase. The last two are no routes: one is for many runs, with code
# that takes a tenth of a second to a second longer to compile, one for certification only.
INTEGRATORS: dict[str, tuple[Callable[..., None], Callable[..., Segment]]] = {
    "taylor": (taylor.prepare, _integrate_taylor),
    "dop853": (_prepare_dop853, _integrate_dop853),
    "augmented": (augmented_integrator.prepare, augmented_integrator.integrate),
    "taylor_optimised": (partial(taylor.prepare, optimised=True), partial(taylor.integrate, optimised=True)),
    "taylor_quadruple": (taylor.prepare_quadruple, taylor.integrate_quadruple),
}

_FREE = Cost()
# Range of `rtol`: below it rounding is larger than the tolerance, above it an integrator's error estimates are
# meaningless.
TOLERANCES = 1e-14, 1e-2


def simulate(case: Case, rtol: float = 1e-10, method: str | None = None) -> Trajectory:
    """Compute the motion of a case by the paper's equations.

    `rtol` is the integrator's relative tolerance, between 1e-14 and 1e-2; `method` one of `METHODS` (None: the best
    available), "taylor_optimised" for many runs of equations of one form (compiling takes up to a second longer, steps
    a tenth to two thirds less), or "augmented", the paper's own matrix (27), literal and slow. The trajectory's
    transitions are located to the integrator's accuracy; its `status` and `reason` report why a motion ended early, its
    `reason` also where that matrix was nearly singular. Raises BadValue or UnknownName for invalid arguments.
    """
    if not isinstance(case, Case):
        advice = f"call it: {case.__name__}()" if isfunction(case) else "give a Case, for example cases.load(name)"
        raise BadValue(f"simulate was given {type(case).__name__}; {advice}")
    rtol, method = between("rtol", rtol, *TOLERANCES), _method_name(method, case)
    if method == "augmented" and case.others:
        raise NotSupported("the method 'augmented' has one plate; leave method out, or give 'dop853'")
    if method == "augmented" and (touches_by_features(case) or has_spinning_plate(case)):
        raise NotSupported("the method 'augmented' has one contact; leave method out, or give 'dop853'")
    if method == "augmented" and has_pieces(case):
        raise NotSupported("the method 'augmented' does not integrate over corners; leave method out, or give 'dop853'")
    curves = case.track.parts, case.plate.outline.parts
    if method == "augmented" and any(parts and parts.order < SMOOTH for parts in curves):
        raise NotSupported("the method 'augmented' takes no jumps of curvature; leave method out, or give 'dop853'")
    # Not as a decorator: NumPy 1 would store the state to restore in one place for all threads.
    with np.errstate(all="ignore"):  # non-finite values end the motion with a reason
        return _simulate(case, rtol, method)


def _simulate(case: Case, rtol: float, method: str) -> Trajectory:
    """Same as `simulate`, for valid arguments."""
    began = time.perf_counter()
    problem = initial_value_problem(case, rtol, method)
    setup = time.perf_counter() - began
    cpu, wall = time.thread_time(), time.perf_counter()
    solution = problem.solve()
    cost = Cost(time.thread_time() - cpu, time.perf_counter() - wall, setup_s=setup)
    motion = problem.trajectory(solution, cost)
    logging.getLogger("reference").info(
        "%s by %s: %s, %d transitions, %d steps, %.3g s of CPU time",
        case.label, method, motion.status, len(motion.transitions), motion.cost.steps, cost.cpu_s,
    )  # fmt: skip
    return motion


@dataclass(frozen=True)
class InitialValueProblem:
    """A case that is ready to be integrated.

    `relative` is the case as its track sees it; `regime` is that of its first contact, None for several contacts or
    plates and where no contact is consistent; `solve` integrates and returns (segments, transitions, (status, reason)).
    """

    case: Case
    relative: Case
    regime: Regime | None
    solve: Callable[[], Any]
    rtol: float

    def trajectory(self, solution, cost: Cost = _FREE) -> Trajectory:
        """The result of `solve` as a motion in the fixed frame."""
        segments, transitions, ending = solution
        motion = as_trajectory(self.relative, segments, transitions, ending, cost, self.rtol)
        return motion if self.relative is self.case else in_fixed_frame(self.case, motion)


def initial_value_problem(case: Case, rtol: float, method: str) -> InitialValueProblem:
    """Decide the regime of the first contact; the case is not integrated yet."""
    relative, (_, integrate) = relative_case(case), INTEGRATORS[method]
    if method == "augmented" and relative is not case:
        integrate = partial(augmented_integrator.integrate, original=case)
    regime = None
    if solver.begins_alone(relative) and relative.start.in_contact:
        with suppress(Undecidable):  # the motion ends with that
            regime = first_regime(relative, start_state(relative))
    solve = partial(solve_motion, relative, rtol, integrate, regime, case)
    return InitialValueProblem(case, relative, regime, partial(_with_check, relative, rtol, solve), rtol)


def _with_check(case: Case, rtol: float, solve: Callable[[], Any]):
    """A solution, with the status `broken_law` if it breaks a law."""
    segments, transitions, ending = solution = solve()
    return segments, transitions, ending_by_laws(case, solution, rtol) if _finite(segments) else ending


def solve_motion(
    case: Case,
    rtol: float,
    integrate: Callable[..., Segment],
    regime: Regime | None = None,
    original: Case | None = None,
):
    """The motion without samples: (segments, transitions, (status, sentence)). `regime`: that of the first contact, if
    it is known; `original`: the case whose relative case it is."""

    def no_poses() -> str:
        if getattr(integrate, "func", integrate) is augmented_integrator.integrate:
            return "The method 'augmented' has one contact; leave method out to go on."
        return as_sentence(limit(original or case, Scope.SEVERAL_CONTACTS))

    return solver.simulate(case, rtol, integrate, regime, no_poses)


def as_trajectory(
    case: Case, segments: list[Segment], transitions, ending: tuple[str, str], cost: Cost = _FREE, rtol: float = 1e-10
) -> Trajectory:
    """Convert the result of `solve_motion` to a trajectory with samples; steps and evaluations are added to `cost`.
    `rtol`: the tolerance it was computed with."""
    steps, evaluations = sum([s.steps for s in segments]), sum([s.evaluations for s in segments])
    cost = Cost(cost.cpu_s, cost.wall_s, cost.setup_s, steps, evaluations)
    status, reason = ending if _finite(segments) else undecidable(segments[-1].start)
    contacts = None
    if case.others or any(isinstance(segment.phase, solver.SolverPhase) for segment in segments):
        contacts = solver.AllContacts(case, segments, transitions)
    if solver.begins_alone(case) and (contacts is None or contacts.names == (CONTACT,)):  # the only one has no name
        contacts, transitions = None, [replace(change, contact="") for change in transitions]
    warning = augmented_integrator.warning(segments)
    reason = f"{reason} {warning}" if warning else reason
    return _trajectory(case, segments, transitions, status, reason, cost, contacts, partial(_impulses, rtol=rtol))


def _impulses(motion: Trajectory, rtol: float) -> tuple[ContactImpulse, ...]:
    """The impulses of a motion's impacts, when they are asked for."""
    from .impulses import impacts  # imports the check of laws, which a motion without impacts does not need

    assert motion.case is not None, "a motion of the reference has its case"
    return impacts(motion.case, motion, rtol)


def _finite(segments: list[Segment]) -> bool:
    """Whether every phase ended in finite numbers."""
    # Sums are quicker than one by one.
    return all([isfinite(sum(segment.event.state, segment.event.time)) for segment in segments])


@lru_cache(maxsize=1)
def _report_method() -> None:
    """Log once that the best method is missing."""
    if not taylor.AVAILABLE:
        logging.getLogger("reference").warning("heyoka is not installed: the reference uses dop853, slower and coarser")


def _has_integrals(case: Case) -> bool:
    """Whether the equations contain an integral, which the Taylor method cannot compute: a track's place is only in
    those with a load."""
    track, outline = case.track, case.plate.outline
    if isinstance(track, Chain) or isinstance(outline, Chain):
        return False
    return track.integrals > (0 if case.effect(Load) else 1) or outline.integrals > 0


def best_method(case: Case) -> str:
    """The method for a case for which none is given."""
    return "dop853" if _has_integrals(case) else METHODS[0]


def _method_name(method: str | None, case: Case) -> str:
    if method is None:
        _report_method()
        return best_method(case)
    is_valid = isinstance(method, str) and method in INTEGRATORS
    if not is_valid or (method.startswith("taylor") and not taylor.AVAILABLE):
        raise unknown_name("method of the reference", str(method), ROUTES)
    return method


def prepare(case: Case, regime: Regime, method: str, rtol: float) -> None:
    """Compile the equations of the regime in which a motion starts. Those of other regimes are compiled when a motion
    of this process first enters them."""
    prepare_phase, _ = INTEGRATORS[method]
    prepare_phase(phase_at(start_pieces(case), regime, start_state(case)), rtol)


def passages(segments: list[Segment]) -> tuple[Passage, ...]:
    """Where the contact passes from one piece of a chain to the next."""
    result: list[Passage] = []
    for last, segment in zip(segments, segments[1:], strict=False):
        before, after = last.phase.case, segment.phase.case
        if not isinstance(before, PieceCase) or not isinstance(after, PieceCase):
            continue
        if before != after:
            xi1, xi2 = after.to_whole(*segment.states(np.array([segment.start]))[:2, 0].tolist())
            result += _passages_between(before, after, segment.start, xi1, xi2)
    return tuple(result)


def _passages_between(before: PieceCase, after: PieceCase, t: float, xi1: float, xi2: float) -> list[Passage]:
    """The passages of the contact from one pair of pieces to another, at a time and its parameters."""
    curves = (("track", before.first, after.first), ("outline", before.second, after.second))
    return [Passage(t, name, _name(old), _name(new), xi1, xi2) for name, old, new in curves if old.number != new.number]


def _name(element: Element) -> str:
    return f"{'corner' if isinstance(element.piece, Corner) else 'piece'} {element.number}"


def _trajectory(
    case: Case, segments: list[Segment], transitions, status: str, reason: str, cost: Cost,
    contacts: solver.AllContacts | None, impulses: Callable,
) -> Trajectory:  # fmt: skip
    """A trajectory with samples at the integrator's steps and on both sides of each transition, and a dense output."""
    common: dict[str, Any] = dict(transitions=tuple(transitions), status=status, reason=reason, cost=cost, case=case)
    common["impulses"] = impulses
    common["passages"] = passages(segments) if has_pieces(case) else ()
    if not segments:
        # No motion and no contact force: the plate leaves at once, or no force is consistent.
        first, nothing = start_state(case), np.zeros(1)
        if case.start.in_contact:
            now = phase_at(start_pieces(case), candidates(case)[-1], first)
            start = solver.observe(case, now, nothing, np.array(state_in(now, first))[:, None])
        else:
            start = State(*(np.array([value]) for value in (*first, *(np.nan,) * (len(State._fields) - len(first)))))
        start = start._replace(normal_force=nothing, friction_force=nothing)
        if case.others:
            poses = {name: pose[:, None] for name, pose in zip(names_of(case), start_poses(case), strict=True)}
            common |= dict(plate_names=names_of(case), plate_columns=SampledPlates(np.zeros(1), poses))
        return Trajectory(t=np.zeros(1), **start._asdict(), **common, first_mode=at_once(status))

    def samples() -> tuple[np.ndarray, State]:
        with np.errstate(all="ignore"):
            return np.concatenate([segment.times for segment in segments]), _states(case, segments, None)

    if contacts is not None:
        common |= dict(contact_names=contacts.names, contact_columns=contacts)
    if case.others:
        common |= dict(plate_names=names_of(case), plate_columns=solver.AllPlates(case, segments))
    first_mode = _first_mode(segments, transitions)
    return Trajectory.on_demand(samples, **common, first_mode=first_mode, dense=_Dense(case, segments))


def _states(case: Case, segments: list[Segment], times: np.ndarray | None) -> State:
    """The motion at times (n,), or at its samples."""
    return State(*solver.evaluate(segments, times, lambda s, when: solver.observe(case, s.phase, when, s.states(when))))


def _first_mode(segments: list[Segment], transitions) -> Mode:
    """The mode of the first contact at the start."""
    first = next((change.before for change in transitions if change.contact == CONTACT), None)
    now = segments[0].phase
    if isinstance(now, solver.SolverPhase):
        regime = solver.regime_of(now)
        return first or dict(zip(regime.names, regime.modes, strict=True)).get(CONTACT, Mode.FLIGHT)
    return now.regime.mode


class _Dense:
    """A motion at any times, from its segments: times (n,) ↦ State.

    It is pickled with all of its steps, so that no process has to integrate again; the functions that evaluate them are
    derived on first use.
    """

    def __init__(self, case: Case, segments: list[Segment]):
        self._case, self._segment_list, self._pickle = case, segments, b""

    def __call__(self, when: np.ndarray) -> State:
        return _states(self._case, self._segments, when)

    @property
    def _segments(self) -> list[Segment]:
        if not self._segment_list:
            self._segment_list = pickle.loads(self._pickle)
        return self._segment_list

    def __getstate__(self) -> tuple[Case, bytes]:
        return self._case, self._pickle or pickle.dumps(self._segment_list, protocol=5)

    def __setstate__(self, state: tuple[Case, bytes]) -> None:
        (self._case, self._pickle), self._segment_list = state, []


def at_once(status: str) -> Mode | None:
    """The mode of a motion that ends at its start: flight if the plate leaves its track, else none."""
    return Mode.FLIGHT if status == LIFT_OFF[0] else None
