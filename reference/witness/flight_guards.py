"""The plate off its track in the second formulation: hops, flights, impacts, and the end of bouncing."""

from __future__ import annotations

from math import hypot, inf, sqrt

import numpy as np

from cases import Flight, Impact, Mode, Transition
from cases.scene.piece_case import corners_meet, has_pieces, lies_flat

from . import bouncing, chain_flights, flight, impact, short_flights
from .bouncing import Bounce
from .coulomb_law import comes_down, leaves
from .equations import ContactPhase
from .motion_state import IN_PROGRESS, ContactState, EndState, FlightState, LandingState, LiftOff, MotionState
from .pairs import frame
from .plate_motion import Motion, limits

# An impact after which the plate flies is listed if it closes with at least this part of the greatest closing speed
# since the plate last lay on its track; slower ones belong to bouncing that comes to rest.
LISTING_PART = 7e-4

# A flight is a hop close to the track if the forces on the plate turn by no more than this (rad) during it.
SHORT = 1 / 32

# The limit of an accumulation is used when its time has this precision, or when bounces are this short, both in parts
# of the time in which the plate falls by its own size: the remaining bounces are then not resolved in the output (they
# rise by 1e-15 of that size).
LIMIT_PRECISION = 1e-13
SHORTEST = 1e-7

# A rebound that rises by at most this part of the lengths in its position (four roundings) does not count: bouncing
# ends, at its limit or, if none was found (successive bounces end in different phases), at once.
OVER = 2.0**-50


def fly(course: MotionState, now: FlightState) -> ContactState | FlightState | EndState:
    """Simulate a flight or a hop; returns the state after its landing."""
    course.work.count += 1
    hop = _short(course, now.leap) if now.leap and now.leap.short else None
    if hop is None:
        course.bounces.clear()  # no bounce of an accumulation yet
    after = hop or _long(course, now)
    return land(course, after) if isinstance(after, LandingState) else after


def _short(course: MotionState, leap: LiftOff) -> LandingState | None:
    """Simulate a hop close to the track; None if it lasts longer, or if the plate meets the track elsewhere."""
    hop = short_flights.hop(course.scene, course.t, leap.z, leap.turns, leap.lift, leap.lasts, course.rtol)
    if hop is None or course.t + hop.duration > course.end:
        return None
    if _elsewhere(course, hop, leap):
        return None
    course.t += hop.duration
    course.last = FlightState(hop.bodies(np.array([hop.duration]))[:, 0].tolist())
    return LandingState(hop.z, leap.turns, hop.lift)


def _elsewhere(course: MotionState, hop: short_flights.Hop, leap: LiftOff) -> bool:
    """Whether the plate meets the track in another place during a hop."""
    if course.pieces:
        return chain_flights.leaves_pieces(course, course.pieces, hop)
    around, ends = course.surroundings(), np.array([0.0, hop.duration])
    motion = Motion(hop.bodies, ends)
    x, y, *_ = hop.bodies(ends)[:, 0].tolist()
    own = around.own(sorted((leap.z[0], hop.z[0])), sorted((leap.z[1], hop.z[1])))
    some = around.near(x, y, around.reach + limits(motion, *ends).speed * hop.duration)
    some, inside = around.inside(some, own or around.at(*sorted((leap.z[0], hop.z[0]))))
    rest = some.some(~inside)
    return around.search.first(motion, hop.duration, rest, np.zeros(rest.number)) is not None


def _long(course: MotionState, now: FlightState) -> LandingState | EndState:
    """Simulate a flight until the outline meets the track anywhere."""
    if has_pieces(course.case):
        return chain_flights.fly(course, now.body)
    lasts = now.leap.lasts if now.leap else inf
    path = flight.fly(
        course.scene, course.surroundings(), course.t, now.body, course.end, course.rtol, course.steps_per_turn, lasts,
        course.work, now.place,
    )  # fmt: skip
    course.t, course.last = path.end, FlightState(path.body)
    if path.touch is None:
        return EndState("completed" if course.t >= course.end else IN_PROGRESS)
    xi1, xi2, turns = course.unwind(path.touch.body[2], path.touch.xi1, path.touch.xi2)
    contact = frame(course.case, path.touch.body, xi1, xi2)
    slip = contact.slip - course.scene.surface(course.t)[0]
    return LandingState([xi1, xi2, path.touch.body[5], slip], turns, contact.lift)


def land(course: MotionState, landing: LandingState, from_flight: bool = True) -> ContactState | FlightState | EndState:
    """The state after the outline meets the track; `from_flight`: whether a flight led there."""
    scene, effect = course.scene, course.case.effect(Impact)
    (xi1, xi2, spin, slip), turns = landing.z, landing.turns
    pieces = course.pieces
    if pieces and lies_flat(pieces, xi1, xi2):
        return EndState("second_contact")
    if pieces and corners_meet(pieces, xi1, xi2):
        return EndState("landing")
    q = scene.place(xi1, xi2)
    if q.bend_outline <= q.bend_track:
        return EndState("no_fit")
    if effect is None:
        return EndState("landing")
    try:
        result = impact.hit(scene, effect, q, slip, min(landing.lift, 0.0), spin)
    except impact.ImpactWithoutSolution:
        return EndState("paradox")
    if effect.law == "newton" and impact.creates_energy(result):
        return EndState("energy_gain")
    z = [xi1, xi2, result.spin, result.slip]
    place = course.on_curves(z)
    course.last_xi1 = place[0]
    course.fastest = max(course.fastest, -landing.lift if from_flight else 0.0)
    is_listed = from_flight and -landing.lift >= LISTING_PART * course.fastest
    if result.lift == 0.0:
        after = _settle(course, z, turns)
    else:
        course.bounces.append(Bounce(course.t, (xi1, xi2, result.spin, result.slip), result.lift, result.phase))
        by_steps = is_listed and not is_unresolved(course, z, turns, result.lift)
        limit = None if by_steps else _accumulation(course, turns)
        if limit is not None:
            course.t = limit.time
            return _settle(course, limit.z, turns)
        after = leap(course, z, turns, result.lift)
    if is_listed and isinstance(after, FlightState):
        course.transitions.append(Transition(course.t, Mode.FLIGHT, Mode.FLIGHT, *place))
    return after


def _press(course: MotionState, z, turns: int) -> float:
    """The acceleration (m/s²) of a plate in flight towards its track."""
    return course.scene.forces(course.t, z, ContactPhase(None, None), turns).push + course.scene.own_lift(course.t, z)


def is_unresolved(course: MotionState, z, turns: int, lift: float) -> bool:
    """Whether a rebound with speed `lift` (m/s) rises no higher than a position's rounding."""
    q, (x, y) = course.scene.place(z[0], z[1]), course.scene.body(course.t, z, turns)[:2]
    return lift**2 <= 2.0 * _press(course, z, turns) * OVER * (abs(x) + abs(y) + hypot(q.arm_t, q.arm_n))


def leap(course: MotionState, z, turns: int, lift: float) -> ContactState | FlightState | EndState:
    """Start a flight from the track with a normal velocity; contact, if it would not rise above rounding."""
    press = _press(course, z, turns)
    lasts = 2.0 * lift / press if press > 0.0 else inf
    if is_unresolved(course, z, turns, lift) or course.t + lasts == course.t:
        return _settle(course, z, turns)
    pace = course.scene.pace(course.t, z, turns) + sqrt(max(press, 0.0) / course.scene.reach)
    leap = LiftOff(z, turns, lift, lasts, lasts * pace <= SHORT)
    return FlightState(
        short_flights.body(course.scene, [*course.scene.absolute(course.t, z), lift, 0.0], turns), (z[0], z[1]), leap
    )


def depart(course: MotionState, z, turns: int) -> FlightState | EndState:
    """The state of a plate that no force holds on its track: off it, unless it would come down at once."""
    if course.case.effect(Flight) and comes_down(course.scene, course.t, z, turns):
        return EndState("accumulation" if course.case.effect(Impact) else "landing")
    return off(course, z, turns)


def off(course: MotionState, z, turns: int) -> FlightState | EndState:
    """The flight that begins at a state in contact; the end of the motion in a case without Flight."""
    if course.case.effect(Flight) is None:
        return EndState("lift_off")
    course.last_xi1 = course.on_curves(z)[0]
    return FlightState(course.scene.body(course.t, z, turns), (z[0], z[1]))


def _settle(course: MotionState, z, turns: int) -> ContactState | FlightState | EndState:
    """The state after a landing without rebound: contact, or flight if no force presses the plate down."""
    course.bounces.clear()
    after = course.contact_state(z, turns)
    if after is None:
        return depart(course, z, turns) if leaves(course.scene, course.t, z, turns) else EndState("paradox")
    course.fastest = 0.0
    course.transitions.append(Transition(course.t, Mode.FLIGHT, after.phase.mode, *course.on_curves(z)))
    return after


def _accumulation(course: MotionState, turns: int) -> bouncing.BounceLimit | None:
    """The limit of ever shorter bounces, if it is precise enough; else None."""
    limit, last = bouncing.limit(course.bounces), course.bounces[-1]
    if limit is None or not course.t < limit.time < course.end:
        return None
    press = _press(course, last.z, turns)
    fall = sqrt(course.scene.reach / press) if press > 0.0 else 0.0
    if course.t - course.bounces[-2].time > SHORTEST * fall:
        is_precise = limit.error <= max(LIMIT_PRECISION * fall, np.spacing(course.t))
        if not is_precise:
            return None
    return limit
