"""What follows a phase of contact: the next regime by the guard that reached zero, flight, or the end of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, Flight, Impact
from cases.contact import clearance
from cases.scene.piece_case import PieceCase, corner_on_corner, is_concave, neighbour

from ..effect_laws import laws
from ..effect_laws.own_forces import OWN_END, own_ending, own_force_values
from ..endings import (
    BREAKDOWN,
    COMPLETION,
    CONCAVE,
    ENDS,
    FLAT,
    LANDING_END,
    LIFT_OFF,
    LIFTED,
    NO_MODE,
    NO_SLIP,
    OFF_CORNER,
    Ending,
    singular_ending,
    work_limit_ending,
)
from ..scales import LOCATION_ERROR, ROUGH, approach_scale, error_range
from .assembly import PIECE_ENDS, Kind
from .decision import AT_BOUND, Undecidable, decide, slack_of
from .elimination import Elimination
from .grazing import may_touch, over_touch
from .impact import ContactVelocity
from .integrators.segment import OUT_OF_STEPS, Segment
from .modes import (
    FLIGHT,
    SLIP_SIGN,
    Phase,
    Regime,
    able,
    candidates,
    constrained,
    full_state,
    in_contact,
    in_flight,
    phase,
    phase_at,
    senses,
    slip_and_spin,
    state_in,
)

# Derivatives that must be continuous at a knot for the forces, and the rates of the contact point, to be continuous.
SMOOTH = 2


class Step(NamedTuple):
    """The result of a phase: its segments, time, place (ξ₁, ξ₂) and cause of its end, and the full state and regime
    that follow, or the ending."""

    segments: tuple[Segment, ...]
    time: float
    place: tuple[float, float] = (np.nan, np.nan)
    cause: str = ""
    state: tuple[float, ...] = ()
    regime: Regime | None = None
    ending: Ending = COMPLETION
    pieces: PieceCase | None = None  # those that the contact passes to


def after_contact(case: Case, segment: Segment, begin: Sequence[float], error: float) -> Step:
    """The step after a guard's zero, in a motion with the relative `error`; `begin`: the state where the segment
    begins."""
    now, guard, t = segment.phase, segment.event.guard, segment.event.time
    if guard is None:
        return Step((segment,), t)
    full = phase(now.case, now.regime, now.parts)  # whose system has guards, whatever equations integrated the segment
    if guard == "normal_force" or guard in BEGINS and may_touch(full, segment, guard, begin):
        across = over_touch(full, segment, guard, error, case.duration)
        if across:
            t, y = across.event.time, full_state(case, now, t, across.event.state)
            return Step((segment, across), t, (y[0], y[1]), guard, y, now.regime if t < case.duration else None)
    if guard in BEGINS and _force_vanished(case, segment, begin):
        guard = "normal_force"
    y = full_state(case, now, t, segment.event.state)
    if (beyond := _beyond_knot(case, segment, y)) is not None:
        return beyond
    if guard in PIECE_ENDS and isinstance(case, PieceCase):
        return _pass_on(case, segment, t, y, guard)
    ending = ending_by(case, segment, guard)
    if ending is not None:
        return Step((segment,), t, ending=ending)
    slips, holds = now.regime.kind
    if guard in ("slip", "turn"):
        y = constrained(case, t, y, Kind(slips and guard != "slip", holds or guard == "turn"))
    following = _following(case, now.regime, guard, t, y, error)
    if following is None:
        return leave(case, (segment,), t, y, guard, error)
    return Step((segment,), t, (y[0], y[1]), guard, y, following)


def ending_by(case: Case, segment: Segment, guard: str) -> Ending | None:
    """How the motion ends if that guard, which ended a segment, ends it; None if another phase follows."""
    if guard in ENDS:
        return ENDS[guard]
    if guard.startswith(OWN_END):
        return own_ending(case, guard)
    if guard == OUT_OF_STEPS:
        return work_limit_ending(segment.event.time, segment.steps)
    return breakdown(segment.phase, segment) if guard == BREAKDOWN else None


def _beyond_knot(case: Case, segment: Segment, y: tuple[float, ...]) -> Step | None:
    """The step after a knot of a curve in pieces: the same regime, or, where the curvature or the parameter's speed
    jumps, the one that follows from slip and spin, which do not. None if the segment did not end at one."""
    now, t, guard = segment.phase, segment.event.time, str(segment.event.guard)
    of_track, step = PIECE_ENDS.get(guard, (True, 0))
    row = 0 if of_track else 1
    pieces, number = (case.track.parts, case.plate.outline.parts)[row], now.parts[row]
    if step == 0 or pieces is None or not pieces.has_neighbour(number, step):
        return None
    y = (*y[:row], pieces.across(number, step, y[row]), *y[row + 1 :])
    if pieces.order >= SMOOTH:
        return Step((segment,), t, (y[0], y[1]), guard, y, now.regime)
    m = Elimination(*now.system.outputs_of_numbers(t, segment.event.state, now.parameters))
    touch = ContactVelocity(m.slip, 0.0, m.omega)
    theta = y[4] if len(y) > 4 else np.nan
    return contact_step(case, (segment,), t, (y[0], y[1]), theta, touch, guard)


def _pass_on(case: PieceCase, segment: Segment, t: float, y: Sequence[float], guard: str) -> Step:
    """The step where the contact reaches the end of a piece: the next piece, with the same slip velocity and spin."""
    of_track, way = PIECE_ENDS[guard]
    following = neighbour(case, of_track, way)
    if following is None:
        return Step((segment,), t, ending=ENDS[guard])
    place = (y[0], y[1])
    if is_concave(following):
        return Step((segment,), t, place, ending=CONCAVE)
    regime = segment.phase.regime
    if corner_on_corner(following):  # the plate's corner passes the track's
        if case.effect(Flight) is None:
            return Step((segment,), t, place, "normal_force", ending=OFF_CORNER)
        return _take_off(case, (segment,), t, y, "normal_force")
    slip, omega = slip_and_spin(case, t, y)
    slip, omega = slip if regime.kind.slips else 0.0, 0.0 if regime.kind.holds else omega
    entry = following.pieces[not of_track].span[0 if way > 0 else 1]
    xi1, xi2 = (entry, y[1]) if of_track else (y[0], entry)
    if not clearance(following, xi1, xi2) > 0.0:
        return Step((segment,), t, place, ending=FLAT)
    y = in_contact(following, t, xi1, xi2, slip, omega, y[4] if len(y) > 4 else 0.0)
    after = decide(following, t, y, LOCATION_ERROR, regimes_beyond(following, regime, guard))
    if after is None:
        return leave(following, (segment,), t, y, "piece")._replace(place=place)
    return Step((segment,), t, (xi1, xi2), "piece", y, after, pieces=following)


def senses_beyond(regime: Regime, guard: str) -> tuple[float, float]:
    """The signs of slip and rotation that a regime has beyond a guard's zero; 0: it has vanished. Friction or
    resistance has reached its bound from inside: the motion that begins is against it."""
    slip, turn = SLIP_SIGN.get(regime.mode, 0.0), float(regime.turn or 0)
    if guard in BEGINS:
        return (BEGINS[guard], turn) if guard.startswith("cone") else (slip, BEGINS[guard])
    return 0.0 if guard == "slip" else slip, 0.0 if guard == "turn" else turn


def regimes_beyond(case: Case, regime: Regime, guard: str) -> tuple[Regime, ...]:
    """The regimes that may follow a guard's zero: where a motion begins, not the same one, with the track's same
    side."""
    some = able(case, *senses_beyond(regime, guard))
    if guard not in BEGINS:
        return some
    return tuple(r for r in some if r.side == regime.side and r != regime._replace(slack=()))


def _following(
    case: Case, regime: Regime, guard: str, t: float, y: Sequence[float], error: float = LOCATION_ERROR
) -> Regime | None:
    """The regime of contact that follows a guard's zero, or None; `error`: the motion's relative error."""
    if guard == "normal_force":
        other = regime._replace(side=-regime.side)
        others = [other] if other in candidates(case) else []
        # The force vanishes along the step's polynomial; at the state it has what the tolerance leaves. The least error
        # that explains it decides: with a larger one a slow slip would count as none.
        return next(filter(None, (decide(case, t, y, size, others) for size in error_range(error))), None)
    among = regimes_beyond(case, regime, guard)
    if guard in BEGINS:
        among = tuple(r for r in among if _unique_force(phase_at(case, r, y), t, y))
        return among[0] if len(among) == 1 else decide(case, t, y, LOCATION_ERROR, among)
    following = decide(case, t, y, LOCATION_ERROR, among)
    if following is None:
        # A motion that began a rounding ago and ends with the event does not continue.
        slip, turn = senses_beyond(regime, guard)
        slips, turns = senses(case, t, y, *slip_and_spin(case, t, y), LOCATION_ERROR)
        following = decide(case, t, y, LOCATION_ERROR, able(case, slip * abs(slips), turn * abs(turns)))
    return following


def _force_vanished(case: Case, segment: Segment, begin: Sequence[float]) -> bool:
    """Whether the normal force of a one-sided contact has vanished since a segment's start. Its bounds on friction and
    couple have vanished with it then, and no motion begins against these."""
    if not laws(case).unilateral:
        return False
    now, event = segment.phase, segment.event
    now = phase(now.case, now.regime, now.parts)  # whose system has outputs, whatever equations integrated the segment
    first, last = (
        abs(Elimination(*now.system.outputs_of_numbers(t, state, now.parameters)).normal)
        for t, state in ((segment.start, begin), (event.time, event.state))
    )
    return last <= ROUGH * first and first > 0.0  # one without weight has no normal force from the start


def _unique_force(now: Phase, t: float, y: Sequence[float]) -> bool:
    """Whether the contact force of a slip that begins is unique: not beyond Painlevé's paradox."""
    names = list(now.system.guards)
    if "painleve" not in names:
        return True
    return now.system.guards_of_numbers(t, state_in(now, y), now.parameters)[names.index("painleve")] > 0.0


BEGINS = {"cone_forward": 1, "cone_backward": -1, "couple_forward": 1, "couple_backward": -1}


def leave(
    case: Case, segments: tuple[Segment, ...], t: float, y: Sequence[float], guard: str, error: float = LOCATION_ERROR
) -> Step:
    """The step if no contact follows: flight, or the end of the motion."""
    ending = _nothing_follows(case, t, y, error)
    if ending is LIFT_OFF and (floats := _floating(case, t, y)) is not None:
        return Step(segments, t, (y[0], y[1]), guard, tuple(y), floats)
    if ending is LIFT_OFF and case.effect(Flight) is not None:
        return _take_off(case, segments, t, y, guard)
    return Step(segments, t, (y[0], y[1]), guard, ending=ending)


def _take_off(case: Case, segments: tuple[Segment, ...], t: float, y: Sequence[float], guard: str) -> Step:
    """The step into a flight that begins with the contact's velocities."""
    return Step(segments, t, (y[0], y[1]), guard, in_flight(case, t, y, *slip_and_spin(case, t, y), 0.0), FLIGHT)


def _floating(case: Case, t: float, y: Sequence[float]) -> Regime | None:
    """The regime of a contact that opens by roundings alone, as its forces vanish all the time: under a load of exactly
    the weight. None if they change along the motion."""
    weak = AT_BOUND * _approach_scale(case, t, y)
    if abs(free_quantities(case, t, y).free_approach) > weak:
        return None
    moves = senses(case, t, y, *slip_and_spin(case, t, y), LOCATION_ERROR)
    regime = decide(case, t, y, LOCATION_ERROR, able(case, *moves), weak)
    if regime is None:
        return None
    now = phase_at(case, regime, y)
    slack = slack_of(now, t, y, LOCATION_ERROR, weak)
    return regime._replace(slack=slack) if slack else None


def breakdown(now: Phase, segment: Segment) -> Ending:
    """The ending at singular equations: the limit of the formulation that was reached, if one was."""
    names = list(now.system.guards)
    first, last = (
        now.system.guards_of_numbers(float(t), segment.states(np.array([t]))[:, 0].tolist(), now.parameters)
        for t in (segment.times[0], segment.times[-1])
    )
    for limit in ("fit", "painleve"):
        for place, name in enumerate(names):
            # Steps vanish as a divisor does; a hundredth of its first value shows that it does.
            if name.partition(":")[0] == limit and last[place] <= 1e-2 * first[place]:
                return ENDS[limit]
    return singular_ending(segment.times[-1])


def _nothing_follows(case: Case, t: float, y: Sequence[float], error: float) -> Ending:
    """Why no contact follows: the plate lifts off, unless without contact it would move into its track, or comes down
    at once, because effects of the user's own lift it and do not act in flight.

    It would move into its track where the normal force of a perfectly rough contact vanishes while friction T acts:
    without T the gap's acceleration is arm_t arm_n T/J. If that is negative, Coulomb friction of any μ begins to slip
    with N ≈ |T|/μ; in the limit of a perfectly rough contact, which excludes slip, there is no solution.
    """
    if not laws(case).unilateral:
        return NO_MODE
    m = free_quantities(case, t, y)
    if not np.isfinite(m.free_approach):
        raise Undecidable
    scale = _approach_scale(case, t, y)
    # At a lift-off the normal force has vanished, to the location's error and the growth of the terms in it, or to the
    # relative `error` of the motion.
    if m.free_approach <= max(1e6 * LOCATION_ERROR, error) * scale:
        # The force that has vanished is zero; the lift of effects that end with the contact is known to rounding.
        returns = min(m.free_approach, 0.0) + own_lift(case, t, y) > LOCATION_ERROR * scale
        if not returns or case.effect(Flight) is None:
            return LIFT_OFF
        return LIFTED if case.effect(Impact) else LANDING_END
    return NO_MODE if laws(case).friction.slip_modes else NO_SLIP


def _approach_scale(case: Case, t: float, y: Sequence[float]) -> float:
    """The size of the terms of `free_approach` at a full state (m/s²). Raises Undecidable if it is not finite."""
    now = phase_at(case, candidates(case)[-1], y)
    try:
        return approach_scale(now, t, state_in(now, y))
    except (ArithmeticError, ValueError) as problem:
        raise Undecidable from problem


def free_quantities(case: Case, t: float, y: Sequence[float]) -> Elimination:
    """The quantities of the contact's equations at a full state; `free_approach` is valid without contact force, too,
    and with `own_lift` added to it in flight."""
    now = phase_at(case, candidates(case)[-1], y)
    return Elimination(*now.system.outputs_of_numbers(t, state_in(now, y), now.parameters))


def own_lift(case: Case, t: float, y: Sequence[float]) -> float:
    """The gap's acceleration (m/s²) by effects of the user's own at a full state in contact; they end with it."""
    own = own_force_values(case, t, *slip_and_spin(case, t, y)) if laws(case).own else ()
    if not own:
        return 0.0
    along, across, couple = (sum(parts) for parts in zip(*own, strict=True))
    (x, r), (tx, ty) = case.plate.outline.point(y[1]), case.plate.outline.tangent(y[1])
    arm_t, arm_n = float(x * tx + r * ty), float(r * tx - x * ty)
    return across / case.plate.mass + arm_t * (arm_t * across - arm_n * along + couple) / case.plate.inertia


def contact_step(case: Case, segments, t: float, place, theta: float, touch: ContactVelocity, cause: str) -> Step:
    """The step of a contact that neither opens nor closes: the mode that follows, or else flight."""
    y = in_contact(case, t, place[0], place[1], touch.slip, touch.omega, theta)
    moves = senses(case, t, y, touch.slip, touch.omega, LOCATION_ERROR)
    following = decide(case, t, y, LOCATION_ERROR, able(case, *moves))
    if following is None and cause == "rest":  # velocities at the limit of bouncing have the error of its extrapolation
        moves = senses(case, t, y, touch.slip, touch.omega, ROUGH)
        still = touch._replace(slip=touch.slip if moves[0] else 0.0, omega=touch.omega if moves[1] else 0.0)
        y = in_contact(case, t, place[0], place[1], still.slip, still.omega, theta)
        following = decide(case, t, y, LOCATION_ERROR, able(case, *moves))
    if following:
        return Step(segments, t, place, cause, y, following)
    return leave(case, segments, t, y, cause)
