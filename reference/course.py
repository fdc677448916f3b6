"""Phase after phase: what ends one, what follows, until the end of time or a status."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from cases import Case, Flight, Impact, Mode, PerfectlyRough, Trajectory, Transition, Unilateral

from .arc import BREAKDOWN, Arc
from .bounces import Bounces
from .eliminated import Motion
from .flight import Landing, first_landing
from .impact import Touch, collide, energy, law_of
from .modes import (
    FLIGHT,
    SLIP_SIGN,
    Phase,
    Regime,
    able,
    candidates,
    full_state,
    in_contact,
    in_flight,
    phase,
    senses,
    state_in,
    without_slip,
    without_turning,
)
from .transitions import decide

# More phases than this in one motion are taken as an accumulation and told as such.
MOST_PHASES = 100_000

# Relative error to which an event's own state is located, whatever the tolerance of the motion that led there.
LOCATED = 1e-12

# So many phases of no length one after the other are no motion any more (a slip that begins, ends and begins), and how
# far from a bound counts as being at it then: a thousand times the location's error.
IDLE, ROUGH = 4, 1e-9

# Near t = 0 instants are finer than a rounding of the motion's duration: phases shorter than that move the clock, and
# so many of them in a row would take minutes to come to nothing.
NO_TIME, MOST_HARDLY = 2.0**-52, 1000

Ending = tuple[str, str]  # status and sentence
COMPLETED: Ending = (Trajectory.status, Trajectory.reason)

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
LIFT_OFF = ("lift_off", "The normal force vanished and would pull: the plate leaves its track.")
LANDED = ("landing", "The plate meets its track again, and the case names no Impact.")
ENERGY = ("energy_gain", "Newton's law of restitution would create energy in this impact; give law='poisson'.")
NO_MODE = ("paradox", "No mode of rigid Coulomb contact is consistent here (Painlevé).")
NO_SLIP = (
    "paradox",
    "A perfectly rough contact would have to pull here, and the free plate would move into its track: "
    "without a slip it can neither stay nor leave.",
)
TOO_MANY = ("accumulation", f"Changes of regime accumulate: {MOST_PHASES} of them, or {MOST_HARDLY} in no time.")

# Guards whose zero changes the mode: the phrase a transition carries.
CAUSES = {
    "slip": "the slip velocity vanished",
    "turn": "the rotation vanished",
    "cone_forward": "friction reached its cone",
    "cone_backward": "friction reached its cone",
    "couple_forward": "rolling resistance reached its bound",
    "couple_backward": "rolling resistance reached its bound",
    "normal_force": "the normal force vanished",
    "landing": "impact",
    "rest": "bouncing came to rest",
}

# A rebound whose flight is shorter than this part of the duration belongs to bouncing that comes to rest and is not
# listed among the transitions: how many of those are stepped through before the limit is found is nobody's concern.
LISTED = 1e-3

# A flight as short as this part of the duration is no higher than the rounding of positions: bouncing is over, also
# where its limit could not be extrapolated (each impact ends otherwise than the one before).
OVER = 1e-7


class Step(NamedTuple):
    """What came of a phase: its arcs, when and where it ended (ξ₁, ξ₂) and why, the full state and regime that follow,
    or the ending."""

    arcs: tuple[Arc, ...]
    time: float
    place: tuple[float, float] = (np.nan, np.nan)
    cause: str = ""
    state: tuple[float, ...] = ()
    regime: Regime | None = None
    ending: Ending = COMPLETED


def run(case: Case, regime: Regime | None, start, rtol: float, integrate: Callable[..., Arc]):
    """Phase after phase until the end of time or a status: (arcs, transitions, (status, sentence))."""
    t, y = 0.0, start
    arcs: list[Arc] = []
    transitions: list[Transition] = []
    if regime is None:
        step = _leave(case, (), t, y, "")
        if step.regime is None:
            return arcs, transitions, step.ending
        regime, y = step.regime, step.state
    bounces, near, idle, hardly = Bounces(case), case.start.xi1, 0, 0
    while len(arcs) < MOST_PHASES:
        now = phase(case, regime)
        arc = integrate(now, t, state_in(now, y), case.duration, rtol)
        step = _after_flight(case, arc, bounces, near) if regime == FLIGHT else _after_contact(case, arc)
        idle = idle + 1 if step.time == t else 0
        hardly = hardly + 1 if step.time - t <= NO_TIME * case.duration else 0
        if hardly > MOST_HARDLY:
            break
        if idle > IDLE and step.regime not in (None, FLIGHT):
            step = _moved_on(case, regime, step)
        arcs.extend(step.arcs)
        following = step.regime.mode if step.regime else Mode.FLIGHT if step.ending is LIFT_OFF else regime.mode
        if following is not regime.mode or (step.regime == FLIGHT == regime):
            transitions.append(Transition(step.time, regime.mode, following, *step.place, CAUSES[step.cause]))
        if step.regime is None:
            return arcs, _listed(case, transitions, step.time), step.ending
        t, y, regime, near = step.time, step.state, step.regime, step.place[0]
    return arcs, _listed(case, transitions, t), TOO_MANY


def _moved_on(case: Case, regime: Regime, step: Step) -> Step:
    """The same step where phases of no length follow each other: what began is too small to be told from rounding.

    What lies within `ROUGH` of its bound counts as being there, and its rate decides.
    """
    others = [r for r in candidates(case) if r != regime]
    return step._replace(regime=decide(case, step.time, step.state, ROUGH, others) or step.regime)


def _listed(case: Case, transitions: list[Transition], end: float) -> list[Transition]:
    """The transitions without the rebounds of bouncing that comes to rest."""
    ends = [*(t.time for t in transitions[1:]), end]
    return [
        t
        for t, until in zip(transitions, ends, strict=False)
        if not t.before is t.after is Mode.FLIGHT or until - t.time >= LISTED * case.duration
    ]


# --- after contact ----------------------------------------------------------------------------------------------------


def _after_contact(case: Case, arc: Arc) -> Step:
    """What follows where a guard reached zero."""
    now, guard, t = arc.phase, arc.stop.guard, arc.stop.time
    if guard is None:
        return Step((arc,), t)
    y = full_state(case, now, arc.stop.state)
    if guard in ENDS:
        return Step((arc,), t, ending=ENDS[guard])
    if guard == BREAKDOWN:
        return Step((arc,), t, ending=_breakdown(now, arc))
    if guard == "slip":
        y = (*y[:3], without_slip(case, *y[:3]), *y[4:])
        if now.regime.turn == 0:
            y = (*y[:2], 0.0, 0.0, *y[4:])
    if guard == "turn":
        y = without_turning(case, y)
    following = _following(case, now.regime, guard, t, y)
    if following is None:
        return _leave(case, (arc,), t, y, guard)
    return Step((arc,), t, (y[0], y[1]), guard, y, following)


def _following(case: Case, regime: Regime, guard: str, t: float, y: Sequence[float]) -> Regime | None:
    """The contact that follows a guard's zero, or None."""
    slip, turn = SLIP_SIGN.get(regime.mode, 0.0), float(regime.turn or 0)
    if guard == "normal_force":
        other = regime._replace(side=-regime.side)
        return decide(case, t, y, LOCATED, [other] if other in candidates(case) else [])
    if guard in _BEGINS:
        # Friction or its like has reached its bound from inside; the motion that begins is against it.
        slip, turn = (_BEGINS[guard], turn) if guard.startswith("cone") else (slip, _BEGINS[guard])
        begun = [r for r in able(case, slip, turn) if r.side == regime.side and r != regime]
        begun = [r for r in begun if _unique_force(phase(case, r), t, y)]
        return begun[0] if len(begun) == 1 else decide(case, t, y, LOCATED, begun)
    slip, turn = 0.0 if guard == "slip" else slip, 0.0 if guard == "turn" else turn
    following = decide(case, t, y, LOCATED, able(case, slip, turn))
    if following is None:
        # What began a rounding ago and ends with the event is no motion that goes on.
        slips, turns = senses(case, y, *_moves(case, y), LOCATED)
        following = decide(case, t, y, LOCATED, able(case, slip * abs(slips), turn * abs(turns)))
    return following


def _unique_force(now: Phase, t: float, y: Sequence[float]) -> bool:
    """Whether a slip that begins has a force at all: not beyond Painlevé's paradox."""
    names = list(now.system.guards)
    if "painleve" not in names:
        return True
    return now.system.guards_of_numbers(t, state_in(now, y), now.parameters)[names.index("painleve")] > 0.0


_BEGINS = {"cone_forward": 1, "cone_backward": -1, "couple_forward": 1, "couple_backward": -1}


def _leave(case: Case, arcs: tuple[Arc, ...], t: float, y: Sequence[float], guard: str) -> Step:
    """No contact follows: the plate flies, or that is the end."""
    ending = _nothing_follows(case, t, y)
    if ending is LIFT_OFF and case.effect(Flight) is not None:
        slip, omega = _moves(case, y)
        return Step(arcs, t, (y[0], y[1]), guard, in_flight(case, y, slip, omega, 0.0), FLIGHT)
    return Step(arcs, t, (y[0], y[1]), guard, ending=ending)


def _moves(case: Case, y: Sequence[float]) -> tuple[float, float]:
    """Slip velocity (12) and spin (9) of a full state in contact."""
    along_track = y[2] * float(case.track.speed(y[0]))
    along_outline = y[3] * float(case.plate.outline.speed(y[1]))
    bends = float(case.track.curvature(y[0])), float(case.plate.outline.curvature(y[1]))
    return along_track - along_outline, bends[0] * along_track - bends[1] * along_outline


def _breakdown(now: Phase, arc: Arc) -> Ending:
    """The limit of the formulation at which the equations became singular."""
    names = list(now.system.guards)
    first, last = (
        now.system.guards_of_numbers(float(t), arc.states(np.array([t]))[:, 0].tolist(), now.parameters)
        for t in (arc.times[0], arc.times[-1])
    )
    for limit in ("fit", "painleve"):
        # Steps vanish where a divisor does; a hundredth of its first value is well on the way there.
        if limit in names and last[names.index(limit)] <= 1e-2 * first[names.index(limit)]:
            return ENDS[limit]
    return BREAKDOWN, f"The equations became singular at t = {arc.times[-1]:.9g} s, and no step was small enough."


def _nothing_follows(case: Case, t: float, y: Sequence[float]) -> Ending:
    """Why no contact follows: the plate flies off, unless without contact it would move into its track.

    So it is where the normal force of a perfectly rough contact vanishes while friction T acts: without T the gap's
    acceleration is arm_t arm_n T/J. Where that is negative, Coulomb friction of any μ begins to slip with N ≈ |T|/μ;
    in the limit of a perfectly rough contact, which excludes slip, nothing is left.
    """
    if case.effect(Unilateral) is None:
        return NO_MODE
    now = phase(case, candidates(case)[-1])
    state = state_in(now, y)
    m = Motion(*now.system.observed_of_numbers(t, state, now.parameters))
    fastest = max(
        (abs(u) / unit for u, unit in zip(state[now.system.positions :], now.lengths, strict=False)), default=0.0
    )
    scale = abs(m.normal) + abs(m.friction) + abs(m.slip_dot) + now.size * (abs(m.omega_dot) + fastest**2)
    # At a lift-off the normal force has vanished, to the location's error and the growth of what it is a difference of.
    if m.closing <= 1e6 * LOCATED * scale:
        return LIFT_OFF
    return NO_SLIP if case.effect(PerfectlyRough) else NO_MODE


# --- after flight -----------------------------------------------------------------------------------------------------


def _after_flight(case: Case, arc: Arc, bounces: Bounces, near: float) -> Step:
    """Where the flight lands, and what the impact makes of it; `near` is where the track was touched last."""
    landing = first_landing(case, arc, case.duration, near)
    if landing is None:
        return Step((arc,), arc.stop.time)
    flown = _until(arc, landing)
    place = landing.xi1, landing.xi2
    if case.effect(Impact) is None:
        return Step((flown,), landing.time, place, "landing", ending=LANDED)
    law = law_of(case, landing.arm_t, landing.arm_n)
    after = collide(law, landing.touch)
    if not law.poisson and energy(law, after) > (1.0 + 1e-12) * energy(law, landing.touch):  # more than by rounding
        return Step((flown,), landing.time, place, "landing", ending=ENERGY)
    if after.lift <= 0.0:
        return _rest(case, (flown,), landing.time, place, landing.theta, after, "landing")
    if landing.time - float(arc.times[0]) < OVER * case.duration:
        return _rest(case, (flown,), landing.time, place, landing.theta, after._replace(lift=0.0), "rest")
    bounces.add(float(arc.times[0]), landing, after)
    limit = bounces.limit()
    if limit and landing.time < limit.time < case.duration:
        arcs, place = (flown, bounces.settling(arc.phase, limit)), (limit.xi1, limit.xi2)
        return _rest(case, arcs, limit.time, place, limit.theta, limit.touch, "rest")
    y = in_contact(case, landing.xi1, landing.xi2, after.slip, after.omega, landing.theta)
    return Step(
        (flown,), landing.time, place, "landing", in_flight(case, y, after.slip, after.omega, after.lift), FLIGHT
    )


def _rest(case: Case, arcs, t: float, place, theta: float, touch: Touch, cause: str) -> Step:
    """Contact that neither opens nor closes: the mode that follows, or flight where none does."""
    y = in_contact(case, place[0], place[1], touch.slip, touch.omega, theta)
    moves = senses(case, y, touch.slip, touch.omega, LOCATED)
    following = decide(case, t, y, LOCATED, able(case, *moves))
    return Step(arcs, t, place, cause, y, following) if following else _leave(case, arcs, t, y, cause)


def _until(arc: Arc, landing: Landing) -> Arc:
    """The arc up to its landing."""
    times = np.append(arc.times[arc.times < landing.time], landing.time)
    return Arc(arc.phase, times, arc.states, arc.stop._replace(time=landing.time), arc.evaluations)
