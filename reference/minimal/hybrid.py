"""The event loop: simulates phase after phase until the end of the time span or a status."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cases import Case, DoesNotFit, Mode, Transition
from cases.contact import start_motion
from cases.piece_case import PieceCase, has_pieces

from ..endings import ACCUMULATION, CAUSES, OFF, no_numbers, phase_limit_ending, undecidable, work_limit_ending
from ..scales import frequency
from ..time_limit import check_time
from .bouncing import Bounces
from .contact_end import after_contact, leave
from .decision import Undecidable, decide
from .flight_end import after_flight, closes, simulate_flight, start_flight
from .integrators.segment import Segment
from .landing import Landings
from .modes import FLIGHT, Phase, Regime, candidates, phase_at, start_pieces, state_in
from .phase_end import LOCATION_ERROR, MANY, MOST_STEPS, ROUGH, Step
from .piece_landing import PieceLandings

# Changes of regime accumulate if MANY of them follow each other within this part of the motion's time scale.
NO_TIME = 1e-9

# Limit on the phases of one run: a segment takes 7 kB and more, so that these fill a gigabyte or two.
MOST_PHASES = 200_000

# After this many phases of zero length in a row (a slip that begins, ends and begins again), values within ROUGH of a
# bound count as being at it.
IDLE = 4


def simulate_phases(case: Case, regime: Regime | None, start, rtol: float, integrate: Callable[..., Segment]):
    """Simulate phases until the end of the time span or a status: (segments, transitions, (status, sentence))."""
    t, y, initial = 0.0, start, start_motion(case)
    whole, case = case, start_pieces(case)
    segments: list[Segment] = []
    transitions: list[Transition] = []
    if regime is None:
        try:
            step = leave(case, (), t, y, "")
        except Undecidable:
            return segments, transitions, undecidable(t)
        if step.regime is None:
            return segments, transitions, step.ending
        regime, y = step.regime, step.state
    bounces, progress, idle, steps = Bounces(whole), _Progress(), 0, 0
    landings, place = None, (initial.xi1, initial.xi2)  # of the whole curves, as all landings are
    for _ in range(MOST_PHASES):
        check_time()
        now = phase_at(case, regime, y)
        y = state_in(now, y)
        if progress.none(now, t, y):
            return segments, transitions, ACCUMULATION
        try:
            if regime == FLIGHT:
                landings = landings or (PieceLandings(whole) if has_pieces(whole) else Landings(whole))
                fly = simulate_flight if segments or not closes(whole) else start_flight
                step = after_flight(whole, *fly(case, now, t, y, place, rtol, integrate, landings), bounces)
            else:
                segment = integrate(now, t, y, case.duration, rtol)
                step = after_contact(case, segment, y, max(rtol, LOCATION_ERROR))
            idle = idle + 1 if step.time == t else 0
            if idle > IDLE and step.regime not in (None, FLIGHT):
                step = _advance(case, regime, step)
        except Undecidable:
            return segments, transitions, undecidable(t)
        except DoesNotFit as problem:  # no nearest point of the track, or no speed of the contact at the landing
            return segments, transitions, no_numbers(t, problem)
        segments.extend(step.segments)
        steps += sum(segment.steps for segment in step.segments)
        following = step.regime.mode if step.regime else Mode.FLIGHT if step.ending in OFF else regime.mode
        case = step.pieces or case
        place = case.to_whole(*step.place) if isinstance(case, PieceCase) else step.place
        if following is not regime.mode or (step.regime == FLIGHT == regime and step.is_listed):
            transitions.append(Transition(step.time, regime.mode, following, place[0], place[1], CAUSES[step.cause]))
        if step.regime is None:
            return segments, transitions, step.ending
        t, y, regime = step.time, step.state, step.regime
        if steps >= MOST_STEPS:
            return segments, transitions, work_limit_ending(t, steps)
    return segments, transitions, phase_limit_ending(t, MOST_PHASES)


class _Progress:
    """Detects phases without progress, measured by the motion's time scale."""

    def __init__(self) -> None:
        self.since = 0.0
        self.phases: list[tuple[Phase, float, Sequence[float]]] = []

    def none(self, now: Phase, t: float, y: Sequence[float]) -> bool:
        """Record a phase that begins at t; returns whether the last MANY took no time by the fastest of their rates."""
        self.phases.append((now, t, y))
        if len(self.phases) <= MANY:
            return False
        took = any((t - self.since) * frequency(*entry) > NO_TIME for entry in self.phases)
        self.since, self.phases = t, []
        return not took


def _advance(case: Case, regime: Regime, step: Step) -> Step:
    """The step with another regime after phases of zero length: what began is too small to distinguish from rounding.

    Values within `ROUGH` of their bound count as being at it, and their rates decide.
    """
    others = [r for r in candidates(case) if r != regime._replace(slack=())]
    return step._replace(regime=decide(case, step.time, step.state, ROUGH, others) or step.regime)
