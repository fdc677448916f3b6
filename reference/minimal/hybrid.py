"""The event loop: simulates phase after phase until the end of the time span or a status."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import hypot
from typing import NamedTuple

import numpy as np

from cases import Case, DoesNotFit, Flight, Impact, Mode, PerfectlyRough, Trajectory, Transition, Unilateral
from cases.contact import belt_speed, clearance, pose, start_motion
from cases.own_effects import own_effects
from cases.piece_case import (
    PieceCase,
    corner_on_corner,
    corners_meet,
    has_pieces,
    is_concave,
    lies_flat,
    neighbour,
    pieces_at,
)

from .bouncing import Bounces
from .curve_pieces import TooMuch
from .decision import Undecidable, decide
from .effects import OWN_END
from .elimination import Elimination
from .grazing import over_touch
from .impact import ContactVelocity, collide, energy, law_of
from .integrators.segment import BREAKDOWN, LOST_SIGHT, OUT_OF_STEPS, Segment
from .knots import passed
from .landing import Landing, Landings
from .modes import (
    FLIGHT,
    SLIP_SIGN,
    Phase,
    Regime,
    able,
    candidates,
    conveyance,
    full_state,
    in_contact,
    in_flight,
    phase_at,
    senses,
    slip_ended,
    start_pieces,
    state_in,
    turn_rate,
    without_slip,
    without_turning,
)
from .piece_landing import PieceLandings
from .scales import frequency
from .series import EPS

# Changes of regime accumulate if this many follow each other within this part of the motion's time scale.
MANY, NO_TIME = 1000, 1e-9

# Limits of one run: a segment takes 7 kB and more, so that these fill a gigabyte or two, and so does the record of
# these steps, which is made when samples are requested. (A hundred thousand changes of a limping wheel take 830,000.)
MOST_PHASES, MOST_STEPS = 200_000, 1_000_000

# Relative error of an event's location, whatever the tolerance of the motion that led there.
LOCATION_ERROR = 1e-12

# After this many phases of zero length in a row (a slip that begins, ends and begins again), values within ROUGH of a
# bound count as being at it: a thousand times the location's error.
IDLE, ROUGH = 4, 1e-9

# A rebound that rises by no more roundings of positions than this does not count: bouncing is over. Its limit is
# extrapolated from the rebounds before it; if that fails (successive impacts end differently), bouncing ends here.
REBOUND_ROUNDINGS = 4

Ending = tuple[str, str]  # status and sentence
COMPLETION: Ending = (Trajectory.status, Trajectory.reason)

# Guards whose zero ends the motion.
ENDS = {
    "painleve": (
        "paradox",
        "The normal equation's coefficient of λ vanished (Painlevé): rigid Coulomb contact has no unique force here.",
    ),
    "fit": ("no_fit", "The curvatures of outline and track became equal: the plate no longer fits its track here."),
    "track_start": ("track_end", "The contact reached the start of the track's domain."),
    "track_end": ("track_end", "The contact reached the end of the track's domain."),
    "outline_start": ("outline_end", "The contact reached the start of the outline's domain."),
    "outline_end": ("outline_end", "The contact reached the end of the outline's domain."),
}
# Guards at the ends of a piece: whether it is the track's, and which way the contact leaves it.
PIECE_ENDS = {
    "track_start": (True, -1),
    "track_end": (True, 1),
    "outline_start": (False, -1),
    "outline_end": (False, 1),
}
CONCAVE = ("second_contact", "The contact reached a corner inside which the plate touches its track in a second place.")
FLAT_LANDING = ("second_contact", "The plate lands on a flat side: it touches its track in two places at once.")
CORNERS_MEET = (
    "landing",
    "A corner of the plate meets a corner of its track: the direction of the impact is not defined there.",
)
FLAT = ("second_contact", "The contact reached a piece along which the plate lies on its track: it touches twice.")
OFF_CORNER = ("lift_off", "The plate's corner passed the track's corner: the plate leaves its track.")
LIFT_OFF = ("lift_off", "The normal force vanished and would pull: the plate leaves its track.")
OFF = (LIFT_OFF, OFF_CORNER)
LANDING_END = ("landing", "The plate meets its track again, and the case names no Impact.")
ENERGY = ("energy_gain", "Newton's law of restitution would create energy in this impact; give law='poisson'.")
NO_MODE = ("paradox", "No mode of rigid Coulomb contact is consistent here (Painlevé).")
NO_SLIP = (
    "paradox",
    "A perfectly rough contact would have to pull here, and the free plate would move into its track: "
    "without slip it can neither stay nor leave.",
)
ACCUMULATION = ("accumulation", f"Changes of regime accumulate: {MANY} of them took no time.")

# Guards whose zero changes the mode, with the cause that the transition reports.
CAUSES = {
    "slip": "the slip velocity vanished",
    "turn": "the rotation vanished",
    "cone_forward": "friction reached its cone",
    "cone_backward": "friction reached its cone",
    "couple_forward": "rolling resistance reached its bound",
    "couple_backward": "rolling resistance reached its bound",
    "normal_force": "the normal force vanished",
    "piece": "the contact passed to the next piece of its curve",
    "landing": "impact",
    "rest": "bouncing came to rest",
    **dict.fromkeys(("track_start", "track_end", "outline_start", "outline_end"), "the curvature jumped at a knot"),
}


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
    is_listed: bool = True  # whether an impact between two flights is listed
    pieces: PieceCase | None = None  # those that the contact passes to


def simulate_phases(case: Case, regime: Regime | None, start, rtol: float, integrate: Callable[..., Segment]):
    """Simulate phases until the end of the time span or a status: (segments, transitions, (status, sentence))."""
    t, y, initial = 0.0, start, start_motion(case)
    segments: list[Segment] = []
    transitions: list[Transition] = []
    if regime is None:
        try:
            step = _leave(case, (), t, y, "")
        except Undecidable:
            return segments, transitions, undecidable(t)
        if step.regime is None:
            return segments, transitions, step.ending
        regime, y = step.regime, step.state
    bounces, progress, idle, steps = Bounces(case), _Progress(), 0, 0
    landings, place = None, (initial.xi1, initial.xi2)  # of the whole curves, as all landings are
    whole, case = case, start_pieces(case)
    for _ in range(MOST_PHASES):
        now = phase_at(case, regime, y)
        y = state_in(now, y)
        if progress.none(now, t, y):
            return segments, transitions, ACCUMULATION
        try:
            if regime == FLIGHT:
                landings = landings or (PieceLandings(whole) if has_pieces(whole) else Landings(whole))
                fly = _flight if segments or not _closes(whole) else _start_flight
                step = _after_flight(whole, *fly(case, now, t, y, place, rtol, integrate, landings), bounces)
            else:
                step = after_contact(case, integrate(now, t, y, case.duration, rtol), max(rtol, LOCATION_ERROR))
            idle = idle + 1 if step.time == t else 0
            if idle > IDLE and step.regime not in (None, FLIGHT):
                step = _advance(case, regime, step)
        except Undecidable:
            return segments, transitions, undecidable(t)
        except DoesNotFit as problem:  # no nearest point of the track, or no speed of the contact at the landing
            return segments, transitions, (BREAKDOWN, f"After t = {t:.9g} s {problem}.")
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
    sentence = f"The regime changed {MOST_PHASES} times until t = {t:.9g} s, the limit of a run; end it there."
    return segments, transitions, ("unfinished", sentence)


def undecidable(t: float) -> Ending:
    """The ending if a decision meets numbers that are not finite."""
    why = "sizes, speeds and forces are too far apart for double precision, or a formula has no value"
    return BREAKDOWN, f"After t = {t:.9g} s {why}."


def work_limit_ending(t: float, steps: int) -> Ending:
    """The ending if a motion reaches its limit on steps."""
    return "unfinished", (
        f"The motion took {steps} steps until t = {t:.9g} s, the limit of a run; end it there, or use "
        "slower speeds and forces."
    )


def _search_limit_ending(t: float) -> Ending:
    """The ending if the search for landings reaches its limit on work."""
    return "unfinished", (
        f"The search for landings reached the limit of a run at t = {t:.9g} s; end it there, or use slower "
        "speeds and spins, or coarser curves."
    )


class _Progress:
    """Detects phases without progress, measured by the motion's time scale."""

    def __init__(self) -> None:
        self.since, self.phases = 0.0, list[tuple[Phase, float, Sequence[float]]]()

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
    others = [r for r in candidates(case) if r != regime]
    return step._replace(regime=decide(case, step.time, step.state, ROUGH, others) or step.regime)


# --- after contact ----------------------------------------------------------------------------------------------------


def after_contact(case: Case, segment: Segment, error: float) -> Step:
    """The step after a guard's zero, in a motion with the relative `error`."""
    now, guard, t = segment.phase, segment.event.guard, segment.event.time
    if guard is None:
        return Step((segment,), t)
    across = over_touch(segment, error, case.duration) if guard == "normal_force" else None
    if across:
        t, y = across.event.time, full_state(case, now, t, across.event.state)
        return Step((segment, across), t, (y[0], y[1]), guard, y, now.regime if t < case.duration else None)
    y = full_state(case, now, t, segment.event.state)
    if (knot := passed(case, segment, y)) is not None:
        return _beyond_knot(case, segment, *knot)
    if guard in PIECE_ENDS and isinstance(case, PieceCase):
        return _pass_on(case, segment, t, y, guard)
    if guard in ENDS:
        return Step((segment,), t, ending=ENDS[guard])
    if guard.startswith(OWN_END):
        return Step((segment,), t, ending=_own_ending(case, guard))
    if guard == OUT_OF_STEPS:
        return Step((segment,), t, ending=work_limit_ending(t, segment.steps))
    if guard == BREAKDOWN:
        return Step((segment,), t, ending=_breakdown(now, segment))
    if guard == "slip":
        y = (*y[:2], *slip_ended(case, t, y), *y[4:])
        if now.regime.turn == 0:
            u1 = conveyance(case, t, y[0], y[1])
            y = (*y[:2], u1, without_slip(case, t, y[0], y[1], u1), *y[4:])
    if guard == "turn":
        y = without_turning(case, y)
    following = _following(case, now.regime, guard, t, y, error)
    if following is None:
        return _leave(case, (segment,), t, y, guard, error)
    return Step((segment,), t, (y[0], y[1]), guard, y, following)


def _own_ending(case: Case, guard: str) -> Ending:
    """The ending by a condition of an effect of the user's own."""
    ends = [end for effect in own_effects(case.effects) for end in effect.ends()]
    return next((end.status, end.reason) for end in ends if guard == f"{OWN_END}{end.status}")


def _beyond_knot(case: Case, segment: Segment, y: Sequence[float], is_smooth: bool) -> Step:
    """The step after a knot: the same regime, or, where the curvature or the parameter's speed jumps, the one that
    follows from slip and spin, which do not."""
    now, t, guard = segment.phase, segment.event.time, str(segment.event.guard)
    if is_smooth:
        return Step((segment,), t, (y[0], y[1]), guard, tuple(y), now.regime)
    m = Elimination(*now.system.outputs_of_numbers(t, segment.event.state, now.parameters))
    touch = ContactVelocity(m.slip, 0.0, m.omega)
    theta = y[4] if len(y) > 4 else np.nan
    return _rest(case, (segment,), t, (y[0], y[1]), theta, touch, guard, True)


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
    if corner_on_corner(following):
        return _off_corner(case, segment, t, y, place)
    slip, omega = slip_and_spin(case, t, y)
    slip, omega = slip if regime.kind.slips else 0.0, 0.0 if regime.kind.holds else omega
    entry = following.pieces[not of_track].span[0 if way > 0 else 1]
    xi1, xi2 = (entry, y[1]) if of_track else (y[0], entry)
    if not clearance(following, xi1, xi2) > 0.0:
        return Step((segment,), t, place, ending=FLAT)
    y = in_contact(following, t, xi1, xi2, slip, omega, y[4] if len(y) > 4 else 0.0)
    signs = SLIP_SIGN.get(regime.mode, 0.0), float(regime.turn or 0)
    after = decide(following, t, y, LOCATION_ERROR, able(following, *signs))
    if after is None:
        return _leave(following, (segment,), t, y, "piece")._replace(place=place)
    return Step((segment,), t, (xi1, xi2), "piece", y, after, pieces=following)


def _off_corner(case: PieceCase, segment: Segment, t: float, y: Sequence[float], place: tuple[float, float]) -> Step:
    """The step where the plate's corner passes the track's: flight, or the end of the motion."""
    if case.effect(Flight) is None:
        return Step((segment,), t, place, "normal_force", ending=OFF_CORNER)
    slip, omega = slip_and_spin(case, t, y)
    return Step((segment,), t, place, "normal_force", in_flight(case, t, y, slip, omega, 0.0), FLIGHT)


def _following(
    case: Case, regime: Regime, guard: str, t: float, y: Sequence[float], error: float = LOCATION_ERROR
) -> Regime | None:
    """The regime of contact that follows a guard's zero, or None; `error`: the motion's relative error."""
    slip, turn = SLIP_SIGN.get(regime.mode, 0.0), float(regime.turn or 0)
    if guard == "normal_force":
        other = regime._replace(side=-regime.side)
        others = [other] if other in candidates(case) else []
        # The force vanishes along the step's polynomial; at the state it has what the tolerance leaves.
        return decide(case, t, y, LOCATION_ERROR, others) or decide(case, t, y, error, others)
    if guard in BEGINS:
        # Friction or resistance has reached its bound from inside; the motion that begins is against it.
        slip, turn = (BEGINS[guard], turn) if guard.startswith("cone") else (slip, BEGINS[guard])
        starting = [r for r in able(case, slip, turn) if r.side == regime.side and r != regime]
        starting = [r for r in starting if _unique_force(phase_at(case, r, y), t, y)]
        return starting[0] if len(starting) == 1 else decide(case, t, y, LOCATION_ERROR, starting)
    slip, turn = 0.0 if guard == "slip" else slip, 0.0 if guard == "turn" else turn
    following = decide(case, t, y, LOCATION_ERROR, able(case, slip, turn))
    if following is None:
        # A motion that began a rounding ago and ends with the event does not continue.
        slips, turns = senses(case, t, y, *slip_and_spin(case, t, y), LOCATION_ERROR)
        following = decide(case, t, y, LOCATION_ERROR, able(case, slip * abs(slips), turn * abs(turns)))
    return following


def _unique_force(now: Phase, t: float, y: Sequence[float]) -> bool:
    """Whether the contact force of a slip that begins is unique: not beyond Painlevé's paradox."""
    names = list(now.system.guards)
    if "painleve" not in names:
        return True
    return now.system.guards_of_numbers(t, state_in(now, y), now.parameters)[names.index("painleve")] > 0.0


BEGINS = {"cone_forward": 1, "cone_backward": -1, "couple_forward": 1, "couple_backward": -1}


def _leave(
    case: Case, segments: tuple[Segment, ...], t: float, y: Sequence[float], guard: str, error: float = LOCATION_ERROR
) -> Step:
    """The step if no contact follows: flight, or the end of the motion."""
    ending = _nothing_follows(case, t, y, error)
    if ending is LIFT_OFF and case.effect(Flight) is not None:
        slip, omega = slip_and_spin(case, t, y)
        return Step(segments, t, (y[0], y[1]), guard, in_flight(case, t, y, slip, omega, 0.0), FLIGHT)
    return Step(segments, t, (y[0], y[1]), guard, ending=ending)


def slip_and_spin(case: Case, t: float, y: Sequence[float]) -> tuple[float, float]:
    """Slip velocity (12), relative to a belt, and spin (9) of a full state in contact at time t."""
    along_track = y[2] * float(case.track.speed(y[0]))
    along_outline = y[3] * float(case.plate.outline.speed(y[1]))
    turns = (
        turn_rate(case.track, y[0], along_track, y[2]),
        turn_rate(case.plate.outline, y[1], along_outline, y[3]),
    )
    return along_track - along_outline - belt_speed(case, t), turns[0] - turns[1]


def _breakdown(now: Phase, segment: Segment) -> Ending:
    """The ending at singular equations: the limit of the formulation that was reached, if one was."""
    names = list(now.system.guards)
    first, last = (
        now.system.guards_of_numbers(float(t), segment.states(np.array([t]))[:, 0].tolist(), now.parameters)
        for t in (segment.times[0], segment.times[-1])
    )
    for limit in ("fit", "painleve"):
        # Steps vanish as a divisor does; a hundredth of its first value shows that it does.
        if limit in names and last[names.index(limit)] <= 1e-2 * first[names.index(limit)]:
            return ENDS[limit]
    return BREAKDOWN, f"The equations became singular at t = {segment.times[-1]:.9g} s, and no step was small enough."


def _nothing_follows(case: Case, t: float, y: Sequence[float], error: float) -> Ending:
    """Why no contact follows: the plate lifts off, unless without contact it would move into its track.

    The latter happens where the normal force of a perfectly rough contact vanishes while friction T acts: without T the
    gap's acceleration is arm_t arm_n T/J. If that is negative, Coulomb friction of any μ begins to slip with N ≈ |T|/μ;
    in the limit of a perfectly rough contact, which excludes slip, there is no solution.
    """
    if case.effect(Unilateral) is None:
        return NO_MODE
    now, m = phase_at(case, candidates(case)[-1], y), _free(case, t, y)
    state = state_in(now, y)
    if not np.isfinite(m.free_approach):
        raise Undecidable
    fastest = max(
        (abs(u) / unit for u, unit in zip(state[now.system.positions :], now.lengths, strict=False)), default=0.0
    )
    scale = abs(m.normal) + abs(m.friction) + abs(m.slip_dot) + now.size * (abs(m.omega_dot) + fastest**2)
    # At a lift-off the normal force has vanished, to the location's error and the growth of the terms in it, or to the
    # relative `error` of the motion.
    if m.free_approach <= max(1e6 * LOCATION_ERROR, error) * scale:
        return LIFT_OFF
    return NO_SLIP if case.effect(PerfectlyRough) else NO_MODE


def _free(case: Case, t: float, y: Sequence[float]) -> Elimination:
    """The quantities of the contact's equations at a full state; `free_approach` is valid without contact, too."""
    now = phase_at(case, candidates(case)[-1], y)
    return Elimination(*now.system.outputs_of_numbers(t, state_in(now, y), now.parameters))


# --- after flight -----------------------------------------------------------------------------------------------------


def _flight(
    case: Case, now: Phase, t: float, y, place: tuple[float, float], rtol: float, integrate, landings: Landings
) -> tuple[list[Segment], Landing | None]:
    """Simulate a flight: its segments up to the landing, and the landing; `place` is the pair of points of last
    contact.

    It is integrated over the duration estimated from its own scales, then repeatedly over twice the time.
    """
    segments: list[Segment] = []
    lasts = _may_last(now, t, y)
    while True:
        until = max(t + lasts, t + 1e3 * np.spacing(t))
        segment = integrate(now, t, y, min(until, case.duration), rtol)
        try:
            landing = landings.first(segment, place, under_way=bool(segments))
        except TooMuch:
            segments.append(segment.until(landings.flies_until, segment.evaluations).ended_by(LOST_SIGHT))
            return segments, None
        segments.append(segment.until(landing.time, segment.evaluations) if landing else segment)
        if landing or segment.event.guard or segment.event.time >= case.duration:
            return segments, landing
        if sum(segment.steps for segment in segments) >= MOST_STEPS:
            return [*segments[:-1], segment.ended_by(OUT_OF_STEPS)], None
        t, y, lasts = segment.event.time, segment.event.state, 2.0 * lasts


def _closes(case: Case) -> bool:
    """Whether a case begins with an impact."""
    return case.start.gap == 0.0 and case.start.gap_rate < 0.0


def _start_flight(
    case: Case, now: Phase, t: float, y, place: tuple[float, float], rtol: float, integrate, landings: Landings
) -> tuple[list[Segment], Landing]:
    """The flight of zero length before the impact that a case begins with, and that impact."""
    segment = integrate(now, t, y, 1e3 * np.spacing(t), rtol)
    return [segment.until(t, 0)], landings.start_impact(segment)


def _may_last(now: Phase, t: float, y: Sequence[float]) -> float:
    """Estimated duration of a flight, s: until its force has brought it back, or it has moved or fallen by its size."""
    rates = now.system.rates_of_numbers(t, tuple(y), now.parameters)
    speed, force = hypot(*y[3:5]), hypot(*rates[3:5])
    often = frequency(now, t, y)
    back = 4.0 * speed / force if force else 0.0
    return max(back, 4.0 / often if often else np.inf)


def _after_flight(case: Case, segments: list[Segment], landing: Landing | None, bounces: Bounces) -> Step:
    """The step after a landing, by the impact law."""
    last = segments[-1]
    if landing is None and last.event.guard == OUT_OF_STEPS:
        steps = sum(segment.steps for segment in segments)
        return Step(tuple(segments), last.event.time, ending=work_limit_ending(last.event.time, steps))
    if landing is None and last.event.guard == LOST_SIGHT:
        return Step(tuple(segments), last.event.time, ending=_search_limit_ending(last.event.time))
    if landing is None:
        return Step(
            tuple(segments), last.event.time, ending=_breakdown(last.phase, last) if last.event.guard else COMPLETION
        )
    here, place = _on_pieces(case, (landing.xi1, landing.xi2))
    step = _after_landing(here, tuple(segments), landing, place, bounces)
    return step if step.pieces or not isinstance(here, PieceCase) else step._replace(pieces=here)


def _on_pieces(case: Case, place: tuple[float, float]) -> tuple[Case, tuple[float, float]]:
    """The case on the pieces at a place of its whole curves, and the place in their parameters."""
    if not has_pieces(case):
        return case, place
    here = pieces_at(case, *place)
    return here, (place[0] - here.first.shift, place[1] - here.second.shift)


def _after_landing(
    case: Case, path: tuple[Segment, ...], landing: Landing, place: tuple[float, float], bounces: Bounces
) -> Step:
    """The step after a landing at a place, on the pieces there."""
    if isinstance(case, PieceCase):
        if corners_meet(case, *place):
            return Step(path, landing.time, place, "landing", ending=CORNERS_MEET)
        if lies_flat(case, *place):
            return Step(path, landing.time, place, "landing", ending=FLAT_LANDING)
    if case.effect(Impact) is None:
        return Step(path, landing.time, place, "landing", ending=LANDING_END)
    law, since = law_of(case, landing.arm_t, landing.arm_n), path[0].start
    # A gap that opens without a flight does not grow: the plate comes down as fast as it rose, and stays.
    none = landing.time == since and landing.touch.lift >= 0.0
    is_listed = not none and bounces.strike(since, landing)
    touch = landing.touch._replace(lift=-landing.touch.lift) if none else landing.touch
    after = collide(law, touch)
    if law.name == "newton" and energy(law, after) > (1.0 + 1e-12) * energy(law, touch):  # more than by rounding
        return Step(path, landing.time, place, "landing", ending=ENERGY)
    y = in_contact(case, landing.time, *place, after.slip, after.omega, landing.theta)
    pull = _free(case, landing.time, y).free_approach if after.lift > 0.0 else np.inf
    if none or after.lift <= 0.0:
        bounces.no_rebound()
        cause = "rest" if after.lift > 0.0 else "landing"
        return _rest(case, path, landing.time, place, landing.theta, after._replace(lift=0.0), cause, is_listed)
    is_unresolved = _is_unresolved(case, after.lift, pull, place)
    bounces.rebound(landing, after, pull)
    # Listed impacts are simulated one by one.
    limit = None if is_listed and not is_unresolved else bounces.limit(is_unresolved)
    if limit and landing.time < limit.time < case.duration:
        with_rest = (*path, bounces.settling(path[-1].phase, limit))
        whole = case.whole if isinstance(case, PieceCase) else case
        there, at = _on_pieces(whole, (limit.xi1, limit.xi2))
        if isinstance(there, PieceCase) and lies_flat(there, *at):
            return Step(with_rest, limit.time, at, "rest", ending=FLAT_LANDING, pieces=there)
        step = _rest(there, with_rest, limit.time, at, limit.theta, limit.touch, "rest", False)
        return step._replace(pieces=there) if isinstance(there, PieceCase) else step
    if is_unresolved:
        return _rest(case, path, landing.time, place, landing.theta, after._replace(lift=0.0), "rest", is_listed)
    aloft = in_flight(case, landing.time, y, after.slip, after.omega, after.lift)
    return Step(path, landing.time, place, "landing", aloft, FLIGHT, is_listed=is_listed)


def _is_unresolved(case: Case, lift: float, pull: float, place: tuple[float, float]) -> bool:
    """Whether a rebound with speed `lift`, pulled back by `pull` (m/s²), rises no higher than positions' rounding."""
    x, y, _ = pose(case, *place)
    rounding = REBOUND_ROUNDINGS * EPS * (abs(x) + abs(y) + float(np.hypot(*case.plate.outline.point(place[1]))))
    return lift * lift <= 2.0 * pull * rounding


def _rest(
    case: Case, segments, t: float, place, theta: float, touch: ContactVelocity, cause: str, is_listed: bool
) -> Step:
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
    return _leave(case, segments, t, y, cause)._replace(is_listed=is_listed)
