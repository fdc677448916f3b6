"""The second formulation, which certifies the first: the same physics in the moving frame of the contact.

It shares no code with `elimination`, `augmented`, `decision` or their integrators: numbers instead of symbols, SciPy's
`solve_ivp` with its own events, Coulomb's inequality instead of one-sided derivatives. Slow and simple on purpose.
`equations` has its forces, `flight_guards` the motion off the track, `motion_state` the state of a simulation; this
module integrates phases of contact and chains them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf, nan, pi
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from cases import Case, CaseError, Mode, Transition
from cases.contact import clearance, start_motion
from cases.curves.corner import Corner
from cases.own_effects import ContactEffect
from cases.scene.piece_case import PieceCase, corner_on_corner, has_pieces, is_concave, neighbour, pieces_at

from ..time_limit import check_time
from . import flight_guards
from .advancement import TooManyRounds
from .chain_overlaps import ChainOverlaps
from .coulomb_law import AT_BOUND, leaves, lets_go, soon
from .dips import PhaseDips
from .drive import in_fixed_frame
from .equations import ContactPhase, ContactScene, Forces, rates
from .motion_state import IN_PROGRESS, ContactState, EndState, FlightState, LandingState, MotionState
from .second_contacts import Overlaps
from .steps import FrequencyLimitedDOP853, StepFailure

# The names of the numbers of a `LastState.motion`.
MOTION = ("x", "y", "theta", "vx", "vy", "omega", "slip")

STOPS = {
    "painleve": "paradox",
    "fit": "no_fit",
    "track": "track_end",
    "outline": "outline_end",
    "elsewhere": "second_contact",
}

# The prefix of guards that end the motion by conditions of the user's own effects.
OWN = "own end: "

# The guard of a slip (or rotation) that has just begun is ignored for this part of the motion's time scale: an instant
# located to 1e-13 may still lie inside the cone, where the slip would first go back by far less than the resolution.
BLIND = 1e-6

# Friction and normal force that are both below this part of the scene's forces when friction reaches its bound have
# vanished together: the contact ends, and no slip begins.
NEGLIGIBLE = 1e-9

# A start's spin or slip below this part of the other is a few roundings of it.
NOTHING = 1e-15

# Steps vanish at p = 0 when it is about the root of a step over the motion's time, 1e-7; this part of its first value
# shows that p is what vanishes.
JAMMED = 1e-2

# Far more changes of phase than any motion makes during one turn; a loop without progress ends with a status.
MOST_CHANGES = 5000


class LastState(NamedTuple):
    """The state at the end of a motion: contact parameters and what `MOTION` names, without contact parameters and slip
    (NaN) in flight. At an impact, values are those after it."""

    points: tuple[float, float]
    motion: tuple[float, ...]


class SecondMotion(NamedTuple):
    """The result of the second formulation: transitions, status, end (s), and the state there."""

    transitions: tuple[Transition, ...]
    status: str
    end: float
    last: LastState


def solve(
    case: Case, rtol: float = 1e-10, steps_per_turn: int = 60, until: float = inf, overlaps: bool = False
) -> SecondMotion:
    """Compute the case's motion by the second formulation, at most until time `until` (s).

    `steps_per_turn` is the least number of steps per turn of the forces on the plate (`ContactScene.pace`): events are
    found by their signs at steps' ends, and short ones inside steps by a bound (`dips`). With `overlaps`, a second
    contact is searched for too, and ends the motion. A motion that takes `steps.MOST_WORK` steps and searches is
    "unfinished" at its `end`. Raises StepFailure, a FloatingPointError with one sentence, if numbers leave the range of
    a double, a load has no value, or steps vanish.
    """
    course = None
    try:
        # Otherwise an overflow or an undefined value would continue as inf or NaN.
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            course = MotionState(case, rtol, steps_per_turn, until, overlaps)
            return _run(course)
    except (StepFailure, CaseError):
        raise
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as problem:
        raise StepFailure(
            f"the second formulation's numbers leave the range of a double at t = {course.t if course else 0.0:.9g} s "
            f"({problem}); give sizes, speeds and coefficients nearer to one"
        ) from problem


def _run(course: MotionState) -> SecondMotion:
    now: ContactState | FlightState | EndState = _start(course)
    changes, counted_until = 0, 0.0
    while not isinstance(now, EndState):
        check_time()
        course.last = now
        if course.t >= course.end:
            now = EndState("completed")
            break
        if course.work.used_up:
            now = EndState(IN_PROGRESS)
            break
        if course.t >= counted_until:
            changes, counted_until = 0, course.t + _turn(course, now)
        changes += not (isinstance(now, FlightState) and now.leap)  # rebounds end when they are no longer resolved
        if changes > MOST_CHANGES:
            now = EndState("accumulation")
            break
        try:
            now = _contact(course, now) if isinstance(now, ContactState) else flight_guards.fly(course, now)
        except TooManyRounds:
            now = EndState(IN_PROGRESS)
    last = _last(course)
    if not np.isfinite(last.motion[:6]).all():
        raise StepFailure(
            f"the second formulation's motion is not finite before t = {course.t:.9g} s; give smaller numbers"
        )
    return SecondMotion(tuple(course.transitions), now.status, course.t, last)


def _last(course: MotionState) -> LastState:
    """The last state, in the fixed frame."""
    now, points, slip = course.last, (nan, nan), nan
    assert now is not None
    if isinstance(now, ContactState):
        points, slip, body = course.on_curves(now.z), now.z[3], course.scene.body(course.t, now.z, now.turns)
    else:
        body = now.body
    if course.drive_load:
        body = in_fixed_frame(course.drive_load.drive.at(course.t), body)
    return LastState((float(points[0]), float(points[1])), (*map(float, body), float(slip)))


def _turn(course: MotionState, now: ContactState | FlightState) -> float:
    """The period 2π/rate of the plate's own motion, s: the time in which it turns once, or moves as much."""
    body = now.body if isinstance(now, FlightState) else course.scene.body(course.t, now.z, now.turns)
    pace = course.scene.free_pace(course.t, body)
    return 2 * pi / pace if pace > 0.0 else inf


def _start(course: MotionState) -> ContactState | FlightState | EndState:
    begin = start_motion(course.case)
    body = [begin.x, begin.y, begin.theta, begin.vx, begin.vy, begin.omega]
    # A speed of a few roundings of the other is set to zero: it would reverse and return within a step, undetected.
    size = course.case.plate.gyration
    omega = begin.omega if size * abs(begin.omega) > NOTHING * abs(begin.slip) else 0.0
    slip = begin.slip if abs(begin.slip) > NOTHING * size * abs(begin.omega) else 0.0
    z = [begin.xi1, begin.xi2, omega, slip]
    if has_pieces(course.case):
        z = _start_on_pieces(course, z)
    course.last = FlightState(body)
    if course.case.start.in_contact:
        course.last = ContactState(z, 0, ContactPhase(None, None))
        return course.contact_state(z, 0) or _without_mode(course, z, 0)
    if course.case.start.gap > 0.0:
        return FlightState(body)
    lift = course.case.start.gap_rate
    if lift < 0.0 or flight_guards.is_unresolved(
        course, z, 0, lift
    ):  # a rise below rounding comes down at once, with the same speed
        return flight_guards.land(course, LandingState(z, 0, -abs(lift)), from_flight=lift < 0.0)
    return flight_guards.leap(course, z, 0, lift)


def _start_on_pieces(course: MotionState, z: list[float]) -> list[float]:
    """The state in the parameters of the pieces on which the motion starts; sets the scene to these."""
    pieces = pieces_at(course.case, z[0], z[1])
    course.scene = ContactScene(pieces, course.drive_load)
    z = [z[0] - pieces.first.shift, z[1] - pieces.second.shift, z[2], z[3]]
    if not course.case.start.in_contact:
        return z
    for i in (0, 1):  # an end towards which the contact moves belongs to the next piece
        moves = rates(course.scene, course.t, z, ContactPhase(None, None), 0)[i]
        following = neighbour(pieces, i == 0, 1)
        if following and moves > 0.0 and z[i] >= pieces.pieces[i].span[1]:
            pieces, z[i] = following, following.pieces[i].span[0]
            course.scene = ContactScene(pieces, course.drive_load)
    return z


def _without_mode(course: MotionState, z, turns: int) -> FlightState | EndState:
    """No phase of contact is consistent: the plate leaves, or rigid contact has no solution (Painlevé)."""
    return flight_guards.depart(course, z, turns) if leaves(course.scene, course.t, z, turns) else EndState("paradox")


def _contact(course: MotionState, now: ContactState) -> ContactState | FlightState | EndState:
    phase, turns = now.phase, now.turns
    guards = _guards(course, now)
    overlaps = _overlaps(course, now)
    if overlaps:
        guards["elsewhere"] = overlaps.before
    solution = _integrate(course, now, guards, overlaps)
    course.t, z = float(solution.t[-1]), [float(value) for value in solution.y[:, -1]]
    guard_names = [name for name, hits in zip(guards, solution.t_events, strict=True) if len(hits)]
    if isinstance(overlaps, ChainOverlaps) and overlaps.time is not None and overlaps.time <= course.t:
        course.t, z = overlaps.time, overlaps.state or z  # a touch may be seen a step after it
    if isinstance(overlaps, Overlaps) and (touch := overlaps.by(course.t)):
        course.t, z, guard_names = touch.time, overlaps.state or z, ["elsewhere"]
    course.last = ContactState([*z], turns, phase)  # `z` is changed where it passes to another piece
    if not guard_names:
        return EndState("completed" if course.t >= course.end else IN_PROGRESS)
    if isinstance(course.scene.case, PieceCase) and not {"painleve", "fit", "elsewhere"} & set(guard_names):
        for i, name in enumerate(("track", "outline")):
            if name in guard_names:
                return _pass_on(course, now, course.scene.case, z, i)
    stop = next((STOPS.get(name, name.removeprefix(OWN)) for name in guard_names if name in STOPS or OWN in name), None)
    if stop:
        return EndState(stop)
    after: ContactState | FlightState | EndState
    if _vanishes(course, phase, guard_names, z, turns):
        if course.scene.laws.stick == inf and not lets_go(course.scene, course.t, z, phase, turns):
            return EndState("paradox")
        after = flight_guards.depart(course, z, turns)
    else:
        after = _after(course, phase, guard_names, z, turns) or _without_mode(course, z, turns)
    _list(course, phase.mode, after, course.on_curves(z))
    return after


def _list(course: MotionState, before: Mode, after: ContactState | FlightState | EndState, place) -> None:
    """Record the transition from a mode of contact; an end other than a lift-off has no mode."""
    if isinstance(after, EndState) and after.status != "lift_off":
        return
    mode = after.phase.mode if isinstance(after, ContactState) else Mode.FLIGHT
    if mode is not before:
        course.transitions.append(Transition(course.t, before, mode, *place))


def _overlaps(course: MotionState, now: ContactState) -> Overlaps | ChainOverlaps | None:
    """The search for second contacts, if there may be any."""
    if not course.overlaps:
        return None
    pieces = course.scene.case
    if isinstance(pieces, PieceCase):
        return ChainOverlaps(course.case, pieces, course.scene.reach, course.on_curves(now.z)[0])
    around = course.surroundings()
    return None if around.fits_everywhere else Overlaps(course.case, around, now.turns)


def _pass_on(
    course: MotionState, now: ContactState, case: PieceCase, z: list[float], i: int
) -> ContactState | FlightState | EndState:
    """The state after the contact has reached an end of its piece of the track (i = 0) or the outline (1): position,
    direction, slip and spin are the same on the next piece."""
    low, high = case.pieces[i].span
    way = 1 if high - z[i] < z[i] - low else -1
    following = neighbour(case, i == 0, way)
    if following is None:
        return EndState(STOPS[("track", "outline")[i]])
    place = course.on_curves(z)
    if is_concave(following):
        return EndState(STOPS["elsewhere"])
    if corner_on_corner(following):
        after: ContactState | FlightState | EndState = flight_guards.off(course, z, now.turns)
    else:
        z[i] = following.pieces[i].span[0 if way > 0 else 1]
        if not clearance(following, z[0], z[1]) > 0.0:
            return EndState(STOPS["elsewhere"])
        course.scene = ContactScene(following, course.drive_load)
        after = course.contact_state(z, now.turns) or _without_mode(course, z, now.turns)
    _list(course, now.phase.mode, after, place)
    return after


def _vanishes(course: MotionState, phase: ContactPhase, guard_names: list[str], z, turns: int) -> bool:
    """Whether the normal force has vanished: alone, or together with the friction that it bounds."""
    if "normal_force" in guard_names:
        return True
    if not course.scene.unilateral or not any(name.startswith("cone") for name in guard_names):
        return False
    return _forceless(course, phase, z, turns)


def _forceless(course: MotionState, phase: ContactPhase, z, turns: int) -> bool:
    """Whether the contact's forces have vanished together."""
    forces, scale = course.scene.forces(course.t, z, phase, turns), course.scene.scale(course.t, z, turns)
    return max(abs(forces.friction), abs(forces.normal)) <= NEGLIGIBLE * scale


def _after(course: MotionState, phase: ContactPhase, guard_names: list[str], z, turns: int) -> ContactState | None:
    """The contact after a guard's zero; sets velocities that have vanished to zero. None: no phase is consistent."""
    if "side" in guard_names:
        return ContactState(z, turns, phase._replace(side=-phase.side))
    if "slip" in guard_names:
        z[3] = 0.0
    if "turn" in guard_names:
        z[2] = 0.0
    cone = any(name.startswith("cone") for name in guard_names)
    couple = any(name.startswith("couple") for name in guard_names)
    if couple and not course.scene.unilateral and _forceless(course, phase, z, turns):
        return ContactState(z, turns, phase._replace(side=-phase.side))  # the couple's bound vanished, and grows again
    return course.contact_state(z, turns, may_stick=not cone, may_hold=not couple)


def _guards(course: MotionState, now: ContactState) -> dict[str, Callable]:
    """Functions of (t, z) that are positive while the phase lasts."""
    scene, laws, phase, turns = course.scene, course.scene.laws, now.phase, now.turns

    def forces(t, z):
        return scene.forces(t, z, phase, turns)

    guards: dict[str, Callable] = {}
    if phase.slip == 0 and laws.stick < inf:
        cone = _within(course, now, laws.stick, lambda f: f.friction)
        guards["cone+"], guards["cone-"] = partial(cone, 1.0), partial(cone, -1.0)
    if phase.turn == 0 and laws.arm is not None and laws.arm < inf:
        couple = _within(course, now, laws.arm, lambda f: f.couple)
        guards["couple+"], guards["couple-"] = partial(couple, 1.0), partial(couple, -1.0)
    if phase.slip:
        guards["slip"] = lambda t, z: phase.slip * z[3]
    if phase.turn:
        guards["turn"] = lambda t, z: phase.turn * z[2]
    if phase.slip or phase.turn:
        guards["painleve"] = lambda t, z: forces(t, z).inverse_mass
    if scene.unilateral and not (phase.slip == 0 and laws.stick < inf):
        # With static friction the cone is reached before the normal force vanishes.
        slack = _slack_of_nothing(course, now)
        guards["normal_force"] = lambda t, z: forces(t, z).normal + slack
    if not scene.unilateral and (phase.slip is not None or phase.turn is not None):
        guards["side"] = lambda t, z: phase.side * forces(t, z).push
    if not (isinstance(scene.track, Corner) or isinstance(scene.outline, Corner)):
        guards["fit"] = lambda t, z: (q := scene.place(z[0], z[1])).bend_outline - q.bend_track
    for effect in scene.own:
        for i, end in enumerate(effect.ends()):
            guards[f"{OWN}{end.status}"] = partial(_own_end, effect, 3 + i)
    for name, curve, i in (("track", scene.track, 0), ("outline", scene.outline, 1)):
        if curve.ends:
            guards[name] = _inside(i, *curve.ends)
    return guards


def _slack_of_nothing(course: MotionState, now: ContactState) -> float:
    """How far below zero (N) rounding may take a normal force that is zero where a phase begins and stays zero, as
    under a load of exactly the weight; 0 for any other."""
    scene, phase, turns = course.scene, now.phase, now.turns
    slack = 2.0 * AT_BOUND * scene.scale(course.t, now.z, turns)
    if abs(scene.forces(course.t, now.z, phase, turns).normal) > slack:
        return 0.0
    return slack if abs(soon(scene, course.t, now.z, phase, turns)) <= slack else 0.0


def _within(
    course: MotionState, now: ContactState, coefficient: float, part: Callable[[Forces], float]
) -> Callable[[float, float, list[float]], float]:
    """A function of (sign, t, z): how far a static force or couple is within its bound of that sign.

    If a phase begins at the bound and stays there, rounding would end it: the bound is then wider by that.
    """
    scene, phase, turns = course.scene, now.phase, now.turns

    def inside(sign: float, t: float, z) -> float:
        forces = scene.forces(t, z, phase, turns)
        return coefficient * phase.side * forces.normal + sign * part(forces)

    def slack(t: float, z) -> float:
        return 2.0 * AT_BOUND * coefficient * scene.scale(t, z, turns)

    if min(inside(sign, course.t, now.z) for sign in (1.0, -1.0)) > slack(course.t, now.z):
        return inside
    return lambda sign, t, z: inside(sign, t, z) + slack(t, z)


def _integrate(
    course: MotionState, now: ContactState, guards: dict[str, Callable], overlaps: Overlaps | ChainOverlaps | None
):
    scene, phase, turns, start = course.scene, now.phase, now.turns, course.t
    at_zero = {"slip": now.z[3] == 0.0, "turn": now.z[2] == 0.0}
    if not scene.unilateral and _forceless(course, phase, now.z, turns):
        at_zero |= {"couple+": True, "couple-": True, "side": True}  # bounds that vanish with the normal force
    pace = scene.pace(start, now.z, turns)
    blind = BLIND / pace if pace > 0.0 else inf
    dips = PhaseDips({name: guard for name, guard in guards.items() if name != "elsewhere"}, start + blind)
    events = []
    for name, guard in guards.items():
        watch_from = start + blind if at_zero.get(name) else start

        value = partial(dips.value, name) if name in dips.guards else guard

        def event(t, z, value=value, watch_from=watch_from):
            return 1.0 if t < watch_from else value(t, z)

        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
        events.append(event)
    solution = solve_ivp(
        lambda t, z: rates(scene, t, z.tolist(), phase, turns), (start, course.end), now.z,
        method=FrequencyLimitedDOP853, rtol=course.rtol, atol=1e-2 * course.rtol, events=events,
        pace=lambda t, z: scene.pace(t, z.tolist(), turns), steps_per_turn=course.steps_per_turn, work=course.work,
        load_allows=_formulas_allow(scene, phase, turns), dips=dips,
        after_step=overlaps.look if overlaps else None, features=scene.in_contact,
    )  # fmt: skip
    usable, end = solution.success or course.work.used_up, float(solution.t[-1])
    if isinstance(overlaps, Overlaps):
        overlaps.finish()
        if overlaps.by(end):  # later steps are not of the motion
            return solution
    if not solution.success and _jams(scene, phase, solution, turns):
        solution.t_events[list(guards).index("painleve")] = solution.t[-1:]
        usable = True
    if not usable or not np.isfinite(solution.y[:, -1]).all():
        raise StepFailure(f"the second formulation stopped at t = {solution.t[-1]:.9g} s: {solution.message}")
    return solution


def _jams(scene: ContactScene, phase: ContactPhase, solution, turns: int) -> bool:
    """Whether steps vanished because Painlevé's number does: friction that grows as the slip falls stops the slip at
    once there, and the number p falls as the root of the remaining time."""
    if not phase.slip or scene.laws.by_speed is None:
        return False
    first, last = (scene.forces(solution.t[i], solution.y[:, i].tolist(), phase, turns).inverse_mass for i in (0, -1))
    return last <= JAMMED * first


def _own_end(effect: ContactEffect, row: int, t: float, z) -> float:
    """The value of a condition of an effect of the user's own."""
    return effect.at(t, float(z[3]), float(z[2]))[row]


def _formulas_allow(scene: ContactScene, phase: ContactPhase, turns: int):
    """Whether load and friction allow a step, as a function of times and states; None if they always do."""
    if scene.load_scales is None and scene.slip_scales is None:
        return None
    return lambda times, states: scene.load_allows(times, states, turns) and scene.slip_allows(times, states, phase)


def _inside(i: int, low: float, high: float):
    return lambda t, z: min(z[i] - low, high - z[i])
